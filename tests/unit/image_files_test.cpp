
#include "host/images/image_files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/images/image_decoder.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "tests/cli/program.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

// Bright on the left and wider than high, so that a turn shows.
cv::Mat picture() {
  cv::Mat mat(40, 64, CV_8UC1);
  for (int r = 0; r < mat.rows; ++r) {
    for (int c = 0; c < mat.cols; ++c) {
      mat.at<std::uint8_t>(r, c) = static_cast<std::uint8_t>(255 - 3 * c - r);
    }
  }
  return mat;
}

std::string encoded(const char* extension) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(extension, picture(), bytes);
  return {bytes.begin(), bytes.end()};
}

// Runs in a separate process, whose limits and descriptors it may change.
bool holds_in_child(const std::function<bool()>& what) {
  const pid_t child = fork();
  if (child == 0) {
    _exit(what() ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status == 0;
}

bool is_refused(const std::string& file) {
  return error_of([&] { images::read_image(file, std::nullopt); }) != "none";
}

// Messages of libjpeg are noticed whether or not they can be written.
TEST(ImageFiles, DamageIsSeenWithoutADisk) {
  const ScratchFolder scratch;
  const std::string whole = encoded(".jpg");
  write_text(scratch / "cut.jpg", whole.substr(0, whole.size() / 2));
  write_text(scratch / "whole.jpg", whole);
  const std::string cut = scratch / "cut.jpg";
  EXPECT_FALSE(is_refused(scratch / "whole.jpg"));
  EXPECT_TRUE(is_refused(cut));
  EXPECT_TRUE(holds_in_child([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit none{0, 0};
    return setrlimit(RLIMIT_FSIZE, &none) == 0 && is_refused(cut);
  })) << "no file may be written";
  EXPECT_TRUE(holds_in_child([&] {
    close(STDERR_FILENO);
    return is_refused(cut) && !is_refused(scratch / "whole.jpg");
  })) << "standard error is closed";
}

// The tag of TIFF (LibTIFF writes it at the end of the file's directory) is ignored, as that of JPEG is.
TEST(ImageFiles, TheOrientationThatAFileNotesIsIgnored) {
  const ScratchFolder scratch;
  std::string bytes = encoded(".tiff");
  const images::Image upright = [&] {
    write_text(scratch / "a.tiff", bytes);
    return images::read_image(scratch / "a.tiff", std::nullopt);
  }();
  ASSERT_EQ(upright.columns, 64);
  // The entry for the software, which OpenCV does not need, becomes one for the orientation: 6, turned to the right.
  const std::string tag("\x1C\x01\x03\x00\x01\x00\x00\x00", 8);  // planar configuration, SHORT, one
  const std::size_t at = bytes.find(tag);
  ASSERT_NE(at, std::string::npos);
  const auto patched = std::string("\x12\x01\x03\x00\x01\x00\x00\x00\x06\x00\x00\x00", 12);
  bytes.replace(at, patched.size(), patched);
  ASSERT_NE(images::image_header(bytes)->orientation_at, 0U);
  write_text(scratch / "b.tiff", bytes);
  const images::Image turned = images::read_image(scratch / "b.tiff", std::nullopt);
  EXPECT_EQ(turned.columns, 64);
  EXPECT_EQ(turned.pixels, upright.pixels);
}

// Each page of a TIFF is an image, of 8 and of 16 bits; whoever takes one image a file refuses such a file.
TEST(ImageFiles, PagesOfATiffAreImages) {
  const ScratchFolder scratch;
  const std::string file = scratch / "pages.tiff";
  std::vector<cv::Mat> pages;
  for (const int less : {0, 1, 7}) {
    pages.push_back(picture() - less);
  }
  ASSERT_TRUE(cv::imwritemulti(file, pages));
  cv::Mat deep;
  picture().convertTo(deep, CV_16UC1, 16);  // 12 bits
  const std::string deep_file = scratch / "deep.tiff";
  ASSERT_TRUE(cv::imwritemulti(deep_file, std::vector<cv::Mat>{deep, deep - 160}));
  const std::string single = scratch / "single.tiff";
  write_text(single, encoded(".tiff"));
  EXPECT_NE(error_of([&] { images::read_image(file, std::nullopt); }).find("several images"), std::string::npos);

  images::ImagePages images({file, single, deep_file});
  ASSERT_EQ(images.count(), 6U);
  EXPECT_EQ(images.names()[1], file + ": page 2");
  EXPECT_EQ(images.names()[3], single);
  for (const auto& [place, less] : std::vector<std::pair<std::size_t, int>>{{2, 7}, {0, 0}, {1, 1}, {3, 0}}) {
    const images::Image image = images.read(place, std::nullopt);
    const cv::Mat expected = picture() - less;
    EXPECT_EQ(image.pixels, std::vector<std::uint8_t>(expected.begin<std::uint8_t>(), expected.end<std::uint8_t>()))
        << place;
  }
  const images::PixelRule twelve_bits(std::nullopt, 4);
  const cv::Mat expected = picture() - 10;
  EXPECT_EQ(images.read(5, twelve_bits).pixels,
            std::vector<std::uint8_t>(expected.begin<std::uint8_t>(), expected.end<std::uint8_t>()));
  EXPECT_NE(error_of([&] { static_cast<void>(images.read(4, std::nullopt)); }).find("deep.tiff: page 1"),
            std::string::npos);

  // A file that was cut short has no pages, or they are damaged.
  const std::string bytes = read_text(file);
  for (const double share : {0.2, 0.6, 0.99}) {
    const std::string cut = scratch / "cut.tiff";
    write_text(cut, bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
    EXPECT_NE(error_of([&] {
                images::ImagePages damaged({cut});
                for (std::size_t i = 0; i < damaged.count(); ++i) {
                  static_cast<void>(damaged.read(i, std::nullopt));
                }
              }),
              "none")
        << share;
  }
}

// All bits of a pixel, for rigs that measure more than 8.
TEST(ImageFiles, PixelsOfMoreBitsAreTakenAsTheyAre) {
  const ScratchFolder scratch;
  cv::Mat deep;
  picture().convertTo(deep, CV_16UC1, 16, 3);  // at most 4083
  const auto file_of = [&](const char* name, const cv::Mat& mat) {
    std::string file = scratch / name;
    EXPECT_TRUE(cv::imwrite(file, mat));
    return file;
  };
  images::ImagePages images(
      {file_of("twelve.png", deep), file_of("left.png", deep * 16), file_of("eight.png", picture())});
  images::PixelRule rule;
  rule.bits = 12;
  const std::vector<std::uint16_t> expected(deep.begin<std::uint16_t>(), deep.end<std::uint16_t>());
  EXPECT_EQ(images.read_wide(0, rule).pixels, expected);
  EXPECT_NE(error_of([&] { static_cast<void>(images.read_wide(1, rule)); }).find("pixels of 12 bits are expected"),
            std::string::npos);
  EXPECT_NE(
      error_of([&] {
        static_cast<void>(images.read_wide(2, rule));
      }).find("has values up to 255; pixels of 12 bits are expected, up to 4095, as measure.pixel_bits of the rig"),
      std::string::npos);
  rule.shift = 4;
  EXPECT_EQ(images.read_wide(1, rule).pixels, expected);
  // A file that says its largest value must say that of the rig's bits, shifted or not.
  const auto pgm = [&](int maximum) {
    const std::string file = scratch / (std::to_string(maximum) + ".pgm");
    write_text(file, "P5 1 1 " + std::to_string(maximum) + " " + std::string{'\x0A', '\x40'});
    return images::ImagePages({file});
  };
  rule.shift = std::nullopt;
  EXPECT_EQ(pgm(4095).read_wide(0, rule).pixels, std::vector<std::uint16_t>{0x0A40});
  EXPECT_NE(error_of([&] { static_cast<void>(pgm(4000).read_wide(0, rule)); }).find("has values up to 4000;"),
            std::string::npos);
  EXPECT_NE(error_of([&] {
              static_cast<void>(pgm(65535).read_wide(0, rule));
            }).find("--shift 4 takes values that are shifted up"),
            std::string::npos);
  rule.shift = 4;
  EXPECT_EQ(pgm(65535).read_wide(0, rule).pixels, std::vector<std::uint16_t>{0x00A4});
  EXPECT_NE(error_of([&] { static_cast<void>(pgm(4095).read_wide(0, rule)); }).find("with --shift 4 up to 255;"),
            std::string::npos);
  rule = {};
  rule.bits = 10;
  EXPECT_NE(error_of([&] { static_cast<void>(images.read_wide(0, rule)); }).find("twelve.png: has a value of 4"),
            std::string::npos);
}

TEST(ImageFiles, DifferencesAreOfOnePlaneAndTheOthers) {
  const ScratchFolder scratch;
  const std::string file = scratch / "colours.png";
  cv::Mat image(1, 3, CV_8UC3);
  image.at<cv::Vec3b>(0, 0) = {10, 40, 201};  // blue, green, red
  image.at<cv::Vec3b>(0, 1) = {10, 200, 41};
  image.at<cv::Vec3b>(0, 2) = {255, 0, 0};
  ASSERT_TRUE(cv::imwrite(file, image));
  using Pixels = std::vector<std::uint8_t>;
  EXPECT_EQ(images::read_image(file, images::Channel::red_difference).pixels, (Pixels{176, 0, 0}));
  EXPECT_EQ(images::read_image(file, images::Channel::green_difference).pixels, (Pixels{0, 175, 0}));
  EXPECT_EQ(images::read_image(file, images::Channel::blue_difference).pixels, (Pixels{0, 0, 255}));
}

TEST(ImageFiles, HeadersSayTheSize) {
  for (const char* extension : {".png", ".jpg", ".tiff", ".bmp", ".pgm"}) {
    const auto header = images::image_header(encoded(extension));
    ASSERT_TRUE(header) << extension;
    EXPECT_EQ(header->columns, 64U) << extension;
    EXPECT_EQ(header->rows, 40U) << extension;
  }
}

// A few bytes that would unpack to gigabytes are refused before unpacking.
TEST(ImageFiles, HugeImagesAreRefusedByTheirHeaders) {
  const ScratchFolder scratch;
  std::string png = encoded(".png");
  png.replace(16, 8, std::string("\x00\x00\xFF\xFF\x00\x00\xFF\xFF", 8));
  write_text(scratch / "huge.png", png);
  const std::string error = error_of([&] { images::read_image(scratch / "huge.png", std::nullopt); });
  EXPECT_NE(error.find("65535 x 65535 pixels"), std::string::npos) << error;
}

TEST(FloatImage, ComesBackFromTiffWithItsGaps) {
  const ScratchFolder folder;
  images::FloatImage image(3, 5);
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    image.values[i] = 0.1F * static_cast<float>(i) - 1e6F;
  }
  image.row(1)[2] = std::numeric_limits<float>::quiet_NaN();
  const std::string file = folder / "a.tiff";
  images::write_float_tiff(file, image);
  const images::FloatImage read = images::read_float_tiff(file);
  ASSERT_EQ(read.rows, 3);
  ASSERT_EQ(read.columns, 5);
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (i == 7) {
      EXPECT_TRUE(std::isnan(read.values[i]));
    } else {
      EXPECT_EQ(read.values[i], image.values[i]) << i;
    }
  }
}

TEST(FloatImage, OtherFilesAreRefused) {
  const ScratchFolder folder;
  EXPECT_THROW(images::read_float_tiff(folder / "none.tiff"), UserError);
  std::ofstream(folder / "grey.pgm") << "P2\n2 1\n255\n1 2\n";
  EXPECT_THROW(images::read_float_tiff(folder / "grey.pgm"), UserError);
  EXPECT_THROW(images::write_float_tiff(folder / "grey.pgm" / "a.tiff", images::FloatImage(1, 1)), UserError);
  EXPECT_THROW(images::write_float_tiff(folder / "empty.tiff", images::FloatImage()), UserError);
}

}  // namespace
}  // namespace selfproj::test
