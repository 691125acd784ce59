// The geometry from which depth images are computed: a rig, or a calibration file.
#ifndef SELFPROJ_STRUCTURED_LIGHT_DEPTH_GEOMETRY_H
#define SELFPROJ_STRUCTURED_LIGHT_DEPTH_GEOMETRY_H

#include <memory>
#include <string>

#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/lens_triangulation.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

// Where images come from, and their size in pixels.
struct ImageSource {
  std::string name;  // a file or a device, for errors
  int rows = 0;
  int columns = 0;
};

// Throws UserError about `geometry`, which is for images of rows x columns, if the source has another size.
void check_size(const std::string& geometry, int rows, int columns, const ImageSource& source);

struct DepthGeometry {
  // One of these two is given, the other is empty.
  std::string rig;          // a built-in rig or a YAML file
  std::string calibration;  // an OpenCV YAML file

  int bits = 0;      // m of the code along the coded axis; with a calibration or both axes, the projector's columns
  int row_bits = 0;  // bits of the code of the projector's rows; 0: one axis is coded
  // What the 2^bits codes cover: of a calibration, or with both axes, projector columns, else the rig's lines. 0: one
  // for each code; of a rig's lines alone, all where they are more.
  double lines = 0;
  double row_lines = 0;                                     // rows that the 2^row_bits codes cover
  double max_residual_px = LensSettings{}.max_residual_px;  // for both axes
  DepthLimits limits;                                       // a finite max_z_per_line_mm replaces the rig's
};

// For images of the source's size. A rig with a full calibration is used with its lenses, any other as pinholes. Throws
// UserError if the file cannot be read, is for images of another size, or gives no geometry for depth.
std::unique_ptr<Triangulation> make_triangulation(const DepthGeometry& geometry, const ImageSource& source);

// The same for both axes. `bits` are then those of the code of the projector's columns, also with a rig, whose x and y
// are exchanged (LensSettings::rows_are_x): it takes the code of its lines, the second one, for the first.
std::unique_ptr<LensTriangulation> make_lens_triangulation(const DepthGeometry& geometry, const ImageSource& source);

// Codes of `bits` bits along the lines of the rig's projector, which cover `lines` of them from the first on (0:
// rig::coded_height), for images of its camera; its max_z_per_line_mm takes the place of that of `limits`. Throws
// std::invalid_argument as the triangulations do.
std::unique_ptr<Triangulation> triangulation_of_rig(const rig::Rig& rig, int bits, const DepthLimits& limits = {},
                                                    double lines = 0);

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_STRUCTURED_LIGHT_DEPTH_GEOMETRY_H
