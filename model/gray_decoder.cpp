#include "selfproj/model/gray_decoder.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace selfproj::model {
namespace {

void check_settings(const GraySettings& settings) {
  if (settings.rows < 1 || settings.columns < 1) {
    throw std::invalid_argument("gray decoder: rows or columns are less than 1");
  }
  if (settings.bits < 1 || settings.bits > GrayDecoder::kMaxBits) {
    throw std::invalid_argument("gray decoder: bits are not in 1.." + std::to_string(GrayDecoder::kMaxBits));
  }
  if (settings.threshold < 0 || settings.threshold > 255) {
    throw std::invalid_argument("gray decoder: threshold is not in 0..255");
  }
}

}  // namespace

GrayDecoder::GrayDecoder(const GraySettings& settings) : settings_(settings) {
  check_settings(settings);
  pixels_.resize(static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns));
}

void GrayDecoder::configure(const GraySettings& settings) {
  if (settings == settings_) {
    return;
  }
  *this = GrayDecoder(settings);
}

bool GrayDecoder::begin(int pattern) {
  const int patterns = 2 * settings_.bits;
  if (pattern != next_) {
    restart();
  }
  if (pattern != next_) {
    role_ = Role::ignored;
    due_ = false;
    return false;
  }
  role_ = pattern % 2 == 0 ? Role::positive : Role::negative;
  plane_ = pattern / 2;
  next_ = (pattern + 1) % patterns;
  if (role_ == Role::negative) {
    pairs_ = std::min(pairs_ + 1, settings_.bits);
  }
  due_ = role_ == Role::negative && pairs_ == settings_.bits;
  return due_;
}

void GrayDecoder::pixels(int row, int column, int count, const std::uint8_t* values, std::uint16_t* codes) {
  const auto bits = static_cast<unsigned>(settings_.bits);
  const unsigned weight = 1U << (bits - 1 - static_cast<unsigned>(plane_));  // weight of the plane in the code
  Pixel* state = pixels_.data() + static_cast<std::ptrdiff_t>(row) * settings_.columns + column;
  for (int i = 0; i < count; ++i) {
    Pixel& pixel = state[i];
    if (role_ == Role::positive) {
      pixel.positive = values[i];
    } else if (role_ == Role::negative) {
      const int difference = pixel.positive - values[i];
      const bool lit = difference > settings_.threshold;
      const bool ambiguous = !lit && difference >= -settings_.threshold;
      const bool above = plane_ != 0 && (pixel.planes & (weight << 1)) != 0;  // B of the previous plane
      pixel.planes = static_cast<std::uint16_t>((pixel.planes & ~weight) | (lit != above ? weight : 0U));
      pixel.ambiguous = static_cast<std::uint16_t>((pixel.ambiguous & ~weight) | (ambiguous ? weight : 0U));
      if (due_) {
        const bool measurable = std::popcount(pixel.ambiguous) <= 1;
        codes[i] = static_cast<std::uint16_t>(pixel.planes | (measurable ? kMeasurable : 0U));
      }
    }
  }
}

void GrayDecoder::end(bool good) {
  role_ = Role::ignored;
  due_ = false;
  if (!good) {
    restart();
  }
}

bool GrayDecoder::add_frame(const ImageView& image, int pattern, bool good, std::uint16_t* codes) {
  if (image.rows != settings_.rows || image.columns != settings_.columns) {
    throw std::invalid_argument("gray decoder: the image has not the size of the settings");
  }
  if (image.pixels == nullptr || codes == nullptr) {
    throw std::invalid_argument("gray decoder: null pointer");
  }
  if (!good) {
    restart();
    return false;
  }
  const bool due = begin(pattern);
  for (int row = 0; row < image.rows; ++row) {
    pixels(row, 0, image.columns, image.pixels + row * image.stride,
           codes + static_cast<std::ptrdiff_t>(row) * image.columns);
  }
  end(true);
  return due;
}

}  // namespace selfproj::model
