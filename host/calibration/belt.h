// How the belt lies before a camera whose lens is known, and how it moves: from images of a chessboard that lies on it,
// with the belt at several places. A laser's line on the flat belt, and on a plate of known height there, then make
// heights exact.
#ifndef SELFPROJ_HOST_CALIBRATION_BELT_H
#define SELFPROJ_HOST_CALIBRATION_BELT_H

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "host/calibration/chessboard.h"
#include "host/calibration/laser_plane.h"
#include "selfproj/rig/rig.h"

namespace selfproj::calibration {

// The line of a laser on a flat surface at a known height above the belt, as (column, row) of each column's centre.
// Where the line lies at another height, on the belt beside a block, its points are left out.
struct LineAtHeight {
  std::string name;
  double height_mm = 0;
  std::vector<cv::Point2d> centres;
};

struct BeltSettings {
  Chessboard chessboard;
  double thickness_mm = 0;        // of the chessboard on the belt
  std::vector<double> moves_mm;   // where the belt was at each image, if that is known
  std::vector<double> counts;     // what its encoder counted there
  std::vector<double> seconds;    // when the images were taken
  double scale_tolerance = 0.02;  // of moves_mm against the chessboard, and of the heights' scale
  double height_tolerance = 1;    // mm: of what the laser sees of the belt against the chessboard
};

struct BeltPlace {
  std::string name;
  double along_mm = 0;  // how far the chessboard has moved since the first image
  double rms_px = 0;
};

struct BeltCalibration {
  rig::Rig rig;  // with belt_pose, plane_z_mm, conveyor and light plane as far as they were measured, and sources
  std::vector<BeltPlace> places;
  double rms_px = 0;            // of the corners
  double distance_sd_mm = 0;    // standard deviations by the corners' noise: of plane_z_mm,
  double normal_sd_deg = 0;     // of the belt's normal,
  double direction_sd_deg = 0;  // and of the way it moves, within the belt
  double way = 0;               // mm by the chessboard for each mm of moves_mm; 0: not given
  double spread_mm = 0;         // greatest distance of a place from an even way by moves, counts or seconds
  // Of the laser: what it saw of the belt before it was taken as height 0, how much the belt was turned about its way
  // for that, and how much the laser's plane was turned for the other heights.
  double zero_mm = 0, zero_turn_deg = 0, light_turn_deg = 0;
  double light_scale = 1;  // mm that it saw for each mm of the heights, before that
  struct Height {
    std::string name;
    double height_mm = 0, mean_mm = 0, rms_mm = 0;
    std::size_t points = 0;
  };
  std::vector<Height> heights;  // measured with the rig that was found
};

// Finds the belt of a light section whose lens is known. `boards` are images of the chessboard flat on the belt, at two
// or more places, in the order in which the belt passes them; the belt moves along that way. `lines` are for a laser
// alone: the first is height 0. Throws UserError if the images do not determine the belt, contradict each other or what
// is said of them.
BeltCalibration calibrate_belt(const rig::Rig& rig, const std::vector<BoardImage>& boards,
                               const std::vector<LineAtHeight>& lines, const BeltSettings& settings);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_BELT_H
