#include "lab/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "lab/cuboids.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

TEST(Evaluation, StepsAreLeftOutToBothSides) {
  images::FloatImage truth(1, 12, 5.0F);
  for (int c = 6; c < 12; ++c) {
    truth.row(0)[c] = 6.0F;
  }
  EXPECT_EQ(lab::near_steps(truth, 0.5, 3, 0), (lab::Mask{0, 0, 0, 1, 1, 1, 1, 1, 1, 0, 0, 0}));
  EXPECT_EQ(lab::near_steps(truth, 0.5, 1, 0), (lab::Mask{0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0}));
  EXPECT_EQ(lab::near_steps(truth, 1.5, 3, 3), lab::Mask(12, 0));
  truth.row(0)[1] = kNone;  // a gap makes two steps, and is itself left out
  EXPECT_EQ(lab::near_steps(truth, 1.5, 2, 0), (lab::Mask{1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(Evaluation, StepsFromFrameToFrameAreLeftOutToo) {
  images::FloatImage truth(6, 2, 0.0F);
  for (int r = 3; r < 6; ++r) {
    truth.row(r)[1] = 30;
  }
  EXPECT_EQ(lab::near_steps(truth, 0.5, 0, 2), (lab::Mask{0, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 0}));
}

TEST(Evaluation, AroundStepsIsARectangle) {
  images::FloatImage truth(6, 8, 0.0F);
  truth.row(2)[3] = 1;  // it and its four neighbours lie beside a step
  EXPECT_EQ(lab::around_steps(truth, 0.5, 3, 2), (lab::Mask{0, 1, 1, 1, 1, 1, 0, 0,  //
                                                            1, 1, 1, 1, 1, 1, 1, 0,  //
                                                            1, 1, 1, 1, 1, 1, 1, 0,  //
                                                            1, 1, 1, 1, 1, 1, 1, 0,  //
                                                            0, 1, 1, 1, 1, 1, 0, 0,  //
                                                            0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(lab::around_steps(truth, 1.5, 3, 2), lab::Mask(48, 0));
}

// Compares with the definition, entry by entry, on random maps.
TEST(Evaluation, NearStepsIsItsDefinition) {
  for (const std::uint64_t seed : seeds(50)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    images::FloatImage truth(random.between(1, 12), random.between(1, 12));
    for (float& value : truth.values) {
      value = random.chance(10) ? kNone : static_cast<float>(random.chance(90) ? 0 : random.between(0, 3));
    }
    const int columns = random.between(0, 4);
    const int rows = random.between(0, 4);
    const lab::Mask mask = lab::near_steps(truth, 1, columns, rows);
    const auto step = [&truth](int r0, int c0, int r1, int c1) {
      const float a = truth.row(r0)[c0];
      const float b = truth.row(r1)[c1];
      return std::isnan(a) || std::isnan(b) ? std::isnan(a) != std::isnan(b) : std::abs(a - b) > 1;
    };
    for (int r = 0; r < truth.rows; ++r) {
      for (int c = 0; c < truth.columns; ++c) {
        bool near = std::isnan(truth.row(r)[c]);
        for (int k = 0; k + 1 < truth.columns; ++k) {  // the step is at k + 1/2
          near = near || (step(r, k, r, k + 1) && std::abs(c - (k + 0.5)) < columns);
        }
        for (int k = 0; k + 1 < truth.rows; ++k) {
          near = near || (step(k, c, k + 1, c) && std::abs(r - (k + 0.5)) < rows);
        }
        EXPECT_EQ(mask[static_cast<std::size_t>(r * truth.columns + c)], near ? 1 : 0) << r << ' ' << c;
      }
    }
  }
}

// Heights that differ by known amounts from a slope that moves with the frames.
TEST(Evaluation, HeightErrorsAreThoseThatWerePutIn) {
  const auto truth = [](int frame, double x, double y) { return 10 + 0.5 * x + 0.25 * y - 0.125 * frame; };
  images::FloatImage height(3, 4);
  images::FloatImage x(3, 4);
  images::FloatImage y(3, 4);
  const std::vector<float> errors = {0.03F, -0.04F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) {
      x.row(r)[c] = 0.5F * static_cast<float>(r);
      y.row(r)[c] = 0.25F * static_cast<float>(c);
      height.row(r)[c] = static_cast<float>(truth(r, 0.5 * r, 0.25 * c)) + errors[static_cast<std::size_t>(4 * r + c)];
    }
  }
  height.row(2)[0] = kNone;  // missing
  height.row(2)[1] = 1000;   // near a step
  height.row(2)[2] = kNone;  // near a step, and no point
  lab::Mask left_out(12, 0);
  left_out[9] = left_out[10] = 1;
  const lab::HeightErrors found = lab::height_errors(height, x, y, left_out, truth);
  EXPECT_EQ(found.points, 9);
  EXPECT_EQ(found.left_out, 1);
  EXPECT_EQ(found.missing, 1);
  EXPECT_DOUBLE_EQ(found.missing_share(), 0.1);
  EXPECT_NEAR(found.max, 0.04, 1e-6);
  EXPECT_NEAR(found.rms, std::sqrt((0.0009 + 0.0016) / 9), 1e-6);
  EXPECT_NEAR(found.mean, -0.01 / 9, 1e-6);
  EXPECT_THROW(lab::height_errors(height, x, images::FloatImage(3, 5), left_out, truth), std::invalid_argument);
  EXPECT_EQ(lab::height_errors(height, x, y, lab::Mask(12, 1), truth).points, 0);
  EXPECT_EQ(lab::HeightErrors().missing_share(), 0);
}

TEST(Evaluation, DepthIsThatOfTheMiddleNotOfTheEdge) {
  images::FloatImage difference(10, 10, 0.01F);
  lab::Mask mask(100, 1);
  for (std::size_t i = 0; i < 30; ++i) {
    mask[i] = 2;
    difference.values[i] = i < 8 ? -0.4F : -0.98F;  // eight points on the edge
  }
  difference.values[50] = 7;  // one wild point
  difference.values[29] = kNone;
  EXPECT_NEAR(lab::depth_of(difference, mask, 2, 1), 0.99, 1e-6);
  const lab::RegionValues values = lab::values_in(difference, mask, 2);
  EXPECT_EQ(values.count, 29);
  EXPECT_NEAR(values.mean, (8 * -0.4 + 21 * -0.98) / 29, 1e-6);
  EXPECT_TRUE(std::isnan(lab::depth_of(difference, mask, 3, 1)));
  EXPECT_THROW(lab::values_in(difference, lab::Mask(99), 1), std::invalid_argument);
}

TEST(Evaluation, RangeOfCentroids) {
  images::FloatImage centroid(4, 3);
  centroid.values = {48, 49, 50, 48, kNone, 48.5F, 10, 90, 48, kNone, kNone, 48};
  lab::Mask left_out(12, 0);
  left_out[6] = 1;
  const lab::CentroidRange all = lab::centroid_range(centroid, left_out, 0, 4);
  EXPECT_DOUBLE_EQ(all.greatest, 42);
  EXPECT_DOUBLE_EQ(all.median, 2);
  EXPECT_DOUBLE_EQ(lab::centroid_range(centroid, left_out, 1, 1).greatest, 0.5);
  EXPECT_DOUBLE_EQ(lab::centroid_range(centroid, left_out, 3, 5).greatest, 0);
}

// Tests the figures of B4's faces on depth images made by hand.

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Images {
  images::FloatImage truth, depth, difference;

  // A row of pixels that see the plane.
  Images(const rig::Rig& rig, int pixels) : truth(1, pixels, static_cast<float>(rig.plane_z_mm)), depth(truth) {
    difference = images::FloatImage(1, pixels, 0.5F);
  }
};

TEST(CuboidFaces, PixelsWithoutAKnownWidthDoNotCountForItsMean) {
  const rig::Rig rig = rig::load_rig("scanner");
  const Images images(rig, 5);
  const std::vector<lab::Face> faces{lab::Face::low, lab::Face::low, lab::Face::low, lab::Face::high, lab::Face::high};
  const std::vector<double> widths{2, std::nan(""), 6, std::nan(""), 3};
  const lab::CuboidFigures figures = lab::cuboid_figures(rig, faces, images.depth, images.difference, images.truth,
                                                         [&](std::size_t pixel) { return widths[pixel]; });
  EXPECT_EQ(figures[lab::Face::low].valid, 3U);
  EXPECT_DOUBLE_EQ(figures[lab::Face::low].width, 4);
  EXPECT_DOUBLE_EQ(figures[lab::Face::high].width, 3) << "nothing of the other face";
  EXPECT_TRUE(std::isnan(figures[lab::Face::plane].width));
}

TEST(CuboidFaces, PixelsWithoutADepthCountForTheShareAlone) {
  const rig::Rig rig = rig::load_rig("scanner");
  Images images(rig, 6);
  images.depth.values = images.truth.values;
  images.depth.values[0] += 3;
  images.depth.values[1] -= 1;
  images.depth.values[2] = kNan;
  images.difference.values[3] = kNan;
  std::vector<lab::Face> faces(6, lab::Face::plane);
  faces[4] = lab::Face::none;
  faces[5] = lab::Face::letter;
  const lab::CuboidFigures figures = lab::cuboid_figures(rig, faces, images.depth, images.difference, images.truth,
                                                         [](std::size_t /*pixel*/) { return 1.0; });
  const lab::FaceFigures& plane = figures[lab::Face::plane];
  EXPECT_EQ(plane.pixels, 4U);
  EXPECT_EQ(plane.valid, 2U);
  EXPECT_NEAR(plane.height, -1, 1e-4);
  EXPECT_NEAR(plane.difference, 0.5, 1e-6);
  EXPECT_NEAR(plane.rms, std::sqrt(5.0), 1e-4);
  EXPECT_NEAR(plane.most, 3, 1e-4);
  EXPECT_EQ(figures[lab::Face::letter].pixels, 1U);
  EXPECT_NEAR(figures[lab::Face::letter].height, 0, 1e-4);
}

// The whole image shows the plane, except for a square at the height of the low cuboid. Faces begin 3 pixels inside.
TEST(CuboidFaces, InteriorsAreThreePixelsFromEveryEdge) {
  const rig::Rig rig = rig::load_rig("scanner");
  images::FloatImage truth(rig.camera.rows, rig.camera.columns, static_cast<float>(rig.plane_z_mm));
  const auto at = [&](int row, int column) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(rig.camera.columns) +
           static_cast<std::size_t>(column);
  };
  for (int r = 260; r < 300; ++r) {
    for (int c = 150; c < 190; ++c) {
      truth.values[at(r, c)] = static_cast<float>(rig.plane_z_mm) - 25;
    }
  }
  truth.values[at(100, 100)] = kNan;
  const std::vector<lab::Face> faces = lab::face_interiors(rig, truth);
  EXPECT_EQ(faces[at(280, 170)], lab::Face::low);
  EXPECT_EQ(faces[at(263, 153)], lab::Face::low);
  EXPECT_EQ(faces[at(262, 170)], lab::Face::none);
  EXPECT_EQ(faces[at(257, 170)], lab::Face::none);
  EXPECT_EQ(faces[at(256, 170)], lab::Face::plane);
  EXPECT_EQ(faces[at(103, 100)], lab::Face::none) << "3 pixels from one without a depth";
  EXPECT_EQ(faces[at(104, 100)], lab::Face::plane);
  EXPECT_EQ(faces[at(2, 100)], lab::Face::none) << "the image's edge";
}

}  // namespace
}  // namespace selfproj::test
