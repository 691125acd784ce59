// The Gray-code decoder and the median by their definitions: from the history of frames, without any state of a pixel.
// The model, the circuit and the host must equal them. Also random sequences of frames with everything that can happen
// to them.
#ifndef SELFPROJ_TESTS_SUPPORT_REFERENCE_GRAY_H
#define SELFPROJ_TESTS_SUPPORT_REFERENCE_GRAY_H

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "selfproj/model/gray_decoder.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

struct GrayFrame {
  std::vector<std::uint8_t> pixels;  // row by row
  int pattern = 0;
  bool good = true;
};

// Keeps the unbroken run of frames that began with plane 0, and computes each code image from it anew.
class ReferenceGray {
 public:
  explicit ReferenceGray(const model::GraySettings& settings) : settings_(settings) {}

  void restart() { run_.clear(); }

  std::optional<std::vector<std::uint16_t>> take(const GrayFrame& frame) {
    const int patterns = 2 * settings_.bits;
    const int expected = static_cast<int>(run_.size()) % patterns;
    if (!frame.good || frame.pattern != expected) {
      run_.clear();
    }
    if (!frame.good || (run_.empty() && frame.pattern != 0)) {
      return std::nullopt;
    }
    run_.push_back(frame.pixels);
    if (run_.size() % 2 != 0 || static_cast<int>(run_.size()) < patterns) {
      return std::nullopt;
    }
    std::vector<std::uint16_t> codes(frame.pixels.size());
    for (std::size_t pixel = 0; pixel < codes.size(); ++pixel) {
      codes[pixel] = code(pixel);
    }
    return codes;
  }

 private:
  // G of a pair of the run, and whether it is ambiguous (4.15).
  [[nodiscard]] std::pair<bool, bool> binarized(std::size_t pair, std::size_t pixel) const {
    const int difference = static_cast<int>(run_[2 * pair][pixel]) - static_cast<int>(run_[2 * pair + 1][pixel]);
    return {difference > settings_.threshold, difference <= settings_.threshold && difference >= -settings_.threshold};
  }

  // The word of a pixel after the newest pair.
  [[nodiscard]] std::uint16_t code(std::size_t pixel) const {
    const auto bits = static_cast<std::size_t>(settings_.bits);
    const std::size_t pairs = run_.size() / 2;
    int word = 0;
    int ambiguous = 0;
    for (std::size_t pair = pairs - bits; pair < pairs; ++pair) {
      const std::size_t plane = pair % bits;
      bool bit = false;  // sum modulo 2 over the planes 0..plane of the pair's own cycle (4.17)
      for (std::size_t k = pair - plane; k <= pair; ++k) {
        bit = bit != binarized(k, pixel).first;
      }
      word += bit ? 1 << (bits - 1 - plane) : 0;
      ambiguous += binarized(pair, pixel).second ? 1 : 0;
    }
    return static_cast<std::uint16_t>(word + (ambiguous <= 1 ? 0x8000 : 0));
  }

  model::GraySettings settings_;
  std::vector<std::vector<std::uint8_t>> run_;
};

// The median by sorting.
inline std::vector<std::uint16_t> reference_median(const std::vector<std::uint16_t>& codes, int rows, int columns) {
  std::vector<std::uint16_t> out;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      std::vector<int> measurable;
      std::size_t existing = 0;
      for (int i = 0; i < 9; ++i) {
        const int r = row + i / 3 - 1;
        const int c = column + i % 3 - 1;
        if (r >= 0 && r < rows && c >= 0 && c < columns) {
          ++existing;
          const int word =
              codes[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c)];
          if (word >= 0x8000) {
            measurable.push_back(word % 0x1000);
          }
        }
      }
      std::sort(measurable.begin(), measurable.end());
      const bool enough = measurable.size() * 2 > existing;
      out.push_back(static_cast<std::uint16_t>(enough ? measurable[(measurable.size() + 1) / 2 - 1] + 0x8000 : 0));
    }
  }
  return out;
}

// A sequence of frames of m pairs whose pixels differ by more or less than the threshold, in both directions. Sometimes
// a frame is missing, comes twice, is flagged or has a wrong index.
class GraySequence {
 public:
  GraySequence(const model::GraySettings& settings, Random& random) : settings_(settings), random_(random) {
    trouble_ = random.between(0, 2) * 100 / (40 * settings.bits);
  }

  // Settings of the frames from here on. The sequence goes on with its next pattern.
  void configure(const model::GraySettings& settings) { settings_ = settings; }

  GrayFrame next() {
    const int patterns = 2 * settings_.bits;
    GrayFrame frame;
    pattern_ %= patterns;
    if (random_.chance(trouble_)) {
      pattern_ = (pattern_ + random_.between(0, patterns - 1)) % patterns;  // frames are missing, or come again
    }
    frame.pattern = random_.chance(trouble_) ? random_.between(0, 40) : pattern_;
    frame.good = !random_.chance(trouble_);
    pattern_ = (pattern_ + 1) % patterns;

    const auto size = static_cast<std::size_t>(settings_.rows) * static_cast<std::size_t>(settings_.columns);
    frame.pixels = random_.bytes(size);
    if (frame.pattern % 2 == 1 && positive_.size() == size) {
      const int threshold = settings_.threshold;
      for (std::size_t i = 0; i < size; ++i) {  // around the threshold, on both sides
        const int edge = (frame.pixels[i] & 1) != 0 ? threshold : -threshold;
        const int near = positive_[i] - edge + random_.between(-2, 2);
        if (random_.chance(60) && near >= 0 && near <= 255) {
          frame.pixels[i] = static_cast<std::uint8_t>(near);
        }
      }
    }
    positive_ = frame.pixels;
    return frame;
  }

 private:
  model::GraySettings settings_;
  Random& random_;
  int trouble_ = 0;  // per cent
  int pattern_ = 0;
  std::vector<std::uint8_t> positive_;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_REFERENCE_GRAY_H
