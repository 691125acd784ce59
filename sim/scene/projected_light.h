// The light from the projector: its pattern, blurred by its lens, also between its pixels.
#ifndef SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H
#define SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/optics.h"
#include "sim/scene/world.h"

namespace selfproj::sim {

// Finds the least and the greatest value of any rectangle of an image quickly.
class MinMaxPyramid {
 public:
  struct Range {
    float low, high;
  };

  MinMaxPyramid() = default;

  // The image must have pixels, and none may be NaN.
  explicit MinMaxPyramid(const images::FloatImage& image) {
    levels_.push_back({image, image});
    while (levels_.back().low.rows > 1 || levels_.back().low.columns > 1) {
      levels_.push_back(halved(levels_.back()));
    }
  }

  // Bounds of rows r0..r1 and columns c0..c1, both included and inside the image. They are sharp if the rectangle has
  // at most 4 pixels along each side. Otherwise they may include neighbours up to its own size away.
  [[nodiscard]] Range range(int r0, int r1, int c0, int c1) const {
    constexpr int kMost = 3;
    unsigned level = 0;
    while (std::max((r1 - r0) >> level, (c1 - c0) >> level) > kMost) {
      ++level;
    }
    const Level& l = levels_[level];
    Range result{l.low.row(r0 >> level)[c0 >> level], l.high.row(r0 >> level)[c0 >> level]};
    for (int r = r0 >> level; r <= r1 >> level; ++r) {
      const float* low = l.low.row(r);
      const float* high = l.high.row(r);
      for (int c = c0 >> level; c <= c1 >> level; ++c) {
        result = {std::min(result.low, low[c]), std::max(result.high, high[c])};
      }
    }
    return result;
  }

 private:
  struct Level {
    images::FloatImage low, high;
  };

  static Level halved(const Level& from) {
    const int rows = (from.low.rows + 1) / 2;
    const int columns = (from.low.columns + 1) / 2;
    Level to{images::FloatImage(rows, columns), images::FloatImage(rows, columns)};
    for (int r = 0; r < rows; ++r) {
      const int below = std::min(2 * r + 1, from.low.rows - 1);
      for (int c = 0; c < columns; ++c) {
        const int right = std::min(2 * c + 1, from.low.columns - 1);
        to.low.row(r)[c] = std::min({from.low.row(2 * r)[2 * c], from.low.row(2 * r)[right], from.low.row(below)[2 * c],
                                     from.low.row(below)[right]});
        to.high.row(r)[c] = std::max({from.high.row(2 * r)[2 * c], from.high.row(2 * r)[right],
                                      from.high.row(below)[2 * c], from.high.row(below)[right]});
      }
    }
    return to;
  }

  std::vector<Level> levels_;
};

// A projector's lens that is sharp at one distance. It maps z of the world to the blur at a place of the pattern.
struct ProjectorFocus {
  FocusedLens lens;
  Pinhole projector;  // its distortion does not matter here
  double nearest_z;   // mm: the blur is prepared from here to the farthest
  double farthest_z;

  // Standard deviation of the blur, in pixels.
  [[nodiscard]] double sigma_px(double line, double column, double z) const;
};

class ProjectedLight {
 public:
  // `pattern` has light 0..1, projector lines x columns; `blur` is the standard deviation in pixels. With a focus the
  // blur grows with the distance from it.
  ProjectedLight(const images::FloatImage& pattern, double blur, const std::optional<ProjectorFocus>& focus = {});

  // The light at a place of the pattern: linear between the centres of the blurred pixels, 0 outside.
  [[nodiscard]] double at(PixelPoint p) const;

  // The same where it falls on something at z, mm.
  [[nodiscard]] double at(PixelPoint p, double z) const { return focus_ ? focused_at(p, z) : at(p); }
  [[nodiscard]] float quick_at(float line, float column, float z) const {
    return focus_ ? static_cast<float>(
                        focused_at({static_cast<double>(line), static_cast<double>(column)}, static_cast<double>(z)))
                  : quick_at(line, column);
  }

  // The light of the blurred pattern, without defocus, in a part of it: sum and middle, and how many pixels have light.
  struct Part {
    double sum;
    double pixels;
    PixelPoint middle;
  };
  [[nodiscard]] Part in(int first_line, int last_line, int first_column, int last_column) const;

  // The same in 32-bit floats, for many places.
  [[nodiscard]] float quick_at(float line, float column) const {
    const float r = line + static_cast<float>(margin_);
    const float c = column + static_cast<float>(margin_);
    if (!(r > 0 && c > 0 && r < static_cast<float>(light_.rows - 1) && c < static_cast<float>(light_.columns - 1))) {
      return 0;
    }
    const int r0 = static_cast<int>(r);
    const int c0 = static_cast<int>(c);
    const float fr = r - static_cast<float>(r0);
    const float fc = c - static_cast<float>(c0);
    const float* above = light_.row(r0) + c0;
    const float* below = above + light_.columns;
    const float left = above[0] + fr * (below[0] - above[0]);
    const float right = above[1] + fr * (below[1] - above[1]);
    return left + fc * (right - left);
  }

  // Bounds of the light in the rectangle.
  [[nodiscard]] MinMaxPyramid::Range range(double line_0, double line_1, double column_0, double column_1) const;

  // Whether the whole rectangle is dark.
  [[nodiscard]] bool is_dark(double line_0, double line_1, double column_0, double column_1) const;

  // The middle of the line at this column: the centroid of the pattern's light without blur, linear between columns.
  // NaN for a column without light.
  [[nodiscard]] double line_centre(double column) const;

  // Bounds of line_centre between two columns; nothing if a column there has no light.
  struct Centres {
    double low, high;
  };
  [[nodiscard]] std::optional<Centres> line_centres(double first, double last) const;

 private:
  int margin_;                // dark or blurred pixels around the pattern
  images::FloatImage light_;  // with the margin
  MinMaxPyramid ranges_;
  std::vector<double> centres_;

  [[nodiscard]] double focused_at(PixelPoint p, double z) const;
  std::optional<ProjectorFocus> focus_;
  double variance_step_ = 0;           // from one of the wider ones to the next
  std::vector<ProjectedLight> wider_;  // with more and more blur
};

// The light 0..1 that comes out where `wanted` 0..1 was meant: round(255 wanted^(1/compensated))/255 to the power of
// gamma.
float light_through(const ProjectorGamma& gamma, float wanted);

// The same for a pattern.
images::FloatImage light_through(const ProjectorGamma& gamma, const images::FloatImage& wanted);

// Returns the light that the rig's projector makes of a pattern of light 0..1, with its gamma, blur and defocus.
ProjectedLight throw_light(const rig::Rig& rig, const images::FloatImage& pattern, const RenderOptions& options);

// Throws UserError about `source` if the pattern does not have the projector's size, or has a value outside 0..1.
void check_pattern(const images::FloatImage& pattern, const rig::RigProjector& projector,
                   const std::string& source = "pattern");

// An image as the rig's projector throws it: its lines x columns, 8 bits, 255 for full light. Only the projector's
// blur, gamma and focus matter among the options. Throws UserError about `source` if the image has another size.
ProjectedLight project_image(const rig::Rig& rig, const images::Image& image, const RenderOptions& options = {},
                             const std::string& source = "pattern");

// Patterns shown one after another, one for each frame, in a cycle.
class PatternSet {
 public:
  // Needs at least one image, else throws std::invalid_argument; also throws as project_image does.
  PatternSet(const rig::Rig& rig, std::span<const images::Image> images, const RenderOptions& options = {});

  [[nodiscard]] int size() const { return static_cast<int>(light_.size()); }
  [[nodiscard]] const ProjectedLight& operator[](int pattern) const {
    return light_[static_cast<std::size_t>(pattern)];
  }
  // Frame k shows pattern k mod size().
  [[nodiscard]] const ProjectedLight& of_frame(int frame) const { return (*this)[frame % size()]; }

 private:
  std::vector<ProjectedLight> light_;
};

// The 2 bits patterns of (4.1) along the projector's lines, with values 0 and 255, lines x columns: positive and
// negative of plane 0 (the most significant), then of plane 1, and so on. `bits` is 1..12. Where 2^bits is more than
// the lines, line v has code v.
std::vector<images::Image> gray_patterns(const rig::RigProjector& projector, int bits);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_PROJECTED_LIGHT_H
