#include "selfproj/structured_light/point_cloud.h"

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
#include <memory>
#include <nanoflann.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/little_endian.h"

namespace selfproj::structured_light {
namespace {

float float_at(const std::string& bytes, std::size_t at) {
  std::array<std::uint8_t, sizeof(float)> little{};
  std::memcpy(little.data(), bytes.data() + at, little.size());
  return std::bit_cast<float>(model::load_little_endian<std::uint32_t>(little.data()));
}

constexpr float kFar = 1e9F;
constexpr double kNoDistance = std::numeric_limits<double>::quiet_NaN();

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
        layout.count = files::number_of_text<std::size_t>(name).value_or(0);
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
  std::array<std::uint8_t, kBytes> vertex{};
  std::uint8_t* at = vertex.data();
  for (const float value : {point.x, point.y, point.z}) {
    model::store_little_endian(at, std::bit_cast<std::uint32_t>(value));
    at += sizeof(float);
  }
  std::copy_n(std::array{red, green, blue}.begin(), 3, at);
  vertices_.append(vertex.begin(), vertex.end());
  ++count_;
}

std::string PlyText::file(const std::string& comment) const {
  return "ply\nformat binary_little_endian 1.0\ncomment " + comment + "\nelement vertex " + std::to_string(count_) +
         "\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n" +
         vertices_;
}

std::vector<Point3f> read_ply(const std::string& file) {
  const std::string bytes = files::read_input(file, files::kMostTableBytes);
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

// The points in the form that nanoflann asks for, and its tree over them.
struct NearestPoint::Tree {
  using Metric = nanoflann::L2_Simple_Adaptor<float, Tree, float, std::uint32_t>;
  using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, Tree, 3, std::uint32_t>;

  explicit Tree(std::vector<Point3f> all) : points(std::move(all)), index(3, *this) {}

  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return axis == 0 ? points[i].x : axis == 1 ? points[i].y : points[i].z;
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;  // to be computed
  }

  std::vector<Point3f> points;
  Index index;
};

NearestPoint::NearestPoint(std::vector<Point3f> points) : tree_(std::make_shared<const Tree>(std::move(points))) {}

double NearestPoint::distance(const Point3f& point) const {
  const std::array<float, 3> at{point.x, point.y, point.z};
  std::uint32_t nearest = 0;
  float squared = std::numeric_limits<float>::infinity();
  if (!tree_->points.empty()) {
    tree_->index.knnSearch(at.data(), 1, &nearest, &squared);
  }
  return std::sqrt(static_cast<double>(squared));
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

}  // namespace selfproj::structured_light
