// The code of the self-projected stripes, which are straight in the camera's view if it sees the reference.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_STRIPE_CODE_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_STRIPE_CODE_H

#include <cstdint>

namespace selfproj {

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

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_STRIPE_CODE_H
