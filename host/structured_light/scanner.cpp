#include "selfproj/structured_light/scanner.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "selfproj/model/gray_decoder.h"
#include "selfproj/structured_light/foreground.h"

namespace selfproj::structured_light {
Scanner::Scanner(const Triangulation& triangulation, const ScannerSettings& settings)
    : triangulation_(&triangulation),
      settings_(settings),
      decoder_({triangulation.rows(), triangulation.columns(), triangulation.bits(), settings.threshold}),
      median_(triangulation.columns()),
      codes_(triangulation.pixels()),
      depth_(triangulation.rows(), triangulation.columns(), images::kNoValue),
      background_(triangulation.rows(), triangulation.columns(), images::kNoValue),
      steady_(triangulation.rows(), triangulation.columns(), settings.steady) {
  if (!(settings.min_difference_mm >= 0)) {
    throw std::invalid_argument("scanner: the least difference is negative");
  }
  if (settings.strict && settings.median) {
    throw std::invalid_argument("scanner: strict and median exclude each other");
  }
}

bool Scanner::add_frame(const model::ImageView& image, int pattern, bool good) {
  if (!decoder_.add_frame(image, pattern, good)) {
    return false;
  }
  if (settings_.median) {
    median_.filter(decoder_.codes(), codes_.data());
  } else if (settings_.strict) {
    unambiguous_code_words(decoder_.codes(), codes_.data());
  } else {
    code_words(decoder_.codes(), codes_.data());
  }
  triangulate();
  return true;
}

void Scanner::add_codes(const std::uint16_t* codes) {
  std::copy_n(codes, codes_.size(), codes_.begin());
  triangulate();
}

void Scanner::triangulate() {
  triangulation_->depth(codes_.data(), depth_.values.data());
  if (has_background_) {
    const float* const background = background_.values.data();
    if (steady_.is_on()) {
      steady_.apply(depth_.values.data(), background, settings_.min_difference_mm);
    }
    foreground_ = foreground_of(*triangulation_, candidates(), background, settings_.min_difference_mm);
  }
  if (steady_.is_on()) {
    steady_.remember(depth_.values.data());
  }
}

void Scanner::set_background(const images::FloatImage& background) {
  if (background.rows != depth_.rows || background.columns != depth_.columns) {
    throw std::invalid_argument("scanner: the background has another size");
  }
  std::copy(background.values.begin(), background.values.end(), background_.values.begin());
  has_background_ = true;
}

void Scanner::difference(images::FloatImage& out) const {
  const float* const z = candidates();
  for (std::size_t i = 0; i < depth_.values.size(); ++i) {
    const bool differs = std::abs(z[i] - background_.values[i]) > settings_.min_difference_mm;
    out.values[i] = differs ? z[i] : images::kNoValue;
  }
}

}  // namespace selfproj::structured_light
