#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/command_line.h"
#include "host/images/frame_options.h"
#include "host/structured_light/self_reference.h"
#include "selfproj/model/gray_decoder.h"
#include "sim/app/commands.h"
#include "sim/cosim/cosim.h"
#include "sim/cosim/render_options.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

constexpr std::int64_t kLastFrame = std::int64_t{1} << 30U;

// Which options go with what is measured.
constexpr const char* kRecorded = "recorded images";
constexpr const char* kSection = "light section";
constexpr const char* kGrayCodes = "Gray codes";
constexpr const char* kSelfProjected = "self-projected codes";

std::string case_of(const CosimOptions& options) {
  if (!options.frames.empty()) {
    return kRecorded;
  }
  switch (find_scene(options.scene).method) {
    case SceneMethod::gray_codes:
      return kGrayCodes;
    case SceneMethod::self_projected:
      return kSelfProjected;
    case SceneMethod::light_section:
      break;
  }
  return kSection;
}

void add_source_options(CLI::App& command, OptionFamilies& families, CosimOptions& options, WorldOptions& world) {
  cli::begin_group(command, "Source of the frames");
  CLI::Option* scene =
      command.add_option("--scene", options.scene, "Scene under the simulated camera, of `selfproj-sim scene list`.")
          ->type_name("NAME")
          ->capture_default_str();
  cli::add_files(command, "--frames", options.frames,
                 "Recorded images instead: files, or quoted patterns such as 'run/*.png'.")
      ->type_name("PATTERN")
      ->excludes(scene);
  command.add_option("--first", options.first, "First frame of them, from 1.")
      ->transform(cli::whole_number(1, kLastFrame))
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--count", options.count, "Number of frames.")
      ->transform(cli::whole_number(1, kLastFrame))
      ->type_name("N")
      ->default_str("all");
  families.begin("Recorded images (--frames)", {kRecorded});
  cli::add_files(
      command, "--background", options.preparation.background,
      "The same view without the line: one image for all frames, or one for each. It is subtracted before the board "
      "sees the frames.")
      ->type_name("PATTERN");
  cli::add_preparation_options(command, options.preparation);
  families.begin("Scenes (--scene)", {kSection, kGrayCodes, kSelfProjected});
  add_error_source_option(command, "--without", options.without,
                          "Sources of error to leave out of the images, with commas between them.", true);
  add_world_options(command, world);
}

void add_measuring_options(CLI::App& command, OptionFamilies& families, CosimOptions& options) {
  cli::begin_group(command, "Measuring");
  command
      .add_option("--engine", options.engine,
                  "Implementation that computes: the board's RTL, the same with the HLS circuits in place of its own, "
                  "or the model.")
      ->check(cli::one_of({"rtl", "hls", "model"}))
      ->type_name("ENGINE")
      ->capture_default_str();
  command
      .add_option("--rig", options.rig,
                  "Built-in rig or YAML file. Recorded images need one for profiles; without it only moments and "
                  "centroids come out.")
      ->type_name("RIG")
      ->default_str("the scene's");
  command
      .add_option(
          "--threshold", options.threshold,
          "A pixel is lit where its grey value is greater than T. With a scanner, a pair of images that differs "
          "by at most T is ambiguous.")
      ->transform(cli::whole_number(0, 4095))
      ->type_name("T")
      ->default_str("the rig's");
  command
      .add_option("--bus-stall", options.bus_stall,
                  "Share of the bus clocks in which the bus takes nothing, in percent.")
      ->transform(cli::whole_number(0, 95))
      ->type_name("PERCENT")
      ->capture_default_str();
  command.add_option("--seed", options.seed, "Seed of everything random.")
      ->transform(cli::whole_number(0))
      ->type_name("N")
      ->default_str("the rig's");
  families.begin("Light section (scenes of rig light-section, and recorded images)", {kSection, kRecorded});
  command
      .add_option("--mode", options.mode,
                  "Weight of a lit pixel: 1 (binary), its grey value (grey), or its grey value less T (grey-over).")
      ->check(cli::one_of(images::mode_names()))
      ->type_name("MODE")
      ->default_str("the rig's");
  cli::add_select_options(command, options.select, cli::kRigsSelect);
  command.add_flag("--compact", options.compact,
                   "Packets of kind compact: the board divides the columns (modes grey and grey-over; else as the rig "
                   "says).");
  CLI::Option* const verdict =
      command
          .add_option(
              "--verdict", options.verdict,
              "The board judges frames by this table, which `selfproj verdict table` writes, and its packets say "
              "what it found (engines rtl and model).")
          ->type_name("FILE");
  command.add_flag("--verdict-alone", options.verdict_alone, "Packets have the verdict, and no columns.")
      ->needs(verdict);
  CLI::Option* trace =
      command.add_option("--trace", options.trace, "File for the waveforms of the board (engine rtl).")
          ->type_name("FILE.fst");
  command.add_option("--trace-from", options.trace_from, "First frame of this run, from 1, in the waveforms.")
      ->transform(cli::whole_number(1, kLastFrame))
      ->type_name("F")
      ->needs(trace)
      ->capture_default_str();
  families.begin("Scenes of a light section", {kSection});
  command.add_flag("--residual", options.residual,
                   "Measure the good part once under its own pattern, and subtract each column's offset.");
  accept_old_name(command, "--real-rig",
                  command
                      .add_option("--perturbed-rig", options.perturbed_rig,
                                  "Rig that takes the images where it differs from --rig, as an error of calibration.")
                      ->type_name("RIG")
                      ->default_str("--rig"));
}

void add_scanner_options(CLI::App& command, OptionFamilies& families, CosimOptions& options) {
  families.begin("Scenes of a scanner", {kGrayCodes, kSelfProjected});
  command.add_option("--bits", options.bits, "Bits of the Gray code.")
      ->transform(cli::whole_number(1, model::GrayDecoder::kMaxBits))
      ->type_name("M")
      ->default_str("8; 4 where self-projected");
  families.begin("Scenes of a scanner under Gray codes: codes, and what is foreground", {kGrayCodes});
  command.add_flag("--no-median", options.no_median, "Decode without the 3 x 3 median.");
  command
      .add_option("--min-difference", options.min_difference,
                  "A pixel is foreground only if it differs from the background by more than this many mm.")
      ->transform(cli::real_number(0, 1000))
      ->type_name("MM")
      ->default_str("10");
  command
      .add_option("--max-change", options.max_change,
                  "A pixel is foreground only if its depth changed by at most this many mm since the last depth image.")
      ->transform(cli::real_number(0, 1000))
      ->type_name("MM")
      ->default_str("10");
  command
      .add_option(
          "--min-neighbours", options.min_neighbours,
          "A pixel is foreground only if at least this many of the 8 pixels around it are, too, and are as close in "
          "z.")
      ->transform(cli::whole_number(0, 8))
      ->type_name("N")
      ->default_str("6");
  families.begin("Scenes of a scanner under self-projected codes", {kSelfProjected});
  command.add_option("--e", options.e, "Codes that are searched below the reference.")
      ->transform(cli::whole_number(0, (1 << structured_light::Stripes::kMaxBits) - 1))
      ->type_name("E")
      ->default_str("8 for the cuboids, else 0");
}

void add_output_options(CLI::App& command, CosimOptions& options) {
  cli::begin_group(command, "Output");
  command
      .add_option("--out", options.out,
                  "Folder for tables, cloud, images and report. Without it the packets are only compared.")
      ->type_name("DIR");
  command
      .add_option("--picture-frame", options.pictures,
                  "Frames of this run, from 1, to save as frame_K.png with the line found. With a scanner they must "
                  "complete a code image.")
      ->transform(cli::whole_number(1, kLastFrame))
      ->type_name("K")
      ->default_str("the middle one; of recorded images the first ten; with a scanner four");
  command
      .add_option(
          "--packets", options.packets,
          "File for the stream of packets, as a device delivers it. The reference of a light section, under whose "
          "pattern the frames are taken, is written beside it as FILE.reference.csv.")
      ->type_name("FILE");
  command
      .add_option(
          "--vectors", options.vectors,
          "Folder for what goes into the board and comes out of it, as hexadecimal words for benches in Verilog "
          "and VHDL.")
      ->type_name("DIR");
}

}  // namespace

void add_cosim_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "cosim",
       .purpose =
           "Sends frames through camera, board and driver to profiles, and compares every packet with the model.",
       .details =
           "Camera, conveyor, board and bus run in SystemC with their real timing; the driver is the one of the real "
           "board. The pattern is computed from the scene's good part, so that its line is straight where the part "
           "is as it should be. The last line says what was compared; the exit status is 1 where a packet "
           "differs.\n\n"
           "With a scene of a scanner the projector shows Gray codes, and the board decodes them. From frame 2M on, "
           "every second frame completes a depth image. A cycle of frames of the scene's background is decoded "
           "beforehand.\n\n"
           "Recorded images have one size, and pixels of 8 bits or of the rig's. With --rig they are measured from the "
           "straight line on the plane. `selfproj lines` shows the line in recorded images without a simulated board.",
       .examples = R"(
# 20 frames of the marked stairs, with all results in the folder part.
selfproj-sim cosim --count 20 --out part

# Recorded images, by the model, with the packets kept.
selfproj-sim scene render stairs --count 4 --out frames
selfproj-sim cosim --frames 'frames/*.png' --threshold 60 --engine model --packets seen.packets

# Waveforms of the board from the second frame on.
selfproj-sim cosim --scene mountain --count 2 --trace board.fst --trace-from 2

# A fist before a scanner, two turns (takes minutes)
selfproj-sim cosim --scene fist --count 588 --out fist
)"});
  const auto options = std::make_shared<CosimOptions>();
  const auto world = std::make_shared<WorldOptions>();
  OptionFamilies families(*command);
  add_source_options(*command, families, *options, *world);
  add_measuring_options(*command, families, *options);
  add_scanner_options(*command, families, *options);
  add_output_options(*command, *options);
  command->callback([options, world, families] {
    families.check(case_of(*options), options->what());
    options->world = world->world();
    run_cosim(*options);
  });
}

}  // namespace selfproj::sim
