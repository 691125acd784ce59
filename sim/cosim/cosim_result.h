// The outcome of a co-simulation: what ran, and what was equal.
#ifndef SELFPROJ_SIM_COSIM_COSIM_RESULT_H
#define SELFPROJ_SIM_COSIM_COSIM_RESULT_H

#include <cstdint>
#include <string>

#include "host/driver/counters.h"
#include "sim/platform/platform.h"

namespace selfproj {

struct CosimResult {
  std::uint64_t columns = 0;     // columns whose moments matched
  std::uint64_t codes = 0;       // pixels whose code matched
  std::uint64_t frames = 0;      // frames whose packets of moments matched
  std::uint64_t mismatches = 0;  // packets that did not match, and counters that disagree
  std::uint64_t lost = 0;        // expected packets that did not arrive
  std::string first_mismatch;
  PlatformReport platform;
  Counters driver;

  // Counts a mismatch, and keeps its description if it is the first.
  void mismatch(const std::string& what) {
    if (mismatches++ == 0) {
      first_mismatch = what;
    }
  }
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_COSIM_COSIM_RESULT_H
