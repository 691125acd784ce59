// What is simulated beside scene and rig: sources of error, which are on by default, and disturbances of the world,
// which are off unless they are named. The parameters of these, and where they come from, stand in world.yaml.
#ifndef SELFPROJ_SIM_SCENE_WORLD_H
#define SELFPROJ_SIM_SCENE_WORLD_H

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace selfproj::sim {

// Light that a surface throws back mostly about the mirror's direction, by a microfacet model.
struct Gloss {
  double diffuse = 1;      // factor of the albedo
  double reflectance = 0;  // of a facet at normal incidence, 0..1
  double roughness = 0.1;  // RMS slope of the facets, > 0
};

// The albedo varies over the surface, as with grain, print or scratches.
struct Texture {
  double contrast = 0;  // standard deviation of the albedo over its mean
  double scale_mm = 1;  // period of its waves
};

// Lit faces throw light onto others.
struct Bounce {
  double strength = 1;  // 1: what evenly scattering faces throw
};

// A lens blurs what is nearer or farther than its focus.
struct Defocus {
  double f_number = 4;
  double focus_above_plane_mm = 0;  // the lens is focused on what is this high in the middle of its view
};

// The projector's light is a power of the 8-bit level that it is sent.
struct ProjectorGamma {
  double gamma = 1;        // of the projector
  double compensated = 1;  // the gamma that the sender of the patterns believes in; 1: it sends the light as it is
};

// Fixed-pattern noise of a sensor as EMVA 1288 states it: offsets in the dark (DSNU) and gains (PRNU) of its pixels.
struct FixedPattern {
  double dsnu_electrons = 0;  // standard deviation of the offsets
  double prnu = 0;            // standard deviation of the gains
};

// Hot pixels are bright without light, and dead ones stay dark.
struct DefectPixels {
  double hot = 0;           // share of the pixels
  double dead = 0;          // share of the pixels
  double min_hot_grey = 0;  // a hot pixel's offset is drawn evenly from here to 255
};

// Every row of a frame gets an offset of its own, because its pixels are read together.
struct RowNoise {
  double grey = 0;  // standard deviation
};

// An exposure that is too long for a bright part fills the pixels' wells.
struct Saturation {
  double exposure = 1;     // factor of all light
  double well_grey = 255;  // grey value at which a pixel's well is full
};

// Ambient light of lamps on alternating current, which flickers at twice the mains' frequency.
struct Flicker {
  double grey = 0;        // mean grey value that the lamps add
  double modulation = 0;  // (max - min) / (max + min) of their light, 0..1
  double hz = 100;
};

// The belt swings up and down, and the camera tips, which moves its image.
struct Vibration {
  double belt_mm = 0;  // amplitude
  double belt_hz = 25;
  double camera_px = 0;  // amplitude along rows and, a quarter of a period later, along columns
  double camera_hz = 50;
};

// The camera is triggered a little early or late, and the encoder does not count where the belt truly is.
struct Jitter {
  double trigger_us = 0;  // standard deviation of the time of a frame
  double encoder_mm = 0;  // standard deviation of the belt's place at it
};

// A second reflection: the camera sees the projected light again, weaker and `min_rows` to `max_rows` below, as in a
// shiny wall or between the glasses of a window. The distance swings with the way of the part, so that a measurement of
// the good part at one place does not know it.
struct SecondLine {
  double share = 0;  // of the first reflection's light
  double min_rows = 0;
  double max_rows = 0;
  double period_mm = 1;
};

// The disturbances that are on.
struct World {
  std::optional<Gloss> gloss;
  std::optional<Texture> texture;
  std::optional<Bounce> bounce;
  std::optional<Defocus> camera_defocus;
  std::optional<Defocus> projector_defocus;
  std::optional<ProjectorGamma> gamma;
  std::optional<FixedPattern> fixed_pattern;
  std::optional<DefectPixels> defect_pixels;
  std::optional<RowNoise> row_noise;
  std::optional<Saturation> saturation;
  std::optional<Flicker> flicker;
  std::optional<Vibration> vibration;
  std::optional<Jitter> jitter;
  std::optional<SecondLine> second_line;
  std::uint64_t seed = 1;  // of the texture, and of all that belongs to one camera

  [[nodiscard]] bool any() const {
    return disturbs_camera() || gloss || texture || projector_defocus || gamma || jitter;
  }

  // Whether the camera itself adds anything to an image (camera_errors.h).
  [[nodiscard]] bool disturbs_camera() const;
};

// The parameters of all disturbances. Every member of `world` is present but the gloss, which has presets.
struct WorldFile {
  World world;
  std::vector<std::pair<std::string, Gloss>> presets;
};

// The built-in world.yaml, or a file like it. Throws UserError with file, line, key and reason.
WorldFile load_world(const std::string& name_or_file);
inline constexpr const char* kBuiltInWorld = "built-in";

// A disturbance by its name, with the parameter that is its strength.
struct WorldSwitch {
  const char* name;
  const char* strength;  // the parameter, with its unit
  double min, max;       // of the strength
  void (*on)(World& to, const World& parameters);
  double& (*parameter)(
      World& of);  // the strength of a disturbance that is on; null for gloss, whose strengths are presets
};
const std::vector<WorldSwitch>& world_switches();
const WorldSwitch& find_world_switch(std::string_view name);

// The world with these disturbances on, each as NAME or NAME=STRENGTH. Throws UserError about --disturb if a name is
// unknown, doubled, or its strength no number within its bounds or no preset.
World world_of(const WorldFile& file, const std::vector<std::string>& disturbances);

// What a renderer simulates: sources of error, each of which can be switched off, the light, and the world.
struct RenderOptions {
  bool shot_noise = true;
  bool read_noise = true;
  bool quantization = true;  // rounding to whole grey values 0..255; 8-bit images are always rounded
  bool camera_blur = true;
  bool projector_blur = true;
  bool motion_blur = true;  // if false, all light comes at the middle of the exposure
  // Light decreases with the square of the distance from the projector. On the plane at x = y = 0 it is as strong as
  // without this option.
  bool falloff = false;
  World world = {};  // disturbances of the world; none by default

  // The same options without the disturbances of the world.
  [[nodiscard]] RenderOptions ideal_world() const {
    RenderOptions result = *this;
    result.world = {};
    return result;
  }
};

// The switches of RenderOptions that turn a source of error off, with the names that commands use.
struct ErrorSource {
  const char* name;
  bool RenderOptions::*flag;
};
inline constexpr std::array<ErrorSource, 6> kErrorSources{{
    {"shot-noise", &RenderOptions::shot_noise},
    {"read-noise", &RenderOptions::read_noise},
    {"quantization", &RenderOptions::quantization},
    {"camera-blur", &RenderOptions::camera_blur},
    {"projector-blur", &RenderOptions::projector_blur},
    {"motion-blur", &RenderOptions::motion_blur},
}};

// The default options with the sources of error of these names switched off.
RenderOptions options_without(const std::vector<std::string>& names);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_WORLD_H
