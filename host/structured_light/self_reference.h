// Self-projected structured light, before the first frame: the code of its stripes, which are straight in the camera's
// view if it sees the reference; the reference; the patterns made from it; and the folder that holds all of this.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_REFERENCE_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_REFERENCE_H

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/structured_light/point_scan.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"

namespace selfproj::structured_light {

// How the stripes count.
enum class StripeCode : std::uint8_t {
  cyclic,     // 0..2^m - 1, 0..2^m - 1, ...: every window of 2^m cells holds each code once
  reflected,  // (4.10) as printed: 0..2^m - 1, then 2^m - 1..0, ...
};

// Stripes of m bits whose smallest width is `width` rows of the camera (a of (4.10)). A cell is the width of one code:
// cell k covers Xc from k a δc to (k + 1) a δc, and Xc = 0 is the middle of the image.
struct Stripes {
  static constexpr int kMaxBits = 8;
  static constexpr int kMaxWidth = 64;

  int bits = 4;   // m, 1..kMaxBits
  int width = 2;  // a, 1..kMaxWidth
  StripeCode code = StripeCode::cyclic;

  bool operator==(const Stripes&) const = default;
};

// ⌊Xc / (a δc)⌋ of a row (from 0, with a fraction) of an image with `rows` rows.
int cell_of_row(double row, int rows, int width);

// Whether the positive pattern of plane `plane` (0 is the most significant bit) is light in this cell. This is (4.10)
// with u = Xc / (a 2^m δc) and does not change within a cell:
//     g_2i = ⌊2^i u + 1/2⌋ mod 2,   cyclic: g_0 = ⌊2u⌋ mod 2
bool is_light(const Stripes& stripes, int cell, int plane);

// The code that a decoder makes from the cell's bits (4.17, 4.18).
int code_of_cell(const Stripes& stripes, int cell);

// Stands for the cell of a projector pixel that has no place f_R.
inline constexpr int kNoCell = std::numeric_limits<int>::min();

// Camera images have the rig's camera's rows x columns, projector images its lines x columns; coordinates count from 0.
struct SelfReference {
  Stripes stripes;
  ProjectorPoints points;  // X_R: the projector point that each camera pixel sees on the reference; A_R says where
                           // there is one (both coordinates or neither)
  images::FloatImage row;  // f_R: the camera point that each projector pixel lights on the reference (4.12); NaN where
                           // it would be far outside the camera's image
  images::FloatImage column;
  std::vector<std::uint8_t> seen;  // for each projector pixel: 1 if the camera sees it, 0 if f_R is filled in

  // A_R of a camera pixel.
  [[nodiscard]] bool measurable(std::size_t pixel) const;

  // ⌊Xc(f_R) / (a δc)⌋ of a projector pixel: the cell of the reference to which its light belongs; kNoCell where f_R is
  // NaN.
  [[nodiscard]] int cell(int line, int projector_column) const;

  int camera_rows = 0;  // the size in which Xc is counted
};

// Inverts X_R to f_R. Between the four pixels of a square of the camera image that lie on one surface (no two of them
// more than `jump` = 8 lines or columns apart), f_R is the inverse of X_R, linear in each of two triangles. Elsewhere,
// in shadows and where the camera does not see, it is filled in, so that every projector pixel has a cell. For this the
// depth z of the reference, as the projector sees it, is continued smoothly (Laplace's equation, level across the
// border of the projector's image), and f_R is where the camera would see that surface, even beyond its image. A plane
// that faces the camera continues as that plane, and neighbouring cells follow each other without a gap. A calibrated
// rig does this through its lenses. f_R is NaN, and the patterns are dark, where the lens model has no ray, or the
// camera would see the surface more than four sizes of its image away. Throws std::invalid_argument if sizes are not
// the rig's, the stripes are out of range, or no pixel is seen.
SelfReference make_self_reference(const rig::Rig& rig, const ProjectorPoints& points, const Stripes& stripes);

// Throws std::invalid_argument if the stripes are out of range.
void check_stripes(const Stripes& stripes);

// Self-projected pattern i of (4.13), 0..2m - 1: even for the positive of plane i / 2, odd for its negative. Light 0 or
// 1.
images::FloatImage self_projected_pattern(const SelfReference& reference, int index);

// Pattern i of a line scan: first the projector's lines, then, from i = lines on, its columns.
images::FloatImage scan_pattern(const rig::Rig& rig, int index);

// Pattern i of the conventional method (4.1): stripes along the projector's lines, 2^bits codes over the central
// `lines` lines, which may be all. Beyond them positives and negatives are dark. Where the codes are more than the
// lines, line v of them has code v, as in GraySequence.
images::FloatImage gray_pattern(const rig::Rig& rig, int bits, int lines, int index);

// A reference as a folder, which `selfproj pattern stripes` makes:
//
//   reference.yaml          version, geometry of the rig, stripes (m, a, code)
//   x_r_line.tiff, x_r_column.tiff   X_R: camera rows x columns, 32-bit floats, NaN where A_R = 0
//   f_r_row.tiff, f_r_column.tiff    f_R: projector lines x columns, 32-bit floats
//   f_r_seen.png            255 where f_R was seen, 0 where it was filled in
//   c_r.png, a_r.png        C_R, 16 bits, 0 where A_R = 0; A_R, 0 or 255
//   pattern_00.png ...      the 2m patterns for the projector: positive and negative of plane 0, ...
//
// That command adds preview.png, the line coordinate of X_R in colours. Adds all other files to the folder, which the
// caller must commit. `inner` is a folder in it, such as "stripes/". Throws UserError.
void write_self_reference(const rig::Rig& rig, const SelfReference& reference, files::OutputFolder& folder,
                          const std::string& inner = {});

// Reads such a folder back (reference.yaml, X_R, f_R and f_r_seen). Throws UserError with file and reason if there is
// no folder, a file is missing, damaged, of another size or version, or made for a rig of another geometry, the stripes
// are out of range, or a value of f_R is not a number.
SelfReference read_self_reference(const rig::Rig& rig, const std::string& folder);

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_REFERENCE_H
