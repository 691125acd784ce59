#include "host/rig/rig.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/io/frame_options.h"
#include "host/io/input_file.h"
#include "host/io/numbers.h"
#include "host/io/user_error.h"
#include "host/rig/rigs_built_in.h"
#include "host/rig/yaml_document.h"
#include "model/pixel_clock.h"

namespace selfproj {
namespace {

constexpr double kMicro = 1e-6;
constexpr double kMmPerUm = 1e-3;
constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kFar = 1e6;  // mm: larger than any machine

// The range of a number.
struct Range {
  double low;
  double high;
  bool zero = true;  // may be 0, or nearer to it than kLeast
};
constexpr double kLeast = 1e-9;  // smaller than any quantity that may not be 0: its inverse is a number, too
constexpr Range kPositive{.low = kLeast, .high = kFar};
constexpr Range kNotNegative{.low = 0, .high = kFar};
constexpr Range kAny{.low = -kFar, .high = kFar};
constexpr Range kNotZero{.low = -kFar, .high = kFar, .zero = false};

const std::vector<std::pair<const char*, Mode>> kModeChoices(kModes.begin(), kModes.end());
const std::vector<std::pair<const char*, RigKind>> kKinds = {{"light-section", RigKind::light_section},
                                                             {"scanner", RigKind::scanner}};

template <class LensT, class Visitor>
void visit_lens(const char* section, LensT& lens, Range focal, Visitor& v) {
  v.begin(section);
  v.number("fx_px", lens.fx_px, 1, focal);
  v.number("fy_px", lens.fy_px, 1, focal);
  v.number("cx_px", lens.cx_px, 1, kAny);
  v.number("cy_px", lens.cy_px, 1, kAny);
  v.number("k1", lens.k1, 1, kAny);
  v.number("k2", lens.k2, 1, kAny);
  v.number("p1", lens.p1, 1, kAny);
  v.number("p2", lens.p2, 1, kAny);
  v.number("k3", lens.k3, 1, kAny);
  v.end();
}

// The sections of a calibrated rig: all are present, or none.
template <class CalibrationT, class Visitor>
void visit_calibration(CalibrationT& calibration, Visitor& v) {
  visit_lens("camera_lens", calibration.camera, kPositive, v);
  visit_lens("projector_lens", calibration.projector, kNotZero, v);
  v.begin("projector_pose");
  v.number("rotation_x_deg", calibration.rotation_rad[0], kRadPerDeg, {-360, 360});
  v.number("rotation_y_deg", calibration.rotation_rad[1], kRadPerDeg, {-360, 360});
  v.number("rotation_z_deg", calibration.rotation_rad[2], kRadPerDeg, {-360, 360});
  v.number("translation_x_mm", calibration.translation_mm[0], 1, kAny);
  v.number("translation_y_mm", calibration.translation_mm[1], 1, kAny);
  v.number("translation_z_mm", calibration.translation_mm[2], 1, kAny);
  v.end();
}

// The keys of a rig in their order, for reader and writer alike. Struct<RigT> is Rig or const Rig.
template <class RigT, class Visitor>
void visit_rig(RigT& rig, Visitor& v) {
  v.text("name", rig.name);
  v.choice("kind", rig.kind, kKinds);
  v.number("plane_z_mm", rig.plane_z_mm, 1, kPositive);
  v.begin("camera");
  v.integer("rows", rig.camera.rows, 1, 1 << 14);
  v.integer("columns", rig.camera.columns, 1, 1 << 14);
  v.number("pixel_pitch_um", rig.camera.pixel_pitch_mm, kMmPerUm, kPositive);
  v.number("focal_length_mm", rig.camera.focal_length_mm, 1, kPositive);
  v.number("frame_rate_hz", rig.camera.frame_rate_hz, 1, kPositive);
  v.number("exposure_us", rig.camera.exposure_s, kMicro, kNotNegative);
  v.end();
  v.begin("projector");
  v.number("x_mm", rig.projector.x_mm, 1, kPositive);
  v.number("z_mm", rig.projector.z_mm, 1, kAny);
  v.number("tilt_deg", rig.projector.tilt_rad, kRadPerDeg, {-89, 89});
  v.number("focal_length_mm", rig.projector.focal_length_mm, 1, kPositive);
  v.integer("lines", rig.projector.lines, 1, 1 << 14);
  v.integer("columns", rig.projector.columns, 1, 1 << 14);
  v.number("line_pitch_um", rig.projector.line_pitch_mm, kMmPerUm, kNotZero);
  v.number("column_pitch_um", rig.projector.column_pitch_mm, kMmPerUm, kNotZero);
  v.number("center_xp_mm", rig.projector.center_xp_mm, 1, kAny);
  v.number("center_yp_mm", rig.projector.center_yp_mm, 1, kAny);
  v.end();
  v.begin("conveyor");
  v.number("speed_mm_per_s", rig.conveyor.speed_mm_per_s, 1, kNotNegative);
  v.number("encoder_mm_per_count", rig.conveyor.encoder_mm_per_count, 1, kPositive);
  v.end();
  if (v.has_any({"board"}, rig.board)) {
    v.begin("board");
    v.number("pixel_clock_hz", rig.board->pixel_clock_hz, 1, {kLeastPixelClockHz, kMostPixelClockHz});
    v.end();
  }
  v.begin("measure");
  v.choice("mode", rig.measure.mode, kModeChoices);
  v.integer("threshold", rig.measure.threshold, 0, 255);
  v.integer("min_lit_px", rig.measure.min_lit_px, 1, 1 << 14);
  v.integer("max_lit_px", rig.measure.max_lit_px, 1, 1 << 14);
  v.number("line_width_px", rig.measure.line_width_px, 1, kPositive);
  v.integer("code_threshold", rig.measure.code_threshold, 0, 255);
  v.number("max_z_per_line_mm", rig.measure.max_z_per_line_mm, 1, kPositive);
  v.end();
  v.begin("imaging");
  v.number("white", rig.imaging.white, 1, {0, 255});
  v.number("ambient", rig.imaging.ambient, 1, {0, 255});
  v.number("dark", rig.imaging.dark, 1, {0, 255});
  v.number("camera_blur_px", rig.imaging.camera_blur_px, 1, {0, 100});
  v.number("projector_blur_px", rig.imaging.projector_blur_px, 1, {0, 100});
  v.number("electrons_per_grey", rig.imaging.electrons_per_grey, 1, kPositive);
  v.number("read_noise", rig.imaging.read_noise, 1, {0, 255});
  v.integer64("seed", rig.imaging.seed);
  v.end();
  if (v.has_any({"camera_lens", "projector_lens", "projector_pose"}, rig.calibration)) {
    visit_calibration(*rig.calibration, v);
  }
}

// Reads a rig from a YAML document.
class Reader {
 public:
  Reader(std::string source, const YAML::Node& root) : source_(std::move(source)) { enter({}, root); }

  void text(const char* key, std::string& value) {
    value = scalar(key).Scalar();
    if (value.empty()) {
      fail(key, "is empty");
    }
  }

  template <class T>
  void choice(const char* key, T& value, const std::vector<std::pair<const char*, T>>& choices) {
    const std::string given = scalar(key).Scalar();
    std::string names;
    for (const auto& [name, meaning] : choices) {
      if (given == name) {
        value = meaning;
        return;
      }
      names += names.empty() ? name : fmt::format(", {}", name);
    }
    fail(key, fmt::format("is '{}'; one of {} is expected", given, names));
  }

  void number(const char* key, double& value, double unit, Range range) {
    const auto given = as<double>(key, "a number");
    if (!range.zero && std::abs(given) < kLeast) {
      fail(key, given == 0 ? "is 0" : fmt::format("is {}; its size must be at least {}", given, kLeast));
    }
    if (given < range.low || given > range.high) {
      const bool open = range.low == kLeast && given <= 0;
      fail(key, range.low == -kFar ? fmt::format("is {}; its size may be at most {}", given, range.high)
                                   : fmt::format("is {}; it must be {} {} and at most {}", given,
                                                 open ? "greater than" : "at least", open ? 0 : range.low, range.high));
    }
    value = given * unit;
  }

  void integer(const char* key, int& value, int low, int high) {
    const int given = as<int>(key, "a whole number");
    if (given < low || given > high) {
      fail(key, fmt::format("is {}; it must be at least {} and at most {}", given, low, high));
    }
    value = given;
  }

  void integer64(const char* key, std::int64_t& value) { value = as<std::int64_t>(key, "a whole number"); }

  // Returns whether one of these keys is present, and if so creates the value.
  template <class T>
  bool has_any(std::initializer_list<const char*> keys, std::optional<T>& value) {
    const YAML::Node& node = levels_.back().node;
    if (std::any_of(keys.begin(), keys.end(), [&](const char* key) { return std::as_const(node)[key].IsDefined(); })) {
      value.emplace();
    }
    return value.has_value();
  }

  void begin(const char* key) {
    const YAML::Node node = find(key);
    if (!node.IsMap()) {
      fail(key, "is not a map of keys");
    }
    enter(path(key), node);
  }

  // Throws for any key that nobody has asked for, since it does not exist.
  void end() {
    const Level& level = levels_.back();
    std::set<std::string> seen;
    for (const auto& entry : level.node) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      if (level.asked.count(key) == 0) {
        std::string wanted;
        for (const std::string& name : level.asked) {  // perhaps the same quantity in another unit
          if (name.substr(0, name.rfind('_')) == key.substr(0, key.rfind('_'))) {
            wanted = fmt::format("; the key is {}", name);
          }
        }
        throw UserError(
            source_, fmt::format("line {}: {}: unknown key{}", entry.first.Mark().line + 1, path(key.c_str()), wanted));
      }
      if (!seen.insert(key).second) {
        throw UserError(source_,
                        fmt::format("line {}: {}: occurs twice", entry.first.Mark().line + 1, path(key.c_str())));
      }
    }
    levels_.pop_back();
  }

 private:
  struct Level {
    std::string prefix;
    YAML::Node node;
    std::set<std::string> asked;
  };

  void enter(const std::string& prefix, const YAML::Node& node) { levels_.push_back({prefix, node, {}}); }

  std::string path(const char* key) const {
    const std::string& prefix = levels_.back().prefix;
    return prefix.empty() ? key : prefix + "." + key;
  }

  [[noreturn]] void fail(const char* key, const std::string& reason) {
    const YAML::Node node = levels_.back().node[key];
    throw UserError(source_, fmt::format("line {}: {} {}", node.Mark().line + 1, path(key), reason));
  }

  // If the key is missing but present in another unit, the error names the latter, which `end` would call unknown.
  YAML::Node find(const char* key) {
    Level& level = levels_.back();
    level.asked.insert(key);
    const YAML::Node node = std::as_const(level.node)[key];
    if (node.IsDefined()) {
      return node;
    }
    const std::string name = key;
    for (const auto& entry : level.node) {
      const std::string other = entry.first.IsScalar() ? entry.first.Scalar() : "";
      const std::string stem = name.substr(0, name.rfind('_'));
      if (other != name && name.find('_') != std::string::npos && other.rfind(stem + "_", 0) == 0 &&
          other.find('_', stem.size() + 1) == std::string::npos && level.asked.count(other) == 0) {
        throw UserError(source_, fmt::format("line {}: {}: unknown key; the key is {}", entry.first.Mark().line + 1,
                                             path(other.c_str()), name));
      }
    }
    throw UserError(source_, fmt::format("{} is missing", path(key)));
  }

  YAML::Node scalar(const char* key) {
    const YAML::Node node = find(key);
    if (!node.IsScalar()) {
      fail(key, "has no single value");
    }
    return node;
  }

  template <class T>
  T as(const char* key, const char* what) {
    const std::string text = scalar(key).Scalar();
    const std::optional<T> value = number_of_text<T>(text);
    if (!value) {
      fail(key, fmt::format("is '{}', not {}", text, what));
    }
    return *value;
  }

  std::string source_;
  std::vector<Level> levels_;
};

// Writes a rig as YAML.
class Writer {
 public:
  void text(const char* key, const std::string& value) {
    YAML::Emitter quoted;  // quotes the name if it needs quotes
    quoted << value;
    line(key, quoted.c_str());
  }
  template <class T>
  void choice(const char* key, const T& value, const std::vector<std::pair<const char*, T>>& choices) {
    const auto found = std::find_if(choices.begin(), choices.end(), [&](const auto& c) { return c.second == value; });
    line(key, found->first);
  }
  // The shortest text that reads back to the same value.
  void number(const char* key, double value, double unit, Range /*range*/) {
    double shown = value / unit;
    for (int digits = 6; digits < 18; ++digits) {
      const std::optional<double> candidate = number_of_text<double>(fmt::format("{:.{}g}", shown, digits));
      if (candidate && *candidate * unit == value) {
        shown = *candidate;
        break;
      }
    }
    line(key, fmt::format("{}", shown));
  }
  void integer(const char* key, int value, int /*low*/, int /*high*/) { line(key, std::to_string(value)); }
  void integer64(const char* key, std::int64_t value) { line(key, std::to_string(value)); }
  template <class T>
  bool has_any(std::initializer_list<const char*> /*keys*/, const std::optional<T>& value) {
    return value.has_value();
  }
  void begin(const char* key) {
    line(key, "");
    indent_ = "  ";
  }
  void end() { indent_.clear(); }
  [[nodiscard]] const std::string& yaml() const { return yaml_; }

 private:
  void line(const char* key, const std::string& value) {
    yaml_ += fmt::format("{}{}:{}{}\n", indent_, key, value.empty() ? "" : " ", value);
  }

  std::string indent_;
  std::string yaml_;
};

}  // namespace

const std::vector<std::string>& built_in_rigs() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const auto& [name, yaml] : kBuiltInRigs) {
      result.emplace_back(name);
    }
    return result;
  }();
  return names;
}

Rig parse_rig(const std::string& yaml, const std::string& source) {
  const YAML::Node root = parse_yaml(yaml, source);
  if (!root.IsMap()) {
    throw UserError(source, "is not a rig; keys and values are expected");
  }
  Rig rig;
  Reader reader(source, root);
  visit_rig(rig, reader);
  reader.end();
  if (rig.measure.min_lit_px > rig.measure.max_lit_px) {
    throw UserError(source, fmt::format("measure.min_lit_px is {}, more than measure.max_lit_px, {}",
                                        rig.measure.min_lit_px, rig.measure.max_lit_px));
  }
  const RigImaging& light = rig.imaging;
  if (light.dark > light.ambient || light.ambient > light.white) {
    throw UserError(source, fmt::format("imaging.dark is {}, imaging.ambient {}, imaging.white {}; each may be at most "
                                        "the next",
                                        light.dark, light.ambient, light.white));
  }
  return rig;
}

Rig load_rig(const std::string& name_or_file) {
  for (const auto& [name, yaml] : kBuiltInRigs) {
    if (name_or_file == name) {
      return parse_rig(yaml, name);
    }
  }
  std::error_code error;
  if (!std::filesystem::exists(name_or_file, error)) {
    throw UserError(name_or_file, fmt::format("is neither a readable file nor a built-in rig ({})",
                                              fmt::join(built_in_rigs(), ", ")));
  }
  return parse_rig(read_input(name_or_file, kMostTextBytes), name_or_file);
}

std::string to_yaml(const Rig& rig) {
  Writer writer;
  visit_rig(rig, writer);
  return writer.yaml();
}

}  // namespace selfproj
