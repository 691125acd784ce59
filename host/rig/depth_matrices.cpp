#include "host/rig/depth_matrices.h"

#include <cmath>

namespace selfproj {

DepthMatrices depth_matrices(const Rig& rig, int bits, int coded_lines) {
  const RigCamera& camera = rig.camera;
  const RigProjector& projector = rig.projector;
  const double focal = camera.focal_length_mm / camera.pixel_pitch_mm;
  // Column <-> y, row <-> x (3.3).
  const cv::Matx34d camera_matrix(0, focal, 0.5 * (camera.columns - 1), 0,  //
                                  focal, 0, 0.5 * (camera.rows - 1), 0,     //
                                  0, 0, 1, 0);
  // Depth along the projector's axis and offset across it, of (x, y, z, 1): Xp = fp side / depth.
  const double sine = std::sin(projector.tilt_rad);
  const double cosine = std::cos(projector.tilt_rad);
  const cv::Vec4d depth(-sine, 0, cosine, sine * projector.x_mm - cosine * projector.z_mm);
  const cv::Vec4d side(-cosine, 0, -sine, cosine * projector.x_mm + sine * projector.z_mm);
  // C = (line + 1/2) 2^m / H with line = (H - 1)/2 + (Xp - center)/pitch, counted from the first of the H lines.
  const int lines = coded_lines > 0 ? coded_lines : projector.lines;
  const double codes_per_line = std::ldexp(1.0, bits) / lines;
  const cv::Vec4d code = codes_per_line * ((0.5 * lines - projector.center_xp_mm / projector.line_pitch_mm) * depth +
                                           (projector.focal_length_mm / projector.line_pitch_mm) * side);
  return {camera_matrix, {code[0], code[1], code[2], code[3], depth[0], depth[1], depth[2], depth[3]}};
}

DepthMatrices depth_matrices(const Calibration& c, CodedAxis axis) {
  const auto projected = [&](double focal, double centre, int i) {
    cv::Vec4d row;
    for (int k = 0; k < 3; ++k) {
      row[k] = focal * c.rotation(i, k) + centre * c.rotation(2, k);
    }
    row[3] = focal * c.translation[i] + centre * c.translation[2];
    return row;
  };
  const cv::Vec4d code = axis == CodedAxis::rows ? projected(c.projector.fy, c.projector.cy + 0.5, 1)
                                                 : projected(c.projector.fx, c.projector.cx + 0.5, 0);
  const cv::Vec4d depth = projected(0, 1, 0);
  return {{c.camera.fx, 0, c.camera.cx, 0, 0, c.camera.fy, c.camera.cy, 0, 0, 0, 1, 0},
          {code[0], code[1], code[2], code[3], depth[0], depth[1], depth[2], depth[3]}};
}

}  // namespace selfproj
