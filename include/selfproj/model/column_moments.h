// Column moments of an image: the definition, which the circuit sp_column_moments equals to the last bit. Where speed
// counts, the host uses host/light_section/fast_moments.
//
// An image has R rows and C columns, rows ξ = 1..R counted from the top, and pixels p(ξ, η) in 0..255. A pixel is lit
// if p > T, T being the threshold. An unlit pixel has the weight 0, and a lit one has
//
//     binary  w = 1        grey  w = p        grey_over  w = p - T
//
// The moments of column η are exact sums:
//
//     M0(η) = Σ_ξ w(ξ, η)        M1(η) = Σ_ξ ξ · w(ξ, η)        N(η) = number of lit pixels                    (3.1)
//
// over the rows that count: all of them, or those of a window. include/selfproj/model/column_runs.h has the strongest
// run of a column.
#ifndef SELFPROJ_MODEL_COLUMN_MOMENTS_H
#define SELFPROJ_MODEL_COLUMN_MOMENTS_H

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::model {

// How much a lit pixel weighs; the values are those of the packet header and of the register `measure`.
enum class Mode : std::uint8_t {
  binary = spec::kModeBinary,
  grey = spec::kModeGrey,
  grey_over = spec::kModeGreyOver,
};

// The weight of a pixel: 0 unless it is lit.
inline std::uint32_t pixel_weight(Mode mode, int threshold, int pixel) {
  const int lit = mode == Mode::binary ? 1 : mode == Mode::grey ? pixel : pixel - threshold;
  return static_cast<std::uint32_t>(pixel > threshold ? lit : 0);
}

// The rows that count, as in the register `window` and in the packet header: rows first..last, from 1. 0 stands for the
// first and for the last row of the image. Rows beyond the image are allowed.
struct RowWindow {
  int first = 0;
  int last = 0;

  [[nodiscard]] bool counts(int row) const { return row >= first && (last == 0 || row <= last); }

  bool operator==(const RowWindow&) const = default;
};

// An image that someone else owns: pixel (row r, column c), both from 0, is pixels[r * stride + c].
template <typename Pixel>
struct PixelView {
  const Pixel* pixels = nullptr;  // the upper left pixel; needs no alignment
  int rows = 0;
  int columns = 0;
  std::ptrdiff_t stride = 0;  // distance in pixels from one row to the next; negative for an image that is upside down
};
using ImageView = PixelView<std::uint8_t>;
using WideImageView = PixelView<std::uint16_t>;  // pixels of more than 8 bits, one in each word, from bit 0 on
using SensorView = std::variant<ImageView, WideImageView>;  // of a sensor of 8 bits, or of more
inline constexpr int kMaxPixelBits = 12;
inline constexpr int kMaxTallBits = 10;  // with more than spec::kMaxRows rows

// The most rows of an image whose pixels have so many bits.
constexpr int row_limit(int bits) { return bits > kMaxTallBits ? spec::kMaxRows : spec::kRowLimit; }

// Moments that someone else owns: three arrays with one entry for each column.
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

// Writes the moments of every column of `image`, over the rows that count in `window`, to the first image.columns
// entries of the arrays of `out`, which must not overlap each other or the image. Rows 1..spec::kRowLimit; columns 1 or
// more (the circuit takes only multiples of 4 up to spec::kColumnLimit); threshold 0..255. If one of these is out of
// range, the mode is unknown, or a pointer is null, throws std::invalid_argument and writes nothing. Allocates nothing
// and keeps no state; any number of threads may call it at once.
//
// `max_rows` up to kMaxSoftwareRows takes images with more rows than a circuit does.
void column_moments(const ImageView& image, Mode mode, int threshold, const MomentsView& out,
                    const RowWindow& window = {}, int max_rows = spec::kRowLimit);

// The most rows of which M1 always fits in 32 bits: 255 R (R + 1) / 2 < 2^32.
inline constexpr int kMaxSoftwareRows = 5803;

// The same for pixels of `bits` bits, 8 to kMaxPixelBits, and a threshold of 0..2^bits - 1. Rows 1..row_limit(bits). M1
// fits in 32 bits, because 4095 · 1023 · 1024 / 2 < 2^31, and 1023 · 2047 · 2048 / 2 is, too. Pixels of 2^bits and more
// are not looked for; they give wrong sums.
void column_moments(const WideImageView& image, int bits, Mode mode, int threshold, const MomentsView& out,
                    const RowWindow& window = {});
void check_column_moments(const WideImageView& image, int bits, Mode mode, int threshold, const MomentsView& out);

// Throws std::invalid_argument under the conditions of column_moments.
void check_column_moments(const ImageView& image, Mode mode, int threshold, const MomentsView& out,
                          int max_rows = spec::kRowLimit);

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_COLUMN_MOMENTS_H
