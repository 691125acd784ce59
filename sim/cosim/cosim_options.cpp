#include "sim/cosim/cosim_options.h"

#include <fmt/format.h>

#include <cstddef>
#include <string>

#include "host/files/user_error.h"
#include "sim/platform/platform.h"
#include "sim/scene/scene_info.h"

namespace selfproj {

void check_options(const CosimOptions& options, SceneMethod method) {
  const bool of_moved = options.min_difference || options.max_change || options.min_neighbours;
  if (method == SceneMethod::light_section) {
    if (options.bits || options.no_median || of_moved || options.e) {
      throw UserError("--bits, --no-median, --min-difference, --max-change, --min-neighbours, --e",
                      "go only with the scenes of a scanner");
    }
    return;
  }
  const auto refuse = [&](bool given, const char* option) {
    if (given) {
      throw UserError(option, fmt::format("does not go with scene {}, which a scanner measures", options.scene));
    }
  };
  refuse(!options.mode.empty(), "--mode");
  refuse(!options.preparation.channel.empty(), "--channel");
  refuse(!options.preparation.roi.empty(), "--roi");
  refuse(options.preparation.transpose, "--transpose");
  refuse(!options.select.select.empty(), "--select");
  refuse(options.select.gap.has_value(), "--gap");
  refuse(!options.select.rows.empty(), "--rows");
  refuse(!options.trace.empty(), "--trace");
  refuse(options.residual, "--residual");
  refuse(!options.real_rig.empty(), "--real-rig");
  const bool self_projected = method == SceneMethod::self_projected;
  if (self_projected && (options.no_median || of_moved)) {
    throw UserError("--no-median, --min-difference, --max-change, --min-neighbours",
                    "do not go with scenes of self-projected structured light");
  }
  if (!self_projected && options.e) {
    throw UserError("--e", "goes only with scenes of self-projected structured light");
  }
}

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

}  // namespace selfproj
