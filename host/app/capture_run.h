// What `selfproj capture` and `selfproj scan` share: camera, projector, and what is said about them.
#ifndef SELFPROJ_HOST_APP_CAPTURE_RUN_H
#define SELFPROJ_HOST_APP_CAPTURE_RUN_H

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/capture/projector.h"
#include "host/capture/sequence_capture.h"
#include "host/images/image_sequence.h"
#include "selfproj/structured_light/gray_sequence.h"

namespace selfproj::app {

// The display that is the projector.
struct DisplayOptions {
  int display = 0;
  std::string gamma;  // empty: every grey value as it is
};

// Adds --display and --gamma.
void add_display_options(CLI::App& command, DisplayOptions& options);

// The table of --gamma.
capture::GreyTable greys_of(const DisplayOptions& options);

struct CaptureOptions {
  std::string camera;
  DisplayOptions display;
  std::optional<double> settle_ms;
};

// Adds --camera to the group that is open. It is required.
void add_camera_option(CLI::App& command, CaptureOptions& options);

// Adds the group of --display, --gamma and --settle-ms.
void add_projector_options(CLI::App& command, CaptureOptions& options);

// Takes an image of every pattern (capture_sequence), prints what is known before the sequence, and shows progress.
// Throws CheckFailed about `out` if Esc or Ctrl-C end it, and UserError.
capture::CaptureRecord run_capture(const CaptureOptions& options, const std::string& out,
                                   const capture::PatternsFor& patterns_for, const capture::TakeShot& take);

// Images of a capture, kept in memory.
struct Captured {
  capture::CaptureRecord record;
  std::vector<images::Image> images;

  // The images in turn. This object must outlive it.
  [[nodiscard]] images::ImageSequence sequence() const;
};

// The same with all images in memory.
Captured capture_in_memory(const CaptureOptions& options, const std::string& out,
                           const capture::PatternsFor& patterns_for);

// The first `count` images of a Gray-code sequence as patterns.
images::ImageSequence gray_patterns(const structured_light::GraySequence& gray, int count);

// "images taken again: 2 incomplete, 0 missing, 4 not of one pattern alone".
std::string retaken_text(const capture::CaptureRecord& record);

}  // namespace selfproj::app

#endif  // SELFPROJ_HOST_APP_CAPTURE_RUN_H
