// The rings of this machine.
#ifndef SELFPROJ_HOST_DRIVER_RING_LIST_H
#define SELFPROJ_HOST_DRIVER_RING_LIST_H

#include <cstdint>
#include <string>
#include <vector>

namespace selfproj {

// A ring, as it is now.
struct RingInfo {
  std::string name;
  std::string problem;          // why it cannot be used; the rest is then 0
  bool board = false;           // a board is writing into it
  bool reader = false;          // a reader has it
  std::uint32_t board_pid = 0;  // of the last board and reader
  std::uint32_t reader_pid = 0;
  std::uint32_t slots = 0;
  std::uint64_t written = 0;  // packets put into it
  std::uint64_t read = 0;     // packets released
  std::uint64_t lost = 0;     // packets that found it full
  std::uint32_t boards = 0;   // started so far
  std::uint32_t readers = 0;
  std::uint32_t board_crashes = 0;  // of these, ended without saying so
  std::uint32_t reader_crashes = 0;
};

// In the order of their names. Disturbs no one.
std::vector<RingInfo> list_rings();

// Takes away the name of a ring: its reader reads what is in it, and then waits for a new one; its writer writes on for
// nobody. False where there is none. Throws UserError where that is not allowed or the name is none.
bool remove_ring(const std::string& name);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_RING_LIST_H
