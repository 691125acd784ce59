// What is rendered faster because a scene says that it is smooth and plain, or because sights are kept, is the same to
// the last bit as without; and what the scenes say of themselves is true.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/images/float_image.h"
#include "host/light_section/pattern.h"
#include "host/rig/rig.h"
#include "sim/scene/chessboard.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/real_rig.h"
#include "sim/scene/sight_table.h"
#include "sim/scene/targets.h"

namespace selfproj {
namespace {

// A scene that says nothing of its smoothness.
class Silent final : public Scene {
 public:
  explicit Silent(const Scene& scene) : scene_(scene) {}
  [[nodiscard]] int frames() const override { return scene_.frames(); }
  [[nodiscard]] double height(double x, double y, double t) const override { return scene_.height(x, y, t); }
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override {
    return scene_.range(box, t0, t1);
  }
  [[nodiscard]] double albedo(double x, double y, double t) const override { return scene_.albedo(x, y, t); }
  [[nodiscard]] bool even_albedo() const override { return scene_.even_albedo(); }
  [[nodiscard]] bool is_plain(const Box& /*box*/) const override { return false; }
  [[nodiscard]] double speed() const override { return scene_.speed(); }

 private:
  const Scene& scene_;
};

RealRig low_image(std::uint64_t seed) {
  Rig rig = load_rig("light-section");
  rig.camera.rows = 40;
  return hidden_rig(rig, seed);
}

std::vector<float> image_of(const RealRig& real, const Scene& scene) {
  RenderOptions exact;
  exact.shot_noise = exact.read_noise = exact.quantization = false;
  FloatImage pattern(real.rig.projector.lines, real.rig.projector.columns);
  for (std::size_t i = 0; i < pattern.values.size(); ++i) {
    pattern.values[i] = i / 1024 % 3 == 0 ? 1.0F : 0.25F;
  }
  std::vector<float> pixels(real.rig.camera.pixels());
  PatternRenderer(real, scene, exact).render(0, throw_light(real.rig, pattern, exact), std::span(pixels));
  return pixels;
}

constexpr ChessboardShape kChessboardShape{37, 3, 2.2};

ChessboardScene board(const RealRig& real, double bend_mm, double lean) {
  ChessboardPlace place;
  place.middle = middle_of_view(real, real.rig.plane_z_mm - 20);
  place.below = {std::cos(lean), 0, std::sin(lean)};
  return {real.rig, kChessboardShape, place, drawn_flaws(1e-4, bend_mm, 7)};
}

TEST(SmoothScenes, ImagesAreTheSameToTheLastBit) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const RealRig real = low_image(seed);
    const FlatPlate plate(20, {0.005, 0.01}, seed);
    EXPECT_EQ(image_of(real, plate), image_of(real, Silent(plate)));
    const FlatPlate wavy(20, {0.005, 3}, seed);  // more than may be left out
    EXPECT_EQ(image_of(real, wavy), image_of(real, Silent(wavy)));
    for (const double bend : {0.0, 0.01, 0.5}) {
      const ChessboardScene scene = board(real, bend, bend);
      EXPECT_EQ(image_of(real, scene), image_of(real, Silent(scene))) << bend;
    }
  }
}

// A plain rectangle has one albedo, and the surface bends no more over one than is said.
TEST(SmoothScenes, ChessboardsTellTheTruth) {
  const RealRig real = low_image(1);
  const ChessboardScene scene = board(real, 0.4, 0.3);
  const Point3 middle = middle_of_view(real, real.rig.plane_z_mm - 20);
  int plain = 0;
  int smooth = 0;
  constexpr double kSide = 0.6;  // mm
  for (double x = middle.x - 8; x < middle.x + 8; x += 0.31) {
    for (double y = middle.y - 48; y < middle.y + 48; y += 0.87) {
      const Box box{x, x + kSide, y, y + kSide};
      double low = 1;
      double high = 0;
      for (int i = 0; i <= 6; ++i) {
        for (int j = 0; j <= 6; ++j) {
          const double albedo = scene.albedo(x + kSide * i / 6, y + kSide * j / 6, 0);
          low = std::min(low, albedo);
          high = std::max(high, albedo);
        }
      }
      const bool is_plain = scene.is_plain(box);
      EXPECT_TRUE(!is_plain || high - low < 1e-12) << x << ", " << y;
      plain += is_plain ? 1 : 0;
      const Smoothness bounds = scene.smoothness(box);
      const auto height = [&](double share) { return scene.height(x + kSide * share, y + kSide * share, 0); };
      const double step = kSide * std::sqrt(2) / 2;
      EXPECT_LE(std::abs(height(1) - height(0)), bounds.slope * 2 * step);
      EXPECT_LE(std::abs(height(0) - 2 * height(0.5) + height(1)), bounds.curvature * step * step + 1e-12);
      smooth += bounds.curvature < 1 ? 1 : 0;
    }
  }
  EXPECT_GT(plain, 2000);
  EXPECT_LT(plain, 5000);
  EXPECT_GT(smooth, 3000);
}

TEST(SmoothScenes, PlatesTellTheTruth) {
  const FlatPlate plate(20, {0.005, 0.5}, 3);
  const Smoothness bounds = plate.smoothness({0, 1, 0, 1});
  constexpr double kStep = 2;  // mm
  for (double x = -60; x < 60; x += 1.7) {
    for (double y = -60; y < 60; y += 1.7) {
      const auto height = [&](int i) { return plate.height(x + kStep * i, y, 0); };
      EXPECT_LE(std::abs(height(1) - height(0)), bounds.slope * kStep);
      EXPECT_LE(std::abs(height(0) - 2 * height(1) + height(2)), bounds.curvature * kStep * kStep);
      EXPECT_LE(std::abs(height(3) - 3 * height(2) + 3 * height(1) - height(0)), bounds.change * kStep * kStep * kStep);
    }
  }
}

TEST(SightTable, IsTheCamera) {
  const RealRig real = low_image(4);
  const auto table = SightTable::of(real.camera, real.rig.camera);
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(SightTable::of(real.camera, real.rig.camera), table) << "shared";
  EXPECT_NE(SightTable::of(low_image(5).camera, real.rig.camera), table);
  EXPECT_EQ(SightTable::of(Pinhole::of_camera(real.rig.camera), real.rig.camera), nullptr);
  for (const double row : {-30.0, -8.375, -7.875, -0.125, 0.0, 3.125, 3.2, 39.5, 40.875, 47.375, 47.875, 90.0}) {
    for (const double column : {-9.0, -7.875, 0.375, 17.0, 255.625, 511.875, 519.375, 519.5, 700.0}) {
      const Point3 found = table->sight({row, column});
      const Point3 wanted = real.camera.sight({row, column});
      EXPECT_EQ(found.x, wanted.x) << row << ", " << column;
      EXPECT_EQ(found.y, wanted.y) << row << ", " << column;
      EXPECT_EQ(found.z, wanted.z) << row << ", " << column;
    }
  }
}

}  // namespace
}  // namespace selfproj
