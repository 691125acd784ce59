// Tests the contract of `selfproj-sim scene`.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/light_section/pattern.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "tests/cli/program.h"
#include "tests/cli/refusal.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

class SceneCommand : public ::testing::Test {
 protected:
  Outcome run(const std::vector<std::string>& arguments) const {
    std::vector<std::string> all{"scene"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run_program(SELFPROJ_SIM_PROGRAM, all, folder_.path());
  }

  Outcome render(const std::vector<std::string>& arguments) const {
    std::vector<std::string> all{"render", "--out", "out"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run(all);
  }

  // Expects status 2, one line that begins with `message`, and nothing written.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& message) const {
    const std::vector<std::string> before = folder_.names();
    expect_refusal(run(arguments), message);
    EXPECT_EQ(folder_.names(), before);
  }

  void save(const std::string& name, const images::FloatImage& image) const {
    images::write_float_tiff((folder_ / name).string(), image);
  }

  std::vector<std::string> names(const std::string& sub_folder) const {
    std::vector<std::string> result;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_ / sub_folder)) {
      result.push_back(entry.path().filename().string());
    }
    std::sort(result.begin(), result.end());
    return result;
  }

  images::Image frame(const std::string& name) const {
    return images::read_image((folder_ / "out" / name).string(), std::nullopt);
  }

  ScratchFolder folder_;
};

TEST_F(SceneCommand, ListNamesEveryScene) {
  const Outcome outcome = run({"list"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err, "");
  for (const sim::SceneInfo& info : sim::scenes()) {
    EXPECT_NE(outcome.out.find("\n" + info.name + " "), std::string::npos) << info.name;
  }
}

TEST_F(SceneCommand, FramesAndTruthAreTheRenderers) {
  const Outcome outcome = render({"stairs-marked", "--first", "700", "--count", "3", "--truth", "truth.tiff"});
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out, "3 frames of 512 x 96, scene stairs-marked, rig light-section, seed 1 → out\n");
  EXPECT_EQ(names("out"),
            (std::vector<std::string>{"frame_00700.png", "frame_00701.png", "frame_00702.png", "pattern.tiff"}));
  const rig::Rig rig = rig::load_rig("light-section");
  const images::FloatImage pattern = images::read_float_tiff((folder_ / "out" / "pattern.tiff").string());
  const std::unique_ptr<sim::Scene> scene = sim::make_scene("stairs-marked", rig);
  const sim::LineRenderer renderer(rig, *scene, pattern);
  const images::FloatImage truth = images::read_float_tiff((folder_ / "truth.tiff").string());
  ASSERT_EQ(truth.rows, 3);
  std::vector<std::uint8_t> expected(96 * 512);
  std::vector<float> heights(512);
  for (int i = 0; i < 3; ++i) {
    renderer.render(699 + i, expected);
    EXPECT_EQ(frame(fmt::format("frame_{:05}.png", 700 + i)).pixels, expected);
    renderer.truth(699 + i, heights);
    for (int c = 0; c < 512; ++c) {
      const float found = truth.row(i)[c];
      const float right = heights[static_cast<std::size_t>(c)];
      EXPECT_TRUE(found == right || (std::isnan(found) && std::isnan(right)));
    }
  }
}

// A scene of the scanner: Gray codes frame by frame from the first one rendered, or the user's patterns.
TEST_F(SceneCommand, WholePatternsOfAScanner) {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows = rig.camera.columns = 32;
  rig.camera.pixel_pitch_mm *= 16;
  rig.projector.lines = 48;
  rig.projector.columns = 64;
  rig.projector.line_pitch_mm *= 16;
  rig.projector.column_pitch_mm *= 16;
  std::ofstream(folder_ / "small.yaml") << rig::to_yaml(rig);
  const std::vector<std::string> common{"fist", "--rig", "small.yaml", "--first", "41", "--count", "5"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), common.begin(), common.end());
    return render(more);
  };
  const Outcome outcome = with({"--bits", "2", "--truth", "truth.tiff"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(names("out"), (std::vector<std::string>{"frame_00041.png", "frame_00042.png", "frame_00043.png",
                                                    "frame_00044.png", "frame_00045.png"}));
  const std::unique_ptr<sim::Scene> scene = sim::make_scene("fist", rig);
  const sim::PatternRenderer renderer(rig, *scene);
  const sim::PatternSet patterns(rig, sim::gray_patterns(rig.projector, 2));
  const images::FloatImage truth = images::read_float_tiff((folder_ / "truth.tiff").string());
  ASSERT_EQ(truth.rows, 5 * 32);
  std::vector<std::uint8_t> expected(32 * 32);
  std::vector<float> z(32 * 32);
  for (int i = 0; i < 5; ++i) {
    renderer.render(40 + i, patterns[i % 4], std::span<std::uint8_t>(expected));
    EXPECT_EQ(frame(fmt::format("frame_{:05}.png", 41 + i)).pixels, expected);
    renderer.depth(40 + i, z);
    EXPECT_TRUE(std::equal(z.begin(), z.end(), truth.row(32 * i)));
  }
  // the same patterns as files, commas between
  fs::remove_all(folder_ / "out");
  std::string files;
  for (int i = 0; i < 4; ++i) {
    std::vector<images::Image> images = sim::gray_patterns(rig.projector, 2);
    images::Image& image = images[static_cast<std::size_t>(i)];
    const std::string name = fmt::format("p{}.png", i);
    cv::imwrite((folder_ / name).string(), cv::Mat(image.rows, image.columns, CV_8UC1, image.pixels.data()));
    files += (i > 0 ? "," : "") + name;
  }
  ASSERT_EQ(with({"--pattern", files}).status, 0);
  EXPECT_EQ(frame("frame_00045.png").pixels, expected);
  fs::remove_all(folder_ / "out");
  expect_refused({"render", "fist", "--rig", "small.yaml", "--out", "out", "--bits", "2", "--pattern", "p0.png"},
                 "--bits: cannot be combined with --pattern");
  expect_refused({"render", "fist", "--rig", "small.yaml", "--out", "out", "--truth", "t.tiff"},
                 "--truth t.tiff: takes at most 256 frames of depth, not 2000");
  expect_refused({"render", "stairs", "--out", "out", "--bits", "2"},
                 "--bits: goes only with rigs of kind scanner; light-section is not one");
  expect_refused({"render", "fist", "--rig", "light-section", "--out", "out"},
                 "fist: needs a rig of kind scanner; light-section is not one");
}

// The default line lies in the middle of the plane's image.
TEST_F(SceneCommand, PatternIsAStraightLineInTheMiddleUnlessGiven) {
  EXPECT_EQ(render({"plane", "--count", "1"}).status, 0);
  const images::Image image = frame("frame_00001.png");
  for (const int column : {3, 200, 511}) {
    double m0 = 0;
    double m1 = 0;
    for (int row = 0; row < image.rows; ++row) {
      const int over = image.pixels[static_cast<std::size_t>(row * image.columns + column)] - 20;
      m0 += over > 0 ? over : 0;
      m1 += over > 0 ? over * row : 0;
    }
    EXPECT_NEAR(m1 / m0, 47.5, 0.1);
  }
}

TEST_F(SceneCommand, PatternFromTiffOrPng) {
  const rig::Rig rig = rig::load_rig("light-section");
  const images::FloatImage pattern = light_section::draw_straight_line(rig, 270.4);
  save("line.tiff", pattern);
  write_text(folder_ / "line.png", light_section::encode_pattern_png(pattern));
  EXPECT_EQ(render({"plane", "--count", "1", "--pattern", "line.tiff"}).status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "pattern.tiff")) << "the user has it";
  const images::Image from_tiff = frame("frame_00001.png");
  EXPECT_EQ(render({"plane", "--count", "1", "--pattern", "line.png"}).status, 0);
  const images::Image from_png = frame("frame_00001.png");
  int greatest = 0;
  for (std::size_t i = 0; i < from_png.pixels.size(); ++i) {
    greatest = std::max(greatest, std::abs(from_png.pixels[i] - from_tiff.pixels[i]));
  }
  EXPECT_LE(greatest, 1);
}

TEST_F(SceneCommand, ErrorSourcesAreTurnedOffOneByOne) {
  EXPECT_EQ(render({"plane", "--count", "1", "--seed", "5", "--without", "shot-noise,read-noise", "--without",
                    "camera-blur,projector-blur,motion-blur"})
                .status,
            0);
  const images::Image image = frame("frame_00001.png");
  EXPECT_TRUE(std::all_of(image.pixels.begin(), image.pixels.begin() + 512, [](int p) { return p == 8; }));
  const Outcome outcome = run({"render", "plane", "--out", "float", "--count", "2", "--without", "quantization"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out,
            "2 frames of 512 x 96, scene plane, rig light-section, seed 1, without quantization → float\n");
  EXPECT_EQ(names("float"), (std::vector<std::string>{"frame_00001.tiff", "frame_00002.tiff", "pattern.tiff"}));
  const images::FloatImage fine = images::read_float_tiff((folder_ / "float" / "frame_00001.tiff").string());
  EXPECT_NE(fine.values[0], std::nearbyint(fine.values[0]));
}

TEST_F(SceneCommand, SeedAndThreads) {
  const auto pixels = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all{"mountain", "--first", "600", "--count", "4"};
    all.insert(all.end(), more.begin(), more.end());
    EXPECT_EQ(render(all).status, 0);
    return frame("frame_00603.png").pixels;
  };
  const auto first = pixels({});
  EXPECT_EQ(pixels({"--threads", "1"}), first);
  EXPECT_EQ(pixels({"--threads", "3", "--seed", "1"}), first);
  EXPECT_NE(pixels({"--seed", "2"}), first);
}

// A ramp of 0.2 mm a row along the conveyor, with the truth beside the frames.
TEST_F(SceneCommand, HeightMap) {
  images::FloatImage map(21, 120);
  for (int r = 0; r < map.rows; ++r) {
    std::fill_n(map.row(r), map.columns, static_cast<float>(10 - r) * 0.2F);
  }
  save("map.tiff", map);
  const Outcome outcome = render({"--height-map", "map.tiff", "--mm-per-pixel", "1", "--truth", "out/truth.tiff",
                                  "--count", "1", "--first", "155"});
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out, "1 frame of 512 x 96, height map map.tiff, rig light-section, seed 1 → out\n");
  const images::FloatImage truth = images::read_float_tiff((folder_ / "out" / "truth.tiff").string());
  // the middle of the map is at x = -15.5 + 15.4 mm, the ramp rises by 0.2 along x, and the sheet leans by 352/588 from
  // the plane at x = 0: h = 0.2 (0.1 + h 352/588)
  EXPECT_NEAR(truth.row(0)[256], 0.02 / (1 - 0.2 * 352 / 588), 1e-4);
}

TEST_F(SceneCommand, OtherRig) {
  std::string yaml = rig::to_yaml(rig::load_rig("light-section"));
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(yaml.find(from), std::string::npos);
    yaml.replace(yaml.find(from), from.size(), to);
  };
  replace("rows: 96", "rows: 160");
  replace("speed_mm_per_s: 1000", "speed_mm_per_s: 0");
  write_text(folder_ / "rig.yaml", yaml);
  EXPECT_EQ(render({"stairs", "--rig", "rig.yaml"}).status, 0);
  EXPECT_EQ(names("out"), (std::vector<std::string>{"frame_00001.png", "pattern.tiff"}));
  EXPECT_EQ(frame("frame_00001.png").rows, 160);
}

// ------------------------------------------------------------------ errors

TEST_F(SceneCommand, BadInputIsOneLineAndNothingWritten) {
  const std::vector<std::string> out{"--out", "out"};
  const auto with_out = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"render", "--out", "out"});
    return arguments;
  };
  expect_refused(with_out({"hill"}), "hill: is not a scene; the scenes are plane, ");
  expect_refused(with_out({}), "SCENE: name a scene, or give --height-map");
  expect_refused({"render", "plane"}, "--out: is required");
  expect_refused(with_out({"plane", "--first", "101"}), "--first 101: the scene ends after 100 frames");
  expect_refused(with_out({"plane", "--first", "0"}), "--first: ");
  expect_refused(with_out({"plane", "--count", "0"}), "--count: ");
  expect_refused(with_out({"plane", "--without", "wind"}), "--without: ");
  expect_refused(with_out({"plane", "--rig", "missing.yaml"}), "missing.yaml: is neither a readable file");
  expect_refused(with_out({"plane", "--pattern", "missing.png"}), "missing.png: No such file");
  write_text(folder_ / "file", "text\n");
  expect_refused({"render", "plane", "--out", "file"}, "file");
  expect_refused({"render", "plane", "--out", "file/out"}, "file/out: file is not a folder");
  expect_refused(with_out({"plane", "--truth", "file/truth.tiff"}), "file/truth.tiff: file is not a folder");
  save("small.tiff", images::FloatImage(10, 10));
  expect_refused(with_out({"plane", "--pattern", "small.tiff"}),
                 "small.tiff: has 10 lines of 10 columns; the rig's projector has 512 of 512");
  save("bright.tiff", images::FloatImage(512, 512, 2));
  expect_refused(with_out({"plane", "--pattern", "bright.tiff"}), "bright.tiff: has a value of 2; light is 0 to 1");
}

TEST_F(SceneCommand, BadHeightMapsAreNamed) {
  const auto map = [](const std::string& file, const std::string& scale) {
    return std::vector<std::string>{"render", "--out", "out", "--height-map", file, "--mm-per-pixel", scale};
  };
  save("map.tiff", images::FloatImage(4, 4, 1));
  expect_refused(map("map.tiff", "0"), "--mm-per-pixel: is '0'; a number above 0");
  expect_refused(map("map.tiff", "-1"), "--mm-per-pixel: is '-1'; a number above 0");
  expect_refused(map("map.tiff", "wide"), "--mm-per-pixel: is 'wide'; a number above 0");
  expect_refused({"render", "--out", "out", "--height-map", "map.tiff"}, "--height-map: goes only with --mm-per-pixel");
  expect_refused({"render", "--out", "out", "plane", "--mm-per-pixel", "1"},
                 "--mm-per-pixel: goes only with --height-map");
  write_text(folder_ / "empty.tiff", "");
  expect_refused(map("empty.tiff", "1"), "empty.tiff: is not an image");
  save("high.tiff", images::FloatImage(4, 4, 600));
  expect_refused(map("high.tiff", "1"), "high.tiff: has heights from 600 to 600 mm");
  save("infinite.tiff", images::FloatImage(4, 4, std::numeric_limits<float>::infinity()));
  expect_refused(map("infinite.tiff", "1"), "infinite.tiff: has a pixel that is inf");
  ASSERT_TRUE(cv::imwrite((folder_ / "bytes.tiff").string(), cv::Mat(4, 4, CV_8UC1, cv::Scalar(9))));
  expect_refused(map("bytes.tiff", "1"), "bytes.tiff: is not an image of one channel of 32-bit");
}

TEST_F(SceneCommand, FramesOfAnotherRunAreNotMixedIn) {
  EXPECT_EQ(render({"plane", "--count", "3"}).status, 0);
  expect_refused({"render", "plane", "--count", "2", "--out", "out"},
                 "--out out: holds frames of another run, such as frame_00003.png");
  EXPECT_EQ(render({"plane", "--count", "3"}).status, 0);
  EXPECT_EQ(names("out").size(), 4U);
}

}  // namespace
}  // namespace selfproj::test
