#include "host/structured_light/self_reference_file.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/user_error.h"
#include "host/images/float_image.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/rig/geometry_keys.h"
#include "host/rig/yaml_document.h"

namespace selfproj {
namespace {

namespace fs = std::filesystem;

constexpr int kVersion = 1;

std::string code_name(StripeCode code) { return code == StripeCode::cyclic ? "cyclic" : "reflected"; }

std::string codes_png(const SelfReference& reference) {
  const FloatImage& line = reference.points.line;
  cv::Mat codes(line.rows, line.columns, CV_16UC1);
  for (int r = 0; r < line.rows; ++r) {
    const int code = code_of_cell(reference.stripes, cell_of_row(r, line.rows, reference.stripes.width));
    std::transform(line.row(r), line.row(r) + line.columns, codes.ptr<std::uint16_t>(r), [code](float value) {
      return std::isnan(value) ? std::uint16_t{0} : static_cast<std::uint16_t>(code);
    });
  }
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", codes, bytes)) {
    throw std::runtime_error("c_r.png cannot be written");
  }
  return {bytes.begin(), bytes.end()};
}

std::string file_in(const std::string& folder, const std::string& name) { return (fs::path(folder) / name).string(); }

// Where each camera pixel lies in the projector: NaN, or in one of its `count` lines (or columns). Gaps that are filled
// at its border may lie outside, by less than its size.
void check_places(const std::string& folder, const std::string& name, const FloatImage& image, int count) {
  const auto size = static_cast<float>(count);
  if (!std::all_of(image.values.begin(), image.values.end(),
                   [size](float value) { return std::isnan(value) || (value > -size && value < 2 * size); })) {
    throw UserError(file_in(folder, name), "is damaged: a camera pixel sees what is not in the projector's image");
  }
}

FloatImage read_map(const std::string& folder, const std::string& name, int rows, int columns) {
  const std::string file = file_in(folder, name);
  FloatImage image = read_float_tiff(file);
  if (image.rows != rows || image.columns != columns) {
    throw UserError(
        file, fmt::format("is {}; the rig's is {}", size_text(image.rows, image.columns), size_text(rows, columns)));
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
    const std::optional<T> number = number_of_text<T>(value.Scalar());
    if (!number) {
      throw UserError(file, fmt::format("is damaged: {} is '{}', which is no such number", key, value.Scalar()));
    }
    return *number;
  }
}

Stripes read_head(const Rig& rig, const std::string& folder) {
  const std::string file = file_in(folder, "reference.yaml");
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw UserError(folder, fs::exists(folder, error) ? "is not a folder" : "there is no such folder");
  }
  if (!fs::is_regular_file(file, error)) {
    throw UserError(folder, "is not a reference of stripes; `selfproj pattern stripes` writes reference.yaml");
  }
  const YAML::Node node = parse_yaml(read_input(file, kMostTextBytes), file);
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
  for (const auto& [key, here] : geometry_of(rig)) {
    const auto there = value_of<double>(geometry, file, key);
    if (!same_geometry(there, here)) {
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

void write_self_reference(const Rig& rig, const SelfReference& reference, OutputFolder& folder) {
  std::string head = fmt::format("selfproj_stripes: {}\nbits: {}\nrows_per_code: {}\ncode: {}\ngeometry:\n", kVersion,
                                 reference.stripes.bits, reference.stripes.width, code_name(reference.stripes.code));
  for (const auto& [key, value] : geometry_of(rig)) {
    head += fmt::format("  {}: {}\n", key, value);
  }
  folder.append("reference.yaml", head);
  const auto add_map = [&](const std::string& name, const FloatImage& image) {
    folder.append(name, encode_float_tiff(folder.name() + "/" + name, image));
  };
  add_map("x_r_line.tiff", reference.points.line);
  add_map("x_r_column.tiff", reference.points.column);
  add_map("f_r_row.tiff", reference.row);
  add_map("f_r_column.tiff", reference.column);
  constexpr std::uint8_t kYes = 255;
  Image seen{reference.row.rows, reference.row.columns, reference.seen};
  std::transform(seen.pixels.begin(), seen.pixels.end(), seen.pixels.begin(),
                 [](std::uint8_t value) { return value != 0 ? kYes : std::uint8_t{0}; });
  folder.append("f_r_seen.png", encode_png(seen));
  folder.append("c_r.png", codes_png(reference));
  Image measurable{rig.camera.rows, rig.camera.columns, std::vector<std::uint8_t>(reference.points.line.values.size())};
  for (std::size_t i = 0; i < measurable.pixels.size(); ++i) {
    measurable.pixels[i] = reference.measurable(i) ? kYes : std::uint8_t{0};
  }
  folder.append("a_r.png", encode_png(measurable));
  for (int i = 0; i < 2 * reference.stripes.bits; ++i) {
    const FloatImage pattern = self_projected_pattern(reference, i);
    Image image{pattern.rows, pattern.columns, std::vector<std::uint8_t>(pattern.values.size())};
    std::transform(pattern.values.begin(), pattern.values.end(), image.pixels.begin(),
                   [](float value) { return value > 0.5F ? kYes : std::uint8_t{0}; });
    folder.append(fmt::format("pattern_{:02}.png", i), encode_png(image));
  }
}

SelfReference read_self_reference(const Rig& rig, const std::string& folder) {
  SelfReference reference;
  reference.stripes = read_head(rig, folder);
  reference.camera_rows = rig.camera.rows;
  reference.points.line = read_map(folder, "x_r_line.tiff", rig.camera.rows, rig.camera.columns);
  reference.points.column = read_map(folder, "x_r_column.tiff", rig.camera.rows, rig.camera.columns);
  check_places(folder, "x_r_line.tiff", reference.points.line, rig.projector.lines);
  check_places(folder, "x_r_column.tiff", reference.points.column, rig.projector.columns);
  reference.row = read_map(folder, "f_r_row.tiff", rig.projector.lines, rig.projector.columns);
  reference.column = read_map(folder, "f_r_column.tiff", rig.projector.lines, rig.projector.columns);
  const Image seen = read_image(file_in(folder, "f_r_seen.png"), std::nullopt);
  if (seen.rows != rig.projector.lines || seen.columns != rig.projector.columns) {
    throw UserError(file_in(folder, "f_r_seen.png"),
                    fmt::format("is {}; the rig's is {}", size_text(seen.rows, seen.columns),
                                size_text(rig.projector.lines, rig.projector.columns)));
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

}  // namespace selfproj
