#include "sim/cosim/cosim_options.h"

#include <fmt/format.h>

#include <cstddef>
#include <string>

#include "selfproj/files/user_error.h"
#include "sim/platform/platform.h"

namespace selfproj::sim {

std::size_t frames_of_run(const CosimOptions& options, std::size_t total, const std::string& what,
                          std::size_t still_frames) {
  const bool still = total == 1 && still_frames > 1;
  if (still && (options.first == 1 || options.count)) {
    return options.count.value_or(still_frames);
  }
  if (options.first > total) {
    throw UserError(fmt::format("--first {}", options.first), fmt::format("{} has {} frames", what, total));
  }
  const std::size_t left = total - options.first + 1;
  if (options.count && *options.count > left) {
    throw UserError(fmt::format("--count {}", *options.count),
                    fmt::format("{} has {} frames from frame {} on", what, left, options.first));
  }
  return options.count.value_or(left);
}

PlatformEngine engine_of(const CosimOptions& options) {
  if (options.engine == "model") {
    return PlatformEngine::model;
  }
#ifdef SELFPROJ_HAS_RTL_PLATFORM
  if (options.engine == "rtl") {
    return PlatformEngine::rtl;
  }
  if (options.engine == "hls") {
    return PlatformEngine::hls;
  }
#endif
  throw UserError("--engine " + options.engine, "this engine is not part of this build");
}

}  // namespace selfproj::sim
