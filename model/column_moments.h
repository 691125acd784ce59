// Column moments of an image: their definition, which the circuit sp_column_moments equals to the last bit. Where speed
// counts the host takes host/light_section/fast_moments.
//
// For an image of R rows and C columns, rows ξ = 1..R counted from the top, pixels p(ξ, η) in 0..255 and a threshold T,
// a pixel is lit where p > T; an unlit one has the weight 0, a lit one
//
//     binary  w = 1        grey  w = p        grey_over  w = p - T
//
// The moments of column η are exact sums:
//
//     M0(η) = Σ_ξ w(ξ, η)        M1(η) = Σ_ξ ξ · w(ξ, η)        N(η) = number of lit pixels                    (3.1)
#ifndef SELFPROJ_MODEL_COLUMN_MOMENTS_H
#define SELFPROJ_MODEL_COLUMN_MOMENTS_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {

// How much a lit pixel weighs; the values are those of the packet header and of the register `measure`.
enum class Mode : std::uint8_t {
  binary = spec::kModeBinary,
  grey = spec::kModeGrey,
  grey_over = spec::kModeGreyOver,
};

// An image that someone else holds: pixel (row r, column c), both from 0, is pixels[r * stride + c].
struct ImageView {
  const std::uint8_t* pixels = nullptr;  // of the upper left pixel; no alignment is needed
  int rows = 0;
  int columns = 0;
  std::ptrdiff_t stride = 0;  // pixels from one row to the next; any sign, so that an image may be upside down
};

// Where moments are put or taken from: three arrays of one entry a column, which someone else holds.
struct MomentsView {
  std::uint32_t* m0 = nullptr;  // 0th moments
  std::uint32_t* m1 = nullptr;  // 1st moments, rows counted from 1
  std::uint32_t* n = nullptr;   // numbers of lit pixels; equal to m0 in mode binary
};

// The moments of one image.
struct Moments {
  std::vector<std::uint32_t> m0;
  std::vector<std::uint32_t> m1;
  std::vector<std::uint32_t> n;

  // Makes room for `columns` >= 0 columns; entries that are new are 0.
  void resize(int columns);

  // Valid until the next resize.
  MomentsView view();

  bool operator==(const Moments&) const = default;
};

// Writes the moments of every column of `image` to the first image.columns entries of the three arrays of `out`, which
// must not overlap each other or the image. Rows 1..spec::kMaxRows; columns 1 or more (that the circuit takes multiples
// of 4 only, and at most spec::kMaxColumns, is its own rule); threshold 0..255. Throws std::invalid_argument, having
// written nothing, where one of these is out of range, the mode is none of the three, or a pointer is null.
// Allocates nothing and keeps no state, so that any number of threads may call it at once.
void column_moments(const ImageView& image, Mode mode, int threshold, const MomentsView& out);

// Throws std::invalid_argument as column_moments does.
void check_column_moments(const ImageView& image, Mode mode, int threshold, const MomentsView& out);

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_COLUMN_MOMENTS_H
