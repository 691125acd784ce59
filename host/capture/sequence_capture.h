// A sequence of patterns, and an image of each.
#ifndef SELFPROJ_HOST_CAPTURE_SEQUENCE_CAPTURE_H
#define SELFPROJ_HOST_CAPTURE_SEQUENCE_CAPTURE_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/camera/camera_uri.h"
#include "host/capture/projector.h"
#include "host/capture/settle.h"
#include "host/capture/shots.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"

namespace selfproj::capture {

struct CaptureSetup {
  std::string camera;  // URI
  int display = 0;
  GreyTable greys = plain_greys();
  std::optional<double> settle_ms;  // measured unless given
};

// What was done, for reports.
struct CaptureRecord {
  struct Shot {
    std::string pattern;  // its file
    std::string image;    // the image's file
    double delay_ms = 0;  // from showing the pattern to the trigger, or to the image of a camera that runs free
  };
  std::string camera;
  int display = 0;
  bool triggered = false;
  int rows = 0;
  int columns = 0;
  Settle settle;
  bool settle_measured = false;
  ExposureCheck exposure;
  images::Image white;  // all of the projector white
  ShotCounters retaken;
  std::vector<Shot> shots;
};

// Of camera and projector, in pixels.
struct CaptureSizes {
  int camera_rows = 0;
  int camera_columns = 0;
  int projector_rows = 0;
  int projector_columns = 0;
};

// The patterns for these sizes. May throw UserError if they do not fit the task; nothing has been shown by then.
using PatternsFor = std::function<images::ImageSequence(const CaptureSizes& sizes)>;

// Receives image i, from 0, of the sequence of `count`; it is valid during the call.
using TakeShot = std::function<void(std::size_t i, std::size_t count, const images::Image& image)>;

// Opens camera and projector, checks the exposure, measures the settle time, and takes an image of every pattern.
// Before the sequence it calls `begin` with what is known by then, then `take` with each image. Leaves camera and
// display as they were found. Throws UserError, and Stopped at Esc or Ctrl-C.
//
// The settle time keeps patterns apart. Where a pattern is followed by its negative, their images are checked as well
// (light_check.h): if one shows another pattern or two at once, because the display was late, tore its picture or
// changed it during the exposure, both are taken again after more than twice the wait, and counted. They count when
// they add up, or when two times in a row were the same.
CaptureRecord capture_sequence(const CaptureSetup& setup, const PatternsFor& patterns_for,
                               const std::function<void(const CaptureRecord&)>& begin, const TakeShot& take);

// What was done, as capture.json.
std::string capture_json(const CaptureRecord& record);

}  // namespace selfproj::capture

#endif  // SELFPROJ_HOST_CAPTURE_SEQUENCE_CAPTURE_H
