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
#include "host/capture/settle.h"
#include "host/capture/shots.h"
#include "host/io/image_files.h"
#include "host/io/image_sequence.h"
#include "host/io/output_folder.h"
#include "host/projector/projector.h"

namespace selfproj {

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
  bool triggered = false;
  int rows = 0;
  int columns = 0;
  Settle settle;
  bool settle_measured = false;
  ExposureCheck exposure;
  ShotCounters retaken;
  std::vector<Shot> shots;
};

// Opens camera and projector, checks the exposure, measures the settle time, and takes an image of every pattern into
// `out`: image_0001.png and so on, and capture.json. Before the sequence it calls `begin` with what is known by then,
// then `done` after each image. Leaves camera and display as they were found. Nothing is written before the last image
// came. Throws UserError, and Stopped at Esc or Ctrl-C.
CaptureRecord capture_sequence(const CaptureSetup& setup, ImageSequence& patterns, OutputFolder& out,
                               const std::function<void(const CaptureRecord&)>& begin,
                               const std::function<void(std::size_t)>& done);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAPTURE_SEQUENCE_CAPTURE_H
