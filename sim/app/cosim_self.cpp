#include "sim/app/cosim_self.h"

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
#include <optional>
#include <span>
#include <string>
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
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "model/gray_match.h"
#include "sim/app/cosim_run.h"
#include "sim/app/frame_source.h"
#include "sim/board/match_engine.h"
#include "sim/experiment/depth_errors.h"
#include "sim/experiment/structured_light.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_list.h"
#include "sim/scene/self_scenes.h"

namespace selfproj {
namespace {

const SceneInfo* info_of(const std::string& scene) {
  const std::vector<SceneInfo>& all = self_scenes();
  const auto at = std::find_if(all.begin(), all.end(), [&](const SceneInfo& info) { return info.name == scene; });
  return at == all.end() ? nullptr : &*at;
}

std::unique_ptr<MatchEngine> engine_of(const ScannerCosimOptions& options, const MatchTable& table) {
#ifdef SELFPROJ_HAS_RTL_ENGINE
  if (options.engine != "model") {  // the block has no kernel in HLS
    return make_match_rtl_engine(table.by_pixels(), table.bits());
  }
#endif
  return make_match_model_engine(table.by_pixels(), table.bits());
}

// Code images through the matching block, its model, and the host.
class Matching {
 public:
  Matching(const ScannerCosimOptions& options, const Rig& rig, const SelfReference& reference,
           const PatternRenderer& renderer)
      : options_(options),
        rig_(rig),
        renderer_(renderer),
        table_(rig, reference, {options.e}),
        engine_(engine_of(options, table_)),
        model_(make_match_model_engine(table_.by_pixels(), table_.bits())),
        scanner_(rig, reference, table_, rig.measure.code_threshold),
        assembler_(spec::kKindCodes, 0, rig.camera.rows, rig.camera.columns),
        lines_(scanner_.depth().values.size()),
        expected_(lines_),
        truth_(rig.camera.rows, rig.camera.columns) {}

  // True where the packet completed a code image: there is a new depth image.
  bool packet(const PacketView& packet) {
    if (!assembler_.add(packet)) {
      return false;
    }
    ++images_;
    const std::uint16_t* const codes = assembler_.codes().data();
    engine_->look_up(codes, rig_.camera.rows, rig_.camera.columns, lines_.data());
    model_->look_up(codes, rig_.camera.rows, rig_.camera.columns, expected_.data());
    scanner_.take_codes(codes);
    compare_lines();
    compare_depths();
    return true;
  }

  // Of the newest depth image: the frame of the run, from 1, that completed it.
  [[nodiscard]] std::size_t frame() const { return static_cast<std::size_t>(assembler_.header().sequence) + 1; }
  [[nodiscard]] const SelfScanner& scanner() const { return scanner_; }
  [[nodiscard]] const FloatImage& truth() const { return truth_; }
  [[nodiscard]] std::size_t images() const { return images_; }
  [[nodiscard]] std::uint64_t incomplete() const { return assembler_.incomplete(); }
  [[nodiscard]] std::uint64_t matched() const { return matched_; }        // look-ups equal to the model's
  [[nodiscard]] std::uint64_t with_line() const { return with_line_; }    // of those that found a line
  [[nodiscard]] std::uint64_t mismatches() const { return mismatches_; }  // look-ups of block or host that are not
  [[nodiscard]] const std::string& first_mismatch() const { return first_mismatch_; }
  [[nodiscard]] double depth_rms() const { return errors_.rms(); }
  [[nodiscard]] double far_off() const { return errors_.far_off(); }
  [[nodiscard]] double valid() const { return errors_.seen() / lit_; }

 private:
  void compare_lines() {
    const std::size_t columns = static_cast<std::size_t>(rig_.camera.columns);
    std::vector<float> row(columns);
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (i % columns == 0) {
        scanner_.newest_lines(static_cast<int>(i / columns), row.data());
      }
      const float wanted = expected_[i] == GrayMatch::kNone ? std::numeric_limits<float>::quiet_NaN()
                                                            : static_cast<float>(GrayMatch::line_of(expected_[i]));
      const float host = row[i % columns];
      const bool host_is_equal = host == wanted || (std::isnan(host) && std::isnan(wanted));
      if (lines_[i] == expected_[i] && host_is_equal) {
        ++matched_;
        with_line_ += expected_[i] == GrayMatch::kNone ? 0U : 1U;
      } else if (mismatches_++ == 0) {
        first_mismatch_ = fmt::format(
            "code image of frame {}, row {}, column {}: matched line word {} by the {}, {} by the host, "
            "{} expected",
            frame(), i / columns, i % columns, lines_[i], engine_->name(), host, expected_[i]);
      }
    }
  }

  // Against the truth in the middle of the frames that the codes are from.
  void compare_depths() {
    const auto middle = static_cast<int>(options_.first + frame()) - 2 - options_.bits;
    renderer_.lit_depth(middle, truth_.values, static_cast<float>(rig_.measure.code_threshold));
    lit_ += static_cast<double>(
        std::count_if(truth_.values.begin(), truth_.values.end(), [](float value) { return !std::isnan(value); }));
    errors_.add(scanner_.depth(), truth_);
  }

  const ScannerCosimOptions& options_;
  const Rig& rig_;
  const PatternRenderer& renderer_;
  MatchTable table_;
  std::unique_ptr<MatchEngine> engine_;
  std::unique_ptr<MatchEngine> model_;
  SelfScanner scanner_;
  ImageAssembler assembler_;
  std::vector<std::uint16_t> lines_, expected_;
  FloatImage truth_;
  std::size_t images_ = 0;
  std::uint64_t matched_ = 0, with_line_ = 0, mismatches_ = 0;
  std::string first_mismatch_;
  DepthErrors errors_;
  double lit_ = 0;
};

// Symmetric, over 99 % of the values: wrong matches do not set it.
MapScale scale_of(const FloatImage& difference) {
  std::vector<float> sizes;
  for (const float value : difference.values) {
    if (!std::isnan(value)) {
      sizes.push_back(std::abs(value));
    }
  }
  double most = 1;
  if (!sizes.empty()) {
    const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 99 / 100);
    std::nth_element(sizes.begin(), at, sizes.end());
    most = std::max(most, static_cast<double>(*at));
  }
  return {ColourMap::diverging, -most, most};
}

}  // namespace

bool is_self_scene(const std::string& scene) { return info_of(scene) != nullptr; }

int self_scene_e(const std::string& scene) { return scene.starts_with("cuboids") ? 8 : 0; }

void run_self_cosim(const ScannerCosimOptions& options) {
  constexpr int kRtlBits = 4;
  if (options.engine != "model" && options.bits != kRtlBits) {
    throw UserError(fmt::format("--bits {}", options.bits),
                    fmt::format("the simulated matching block is built for {} bits", kRtlBits));
  }
  if (options.bits > GrayMatch::kMaxBits) {
    throw UserError(fmt::format("--bits {}", options.bits),
                    fmt::format("self-projected codes have {} bits at most", GrayMatch::kMaxBits));
  }
  if (options.e >= 1 << options.bits) {
    throw UserError(fmt::format("--e {}", options.e), fmt::format("is not in 0..{}", (1 << options.bits) - 1));
  }
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
  const SceneInfo& info = *info_of(options.scene);
  const std::unique_ptr<Scene> scene = make_scene(info.name, rig);
  const std::string reference_name = info.reference_name();
  const std::unique_ptr<Scene> reference_scene = make_scene(reference_name, rig);
  const std::size_t total = frames_of_run(options, static_cast<std::size_t>(scene->frames()));
  const std::vector<std::size_t> pictures = folder ? pictured_frames(options, total) : std::vector<std::size_t>();

  // Before the first frame: scan, reference, patterns, table.
  Stripes stripes;
  stripes.bits = options.bits;
  const SelfReference reference =
      make_self_reference(rig, scan_points(rig, *reference_scene, options.render, true, [] {}), stripes);
  std::vector<Image> drawn;
  for (int i = 0; i < 2 * options.bits; ++i) {
    drawn.push_back(pattern_image(self_projected_pattern(reference, i)));
  }
  const PatternSet patterns(rig, drawn, options.render.projector_blur);
  const PatternRenderer renderer(rig, *scene, options.render);
  Matching matching(options, rig, reference, renderer);
  const auto first = static_cast<int>(options.first - 1);
  SceneFrames source(
      [&](int frame, std::span<std::uint8_t> pixels) {
        renderer.render(frame, patterns.of_frame(frame - first), pixels);
      },
      rig.camera.rows, rig.camera.columns, options.first - 1, total);

  ReportPage page;
  page.pictures.push_back({"Finest self-projected pattern", image_png(drawn[drawn.size() - 2]), ""});
  std::map<std::size_t, Image> camera;
  std::string stream;  // --packets
  const double pixel = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const auto show = [&](std::size_t frame) {
    const double t = (static_cast<double>(first) + static_cast<double>(frame) - 1) / rig.camera.frame_rate_hz;
    const std::string when = fmt::format("frame {}, t = {:.3f} s", frame, t);
    const SelfScanner& scanner = matching.scanner();
    const std::string depth = depth_picture(scanner.triangulation(), scanner.depth(), "depth, " + when);
    const std::string difference = labelled_map_png(scanner.difference(), scale_of(scanner.difference()),
                                                    {pixel, pixel}, "difference from the reference, " + when + ", mm");
    const std::string name = fmt::format("{:05}.", frame);
    folder->append("depth_" + name + "tiff", encode_float_tiff("depth.tiff", scanner.depth()));
    folder->append("difference_" + name + "tiff", encode_float_tiff("difference.tiff", scanner.difference()));
    folder->append("depth_" + name + "png", depth);
    folder->append("difference_" + name + "png", difference);
    if (const auto image = camera.find(frame); image != camera.end()) {
      const std::string taken = image_png(image->second);
      folder->append("frame_" + name + "png", taken);
      page.pictures.push_back({"Camera, " + when, taken, "the newest image of its cycle"});
    }
    page.pictures.push_back({"Depth, " + when, depth, "z, mm"});
    page.pictures.push_back({"Difference from the reference, " + when, difference, "mm, positive towards the camera"});
  };

  CosimResult result;
  const auto start = std::chrono::steady_clock::now();
  {
    Progress progress("frame", total);
    const auto is_shown = [&](std::size_t frame) {
      return std::find(pictures.begin(), pictures.end(), frame) != pictures.end();
    };
    result = run_cosim(platform, source,
                       {.frame =
                            [&](std::size_t frame, const Image& image) {
                              if (is_shown(frame + 1)) {
                                camera[frame + 1] = image;
                              }
                              progress.update(frame + 1);
                            },
                        .packet =
                            [&](std::span<const std::uint8_t> bytes, const PacketView& packet) {
                              if (packets_file) {
                                stream.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                              }
                              if (matching.packet(packet) && is_shown(matching.frame())) {
                                show(matching.frame());
                              }
                            }});
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (matching.incomplete() != 0 && result.lost == 0 && result.mismatches++ == 0) {
    result.first_mismatch = fmt::format("{} code images are not complete", matching.incomplete());
  }
  if (matching.mismatches() != 0 && result.mismatches == 0) {
    result.first_mismatch = matching.first_mismatch();
  }
  const std::uint64_t mismatches = result.mismatches + matching.mismatches();
  if (folder) {
    const auto count = [](const char* key, const char* label, std::uint64_t value) {
      return Fact{key, label, static_cast<std::int64_t>(value)};
    };
    page.title = "Co-simulation: " + options.scene;
    page.subtitle = fmt::format(
        "rig {}, self-projected, {} bits, e = {}, threshold {}, {} frames from frame {} on at {:g} frames/s", rig.name,
        options.bits, options.e, rig.measure.code_threshold, total, options.first, rig.camera.frame_rate_hz);
    page.highlights = {{"depth_rms_mm", "depth from the truth, RMS", matching.depth_rms(), "mm"},
                       {"depth_far_off", "pixels more than 15 mm off", 100 * matching.far_off(), "%"},
                       {"valid", "pixels in the light with a depth", 100 * matching.valid(), "%"}};
    page.counters = {count("depth_images", "depth images", matching.images()),
                     count("matched_codes", "codes equal to the model's", result.codes),
                     count("matched_lines", "matched lines equal to the model's", matching.matched()),
                     count("with_line", "of these with a line", matching.with_line()),
                     count("matched_columns", "columns of moments equal to the model's", result.columns),
                     count("matched_frames", "frames equal to the model's", result.frames),
                     count("mismatches", "mismatches with the model", mismatches),
                     count("incomplete", "incomplete code images", matching.incomplete()),
                     count("delivered", "packets delivered", result.driver.delivered),
                     count("lost_board", "lost on the board", result.lost),
                     count("bad", "bad packets", result.driver.bad)};
    page.settings = {{"scene", "scene", options.scene},
                     {"reference", "reference", reference_name},
                     {"engine", "engine", options.engine},
                     {"seed", "seed of the noise", rig.imaging.seed},
                     {"without", "simulated without", options.without.empty() ? "–" : options.without},
                     {"bits", "bits", std::int64_t{options.bits}},
                     {"e", "e, cells below the reference", std::int64_t{options.e}},
                     {"threshold", "threshold", std::int64_t{rig.measure.code_threshold}},
                     {"clocks", "pixel clocks simulated", static_cast<std::int64_t>(result.platform.clocks)},
                     {"bus_stall", "bus not ready", std::int64_t{options.bus_stall}, "%"}};
    folder->append("depth.tiff", encode_float_tiff("depth.tiff", matching.scanner().depth()));
    folder->append("difference.tiff", encode_float_tiff("difference.tiff", matching.scanner().difference()));
    folder->append("truth.tiff", encode_float_tiff("truth.tiff", matching.truth()));
    folder->append("cloud.ply", cloud_ply(matching.scanner().triangulation(), matching.scanner().depth()));
    folder->append("summary.json", summary_json(page));
    folder->append("report.html", page_html(page));
    folder->commit();
  }
  if (packets_file) {
    packets_file->write(stream);
  }
  const auto clocks = static_cast<double>(result.platform.clocks);
  fmt::print(
      "scene {}: {} frames of {} x {} at {:g} fps, self-projected, {} bits, e = {}, threshold {}, engine {}: {} "
      "depth images\n",
      options.scene, total, rig.camera.columns, rig.camera.rows, rig.camera.frame_rate_hz, options.bits, options.e,
      rig.measure.code_threshold, options.engine, matching.images());
  fmt::print("depth: {:.2f} mm RMS from the truth, {:.2f} % of the pixels more than 15 mm off\n", matching.depth_rms(),
             100 * matching.far_off());
  fmt::print("{:.2f} M pixel clocks in {:.1f} s\n", clocks * 1e-6, seconds);
  for (const std::string& written : {options.out, options.packets}) {
    if (!written.empty()) {
      fmt::print("→ {}\n", written);
    }
  }
  fmt::print("matched {} codes and {} lines in {} code images and {} columns in {} frames, {} mismatches\n",
             result.codes, matching.matched(), matching.images(), result.columns, result.frames, mismatches);
  if (mismatches != 0) {
    std::fflush(stdout);
    throw CheckFailed(result.first_mismatch);
  }
}

}  // namespace selfproj
