// Point clouds: PLY files, and how far two clouds lie apart.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_POINT_CLOUD_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_POINT_CLOUD_H

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/structured_light/triangulation.h"

namespace selfproj {

// Binary PLY, little endian: x, y, z as 32-bit floats in mm, red, green, blue as bytes. Text that is a file's content.
class PlyText {
 public:
  // Room for so many points.
  explicit PlyText(std::size_t points) { vertices_.reserve(points * kBytes); }

  void add(const Point3f& point, std::uint8_t red, std::uint8_t green, std::uint8_t blue);

  // The whole file; `comment` (one line) says what it is.
  [[nodiscard]] std::string file(const std::string& comment) const;

 private:
  static constexpr std::size_t kBytes = 15;
  std::size_t count_ = 0;
  std::string vertices_;
};

// The vertices of a binary PLY file, little endian, whose first element is vertex with float properties x, y, z and
// others of any scalar type. Throws UserError, naming the file: unreadable, no such PLY, cut short.
std::vector<Point3f> read_ply(const std::string& file);

// Finds the nearest of many points: a tree of planes.
class NearestPoint {
 public:
  explicit NearestPoint(std::vector<Point3f> points);

  // Distance in mm to the nearest point; infinite where there are none.
  [[nodiscard]] double distance(const Point3f& point) const;

 private:
  void build(std::size_t first, std::size_t last, int axis);
  void search(std::size_t first, std::size_t last, int axis, const Point3f& point, float& best) const;
  std::vector<Point3f> points_;  // the middle one of a range halves it along the axis, x, y and z in turn
};

// What lies between two clouds; NaN where one of them is empty.
struct CloudComparison {
  std::size_t ours = 0;
  std::size_t theirs = 0;
  double median_mm = 0;      // of our points' distances to the nearest of theirs
  double ours_within = 0;    // share of our points with one of theirs within `within_mm`
  double theirs_within = 0;  // share of their points with one of ours
};
CloudComparison compare_clouds(const std::vector<Point3f>& ours, const std::vector<Point3f>& theirs, double within_mm);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_POINT_CLOUD_H
