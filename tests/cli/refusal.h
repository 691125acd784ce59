// How programs refuse bad input.
#ifndef SELFPROJ_TESTS_CLI_REFUSAL_H
#define SELFPROJ_TESTS_CLI_REFUSAL_H

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/cli/program.h"

namespace selfproj::test {

// Expects this status, and one line on standard error that begins with the program's name and `begin`, and contains all
// of these texts. Bad input (status 2) prints nothing on standard output.
inline void expect_refusal(const Outcome& outcome, const std::string& begin, const std::vector<std::string>& texts = {},
                           int status = 2) {
  const std::string& err = outcome.err;
  EXPECT_EQ(outcome.status, status) << err;
  EXPECT_TRUE(status != 2 || outcome.out.empty()) << outcome.out;
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_EQ(err.find('\n'), err.size() - 1) << err;
  EXPECT_TRUE(err.starts_with("selfproj: " + begin) || err.starts_with("selfproj-sim: " + begin))
      << begin << " is not the beginning of: " << err;
  for (const std::string& text : texts) {
    EXPECT_NE(err.find(text), std::string::npos) << text << " is not in: " << err;
  }
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_CLI_REFUSAL_H
