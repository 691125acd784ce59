// Tests selfproj pattern from the command line.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/calibration/chessboard.h"
#include "host/images/image_files.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/reference_file.h"
#include "tests/cli/program.h"
#include "tests/cli/refusal.h"

namespace selfproj::test {
namespace {

Outcome pattern(const ScratchFolder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "pattern");
  return run_program(SELFPROJ_PROGRAM, arguments, folder.path());
}

const std::string kPlane = "y_mm,z_mm\n-80,1167\n80,1167\n";

// Bad input: expects status 2, one line that begins with this text, and nothing written.
void expect_pattern_refused(const ScratchFolder& folder, const Outcome& outcome, const std::string& begin) {
  expect_refusal(outcome, begin);
  for (const std::string& name : folder.names()) {
    EXPECT_NE(name, "out");
    EXPECT_FALSE(name.starts_with("."));
  }
}

TEST(PatternCommand, MakesAReferenceFolder) {
  const ScratchFolder folder;
  write_text(folder / "plane.csv", kPlane);
  const Outcome outcome = pattern(folder, {"--reference", "plane.csv", "--out", "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "out: reference in 512 of 512 columns\n");
  const rig::Rig rig = rig::load_rig("light-section");
  const std::string out = (folder / "out").string();
  const light_section::ReferenceProfile reference = light_section::load_reference(rig, out);
  EXPECT_NEAR(reference.z_mm[17], 1167, 1e-9);
  const images::FloatImage image = light_section::load_pattern(rig, out);
  const images::Image png = images::read_image(out + "/pattern.png", {});
  ASSERT_EQ(png.rows, 512);
  ASSERT_EQ(png.columns, 512);
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    ASSERT_EQ(png.pixels[i], std::lround(255 * image.values[i]));
  }
  EXPECT_GT(images::read_image(out + "/preview.png", images::Channel::grey).columns, 500);
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"out", "plane.csv"}));
  // Again into the same folder.
  EXPECT_EQ(pattern(folder, {"--reference", "plane.csv", "--out", "out"}).status, 0);
}

// A part that lies elsewhere: as if its section, or a finished reference, had been taken there.
TEST(PatternCommand, ForAPartThatLiesAcross) {
  const ScratchFolder folder;
  write_text(folder / "there.csv", "y_mm,z_mm\n-80,1167\n-30,1167\n10,1147\n20,1147\n20,1167\n80,1167\n");
  write_text(folder / "here.csv", "y_mm,z_mm\n-82.5,1167\n-32.5,1167\n7.5,1147\n17.5,1147\n17.5,1167\n77.5,1167\n");
  const auto made = [&](const std::vector<std::string>& arguments, const std::string& out) {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), {"--out", out});
    const Outcome outcome = pattern(folder, all);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return light_section::load_reference(rig::load_rig("light-section"), (folder / out).string());
  };
  const light_section::ReferenceProfile there = made({"--reference", "there.csv"}, "there");
  const light_section::ReferenceProfile by_section = made({"--reference", "here.csv", "--across", "2.5"}, "section");
  EXPECT_EQ(by_section.valid, there.valid);
  made({"--reference", "here.csv"}, "here");
  const light_section::ReferenceProfile by_folder = made({"--reference", "here", "--across", "2.5"}, "folder");
  int compared = 0;
  for (std::size_t i = 0; i < there.valid.size(); ++i) {
    if (there.valid[i] != 0) {
      EXPECT_NEAR(by_section.z_mm[i], there.z_mm[i], 1e-6) << i;  // as many digits as the file has
      if (by_folder.valid[i] != 0) {
        // Straight between the columns: the section's corners are cut by up to half a column, 0.12 mm of its slope.
        EXPECT_NEAR(by_folder.z_mm[i], there.z_mm[i], 0.06) << i;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, there.valid_columns() - 12);  // beside the wall
  const images::FloatImage pattern_there =
      light_section::load_pattern(rig::load_rig("light-section"), (folder / "there").string());
  EXPECT_EQ(light_section::load_pattern(rig::load_rig("light-section"), (folder / "section").string()).values,
            pattern_there.values);
}

TEST(PatternCommand, StraightLineAndSweep) {
  const ScratchFolder folder;
  ASSERT_EQ(pattern(folder, {"--line", "255.5", "--out", "line"}).status, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "line" / "pattern.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "line" / "reference.csv"));
  ASSERT_EQ(pattern(folder, {"--sweep", "--every", "64", "--out", "sweep"}).status, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "sweep" / "line_00064.png"));
  expect_pattern_refused(folder, pattern(folder, {"--line", "512", "--out", "out"}), "--line: is 512");
}

TEST(PatternCommand, GraySequence) {
  const ScratchFolder folder;
  const Outcome outcome = pattern(folder, {"gray", "--projector", "5x3", "--out", "gray"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "gray: 12 patterns of 5x3: 3 bits for columns, 2 for rows, white, black\n");
  const images::Image second =
      images::read_image((folder / "gray" / "pattern_01.png").string(), {});  // bit 2 of 0..4, inverse
  EXPECT_EQ(second.pixels,
            (std::vector<std::uint8_t>{255, 255, 255, 255, 0, 255, 255, 255, 255, 0, 255, 255, 255, 255, 0}));
  const images::Image rows = images::read_image((folder / "gray" / "pattern_08.png").string(), {});  // bit 0 of 0, 1, 3
  EXPECT_EQ(rows.pixels, (std::vector<std::uint8_t>{0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255}));
  EXPECT_TRUE(std::filesystem::exists(folder / "gray" / "pattern_11.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "gray" / "pattern_12.png"));
  // The rig's lines are the rows.
  ASSERT_EQ(pattern(folder, {"gray", "--rig", "light-section", "--out", "rig"}).status, 0);
  EXPECT_EQ(images::read_image((folder / "rig" / "pattern_37.png").string(), {}).rows, 512);
  expect_pattern_refused(folder, pattern(folder, {"gray", "--projector", "5x", "--out", "out"}),
                         "--projector: is '5x'");
  expect_pattern_refused(folder, pattern(folder, {"gray", "--projector", "0x5", "--out", "out"}),
                         "--projector: is '0x5'");
  expect_pattern_refused(folder, pattern(folder, {"gray", "--out", "out"}),
                         "--projector, --rig: exactly one of them is needed");
  expect_pattern_refused(folder, pattern(folder, {"gray", "--projector", "4x4"}), "--out");
}

// The print as an image of 60 dots an inch, the whole sheet.
images::Image printed(const ScratchFolder& folder, const std::string& file) {
  const Outcome outcome = run_program("/usr/bin/rsvg-convert",
                                      {"--dpi-x", "60", "--dpi-y", "60", "--output", "print.png", file}, folder.path());
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return images::read_image((folder / "print.png").string(), images::Channel::grey);
}

// Calibration finds the board in its print, with squares of the size that is written on it, in the middle of the paper.
TEST(PatternCommand, ChessboardIsFoundInItsPrint) {
  if (!std::filesystem::exists("/usr/bin/rsvg-convert")) {
    GTEST_SKIP() << "librsvg2-bin is not installed";
  }
  struct Case {
    std::vector<std::string> arguments;
    calibration::Chessboard board;
    double width_mm, height_mm;
    std::string text;
  };
  const std::vector<Case> cases = {
      {{}, {9, 6, 25}, 297, 210, "9 x 6 inner corners, squares of 25 mm, 250 x 175 mm in all"},
      {{"--paper", "A3", "--chessboard", "11x14", "--square", "12.5"},
       {14, 11, 12.5},
       420,
       297,
       "14 x 11 inner corners, squares of 12.5 mm, 187.5 x 150 mm in all"},
  };
  for (const Case& one : cases) {
    const ScratchFolder folder;
    std::vector<std::string> arguments = {"chessboard", "--out", "board.svg"};
    arguments.insert(arguments.end(), one.arguments.begin(), one.arguments.end());
    const Outcome outcome = pattern(folder, arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(read_text(folder / "board.svg").find(one.text), std::string::npos);
    const images::Image sheet = printed(folder, "board.svg");
    constexpr double kDotsPerMm = 60 / 25.4;
    EXPECT_NEAR(sheet.columns, one.width_mm * kDotsPerMm, 1);
    EXPECT_NEAR(sheet.rows, one.height_mm * kDotsPerMm, 1);
    const calibration::FoundChessboard found = calibration::find_chessboard(sheet, one.board);
    ASSERT_EQ(found.corners.size(), static_cast<std::size_t>(one.board.corners())) << found.reason;
    const cv::Point2d along = found.corners.back() - found.corners.front();
    const double diagonal = one.board.square_mm * std::hypot(one.board.columns - 1, one.board.rows - 1);
    EXPECT_NEAR(std::hypot(along.x, along.y) / diagonal, kDotsPerMm, 1e-3 * kDotsPerMm);
    const cv::Point2d middle = 0.5 * (found.corners.back() + found.corners.front());
    EXPECT_NEAR(middle.x, 0.5 * (sheet.columns - 1), 1);
    EXPECT_NEAR(middle.y, 0.5 * (sheet.rows - 1), 1);
  }
}

TEST(PatternCommand, ChessboardThatDoesNotFit) {
  const ScratchFolder folder;
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& begin) {
    std::vector<std::string> words = {"chessboard", "--out", "out"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    expect_pattern_refused(folder, pattern(folder, words), begin);
  };
  refused({"--square", "26"}, "--square: 26 mm is too large; on A4 the squares of 9x6 can have 25 mm");
  refused({"--chessboard", "9x2"}, "--chessboard: is 9x2; calibration needs 3 inner corners along both sides");
  refused({"--chessboard", "200x200"}, "--chessboard: 200x200 is too many corners for A4");
  refused({"--paper", "B5"}, "--paper: ");
}

TEST(PatternCommand, WrongInputIsOneLine) {
  const ScratchFolder folder;
  write_text(folder / "plane.csv", kPlane);
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& begin) {
    SCOPED_TRACE(begin);
    expect_pattern_refused(folder, pattern(folder, arguments), begin);
  };
  refused({"--reference", "none.csv", "--out", "out"}, "none.csv: ");
  refused({"--reference", "plane.csv", "--out", "plane.csv/out"}, "plane.csv/out: plane.csv is not a folder");
  refused({"--reference", "plane.csv", "--out", "plane.csv"}, "plane.csv: exists and is not a folder");
  refused({"--reference", "plane.csv", "--frame", "1", "--out", "out"}, "plane.csv: is not a TIFF file");
  refused({"--reference", "plane.csv", "--scan", ".", "--out", "out"}, "");
  refused({"--out", "out"}, "");
  refused({"--reference", "plane.csv"}, "--out");
  write_text(folder / "away.csv", "y_mm,z_mm\n-80,3000\n80,3000\n");
  refused({"--reference", "away.csv", "--out", "out"},
          "away.csv: no camera column sees the part in the projector's light");
  images::write_float_tiff((folder / "narrow.tiff").string(), images::FloatImage(1, 500));
  refused({"--reference", "narrow.tiff", "--out", "out"}, "narrow.tiff: has 500 columns; the rig's camera has 512");
  write_text(folder / "rig.yaml", "name: mine\n");
  refused({"--rig", "rig.yaml", "--reference", "plane.csv", "--out", "out"}, "rig.yaml: ");
  std::filesystem::create_directory(folder / "images");
  refused({"--scan", "images", "--out", "out"}, "images: contains no images");
  write_text(folder / "images" / "a.pgm", "P2\n2 1\n255\n1 2\n");
  refused({"--scan", "images", "--out", "out"}, "images: has 1 images; a sweep of this rig with --every 1 has 508");
  refused({"--reference", "plane.csv", "--residual", "images", "--out", "out"}, "images/a.pgm: has 1 x 2 pixels");
  refused({"--reference", "images", "--out", "out"}, "--reference: images is a finished reference; give --residual");
  refused({"--line", "3", "--across", "1", "--out", "out"}, "");
  refused({"--reference", "plane.csv", "--across", "-500", "--out", "out"}, "--across: is -500 mm: there the camera");
}

// Images in which the line wanders are not those of one part that stands still.
TEST(PatternCommand, ResidualsOfAMovingPartAreRefused) {
  const ScratchFolder folder;
  write_text(folder / "plane.csv", kPlane);
  std::filesystem::create_directory(folder / "moving");
  for (const int row : {40, 50}) {
    images::Image image{96, 512, std::vector<std::uint8_t>(std::size_t{96} * 512, 5)};
    std::fill_n(image.pixels.begin() + std::ptrdiff_t{512} * row, 5 * 512, std::uint8_t{200});
    write_text(folder / "moving" / (std::to_string(row) + ".png"), images::encode_png(image));
  }
  const std::vector<std::string> arguments = {"--reference", "plane.csv", "--residual", "moving", "--out", "out"};
  const Outcome refused = pattern(folder, arguments);
  EXPECT_EQ(refused.status, 1);
  EXPECT_TRUE(refused.err.starts_with("selfproj: moving: in 512 of 512 columns the line moves by more than 0.4 rows"))
      << refused.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  std::vector<std::string> unchecked = arguments;
  unchecked.emplace_back("--unchecked");
  const Outcome told = pattern(folder, unchecked);
  EXPECT_EQ(told.status, 0) << told.err;
  EXPECT_NE(told.err.find("warning: in 512 of 512 columns"), std::string::npos) << told.err;
}

}  // namespace
}  // namespace selfproj::test
