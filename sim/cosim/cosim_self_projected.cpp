#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/report/frame_picture.h"
#include "host/report/map_picture.h"
#include "host/report/report.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/gray_match.h"
#include "selfproj/rig/rig.h"
#include "sim/board/engines.h"
#include "sim/cosim/cosim_measurement.h"
#include "sim/cosim/cosim_options.h"
#include "sim/cosim/depth_cosim.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::sim {
namespace {

constexpr int kRtlBits = 4;  // bits for which the simulated matching block is built

// The bits of the codes. Throws UserError about --bits and --e.
int bits_of(const CosimOptions& options, int cells_below) {
  const int bits = options.bits.value_or(structured_light::Stripes{}.bits);
  if (options.engine != "model" && bits != kRtlBits) {
    throw UserError(fmt::format("--bits {}", bits),
                    fmt::format("the simulated matching block is built for {} bits", kRtlBits));
  }
  if (bits > model::GrayMatch::kMaxBits) {
    throw UserError(fmt::format("--bits {}", bits),
                    fmt::format("self-projected codes have at most {} bits", model::GrayMatch::kMaxBits));
  }
  if (cells_below >= 1 << bits) {
    throw UserError(fmt::format("--e {}", cells_below),
                    fmt::format("is out of range; {} bits allow 0 to {}", bits, (1 << bits) - 1));
  }
  return bits;
}

std::unique_ptr<MatchEngine> match_engine_of([[maybe_unused]] const CosimOptions& options,
                                             const structured_light::MatchTable& table) {
#ifdef SELFPROJ_HAS_RTL_ENGINE
  if (options.engine != "model") {  // the block has no shell
    return make_match_rtl_engine(table.by_pixels(), table.bits());
  }
#endif
  return make_match_model_engine(table.by_pixels(), table.bits());
}

// Runs code images through the matching block, and compares it with its model and the host.
class Matching {
 public:
  Matching(const CosimOptions& options, const rig::Rig& rig, const structured_light::SelfReference& reference,
           int cells_below)
      : rows_(rig.camera.rows),
        columns_(rig.camera.columns),
        table_(rig, reference, {cells_below}),
        engine_(match_engine_of(options, table_)),
        model_(make_match_model_engine(table_.by_pixels(), table_.bits())),
        scanner_(rig, reference, table_, rig.measure.code_threshold),
        lines_(scanner_.depth().values.size()),
        expected_(lines_) {}

  // Takes a code image, row by row, that was complete with this frame of the run.
  void add_codes(const std::uint16_t* codes, std::size_t frame) {
    engine_->look_up(codes, rows_, columns_, lines_.data());
    model_->look_up(codes, rows_, columns_, expected_.data());
    scanner_.add_codes(codes);
    compare(frame);
  }

  [[nodiscard]] const structured_light::SelfScanner& scanner() const { return scanner_; }
  [[nodiscard]] std::uint64_t matched() const { return matched_; }        // look-ups equal to the model's
  [[nodiscard]] std::uint64_t with_line() const { return with_line_; }    // look-ups that found a line
  [[nodiscard]] std::uint64_t mismatches() const { return mismatches_; }  // look-ups of block or host that differ
  [[nodiscard]] const std::string& first_mismatch() const { return first_mismatch_; }

 private:
  void compare(std::size_t frame) {
    const auto columns = static_cast<std::size_t>(columns_);
    std::vector<float> row(columns);
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (i % columns == 0) {
        scanner_.newest_lines(static_cast<int>(i / columns), row.data());
      }
      const float wanted = expected_[i] == model::GrayMatch::kNone
                               ? std::numeric_limits<float>::quiet_NaN()
                               : static_cast<float>(model::GrayMatch::line_of(expected_[i]));
      const float host = row[i % columns];
      const bool host_is_equal = host == wanted || (std::isnan(host) && std::isnan(wanted));
      if (lines_[i] == expected_[i] && host_is_equal) {
        ++matched_;
        with_line_ += expected_[i] == model::GrayMatch::kNone ? 0U : 1U;
      } else if (mismatches_++ == 0) {
        first_mismatch_ = fmt::format(
            "code image of frame {}, row {}, column {}: matched line word {} by the {}, {} by the host, "
            "{} expected",
            frame, i / columns, i % columns, lines_[i], engine_->name(), host, expected_[i]);
      }
    }
  }

  int rows_, columns_;
  structured_light::MatchTable table_;
  std::unique_ptr<MatchEngine> engine_;
  std::unique_ptr<MatchEngine> model_;
  structured_light::SelfScanner scanner_;
  std::vector<std::uint16_t> lines_, expected_;
  std::uint64_t matched_ = 0, with_line_ = 0, mismatches_ = 0;
  std::string first_mismatch_;
};

// A symmetric scale over 99 % of the values, so that wrong matches do not set it.
report::MapScale scale_of(const images::FloatImage& difference) {
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
  return {report::ColourMap::diverging, -most, most};
}

class SelfProjectedCosim final : public DepthCosim {
 public:
  // `drawn` are the self-projected patterns of the reference, and `patterns` is their light.
  SelfProjectedCosim(const CosimOptions& options, const SceneInfo& info, DepthCosimSetup setup,
                     const structured_light::SelfReference& reference, const std::vector<images::Image>& drawn,
                     PatternSet patterns, int cells_below)
      : DepthCosim(options, info, std::move(setup), Median::off, std::move(patterns)),
        cells_below_(cells_below),
        matching_(options, rig(), reference, cells_below) {
    page().pictures.push_back({"Finest self-projected pattern", images::encode_png(drawn[drawn.size() - 2]), ""});
  }

  void compare(CosimResult& result) const override {
    DepthCosim::compare(result);
    if (matching_.mismatches() != 0) {
      result.mismatch(matching_.first_mismatch());
      result.mismatches += matching_.mismatches() - 1;
    }
  }

  [[nodiscard]] std::vector<report::Fact> counters(const CosimResult& result) const override {
    return {{"depth_images", "depth images", static_cast<std::int64_t>(images())},
            {"matched_codes", "codes equal to the model's", static_cast<std::int64_t>(result.codes)},
            {"matched_lines", "matched lines equal to the model's", static_cast<std::int64_t>(matching_.matched())},
            {"with_line", "of these with a line", static_cast<std::int64_t>(matching_.with_line())},
            {"incomplete", "incomplete code images", static_cast<std::int64_t>(incomplete())}};
  }

  [[nodiscard]] std::vector<report::Fact> settings() const override {
    std::vector<report::Fact> facts = scene_facts("reference");
    facts.push_back({"e", "e, cells below the reference", std::int64_t{cells_below_}});
    facts.push_back({"threshold", "threshold", std::int64_t{rig().measure.code_threshold}});
    return facts;
  }

  [[nodiscard]] std::vector<report::Fact> findings() const override { return error_facts(); }

  [[nodiscard]] std::string text() const override { return run_text(method()) + errors_text(); }

  [[nodiscard]] std::string matched(const CosimResult& result) const override {
    return fmt::format("{} codes and {} lines in {} code images and {} columns in {} frames", result.codes,
                       matching_.matched(), images(), result.columns, result.frames);
  }

 private:
  [[nodiscard]] std::string method() const {
    return fmt::format("self-projected, {} bits, e = {}", bits(), cells_below_);
  }

  void add_codes(const std::uint16_t* codes) override { matching_.add_codes(codes, newest_frame()); }
  [[nodiscard]] const structured_light::Triangulation& triangulation() const override {
    return matching_.scanner().triangulation();
  }
  [[nodiscard]] const images::FloatImage& depth() const override { return matching_.scanner().depth(); }
  [[nodiscard]] const images::FloatImage& difference() const { return matching_.scanner().difference(); }

  void followed() override {
    in_light_ += static_cast<double>(
        std::count_if(truth().values.begin(), truth().values.end(), [](float value) { return !std::isnan(value); }));
  }

  [[nodiscard]] ShownMap shown_map(const std::string& when) const override {
    const rig::RigCamera& camera = rig().camera;
    const double pixel = rig().plane_z_mm * camera.pixel_pitch_mm / camera.focal_length_mm;
    return {.file = "difference",
            .title = "Difference from the reference",
            .png = report::labelled_map_png(difference(), scale_of(difference()), {pixel, pixel},
                                            "difference from the reference, " + when + ", mm"),
            .note = "mm, positive towards the camera",
            .values = difference()};
  }

  void complete_page(report::ReportPage& page) override {
    page.subtitle = subtitle(method());
    page.highlights = error_facts();
    page.highlights.push_back({"valid", "pixels in the light with a depth", 100 * (errors().seen() / in_light_), "%"});
  }

  void write_maps(files::OutputFolder& folder) const override {
    folder.append("difference.tiff", images::encode_float_tiff("difference.tiff", difference()));
    folder.append("truth.tiff", images::encode_float_tiff("truth.tiff", truth()));
  }

  int cells_below_;  // e of (4.20)
  Matching matching_;
  double in_light_ = 0;  // pixels in the light, over all depth images
};

}  // namespace

std::unique_ptr<CosimMeasurement> make_self_projected_cosim(const CosimOptions& options, const SceneInfo& scene) {
  const int cells_below = options.e.value_or(scene.cells_below);
  DepthCosimSetup setup = depth_cosim_setup(options, scene, bits_of(options, cells_below));
  const rig::Rig& rig = setup.rig;
  const std::unique_ptr<Scene> reference_scene = find_scene(scene.reference_name()).make(rig);
  structured_light::Stripes stripes;
  stripes.bits = setup.bits;
  const structured_light::SelfReference reference = structured_light::make_self_reference(
      rig, scan_points(rig, *reference_scene, options.render(), ScanMethod::gray_codes, [] {}), stripes);
  std::vector<images::Image> drawn;
  for (int i = 0; i < 2 * setup.bits; ++i) {
    drawn.push_back(pattern_image(structured_light::self_projected_pattern(reference, i)));
  }
  PatternSet patterns(rig, drawn, options.render());
  return std::make_unique<SelfProjectedCosim>(options, scene, std::move(setup), reference, drawn, std::move(patterns),
                                              cells_below);
}

}  // namespace selfproj::sim
