// The main function of all soaks.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/support/soak.h"

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  auto& command = selfproj::test::soak_command;
  command.program = argv[0];
  for (int i = 1; i < argc; ++i) {
    command.numbers.push_back(std::strtoull(argv[i], nullptr, 10));
  }
  return RUN_ALL_TESTS();
}
