// Moments from the RTL: frames go into the Verilated board, and packets come out.
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

#include "Vboard.h"
#include "Vboard_runs.h"
#include "model/packet.h"
#include "sim/board/board_device.h"
#include "sim/board/moments_engine.h"

namespace selfproj {
namespace {

class RtlEngine final : public MomentsEngine {
 public:
  [[nodiscard]] std::string name() const override { return "rtl"; }

  void process(std::span<const ImageView> frames, const MomentsSettings& settings, std::span<Runs> out) override {
    if (settings.measure.select == Select::strongest) {
      process_on<Vboard_runs>(frames, settings, out);
    } else {
      process_on<Vboard>(frames, settings, out);
    }
  }

 private:
  template <class Model>
  void process_on(std::span<const ImageView> frames, const MomentsSettings& settings, std::span<Runs> out) {
    const Measure& measure = settings.measure;
    BoardDevice<Model> board;
    std::size_t received = 0;
    std::string problem;
    board.on_packet([&](std::span<const std::uint8_t> bytes) {
      PacketView packet;
      const PacketError error = parse_packet(bytes, packet);
      if (error != PacketError::none) {
        problem = std::string("bad packet: ") + to_string(error);
      } else if (packet.status != 0 || packet.header.lost != 0 || packet.header.sequence != received ||
                 received == out.size()) {
        problem = "frame " + std::to_string(received + 1) + " was lost or broken on the board";
      } else {
        out[received].resize(measure.select, settings.columns);
        unpack_columns(measure.select, measure.mode, settings.columns, packet.payload.data(), out[received].view());
        ++received;
      }
    });
    board.write(BoardSettings{.columns = settings.columns,
                              .rows = settings.rows,
                              .mode = measure.mode,
                              .threshold = measure.threshold,
                              .select = measure.select,
                              .gap = measure.gap,
                              .window = measure.window});
    // Frames of few rows must not follow each other immediately. Leave the time that two packets need.
    const auto gap = static_cast<std::uint32_t>(moments_payload_bytes(measure.mode, settings.columns) / 8 + 64);
    for (const ImageView& frame : frames) {
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

}  // namespace selfproj
