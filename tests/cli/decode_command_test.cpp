// Tests the contract of `selfproj-sim decode`.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "selfproj/model/gray_decoder.h"
#include "tests/cli/program.h"
#include "tests/cli/refusal.h"
#include "tests/support/random_cases.h"
#include "tests/support/reference_gray.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> engines() {
#ifdef SELFPROJ_HAS_RTL_ENGINE
  return {"model", "hls", "rtl"};
#else
  return {"model", "hls"};
#endif
}

class DecodeCommand : public ::testing::Test {
 protected:
  // Runs selfproj-sim decode in the scratch folder.
  Outcome decode(const std::vector<std::string>& arguments) const {
    std::vector<std::string> all{"decode"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run_program(SELFPROJ_SIM_PROGRAM, all, folder_.path());
  }

  // Saves a Gray sequence of images as 00.png, 01.png, ...; returns the names.
  std::vector<std::string> save(const std::vector<cv::Mat>& images) const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < images.size(); ++i) {
      names.push_back(fmt::format("{:02}.png", i));
      EXPECT_TRUE(cv::imwrite((folder_ / names.back()).string(), images[i]));
    }
    return names;
  }

  // Expects a failure as in the contract: status 2, one line that begins with `subject` and contains `reason`, nothing
  // written.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& subject,
                      const std::string& reason) const {
    const std::vector<std::string> before = folder_.names();
    expect_refusal(decode(arguments), subject, {reason});
    EXPECT_EQ(folder_.names(), before);
  }

  ScratchFolder folder_;
};

// Images of a random sequence whose pairs differ by about the threshold.
std::vector<cv::Mat> random_sequence(Random& random, const model::GraySettings& settings, int frames) {
  std::vector<cv::Mat> images;
  for (int i = 0; i < frames; ++i) {
    cv::Mat image(settings.rows, settings.columns, CV_8UC1);
    for (std::size_t k = 0; k < image.total(); ++k) {
      image.data[k] = i % 2 == 0 ? static_cast<std::uint8_t>(random.between(40, 200))
                                 : static_cast<std::uint8_t>(images.back().data[k] + random.between(-20, 20));
    }
    images.push_back(image);
  }
  return images;
}

TEST_F(DecodeCommand, EveryEngineGivesTheReferencesCodes) {
  for (const std::uint64_t seed : seeds(6)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const model::GraySettings settings{.rows = random.between(1, 20),
                                       .columns = 4 * random.between(1, 30),
                                       .bits = random.between(1, 12),
                                       .threshold = random.between(0, 9)};
    const int pairs = settings.bits + random.between(0, 5);
    const std::vector<cv::Mat> images = random_sequence(random, settings, 2 * pairs);
    const std::vector<std::string> names = save(images);
    for (const std::string& engine : engines()) {
      for (const bool median : {false, true}) {
        SCOPED_TRACE(engine + (median ? ", median" : ""));
        std::vector<std::string> arguments{"--engine",    engine,
                                           "--bits",      std::to_string(settings.bits),
                                           "--threshold", std::to_string(settings.threshold),
                                           "--out",       "out"};
        if (median) {
          arguments.emplace_back("--median");
        }
        arguments.insert(arguments.end(), names.begin(), names.end());
        const Outcome outcome = decode(arguments);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        ReferenceGray reference(settings);
        std::vector<std::string> files;
        for (int i = 0; i < 2 * pairs; ++i) {
          const cv::Mat& image = images[static_cast<std::size_t>(i)];
          auto codes = reference.take(
              {.pixels = {image.data, image.data + image.total()}, .pattern = i % (2 * settings.bits), .good = true});
          if (!codes) {
            continue;
          }
          if (median) {
            codes = reference_median(*codes, settings.rows, settings.columns);
          }
          files.push_back(fmt::format("code_{:04}.png", i / 2));
          const cv::Mat code = cv::imread((folder_ / "out" / files.back()).string(), cv::IMREAD_UNCHANGED);
          const cv::Mat measurable =
              cv::imread((folder_ / "out" / fmt::format("measurable_{:04}.png", i / 2)).string(), cv::IMREAD_UNCHANGED);
          ASSERT_EQ(code.type(), CV_16UC1);
          ASSERT_EQ(measurable.type(), CV_8UC1);
          for (std::size_t k = 0; k < codes->size(); ++k) {
            const bool good = (*codes)[k] >= 0x8000;
            ASSERT_EQ(code.at<std::uint16_t>(static_cast<int>(k) / code.cols, static_cast<int>(k) % code.cols),
                      good ? (*codes)[k] - 0x8000 : 0)
                << "pixel " << k << " of " << files.back();
            ASSERT_EQ(measurable.data[k], good ? 255 : 0) << "pixel " << k << " of " << files.back();
          }
        }
        EXPECT_EQ(files.size(), static_cast<std::size_t>(pairs - settings.bits + 1));
        EXPECT_EQ(static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_ / "out"), {})),
                  2 * files.size());
        fs::remove_all(folder_ / "out");
      }
    }
  }
}

TEST_F(DecodeCommand, TakesAChannelOfColourImages) {
  Random random(1);
  const model::GraySettings settings{.rows = 5, .columns = 8, .bits = 2, .threshold = 5};
  const std::vector<cv::Mat> images = random_sequence(random, settings, 4);
  std::vector<cv::Mat> colour;
  for (const cv::Mat& image : images) {
    cv::Mat all;
    cv::merge(std::vector<cv::Mat>{image, cv::Mat::zeros(image.size(), CV_8UC1), cv::Mat::zeros(image.size(), CV_8UC1)},
              all);
    colour.push_back(all);
  }
  std::vector<std::string> names = save(images);
  std::vector<std::string> grey{"--engine", "model", "--bits", "2", "--out", "grey"};
  grey.insert(grey.end(), names.begin(), names.end());
  ASSERT_EQ(decode(grey).status, 0);
  save(colour);
  std::vector<std::string> blue{"--engine", "model", "--bits", "2", "--channel", "blue", "--out", "blue"};
  blue.insert(blue.end(), names.begin(), names.end());
  ASSERT_EQ(decode(blue).status, 0);
  EXPECT_EQ(read_text(folder_ / "grey" / "code_0001.png"), read_text(folder_ / "blue" / "code_0001.png"));
}

TEST_F(DecodeCommand, RefusesWhatItCannotTake) {
  Random random(1);
  const model::GraySettings settings{.rows = 5, .columns = 8, .bits = 2, .threshold = 5};
  const std::vector<cv::Mat> images = random_sequence(random, settings, 6);
  const std::vector<std::string> n = save(images);
  cv::imwrite((folder_ / "small.png").string(), images[0](cv::Rect(0, 0, 4, 5)));
  cv::imwrite((folder_ / "odd.png").string(), images[0](cv::Rect(0, 0, 6, 5)));
  cv::Mat other;
  images[0].convertTo(other, CV_16U);
  cv::imwrite((folder_ / "deep.png").string(), other);
  cv::cvtColor(images[0], other, cv::COLOR_GRAY2BGR);
  cv::imwrite((folder_ / "colour.png").string(), other);
  write_text(folder_ / "text.png", "no image");
  write_text(folder_ / "file", "no folder");
  for (const std::string& engine : engines()) {
    const auto refused = [&](std::vector<std::string> arguments, const std::string& subject,
                             const std::string& reason) {
      SCOPED_TRACE(engine + ": " + subject + ": " + reason);
      arguments.insert(arguments.begin(), {"--engine", engine});
      expect_refused(arguments, subject, reason);
    };
    refused({"--bits", "2", "--out", "out", n[0], n[1], n[2], n[3], n[4]}, "IMAGE: ", "odd number");
    refused({"--bits", "2", "--out", "out", n[0], n[1]}, "IMAGE: ", "at least 4");
    refused({"--bits", "2", "--out", "out", n[0], n[1], n[2], "small.png"}, "small.png: ", "one size");
    refused({"--bits", "2", "--out", "out", "odd.png", n[1], n[2], n[3]}, "odd.png: ", "multiple of 4");
    refused({"--bits", "2", "--out", "out", n[0], n[1], n[2], "deep.png"}, "deep.png: ", "16 bits");
    refused({"--bits", "2", "--out", "out", n[0], n[1], n[2], "colour.png"}, "colour.png: ", "--channel");
    refused({"--bits", "2", "--out", "out", n[0], n[1], n[2], "text.png"}, "text.png: ", "");
    refused({"--bits", "2", "--out", "out", n[0], n[1], n[2], "missing.png"}, "missing.png: ", "");
    refused({"--bits", "2", "--out", "file", n[0], n[1], n[2], n[3]}, "file: ", "");
    refused({"--bits", "0", "--out", "out", n[0], n[1]}, "--bits: ", "0");
    refused({"--bits", "13", "--out", "out", n[0], n[1]}, "--bits: ", "13");
    refused({"--bits", "2", "--threshold", "256", "--out", "out", n[0], n[1], n[2], n[3]}, "--threshold: ", "256");
    refused({"--bits", "2", n[0], n[1], n[2], n[3]}, "--out", "required");
    refused({"--out", "out", n[0], n[1], n[2], n[3]}, "--bits", "required");
  }
}

TEST_F(DecodeCommand, OverwritesNoImageOfItsOwn) {
  Random random(1);
  const model::GraySettings settings{.rows = 5, .columns = 8, .bits = 1, .threshold = 5};
  const std::vector<cv::Mat> images = random_sequence(random, settings, 2);
  save(images);
  fs::rename(folder_ / "00.png", folder_ / "code_0000.png");
  expect_refused({"--engine", "model", "--bits", "1", "--out", ".", "code_0000.png", "01.png"},
                 (folder_ / "code_0000.png").string() + ": ", "overwritten");
}

// The real captures that may lie beside the project (../shared/data): all engines give the same files.
class RealCaptures : public DecodeCommand {
 protected:
  static std::optional<fs::path> data(const std::string& name) {
    const fs::path path = fs::path(SELFPROJ_SOURCE_DIR) / ".." / "shared" / "data" / name;
    return fs::exists(path) ? std::optional(fs::canonical(path)) : std::nullopt;
  }

  void expect_engines_agree(const std::vector<std::string>& images, int bits) const {
    for (const std::string& engine : engines()) {
      std::vector<std::string> arguments{"--engine", engine, "--bits", std::to_string(bits), "--out", engine};
      arguments.insert(arguments.end(), images.begin(), images.end());
      const Outcome outcome = decode(arguments);
      ASSERT_EQ(outcome.status, 0) << outcome.err;
    }
    for (const char* kind : {"code", "measurable"}) {
      const std::string file = fmt::format("{}_{:04}.png", kind, bits - 1);
      for (const std::string& engine : engines()) {
        EXPECT_EQ(read_text(folder_ / "model" / file), read_text(folder_ / engine / file)) << engine << ": " << file;
      }
    }
    const cv::Mat measurable =
        cv::imread((folder_ / "model" / fmt::format("measurable_{:04}.png", bits - 1)).string(), cv::IMREAD_UNCHANGED);
    EXPECT_GT(cv::countNonZero(measurable), static_cast<int>(measurable.total() / 100));
    for (const std::string& engine : engines()) {
      fs::remove_all(folder_ / engine);
    }
  }
};

TEST_F(RealCaptures, ChessboardColumnsAndRows) {
  const auto folder = data("gray-kamino-pose0");
  if (!folder) {
    GTEST_SKIP() << "there is no ../shared/data/gray-kamino-pose0";
  }
  for (const int first : {0, 20}) {
    std::vector<std::string> images;
    for (int i = first; i < first + 20; ++i) {
      images.push_back((*folder / "capture_0" / fmt::format("graycode_{:02}.png", i)).string());
    }
    expect_engines_agree(images, 10);
  }
}

// A crop of 256 x 200 pixels.
TEST_F(RealCaptures, CropOfTheShell) {
  const auto folder = data("gray-sltk");
  if (!folder) {
    GTEST_SKIP() << "there is no ../shared/data/gray-sltk";
  }
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(*folder)) {
    const std::string name = entry.path().filename().string();
    if (name.find("_[00-") != std::string::npos && entry.path().extension() == ".jpg") {
      files.push_back(entry.path().string());
    }
  }
  // Name …_[AA-BB-II_SS]_img.jpg: bit BB falls, positive II = 00 before inverse 01.
  const auto key = [](const std::string& file) {
    const std::size_t at = file.find("_[00-") + 5;
    return std::pair(-std::stoi(file.substr(at, 2)), std::stoi(file.substr(at + 3, 2)));
  };
  std::sort(files.begin(), files.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  ASSERT_EQ(files.size(), 22U);
  std::vector<cv::Mat> crops;
  for (const std::string& file : files) {
    crops.push_back(cv::imread(file, cv::IMREAD_GRAYSCALE)(cv::Rect(1200, 900, 256, 200)).clone());
  }
  expect_engines_agree(save(crops), 11);
}

// One folder stands for its images in natural order: 10.png after 9.png.
TEST_F(DecodeCommand, TakesAFolder) {
  Random random(4);
  const model::GraySettings settings{.rows = 6, .columns = 8, .bits = 6, .threshold = 5};
  const std::vector<cv::Mat> images = random_sequence(random, settings, 12);
  const std::vector<std::string> names = save(images);
  fs::create_directory(folder_ / "images");
  for (std::size_t i = 0; i < images.size(); ++i) {
    fs::copy_file(folder_ / names[i], folder_ / "images" / fmt::format("{}.png", i));
  }
  std::vector<std::string> arguments{"--engine", "model", "--bits", "6", "--out", "by_names"};
  arguments.insert(arguments.end(), names.begin(), names.end());
  ASSERT_EQ(decode(arguments).status, 0);
  const Outcome outcome = decode({"--engine", "model", "--bits", "6", "--out", "by_folder", "images"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* file : {"code_0005.png", "measurable_0005.png"}) {
    EXPECT_EQ(read_text(folder_ / "by_folder" / file), read_text(folder_ / "by_names" / file));
  }
  write_text(folder_ / "images" / "notes.txt", "no image");
  write_text(folder_ / "images" / "notes2.txt", "no image");
  const Outcome noted = decode({"--engine", "model", "--bits", "6", "--out", "out", "images"});
  EXPECT_EQ(noted.status, 0);
  EXPECT_EQ(noted.err, "selfproj-sim: images/notes.txt: is no image and left out, like another one of its folder\n");
}

}  // namespace
}  // namespace selfproj::test
