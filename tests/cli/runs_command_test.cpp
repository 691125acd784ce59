// Tests `selfproj-sim moments` with the strongest run and with images as they come, and `selfproj lines`.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet_payload.h"
#include "tests/cli/program.h"
#include "tests/cli/random_image.h"
#include "tests/cli/refusal.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// The expected table, from the definition; in mode binary `second` is 8 or 0.
std::string expected_csv(const cv::Mat& image, const model::Measure& measure) {
  model::Runs runs;
  runs.resize(measure.select, image.cols);
  model::measure_columns({image.data, image.rows, image.cols, static_cast<std::ptrdiff_t>(image.step[0])}, measure,
                         runs.view());
  const bool strongest = measure.select == model::Select::strongest;
  std::string csv = strongest ? "frame,column,m0,m1,n,runs,second\n" : "frame,column,m0,m1,n\n";
  for (std::size_t i = 0; i < runs.moments.n.size(); ++i) {
    fmt::format_to(std::back_inserter(csv), "1,{},{},{},{}", i + 1, runs.moments.m0[i], runs.moments.m1[i],
                   runs.moments.n[i]);
    if (strongest) {
      const int second = measure.mode == model::Mode::binary ? runs.second[i] / 8 > 0 ? 8 : 0 : runs.second[i];
      fmt::format_to(std::back_inserter(csv), ",{},{}", runs.runs[i], second);
    }
    csv += "\n";
  }
  return csv;
}

class RunsCommand : public ::testing::Test {
 protected:
  Outcome moments(const std::vector<std::string>& arguments, const std::string& engine = "model") const {
    std::vector<std::string> all{"moments", "--out", "out.csv", "--engine", engine};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run_program(SELFPROJ_SIM_PROGRAM, all, folder_.path());
  }
  Outcome lines(const std::vector<std::string>& arguments) const {
    std::vector<std::string> all{"lines"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run_program(SELFPROJ_PROGRAM, all, folder_.path());
  }
  void save(const std::string& name, const cv::Mat& image) const {
    ASSERT_TRUE(cv::imwrite((folder_ / name).string(), image));
  }
  std::string table() const { return read_text(folder_ / "out.csv"); }
  void refused(const std::vector<std::string>& arguments, const std::string& reason) const {
    expect_refusal(moments(arguments), "", {reason});
  }

  ScratchFolder folder_;
};

TEST_F(RunsCommand, StrongestRunWithGapAndRows) {
  Random random(1);
  const cv::Mat image = random_image(random, 30, 23);
  save("a.png", image);
  for (const auto& [name, mode] :
       {std::pair{"binary", model::Mode::binary}, {"grey", model::Mode::grey}, {"grey-over", model::Mode::grey_over}}) {
    const model::Measure measure{.mode = mode,
                                 .threshold = 170,
                                 .select = model::Select::strongest,
                                 .gap = 2,
                                 .window = {.first = 4, .last = 27}};
    for (const char* engine : {"rtl", "hls", "model"}) {
      const Outcome outcome = moments(
          {"--select", "strongest", "--gap", "2", "--rows", "4..27", "--mode", name, "--threshold", "170", "a.png"},
          engine);
      EXPECT_EQ(outcome.status, 0) << outcome.err;
      EXPECT_NE(outcome.out.find("strongest, gap 2, rows 4..27"), std::string::npos) << outcome.out;
      EXPECT_EQ(table(), expected_csv(image, measure)) << engine;
    }
  }
  EXPECT_EQ(moments({"--rows", "4..27", "a.png"}).status, 0);
  EXPECT_EQ(table(), expected_csv(image, {.window = {.first = 4, .last = 27}}));
}

TEST_F(RunsCommand, PartTurnedAndWithoutItsBackground) {
  Random random(2);
  const cv::Mat with = random_image(random, 21, 33);
  const cv::Mat without = random_image(random, 21, 33);
  save("with.png", with);
  save("without.png", without);
  cv::Mat expected;
  cv::subtract(with, without, expected);
  expected = expected(cv::Rect(5, 2, 17, 12)).t();
  EXPECT_EQ(
      moments({"--threshold", "40", "--background", "without.png", "--roi", "17x12+5+2", "--transpose", "with.png"})
          .status,
      0);
  EXPECT_EQ(table(), expected_csv(expected.clone(), {.threshold = 40}));
}

TEST_F(RunsCommand, RedLessTheMeanOfGreenAndBlue) {
  Random random(3);
  const cv::Mat image = random_image(random, 9, 10, CV_8UC3);
  save("a.png", image);
  cv::Mat expected(image.rows, image.cols, CV_8UC1);
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      const auto& pixel = image.at<cv::Vec3b>(row, column);
      const double difference = pixel[2] - 0.5 * (pixel[0] + pixel[1]);
      expected.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(std::max(0.0, std::floor(difference + 0.5)));
    }
  }
  EXPECT_EQ(moments({"--channel", "red-difference", "--mode", "grey", "--threshold", "10", "a.png"}).status, 0);
  EXPECT_EQ(table(), expected_csv(expected, {.mode = model::Mode::grey, .threshold = 10}));
}

TEST_F(RunsCommand, RefusesWhatMakesNoSense) {
  save("a.png", cv::Mat(8, 12, CV_8UC1, cv::Scalar(200)));
  refused({"--rows", "5..4", "a.png"}, "--rows: is '5..4'");
  refused({"--rows", "0..4", "a.png"}, "--rows");
  refused({"--rows", "5-8", "a.png"}, "--rows");
  refused({"--gap", "1", "a.png"}, "--gap: goes only with --select strongest");
  refused({"--select", "strongest", "--gap", "4", "a.png"}, "--gap");
  refused({"--select", "second", "a.png"}, "--select");
  refused({"--roi", "8x8", "a.png"}, "--roi: is '8x8'");
  refused({"--roi", "8x8+5+0", "a.png"}, "a.png: is 12 x 8; --roi 8 x 8+5+0 is not within it");
  refused({"--background", "b.png", "a.png"}, "b.png");
}

TEST_F(RunsCommand, LinesLeaveOutAHotPixelAndMarkWhatIsAmbiguous) {
  cv::Mat image(40, 21, CV_8UC1, cv::Scalar(5));
  image.rowRange(10, 15) = 150;
  image.at<std::uint8_t>(32, 7) = 255;
  image.col(12).rowRange(30, 34) = 150;
  save("a.png", image);
  const Outcome outcome = lines({"--threshold", "60", "--out", "seen", "a.png"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(
      outcome.out,
      "1 image of 21 x 40, grey-over, threshold 60, strongest, gap 0\n21 columns with light, 1 ambiguous → seen\n");
  std::string expected = "frame,column,m0,m1,n,runs,second\n";
  for (int column = 1; column <= 21; ++column) {
    fmt::format_to(std::back_inserter(expected), "1,{},450,5850,5,{},{}\n", column, column == 8 || column == 13 ? 2 : 1,
                   column == 8    ? 6
                   : column == 13 ? 12
                                  : 0);
  }
  EXPECT_EQ(read_text(folder_ / "seen/moments.csv"), expected);
  const cv::Mat picture = cv::imread((folder_ / "seen/frame_1.png").string());
  ASSERT_FALSE(picture.empty());
  int magenta = 0;
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      magenta += picture.at<cv::Vec3b>(row, column) == cv::Vec3b(255, 0, 220) ? 1 : 0;
    }
  }
  EXPECT_GT(magenta, 0);
  EXPECT_NE(read_text(folder_ / "seen/report.html").find("ambiguous columns"), std::string::npos);
  EXPECT_NE(read_text(folder_ / "seen/summary.json").find("\"ambiguous\": 1"), std::string::npos);
  const Outcome all = lines({"--threshold", "60", "--select", "all", "--out", "all", "a.png"});
  EXPECT_EQ(all.status, 0) << all.err;
  EXPECT_NE(read_text(folder_ / "all/moments.csv").find("1,8,645,"), std::string::npos);

  // Each image is judged by itself.
  EXPECT_EQ(outcome.err, "");
  save("dark.png", cv::Mat(40, 21, CV_8UC1, cv::Scalar(5)));
  save("bright.png", cv::Mat(40, 21, CV_8UC1, cv::Scalar(200)));
  const auto doubts = [&](const std::vector<std::string>& images) {
    std::vector<std::string> words{"--threshold", "60", "--out", "doubts"};
    words.insert(words.end(), images.begin(), images.end());
    return lines(words).err;
  };
  EXPECT_EQ(doubts({"a.png", "dark.png"}),
            "selfproj: dark.png: warning: no column has a pixel above the threshold of 60\n");
  EXPECT_EQ(doubts({"a.png", "dark.png", "dark.png"}),
            "selfproj: dark.png: warning: no column has a pixel above the threshold of 60; so in 2 of the 3 images\n");
  EXPECT_NE(read_text(folder_ / "doubts/summary.json").find("\"dark.png: no column has"), std::string::npos);
  EXPECT_NE(read_text(folder_ / "doubts/report.html").find("dark.png: no column has"), std::string::npos);
  EXPECT_EQ(doubts({"dark.png", "dark.png"}),
            "selfproj: dark.png to dark.png: warning: no column has a pixel above the threshold of 60\n");
  EXPECT_EQ(
      doubts({"a.png", "bright.png"})
          .find("selfproj: bright.png: warning: most columns with light have more than 16 lit rows, which is likely"),
      0U);
}

// The whole way: scene, board, packets, driver, profiles. A stream of another select is refused.
TEST_F(RunsCommand, PacketsOfTheStrongestRunAreInspected) {
  const auto run = [&](const std::string& program, const std::vector<std::string>& arguments) {
    return run_program(program, arguments, folder_.path());
  };
  const Outcome sent =
      run(SELFPROJ_SIM_PROGRAM, {"cosim", "--engine", "rtl", "--first", "700", "--count", "3", "--select", "strongest",
                                 "--gap", "1", "--packets", "p", "--out", "sim"});
  ASSERT_EQ(sent.status, 0) << sent.err;
  EXPECT_NE(sent.out.find("matched 1536 columns in 3 frames, 0 mismatches"), std::string::npos) << sent.out;
  const Outcome seen =
      run(SELFPROJ_PROGRAM, {"inspect", "--device", "file:p", "--select", "strongest", "--out", "seen", "--check"});
  ASSERT_EQ(seen.status, 0) << seen.err;
  const std::string table = read_text(folder_ / "seen/moments.csv");
  EXPECT_EQ(table.rfind("frame,column,m0,m1,n,runs,second\n", 0), 0U);
  EXPECT_EQ(read_text(folder_ / "sim/moments.csv"), table);
  const std::string summary = read_text(folder_ / "seen/summary.json");
  EXPECT_NE(summary.find("\"select\": \"strongest\""), std::string::npos);
  EXPECT_NE(summary.find("\"ambiguous\": "), std::string::npos);
  const Outcome other = run(SELFPROJ_PROGRAM, {"inspect", "--device", "file:p", "--select", "all"});
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.err.find("file:p: its packets are of strongest, not of --select all"), std::string::npos)
      << other.err;
}

}  // namespace
}  // namespace selfproj::test
