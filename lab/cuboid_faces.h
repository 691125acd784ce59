// The faces of B4's cuboids, and how a depth image of each compares with the truth.
#ifndef SELFPROJ_LAB_CUBOID_FACES_H
#define SELFPROJ_LAB_CUBOID_FACES_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/images/float_image.h"
#include "host/rig/rig.h"
#include "lab/error_spread.h"

namespace selfproj {

enum class Face : std::uint8_t { plane, low, letter, high, block_3, block_6, block_9, none };

// Without `none`, in the order of the enumeration.
inline constexpr std::array<const char*, 7> kFaceNames{"plane",   "low cuboid", "letter", "high cuboid",
                                                       "block 3", "block 6",    "block 9"};

// The face of `cuboids-marked` that each pixel sees, from the true z (mm, NaN: none). It is `none` within less than 3
// pixels of another face or of a pixel without one.
std::vector<Face> face_interiors(const Rig& rig, const FloatImage& truth);

// A method's findings on one face, over the pixels with a depth and a difference; mm, NaN if there are none.
struct FaceFigures {
  std::size_t pixels = 0;
  std::size_t valid = 0;
  double height = 0;      // mean over the plane
  double difference = 0;  // mean difference from the reference
  double rms = 0;         // RMS error of z
  double most = 0;        // largest error of z; 0 if there are no pixels
  ErrorSpread errors;     // of z
  double width = 0;       // mean width of a code in z, over the pixels at which it is known
};

// The figures of each face but `none`.
class CuboidFigures {
 public:
  [[nodiscard]] const FaceFigures& operator[](Face face) const { return faces_.at(static_cast<std::size_t>(face)); }
  [[nodiscard]] FaceFigures& operator[](Face face) { return faces_.at(static_cast<std::size_t>(face)); }
  [[nodiscard]] auto begin() const { return faces_.begin(); }
  [[nodiscard]] auto end() const { return faces_.end(); }

 private:
  std::array<FaceFigures, kFaceNames.size()> faces_;
};

// `depth` and `truth` are z in mm; `difference` is from the reference. `code_width` is called for every pixel with a
// depth. It returns the width of the pixel's code in z, mm, or NaN if that is unknown.
CuboidFigures cuboid_figures(const Rig& rig, const std::vector<Face>& faces, const FloatImage& depth,
                             const FloatImage& difference, const FloatImage& truth,
                             const std::function<double(std::size_t pixel)>& code_width);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_CUBOID_FACES_H
