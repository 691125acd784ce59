#include "selfproj/light_section/differential_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>

#include "host/rig/geometry.h"
#include "model/cpu_clones.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/column_curves.h"
#include "selfproj/light_section/strip_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet_payload.h"

// The compiler vectorizes the loops over columns for each instruction set of SELFPROJ_CLONES. -std=c++20 (ISO, without
// extensions) keeps it from fusing multiplications with additions, so that all sets give the same bits.

namespace selfproj::light_section {
// The inputs of the kernel, from the strip's first column on.
struct ProfileTables {
  const float* tan_theta;
  const float* tan_beta;
  const float* tan_alpha_r;
  const float* z_r;
  const float* numerator;
  const float* theta_per_line;
  const std::int32_t* valid;
  float middle_row;
  float tan_alpha_per_row;
  float projector_x;
  float projector_z;
  float max_z_per_line;
  LineRules rules;
};

namespace {

// The compiler honours __restrict only on parameters, also of functions that it inlines. `reciprocal` is 1 / (tan α +
// tan θ): one division takes as long as all the rest of a column.
[[gnu::always_inline]] inline void shape_of(const float* __restrict tan_alpha, const float* __restrict reciprocal,
                                            int columns, const float* __restrict numerator,
                                            const float* __restrict tan_beta, float* __restrict x, float* __restrict y,
                                            float* __restrict z) {
  for (int i = 0; i < columns; ++i) {
    const float depth = numerator[i] * reciprocal[i];  // (3.10 = 3.11; 3.4)
    z[i] = depth;
    x[i] = depth * tan_alpha[i];
    y[i] = depth * tan_beta[i];
  }
}

[[gnu::always_inline]] inline void difference_of(const float* __restrict tan_alpha, const float* __restrict reciprocal,
                                                 int columns, const float* __restrict z_r,
                                                 const float* __restrict tan_alpha_r, const float* __restrict tan_theta,
                                                 const float* __restrict tan_beta, float* __restrict dx,
                                                 float* __restrict dy, float* __restrict dz) {
  for (int i = 0; i < columns; ++i) {
    const float k = z_r[i] * (tan_alpha_r[i] - tan_alpha[i]) * reciprocal[i];  // k' of (3.12); -k of (3.13)
    dx[i] = -k * tan_theta[i];
    dy[i] = k * tan_beta[i];
    dz[i] = k;
  }
}

// Takes `columns` <= kStrip columns.
[[gnu::always_inline]] inline void triangulate(const StripMoments& moments, int columns, const ProfileTables& tables,
                                               const ProfileView& out) {
  alignas(64) std::array<std::int32_t, kStrip> state;
  alignas(64) std::array<float, kStrip> tangent;
  alignas(64) std::array<float, kStrip> reciprocal;
  const ProfileTables t = tables;  // by value, so that no store can change them
  const float* __restrict tan_theta = t.tan_theta;
  const float* __restrict theta_per_line = t.theta_per_line;
  const std::int32_t* __restrict valid = t.valid;
  float* __restrict centroid = out.centroid;
  for (int i = 0; i < columns; ++i) {
    const std::int32_t n = moments.n[i];
    const std::int32_t m0 = moments.m0[i];
    const float c = static_cast<float>(moments.m1[i]) / static_cast<float>(m0);  // (3.2); a result of 0/0 is discarded
    const float row = c + t.rules.offset;
    const float tan_alpha = (row - t.middle_row) * t.tan_alpha_per_row;  // (3.3), (3.6)
    const float sum = tan_alpha + tan_theta[i];
    // z falls with θ at the rate (x0 - z0 tan α) / (tan α + tan θ)², which must be more than 0 and, for one line of
    // the projector, within the rig's limit.
    const float reach = t.projector_x - t.projector_z * tan_alpha;
    const float worth = reach * theta_per_line[i];
    const float limit = t.max_z_per_line * (sum * sum);
    std::int32_t s = worth <= limit ? code(Validity::valid) : code(Validity::out_of_range);
    s = sum > 0.0F ? s : code(Validity::out_of_range);
    s = reach > 0.0F ? s : code(Validity::out_of_range);
    s = validity_of(c, m0, n, moments.second[i], valid[i], s, t.rules);
    state[i] = s;
    centroid[i] = s == code(Validity::valid) ? row : images::kNoValue;
    tangent[i] = s == code(Validity::valid) ? tan_alpha : images::kNoValue;
    reciprocal[i] = 1.0F / (s == code(Validity::valid) ? sum : images::kNoValue);  // makes all that follows NaN
  }
  shape_of(tangent.data(), reciprocal.data(), columns, t.numerator, t.tan_beta, out.x, out.y, out.z);
  difference_of(tangent.data(), reciprocal.data(), columns, t.z_r, t.tan_alpha_r, t.tan_theta, t.tan_beta, out.dx,
                out.dy, out.dz);
  std::uint8_t* __restrict validity = out.validity;
  for (int i = 0; i < columns; ++i) {
    validity[i] = static_cast<std::uint8_t>(state[i]);
  }
}

SELFPROJ_CLONES void strip_words(model::ColumnWord word, const std::uint8_t* payload, int first, int columns,
                                 const ProfileTables& tables, const ProfileView& out) {
  StripMoments moments;
  unpack_strip(word, payload, first, columns, moments);
  triangulate(moments, columns, tables, out);
}

SELFPROJ_CLONES void strip_moments(const model::RunsView& from, int first, int columns, const ProfileTables& tables,
                                   const ProfileView& out) {
  StripMoments moments;
  copy_runs(from, first, columns, moments);
  triangulate(moments, columns, tables, out);
}

// Columns that a frame has not.
void blank(const ProfileView& out, int begin, int end) {
  for (float* values : {out.centroid, out.x, out.y, out.z, out.dx, out.dy, out.dz}) {
    std::fill(values + begin, values + end, images::kNoValue);
  }
  std::fill(out.validity + begin, out.validity + end, static_cast<std::uint8_t>(Validity::outside));
}

}  // namespace

DifferentialProfiler::DifferentialProfiler(const rig::Rig& rig, const ReferenceProfile& reference)
    : camera_(rig.camera),
      measure_(rig.measure),
      middle_row_(static_cast<float>(rig::middle_row(rig.camera))),
      tan_alpha_per_row_(static_cast<float>(rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm)),
      projector_x_(static_cast<float>(rig.projector.x_mm)),
      projector_z_(static_cast<float>(rig.projector.z_mm)),
      max_z_per_line_(static_cast<float>(rig.measure.max_z_per_line_mm)),
      rules_(line_rules(rig)) {
  if (reference.columns() != rig.camera.columns) {
    throw std::invalid_argument("profile: the reference has other columns than the camera");
  }
  columns_ = reference.columns();
  measured_ = reference.measured;
  if (!rig.is_pinholes()) {
    curves_ = std::make_shared<const ColumnCurves>(rig, reference);
    return;
  }
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    const bool valid = reference.valid[i] != 0;
    const double theta = valid ? reference.tan_theta[i] : 0;
    const double z_r = valid ? reference.z_mm[i] : 0;
    const double alpha_r = valid ? rig::tan_alpha(rig.camera, rig::middle_row(rig.camera) + reference.offset_px[i]) : 0;
    const double cosine = std::cos(std::atan(theta) - rig.projector.tilt_rad);
    tan_theta_.push_back(static_cast<float>(theta));
    tan_beta_.push_back(static_cast<float>(rig::tan_beta(rig.camera, static_cast<double>(i))));
    tan_alpha_r_.push_back(static_cast<float>(alpha_r));
    z_r_.push_back(static_cast<float>(z_r));
    numerator_.push_back(static_cast<float>(z_r * (alpha_r + theta)));
    // θ = θ0 + atan(Xp / fp) (3.7), so d tan θ / dXp = (1 + tan² θ) cos²(θ - θ0) / fp.
    theta_per_line_.push_back(static_cast<float>(std::abs(rig.projector.line_pitch_mm) * (1 + theta * theta) * cosine *
                                                 cosine / rig.projector.focal_length_mm));
    valid_.push_back(valid ? 1 : 0);
  }
}

std::string DifferentialProfiler::unlike_reference(const model::PacketHeader& header) const {
  return light_section::unlike_reference(measured_, selection_of(model::measure_of(header)),
                                         place_of_frame(camera_, header).value_or(FramePlace{}).row, header.rows);
}

std::optional<FramePlace> place_of_frame(const rig::RigCamera& camera, const model::PacketHeader& header) {
  if (header.region_row > 0 && header.region_column > 0) {
    return FramePlace{header.region_row - 1, header.region_column - 1};
  }
  if (header.rows == camera.rows && header.columns == camera.columns) {
    return FramePlace{0, 0};
  }
  if (camera.region && header.rows == camera.region->rows && header.columns == camera.region->columns) {
    return FramePlace{camera.region->row_offset, camera.region->column_offset};
  }
  return std::nullopt;
}

std::string DifferentialProfiler::unlike_camera(const model::PacketHeader& header) const {
  const std::optional<FramePlace> place = place_of_frame(camera_, header);
  if (!place) {
    return fmt::format(
        "its frames are {} x {} pixels, those of the rig {} x {}, and they do not say where on the "
        "sensor they lie",
        header.columns, header.rows, camera_.columns, camera_.rows);
  }
  if (place->row + header.rows > camera_.rows || place->column + header.columns > camera_.columns) {
    return fmt::format(
        "its frames of {} x {} pixels begin at row {}, column {} of the sensor, but the rig's has {} x {}",
        header.columns, header.rows, place->row + 1, place->column + 1, camera_.columns, camera_.rows);
  }
  return {};
}

ProfileTables DifferentialProfiler::tables_from(int first, const LineRules& rules) const {
  return {tan_theta_.data() + first,
          tan_beta_.data() + first,
          tan_alpha_r_.data() + first,
          z_r_.data() + first,
          numerator_.data() + first,
          theta_per_line_.data() + first,
          valid_.data() + first,
          middle_row_,
          tan_alpha_per_row_,
          projector_x_,
          projector_z_,
          max_z_per_line_,
          rules};
}

// The payload begins with column `begin` of the sensor.
void DifferentialProfiler::profile(model::ColumnWord word, const std::uint8_t* payload, int begin, int end,
                                   const LineRules& rules, const ProfileView& out) const {
  if (curves_) {
    profile_by_curves(*curves_, rules, word, payload, begin, end, out);
    return;
  }
  for (int first = begin; first < end; first += kStrip) {
    const int count = std::min(kStrip, end - first);
    strip_words(word, payload, first - begin, count, tables_from(first, rules), from_column(out, first));
  }
}

bool DifferentialProfiler::profile(const model::PacketView& packet, const ProfileView& out) const {
  const model::PacketHeader& header = packet.header;
  if (!model::has_columns(header.kind) || packet.status != 0 || !unlike_camera(header).empty() ||
      !unlike_reference(header).empty()) {
    return false;
  }
  const auto [row, column] = place_of_frame(camera_, header).value_or(FramePlace{});
  const int end = column + header.columns;
  profile(model::column_word(header), packet.payload.data(), column, end,
          line_rules(camera_, measure_, row, header.rows), out);
  blank(out, 0, column);
  blank(out, end, columns());
  return true;
}

void DifferentialProfiler::profile(const model::RunsView& runs, const ProfileView& out) const {
  if (curves_) {
    profile_by_curves(*curves_, rules_, runs, out);
    return;
  }
  for (int first = 0; first < columns(); first += kStrip) {
    strip_moments(runs, first, std::min(kStrip, columns() - first), tables_from(first, rules_),
                  from_column(out, first));
  }
}

}  // namespace selfproj::light_section
