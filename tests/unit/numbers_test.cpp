#include "host/files/numbers.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "host/images/frame_options.h"
#include "selfproj/files/user_error.h"

namespace selfproj::test {
namespace {

TEST(Numbers, WholeNumbersAreDecimal) {
  EXPECT_EQ(files::number_of_text<int>("12"), 12);
  EXPECT_EQ(files::number_of_text<int>("010"), 10);
  EXPECT_EQ(files::number_of_text<int>("-3"), -3);
  EXPECT_EQ(files::number_of_text<int>("+3"), 3);
  EXPECT_EQ(files::number_of_text<std::uint64_t>("18446744073709551615"), UINT64_MAX);
  for (const char* text : {"", " 1", "1 ", "0x10", "1.0", "1e3", "--1", "+-1", "2147483648", "1'000", "1_000", "one"}) {
    EXPECT_FALSE(files::number_of_text<int>(text)) << text;
  }
  EXPECT_FALSE(files::number_of_text<std::uint64_t>("-1"));
  EXPECT_FALSE(files::number_of_text<unsigned>("4294967296"));
}

TEST(Numbers, RealNumbersAreFinite) {
  EXPECT_EQ(files::number_of_text<double>("1.5"), 1.5);
  EXPECT_EQ(files::number_of_text<double>("-2e-3"), -2e-3);
  EXPECT_EQ(files::number_of_text<double>("1e-320"), 1e-320);
  for (const char* text : {"", "nan", "inf", "-inf", "NAN", "infinity", "1e999", "0x1p3", "1,5", "1.5mm", "1e-999"}) {
    EXPECT_FALSE(files::number_of_text<double>(text)) << text;
  }
}

TEST(Numbers, Sizes) {
  const images::FrameSize size = images::size_of_text("--line", "512x96", 2048);
  EXPECT_EQ(size.columns, 512);
  EXPECT_EQ(size.rows, 96);
  for (const char* text : {"4294967808x96", "512", "512x", "x96", "512x96x", "512 x 96", "-1x96", "0x96", "512X96"}) {
    EXPECT_THROW(images::size_of_text("--line", text, 2048), UserError) << text;
  }
}

}  // namespace
}  // namespace selfproj::test
