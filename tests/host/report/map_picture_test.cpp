#include "host/report/map_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"

namespace selfproj::test {
namespace {

constexpr float kGap = std::numeric_limits<float>::quiet_NaN();

cv::Mat decode(const std::string& png) {
  return cv::imdecode(std::vector<std::uint8_t>(png.begin(), png.end()), cv::IMREAD_COLOR);
}

void expect_colour(const cv::Vec3b& bgr, report::Colour colour) {
  EXPECT_EQ(int{bgr[2]}, int{colour.red});
  EXPECT_EQ(int{bgr[1]}, int{colour.green});
  EXPECT_EQ(int{bgr[0]}, int{colour.blue});
}

TEST(MapPicture, ValuesHaveTheirColoursAndGapsAreGrey) {
  images::FloatImage map(2, 3);
  map.values = {-1, 0, 1, -7, kGap, 7};
  const cv::Mat picture = decode(report::map_png(map, {report::ColourMap::diverging, -1, 1}, {30, 20}));
  ASSERT_EQ(picture.cols, 30);
  ASSERT_EQ(picture.rows, 20);
  expect_colour(picture.at<cv::Vec3b>(5, 5), report::colour_at(report::ColourMap::diverging, 0));
  expect_colour(picture.at<cv::Vec3b>(5, 25), report::colour_at(report::ColourMap::diverging, 1));
  expect_colour(picture.at<cv::Vec3b>(15, 5), report::colour_at(report::ColourMap::diverging, 0));  // beyond the end
  expect_colour(picture.at<cv::Vec3b>(15, 25), report::colour_at(report::ColourMap::diverging, 1));
  for (int r = 10; r < 20; ++r) {
    for (int c = 10; c < 20; ++c) {
      const auto& gap = picture.at<cv::Vec3b>(r, c);
      EXPECT_TRUE(gap == cv::Vec3b(178, 178, 178) || gap == cv::Vec3b(132, 132, 132));
    }
  }
}

// No value looks like a gap: the maps never come near its greys.
TEST(MapPicture, NoColourIsTheGreyOfGaps) {
  for (const report::ColourMap map : {report::ColourMap::diverging, report::ColourMap::sequential}) {
    for (int i = 0; i <= 1000; ++i) {
      const report::Colour colour = report::colour_at(map, i / 1000.0);
      for (const int grey : {132, 178}) {
        EXPECT_GT(std::abs(colour.red - grey) + std::abs(colour.green - grey) + std::abs(colour.blue - grey), 40);
      }
    }
  }
}

TEST(MapPicture, DivergingIsLightInTheMiddleAndSaysTheSign) {
  const report::Colour middle = report::colour_at(report::ColourMap::diverging, 0.5);
  EXPECT_GT(std::min({middle.red, middle.green, middle.blue}), 240);
  EXPECT_GT(report::colour_at(report::ColourMap::diverging, 0.8).red,
            report::colour_at(report::ColourMap::diverging, 0.8).blue);
  EXPECT_LT(report::colour_at(report::ColourMap::diverging, 0.2).red,
            report::colour_at(report::ColourMap::diverging, 0.2).blue);
}

TEST(MapPicture, APixelIsTheMeanOfWhatFallsIntoIt) {
  images::FloatImage map(4, 4, 0.5F);
  map.row(0)[0] = -0.5F;
  map.row(1)[1] = kGap;  // mean of the three others: 1/6
  const cv::Mat picture = decode(report::map_png(map, {report::ColourMap::sequential, 0, 1}, {2, 2}));
  const auto near = [](const cv::Vec3b& bgr, report::Colour colour) {
    return std::abs(bgr[2] - colour.red) <= 2 && std::abs(bgr[1] - colour.green) <= 2;
  };
  EXPECT_TRUE(near(picture.at<cv::Vec3b>(0, 0), report::colour_at(report::ColourMap::sequential, 1.0 / 6)));
  EXPECT_TRUE(near(picture.at<cv::Vec3b>(1, 1), report::colour_at(report::ColourMap::sequential, 0.5)));
}

TEST(MapPicture, BothDirectionsHaveOneScale) {
  const report::MapSize size = report::map_size(1400, 512, {0.1, 0.2334}, 1200);
  EXPECT_EQ(size.height, 1200);
  EXPECT_NEAR(static_cast<double>(size.width) / size.height, 512 * 0.2334 / 140, 0.001);
  EXPECT_EQ(report::map_size(3, 512, {0.1, 0.2334}, 1000).height, 200);  // a fifth at least
  EXPECT_EQ(report::map_size(3, 512, {0, 0.2334}, 1000).width, 1000);
}

TEST(MapPicture, ScalesReachOverWhatIsThere) {
  images::FloatImage map(100, 100, kGap);
  EXPECT_DOUBLE_EQ(report::difference_scale(map).high, 0.1);
  EXPECT_DOUBLE_EQ(report::height_scale(map).low, 0);
  for (int i = 0; i < 10000; ++i) {
    map.values[static_cast<std::size_t>(i)] = i % 100 < 3 ? -1.02F : 0.01F;
  }
  for (int i = 0; i < 1000; ++i) {  // rows 0..9 are half empty, and far off: not the part
    map.values[static_cast<std::size_t>(i)] = i % 2 == 0 ? kGap : -20;
  }
  EXPECT_EQ(report::full_rows(map).size(), 90U);
  EXPECT_EQ(report::full_rows(map).front(), 10);
  map.values[5000] = 40;  // one wild point does not set the scale
  EXPECT_DOUBLE_EQ(report::difference_scale(map).high, 1.5);
  EXPECT_DOUBLE_EQ(report::difference_scale(map).low, -1.5);
  EXPECT_NEAR(report::height_scale(map).low, -20, 0.01);
  EXPECT_LT(report::height_scale(map).high, 1);
  EXPECT_GE(report::height_scale(map).high - report::height_scale(map).low, 1);
}

// The labelled picture holds the map, a scale bar for each direction, of the right length, and a colour bar.
TEST(MapPicture, LabelsAreToScale) {
  const images::FloatImage map(1400, 512, 0.0F);
  const report::MapPitch pitch{0.1, 0.2334};
  const cv::Mat picture =
      decode(report::labelled_map_png(map, {report::ColourMap::diverging, -1, 1}, pitch, "difference"));
  const report::MapSize size = report::map_size(1400, 512, pitch, 1200);
  // The longest run of ink in a row below the map and in a column left of it.
  const auto longest_run = [&picture](bool along_row, int from, int to) {
    int longest = 0;
    for (int i = from; i < to; ++i) {
      int run = 0;
      for (int j = 0; j < (along_row ? picture.cols : picture.rows); ++j) {
        const auto pixel = along_row ? picture.at<cv::Vec3b>(i, j) : picture.at<cv::Vec3b>(j, i);
        run = pixel == cv::Vec3b(40, 40, 40) ? run + 1 : 0;
        longest = std::max(longest, run);
      }
    }
    return longest;
  };
  EXPECT_NEAR(longest_run(true, picture.rows - 60, picture.rows), 20 / (512 * 0.2334) * size.width, 1.5);
  EXPECT_NEAR(longest_run(false, 0, 109), 20 / 140.0 * size.height, 1.5);
  int blue = 0;
  int red = 0;
  for (int r = 0; r < picture.rows; ++r) {
    const auto pixel = picture.at<cv::Vec3b>(r, picture.cols - 150 + 30);
    blue += pixel[0] > pixel[2] + 50 ? 1 : 0;
    red += pixel[2] > pixel[0] + 50 ? 1 : 0;
  }
  EXPECT_GT(blue, 200);
  EXPECT_GT(red, 200);
}

TEST(MapPicture, AnEmptyMapIsAnError) {
  EXPECT_THROW(report::map_png(images::FloatImage(), {}, {10, 10}), UserError);
  EXPECT_THROW(report::labelled_map_png(images::FloatImage(), {}, {}, ""), UserError);
}

}  // namespace
}  // namespace selfproj::test
