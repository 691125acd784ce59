#include "host/app/capture_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "host/app/project_command.h"
#include "host/capture/sequence_capture.h"
#include "host/io/command_line.h"
#include "host/io/image_files.h"
#include "host/io/image_sequence.h"
#include "host/io/output_folder.h"
#include "host/io/progress.h"
#include "host/io/stop_signal.h"
#include "host/io/user_error.h"

namespace selfproj {
namespace {

struct SequenceOptions {
  std::string camera;
  DisplayOptions display;
  std::string patterns;
  std::optional<double> settle_ms;
  std::string out;
};

void print_beginning(const CaptureRecord& record) {
  fmt::print("{}, {} x {} pixels, {}\n", record.camera, record.columns, record.rows,
             record.triggered ? "software trigger" : "running free");
  fmt::print("exposure: {}\n", exposure_text(record.exposure));
  if (record.settle_measured) {
    fmt::print("settle time: {:.1f} ms; the light follows after {:.1f} to {:.1f} ms\n", record.settle.settle_ms,
               record.settle.least_ms, record.settle.most_ms);
  }
  static_cast<void>(std::fflush(stdout));  // before the sequence, on a pipe too
}

void run_sequence(const SequenceOptions& options) {
  OutputFolder out(options.out);
  ImageSequence patterns(files_of_folder(options.patterns), std::nullopt);
  const CaptureSetup setup{.camera = options.camera,
                           .display = options.display.display,
                           .greys = greys_of(options.display),
                           .settle_ms = options.settle_ms};
  const StopSignal stop;
  Progress progress("pattern", patterns.count());
  try {
    const CaptureRecord record =
        capture_sequence(setup, patterns, out, print_beginning, [&](std::size_t done) { progress.update(done); });
    out.commit();
    fmt::print("{} images → {}; taken again: {} incomplete, {} that did not come\n", record.shots.size(), out.name(),
               record.retaken.incomplete, record.retaken.missing);
  } catch (const Stopped& stopped) {
    throw CheckFailed(options.out + ": " + stopped.what());
  }
}

}  // namespace

void add_capture_command(CLI::App& app) {
  CLI::App* command = add_command(
      app,
      {.name = "capture",
       .purpose = "Shows patterns on a projector and takes an image of each.",
       .details =
           "First the projector shows black and white. From these two images the command says which shares of the "
           "pixels are saturated and dark, and how the exposure should change. Then it flashes, and measures how long "
           "after showing a pattern an image shows it, and how much this spreads. It waits so long before each "
           "image.\n\n"
           "The camera's software trigger is used where it has one; otherwise it runs free, and images that came too "
           "early are passed over. There is never a second trigger under way. An image of which parts were lost, or "
           "that did not come, is taken again and counted. Automatic exposure and gain are switched off, and come back "
           "at the end.\n\n"
           "The folder gets image_0001.png and so on, in the order of the patterns, and capture.json. `selfproj "
           "depth`, "
           "`selfproj match` and `selfproj calibrate` take it as it is. Esc and Ctrl-C end the capture; nothing is "
           "written then, and the exit status is 1.",
       .examples = R"(
# Gray codes of a projector of 1280 x 800 pixels, seen by a GigE camera (needs hardware)
selfproj pattern gray --projector 1280x800 --out gray
selfproj capture --camera "camera:192.168.1.20?exposure-us=20000" --display 1 --patterns gray \
  --out seen
)"});
  const auto options = std::make_shared<SequenceOptions>();
  begin_group(*command, "Input");
  command
      ->add_option("--camera", options->camera,
                   "Camera and its settings, camera:NAME[?KEY=VALUE&...], as `selfproj devices` lists them.")
      ->type_name("URI")
      ->required();
  command->add_option("--patterns", options->patterns, "Folder of the patterns, in natural order.")
      ->type_name("DIR")
      ->required();
  begin_group(*command, "Display");
  add_display_options(*command, options->display);
  command
      ->add_option("--settle-ms", options->settle_ms,
                   "Wait so long after showing a pattern, in ms, instead of measuring it.")
      ->transform(real_number(0, 60'000))
      ->type_name("MS")
      ->default_str("measured");
  begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the images.")->type_name("DIR")->required();
  command->callback([options] { run_sequence(*options); });
}

}  // namespace selfproj
