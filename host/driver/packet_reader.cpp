#include "host/driver/packet_reader.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "host/driver/counters.h"
#include "model/packet.h"

namespace selfproj {
namespace {

using Bytes = std::span<const std::uint8_t>;

// Like parse_packet, but asks for no more bytes if those present show that this is not a packet that a board sends.
PacketError judge(Bytes bytes, PacketView& packet) {
  if (!begins_like_packet(bytes)) {
    return PacketError::magic;
  }
  const PacketError error = parse_packet(bytes.first(std::min(bytes.size(), kLargestPacketBytes)), packet);
  const bool endless = error == PacketError::too_short && announced_packet_bytes(bytes) > kLargestPacketBytes;
  return endless ? PacketError::size : error;
}

}  // namespace

PacketStreamReader::PacketStreamReader(Counters& counters, std::size_t capacity, std::size_t fill)
    : counters_(counters), fill_(fill), buffer_(std::max(capacity, 2 * kLargestPacketBytes)) {}

std::span<std::uint8_t> PacketStreamReader::room_in_place() { return std::span(buffer_).subspan(end_); }

std::span<std::uint8_t> PacketStreamReader::room() {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, held());
    end_ -= begin_;
    begin_ = 0;
  }
  return room_in_place();
}

void PacketStreamReader::discard(std::size_t bytes) {
  begin_ += bytes;
  counters_.bytes_discarded += bytes;
  due_ = false;
  skipping_ = skipping_ || bytes > 0;
}

void PacketStreamReader::restart() {
  discard(held());
  finished_ = false;
}

void PacketStreamReader::skip_fill() {
  const auto is_zero = [](std::uint8_t byte) { return byte == 0; };
  while (fill_ > 0 && held() >= fill_ && std::all_of(&buffer_[begin_], &buffer_[begin_] + fill_, is_zero)) {
    begin_ += fill_;
  }
}

bool PacketStreamReader::next(PacketView& packet) {
  while (begin_ < end_) {
    if (due_) {
      skip_fill();
    }
    const Bytes bytes(buffer_.data() + begin_, held());
    const PacketError error = judge(bytes, packet);
    if (error == PacketError::none) {
      counters_.resynchronized += skipping_ ? 1 : 0;
      skipping_ = false;
      due_ = true;
      begin_ += packet.size;
      return true;
    }
    if (error == PacketError::too_short && !finished_) {
      return false;
    }
    counters_.bad += due_ || (error != PacketError::magic && bytes.size() >= sizeof spec::kMagic) ? 1 : 0;
    counters_.other_spec += error == PacketError::hash || error == PacketError::version ? 1 : 0;
    discard(find_packet_start(bytes, 1));
  }
  return false;
}

}  // namespace selfproj
