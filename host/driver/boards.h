// Finds boards, and tests the access to their registers.
#ifndef SELFPROJ_HOST_DRIVER_BOARDS_H
#define SELFPROJ_HOST_DRIVER_BOARDS_H

#include <filesystem>
#include <string>
#include <vector>

#include "host/driver/control.h"

namespace selfproj::driver {

// A place where a board may be.
struct BoardPlace {
  std::string uri;
  std::string problem;  // why no board can be opened there; empty if one was
};

// Looks for boards, and tries to open the registers of each. First come the files of `devices`, sorted as text:
// xdma*_user and uio* as bar:FILE, litepcie* as litepcie:FILE. Then come `hosts`, as udp:HOST. A folder that cannot be
// read counts as empty.
std::vector<BoardPlace> list_boards(const std::filesystem::path& devices = "/dev",
                                    const std::vector<std::string>& hosts = {});

struct BoardTestResult {
  std::string what;
  std::string fault;  // empty: the check is good
};

// Tests the way to the registers of a board that is stopped and gives no trigger pulses: every bit of registers that
// take any value is written and read as 0 and 1, values that every board refuses are refused, and the clock runs. Every
// register has its old value afterwards. Throws UserError if the board is not stopped, or does not answer.
std::vector<BoardTestResult> test_board(Control& control);

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_BOARDS_H
