// References as files: the inputs for a pattern, and the folder that `selfproj pattern` makes from them.
//
// A reference folder holds
//   reference.csv   the ReferenceProfile, one line for each camera column, after the geometry of the rig it was made
//   for:
//                       # selfproj reference 1
//                       # camera.rows 96
//                       ...
//                       column,tan_theta,z_mm,offset_px
//                       1,0.5986394557823129,1167,0
//                       2,,,
//                   columns count from 1; a column without reference has empty fields. If the reference was found in
//                   images, lines before that of the columns say what counted there (Selection):
//                       # measured.select strongest
//                       # measured.gap_rows 0
//                       # measured.first_row 0
//                       # measured.last_row 0
//                   Of a rig with lenses, a laser or corrected heights the file is
//                       # selfproj reference 2
//                       column,line,line_slope,z_mm,offset_px
//   pattern.tiff    the pattern, 32-bit floating point, projector lines x columns, 0..1
//   pattern.png     the same in 8 bits, for projectors
//   preview.png     pattern and profile to look at
//
// A recording of packets may have its reference beside it: reference_file_of.
#ifndef SELFPROJ_LIGHT_SECTION_REFERENCE_FILE_H
#define SELFPROJ_LIGHT_SECTION_REFERENCE_FILE_H

#include <optional>
#include <string>

#include "selfproj/images/float_image.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

// A curve from CSV text: a line `y_mm,z_mm`, then points with y not falling; an empty z is a gap. Errors name `source`.
// Throws UserError if the first line differs, there are fewer than two points, a field is not a number, y falls, or z
// is not positive.
ReferenceCurve parse_curve_csv(const std::string& text, const std::string& source);

// The curve from a file. *.tif and *.tiff are heights (plane_z - z, mm; rows are frames, columns those of the camera,
// as `scene render --truth` and `height.tiff` have them). Anything else is CSV. From several frames it takes number
// `frame` (from 1) or, without a number, the median of each column. Throws UserError with the file if it is unreadable
// or damaged, has other columns than the rig's camera, or has no such frame.
ReferenceCurve load_curve(const rig::Rig& rig, const std::string& file, std::optional<int> frame);

// The text of reference.csv.
std::string reference_csv(const rig::Rig& rig, const ReferenceProfile& reference);

// The reference from that text. Throws UserError with `source` and the line if the text is no such file or of another
// version, was made for a rig of another geometry, is damaged or cut off, or has other columns than the rig's camera.
ReferenceProfile parse_reference_csv(const rig::Rig& rig, const std::string& text, const std::string& source);

// The reference from a reference folder, or from its reference.csv. Throws UserError as above.
ReferenceProfile load_reference(const rig::Rig& rig, const std::string& folder_or_file);

// The file beside a recording of packets that holds the reference under whose pattern it was taken:
// PATH.reference.csv.
std::string reference_file_of(const std::string& recording);

// The pattern of a reference folder. Throws UserError if its size is not that of the rig's projector, or a value is not
// in 0..1.
images::FloatImage load_pattern(const rig::Rig& rig, const std::string& folder);

}  // namespace selfproj::light_section

#endif  // SELFPROJ_LIGHT_SECTION_REFERENCE_FILE_H
