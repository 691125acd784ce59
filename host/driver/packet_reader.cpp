#include "host/driver/packet_reader.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "host/driver/counters.h"
#include "host/driver/packet_limits.h"
#include "model/packet.h"

namespace selfproj {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::array<std::uint8_t, 4> kMagicBytes{spec::kMagic & 0xFFU, spec::kMagic >> 8U & 0xFFU,
                                                  spec::kMagic >> 16U & 0xFFU, spec::kMagic >> 24U & 0xFFU};

// Whether `bytes` begin like the magic number, as far as there are any.
bool begins_like_magic(Bytes bytes) {
  return std::equal(bytes.begin(),
                    bytes.begin() + static_cast<std::ptrdiff_t>(std::min(bytes.size(), kMagicBytes.size())),
                    kMagicBytes.begin());
}

// Bytes up to the first place, from 1 on, where a packet may begin, or all of them.
std::size_t up_to_magic(Bytes bytes) {
  for (std::size_t at = 1; at < bytes.size(); ++at) {
    const void* found = std::memchr(bytes.data() + at, kMagicBytes[0], bytes.size() - at);
    if (found == nullptr) {
      break;
    }
    at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes.data());
    if (begins_like_magic(bytes.subspan(at))) {
      return at;
    }
  }
  return bytes.size();
}

std::size_t payload_size(Bytes header) {
  std::uint32_t size = 0;
  for (std::size_t i = 0; i < sizeof size; ++i) {
    size |= std::uint32_t{header[spec::kHeaderPayloadSize + i]} << (8 * i);
  }
  return size;
}

// As parse_packet, but no more bytes are asked for where those there already show that this is no packet, or none that
// a board sends.
PacketError judge(Bytes bytes, PacketView& packet) {
  if (!begins_like_magic(bytes)) {
    return PacketError::magic;
  }
  const PacketError error = parse_packet(bytes.first(std::min(bytes.size(), kLargestPacketBytes)), packet);
  if (error == PacketError::too_short && bytes.size() >= spec::kHeaderBytes &&
      spec::kHeaderBytes + payload_size(bytes) + spec::kTrailerBytes > kLargestPacketBytes) {
    return PacketError::size;
  }
  return error;
}

}  // namespace

PacketStreamReader::PacketStreamReader(Counters& counters, std::size_t capacity)
    : counters_(counters), buffer_(std::max(capacity, 2 * kLargestPacketBytes)) {}

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

bool PacketStreamReader::next(PacketView& packet) {
  while (begin_ < end_) {
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
    counters_.bad += due_ || (error != PacketError::magic && bytes.size() >= kMagicBytes.size()) ? 1 : 0;
    counters_.other_spec += error == PacketError::hash || error == PacketError::version ? 1 : 0;
    discard(up_to_magic(bytes));
  }
  return false;
}

}  // namespace selfproj
