// What is known of chessboards that lie on plates over a belt: parallel planes at known heights, each moved by the belt
// through known distances. This ties a lens of narrow view, which free poses leave open, to true millimetres, and tells
// how the belt runs before the camera.
#ifndef SELFPROJ_HOST_CALIBRATION_BUNDLE_PLATES_H
#define SELFPROJ_HOST_CALIBRATION_BUNDLE_PLATES_H

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <vector>

#include "host/calibration/bundle_types.h"

namespace selfproj {

// Where the chessboard of one view lies.
struct PlatePlace {
  int plate = -1;  // number of the plate, from 0; -1: held by hand, nothing is known
  double height_mm = 0;
  double belt_mm = 0;  // place of the belt
};

// How far plates may be from where they are said to be, to either side, mm.
struct PlateTolerance {
  double height_mm = 0.005;
  double parallel_mm = 0.01;  // of one end of the chessboard over the other
  double fence_mm = 0.05;     // of the place on the belt, from height to height
  double square = 1e-4;       // of the side of the chessboard's squares, as a share
};

// What the drawings of a rig say of its scale. Heights that are all wrong by one factor give a fit as good as right
// ones: the focal length and the distance take up the factor. Only these numbers tell.
struct DrawnScale {
  double distance_mm = 0;                        // of the belt from the camera's centre
  double distance_tolerance = 0.03;              // as a share
  double least_focal_px = 0, most_focal_px = 0;  // of the camera, without tolerance
  double focal_tolerance = 0.03;                 // as a share
};

struct Plates {
  // Of plates at ascending heights, each with the belt at each of these places (one place: it does not move); `side_mm`
  // is the chessboard's longer side. A view for each of them, height by height, is to come first.
  Plates(const std::vector<double>& heights_mm, const std::vector<double>& belt_mm, const PlateTolerance& tolerance,
         double side_mm);

  [[nodiscard]] std::size_t count() const { return heights_mm.size(); }

  // What a length in units of the drawn chessboard is in mm: heights tell how large its squares really are.
  [[nodiscard]] double unit(const Belt& belt) const { return 1 + scale_deviation * belt.scale; }

  std::vector<double> heights_mm;
  std::vector<PlatePlace> places;  // one for each view
  // Standard deviations of what a plate is off: turns about x, y and z, rad, and shifts along x, y and z, mm.
  std::array<double, 6> deviations{};
  double scale_deviation = 0;  // of the chessboard's size, as a share
  bool moved = false;          // whether the belt moves
  // Lenses and pose between them by the drawings, where the least squares start.
  LensParameters camera{}, projector{};
  Pose stereo;
  DrawnScale scale;
};

// Belt and way of the views' poses in `bundle`, to start from.
void start_belt(const Plates& plates, Bundle& bundle);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CALIBRATION_BUNDLE_PLATES_H
