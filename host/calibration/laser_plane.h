// A camera alone, from plain images of a chessboard, and the plane of a laser's line on that chessboard.
#ifndef SELFPROJ_HOST_CALIBRATION_LASER_PLANE_H
#define SELFPROJ_HOST_CALIBRATION_LASER_PLANE_H

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "host/calibration/chessboard.h"
#include "host/calibration/model_choice.h"
#include "host/images/image_files.h"
#include "selfproj/rig/rig.h"

namespace selfproj::calibration {

struct CameraSettings {
  Chessboard chessboard;
  int distortion = FreeDistortion::kByData;  // 0, 1, 2, 4 or 5 coefficients, or kByData
  bool bent = true;                          // the chessboard's shape is estimated; false: it is exactly flat
  double reject = 4.5;   // corners with residuals above this many standard deviations are left out; 0: none
  int min_corners = 12;  // an image with fewer is left out
  int threshold = 40;    // a laser's line is brighter than this grey value
};

// A plain image of the chessboard.
struct BoardImage {
  std::string name;
  std::string reason;  // why it is left out; empty if it is used
  int rows = 0, columns = 0;
  std::vector<cv::Point2d> corners;  // column, row; all of the chessboard's, or none
  std::vector<bool> used;            // of the corners
  double rms_px = 0;
  bool by_squares = false;  // its chessboard was found so (chessboard.h)

  [[nodiscard]] int used_corners() const;
};

struct CameraReport {
  CameraSettings settings;
  std::vector<BoardImage> images;
  std::vector<std::size_t> image_of_view;  // of each view of the model
  ModelChoice model;                       // of the camera alone; model.refusal: why it must not be used
  std::vector<CornerModes> shape;          // of the chessboard; empty if it is flat
};

inline constexpr std::size_t kMinLinePoints = 5;  // of an image

struct LaserPlane {
  rig::RigLightPlane plane;
  std::size_t images = 0;                   // in which the line was found on the chessboard
  std::vector<std::string> without_line;    // the names of the other images of a chessboard that was found
  std::size_t points = 0, left_out = 0;     // of the line
  double rms_mm = 0;                        // of the points' distances from the plane
  double turn_sd_deg = 0, shift_sd_mm = 0;  // standard deviations, from fits that leave out one image each; the shift
                                            // is that of the plane in the points' middle
};

// Finds the chessboard. That there is none is not an error. With `light` a laser's line may cross it
// (find_chessboard_under_line); corners under it are not used.
BoardImage observe_board(const std::string& name, const images::Image& image, const Chessboard& chessboard,
                         const images::Image* light = nullptr);

// The camera's lens, with the model that the images support (model_choice.h). Throws UserError if fewer than two images
// can be used, if they differ in size, or if nothing converges.
CameraReport calibrate_camera(std::vector<BoardImage> images, const CameraSettings& settings);

// The centre of the line in each column of an image, as (column, row): the centroid, by what is above the threshold, of
// the pixels around the column's brightest one.
std::vector<cv::Point2d> line_centres(const images::Image& image, int threshold);

// The plane of the line, from images of the same poses as those of `camera`, in the same order. It uses the points on
// the chessboard that are not near the edge of a square along the line's columns, where black and white shift the
// centre. Throws UserError if the line is found on fewer than three chessboards, or lies on one straight line in space
// on all of them.
LaserPlane laser_plane(const CameraReport& camera, const std::vector<images::Image>& lines);

// The rig of this camera and laser. What they do not tell, such as the pixel pitch and the belt, is that of `drawn`. If
// `drawn` takes all lit pixels of a column, this rig takes the strongest run.
rig::Rig rig_of_laser(const rig::Rig& drawn, const CameraReport& camera, const LaserPlane& laser);

}  // namespace selfproj::calibration

#endif  // SELFPROJ_HOST_CALIBRATION_LASER_PLANE_H
