// Between rigs and calibrations: the full model of a rig, and the rig nearest to a calibration.
#ifndef SELFPROJ_HOST_RIG_RIG_CALIBRATION_H
#define SELFPROJ_HOST_RIG_RIG_CALIBRATION_H

#include <string>

#include "host/rig/calibration.h"
#include "host/rig/rig.h"

namespace selfproj {

// The rig's full model if it is calibrated, else its two pinholes. The axes are those of a calibration: x along the
// camera's columns (the rig's y), y along its rows (the rig's x). This mirrors the rig's frame, so the projector of a
// rig with positive pitches has a negative fy: its lines count upwards.
Calibration calibration_of(const Rig& rig);

// The same calibration with x and y exchanged in camera, projector and space: rows take the place of columns. Doing it
// twice gives the original calibration.
Calibration with_axes_exchanged(const Calibration& calibration);

// A rig with this calibration as its full model. It is `like` with the sizes of the calibration's images, and with the
// pinholes of (3.4) that are nearest to the calibration. These keep the pixel pitch and the projector's focal length of
// `like`. They cannot have distortion, a principal point of the camera, a projector place along y, or turns other than
// the tilt, so these are left out. Throws std::invalid_argument if the calibration has no sizes, the projector's
// columns do not lie along the camera's, or it does not stand beside the camera in the direction of growing rows.
Rig rig_of(const Calibration& calibration, const Rig& like);

// How far the rig's pinholes are from its full model: the greatest error in z, mm, of triangulation by (3.4) over
// points of the plane at `z_mm` that both camera and projector see, on a 9 x 9 grid of camera pixels; NaN if there is
// none.
double pinhole_error(const Rig& rig, double z_mm);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_RIG_CALIBRATION_H
