#include "sim/scene/camera_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "selfproj/model/generated/selfproj_spec.h"
#include "sim/scene/optics.h"
#include "sim/scene/random.h"
#include "sim/scene/scene.h"

namespace selfproj::sim {
namespace {

constexpr float kWhite = 255;  // of an 8-bit image

// Steps in a grey value, and the pixel of `bits` for a grey value.
float steps_of(int bits) { return static_cast<float>(1 << (bits - spec::kPixelBits)); }
float pixel_of(int bits, float value) {
  return std::clamp(std::nearbyint(steps_of(bits) * value), 0.0F, static_cast<float>((1 << bits) - 1));
}

}  // namespace

// Shot noise: the variance is the number of electrons, as in Poisson's distribution, for the light above the dark
// value; the distribution is taken as normal.
void add_noise(const rig::RigImaging& imaging, const RenderOptions& options, int frame, std::span<float> pixels) {
  if (!options.shot_noise && !options.read_noise) {
    return;
  }
  NormalNoise noise(static_cast<std::uint64_t>(imaging.seed), static_cast<std::uint64_t>(frame));
  const double shot = options.shot_noise ? 1 / imaging.electrons_per_grey : 0;
  const double read = options.read_noise ? imaging.read_noise * imaging.read_noise : 0;
  const auto with = [&](float value, float random) {
    const double variance = read + shot * std::max(0.0, static_cast<double>(value) - imaging.dark);
    return value + random * static_cast<float>(std::sqrt(variance));
  };
  for (std::size_t i = 0; i < pixels.size(); i += 2) {
    const auto [a, b] = noise.two();
    pixels[i] = with(pixels[i], a);
    if (i + 1 < pixels.size()) {
      pixels[i + 1] = with(pixels[i + 1], b);
    }
  }
}

void quantize(int bits, std::span<float> pixels) {
  std::ranges::transform(pixels, pixels.begin(), [&](float value) { return pixel_of(bits, value) / steps_of(bits); });
}

void quantize(int bits, std::span<const float> from, std::span<std::uint16_t> to) {
  std::ranges::transform(from, to.begin(),
                         [&](float value) { return static_cast<std::uint16_t>(pixel_of(bits, value)); });
}

void quantize(std::span<const float> from, std::span<std::uint8_t> to) {
  std::transform(from.begin(), from.end(), to.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::clamp(std::nearbyint(value), 0.0F, kWhite));
  });
}

FixedPatternMap::FixedPatternMap(const FixedPattern& pattern, double electrons_per_grey, std::size_t pixels,
                                 std::uint64_t seed)
    : gains_(pixels), offsets_(pixels) {
  constexpr std::uint64_t kStream = 0x46504e;  // apart from those of frames
  NormalNoise noise(seed, kStream);
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto [gain, offset] = noise.two();
    gains_[i] = 1 + static_cast<float>(pattern.prnu) * gain;
    offsets_[i] = static_cast<float>(pattern.dsnu_electrons / electrons_per_grey) * offset;
  }
}

void FixedPatternMap::add_gains(double dark, std::span<float> pixels) const {
  const auto zero = static_cast<float>(dark);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = zero + gains_[i] * (pixels[i] - zero);
  }
}

void FixedPatternMap::add_offsets(std::span<float> pixels) const {
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] += offsets_[i];
  }
}

DefectMap::DefectMap(const DefectPixels& defects, std::size_t pixels, std::uint64_t seed) {
  EvenNumbers random(seed);
  for (std::size_t i = 0; i < pixels; ++i) {
    const double drawn = random.next();
    if (drawn < defects.hot) {
      const double level = defects.min_hot_grey + (static_cast<double>(kWhite) - defects.min_hot_grey) * random.next();
      hot_.push_back({i, static_cast<float>(level)});
    } else if (drawn < defects.hot + defects.dead) {
      dead_.push_back(i);
    }
  }
}

void DefectMap::apply(double dark, std::span<float> pixels) const {
  for (const Hot& hot : hot_) {
    pixels[hot.pixel] += hot.offset;
  }
  for (const std::size_t i : dead_) {
    pixels[i] = static_cast<float>(dark);
  }
}

void add_row_noise(const RowNoise& noise, std::uint64_t seed, int frame, int columns, std::span<float> pixels) {
  constexpr std::uint64_t kApart = 0x726f7773;  // from the noise of pixels
  NormalNoise random(seed + kApart, static_cast<std::uint64_t>(frame));
  const auto width = static_cast<std::size_t>(columns);
  for (std::size_t first = 0; first < pixels.size(); first += width) {
    const float offset = static_cast<float>(noise.grey) * random.two().first;
    for (float& value : pixels.subspan(first, width)) {
      value += offset;
    }
  }
}

void saturate(const Saturation& saturation, double dark, std::span<float> pixels) {
  for (float& value : pixels) {
    value = static_cast<float>(
        std::min(dark + saturation.exposure * (static_cast<double>(value) - dark), saturation.well_grey));
  }
}

double flicker_grey(const Flicker& flicker, double t, double exposure_s) {
  const double half = std::numbers::pi * flicker.hz * exposure_s;
  const double mean = half > 0 ? std::sin(half) / half : 1;
  return flicker.grey * (1 + flicker.modulation * mean * std::sin(2 * std::numbers::pi * flicker.hz * t));
}

namespace {

class SwingingBelt final : public WrappedScene {
 public:
  SwingingBelt(const Scene& scene, const Vibration& vibration)
      : WrappedScene(scene), amplitude_(vibration.belt_mm), pulsation_(2 * std::numbers::pi * vibration.belt_hz) {}
  [[nodiscard]] double height(double x, double y, double t) const override {
    return WrappedScene::height(x, y, t) + swing(t);
  }
  // The swing's bounds over the time are those of a straight line through its middle of the greatest slope.
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override {
    const HeightRange range = WrappedScene::range(box, t0, t1);
    const double middle = swing((t0 + t1) / 2);
    const double off = std::min(amplitude_ * pulsation_ * (t1 - t0) / 2, 2 * amplitude_);
    return {range.low + middle - off, range.high + middle + off};
  }

 private:
  [[nodiscard]] double swing(double t) const { return amplitude_ * std::sin(pulsation_ * t); }

  double amplitude_;
  double pulsation_;
};

// Weights of the four pixels around a place that is `f` after the second of them (Keys 1981, a = -1/2).
std::array<float, 4> cubic(double f) {
  return {static_cast<float>(((-0.5 * f + 1) * f - 0.5) * f), static_cast<float>((1.5 * f - 2.5) * f * f + 1),
          static_cast<float>(((-1.5 * f + 2) * f + 0.5) * f), static_cast<float>((0.5 * f - 0.5) * f * f)};
}

}  // namespace

std::unique_ptr<Scene> on_swinging_belt(const Scene& scene, const Vibration& vibration) {
  return std::make_unique<SwingingBelt>(scene, vibration);
}

ImageShift camera_shift(const Vibration& vibration, double t) {
  const double phase = 2 * std::numbers::pi * vibration.camera_hz * t;
  return {vibration.camera_px * std::sin(phase), vibration.camera_px * std::cos(phase)};
}

void move_image(int rows, int columns, ImageShift shift, std::span<float> pixels) {
  const auto pass = [&](std::span<const float> from, std::span<float> to, bool down, double by) {
    const int whole = static_cast<int>(std::floor(-by));
    const std::array<float, 4> weights = cubic(-by - whole);
    const int last = (down ? rows : columns) - 1;
    const std::ptrdiff_t step = down ? columns : 1;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(r) * columns + c;
        const int place = down ? r : c;
        float sum = 0;
        for (int k = 0; k < 4; ++k) {
          const int at = std::clamp(place + whole - 1 + k, 0, last);
          sum += weights.at(static_cast<std::size_t>(k)) * from[static_cast<std::size_t>(i + (at - place) * step)];
        }
        to[static_cast<std::size_t>(i)] = sum;
      }
    }
  };
  std::vector<float> half(pixels.size());
  pass(pixels, half, true, shift.rows);
  pass(half, pixels, false, shift.columns);
}

double lateness(const Jitter& jitter, std::uint64_t seed, int frame, double speed) {
  constexpr std::uint64_t kApart = 0x6a6974;  // from the noise of pixels
  constexpr double kMicro = 1e-6;
  NormalNoise random(seed + kApart, static_cast<std::uint64_t>(frame));
  const auto [trigger, encoder] = random.two();
  return kMicro * jitter.trigger_us * static_cast<double>(trigger) +
         (speed > 0 ? jitter.encoder_mm / speed * static_cast<double>(encoder) : 0);
}

double second_line_rows(const SecondLine& line, double way_mm) {
  return (line.min_rows + line.max_rows) / 2 +
         (line.max_rows - line.min_rows) / 2 * std::sin(2 * std::numbers::pi * way_mm / line.period_mm);
}

void add_second_line(const SecondLine& line, double way_mm, int rows, int columns, double without,
                     std::span<float> pixels) {
  const double distance = second_line_rows(line, way_mm);
  const int whole = static_cast<int>(std::floor(distance));
  const double f = distance - whole;
  const auto at = [&](int row, int column) {
    return row < 0
               ? 0.0
               : std::max(0.0, static_cast<double>(pixels[static_cast<std::size_t>(row * columns + column)]) - without);
  };
  for (int r = rows - 1; r >= 0; --r) {  // from below, so that what is reflected is still the first reflection
    for (int c = 0; c < columns; ++c) {
      pixels[static_cast<std::size_t>(r * columns + c)] +=
          static_cast<float>(line.share * ((1 - f) * at(r - whole, c) + f * at(r - whole - 1, c)));
    }
  }
}

std::unique_ptr<const DisturbedCamera> DisturbedCamera::of(const PerturbedRig& actual, const Scene& scene,
                                                           const LitSurface& surface, const World& world) {
  return world.disturbs_camera()
             ? std::unique_ptr<const DisturbedCamera>(new DisturbedCamera(actual, scene, surface, world))
             : nullptr;
}

DisturbedCamera::DisturbedCamera(const PerturbedRig& actual, const Scene& scene, const LitSurface& surface,
                                 const World& world)
    : actual_(actual), world_(world), without_light_(actual.rig.imaging.ambient), speed_(scene.speed()) {
  const std::size_t pixels = actual.rig.camera.pixels();
  if (world.bounce) {
    bounce_.emplace(actual, scene, surface, *world.bounce);
  }
  if (world.fixed_pattern) {
    fixed_pattern_.emplace(*world.fixed_pattern, actual.rig.imaging.electrons_per_grey, pixels, world.seed);
  }
  if (world.defect_pixels) {
    defects_.emplace(*world.defect_pixels, pixels, world.seed);
  }
}

void DisturbedCamera::defocus(const Shot& shot, std::span<float> pixels) const {
  const rig::RigCamera& camera = actual_.rig.camera;
  const FocusedLens lens(camera.focal_length_mm, world_.camera_defocus->f_number, camera.pixel_pitch_mm,
                         actual_.rig.plane_z_mm - world_.camera_defocus->focus_above_plane_mm);
  std::vector<float> sigma(pixels.size());
  shot.depths(sigma);
  std::transform(sigma.begin(), sigma.end(), sigma.begin(),
                 [&](float z) { return static_cast<float>(lens.sigma_px(static_cast<double>(z))); });
  spread(camera.rows, camera.columns, sigma, pixels);
}

void DisturbedCamera::add_light(const Shot& shot, std::span<float> pixels) const {
  const rig::RigCamera& camera = actual_.rig.camera;
  const double dark = actual_.rig.imaging.dark;
  if (bounce_) {
    bounce_->add(shot.pattern, shot.t, pixels);
  }
  if (world_.second_line) {
    add_second_line(*world_.second_line, speed_ * shot.t, camera.rows, camera.columns, without_light_, pixels);
  }
  if (world_.flicker) {
    const auto grey = static_cast<float>(flicker_grey(*world_.flicker, shot.t, shot.exposure_s));
    std::transform(pixels.begin(), pixels.end(), pixels.begin(), [grey](float value) { return value + grey; });
  }
  if (world_.camera_defocus) {
    defocus(shot, pixels);
  }
  if (world_.vibration && world_.vibration->camera_px > 0) {
    move_image(camera.rows, camera.columns, camera_shift(*world_.vibration, shot.t), pixels);
  }
  if (world_.saturation) {
    saturate(*world_.saturation, dark, pixels);
  }
  if (fixed_pattern_) {
    fixed_pattern_->add_gains(dark, pixels);
  }
}

void DisturbedCamera::add_faults(int frame, std::span<float> pixels) const {
  if (fixed_pattern_) {
    fixed_pattern_->add_offsets(pixels);
  }
  if (world_.row_noise) {
    add_row_noise(*world_.row_noise, static_cast<std::uint64_t>(actual_.rig.imaging.seed), frame,
                  actual_.rig.camera.columns, pixels);
  }
  if (defects_) {
    defects_->apply(actual_.rig.imaging.dark, pixels);
  }
}

}  // namespace selfproj::sim
