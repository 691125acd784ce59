// The geometry that depth images are computed with: a rig or a calibration file.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_GEOMETRY_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_GEOMETRY_H

#include <memory>
#include <string>

#include "host/structured_light/lens_triangulation.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

// Where images come from, and their size in pixels.
struct ImageSource {
  std::string name;  // for errors: a file, a device
  int rows = 0;
  int columns = 0;
};

// Throws UserError about `geometry`, which is for images of rows x columns, where the source has another size.
void check_size(const std::string& geometry, int rows, int columns, const ImageSource& source);

struct DepthGeometry {
  // One of the two, the other is empty.
  std::string rig;          // a built-in rig or a YAML file
  std::string calibration;  // an OpenCV YAML file

  int bits = 0;          // m, of the code of the coded axis; of the projector's columns with a calibration
  int row_bits = 0;      // with a calibration: of the code of the projector's rows; 0: these have no code
  double lines = 0;      // with a calibration: projector columns that 2^bits codes cover; 0: a code a column
  double row_lines = 0;  // likewise rows
  double max_residual_px = LensSettings{}.max_residual_px;  // both axes
  DepthLimits limits;                                       // a finite max_z_per_line_mm takes the place of the rig's
};

// For images of the source's size. A rig with the sections of a full calibration is taken with its lenses, any other as
// pinholes. Throws UserError: the file cannot be read, is for images of another size, or is no geometry that depth can
// be computed with.
std::unique_ptr<Triangulation> make_triangulation(const DepthGeometry& geometry, const ImageSource& source);

// The same of a calibration file, which both axes need.
std::unique_ptr<LensTriangulation> make_lens_triangulation(const DepthGeometry& geometry, const ImageSource& source);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_GEOMETRY_H
