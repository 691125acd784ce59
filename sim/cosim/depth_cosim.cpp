#include "sim/cosim/depth_cosim.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/files/user_error.h"
#include "host/report/depth_output.h"
#include "host/report/facts.h"
#include "host/report/frame_picture.h"
#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {
namespace {

constexpr std::size_t kMostPictures = 4;

std::string scene_text(const CosimOptions& options) { return "scene " + options.scene; }

// The scanner with the seed and threshold of the options. Throws UserError if the board cannot take its images.
Rig scanner_rig(const CosimOptions& options) {
  const std::string name = options.rig.empty() ? "scanner" : options.rig;
  Rig rig = load_rig(name);
  if (rig.kind != RigKind::scanner) {
    throw UserError("--rig " + name, fmt::format("is not a scanner, which scene {} needs", options.scene));
  }
  rig.imaging.seed = options.seed.value_or(rig.imaging.seed);
  rig.measure.code_threshold = options.threshold.value_or(rig.measure.code_threshold);
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
std::string summary_json(const ReportPage& page) {
  nlohmann::ordered_json json;
  json["title"] = page.title;
  json["measured"] = facts_json(page.highlights);
  json["counters"] = facts_json(page.counters);
  json["settings"] = facts_json(page.settings);
  return json.dump(2) + "\n";
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
          [this](int frame, std::span<std::uint8_t> pixels) {
            const int of_run = frame - static_cast<int>(options_.first - 1);
            renderer_.render(frame, patterns_.of_frame(of_run), pixels);
          },
          setup_.rig.camera.rows, setup_.rig.camera.columns, options.first - 1, setup_.frames),
      assembler_(spec::kKindCodes, 0, setup_.rig.camera.rows, setup_.rig.camera.columns),
      truth_(setup_.rig.camera.rows, setup_.rig.camera.columns) {}

PlatformOptions DepthCosim::platform() const {
  PlatformOptions platform;
  platform.engine = engine_of(options_);
  platform.settings = {.columns = setup_.rig.camera.columns,
                       .rows = setup_.rig.camera.rows,
                       .mode = Mode::binary,
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
  const std::size_t shown = std::min(kMostPictures, images);
  for (std::size_t i = 0; i < shown; ++i) {
    pictures_.push_back(cycle + 2 * (images * (2 * i + 1) / (2 * shown)));
  }
}

void DepthCosim::frame(std::size_t frame, const Image& image) {
  if (std::find(pictures_.begin(), pictures_.end(), frame + 1) != pictures_.end()) {
    camera_[frame + 1] = image;
  }
}

void DepthCosim::packet(const PacketView& packet, OutputFolder* folder) {
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

void DepthCosim::show(OutputFolder& folder) {
  const std::size_t frame = newest_frame();
  const double t =
      (static_cast<double>(options_.first) - 1 + static_cast<double>(frame) - 1) / setup_.rig.camera.frame_rate_hz;
  const std::string when = fmt::format("frame {}, t = {:.3f} s", frame, t);
  const std::string depth_png = depth_picture(triangulation(), depth(), "depth, " + when);
  const ShownMap map = shown_map(when);
  const std::string name = fmt::format("{:05}.", frame);
  folder.append("depth_" + name + "tiff", encode_float_tiff("depth.tiff", depth()));
  if (!map.values.values.empty()) {
    folder.append(map.file + "_" + name + "tiff", encode_float_tiff(map.file + ".tiff", map.values));
  }
  folder.append("depth_" + name + "png", depth_png);
  folder.append(map.file + "_" + name + "png", map.png);
  if (const auto image = camera_.find(frame); image != camera_.end()) {
    const std::string camera_png = encode_png(image->second);
    folder.append("frame_" + name + "png", camera_png);
    page_.pictures.push_back({"Camera, " + when, camera_png, "the newest image of its cycle"});
  }
  page_.pictures.push_back({"Depth, " + when, depth_png, "z, mm"});
  page_.pictures.push_back({map.title + ", " + when, map.png, map.note});
}

void DepthCosim::judge(CosimResult& result) const {
  if (incomplete() != 0 && result.lost == 0) {
    result.mismatch(fmt::format("{} code images are not complete", incomplete()));
  }
}

void DepthCosim::write(OutputFolder& folder, const CosimFacts& facts) {
  page_.title = facts.title;
  page_.counters = facts.counters;
  page_.settings = facts.settings;
  complete_page(page_);
  folder.append("depth.tiff", encode_float_tiff("depth.tiff", depth()));
  write_maps(folder);
  folder.append("cloud.ply", cloud_ply(triangulation(), depth()));
  folder.append("summary.json", summary_json(page_));
  folder.append("report.html", page_html(page_));
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

std::vector<Fact> DepthCosim::error_facts() const {
  return {{"depth_rms_mm", "depth from the truth, RMS", errors_.rms(), "mm"},
          {"depth_far_off", "pixels more than 15 mm off", 100 * errors_.far_off(), "%"}};
}

std::vector<Fact> DepthCosim::scene_facts(const char* reference_label) const {
  return {{"scene", "scene", options_.scene},
          {"reference", reference_label, info_.reference_name()},
          {"engine", "engine", options_.engine},
          {"seed", "seed of the noise", setup_.rig.imaging.seed},
          {"without", "simulated without",
           options_.without.empty() ? "–" : fmt::format("{}", fmt::join(options_.without, ", "))},
          {"bits", "bits", std::int64_t{setup_.bits}}};
}

}  // namespace selfproj
