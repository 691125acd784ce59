#include "host/calibration/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/files/user_error.h"
#include "host/images/frame_options.h"
#include "host/structured_light/fast_decoder.h"
#include "model/gray_decoder.h"

namespace selfproj {
namespace {

// Reads images of one size in turn and keeps their sum.
class Images {
 public:
  explicit Images(ImageSequence& images) : images_(images) {}

  // The next image, valid until the one after its successor is read.
  const Image& next() {
    Image& image = pair_[next_ % 2];
    image = images_.read(next_);
    if (next_ == 0) {
      if (std::max(image.rows, image.columns) > FastGrayDecoder::kMaxSide) {
        throw UserError(images_.files()[0],
                        fmt::format("is {}; at most {} rows and columns are taken",
                                    size_text(image.rows, image.columns), FastGrayDecoder::kMaxSide));
      }
      sum_.resize(image.pixels.size());
      rows_ = image.rows;
      columns_ = image.columns;
    }
    std::transform(sum_.begin(), sum_.end(), image.pixels.begin(), sum_.begin(),
                   [](std::uint32_t sum, std::uint8_t pixel) { return sum + pixel; });
    ++next_;
    return image;
  }

  // The sum of all images so far, stretched to 0..255.
  [[nodiscard]] Image stretched() const {
    const auto [low, high] = std::minmax_element(sum_.begin(), sum_.end());
    const std::uint32_t range = std::max(1U, *high - *low);
    Image result{rows_, columns_, std::vector<std::uint8_t>(sum_.size())};
    std::transform(sum_.begin(), sum_.end(), result.pixels.begin(), [&, least = *low](std::uint32_t sum) {
      return static_cast<std::uint8_t>((255 * (sum - least) + range / 2) / range);
    });
    return result;
  }

 private:
  ImageSequence& images_;
  std::array<Image, 2> pair_;
  std::vector<std::uint32_t> sum_;
  std::size_t next_ = 0;
  int rows_ = 0;
  int columns_ = 0;
};

// The codes along one axis from its pairs of images; kNone if a pair is ambiguous or the code is not within `side`.
std::vector<std::int16_t> decode_axis(Images& images, int bits, int side, int threshold) {
  std::optional<FastGrayDecoder> decoder;
  std::size_t pixels = 0;
  for (int i = 0; i < 2 * bits; ++i) {
    const Image& image = images.next();
    if (!decoder) {
      decoder.emplace(GraySettings{image.rows, image.columns, bits, threshold});
      pixels = image.pixels.size();
    }
    decoder->take(image.view(), i);
  }
  std::vector<std::uint16_t> words(pixels);
  unambiguous_code_words(decoder->codes(), words.data());
  std::vector<std::int16_t> codes(pixels);
  std::transform(words.begin(), words.end(), codes.begin(), [&](std::uint16_t word) {
    const int code = word & GrayDecoder::kCode;
    const bool valid = (word & GrayDecoder::kMeasurable) != 0 && code < side;
    return valid ? static_cast<std::int16_t>(code) : Capture::kNone;
  });
  return codes;
}

}  // namespace

std::size_t Capture::decoded() const {
  return projector_column.size() -
         static_cast<std::size_t>(std::count(projector_column.begin(), projector_column.end(), kNone));
}

Capture decode_capture(const std::string& name, ImageSequence& captured, const GraySequence& sequence,
                       const DecodeSettings& settings) {
  constexpr int kMostBits = GrayDecoder::kMaxBits;
  if (sequence.column_bits() > kMostBits || sequence.row_bits() > kMostBits) {
    throw UserError("--projector", fmt::format("has a side of more than {} pixels", 1 << kMostBits));
  }
  if (captured.count() != static_cast<std::size_t>(sequence.count())) {
    throw UserError(name,
                    fmt::format("has {} images; {} are expected for a projector of {}: {} pairs for columns, {} for "
                                "rows, white, black",
                                captured.count(), sequence.count(), size_text(sequence.rows(), sequence.columns()),
                                sequence.column_bits(), sequence.row_bits()));
  }
  Images images(captured);
  Capture capture;
  capture.projector_column = decode_axis(images, sequence.column_bits(), sequence.columns(), settings.threshold);
  capture.projector_row = decode_axis(images, sequence.row_bits(), sequence.rows(), settings.threshold);
  const Image& white = images.next();
  const Image& black = images.next();
  capture.rows = white.rows;
  capture.columns = white.columns;
  for (std::size_t i = 0; i < white.pixels.size(); ++i) {
    const bool lit = white.pixels[i] - black.pixels[i] > settings.contrast;
    if (!lit || capture.projector_column[i] == Capture::kNone || capture.projector_row[i] == Capture::kNone) {
      capture.projector_column[i] = capture.projector_row[i] = Capture::kNone;
    }
  }
  capture.mean = images.stretched();
  return capture;
}

}  // namespace selfproj
