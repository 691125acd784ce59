#include "sim/app/cosim_run.h"

#include <fmt/format.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "host/driver/sim_device.h"
#include "sim/platform/packet_checker.h"

namespace selfproj {
namespace {

// A packet as its bytes: PacketView's payload lies between header and trailer.
std::span<const std::uint8_t> bytes_of(const PacketView& packet) {
  return {packet.payload.data() - spec::kHeaderBytes, packet.size};
}

}  // namespace

CosimResult run_cosim(const PlatformOptions& options, FrameSource& frames, const CosimCallbacks& callbacks) {
  CosimResult result;
  PacketChecker checker;
  SimDevice device;

  const auto next_packets = [&] {
    PacketView packet;
    while (device.next(packet, std::chrono::nanoseconds(0)) == Next::packet) {
      const std::span<const std::uint8_t> bytes = bytes_of(packet);
      if (checker.check(bytes) && packet.header.kind == spec::kKindMoments) {
        ++result.frames;
      }
      if (callbacks.packet) {
        callbacks.packet(bytes, packet);
      }
      device.release();
    }
  };
  const auto receive = [&](std::span<const std::uint8_t> bytes) {
    for (std::size_t at = 0; at < bytes.size(); at += spec::kPacketBeatBytes) {
      const bool last = at + spec::kPacketBeatBytes >= bytes.size();
      if (!device.push(bytes.subspan(at, last ? bytes.size() - at : spec::kPacketBeatBytes), last)) {
        throw std::logic_error("the driver's buffer is full");
      }
    }
    next_packets();
  };

  std::size_t given = 0;
  Platform platform(
      options,
      [&]() -> std::optional<ImageView> {
        const Image* image = frames.next();
        if (image == nullptr) {
          return std::nullopt;
        }
        if (callbacks.frame) {
          callbacks.frame(given, frames.picture());
        }
        ++given;
        return image->view();
      },
      [&](std::span<const std::uint8_t> bytes, std::uint64_t /*time_ps*/) { receive(bytes); },
      [&](BoardPacket&& packet) { checker.expect(std::move(packet)); });
  platform.run();
  device.finish();
  next_packets();
  checker.finish();

  result.columns = checker.matched_columns();
  result.codes = checker.matched_codes();
  result.mismatches = checker.mismatches();
  result.first_mismatch = checker.first_mismatch();
  result.lost = checker.lost();
  result.platform = platform.report();
  result.driver = device.counters();

  // What was counted must fit together, too.
  const auto must_be = [&](std::uint64_t got, std::uint64_t want, const char* what) {
    if (got != want && result.mismatches++ == 0) {
      result.first_mismatch = fmt::format("{}: {}, expected {}", what, got, want);
    }
  };
  const BoardCounters& board = result.platform.board;
  must_be(board.frames, result.platform.frames, "frames accepted by the board");
  must_be(board.broken, 0, "broken frames");
  must_be(board.stray, 0, "beats outside any frame");
  must_be(board.lost_moments + board.lost_image + board.lost_codes, result.lost, "packets lost by the board's count");
  must_be(board.abandoned, 0, "frames abandoned by the decoder");
  must_be(result.driver.bad, 0, "packets refused by the driver");
  must_be(result.driver.bytes_discarded, 0, "bytes discarded by the driver");
  must_be(device.misframed(), 0, "packets whose end is not where their header says");
  must_be(result.driver.delivered, result.platform.packets, "packets delivered by the driver");
  return result;
}

std::string outcome_text(const CosimResult& result) {
  return fmt::format("matched {} columns in {} frames, {} mismatches", result.columns, result.frames,
                     result.mismatches);
}

}  // namespace selfproj
