#include "sim/app/cosim_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/driver/image_assembler.h"
#include "host/io/float_image.h"
#include "host/io/output_file.h"
#include "host/io/output_folder.h"
#include "host/io/program_main.h"
#include "host/io/progress.h"
#include "host/io/user_error.h"
#include "host/report/depth_output.h"
#include "host/report/frame_picture.h"
#include "host/report/map_picture.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "host/structured_light/moved.h"
#include "host/structured_light/scanner.h"
#include "host/structured_light/triangulation.h"
#include "sim/app/cosim_run.h"
#include "sim/app/frame_source.h"
#include "sim/experiment/depth_errors.h"
#include "sim/experiment/motion_analysis.h"
#include "sim/platform/platform.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/scanner_scenes.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_list.h"

namespace selfproj {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Nothing lies below the plane: what is found deeper than this, mm, for quantization, is a wrong code.
constexpr double kBelowPlane = 15;

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{:.4f}", value) : ""; }

// What is measured in a depth image and in the truth beside it.
struct Sample {
  std::size_t frame = 0;  // of this run, from 1: the one that completed the code image
  double t = 0;           // s, of the frame in the middle of the cycle that the codes are from
  Moved moved, true_moved;
  double front = kNan, true_front = kNan;
  std::vector<double> z, true_z;  // at the pixels of the keys, of what moved
};

// The scene, its background as the scanner measures it, and what each depth image says.
class ScannerMeasurement {
 public:
  ScannerMeasurement(const ScannerCosimOptions& options, const Rig& rig, const Scene& scene, const Scene& reference,
                     const PatternSet& patterns)
      : options_(options),
        rig_(rig),
        renderer_(rig, scene, options.render),
        triangulation_(rig, options.bits, {0, rig.plane_z_mm + kBelowPlane}),
        scanner_(triangulation_, {rig.measure.code_threshold, options.median, false,
                                  static_cast<float>(options.min_difference_mm), options.steady}),
        assembler_(spec::kKindCodes, 0, rig.camera.rows, rig.camera.columns),
        background_(rig.camera.rows, rig.camera.columns),
        true_background_(rig.camera.rows, rig.camera.columns),
        truth_(rig.camera.rows, rig.camera.columns),
        moved_(rig.camera.rows, rig.camera.columns) {
    measure_background(reference, patterns);
  }

  [[nodiscard]] const PatternRenderer& renderer() const { return renderer_; }
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }
  [[nodiscard]] const PlaneTriangulation& triangulation() const { return triangulation_; }
  [[nodiscard]] const Scanner& scanner() const { return scanner_; }
  [[nodiscard]] const FloatImage& background() const { return background_; }
  [[nodiscard]] std::uint64_t incomplete() const { return assembler_.incomplete(); }
  [[nodiscard]] double depth_rms() const { return errors_.rms(); }
  [[nodiscard]] double far_off() const { return errors_.far_off(); }

  // True where the packet completed a code image: there is a new sample.
  bool packet(const PacketView& packet) {
    if (!assembler_.add(packet)) {
      return false;
    }
    scanner_.take_codes(assembler_.codes().data());
    Sample sample;
    sample.frame = static_cast<std::size_t>(assembler_.header().sequence) + 1;
    // The planes of a code are up to 2m frames old: the truth beside it is that of their middle.
    const auto middle = static_cast<int>(options_.first + sample.frame) - 2 - options_.bits;
    sample.t = middle / rig_.camera.frame_rate_hz;
    renderer_.lit_depth(middle, truth_.values, static_cast<float>(rig_.measure.code_threshold));
    sample.moved = scanner_.moved();
    sample.true_moved = moved(triangulation_, truth_.values.data(), true_background_.values.data(),
                              static_cast<float>(options_.min_difference_mm));
    errors_.add(scanner_.depth(), truth_);
    if (options_.scene == "waves") {
      sample.front = front(sample.t, scanner_.depth(), background_);
      sample.true_front = front(sample.t, truth_, true_background_);
    }
    if (options_.scene == "keys") {
      scanner_.difference(moved_);
      for (const KeyTaps::Pixel pixel : {KeyTaps::kFirst, KeyTaps::kSecond}) {
        const bool inside = pixel.row < rig_.camera.rows && pixel.column < rig_.camera.columns;
        sample.z.push_back(inside ? static_cast<double>(moved_.row(pixel.row)[pixel.column]) : kNan);
        sample.true_z.push_back(inside ? static_cast<double>(truth_.row(pixel.row)[pixel.column]) : kNan);
      }
    }
    samples_.push_back(std::move(sample));
    return true;
  }

 private:
  // A cycle of frames of the reference, decoded by the host, before the run.
  void measure_background(const Scene& reference, const PatternSet& patterns) {
    Rig rig = rig_;
    ++rig.imaging.seed;
    const PatternRenderer still(rig, reference, options_.render);
    Image positive{rig.camera.rows, rig.camera.columns, std::vector<std::uint8_t>(background_.values.size())};
    Image negative = positive;
    for (int k = 0; k < patterns.size(); ++k) {
      Image& image = k % 2 == 0 ? positive : negative;
      still.render(k, patterns[k], std::span<std::uint8_t>(image.pixels));
      scanner_.take(image.view(), k);
    }
    background_ = scanner_.depth();
    scanner_.set_background(background_);
    still.lit_depth(0, true_background_.values, static_cast<float>(rig_.measure.code_threshold));
    // What the scanner sees nothing of (where a line is worth too much) is not asked of the truth either.
    for (std::size_t i = 0; i < background_.values.size(); ++i) {
      true_background_.values[i] += 0 * background_.values[i];  // NaN where that is
    }
  }

  // Only after the ring has come out of the splash, and before it comes to a wall.
  [[nodiscard]] double front(double t, const FloatImage& depth, const FloatImage& background) const {
    constexpr double kFrom = 0.08;  // s after the impact
    constexpr double kTo = 0.17;
    constexpr double kStep = 3;  // mm
    constexpr std::size_t kRings = 40;
    constexpr double kLeast = 0.5;  // mm
    constexpr double kMost = 10;
    constexpr double kX = PoolWave::kWidth / 2;
    constexpr double kY = PoolWave::kLength / 2;
    if (t - PoolWave::kImpact < kFrom || t - PoolWave::kImpact > kTo) {
      return kNan;
    }
    const RingMeans rings(
        triangulation_,
        {PoolWave::kImpactX, PoolWave::kImpactY, PoolWave::kCentreX - kX, PoolWave::kCentreX + kX, -kY, kY}, kStep,
        kRings);
    return foremost_crest(rings, rings.means(depth, background, kMost), kLeast);
  }

  const ScannerCosimOptions& options_;
  Rig rig_;
  PatternRenderer renderer_;
  PlaneTriangulation triangulation_;
  Scanner scanner_;
  ImageAssembler assembler_;
  FloatImage background_;
  FloatImage true_background_;
  FloatImage truth_;
  FloatImage moved_;
  std::vector<Sample> samples_;
  DepthErrors errors_;
};

// ------------------------------------------------------------------ what the samples say

using Get = double (*)(const Sample&);

std::vector<double> column(const std::vector<Sample>& samples, Get get) {
  std::vector<double> values;
  std::transform(samples.begin(), samples.end(), std::back_inserter(values), get);
  return values;
}

std::vector<double> times(const std::vector<Sample>& samples) {
  return column(samples, [](const Sample& s) { return s.t; });
}

double greatest_distance(const std::vector<Sample>& samples, bool rms) {
  double most = 0;
  double squares = 0;
  std::size_t count = 0;
  for (const Sample& s : samples) {
    if (s.moved.pixels == 0 || s.true_moved.pixels == 0) {
      continue;
    }
    const double d = std::hypot(s.moved.x - s.true_moved.x, s.moved.y - s.true_moved.y, s.moved.z - s.true_moved.z);
    most = std::max(most, d);
    squares += d * d;
    ++count;
  }
  return count == 0 ? kNan : rms ? std::sqrt(squares / static_cast<double>(count)) : most;
}

struct Findings {
  std::vector<Fact> facts;
  std::vector<ReportPlot> plots;
  std::string table_name;
  std::string table;
};

void add_sine(Findings& found, const std::string& key, const std::string& label, const SineFit& fit) {
  if (std::isfinite(fit.frequency)) {
    found.facts.push_back({key + "_hz", label + ": frequency", fit.frequency, "Hz"});
    found.facts.push_back({key + "_amplitude_mm", label + ": amplitude", fit.amplitude, "mm"});
  }
}

Findings moved_findings(const std::vector<Sample>& samples) {
  Findings found;
  const std::vector<double> t = times(samples);
  const auto x = column(samples, [](const Sample& s) { return s.moved.x; });
  const auto y = column(samples, [](const Sample& s) { return s.moved.y; });
  const auto z = column(samples, [](const Sample& s) { return s.moved.z; });
  const auto true_x = column(samples, [](const Sample& s) { return s.true_moved.x; });
  const auto true_y = column(samples, [](const Sample& s) { return s.true_moved.y; });
  const auto true_z = column(samples, [](const Sample& s) { return s.true_moved.z; });
  constexpr double kLow = 1;
  constexpr double kHigh = 8;
  for (const auto& [name, measured, truth] : {std::tuple("x", &x, &true_x), {"y", &y, &true_y}, {"z", &z, &true_z}}) {
    add_sine(found, fmt::format("centroid_{}", name), fmt::format("centroid {}", name),
             fit_sine(t, *measured, kLow, kHigh));
    found.plots.push_back({fmt::format("Centroid of what moved: {}", name),
                           "time, s",
                           fmt::format("{}, mm", name),
                           {{t, *measured, "a", "measured"}, {t, *truth, "b", "of the true depths"}}});
  }
  found.plots.push_back({"Path of the centroid, seen along z",
                         "x, mm",
                         "y, mm",
                         {{x, y, "a", "measured"}, {true_x, true_y, "b", "of the true depths"}}});
  found.facts.push_back(
      {"centroid_rms_mm", "centroid from that of the true depths, RMS", greatest_distance(samples, true), "mm"});
  found.facts.push_back({"centroid_most_mm", "... greatest", greatest_distance(samples, false), "mm"});
  found.table_name = "moved.csv";
  found.table = "frame,time_s,pixels,x,y,z,true_pixels,true_x,true_y,true_z\n";
  for (const Sample& s : samples) {
    fmt::format_to(std::back_inserter(found.table), "{},{:.4f},{},{},{},{},{},{},{},{}\n", s.frame, s.t, s.moved.pixels,
                   number_text(s.moved.x), number_text(s.moved.y), number_text(s.moved.z), s.true_moved.pixels,
                   number_text(s.true_moved.x), number_text(s.true_moved.y), number_text(s.true_moved.z));
  }
  return found;
}

Findings wave_findings(const std::vector<Sample>& samples) {
  Findings found;
  const std::vector<double> t = times(samples);
  const auto front = column(samples, [](const Sample& s) { return s.front; });
  const auto true_front = column(samples, [](const Sample& s) { return s.true_front; });
  const LineFit fit = fit_line(t, front);
  const LineFit true_fit = fit_line(t, true_front);
  constexpr double kCmPerMm = 0.1;
  if (std::isfinite(fit.slope)) {
    found.facts.push_back({"front_cm_per_s", "wave front", fit.slope * kCmPerMm, "cm/s"});
  }
  if (std::isfinite(true_fit.slope)) {
    found.facts.push_back({"true_front_cm_per_s", "... in the true depths", true_fit.slope * kCmPerMm, "cm/s"});
    found.facts.push_back({"theory_cm_per_s", "√(g h) at 3 cm", PoolWave::kSpeed * kCmPerMm, "cm/s"});
  }
  // Beside it a line of the theory's speed through the middle of what was measured.
  ReportTrace theory{{}, {}, "b", "54.2 cm/s"};
  double sum_t = 0;
  double sum_r = 0;
  double count = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (std::isfinite(front[i])) {
      sum_t += t[i];
      sum_r += front[i];
      ++count;
    }
  }
  ReportTrace measured{{}, {}, "a", "foremost crest, measured"};
  for (std::size_t i = 0; i < t.size() && count > 0; ++i) {
    if (std::isfinite(front[i])) {
      measured.x.push_back(t[i]);
      measured.y.push_back(front[i]);
      theory.x.push_back(t[i]);
      theory.y.push_back(sum_r / count + PoolWave::kSpeed * (t[i] - sum_t / count));
    }
  }
  found.plots.push_back({"Wave front", "time, s", "distance from the impact, mm", {measured, theory}});
  found.table_name = "front.csv";
  found.table = "frame,time_s,front_mm,true_front_mm\n";
  for (const Sample& s : samples) {
    fmt::format_to(std::back_inserter(found.table), "{},{:.4f},{},{}\n", s.frame, s.t, number_text(s.front),
                   number_text(s.true_front));
  }
  return found;
}

Findings key_findings(const std::vector<Sample>& samples) {
  Findings found;
  const std::vector<double> t = times(samples);
  constexpr double kLow = 2;
  constexpr double kHigh = 9;
  for (const std::size_t key : {0U, 1U}) {
    const KeyTaps::Pixel pixel = key == 0 ? KeyTaps::kFirst : KeyTaps::kSecond;
    std::vector<double> z;
    std::vector<double> truth;
    for (const Sample& s : samples) {
      z.push_back(s.z[key]);
      truth.push_back(s.true_z[key]);
    }
    add_sine(found, fmt::format("key_{}", key + 1), fmt::format("pixel ({}, {})", pixel.row, pixel.column),
             fit_sine(t, z, kLow, kHigh));
    found.plots.push_back({fmt::format("Depth at pixel ({}, {})", pixel.row, pixel.column),
                           "time, s",
                           "z, mm",
                           {{t, z, "a", "measured"}, {t, truth, "b", "true"}}});
  }
  found.table_name = "keys.csv";
  found.table = "frame,time_s,z_1,z_2,true_z_1,true_z_2\n";
  for (const Sample& s : samples) {
    fmt::format_to(std::back_inserter(found.table), "{},{:.4f},{},{},{},{}\n", s.frame, s.t, number_text(s.z[0]),
                   number_text(s.z[1]), number_text(s.true_z[0]), number_text(s.true_z[1]));
  }
  return found;
}

Findings findings_of(const std::string& scene, const std::vector<Sample>& samples) {
  return scene == "waves" ? wave_findings(samples) : scene == "keys" ? key_findings(samples) : moved_findings(samples);
}

// Background less depth where both are.
FloatImage difference_of(const FloatImage& depth, const FloatImage& background) {
  FloatImage result = depth;
  std::transform(background.values.begin(), background.values.end(), depth.values.begin(), result.values.begin(),
                 [](float before, float now) { return before - now; });
  return result;
}

}  // namespace

bool is_scanner_scene(const std::string& scene) {
  const std::vector<SceneInfo>& all = scanner_scenes();
  return std::any_of(all.begin(), all.end(), [&](const SceneInfo& info) { return info.name == scene; });
}

// Of the frames of a run those that complete code images: the 2m-th, and every second one after it.
std::vector<std::size_t> pictured_frames(const ScannerCosimOptions& options, std::size_t total) {
  const auto cycle = static_cast<std::size_t>(2 * options.bits);
  if (!options.pictures.empty()) {
    for (const std::size_t frame : options.pictures) {
      if (frame > total || frame < cycle || frame % 2 != 0) {
        throw UserError(
            fmt::format("--picture-frame {}", frame),
            fmt::format("completes no code image; those are {}, {}, ... {}", cycle, cycle + 2, total / 2 * 2));
      }
    }
    return options.pictures;
  }
  constexpr std::size_t kMost = 4;
  const std::size_t images = (total - cycle) / 2 + 1;
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < std::min(kMost, images); ++i) {
    frames.push_back(cycle + 2 * (images * (2 * i + 1) / (2 * std::min(kMost, images))));
  }
  return frames;
}

std::size_t frames_of_run(const ScannerCosimOptions& options, std::size_t total) {
  if (options.first > total && !options.count) {
    throw UserError(fmt::format("--first {}", options.first),
                    fmt::format("scene {} has {} frames", options.scene, total));
  }
  // a scene that stands may be looked at as long as one likes
  const bool still = total == 1;
  if (options.count && !still && options.first - 1 + *options.count > total) {
    throw UserError(fmt::format("--count {}", *options.count),
                    fmt::format("scene {} has {} frames from frame {} on", options.scene,
                                total - std::min(total, options.first - 1), options.first));
  }
  const auto cycle = static_cast<std::size_t>(2 * options.bits);
  const std::size_t frames = options.count.value_or(still ? cycle : total - options.first + 1);
  if (frames < cycle) {
    throw UserError(fmt::format("--count {}", frames),
                    fmt::format("is less than the {} frames that codes of {} bits take", cycle, options.bits));
  }
  return frames;
}

PlatformOptions scanner_platform(const ScannerCosimOptions& options, const Rig& rig) {
  PlatformOptions platform;
  if (options.engine == "model") {
    platform.engine = PlatformEngine::model;
#ifdef SELFPROJ_HAS_RTL_PLATFORM
  } else if (options.engine == "rtl" || options.engine == "hls") {
    platform.engine = options.engine == "rtl" ? PlatformEngine::rtl : PlatformEngine::hls;
    constexpr int kMost = 512;  // of the Verilated board with codes
    if (rig.camera.rows > kMost || rig.camera.columns > kMost) {
      throw UserError("--rig " + rig.name, "the simulated board with codes takes images up to 512 x 512");
    }
#endif
  } else {
    throw UserError("--engine " + options.engine, "this engine is not part of this build");
  }
  if (rig.camera.columns % spec::kPixelsPerBeat != 0) {
    throw UserError("--rig " + rig.name, "the board takes images of a multiple of 4 columns");
  }
  platform.settings = {.columns = rig.camera.columns,
                       .rows = rig.camera.rows,
                       .mode = Mode::binary,
                       .threshold = rig.measure.threshold,
                       .codes = true,
                       .median = options.median,
                       .code_bits = options.bits,
                       .code_threshold = rig.measure.code_threshold};
  platform.frame_rate_hz = rig.camera.frame_rate_hz;
  platform.patterns = 2 * options.bits;
  platform.bus.stall_percent = options.bus_stall;
  platform.seed = static_cast<std::uint64_t>(rig.imaging.seed);
  return platform;
}

std::string summary_json(const ReportPage& page) {
  nlohmann::ordered_json json;
  json["title"] = page.title;
  for (const auto& [name, facts] : {std::pair("measured", &page.highlights), std::pair("counters", &page.counters),
                                    std::pair("settings", &page.settings)}) {
    for (const Fact& fact : *facts) {
      std::visit([&, key = name](const auto& value) { json[key][fact.key] = value; }, fact.value);
    }
  }
  return json.dump(2) + "\n";
}

void run_scanner_cosim(const ScannerCosimOptions& options) {
  const std::optional<OutputFile> packets_file =
      options.packets.empty() ? std::nullopt : std::optional<OutputFile>(options.packets);
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  Rig rig = load_rig(options.rig);
  if (rig.kind != RigKind::scanner) {
    throw UserError("--rig " + options.rig, fmt::format("is no scanner, as scene {} needs", options.scene));
  }
  rig.imaging.seed = options.seed.value_or(rig.imaging.seed);
  rig.measure.code_threshold = options.threshold.value_or(rig.measure.code_threshold);
  const PlatformOptions platform = scanner_platform(options, rig);
  const std::unique_ptr<Scene> scene = make_scene(options.scene, rig);
  const std::string reference_name = find_scene(options.scene).reference_name();
  const std::unique_ptr<Scene> reference = make_scene(reference_name, rig);
  const std::size_t total = frames_of_run(options, static_cast<std::size_t>(scene->frames()));
  const std::vector<std::size_t> pictures = folder ? pictured_frames(options, total) : std::vector<std::size_t>();

  const PatternSet patterns(rig, gray_patterns(rig.projector, options.bits), options.render.projector_blur);
  ScannerMeasurement measurement(options, rig, *scene, *reference, patterns);
  const auto first = static_cast<int>(options.first - 1);
  SceneFrames source(
      [&](int frame, std::span<std::uint8_t> pixels) {
        measurement.renderer().render(frame, patterns.of_frame(frame - first), pixels);
      },
      rig.camera.rows, rig.camera.columns, options.first - 1, total);

  ReportPage page;
  std::map<std::size_t, Image> camera;
  std::string stream;  // --packets
  const auto show = [&](std::size_t frame) {
    const double t = (static_cast<double>(first) + static_cast<double>(frame) - 1) / rig.camera.frame_rate_hz;
    const std::string when = fmt::format("frame {}, t = {:.3f} s", frame, t);
    const FloatImage& depth = measurement.scanner().depth();
    FloatImage moved = depth;
    measurement.scanner().difference(moved);
    const std::string depth_png = depth_picture(measurement.triangulation(), depth, "depth, " + when);
    const std::string moved_png = depth_picture(measurement.triangulation(), moved, "moved, " + when);
    const std::string name = fmt::format("{:05}.", frame);
    folder->append("depth_" + name + "tiff", encode_float_tiff("depth.tiff", depth));
    folder->append("depth_" + name + "png", depth_png);
    folder->append("moved_" + name + "png", moved_png);
    if (const auto image = camera.find(frame); image != camera.end()) {
      const std::string camera_png = image_png(image->second);
      folder->append("frame_" + name + "png", camera_png);
      page.pictures.push_back({"Camera, " + when, camera_png, "the newest image of its cycle"});
    }
    page.pictures.push_back({"Depth, " + when, depth_png, "z, mm"});
    page.pictures.push_back(
        {"What moved, " + when, moved_png,
         fmt::format("pixels whose depth differs from the background's by more than {} mm and stays",
                     options.min_difference_mm)});
  };

  CosimResult result;
  const auto start = std::chrono::steady_clock::now();
  {
    Progress progress("frame", total);
    result = run_cosim(
        platform, source,
        {.frame =
             [&](std::size_t frame, const Image& image) {
               if (std::find(pictures.begin(), pictures.end(), frame + 1) != pictures.end()) {
                 camera[frame + 1] = image;
               }
               progress.update(frame + 1);
             },
         .packet =
             [&](std::span<const std::uint8_t> bytes, const PacketView& packet) {
               if (packets_file) {
                 stream.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
               }
               if (measurement.packet(packet) &&
                   std::find(pictures.begin(), pictures.end(), measurement.samples().back().frame) != pictures.end()) {
                 show(measurement.samples().back().frame);
               }
             }});
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (measurement.incomplete() != 0 && result.lost == 0 && result.mismatches++ == 0) {
    result.first_mismatch = fmt::format("{} code images are not complete", measurement.incomplete());
  }
  const std::vector<Sample>& samples = measurement.samples();
  const Findings found = findings_of(options.scene, samples);
  if (folder) {
    const auto count = [](const char* key, const char* label, std::uint64_t value) {
      return Fact{key, label, static_cast<std::int64_t>(value)};
    };
    page.title = "Co-simulation: " + options.scene;
    page.subtitle = fmt::format("rig {}, {} bits, threshold {}{}, {} frames from frame {} on at {:g} frames/s",
                                rig.name, options.bits, rig.measure.code_threshold, options.median ? ", median" : "",
                                total, options.first, rig.camera.frame_rate_hz);
    page.highlights = found.facts;
    page.highlights.push_back({"depth_rms_mm", "depth from the truth, RMS", measurement.depth_rms(), "mm"});
    page.highlights.push_back({"depth_far_off", "pixels more than 15 mm off", 100 * measurement.far_off(), "%"});
    page.plots = found.plots;
    page.counters = {count("depth_images", "depth images", samples.size()),
                     count("matched_codes", "codes equal to the model's", result.codes),
                     count("matched_columns", "columns of moments equal to the model's", result.columns),
                     count("matched_frames", "frames equal to the model's", result.frames),
                     count("mismatches", "mismatches with the model", result.mismatches),
                     count("incomplete", "incomplete code images", measurement.incomplete()),
                     count("delivered", "packets delivered", result.driver.delivered),
                     count("lost_board", "lost on the board", result.lost),
                     count("bad", "bad packets", result.driver.bad)};
    page.settings = {
        {"scene", "scene", options.scene},
        {"reference", "background", reference_name},
        {"engine", "engine", options.engine},
        {"seed", "seed of the noise", rig.imaging.seed},
        {"without", "simulated without", options.without.empty() ? "–" : options.without},
        {"bits", "bits", std::int64_t{options.bits}},
        {"threshold", "threshold", std::int64_t{rig.measure.code_threshold}},
        {"min_difference_mm", "moved: differs by more than", options.min_difference_mm, "mm"},
        {"max_change_mm", "... changes from one depth image to the next by no more than",
         static_cast<double>(options.steady.most_change_mm), "mm"},
        {"min_neighbours", "... neighbours that moved, too", std::int64_t{options.steady.least_neighbours}},
        {"clocks", "pixel clocks simulated", static_cast<std::int64_t>(result.platform.clocks)},
        {"bus_stall", "bus not ready", std::int64_t{options.bus_stall}, "%"}};
    const FloatImage difference = difference_of(measurement.scanner().depth(), measurement.background());
    folder->append("depth.tiff", encode_float_tiff("depth.tiff", measurement.scanner().depth()));
    folder->append("background.tiff", encode_float_tiff("background.tiff", measurement.background()));
    folder->append("difference.tiff", encode_float_tiff("difference.tiff", difference));
    folder->append("difference.png", labelled_map_png(difference, difference_scale(difference), {1, 1, 'x', 'y'},
                                                      "background − depth, newest; a pixel is shown as 1 mm"));
    folder->append("cloud.ply", cloud_ply(measurement.triangulation(), measurement.scanner().depth()));
    folder->append(found.table_name, found.table);
    folder->append("summary.json", summary_json(page));
    folder->append("report.html", page_html(page));
    folder->commit();
  }
  if (packets_file) {
    packets_file->write(stream);
  }
  const auto clocks = static_cast<double>(result.platform.clocks);
  fmt::print("scene {}: {} frames of {} x {} at {:g} fps, {} bits, threshold {}, engine {}: {} depth images\n",
             options.scene, total, rig.camera.columns, rig.camera.rows, rig.camera.frame_rate_hz, options.bits,
             rig.measure.code_threshold, options.engine, samples.size());
  for (const Fact& fact : found.facts) {
    fmt::print("{}: {:.4g} {}\n", fact.label, std::get<double>(fact.value), fact.unit);
  }
  fmt::print("depth: {:.2f} mm RMS from the truth, {:.2f} % of the pixels more than 15 mm off\n",
             measurement.depth_rms(), 100 * measurement.far_off());
  fmt::print("{:.2f} M pixel clocks in {:.1f} s\n", clocks * 1e-6, seconds);
  for (const std::string& written : {options.out, options.packets}) {
    if (!written.empty()) {
      fmt::print("→ {}\n", written);
    }
  }
  fmt::print("matched {} codes in {} code images and {} columns in {} frames, {} mismatches\n", result.codes,
             samples.size(), result.columns, result.frames, result.mismatches);
  if (result.mismatches != 0) {
    std::fflush(stdout);
    throw CheckFailed(result.first_mismatch);
  }
}

}  // namespace selfproj
