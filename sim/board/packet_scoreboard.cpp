#include "sim/board/packet_scoreboard.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "selfproj/model/packet.h"

namespace selfproj::sim {
namespace {

std::string name_of(const model::PacketHeader& header) {
  return "packet of frame " + std::to_string(header.sequence + 1) + " (" + std::to_string(header.columns) + " x " +
         std::to_string(header.rows) + ", mode " + std::to_string(header.mode) + "), line " +
         std::to_string(header.first_line) + ", kind " + std::to_string(header.kind);
}

}  // namespace

void PacketScoreboard::expect(model::BoardPacket&& packet) {
  streams_[index(packet.header.kind)].expected.push_back(std::move(packet));
}

bool PacketScoreboard::compare(std::span<const std::uint8_t> bytes) {
  model::PacketView got;
  const model::PacketError error = model::parse_packet(bytes, got);
  if (error != model::PacketError::none) {
    return fail(std::string("no packet: ") + model::to_string(error) + ", " + std::to_string(bytes.size()) + " bytes");
  }
  Stream& stream = streams_[index(got.header.kind)];
  const auto found =
      std::find_if(stream.expected.begin(), stream.expected.end(), [&](const model::BoardPacket& packet) {
        return packet.header.sequence == got.header.sequence && packet.header.first_line == got.header.first_line;
      });
  if (found == stream.expected.end()) {
    return fail(name_of(got.header) + ": none is expected");
  }
  stream.known.lost += static_cast<std::uint64_t>(found - stream.expected.begin());
  model::BoardPacket packet = std::move(*found);
  stream.expected.erase(stream.expected.begin(), found + 1);
  packet.header.lost = stream.lost_in_all();
  want_.clear();
  model::append_packet(packet.header, packet.payload, packet.status, want_);
  if (!std::equal(want_.begin(), want_.end(), bytes.begin(), bytes.end())) {
    const auto at = std::mismatch(want_.begin(), want_.end(), bytes.begin(), bytes.end()).first - want_.begin();
    const auto both = [](const char* what, std::size_t is, std::size_t expected) {
      return std::string("; ") + what + " " + std::to_string(is) + ", expected " + std::to_string(expected);
    };
    return fail(name_of(got.header) + ": differs from the model's at byte " + std::to_string(at) +
                both("size", bytes.size(), want_.size()) + both("lost", got.header.lost, packet.header.lost) +
                both("status", got.status, packet.status));
  }
  ++stream.known.matched;
  stream.known.last_header = got.header;
  stream.known.last_status = got.status;
  ++by_status_[got.status];
  matched_bytes_ += bytes.size();
  if (model::has_columns(got.header.kind) && !got.payload.empty()) {
    matched_columns_ += got.header.columns;
  }
  if (got.header.kind == spec::kKindCodes) {
    matched_codes_ += got.payload.size() / sizeof(std::uint16_t);
  }
  return true;
}

void PacketScoreboard::finish() {
  for (Stream& stream : streams_) {
    stream.known.lost += stream.expected.size();
    stream.expected.clear();
  }
}

std::uint64_t PacketScoreboard::matched() const {
  std::uint64_t sum = 0;
  for (const Stream& stream : streams_) {
    sum += stream.known.matched;
  }
  return sum;
}

std::uint64_t PacketScoreboard::lost() const {
  std::uint64_t sum = 0;
  for (const Stream& stream : streams_) {
    sum += stream.known.lost;
  }
  return sum;
}

bool PacketScoreboard::fail(const std::string& what) {
  if (mismatches_++ == 0) {
    first_mismatch_ = what;
  }
  return false;
}

}  // namespace selfproj::sim
