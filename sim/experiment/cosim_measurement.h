// What a co-simulation measures: the part of it that depends on the method.
#ifndef SELFPROJ_SIM_EXPERIMENT_COSIM_MEASUREMENT_H
#define SELFPROJ_SIM_EXPERIMENT_COSIM_MEASUREMENT_H

#include <cstddef>
#include <string>
#include <vector>

#include "host/io/image_files.h"
#include "host/io/output_folder.h"
#include "host/report/report.h"
#include "model/packet.h"
#include "sim/experiment/cosim_result.h"
#include "sim/experiment/frame_source.h"
#include "sim/platform/platform.h"

namespace selfproj {

// What the runner adds to a measurement's page.
struct CosimFacts {
  std::string title;
  std::vector<Fact> counters;
  std::vector<Fact> settings;
};

// One run of it: frames are asked for, each packet is given back, and at the end the page is written. `folder` is null
// where the user wants only the comparison.
class CosimMeasurement {
 public:
  CosimMeasurement() = default;
  CosimMeasurement(const CosimMeasurement&) = delete;
  CosimMeasurement& operator=(const CosimMeasurement&) = delete;
  virtual ~CosimMeasurement() = default;

  // The frames of the run, of the size in the platform's settings.
  virtual FrameSource& source() = 0;
  [[nodiscard]] virtual PlatformOptions platform() const = 0;

  // Before the first frame: the frames of the run, from 1, that are to be shown. Throws UserError about
  // --picture-frame.
  virtual void choose_pictures() = 0;

  // Each frame as the source shows it, from 0.
  virtual void frame(std::size_t frame, const Image& image) = 0;

  // Each packet of the driver; valid during the call.
  virtual void packet(const PacketView& packet, OutputFolder* folder) = 0;

  // After the last packet: adds to the result what this measurement compared and what did not match.
  virtual void judge(CosimResult& /*result*/) const {}

  // Its own counters, before those of board and driver; its settings.
  [[nodiscard]] virtual std::vector<Fact> counters(const CosimResult& /*result*/) const { return {}; }
  [[nodiscard]] virtual std::vector<Fact> settings() const = 0;

  // What was found, where there is a truth to compare with.
  [[nodiscard]] virtual std::vector<Fact> findings() const { return {}; }

  // Writes tables, pictures and page, without committing the folder.
  virtual void write(OutputFolder& folder, const CosimFacts& facts) = 0;

  // Lines for the terminal, each with its end: what ran and what was found.
  [[nodiscard]] virtual std::string text() const = 0;

  // What was equal: "716800 columns in 1400 frames".
  [[nodiscard]] virtual std::string matched(const CosimResult& result) const = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_COSIM_MEASUREMENT_H
