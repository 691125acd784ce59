// Tests the contracts of `selfproj pattern stripes`, `selfproj match` and `selfproj accuracy`.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/io/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/gray_sequence.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_reference_file.h"
#include "tests/cli/program.h"
#include "tests/host/light_section/seen_surface.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

// The camera's image of the points under a pattern of the projector.
void write_picture(const fs::path& file, const ProjectorPoints& points, const std::vector<std::uint8_t>& pattern,
                   int pattern_columns) {
  cv::Mat image(points.line.rows, points.line.columns, CV_8UC1);
  for (int r = 0; r < image.rows; ++r) {
    for (int c = 0; c < image.cols; ++c) {
      const float line = points.line.row(r)[c];
      std::uint8_t value = 10;
      if (!std::isnan(line)) {
        const auto at = std::lround(line) * pattern_columns + std::lround(points.column.row(r)[c]);
        value = pattern[static_cast<std::size_t>(at)] != 0 ? 150 : 10;
      }
      image.at<std::uint8_t>(r, c) = value;
    }
  }
  ASSERT_TRUE(cv::imwrite(file.string(), image));
}

class MatchCommand : public ::testing::Test {
 protected:
  MatchCommand() : rig_(coarse_scanner(8)) {
    rig_.measure.max_z_per_line_mm = 50;
    write_text(folder_ / "rig.yaml", to_yaml(rig_));
    rig_ = load_rig((folder_ / "rig.yaml").string());
    points_ = points_of(rig_, plane_at(550));
  }

  Outcome run(const std::vector<std::string>& arguments) {
    return run_program(SELFPROJ_PROGRAM, arguments, folder_.path());
  }

  // The folder `scan` of Gray-code images of the plane.
  void scan() {
    fs::create_directory(folder_ / "scan");
    const GraySequence sequence(rig_.projector.columns, rig_.projector.lines);
    for (int i = 0; i < sequence.count(); ++i) {
      write_picture(folder_ / fmt::format("scan/{:03}.png", i), points_, sequence.image(i), sequence.columns());
    }
  }

  // ... and the reference folder `ref` of it.
  void reference() {
    scan();
    const Outcome outcome =
        run({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "scan", "--gray-code", "--out", "ref"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }

  // Expects status 2, one line on stderr that contains all of these texts, and nothing written.
  void refused(const std::vector<std::string>& arguments, const std::vector<std::string>& words) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    for (const std::string& word : words) {
      EXPECT_NE(outcome.err.find(word), std::string::npos) << word << " is not in: " << outcome.err;
    }
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  }

  ScratchFolder folder_;
  Rig rig_;
  ProjectorPoints points_;
};

TEST_F(MatchCommand, ReferenceOfAScanAndDepthOfImages) {
  reference();
  const SelfReference found = read_self_reference(rig_, (folder_ / "ref").string());
  EXPECT_EQ(found.stripes, (Stripes{4, 2, StripeCode::cyclic}));
  int compared = 0;
  for (std::size_t i = 0; i < found.points.line.values.size(); ++i) {
    if (found.measurable(i) && !std::isnan(points_.line.values[i])) {
      EXPECT_NEAR(found.points.line.values[i], points_.line.values[i], 0.6);
      ++compared;
    }
  }
  EXPECT_GT(compared, 2000);

  const ProjectorPoints part = points_of(rig_, plane_at(530));
  std::vector<std::string> arguments{"match", "--rig", "rig.yaml", "--reference", "ref", "--e", "4", "--out", "out"};
  for (int i = 0; i < 8; ++i) {
    const cv::Mat pattern =
        cv::imread((folder_ / fmt::format("ref/pattern_{:02}.png", i)).string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(pattern.rows, rig_.projector.lines);
    write_picture(folder_ / fmt::format("image_{}.png", i), part,
                  std::vector<std::uint8_t>(pattern.begin<std::uint8_t>(), pattern.end<std::uint8_t>()), pattern.cols);
    arguments.push_back(fmt::format("image_{}.png", i));
  }
  const Outcome outcome = run(arguments);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const FloatImage difference = read_float_tiff((folder_ / "out/difference.tiff").string());
  double sum = 0;
  int count = 0;
  for (int r = 20; r < 44; ++r) {
    for (int c = 20; c < 44; ++c) {
      const float value = difference.row(r)[c];
      if (!std::isnan(value)) {
        sum += static_cast<double>(value);
        ++count;
      }
    }
  }
  ASSERT_GT(count, 300);
  EXPECT_NEAR(sum / count, 20, 5);  // one code of this coarse rig is 35 mm
}

TEST_F(MatchCommand, RefusesWrongScans) {
  scan();
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--out", "out"}, {"--scan", "--sweep"});
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "scan", "--out", "out"}, {"scan", "images", "224"});
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "nowhere", "--out", "out"}, {"nowhere"});
  refused({"pattern", "stripes", "--rig", "light-section", "--scan", "scan", "--out", "out"}, {"kind scanner"});
  refused({"pattern", "stripes", "--rig", "scanner", "--scan", "scan", "--gray-code", "--out", "out"},
          {"scan", "images"});
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "scan", "--bits", "9", "--out", "out"}, {"--bits"});
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "scan", "--rows-per-code", "0", "--out", "out"},
          {"--rows-per-code"});
}

TEST_F(MatchCommand, RefusesWrongReferencesAndSettings) {
  reference();
  const std::vector<std::string> images(8, "scan/000.png");
  const auto with = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), images.begin(), images.end());
    return arguments;
  };
  const auto match = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"match", "--rig", "rig.yaml", "--reference", "ref", "--out", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return with(arguments);
  };
  refused(match({"--e", "16"}), {"--e", "0 to 15"});
  refused(match({"--e", "-1"}), {"--e", "0 to 255"});
  refused(match({"--line-width", "0"}), {"--line-width"});
  refused({"match", "--rig", "rig.yaml", "--reference", "ref", "--out", "out", "scan/000.png"}, {"too few"});
  refused(with({"match", "--rig", "rig.yaml", "--reference", "nowhere", "--out", "out"}), {"nowhere"});
  refused(with({"match", "--rig", "rig.yaml", "--reference", "scan", "--out", "out"}), {"scan", "reference.yaml"});
  refused(with({"match", "--rig", "scanner", "--reference", "ref", "--out", "out"}), {"another rig", "camera.rows"});

  const std::string head = read_text(folder_ / "ref/reference.yaml");
  const auto damaged = [&](const std::string& text, const std::vector<std::string>& words) {
    write_text(folder_ / "ref/reference.yaml", text);
    refused(match({}), words);
    write_text(folder_ / "ref/reference.yaml", head);
  };
  damaged("", {"reference.yaml", "damaged"});
  damaged("{", {"reference.yaml", "line 1: end of map flow not found"});
  damaged(head.substr(0, 60), {"reference.yaml", "damaged"});
  damaged("selfproj_stripes: 2\n", {"version 2"});
  std::string other = head;
  other.replace(other.find("bits: 4"), 7, "bits: 9");
  damaged(other, {"reference.yaml", "bits"});

  for (const char* name : {"x_r_line.tiff", "f_r_row.tiff", "f_r_seen.png"}) {
    fs::rename(folder_ / ("ref/" + std::string(name)), folder_ / "kept");
    refused(match({}), {name});
    write_text(folder_ / ("ref/" + std::string(name)), "no image");
    refused(match({}), {name});
    fs::remove(folder_ / ("ref/" + std::string(name)));
    fs::rename(folder_ / "kept", folder_ / ("ref/" + std::string(name)));
  }
  write_float_tiff((folder_ / "ref/x_r_line.tiff").string(), FloatImage(3, 5));
  refused(match({}), {"x_r_line.tiff", "5 x 3"});
}

TEST_F(MatchCommand, AccuracyShowsPublishedAndDerivedFigures) {
  const Outcome outcome = run({"accuracy", "--out", "map"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* text : {"1.79", "1.50", "0.72", "1.59", "496.72", "461.29", "457.88", "141.66"}) {
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text;
  }
  const std::string map = read_text(folder_ / "map/error_map.csv");
  EXPECT_EQ(std::count(map.begin(), map.end(), '\n'), 1 + 3 * 16 * 16);
  refused({"accuracy", "--e", "16", "--out", "out"}, {"--e"});
  refused({"accuracy", "--rig", "light-section", "--out", "out"}, {"kind scanner"});
}

}  // namespace
}  // namespace selfproj::test
