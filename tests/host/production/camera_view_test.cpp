// What the live page says of a raw image: where the line is, and whether the exposure is right.
#include "host/production/camera_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"
#include "selfproj/rig/rig.h"

namespace selfproj::test {
namespace {

rig::Rig rig_of_line() {
  rig::Rig rig = rig::load_rig("light-section");
  rig.measure.threshold = 40;
  rig.measure.min_lit_px = 2;
  rig.measure.max_lit_px = 20;
  return rig;
}

// A line of this peak in row 20 + column / 8 of the columns from `first` on, 5 rows wide, before grey 10.
images::Image line_image(int peak, int first = 0) {
  images::Image image{64, 96, std::vector<std::uint8_t>(std::size_t{64} * 96, 10)};
  for (int c = first; c < image.columns; ++c) {
    const int middle = 20 + c / 8;
    for (int r = middle - 2; r <= middle + 2; ++r) {
      const double falls = 1 - 0.2 * std::abs(r - middle);
      image.pixels[static_cast<std::size_t>(r * image.columns + c)] = static_cast<std::uint8_t>(peak * falls);
    }
  }
  return image;
}

production::ExposureFigures figures_of(const images::Image& image) {
  return production::exposure_figures(image.view(), production::line_in_image(image.view(), rig_of_line()),
                                      rig_of_line().measure);
}

TEST(CameraView, FindsTheLineWhereItIs) {
  const images::Image image = line_image(200, 16);
  const std::vector<float> line = production::line_in_image(image.view(), rig_of_line());
  ASSERT_EQ(line.size(), 96U);
  for (std::size_t c = 0; c < line.size(); ++c) {
    if (c < 16) {
      EXPECT_TRUE(std::isnan(line[c])) << c;
    } else {
      EXPECT_NEAR(line[c], 20 + static_cast<double>(c / 8), 1e-3) << c;
    }
  }
}

TEST(CameraView, FiguresOfTheExposureOfALine) {
  const production::ExposureFigures right = figures_of(line_image(200, 12));
  EXPECT_TRUE(right.good) << right.advice;
  EXPECT_EQ(right.bright_grey, 200);
  EXPECT_EQ(right.saturated, 0);
  EXPECT_DOUBLE_EQ(right.dark, 12.0 / 96);

  const production::ExposureFigures bright = figures_of(line_image(255));
  EXPECT_FALSE(bright.good);
  EXPECT_EQ(bright.saturated, 1);
  EXPECT_EQ(bright.advice, "too bright: 100.0 % of the line is saturated; shorten the exposure");

  const production::ExposureFigures dim = figures_of(line_image(120));
  EXPECT_FALSE(dim.good);
  EXPECT_EQ(dim.advice, "too dark: its brightest places have grey value 120; lengthen the exposure");

  const production::ExposureFigures none = figures_of(line_image(200, 60));
  EXPECT_FALSE(none.good);
  EXPECT_NE(none.advice.find("62 % of the columns have no line"), std::string::npos) << none.advice;
}

TEST(CameraView, FiguresOfTheExposureOfAScanner) {
  const auto striped = [](std::uint8_t bright) {
    images::Image image{64, 64, std::vector<std::uint8_t>(std::size_t{64} * 64, 8)};
    std::fill(image.pixels.begin(), image.pixels.begin() + 64 * 32, bright);
    return production::exposure_figures(image.view(), {}, rig_of_line().measure);
  };
  const production::ExposureFigures right = striped(180);
  EXPECT_TRUE(right.good) << right.advice;
  EXPECT_DOUBLE_EQ(right.dark, 0.5);
  EXPECT_EQ(right.bright_grey, 180);
  EXPECT_EQ(striped(255).advice, "too bright: 50.0 % of the pixels are saturated; shorten the exposure");
  EXPECT_EQ(striped(60).advice, "too dark: its brightest places have grey value 60; lengthen the exposure");
}

// Images are put together only while somebody watches, and one of which a line is lost is passed over.
TEST(CameraView, TakesWholeImagesWhileSomebodyWatches) {
  bool watched = false;
  std::vector<std::uint64_t> taken;
  production::CameraView view;
  const auto send = [&](std::uint64_t sequence, int without = -1) {
    for (int row = 0; row < 4; ++row) {
      model::PacketHeader header;
      header.kind = spec::kKindImage;
      header.sequence = sequence;
      header.rows = 4;
      header.columns = 16;
      header.first_line = static_cast<std::uint16_t>(row + 1);
      header.lines = 1;
      std::vector<std::uint8_t> payload(model::image_line_payload_bytes(16), static_cast<std::uint8_t>(row));
      model::PacketView packet;
      packet.header = header;
      packet.payload = payload;
      if (row != without && view.add(packet, watched)) {
        EXPECT_EQ(view.image().rows, 4);
        EXPECT_EQ(view.image().pixels[2 * view.image().stride + 5], 2);
        taken.push_back(view.header().sequence);
      }
    }
  };
  send(1);
  EXPECT_TRUE(taken.empty());
  watched = true;
  send(2, 1);
  send(3);
  EXPECT_EQ(taken, std::vector<std::uint64_t>{3});
  send(4);  // too soon for the next
  EXPECT_EQ(taken.size(), 1U);
}

}  // namespace
}  // namespace selfproj::test
