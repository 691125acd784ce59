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
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/little_endian.h"

namespace selfproj::structured_light {
namespace {

constexpr double kFar = 1e9;
constexpr double kNoDistance = std::numeric_limits<double>::quiet_NaN();

// A scalar type of PLY files.
struct PlyType {
  std::size_t size;
  enum class Kind : std::uint8_t { natural, integer, real } kind;
};

// One of the properties of each vertex, in its order.
struct PlyProperty {
  std::string name;
  PlyType type;
  std::size_t offset;  // in the bytes of a vertex
};

// Where the vertices are in a PLY file.
struct PlyLayout {
  enum class Format : std::uint8_t { text, little, big } format = Format::text;
  std::size_t header = 0;  // bytes
  std::size_t count = 0;
  std::size_t stride = 0;  // bytes of a vertex
  std::vector<PlyProperty> properties;
  std::array<std::size_t, 3> axes{};  // which of them are x, y, z
};

std::size_t end_of_header(const std::string& bytes) {
  const std::size_t end = bytes.find("\nend_header");
  const std::size_t line = end == std::string::npos ? end : bytes.find('\n', end + 1);
  const bool begins = bytes.starts_with("ply\n") || bytes.starts_with("ply\r\n");
  return begins && line != std::string::npos ? line + 1 : std::string::npos;
}

PlyLayout layout_of(const std::string& file, const std::string& bytes) {
  using enum PlyType::Kind;
  static const std::map<std::string, PlyType> types{
      {"char", {1, integer}},  {"uchar", {1, natural}},  {"int8", {1, integer}},  {"uint8", {1, natural}},
      {"short", {2, integer}}, {"ushort", {2, natural}}, {"int16", {2, integer}}, {"uint16", {2, natural}},
      {"int", {4, integer}},   {"uint", {4, natural}},   {"int32", {4, integer}}, {"uint32", {4, natural}},
      {"float", {4, real}},    {"float32", {4, real}},   {"double", {8, real}},   {"float64", {8, real}}};
  static const std::map<std::string, PlyLayout::Format> formats{{"ascii", PlyLayout::Format::text},
                                                                {"binary_little_endian", PlyLayout::Format::little},
                                                                {"binary_big_endian", PlyLayout::Format::big}};
  PlyLayout layout;
  layout.header = end_of_header(bytes);
  if (layout.header == std::string::npos) {
    throw UserError(file, "is not a PLY file");
  }
  std::istringstream lines(bytes.substr(0, layout.header));
  std::string line;
  int elements = 0;
  bool known = false;
  bool vertices = false;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string word;
    std::string type;
    std::string name;
    words >> word >> type >> name;
    if (word == "format") {
      const auto format = formats.find(type);
      known = format != formats.end();
      layout.format = known ? format->second : layout.format;
    } else if (word == "element") {
      ++elements;
      if (elements == 1) {
        layout.count = files::number_of_text<std::size_t>(name).value_or(0);
        vertices = type == "vertex";
      }
    } else if (word == "property" && elements == 1 && vertices) {
      const auto found = types.find(type);
      if (found == types.end()) {
        throw UserError(file, "has a vertex property of type " + type);
      }
      layout.properties.push_back({name, found->second, layout.stride});
      layout.stride += found->second.size;
    }
  }
  for (std::size_t axis = 0; axis < layout.axes.size(); ++axis) {
    const auto found = std::find_if(layout.properties.begin(), layout.properties.end(), [axis](const PlyProperty& p) {
      return p.name.size() == 1 && p.name[0] == static_cast<char>('x' + axis);
    });
    vertices = vertices && found != layout.properties.end();
    layout.axes[axis] = static_cast<std::size_t>(found - layout.properties.begin());
  }
  if (!known || !vertices) {
    throw UserError(file, "is not a PLY of a known format that begins with vertices with x, y, z");
  }
  return layout;
}

// The number at this place; its bytes are within the text.
double number_at(const std::string& bytes, std::size_t at, PlyType type, PlyLayout::Format format) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < type.size; ++i) {
    const std::size_t place = format == PlyLayout::Format::big ? i : type.size - 1 - i;
    value = value << 8U | static_cast<std::uint8_t>(bytes[at + place]);
  }
  switch (type.kind) {
    case PlyType::Kind::natural:
      return static_cast<double>(value);
    case PlyType::Kind::integer: {
      const auto unused = static_cast<unsigned>(64 - 8 * std::max<std::size_t>(type.size, 1));
      return static_cast<double>(static_cast<std::int64_t>(value << unused) >> unused);
    }
    case PlyType::Kind::real:
      return type.size == 4 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(value)))
                            : std::bit_cast<double>(value);
  }
  return 0;
}

// Calls add(x, y, z) for each vertex.
template <class Add>
void vertices_of_bytes(const std::string& file, const std::string& bytes, const PlyLayout& layout, const Add& add) {
  if ((bytes.size() - layout.header) / layout.stride < layout.count) {
    throw UserError(file, "is truncated");
  }
  std::array<double, 3> point{};
  for (std::size_t i = 0; i < layout.count; ++i) {
    for (std::size_t axis = 0; axis < point.size(); ++axis) {
      const PlyProperty& property = layout.properties[layout.axes[axis]];
      point[axis] = number_at(bytes, layout.header + i * layout.stride + property.offset, property.type, layout.format);
    }
    add(point);
  }
}

template <class Add>
void vertices_of_text(const std::string& file, const std::string& bytes, const PlyLayout& layout, const Add& add) {
  constexpr std::string_view kSpaces = " \t\r\n";
  std::string_view left = std::string_view(bytes).substr(layout.header);
  std::array<double, 3> point{};
  for (std::size_t i = 0; i < layout.count; ++i) {
    for (std::size_t which = 0; which < layout.properties.size(); ++which) {
      left.remove_prefix(std::min(left.find_first_not_of(kSpaces), left.size()));
      const std::string_view word = left.substr(0, left.find_first_of(kSpaces));
      if (word.empty()) {
        throw UserError(file, "is truncated");
      }
      left.remove_prefix(word.size());
      const auto* const axis = std::find(layout.axes.begin(), layout.axes.end(), which);
      if (axis != layout.axes.end()) {
        const std::optional<double> value = files::number_of_text<double>(word);
        if (!value) {
          const bool is_text = std::all_of(word.begin(), word.end(), [](char c) { return c > ' ' && c <= '~'; });
          throw UserError(file, "vertex " + std::to_string(i + 1) + ": " +
                                    (is_text ? "'" + std::string(word) + "'" : "this") + " is not a coordinate");
        }
        point[static_cast<std::size_t>(axis - layout.axes.begin())] = *value;
      }
    }
    add(point);
  }
}

}  // namespace

void PlyText::add(const Point3f& point, std::uint8_t red, std::uint8_t green, std::uint8_t blue, float intensity,
                  float quality) {
  std::array<std::uint8_t, kBytes> vertex{};
  std::uint8_t* at = vertex.data();
  for (const float value : {point.x, point.y, point.z}) {
    model::store_little_endian(at, std::bit_cast<std::uint32_t>(value));
    at += sizeof(float);
  }
  std::copy_n(std::array{red, green, blue}.begin(), 3, at);
  vertices_.append(vertex.begin(), vertex.end());
  if (measured_) {
    std::array<std::uint8_t, 2 * sizeof(float)> more{};
    model::store_little_endian(more.data(), std::bit_cast<std::uint32_t>(intensity));
    model::store_little_endian(more.data() + sizeof(float), std::bit_cast<std::uint32_t>(quality));
    vertices_.append(more.begin(), more.end());
  }
  ++count_;
}

std::string PlyText::file(const std::string& comment) const {
  return "ply\nformat binary_little_endian 1.0\ncomment " + comment + "\nelement vertex " + std::to_string(count_) +
         "\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\n" +
         (measured_ ? "property float intensity\nproperty float quality\n" : "") + "end_header\n" + vertices_;
}

std::vector<Point3f> read_ply(const std::string& file) {
  const std::string bytes = files::read_input(file, files::kMostTableBytes);
  const PlyLayout layout = layout_of(file, bytes);
  std::vector<Point3f> points;
  points.reserve(std::min(layout.count, bytes.size()));
  const auto add = [&](const std::array<double, 3>& point) {
    for (const double value : point) {
      if (!(std::abs(value) <= kFar)) {
        throw UserError(file, "has a coordinate that is not finite, or beyond 1e9");
      }
    }
    points.push_back({static_cast<float>(point[0]), static_cast<float>(point[1]), static_cast<float>(point[2])});
  };
  if (layout.format == PlyLayout::Format::text) {
    vertices_of_text(file, bytes, layout, add);
  } else {
    vertices_of_bytes(file, bytes, layout, add);
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
