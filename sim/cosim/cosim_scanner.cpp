#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/report/depth_output.h"
#include "host/report/map_picture.h"
#include "host/report/report.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/depth_geometry.h"
#include "selfproj/structured_light/foreground.h"
#include "selfproj/structured_light/scanner.h"
#include "selfproj/structured_light/triangulation.h"
#include "sim/cosim/cosim_measurement.h"
#include "sim/cosim/cosim_options.h"
#include "sim/cosim/depth_cosim.h"
#include "sim/cosim/motion_analysis.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Nothing lies below the plane. A depth that is more than this below it, mm, which leaves room for quantization, comes
// from a wrong code.
constexpr double kBelowPlane = 15;

constexpr int kDefaultBits = 8;

// Background less depth, where both exist.
images::FloatImage difference_of(const images::FloatImage& depth, const images::FloatImage& background) {
  images::FloatImage result = depth;
  std::transform(background.values.begin(), background.values.end(), depth.values.begin(), result.values.begin(),
                 [](float before, float now) { return before - now; });
  return result;
}

class ScannerCosim final : public DepthCosim {
 public:
  ScannerCosim(const CosimOptions& options, const SceneInfo& info, DepthCosimSetup setup, const PatternSet& patterns)
      : DepthCosim(options, info, std::move(setup), options.no_median ? Median::off : Median::on, patterns),
        min_difference_(options.min_difference.value_or(kMovedMm)),
        steady_{options.max_change.value_or(kSteady.max_change_mm),
                options.min_neighbours.value_or(kSteady.min_neighbours)},
        triangulation_(structured_light::triangulation_of_rig(rig(), bits(), {0, rig().plane_z_mm + kBelowPlane})),
        scanner_(*triangulation_, {.threshold = rig().measure.code_threshold,
                                   .median = median() == Median::on,
                                   .min_difference_mm = static_cast<float>(min_difference_),
                                   .steady = steady_}),
        background_(rig().camera.rows, rig().camera.columns),
        true_background_(background_),
        moved_(background_) {
    measure_background(*find_scene(info.reference_name()).make(rig()), patterns);
  }

  [[nodiscard]] std::vector<report::Fact> counters(const CosimResult& result) const override {
    return {{"depth_images", "depth images", static_cast<std::int64_t>(images())},
            {"matched_codes", "codes equal to the model's", static_cast<std::int64_t>(result.codes)},
            {"incomplete", "incomplete code images", static_cast<std::int64_t>(incomplete())}};
  }

  [[nodiscard]] std::vector<report::Fact> settings() const override {
    std::vector<report::Fact> facts = scene_facts("background");
    facts.push_back({"threshold", "threshold", std::int64_t{rig().measure.code_threshold}});
    facts.push_back({"min_difference_mm", "moved: differs by more than", min_difference_, "mm"});
    facts.push_back({"max_change_mm", "... changes from one depth image to the next by no more than",
                     static_cast<double>(steady_.max_change_mm), "mm"});
    facts.push_back({"min_neighbours", "... neighbours that moved, too", std::int64_t{steady_.min_neighbours}});
    return facts;
  }

  [[nodiscard]] std::vector<report::Fact> findings() const override {
    std::vector<report::Fact> facts = findings_of(info().analysis, samples_).facts;
    for (report::Fact& fact : error_facts()) {
      facts.push_back(std::move(fact));
    }
    return facts;
  }

  [[nodiscard]] std::string text() const override {
    std::string text = run_text(fmt::format("{} bits", bits()));
    for (const report::Fact& fact : findings_of(info().analysis, samples_).facts) {
      text += fmt::format("{}: {:.4g} {}\n", fact.label, std::get<double>(fact.value), fact.unit);
    }
    return text + errors_text();
  }

  [[nodiscard]] std::string matched(const CosimResult& result) const override {
    return fmt::format("{} codes in {} code images and {} columns in {} frames", result.codes, images(), result.columns,
                       result.frames);
  }

 private:
  void add_codes(const std::uint16_t* codes) override { scanner_.add_codes(codes); }
  [[nodiscard]] const structured_light::Triangulation& triangulation() const override { return *triangulation_; }
  [[nodiscard]] const images::FloatImage& depth() const override { return scanner_.depth(); }

  void followed() override {
    DepthSample sample;
    sample.frame = newest_frame();
    sample.t = middle_frame() / rig().camera.frame_rate_hz;
    sample.moved = scanner_.foreground();
    sample.true_moved = structured_light::foreground_of(
        *triangulation_, truth().values.data(), true_background_.values.data(), static_cast<float>(min_difference_));
    if (info().analysis == SceneAnalysis::wave_front) {
      sample.front = front(sample.t, depth(), background_);
      sample.true_front = front(sample.t, truth(), true_background_);
    }
    if (info().analysis == SceneAnalysis::key_taps) {
      scanner_.difference(moved_);
      for (const KeyTaps::Pixel key : {KeyTaps::kFirst, KeyTaps::kSecond}) {
        const KeyTaps::Pixel pixel = key.of(rig().camera);
        sample.z.push_back(static_cast<double>(moved_.row(pixel.row)[pixel.column]));
        sample.true_z.push_back(static_cast<double>(truth().row(pixel.row)[pixel.column]));
      }
    }
    samples_.push_back(std::move(sample));
  }

  [[nodiscard]] ShownMap shown_map(const std::string& when) const override {
    images::FloatImage moved = depth();
    scanner_.difference(moved);
    return {.file = "moved",
            .title = "What moved",
            .png = report::depth_picture(*triangulation_, moved, "moved, " + when),
            .note = fmt::format("pixels whose depth differs from the background's by more than {} mm and stays",
                                min_difference_)};
  }

  void complete_page(report::ReportPage& page) override {
    const DepthFindings found = findings_of(info().analysis, samples_);
    page.subtitle = subtitle(fmt::format("{} bits", bits()), median() == Median::on ? ", median" : "");
    page.highlights = findings();
    page.plots = found.plots;
  }

  void write_maps(files::OutputFolder& folder) const override {
    const images::FloatImage difference = difference_of(depth(), background_);
    folder.append("background.tiff", images::encode_float_tiff("background.tiff", background_));
    folder.append("difference.tiff", images::encode_float_tiff("difference.tiff", difference));
    folder.append("difference.png", report::labelled_map_png(difference, report::difference_scale(difference), {1, 1},
                                                             "background − depth, newest; a pixel is shown as 1 mm"));
    const DepthFindings found = findings_of(info().analysis, samples_);
    folder.append(found.table_name, found.table);
  }

  // Decodes a cycle of frames of the reference on the host before the run.
  void measure_background(const Scene& reference, const PatternSet& patterns) {
    rig::Rig still_rig = rig();
    ++still_rig.imaging.seed;
    const PatternRenderer still(still_rig, reference, options().render());
    images::Image positive{background_.rows, background_.columns, std::vector<std::uint8_t>(background_.values.size())};
    images::Image negative = positive;
    for (int k = 0; k < patterns.size(); ++k) {
      images::Image& image = k % 2 == 0 ? positive : negative;
      still.render(k, patterns[k], std::span<std::uint8_t>(image.pixels));
      scanner_.add_frame(image.view(), k);
    }
    background_ = scanner_.depth();
    scanner_.set_background(background_);
    still.lit_depth(0, true_background_.values, static_cast<float>(rig().measure.code_threshold));
    // Where the scanner sees no background (a line is worth too much there), the truth is not used either.
    for (std::size_t i = 0; i < background_.values.size(); ++i) {
      if (std::isnan(background_.values[i])) {
        true_background_.values[i] = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }

  [[nodiscard]] double front(double t, const images::FloatImage& depth, const images::FloatImage& background) const {
    if (!is_open_wave(t - PoolWave::kImpact)) {
      return kNan;
    }
    const RingMeans rings = pool_rings(*triangulation_);
    return foremost_crest(rings, rings.means(depth, background, kMaxWave), kMinWave);
  }

  double min_difference_;  // mm
  structured_light::SteadySettings steady_;
  std::unique_ptr<structured_light::Triangulation> triangulation_;
  structured_light::Scanner scanner_;
  images::FloatImage background_;
  images::FloatImage true_background_;
  images::FloatImage moved_;
  std::vector<DepthSample> samples_;
};

}  // namespace

std::unique_ptr<CosimMeasurement> make_scanner_cosim(const CosimOptions& options, const SceneInfo& scene) {
  DepthCosimSetup setup = depth_cosim_setup(options, scene, options.bits.value_or(kDefaultBits));
  const PatternSet patterns(setup.rig, gray_patterns(setup.rig.projector, setup.bits), options.render());
  return std::make_unique<ScannerCosim>(options, scene, std::move(setup), patterns);
}

}  // namespace selfproj::sim
