#include "lab/section_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "host/light_section/pattern.h"
#include "host/rig/geometry.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/fast_moments.h"
#include "selfproj/light_section/inspection.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/optics.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/parallel.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {
namespace {

model::ImageView view_of(const rig::Rig& rig, const std::vector<std::uint8_t>& pixels) {
  return {pixels.data(), rig.camera.rows, rig.camera.columns, rig.camera.columns};
}

// What the board measures in this mode.
model::Measure measure_in(const rig::Rig& rig, model::Mode mode) {
  model::Measure measure = rig.measure.of_board();
  measure.mode = mode;
  return measure;
}

// For moments of grey values that are not integers, which no board has. They are counted in units of 1 / kFine, with
// which M1 of 255 white rows is still below 2^31. The unit does not affect the centroid.
constexpr int kFine = 256;

void fine_moments(const rig::Rig& rig, const std::vector<float>& values, model::Mode mode, model::Moments& moments) {
  std::fill(moments.m0.begin(), moments.m0.end(), 0U);
  std::fill(moments.m1.begin(), moments.m1.end(), 0U);
  std::fill(moments.n.begin(), moments.n.end(), 0U);
  const auto columns = static_cast<std::size_t>(rig.camera.columns);
  const auto threshold = static_cast<float>(rig.measure.threshold);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float value = std::min(values[i], 255.0F);
    if (value <= threshold) {
      continue;
    }
    const float weight = mode == model::Mode::binary ? 1.0F : mode == model::Mode::grey ? value : value - threshold;
    const auto units = static_cast<std::uint32_t>(std::lround(weight * kFine));
    moments.m0[i % columns] += units;
    moments.m1[i % columns] += units * static_cast<std::uint32_t>(i / columns + 1);
    ++moments.n[i % columns];
  }
}

// The result of one frame, before it is added in order.
struct FrameResult {
  std::vector<std::uint8_t> pixels;
  std::vector<float> values;  // used instead if nothing is quantized
  std::array<model::Runs, sim::kAllModes.size()> runs;
  std::array<light_section::Profile, sim::kAllModes.size()> profiles;
};

double line_peak(const images::Image& image) {
  std::vector<std::uint8_t> peaks(static_cast<std::size_t>(image.columns), 0);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    auto& peak = peaks[i % peaks.size()];
    peak = std::max(peak, image.pixels[i]);
  }
  std::nth_element(peaks.begin(), peaks.begin() + image.columns / 2, peaks.end());
  return peaks[static_cast<std::size_t>(image.columns / 2)];
}

// The projector line that lights what the middle of the camera's image sees at depth z.
double line_in_middle(const rig::Rig& rig, double z) {
  if (rig.is_pinholes()) {
    return rig::line_on_middle(rig.projector, z);
  }
  const rig::RigOptics optics(rig);
  const auto ray = optics.ray({0.5 * (rig.camera.rows - 1), 0.5 * (rig.camera.columns - 1)});
  const auto light = ray ? optics.lit_by({(*ray)[0] * z, (*ray)[1] * z, z}) : std::nullopt;
  if (!light) {
    throw UserError(rig.name, fmt::format("its projector does not light the middle of the image at z = {} mm", z));
  }
  return light->line;
}

}  // namespace

sim::LightSection straight_line(const rig::Rig& rig, const sim::PerturbedRig& actual, const sim::Scene& reference,
                                const sim::RenderOptions& options, double middle_height) {
  const double line = line_in_middle(rig, rig.plane_z_mm - middle_height);
  sim::LightSection result{rig, actual, light_section::draw_straight_line(rig, line), {}};
  const auto centroids = sim::scan_centroids(rig, actual, reference, result.pattern, options, sim::kAllModes);
  for (std::size_t m = 0; m < sim::kAllModes.size(); ++m) {
    result.references[m] = light_section::reference_of_straight_line(rig, line, centroids[m]);
  }
  return result;
}

// Fills row `row` of the true maps by frame `number`.
void add_truth(const sim::LineRenderer& ideal, int number, int row, Measurement& result) {
  std::vector<sim::Point3> points(static_cast<std::size_t>(result.truth.columns),
                                  {rig::kUnknown, rig::kUnknown, rig::kUnknown});
  ideal.truth(number, {result.truth.row(row), points.size()}, points);
  for (std::size_t c = 0; c < points.size(); ++c) {
    result.true_x.row(row)[c] = static_cast<float>(points[c].x);
    result.true_y.row(row)[c] = static_cast<float>(points[c].y);
  }
}

Measurement measure(const sim::LightSection& setup, const sim::Scene& scene, const sim::RenderOptions& options,
                    int every, int threads, const std::function<void(std::size_t)>& progress) {
  const rig::Rig& rig = setup.rig;
  Measurement result;
  for (int frame = 0; frame < scene.frames(); frame += every) {
    result.frames.push_back(frame);
  }
  const int count = static_cast<int>(result.frames.size());
  light_section::InspectionOptions inspection;
  inspection.expected_frames = inspection.max_frames = result.frames.size();
  std::vector<light_section::DifferentialProfiler> profilers;
  for (const light_section::ReferenceProfile& reference : setup.references) {
    profilers.emplace_back(rig, reference);
    result.by_mode.emplace_back(rig, rig.camera.columns, inspection);
  }
  const sim::LineRenderer renderer(setup.actual, scene, setup.pattern, options);
  const sim::LineRenderer ideal(setup.actual, scene, setup.pattern, options.ideal_world());
  result.truth = result.true_x = result.true_y = images::FloatImage(count, rig.camera.columns);

  constexpr int kBatch = 64;
  const model::Select select = rig.measure.of_board().select;
  std::vector<FrameResult> batch(kBatch);
  for (FrameResult& frame : batch) {
    frame.pixels.resize(rig.camera.pixels());
    for (std::size_t m = 0; m < sim::kAllModes.size(); ++m) {
      frame.runs[m].resize(select, rig.camera.columns);
      frame.profiles[m].resize(rig.camera.columns);
    }
  }
  for (int begin = 0; begin < count; begin += kBatch) {
    const int size = std::min(kBatch, count - begin);
    sim::parallel_for(size, threads, [&](int i) {
      FrameResult& frame = batch[static_cast<std::size_t>(i)];
      const int number = result.frames[static_cast<std::size_t>(begin + i)];
      renderer.render(number, std::span(frame.pixels));
      if (!options.quantization) {
        frame.values.resize(frame.pixels.size());
        renderer.render(number, std::span(frame.values));
      }
      add_truth(ideal, number, begin + i, result);
      for (std::size_t m = 0; m < sim::kAllModes.size(); ++m) {
        if (options.quantization) {
          light_section::fast_measure_columns(view_of(rig, frame.pixels), measure_in(rig, sim::kAllModes[m]),
                                              frame.runs[m].view());
        } else {
          fine_moments(rig, frame.values, sim::kAllModes[m], frame.runs[m].moments);
        }
        profilers[m].profile(frame.runs[m].view(), frame.profiles[m].view());
      }
    });
    for (int i = 0; i < size; ++i) {
      FrameResult& frame = batch[static_cast<std::size_t>(i)];
      const int number = result.frames[static_cast<std::size_t>(begin + i)];
      const double time = number / rig.camera.frame_rate_hz;
      model::PacketHeader header;
      header.kind = spec::kKindMoments;
      header.sequence = static_cast<std::uint64_t>(number);
      header.time_stamp = static_cast<std::uint64_t>(std::llround(time * rig.pixel_clock_hz()));
      header.encoder = static_cast<std::uint32_t>(
          std::llround(time * rig.conveyor.speed_mm_per_s / rig.conveyor.encoder_mm_per_count));
      for (std::size_t m = 0; m < sim::kAllModes.size(); ++m) {
        model::describe_frame(header, rig.camera.rows, rig.camera.columns, measure_in(rig, sim::kAllModes[m]));
        result.by_mode[m].add(header, frame.runs[m].view(), frame.profiles[m].view());
      }
      if (begin + i == count / 2) {
        result.camera.image = {rig.camera.rows, rig.camera.columns, frame.pixels};
        result.camera.moments = frame.runs[0].moments;
        result.camera.frame = static_cast<std::size_t>(begin + i + 1);
        result.line_peak = line_peak(result.camera.image);
      }
    }
    progress(static_cast<std::size_t>(begin + size));
  }
  return result;
}

}  // namespace selfproj::lab
