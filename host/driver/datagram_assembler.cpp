#include "host/driver/datagram_assembler.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "host/driver/counters.h"
#include "model/datagram.h"
#include "model/packet.h"

namespace selfproj {
namespace {

// How far the first number is behind the second, modulo 2^32; negative if it is before it.
std::int32_t distance(std::uint32_t number, std::uint32_t from) { return static_cast<std::int32_t>(number - from); }

}  // namespace

DatagramAssembler::DatagramAssembler(Counters& counters) : counters_(counters) {
  for (Slot& slot : slots_) {
    slot.bytes.resize(kLargestPacketBytes);
  }
}

void DatagramAssembler::clear(Slot& slot) {
  slot.received = 0;
  slot.begun = false;
}

// A session that is seen early is taken from its beginning: what is missing there was lost.
void DatagramAssembler::begin(const DatagramHeader& header) {
  const bool from_start = header.sequence < kSequences;
  session_ = header.session;
  started_ = true;
  seen_.set();
  next_sequence_ = from_start ? 0 : header.sequence;
  in_middle_ = !from_start && header.offset != 0;
  joined_ = header.packet;
  next_packet_ = from_start ? 0 : header.packet + (in_middle_ ? 1 : 0);
  end_packet_ = next_packet_;
  given_up_ = next_packet_;
}

bool DatagramAssembler::note(std::uint32_t sequence) {
  const std::int32_t ahead = distance(sequence, next_sequence_);
  if (ahead < -static_cast<std::int32_t>(kSequences)) {
    ++counters_.datagrams_reordered;  // too late to know more
    return false;
  }
  if (ahead < 0) {
    if (seen_[sequence % kSequences]) {
      ++counters_.datagrams_doubled;
      return false;
    }
    ++counters_.datagrams_reordered;
    seen_.set(sequence % kSequences);
    return true;
  }
  // Datagrams that leave the memory without having come are lost.
  const auto steps = static_cast<std::uint32_t>(ahead) + 1;
  for (std::uint32_t i = 0; i < std::min<std::uint32_t>(steps, kSequences); ++i) {
    const std::size_t place = (next_sequence_ + i) % kSequences;
    counters_.datagrams_lost += seen_[place] ? 0 : 1;
    seen_.reset(place);
  }
  counters_.datagrams_lost += steps > kSequences ? steps - kSequences : 0;
  next_sequence_ = sequence + 1;
  seen_.set(sequence % kSequences);
  return true;
}

bool DatagramAssembler::add(std::span<const std::uint8_t> datagram) {
  const std::optional<DatagramHeader> header = read_datagram_header(datagram);
  const bool holds_header =
      header && (header->offset != 0 || header->length == 0 || header->length >= spec::kHeaderBytes);
  if (!holds_header || std::size_t{header->offset} + header->length > kLargestPacketBytes) {
    ++counters_.datagrams_refused;
    return true;
  }
  if (!started_) {
    begin(*header);
  } else if (header->session != session_) {
    if (had_session_ && header->session == old_session_) {
      ++counters_.datagrams_refused;  // late, of the session before
      return true;
    }
    flush();
    if (next_packet_ != given_up_) {
      return false;
    }
    old_session_ = session_;
    had_session_ = true;
    ++counters_.reattached;
    begin(*header);
  }
  if (header->length == 0) {
    // Everything before this packet has been sent. What does not come before the next silence is lost.
    static_cast<void>(note(header->sequence));
    end_packet_ = distance(header->packet, end_packet_) > 0 ? header->packet : end_packet_;
    return true;
  }
  if (distance(header->packet, next_packet_) >= static_cast<std::int32_t>(kPackets)) {
    const std::uint32_t oldest = header->packet + 1 - static_cast<std::uint32_t>(kPackets);
    given_up_ = distance(oldest, given_up_) > 0 ? oldest : given_up_;
    return false;
  }
  if (note(header->sequence)) {
    store(*header, datagram.subspan(spec::kDatagramHeaderBytes));
  }
  return true;
}

void DatagramAssembler::store(const DatagramHeader& header, std::span<const std::uint8_t> piece) {
  if (distance(header.packet, next_packet_) < 0) {
    counters_.bytes_discarded += in_middle_ && header.packet == joined_ ? piece.size() : 0;
    return;  // its packet is counted as lost
  }
  Slot& place = slot(header.packet);
  std::memcpy(place.bytes.data() + header.offset, piece.data(), piece.size());
  place.received += piece.size();
  place.begun = place.begun || header.offset == 0;
  end_packet_ = distance(header.packet, end_packet_) >= 0 ? header.packet + 1 : end_packet_;
}

bool DatagramAssembler::complete(const Slot& slot) const {
  return slot.begun && slot.received >= std::min(announced_packet_bytes(slot.bytes).value_or(0), kLargestPacketBytes);
}

// Counts packets that no slot holds.
void DatagramAssembler::give_up(std::uint32_t packets) {
  counters_.lost_network += packets;
  next_packet_ += packets;
}

bool DatagramAssembler::next(PacketView& packet) {
  if (held_) {
    clear(slot(next_packet_ - 1));
    held_ = false;
  }
  for (std::size_t looked = 0;; ++looked) {
    if (looked >= kPackets && distance(given_up_, next_packet_) > 0) {
      give_up(given_up_ - next_packet_);  // further away than any slot
    }
    Slot& place = slot(next_packet_);
    if (complete(place)) {
      const std::span<const std::uint8_t> bytes(place.bytes.data(), place.received);
      const PacketError error = place.received > kLargestPacketBytes ? PacketError::size : parse_packet(bytes, packet);
      ++next_packet_;
      if (error == PacketError::none && packet.size == place.received) {
        held_ = true;
        return true;
      }
      ++counters_.bad;
      counters_.other_spec += error == PacketError::hash || error == PacketError::version ? 1 : 0;
      clear(place);
    } else if (distance(given_up_, next_packet_) > 0) {
      clear(place);
      give_up(1);
    } else {
      return false;
    }
  }
}

void DatagramAssembler::flush() {
  given_up_ = distance(end_packet_, given_up_) > 0 ? end_packet_ : given_up_;
  if (started_) {
    counters_.datagrams_lost += kSequences - seen_.count();
    seen_.set();
  }
}

}  // namespace selfproj
