// The camera's image for the live page: what it shows, the line found in it, and whether the exposure is right.
#ifndef SELFPROJ_HOST_PRODUCTION_CAMERA_VIEW_H
#define SELFPROJ_HOST_PRODUCTION_CAMERA_VIEW_H

#include <cstdint>
#include <string>
#include <vector>

#include "selfproj/driver/image_assembler.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// What is said of an image. Shares are 0..1.
struct ExposureFigures {
  double saturated =
      0;                // of a light section: of the columns with a line, those with a pixel of 255; else of all pixels
  double dark = 0;      // of a light section: columns without a line; else pixels below kDarkGrey
  int bright_grey = 0;  // grey value that 1 % of the pixels reach; of a light section 1 % of the columns' maxima
  std::string advice;   // one sentence
  bool good = false;
};

// Grey values and shares that decide on the advice.
inline constexpr int kDarkGrey = 20;
inline constexpr double kMaxSaturated = 0.01;
inline constexpr double kMaxWithoutLine = 0.5;
inline constexpr int kMinBright = 100;

// The row of the line in each column, from 0, by the rules of the rig (LineFinder), for an image of any size; NaN in a
// column without a line.
std::vector<float> line_in_image(const model::ImageView& image, rig::Rig rig);

// Of an image of a light section, whose line is `line`, or of a scanner, where `line` is empty. Too bright is an
// image of which more than kMaxSaturated are saturated. Too dark is one whose bright_grey is below kMinBright, or
// for a light section below the middle between its threshold and 255.
ExposureFigures exposure_figures(const model::ImageView& image, const std::vector<float>& line,
                                 const rig::RigMeasure& measure);

// Puts raw images together out of the packets of a device, kPerSecond at most. A packet that is not needed costs no
// more than a look at the clock.
class CameraView {
 public:
  static constexpr int kPerSecond = 4;

  // Returns whether the packet has completed an image. No image begins unless it is `wanted`.
  bool add(const model::PacketView& packet, bool wanted);

  // The newest complete image, until the next call of add().
  [[nodiscard]] const model::PacketHeader& header() const { return images_.header(); }
  [[nodiscard]] model::ImageView image() const {
    return {images_.pixels().data(), header().rows, header().columns, header().columns};
  }

 private:
  driver::ImageAssembler images_{spec::kKindImage, 0};
  bool begun_ = false;  // an image has begun
  std::int64_t next_ns_ = 0;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_CAMERA_VIEW_H
