// References and patterns of rigs that are more than pinholes: lenses, any pose, a laser's plane, corrected heights.
// The functions of reference.h call these; what they return is described there.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_LENS_REFERENCE_H
#define SELFPROJ_HOST_LIGHT_SECTION_LENS_REFERENCE_H

#include <optional>
#include <span>
#include <vector>

#include "host/light_section/reference_profile.h"
#include "host/rig/optics.h"
#include "host/rig/rig.h"

namespace selfproj {

// The rays of the camera's middle row, of any rig.
class MiddleRow {
 public:
  explicit MiddleRow(const Rig& rig);

  // y / z of a column from 0, also beyond the image; NaN where the lens model folds over.
  [[nodiscard]] double tan_beta(double column) const;

 private:
  RigCamera camera_;
  std::optional<RigOptics> optics_;  // none: pinholes
};

ReferenceProfile lens_reference_of_curve(const Rig& rig, const ReferenceCurve& curve);
ReferenceProfile lens_reference_of_line(const Rig& rig, double line, std::span<const double> centroid);
ReferenceProfile lens_without_residual(const Rig& rig, const ReferenceProfile& reference,
                                       std::span<const double> centroid);
std::vector<double> lens_pattern_of_curve(const Rig& rig, const ReferenceCurve& curve);

// The reference of columns that saw the projector line `line` (NaN: none) on the middle row, as a scan finds them.
ReferenceProfile lens_reference_of_scan(const Rig& rig, std::span<const double> line);

// The sheet of light through the reference of a column. Nothing if the reference is not valid there, or the projector
// cannot light it.
std::optional<LightSheet> sheet_of(const RigOptics& optics, const ReferenceProfile& reference, int column);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_LENS_REFERENCE_H
