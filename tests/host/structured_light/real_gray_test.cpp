// Decodes Gray codes that others have captured (../shared/data, not part of the project), and compares the codes with
// OpenCV's and the points with the owner's cloud. Each test reports that it is skipped if its data or OpenCV's module
// is missing.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "host/files/results_file.h"
#include "host/images/image_files.h"
#include "host/report/depth_output.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "selfproj/structured_light/lens_triangulation.h"
#include "selfproj/structured_light/point_cloud.h"

#ifdef SELFPROJ_HAS_OPENCV_STRUCTURED_LIGHT
#include <opencv2/structured_light/graycodepattern.hpp>
#endif

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

fs::path data_folder() { return fs::path(SELFPROJ_SOURCE_DIR) / "../shared/data"; }

std::vector<std::string> files_in(const fs::path& folder, const std::string& extension) {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) {
      files.push_back(entry.path().string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The code words of both axes at two thresholds, from one pass over the images.
TEST(RealGray, ShellLiesOnTheOwnersCloud) {
  const fs::path folder = data_folder() / "gray-sltk";
  if (!fs::exists(folder)) {
    GTEST_SKIP() << "no " << folder;
  }
  constexpr int kBits = 11;
  const std::array<int, 2> thresholds{3, 5};
  const std::vector<std::string> files = files_in(folder / "scan_0020", ".jpg");
  ASSERT_EQ(files.size(), 4U * kBits);
  const rig::Calibration calibration = rig::read_calibration((folder / "procam_2016_12_09.yaml").string());
  const model::GraySettings settings{calibration.camera_rows, calibration.camera_columns, kBits, 0};
  // [axis][threshold]
  std::array<std::array<std::vector<std::uint16_t>, 2>, 2> words;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::vector<structured_light::FastGrayDecoder> decoders;
    for (const int threshold : thresholds) {
      model::GraySettings own = settings;
      own.threshold = threshold;
      decoders.emplace_back(own);
    }
    std::array<images::Image, 2> pair;
    for (int pattern = 0; pattern < 2 * kBits; ++pattern) {
      images::Image& image = pair[static_cast<std::size_t>(pattern % 2)];
      image = images::read_image(files[axis * 2 * kBits + static_cast<std::size_t>(pattern)], images::Channel::grey);
      for (structured_light::FastGrayDecoder& decoder : decoders) {
        decoder.add_frame(image.view(), pattern);
      }
    }
    for (std::size_t i = 0; i < thresholds.size(); ++i) {
      words[axis][i].resize(pair[0].pixels.size());
      structured_light::unambiguous_code_words(decoders[i].codes(), words[axis][i].data());
    }
  }
  std::vector<structured_light::Point3f> theirs = structured_light::read_ply((folder / "scan_0020_cloud.ply").string());
  for (structured_light::Point3f& point : theirs) {
    point = {point.x, -point.y, -point.z};  // the owner's axes are OpenGL's
  }
  const structured_light::LensTriangulation triangulation(calibration,
                                                          {settings.rows, settings.columns, kBits, kBits, 0, 0, 3, {}});
  images::FloatImage depth(settings.rows, settings.columns);
  nlohmann::ordered_json results;
  for (std::size_t i = 0; i < thresholds.size(); ++i) {
    triangulation.depth_of_both(words[0][i].data(), words[1][i].data(), depth.values.data(), nullptr, nullptr);
    const structured_light::CloudComparison found =
        structured_light::compare_clouds(report::points_of(triangulation, depth), theirs, 1.0);
    std::printf(
        "threshold %d, no ambiguous pair: %zu points, median distance to the owner's cloud %.3f mm, %.1f %% within 1 "
        "mm; "
        "%.1f %% of the owner's %zu points have one of ours within 1 mm\n",
        thresholds[i], found.ours, found.median_mm, 100 * found.ours_within, 100 * found.theirs_within, found.theirs);
    results["threshold_" + std::to_string(thresholds[i])] = {{"points", found.ours},
                                                             {"median_mm", found.median_mm},
                                                             {"within_1_mm", found.ours_within},
                                                             {"owners_points", found.theirs},
                                                             {"owners_within_1_mm", found.theirs_within}};
    EXPECT_LE(found.median_mm, 0.4);
    EXPECT_GE(found.theirs_within, 0.95);
    EXPECT_GT(found.ours, 100000U);
  }
  files::write_results(
      "real_gray", "A shell from real captures, 11 bits an axis, no ambiguous pair, beside its owner's cloud", results);
}

#ifdef SELFPROJ_HAS_OPENCV_STRUCTURED_LIGHT

// OpenCV's pixels are valid if no pair of either axis is ambiguous and the code belongs to the projector. The test
// gives it one axis only; the other axis has the one bit that its class requires. Its validity then differs from ours
// exactly at the pixels with one ambiguous pair, and at those whose code does not exist.
TEST(RealGray, ChessboardDecodesAsWithOpenCv) {
  const fs::path folder = data_folder() / "gray-kamino-pose0/capture_0";
  if (!fs::exists(folder)) {
    GTEST_SKIP() << "no " << folder;
  }
  constexpr int kBits = 10;
  constexpr int kThreshold = 5;
  const std::vector<std::string> files = files_in(folder, ".png");
  ASSERT_GE(files.size(), 4U * kBits);
  for (const int lines : {1024, 768}) {
    SCOPED_TRACE(lines == 1024 ? "columns" : "rows");
    std::vector<images::Image> images;
    for (std::size_t i = 0; i < 2 * kBits; ++i) {
      images.push_back(images::read_image(files[i + (lines == 1024 ? 0U : 2U * kBits)], std::nullopt));
    }
    const int rows = images[0].rows;
    const int columns = images[0].columns;
    structured_light::FastGrayDecoder decoder({rows, columns, kBits, kThreshold});
    std::vector<cv::Mat> mats;
    for (int i = 0; i < 2 * kBits; ++i) {
      images::Image& image = images[static_cast<std::size_t>(i)];
      decoder.add_frame(image.view(), i);
      mats.emplace_back(rows, columns, CV_8U, image.pixels.data());
    }
    mats.push_back(mats[0]);
    mats.push_back(mats[1]);
    const auto peer = cv::structured_light::GrayCodePattern::create(lines, 2);
    ASSERT_EQ(peer->getNumberOfPatternImages(), mats.size());
    peer->setWhiteThreshold(kThreshold + 1);  // it accepts a difference equal to its threshold, we do not
    peer->setBlackThreshold(0);

    const structured_light::CodeImageView codes = decoder.codes();
    std::size_t equal = 0;
    std::size_t one = 0;
    std::size_t one_equal = 0;
    std::size_t no_line = 0;
    std::size_t neither = 0;
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
        const unsigned ambiguous = codes.ambiguous16[i];
        const bool measurable = (ambiguous & (ambiguous - 1U)) == 0;
        cv::Point point;
        const bool valid = !peer->getProjPixel(mats, x, y, point);
        if (ambiguous == 0 && codes.codes16[i] < lines) {
          ASSERT_TRUE(valid) << x << ", " << y;
          ASSERT_EQ(point.x, codes.codes16[i]) << x << ", " << y;
          ++equal;
          continue;
        }
        ASSERT_FALSE(valid) << x << ", " << y;
        if (ambiguous == 0) {
          ++no_line;
        } else if (measurable) {
          ++one;
          one_equal += point.x == codes.codes16[i] ? 1 : 0;
        } else {
          ++neither;
        }
      }
    }
    std::printf(
        "%d lines, threshold %d: %zu pixels valid in both, all codes equal; valid here only: %zu with one ambiguous "
        "pair "
        "(there the sign decides: %zu codes equal), %zu with a code of no line; in neither %zu\n",
        lines, kThreshold, equal, one, one_equal, no_line, neither);
    EXPECT_GT(equal, static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) / 4);
  }
}

#else

TEST(RealGray, ChessboardDecodesAsWithOpenCv) {
  GTEST_SKIP() << "built without OpenCV's structured_light module (libopencv-contrib-dev)";
}

#endif

}  // namespace
}  // namespace selfproj::test
