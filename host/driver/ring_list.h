// The rings of this machine.
#ifndef SELFPROJ_HOST_DRIVER_RING_LIST_H
#define SELFPROJ_HOST_DRIVER_RING_LIST_H

#include <cstdint>
#include <string>
#include <vector>

namespace selfproj {

// The present state of a ring.
struct RingInfo {
  std::string name;
  std::string problem;          // why the ring cannot be used; the rest is then 0
  bool board = false;           // a board is writing into it
  bool reader = false;          // a reader is reading from it
  std::uint32_t board_pid = 0;  // process IDs of the last board and reader
  std::uint32_t reader_pid = 0;
  std::uint32_t slots = 0;
  std::uint64_t written = 0;  // packets put into it
  std::uint64_t read = 0;     // packets released
  std::uint64_t lost = 0;     // packets for which it had no room
  std::uint32_t boards = 0;   // boards started so far
  std::uint32_t readers = 0;
  std::uint32_t board_crashes = 0;  // of these, boards that ended without saying so
  std::uint32_t reader_crashes = 0;
};

// All rings in the order of their names. Does not disturb their users.
std::vector<RingInfo> list_rings();

// Removes the name of a ring. Its reader reads the remaining packets, and then waits for a new ring. Its writer
// continues, but nobody reads. Returns false if the ring does not exist. Throws UserError if removal is not allowed or
// the name is invalid.
bool remove_ring(const std::string& name);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_RING_LIST_H
