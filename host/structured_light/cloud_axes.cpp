#include "host/structured_light/cloud_axes.h"

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "host/files/numbers.h"

namespace selfproj::structured_light {

std::optional<OtherAxes> other_axes(const NearestPoint& nearest, const std::vector<Point3f>& cloud) {
  constexpr std::size_t kPoints = 2000;
  constexpr double kMuchNearer = 0.2;
  const std::size_t every = cloud.size() / kPoints + 1;
  const auto median = [&](const CloudAxes& axes) {
    std::vector<double> distances;
    for (std::size_t i = 0; i < cloud.size(); i += every) {
      distances.push_back(nearest.distance(axes.of(cloud[i])));
    }
    return files::median_of(std::move(distances));
  };
  const double as_they_are = median({});
  double least = kMuchNearer * as_they_are;
  std::optional<OtherAxes> found;
  for (const CloudAxes axes : {CloudAxes{true, false}, {false, true}, {true, true}}) {
    if (const double other = median(axes); other < least) {
      least = other;
      found = {axes, other, as_they_are};
    }
  }
  return found;
}

}  // namespace selfproj::structured_light
