#include "sim/cosim/depth_cosim.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/files/json_text.h"
#include "host/report/depth_output.h"
#include "host/report/facts.h"
#include "host/report/frame_picture.h"
#include "host/report/report.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "sim/cosim/motion_analysis.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string number_text(double value) { return std::isfinite(value) ? fmt::format("{:.4f}", value) : ""; }

using Get = double (*)(const DepthSample&);

std::vector<double> column(const std::vector<DepthSample>& samples, Get get) {
  std::vector<double> values;
  std::transform(samples.begin(), samples.end(), std::back_inserter(values), get);
  return values;
}

std::vector<double> times(const std::vector<DepthSample>& samples) {
  return column(samples, [](const DepthSample& s) { return s.t; });
}

// Distances in mm of the measured centroid from the true one.
struct Distances {
  double rms = kNone;
  double greatest = kNone;
};

Distances centroid_distances(const std::vector<DepthSample>& samples) {
  double most = 0;
  double squares = 0;
  std::size_t count = 0;
  for (const DepthSample& s : samples) {
    if (s.moved.pixels == 0 || s.true_moved.pixels == 0) {
      continue;
    }
    const double d = std::hypot(s.moved.x - s.true_moved.x, s.moved.y - s.true_moved.y, s.moved.z - s.true_moved.z);
    most = std::max(most, d);
    squares += d * d;
    ++count;
  }
  return count == 0 ? Distances{} : Distances{std::sqrt(squares / static_cast<double>(count)), most};
}

void add_sine(DepthFindings& found, const std::string& key, const std::string& label, const SineFit& fit) {
  if (std::isfinite(fit.frequency)) {
    found.facts.push_back({key + "_hz", label + ": frequency", fit.frequency, "Hz"});
    found.facts.push_back({key + "_amplitude_mm", label + ": amplitude", fit.amplitude, "mm"});
  }
}

DepthFindings moved_findings(const std::vector<DepthSample>& samples) {
  DepthFindings found;
  const std::vector<double> t = times(samples);
  const auto x = column(samples, [](const DepthSample& s) { return s.moved.x; });
  const auto y = column(samples, [](const DepthSample& s) { return s.moved.y; });
  const auto z = column(samples, [](const DepthSample& s) { return s.moved.z; });
  const auto true_x = column(samples, [](const DepthSample& s) { return s.true_moved.x; });
  const auto true_y = column(samples, [](const DepthSample& s) { return s.true_moved.y; });
  const auto true_z = column(samples, [](const DepthSample& s) { return s.true_moved.z; });
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
  const Distances distances = centroid_distances(samples);
  found.facts.push_back({"centroid_rms_mm", "centroid from that of the true depths, RMS", distances.rms, "mm"});
  found.facts.push_back({"centroid_most_mm", "... greatest", distances.greatest, "mm"});
  found.table_name = "moved.csv";
  found.table = "frame,time_s,pixels,x,y,z,true_pixels,true_x,true_y,true_z\n";
  for (const DepthSample& s : samples) {
    fmt::format_to(std::back_inserter(found.table), "{},{:.4f},{},{},{},{},{},{},{},{}\n", s.frame, s.t, s.moved.pixels,
                   number_text(s.moved.x), number_text(s.moved.y), number_text(s.moved.z), s.true_moved.pixels,
                   number_text(s.true_moved.x), number_text(s.true_moved.y), number_text(s.true_moved.z));
  }
  return found;
}

DepthFindings wave_findings(const std::vector<DepthSample>& samples) {
  DepthFindings found;
  const std::vector<double> t = times(samples);
  const auto front = column(samples, [](const DepthSample& s) { return s.front; });
  const auto true_front = column(samples, [](const DepthSample& s) { return s.true_front; });
  const double speed = crest_speed(t, front);
  const double true_speed = crest_speed(t, true_front);
  constexpr double kCmPerMm = 0.1;
  if (std::isfinite(speed)) {
    found.facts.push_back({"front_cm_per_s", "foremost crest", speed * kCmPerMm, "cm/s"});
  }
  if (std::isfinite(true_speed)) {
    found.facts.push_back({"true_front_cm_per_s", "... in the true depths", true_speed * kCmPerMm, "cm/s"});
    found.facts.push_back({"theory_cm_per_s", "long waves, √(g h) at 3 cm", PoolWave::kSpeed * kCmPerMm, "cm/s"});
  }
  // Adds a line with the theory's speed through the middle of the measurement.
  report::ReportTrace theory{{}, {}, "b", "long waves, 54.2 cm/s"};
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
  report::ReportTrace measured{{}, {}, "a", "foremost crest, measured"};
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
  for (const DepthSample& s : samples) {
    fmt::format_to(std::back_inserter(found.table), "{},{:.4f},{},{}\n", s.frame, s.t, number_text(s.front),
                   number_text(s.true_front));
  }
  return found;
}

DepthFindings key_findings(const std::vector<DepthSample>& samples) {
  DepthFindings found;
  const std::vector<double> t = times(samples);
  constexpr double kLow = 2;
  constexpr double kHigh = 9;
  for (const std::size_t key : {0U, 1U}) {
    const KeyTaps::Pixel pixel = key == 0 ? KeyTaps::kFirst : KeyTaps::kSecond;
    std::vector<double> z;
    std::vector<double> truth;
    for (const DepthSample& s : samples) {
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
  for (const DepthSample& s : samples) {
    fmt::format_to(std::back_inserter(found.table), "{},{:.4f},{},{},{},{}\n", s.frame, s.t, number_text(s.z[0]),
                   number_text(s.z[1]), number_text(s.true_z[0]), number_text(s.true_z[1]));
  }
  return found;
}

}  // namespace

DepthFindings findings_of(SceneAnalysis analysis, const std::vector<DepthSample>& samples) {
  switch (analysis) {
    case SceneAnalysis::wave_front:
      return wave_findings(samples);
    case SceneAnalysis::key_taps:
      return key_findings(samples);
    case SceneAnalysis::moved_centroid:
      break;
  }
  return moved_findings(samples);
}

namespace {

constexpr std::size_t kMaxPictures = 4;

std::string scene_text(const CosimOptions& options) { return "scene " + options.scene; }

// The scanner with the seed and threshold of the options. Throws UserError if the board cannot take its images.
rig::Rig scanner_rig(const CosimOptions& options) {
  const std::string name = options.rig.empty() ? "scanner" : options.rig;
  rig::Rig rig = rig::load_rig(name);
  if (rig.kind != rig::RigKind::scanner) {
    throw UserError("--rig " + name, fmt::format("is not a scanner, which scene {} needs", options.scene));
  }
  rig.imaging.seed = options.seed.value_or(rig.imaging.seed);
  rig.measure.code_threshold = options.threshold.value_or(rig.measure.code_threshold);
  if (rig.measure.code_threshold > UINT8_MAX) {
    throw UserError(fmt::format("--threshold {}", rig.measure.code_threshold), "pixels of a scanner are 255 at most");
  }
  if (engine_of(options) != PlatformEngine::model) {
    constexpr int kMost = 512;  // size of the Verilated board with codes
    if (rig.camera.rows > kMost || rig.camera.columns > kMost) {
      throw UserError("--rig " + rig.name, "the simulated board that decodes takes images of up to 512 x 512 pixels");
    }
  }
  if (rig.camera.columns % spec::kPixelsPerBeat != 0) {
    throw UserError("--rig " + rig.name, "its images need a multiple of 4 columns");
  }
  return rig;
}

// The number of frames of the run, which must be at least a cycle of patterns.
std::size_t frames_of_cycles(const CosimOptions& options, const Scene& scene, int bits) {
  const auto cycle = static_cast<std::size_t>(2 * bits);
  const std::size_t frames =
      frames_of_run(options, static_cast<std::size_t>(scene.frames()), scene_text(options), cycle);
  if (frames < cycle) {
    throw UserError(fmt::format("--count {}", frames),
                    fmt::format("is too few; codes of {1} bits take {0} frames", cycle, bits));
  }
  return frames;
}

// summary.json of a page.
std::string summary_json(const report::ReportPage& page) {
  nlohmann::ordered_json json;
  json["title"] = page.title;
  json["measured"] = report::facts_json(page.highlights);
  json["counters"] = report::facts_json(page.counters);
  json["settings"] = report::facts_json(page.settings);
  return files::json_text(json, 2) + "\n";
}

}  // namespace

DepthCosimSetup depth_cosim_setup(const CosimOptions& options, const SceneInfo& info, int bits) {
  DepthCosimSetup setup{.rig = scanner_rig(options), .scene = nullptr, .bits = bits};
  setup.scene = info.make(setup.rig);
  setup.frames = frames_of_cycles(options, *setup.scene, bits);
  return setup;
}

DepthCosim::DepthCosim(const CosimOptions& options, const SceneInfo& info, DepthCosimSetup setup, Median median,
                       PatternSet patterns)
    : options_(options),
      info_(info),
      setup_(std::move(setup)),
      median_(median),
      patterns_(std::move(patterns)),
      renderer_(setup_.rig, *setup_.scene, options.render()),
      source_(
          [this](int frame) {
            const int of_run = frame - static_cast<int>(options_.first - 1);
            images::Image image{setup_.rig.camera.rows, setup_.rig.camera.columns, {}};
            image.pixels.resize(setup_.rig.camera.pixels());
            renderer_.render(frame, patterns_.of_frame(of_run), image.pixels);
            return image;
          },
          setup_.rig.camera.rows, setup_.rig.camera.columns, spec::kPixelBits, options.first - 1, setup_.frames),
      assembler_(spec::kKindCodes, 0, setup_.rig.camera.rows, setup_.rig.camera.columns),
      truth_(setup_.rig.camera.rows, setup_.rig.camera.columns) {}

PlatformOptions DepthCosim::platform() const {
  PlatformOptions platform;
  platform.engine = engine_of(options_);
  platform.settings = {.columns = setup_.rig.camera.columns,
                       .rows = setup_.rig.camera.rows,
                       .mode = model::Mode::binary,
                       .threshold = setup_.rig.measure.threshold,
                       .codes = true,
                       .median = median_ == Median::on,
                       .code_bits = setup_.bits,
                       .code_threshold = setup_.rig.measure.code_threshold};
  platform.frame_rate_hz = setup_.rig.camera.frame_rate_hz;
  platform.pixel_clock_hz = setup_.rig.pixel_clock_hz();
  platform.patterns = 2 * setup_.bits;
  platform.seed = static_cast<std::uint64_t>(setup_.rig.imaging.seed);
  return platform;
}

void DepthCosim::choose_pictures() {
  const auto cycle = static_cast<std::size_t>(2 * setup_.bits);
  const std::size_t total = frames();
  pictures_ = options_.pictures;
  for (const std::size_t frame : pictures_) {
    if (frame > total || frame < cycle || frame % 2 != 0) {
      throw UserError(
          fmt::format("--picture-frame {}", frame),
          fmt::format("completes no code image; frames {}, {}, ... {} do", cycle, cycle + 2, total / 2 * 2));
    }
  }
  if (!pictures_.empty()) {
    return;
  }
  const std::size_t images = (total - cycle) / 2 + 1;
  const std::size_t shown = std::min(kMaxPictures, images);
  for (std::size_t i = 0; i < shown; ++i) {
    pictures_.push_back(cycle + 2 * (images * (2 * i + 1) / (2 * shown)));
  }
}

void DepthCosim::frame(std::size_t frame, const images::Image& image) {
  if (std::find(pictures_.begin(), pictures_.end(), frame + 1) != pictures_.end()) {
    camera_[frame + 1] = image;
  }
}

void DepthCosim::packet(const model::PacketView& packet, files::OutputFolder* folder) {
  if (!assembler_.add(packet)) {
    return;
  }
  ++images_;
  add_codes(assembler_.codes().data());
  renderer_.lit_depth(middle_frame(), truth_.values, static_cast<float>(setup_.rig.measure.code_threshold));
  errors_.add(depth(), truth_);
  followed();
  if (folder != nullptr && std::find(pictures_.begin(), pictures_.end(), newest_frame()) != pictures_.end()) {
    show(*folder);
  }
}

void DepthCosim::show(files::OutputFolder& folder) {
  const std::size_t frame = newest_frame();
  const double t =
      (static_cast<double>(options_.first) - 1 + static_cast<double>(frame) - 1) / setup_.rig.camera.frame_rate_hz;
  const std::string when = fmt::format("frame {}, t = {:.3f} s", frame, t);
  const std::string depth_png = report::depth_picture(triangulation(), depth(), "depth, " + when);
  const ShownMap map = shown_map(when);
  const std::string name = fmt::format("{:05}.", frame);
  folder.append("depth_" + name + "tiff", images::encode_float_tiff("depth.tiff", depth()));
  if (!map.values.values.empty()) {
    folder.append(map.file + "_" + name + "tiff", images::encode_float_tiff(map.file + ".tiff", map.values));
  }
  folder.append("depth_" + name + "png", depth_png);
  folder.append(map.file + "_" + name + "png", map.png);
  if (const auto image = camera_.find(frame); image != camera_.end()) {
    const std::string camera_png = images::encode_png(image->second);
    folder.append("frame_" + name + "png", camera_png);
    page_.pictures.push_back({"Camera, " + when, camera_png, "the newest image of its cycle"});
  }
  page_.pictures.push_back({"Depth, " + when, depth_png, "z, mm"});
  page_.pictures.push_back({map.title + ", " + when, map.png, map.note});
}

void DepthCosim::compare(CosimResult& result) const {
  if (incomplete() != 0 && result.lost == 0) {
    result.mismatch(fmt::format("{} code images are not complete", incomplete()));
  }
}

void DepthCosim::write(files::OutputFolder& folder, const CosimFacts& facts) {
  page_.title = facts.title;
  page_.counters = facts.counters;
  page_.settings = facts.settings;
  complete_page(page_);
  folder.append("depth.tiff", images::encode_float_tiff("depth.tiff", depth()));
  write_maps(folder);
  folder.append("cloud.ply", report::cloud_ply(triangulation(), depth()));
  folder.append("summary.json", summary_json(page_));
  folder.append("report.html", report::page_html(page_));
}

std::string DepthCosim::run_text(const std::string& method) const {
  return fmt::format("scene {}: {} frames of {} x {} at {:g} fps, {}, threshold {}, engine {}: {} depth images\n",
                     options_.scene, frames(), setup_.rig.camera.columns, setup_.rig.camera.rows,
                     setup_.rig.camera.frame_rate_hz, method, setup_.rig.measure.code_threshold, options_.engine,
                     images_);
}

std::string DepthCosim::subtitle(const std::string& method, const std::string& filter) const {
  return fmt::format("rig {}, {}, threshold {}{}, {} frames from frame {} on at {:g} frames/s", setup_.rig.name, method,
                     setup_.rig.measure.code_threshold, filter, frames(), options_.first,
                     setup_.rig.camera.frame_rate_hz);
}

std::string DepthCosim::errors_text() const {
  return fmt::format("depth: {:.2f} mm RMS from the truth, {:.2f} % of the pixels more than 15 mm off\n", errors_.rms(),
                     100 * errors_.far_off());
}

std::vector<report::Fact> DepthCosim::error_facts() const {
  return {{"depth_rms_mm", "depth from the truth, RMS", errors_.rms(), "mm"},
          {"depth_far_off", "pixels more than 15 mm off", 100 * errors_.far_off(), "%"}};
}

std::vector<report::Fact> DepthCosim::scene_facts(const char* reference_label) const {
  return {{"scene", "scene", options_.scene},
          {"reference", reference_label, info_.reference_name()},
          {"engine", "engine", options_.engine},
          {"seed", "seed of the noise", setup_.rig.imaging.seed},
          {"without", "simulated without",
           options_.without.empty() ? "–" : fmt::format("{}", fmt::join(options_.without, ", "))},
          {"bits", "bits", std::int64_t{setup_.bits}}};
}

}  // namespace selfproj::sim
