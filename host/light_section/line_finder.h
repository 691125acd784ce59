// From pixels to the position of a line, for everything on the host that looks at images itself: scans, residuals,
// known heights. The rig says what counts, by the same rules as in a profile of packets.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_LINE_FINDER_H
#define SELFPROJ_HOST_LIGHT_SECTION_LINE_FINDER_H

#include <cstddef>
#include <variant>

#include "host/images/image_files.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/strip_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

using model::SensorView;  // an image of the rig's bits
inline SensorView view_of(const images::SensorImage& image) {
  return std::visit([](const auto& one) { return SensorView(one.view()); }, image);
}

class LineFinder {
 public:
  explicit LineFinder(const rig::Rig& rig);

  // Measures the columns of an image as the board does with the rig's `measure`. Throws std::invalid_argument unless it
  // has the size of the camera's sensor, or of the region that it sends while it measures; columns outside the region
  // then have no line. Pixels must be of the rig's bits: what is brighter gives wrong sums.
  void find(const SensorView& image);

  // What a profile with a reference everywhere says of a column; valid if it has a line.
  [[nodiscard]] Validity validity(std::size_t column) const;
  [[nodiscard]] bool has_line(std::size_t column) const { return validity(column) == Validity::valid; }
  // C of its line, rows of the sensor from 1 (3.2), and the line's light, M0.
  [[nodiscard]] double centroid(std::size_t column) const {
    return row_offset_ + static_cast<double>(runs_.moments.m1[column]) / runs_.moments.m0[column];
  }
  [[nodiscard]] double light(std::size_t column) const { return runs_.moments.m0[column]; }
  [[nodiscard]] std::size_t columns() const { return runs_.moments.m0.size(); }

  // The light below which what a column shows in a sweep is no line, where `most` is the most that it shows in any
  // image of it. A rig that selects the strongest run takes a reflection for the line where the line itself is not in
  // the image. Its share of the light gives it away, as it does where both are in the image.
  [[nodiscard]] double least_light(double most) const { return least_share_ * most; }

 private:
  rig::RigCamera camera_;
  model::Measure measure_;
  rig::RigMeasure rig_measure_;
  LineRules rules_;
  int row_offset_ = 0;  // of the image found last
  double least_share_;
  model::Runs runs_;
};

}  // namespace selfproj::light_section

#endif  // SELFPROJ_HOST_LIGHT_SECTION_LINE_FINDER_H
