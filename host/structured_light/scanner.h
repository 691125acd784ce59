// The scanner of chapter 4: frames in, a depth image and the centroid of what moved after every pair.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_SCANNER_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_SCANNER_H

#include <cstdint>
#include <vector>

#include "host/io/float_image.h"
#include "host/structured_light/fast_decoder.h"
#include "host/structured_light/moved.h"
#include "host/structured_light/triangulation.h"
#include "model/column_moments.h"

namespace selfproj {

struct ScannerSettings {
  int threshold = 5;            // θ_b of (4.15), 0..255
  bool median = true;           // 3 x 3, on the code image
  bool strict = false;          // a pixel with one ambiguous pair has no depth either; not together with the median
  float min_difference_mm = 5;  // from the background, for what counts as moved
  SteadySettings steady = {};   // likewise
};

class Scanner {
 public:
  // For images of the triangulation's size and codes of its bits; it must outlive the scanner. Everything is allocated
  // here. Throws std::invalid_argument where a setting is out of range.
  Scanner(const Triangulation& triangulation, const ScannerSettings& settings);

  // Takes a frame with its pattern index, by the rules of FastGrayDecoder, and returns true where there is a new depth
  // image. `good` is false for a frame that was flagged.
  bool take(const ImageView& image, int pattern, bool good = true);

  // Takes a code image decoded elsewhere (on the board), rows · columns words.
  void take_codes(const std::uint16_t* codes);

  // The newest depth image, mm, NaN where there is none, and the code words it was made of.
  [[nodiscard]] const FloatImage& depth() const { return depth_; }
  [[nodiscard]] const std::vector<std::uint16_t>& codes() const { return codes_; }

  // The background. Throws std::invalid_argument where the image has another size.
  void set_background(const FloatImage& background);
  [[nodiscard]] bool has_background() const { return has_background_; }

  // What of the newest depth image moved; 0 pixels where there is no background.
  [[nodiscard]] const Moved& moved() const { return moved_; }

  // Depth of the pixels that moved, NaN elsewhere, to `out` of the same size.
  void difference(FloatImage& out) const;

 private:
  void triangulate();
  // Depths, those that can have moved.
  [[nodiscard]] const float* candidates() const { return steady_.is_on() ? steady_.kept() : depth_.values.data(); }

  const Triangulation* triangulation_;
  ScannerSettings settings_;
  FastGrayDecoder decoder_;
  FastMedian median_;
  std::vector<std::uint16_t> codes_;
  FloatImage depth_;
  FloatImage background_;
  bool has_background_ = false;
  SteadyFilter steady_;
  Moved moved_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_SCANNER_H
