#include "sim/scene/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/rig.h"
#include "host/io/user_error.h"
#include "sim/scene/noise.h"
#include "sim/scene/parallel.h"

namespace selfproj {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kLift = 1e-3;       // mm off the surface, where its shadow is looked for
constexpr double kSlopeStep = 5e-3;  // mm to both sides, for the surface's slope
constexpr double kEverywhere = 1e6;  // mm
constexpr float kGreyMaximum = 255;  // of an 8-bit image

const FloatImage& checked(const FloatImage& pattern, const RigProjector& projector) {
  check_pattern(pattern, projector);
  return pattern;
}

int margin_of(double blur) { return blur > 0 ? static_cast<int>(std::ceil(4 * blur)) : 0; }

// The share of a sub-pixel's light that falls on a pixel: the pixel's square and the lens's Gaussian, folded.
std::vector<float> pixel_kernel(int margin, int sub, double sigma) {
  const auto below = [&](double d) {  // share of the Gaussian below d
    return sigma > 0 ? 0.5 * std::erfc(-d / (sigma * std::numbers::sqrt2)) : static_cast<double>(d > 0);
  };
  std::vector<double> weights;
  double sum = 0;
  for (int k = 0; k < (2 * margin + 1) * sub; ++k) {
    const double d = (k + 0.5) / sub - margin - 0.5;  // from the pixel's centre
    weights.push_back(below(d + 0.5) - below(d - 0.5));
    sum += weights.back();
  }
  std::vector<float> kernel(weights.size());
  std::transform(weights.begin(), weights.end(), kernel.begin(),
                 [sum](double weight) { return static_cast<float>(weight / sum); });
  return kernel;
}

}  // namespace

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

// What is the same for all pixels of a frame.
struct Renderer::Light {
  double middle;        // of the exposure, s
  double exposure;      // s; 0 without motion blur
  int passes;           // each sub-pixel is looked at so often, at other times
  HeightRange heights;  // of all the scene, meanwhile
};

Renderer::Renderer(const Rig& rig, const Scene& scene, const FloatImage& pattern, RenderOptions options)
    : rig_(rig),
      scene_(scene),
      options_(options),
      camera_(Pinhole::of_camera(rig.camera)),
      projector_(Pinhole::of_projector(rig.projector)),
      light_(checked(pattern, rig.projector), options.projector_blur ? rig.imaging.projector_blur_px : 0),
      margin_(margin_of(options.camera_blur ? rig.imaging.camera_blur_px : 0)),
      kernel_(pixel_kernel(margin_, kSub, options.camera_blur ? rig.imaging.camera_blur_px : 0)) {}

void Renderer::set_pattern(const FloatImage& pattern) {
  light_ =
      ProjectedLight(checked(pattern, rig_.projector), options_.projector_blur ? rig_.imaging.projector_blur_px : 0);
}

HeightRange Renderer::all_heights(double t0, double t1) const {
  return scene_.range({-kEverywhere, kEverywhere, -kEverywhere, kEverywhere}, t0, t1);
}

double Renderer::true_height(int frame, double x, double y) const { return scene_.height(x, y, time_of(frame)); }

// The bounds of the heights that the rays through a block of pixels can meet: the block's footprint between two heights
// gives bounds of the surface in it, which give a smaller footprint, and so on.
HeightRange Renderer::block_heights(const Light& light, int row, int column) const {
  const Point3 first = camera_.ray({row - 0.5, column - 0.5});
  const Point3 last = camera_.ray({row + kBlock - 0.5, column + kBlock - 0.5});
  const double t0 = light.middle - light.exposure / 2;
  const double t1 = light.middle + light.exposure / 2;
  HeightRange heights = light.heights;
  constexpr int kTries = 8;
  constexpr double kWorthwhile = 0.9;
  for (int i = 0; i < kTries; ++i) {
    const double near = rig_.plane_z_mm - heights.high;
    const double far = rig_.plane_z_mm - heights.low;
    const HeightRange found = scene_.range({first.x * (first.x < 0 ? far : near), last.x * (last.x > 0 ? far : near),
                                            first.y * (first.y < 0 ? far : near), last.y * (last.y > 0 ? far : near)},
                                           t0, t1);
    const double before = heights.high - heights.low;
    heights = {std::max(heights.low, found.low), std::min(heights.high, found.high)};
    if (heights.high - heights.low > kWorthwhile * before) {
      break;
    }
  }
  return heights;
}

// Whether no light falls on what the rays through a block of pixels meet between these heights. What they pass is
// convex, and so is its image in the projector: its corners bound it.
bool Renderer::is_dark(int row, int column, HeightRange heights) const {
  double line_0 = std::numeric_limits<double>::max();
  double line_1 = std::numeric_limits<double>::lowest();
  double column_0 = line_0;
  double column_1 = line_1;
  for (const double r : {row - 0.5, row + kBlock - 0.5}) {
    for (const double c : {column - 0.5, column + kBlock - 0.5}) {
      const Point3 ray = camera_.ray({r, c});
      for (const double h : {heights.low, heights.high}) {
        const Point3 point = (rig_.plane_z_mm - h) * ray;
        if (projector_.depth(point) <= 0) {
          return false;
        }
        const PixelPoint p = projector_.project(point);
        line_0 = std::min(line_0, p.row);
        line_1 = std::max(line_1, p.row);
        column_0 = std::min(column_0, p.column);
        column_1 = std::max(column_1, p.column);
      }
    }
  }
  return light_.is_dark(line_0, line_1, column_0, column_1);
}

Renderer::Hit Renderer::hit(PixelPoint pixel, double t, HeightRange heights) const {
  const Point3 ray = camera_.ray(pixel);  // of depth 1
  const double z = rig_.plane_z_mm;
  const bool level = heights.high - heights.low <= kHeightTolerance;
  const double h =
      level ? heights.low : first_hit(scene_, {ray.x * z, -ray.x, ray.y * z, -ray.y}, t, heights.low, heights.high);
  return {(z - h) * ray, h, level};
}

// The cosine of the incidence of the projector's light, with falloff where that is wanted; 0 in the shadow. `highest`:
// bound of all heights.
double Renderer::lit_share(const Hit& hit, double t, double highest) const {
  const Point3 p = hit.point;
  const auto slope = [&](double dx, double dy) {
    return (scene_.height(p.x + dx, p.y + dy, t) - scene_.height(p.x - dx, p.y - dy, t)) / (2 * kSlopeStep);
  };
  // towards the camera, which is −z
  const Point3 up = hit.level ? Point3{0, 0, -1} : Point3{-slope(kSlopeStep, 0), -slope(0, kSlopeStep), -1};
  const Point3 normal = 1 / std::sqrt(dot(up, up)) * up;
  const Point3 to_projector = projector_.centre() - p;
  const double distance_2 = dot(to_projector, to_projector);
  const double cosine = dot(normal, to_projector) / std::sqrt(distance_2);
  if (!(cosine > 0)) {
    return 0;
  }
  const Point3 start = p + kLift * normal;
  const double low = rig_.plane_z_mm - start.z;
  const double top = rig_.plane_z_mm - projector_.centre().z;  // the projector's height
  const double high = std::min(highest, top);
  if (low < high) {
    const double dx = (projector_.centre().x - start.x) / (top - low);
    const double dy = (projector_.centre().y - start.y) / (top - low);
    if (is_blocked(scene_, {start.x - dx * low, dx, start.y - dy * low, dy}, t, low, high)) {
      return 0;
    }
  }
  if (!options_.falloff) {
    return cosine;
  }
  const Point3 whole = Point3{0, 0, rig_.plane_z_mm} - projector_.centre();
  return cosine * dot(whole, whole) / distance_2;
}

// The grey value that the projector's light gives a surface point.
double Renderer::grey(const Hit& hit, double t, double highest) const {
  const double light = projector_.depth(hit.point) > 0 ? light_.at(projector_.project(hit.point)) : 0;
  return light > 0 ? (rig_.imaging.white - rig_.imaging.ambient) * light * lit_share(hit, t, highest) *
                         scene_.albedo(hit.point.x, hit.point.y, t)
                   : 0;
}

// Grey values of the sub-pixels of a block, kSub kBlock squared, less those of a dark surface. The times of the
// exposure are dealt out so that in every row and in every column of sub-pixels each comes equally often. A block
// without projected light needs but one look a pixel.
void Renderer::sample_block(const Light& light, int row, int column, HeightRange heights, bool dark, float* to) const {
  constexpr int kSide = kBlock * kSub;
  const double ambient = scene_.even_albedo() ? 0 : rig_.imaging.ambient - rig_.imaging.dark;
  if (dark) {
    for (int i = 0; i < kSide; ++i) {
      for (int j = 0; j < kSide; ++j) {
        if (i % kSub == 0 && j % kSub == 0) {
          const int pixel_row = row + i / kSub;
          const int pixel_column = column + j / kSub;
          const Hit h = hit({static_cast<double>(pixel_row), static_cast<double>(pixel_column)}, light.middle, heights);
          to[i * kSide + j] = static_cast<float>(ambient * scene_.albedo(h.point.x, h.point.y, light.middle));
        } else {
          to[i * kSide + j] = to[(i - i % kSub) * kSide + j - j % kSub];
        }
      }
    }
    return;
  }
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const PixelPoint pixel{row - 0.5 + (i + 0.5) / kSub, column - 0.5 + (j + 0.5) / kSub};
      double sum = 0;
      for (int pass = 0; pass < light.passes; ++pass) {
        const int instant = (i + j) % kSub * light.passes + pass;
        const double t = light.middle + light.exposure * ((instant + 0.5) / (kSub * light.passes) - 0.5);
        const Hit h = hit(pixel, t, heights);
        sum += grey(h, t, light.heights.high);
        if (ambient > 0) {
          sum += ambient * scene_.albedo(h.point.x, h.point.y, t);
        }
      }
      to[i * kSide + j] = static_cast<float>(sum / light.passes);
    }
  }
}

// The image without noise: block rows of sub-pixels are looked at, each sub-pixel row is folded with the kernel along
// the columns, and what it gives to the rows around it is added there.
void Renderer::expose(int frame, std::span<float> pixels) const {
  const int rows = rig_.camera.rows;
  const int columns = rig_.camera.columns;
  Light light{time_of(frame), options_.motion_blur ? rig_.camera.exposure_s : 0, 1, {}};
  light.heights = all_heights(light.middle - light.exposure / 2, light.middle + light.exposure / 2);
  const double way = scene_.speed() * light.exposure;  // in pixels of the nearest surface:
  const double way_px =
      way * rig_.camera.focal_length_mm / rig_.camera.pixel_pitch_mm / (rig_.plane_z_mm - light.heights.high);
  light.passes = std::clamp(static_cast<int>(std::ceil(way_px)), 1, 64);

  constexpr int kSide = kBlock * kSub;
  const bool even = scene_.even_albedo();
  const int blocks_across = (columns + 2 * margin_ + kBlock - 1) / kBlock;
  const int blocks_down = (rows + 2 * margin_ + kBlock - 1) / kBlock;
  const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(blocks_across) * kSide;
  std::vector<float> strip(static_cast<std::size_t>(stride) * kSide);
  std::vector<float> line(static_cast<std::size_t>(columns));
  std::array<float, static_cast<std::size_t>(kSide) * kSide> block{};
  const int taps = static_cast<int>(kernel_.size());

  const double surroundings =
      rig_.imaging.dark + (even ? scene_.albedo(0, 0, light.middle) * (rig_.imaging.ambient - rig_.imaging.dark) : 0);
  std::fill(pixels.begin(), pixels.end(), static_cast<float>(surroundings));
  for (int down = 0; down < blocks_down; ++down) {
    const int row = down * kBlock - margin_;
    bool any = false;
    for (int across = 0; across < blocks_across; ++across) {
      const int column = across * kBlock - margin_;
      const HeightRange heights = block_heights(light, row, column);
      const bool dark = is_dark(row, column, heights);
      if (dark && even) {
        continue;
      }
      if (!any) {
        std::fill(strip.begin(), strip.end(), 0.0F);
        any = true;
      }
      sample_block(light, row, column, heights, dark, block.data());
      for (int i = 0; i < kSide; ++i) {
        std::copy_n(block.data() + i * kSide, kSide, strip.data() + i * stride + across * kSide);
      }
    }
    if (!any) {
      continue;
    }
    for (int i = 0; i < kSide; ++i) {
      const float* from = strip.data() + i * stride;
      for (int c = 0; c < columns; ++c) {
        float sum = 0;
        for (int k = 0; k < taps; ++k) {
          sum += kernel_[static_cast<std::size_t>(k)] * from[c * kSub + k];
        }
        line[static_cast<std::size_t>(c)] = sum;
      }
      const int sub_row = down * kSide + i;  // from the margin's first
      const int first = std::max(0, (sub_row - taps + kSub) / kSub);
      const int last = std::min(rows - 1, sub_row / kSub);
      for (int r = first; r <= last; ++r) {
        const float weight = kernel_[static_cast<std::size_t>(sub_row - r * kSub)];
        float* to = pixels.data() + static_cast<std::ptrdiff_t>(r) * columns;
        for (int c = 0; c < columns; ++c) {
          to[c] += weight * line[static_cast<std::size_t>(c)];
        }
      }
    }
  }
}

// Shot noise has the variance of the electrons' number, that is, of Poisson's distribution for the light above the dark
// value, taken as normal.
void Renderer::add_noise(int frame, std::span<float> pixels) const {
  if (!options_.shot_noise && !options_.read_noise) {
    return;
  }
  NormalNoise noise(static_cast<std::uint64_t>(rig_.imaging.seed), static_cast<std::uint64_t>(frame));
  const double shot = options_.shot_noise ? 1 / rig_.imaging.electrons_per_grey : 0;
  const double read = options_.read_noise ? rig_.imaging.read_noise * rig_.imaging.read_noise : 0;
  const auto with = [&](float value, float random) {
    const double variance = read + shot * std::max(0.0, static_cast<double>(value) - rig_.imaging.dark);
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

void Renderer::render(int frame, std::span<float> pixels) const {
  expose(frame, pixels);
  add_noise(frame, pixels);
  if (options_.quantization) {
    std::transform(pixels.begin(), pixels.end(), pixels.begin(),
                   [](float value) { return std::clamp(std::nearbyint(value), 0.0F, kGreyMaximum); });
  }
}

void Renderer::render(int frame, std::span<std::uint8_t> pixels) const {
  std::vector<float> values(pixels.size());
  render(frame, values);
  std::transform(values.begin(), values.end(), pixels.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::clamp(std::nearbyint(value), 0.0F, kGreyMaximum));
  });
}

void Renderer::truth(int frame, std::span<float> heights) const {
  const double t = time_of(frame);
  const HeightRange all = all_heights(t, t);
  for (int column = 0; column < rig_.camera.columns; ++column) {
    // how far, in projector lines, what a row sees is from the light sheet
    const auto miss = [&](double row) {
      const Hit h = hit({row, column + 0.0}, t, all);
      if (projector_.depth(h.point) <= 0) {
        return kNan;
      }
      const PixelPoint p = projector_.project(h.point);
      return p.row - light_.line_centre(p.column);
    };
    int seen = 0;
    double height = kNan;
    double above = miss(-0.5);
    for (int row = 0; row < rig_.camera.rows; ++row) {
      const double below = miss(row + 0.5);
      if ((above < 0) != (below < 0) && !std::isnan(above) && !std::isnan(below)) {
        constexpr int kHalvings = 24;
        double low = row - 0.5;
        double high = row + 0.5;
        for (int i = 0; i < kHalvings; ++i) {
          const double middle = (low + high) / 2;
          ((miss(middle) < 0) == (above < 0) ? low : high) = middle;
        }
        constexpr double kThere = 0.01;  // a jump of the surface across the sheet is no crossing
        const Hit h = hit({low, column + 0.0}, t, all);
        if (std::abs(miss(low)) < kThere && lit_share(h, t, all.high) > 0) {
          ++seen;
          height = h.height;
        }
      }
      above = below;
    }
    heights[static_cast<std::size_t>(column)] = static_cast<float>(seen == 1 ? height : kNan);
  }
}

FloatImage Renderer::truth(int first, int count, int threads) const {
  FloatImage result(count, rig_.camera.columns);
  parallel_for(count, threads, [&](int i) {
    truth(first + i, {result.row(i), static_cast<std::size_t>(result.columns)});
  });
  return result;
}

}  // namespace selfproj
