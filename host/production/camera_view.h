// The camera's image for the page of a line: what it shows, the line found in it, and whether the exposure is right.
#ifndef SELFPROJ_HOST_PRODUCTION_CAMERA_VIEW_H
#define SELFPROJ_HOST_PRODUCTION_CAMERA_VIEW_H

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/driver/image_assembler.h"
#include "host/rig/rig.h"
#include "model/column_moments.h"
#include "model/column_runs.h"
#include "model/packet.h"

namespace selfproj {

// What is said of an image. Shares are 0..1.
struct ExposureFigures {
  double saturated =
      0;                // of a light section: of the columns with a line, those with a pixel of 255; else of all pixels
  double dark = 0;      // of a light section: columns without a line; else pixels below kDarkGrey
  int bright_grey = 0;  // grey value that 1 % of the pixels reach; of a light section 1 % of the columns' maxima
  std::string judgement;  // one sentence
  bool good = false;
};

// Grey values and shares of the judgement.
inline constexpr int kDarkGrey = 20;
inline constexpr double kMostSaturated = 0.01;
inline constexpr double kMostWithoutLine = 0.5;
inline constexpr int kLeastBright = 100;

// The row of the line in each column, from 0, as the board finds it; NaN in a column without a line, or with fewer or
// more lit pixels than the rig allows.
std::vector<float> line_in_image(const ImageView& image, const RigMeasure& measure);

// Judges an image of a light section, whose line is `line`, or of a scanner, where `line` is empty. Too bright is an
// image of which more than kMostSaturated are saturated. Too dark is one whose bright_grey is below kLeastBright, or
// for a light section below the middle between its threshold and 255.
ExposureFigures judge_exposure(const ImageView& image, const std::vector<float>& line, const RigMeasure& measure);

// Puts raw images together out of the packets of a device, kPerSecond at most, and only while `wanted` says so. A
// packet that is not needed costs no more than a look at the clock.
class CameraView {
 public:
  static constexpr int kPerSecond = 4;

  using Take = std::function<void(const PacketHeader&, const ImageView&)>;

  // All arguments are called in the thread that calls add().
  CameraView(std::function<bool()> wanted, Take take);

  void add(const PacketView& packet);

 private:
  std::function<bool()> wanted_;
  Take take_;
  ImageAssembler images_{spec::kKindImage, 0};
  bool taking_ = false;  // an image has begun
  std::int64_t next_ns_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_CAMERA_VIEW_H
