// Tests work by several threads.

#include "sim/scene/parallel.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "host/files/user_error.h"

namespace selfproj {
namespace {

TEST(ParallelFor, CallsEachOnceAndPassesOnWhatIsThrown) {
  for (const int threads : {0, 1, 4}) {
    std::vector<int> calls(1000);
    parallel_for(1000, threads, [&](int i) { ++calls[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(calls, std::vector<int>(1000, 1));
    EXPECT_THROW(parallel_for(100, threads,
                              [](int i) {
                                if (i == 7) {
                                  throw UserError("a", "b");
                                }
                              }),
                 UserError);
  }
  parallel_for(0, 2, [](int) { FAIL(); });
}

}  // namespace
}  // namespace selfproj
