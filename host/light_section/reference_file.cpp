#include "selfproj/light_section/reference_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/text.h"
#include "host/images/frame_options.h"
#include "host/rig/geometry.h"
#include "host/rig/yaml.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/column_runs.h"

namespace selfproj::light_section {
namespace {

namespace fs = std::filesystem;

// The forms of the file, for pinholes and for all other rigs.
struct Form {
  std::string_view magic;
  std::string_view columns;
  std::size_t fields;
};
constexpr Form kPinholes{"# selfproj reference 1", "column,tan_theta,z_mm,offset_px", 4};
constexpr Form kLenses{"# selfproj reference 2", "column,line,line_slope,z_mm,offset_px", 5};

constexpr std::array<std::string_view, 4> kMeasured{"# measured.select ", "# measured.gap_rows ",
                                                    "# measured.first_row ", "# measured.last_row "};

const Form& form_of(const rig::Rig& rig) { return rig.is_pinholes() ? kPinholes : kLenses; }

constexpr double kFar = 1e6;         // mm: as of the rig's own lengths
constexpr double kNear = 1e-3;       // mm
constexpr double kMaxTangent = 1e4;  // of tan θ: 89.99 degrees
constexpr double kMaxSlope = 1e4;    // lines for each column
constexpr double kMaxLine = 1e5;

// Splits a text into lines, and makes errors that name them.
class Lines {
 public:
  Lines(std::string text, std::string source) : held_(std::move(text)), text_(held_), source_(std::move(source)) {}
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  // The next line without its end; nothing after the last one. A file that ends within a line is damaged.
  std::optional<std::string_view> next() {
    if (text_.empty()) {
      return std::nullopt;
    }
    ++number_;
    const std::size_t end = text_.find('\n');
    if (end == std::string_view::npos) {
      fail("is cut off");
    }
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(end + 1);
    if (line.ends_with('\r')) {
      line.remove_suffix(1);
    }
    return line;
  }

  [[noreturn]] void fail(const std::string& reason) const {
    throw UserError(source_, fmt::format("line {}: {}", number_, reason));
  }

  [[nodiscard]] const std::string& source() const { return source_; }

 private:
  std::string held_;
  std::string_view text_;  // what is left of the text
  std::string source_;
  int number_ = 0;
};

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t end = line.find(',');
    fields.push_back(line.substr(0, end));
    if (end == std::string_view::npos) {
      return fields;
    }
    line.remove_prefix(end + 1);
  }
}

double number(const Lines& lines, std::string_view field) {
  while (field.starts_with(' ')) {
    field.remove_prefix(1);
  }
  while (field.ends_with(' ')) {
    field.remove_suffix(1);
  }
  const std::optional<double> value = files::number_of_text<double>(field);
  if (!value) {
    lines.fail(fmt::format("'{}' is not a number", field));
  }
  return *value;
}

// A number of a field that means `what`, at most `most` in size.
double number_within(const Lines& lines, std::string_view field, const char* what, double most) {
  const double value = number(lines, field);
  if (!(std::abs(value) <= most)) {
    lines.fail(fmt::format("{} is {}; its size may be at most {}", what, value, most));
  }
  return value;
}

// The heights of a TIFF as one row.
std::vector<double> heights_of(const rig::Rig& rig, const std::string& file, std::optional<int> frame) {
  const images::FloatImage image = images::read_float_tiff(file);
  if (image.columns != rig.camera.columns) {
    throw UserError(file, fmt::format("has {} columns; the rig's camera has {}", image.columns, rig.camera.columns));
  }
  if (frame && (*frame < 1 || *frame > image.rows)) {
    throw UserError(file, fmt::format("has no frame {}; it has {}", *frame, image.rows));
  }
  std::vector<double> heights;
  for (int c = 0; c < image.columns; ++c) {
    std::vector<float> values;
    for (int r = frame ? *frame - 1 : 0; r < (frame ? *frame : image.rows); ++r) {
      if (std::isfinite(image.row(r)[c])) {
        values.push_back(image.row(r)[c]);
      }
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    heights.push_back(values.empty() ? rig::kUnknown : static_cast<double>(*middle));
  }
  return heights;
}

}  // namespace

ReferenceCurve parse_curve_csv(const std::string& text, const std::string& source) {
  Lines lines(text.ends_with('\n') ? text : text + '\n', source);  // a user's table need not end with a newline
  const auto first = lines.next();
  if (!first || *first != "y_mm,z_mm") {
    throw UserError(source, "line 1: y_mm,z_mm is expected");
  }
  ReferenceCurve curve;
  while (const auto line = lines.next()) {
    const std::vector<std::string_view> fields = fields_of(*line);
    if (fields.size() != 2) {
      lines.fail("two numbers are expected: y, z");
    }
    const double y = number_within(lines, fields[0], "y", kFar);
    const double z = fields[1].empty() ? rig::kUnknown : number_within(lines, fields[1], "z", kFar);
    if (!curve.y_mm.empty() && y < curve.y_mm.back()) {
      lines.fail(fmt::format("y falls from {} to {}", curve.y_mm.back(), y));
    }
    if (z < kNear) {
      lines.fail(fmt::format("z is {}; it is the distance from the camera and must be {}", z,
                             z > 0 ? fmt::format("at least {}", kNear) : "greater than 0"));
    }
    curve.y_mm.push_back(y);
    curve.z_mm.push_back(z);
  }
  if (curve.y_mm.size() < 2) {
    throw UserError(source, "has fewer than two points");
  }
  return curve;
}

ReferenceCurve load_curve(const rig::Rig& rig, const std::string& file, std::optional<int> frame) {
  const std::string extension = fs::path(file).extension().string();
  if (extension == ".tif" || extension == ".tiff") {
    return curve_of_heights(rig, heights_of(rig, file, frame));
  }
  if (frame) {
    throw UserError(file, "is not a TIFF file, so it has no frames");
  }
  return parse_curve_csv(files::read_text(file, files::kMostTableBytes), file);
}

std::string reference_csv(const rig::Rig& rig, const ReferenceProfile& reference) {
  const Form& form = form_of(rig);
  std::string text = fmt::format("{}\n", form.magic);
  for (const auto& [key, value] : rig::geometry_of(rig)) {
    text += fmt::format("# {} {}\n", key, value);
  }
  if (reference.measured) {
    const auto& [select, gap, window] = *reference.measured;
    text += fmt::format("{}{}\n{}{}\n{}{}\n{}{}\n", kMeasured[0], images::select_name(select), kMeasured[1], gap,
                        kMeasured[2], window.first, kMeasured[3], window.last);
  }
  text += fmt::format("{}\n", form.columns);
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    text += fmt::format("{}", i + 1);
    if (reference.valid[i] == 0) {
      text += std::string(form.fields - 1, ',');
    } else if (rig.is_pinholes()) {
      text += fmt::format(",{},{},{}", reference.tan_theta[i], reference.z_mm[i], reference.offset_px[i]);
    } else {
      text +=
          fmt::format(",{},{},{},{}", reference.line[i], reference.slope[i], reference.z_mm[i], reference.offset_px[i]);
    }
    text += '\n';
  }
  return text;
}

namespace {

// The first line and the rig's geometry.
void read_head(const rig::Rig& rig, const std::string& source, Lines& lines, std::string_view magic) {
  if (magic != form_of(rig).magic) {
    if (magic == kPinholes.magic || magic == kLenses.magic) {
      throw UserError(source, fmt::format("was made for another rig: one {} lenses, a laser or corrected heights",
                                          magic == kLenses.magic ? "with" : "without"));
    }
    throw UserError(source, magic.starts_with("# selfproj reference ")
                                ? fmt::format("is of version {}; this program reads versions 1 and 2", magic.substr(21))
                                : "is not a reference; `selfproj pattern` writes references");
  }
  static_cast<void>(lines.next());
  for (const auto& [key, value] : rig::geometry_of(rig)) {
    const auto line = lines.next();
    std::string start = fmt::format("# {} ", key);
    for (const std::string& earlier : rig::earlier_names(key)) {
      start = line && line->starts_with("# " + earlier + " ") ? "# " + earlier + " " : start;
    }
    if (!line || !line->starts_with(start)) {
      lines.fail(fmt::format("is damaged: {} is expected", key));
    }
    const double made_for = number(lines, line->substr(start.size()));
    if (!rig::same_geometry(made_for, value)) {
      throw UserError(source,
                      fmt::format("was made for another rig: {} is {} there and {} here", key, made_for, value));
    }
  }
}

// What counted in the images, in the lines from `line` on.
Selection read_measured(Lines& lines, std::optional<std::string_view> line) {
  std::array<std::string, kMeasured.size()> values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    line = i == 0 ? line : lines.next();
    if (!line || !line->starts_with(kMeasured.at(i))) {
      lines.fail(fmt::format("is damaged: {} is expected", kMeasured.at(i).substr(2)));
    }
    values.at(i) = line->substr(kMeasured.at(i).size());
  }
  const std::vector<std::string> selects = images::select_names();
  if (std::find(selects.begin(), selects.end(), values[0]) == selects.end()) {
    lines.fail(fmt::format("'{}' is no selection; {} are", values[0], fmt::join(selects, ", ")));
  }
  const auto whole = [&](std::size_t i, int most) {
    const std::optional<int> value = files::number_of_text<int>(values.at(i));
    if (!value || *value < 0 || *value > most) {
      lines.fail(fmt::format("'{}' is not a whole number from 0 to {}", values.at(i), most));
    }
    return *value;
  };
  return {
      images::select_of(values[0]), whole(1, model::kMaxGap), {whole(2, spec::kRowLimit), whole(3, spec::kRowLimit)}};
}

// One column. Its fields are those of the rig's form.
void read_column(const rig::Rig& rig, const Lines& lines, const std::vector<std::string_view>& fields, std::size_t i,
                 ReferenceProfile& reference) {
  const bool valid =
      std::any_of(fields.begin() + 1, fields.end(), [](std::string_view field) { return !field.empty(); });
  reference.valid[i] = valid ? 1 : 0;
  const auto value = [&](std::size_t field, const char* what, double most) {
    return valid ? number_within(lines, fields[field], what, most) : rig::kUnknown;
  };
  if (rig.is_pinholes()) {
    reference.tan_theta[i] = value(1, "tan_theta", kMaxTangent);
  } else {
    reference.line[i] = value(1, "line", kMaxLine);
    reference.slope[i] = value(2, "line_slope", kMaxSlope);
  }
  reference.z_mm[i] = value(fields.size() - 2, "z_mm", kFar);
  reference.offset_px[i] = value(fields.size() - 1, "offset_px", rig.camera.rows);
  if (valid && !(reference.z_mm[i] >= kNear)) {
    lines.fail(fmt::format("is damaged: z is {}, less than {}", reference.z_mm[i], kNear));
  }
}

}  // namespace

ReferenceProfile parse_reference_csv(const rig::Rig& rig, const std::string& text, const std::string& source) {
  const Form& form = form_of(rig);
  Lines lines(text, source);
  read_head(rig, source, lines, std::string_view(text).substr(0, text.find('\n')));
  ReferenceProfile reference;
  auto head = lines.next();
  if (head && head->starts_with(kMeasured[0])) {
    reference.measured = read_measured(lines, head);
    head = lines.next();
  }
  if (head != form.columns) {
    lines.fail(fmt::format("is damaged: {} is expected", form.columns));
  }
  if (rig.is_pinholes()) {
    reference.resize(rig.camera.columns);
  } else {
    reference.resize_for_lenses(rig.camera.columns);
  }
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    const auto line = lines.next();
    if (!line) {
      throw UserError(source, fmt::format("is truncated: it has {} of {} columns", i, reference.valid.size()));
    }
    const std::vector<std::string_view> fields = fields_of(*line);
    if (fields.size() != form.fields || fields[0] != std::to_string(i + 1)) {
      lines.fail(fmt::format("is damaged: column {} with {} numbers is expected", i + 1,
                             rig.is_pinholes() ? "three" : "four"));
    }
    read_column(rig, lines, fields, i, reference);
  }
  if (lines.next()) {
    lines.fail(fmt::format("is damaged: it has more than {} columns", reference.valid.size()));
  }
  return reference;
}

ReferenceProfile load_reference(const rig::Rig& rig, const std::string& folder_or_file) {
  std::error_code error;
  const std::string file =
      fs::is_directory(folder_or_file, error) ? (fs::path(folder_or_file) / "reference.csv").string() : folder_or_file;
  return parse_reference_csv(rig, files::read_text(file, files::kMostTableBytes), file);
}

std::string reference_file_of(const std::string& recording) { return recording + ".reference.csv"; }

images::FloatImage load_pattern(const rig::Rig& rig, const std::string& folder) {
  const std::string file = (fs::path(folder) / "pattern.tiff").string();
  images::FloatImage pattern = images::read_float_tiff(file);
  if (pattern.rows != rig.projector.lines || pattern.columns != rig.projector.columns) {
    throw UserError(file, fmt::format("has {} x {} pixels; the rig's projector has {} lines x {} columns", pattern.rows,
                                      pattern.columns, rig.projector.lines, rig.projector.columns));
  }
  if (!std::all_of(pattern.values.begin(), pattern.values.end(), [](float v) { return v >= 0 && v <= 1; })) {
    throw UserError(file, "has values outside 0 to 1");
  }
  return pattern;
}

}  // namespace selfproj::light_section
