// The profile of one frame: what triangulation makes of the moments of its columns.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_PROFILE_H
#define SELFPROJ_HOST_LIGHT_SECTION_PROFILE_H

#include <cstddef>
#include <cstdint>
#include <vector>

namespace selfproj {

// Why a column has no point; valid where it has one.
enum class Validity : std::uint8_t {
  valid = 0,
  unlit,         // no pixel over the threshold
  too_few,       // fewer lit pixels than the rig's min_lit_px
  too_wide,      // more than max_lit_px
  cut_off,       // the line reaches the image's first or last row, and may go on beyond it: see line_is_cut_off
  no_reference,  // the reference has no point in this column
  out_of_range,  // triangulation is not possible there (section 1 of the method)
};

// Whether a line of n lit pixels around the centroid (rows from 1) reaches the first or the last of `rows` rows, so
// that a part of it may lie outside the image, and its centroid is not where the line is. Moments do not say which rows
// were lit, but a line is about as long to both sides of its centroid, and so begins at centroid - n / 2 (row r covers
// r - 1/2 to r + 1/2). For lit rows without a gap that is exact in mode binary. In the grey modes the centroid of a
// line lies within half a row of their middle, so that a line which leaves the second row free may be called cut off,
// and one that is cut off is always found as long as its centroid is within one row of their middle.
[[gnu::always_inline]] inline bool line_is_cut_off(float centroid, float n, float rows) {
  const float half = 0.5F * n;
  // Both are worked out, so that a loop has no branch.
  return static_cast<int>(centroid - half < 1.5F) + static_cast<int>(centroid + half > rows - 0.5F) != 0;
}

// Where a profile is put: arrays of one entry a column, which someone else holds. Millimetres, camera's frame. Entries
// of columns that are not valid are NaN.
struct ProfileView {
  float* centroid = nullptr;  // C = M1/M0, rows from 1 (3.2)
  float* x = nullptr;         // shape (3.10, 3.11), x not carried back by the belt
  float* y = nullptr;
  float* z = nullptr;
  float* dx = nullptr;  // difference from the reference (3.13); dz < 0 is nearer to the camera
  float* dy = nullptr;
  float* dz = nullptr;
  std::uint8_t* validity = nullptr;  // a Validity each
};

// The profile of one frame, held.
struct Profile {
  std::vector<float> centroid, x, y, z, dx, dy, dz;
  std::vector<std::uint8_t> validity;

  void resize(int columns) {
    const auto size = static_cast<std::size_t>(columns);
    for (auto* values : {&centroid, &x, &y, &z, &dx, &dy, &dz}) {
      values->resize(size);
    }
    validity.resize(size);
  }
  ProfileView view() {
    return {centroid.data(), x.data(), y.data(), z.data(), dx.data(), dy.data(), dz.data(), validity.data()};
  }
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_PROFILE_H
