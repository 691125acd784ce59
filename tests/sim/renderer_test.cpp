// Compares rendered images with optics.
#include "sim/scene/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/light_section/pattern.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/optics.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "tests/sim/level_scene.h"

namespace selfproj::test {
namespace {

// ------------------------------------------------------------------ where the line is seen

// (3.4) solved for tan α: where a straight line is seen on level surfaces.
TEST(Renderer, StraightLineIsSeenWhere34Says) {
  const rig::Rig rig = rig::load_rig("light-section");
  for (const double height : {0.0, 5.0, 21.0, 39.0}) {
    LevelScene scene;
    scene.floor = height;
    const double z = rig.plane_z_mm - height;
    for (const double offset : {-6.0, -0.31, 0.0, 4.7}) {
      const double line = line_at(rig, offset, z);
      const sim::LineRenderer renderer(rig, scene, light_section::draw_straight_line(rig, line), ideal());
      const Frame frame(rig, renderer, 0);
      const double t = tan_theta(rig, line);
      const double expected = row_of(rig, (rig.projector.x_mm + rig.projector.z_mm * t) / z - t);
      for (const int column : {14, 100, 256, 497}) {  // at 39 mm the projector's columns end beside these
        EXPECT_NEAR(frame.centroid(column, rig.imaging.ambient), expected, 0.01) << height << ' ' << offset;
      }
    }
  }
}

// A line drawn by (3.9) for the mountain is straight in the middle of the image, with blur, motion and all.
TEST(Renderer, LineOf39FallsOnTheMiddleOfTheImage) {
  const rig::Rig rig = rig::load_rig("light-section");
  const rig::RigProjector& p = rig.projector;
  const auto scene = sim::make_scene("mountain", rig);
  const int middle = 700;
  // For steps of y along the reference: the projector column, and the line by (3.9), corrected.
  std::vector<double> columns;
  std::vector<double> lines;
  for (double y = -65; y <= 65; y += 0.05) {
    const double z = rig.plane_z_mm - scene->height(0, y, middle / rig.camera.frame_rate_hz);
    const double tan_0 = std::tan(p.tilt_rad);
    const double xp = p.focal_length_mm * (p.x_mm - (z - p.z_mm) * tan_0) / ((z - p.z_mm) + p.x_mm * tan_0);
    const double yp = y / (z - p.z_mm) * (p.focal_length_mm * std::cos(p.tilt_rad) - xp * std::sin(p.tilt_rad));
    lines.push_back((xp - p.center_xp_mm) / p.line_pitch_mm + (p.lines - 1) / 2.0);
    columns.push_back((yp - p.center_yp_mm) / p.column_pitch_mm + (p.columns - 1) / 2.0);
  }
  images::FloatImage pattern(p.lines, p.columns);
  for (int c = 0; c < p.columns; ++c) {
    const auto next = std::upper_bound(columns.begin(), columns.end(), c);
    if (next == columns.begin() || next == columns.end()) {
      continue;
    }
    const auto i = static_cast<std::size_t>(next - columns.begin());
    const double f = (c - columns[i - 1]) / (columns[i] - columns[i - 1]);
    const images::FloatImage straight = light_section::draw_straight_line(rig, (1 - f) * lines[i - 1] + f * lines[i]);
    for (int r = 0; r < p.lines; ++r) {
      pattern.row(r)[c] = straight.row(r)[0];
    }
  }
  sim::RenderOptions options;
  options.shot_noise = options.read_noise = options.quantization = false;
  const sim::LineRenderer renderer(rig, *scene, pattern, options);
  const Frame frame(rig, renderer, middle);
  std::vector<float> truth(512);
  renderer.truth(middle, truth);
  for (int column = 4; column < 508; ++column) {
    EXPECT_NEAR(frame.centroid(column, rig.imaging.ambient), 47.5, 0.03) << column;
    const double h = static_cast<double>(truth[static_cast<std::size_t>(column)]);
    const double y = (rig.plane_z_mm - h) * (column - 255.5) * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
    EXPECT_NEAR(h, renderer.true_height(middle, 0, y), 0.003) << column;
  }
}

// Centroid and (3.4) against the truth, on a smooth slope without disturbances.
TEST(Renderer, TriangulatedHeightsAreTheTrueOnes) {
  const rig::Rig rig = rig::load_rig("light-section");
  const auto scene = sim::make_scene("mountain", rig);
  const double line = line_at(rig, 0, rig.plane_z_mm - 12);
  const sim::LineRenderer renderer(rig, *scene, light_section::draw_straight_line(rig, line), ideal());
  const int number = 700;
  const Frame frame(rig, renderer, number);
  std::vector<float> truth(512);
  renderer.truth(number, truth);
  const double t = tan_theta(rig, line);
  for (int column = 0; column < 512; ++column) {
    const double tan_alpha =
        (frame.centroid(column, rig.imaging.ambient) - 47.5) * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
    const double z = (rig.projector.x_mm + rig.projector.z_mm * t) / (tan_alpha + t);
    const double y = z * (column - 255.5) * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
    const double measured = rig.plane_z_mm - z;
    EXPECT_NEAR(measured, static_cast<double>(truth[static_cast<std::size_t>(column)]), 0.01) << column;
    EXPECT_NEAR(measured, renderer.true_height(number, z * tan_alpha, y), 0.01) << column;
  }
}

// ------------------------------------------------------------------ light

TEST(Renderer, GreyValuesAreThoseOfTheRig) {
  const rig::Rig rig = rig::load_rig("light-section");
  LevelScene scene;
  const images::FloatImage white(512, 512, 1);
  sim::LineRenderer renderer(rig, scene, white, ideal());
  // seen at the middle: (0, 0, plane), light from (352, 0, 579)
  const double cosine = 588 / std::hypot(352, 588);
  const Frame lit(rig, renderer, 0);
  EXPECT_NEAR((lit.at(47, 255) + lit.at(48, 256)) / 2, 8 + 192 * cosine, 0.01);
  renderer.set_pattern(images::FloatImage(512, 512));
  EXPECT_NEAR(Frame(rig, renderer, 0).at(47, 255), 8, 1e-5);
  scene.reflectance = [](double) { return 0.25; };
  EXPECT_NEAR(Frame(rig, renderer, 0).at(47, 255), 2 + 0.25 * 6, 1e-5);
  renderer.set_pattern(white);
  EXPECT_NEAR(Frame(rig, renderer, 0).at(47, 255), 2 + 0.25 * (6 + 192 * cosine), 0.2);
  // twice as far from the projector: a quarter of the light
  LevelScene lower;
  rig::Rig raised = rig;
  raised.imaging.ambient = raised.imaging.dark = 0;
  lower.floor = -100;
  sim::RenderOptions falling = ideal();
  falling.falloff = true;
  const double with = Frame(raised, sim::LineRenderer(raised, lower, white, falling), 0).at(47, 255);
  const double without = Frame(raised, sim::LineRenderer(raised, lower, white, ideal()), 0).at(47, 255);
  EXPECT_NEAR(with / without, (352.0 * 352 + 588.0 * 588) / (352.0 * 352 + 688.0 * 688), 1e-3);
}

TEST(Renderer, BlurKeepsTheLightOfALineAndItsPlace) {
  const rig::Rig rig = rig::load_rig("light-section");
  const LevelScene scene;
  const images::FloatImage line = light_section::draw_straight_line(rig, line_at(rig, 0.1, rig.plane_z_mm));
  const Frame sharp(rig, sim::LineRenderer(rig, scene, line, ideal()), 0);
  const auto variance = [&](const Frame& frame) {
    const double middle = frame.centroid(200, 8);
    double sum = 0;
    for (int r = 0; r < frame.rows; ++r) {
      sum += (frame.at(r, 200) - 8) * (r - middle) * (r - middle);
    }
    return sum / frame.sum(200, 8);
  };
  for (const bool camera : {false, true}) {
    for (const bool projector : {false, true}) {
      sim::RenderOptions options = ideal();
      options.camera_blur = camera;
      options.projector_blur = projector;
      const Frame frame(rig, sim::LineRenderer(rig, scene, line, options), 0);
      for (const int column : {1, 200, 510}) {
        EXPECT_NEAR(frame.sum(column, 8) / sharp.sum(column, 8), 1, 2e-4);
        EXPECT_NEAR(frame.centroid(column, 8), sharp.centroid(column, 8), 2e-3);
      }
      // a projector line is 1.03 camera rows here
      const double line_rows = 5 * sharp.sum(200, 8) / (192 * 0.858) / 25;
      const double added = (camera ? 0.49 : 0) + (projector ? 0.49 * line_rows * line_rows : 0);
      EXPECT_NEAR(variance(frame) - variance(sharp), added, 0.02);
    }
  }
}

// A cliff moves along x through the line, by 1.2 mm, during the exposure of the frame. The rows of the upper level are
// lit for the share of the exposure in which the cliff has passed them.
TEST(Renderer, MotionBlurAveragesOverTheExposure) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.frame_rate_hz = 1e4;
  const double speed = 1e5;
  const double way = speed * rig.camera.exposure_s;  // 9 mm
  LevelScene scene;
  const double height = 2;
  scene.top = height;
  scene.x0 = -1000;
  scene.x1 = 0;
  scene.fastest = speed;
  for (const double place : {-3.0, 0.5, 2.0}) {
    const images::FloatImage line =
        light_section::draw_straight_line(rig, line_at(rig, place, rig.plane_z_mm - height));
    sim::RenderOptions options = ideal();
    const double lit = Frame(rig, sim::LineRenderer(rig, scene, line, options), 1).sum(256, 8);
    options.motion_blur = true;
    const Frame frame(rig, sim::LineRenderer(rig, scene, line, options), 0);
    const auto row = static_cast<int>(std::lround(row_of(rig, place / (rig.plane_z_mm - height))));
    const Frame still(rig, sim::LineRenderer(rig, scene, line, ideal()), 1);
    const double share = 0.5 - place / way;
    EXPECT_NEAR((frame.at(row, 256) - 8) / (still.at(row, 256) - 8), share, 0.03) << place;
    EXPECT_GT(lit, 0);
    // Without motion blur the line is where the middle of the exposure puts it.
    const Frame middle(rig, sim::LineRenderer(rig, scene, line, ideal()), 0);
    EXPECT_NEAR((middle.at(row, 256) - 8) / (still.at(row, 256) - 8), place < 0 ? 1 : 0, 1e-6) << place;
  }
}

// ------------------------------------------------------------------ shadow and occlusion

// A wall 5 mm high from x = 2 to 6 under full light from +x. Its shadow on the plane ends where the ray over its far
// edge lands.
TEST(Renderer, WallThrowsItsShadow) {
  const rig::Rig rig = rig::load_rig("light-section");
  LevelScene scene;
  scene.top = 5;
  scene.x0 = 2;
  scene.x1 = 6;
  const sim::LineRenderer renderer(rig, scene, images::FloatImage(512, 512, 1), ideal());
  const Frame frame(rig, renderer, 0);
  const double end = 2 - 350.0 / (588 - 5) * 5;
  const double first = row_of(rig, end / 1167);
  const double last = row_of(rig, 2.0 / 1162);  // from there on the wall's top hides what is behind
  const auto share_lit = [&](int row) { return (frame.at(row, 256) - 8) / (frame.at(20, 256) - 8); };
  for (int row = 0; row < 96; ++row) {
    if (row < first - 1) {
      EXPECT_NEAR(share_lit(row), 1, 0.03) << row;
    } else if (row > first + 1 && row < last - 1) {
      EXPECT_NEAR(share_lit(row), 0, 1e-6) << row;
    } else if (row > last + 1 && row < row_of(rig, 6.0 / 1162) - 1) {
      EXPECT_NEAR(share_lit(row), 1, 0.03) << row;
    }
  }
  double dark = 0;
  for (int row = 30; row < 70; ++row) {
    dark += 1 - share_lit(row) / (row < last ? share_lit(39) : share_lit(62));
  }
  EXPECT_NEAR(dark, last - first, 0.3);
}

// The top of a tower hides the plane behind its edge: the border between the reflectances is seen at the edge.
TEST(Renderer, TowerHidesWhatIsBehind) {
  const rig::Rig rig = rig::load_rig("light-section");
  LevelScene scene;
  scene.top = 100;
  scene.x0 = -3;
  scene.x1 = 6;
  scene.reflectance = [](double x) { return x <= 6.01 ? 1 : 0.0; };
  const sim::LineRenderer renderer(rig, scene, images::FloatImage(512, 512), ideal());
  const Frame frame(rig, renderer, 0);
  EXPECT_NEAR(frame.sum(256, 2) - 6 * row_of(rig, 6.0 / 1067), 6 * 0.5, 6 * 0.51);
  EXPECT_NEAR(frame.at(75, 256), 8, 1e-4);
  EXPECT_NEAR(frame.at(77, 256), 2, 1e-4);
}

// ------------------------------------------------------------------ truth

TEST(Renderer, TruthIsTheHeightOnTheLightSheet) {
  const rig::Rig rig = rig::load_rig("light-section");
  const auto stairs = sim::make_scene("stairs", rig);
  const double line = line_at(rig, 0.2, rig.plane_z_mm - 30);
  const sim::LineRenderer renderer(rig, *stairs, light_section::draw_straight_line(rig, line));
  std::vector<float> heights(512);
  renderer.truth(700, heights);
  EXPECT_NEAR(heights[100], 30, 1e-3);
  EXPECT_NEAR(heights[256], 39, 1e-3);
  EXPECT_NEAR(heights[400], 21, 1e-3);
  EXPECT_TRUE(std::isnan(heights[2])) << "the plane's line is out of the image";
  renderer.truth(1399, heights);  // of the part, the sheet meets only the highest tread
  EXPECT_TRUE(std::isnan(heights[100]));
  EXPECT_NEAR(heights[256], 39, 1e-3);
  EXPECT_TRUE(std::isnan(heights[400]));
  const images::FloatImage rows = renderer.truth(698, 4, 3);
  EXPECT_EQ(rows.rows, 4);
  EXPECT_EQ(rows.row(2)[400], [&] {
    renderer.truth(700, heights);
    return heights[400];
  }());
  EXPECT_EQ(renderer.true_height(700, 0, 0), 39);
  EXPECT_EQ(renderer.true_height(0, 0, 0), 0);
}

// On a slope: the point lies on the sheet, on the column's viewing plane and on the surface.
TEST(Renderer, TruthOnASlopeLiesOnTheSurface) {
  const rig::Rig rig = rig::load_rig("light-section");
  const auto mountain = sim::make_scene("mountain", rig);
  const double line = line_at(rig, 0, rig.plane_z_mm - 12);
  const sim::LineRenderer renderer(rig, *mountain, light_section::draw_straight_line(rig, line));
  std::vector<float> heights(512);
  renderer.truth(500, heights);
  for (int column = 0; column < 512; ++column) {
    const double h = static_cast<double>(heights[static_cast<std::size_t>(column)]);
    const double z = rig.plane_z_mm - h;
    const double y = z * (column - 255.5) * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
    const double x = rig.projector.x_mm - (z - rig.projector.z_mm) * tan_theta(rig, line);
    EXPECT_NEAR(h, renderer.true_height(500, x, y), 1e-3) << column;
  }
}

// Where a wall catches the light on the face that the camera does not see, there is no truth.
TEST(Renderer, NoTruthInTheShadow) {
  const rig::Rig rig = rig::load_rig("light-section");
  LevelScene scene;
  scene.x0 = 2;
  scene.x1 = 6;
  std::vector<float> heights(512);
  for (const double top : {0.0, 40.0}) {
    scene.top = top;
    const sim::LineRenderer renderer(rig, scene,
                                     light_section::draw_straight_line(rig, line_at(rig, 0, rig.plane_z_mm)));
    renderer.truth(0, heights);
    EXPECT_EQ(std::isnan(heights[256]), top > 0) << heights[256];
  }
}

// ------------------------------------------------------------------ errors

TEST(Renderer, PatternMustFitTheProjector) {
  const rig::Rig rig = rig::load_rig("light-section");
  const LevelScene scene;
  const auto error_of = [&](const images::FloatImage& pattern) -> std::string {
    try {
      const sim::LineRenderer renderer(rig, scene, pattern);
    } catch (const UserError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(error_of(images::FloatImage(512, 500)),
            "pattern: has 512 lines of 500 columns; the rig's projector has 512 of 512");
  EXPECT_EQ(error_of(images::FloatImage(512, 512, 1.5)), "pattern: has a value of 1.5; light is 0 to 1");
  EXPECT_EQ(error_of(images::FloatImage(512, 512, NAN)), "pattern: has a value of nan; light is 0 to 1");
  EXPECT_EQ(error_of(images::FloatImage(512, 512, 0.5)), "none");
}

// Compares noise, rounding and repeatability of rendered images with statistics.
struct Statistics {
  double mean;
  double variance;
};

// Statistics of the difference between noisy frames and the ideal one.
Statistics noise_of(const rig::Rig& rig, const sim::Scene& scene, const images::FloatImage& pattern,
                    const sim::RenderOptions& options) {
  const Frame ideal_frame(rig, sim::LineRenderer(rig, scene, pattern, ideal()), 0);
  const sim::LineRenderer renderer(rig, scene, pattern, options);
  double sum = 0;
  double squares = 0;
  double count = 0;
  for (int i = 0; i < 2; ++i) {
    const Frame frame(rig, renderer, i);
    for (std::size_t k = 0; k < frame.pixels.size(); ++k) {
      const double difference = static_cast<double>(frame.pixels[k]) - static_cast<double>(ideal_frame.pixels[k]);
      sum += difference;
      squares += difference * difference;
      count += 1;
    }
  }
  return {sum / count, squares / count - sum / count * sum / count};
}

TEST(RendererNoise, NoiseHasTheRigsMeanAndVariance) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.imaging.ambient = 60;
  rig.imaging.read_noise = 1.5;
  const LevelScene scene;
  const images::FloatImage none(512, 512);
  const double shot = (60 - 2) / rig.imaging.electrons_per_grey;
  struct Case {
    bool shot, read, quantization;
    double variance;
  };
  for (const Case& c : {Case{true, false, false, shot}, Case{false, true, false, 2.25},
                        Case{true, true, false, shot + 2.25}, Case{true, true, true, shot + 2.25 + 1.0 / 12}}) {
    sim::RenderOptions options = ideal();
    options.shot_noise = c.shot;
    options.read_noise = c.read;
    options.quantization = c.quantization;
    const Statistics found = noise_of(rig, scene, none, options);
    // of 98,304 pixels: five standard deviations
    EXPECT_NEAR(found.mean, 0, 5 * std::sqrt(c.variance / 98304));
    EXPECT_NEAR(found.variance / c.variance, 1, 5 * std::sqrt(2.0 / 98304));
  }
  // more light, more shot noise
  sim::RenderOptions options = ideal();
  options.shot_noise = true;
  const Statistics lit = noise_of(rig, scene, images::FloatImage(512, 512, 1), options);
  const Frame frame(rig, sim::LineRenderer(rig, scene, images::FloatImage(512, 512, 1), ideal()), 0);
  const double mean =
      std::accumulate(frame.pixels.begin(), frame.pixels.end(), 0.0) / static_cast<double>(frame.pixels.size());
  EXPECT_NEAR(lit.variance / ((mean - 2) / rig.imaging.electrons_per_grey), 1, 0.03);
}

TEST(RendererNoise, EightBitsAreRoundedAndBounded) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.imaging.white = 255;
  rig.imaging.ambient = 250;
  rig.imaging.read_noise = 20;
  const LevelScene scene;
  const sim::LineRenderer renderer(rig, scene, images::FloatImage(512, 512, 1), {});
  std::vector<std::uint8_t> bytes(96 * 512);
  renderer.render(3, bytes);
  const Frame frame(rig, renderer, 3);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    ASSERT_EQ(static_cast<float>(bytes[i]), frame.pixels[i]);
  }
  EXPECT_EQ(*std::max_element(bytes.begin(), bytes.end()), 255);
  sim::RenderOptions free;
  free.quantization = false;
  const Frame unbounded(rig, sim::LineRenderer(rig, scene, images::FloatImage(512, 512, 1), free), 3);
  EXPECT_GT(*std::max_element(unbounded.pixels.begin(), unbounded.pixels.end()), 260.0F);
  EXPECT_NE(unbounded.pixels[0], std::nearbyint(unbounded.pixels[0]));
}

TEST(RendererNoise, ImagesDependOnSeedAndFrameAloneNotOnOrderOrThreads) {
  rig::Rig rig = rig::load_rig("light-section");
  const auto scene = sim::make_scene("stairs-marked", rig);
  const images::FloatImage line = light_section::draw_straight_line(rig, line_at(rig, 0, rig.plane_z_mm - 39));
  const sim::LineRenderer renderer(rig, *scene, line);
  constexpr int kCount = 6;
  constexpr int kFirst = 640;
  std::vector<std::vector<std::uint8_t>> alone(kCount, std::vector<std::uint8_t>(96 * 512));
  std::vector<std::vector<std::uint8_t>> together = alone;
  for (int i = kCount - 1; i >= 0; --i) {
    renderer.render(kFirst + i, alone[static_cast<std::size_t>(i)]);
  }
  sim::parallel_for(kCount, 3, [&](int i) { renderer.render(kFirst + i, together[static_cast<std::size_t>(i)]); });
  EXPECT_EQ(alone, together);
  EXPECT_NE(alone[0], alone[1]);
  rig.imaging.seed = 2;
  std::vector<std::uint8_t> other(96 * 512);
  sim::LineRenderer(rig, *scene, line).render(kFirst, other);
  EXPECT_NE(other, alone[0]);
}

// Without a disturbance of the world, images are those of before there was any, byte for byte. The sums were made of
// the PNG files of the program of that time.

// FNV-1a.
std::uint64_t sum_of(const std::vector<std::uint8_t>& pixels) {
  std::uint64_t sum = 0xcbf29ce484222325U;
  for (const std::uint8_t pixel : pixels) {
    sum = (sum ^ pixel) * 0x100000001b3U;
  }
  return sum;
}

images::FloatImage line_on_plane(const rig::Rig& rig) {
  return light_section::draw_straight_line(
      rig, sim::Pinhole::of_projector(rig.projector).project({0, 0, rig.plane_z_mm}).row);
}

std::uint64_t of_line(const sim::PerturbedRig& actual, const std::string& scene_name, int frame,
                      const sim::RenderOptions& options) {
  const auto scene = sim::make_scene(scene_name, actual.rig);
  const rig::Rig& rig = actual.rig;
  std::vector<std::uint8_t> pixels(rig.camera.pixels());
  sim::LineRenderer(actual, *scene, line_on_plane(rig), options).render(frame - 1, std::span(pixels));
  return sum_of(pixels);
}

std::uint64_t of_pattern(const std::string& scene_name, int frame, int pattern) {
  const rig::Rig rig = rig::load_rig("scanner");
  const auto scene = sim::make_scene(scene_name, rig);
  const std::vector<images::Image> patterns = sim::gray_patterns(rig.projector, 8);
  std::vector<std::uint8_t> pixels(rig.camera.pixels());
  sim::PatternRenderer(rig, *scene)
      .render(frame - 1, sim::project_image(rig, patterns[static_cast<std::size_t>(pattern)]), std::span(pixels));
  return sum_of(pixels);
}

TEST(ImagesOfBefore, OfALine) {
  const rig::Rig rig = rig::load_rig("light-section");
  EXPECT_EQ(of_line(rig, "stairs-marked", 700, {}), 0xc91e686512317edcU);
  EXPECT_EQ(of_line(rig, "stairs-marked", 701, {}), 0x71de9c1ca9382ed4U);
  EXPECT_EQ(of_line(rig, "mountain", 300, {}), 0x66fa39af3e067559U);
  sim::RenderOptions falling;
  falling.falloff = true;
  EXPECT_EQ(of_line(sim::hidden_rig(rig, 3), "mountain", 300, falling), 0x73faae068e6eef81U);
}

TEST(ImagesOfBefore, OfWholePatterns) {
  EXPECT_EQ(of_pattern("desk", 1, 0), 0x816f27fe4bf7fff4U);
  EXPECT_EQ(of_pattern("cuboids-marked", 2, 1), 0x2448fd90bbd0877eU);
  EXPECT_EQ(of_pattern("fist", 101, 0), 0xa54b773e0604e7e2U);
}

// A world in which nothing is on is no world at all, and one with a name on changes the image.
TEST(ImagesOfBefore, OnlyWithoutDisturbances) {
  const rig::Rig rig = rig::load_rig("light-section");
  const sim::WorldFile file = sim::load_world(sim::kBuiltInWorld);
  sim::RenderOptions options;
  options.world = sim::world_of(file, {});
  EXPECT_EQ(of_line(rig, "stairs-marked", 700, options), 0xc91e686512317edcU);
  const auto scene = sim::make_scene("stairs-marked", rig);
  const auto image_of = [&](const std::vector<std::string>& names) {
    sim::RenderOptions exact = options;
    exact.quantization = false;
    exact.world = sim::world_of(file, names);
    std::vector<float> pixels(rig.camera.pixels());  // of the part's front edge, on which a straight line falls
    sim::LineRenderer(rig, *scene, line_on_plane(rig), exact).render(54, std::span(pixels));
    return pixels;
  };
  const std::vector<float> before = image_of({});
  for (const sim::WorldSwitch& entry : sim::world_switches()) {
    EXPECT_NE(image_of({entry.name}), before) << entry.name;
  }
}

// Tests work by several threads.

TEST(ParallelFor, CallsEachOnceAndPassesOnWhatIsThrown) {
  for (const int threads : {0, 1, 4}) {
    std::vector<int> calls(1000);
    sim::parallel_for(1000, threads, [&](int i) { ++calls[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(calls, std::vector<int>(1000, 1));
    EXPECT_THROW(sim::parallel_for(100, threads,
                                   [](int i) {
                                     if (i == 7) {
                                       throw UserError("a", "b");
                                     }
                                   }),
                 UserError);
  }
  sim::parallel_for(0, 2, [](int) { FAIL(); });
}

}  // namespace
}  // namespace selfproj::test
