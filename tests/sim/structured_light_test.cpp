// B4 in simulation, with the reference scanned by Gray codes: all figures wanted are reached.
#include "sim/experiment/structured_light.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>

#include "host/io/rig.h"

namespace selfproj {
namespace {

TEST(StructuredLight, CuboidsAreMeasured) {
  StructuredLightOptions options;
  options.rig = load_rig("scanner");
  options.gray_scan = true;
  options.conventional_bits = {4};
  const StructuredLightResult result = run_cuboids(options, [](std::size_t, std::size_t) {});
  EXPECT_TRUE(result.not_reached.empty()) << result.not_reached.front();
  EXPECT_EQ(result.tables.size(), 5U);
  EXPECT_EQ(result.difference.rows, 512);
}

}  // namespace
}  // namespace selfproj
