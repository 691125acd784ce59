// The axes that clouds of different sources have.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_CLOUD_AXES_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_CLOUD_AXES_H

#include <optional>
#include <vector>

#include "selfproj/structured_light/point_cloud.h"

namespace selfproj::structured_light {

// How a cloud is brought into the axes of another one. A rig's frame has x down the image and is left-handed, those of
// calibrations and of most others have x to the right.
struct CloudAxes {
  bool exchange_xy = false;
  bool opengl = false;  // y and z have the opposite sign

  [[nodiscard]] bool as_they_are() const { return !exchange_xy && !opengl; }
  [[nodiscard]] Point3f of(const Point3f& p) const {
    const Point3f seen = opengl ? from_opengl(p) : p;
    return exchange_xy ? Point3f{seen.y, seen.x, seen.z} : seen;
  }
};

// The median distance of a cloud to another one as it is, and in axes in which it is much less, at most a fifth.
struct OtherAxes {
  CloudAxes axes;
  double median_mm = 0;
  double as_they_are_mm = 0;
};

// Nothing where no axes bring the cloud, of which about 2000 points are looked at, much nearer. Not for empty clouds.
std::optional<OtherAxes> other_axes(const NearestPoint& nearest, const std::vector<Point3f>& cloud);

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_CLOUD_AXES_H
