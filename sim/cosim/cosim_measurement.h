// The part of a co-simulation that depends on the method of measuring.
#ifndef SELFPROJ_SIM_COSIM_COSIM_MEASUREMENT_H
#define SELFPROJ_SIM_COSIM_COSIM_MEASUREMENT_H

#include <cstddef>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/report/report.h"
#include "model/packet.h"
#include "sim/cosim/cosim_result.h"
#include "sim/cosim/frame_source.h"
#include "sim/platform/platform.h"

namespace selfproj {

// The runner's contribution to a measurement's page.
struct CosimFacts {
  std::string title;
  std::vector<Fact> counters;
  std::vector<Fact> settings;
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
  virtual void frame(std::size_t frame, const Image& image) = 0;

  // Called with each packet of the driver, which is valid during the call.
  virtual void packet(const PacketView& packet, OutputFolder* folder) = 0;

  // Called after the last packet: adds to the result what this measurement compared and what did not match.
  virtual void judge(CosimResult& /*result*/) const {}

  // Its own counters, shown before those of board and driver; and its settings.
  [[nodiscard]] virtual std::vector<Fact> counters(const CosimResult& /*result*/) const { return {}; }
  [[nodiscard]] virtual std::vector<Fact> settings() const = 0;

  // The findings, if there is a truth to compare with.
  [[nodiscard]] virtual std::vector<Fact> findings() const { return {}; }

  // Writes tables, pictures and page. Does not commit the folder.
  virtual void write(OutputFolder& folder, const CosimFacts& facts) = 0;

  // Complete lines for the terminal: what ran and what was found.
  [[nodiscard]] virtual std::string text() const = 0;

  // The amount that was equal, such as "716800 columns in 1400 frames".
  [[nodiscard]] virtual std::string matched(const CosimResult& result) const = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_COSIM_MEASUREMENT_H
