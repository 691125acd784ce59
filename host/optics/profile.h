// The profile of one frame: what triangulation makes of the moments of its columns.
#ifndef SELFPROJ_HOST_OPTICS_PROFILE_H
#define SELFPROJ_HOST_OPTICS_PROFILE_H

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
  no_reference,  // the reference has no point in this column
  out_of_range,  // triangulation is not possible there (section 1 of the method)
};

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

#endif  // SELFPROJ_HOST_OPTICS_PROFILE_H
