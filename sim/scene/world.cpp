#include "sim/scene/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/text.h"
#include "host/rig/yaml.h"
#include "selfproj/files/user_error.h"
#include "sim/scene/world_built_in.h"

namespace selfproj::sim {
namespace {

constexpr rig::ValueRange kShare{.low = 0, .high = 1};
constexpr double kMaxGrey = 255;
constexpr std::size_t kMaxBytes = 1 << 20;

Gloss read_gloss(rig::FieldReader& from, const char* section) {
  Gloss gloss;
  from.begin(section);
  from.number("diffuse", gloss.diffuse, 1, kShare);
  from.number("reflectance", gloss.reflectance, 1, kShare);
  from.number("roughness", gloss.roughness, 1, {.low = 0.02, .high = 1});
  from.end();
  return gloss;
}

Defocus read_defocus(rig::FieldReader& from, const char* section) {
  Defocus defocus;
  from.begin(section);
  from.number("f_number", defocus.f_number, 1, {.low = 0.5, .high = 1e3});
  from.number("focus_above_plane_mm", defocus.focus_above_plane_mm, 1, {.low = -100, .high = 100});
  from.end();
  return defocus;
}

void read_surface(rig::FieldReader& from, World& world) {
  from.begin("texture");
  from.number("contrast", world.texture.emplace().contrast, 1, kShare);
  from.number("scale_mm", world.texture->scale_mm, 1, rig::kPositive);
  from.end();
  from.begin("bounce");
  from.number("strength", world.bounce.emplace().strength, 1, kShare);
  from.end();
  world.camera_defocus = read_defocus(from, "camera_defocus");
  world.projector_defocus = read_defocus(from, "projector_defocus");
  from.begin("gamma");
  from.number("gamma", world.gamma.emplace().gamma, 1, {.low = 0.1, .high = 10});
  from.number("compensated", world.gamma->compensated, 1, {.low = 0.1, .high = 10});
  from.end();
}

void read_camera(rig::FieldReader& from, World& world) {
  from.begin("fixed_pattern");
  from.number("dsnu_electrons", world.fixed_pattern.emplace().dsnu_electrons, 1, rig::kNotNegative);
  from.number("prnu", world.fixed_pattern->prnu, 1, kShare);
  from.end();
  from.begin("defect_pixels");
  from.number("hot", world.defect_pixels.emplace().hot, 1, {.low = 0, .high = 0.5});
  from.number("dead", world.defect_pixels->dead, 1, {.low = 0, .high = 0.5});
  from.number("min_hot_grey", world.defect_pixels->min_hot_grey, 1, {.low = 0, .high = kMaxGrey});
  from.end();
  from.begin("row_noise");
  from.number("grey", world.row_noise.emplace().grey, 1, {.low = 0, .high = kMaxGrey});
  from.end();
  from.begin("saturation");
  from.number("exposure", world.saturation.emplace().exposure, 1, {.low = 0, .high = 1e3});
  from.number("well_grey", world.saturation->well_grey, 1, {.low = 1, .high = kMaxGrey});
  from.end();
}

void read_line(rig::FieldReader& from, World& world) {
  from.begin("flicker");
  from.number("grey", world.flicker.emplace().grey, 1, {.low = 0, .high = kMaxGrey});
  from.number("modulation", world.flicker->modulation, 1, kShare);
  from.number("hz", world.flicker->hz, 1, rig::kPositive);
  from.end();
  from.begin("vibration");
  from.number("belt_mm", world.vibration.emplace().belt_mm, 1, {.low = 0, .high = 100});
  from.number("belt_hz", world.vibration->belt_hz, 1, rig::kPositive);
  from.number("camera_px", world.vibration->camera_px, 1, {.low = 0, .high = 100});
  from.number("camera_hz", world.vibration->camera_hz, 1, rig::kPositive);
  from.end();
  from.begin("jitter");
  from.number("trigger_us", world.jitter.emplace().trigger_us, 1, {.low = 0, .high = 1e3});
  from.number("encoder_mm", world.jitter->encoder_mm, 1, {.low = 0, .high = 10});
  from.end();
  SecondLine& line = world.second_line.emplace();
  from.begin("second_line");
  from.number("share", line.share, 1, kShare);
  from.number("min_rows", line.min_rows, 1, {.low = 0, .high = 1e4});
  from.number("max_rows", line.max_rows, 1, {.low = line.min_rows, .high = 1e4});
  from.number("period_mm", line.period_mm, 1, rig::kPositive);
  from.end();
}

// Separates NAME=STRENGTH.
std::pair<std::string, std::optional<std::string>> parts_of(const std::string& text) {
  const std::size_t at = text.find('=');
  return at == std::string::npos ? std::pair(text, std::optional<std::string>())
                                 : std::pair(text.substr(0, at), std::optional(text.substr(at + 1)));
}

void set_gloss(World& world, const WorldFile& file, const std::string& preset) {
  std::string names;
  for (const auto& [name, gloss] : file.presets) {
    if (name == preset) {
      world.gloss = gloss;
      return;
    }
    names += (names.empty() ? "" : ", ") + name;
  }
  throw UserError("--disturb gloss=" + preset, "is none of " + names);
}

}  // namespace

bool World::disturbs_camera() const {
  return bounce || camera_defocus || fixed_pattern || defect_pixels || row_noise || saturation || flicker ||
         vibration || second_line;
}

RenderOptions options_without(const std::vector<std::string>& names) {
  RenderOptions options;
  for (const auto& [name, flag] : kErrorSources) {
    options.*flag = std::find(names.begin(), names.end(), name) == names.end();
  }
  return options;
}

WorldFile load_world(const std::string& name_or_file) {
  const bool built_in = name_or_file == kBuiltInWorld;
  const std::string source = built_in ? "world.yaml" : name_or_file;
  rig::FieldReader from(source,
                        rig::parse_yaml(built_in ? kWorldText : files::read_text(name_or_file, kMaxBytes), source));
  WorldFile file;
  std::int64_t seed = 0;
  from.integer64("seed", seed);
  file.world.seed = static_cast<std::uint64_t>(seed);
  file.presets = {{"painted-metal", read_gloss(from, "painted_metal")},
                  {"matt-plastic", read_gloss(from, "matt_plastic")},
                  {"brushed-steel", read_gloss(from, "brushed_steel")}};
  read_surface(from, file.world);
  read_camera(from, file.world);
  read_line(from, file.world);
  from.end();
  return file;
}

const std::vector<WorldSwitch>& world_switches() {
  static const std::vector<WorldSwitch> all = {
      {"gloss", "preset", 0, 0, [](World& /*to*/, const World& /*from*/) {}, nullptr},
      {"texture", "contrast", 0, 1, [](World& to, const World& from) { to.texture = from.texture; },
       [](World& of) -> double& { return of.texture->contrast; }},
      {"bounce", "strength", 0, 1, [](World& to, const World& from) { to.bounce = from.bounce; },
       [](World& of) -> double& { return of.bounce->strength; }},
      {"camera-defocus", "f-number", 0.5, 1e3,
       [](World& to, const World& from) { to.camera_defocus = from.camera_defocus; },
       [](World& of) -> double& { return of.camera_defocus->f_number; }},
      {"projector-defocus", "f-number", 0.5, 1e3,
       [](World& to, const World& from) { to.projector_defocus = from.projector_defocus; },
       [](World& of) -> double& { return of.projector_defocus->f_number; }},
      {"gamma", "gamma", 0.1, 10, [](World& to, const World& from) { to.gamma = from.gamma; },
       [](World& of) -> double& { return of.gamma->gamma; }},
      {"fixed-pattern", "PRNU", 0, 1, [](World& to, const World& from) { to.fixed_pattern = from.fixed_pattern; },
       [](World& of) -> double& { return of.fixed_pattern->prnu; }},
      {"defect-pixels", "share of hot pixels", 0, 0.5,
       [](World& to, const World& from) { to.defect_pixels = from.defect_pixels; },
       [](World& of) -> double& { return of.defect_pixels->hot; }},
      {"row-noise", "grey values", 0, kMaxGrey, [](World& to, const World& from) { to.row_noise = from.row_noise; },
       [](World& of) -> double& { return of.row_noise->grey; }},
      {"saturation", "factor of the exposure", 0, 1e3,
       [](World& to, const World& from) { to.saturation = from.saturation; },
       [](World& of) -> double& { return of.saturation->exposure; }},
      {"flicker", "grey values", 0, kMaxGrey, [](World& to, const World& from) { to.flicker = from.flicker; },
       [](World& of) -> double& { return of.flicker->grey; }},
      {"vibration", "mm of the belt", 0, 100, [](World& to, const World& from) { to.vibration = from.vibration; },
       [](World& of) -> double& { return of.vibration->belt_mm; }},
      {"jitter", "mm of the encoder", 0, 10, [](World& to, const World& from) { to.jitter = from.jitter; },
       [](World& of) -> double& { return of.jitter->encoder_mm; }},
      {"second-line", "share", 0, 1, [](World& to, const World& from) { to.second_line = from.second_line; },
       [](World& of) -> double& { return of.second_line->share; }}};
  return all;
}

const WorldSwitch& find_world_switch(std::string_view name) {
  const auto found = std::find_if(world_switches().begin(), world_switches().end(),
                                  [&](const WorldSwitch& entry) { return name == entry.name; });
  if (found != world_switches().end()) {
    return *found;
  }
  std::string names;
  for (const WorldSwitch& entry : world_switches()) {
    names += (names.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw UserError("--disturb " + std::string(name), "is none of " + names);
}

World world_of(const WorldFile& file, const std::vector<std::string>& disturbances) {
  World world;
  world.seed = file.world.seed;
  std::set<std::string> seen;
  for (const std::string& text : disturbances) {
    const auto [name, strength] = parts_of(text);
    const WorldSwitch& entry = find_world_switch(name);
    if (!seen.insert(name).second) {
      throw UserError("--disturb " + text, "names " + name + " twice");
    }
    if (entry.parameter == nullptr) {
      set_gloss(world, file, strength.value_or(file.presets.front().first));
      continue;
    }
    entry.on(world, file.world);
    if (strength) {
      const std::optional<double> value = files::number_of_text<double>(*strength);
      if (!value || *value < entry.min || *value > entry.max) {
        throw UserError("--disturb " + text,
                        fmt::format("needs {}, a number from {} to {}", entry.strength, entry.min, entry.max));
      }
      entry.parameter(world) = *value;
    }
  }
  return world;
}

}  // namespace selfproj::sim
