// The faces of B4's cuboids, and what a depth image says of each against the truth.
#ifndef SELFPROJ_SIM_EXPERIMENT_CUBOID_FACES_H
#define SELFPROJ_SIM_EXPERIMENT_CUBOID_FACES_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/io/float_image.h"
#include "host/rig/rig.h"

namespace selfproj {

enum class Face : std::uint8_t { plane, low, letter, high, block_3, block_6, block_9, none };

// All but `none`, in the order of the enumeration.
inline constexpr std::array<const char*, 7> kFaceNames{"plane",   "low cuboid", "letter", "high cuboid",
                                                       "block 3", "block 6",    "block 9"};

// The face that each pixel sees by the true z (mm, NaN: none) of `cuboids-marked`; `none` less than 3 pixels from
// another face or from a pixel without one.
std::vector<Face> face_interiors(const Rig& rig, const FloatImage& truth);

// What a method finds of one face, over its pixels that have a depth and a difference; mm, NaN where there are none.
struct FaceFigures {
  std::size_t pixels = 0;
  std::size_t valid = 0;
  double height = 0;      // mean over the plane
  double difference = 0;  // mean, from the reference
  double rms = 0;         // of z against the truth
  double most = 0;        // likewise, the largest; 0 where there are none
  double width = 0;       // mean of a code's width in z, over the pixels at which that is known
};

// One for each face but `none`.
class CuboidFigures {
 public:
  [[nodiscard]] const FaceFigures& operator[](Face face) const { return faces_.at(static_cast<std::size_t>(face)); }
  [[nodiscard]] FaceFigures& operator[](Face face) { return faces_.at(static_cast<std::size_t>(face)); }
  [[nodiscard]] auto begin() const { return faces_.begin(); }
  [[nodiscard]] auto end() const { return faces_.end(); }

 private:
  std::array<FaceFigures, kFaceNames.size()> faces_;
};

// `depth`, `truth`: z, mm; `difference` from the reference. `code_width` is asked for every pixel that has a depth: the
// width of its code in z, mm, NaN where it is not known.
CuboidFigures cuboid_figures(const Rig& rig, const std::vector<Face>& faces, const FloatImage& depth,
                             const FloatImage& difference, const FloatImage& truth,
                             const std::function<double(std::size_t pixel)>& code_width);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_CUBOID_FACES_H
