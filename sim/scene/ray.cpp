#include "sim/scene/ray.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "sim/scene/scene.h"

namespace selfproj {
namespace {

struct Segment {
  double low, high;  // heights
};

// Segments still to be examined. They are halves of halves; 64 halvings suffice for any size and tolerance.
class Segments {
 public:
  void push(Segment segment) { segments_[count_++] = segment; }
  bool pop(Segment& segment) {
    if (count_ == 0) {
      return false;
    }
    segment = segments_[--count_];
    return true;
  }

 private:
  std::array<Segment, 64> segments_;
  std::size_t count_ = 0;
};

HeightRange bounds(const Scene& scene, const HeightRay& ray, double t, Segment s) {
  const double xa = ray.x + ray.dx * s.low;
  const double xb = ray.x + ray.dx * s.high;
  const double ya = ray.y + ray.dy * s.low;
  const double yb = ray.y + ray.dy * s.high;
  return scene.range({std::min(xa, xb), std::max(xa, xb), std::min(ya, yb), std::max(ya, yb)}, t, t);
}

double height_under(const Scene& scene, const HeightRay& ray, double t, double h) {
  return scene.height(ray.x + ray.dx * h, ray.y + ray.dy * h, t);
}

// Whether the bounds shrank the segment too little for another try without halving it.
bool shrinks_slowly(Segment before, Segment after) { return after.high - after.low > 0.5 * (before.high - before.low); }

}  // namespace

double first_hit(const Scene& scene, const HeightRay& ray, double t, double low, double high) {
  Segments rest;
  Segment s{low, high};
  for (;;) {
    const HeightRange range = bounds(scene, ray, t, s);
    if (range.low >= s.high) {
      return s.high;  // already below the surface where the segment begins
    }
    const Segment shrunk{std::max(s.low, range.low), std::min(s.high, range.high)};
    const bool surely = range.low >= s.low;
    bool nothing = shrunk.high < shrunk.low;
    if (!nothing && shrunk.high - shrunk.low <= kHeightTolerance) {
      const double middle = (shrunk.low + shrunk.high) / 2;
      if (surely || height_under(scene, ray, t, shrunk.high) >= shrunk.low) {
        return middle;
      }
      nothing = true;
    }
    if (nothing) {
      if (!rest.pop(s)) {
        return low;
      }
    } else if (shrinks_slowly(s, shrunk)) {
      const double middle = (shrunk.low + shrunk.high) / 2;
      rest.push({shrunk.low, middle});
      s = {middle, shrunk.high};
    } else {
      s = shrunk;
    }
  }
}

bool is_blocked(const Scene& scene, const HeightRay& ray, double t, double low, double high) {
  Segments rest;
  Segment s{low, high};
  do {
    for (;;) {
      const HeightRange range = bounds(scene, ray, t, s);
      if (range.high <= s.low) {
        break;
      }
      const Segment shrunk{s.low, std::min(s.high, range.high)};
      if (range.low >= shrunk.high) {
        return true;
      }
      if (shrunk.high - shrunk.low <= kHeightTolerance) {
        if (height_under(scene, ray, t, shrunk.low) > shrunk.high) {
          return true;
        }
        break;
      }
      if (shrinks_slowly(s, shrunk)) {
        const double middle = (shrunk.low + shrunk.high) / 2;
        rest.push({middle, shrunk.high});
        s = {shrunk.low, middle};
      } else {
        s = shrunk;
      }
    }
  } while (rest.pop(s));
  return false;
}

}  // namespace selfproj
