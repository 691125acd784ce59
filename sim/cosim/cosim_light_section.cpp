#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/prepared_images.h"
#include "host/production/verdict_file.h"
#include "host/production/verdict_table.h"
#include "host/report/frame_picture.h"
#include "host/report/inspection_output.h"
#include "host/report/line_images.h"
#include "host/report/report.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/inspection.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "sim/cosim/cosim_measurement.h"
#include "sim/cosim/cosim_options.h"
#include "sim/cosim/light_section.h"
#include "sim/platform/platform.h"
#include "sim/scene/region.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

// All that frames and profiles need, for scenes and for recorded images.
struct Setup {
  rig::Rig rig;
  std::unique_ptr<Scene> scene;
  std::unique_ptr<LineRenderer> renderer;
  std::unique_ptr<FrameSource> source;
  int image_columns = 0;                                          // of the frames without padding; 0: there is none
  std::unique_ptr<light_section::DifferentialProfiler> profiler;  // null without a geometry
  std::string reference;  // the text of reference.csv; empty for recorded images
  std::vector<report::Fact> facts;
};

rig::Rig light_section_rig(const std::string& name) {
  rig::Rig rig = rig::load_any_rig(name);
  if (rig.kind != rig::RigKind::light_section) {
    throw UserError("--rig " + name, "is not a rig of kind light-section");
  }
  const rig::RigRegion sent = rig.camera.sent();
  if (sent.rows > spec::kMaxRows || sent.columns > spec::kMaxColumns) {
    throw UserError("--rig " + name, fmt::format("its camera sends {}; the boards of co-simulation take up to {}",
                                                 images::size_text(sent.rows, sent.columns),
                                                 images::size_text(spec::kMaxRows, spec::kMaxColumns)));
  }
  return rig;
}

// The rig that computes the profiles.
rig::Rig rig_of(const CosimOptions& options) {
  rig::Rig rig = light_section_rig(options.rig.empty() ? "light-section" : options.rig);
  if (!options.mode.empty()) {
    rig.measure.mode = images::mode_of(options.mode);
  }
  rig.measure.threshold = options.threshold.value_or(rig.measure.threshold);
  if (rig.measure.threshold >= 1 << rig.measure.bits()) {
    throw UserError(fmt::format("--threshold {}", rig.measure.threshold),
                    fmt::format("pixels of {} bits are {} at most", rig.measure.bits(), (1 << rig.measure.bits()) - 1));
  }
  model::Measure measure = rig.measure.of_board();
  options.select.apply(measure);
  rig.measure.apply(measure);
  if (rig.measure.bits() > spec::kPixelBits) {
    const std::string source = options.rig.empty() ? "--engine " + options.engine : "--rig " + options.rig;
    const std::string has = fmt::format("has pixels of {} bits, ", rig.measure.bits());
    if (options.engine == "hls" || !options.trace.empty()) {
      throw UserError(source, has + "which go with --engine rtl and model, and without --trace");
    }
    if (options.engine == "rtl" && !has_rtl_of(rig.measure.bits())) {
      throw UserError(source, has + "and the Verilated boards 8, 10 and 12; --engine model takes others");
    }
  }
  if (measure.select == model::Select::strongest && options.engine == "hls") {
    throw UserError("--select strongest",
                    "no board has the SystemC shell of the runs; --engine rtl and model have them");
  }
  if (measure.select == model::Select::strongest && !options.trace.empty()) {
    throw UserError("--select strongest", "the board with waveforms has no runs; leave out --trace");
  }
  if (options.compact) {
    rig.measure.compact = true;
  }
  if (rig.measure.sends_compact()) {
    if (rig.measure.mode == model::Mode::binary) {
      throw UserError("--compact", "goes with modes grey and grey-over; words of mode binary have 32 bits already");
    }
    if (options.engine == "hls" || !options.trace.empty()) {
      throw UserError("--compact", "goes with --engine rtl and model, and without --trace");
    }
  }
  rig.imaging.seed = options.seed.value_or(rig.imaging.seed);
  return rig;
}

// The rig that takes the images.
rig::Rig perturbed_rig_of(const CosimOptions& options, const rig::Rig& rig) {
  if (options.perturbed_rig.empty()) {
    return rig;
  }
  rig::Rig actual = light_section_rig(options.perturbed_rig);
  if (actual.camera.rows != rig.camera.rows || actual.camera.columns != rig.camera.columns) {
    throw UserError("--perturbed-rig " + options.perturbed_rig,
                    fmt::format("has images of {}, but --rig has images of {}",
                                images::size_text(actual.camera.rows, actual.camera.columns),
                                images::size_text(rig.camera.rows, rig.camera.columns)));
  }
  if (actual.measure.bits() != rig.measure.bits()) {
    throw UserError(
        "--perturbed-rig " + options.perturbed_rig,
        fmt::format("has pixels of {} bits, but --rig has pixels of {}", actual.measure.bits(), rig.measure.bits()));
  }
  if (actual.light_plane.has_value() != rig.light_plane.has_value()) {
    throw UserError("--perturbed-rig " + options.perturbed_rig,
                    fmt::format("has a {}, but --rig has none", actual.light_plane ? "laser" : "projector"));
  }
  actual.imaging.seed = rig.imaging.seed;
  return actual;
}

std::vector<report::Fact> scene_facts(const CosimOptions& options, const SceneInfo& scene, const rig::Rig& rig,
                                      const light_section::ReferenceProfile& reference) {
  std::vector<report::Fact> facts = {
      {"scene", "scene", options.scene},
      {"reference", "reference", scene.reference_name()},
      {"residual", "residual of the reference", std::string(options.residual ? "measured and removed" : "left")},
      {"reference_columns", "columns with a reference", std::int64_t{reference.valid_columns()}},
      {"seed", "seed of the noise", rig.imaging.seed}};
  if (!options.perturbed_rig.empty()) {
    facts.push_back({"perturbed_rig", "rig that took the images", options.perturbed_rig});
  }
  if (!options.without.empty()) {
    facts.push_back({"without", "simulated without", fmt::format("{}", fmt::join(options.without, ", "))});
  }
  return facts;
}

// What the camera sends of the image of a frame.
template <typename Pixel>
images::ImageOf<Pixel> image_sent(const LineRenderer& renderer, const rig::RigCamera& camera, int frame) {
  images::ImageOf<Pixel> sensor{camera.rows, camera.columns, std::vector<Pixel>(camera.pixels())};
  renderer.render(frame, sensor.pixels);
  if (!camera.region) {
    return sensor;
  }
  const rig::RigRegion region = camera.sent();
  images::ImageOf<Pixel> sent{region.rows, region.columns, {}};
  sent.pixels.resize(static_cast<std::size_t>(region.rows) * static_cast<std::size_t>(region.columns));
  crop_as_sent<Pixel>(camera, sensor.pixels, sent.pixels);
  return sent;
}

Setup scene_setup(const CosimOptions& options, const SceneInfo& info) {
  Setup setup;
  setup.rig = rig_of(options);
  const rig::Rig& rig = setup.rig;
  const rig::Rig actual = perturbed_rig_of(options, rig);
  const rig::RigRegion sent = rig.camera.sent();
  // The reference is scanned with the same exposure, by the whole sensor and so more slowly.
  rig::Rig exposed = actual;
  expose_as_sent(rig.camera, exposed);
  rig::Rig running = exposed;
  running.camera.frame_rate_hz = rig.camera.region ? sent.frame_rate_hz : actual.camera.frame_rate_hz;
  setup.scene = make_scene(info.name, running);
  const RenderOptions render = options.render();
  const LightSection light =
      self_projection(rig, exposed, *make_scene(info.reference_name(), exposed), render, options.residual);
  const auto mode =
      static_cast<std::size_t>(std::find(kAllModes.begin(), kAllModes.end(), rig.measure.mode) - kAllModes.begin());
  const light_section::ReferenceProfile& reference = light.references.at(mode);
  if (reference.valid_columns() == 0) {
    throw UserError("--scene " + options.scene, "the rig's camera sees the projected line in no column");
  }
  setup.renderer = std::make_unique<LineRenderer>(running, *setup.scene, light.pattern, render);
  const std::size_t count =
      frames_of_run(options, static_cast<std::size_t>(setup.scene->frames()), "scene " + options.scene);
  setup.source = std::make_unique<SceneFrames>(
      [renderer = setup.renderer.get(), camera = rig.camera, bits = rig.measure.bits()](int frame) {
        return bits > spec::kPixelBits ? images::SensorImage(image_sent<std::uint16_t>(*renderer, camera, frame))
                                       : image_sent<std::uint8_t>(*renderer, camera, frame);
      },
      sent.rows, sent.columns, rig.measure.bits(), options.first - 1, count);
  setup.profiler = std::make_unique<light_section::DifferentialProfiler>(rig, reference);
  setup.reference = light_section::reference_csv(rig, reference);
  setup.facts = scene_facts(options, info, rig, reference);
  return setup;
}

std::unique_ptr<RecordedFrames> recorded_frames(const CosimOptions& options, int bits) {
  std::vector<std::string> files = images::files_of_patterns("--frames", options.frames);
  const std::size_t count = frames_of_run(options, files.size(), "--frames " + options.frames.front());
  images::Preparation preparation = options.preparation;
  preparation.background = images::files_of_patterns("--background", options.preparation.background);
  if (preparation.background.size() == 1 && files.size() > 1) {
    // one for all frames
  } else if (!preparation.background.empty() && preparation.background.size() != files.size()) {
    throw UserError("--background " + options.preparation.background.front(),
                    fmt::format("has {} files for {} frames", preparation.background.size(), files.size()));
  }
  for (auto* list : {&files, &preparation.background}) {
    if (list->size() > 1) {
      list->erase(list->begin(), list->begin() + static_cast<std::ptrdiff_t>(options.first - 1));
      list->resize(count);
    }
  }
  preparation.bits = bits;
  auto source = std::make_unique<RecordedFrames>(images::PreparedSensorImages(files, preparation), bits, 0, count);
  if (!options.rig.empty()) {
    const rig::RigRegion sent = light_section_rig(options.rig).camera.sent();
    if (source->rows() != sent.rows || source->image_columns() != sent.columns) {
      throw UserError(files.front(), fmt::format("is {}, but the camera of --rig {} sends {}",
                                                 images::size_text(source->rows(), source->image_columns()),
                                                 options.rig, images::size_text(sent.rows, sent.columns)));
    }
  }
  return source;
}

Setup recorded_setup(const CosimOptions& options) {
  Setup setup;
  setup.rig = rig_of(options);
  std::unique_ptr<RecordedFrames> frames =
      recorded_frames(options, options.rig.empty() ? spec::kPixelBits : setup.rig.measure.bits());
  setup.image_columns = frames->image_columns();
  setup.source = std::move(frames);
  setup.facts = {{"frames_from", "recorded images", options.frames.front()}};
  if (!options.preparation.background.empty()) {
    setup.facts.push_back({"background", "subtracted from them", options.preparation.background.front()});
  }
  if (options.rig.empty()) {
    // Without a rig only the grey values of the images are known.
    if (!options.threshold) {
      throw UserError("--frames", "needs --threshold, or --rig, which has one");
    }
    return setup;
  }
  // The straight line that lies on the middle row where it meets the plane.
  const double far = setup.rig.plane_z_mm;
  const light_section::ReferenceProfile reference =
      light_section::reference_of_curve(setup.rig, {{-far, far}, {far, far}});
  if (reference.valid_columns() == 0) {
    throw UserError("--rig " + options.rig, "the camera sees the projected line on the plane in no column");
  }
  setup.profiler = std::make_unique<light_section::DifferentialProfiler>(setup.rig, reference);
  setup.facts.push_back({"reference", "reference", std::string("the plane, straight line")});
  return setup;
}

class LightSectionCosim final : public CosimMeasurement {
 public:
  LightSectionCosim(const CosimOptions& options, Setup setup)
      : options_(options),
        setup_(std::move(setup)),
        columns_(setup_.source->columns()),
        measure_(setup_.rig.measure.of_board()),
        line_images_(setup_.source->rows(), setup_.image_columns > 0 ? setup_.image_columns : columns_,
                     setup_.rig.measure) {
    if (setup_.profiler != nullptr) {
      inspection_.emplace(setup_.rig, setup_.profiler->columns(),
                          light_section::InspectionOptions{.expected_frames = setup_.source->total()});
      profile_.resize(setup_.profiler->columns());
    }
    runs_.resize(measure_.select, columns_);
  }

  FrameSource& source() override { return *setup_.source; }
  [[nodiscard]] std::string reference() const override { return setup_.reference; }

  [[nodiscard]] PlatformOptions platform() const override {
    const rig::Rig& rig = setup_.rig;
    const rig::RigRegion sent = rig.camera.sent();
    PlatformOptions platform;
    platform.engine = engine_of(options_);
    platform.pixel_bits = rig.measure.bits();
    platform.settings = {.columns = columns_,
                         .rows = setup_.source->rows(),
                         .mode = measure_.mode,
                         .threshold = measure_.threshold,
                         .select = measure_.select,
                         .gap = measure_.gap,
                         .window = measure_.window,
                         .region_row = rig.camera.region_row(),
                         .region_column = rig.camera.region_column(),
                         .compact = rig.measure.sends_compact()};
    if (!options_.verdict.empty()) {
      judge(platform);
    }
    platform.frame_rate_hz = sent.frame_rate_hz;
    platform.pixel_clock_hz = rig.pixel_clock_hz();
    if (rig.conveyor.encoder_mm_per_count > 0 && setup_.profiler != nullptr) {
      platform.encoder_steps_per_s = rig.conveyor.speed_mm_per_s / rig.conveyor.encoder_mm_per_count;
      if (platform.encoder_steps_per_s > platform.pixel_clock_hz / 4) {
        throw UserError("--rig " + rig.name, "the encoder turns too fast for the board");
      }
    }
    platform.seed = static_cast<std::uint64_t>(rig.imaging.seed);
    return platform;
  }

  // The board judges by the table of the options.
  void judge(PlatformOptions& platform) const {
    constexpr std::size_t kMostSections = 15;
    const std::string source = "--verdict " + options_.verdict;
    const production::VerdictTable table = production::load_verdict_table(options_.verdict);
    production::check_verdict_table(table, setup_.rig, source);
    if (table.columns != columns_ || table.rows != setup_.source->rows()) {
      throw UserError(source,
                      fmt::format("is for frames of {}, but these are {}", images::size_text(table.rows, table.columns),
                                  images::size_text(setup_.source->rows(), columns_)));
    }
    if (table.sections.size() > kMostSections) {
      throw UserError(source, fmt::format("has {} sections; the simulated board has room for {}", table.sections.size(),
                                          kMostSections));
    }
    if (options_.engine == "hls" || !options_.trace.empty()) {
      throw UserError(source, "goes with --engine rtl and model, and without --trace");
    }
    platform.limits = table.sections;
    platform.settings.verdict = true;
    platform.settings.verdict_packets = options_.verdict_alone ? 2 : 1;
    platform.settings.verdict_settings = table.settings;
    platform.settings.part_rule = table.rule;
  }

  // Takes the frames that the user asked for, or else the middle one of a scene, or the first ten recorded images.
  void choose_pictures() override {
    constexpr std::size_t kMost = 10;
    const std::size_t total = setup_.source->total();
    pictures_ = options_.pictures;
    for (const std::size_t frame : pictures_) {
      if (frame > total) {
        throw UserError(fmt::format("--picture-frame {}", frame), fmt::format("the run has {} frames", total));
      }
    }
    if (!pictures_.empty()) {
      return;
    }
    if (options_.frames.empty()) {
      pictures_ = {(total + 1) / 2};
      return;
    }
    for (std::size_t frame = 1; frame <= std::min(total, kMost); ++frame) {
      pictures_.push_back(frame);
    }
  }

  void frame(std::size_t frame, const images::Image& image) override {
    if (std::find(pictures_.begin(), pictures_.end(), frame + 1) != pictures_.end()) {
      camera_[frame + 1].image = image;
      camera_[frame + 1].frame = frame + 1;
    }
  }

  void packet(const model::PacketView& packet, files::OutputFolder* folder) override {
    if (folder == nullptr || !model::has_columns(packet.header.kind) || packet.payload.empty() ||
        packet.header.columns != columns_) {
      return;
    }
    const std::size_t frame = packet.header.sequence + 1;
    model::unpack_columns(packet.header, packet.payload.data(), runs_.view());
    if (const auto picture = camera_.find(frame); picture != camera_.end()) {
      picture->second = line_images_.picture(frame, std::move(picture->second.image), runs_);
    }
    if (inspection_) {
      if (setup_.profiler->profile(packet, profile_.view())) {
        inspection_->add(packet.header, packet.payload, profile_.view());
      }
    } else {
      line_images_.add(frame, runs_);
    }
  }

  [[nodiscard]] std::vector<report::Fact> settings() const override {
    std::vector<report::Fact> facts = setup_.facts;
    const CameraTiming timing = this->timing();
    facts.push_back({"engine", "engine", options_.engine});
    facts.push_back({"frame_rate", "frame rate", rate(timing), "Hz"});
    facts.push_back({"clocks_per_frame", "clocks a frame", static_cast<std::int64_t>(timing.frame_clocks)});
    return facts;
  }

  void write(files::OutputFolder& folder, const CosimFacts& facts) override {
    std::vector<report::CameraPicture> pictures;  // those whose packet came
    for (const auto& [frame, picture] : camera_) {
      if (!picture.moments.m0.empty()) {
        pictures.push_back(picture);
      }
    }
    if (inspection_) {
      report::ReportParts parts;
      parts.title = facts.title;
      parts.counters = facts.counters;
      parts.settings = facts.settings;
      if (!pictures.empty()) {
        parts.camera = pictures.front();
        pictures.erase(pictures.begin());  // the inspection writes this one
      }
      report::write_inspection(*inspection_, folder, parts);
    } else {
      line_images_.write(folder, {.title = facts.title, .counters = facts.counters, .settings = facts.settings},
                         setup_.source->total(), pictures);
    }
    for (const report::CameraPicture& picture : pictures) {
      folder.append(fmt::format("frame_{}.png", picture.frame), report::frame_png(picture));
    }
  }

  [[nodiscard]] std::string text() const override {
    const rig::RigMeasure& measure = setup_.rig.measure;
    const std::string select = images::select_text(measure_);
    return fmt::format("{}: {} frames of {} at {:.0f} fps, {}, threshold {}{}{}, engine {}\n", options_.what(),
                       setup_.source->total(), images::size_text(setup_.source->rows(), columns_), rate(timing()),
                       images::mode_name(measure.mode), measure.threshold, select.empty() ? "" : ", ", select,
                       options_.engine);
  }

  [[nodiscard]] std::string matched(const CosimResult& result) const override {
    return options_.verdict_alone ? fmt::format("the verdicts of {} frames", result.frames)
                                  : fmt::format("{} columns in {} frames", result.columns, result.frames);
  }

 private:
  [[nodiscard]] CameraTiming timing() const {
    return camera_timing(setup_.source->rows(), columns_, setup_.rig.camera.sent().frame_rate_hz,
                         setup_.rig.pixel_clock_hz());
  }
  [[nodiscard]] double rate(const CameraTiming& timing) const {
    return setup_.rig.pixel_clock_hz() / static_cast<double>(timing.frame_clocks);
  }

  const CosimOptions& options_;
  Setup setup_;
  int columns_;
  model::Measure measure_;
  std::vector<std::size_t> pictures_;  // frames to show, from 1
  std::map<std::size_t, report::CameraPicture> camera_;
  light_section::Profile profile_;
  model::Runs runs_;
  std::optional<light_section::Inspection> inspection_;
  report::LineImages line_images_;  // used without a geometry
};

}  // namespace

std::unique_ptr<CosimMeasurement> make_light_section_cosim(const CosimOptions& options, const SceneInfo& scene) {
  return std::make_unique<LightSectionCosim>(options, scene_setup(options, scene));
}

std::unique_ptr<CosimMeasurement> make_recorded_cosim(const CosimOptions& options) {
  return std::make_unique<LightSectionCosim>(options, recorded_setup(options));
}

}  // namespace selfproj::sim
