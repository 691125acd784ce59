// Depths at the borders between codes, to a fraction of a pixel and of a code.
//
// Where the code changes by one from a pixel to the next along x, one bit of the Gray code changes. The difference of
// that bit's pair of images passes through zero between the two pixels, where the border is. The depth of a border is
// not rounded to codes. On a smooth surface rounding is no noise: it is the same in all pixels of a row, because they
// see the same place of a code.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_CODE_BORDERS_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_CODE_BORDERS_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/structured_light/triangulation.h"
#include "model/column_moments.h"

namespace selfproj {

class CodeBorders {
 public:
  // Differences of at most `threshold` grey values (0..255) on either side are taken for noise. The triangulation must
  // outlive this, and its codes must run along the rows of the image. Throws std::invalid_argument otherwise.
  CodeBorders(const Triangulation& triangulation, int threshold);

  // Takes the two images of a plane, 0 for the most significant. Throws std::invalid_argument if the plane does not
  // exist or an image has another size.
  void take(int plane, const ImageView& positive, const ImageView& negative);

  // Writes rows · columns depths (mm) of the borders between the codes of the images taken last, each at the pixel that
  // is nearest to it; NaN elsewhere. `codes` are the words decoded from them. Call it when all planes come from one
  // cycle. Planes that never came have no borders.
  void depth(const std::uint16_t* codes, float* z);

 private:
  const Triangulation& triangulation_;
  int threshold_;
  float towards_ = -1;                                 // sign of dz by code
  std::vector<std::vector<std::int16_t>> difference_;  // of each plane, positive - negative
  std::vector<float> whole_;                           // depths of whole codes
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_CODE_BORDERS_H
