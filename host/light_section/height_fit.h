// Ties the heights of a light section to known ones, from sweeps of lines over flat plates or over a block of steps.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_FIT_H
#define SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_FIT_H

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/light_section/scan.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

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

// The mean error of a height in a sixteenth of the columns.
struct HeightPart {
  int first_column = 0, last_column = 0;  // from 0
  double mean_mm = 0;
  double noise_mm = 0;  // standard deviation of the mean, from the scatter of the columns in these very images
};

// One height: a position of the plate, or a tread.
struct HeightLevel {
  std::string name;
  double height_mm = 0;
  std::size_t samples = 0;
  double before_rms_mm = 0, before_mean_mm = 0;  // of the heights by the geometry alone
  double rms_mm = 0, mean_mm = 0;                // of the corrected heights
  double uneven_mm = 0;                          // greatest mean error of a part
  std::vector<HeightPart> parts{};               // those with enough samples
};

struct HeightFit {
  rig::Rig rig;  // with `heights` and plane_z_mm as found; with the belt's normal if it is calibrated and had none
  std::vector<HeightLevel> levels;
  double rms_mm = 0;         // of single centroids, all levels
  double correction_mm = 0;  // the greatest correction in the image, over all heights
  // What is left open, in mm: the greatest change of a height anywhere in the image, over all calibrated heights.
  double open_by_tolerance_mm = 0;  // if each height is off by its tolerance, in the worst way
  double open_by_flatness_mm = 0;   // if the plate is off a plane by its tolerance in the same way at all heights
  double open_by_noise_mm = 0;      // one standard deviation
};

// Fits plane, belt and corrections. Throws UserError if there are fewer than three heights, one has too few samples,
// the heights are not in the order in which the rig sees them, a plate is not flat within its tolerance, or the
// positions do not determine the heights of the whole image. Throws CheckFailed if the rig sees all heights larger or
// smaller by one factor beyond its tolerance: the corrections would take it up.
HeightFit fit_heights(const rig::Rig& given, const std::vector<HeightPosition>& positions,
                      const HeightSettings& settings);

// The same levels measured with the rig as it is.
std::vector<HeightLevel> check_heights(const rig::Rig& rig, const std::vector<HeightPosition>& positions,
                                       const HeightSettings& settings);

// How far a part of a level that is checked may be off: by tolerance and flatness, twice because the heights of the
// calibration had them, too, and by four standard deviations of its noise.
double allowed_mm(const HeightPart& part, const HeightSettings& settings);

}  // namespace selfproj::light_section

#endif  // SELFPROJ_HOST_LIGHT_SECTION_HEIGHT_FIT_H
