#include "sim/platform/packet_checker.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <utility>

#include "model/packet.h"

namespace selfproj {

void PacketChecker::expect(BoardPacket&& packet) { expected_[index(packet.header.kind)].push_back(std::move(packet)); }

bool PacketChecker::check(std::span<const std::uint8_t> bytes) {
  PacketView got;
  const PacketError error = parse_packet(bytes, got);
  if (error != PacketError::none) {
    return fail(std::string("no packet: ") + to_string(error));
  }
  const std::string name = "packet of frame " + std::to_string(got.header.sequence + 1) + ", line " +
                           std::to_string(got.header.first_line) + ", kind " + std::to_string(got.header.kind);
  std::deque<BoardPacket>& expected = expected_[index(got.header.kind)];
  std::uint64_t& lost = lost_[index(got.header.kind)];
  const auto found = std::find_if(expected.begin(), expected.end(), [&](const BoardPacket& packet) {
    return packet.header.sequence == got.header.sequence && packet.header.first_line == got.header.first_line;
  });
  if (found == expected.end()) {
    return fail(name + ": none is expected");
  }
  lost += static_cast<std::uint64_t>(found - expected.begin());
  BoardPacket packet = std::move(*found);
  expected.erase(expected.begin(), found + 1);
  packet.header.lost = static_cast<std::uint32_t>(lost);
  want_.clear();
  append_packet(packet.header, packet.payload, packet.status, want_);
  if (!std::equal(want_.begin(), want_.end(), bytes.begin(), bytes.end())) {
    const auto at = std::mismatch(want_.begin(), want_.end(), bytes.begin(), bytes.end()).first - want_.begin();
    return fail(name + ": differs from the model's at byte " + std::to_string(at));
  }
  ++matched_;
  if (got.header.kind == spec::kKindMoments && !got.payload.empty()) {
    matched_columns_ += got.header.columns;
  }
  if (got.header.kind == spec::kKindCodes) {
    matched_codes_ += got.payload.size() / sizeof(std::uint16_t);
  }
  return true;
}

void PacketChecker::finish() {
  for (std::size_t kind = 0; kind < expected_.size(); ++kind) {
    lost_[kind] += expected_[kind].size();
    expected_[kind].clear();
  }
}

bool PacketChecker::fail(const std::string& what) {
  if (mismatches_++ == 0) {
    first_mismatch_ = what;
  }
  return false;
}

}  // namespace selfproj
