// Which point of the projector each pixel of the camera sees, from a scan: one straight line of light at a time along
// each axis, or Gray codes along both. Whoever shows the patterns and takes the images looks on.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_POINT_SCAN_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_POINT_SCAN_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/io/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/fast_decoder.h"
#include "host/structured_light/gray_sequence.h"
#include "model/column_moments.h"

namespace selfproj {

// Of each camera pixel the point of the projector that lights what it sees: line and column, from 0 with a fraction,
// both NaN where there is none.
struct ProjectorPoints {
  FloatImage line;
  FloatImage column;
};

// One axis of a line scan. The images come in the order of the lines; of each pixel is kept where along the axis it was
// brightest, as the centroid of the light there, so that memory does not grow with the number of lines.
class AxisScan {
 public:
  // Images of rows x columns. `contrast`: how much brighter, in grey values, than its surroundings along the axis a
  // pixel must become. Throws std::invalid_argument where a size is less than 1.
  AxisScan(int rows, int columns, int contrast);

  // The image under the next line, 0 first. Throws std::invalid_argument for another size.
  void add(const ImageView& image);

  // The coordinate of each pixel, NaN where the contrast is not reached, where light lies at the end of the axis and
  // is not whole, or where two places more than four lines apart are lit alike (the dimmer one by more than half as
  // much): a pixel that sees both sides of a step.
  [[nodiscard]] FloatImage coordinates();

 private:
  // The light of one pixel spreads over no more than so many lines to either side. On rig B a pixel sees 1.2 to 3.4
  // lines, and a lens's blur of half a pixel adds 1.5 times as much.
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
  int lines_ = 0;                             // that came
  std::vector<std::uint8_t> ring_;            // the newest kRing images
  std::vector<std::uint8_t> look_;            // a pixel is worth a look where it is brighter
  std::vector<float> best_, place_, second_;  // contrast, coordinate; contrast of another place
};

// Both axes: the lines' images first, then the columns'. Throws as AxisScan.
class LinePointScan {
 public:
  explicit LinePointScan(const Rig& rig);

  // All images that come: one under each line, then one under each column of the projector.
  [[nodiscard]] int count() const { return lines_ + columns_; }

  void add(const ImageView& image);

  [[nodiscard]] ProjectorPoints points();

 private:
  int lines_, columns_;
  int next_ = 0;
  AxisScan line_axis_, column_axis_;
};

// Codes along one axis in which some planes of some pixels are ambiguous: of plane p of m bit m - 1 - p, as the Gray
// decoder keeps them.
struct AmbiguousCodes {
  int rows = 0;
  int columns = 0;
  int bits = 0;
  std::vector<std::uint16_t> codes;      // ambiguous planes taken for 0 (4.17)
  std::vector<std::uint16_t> ambiguous;  // planes
};

// Coordinates from Gray codes of which each counts one line. A plane is ambiguous where an edge of it passes through
// the pixel, and then no other plane is: the place is between the two codes that differ in that plane. Or the pixel
// sees too much of the projector to resolve the finest planes: then the place is in the middle of what the others leave
// open, which may be `most_open` lines. Anything else gives NaN. In a second step each place is that of the straight
// plane fitted to those of the neighbourhood, which averages the codes' steps: of the pixels up to `reach` rows and
// columns away whose places are within `jump` lines a pixel of distance from the middle one's; where less than half of
// them are, the place stays as it is.
FloatImage coordinates_of_codes(const AmbiguousCodes& codes, int most_open = 4, int reach = 2, double jump = 4);

// The same from the images seen under the patterns of GraySequence (columns, then lines, then white and black, which
// are not needed): 42 of them on rig B in place of 1792.
class GrayPointScan {
 public:
  explicit GrayPointScan(const Rig& rig);

  [[nodiscard]] int count() const { return sequence_.count(); }

  // The next image. Throws std::invalid_argument for another size, or where there are more.
  void add(const ImageView& image);

  // Coordinates as of coordinates_of_codes, where both axes have one.
  [[nodiscard]] ProjectorPoints points() const;

 private:
  GraySequence sequence_;
  FastGrayDecoder columns_, lines_;
  std::vector<std::uint8_t> positive_;
  int next_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_POINT_SCAN_H
