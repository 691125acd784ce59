#include "host/light_section/curve_kernel.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "host/images/float_image.h"
#include "model/cpu_clones.h"
#include "model/moments_words.h"

// As in differential_profile.cpp: vectorized for each instruction set, with the same bits from all.

namespace selfproj {
namespace {

// The curves from the strip's first column on. The coefficients of the powers lie `columns` apart.
struct CurveTables {
  const float* row_r;
  const float* first;
  const float* last;
  const float* z_r;
  const float* inverse;
  const float* a_r;
  const float* b_r;
  const std::int32_t* valid;
  const float* w;
  const float* a;
  const float* b;
  std::ptrdiff_t columns;
  float per_row;
};

// sum = c_1 t + c_2 t² + ... of each column.
template <int Degree>
[[gnu::always_inline]] inline void polynomial(const float* __restrict t, int count,
                                              const float* __restrict coefficients, std::ptrdiff_t columns,
                                              float* __restrict sum) {
  for (int i = 0; i < count; ++i) {
    float s = coefficients[(Degree - 1) * columns + i];
    for (int k = Degree - 2; k >= 0; --k) {
      s = s * t[i] + coefficients[k * columns + i];
    }
    sum[i] = s * t[i];
  }
}

// One lateral coordinate and its difference from the reference.
[[gnu::always_inline]] inline void beside(const float* __restrict z, const float* __restrict dz,
                                          const float* __restrict tangent, const float* __restrict change, int count,
                                          float* __restrict at, float* __restrict difference) {
  for (int i = 0; i < count; ++i) {
    at[i] = z[i] * (tangent[i] + change[i]);
    difference[i] = tangent[i] * dz[i] + z[i] * change[i];
  }
}

[[gnu::always_inline]] inline void depth(const float* __restrict w, const float* __restrict inverse,
                                         const float* __restrict z_r, int count, float* __restrict z,
                                         float* __restrict dz) {
  for (int i = 0; i < count; ++i) {
    const float at = 1.0F / (inverse[i] + w[i]);
    z[i] = at;
    dz[i] = -z_r[i] * (at * w[i]);
  }
}

// Centroid, validity, and t, which is NaN if the column is not valid and makes all that follows NaN.
[[gnu::always_inline]] inline void begin(const StripMoments& moments, int count, const CurveTables& tables,
                                         const LineRules& line_rules, std::int32_t* __restrict state,
                                         float* __restrict centroid, float* __restrict t) {
  const LineRules rules = line_rules;  // by value, so that no store can change them
  const float per_row = tables.per_row;
  const float* __restrict row_r = tables.row_r;
  const float* __restrict first = tables.first;
  const float* __restrict last = tables.last;
  const std::int32_t* __restrict valid = tables.valid;
  for (int i = 0; i < count; ++i) {
    const std::int32_t m0 = moments.m0[static_cast<std::size_t>(i)];
    const std::int32_t n = moments.n[static_cast<std::size_t>(i)];
    const float c = static_cast<float>(moments.m1[static_cast<std::size_t>(i)]) / static_cast<float>(m0);  // (3.2)
    std::int32_t found = c >= first[i] ? code(Validity::valid) : code(Validity::out_of_range);
    found = c <= last[i] ? found : code(Validity::out_of_range);
    const std::int32_t second = moments.second[static_cast<std::size_t>(i)];
    const std::int32_t s = validity_of(c, m0, n, second, valid[i], found, rules);
    state[i] = s;
    centroid[i] = s == code(Validity::valid) ? c : kNoValue;
    t[i] = s == code(Validity::valid) ? (c - row_r[i]) * per_row : kNoValue;
  }
}

// Takes `count` <= kStrip columns.
template <int Degree>
[[gnu::always_inline]] inline void triangulate(const StripMoments& moments, int count, const CurveTables& k,
                                               const LineRules& rules, const ProfileView& out) {
  alignas(64) std::array<std::int32_t, kStrip> state;
  alignas(64) std::array<float, kStrip> t;
  alignas(64) std::array<float, kStrip> sum;
  begin(moments, count, k, rules, state.data(), out.centroid, t.data());
  polynomial<Degree>(t.data(), count, k.w, k.columns, sum.data());
  depth(sum.data(), k.inverse, k.z_r, count, out.z, out.dz);
  polynomial<Degree>(t.data(), count, k.a, k.columns, sum.data());
  beside(out.z, out.dz, k.a_r, sum.data(), count, out.x, out.dx);
  polynomial<Degree>(t.data(), count, k.b, k.columns, sum.data());
  beside(out.z, out.dz, k.b_r, sum.data(), count, out.y, out.dy);
  std::uint8_t* __restrict validity = out.validity;
  for (int i = 0; i < count; ++i) {
    validity[i] = static_cast<std::uint8_t>(state[static_cast<std::size_t>(i)]);
  }
}

using CurveStrip = void (*)(const StripMoments&, int, const CurveTables&, const LineRules&, const ProfileView&);

SELFPROJ_CLONES void strip_3(const StripMoments& moments, int count, const CurveTables& tables, const LineRules& rules,
                             const ProfileView& out) {
  triangulate<ColumnCurves::kDegrees[0]>(moments, count, tables, rules, out);
}

SELFPROJ_CLONES void strip_5(const StripMoments& moments, int count, const CurveTables& tables, const LineRules& rules,
                             const ProfileView& out) {
  triangulate<ColumnCurves::kDegrees[1]>(moments, count, tables, rules, out);
}

SELFPROJ_CLONES void strip_8(const StripMoments& moments, int count, const CurveTables& tables, const LineRules& rules,
                             const ProfileView& out) {
  triangulate<ColumnCurves::kDegrees[2]>(moments, count, tables, rules, out);
}

SELFPROJ_CLONES void unpack_binary(const std::uint8_t* payload, int first, int count, StripMoments& moments) {
  for_each_binary_word(payload, first, count, take_moments(moments));
}

SELFPROJ_CLONES void unpack_grey(const std::uint8_t* payload, int first, int count, StripMoments& moments) {
  for_each_grey_word(payload, first, count, take_moments(moments));
}

SELFPROJ_CLONES void unpack_runs_binary(const std::uint8_t* payload, int first, int count, StripMoments& moments) {
  unpack_binary_runs(payload, first, count, moments);
}

SELFPROJ_CLONES void unpack_runs_grey(const std::uint8_t* payload, int first, int count, StripMoments& moments) {
  unpack_grey_runs(payload, first, count, moments);
}

// Calls unpack(first, count, moments) and the kernel for each strip.
template <class Unpack>
void for_each_strip(const ColumnCurves& curves, const LineRules& rules, const ProfileView& out, const Unpack& unpack) {
  const CurveStrip strip = curves.degree() == ColumnCurves::kDegrees[0]   ? strip_3
                           : curves.degree() == ColumnCurves::kDegrees[1] ? strip_5
                                                                          : strip_8;
  StripMoments moments;
  for (int first = 0; first < curves.columns(); first += kStrip) {
    const int count = std::min(kStrip, curves.columns() - first);
    unpack(first, count, moments);
    strip(moments, count,
          {curves.row_r.data() + first, curves.first.data() + first, curves.last.data() + first,
           curves.z_r.data() + first, curves.inverse.data() + first, curves.a_r.data() + first,
           curves.b_r.data() + first, curves.valid.data() + first, curves.w.data() + first, curves.a.data() + first,
           curves.b.data() + first, curves.columns(), 1.0F / rules.rows},
          rules, from_column(out, first));
  }
}

}  // namespace

void profile_by_curves(const ColumnCurves& curves, const LineRules& rules, Select select, Mode mode,
                       const std::uint8_t* payload, const ProfileView& out) {
  const bool runs = select == Select::strongest;
  const auto unpack =
      mode == Mode::binary ? (runs ? unpack_runs_binary : unpack_binary) : (runs ? unpack_runs_grey : unpack_grey);
  for_each_strip(curves, rules, out,
                 [&](int first, int count, StripMoments& moments) { unpack(payload, first, count, moments); });
}

void profile_by_curves(const ColumnCurves& curves, const LineRules& rules, const RunsView& runs,
                       const ProfileView& out) {
  for_each_strip(curves, rules, out,
                 [&](int first, int count, StripMoments& strip) { copy_runs(runs, first, count, strip); });
}

}  // namespace selfproj
