// The options of a co-simulation.
#ifndef SELFPROJ_SIM_COSIM_COSIM_OPTIONS_H
#define SELFPROJ_SIM_COSIM_COSIM_OPTIONS_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/command_line.h"
#include "host/images/prepared_images.h"
#include "sim/platform/platform.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scenes.h"
#include "sim/scene/world.h"

namespace selfproj::sim {

struct CosimOptions {
  std::string scene = "stairs-marked";
  std::vector<std::string> frames = {};    // files or patterns of recorded images; empty: use the scene
  images::Preparation preparation = {};    // how recorded images become frames; `background` has patterns
  std::string engine = "rtl";              // rtl, hls or model
  std::string rig = {};                    // empty: the scene's own; none for recorded images
  std::optional<int> threshold = {};       // for lit pixels, or for codes (4.15); nothing: the rig's
  std::optional<std::int64_t> seed = {};   // nothing: the rig's
  std::vector<std::string> without = {};   // names of RenderOptions to switch off
  World world = {};                        // disturbances of the images
  std::size_t first = 1;                   // first frame
  std::optional<std::size_t> count = {};   // number of frames; nothing: all
  int bus_stall = 0;                       // percent of the bus's clocks in which it is not ready
  std::string out = {};                    // folder; empty: only compare
  std::vector<std::size_t> pictures = {};  // frames of the run to show, from 1; empty: a choice
  std::string packets = {};                // file for the stream of packets; empty: none
  std::string vectors = {};                // folder for the vectors (vector_files.h); empty: none

  // For method light_section:
  std::string perturbed_rig = {};  // the rig that takes the images; empty: `rig`
  bool residual = false;           // measure the reference's own residual and remove it
  std::string mode = {};           // empty: the rig's
  cli::SelectOptions select = {};  // nothing: the rig's
  bool compact = false;            // compact packets, also where the rig does not say so
  std::string verdict = {};        // table by which the board judges; empty: it does not
  bool verdict_alone = false;      // its packets have nothing but the verdict
  std::string trace = {};          // FST file of waveforms; empty: none
  std::size_t trace_from = 1;

  // For methods gray_codes and self_projected:
  std::optional<int> bits = {};
  bool no_median = false;
  std::optional<double> min_difference = {};  // mm
  std::optional<float> max_change = {};       // mm
  std::optional<int> min_neighbours = {};
  std::optional<int> e = {};  // e of (4.20)

  // How the images of a scene are rendered.
  [[nodiscard]] RenderOptions render() const {
    RenderOptions result = options_without(without);
    result.world = world;
    return result;
  }

  // The scene or the recorded images, in words.
  [[nodiscard]] std::string what() const { return frames.empty() ? "scene " + scene : "recorded images"; }
};

// Number of frames in the run, from options.first on, if `what` has `total`. A scene of one frame stands still; the run
// then has `still_frames` of it, or options.count. Throws UserError about --first or --count.
std::size_t frames_of_run(const CosimOptions& options, std::size_t total, const std::string& what,
                          std::size_t still_frames = 1);

// The engine by its name. Throws UserError if it is not part of this build.
PlatformEngine engine_of(const CosimOptions& options);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_COSIM_COSIM_OPTIONS_H
