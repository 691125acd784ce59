#include "host/app/capture_run.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/capture/grey_curve.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/stop_signal.h"
#include "selfproj/files/user_error.h"

namespace selfproj::app {
namespace {

void print_beginning(const capture::CaptureRecord& record) {
  fmt::print("{}, {} x {} pixels, {}\n", record.camera, record.columns, record.rows,
             record.triggered ? "software trigger" : "free-running");
  fmt::print("exposure: {}\n", capture::exposure_text(record.exposure));
  if (record.settle_measured) {
    fmt::print("settle time: {:.1f} ms; a new pattern is seen after {:.1f} to {:.1f} ms\n", record.settle.settle_ms,
               record.settle.min_ms, record.settle.max_ms);
  }
  static_cast<void>(std::fflush(stdout));  // before the sequence, on a pipe too
}

}  // namespace

void add_display_options(CLI::App& command, DisplayOptions& options) {
  command
      .add_option("--display", options.display,
                  "Number of the display that is the projector, as `selfproj devices` lists them.")
      ->transform(cli::whole_number(0, 99))
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option("--gamma", options.gamma,
                  "Table grey,light of the projector. Greys are changed so that light becomes proportional to them.")
      ->type_name("FILE")
      ->default_str("every grey value as it is");
}

capture::GreyTable greys_of(const DisplayOptions& options) {
  return options.gamma.empty() ? capture::plain_greys()
                               : capture::linear_greys(capture::load_grey_curve(options.gamma));
}

void add_camera_option(CLI::App& command, CaptureOptions& options) {
  command
      .add_option("--camera", options.camera,
                  "Camera and its settings, camera:NAME[?KEY=VALUE&...], as `selfproj devices` lists them.")
      ->type_name("URI")
      ->required();
}

void add_projector_options(CLI::App& command, CaptureOptions& options) {
  cli::begin_group(command, "Display");
  add_display_options(command, options.display);
  command
      .add_option("--settle-ms", options.settle_ms,
                  "Wait so long after showing a pattern, in ms, instead of measuring it.")
      ->transform(cli::real_number(0, 60'000))
      ->type_name("MS")
      ->default_str("measured");
}

capture::CaptureRecord run_capture(const CaptureOptions& options, const std::string& out,
                                   const capture::PatternsFor& patterns_for, const capture::TakeShot& take) {
  const capture::CaptureSetup setup{.camera = options.camera,
                                    .display = options.display.display,
                                    .greys = greys_of(options.display),
                                    .settle_ms = options.settle_ms};
  const files::StopSignal stop;
  std::optional<cli::Progress> progress;
  try {
    return capture::capture_sequence(setup, patterns_for, print_beginning,
                                     [&](std::size_t i, std::size_t count, const images::Image& image) {
                                       if (!progress) {
                                         progress.emplace("pattern", count);
                                       }
                                       take(i, count, image);
                                       progress->update(i + 1);
                                     });
  } catch (const capture::Stopped& stopped) {
    throw CheckFailed(out + ": " + stopped.what());
  }
}

images::ImageSequence Captured::sequence() const {
  std::vector<std::string> names;
  for (const capture::CaptureRecord::Shot& shot : record.shots) {
    names.push_back(shot.image + " of " + record.camera);
  }
  return {std::move(names), [this](std::size_t i) { return images[i]; }};
}

Captured capture_in_memory(const CaptureOptions& options, const std::string& out,
                           const capture::PatternsFor& patterns_for) {
  Captured captured;
  captured.record = run_capture(
      options, out, patterns_for,
      [&](std::size_t /*i*/, std::size_t /*count*/, const images::Image& image) { captured.images.push_back(image); });
  return captured;
}

images::ImageSequence gray_patterns(const structured_light::GraySequence& gray, int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) {
    names.push_back(fmt::format("Gray code image {}", i + 1));
  }
  return {std::move(names), [gray](std::size_t i) {
            return images::Image{gray.rows(), gray.columns(), gray.image(static_cast<int>(i))};
          }};
}

std::string retaken_text(const capture::CaptureRecord& record) {
  return fmt::format("images taken again: {} incomplete, {} missing, {} not of one pattern alone",
                     record.retaken.incomplete, record.retaken.missing, record.retaken.mixed);
}

}  // namespace selfproj::app
