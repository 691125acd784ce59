#include "selfproj/rig/rig.h"

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

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/text.h"
#include "host/images/frame_options.h"
#include "host/rig/rigs_built_in.h"
#include "host/rig/yaml.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/pixel_clock.h"

namespace selfproj::rig {
namespace {

constexpr double kMicro = 1e-6;
constexpr double kMilli = 1e-3;
constexpr double kMmPerUm = 1e-3;
constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kUnit = 1e-6;  // how far the length of a vector may be from 1
const std::vector<std::pair<const char*, model::Mode>> kModeChoices(images::kModes.begin(), images::kModes.end());
const std::vector<std::pair<const char*, RigKind>> kKinds = {{"light-section", RigKind::light_section},
                                                             {"scanner", RigKind::scanner}};
const std::vector<std::pair<const char*, PartCut>> kCuts = {
    {"profile", PartCut::profile}, {"distance", PartCut::distance}, {"trigger", PartCut::trigger}};
const std::vector<std::pair<const char*, PartCut>> kScannerCuts = {{"image", PartCut::image},
                                                                   {"trigger", PartCut::trigger}};
const std::vector<std::pair<const char*, ValueSource>> kSources = {
    {"drawing", ValueSource::drawing}, {"measured", ValueSource::measured}, {"assumed", ValueSource::assumed}};
const std::vector<std::pair<const char*, ValueSource RigSources::*>> kSourceKeys = {{"camera", &RigSources::camera},
                                                                                    {"light", &RigSources::light},
                                                                                    {"belt", &RigSources::belt},
                                                                                    {"speed", &RigSources::speed},
                                                                                    {"encoder", &RigSources::encoder}};
const std::vector<std::pair<const char*, bool>> kWords = {{"exact", false}, {"compact", true}};
const std::vector<std::pair<const char*, bool>> kBelts = {{"encoder", true}, {"clock", false}};

template <class LensT, class Visitor>
void visit_lens(const char* section, LensT& lens, ValueRange focal, Visitor& v) {
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

// The sections of a calibrated projector: they are present with that of the camera, or not at all.
template <class CalibrationT, class Visitor>
void visit_projector(CalibrationT& calibration, Visitor& v) {
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

template <class PlaneT, class Visitor>
void visit_light_plane(PlaneT& plane, Visitor& v) {
  v.begin("light_plane");
  v.number("normal_x", plane.normal[0], 1, {-1, 1});
  v.number("normal_y", plane.normal[1], 1, {-1, 1});
  v.number("normal_z", plane.normal[2], 1, {-1, 1});
  v.number("distance_mm", plane.distance_mm, 1, kNotZero);
  v.end();
}

template <class PoseT, class Visitor>
void visit_belt_pose(PoseT& pose, Visitor& v) {
  v.begin("belt_pose");
  v.number("direction_x", pose.direction[0], 1, {-1, 1});
  v.number("direction_y", pose.direction[1], 1, {-1, 1});
  v.number("direction_z", pose.direction[2], 1, {-1, 1});
  v.number("normal_x", pose.normal[0], 1, {-1, 1});
  v.number("normal_y", pose.normal[1], 1, {-1, 1});
  v.number("normal_z", pose.normal[2], 1, {-1, 1});
  v.end();
}

template <class HeightsT, class Visitor>
void visit_heights(HeightsT& heights, Visitor& v) {
  v.begin("heights");
  v.number("min_mm", heights.min_mm, 1, kAny);
  v.number("max_mm", heights.max_mm, 1, kAny);
  v.integer("order", heights.order, 0, kMaxHeightOrder);
  v.integer("order_heights", heights.order_heights, 0, kMaxHeightOrder);
  v.numbers("corrections_mm", heights.corrections_mm, 1, kAny);
  v.end();
}

template <class PartsT, class Visitor>
void visit_parts(PartsT& parts, RigKind kind, Visitor& v) {
  v.begin("parts");
  if (kind == RigKind::scanner) {
    v.choice("cut", parts.cut, kScannerCuts);
    v.number("grid_mm", parts.grid_mm, 1, {.low = 0.01, .high = 100});
    v.number("pause_ms", parts.pause_s, kMilli, kPositive);
    v.end();
    return;
  }
  v.choice("cut", parts.cut, kCuts);
  v.choice("belt", parts.by_encoder, kBelts);
  v.number("grid_mm", parts.grid_mm, 1, {.low = 0.01, .high = 100});
  v.number("above_mm", parts.above_mm, 1, kAny);
  v.number("min_width_mm", parts.min_width_mm, 1, kNotNegative);
  v.number("gap_mm", parts.gap_mm, 1, kPositive);
  v.number("pause_ms", parts.pause_s, kMilli, kPositive);
  v.number("min_length_mm", parts.min_length_mm, 1, kNotNegative);
  v.number("length_mm", parts.length_mm, 1, kPositive);
  v.end();
}

template <class RegionT, class Visitor>
void visit_region(RegionT& region, Visitor& v) {
  v.begin("region");
  v.integer("row_offset", region.row_offset, 0, 1 << 14);
  v.integer("rows", region.rows, 1, 1 << 14);
  v.integer("column_offset", region.column_offset, 0, 1 << 14);
  v.integer("columns", region.columns, 4, 1 << 14);
  v.number("frame_rate_hz", region.frame_rate_hz, 1, kPositive);
  v.number("exposure_us", region.exposure_s, kMicro, kNotNegative);
  v.end();
}

template <class SourcesT, class Visitor>
void visit_sources(SourcesT& sources, Visitor& v) {
  v.begin("sources");
  for (const auto& [key, member] : kSourceKeys) {
    v.choice(key, sources.*member, kSources);
  }
  v.end();
}

template <class ProjectorT, class Visitor>
void visit_pinhole(ProjectorT& projector, Visitor& v) {
  v.begin("projector");
  v.number("x_mm", projector.x_mm, 1, kPositive);
  v.number("z_mm", projector.z_mm, 1, kAny);
  v.number("tilt_deg", projector.tilt_rad, kRadPerDeg, {-89, 89});
  v.number("focal_length_mm", projector.focal_length_mm, 1, kPositive);
  v.integer("lines", projector.lines, 1, 1 << 14);
  v.integer("columns", projector.columns, 1, 1 << 14);
  v.number("line_pitch_um", projector.line_pitch_mm, kMmPerUm, kNotZero);
  v.number("column_pitch_um", projector.column_pitch_mm, kMmPerUm, kNotZero);
  v.number("center_xp_mm", projector.center_xp_mm, 1, kAny);
  v.number("center_yp_mm", projector.center_yp_mm, 1, kAny);
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
  if (v.has_any({"region"}, rig.camera.region)) {
    visit_region(*rig.camera.region, v);
  }
  v.end();
  if (!v.has_any({"light_plane"}, rig.light_plane)) {
    visit_pinhole(rig.projector, v);
  } else {
    v.refuse({"projector", "projector_lens", "projector_pose"}, "light_plane");
  }
  v.begin("conveyor");
  v.number("speed_mm_per_s", rig.conveyor.speed_mm_per_s, 1, kNotNegative);
  v.number("encoder_mm_per_count", rig.conveyor.encoder_mm_per_count, 1, kPositive);
  v.end();
  if (v.has_any({"board"}, rig.board)) {
    v.begin("board");
    v.number("pixel_clock_hz", rig.board->pixel_clock_hz, 1, {model::kMinPixelClockHz, model::kMaxPixelClockHz});
    v.end();
  }
  v.begin("measure");
  v.choice("mode", rig.measure.mode, kModeChoices);
  if (v.has_any({"pixel_bits"}, rig.measure.pixel_bits)) {
    v.integer("pixel_bits", *rig.measure.pixel_bits, spec::kPixelBits, model::kMaxPixelBits);
  }
  v.integer("threshold", rig.measure.threshold, 0, (1 << rig.measure.bits()) - 1);
  v.integer("min_lit_px", rig.measure.min_lit_px, 1, 1 << 14);
  v.integer("max_lit_px", rig.measure.max_lit_px, 1, 1 << 14);
  v.number("line_width_px", rig.measure.line_width_px, 1, kPositive);
  v.integer("code_threshold", rig.measure.code_threshold, 0, 255);
  v.number("max_z_per_line_mm", rig.measure.max_z_per_line_mm, 1, kPositive);
  if (v.has_any({"runs"}, rig.measure.runs)) {
    v.begin("runs");
    v.integer("gap_rows", rig.measure.runs->gap_rows, 0, model::kMaxGap);
    v.number("ambiguous_from", rig.measure.runs->ambiguous_from, 1, {.low = 1.0 / 16, .high = 2});
    v.end();
  }
  if (v.has_any({"window"}, rig.measure.window)) {
    v.begin("window");
    v.integer("first_row", rig.measure.window->first, 1, spec::kRowLimit);
    v.integer("last_row", rig.measure.window->last, 1, spec::kRowLimit);
    v.end();
  }
  if (v.has_any({"words"}, rig.measure.compact)) {
    v.choice("words", *rig.measure.compact, kWords);
  }
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
  if (v.has_any({"camera_lens", "projector_lens", "projector_pose", "light_plane"}, rig.calibration)) {
    visit_lens("camera_lens", rig.calibration->camera, kPositive, v);
    if (rig.light_plane) {
      visit_light_plane(*rig.light_plane, v);
    } else {
      visit_projector(*rig.calibration, v);
    }
  }
  if (v.has_any({"belt_pose"}, rig.belt_pose)) {
    visit_belt_pose(*rig.belt_pose, v);
  }
  if (v.has_any({"heights"}, rig.heights)) {
    visit_heights(*rig.heights, v);
  }
  if (v.has_any({"parts"}, rig.parts)) {
    visit_parts(*rig.parts, rig.kind, v);
  }
  if (v.has_any({"sources"}, rig.sources)) {
    visit_sources(*rig.sources, v);
  }
}

// What the sections that a rig may have demand of each other.
void check_sections(const Rig& rig, const std::string& source) {
  const auto expect_unit = [&](const char* name, const std::array<double, 3>& v) {
    const double length = std::hypot(v[0], v[1], v[2]);
    if (std::abs(length - 1) > kUnit) {
      throw UserError(source, fmt::format("{} has the length {:.6g}; 1 is expected", name, length));
    }
  };
  if (rig.camera.region) {
    const RigRegion& region = *rig.camera.region;
    if (region.row_offset + region.rows > rig.camera.rows ||
        region.column_offset + region.columns > rig.camera.columns) {
      throw UserError(source, fmt::format("camera.region ends at row {}, column {}; the camera has {} rows, {} columns",
                                          region.row_offset + region.rows, region.column_offset + region.columns,
                                          rig.camera.rows, rig.camera.columns));
    }
    if (region.columns % spec::kPixelsPerBeat != 0) {
      throw UserError(source, fmt::format("camera.region.columns is {}; a multiple of {} is expected", region.columns,
                                          spec::kPixelsPerBeat));
    }
    if (rig.kind != RigKind::light_section) {
      throw UserError(source, "camera.region goes only with kind light-section");
    }
  }
  if (rig.kind != RigKind::light_section) {
    need_eight_bits(rig, source, "a rig of kind scanner");
  } else if (rig.measure.bits() > spec::kPixelBits && rig.camera.sent().rows > model::row_limit(rig.measure.bits())) {
    throw UserError(source,
                    fmt::format("the camera sends {} rows; with measure.pixel_bits {} at most {} can be "
                                "measured (camera.region takes fewer)",
                                rig.camera.sent().rows, rig.measure.bits(), model::row_limit(rig.measure.bits())));
  }
  if (rig.light_plane) {
    expect_unit("light_plane.normal", rig.light_plane->normal);
  }
  if (rig.belt_pose) {
    const auto& [direction, normal] = *rig.belt_pose;
    expect_unit("belt_pose.direction", direction);
    expect_unit("belt_pose.normal", normal);
    const double along = direction[0] * normal[0] + direction[1] * normal[1] + direction[2] * normal[2];
    if (std::abs(along) > kUnit) {
      throw UserError(source, fmt::format("belt_pose.direction and belt_pose.normal are {:.4g} degrees apart; 90 are "
                                          "expected",
                                          std::acos(along) / kRadPerDeg));
    }
  }
  const char* const section = rig.light_plane ? "light_plane"
                              : rig.belt_pose ? "belt_pose"
                              : rig.heights   ? "heights"
                              : rig.sources   ? "sources"
                                              : nullptr;
  if (section != nullptr && rig.kind != RigKind::light_section) {
    throw UserError(source, fmt::format("{} goes only with kind light-section", section));
  }
  if (rig.parts && rig.kind == RigKind::light_section) {
    const RigParts& parts = *rig.parts;
    if (!(parts.min_length_mm < parts.length_mm)) {
      throw UserError(source, fmt::format("parts.length_mm is {}, parts.min_length_mm {}; it must be greater",
                                          parts.length_mm, parts.min_length_mm));
    }
    constexpr double kMaxRows = 20'000;  // of a part's map
    if ((parts.length_mm + 2 * parts.gap_mm) / parts.grid_mm > kMaxRows) {
      throw UserError(source, fmt::format("parts.length_mm, {}, has more than {} cells of parts.grid_mm, {}",
                                          parts.length_mm, kMaxRows, parts.grid_mm));
    }
  }
  if (rig.heights) {
    const RigHeights& h = *rig.heights;
    if (!(h.min_mm < h.max_mm)) {
      throw UserError(source,
                      fmt::format("heights.min_mm is {}, heights.max_mm {}; it must be greater", h.min_mm, h.max_mm));
    }
    const std::size_t terms = height_terms(h.order, h.order_heights).size();
    if (h.corrections_mm.size() != terms) {
      throw UserError(source, fmt::format("heights.corrections_mm has {} numbers; orders {} and {} have {}",
                                          h.corrections_mm.size(), h.order, h.order_heights, terms));
    }
  }
}

void add_lens(const std::string& section, const RigLens& lens, std::vector<std::pair<std::string, double>>& keys) {
  keys.insert(keys.end(), {{section + ".fx_px", lens.fx_px},
                           {section + ".fy_px", lens.fy_px},
                           {section + ".cx_px", lens.cx_px},
                           {section + ".cy_px", lens.cy_px},
                           {section + ".k1", lens.k1},
                           {section + ".k2", lens.k2},
                           {section + ".p1", lens.p1},
                           {section + ".p2", lens.p2},
                           {section + ".k3", lens.k3}});
}

}  // namespace

std::vector<std::array<int, 3>> height_terms(int order, int order_heights) {
  std::vector<std::array<int, 3>> terms;
  for (int height = 0; height <= std::min(order, order_heights); ++height) {
    for (int row = 0; row + height <= order; ++row) {
      for (int column = 0; column + row + height <= order; ++column) {
        terms.push_back({column, row, height});
      }
    }
  }
  return terms;
}

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
  FieldReader reader(source, root);
  visit_rig(rig, reader);
  reader.end();
  if (rig.measure.window && rig.measure.window->first > rig.measure.window->last) {
    throw UserError(source, fmt::format("measure.window.first_row is {}, after last_row, {}", rig.measure.window->first,
                                        rig.measure.window->last));
  }
  if (rig.measure.sends_compact() && rig.measure.mode == model::Mode::binary) {
    throw UserError(source,
                    "measure.words is compact, which goes with modes grey and grey_over: binary words have 32 bits");
  }
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
  check_sections(rig, source);
  return rig;
}

void need_eight_bits(const Rig& rig, const std::string& source, const std::string& what) {
  if (rig.measure.bits() > spec::kPixelBits) {
    throw UserError(source,
                    fmt::format("measure.pixel_bits is {}; {} takes pixels of 8 bits", rig.measure.bits(), what));
  }
}

Rig load_any_rig(const std::string& name_or_file) {
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
  return parse_rig(files::read_text(name_or_file, files::kMostTextBytes), name_or_file);
}

Rig load_rig(const std::string& name_or_file) {
  Rig rig = load_any_rig(name_or_file);
  if (rig.light_plane) {
    throw UserError(name_or_file, "has a laser line (light_plane), and a projector is needed here");
  }
  return rig;
}

void expect_measured(const Rig& rig, const std::string& source, Millimetres which) {
  if (!rig.sources) {
    return;
  }
  const RigSources& from = *rig.sources;
  const auto refuse = [&](ValueSource value, const char* what, const char* name, const char* command) {
    if (value == ValueSource::drawing) {
      throw UserError(source, fmt::format("{} the drawing's and never measured; measure with `selfproj {}`, or say "
                                          "--assume {}",
                                          what, command, name));
    }
  };
  refuse(from.camera, "its camera's lens is", "camera", rig.light_plane ? "calibrate camera" : "calibrate");
  refuse(from.light, "its light's place is", "light", rig.light_plane ? "calibrate camera --laser" : "calibrate");
  refuse(from.belt, "the place of its belt (plane_z_mm, belt_pose) is", "belt", "calibrate belt");
  if (which == Millimetres::of_section) {
    return;
  }
  if (rig.parts && rig.kind == RigKind::light_section) {
    expect_way_measured(rig, rig.parts->by_encoder, source);
  } else if (from.speed == ValueSource::drawing && from.encoder == ValueSource::drawing) {
    throw UserError(source,
                    "its conveyor's speed and encoder are the drawing's and never measured; measure with `selfproj "
                    "calibrate belt --counts` or --seconds, or say --assume encoder or --assume speed");
  }
}

void expect_way_measured(const Rig& rig, bool by_encoder, const std::string& source) {
  const RigSources from =
      rig.sources.value_or(RigSources{.speed = ValueSource::assumed, .encoder = ValueSource::assumed});
  if ((by_encoder ? from.encoder : from.speed) == ValueSource::drawing) {
    throw UserError(source, fmt::format("its conveyor's {} is the drawing's and never measured; measure with `selfproj "
                                        "calibrate belt --{}`, or say --assume {}",
                                        by_encoder ? "encoder" : "speed", by_encoder ? "counts" : "seconds",
                                        by_encoder ? "encoder" : "speed"));
  }
}

void assume(Rig& rig, const std::string& names, const std::string& option) {
  std::string known;
  for (const auto& [key, member] : kSourceKeys) {
    known += fmt::format("{}{}", known.empty() ? "" : ", ", key);
  }
  for (std::size_t begin = 0; begin <= names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    const std::string name = names.substr(begin, end - begin);
    const auto found =
        std::find_if(kSourceKeys.begin(), kSourceKeys.end(), [&](const auto& key) { return name == key.first; });
    if (found == kSourceKeys.end()) {
      throw UserError(option, fmt::format("'{}' is none of {}", name, known));
    }
    if (rig.sources && (*rig.sources).*(found->second) == ValueSource::drawing) {
      (*rig.sources).*(found->second) = ValueSource::assumed;
    }
    begin = end + 1;
  }
}

std::string to_yaml(const Rig& rig) {
  FieldWriter writer;
  visit_rig(rig, writer);
  return writer.yaml();
}

std::vector<std::pair<std::string, double>> geometry_of(const Rig& rig) {
  std::vector<std::pair<std::string, double>> keys = {{"camera.rows", rig.camera.rows},
                                                      {"camera.columns", rig.camera.columns},
                                                      {"camera.pixel_pitch_mm", rig.camera.pixel_pitch_mm},
                                                      {"camera.focal_length_mm", rig.camera.focal_length_mm},
                                                      {"projector.x_mm", rig.projector.x_mm},
                                                      {"projector.z_mm", rig.projector.z_mm},
                                                      {"projector.tilt_rad", rig.projector.tilt_rad},
                                                      {"projector.focal_length_mm", rig.projector.focal_length_mm},
                                                      {"projector.lines", rig.projector.lines},
                                                      {"projector.columns", rig.projector.columns},
                                                      {"projector.line_pitch_mm", rig.projector.line_pitch_mm},
                                                      {"projector.column_pitch_mm", rig.projector.column_pitch_mm},
                                                      {"projector.center_xp_mm", rig.projector.center_xp_mm},
                                                      {"projector.center_yp_mm", rig.projector.center_yp_mm}};
  if (rig.calibration) {
    add_lens("camera_lens", rig.calibration->camera, keys);
  }
  if (rig.calibration && !rig.light_plane) {
    const std::array<double, 3>& turn = rig.calibration->rotation_rad;
    const std::array<double, 3>& move = rig.calibration->translation_mm;
    add_lens("projector_lens", rig.calibration->projector, keys);
    keys.insert(keys.end(), {{"projector_pose.rotation_x_rad", turn[0]},
                             {"projector_pose.rotation_y_rad", turn[1]},
                             {"projector_pose.rotation_z_rad", turn[2]},
                             {"projector_pose.translation_x_mm", move[0]},
                             {"projector_pose.translation_y_mm", move[1]},
                             {"projector_pose.translation_z_mm", move[2]}});
  }
  if (rig.light_plane) {
    keys.insert(keys.end(), {{"light_plane.normal_x", rig.light_plane->normal[0]},
                             {"light_plane.normal_y", rig.light_plane->normal[1]},
                             {"light_plane.normal_z", rig.light_plane->normal[2]},
                             {"light_plane.distance_mm", rig.light_plane->distance_mm}});
  }
  if (rig.belt_pose) {
    const auto& [direction, normal] = *rig.belt_pose;
    keys.insert(keys.end(), {{"belt_pose.direction_x", direction[0]},
                             {"belt_pose.direction_y", direction[1]},
                             {"belt_pose.direction_z", direction[2]},
                             {"belt_pose.normal_x", normal[0]},
                             {"belt_pose.normal_y", normal[1]},
                             {"belt_pose.normal_z", normal[2]}});
  }
  if (rig.heights) {
    keys.insert(keys.end(), {{"plane_z_mm", rig.plane_z_mm},
                             {"heights.min_mm", rig.heights->min_mm},
                             {"heights.max_mm", rig.heights->max_mm},
                             {"heights.order", rig.heights->order},
                             {"heights.order_heights", rig.heights->order_heights}});
    for (std::size_t i = 0; i < rig.heights->corrections_mm.size(); ++i) {
      keys.emplace_back("heights.corrections_mm." + std::to_string(i + 1), rig.heights->corrections_mm[i]);
    }
  }
  return keys;
}

bool same_geometry(double a, double b) { return std::abs(a - b) <= 1e-12 * std::max(std::abs(a), std::abs(b)); }

}  // namespace selfproj::rig
