// The profile of one frame: the result of triangulating the moments of its columns.
#ifndef SELFPROJ_LIGHT_SECTION_PROFILE_H
#define SELFPROJ_LIGHT_SECTION_PROFILE_H

#include <cstddef>
#include <cstdint>
#include <vector>

namespace selfproj::light_section {

// Why a column has no point, or valid if it has one.
enum class Validity : std::uint8_t {
  valid = 0,
  unlit,         // no pixel is over the threshold
  too_few,       // fewer lit pixels than the rig's min_lit_px
  too_wide,      // more lit pixels than the rig's max_lit_px
  cut_off,       // the line reaches the first or last row that counts and may go on beyond it: see line_is_cut_off
  no_reference,  // the reference has no point in this column; with a laser, the plane of the belt has none either
  out_of_range,  // triangulation is impossible there
  ambiguous,     // the second run is nearly as strong as the strongest: see the rig's ambiguous_from
  outside,       // the camera's region has not this column
};
inline constexpr int kValidities = 9;

// Whether a line of n lit pixels around the centroid C (rows from 1, 3.2) reaches the first or the last row that
// counts. Part of it may then lie beyond these rows, and its centroid is not where the line is. Moments do not say
// which rows were lit, but a line is about equally long on both sides of its centroid, and so begins at centroid - n /
// 2 (row r covers r - 1/2 to r + 1/2). In mode binary this is exact for lit rows without a gap. In the grey modes the
// centroid may differ from the middle of the lit rows by half a row, so a line that leaves only the outermost row free
// may be called cut off. A line that is cut off is always found if its centroid is within one row of the middle of its
// lit rows.
[[gnu::always_inline]] inline bool line_is_cut_off(float centroid, float n, float first, float last) {
  const float half = 0.5F * n;
  // Computes both conditions, so that a loop has no branch.
  return static_cast<int>(centroid - half < first + 0.5F) + static_cast<int>(centroid + half > last - 0.5F) != 0;
}

// Where a profile goes: arrays with one entry for each column, owned by someone else. Millimetres in the camera's
// frame. Entries of invalid columns are NaN; with a laser also the differences in columns without a reference.
struct ProfileView {
  float* centroid = nullptr;  // C = M1/M0 (3.2), rows of the sensor from 1
  float* x = nullptr;         // shape (3.10, 3.11), x not carried back by the belt
  float* y = nullptr;
  float* z = nullptr;
  float* dx = nullptr;  // difference from the reference (3.13); dz < 0 is nearer to the camera
  float* dy = nullptr;
  float* dz = nullptr;
  std::uint8_t* validity = nullptr;  // a Validity for each column
};

inline ProfileView from_column(const ProfileView& view, int first) {
  return {view.centroid + first, view.x + first,  view.y + first,  view.z + first,
          view.dx + first,       view.dy + first, view.dz + first, view.validity + first};
}

// A profile that owns its arrays.
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

}  // namespace selfproj::light_section

#endif  // SELFPROJ_LIGHT_SECTION_PROFILE_H
