// Point clouds: PLY files, and how far two clouds lie apart.
#ifndef SELFPROJ_STRUCTURED_LIGHT_POINT_CLOUD_H
#define SELFPROJ_STRUCTURED_LIGHT_POINT_CLOUD_H

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

// Builds a binary little-endian PLY file: x, y, z as 32-bit floats in mm; red, green, blue as bytes; with `measured`
// also intensity and quality as 32-bit floats.
class PlyText {
 public:
  // Reserves room for this many points.
  explicit PlyText(std::size_t points, bool measured = false) : measured_(measured) {
    vertices_.reserve(points * kBytes);
  }

  void add(const Point3f& point, std::uint8_t red, std::uint8_t green, std::uint8_t blue, float intensity = 0,
           float quality = 0);

  // The whole file; `comment`, one line, says what it is.
  [[nodiscard]] std::string file(const std::string& comment) const;

 private:
  static constexpr std::size_t kBytes = 15;
  bool measured_;
  std::size_t count_ = 0;
  std::string vertices_;
};

// The vertices of a PLY file, binary of either byte order or text. Its first element must be vertex with properties x,
// y, z; all of them may have any scalar type. Throws UserError with the file if it is unreadable, no such PLY, or cut
// short.
std::vector<Point3f> read_ply(const std::string& file);

// A point whose y and z have the opposite sign, as in OpenGL.
inline Point3f from_opengl(const Point3f& point) { return {point.x, -point.y, -point.z}; }

// Finds the nearest of many points by a k-d tree (nanoflann).
class NearestPoint {
 public:
  explicit NearestPoint(std::vector<Point3f> points);

  // Distance in mm to the nearest point, computed in 32-bit floats; infinite if there are no points.
  [[nodiscard]] double distance(const Point3f& point) const;

 private:
  struct Tree;
  std::shared_ptr<const Tree> tree_;
};

// The distances between two clouds. Median and shares are NaN if one of them is empty.
struct CloudComparison {
  std::size_t ours = 0;
  std::size_t theirs = 0;
  double median_mm = 0;      // over our points, the distance to the nearest of theirs
  double ours_within = 0;    // share, 0..1, of our points with one of theirs within `within_mm`
  double theirs_within = 0;  // share of their points with one of ours
};

// Points in mm; `within_mm` >= 0. Takes time in proportion to n log n of their numbers.
CloudComparison compare_clouds(const std::vector<Point3f>& ours, const std::vector<Point3f>& theirs, double within_mm);

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_STRUCTURED_LIGHT_POINT_CLOUD_H
