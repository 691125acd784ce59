// Chessboards that lie on plates over a belt: parallel planes at known heights, each moved by the belt through known
// distances. This ties a lens of narrow view, which free poses leave open, to true millimetres, and tells how the belt
// runs before the camera.
#ifndef SELFPROJ_HOST_CALIBRATION_PLATES_H
#define SELFPROJ_HOST_CALIBRATION_PLATES_H

#include <array>
#include <complex>
#include <cstddef>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "host/calibration/bundle.h"
#include "host/calibration/chessboard.h"
#include "selfproj/rig/rig.h"

namespace selfproj::calibration {

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
  double distance_mm = 0;                     // of the belt from the camera's centre
  double distance_tolerance = 0.03;           // as a share
  double min_focal_px = 0, max_focal_px = 0;  // of the camera, without tolerance
  double focal_tolerance = 0.03;              // as a share
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

// A point of a chessboard, and the ray (x, y, 1) on which it is seen, each as x + iy.
struct PlanePoint {
  std::complex<double> board;  // mm
  std::complex<double> ray;
};

// The pose of a chessboard that is square to the camera's axis: the similarity that fits its points best.
Pose square_pose(const std::vector<PlanePoint>& points);

// Belt and way of the views' poses in `bundle`, to start from.
void start_belt(const Plates& plates, Bundle& bundle);

// How the belt lies before the camera, from chessboards on plates.
struct BeltReport {
  rig::RigBeltPose pose;
  bool moved = false;                  // whether the belt moved; if not, the pose's direction is the chessboard's rows
  double plane_z_mm = 0;               // from the camera's centre, square to the belt
  double way = 0;                      // mm that the chessboard moved for each mm of the belt
  double squares = 1, squares_sd = 0;  // true size of the chessboard over the given one
  double lean_deg_sd = 0;              // of the angle between the belt's normal and the view of the image's middle
};

// What is wrong with the plates of a result, for the user; empty if nothing: a plate that is off by more than its
// tolerance and what the camera sees, or a belt that does not move the chessboard as far as it is said to. In the fit
// itself a wrong height looks like noise, so that the camera alone is asked, with the lens found.
std::string fault_of_plates(const std::vector<View>& views, const Plates& plates, const Bundle& found);

// What the drawings say against the distance of the belt, mm, and the focal length of the camera, px, that a fit has
// found, and the likely reason; empty if both are within their tolerances.
std::string fault_of_scale(const DrawnScale& drawn, double distance_mm, double focal_px);

// Puts all lengths of the result into mm of the plates' heights, and tells of the belt.
BeltReport belt_report(const Plates& plates, BundleResult& result);

// Plates over the belt of a rig (CalibrateSettings::plates), whose lenses, poses and distance are where the least
// squares start. Heights and places of the belt are in mm, ascending; `tolerances` gives the two of DrawnScale, and the
// rig the rest of it.
Plates plates_over(const rig::Rig& rig, const Chessboard& chessboard, const std::vector<double>& heights_mm,
                   const std::vector<double>& belt_mm, const PlateTolerance& tolerance, const DrawnScale& tolerances);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_PLATES_H
