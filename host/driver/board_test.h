#ifndef SELFPROJ_HOST_DRIVER_BOARD_TEST_H
#define SELFPROJ_HOST_DRIVER_BOARD_TEST_H

#include <string>
#include <vector>

#include "host/driver/control.h"

namespace selfproj {

struct BoardTestResult {
  std::string what;
  std::string fault;  // empty: the check is good
};

// Tests the way to the registers of a board that is stopped and gives no trigger pulses: every bit of
// registers that take any value is written and read as 0 and 1, values that every board refuses are refused, and the
// clock runs. Every register has its old value afterwards. Throws UserError if the board is not stopped, or does not
// answer.
std::vector<BoardTestResult> test_board(Control& control);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_BOARD_TEST_H
