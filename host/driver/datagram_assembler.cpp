#include "host/driver/datagram_assembler.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "model/datagram.h"
#include "selfproj/driver/counters.h"
#include "selfproj/model/packet.h"

namespace selfproj::driver {
namespace {

// The numbers of a stream begin here, so that those before them are positive, too.
constexpr std::uint64_t kBase = std::uint64_t{1} << 33U;

// Datagrams overtake each other by no more than so many datagrams.
constexpr auto kWindow = static_cast<std::int32_t>(DatagramAssembler::kSequences);

// As little, while the first datagram is the only one.
constexpr std::int32_t kNearStart = 16;

// How far a number of 32 bits that wraps is behind another one; negative if it is before it.
std::int32_t distance(std::uint32_t number, std::uint32_t from) { return static_cast<std::int32_t>(number - from); }

// The number near `from` of which a datagram has the lower 32 bits.
std::uint64_t unwrapped(std::uint32_t number, std::uint64_t from) {
  return from + static_cast<std::uint64_t>(std::int64_t{distance(number, static_cast<std::uint32_t>(from))});
}

// Whether a datagram is one of a session's first.
bool young(const model::DatagramHeader& header, std::uint32_t limit) {
  return header.sequence < limit && header.packet <= header.sequence;
}

}  // namespace

DatagramAssembler::DatagramAssembler(Counters& counters) : counters_(counters) {
  for (Slot& slot : slots_) {
    slot.bytes.resize(model::kLargestPacketBytes);
  }
  for (std::vector<std::uint8_t>& datagram : candidate_.datagrams) {
    datagram.reserve(spec::kDatagramHeaderBytes + model::kLargestPacketBytes);
  }
}

void DatagramAssembler::clear(Slot& slot) {
  slot.received = 0;
  slot.begun = false;
}

void DatagramAssembler::go_to(const Position& position) {
  next_sequence_ = position.sequence;
  next_packet_ = position.packet;
  end_packet_ = position.packet;
  given_up_ = position.packet;
  accepted_ = 0;
  seen_.set();
}

// A session that is received early is taken from its beginning: what is missing there was lost.
void DatagramAssembler::begin(const model::DatagramHeader& header) {
  const bool from_start = young(header, kSequences);
  session_ = header.session;
  started_ = true;
  in_middle_ = !from_start && header.offset != 0;
  joined_ = kBase + header.packet;
  go_to({.sequence = from_start ? kBase : kBase + header.sequence,
         .packet = from_start ? kBase : kBase + header.packet + (in_middle_ ? 1U : 0U)});
}

// Datagrams overtake each other by up to kPackets packets and kSequences datagrams. A first datagram that is far ahead
// may be a false one.
bool DatagramAssembler::follows(const model::DatagramHeader& header) const {
  const std::int32_t datagrams = distance(header.sequence, static_cast<std::uint32_t>(next_sequence_));
  const std::int32_t packets = distance(header.packet, static_cast<std::uint32_t>(end_packet_));
  const std::int32_t behind = accepted_ < kConfirmations ? kNearStart : kWindow;
  return header.session == session_ && datagrams >= -behind && datagrams < kWindow && packets >= -behind &&
         packets <= static_cast<std::int32_t>(kPackets);
}

bool DatagramAssembler::note(std::uint64_t sequence) {
  if (sequence + kSequences < next_sequence_) {
    ++counters_.datagrams_reordered;  // too late to know more
    return false;
  }
  if (sequence < next_sequence_) {
    if (seen_[sequence % kSequences]) {
      ++counters_.datagrams_doubled;
      return false;
    }
    ++counters_.datagrams_reordered;
    seen_.set(sequence % kSequences);
    return true;
  }
  // Datagrams that leave the memory without having come are lost.
  for (; next_sequence_ <= sequence; ++next_sequence_) {
    const std::size_t place = next_sequence_ % kSequences;
    counters_.datagrams_lost += seen_[place] ? 0 : 1;
    seen_.reset(place);
  }
  seen_.set(sequence % kSequences);
  return true;
}

bool DatagramAssembler::add(std::span<const std::uint8_t> datagram) {
  const std::optional<model::DatagramHeader> header = model::read_datagram_header(datagram);
  const bool holds_header =
      header && (header->offset != 0 || header->length == 0 || header->length >= spec::kHeaderBytes);
  if (!holds_header || std::size_t{header->offset} + header->length > model::kLargestPacketBytes) {
    ++counters_.datagrams_refused;
    return true;
  }
  if (replayed_ < to_replay_) {
    return false;
  }
  if (!started_) {
    begin(*header);
  }
  return follows(*header) || accepted_ == 0 ? add_to_stream(*header, datagram) : add_to_candidate(*header, datagram);
}

bool DatagramAssembler::add_to_stream(const model::DatagramHeader& header, std::span<const std::uint8_t> datagram) {
  const std::uint64_t packet = unwrapped(header.packet, end_packet_);
  if (header.length != 0 && packet >= next_packet_ + kPackets) {
    given_up_ = std::max(given_up_, packet + 1 - kPackets);
    end_packet_ = std::max(end_packet_, given_up_);
    return false;
  }
  refuse_candidate();
  ++accepted_;
  if (accepted_ == kSequences) {
    count_gap();
  }
  if (!note(unwrapped(header.sequence, next_sequence_))) {
    return true;
  }
  if (header.length == 0) {
    // Everything before this packet has been sent. What does not come before the next silence is lost.
    end_packet_ = std::max(end_packet_, packet);
  } else {
    store(header, packet, datagram.subspan(spec::kDatagramHeaderBytes));
  }
  return true;
}

void DatagramAssembler::refuse_candidate() {
  counters_.datagrams_refused += static_cast<std::uint64_t>(candidate_.count);
  candidate_.count = 0;
}

const DatagramAssembler::Session* DatagramAssembler::earlier(std::uint16_t session) const {
  for (std::size_t i = 0; i < std::min(sessions_, earlier_.size()); ++i) {
    if (earlier_[i].number == session) {
      return &earlier_[i];
    }
  }
  return nullptr;
}

DatagramAssembler::Change DatagramAssembler::change_to(const model::DatagramHeader& first) const {
  const auto beyond = [&first](const Position& position) {
    return distance(first.packet, static_cast<std::uint32_t>(position.packet)) >= -kWindow &&
           distance(first.sequence, static_cast<std::uint32_t>(position.sequence)) >= -kWindow;
  };
  const bool ahead = beyond({.sequence = next_sequence_, .packet = next_packet_});
  if (first.session == session_ && gap_open_ && !ahead && beyond(before_gap_)) {
    return Change::goes_back;
  }
  if (accepted_ < kConfirmations) {
    return Change::false_start;
  }
  if (first.session == session_) {
    return ahead ? Change::goes_on : Change::restarts_as_known;
  }
  if (const Session* const session = earlier(first.session); session != nullptr) {
    return beyond(session->position) ? Change::resumes : Change::restarts_as_known;
  }
  return Change::restarts;
}

bool DatagramAssembler::add_to_candidate(const model::DatagramHeader& header, std::span<const std::uint8_t> datagram) {
  Candidate& candidate = candidate_;
  const std::int32_t datagrams = distance(header.sequence, candidate.last.sequence);
  const std::int32_t packets = distance(header.packet, candidate.last.packet);
  constexpr auto kFurthest = static_cast<std::int32_t>(kYoung);
  const bool goes_on = candidate.count > 0 && header.session == candidate.last.session && datagrams != 0 &&
                       datagrams >= -kWindow && packets >= -kWindow && datagrams < kFurthest && packets < kFurthest;
  if (!goes_on) {
    refuse_candidate();
    candidate.first = header;
  }
  const Change change = change_to(candidate.first);
  const bool last = candidate.count + 1 >= (change == Change::restarts_as_known ? kConfirmationsBack : kConfirmations);
  if (last && change != Change::goes_back && change != Change::false_start) {
    given_up_ = end_packet_;
    if (next_packet_ != given_up_) {
      return false;
    }
  }
  if (candidate.count < kConfirmations) {
    candidate.datagrams[static_cast<std::size_t>(candidate.count)].assign(datagram.begin(), datagram.end());
  }
  ++candidate.count;
  candidate.last = header;
  if (last) {
    change_stream(change);
  }
  return true;
}

// Makes the candidate the stream. What is in assembly belongs to packets that are counted or were false.
void DatagramAssembler::change_stream(Change change) {
  to_replay_ = static_cast<std::size_t>(std::min(candidate_.count, kConfirmations));
  replayed_ = 0;
  counters_.datagrams_refused += static_cast<std::uint64_t>(candidate_.count) - to_replay_;
  candidate_.count = 0;
  model::DatagramHeader first = candidate_.first;
  for (std::size_t i = 1; i < to_replay_; ++i) {
    const model::DatagramHeader header = *model::read_datagram_header(candidate_.datagrams[i]);
    first = distance(header.sequence, first.sequence) < 0 ? header : first;
  }
  for (Slot& slot : slots_) {
    clear(slot);
  }
  held_ = false;
  const Position here{.sequence = next_sequence_, .packet = next_packet_};
  switch (change) {
    case Change::goes_on:
      count_gap();
      go_on(here, first);
      break;
    case Change::goes_back:
      go_on(before_gap_, first);
      break;
    case Change::false_start:
      begin(first);
      break;
    case Change::resumes:
    case Change::restarts:
    case Change::restarts_as_known: {
      gap_open_ = gap_open_ && change != Change::resumes;  // nothing is missing in a session that was a false one
      count_gap();
      ++counters_.reattached;
      const Session* const session = earlier(first.session);
      const Position before = session != nullptr ? session->position : Position{};
      earlier_[sessions_ % earlier_.size()] = {.position = here, .number = session_};
      ++sessions_;
      if (change == Change::resumes) {
        session_ = first.session;
        go_on(before, first);
      } else {
        restart(first);
      }
      break;
    }
  }
}

// Begins a session during which the receiver has listened from the start.
void DatagramAssembler::restart(const model::DatagramHeader& first) {
  begin(first);
  if (!young(first, kYoung)) {
    return;
  }
  if (first.packet >= kPackets) {
    go_on({.sequence = kBase, .packet = kBase}, first);
  } else {  // all packets before this one can still come
    in_middle_ = false;
    go_to({.sequence = kBase + (first.sequence < kSequences ? 0U : first.sequence), .packet = kBase});
  }
}

// Goes on at the number of a datagram. What is missing since `from` is lost, unless the stream goes back.
void DatagramAssembler::go_on(const Position& from, const model::DatagramHeader& first) {
  in_middle_ = false;
  const Position to{.sequence = std::max(unwrapped(first.sequence, from.sequence), from.sequence),
                    .packet = std::max(unwrapped(first.packet, from.packet), from.packet)};
  before_gap_ = from;
  gap_ = {.sequence = to.sequence - from.sequence, .packet = to.packet - from.packet};
  gap_open_ = true;
  go_to(to);
}

void DatagramAssembler::count_gap() {
  if (gap_open_) {
    counters_.lost_network += gap_.packet;
    counters_.datagrams_lost += gap_.sequence;
    gap_open_ = false;
  }
}

void DatagramAssembler::store(const model::DatagramHeader& header, std::uint64_t packet,
                              std::span<const std::uint8_t> piece) {
  if (packet < next_packet_) {
    counters_.bytes_discarded += in_middle_ && packet == joined_ ? piece.size() : 0;
    return;  // its packet is counted as lost
  }
  Slot& place = slot(packet);
  std::memcpy(place.bytes.data() + header.offset, piece.data(), piece.size());
  place.received += piece.size();
  place.begun = place.begun || header.offset == 0;
  end_packet_ = std::max(end_packet_, packet + 1);
}

bool DatagramAssembler::complete(const Slot& slot) const {
  return slot.begun &&
         slot.received >= std::min(model::announced_packet_bytes(slot.bytes).value_or(0), model::kLargestPacketBytes);
}

bool DatagramAssembler::next(model::PacketView& packet) {
  if (held_) {
    clear(slot(next_packet_ - 1));
    held_ = false;
  }
  for (;;) {
    Slot& place = slot(next_packet_);
    if (complete(place)) {
      const std::span<const std::uint8_t> bytes(place.bytes.data(), place.received);
      const model::PacketError error =
          place.received > model::kLargestPacketBytes ? model::PacketError::size : model::parse_packet(bytes, packet);
      ++next_packet_;
      if (error == model::PacketError::none && packet.size == place.received) {
        held_ = true;
        return true;
      }
      ++counters_.bad;
      counters_.other_spec += error == model::PacketError::hash || error == model::PacketError::version ? 1 : 0;
      clear(place);
    } else if (next_packet_ < given_up_) {
      clear(place);
      ++counters_.lost_network;
      ++next_packet_;
    } else if (replayed_ < to_replay_) {
      const std::vector<std::uint8_t>& datagram = candidate_.datagrams[replayed_];
      replayed_ += add_to_stream(*model::read_datagram_header(datagram), datagram) ? 1 : 0;
    } else {
      return false;
    }
  }
}

void DatagramAssembler::flush() {
  given_up_ = end_packet_;
  if (started_) {
    count_gap();
    counters_.datagrams_lost += kSequences - seen_.count();
    seen_.set();
  }
}

}  // namespace selfproj::driver
