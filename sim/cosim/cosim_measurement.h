// The outcome of a co-simulation: what ran, and what was equal.
#ifndef SELFPROJ_SIM_COSIM_COSIM_MEASUREMENT_H
#define SELFPROJ_SIM_COSIM_COSIM_MEASUREMENT_H

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/images/prepared_images.h"
#include "host/report/report.h"
#include "selfproj/driver/counters.h"
#include "selfproj/model/packet.h"
#include "sim/cosim/cosim_options.h"
#include "sim/platform/platform.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {

struct CosimResult {
  std::uint64_t columns = 0;     // columns whose moments matched
  std::uint64_t codes = 0;       // pixels whose code matched
  std::uint64_t frames = 0;      // frames whose packets of moments, or of verdicts alone, matched
  std::uint64_t mismatches = 0;  // packets that did not match, and counters that disagree
  std::uint64_t lost = 0;        // expected packets that did not arrive
  std::string first_mismatch;
  PlatformReport platform;
  driver::Counters driver;

  // Counts a mismatch, and keeps its description if it is the first.
  void mismatch(const std::string& what) {
    if (mismatches++ == 0) {
      first_mismatch = what;
    }
  }
};

// The frames of a co-simulation: a scene in front of the simulated camera, or recorded images.
class FrameSource {
 public:
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;
  virtual ~FrameSource() = default;

  [[nodiscard]] virtual std::size_t total() const = 0;
  [[nodiscard]] virtual int rows() const = 0;
  [[nodiscard]] virtual int columns() const = 0;

  // The next frame, valid until the next call; null after the last one. Throws UserError about bad input.
  virtual const images::SensorImage* next() = 0;

  // The picture to show for the frame that next() gave last: its upper eight bits, before a background was subtracted.
  [[nodiscard]] virtual images::Image picture() const = 0;
};

// Frames first..first + count - 1 (from 0) of a rendered scene. Several threads render some of them ahead.
class SceneFrames final : public FrameSource {
 public:
  // Renders the image of a frame, of rows x columns; several threads may call it at once.
  using Render = std::function<images::SensorImage(int frame)>;
  SceneFrames(Render render, int rows, int columns, int bits, std::size_t first, std::size_t count);

  [[nodiscard]] std::size_t total() const override { return count_; }
  [[nodiscard]] int rows() const override { return rows_; }
  [[nodiscard]] int columns() const override { return columns_; }
  const images::SensorImage* next() override;
  [[nodiscard]] images::Image picture() const override { return upper_bits(image_, bits_); }

 private:
  Render render_;
  int rows_;
  int columns_;
  int bits_;
  std::size_t first_;
  std::size_t count_;
  std::size_t asked_ = 0;  // frames whose rendering has begun
  std::deque<std::future<images::SensorImage>> ahead_;
  images::SensorImage image_;
};

// Images of one size, padded with dark columns to a size that fits the board.
class RecordedFrames final : public FrameSource {
 public:
  // The images from `first`, from 0, on. Throws UserError as PreparedImages does, and if they do not fit the board.
  RecordedFrames(images::PreparedSensorImages images, int bits, std::size_t first, std::size_t count);

  [[nodiscard]] std::size_t total() const override { return count_; }
  [[nodiscard]] int rows() const override { return images_.rows(); }
  [[nodiscard]] int columns() const override { return columns_; }
  // Columns of the images, without the padding.
  [[nodiscard]] int image_columns() const { return images_.columns(); }
  const images::SensorImage* next() override;
  [[nodiscard]] images::Image picture() const override { return upper_bits(as_taken_, bits_); }

 private:
  images::PreparedSensorImages images_;
  int bits_;
  std::size_t first_;
  std::size_t count_;
  int columns_;
  images::SensorImage as_taken_;
  images::SensorImage image_;
  std::size_t given_ = 0;
};

// The part of a co-simulation that depends on the method of measuring.

// The runner's contribution to a measurement's page.
struct CosimFacts {
  std::string title;
  std::vector<report::Fact> counters;
  std::vector<report::Fact> settings;
};

// One run. The runner asks for frames, hands back each packet, and at the end has the page written. `folder` is null if
// the user wants only the comparison.
class CosimMeasurement {
 public:
  CosimMeasurement() = default;
  CosimMeasurement(const CosimMeasurement&) = delete;
  CosimMeasurement& operator=(const CosimMeasurement&) = delete;
  virtual ~CosimMeasurement() = default;

  // The frames of the run, of the size in the platform's settings.
  virtual FrameSource& source() = 0;
  [[nodiscard]] virtual PlatformOptions platform() const = 0;

  // Called before the first frame: chooses the frames of the run, from 1, that the page shows. Throws UserError about
  // --picture-frame.
  virtual void choose_pictures() = 0;

  // Called with each frame as the source shows it, from 0.
  virtual void frame(std::size_t frame, const images::Image& image) = 0;

  // Called with each packet of the driver, which is valid during the call.
  virtual void packet(const model::PacketView& packet, files::OutputFolder* folder) = 0;

  // Called after the last packet: adds to the result what this measurement compared and what did not match.
  virtual void compare(CosimResult& /*result*/) const {}

  // The text of the reference.csv under whose pattern the frames are taken; empty where there is none.
  [[nodiscard]] virtual std::string reference() const { return {}; }

  // Its own counters, shown before those of board and driver; and its settings.
  [[nodiscard]] virtual std::vector<report::Fact> counters(const CosimResult& /*result*/) const { return {}; }
  [[nodiscard]] virtual std::vector<report::Fact> settings() const = 0;

  // The findings, if there is a truth to compare with.
  [[nodiscard]] virtual std::vector<report::Fact> findings() const { return {}; }

  // Writes tables, pictures and page. Does not commit the folder.
  virtual void write(files::OutputFolder& folder, const CosimFacts& facts) = 0;

  // Complete lines for the terminal: what ran and what was found.
  [[nodiscard]] virtual std::string text() const = 0;

  // The amount that was equal, such as "716800 columns in 1400 frames".
  [[nodiscard]] virtual std::string matched(const CosimResult& result) const = 0;
};

// A co-simulation of a light section: it measures the differential profile of every frame, or only the moments if the
// geometry is unknown.

// For a scene under the simulated camera. The pattern is computed from the scene's reference. Both functions throw
// UserError about bad options or input.
std::unique_ptr<CosimMeasurement> make_light_section_cosim(const CosimOptions& options, const SceneInfo& scene);

// For recorded images. With --rig, profiles are measured from the empty plane under a straight line, which is assumed
// to lie on the middle row where it meets the plane. Without --rig, the result is moments and centroids.
std::unique_ptr<CosimMeasurement> make_recorded_cosim(const CosimOptions& options);

// A co-simulation of Gray codes: it measures depth images, and what moves in them in front of a background.

// For a scene of method gray_codes. Options and scene must outlive the result. Throws UserError about the options.
std::unique_ptr<CosimMeasurement> make_scanner_cosim(const CosimOptions& options, const SceneInfo& scene);

// A co-simulation of self-projected structured light. The scene's reference is scanned by Gray codes, and patterns and
// match table are made from the scan. The board's code images, as the driver gives them, go through the matching block.
// Its lines are compared with model/gray_match and with the host's own for every pixel.

// For a scene of method self_projected. Options and scene must outlive the result. Throws UserError about the options.
std::unique_ptr<CosimMeasurement> make_self_projected_cosim(const CosimOptions& options, const SceneInfo& scene);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_COSIM_COSIM_MEASUREMENT_H
