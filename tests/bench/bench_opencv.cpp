// Compares Gray decoding with OpenCV's GrayCodePattern (structured_light of opencv-contrib) on the same work, with one
// thread.
//
//     bench_opencv [--benchmark_...]
//
// A whole decode takes all images of a sequence and gives the code of every pixel along both axes, as 16-bit images.
// OpenCV does this with getProjPixel, pixel by pixel; FastGrayDecoder does the same work on the same images:
//
//   512    512 x 512 pixels, 8 bits along one axis and 1 along the other, the least that the class takes; in cache
//   1280   1280 x 1024 pixels, 10 bits along each axis, the 40 images in memory
//   files  the same 40 images, read from PNG files by each side's own reader (both rest on OpenCV's)
//
// A further row is `pair`: FastGrayDecoder keeps the codes of the other planes, so that a new pair of images gives a
// new code image. This is not the same work; the row shows only the gain for a stream of images. Before the first
// measurement the codes of both sides are compared pixel by pixel; a difference ends the program with status 1.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/structured_light/graycodepattern.hpp>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "tests/bench/collector.h"

namespace selfproj::test {
namespace {

constexpr int kThreshold = 5;
// For us a pair is ambiguous if it differs by the threshold or less, for OpenCV only if it differs by less.
constexpr int kOpenCvThreshold = kThreshold + 1;

// The images of a sequence, with noise, as seen by a camera that looks straight at the projector's light.
class Capture {
 public:
  Capture(int rows, int columns, int projector_rows, int projector_columns)
      : sequence_(projector_columns, projector_rows), rows_(rows), columns_(columns) {
    std::minstd_rand random(1);
    for (int i = 0; i < sequence_.white(); ++i) {
      const std::vector<std::uint8_t> light = sequence_.image(i);
      images::Image& image = images_.emplace_back(images::Image{rows, columns, {}});
      image.pixels.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
      for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
          const int at = y * projector_rows / rows * projector_columns + x * projector_columns / columns;
          image.pixels[static_cast<std::size_t>(y * columns + x)] =
              static_cast<std::uint8_t>((light[static_cast<std::size_t>(at)] != 0 ? 180 : 30) + random() % 8);
        }
      }
    }
  }

  const structured_light::GraySequence& sequence() const { return sequence_; }
  int rows() const { return rows_; }
  int columns() const { return columns_; }
  std::size_t pixels() const { return images_.front().pixels.size(); }
  const std::vector<images::Image>& images() const { return images_; }

 private:
  structured_light::GraySequence sequence_;
  int rows_, columns_;
  std::vector<images::Image> images_;
};

// The codes of every pixel along both axes; kNone where there is none.
struct Codes {
  static constexpr std::uint16_t kNone = 0;
  explicit Codes(std::size_t pixels) : column(pixels), row(pixels) {}
  bool operator==(const Codes&) const = default;
  std::vector<std::uint16_t> column, row;
};

class OurDecoder {
 public:
  explicit OurDecoder(const Capture& capture)
      : columns_({capture.rows(), capture.columns(), capture.sequence().column_bits(), kThreshold}),
        rows_({capture.rows(), capture.columns(), capture.sequence().row_bits(), kThreshold}) {}

  void decode(const std::vector<images::Image>& images, Codes& codes) {
    std::size_t image = 0;
    image = decode_axis(columns_, images, image, codes.column);
    decode_axis(rows_, images, image, codes.row);
  }

 private:
  static std::size_t decode_axis(structured_light::FastGrayDecoder& decoder, const std::vector<images::Image>& images,
                                 std::size_t image, std::vector<std::uint16_t>& codes) {
    decoder.restart();
    for (int pattern = 0; pattern < 2 * decoder.settings().bits; ++pattern) {
      decoder.add_frame(images[image++].view(), pattern);
    }
    structured_light::unambiguous_code_words(decoder.codes(), codes.data());
    return image;
  }

  structured_light::FastGrayDecoder columns_, rows_;
};

class OpenCvDecoder {
 public:
  explicit OpenCvDecoder(const Capture& capture)
      : pattern_(
            cv::structured_light::GrayCodePattern::create(capture.sequence().columns(), capture.sequence().rows())) {
    pattern_->setWhiteThreshold(kOpenCvThreshold);
  }

  void decode(const std::vector<cv::Mat>& images, Codes& codes) const {
    std::size_t i = 0;
    for (int y = 0; y < images.front().rows; ++y) {
      for (int x = 0; x < images.front().cols; ++x, ++i) {
        cv::Point point;
        const bool bad = pattern_->getProjPixel(images, x, y, point);
        codes.column[i] = bad ? Codes::kNone : word_of(point.x);
        codes.row[i] = bad ? Codes::kNone : word_of(point.y);
      }
    }
  }

 private:
  static std::uint16_t word_of(int code) { return static_cast<std::uint16_t>(model::GrayDecoder::kMeasurable | code); }

  cv::Ptr<cv::structured_light::GrayCodePattern> pattern_;
};

std::vector<cv::Mat> mats_of(const std::vector<images::Image>& images) {
  std::vector<cv::Mat> mats;
  for (const images::Image& image : images) {
    mats.emplace_back(image.rows, image.columns, CV_8U,
                      const_cast<std::uint8_t*>(image.pixels.data()));  // NOLINT: OpenCV only reads
  }
  return mats;
}

// The images of a capture as PNG files, in a folder that is removed with it.
class Files {
 public:
  explicit Files(const Capture& capture)
      : folder_(std::filesystem::temp_directory_path() / ("bench_opencv-" + std::to_string(getpid()))) {
    std::filesystem::create_directory(folder_);
    for (const images::Image& image : capture.images()) {
      const std::string png = images::encode_png(image);
      names_.push_back((folder_ / (std::to_string(names_.size()) + ".png")).string());
      std::ofstream(names_.back(), std::ios::binary) << png;
    }
  }
  ~Files() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;

  std::vector<images::Image> ours() const {
    std::vector<images::Image> images;
    for (const std::string& name : names_) {
      images.push_back(images::read_image(name, std::nullopt));
    }
    return images;
  }
  std::vector<cv::Mat> theirs() const {
    std::vector<cv::Mat> images;
    for (const std::string& name : names_) {
      images.push_back(cv::imread(name, cv::IMREAD_GRAYSCALE));
    }
    return images;
  }

 private:
  std::filesystem::path folder_;
  std::vector<std::string> names_;
};

// Both sides give the same codes, and nearly every pixel has one.
bool codes_are_equal(const Capture& capture, const std::vector<images::Image>& ours,
                     const std::vector<cv::Mat>& theirs) {
  Codes found(capture.pixels());
  Codes expected(capture.pixels());
  OurDecoder(capture).decode(ours, found);
  OpenCvDecoder(capture).decode(theirs, expected);
  const auto none = std::count(found.column.begin(), found.column.end(), Codes::kNone);
  return found == expected && static_cast<std::size_t>(none) < capture.pixels() / 100;
}

template <class Decode>
void add(const std::string& name, Decode decode) {
  bench::add(name, [decode = std::move(decode)](benchmark::State& state) mutable {
    for (auto _ : state) {
      decode();
      benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations());
  });
}

void add_whole(const std::string& name, const Capture& capture) {
  add("whole/" + name + "/ours", [&capture, decoder = OurDecoder(capture), codes = Codes(capture.pixels())]() mutable {
    decoder.decode(capture.images(), codes);
  });
  add("whole/" + name + "/opencv", [decoder = OpenCvDecoder(capture), mats = mats_of(capture.images()),
                                    codes = Codes(capture.pixels())]() mutable { decoder.decode(mats, codes); });
}

void add_files(const Capture& capture, const Files& files) {
  add("whole/files/ours", [&files, decoder = OurDecoder(capture), codes = Codes(capture.pixels())]() mutable {
    decoder.decode(files.ours(), codes);
  });
  add("whole/files/opencv", [&files, decoder = OpenCvDecoder(capture), codes = Codes(capture.pixels())]() mutable {
    decoder.decode(files.theirs(), codes);
  });
}

// From a new pair of images to a new code image along the first axis.
void add_pair(const Capture& capture) {
  const int patterns = 2 * capture.sequence().column_bits();
  add("pair/512/ours", [&capture, patterns, pattern = 0, words = std::vector<std::uint16_t>(capture.pixels()),
                        decoder = structured_light::FastGrayDecoder(
                            {capture.rows(), capture.columns(), patterns / 2, kThreshold})]() mutable {
    for (int half = 0; half < 2; ++half, pattern = (pattern + 1) % patterns) {
      decoder.add_frame(capture.images()[static_cast<std::size_t>(pattern)].view(), pattern);
    }
    structured_light::unambiguous_code_words(decoder.codes(), words.data());
  });
}

nlohmann::ordered_json print_ratios(const bench::Collector& collector) {
  nlohmann::ordered_json results;
  const auto print = [&](const char* key, const std::string& ours, const std::string& theirs, const char* what) {
    const double our = collector.median(ours);
    const double their = collector.median(theirs);
    if (our > 0 && their > 0) {
      std::printf("%-62s %9.2f /s, OpenCV %7.2f /s: %.1f times\n", what, our, their, our / their);
      results[key] = {{"what", what}, {"ours_per_s", our}, {"opencv_per_s", their}, {"times", our / their}};
    }
  };
  std::printf("\n");
  print("whole_512", "whole/512/ours", "whole/512/opencv", "whole decode, 512 x 512, 8 + 1 bits, in cache");
  print("whole_1280", "whole/1280/ours", "whole/1280/opencv", "whole decode, 1280 x 1024, 10 + 10 bits, from memory");
  print("files_1280", "whole/files/ours", "whole/files/opencv", "the same, from 40 PNG files to codes");
  print("pair_512", "pair/512/ours", "whole/512/opencv",
        "new pair to new code image, beside a whole decode, 512 x 512");
  return results;
}

int run() {
  cv::setNumThreads(1);
  const Capture small(512, 512, 2, 256);
  const Capture large(1024, 1280, 768, 1024);
  const Files files(large);
  bench::require(codes_are_equal(small, small.images(), mats_of(small.images())) &&
                     codes_are_equal(large, files.ours(), files.theirs()),
                 "the codes differ");
  add_whole("512", small);
  add_whole("1280", large);
  add_files(large, files);
  add_pair(small);
  return bench::run_registered(
      {"bench_opencv", "Gray decoding beside OpenCV's GrayCodePattern, one thread", "items_per_second"}, print_ratios);
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  return selfproj::bench::main_of("bench_opencv", {argv + 1, argv + argc}, selfproj::test::run);
}
