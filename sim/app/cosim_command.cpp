#include "sim/app/cosim_command.h"

#include <CLI/CLI.hpp>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "host/io/frame_options.h"
#include "host/structured_light/stripe_code.h"
#include "model/gray_decoder.h"
#include "sim/experiment/cosim.h"
#include "sim/experiment/cosim_options.h"
#include "sim/scene/renderer.h"

namespace selfproj {

void add_cosim_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "cosim", "Frames through camera, board and driver to profiles; every packet compared with the model");
  const auto options = std::make_shared<CosimOptions>();
  CLI::Option* scene = command->add_option("--scene", options->scene, "Scene under the simulated camera (scene list)")
                           ->type_name("NAME")
                           ->capture_default_str();
  CLI::Option* frames =
      command
          ->add_option("--frames", options->frames, "Recorded images instead: files, or patterns such as 'run/*.png'")
          ->type_name("PATTERN")
          ->excludes(scene);
  command
      ->add_option("--background", options->background,
                   "The same views without the line, one for each frame, to be subtracted before the board sees them")
      ->type_name("PATTERN")
      ->needs(frames);
  command->add_option("--engine", options->engine, "What computes: the board's RTL, the HLS kernel, the model")
      ->check(CLI::IsMember(std::vector<std::string>{"rtl", "hls", "model"}))
      ->capture_default_str();
  command
      ->add_option("--rig", options->rig,
                   "Built-in rig or its YAML file (scenes: light-section, or scanner; recorded images: none, so that "
                   "only moments "
                   "and centroids come out)")
      ->type_name("RIG");
  command->add_flag("--residual", options->residual,
                    "Measure the reference part once with its own pattern, keep each column's offset and remove it");
  command
      ->add_option("--real-rig", options->real_rig,
                   "Rig that takes the images, where it is not quite what --rig says (an error of calibration)")
      ->type_name("RIG");
  command->add_option("--channel", options->channel, "What to take of colour images")
      ->check(CLI::IsMember(channel_names()));
  command
      ->add_option("--mode", options->mode,
                   "A lit pixel weighs 1 (binary), its value (grey), its value - T (grey-over) [the rig's]")
      ->check(CLI::IsMember(mode_names()));
  command
      ->add_option("--threshold", options->threshold,
                   "A pixel is lit where it is greater than this; a scanner's pair is ambiguous where it differs "
                   "by no more [the rig's]")
      ->check(CLI::Range(0, 255))
      ->type_name("T");
  command->add_option("--seed", options->seed, "Of all that is random [the rig's]")->type_name("N");
  std::vector<std::string> names;
  for (const auto& [name, flag] : kDisturbances) {
    if (flag != &RenderOptions::quantization) {  // the board takes 8 bits
      names.emplace_back(name);
    }
  }
  command->add_option("--without", options->without, "Leaves these out of the simulated camera's image, comma between")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  command->add_option("--first", options->first, "Frame to begin with")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30U))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--count", options->count, "Frames [all]")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30U))
      ->type_name("N");
  command->add_option("--bus-stall", options->bus_stall, "Share of the bus's clocks in which it takes nothing, percent")
      ->check(CLI::Range(0, 95))
      ->type_name("PERCENT")
      ->capture_default_str();
  command->add_option("--out", options->out, "Folder for tables, cloud, images, report; without it only the comparison")
      ->type_name("DIR");
  command
      ->add_option("--picture-frame", options->pictures,
                   "Frames of this run, from 1, to show as frame_K.png with the line found [the middle one; of "
                   "recorded images the first ten]")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30U))
      ->type_name("K");
  command->add_option("--packets", options->packets, "Keeps the stream of packets, for selfproj-sim board --replay")
      ->type_name("FILE");
  command
      ->add_option("--bits", options->bits,
                   "With a scanner's scene: bits of the Gray code [8; 4 where it is self-projected]")
      ->check(CLI::Range(1, GrayDecoder::kMaxBits))
      ->type_name("M");
  command->add_flag("--no-median", options->no_median, "With a scanner's scene: codes without the 3 x 3 median");
  command
      ->add_option("--min-difference", options->min_difference,
                   "With a scanner's scene: from the background, mm, of what counts as moved [10]")
      ->check(CLI::Range(0.0, 1000.0))
      ->type_name("MM");
  command
      ->add_option("--max-change", options->max_change,
                   "With a scanner's scene: from one depth image to the next, mm, of what counts as moved [10]")
      ->check(CLI::Range(0.0, 1000.0))
      ->type_name("MM");
  command
      ->add_option(
          "--min-neighbours", options->min_neighbours,
          "With a scanner's scene: of the 8 pixels around, moved and as near in z, for what counts as moved [6]")
      ->check(CLI::Range(0, 8))
      ->type_name("N");
  command
      ->add_option("--e", options->e,
                   "With a scene of self-projected structured light: cells below the reference that are searched [8 of "
                   "the cuboids, else 0]")
      ->check(CLI::Range(0, (1 << Stripes::kMaxBits) - 1))
      ->type_name("CELLS");
  CLI::Option* trace =
      command->add_option("--trace", options->trace, "Waveforms of the board (engine rtl)")->type_name("FILE.fst");
  command->add_option("--trace-from", options->trace_from, "... from this frame of this run on, from 1")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30U))
      ->type_name("F")
      ->needs(trace)
      ->capture_default_str();
  command->callback([options] { run_cosim(*options); });
}

}  // namespace selfproj
