// Compares depth images of a scene with the true depths.
#ifndef SELFPROJ_SIM_COSIM_DEPTH_COSIM_H
#define SELFPROJ_SIM_COSIM_DEPTH_COSIM_H

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/report/report.h"
#include "selfproj/driver/image_assembler.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/foreground.h"
#include "selfproj/structured_light/triangulation.h"
#include "sim/cosim/cosim_measurement.h"
#include "sim/cosim/cosim_options.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {

// Over the pixels of all images with both a measured and a true depth; NaN if there were none.
class DepthErrors {
 public:
  // Adds images of one size, mm.
  void add(const images::FloatImage& depth, const images::FloatImage& truth) {
    constexpr double kFar = 15;  // mm: a larger error comes from a wrong code or match, not from quantization
    for (std::size_t i = 0; i < truth.values.size(); ++i) {
      const auto error = static_cast<double>(depth.values[i] - truth.values[i]);
      if (std::isnan(error)) {
        continue;
      }
      ++seen_;
      if (std::abs(error) > kFar) {
        ++far_off_;
      } else {
        ++near_;
        squares_ += error * error;
      }
    }
  }

  [[nodiscard]] double seen() const { return seen_; }
  // RMS error in mm of the pixels that are no more than 15 mm off.
  [[nodiscard]] double rms() const { return near_ > 0 ? std::sqrt(squares_ / near_) : kNone; }
  // Share of the other pixels, 0..1.
  [[nodiscard]] double far_off() const { return seen_ > 0 ? far_off_ / seen_ : kNone; }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double seen_ = 0, near_ = 0, far_off_ = 0, squares_ = 0;
};

// The motion in the depth images of a scene as facts, plots and a table, compared with the truth.

// A measurement from one depth image, and the same from the true depths; lengths in mm, NaN if there is none.
struct DepthSample {
  std::size_t frame = 0;  // frame of this run, from 1, that completed the code image
  double t = 0;           // time in s of the frame in the middle of the code's cycle
  structured_light::Foreground moved, true_moved;
  double front = std::numeric_limits<double>::quiet_NaN();  // SceneAnalysis::wave_front
  double true_front = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> z, true_z;  // SceneAnalysis::key_taps: z at the pixels of the keys, of what moved
};

struct DepthFindings {
  std::vector<report::Fact> facts;
  std::vector<report::ReportPlot> plots;
  std::string table_name;
  std::string table;  // CSV
};

DepthFindings findings_of(SceneAnalysis analysis, const std::vector<DepthSample>& samples);

// The common part of co-simulations of structured light: the rig, the frames of the patterns, the pictures of depth
// images, and the page.

// Values that are known before the patterns: the scanner with the options' seed and threshold, its scene, and the
// length of the run.
struct DepthCosimSetup {
  rig::Rig rig;
  std::unique_ptr<Scene> scene;
  int bits = 8;  // bits of the codes
  std::size_t frames = 0;
};

// Throws UserError about the rig and the options of the run.
DepthCosimSetup depth_cosim_setup(const CosimOptions& options, const SceneInfo& info, int bits);

class DepthCosim : public CosimMeasurement {
 public:
  FrameSource& source() override { return source_; }
  [[nodiscard]] PlatformOptions platform() const override;

  // Chooses among the frames that complete code images, which are number 2 bits and every second one after it: those
  // that the user asked for, or else four.
  void choose_pictures() override;
  void frame(std::size_t frame, const images::Image& image) override;
  void packet(const model::PacketView& packet, files::OutputFolder* folder) override;
  void compare(CosimResult& result) const override;
  void write(files::OutputFolder& folder, const CosimFacts& facts) override;

 protected:
  enum class Median : std::uint8_t { off, on };  // of the board's codes

  // A second map to show beside depth: its title, and the name for its file.
  struct ShownMap {
    std::string file;   // "moved"
    std::string title;  // "What moved"
    std::string png;
    std::string note;                // printed below it
    images::FloatImage values = {};  // written as TIFF if there are any
  };

  // The camera sees the scene under `patterns`, two for each bit. `options` and `info` must outlive this object.
  DepthCosim(const CosimOptions& options, const SceneInfo& info, DepthCosimSetup setup, Median median,
             PatternSet patterns);

  [[nodiscard]] const CosimOptions& options() const { return options_; }
  [[nodiscard]] const SceneInfo& info() const { return info_; }
  [[nodiscard]] const rig::Rig& rig() const { return setup_.rig; }
  [[nodiscard]] int bits() const { return setup_.bits; }
  [[nodiscard]] Median median() const { return median_; }
  [[nodiscard]] std::size_t frames() const { return setup_.frames; }
  [[nodiscard]] const PatternRenderer& renderer() const { return renderer_; }
  [[nodiscard]] report::ReportPage& page() { return page_; }
  [[nodiscard]] std::size_t images() const { return images_; }
  [[nodiscard]] std::uint64_t incomplete() const { return assembler_.incomplete(); }
  [[nodiscard]] const images::FloatImage& truth() const { return truth_; }  // truth for the newest depth image, mm
  [[nodiscard]] const DepthErrors& errors() const { return errors_; }

  // For the newest code image: the frame of the run, from 1, that completed it, and the scene's frame, from 0, in the
  // middle of those from which it was made.
  [[nodiscard]] std::size_t newest_frame() const { return static_cast<std::size_t>(assembler_.header().sequence) + 1; }
  [[nodiscard]] int middle_frame() const { return static_cast<int>(options_.first + newest_frame()) - 2 - setup_.bits; }
  // The line that says what ran, and the page's subtitle; `method` says how codes are made.
  [[nodiscard]] std::string run_text(const std::string& method) const;
  [[nodiscard]] std::string subtitle(const std::string& method, const std::string& filter = "") const;
  // Such as "depth: 1.71 mm RMS from the truth, 0.50 % of the pixels more than 15 mm off\n".
  [[nodiscard]] std::string errors_text() const;
  // The same as highlights of the page.
  [[nodiscard]] std::vector<report::Fact> error_facts() const;
  // The settings common to all methods; those of the scene come first.
  [[nodiscard]] std::vector<report::Fact> scene_facts(const char* reference_label) const;

  // Makes a depth image from the newest code image, given row by row.
  virtual void add_codes(const std::uint16_t* codes) = 0;
  // Called when the newest depth image has its truth.
  virtual void followed() {}
  [[nodiscard]] virtual const structured_light::Triangulation& triangulation() const = 0;
  [[nodiscard]] virtual const images::FloatImage& depth() const = 0;
  // The second map of the newest depth image; `when` becomes part of its title.
  [[nodiscard]] virtual ShownMap shown_map(const std::string& when) const = 0;
  // Adds to the page its subtitle, highlights and plots, and the files beside depth.tiff and cloud.ply.
  virtual void complete_page(report::ReportPage& page) = 0;
  virtual void write_maps(files::OutputFolder& folder) const = 0;

 private:
  void show(files::OutputFolder& folder);

  const CosimOptions& options_;
  const SceneInfo& info_;
  DepthCosimSetup setup_;
  Median median_;
  PatternSet patterns_;
  PatternRenderer renderer_;
  SceneFrames source_;
  driver::ImageAssembler assembler_;
  images::FloatImage truth_;
  DepthErrors errors_;
  std::size_t images_ = 0;
  std::vector<std::size_t> pictures_;            // frames to show, from 1
  std::map<std::size_t, images::Image> camera_;  // by frame
  report::ReportPage page_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_COSIM_DEPTH_COSIM_H
