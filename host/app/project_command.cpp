#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/app/capture_run.h"
#include "host/app/commands.h"
#include "host/capture/projector.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/driver/clock.h"
#include "host/files/stop_signal.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"

namespace selfproj::app {
namespace {

struct ProjectOptions {
  DisplayOptions display;
  std::vector<std::string> images;
  double seconds = 0;  // 0: a single pattern stays, several have one second each
  bool loop = false;
};

// Waits until this time. Returns false if Esc, Ctrl-C or the closed window came first.
bool hold(capture::Projector& projector, std::int64_t until_ns) {
  constexpr auto kLook = std::chrono::milliseconds(5);
  while (driver::now_ns() < until_ns) {
    if (projector.stopped() || files::StopSignal::came()) {
      return false;
    }
    std::this_thread::sleep_for(kLook);
  }
  return !projector.stopped() && !files::StopSignal::came();
}

void run_project(const ProjectOptions& options) {
  images::ImageSequence patterns(images::image_arguments(options.images), std::nullopt);
  std::vector<images::Image> images;
  for (std::size_t i = 0; i < patterns.count(); ++i) {
    images.push_back(patterns.read(i));
  }
  const bool stays = images.size() == 1 && options.seconds == 0;
  const double seconds = options.seconds > 0 ? options.seconds : 1;
  const auto step = static_cast<std::int64_t>(seconds * 1e9);
  const files::StopSignal stop;
  capture::Projector projector(options.display.display, greys_of(options.display));
  cli::StatusLine status;
  std::size_t shown = 0;
  std::int64_t until = driver::now_ns();
  bool goes_on = true;
  do {
    for (std::size_t i = 0; goes_on && i < images.size(); ++i) {
      projector.show(images[i], patterns.files()[i]);
      ++shown;
      status.show(fmt::format("{} ({} of {}); Esc ends", patterns.files()[i], i + 1, images.size()));
      until = stays ? std::numeric_limits<std::int64_t>::max() : until + step;
      goes_on = hold(projector, until);
    }
  } while (goes_on && options.loop);
  status.show("");
  fmt::print("{} pattern{} shown on display {}{}\n", shown, shown == 1 ? "" : "s", options.display.display,
             goes_on ? "" : ", then stopped");
}

}  // namespace

void add_project_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "project",
       .purpose = "Shows patterns full screen on a projector, a pixel a pixel.",
       .details =
           "A pattern must have exactly the pixels of the display: nothing is scaled, because a scaled pattern is "
           "another one. The display is black before and after. A single pattern stays until Esc or Ctrl-C, unless "
           "--seconds is given; several are shown one after another.\n\n"
           "Switch off what the projector or the desktop changes: keystone correction, sharpening, dynamic contrast, "
           "night colours, screen savers. A notebook's second screen must extend the first, not mirror it.",
       .examples = R"(
# Gray codes for a projector of 1280 x 800 pixels, half a second each (needs hardware)
selfproj pattern gray --projector 1280x800 --out gray
selfproj project --display 1 --seconds 0.5 gray
)"});
  const auto options = std::make_shared<ProjectOptions>();
  cli::begin_group(*command, "Input");
  cli::add_files(*command, "IMAGE", options->images, "Patterns, 8 bits and one channel, or a folder of them.")
      ->required();
  cli::begin_group(*command, "Display");
  add_display_options(*command, options->display);
  command->add_option("--seconds", options->seconds, "Show each pattern so long.")
      ->transform(cli::number_above_zero(1e6))
      ->type_name("S")
      ->default_str("1, and a single pattern stays");
  command->add_flag("--loop", options->loop, "Begin again after the last pattern.");
  command->callback([options] { run_project(*options); });
}

}  // namespace selfproj::app
