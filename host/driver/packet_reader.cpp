#include "selfproj/driver/packet_reader.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "selfproj/driver/counters.h"
#include "selfproj/model/packet.h"

namespace selfproj::driver {
namespace {

using Bytes = std::span<const std::uint8_t>;

// Like parse_packet, but asks for no more bytes if those present show that this is not a packet that a board sends.
model::PacketError parse_available(Bytes bytes, model::PacketView& packet) {
  if (!model::begins_like_packet(bytes)) {
    return model::PacketError::magic;
  }
  const model::PacketError error =
      model::parse_packet(bytes.first(std::min(bytes.size(), model::kLargestPacketBytes)), packet);
  const bool endless =
      error == model::PacketError::too_short && model::announced_packet_bytes(bytes) > model::kLargestPacketBytes;
  return endless ? model::PacketError::size : error;
}

}  // namespace

PacketStreamReader::PacketStreamReader(Counters& counters, std::size_t capacity, std::size_t fill)
    : counters_(counters), fill_(fill), buffer_(std::max(capacity, 2 * model::kLargestPacketBytes)) {}

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

bool PacketStreamReader::next(model::PacketView& packet) {
  while (begin_ < end_) {
    if (due_) {
      skip_fill();
    }
    const Bytes bytes(buffer_.data() + begin_, held());
    const model::PacketError error = parse_available(bytes, packet);
    if (error == model::PacketError::none) {
      counters_.resynchronized += skipping_ ? 1 : 0;
      skipping_ = false;
      due_ = true;
      begin_ += packet.size;
      return true;
    }
    if (error == model::PacketError::too_short && !finished_) {
      return false;
    }
    counters_.bad += due_ || (error != model::PacketError::magic && bytes.size() >= sizeof spec::kMagic) ? 1 : 0;
    counters_.other_spec += error == model::PacketError::hash || error == model::PacketError::version ? 1 : 0;
    discard(model::find_packet_start(bytes, 1));
  }
  return false;
}

bool PacketTally::accept(const model::PacketHeader& header) {
  auto& stream = newest_[header.stream];
  const bool of_frame = model::one_for_a_frame(header.kind);
  Newest& kind = stream.at(of_frame ? 0 : static_cast<std::size_t>(header.kind - spec::kKindMoments));
  const model::PacketHeader& newest = kind.header;
  const auto lost_since = static_cast<std::uint32_t>(header.lost - newest.lost);  // modulo 2^32
  constexpr std::uint32_t kBackwards = std::uint32_t{1} << 31U;

  if (kind.known) {
    const bool same_frame = header.same_frame(newest);
    const bool not_later = same_frame && (of_frame || header.first_line <= newest.first_line);
    if (not_later && !kind.anew) {
      ++counters_.repeated;
      return false;
    }
    // If a frame number comes with the wrong time, or anything runs backwards, the board was restarted.
    const bool restarted = not_later || header.sequence < newest.sequence || header.time_stamp < newest.time_stamp ||
                           (!same_frame && header.sequence == newest.sequence) || lost_since >= kBackwards;
    if (restarted) {
      ++counters_.restarts;
      stream.fill({.reset = true});
    } else {
      counters_.lost_board += lost_since;
      counters_.missing += of_frame ? header.sequence - newest.sequence - 1 : 0;
    }
  }
  if (kind.reset) {
    counters_.lost_board += header.lost;
    counters_.missing += of_frame ? header.sequence : 0;
  }
  kind = {.header = header, .known = true, .reset = false, .anew = false};
  return true;
}

bool PacketTally::deliver(const model::PacketView& packet) {
  if (!accept(packet.header)) {
    return false;
  }
  ++counters_.delivered;
  counters_.flagged += packet.status != 0 ? 1 : 0;
  return true;
}

void PacketTally::begin_anew() {
  for (auto& stream : newest_) {
    for (Newest& kind : stream) {
      kind.anew = true;
    }
  }
}

}  // namespace selfproj::driver
