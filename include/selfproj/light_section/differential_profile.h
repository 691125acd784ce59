// Centroids, shape and difference from the reference, from the moments of one frame.
#ifndef SELFPROJ_LIGHT_SECTION_DIFFERENTIAL_PROFILE_H
#define SELFPROJ_LIGHT_SECTION_DIFFERENTIAL_PROFILE_H

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "selfproj/light_section/column_curves.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/strip_moments.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

struct ProfileTables;  // defined in the .cpp file

// Where a frame begins on the camera's sensor, row and column from 0: as its header says; else the whole sensor, or the
// rig's region, whichever has its size. Nothing if neither has.
struct FramePlace {
  int row = 0;
  int column = 0;
};
std::optional<FramePlace> place_of_frame(const rig::RigCamera& camera, const model::PacketHeader& header);

// Holds what is the same for all frames. With tan α of the column's centroid C = M1/M0 (3.2, 3.3, 3.6), and tan α_r of
// the reference's row (0 in a perfect self-projection):
//
//     z = z_r (tan α_r + tan θ) / (tan α + tan θ),   x = z tan α,   y = z tan β         (3.10 = 3.11; 3.4)
//     k' = z_r (tan α_r - tan α) / (tan α + tan θ)
//     (Δx, Δy, Δz) = k' (-tan θ, tan β, 1)                                              (3.12 corrected)
//
// For α_r = 0 this is (3.13), corrected, with k = -k'. One class thus serves self-projection, with or without a
// residual, and the conventional straight line; only the ReferenceProfile differs.
//
// Numbers are 32-bit floats. In images of 96 rows the centroid is within 4e-6 of a row of the exact one (half a unit in
// the last place of M1, M0 and the quotient each). x, y, z are within two or three units in their last place (0.12 µm
// at z = 1167). The differences come from k' and not from z, and are exact to 1e-6 of their own value plus the change
// that 4e-6 rows cause. The camera's noise is some 0.01 rows.
class DifferentialProfiler {
 public:
  // Throws std::invalid_argument if the reference has another number of columns than the rig, and UserError if the
  // curves of its columns cannot be fitted.
  DifferentialProfiler(const rig::Rig& rig, const ReferenceProfile& reference);

  [[nodiscard]] int columns() const { return columns_; }

  // The curves of a rig that is more than pinholes, else null.
  [[nodiscard]] const ColumnCurves* curves() const { return curves_.get(); }

  // Why a frame with this header does not go with the reference, as unlike_reference says it; empty if it does.
  [[nodiscard]] std::string unlike_reference(const model::PacketHeader& header) const;

  // Computes the profile from the payload of a moments packet (selfproj/model/packet.h) in this mode, with columns()
  // columns. `out` has columns() entries in each of its arrays, which must not overlap. Invalid entries become NaN,
  // with the first reason of Validity that applies. A column is cut_off if line_is_cut_off says so. It is out_of_range
  // if the light plane is not before the camera's ray, z0 tan α < x0 does not hold, or one projector line is worth more
  // than max_z_per_line_mm. Allocates nothing and keeps no state; any number of threads may call it at once. Unknown
  // modes count as grey.
  void profile(model::Mode mode, const std::uint8_t* payload, const ProfileView& out) const {
    profile(model::Select::all, mode, payload, out);
  }

  // The same for a payload with the strongest run of each column. A column is ambiguous if its second run has at least
  // the share of the strongest one's M0 that the rig calls ambiguous. Unknown selects count as `all`.
  void profile(model::Select select, model::Mode mode, const std::uint8_t* payload, const ProfileView& out) const {
    profile(model::column_word(select, mode), payload, out);
  }

  // The same for a payload of these words, perhaps compact ones.
  void profile(model::ColumnWord word, const std::uint8_t* payload, const ProfileView& out) const {
    profile(word, payload, 0, columns(), rules_, out);
  }

  // Why a frame of this size and place is not one of the rig's camera; empty if it is: the whole sensor, or a region of
  // it. See place_of_frame.
  [[nodiscard]] std::string unlike_camera(const model::PacketHeader& header) const;

  // The same from a packet, of kind moments or compact. Returns false, and writes nothing, unless it has the columns of
  // a good frame for which
  // unlike_camera and unlike_reference are empty. Columns outside its region become Validity::outside.
  [[nodiscard]] bool profile(const model::PacketView& packet, const ProfileView& out) const;

  // The same from moments, which are only read, and are as column_moments gives them (below 2^31).
  void profile(const model::MomentsView& moments, const ProfileView& out) const {
    profile({moments, nullptr, nullptr}, out);
  }

  // The same from runs; without `second`, from the moments alone.
  void profile(const model::RunsView& runs, const ProfileView& out) const;

 private:
  [[nodiscard]] ProfileTables tables_from(int first, const LineRules& rules) const;
  void profile(model::ColumnWord word, const std::uint8_t* payload, int begin, int end, const LineRules& rules,
               const ProfileView& out) const;

  int columns_ = 0;
  rig::RigCamera camera_;
  rig::RigMeasure measure_;
  std::optional<Selection> measured_;
  std::shared_ptr<const ColumnCurves> curves_;  // null for pinholes
  // Values of the rig:
  float middle_row_;
  float tan_alpha_per_row_;
  float projector_x_;
  float projector_z_;
  float max_z_per_line_;
  LineRules rules_;
  // Values of each column:
  std::vector<float> tan_theta_;
  std::vector<float> tan_beta_;
  std::vector<float> tan_alpha_r_;
  std::vector<float> z_r_;
  std::vector<float> numerator_;       // z_r (tan α_r + tan θ)
  std::vector<float> theta_per_line_;  // d tan θ / d line
  std::vector<std::int32_t> valid_;    // 0 or 1
};

}  // namespace selfproj::light_section

#endif  // SELFPROJ_LIGHT_SECTION_DIFFERENTIAL_PROFILE_H
