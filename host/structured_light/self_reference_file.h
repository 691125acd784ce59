// A reference of self-projected structured light as a folder: what `selfproj pattern stripes` makes.
//
//   reference.yaml          version, geometry of the rig, stripes (m, a, code)
//   x_r_line.tiff, x_r_column.tiff   X_R: camera rows x columns, 32-bit floats, NaN where A_R = 0
//   f_r_row.tiff, f_r_column.tiff    f_R: projector lines x columns, 32-bit floats
//   f_r_seen.png            255 where f_R was seen, 0 where it was filled in
//   c_r.png, a_r.png        C_R, 16 bits, 0 where A_R = 0; A_R, 0 or 255
//   pattern_00.png ...      the 2m patterns for the projector: positive and negative of plane 0, ...
//
// `selfproj pattern stripes` adds preview.png, the line coordinate of X_R in colours.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_REFERENCE_FILE_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_REFERENCE_FILE_H

#include <string>

#include "host/files/output_folder.h"
#include "host/rig/rig.h"
#include "host/structured_light/self_reference.h"

namespace selfproj {

// Adds all files to the folder, which the caller must commit. Throws UserError.
void write_self_reference(const Rig& rig, const SelfReference& reference, OutputFolder& folder);

// Reads such a folder back (reference.yaml, X_R, f_R and f_r_seen). Throws UserError with file and reason if there is
// no folder, a file is missing, damaged, of another size or version, or made for a rig of another geometry, the stripes
// are out of range, or a value of f_R is not a number.
SelfReference read_self_reference(const Rig& rig, const std::string& folder);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_REFERENCE_FILE_H
