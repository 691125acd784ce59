#include "host/structured_light/self_reference.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <opencv2/core.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/text.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/rig/geometry.h"
#include "host/rig/yaml.h"
#include "host/structured_light/check.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/optics.h"
#include "selfproj/rig/rig.h"

namespace selfproj::structured_light {

int cell_of_row(double row, int rows, int width) {
  return static_cast<int>(std::floor((row - 0.5 * (rows - 1)) / width));
}

bool is_light(const Stripes& stripes, int cell, int plane) {
  // The middle of the cell, in units of half a cell, so that all numbers are whole. Divisions round down, also below 0.
  const int period = 2 << std::max(stripes.bits, 0);  // period of u, in half cells
  const int at = 2 * cell + 1;
  const auto floor_of_quotient = [](int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); };
  const int stripe = plane == 0 && stripes.code == StripeCode::cyclic
                         ? floor_of_quotient(2 * at, period)
                         : floor_of_quotient((at << plane) + period / 2, period);
  return stripe % 2 != 0;
}

int code_of_cell(const Stripes& stripes, int cell) {
  int code = 0;
  bool bit = false;
  for (int plane = 0; plane < stripes.bits; ++plane) {
    bit = bit != is_light(stripes, cell, plane);
    code = 2 * code + (bit ? 1 : 0);
  }
  return code;
}

namespace {

// A camera pixel and the projector point that it sees.
struct Corner {
  double line, column;  // of the projector
  double camera_row, camera_column;
};

// Writes f_R within a triangle: at the projector pixels whose centres lie in it, bounds included.
void fill_triangle(const std::array<Corner, 3>& t, SelfReference& reference) {
  const double area =
      (t[1].line - t[0].line) * (t[2].column - t[0].column) - (t[2].line - t[0].line) * (t[1].column - t[0].column);
  if (std::abs(area) < 1e-9) {
    return;
  }
  const auto [low_line, high_line] = std::minmax({t[0].line, t[1].line, t[2].line});
  const auto [low_column, high_column] = std::minmax({t[0].column, t[1].column, t[2].column});
  const int line_0 = std::max(0, static_cast<int>(std::ceil(low_line)));
  const int line_1 = std::min(reference.row.rows - 1, static_cast<int>(std::floor(high_line)));
  const int column_0 = std::max(0, static_cast<int>(std::ceil(low_column)));
  const int column_1 = std::min(reference.row.columns - 1, static_cast<int>(std::floor(high_column)));
  for (int l = line_0; l <= line_1; ++l) {
    for (int c = column_0; c <= column_1; ++c) {
      const double b1 =
          ((l - t[0].line) * (t[2].column - t[0].column) - (t[2].line - t[0].line) * (c - t[0].column)) / area;
      const double b2 =
          ((t[1].line - t[0].line) * (c - t[0].column) - (l - t[0].line) * (t[1].column - t[0].column)) / area;
      constexpr double kRounding = 1e-9;
      if (b1 < -kRounding || b2 < -kRounding || b1 + b2 > 1 + kRounding) {
        continue;
      }
      const double b0 = 1 - b1 - b2;
      reference.row.row(l)[c] = static_cast<float>(b0 * t[0].camera_row + b1 * t[1].camera_row + b2 * t[2].camera_row);
      reference.column.row(l)[c] =
          static_cast<float>(b0 * t[0].camera_column + b1 * t[1].camera_column + b2 * t[2].camera_column);
    }
  }
}

void invert(SelfReference& reference) {
  constexpr double kJump = 8;
  const images::FloatImage& line = reference.points.line;
  const images::FloatImage& column = reference.points.column;
  const auto corner = [&](int r, int c) {
    return Corner{static_cast<double>(line.row(r)[c]), static_cast<double>(column.row(r)[c]), static_cast<double>(r),
                  static_cast<double>(c)};
  };
  const auto together = [](const Corner& a, const Corner& b) {  // false for NaN
    return std::abs(a.line - b.line) <= kJump && std::abs(a.column - b.column) <= kJump;
  };
  for (int r = 0; r + 1 < line.rows; ++r) {
    for (int c = 0; c + 1 < line.columns; ++c) {
      const Corner p00 = corner(r, c);
      const Corner p01 = corner(r, c + 1);
      const Corner p10 = corner(r + 1, c);
      const Corner p11 = corner(r + 1, c + 1);
      if (together(p00, p01) && together(p10, p11) && together(p00, p10) && together(p01, p11) && together(p00, p11) &&
          together(p01, p10)) {
        fill_triangle({p00, p01, p10}, reference);
        fill_triangle({p11, p10, p01}, reference);
      }
    }
  }
}

// Gives every pixel that is not `seen` a value that continues smoothly from those that are: the solution of Laplace's
// equation between them, level across the image's border. It starts from averages over larger and larger squares and
// relaxes them.
void fill_smoothly(images::FloatImage& image, const std::vector<std::uint8_t>& seen) {
  constexpr int kSweeps = 200;
  constexpr float kOver = 1.7F;  // over-relaxation
  struct Level {
    images::FloatImage sum, count;
  };
  std::vector<Level> levels(
      1, {images::FloatImage(image.rows, image.columns), images::FloatImage(image.rows, image.columns)});
  for (std::size_t i = 0; i < seen.size(); ++i) {
    levels[0].sum.values[i] = seen[i] != 0 ? image.values[i] : 0;
    levels[0].count.values[i] = seen[i] != 0 ? 1.0F : 0.0F;
  }
  while (levels.back().sum.rows > 1 || levels.back().sum.columns > 1) {
    const Level& fine = levels.back();
    const int rows = (fine.sum.rows + 1) / 2;
    const int columns = (fine.sum.columns + 1) / 2;
    Level coarse{images::FloatImage(rows, columns), images::FloatImage(rows, columns)};
    for (int r = 0; r < fine.sum.rows; ++r) {
      for (int c = 0; c < fine.sum.columns; ++c) {
        const float count = fine.count.row(r)[c];
        if (count > 0) {  // each square has the same weight
          coarse.sum.row(r / 2)[c / 2] += fine.sum.row(r)[c] / count;
          coarse.count.row(r / 2)[c / 2] += 1;
        }
      }
    }
    levels.push_back(std::move(coarse));
  }
  for (std::size_t k = levels.size() - 1; k-- > 0;) {
    Level& fine = levels[k];
    const Level& coarse = levels[k + 1];
    for (int r = 0; r < fine.sum.rows; ++r) {
      for (int c = 0; c < fine.sum.columns; ++c) {
        if (!(fine.count.row(r)[c] > 0)) {
          fine.sum.row(r)[c] = coarse.sum.row(r / 2)[c / 2] / coarse.count.row(r / 2)[c / 2];
          fine.count.row(r)[c] = 1;
        }
      }
    }
  }
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i] == 0) {
      image.values[i] = levels[0].sum.values[i];
      open.push_back(i);
    }
  }
  const auto columns = static_cast<std::size_t>(image.columns);
  const std::size_t all = image.values.size();
  std::vector<float>& v = image.values;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const std::size_t i : open) {
      const std::size_t c = i % columns;
      const float up = v[i >= columns ? i - columns : i];
      const float down = v[i + columns < all ? i + columns : i];
      const float left = v[c > 0 ? i - 1 : i];
      const float right = v[c + 1 < columns ? i + 1 : i];
      v[i] += kOver * (0.25F * (up + down + left + right) - v[i]);
    }
  }
}

// The geometry of pinholes, in their own equations.
class PinholeView {
 public:
  explicit PinholeView(const rig::Rig& rig) : rig_(rig) {}

  // z of what a camera point sees under a projector line; NaN if there is none.
  [[nodiscard]] double depth(double row, double /*column*/, int line) const {
    const double theta = rig::tan_theta(rig_.projector, line);
    const double alpha = rig::tan_alpha(rig_.camera, row + 1);                     // rows from 1
    return (rig_.projector.x_mm + rig_.projector.z_mm * theta) / (alpha + theta);  // (4.8)
  }

  // Where the camera sees what a projector pixel lights at depth z.
  [[nodiscard]] std::optional<rig::CameraPlace> seen(int line, int column, double z) const {
    const rig::RigProjector& p = rig_.projector;
    const double theta = rig::tan_theta(p, line);
    const double xp = p.center_xp_mm + p.line_pitch_mm * (line - 0.5 * (p.lines - 1));
    const double yp = p.center_yp_mm + p.column_pitch_mm * (column - 0.5 * (p.columns - 1));
    const double x = p.x_mm - (z - p.z_mm) * theta;
    const double y = (z - p.z_mm) * yp / (p.focal_length_mm * std::cos(p.tilt_rad) - xp * std::sin(p.tilt_rad));
    return rig::CameraPlace{rig::centroid_of(rig_.camera, x / z) - 1, rig::column_of(rig_.camera, y / z)};
  }

 private:
  const rig::Rig& rig_;
};

// The same through the lenses of a calibrated rig.
class LensView {
 public:
  explicit LensView(const rig::Rig& rig) : optics_(rig) {}

  [[nodiscard]] double depth(double row, double column, int line) const {
    const std::optional<cv::Vec2d> ray = optics_.ray({row, column});
    const rig::LightSheet sheet{static_cast<double>(line), 0, 0.5 * (optics_.rig().projector.columns - 1)};
    return (ray ? optics_.meet(*ray, sheet) : std::nullopt).value_or(rig::kUnknown);
  }

  [[nodiscard]] std::optional<rig::CameraPlace> seen(int line, int column, double z) const {
    const auto light = optics_.light_of({static_cast<double>(line), static_cast<double>(column)});
    const cv::Vec3d centre = optics_.projector_centre();
    if (!light || !((z - centre[2]) / (*light)[2] > 0)) {
      return std::nullopt;
    }
    return optics_.seen(centre + *light * ((z - centre[2]) / (*light)[2]));
  }

 private:
  rig::RigOptics optics_;
};

// Whether a camera point is near enough to the image to mean something.
bool is_near(const rig::RigCamera& camera, const std::optional<rig::CameraPlace>& place) {
  constexpr double kSizes = 4;
  return place && std::abs(place->row) < kSizes * camera.rows && std::abs(place->column) < kSizes * camera.columns;
}

// Continues the depth of the reference along the projector's rays. From it follows where the camera would see the
// light.
template <class View>
void fill_in(const rig::Rig& rig, const View& view, SelfReference& reference) {
  const rig::RigProjector& p = rig.projector;
  images::FloatImage depth(p.lines, p.columns);
  std::vector<std::uint8_t> known = reference.seen;
  std::size_t i = 0;
  for (int l = 0; l < p.lines; ++l) {
    for (int c = 0; c < p.columns; ++c, ++i) {
      if (known[i] != 0) {
        depth.values[i] = static_cast<float>(view.depth(static_cast<double>(reference.row.values[i]),
                                                        static_cast<double>(reference.column.values[i]), l));
        known[i] = std::isnan(depth.values[i]) ? 0 : 1;
      }
    }
  }
  check(std::find(known.begin(), known.end(), 1) != known.end(), "self reference: no projector pixel is seen");
  fill_smoothly(depth, known);
  i = 0;
  for (int l = 0; l < p.lines; ++l) {
    for (int c = 0; c < p.columns; ++c, ++i) {
      if (reference.seen[i] != 0) {
        continue;
      }
      const std::optional<rig::CameraPlace> place = view.seen(l, c, static_cast<double>(depth.values[i]));
      const bool near = is_near(rig.camera, place);
      reference.row.values[i] = near ? static_cast<float>(place->row) : images::kNoValue;
      reference.column.values[i] = near ? static_cast<float>(place->column) : images::kNoValue;
    }
  }
}

}  // namespace

bool SelfReference::measurable(std::size_t pixel) const {
  return !std::isnan(points.line.values[pixel]) && !std::isnan(points.column.values[pixel]);
}

int SelfReference::cell(int line, int projector_column) const {
  const auto place = static_cast<double>(row.row(line)[projector_column]);
  return std::isnan(place) ? kNoCell : cell_of_row(place, camera_rows, stripes.width);
}

void check_stripes(const Stripes& stripes) {
  check(stripes.bits >= 1 && stripes.bits <= Stripes::kMaxBits, "stripes: bits out of range");
  check(stripes.width >= 1 && stripes.width <= Stripes::kMaxWidth, "stripes: width out of range");
}

SelfReference make_self_reference(const rig::Rig& rig, const ProjectorPoints& points, const Stripes& stripes) {
  check_stripes(stripes);
  for (const images::FloatImage* image : {&points.line, &points.column}) {
    check(image->rows == rig.camera.rows && image->columns == rig.camera.columns,
          "self reference: the points have not the camera's size");
  }
  SelfReference reference;
  reference.stripes = stripes;
  reference.points = points;
  reference.camera_rows = rig.camera.rows;
  for (std::size_t i = 0; i < points.line.values.size(); ++i) {
    if (!reference.measurable(i)) {
      reference.points.line.values[i] = reference.points.column.values[i] = images::kNoValue;
    }
  }
  reference.row = images::FloatImage(rig.projector.lines, rig.projector.columns, images::kNoValue);
  reference.column = reference.row;
  invert(reference);
  reference.seen.resize(reference.row.values.size());
  std::transform(reference.row.values.begin(), reference.row.values.end(), reference.seen.begin(),
                 [](float value) { return std::isnan(value) ? std::uint8_t{0} : std::uint8_t{1}; });
  if (rig.is_pinholes()) {
    fill_in(rig, PinholeView(rig), reference);
  } else {
    fill_in(rig, LensView(rig), reference);
  }
  return reference;
}

images::FloatImage self_projected_pattern(const SelfReference& reference, int index) {
  check(index >= 0 && index < 2 * reference.stripes.bits, "self-projected pattern: index out of range");
  images::FloatImage pattern(reference.row.rows, reference.row.columns);
  for (int l = 0; l < pattern.rows; ++l) {
    for (int c = 0; c < pattern.columns; ++c) {
      const int cell = reference.cell(l, c);
      if (cell == kNoCell) {
        continue;
      }
      const bool light = is_light(reference.stripes, cell, index / 2);
      pattern.row(l)[c] = light == (index % 2 == 0) ? 1.0F : 0.0F;
    }
  }
  return pattern;
}

images::FloatImage scan_pattern(const rig::Rig& rig, int index) {
  const int lines = rig.projector.lines;
  const int columns = rig.projector.columns;
  check(index >= 0 && index < lines + columns, "scan pattern: index out of range");
  images::FloatImage pattern(lines, columns);
  if (index < lines) {
    std::fill_n(pattern.row(index), columns, 1.0F);
  } else {
    for (int l = 0; l < lines; ++l) {
      pattern.row(l)[index - lines] = 1;
    }
  }
  return pattern;
}

images::FloatImage gray_pattern(const rig::Rig& rig, int bits, int lines, int index) {
  check(bits >= 1 && bits <= 12, "gray pattern: bits out of range");
  check(lines >= 1 && lines <= rig.projector.lines, "gray pattern: lines out of range");
  check(index >= 0 && index < 2 * bits, "gray pattern: index out of range");
  images::FloatImage pattern(rig.projector.lines, rig.projector.columns);
  const double first = 0.5 * (rig.projector.lines - lines);
  const double height = rig::coded_height(lines, bits);
  for (int l = 0; l < pattern.rows; ++l) {
    const double y = l - first + 0.5;  // middle of the line, in lines from the first coded one
    if (y < 0 || y > lines) {
      continue;
    }
    const auto stripe = static_cast<int>(std::floor(std::ldexp(y / height, index / 2) + 0.5));
    const bool light = (stripe % 2 != 0) == (index % 2 == 0);
    std::fill_n(pattern.row(l), pattern.columns, light ? 1.0F : 0.0F);
  }
  return pattern;
}

namespace {

namespace fs = std::filesystem;

constexpr int kVersion = 1;

std::string code_name(StripeCode code) { return code == StripeCode::cyclic ? "cyclic" : "reflected"; }

std::string codes_png(const SelfReference& reference) {
  const images::FloatImage& line = reference.points.line;
  std::vector<std::uint16_t> codes;
  codes.reserve(line.values.size());
  for (int r = 0; r < line.rows; ++r) {
    const int code = code_of_cell(reference.stripes, cell_of_row(r, line.rows, reference.stripes.width));
    std::transform(line.row(r), line.row(r) + line.columns, std::back_inserter(codes), [code](float value) {
      return std::isnan(value) ? std::uint16_t{0} : static_cast<std::uint16_t>(code);
    });
  }
  return images::encode_png16(line.rows, line.columns, codes);
}

std::string file_in(const std::string& folder, const std::string& name) { return (fs::path(folder) / name).string(); }

// Where each camera pixel lies in the projector: NaN, or in one of its `count` lines (or columns). Gaps that are filled
// at its border may lie outside, by less than its size.
void check_places(const std::string& folder, const std::string& name, const images::FloatImage& image, int count) {
  const auto size = static_cast<float>(count);
  if (!std::all_of(image.values.begin(), image.values.end(),
                   [size](float value) { return std::isnan(value) || (value > -size && value < 2 * size); })) {
    throw UserError(file_in(folder, name), "is damaged: a camera pixel sees what is not in the projector's image");
  }
}

images::FloatImage read_map(const std::string& folder, const std::string& name, int rows, int columns) {
  const std::string file = file_in(folder, name);
  images::FloatImage image = images::read_float_tiff(file);
  if (image.rows != rows || image.columns != columns) {
    throw UserError(file, fmt::format("is {}; the rig's is {}", images::size_text(image.rows, image.columns),
                                      images::size_text(rows, columns)));
  }
  return image;
}

// The scalar under a key. Throws UserError if there is none.
template <class T>
T value_of(const YAML::Node& node, const std::string& file, const std::string& key) {
  const YAML::Node value = node[key];
  if (!value || !value.IsScalar()) {
    throw UserError(file, fmt::format("is damaged: {} is missing", key));
  }
  if constexpr (std::is_same_v<T, std::string>) {
    return value.Scalar();
  } else {
    const std::optional<T> number = files::number_of_text<T>(value.Scalar());
    if (!number) {
      throw UserError(file, fmt::format("is damaged: {} is '{}', which is no such number", key, value.Scalar()));
    }
    return *number;
  }
}

Stripes read_head(const rig::Rig& rig, const std::string& folder) {
  const std::string file = file_in(folder, "reference.yaml");
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw UserError(folder, fs::exists(folder, error) ? "is not a folder" : "there is no such folder");
  }
  if (!fs::is_regular_file(file, error)) {
    throw UserError(folder, "is not a reference of stripes; `selfproj pattern stripes` writes reference.yaml");
  }
  const YAML::Node node = rig::parse_yaml(files::read_text(file, files::kMostTextBytes), file);
  if (!node.IsMap()) {
    throw UserError(file, "is damaged: it has no keys");
  }
  const int version = value_of<int>(node, file, "selfproj_stripes");
  if (version != kVersion) {
    throw UserError(file, fmt::format("is of version {}; this program reads version {}", version, kVersion));
  }
  const YAML::Node geometry = node["geometry"];
  if (!geometry || !geometry.IsMap()) {
    throw UserError(file, "is damaged: geometry is missing");
  }
  for (const auto& [key, here] : rig::geometry_of(rig)) {
    const auto there = value_of<double>(geometry, file, key);
    if (!rig::same_geometry(there, here)) {
      throw UserError(file, fmt::format("was made for another rig: {} is {} there and {} here", key, there, here));
    }
  }
  const auto code = value_of<std::string>(node, file, "code");
  if (code != "cyclic" && code != "reflected") {
    throw UserError(file, fmt::format("is damaged: code is '{}'", code));
  }
  const Stripes stripes{value_of<int>(node, file, "bits"), value_of<int>(node, file, "rows_per_code"),
                        code == "cyclic" ? StripeCode::cyclic : StripeCode::reflected};
  try {
    check_stripes(stripes);
  } catch (const std::invalid_argument& e) {
    throw UserError(file, e.what());
  }
  return stripes;
}

}  // namespace

void write_self_reference(const rig::Rig& rig, const SelfReference& reference, files::OutputFolder& folder,
                          const std::string& inner) {
  std::string head = fmt::format("selfproj_stripes: {}\nbits: {}\nrows_per_code: {}\ncode: {}\ngeometry:\n", kVersion,
                                 reference.stripes.bits, reference.stripes.width, code_name(reference.stripes.code));
  for (const auto& [key, value] : rig::geometry_of(rig)) {
    head += fmt::format("  {}: {}\n", key, value);
  }
  folder.append(inner + "reference.yaml", head);
  const auto add_map = [&](const std::string& name, const images::FloatImage& image) {
    folder.append(inner + name, images::encode_float_tiff(folder.name() + "/" + name, image));
  };
  add_map("x_r_line.tiff", reference.points.line);
  add_map("x_r_column.tiff", reference.points.column);
  add_map("f_r_row.tiff", reference.row);
  add_map("f_r_column.tiff", reference.column);
  constexpr std::uint8_t kYes = 255;
  images::Image seen{reference.row.rows, reference.row.columns, reference.seen};
  std::transform(seen.pixels.begin(), seen.pixels.end(), seen.pixels.begin(),
                 [](std::uint8_t value) { return value != 0 ? kYes : std::uint8_t{0}; });
  folder.append(inner + "f_r_seen.png", images::encode_png(seen));
  folder.append(inner + "c_r.png", codes_png(reference));
  images::Image measurable{rig.camera.rows, rig.camera.columns,
                           std::vector<std::uint8_t>(reference.points.line.values.size())};
  for (std::size_t i = 0; i < measurable.pixels.size(); ++i) {
    measurable.pixels[i] = reference.measurable(i) ? kYes : std::uint8_t{0};
  }
  folder.append(inner + "a_r.png", images::encode_png(measurable));
  for (int i = 0; i < 2 * reference.stripes.bits; ++i) {
    const images::FloatImage pattern = self_projected_pattern(reference, i);
    images::Image image{pattern.rows, pattern.columns, std::vector<std::uint8_t>(pattern.values.size())};
    std::transform(pattern.values.begin(), pattern.values.end(), image.pixels.begin(),
                   [](float value) { return value > 0.5F ? kYes : std::uint8_t{0}; });
    folder.append(fmt::format("{}pattern_{:02}.png", inner, i), images::encode_png(image));
  }
}

SelfReference read_self_reference(const rig::Rig& rig, const std::string& folder) {
  SelfReference reference;
  reference.stripes = read_head(rig, folder);
  reference.camera_rows = rig.camera.rows;
  reference.points.line = read_map(folder, "x_r_line.tiff", rig.camera.rows, rig.camera.columns);
  reference.points.column = read_map(folder, "x_r_column.tiff", rig.camera.rows, rig.camera.columns);
  check_places(folder, "x_r_line.tiff", reference.points.line, rig.projector.lines);
  check_places(folder, "x_r_column.tiff", reference.points.column, rig.projector.columns);
  reference.row = read_map(folder, "f_r_row.tiff", rig.projector.lines, rig.projector.columns);
  reference.column = read_map(folder, "f_r_column.tiff", rig.projector.lines, rig.projector.columns);
  const images::Image seen = images::read_image(file_in(folder, "f_r_seen.png"), std::nullopt);
  if (seen.rows != rig.projector.lines || seen.columns != rig.projector.columns) {
    throw UserError(file_in(folder, "f_r_seen.png"),
                    fmt::format("is {}; the rig's is {}", images::size_text(seen.rows, seen.columns),
                                images::size_text(rig.projector.lines, rig.projector.columns)));
  }
  for (const std::uint8_t value : seen.pixels) {
    reference.seen.push_back(value != 0 ? 1 : 0);
  }
  // A pixel that the camera does not see may be without a place, which is then without both numbers.
  for (const auto& [name, image] :
       {std::pair{"f_r_row.tiff", &reference.row}, {"f_r_column.tiff", &reference.column}}) {
    for (std::size_t i = 0; i < image->values.size(); ++i) {
      const bool none = std::isnan(reference.row.values[i]) && std::isnan(reference.column.values[i]);
      if (!(std::abs(image->values[i]) < 1e6F) && !(none && reference.seen[i] == 0)) {
        throw UserError(file_in(folder, name), "is damaged: a projector pixel has no place");
      }
    }
  }
  return reference;
}

}  // namespace selfproj::structured_light
