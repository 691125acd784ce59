// Tests the contract of `selfproj-sim moments`.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "tests/cli/program.h"
#include "tests/cli/random_image.h"
#include "tests/cli/refusal.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOldText = "an older table\n";

// The expected table, from the definition of the moments.
std::string expected_csv(const std::vector<cv::Mat>& frames, model::Mode mode, int threshold) {
  std::string csv = "frame,column,m0,m1,n\n";
  for (std::size_t frame = 0; frame < frames.size(); ++frame) {
    const cv::Mat& image = frames[frame];
    const model::ImageView view{image.data, image.rows, image.cols, static_cast<std::ptrdiff_t>(image.step[0])};
    model::Moments moments;
    moments.resize(image.cols);
    model::column_moments(view, mode, threshold, moments.view());
    for (std::size_t i = 0; i < moments.n.size(); ++i) {
      fmt::format_to(std::back_inserter(csv), "{},{},{},{},{}\n", frame + 1, i + 1, moments.m0[i], moments.m1[i],
                     moments.n[i]);
    }
  }
  return csv;
}

// Both are long, so print only where they differ.
::testing::AssertionResult equal_text(const std::string& found, const std::string& expected) {
  const auto [a, b] = std::mismatch(found.begin(), found.end(), expected.begin(), expected.end());
  if (a == found.end() && b == expected.end()) {
    return ::testing::AssertionSuccess();
  }
  return ::testing::AssertionFailure() << "differs in line " << std::count(found.begin(), a, '\n') + 1 << " of "
                                       << std::count(found.begin(), found.end(), '\n') << ", expected "
                                       << std::count(expected.begin(), expected.end(), '\n') << " lines";
}

class MomentsCommand : public ::testing::Test {
 protected:
  // Runs selfproj-sim with these arguments in the scratch folder.
  Outcome run(const std::vector<std::string>& arguments) const {
    return run_program(SELFPROJ_SIM_PROGRAM, arguments, folder_.path());
  }

  // Runs its subcommand moments into out.csv.
  Outcome moments(const std::vector<std::string>& arguments) const {
    std::vector<std::string> all{"moments", "--engine", "model", "--out", "out.csv"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run(all);
  }

  void save(const std::string& name, const cv::Mat& image) const {
    ASSERT_TRUE(cv::imwrite((folder_ / name).string(), image));
  }

  // Saves an image and cuts the file short.
  void save_truncated(const std::string& name, const cv::Mat& image) const {
    save(name, image);
    fs::resize_file(folder_ / name, fs::file_size(folder_ / name) / 2);
  }

  std::string table() const { return read_text(folder_ / "out.csv"); }

  // Expects a failure as in the contract: status 2, one line that begins with the program's name and `subject`, nothing
  // on stdout, and an older table unchanged, with only `names` beside it.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& subject,
                      const std::string& reason) const {
    const std::vector<std::string> before = folder_.names();
    for (const bool existing : {false, true}) {
      if (existing) {
        write_text(folder_ / "out.csv", kOldText);
      }
      expect_refusal(moments(arguments), subject + ": ", {reason});
      if (existing) {
        EXPECT_EQ(table(), kOldText);
        fs::remove(folder_ / "out.csv");
      }
      EXPECT_EQ(folder_.names(), before);
    }
  }

  ScratchFolder folder_;
};

// ------------------------------------------------------------------ results, for each engine of this build

class MomentsByEngine : public MomentsCommand, public ::testing::WithParamInterface<std::string> {
 protected:
  // Runs the engine on these frames in one mode and compares the table with the definition.
  void expect_right(const std::vector<cv::Mat>& frames, const std::string& mode, int threshold) const {
    std::vector<std::string> arguments{"moments",  "--out",       "out.csv",
                                       "--engine", GetParam(),    "--mode",
                                       mode,       "--threshold", std::to_string(threshold)};
    for (std::size_t i = 0; i < frames.size(); ++i) {
      arguments.push_back(fmt::format("frame{:03}.pgm", i));
      save(arguments.back(), frames[i]);
    }
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.out,
              fmt::format("{} {} of {} x {}, engine {}, {}, threshold {}: {} columns → out.csv\n", frames.size(),
                          frames.size() == 1 ? "frame" : "frames", frames[0].cols, frames[0].rows, GetParam(), mode,
                          threshold, frames.size() * static_cast<std::size_t>(frames[0].cols)));
    const model::Mode weight = mode == "binary" ? model::Mode::binary
                               : mode == "grey" ? model::Mode::grey
                                                : model::Mode::grey_over;
    EXPECT_TRUE(equal_text(table(), expected_csv(frames, weight, threshold)));
  }
};

struct EngineName {
  std::string operator()(const ::testing::TestParamInfo<std::string>& engine) const { return engine.param; }
};
const std::vector<std::string> kEngines{
    "model",
    "hls",
#ifdef SELFPROJ_HAS_RTL_ENGINE
    "rtl",
#endif
};
INSTANTIATE_TEST_SUITE_P(Engine, MomentsByEngine, ::testing::ValuesIn(kEngines), EngineName());

TEST_F(MomentsCommand, EachPageOfATiffIsAFrame) {
  Random random(1);
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 3; ++i) {
    frames.push_back(random_image(random, 5, 8));
  }
  ASSERT_TRUE(cv::imwritemulti((folder_ / "a.tiff").string(), std::vector<cv::Mat>(frames.begin(), frames.end() - 1)));
  save("b.pgm", frames.back());
  const Outcome outcome = moments({"a.tiff", "b.pgm", "--mode", "grey", "--threshold", "0"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(equal_text(table(), expected_csv(frames, model::Mode::grey, 0)));
}

TEST_P(MomentsByEngine, RandomImagesGiveWhatTheDefinitionGives) {
  for (const std::uint64_t seed : seeds(6)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(1, 40);
    const int columns = random.between(1, 120);  // padded where the circuit needs it
    std::vector<cv::Mat> frames;
    for (int i = random.between(1, 4); i > 0; --i) {
      frames.push_back(random_image(random, rows, columns));
    }
    for (const std::string mode : {"binary", "grey", "grey-over"}) {
      expect_right(frames, mode, random.between(0, 255));
    }
  }
}

TEST_P(MomentsByEngine, SmallestImage) {
  expect_right({cv::Mat(1, spec::kPixelsPerBeat, CV_8UC1, cv::Scalar(200))}, "grey", 0);
}

TEST_P(MomentsByEngine, LargestImageAllWhiteReachesTheLargestSums) {
  const cv::Mat white(spec::kMaxRows, spec::kMaxColumns, CV_8UC1, cv::Scalar(255));
  for (const std::string mode : {"binary", "grey", "grey-over"}) {
    expect_right({white}, mode, 0);
  }
}

TEST_P(MomentsByEngine, LargestImageAtRandom) {
  Random random(1);
  expect_right({random_image(random, spec::kMaxRows, spec::kMaxColumns)}, "grey-over", 100);
}

// More frames than are handed to an engine at once.
TEST_P(MomentsByEngine, ManyFramesKeepTheirNumbers) {
  Random random(1);
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 150; ++i) {
    frames.push_back(random_image(random, 3, 8));
  }
  expect_right(frames, "binary", 128);
}

// ------------------------------------------------------------------ defaults and channels

TEST_F(MomentsCommand, ThresholdIs128AndModeBinaryUnlessSaid) {
  Random random(1);
  const cv::Mat image = random_image(random, 20, 16);
  save("a.png", image);
  EXPECT_EQ(moments({"a.png"}).status, 0);
  EXPECT_EQ(table(), expected_csv({image}, model::Mode::binary, 128));
}

TEST_F(MomentsCommand, ChannelTakesAPlaneOrTheLuminance) {
  Random random(1);
  const cv::Mat image = random_image(random, 20, 16, CV_8UC3);
  cv::Mat planes[3];  // NOLINT(*-avoid-c-arrays): cv::split wants it
  cv::split(image, planes);
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::Mat with_alpha;
  cv::cvtColor(image, with_alpha, cv::COLOR_BGR2BGRA);
  save("three.png", image);
  save("four.png", with_alpha);
  const std::vector<std::pair<std::string, cv::Mat>> channels{
      {"red", planes[2]}, {"green", planes[1]}, {"blue", planes[0]}, {"grey", grey}};
  for (const auto& [channel, plane] : channels) {
    for (const std::string file : {"three.png", "four.png"}) {
      SCOPED_TRACE(fmt::format("{} of {}", channel, file));
      EXPECT_EQ(moments({"--channel", channel, "--mode", "grey", file}).status, 0);
      EXPECT_TRUE(equal_text(table(), expected_csv({plane}, model::Mode::grey, 128)));
    }
  }
}

TEST_F(MomentsCommand, ImageOfOneChannelIsItsOwnGrey) {
  Random random(1);
  const cv::Mat image = random_image(random, 20, 16);
  save("a.png", image);
  EXPECT_EQ(moments({"--channel", "grey", "a.png"}).status, 0);
  EXPECT_EQ(table(), expected_csv({image}, model::Mode::binary, 128));
}

TEST_F(MomentsCommand, ImageOfOneChannelHasNoColour) {
  save("a.png", cv::Mat(4, 8, CV_8UC1, cv::Scalar(9)));
  for (const std::string colour : {"red", "green", "blue"}) {
    expect_refused({"--channel", colour, "a.png"}, "a.png", "--channel " + colour);
  }
}

TEST_F(MomentsCommand, ColourImageNeedsAChannel) {
  save("a.png", cv::Mat(4, 8, CV_8UC3, cv::Scalar(9, 8, 7)));
  expect_refused({"a.png"}, "a.png", "--channel");
}

// ------------------------------------------------------------------ images that are refused

TEST_F(MomentsCommand, ColumnsAndRowsHaveAMaximum) {
  save("wide.pgm", cv::Mat(1, spec::kMaxColumns + 1, CV_8UC1, cv::Scalar(9)));
  const Outcome outcome = run({"moments", "--engine", "hls", "--out", "out.csv", "wide.pgm"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("wide.pgm: has 2052 columns"), std::string::npos) << outcome.err;
  save("high.pgm", cv::Mat(spec::kMaxRows + 1, 4, CV_8UC1, cv::Scalar(9)));
  expect_refused({"high.pgm"}, "high.pgm", "1024 rows");
  EXPECT_EQ(moments({"wide.pgm"}).status, 0) << "the model takes any width";
}

TEST_F(MomentsCommand, PixelsMustHave8Bits) {
  save("a16.png", cv::Mat(4, 8, CV_16UC1, cv::Scalar(9)));
  expect_refused({"a16.png"}, "a16.png", "16 bits");
  save("a32.tiff", cv::Mat(4, 8, CV_32FC1, cv::Scalar(9)));
  expect_refused({"a32.tiff"}, "a32.tiff", "floating-point numbers");
}

TEST_F(MomentsCommand, AllImagesMustHaveOneSize) {
  save("a.pgm", cv::Mat(4, 8, CV_8UC1, cv::Scalar(9)));
  save("b.pgm", cv::Mat(4, 8, CV_8UC1, cv::Scalar(9)));
  save("c.pgm", cv::Mat(5, 8, CV_8UC1, cv::Scalar(9)));
  expect_refused({"a.pgm", "b.pgm", "c.pgm"}, "c.pgm", "is 8 x 5, but a.pgm is 8 x 4");
}

TEST_F(MomentsCommand, UnreadableFileIsNamed) {
  save("a.pgm", cv::Mat(4, 8, CV_8UC1, cv::Scalar(9)));
  expect_refused({"a.pgm", "missing.png"}, "missing.png", "No such file or directory");
  fs::create_directory(folder_ / "folder");
  expect_refused({"folder"}, "folder", "is a folder");
}

TEST_F(MomentsCommand, FileThatIsNoImageIsNamed) {
  write_text(folder_ / "text.png", "not an image at all\n");
  expect_refused({"text.png"}, "text.png", "not an image");
  write_text(folder_ / "empty.png", "");
  expect_refused({"empty.png"}, "empty.png", "not an image");
}

// Image libraries fill up what is missing; a measurement must not.
TEST_F(MomentsCommand, TruncatedImageIsRefused) {
  Random random(1);
  const cv::Mat image = random_image(random, 64, 64);
  for (const std::string name : {"a.png", "a.jpg", "a.pgm", "a.bmp", "a.tiff"}) {
    SCOPED_TRACE(name);
    save_truncated(name, image);
    expect_refused({name}, name, "damaged");
  }
}

TEST_F(MomentsCommand, LineBreakInANameStaysOneLine) {
  const Outcome outcome = moments({"two\nlines.png"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err, "selfproj-sim: two lines.png: No such file or directory\n");
}

// ------------------------------------------------------------------ the output file

TEST_F(MomentsCommand, OutputThatCannotBeIsNamedBeforeTheWorkBegins) {
  save("a.pgm", cv::Mat(4, 8, CV_8UC1, cv::Scalar(9)));
  write_text(folder_ / "file", "a file\n");
  fs::create_directory(folder_ / "folder");
  const std::vector<std::pair<std::string, std::string>> cases{{"file/out.csv", "file is not a folder"},
                                                               {"file/missing/out.csv", "file is not a folder"},
                                                               {"folder", "Is a directory"}};
  const std::vector<std::string> before = folder_.names();
  for (const auto& [out, reason] : cases) {
    // The image is not even opened.
    const Outcome outcome = run({"moments", "--engine", "model", "--out", out, "no-such-image.pgm"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.err, fmt::format("selfproj-sim: {}: {}\n", out, reason));
    EXPECT_EQ(folder_.names(), before);
  }
}

TEST_F(MomentsCommand, OutputMustNotBeAnImage) {
  save("a.pgm", cv::Mat(4, 8, CV_8UC1, cv::Scalar(9)));
  const std::string before = read_text(folder_ / "a.pgm");
  const Outcome outcome = run({"moments", "--engine", "model", "--out", "./a.pgm", "a.pgm"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err, "selfproj-sim: ./a.pgm: is an input of this command, too; it would be overwritten\n");
  EXPECT_EQ(read_text(folder_ / "a.pgm"), before);
}

TEST_F(MomentsCommand, ExistingOutputIsReplacedAndKeepsItsPermissions) {
  const cv::Mat image(4, 8, CV_8UC1, cv::Scalar(200));
  save("a.pgm", image);
  write_text(folder_ / "out.csv", kOldText);
  const auto permissions = fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read;
  fs::permissions(folder_ / "out.csv", permissions);
  EXPECT_EQ(moments({"a.pgm"}).status, 0);
  EXPECT_EQ(table(), expected_csv({image}, model::Mode::binary, 128));
  EXPECT_EQ(fs::status(folder_ / "out.csv").permissions(), permissions);
  EXPECT_EQ(folder_.names(), (std::vector<std::string>{"a.pgm", "out.csv"}));
}

TEST_F(MomentsCommand, OutputFollowsALink) {
  save("a.pgm", cv::Mat(4, 8, CV_8UC1, cv::Scalar(200)));
  fs::create_directory(folder_ / "folder");
  write_text(folder_ / "folder/table.csv", kOldText);
  fs::create_symlink("folder/table.csv", folder_ / "out.csv");
  EXPECT_EQ(moments({"a.pgm"}).status, 0);
  EXPECT_TRUE(fs::is_symlink(folder_ / "out.csv"));
  EXPECT_NE(read_text(folder_ / "folder/table.csv"), kOldText);
}

// A file size limit takes the part of a full disk.
TEST_F(MomentsCommand, FailureInTheMiddleOfWritingLeavesEverythingAsItWas) {
  save("a.pgm", cv::Mat(4, spec::kMaxColumns, CV_8UC1, cv::Scalar(200)));
  write_text(folder_ / "out.csv", kOldText);
  const Outcome outcome = run_program("/bin/sh",
                                      {"-c", R"(trap '' XFSZ; ulimit -f 1; exec "$0" "$@")", SELFPROJ_SIM_PROGRAM,
                                       "moments", "--engine", "model", "--out", "out.csv", "a.pgm"},
                                      folder_.path());
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err, "selfproj-sim: out.csv: File too large\n");
  EXPECT_EQ(table(), kOldText);
  EXPECT_EQ(folder_.names(), (std::vector<std::string>{"a.pgm", "out.csv"}));
}

TEST_F(MomentsCommand, FullDeviceIsAnError) {
  save("a.pgm", cv::Mat(4, 8, CV_8UC1, cv::Scalar(200)));
  const Outcome outcome = run({"moments", "--engine", "model", "--out", "/dev/full", "a.pgm"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err, "selfproj-sim: /dev/full: No space left on device\n");
}

// ------------------------------------------------------------------ the command line

TEST_F(MomentsCommand, BadUsageIsOneLineAndStatus2) {
  save("a.pgm", cv::Mat(4, 8, CV_8UC1, cv::Scalar(9)));
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{}, "command"},
      {{"bogus"}, "bogus"},
      {{"moments"}, "--out"},
      {{"moments", "--out", "out.csv"}, "IMAGE"},
      {{"moments", "--out", "out.csv", "--bogus", "a.pgm"}, "--bogus"},
      {{"moments", "--out", "out.csv", "--mode", "sepia", "a.pgm"}, "--mode"},
      {{"moments", "--out", "out.csv", "--engine", "steam", "a.pgm"}, "--engine"},
      {{"moments", "--out", "out.csv", "--channel", "violet", "a.pgm"}, "--channel"},
      {{"moments", "--out", "out.csv", "--threshold", "256", "a.pgm"}, "--threshold"},
      {{"moments", "--out", "out.csv", "--threshold", "-1", "a.pgm"}, "--threshold"},
      {{"moments", "--out", "out.csv", "--threshold", "many", "a.pgm"}, "--threshold"},
  };
  for (const auto& [arguments, subject] : cases) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << subject;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err.rfind("selfproj-sim: ", 0), 0U) << outcome.err;
    EXPECT_NE(outcome.err.find(subject), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(folder_.names(), std::vector<std::string>{"a.pgm"});
  }
}

TEST_F(MomentsCommand, HelpIsEverywhereAndVersionNamesTheSpecification) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--help"}, {"moments", "--help"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.err, "");
    EXPECT_NE(outcome.out.find("Usage: selfproj-sim"), std::string::npos);
  }
  const Outcome outcome = run({"--version"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_NE(outcome.out.find(fmt::format("{}.{}", spec::kVersion >> 8U, spec::kVersion & 0xFFU)), std::string::npos);
  EXPECT_NE(outcome.out.find(fmt::format("0x{:08X}", spec::kHash)), std::string::npos);
}

}  // namespace
}  // namespace selfproj::test
