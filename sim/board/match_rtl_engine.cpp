// Matching by the RTL: a code image goes into the Verilated block as the decoder would give it, a line of beats in
// successive clocks. Behind its port is a memory of four lanes.
#include <verilated.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "Vmatch.h"
#include "model/spec/generated/selfproj_spec.h"
#include "sim/board/match_engine.h"

namespace selfproj {
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

}  // namespace selfproj
