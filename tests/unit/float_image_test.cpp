#include "host/images/float_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "host/files/user_error.h"
#include "tests/cli/program.h"

namespace selfproj {
namespace {

TEST(FloatImage, ComesBackFromTiffWithItsGaps) {
  const test::ScratchFolder folder;
  FloatImage image(3, 5);
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    image.values[i] = 0.1F * static_cast<float>(i) - 1e6F;
  }
  image.row(1)[2] = std::numeric_limits<float>::quiet_NaN();
  const std::string file = folder / "a.tiff";
  write_float_tiff(file, image);
  const FloatImage read = read_float_tiff(file);
  ASSERT_EQ(read.rows, 3);
  ASSERT_EQ(read.columns, 5);
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (i == 7) {
      EXPECT_TRUE(std::isnan(read.values[i]));
    } else {
      EXPECT_EQ(read.values[i], image.values[i]) << i;
    }
  }
}

TEST(FloatImage, OtherFilesAreRefused) {
  const test::ScratchFolder folder;
  EXPECT_THROW(read_float_tiff(folder / "none.tiff"), UserError);
  std::ofstream(folder / "grey.pgm") << "P2\n2 1\n255\n1 2\n";
  EXPECT_THROW(read_float_tiff(folder / "grey.pgm"), UserError);
  EXPECT_THROW(write_float_tiff(folder / "grey.pgm" / "a.tiff", FloatImage(1, 1)), UserError);
  EXPECT_THROW(write_float_tiff(folder / "empty.tiff", FloatImage()), UserError);
}

}  // namespace
}  // namespace selfproj
