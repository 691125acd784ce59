// Noise and disturbances of the camera: what its lens, its sensor, its mounting and its trigger do to an image.
#ifndef SELFPROJ_SIM_SCENE_CAMERA_ERRORS_H
#define SELFPROJ_SIM_SCENE_CAMERA_ERRORS_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "selfproj/rig/rig.h"
#include "sim/scene/lit_surface.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"
#include "sim/scene/world.h"

namespace selfproj::sim {

// Adds shot noise and read noise, as switched on in `options`, to an image of grey values. The noise is normal, with
// variance (grey - dark) / electrons_per_grey + read_noise^2. The seed of `imaging` and the frame number determine it.
void add_noise(const rig::RigImaging& imaging, const RenderOptions& options, int frame, std::span<float> pixels);

// Rounds grey values to those of pixels of 8..12 bits, in steps of 2^(8 - bits), and limits them to
// (2^bits - 1) 2^(8 - bits), which is 255 with 8 bits.
void quantize(int bits, std::span<float> pixels);

// The pixels of 8 bits, or of 8..12, that grey values are rounded and limited to.
void quantize(std::span<const float> from, std::span<std::uint8_t> to);
void quantize(int bits, std::span<const float> from, std::span<std::uint16_t> to);

// The same offsets and gains in every frame of a camera.
class FixedPatternMap {
 public:
  FixedPatternMap(const FixedPattern& pattern, double electrons_per_grey, std::size_t pixels, std::uint64_t seed);

  // dark + gain (value - dark); before the noise, because electrons are counted after it.
  void add_gains(double dark, std::span<float> pixels) const;

  void add_offsets(std::span<float> pixels) const;

 private:
  std::vector<float> gains_;
  std::vector<float> offsets_;  // grey values
};

// Each pixel is drawn by itself, so the number of defects is that of a binomial distribution.
class DefectMap {
 public:
  DefectMap(const DefectPixels& defects, std::size_t pixels, std::uint64_t seed);

  // Hot pixels get their offset on top, dead ones are `dark`.
  void apply(double dark, std::span<float> pixels) const;

  [[nodiscard]] std::size_t hot() const { return hot_.size(); }
  [[nodiscard]] std::size_t dead() const { return dead_.size(); }

 private:
  struct Hot {
    std::size_t pixel;
    float offset;
  };
  std::vector<Hot> hot_;
  std::vector<std::size_t> dead_;
};

// Adds the offsets of a frame, normal and new in every frame, to an image of this many columns.
void add_row_noise(const RowNoise& noise, std::uint64_t seed, int frame, int columns, std::span<float> pixels);

// min(dark + exposure (value - dark), well_grey), before the noise.
void saturate(const Saturation& saturation, double dark, std::span<float> pixels);

// The grey value that the lamps add to a frame whose exposure is centred on t: the mean over the exposure of
// grey (1 + modulation sin(2π hz t)), so that long exposures see less of it (sinc).
double flicker_grey(const Flicker& flicker, double t, double exposure_s);

// The scene on a belt that swings: its heights are those of `scene`, which must live as long, and
// belt_mm sin(2π belt_hz t) more.
std::unique_ptr<Scene> on_swinging_belt(const Scene& scene, const Vibration& vibration);

// How far the camera's image is moved at the time t, pixels.
struct ImageShift {
  double rows, columns;
};
ImageShift camera_shift(const Vibration& vibration, double t);

// Moves an image: what was at a pixel comes to its place plus the shift. Keys's cubic convolution, which moves the
// centroid of a spot exactly. The border is repeated outwards.
void move_image(int rows, int columns, ImageShift shift, std::span<float> pixels);

// How much later than planned a frame of a belt with this speed (mm/s) is taken, s: normal, new in every frame. On a
// belt that stands still the encoder does not matter.
double lateness(const Jitter& jitter, std::uint64_t seed, int frame, double speed);

// The distance in rows when the part has moved `way_mm`: (min + max)/2 + (max - min)/2 sin(2π way / period).
double second_line_rows(const SecondLine& line, double way_mm);

// Adds the second reflection to an image of grey values. `without` is the grey value without projected light; what lies
// above it is reflected, linear between rows.
void add_second_line(const SecondLine& line, double way_mm, int rows, int columns, double without,
                     std::span<float> pixels);

// What the world adds to the images of one camera: before the noise of its light, and after it.
class DisturbedCamera {
 public:
  // Null if the world does not disturb it. Scene and surface must live as long as the camera.
  static std::unique_ptr<const DisturbedCamera> of(const PerturbedRig& actual, const Scene& scene,
                                                   const LitSurface& surface, const World& world);

  // A frame as it is taken. `depths` gives z in mm of what each pixel sees.
  struct Shot {
    int frame;
    double t;  // s, the middle of the exposure
    double exposure_s;
    const ProjectedLight& pattern;
    std::function<void(std::span<float> z)> depths;
  };

  // In the order of the light's way: bounce of light, second reflection, ambient light that flickers, defocus,
  // vibration, exposure and full wells, gains of the pixels.
  void add_light(const Shot& shot, std::span<float> pixels) const;

  // Offsets of pixels and rows, defect pixels.
  void add_faults(int frame, std::span<float> pixels) const;

 private:
  DisturbedCamera(const PerturbedRig& actual, const Scene& scene, const LitSurface& surface, const World& world);
  void defocus(const Shot& shot, std::span<float> pixels) const;

  PerturbedRig actual_;
  World world_;
  double without_light_;  // grey value of a white surface without projected light
  double speed_;          // of the part, mm/s
  std::optional<BounceLight> bounce_;
  std::optional<FixedPatternMap> fixed_pattern_;
  std::optional<DefectMap> defects_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_CAMERA_ERRORS_H
