// The scanner of chapter 4: frames in, a depth image and the centroid of the foreground after every pair.
#ifndef SELFPROJ_STRUCTURED_LIGHT_SCANNER_H
#define SELFPROJ_STRUCTURED_LIGHT_SCANNER_H

#include <cstdint>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "selfproj/structured_light/foreground.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

struct ScannerSettings {
  int threshold = 5;            // θ_b of (4.15), 0..255
  bool median = true;           // 3 x 3 median of the code image
  bool strict = false;          // a single ambiguous pair leaves a pixel without depth; not together with the median
  float min_difference_mm = 5;  // difference from the background above which a pixel is foreground
  SteadySettings steady = {};   // further conditions for the foreground
};

class Scanner {
 public:
  // For images of the triangulation's size and codes of its bits; it must outlive the scanner. Allocates everything
  // here. Throws std::invalid_argument if a setting is out of range.
  Scanner(const Triangulation& triangulation, const ScannerSettings& settings);

  // Takes a frame with its pattern index, by the rules of FastGrayDecoder. Returns true if there is a new depth image.
  // `good` is false for a flagged frame.
  bool add_frame(const model::ImageView& image, int pattern, bool good = true);

  // The next frame does not follow the one before: decoding begins anew.
  void restart() { decoder_.restart(); }

  // Takes a code image that was decoded elsewhere (on the board), rows · columns words.
  void add_codes(const std::uint16_t* codes);

  // The newest depth image in mm, NaN for pixels without depth, and the code words from which it was made.
  [[nodiscard]] const images::FloatImage& depth() const { return depth_; }
  [[nodiscard]] const std::vector<std::uint16_t>& codes() const { return codes_; }

  // Sets the background. Throws std::invalid_argument if the image has another size.
  void set_background(const images::FloatImage& background);
  [[nodiscard]] bool has_background() const { return has_background_; }

  // The foreground of the newest depth image; 0 pixels if there is no background.
  [[nodiscard]] const Foreground& foreground() const { return foreground_; }

  // Writes the depth of the foreground, NaN elsewhere, to `out`, which has the same size.
  void difference(images::FloatImage& out) const;

 private:
  void triangulate();
  // The depths of pixels that may be foreground.
  [[nodiscard]] const float* candidates() const { return steady_.is_on() ? steady_.kept() : depth_.values.data(); }

  const Triangulation* triangulation_;
  ScannerSettings settings_;
  FastGrayDecoder decoder_;
  FastMedian median_;
  std::vector<std::uint16_t> codes_;
  images::FloatImage depth_;
  images::FloatImage background_;
  bool has_background_ = false;
  SteadyFilter steady_;
  Foreground foreground_;
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_STRUCTURED_LIGHT_SCANNER_H
