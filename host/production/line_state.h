// What the outputs of a running line tell of it.
#ifndef SELFPROJ_HOST_PRODUCTION_LINE_STATE_H
#define SELFPROJ_HOST_PRODUCTION_LINE_STATE_H

#include <array>
#include <cstdint>

#include "host/production/part_result.h"

namespace selfproj {

// Counts of parts, and the last one.
struct LineState {
  std::array<std::uint64_t, 3> verdicts{};  // by Verdict
  std::uint64_t specks = 0;
  std::uint64_t last_part = 0;  // its number; 0: none yet
  Verdict last_verdict = Verdict::cannot_tell;
  std::uint64_t last_defects = 0;
  double last_depth_mm = 0;  // of its largest defect
  std::int64_t last_delay_ns = 0;
  std::int64_t last_ns = 0;  // when its result was there, steady clock

  [[nodiscard]] std::uint64_t parts() const { return verdicts[0] + verdicts[1] + verdicts[2]; }
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_LINE_STATE_H
