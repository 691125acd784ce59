// Finds which projector point each camera pixel sees, from a scan: one straight line of light at a time along each
// axis, or Gray codes along both. The caller shows the patterns and takes the images.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_POINT_SCAN_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_POINT_SCAN_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "selfproj/structured_light/gray_sequence.h"

namespace selfproj::structured_light {

// For each camera pixel the projector point that lights what it sees: line and column, from 0 with a fraction, both NaN
// if there is none.
struct ProjectorPoints {
  images::FloatImage line;
  images::FloatImage column;
};

// One axis of a line scan. The images come in the order of the lines. For each pixel it keeps the place along the axis
// where the pixel was brightest, as the centroid of the light there; memory thus does not grow with the number of
// lines.
class AxisScan {
 public:
  // Images of rows x columns. `contrast`: by how many grey values a pixel must become brighter than its surroundings
  // along the axis. Throws std::invalid_argument if a size is less than 1.
  AxisScan(int rows, int columns, int contrast);

  // Adds the image under the next line, beginning with line 0. Throws std::invalid_argument for another size.
  void add(const model::ImageView& image);

  // The coordinate of each pixel. NaN if the contrast is not reached, if the light lies at the end of the axis and is
  // not whole, or if two places more than four lines apart are lit alike (the dimmer by more than half as much): such a
  // pixel sees both sides of a step.
  [[nodiscard]] images::FloatImage coordinates();

 private:
  // The light of one pixel spreads over no more than this many lines to either side. On rig B a pixel sees 1.2 to 3.4
  // lines, and a lens blur of half a pixel adds 1.5 times as much.
  static constexpr int kReach = 10;
  static constexpr int kRing = 2 * kReach + 1;

  [[nodiscard]] int value(int line, std::size_t pixel) const {
    return ring_[static_cast<std::size_t>(line % kRing) * pixels_ + pixel];
  }
  void look_at(int line);
  void weigh(int line, std::size_t pixel);

  int rows_, columns_;
  std::size_t pixels_;
  int contrast_;
  int lines_ = 0;                             // lines that have come
  std::vector<std::uint8_t> ring_;            // the newest kRing images
  std::vector<std::uint8_t> look_;            // only pixels brighter than this need a look
  std::vector<float> best_, place_, second_;  // contrast and coordinate; contrast of another place
};

// Both axes: first the images of the lines, then those of the columns. Throws as AxisScan does.
class LinePointScan {
 public:
  explicit LinePointScan(const rig::Rig& rig);

  // The number of images: one under each line, then one under each column of the projector.
  [[nodiscard]] int count() const { return lines_ + columns_; }

  void add(const model::ImageView& image);

  [[nodiscard]] ProjectorPoints points();

 private:
  int lines_, columns_;
  int next_ = 0;
  AxisScan line_axis_, column_axis_;
};

// Codes along one axis, with planes that are ambiguous in some pixels. Plane p of m has bit m - 1 - p, as in the Gray
// decoder.
struct AmbiguousCodes {
  int rows = 0;
  int columns = 0;
  int bits = 0;
  std::vector<std::uint16_t> codes;      // codes with ambiguous planes taken for 0 (4.17)
  std::vector<std::uint16_t> ambiguous;  // ambiguous planes
};

// Coordinates from Gray codes that count single lines. If an edge of a plane passes through the pixel, this plane alone
// is ambiguous, and the place is between the two codes that differ in that plane. If the pixel sees too much of the
// projector to resolve the finest planes, the place is the middle of what the others leave open, at most `max_open`
// lines. Anything else gives NaN. In a second step each place is replaced by that of the plane fitted to its
// neighbourhood, which averages the steps of the codes. The fit uses pixels up to `reach` rows and columns away whose
// places are within `jump` lines for each pixel of distance. If these are fewer than half, the place stays.
images::FloatImage coordinates_of_codes(const AmbiguousCodes& codes, int max_open = 4, int reach = 2, double jump = 4);

// The same from the images seen under the patterns of GraySequence: columns, lines, and finally white and black, which
// are not needed. On rig B these are 42 images instead of 1792.
class GrayPointScan {
 public:
  explicit GrayPointScan(const rig::Rig& rig);

  [[nodiscard]] int count() const { return sequence_.count(); }

  // Adds the next image. Throws std::invalid_argument for another size, or for one image too many.
  void add(const model::ImageView& image);

  // Coordinates as coordinates_of_codes gives them, for pixels that have both.
  [[nodiscard]] ProjectorPoints points() const;

 private:
  GraySequence sequence_;
  FastGrayDecoder columns_, lines_;
  std::vector<std::uint8_t> positive_;
  int next_ = 0;
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_POINT_SCAN_H
