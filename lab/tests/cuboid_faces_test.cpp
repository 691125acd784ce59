// Tests the figures of B4's faces on depth images made by hand.
#include "lab/cuboid_faces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "host/images/float_image.h"
#include "host/rig/rig.h"

namespace selfproj {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Images {
  FloatImage truth, depth, difference;

  // A row of pixels that see the plane.
  Images(const Rig& rig, int pixels) : truth(1, pixels, static_cast<float>(rig.plane_z_mm)), depth(truth) {
    difference = FloatImage(1, pixels, 0.5F);
  }
};

TEST(CuboidFaces, PixelsWithoutAKnownWidthDoNotCountForItsMean) {
  const Rig rig = load_rig("scanner");
  const Images images(rig, 5);
  const std::vector<Face> faces{Face::low, Face::low, Face::low, Face::high, Face::high};
  const std::vector<double> widths{2, std::nan(""), 6, std::nan(""), 3};
  const CuboidFigures figures = cuboid_figures(rig, faces, images.depth, images.difference, images.truth,
                                               [&](std::size_t pixel) { return widths[pixel]; });
  EXPECT_EQ(figures[Face::low].valid, 3U);
  EXPECT_DOUBLE_EQ(figures[Face::low].width, 4);
  EXPECT_DOUBLE_EQ(figures[Face::high].width, 3) << "nothing of the other face";
  EXPECT_TRUE(std::isnan(figures[Face::plane].width));
}

TEST(CuboidFaces, PixelsWithoutADepthCountForTheShareAlone) {
  const Rig rig = load_rig("scanner");
  Images images(rig, 6);
  images.depth.values = images.truth.values;
  images.depth.values[0] += 3;
  images.depth.values[1] -= 1;
  images.depth.values[2] = kNan;
  images.difference.values[3] = kNan;
  std::vector<Face> faces(6, Face::plane);
  faces[4] = Face::none;
  faces[5] = Face::letter;
  const CuboidFigures figures = cuboid_figures(rig, faces, images.depth, images.difference, images.truth,
                                               [](std::size_t /*pixel*/) { return 1.0; });
  const FaceFigures& plane = figures[Face::plane];
  EXPECT_EQ(plane.pixels, 4U);
  EXPECT_EQ(plane.valid, 2U);
  EXPECT_NEAR(plane.height, -1, 1e-4);
  EXPECT_NEAR(plane.difference, 0.5, 1e-6);
  EXPECT_NEAR(plane.rms, std::sqrt(5.0), 1e-4);
  EXPECT_NEAR(plane.most, 3, 1e-4);
  EXPECT_EQ(figures[Face::letter].pixels, 1U);
  EXPECT_NEAR(figures[Face::letter].height, 0, 1e-4);
}

// The whole image shows the plane, except for a square at the height of the low cuboid. Faces begin 3 pixels inside.
TEST(CuboidFaces, InteriorsAreThreePixelsFromEveryEdge) {
  const Rig rig = load_rig("scanner");
  FloatImage truth(rig.camera.rows, rig.camera.columns, static_cast<float>(rig.plane_z_mm));
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
  const std::vector<Face> faces = face_interiors(rig, truth);
  EXPECT_EQ(faces[at(280, 170)], Face::low);
  EXPECT_EQ(faces[at(263, 153)], Face::low);
  EXPECT_EQ(faces[at(262, 170)], Face::none);
  EXPECT_EQ(faces[at(257, 170)], Face::none);
  EXPECT_EQ(faces[at(256, 170)], Face::plane);
  EXPECT_EQ(faces[at(103, 100)], Face::none) << "3 pixels from one without a depth";
  EXPECT_EQ(faces[at(104, 100)], Face::plane);
  EXPECT_EQ(faces[at(2, 100)], Face::none) << "the image's edge";
}

}  // namespace
}  // namespace selfproj
