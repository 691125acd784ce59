// The counters of a device since it was opened.
#ifndef SELFPROJ_DRIVER_COUNTERS_H
#define SELFPROJ_DRIVER_COUNTERS_H

#include <array>
#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>

namespace selfproj::driver {

// Nothing is lost, torn or skipped without one of these counters saying so. All of them only grow.
struct Counters {
  std::uint64_t delivered = 0;        // packets given out
  std::uint64_t flagged = 0;          // of these, packets of frames that broke on the board (status is not 0)
  std::uint64_t lost_board = 0;       // packets for which the board's FIFO had no room, from the headers' field `lost`
  std::uint64_t lost_ring = 0;        // packets for which the ring had no room, because the reader was too slow
  std::uint64_t missing = 0;          // frames without moments, from gaps in the sequence, whatever the reason
  std::uint64_t bad = 0;              // packets refused: they began, or were expected here, but were not right
  std::uint64_t other_spec = 0;       // of these, packets of a board built from another specification
  std::uint64_t resynchronized = 0;   // times that the next whole packet was found after other bytes
  std::uint64_t bytes_discarded = 0;  // bytes that belong to no good packet
  std::uint64_t repeated = 0;         // good packets that had come before; they are not given out again
  std::uint64_t restarts = 0;         // times that the board's sequence or clock went back because of a reset
  std::uint64_t reattached = 0;       // ring, LitePCIe: times that a new writer, or a new ring of this name, took over
  std::uint64_t read_errors = 0;   // faults of the device after which reading continued; a ring removed and not renewed
  std::uint64_t lost_network = 0;  // network: packets of which a datagram did not come
  std::uint64_t datagrams_lost = 0;       // network: datagrams that did not come, whoever lost them
  std::uint64_t datagrams_overflow = 0;   // of these, those for which the socket's buffer had no room
  std::uint64_t datagrams_doubled = 0;    // network: datagrams that had come before
  std::uint64_t datagrams_reordered = 0;  // network: datagrams that came after a later one
  std::uint64_t datagrams_refused = 0;    // network: datagrams that are none of a board, or are cut

  bool operator==(const Counters&) const = default;
};

// The names of a counter: its key in JSON, which is the name of the field, and its label in reports and on terminals.
struct CounterName {
  std::uint64_t Counters::*field;
  const char* key;
  const char* label;
};

// Every counter once, in the order of the fields.
inline constexpr std::array<CounterName, 19> kCounterNames = {{
    {&Counters::delivered, "delivered", "packets delivered"},
    {&Counters::flagged, "flagged", "packets flagged by the board"},
    {&Counters::lost_board, "lost_board", "lost on the board"},
    {&Counters::lost_ring, "lost_ring", "lost in the ring"},
    {&Counters::missing, "missing", "missing frames"},
    {&Counters::bad, "bad", "bad packets"},
    {&Counters::other_spec, "other_spec", "packets of another specification"},
    {&Counters::resynchronized, "resynchronized", "resynchronized"},
    {&Counters::bytes_discarded, "bytes_discarded", "bytes discarded"},
    {&Counters::repeated, "repeated", "repeated packets"},
    {&Counters::restarts, "restarts", "restarts of the board"},
    {&Counters::reattached, "reattached", "changes of writer or ring"},
    {&Counters::read_errors, "read_errors", "errors of the device"},
    {&Counters::lost_network, "lost_network", "lost in the network"},
    {&Counters::datagrams_lost, "datagrams_lost", "datagrams lost"},
    {&Counters::datagrams_overflow, "datagrams_overflow", "datagrams lost in the socket's buffer"},
    {&Counters::datagrams_doubled, "datagrams_doubled", "datagrams doubled"},
    {&Counters::datagrams_reordered, "datagrams_reordered", "datagrams out of order"},
    {&Counters::datagrams_refused, "datagrams_refused", "datagrams refused"},
}};
static_assert(sizeof(Counters) == kCounterNames.size() * sizeof(std::uint64_t), "a counter has no name");

// The names of one counter, as in name_of(&Counters::bad). Throws std::invalid_argument for an unknown one.
constexpr const CounterName& name_of(std::uint64_t Counters::*field) {
  for (const CounterName& name : kCounterNames) {
    if (name.field == field) {
      return name;
    }
  }
  throw std::invalid_argument("no such counter");
}

// Several counters in one line, such as "lost on the board 0, missing frames 2".
inline std::string counters_text(const Counters& counters, std::initializer_list<std::uint64_t Counters::*> which) {
  std::string text;
  for (std::uint64_t Counters::*const counter : which) {
    text += (text.empty() ? "" : ", ") + std::string(name_of(counter).label) + ' ' + std::to_string(counters.*counter);
  }
  return text;
}

}  // namespace selfproj::driver

#endif  // SELFPROJ_DRIVER_COUNTERS_H
