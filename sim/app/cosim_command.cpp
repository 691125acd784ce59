#include "sim/app/cosim_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "host/io/float_image.h"
#include "host/io/frame_options.h"
#include "host/io/output_file.h"
#include "host/io/output_folder.h"
#include "host/io/program_main.h"
#include "host/io/progress.h"
#include "host/io/user_error.h"
#include "host/light_section/differential_profile.h"
#include "host/light_section/inspection.h"
#include "host/light_section/reference.h"
#include "host/report/frame_picture.h"
#include "host/report/inspection_output.h"
#include "host/rig/rig.h"
#include "host/structured_light/stripe_code.h"
#include "model/gray_decoder.h"
#include "sim/app/cosim_run.h"
#include "sim/app/cosim_scanner.h"
#include "sim/app/cosim_self.h"
#include "sim/app/frame_source.h"
#include "sim/app/moments_csv.h"
#include "sim/experiment/light_section.h"
#include "sim/platform/platform.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_list.h"

namespace selfproj {
namespace {

namespace fs = std::filesystem;

struct CosimOptions {
  std::string scene = "stairs-marked";
  std::vector<std::string> frames;      // empty: the scene
  std::vector<std::string> background;  // of the frames
  std::string engine = "rtl";
  std::string rig;       // empty: light-section for scenes, none for recorded images
  std::string real_rig;  // empty: the rig
  bool residual = false;
  std::string channel;
  std::string mode;              // empty: the rig's
  std::optional<int> threshold;  // likewise
  std::optional<std::int64_t> seed;
  std::vector<std::string> without;
  std::size_t first = 1;
  std::optional<std::size_t> count;
  int bus_stall = 0;
  std::string out;
  std::vector<std::size_t> pictures;  // frames, from 1
  std::string packets;
  std::string trace;
  std::size_t trace_from = 1;
  std::optional<int> bits;  // the rest is for scanners
  bool no_median = false;
  std::optional<double> min_difference;
  std::optional<float> max_change;
  std::optional<int> min_neighbours;
  std::optional<int> e;
};

// How many frames from --first on; `total` of them exist.
std::size_t frames_to_play(const CosimOptions& options, std::size_t total, const std::string& what) {
  if (options.first > total) {
    throw UserError(fmt::format("--first {}", options.first), fmt::format("{} has {} frames", what, total));
  }
  const std::size_t left = total - options.first + 1;
  if (options.count && *options.count > left) {
    throw UserError(fmt::format("--count {}", *options.count),
                    fmt::format("{} has {} frames from frame {} on", what, left, options.first));
  }
  return options.count.value_or(left);
}

// Everything frames, patterns and profiles need, for scenes and for recorded images.
struct Setup {
  Rig rig;
  std::unique_ptr<Scene> scene;
  std::unique_ptr<Renderer> renderer;
  std::unique_ptr<FrameSource> source;
  std::unique_ptr<DifferentialProfiler> profiler;  // none: there is no geometry
  std::vector<Fact> facts;
};

void apply_options(const CosimOptions& options, Rig& rig) {
  if (!options.mode.empty()) {
    rig.measure.mode = mode_of(options.mode);
  }
  if (options.threshold) {
    rig.measure.threshold = *options.threshold;
  }
  if (options.seed) {
    rig.imaging.seed = *options.seed;
  }
}

Rig light_section_rig(const std::string& name) {
  Rig rig = load_rig(name);
  if (rig.kind != RigKind::light_section) {
    throw UserError("--rig " + name, "is not a light section");
  }
  return rig;
}

Setup scene_setup(const CosimOptions& options) {
  Setup setup;
  setup.rig = light_section_rig(options.rig.empty() ? "light-section" : options.rig);
  apply_options(options, setup.rig);
  const Rig& rig = setup.rig;
  Rig real = rig;
  if (!options.real_rig.empty()) {
    real = light_section_rig(options.real_rig);
    if (real.camera.rows != rig.camera.rows || real.camera.columns != rig.camera.columns) {
      throw UserError("--real-rig " + options.real_rig,
                      fmt::format("has images of {}, --rig of {}", size_text(real.camera.rows, real.camera.columns),
                                  size_text(rig.camera.rows, rig.camera.columns)));
    }
    real.imaging.seed = rig.imaging.seed;
  }
  setup.scene = make_scene(options.scene, real);
  const std::string reference_name = find_scene(options.scene).reference_name();
  const RenderOptions render = options_without(options.without);
  const LightSection light = self_projection(rig, real, *make_scene(reference_name, real), render, options.residual);
  const auto mode =
      static_cast<std::size_t>(std::find(kAllModes.begin(), kAllModes.end(), rig.measure.mode) - kAllModes.begin());
  const ReferenceProfile& reference = light.references.at(mode);
  if (reference.valid_columns() == 0) {
    throw UserError("--scene " + options.scene, "the rig's camera sees the projected line in no column");
  }
  setup.renderer = std::make_unique<Renderer>(real, *setup.scene, light.pattern, render);
  const std::size_t count =
      frames_to_play(options, static_cast<std::size_t>(setup.scene->frames()), "scene " + options.scene);
  setup.source = std::make_unique<SceneFrames>(
      [renderer = setup.renderer.get()](int frame, std::span<std::uint8_t> pixels) { renderer->render(frame, pixels); },
      rig.camera.rows, rig.camera.columns, options.first - 1, count);
  setup.profiler = std::make_unique<DifferentialProfiler>(rig, reference);
  setup.facts = {
      {"scene", "scene", options.scene},
      {"reference", "reference", reference_name},
      {"residual", "residual of the reference", std::string(options.residual ? "measured and removed" : "left")},
      {"reference_columns", "columns with a reference", std::int64_t{reference.valid_columns()}},
      {"seed", "seed of the noise", rig.imaging.seed}};
  if (!options.real_rig.empty()) {
    setup.facts.push_back({"real_rig", "rig that took the images", options.real_rig});
  }
  if (!options.without.empty()) {
    setup.facts.push_back({"without", "simulated without", fmt::format("{}", fmt::join(options.without, ", "))});
  }
  return setup;
}

// The files of all the patterns of an option.
std::vector<std::string> files_of(const std::string& option, const std::vector<std::string>& patterns) {
  std::vector<std::string> files;
  for (const std::string& pattern : patterns) {
    const std::vector<std::string> found = files_of_pattern(option, pattern);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

Setup recorded_setup(const CosimOptions& options) {
  if (!options.without.empty()) {
    throw UserError("--without", "recorded images are as they are");
  }
  if (options.residual || !options.real_rig.empty()) {
    throw UserError(options.residual ? "--residual" : "--real-rig", "is for scenes, not for recorded images");
  }
  std::vector<std::string> files = files_of("--frames", options.frames);
  const std::size_t count = frames_to_play(options, files.size(), "--frames " + options.frames.front());
  std::vector<std::string> background = files_of("--background", options.background);
  if (!background.empty() && background.size() != files.size()) {
    throw UserError("--background " + options.background.front(),
                    fmt::format("{} files for {} frames", background.size(), files.size()));
  }
  for (auto* list : {&files, &background}) {
    if (!list->empty()) {
      list->erase(list->begin(), list->begin() + static_cast<std::ptrdiff_t>(options.first - 1));
      list->resize(count);
    }
  }

  Setup setup;
  setup.source = std::make_unique<RecordedFrames>(files, channel_of(options.channel), background);
  setup.facts = {{"frames_from", "recorded images", options.frames.front()}};
  if (!background.empty()) {
    setup.facts.push_back({"background", "subtracted from them", options.background.front()});
  }
  // Without a rig nothing is known about the images but their grey values.
  setup.rig = light_section_rig(options.rig.empty() ? "light-section" : options.rig);
  apply_options(options, setup.rig);
  const RigCamera& camera = setup.rig.camera;
  if (options.rig.empty()) {
    if (!options.threshold) {
      throw UserError("--frames", "needs --threshold (or --rig, which has one)");
    }
    return setup;
  }
  if (setup.source->rows() != camera.rows || setup.source->columns() != camera.columns) {
    throw UserError(files.front(), fmt::format("is {}, but the camera of --rig {} has {}",
                                               size_text(setup.source->rows(), setup.source->columns()), options.rig,
                                               size_text(camera.rows, camera.columns)));
  }
  // The straight line that lies on the middle row where it meets the plane.
  const double far = setup.rig.plane_z_mm;
  const ReferenceProfile reference = reference_of_curve(setup.rig, {{-far, far}, {far, far}});
  if (reference.valid_columns() == 0) {
    throw UserError("--rig " + options.rig, "the camera sees the projected line on the plane in no column");
  }
  setup.profiler = std::make_unique<DifferentialProfiler>(setup.rig, reference);
  setup.facts.push_back({"reference", "reference", std::string("the plane, straight line")});
  return setup;
}

PlatformOptions platform_options(const CosimOptions& options, const Setup& setup) {
  PlatformOptions platform;
  if (options.engine == "model") {
    platform.engine = PlatformEngine::model;
#ifdef SELFPROJ_HAS_RTL_PLATFORM
  } else if (options.engine == "rtl") {
    platform.engine = PlatformEngine::rtl;
  } else if (options.engine == "hls") {
    platform.engine = PlatformEngine::hls;
#endif
  } else {
    throw UserError("--engine " + options.engine, "this engine is not part of this build");
  }
  const Rig& rig = setup.rig;
  platform.settings = {.columns = setup.source->columns(),
                       .rows = setup.source->rows(),
                       .mode = rig.measure.mode,
                       .threshold = rig.measure.threshold};
  platform.frame_rate_hz = rig.camera.frame_rate_hz;
  if (rig.conveyor.encoder_mm_per_count > 0 && setup.profiler != nullptr) {
    platform.encoder_steps_per_s = rig.conveyor.speed_mm_per_s / rig.conveyor.encoder_mm_per_count;
    if (platform.encoder_steps_per_s > kPixelClockHz / 4) {
      throw UserError("--rig " + rig.name, "the encoder turns too fast for the board");
    }
  }
  platform.bus.stall_percent = options.bus_stall;
  platform.seed = static_cast<std::uint64_t>(rig.imaging.seed);
  if (!options.trace.empty()) {
    if (platform.engine != PlatformEngine::rtl) {
      throw UserError("--trace " + options.trace, "only --engine rtl has waveforms");
    }
    if (options.trace_from > setup.source->total()) {
      throw UserError(fmt::format("--trace-from {}", options.trace_from),
                      fmt::format("there are {} frames", setup.source->total()));
    }
    platform.trace_file = options.trace + ".part";
    platform.trace_from = options.trace_from;
  }
  return platform;
}

// A waveform file that the simulator writes itself: under another name until it is whole.
class TraceFile {
 public:
  TraceFile(std::string name, std::string part) : name_(std::move(name)), part_(std::move(part)) {
    if (!name_.empty()) {
      const OutputFile check(name_);
      const OutputFile check_part(part_);
    }
  }
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;
  ~TraceFile() {
    std::error_code unused;
    if (!name_.empty() && !done_) {
      fs::remove(part_, unused);
      fs::remove(part_ + ".hier", unused);
    }
  }
  void commit() {
    if (!name_.empty()) {
      std::error_code error;
      fs::rename(part_, name_, error);
      if (error) {
        throw UserError(name_, error.message());
      }
      done_ = true;
    }
  }

 private:
  std::string name_;
  std::string part_;
  bool done_ = false;
};

// What is kept of the frames while they pass.
class Collector {
 public:
  Collector(const Setup& setup, std::vector<std::size_t> pictures)
      : setup_(setup), pictures_(std::move(pictures)), columns_(setup.source->columns()) {
    if (setup.profiler != nullptr) {
      inspection_.emplace(setup.rig, columns_, InspectionOptions{.expected_frames = setup.source->total()});
      profile_.resize(columns_);
    }
    moments_.resize(columns_);
  }

  void frame(std::size_t frame, const Image& image) {
    if (std::find(pictures_.begin(), pictures_.end(), frame + 1) != pictures_.end()) {
      camera_[frame + 1].image = image;
      camera_[frame + 1].frame = frame + 1;
    }
  }

  void packet(const PacketView& packet) {
    if (packet.header.kind != spec::kKindMoments || packet.payload.empty() || packet.header.columns != columns_) {
      return;
    }
    const std::size_t frame = packet.header.sequence + 1;
    const auto mode = static_cast<Mode>(packet.header.mode);
    unpack_moments(mode, columns_, packet.payload.data(), moments_.view());
    if (const auto picture = camera_.find(frame); picture != camera_.end()) {
      picture->second.moments = moments_;
    }
    if (inspection_) {
      setup_.profiler->profile(mode, packet.payload.data(), profile_.view());
      inspection_->add(packet.header, packet.payload, profile_.view());
    } else {
      append_moments_csv(csv_, frame, moments_);
      for (std::size_t column = 0; column < moments_.m0.size(); ++column) {
        centroids_.push_back(moments_.m0[column] == 0
                                 ? std::numeric_limits<float>::quiet_NaN()
                                 : static_cast<float>(static_cast<double>(moments_.m1[column]) / moments_.m0[column]));
      }
    }
  }

  // Writes what was collected into the folder.
  void write(OutputFolder& folder, ReportParts parts) const {
    std::vector<CameraPicture> pictures;  // those whose packet came
    for (const auto& [frame, picture] : camera_) {
      if (!picture.moments.m0.empty()) {
        pictures.push_back(picture);
      }
    }
    if (inspection_) {
      if (!pictures.empty()) {
        parts.camera = pictures.front();
        pictures.erase(pictures.begin());  // the inspection writes that one
      }
      write_inspection(*inspection_, folder, parts);
    } else {
      FloatImage image;
      image.columns = columns_;
      image.rows = static_cast<int>(centroids_.size() / static_cast<std::size_t>(columns_));
      image.values = centroids_;
      folder.append("summary.json", summary(parts));
      folder.append("moments.csv", csv_);
      folder.append("centroid.tiff", encode_float_tiff("centroid.tiff", image));
      folder.append("report.html", report_html(report(parts, pictures)));
    }
    for (const CameraPicture& picture : pictures) {
      folder.append(fmt::format("frame_{}.png", picture.frame), frame_png(picture));
    }
  }

 private:
  // What is known without geometry, as the inspection names it.
  [[nodiscard]] std::string summary(const ReportParts& parts) const {
    nlohmann::ordered_json json;
    json["title"] = parts.title;
    json["frames"] = centroids_.size() / static_cast<std::size_t>(columns_);
    json["columns"] = columns_;
    json["mode"] = mode_name(setup_.rig.measure.mode);
    json["threshold"] = setup_.rig.measure.threshold;
    for (const auto& [name, facts] : {std::pair("counters", &parts.counters), std::pair("settings", &parts.settings)}) {
      for (const Fact& fact : *facts) {
        std::visit([&, key = name](const auto& value) { json[key][fact.key] = value; }, fact.value);
      }
    }
    return json.dump(2) + "\n";
  }

  [[nodiscard]] MomentsReport report(const ReportParts& parts, const std::vector<CameraPicture>& pictures) const {
    const RigMeasure& measure = setup_.rig.measure;
    const auto lit = centroids_.size() - static_cast<std::size_t>(std::count_if(centroids_.begin(), centroids_.end(),
                                                                                [](float c) { return std::isnan(c); }));
    return {.title = parts.title,
            .subtitle = fmt::format("{} × {} px · no rig: moments only · mode {} · threshold {}", setup_.source->rows(),
                                    columns_, mode_name(measure.mode), measure.threshold),
            .highlights = {{"frames", "frames", static_cast<std::int64_t>(setup_.source->total())},
                           {"lit", "columns with light", static_cast<std::int64_t>(lit)},
                           {"lit_share", "of all columns",
                            fmt::format("{:.1f}", 100 * static_cast<double>(lit) /
                                                      static_cast<double>(std::max<std::size_t>(1, centroids_.size()))),
                            "%"}},
            .counters = parts.counters,
            .settings = parts.settings,
            .cameras = pictures};
  }

  const Setup& setup_;
  std::vector<std::size_t> pictures_;
  int columns_;
  Profile profile_;
  Moments moments_;
  std::optional<Inspection> inspection_;
  std::map<std::size_t, CameraPicture> camera_;
  // Without geometry.
  std::string csv_ = kMomentsCsvHeader;
  std::vector<float> centroids_;
};

// The frames asked for; else the middle one of a scene, or the first ten of recorded images.
std::vector<std::size_t> pictures_of(const CosimOptions& options, std::size_t total) {
  constexpr std::size_t kMost = 10;
  if (!options.pictures.empty()) {
    for (const std::size_t frame : options.pictures) {
      if (frame > total) {
        throw UserError(fmt::format("--picture-frame {}", frame), fmt::format("there are {} frames", total));
      }
    }
    return options.pictures;
  }
  if (options.frames.empty()) {
    return {(total + 1) / 2};
  }
  std::vector<std::size_t> all;
  for (std::size_t frame = 1; frame <= std::min(total, kMost); ++frame) {
    all.push_back(frame);
  }
  return all;
}

std::vector<Fact> counters_of(const CosimResult& result) {
  const auto fact = [](const char* key, const char* label, std::uint64_t value) {
    return Fact{key, label, static_cast<std::int64_t>(value)};
  };
  return {fact("matched_columns", "columns equal to the model's", result.columns),
          fact("matched_frames", "frames equal to the model's", result.frames),
          fact("mismatches", "mismatches with the model", result.mismatches),
          fact("delivered", "packets delivered", result.driver.delivered),
          fact("lost_board", "lost on the board", result.lost),
          fact("lost_ring", "lost in the ring", result.driver.lost_ring),
          fact("bad", "bad packets", result.driver.bad),
          fact("resynchronized", "resynchronized", result.driver.resynchronized)};
}

// Scenes of rig B have a run of their own.
void run_scanner(const CosimOptions& options) {
  const bool self = is_self_scene(options.scene);
  const auto refuse = [&](bool given, const char* option) {
    if (given) {
      throw UserError(option, fmt::format("is not for scene {}, which a scanner sees", options.scene));
    }
  };
  refuse(!options.mode.empty(), "--mode");
  refuse(!options.channel.empty(), "--channel");
  refuse(!options.trace.empty(), "--trace");
  refuse(options.residual, "--residual");
  refuse(!options.real_rig.empty(), "--real-rig");
  const bool of_moved = options.min_difference || options.max_change || options.min_neighbours;
  if (self && (options.no_median || of_moved)) {
    throw UserError("--no-median, --min-difference, --max-change, --min-neighbours",
                    "are not for scenes of self-projected structured light");
  }
  if (!self && options.e) {
    throw UserError("--e", "is for scenes of self-projected structured light");
  }
  ScannerCosimOptions scanner{
      .scene = options.scene,
      .engine = options.engine,
      .threshold = options.threshold,
      .seed = options.seed,
      .first = options.first,
      .count = options.count,
      .bits = options.bits.value_or(self ? Stripes{}.bits : ScannerCosimOptions{}.bits),
      .median = !self && !options.no_median,
      .e = options.e.value_or(self_scene_e(options.scene)),
      .min_difference_mm = options.min_difference.value_or(ScannerCosimOptions{}.min_difference_mm),
      .steady = {options.max_change.value_or(ScannerCosimOptions{}.steady.most_change_mm),
                 options.min_neighbours.value_or(ScannerCosimOptions{}.steady.least_neighbours)},
      .bus_stall = options.bus_stall,
      .out = options.out,
      .pictures = options.pictures,
      .packets = options.packets};
  if (!options.rig.empty()) {
    scanner.rig = options.rig;
  }
  scanner.render = options_without(options.without);
  scanner.without = fmt::format("{}", fmt::join(options.without, ", "));
  if (self) {
    run_self_cosim(scanner);
  } else {
    run_scanner_cosim(scanner);
  }
}

void run_cosim(const CosimOptions& options) {
  if (options.frames.empty() && (is_scanner_scene(options.scene) || is_self_scene(options.scene))) {
    run_scanner(options);
    return;
  }
  if (options.bits || options.no_median || options.min_difference || options.max_change || options.min_neighbours ||
      options.e) {
    throw UserError("--bits, --no-median, --min-difference, --max-change, --min-neighbours, --e",
                    "are for the scenes of a scanner");
  }
  const std::optional<OutputFile> packets_file =
      options.packets.empty() ? std::nullopt : std::optional<OutputFile>(options.packets);
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  const Setup setup = options.frames.empty() ? scene_setup(options) : recorded_setup(options);
  const PlatformOptions platform = platform_options(options, setup);
  TraceFile trace(options.trace, platform.trace_file);
  const std::size_t total = setup.source->total();

  Collector collector(setup, folder ? pictures_of(options, total) : std::vector<std::size_t>());
  std::string stream;  // --packets
  CosimResult result;
  const auto start = std::chrono::steady_clock::now();
  {
    Progress progress("frame", total);
    result = run_cosim(platform, *setup.source,
                       {.frame =
                            [&](std::size_t frame, const Image& image) {
                              collector.frame(frame, image);
                              progress.update(frame + 1);
                            },
                        .packet =
                            [&](std::span<const std::uint8_t> bytes, const PacketView& packet) {
                              if (packets_file) {
                                stream.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                              }
                              if (folder) {
                                collector.packet(packet);
                              }
                            }});
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  const CameraTiming timing = camera_timing(platform.settings.rows, platform.settings.columns, platform.frame_rate_hz);
  const double rate = kPixelClockHz / static_cast<double>(timing.frame_clocks);
  if (folder) {
    ReportParts parts;
    parts.title = options.frames.empty() ? "Co-simulation: " + options.scene : "Co-simulation of recorded images";
    parts.counters = counters_of(result);
    parts.settings = setup.facts;
    parts.settings.push_back({"engine", "engine", options.engine});
    parts.settings.push_back({"frame_rate", "frame rate", rate, "Hz"});
    parts.settings.push_back({"clocks_per_frame", "clocks a frame", static_cast<std::int64_t>(timing.frame_clocks)});
    parts.settings.push_back({"clocks", "pixel clocks simulated", static_cast<std::int64_t>(result.platform.clocks)});
    parts.settings.push_back({"bus_stall", "bus not ready", std::int64_t{options.bus_stall}, "%"});
    collector.write(*folder, std::move(parts));
    folder->commit();
  }
  if (packets_file) {
    packets_file->write(stream);
  }
  trace.commit();

  const auto clocks = static_cast<double>(result.platform.clocks);
  fmt::print("{}: {} frames of {} at {:.0f} fps, {}, threshold {}, engine {}\n",
             options.frames.empty() ? "scene " + options.scene : "recorded images", total,
             size_text(platform.settings.rows, platform.settings.columns), rate, mode_name(platform.settings.mode),
             platform.settings.threshold, options.engine);
  fmt::print("{:.2f} M pixel clocks in {:.1f} s: {:.2f} M clocks/s, 1/{:.0f} of real time\n", clocks * 1e-6, seconds,
             clocks / seconds * 1e-6, kPixelClockHz * seconds / clocks);
  if (result.lost != 0) {
    fmt::print("{} packets lost on the board, all of them counted by it\n", result.lost);
  }
  for (const std::string& written : {options.out, options.packets, options.trace}) {
    if (!written.empty()) {
      fmt::print("→ {}\n", written);
    }
  }
  fmt::print("{}\n", outcome_text(result));
  if (result.mismatches != 0) {
    std::fflush(stdout);
    throw CheckFailed(result.first_mismatch);
  }
}

}  // namespace

void add_cosim_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "cosim", "Frames through camera, board and driver to profiles; every packet compared with the model");
  const auto options = std::make_shared<CosimOptions>();
  CLI::Option* scene = command->add_option("--scene", options->scene, "Scene under the simulated camera (scene list)")
                           ->type_name("NAME")
                           ->capture_default_str();
  CLI::Option* frames =
      command
          ->add_option("--frames", options->frames, "Recorded images instead: files, or patterns such as 'run/*.png'")
          ->type_name("PATTERN")
          ->excludes(scene);
  command
      ->add_option("--background", options->background,
                   "The same views without the line, one for each frame, to be subtracted before the board sees them")
      ->type_name("PATTERN")
      ->needs(frames);
  command->add_option("--engine", options->engine, "What computes: the board's RTL, the HLS kernel, the model")
      ->check(CLI::IsMember(std::vector<std::string>{"rtl", "hls", "model"}))
      ->capture_default_str();
  command
      ->add_option("--rig", options->rig,
                   "Built-in rig or its YAML file (scenes: light-section, or scanner; recorded images: none, so that "
                   "only moments "
                   "and centroids come out)")
      ->type_name("RIG");
  command->add_flag("--residual", options->residual,
                    "Measure the reference part once with its own pattern, keep each column's offset and remove it");
  command
      ->add_option("--real-rig", options->real_rig,
                   "Rig that takes the images, where it is not quite what --rig says (an error of calibration)")
      ->type_name("RIG");
  command->add_option("--channel", options->channel, "What to take of colour images")
      ->check(CLI::IsMember(channel_names()));
  command
      ->add_option("--mode", options->mode,
                   "A lit pixel weighs 1 (binary), its value (grey), its value - T (grey-over) [the rig's]")
      ->check(CLI::IsMember(mode_names()));
  command
      ->add_option("--threshold", options->threshold,
                   "A pixel is lit where it is greater than this; a scanner's pair is ambiguous where it differs "
                   "by no more [the rig's]")
      ->check(CLI::Range(0, 255))
      ->type_name("T");
  command->add_option("--seed", options->seed, "Of all that is random [the rig's]")->type_name("N");
  std::vector<std::string> names;
  for (const auto& [name, flag] : kDisturbances) {
    if (flag != &RenderOptions::quantization) {  // the board takes 8 bits
      names.emplace_back(name);
    }
  }
  command->add_option("--without", options->without, "Leaves these out of the simulated camera's image, comma between")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  command->add_option("--first", options->first, "Frame to begin with")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30U))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--count", options->count, "Frames [all]")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30U))
      ->type_name("N");
  command->add_option("--bus-stall", options->bus_stall, "Share of the bus's clocks in which it takes nothing, percent")
      ->check(CLI::Range(0, 95))
      ->type_name("PERCENT")
      ->capture_default_str();
  command->add_option("--out", options->out, "Folder for tables, cloud, images, report; without it only the comparison")
      ->type_name("DIR");
  command
      ->add_option("--picture-frame", options->pictures,
                   "Frames of this run, from 1, to show as frame_K.png with the line found [the middle one; of "
                   "recorded images the first ten]")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30U))
      ->type_name("K");
  command->add_option("--packets", options->packets, "Keeps the stream of packets, for selfproj-sim board --replay")
      ->type_name("FILE");
  command
      ->add_option("--bits", options->bits,
                   "With a scanner's scene: bits of the Gray code [8; 4 where it is self-projected]")
      ->check(CLI::Range(1, GrayDecoder::kMaxBits))
      ->type_name("M");
  command->add_flag("--no-median", options->no_median, "With a scanner's scene: codes without the 3 x 3 median");
  command
      ->add_option("--min-difference", options->min_difference,
                   "With a scanner's scene: from the background, mm, of what counts as moved [10]")
      ->check(CLI::Range(0.0, 1000.0))
      ->type_name("MM");
  command
      ->add_option("--max-change", options->max_change,
                   "With a scanner's scene: from one depth image to the next, mm, of what counts as moved [10]")
      ->check(CLI::Range(0.0, 1000.0))
      ->type_name("MM");
  command
      ->add_option(
          "--min-neighbours", options->min_neighbours,
          "With a scanner's scene: of the 8 pixels around, moved and as near in z, for what counts as moved [6]")
      ->check(CLI::Range(0, 8))
      ->type_name("N");
  command
      ->add_option("--e", options->e,
                   "With a scene of self-projected structured light: cells below the reference that are searched [8 of "
                   "the cuboids, else 0]")
      ->check(CLI::Range(0, (1 << Stripes::kMaxBits) - 1))
      ->type_name("CELLS");
  CLI::Option* trace =
      command->add_option("--trace", options->trace, "Waveforms of the board (engine rtl)")->type_name("FILE.fst");
  command->add_option("--trace-from", options->trace_from, "... from this frame of this run on, from 1")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30U))
      ->type_name("F")
      ->needs(trace)
      ->capture_default_str();
  command->callback([options] { run_cosim(*options); });
}

}  // namespace selfproj
