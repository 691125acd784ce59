// The matrices of triangulation by structured light (4.7), from a rig's pinholes or from a calibration.
#ifndef SELFPROJ_HOST_RIG_DEPTH_MATRICES_H
#define SELFPROJ_HOST_RIG_DEPTH_MATRICES_H

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "host/rig/calibration.h"
#include "host/rig/rig.h"

namespace selfproj {

// The two matrices of (4.7):
//
//     H_C (X, Y, 1)^T = T_C (x, y, z, 1)^T       X image column, Y image row, from 0, pixel centres are integers
//     H_P (C, 1)^T    = T_P (x, y, z, 1)^T       C = code + 1/2: code c covers [c, c + 1)
//
// Each is scaled so that H is positive in front of the camera or the projector.
struct DepthMatrices {
  cv::Matx34d camera;                // T_C
  cv::Matx<double, 2, 4> projector;  // T_P
};

// The matrices of a rig whose projector shows `bits` pairs coded along its lines. Its central H lines, or all of them
// if H is 0, are divided into 2^bits codes: code centre Xp = pitch ((c + 1/2) H/2^bits - 1/2 - (H - 1)/2) +
// center_xp_mm.
DepthMatrices depth_matrices(const Rig& rig, int bits, int coded_lines = 0);

// The projector axis along which codes count.
enum class CodedAxis : std::uint8_t { columns, rows };

// The matrices of (4.7) of a calibration without its distortion, along one of its axes: C = projector column or row +
// 1/2.
DepthMatrices depth_matrices(const Calibration& calibration, CodedAxis axis);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_RIG_DEPTH_MATRICES_H
