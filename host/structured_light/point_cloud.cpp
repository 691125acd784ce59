#include "host/structured_light/point_cloud.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/user_error.h"

namespace selfproj {
namespace {

void append(std::string& to, float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (unsigned shift = 0; shift < 32; shift += 8) {
    to.push_back(static_cast<char>((bits >> shift) & 0xFFU));
  }
}

float float_at(const std::string& bytes, std::size_t at) {
  std::uint32_t bits = 0;
  for (unsigned i = 0; i < 4; ++i) {
    bits |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(bytes[at + i])) << (8 * i);
  }
  return std::bit_cast<float>(bits);
}

constexpr float kFar = 1e9F;
constexpr double kNoDistance = std::numeric_limits<double>::quiet_NaN();

float along(const Point3f& point, int axis) { return axis == 0 ? point.x : axis == 1 ? point.y : point.z; }

// Where the vertices are in a PLY file.
struct PlyLayout {
  std::size_t header = 0;  // bytes
  std::size_t count = 0;
  std::size_t stride = 0;
  std::map<std::string, std::size_t> floats;  // offsets of float properties
};

PlyLayout layout_of(const std::string& file, const std::string& bytes) {
  static const std::map<std::string, std::size_t> sizes{{"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},
                                                        {"short", 2}, {"ushort", 2},  {"int16", 2},  {"uint16", 2},
                                                        {"int", 4},   {"uint", 4},    {"int32", 4},  {"uint32", 4},
                                                        {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const std::string last = "end_header\n";
  const std::size_t end = bytes.find(last);
  if (bytes.compare(0, 4, "ply\n") != 0 || end == std::string::npos) {
    throw UserError(file, "is not a PLY file");
  }
  PlyLayout layout;
  layout.header = end + last.size();
  std::istringstream lines(bytes.substr(0, end));
  std::string line;
  int elements = 0;
  bool binary = false;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string word;
    std::string type;
    std::string name;
    words >> word >> type >> name;
    if (word == "format") {
      binary = type == "binary_little_endian";
    } else if (word == "element") {
      ++elements;
      if (elements == 1) {
        layout.count = number_of_text<std::size_t>(name).value_or(0);
        binary = binary && type == "vertex";
      }
    } else if (word == "property" && elements == 1) {
      const auto size = sizes.find(type);
      if (size == sizes.end()) {
        throw UserError(file, "has a vertex property of type " + type);
      }
      if (type == "float" || type == "float32") {
        layout.floats[name] = layout.stride;
      }
      layout.stride += size->second;
    }
  }
  if (!binary || layout.floats.count("x") + layout.floats.count("y") + layout.floats.count("z") != 3) {
    throw UserError(file, "is not a binary little-endian PLY that begins with vertices of floats x, y, z");
  }
  if ((bytes.size() - layout.header) / layout.stride < layout.count) {
    throw UserError(file, "is truncated");
  }
  return layout;
}

}  // namespace

void PlyText::add(const Point3f& point, std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  for (const float value : {point.x, point.y, point.z}) {
    append(vertices_, value);
  }
  for (const std::uint8_t value : {red, green, blue}) {
    vertices_.push_back(static_cast<char>(value));
  }
  ++count_;
}

std::string PlyText::file(const std::string& comment) const {
  return "ply\nformat binary_little_endian 1.0\ncomment " + comment + "\nelement vertex " + std::to_string(count_) +
         "\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n" +
         vertices_;
}

std::vector<Point3f> read_ply(const std::string& file) {
  const std::string bytes = read_input(file, kMostTableBytes);
  const PlyLayout layout = layout_of(file, bytes);
  std::vector<Point3f> points(layout.count);
  std::size_t at = layout.header;
  for (Point3f& point : points) {
    point = {float_at(bytes, at + layout.floats.at("x")), float_at(bytes, at + layout.floats.at("y")),
             float_at(bytes, at + layout.floats.at("z"))};
    at += layout.stride;
    for (const float value : {point.x, point.y, point.z}) {
      if (!(std::abs(value) <= kFar)) {
        throw UserError(file, "has a coordinate that is not finite, or beyond 1e9");
      }
    }
  }
  return points;
}

NearestPoint::NearestPoint(std::vector<Point3f> points) : points_(std::move(points)) { build(0, points_.size(), 0); }

void NearestPoint::build(std::size_t first, std::size_t last, int axis) {
  if (last - first < 2) {
    return;
  }
  const std::size_t middle = first + (last - first) / 2;
  const auto at = [this](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(last),
                   [axis](const Point3f& a, const Point3f& b) { return along(a, axis) < along(b, axis); });
  build(first, middle, (axis + 1) % 3);
  build(middle + 1, last, (axis + 1) % 3);
}

// `best` is a squared distance.
void NearestPoint::search(std::size_t first, std::size_t last, int axis, const Point3f& point, float& best) const {
  if (first == last) {
    return;
  }
  const std::size_t middle = first + (last - first) / 2;
  const Point3f& node = points_[middle];
  const float dx = node.x - point.x;
  const float dy = node.y - point.y;
  const float dz = node.z - point.z;
  best = std::min(best, dx * dx + dy * dy + dz * dz);
  const float side = along(point, axis) - along(node, axis);
  const int next = (axis + 1) % 3;
  const bool below = side < 0;
  below ? search(first, middle, next, point, best) : search(middle + 1, last, next, point, best);
  if (side * side < best) {
    below ? search(middle + 1, last, next, point, best) : search(first, middle, next, point, best);
  }
}

double NearestPoint::distance(const Point3f& point) const {
  float best = std::numeric_limits<float>::infinity();
  search(0, points_.size(), 0, point, best);
  return std::sqrt(static_cast<double>(best));
}

CloudComparison compare_clouds(const std::vector<Point3f>& ours, const std::vector<Point3f>& theirs, double within_mm) {
  CloudComparison result{ours.size(), theirs.size(), kNoDistance, kNoDistance, kNoDistance};
  if (ours.empty() || theirs.empty()) {
    return result;
  }
  const auto distances = [](const std::vector<Point3f>& from, const std::vector<Point3f>& to) {
    const NearestPoint nearest(to);
    std::vector<double> all;
    std::transform(from.begin(), from.end(), std::back_inserter(all),
                   [&nearest](const Point3f& point) { return nearest.distance(point); });
    return all;
  };
  const auto share = [within_mm](const std::vector<double>& all) {
    const auto near = std::count_if(all.begin(), all.end(), [&](double distance) { return distance <= within_mm; });
    return static_cast<double>(near) / static_cast<double>(all.size());
  };
  std::vector<double> to_theirs = distances(ours, theirs);
  result.ours_within = share(to_theirs);
  result.theirs_within = share(distances(theirs, ours));
  const auto middle = to_theirs.begin() + static_cast<std::ptrdiff_t>(to_theirs.size() / 2);
  std::nth_element(to_theirs.begin(), middle, to_theirs.end());
  result.median_mm = *middle;
  return result;
}

}  // namespace selfproj
