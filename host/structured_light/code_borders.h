// Finds the borders between codes to a fraction of a pixel, and their depths to a fraction of a code.
//
// Here x changes from one row of the image to the next. Where the codes of two neighbouring pixels along x differ by
// one, one bit of the Gray code differs. The border lies between these pixels, where the difference of this bit's two
// images passes through zero. Its depth is not rounded to whole codes. On a smooth surface an average does not remove
// rounding, because the error is the same in all pixels of a row: they lie at the same position within their code.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_CODE_BORDERS_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_CODE_BORDERS_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

class CodeBorders {
 public:
  // A border counts only if the difference of the two images changes by more than 2 · `threshold` grey values between
  // the two pixels. A smaller change is taken for noise. The triangulation must outlive this object. Throws
  // std::invalid_argument if the threshold is not in 0..255, or if x runs along the rows (rows_are_x() is false).
  CodeBorders(const Triangulation& triangulation, int threshold);

  // Takes the two images of a bit plane. Plane 0 is the most significant one. Throws std::invalid_argument if the plane
  // does not exist or an image has another size.
  void add_plane(int plane, const model::ImageView& positive, const model::ImageView& negative);

  // Writes rows · columns depths (mm) from the images taken last. Each border's depth is written to the pixel that is
  // nearest to the border, and NaN to all other pixels. `codes` are the words decoded from these images. Call this when
  // all planes come from one cycle. Borders of planes that were never taken are left out.
  void depth(const std::uint16_t* codes, float* z);

 private:
  const Triangulation& triangulation_;
  int threshold_;
  float towards_ = -1;                                 // 1 if depth grows with the code, -1 if it falls
  std::vector<std::vector<std::int16_t>> difference_;  // for each plane: positive - negative
  std::vector<float> whole_;                           // depths in the middle of whole codes
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_CODE_BORDERS_H
