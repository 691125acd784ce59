// Frames through the platform, packets through the driver, every packet compared with the model's.
#ifndef SELFPROJ_SIM_APP_COSIM_RUN_H
#define SELFPROJ_SIM_APP_COSIM_RUN_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "host/driver/counters.h"
#include "model/column_moments.h"
#include "model/packet.h"
#include "sim/app/frame_source.h"
#include "sim/platform/platform.h"

namespace selfproj {

struct CosimCallbacks {
  // Each frame as the source shows it (FrameSource::picture), from 0.
  std::function<void(std::size_t frame, const Image& image)> frame;
  // Each packet as the driver gives it: its bytes, and what is in it; valid during the call.
  std::function<void(std::span<const std::uint8_t> bytes, const PacketView& packet)> packet;
};

struct CosimResult {
  std::uint64_t columns = 0;     // whose moments matched
  std::uint64_t codes = 0;       // pixels whose code matched
  std::uint64_t frames = 0;      // whose packets of moments matched
  std::uint64_t mismatches = 0;  // packets that did not match, counters that disagree
  std::uint64_t lost = 0;        // packets lost on the board, all of them counted by it
  std::string first_mismatch;
  PlatformReport platform;
  Counters driver;
};

// Runs all frames of the source, whose size is that of the options' settings. Throws what the source and the callbacks
// throw.
CosimResult run_cosim(const PlatformOptions& options, FrameSource& frames, const CosimCallbacks& callbacks);

// "matched 716800 columns in 1400 frames, 0 mismatches"
std::string outcome_text(const CosimResult& result);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_COSIM_RUN_H
