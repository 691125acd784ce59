// What a calibration of heights starts from.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_FIT_TYPES_H
#define SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_FIT_TYPES_H

#include <optional>
#include <string>
#include <vector>

#include "host/light_section/scan.h"

namespace selfproj {

// The lines of one sweep, as the camera saw them.
struct HeightPosition {
  std::string name;      // for errors
  double height_mm = 0;  // of the plate; without meaning over a block of steps
  std::vector<LineSighting> seen;
};

struct HeightSettings {
  std::vector<double> steps_mm;  // heights of the treads of a block, ascending; empty: plates
  double tolerance_mm = 0.005;   // of a height
  double flatness_mm = 0.01;     // of a plate or tread: how far it may be from a plane
  // How far a mm of height by the rig may be from a true one, as a share; nothing: kDrawnScale or kCalibratedScale.
  std::optional<double> scale_tolerance{};

  static constexpr double kDrawnScale = 0.1;        // a rig as drawn
  static constexpr double kCalibratedScale = 0.02;  // a rig with a calibration
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_FIT_TYPES_H
