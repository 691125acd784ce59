// Moments from the RTL: frames go into the Verilated board, and packets come out.
#include <verilated.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "Vboard.h"
#include "Vboard_runs.h"
#include "Vgray.h"
#include "Vmatch.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/little_endian.h"
#include "selfproj/model/packet.h"
#include "sim/board/board_device.h"
#include "sim/board/engines.h"

namespace selfproj::sim {
namespace {

class RtlEngine final : public MomentsEngine {
 public:
  [[nodiscard]] std::string name() const override { return "rtl"; }

  void process(std::span<const model::ImageView> frames, const MomentsSettings& settings,
               std::span<model::Runs> out) override {
    if (settings.measure.select == model::Select::strongest) {
      process_on<Vboard_runs>(frames, settings, out);
    } else {
      process_on<Vboard>(frames, settings, out);
    }
  }

 private:
  template <class Model>
  void process_on(std::span<const model::ImageView> frames, const MomentsSettings& settings,
                  std::span<model::Runs> out) {
    const model::Measure& measure = settings.measure;
    BoardDevice<Model> board;
    std::size_t received = 0;
    std::string problem;
    board.on_packet([&](std::span<const std::uint8_t> bytes) {
      model::PacketView packet;
      const model::PacketError error = model::parse_packet(bytes, packet);
      if (error != model::PacketError::none) {
        problem = std::string("bad packet: ") + model::to_string(error);
      } else if (packet.status != 0 || packet.header.lost != 0 || packet.header.sequence != received ||
                 received == out.size()) {
        problem = "frame " + std::to_string(received + 1) + " was lost or broken on the board";
      } else {
        out[received].resize(measure.select, settings.columns);
        model::unpack_columns(model::column_word(measure.select, measure.mode), settings.columns, packet.payload.data(),
                              out[received].view());
        ++received;
      }
    });
    board.write(model::BoardSettings{.columns = settings.columns,
                                     .rows = settings.rows,
                                     .mode = measure.mode,
                                     .threshold = measure.threshold,
                                     .select = measure.select,
                                     .gap = measure.gap,
                                     .window = measure.window});
    // Frames of few rows must not follow each other immediately. Leave the time that two packets need.
    const auto gap = static_cast<std::uint32_t>(model::moments_payload_bytes(measure.mode, settings.columns) / 8 + 64);
    for (const model::ImageView& frame : frames) {
      board.send(frame);
      board.gap(gap);
      board.drain(gap);
      if (!problem.empty()) {
        throw std::runtime_error("engine rtl: " + problem);
      }
    }
    board.drain();
    if (received != frames.size()) {
      throw std::runtime_error("engine rtl: " + std::to_string(frames.size() - received) + " frames gave no packet");
    }
  }
};

}  // namespace

std::unique_ptr<MomentsEngine> make_moments_rtl_engine() { return std::make_unique<RtlEngine>(); }

// Codes from the RTL: beats go into the Verilated decoder as the frame tracker would give them, and codes come out.

namespace {

class GrayRtlEngine final : public GrayEngine {
 public:
  GrayRtlEngine() : dut_(std::make_unique<Vgray>(&context_)) {
    dut_->rst_i = 1;
    dut_->beat_valid_i = 0;
    dut_->frame_start_i = 0;
    dut_->take_i = 0;
    dut_->break_i = 0;
    for (int i = 0; i < 4; ++i) {
      tick();
    }
    dut_->rst_i = 0;
  }
  GrayRtlEngine(const GrayRtlEngine&) = delete;
  GrayRtlEngine& operator=(const GrayRtlEngine&) = delete;
  ~GrayRtlEngine() override { dut_->final(); }

  [[nodiscard]] std::string name() const override { return "rtl"; }
  [[nodiscard]] int max_rows() const override { return 4095; }  // parameters of Vgray in sim/board/CMakeLists.txt
  [[nodiscard]] int max_columns() const override { return 4096; }

  void start(const model::GraySettings& settings, bool median) override {
    settings_ = settings;
    dut_->decode_i = 1;
    dut_->median_i = median;
    dut_->bits_i = static_cast<CData>(settings.bits);
    dut_->threshold_i = static_cast<CData>(settings.threshold);
    dut_->columns_i = static_cast<SData>(settings.columns);
    dut_->rows_i = static_cast<SData>(settings.rows);
    // A break makes the decoder wait for plane 0, even if the settings have not changed.
    dut_->break_i = 1;
    tick();
    dut_->break_i = 0;
    idle();
  }

  bool take(const model::ImageView& image, int pattern, std::uint16_t* codes) override {
    out_ = codes;
    left_ = static_cast<std::int64_t>(image.rows) * image.columns;
    const std::int64_t all = left_;
    dut_->pattern_i = static_cast<SData>(pattern);  // nothing of the previous frame is under way any more
    for (int row = 0; row < image.rows; ++row) {
      const std::uint8_t* line = image.pixels + row * image.stride;
      for (int column = 0; column < image.columns; column += spec::kPixelsPerBeat) {
        const bool first = row == 0 && column == 0;
        dut_->take_i = first;
        dut_->frame_start_i = first;
        dut_->beat_valid_i = 1;
        dut_->beat_pixels_i = model::load_little_endian<std::uint32_t>(line + column);
        dut_->beat_line_start_i = column == 0;
        dut_->beat_line_end_i = column + spec::kPixelsPerBeat == image.columns;
        dut_->beat_last_row_i = row + 1 == image.rows;
        tick();
      }
    }
    dut_->beat_valid_i = 0;
    dut_->frame_start_i = 0;
    dut_->take_i = 0;
    idle();
    if (left_ != 0 && left_ != all) {
      throw std::runtime_error("the decoder gave a part of a code image");
    }
    return left_ == 0;
  }

 private:
  // Runs until everything under way is out.
  void idle() {
    for (int i = 0; i < settings_.columns / spec::kPixelsPerBeat + 40; ++i) {
      tick();
    }
  }

  void tick() {
    dut_->clk_i = 0;
    dut_->eval();
    dut_->clk_i = 1;
    dut_->eval();
    if (dut_->codes_valid_o != 0) {
      if (left_ < spec::kPixelsPerBeat) {
        throw std::runtime_error("the decoder gave more codes than pixels");
      }
      for (int i = 0; i < spec::kPixelsPerBeat; ++i) {
        *out_++ = static_cast<std::uint16_t>(dut_->codes_o >> (16 * i));
      }
      left_ -= spec::kPixelsPerBeat;
    }
  }

  VerilatedContext context_;
  std::unique_ptr<Vgray> dut_;
  model::GraySettings settings_;
  std::uint16_t* out_ = nullptr;
  std::int64_t left_ = 0;  // codes still to come
};

}  // namespace

std::unique_ptr<GrayEngine> make_gray_rtl_engine() { return std::make_unique<GrayRtlEngine>(); }

// Matching by the RTL: a code image goes into the Verilated block as the decoder would give it, a line of beats in
// successive clocks. Behind its port is a memory of four lanes.

namespace {

// Parameters of Vmatch in sim/board/CMakeLists.txt.
constexpr unsigned kBits = 4;
constexpr std::size_t kGroups = 65536;
constexpr unsigned kAddressBits = 16 + kBits;
constexpr std::size_t kLatency = 4;

class MatchRtlEngine final : public MatchEngine {
 public:
  MatchRtlEngine(std::vector<std::uint16_t> table, int bits)
      : table_(std::move(table)), dut_(std::make_unique<Vmatch>(&context_)) {
    if (bits != kBits || table_.size() > kGroups * spec::kPixelsPerBeat << kBits) {
      throw std::invalid_argument("match: the circuit is built for 4 bits and 512 x 512 pixels");
    }
    table_.resize(kGroups * spec::kPixelsPerBeat << kBits);
    dut_->rst_i = 1;
    dut_->s_valid_i = 0;
    dut_->s_break_i = 0;
    dut_->mem_late_i = 0;
    for (int i = 0; i < 4; ++i) {
      tick();
    }
    dut_->rst_i = 0;
  }
  MatchRtlEngine(const MatchRtlEngine&) = delete;
  MatchRtlEngine& operator=(const MatchRtlEngine&) = delete;
  ~MatchRtlEngine() override { dut_->final(); }

  [[nodiscard]] std::string name() const override { return "rtl"; }

  void look_up(const std::uint16_t* codes, int rows, int columns, std::uint16_t* lines) override {
    constexpr int kBlank = 4;  // clocks between two lines
    out_ = lines;
    left_ = static_cast<std::int64_t>(rows) * columns;
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; column += spec::kPixelsPerBeat, codes += spec::kPixelsPerBeat) {
        std::uint64_t beat = 0;
        for (int i = 0; i < spec::kPixelsPerBeat; ++i) {
          beat |= std::uint64_t{codes[i]} << (16 * i);
        }
        dut_->s_valid_i = 1;
        dut_->s_codes_i = beat;
        dut_->s_start_i = row == 0 && column == 0;
        dut_->s_line_start_i = column == 0;
        dut_->s_line_end_i = column + spec::kPixelsPerBeat == columns;
        tick();
      }
      dut_->s_valid_i = 0;
      for (int i = 0; i < kBlank; ++i) {
        tick();
      }
    }
    for (std::size_t i = 0; i < kLatency + 4; ++i) {
      tick();
    }
    if (left_ != 0) {
      throw std::runtime_error("the matching block gave a part of an image");
    }
  }

 private:
  // The words of the four lanes at the addresses on the port.
  [[nodiscard]] std::uint64_t words() const {
    std::uint64_t data = 0;
    for (unsigned lane = 0; lane < spec::kPixelsPerBeat; ++lane) {
      std::size_t address = 0;
      for (unsigned b = 0; b < kAddressBits; ++b) {
        const unsigned at = kAddressBits * lane + b;
        address |= static_cast<std::size_t>(dut_->mem_address_o[at / 32] >> at % 32 & 1U) << b;
      }
      const std::size_t group = address >> kBits;
      const std::size_t code = address & ((1U << kBits) - 1);
      const std::size_t pixel = group * spec::kPixelsPerBeat + lane;
      data |= std::uint64_t{table_[(pixel << kBits) + code]} << (16 * lane);
    }
    return data;
  }

  void tick() {
    dut_->clk_i = 0;
    dut_->mem_data_i = on_the_way_[at_];
    dut_->eval();
    // The words arrive kLatency clocks from now. If nothing is read, the value does not matter.
    on_the_way_[at_] = dut_->mem_read_o != 0 ? words() : ~std::uint64_t{0};
    at_ = (at_ + 1) % kLatency;
    dut_->clk_i = 1;
    dut_->eval();
    if (dut_->m_valid_o != 0 && dut_->rst_i == 0) {
      if (left_ < spec::kPixelsPerBeat) {
        throw std::runtime_error("the matching block gave more lines than pixels");
      }
      for (int i = 0; i < spec::kPixelsPerBeat; ++i) {
        *out_++ = static_cast<std::uint16_t>(dut_->m_lines_o >> (16 * i));
      }
      left_ -= spec::kPixelsPerBeat;
    }
  }

  std::vector<std::uint16_t> table_;
  VerilatedContext context_;
  std::unique_ptr<Vmatch> dut_;
  std::array<std::uint64_t, kLatency> on_the_way_{};
  std::size_t at_ = 0;
  std::uint16_t* out_ = nullptr;
  std::int64_t left_ = 0;  // lines still to come
};

}  // namespace

std::unique_ptr<MatchEngine> make_match_rtl_engine(std::vector<std::uint16_t> table, int bits) {
  return std::make_unique<MatchRtlEngine>(std::move(table), bits);
}

}  // namespace selfproj::sim
