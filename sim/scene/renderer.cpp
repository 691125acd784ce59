#include "sim/scene/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/files/user_error.h"
#include "host/images/float_image.h"
#include "host/rig/rig.h"
#include "sim/scene/noise.h"
#include "sim/scene/parallel.h"

namespace selfproj {
namespace {

constexpr float kGreyMaximum = 255;  // of an 8-bit image
constexpr double kAnyTime = 1e6;     // s

const FloatImage& checked(const FloatImage& pattern, const RigProjector& projector) {
  check_pattern(pattern, projector);
  return pattern;
}

}  // namespace

RenderOptions options_without(const std::vector<std::string>& names) {
  RenderOptions options;
  for (const auto& [name, flag] : kDisturbances) {
    options.*flag = std::find(names.begin(), names.end(), name) == names.end();
  }
  return options;
}

ProjectedLight throw_light(const Rig& rig, const FloatImage& pattern, const RenderOptions& options) {
  std::optional<ProjectorFocus> focus;
  if (options.world.projector_defocus) {
    const Defocus& defocus = *options.world.projector_defocus;
    const RigProjector& size = rig.projector;
    const Pinhole projector = Pinhole::of_projector(size);
    const double sharp = projector.depth({0, 0, rig.plane_z_mm - defocus.focus_above_plane_mm});
    constexpr double kReach = 150;  // mm above the plane: as high as parts are
    const double pitch = std::sqrt(std::abs(size.line_pitch_mm * size.column_pitch_mm));
    focus.emplace(ProjectorFocus{
        {size.focal_length_mm, defocus.f_number, pitch, sharp}, projector, rig.plane_z_mm - kReach, rig.plane_z_mm});
  }
  const double blur = options.projector_blur ? rig.imaging.projector_blur_px : 0;
  return options.world.gamma ? ProjectedLight(light_through(*options.world.gamma, pattern), blur, focus)
                             : ProjectedLight(pattern, blur, focus);
}

void check_pattern(const FloatImage& pattern, const RigProjector& projector, const std::string& source) {
  if (pattern.rows != projector.lines || pattern.columns != projector.columns) {
    throw UserError(source, fmt::format("has {} lines of {} columns; the rig's projector has {} of {}", pattern.rows,
                                        pattern.columns, projector.lines, projector.columns));
  }
  const auto wrong = std::find_if_not(pattern.values.begin(), pattern.values.end(),
                                      [](float value) { return value >= 0 && value <= 1; });
  if (wrong != pattern.values.end()) {
    throw UserError(source, fmt::format("has a value of {}; light is 0 to 1", *wrong));
  }
}

Renderer::Renderer(const RealRig& real, const Scene& scene, const FloatImage& pattern, RenderOptions options)
    : rig_(real.rig),
      scene_(scene),
      options_(options),
      swinging_(options.world.vibration ? on_swinging_belt(scene, *options.world.vibration) : nullptr),
      camera_(real.camera),
      projector_(real.projector),
      lit_(std::make_shared<const LitSurface>(real, swinging_ ? *swinging_ : scene, options.falloff, options.world)),
      surface_(*lit_),
      disturbed_(DisturbedCamera::of(real, swinging_ ? *swinging_ : scene, surface_, options.world)),
      light_(throw_light(rig_, checked(pattern, rig_.projector), options)),
      grid_(rig_.camera, lens_margin(options.camera_blur ? rig_.imaging.camera_blur_px : 0)),
      views_(real, grid_, surface_.all_heights(-kAnyTime, kAnyTime)),
      levels_(std::make_shared<LevelBlocks>(grid_.blocks())),
      column_views_(std::make_shared<ColumnViews>(real.camera, rig_.camera)),
      kernel_(lens_kernel(options.camera_blur ? rig_.imaging.camera_blur_px : 0)) {
  views_.set_light(light_);
}

void Renderer::set_pattern(const FloatImage& pattern) {
  light_ = throw_light(rig_, checked(pattern, rig_.projector), options_);
  views_.set_light(light_);
  levels_ = std::make_shared<LevelBlocks>(grid_.blocks());
}

double Renderer::time_of_shot(int frame) const {
  const std::optional<Jitter>& jitter = options_.world.jitter;
  return time_of(frame) +
         (jitter ? lateness(*jitter, static_cast<std::uint64_t>(rig_.imaging.seed), frame, scene_.speed()) : 0);
}

double Renderer::true_height(int frame, double x, double y) const { return scene_.height(x, y, time_of(frame)); }

// Folds each row of the strip's sub-pixels with the kernel along the columns, and adds its contributions to the rows of
// pixels around it. What is dark contributes nothing.
void Renderer::add_strip(const Strip& strip, int down, std::span<float> pixels) const {
  const int rows = rig_.camera.rows;
  const int columns = rig_.camera.columns;
  const int taps = static_cast<int>(kernel_.size());
  const int first_column = std::max(0, (strip.first - taps + kSub) / kSub);
  const int last_column = std::min(columns - 1, (strip.last - 1) / kSub);
  std::array<std::vector<float>, kSub> phases;  // every kSub-th sub-pixel
  for (std::vector<float>& phase : phases) {
    phase.resize(static_cast<std::size_t>(strip.width / kSub));
  }
  std::vector<float> line(static_cast<std::size_t>(columns));
  for (int i = 0; i < strip.rows(); ++i) {
    const float* from = strip.row(i);
    if (std::all_of(from + strip.first, from + strip.last, [](float value) { return value == 0; })) {
      continue;
    }
    for (std::size_t c = 0; c < phases[0].size(); ++c) {
      for (std::size_t phase = 0; phase < kSub; ++phase) {
        phases[phase][c] = from[c * kSub + phase];
      }
    }
    std::fill(line.begin(), line.end(), 0.0F);
    for (int k = 0; k < taps; ++k) {
      const float weight = kernel_[static_cast<std::size_t>(k)];
      const float* shifted = phases.at(static_cast<std::size_t>(k % kSub)).data() + k / kSub;
      for (int c = first_column; c <= last_column; ++c) {
        line[static_cast<std::size_t>(c)] += weight * shifted[c];
      }
    }
    const int sub_row = down * strip.rows() + i;  // from the first one of the margin
    const int first = std::max(0, (sub_row - taps + kSub) / kSub);
    const int last = std::min(rows - 1, sub_row / kSub);
    for (int r = first; r <= last; ++r) {
      const float weight = kernel_[static_cast<std::size_t>(sub_row - r * kSub)];
      float* to = pixels.data() + static_cast<std::ptrdiff_t>(r) * columns;
      for (int c = first_column; c <= last_column; ++c) {
        to[c] += weight * line[static_cast<std::size_t>(c)];
      }
    }
  }
}

// The image without noise.
void Renderer::expose(int frame, std::span<float> pixels) const {
  Light light{time_of_shot(frame), options_.motion_blur ? rig_.camera.exposure_s : 0, 1, {}};
  light.heights = surface_.all_heights(light.middle - light.exposure / 2, light.middle + light.exposure / 2);
  const double way = scene_.speed() * light.exposure;  // in pixels of the nearest surface
  const double way_px =
      way * rig_.camera.focal_length_mm / rig_.camera.pixel_pitch_mm / (rig_.plane_z_mm - light.heights.high);
  light.passes = std::clamp(static_cast<int>(std::ceil(way_px)), 1, 64);

  const double surroundings =
      rig_.imaging.dark +
      (surface_.even_albedo() ? scene_.albedo(0, 0, light.middle) * (rig_.imaging.ambient - rig_.imaging.dark) : 0);
  std::fill(pixels.begin(), pixels.end(), static_cast<float>(surroundings));
  Strip strip(grid_.across() * kBlock * kSub);
  for (int down = 0; down < grid_.down(); ++down) {
    sample_strip(light, down, strip);
    if (strip.first < strip.last) {
      add_strip(strip, down, pixels);
    }
  }
}

// Shot noise: the variance is the number of electrons, as in Poisson's distribution, for the light above the dark
// value; the distribution is taken as normal.
void add_noise(const RigImaging& imaging, const RenderOptions& options, int frame, std::span<float> pixels) {
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

void quantize(std::span<float> pixels) {
  std::transform(pixels.begin(), pixels.end(), pixels.begin(),
                 [](float value) { return std::clamp(std::nearbyint(value), 0.0F, kGreyMaximum); });
}

void quantize(std::span<const float> from, std::span<std::uint8_t> to) {
  std::transform(from.begin(), from.end(), to.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::clamp(std::nearbyint(value), 0.0F, kGreyMaximum));
  });
}

void Renderer::render(int frame, std::span<float> pixels) const {
  expose(frame, pixels);
  if (disturbed_) {
    const double t = time_of_shot(frame);
    const auto depths = [&](std::span<float> z) {
      const HeightRange all = surface_.all_heights(t, t);
      for (std::size_t i = 0; i < z.size(); ++i) {
        const auto columns = static_cast<std::size_t>(rig_.camera.columns);
        const std::size_t row = i / columns;
        const PixelPoint pixel{static_cast<double>(row), static_cast<double>(i % columns)};
        z[i] = static_cast<float>(surface_.hit(pixel, t, all).point.z);
      }
    };
    disturbed_->add_light({frame, t, rig_.camera.exposure_s, light_, depths}, pixels);
  }
  add_noise(rig_.imaging, options_, frame, pixels);
  if (disturbed_) {
    disturbed_->add_faults(frame, pixels);
  }
  if (options_.quantization) {
    quantize(pixels);
  }
}

void Renderer::render(int frame, std::span<std::uint8_t> pixels) const {
  std::vector<float> values(pixels.size());
  render(frame, values);
  quantize(values, pixels);
}

}  // namespace selfproj
