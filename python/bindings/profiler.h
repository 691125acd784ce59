// The profiler of light_section, on arrays and packets.
#ifndef SELFPROJ_PYTHON_BINDINGS_PROFILER_H
#define SELFPROJ_PYTHON_BINDINGS_PROFILER_H

#include <nanobind/stl/optional.h>
#include <nanobind/stl/variant.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "python/bindings/arrays.h"
#include "python/bindings/packet_view.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/rig/rig.h"

namespace selfproj::python {

using Column = In<std::uint32_t, nb::c_contig>;

// New arrays for one or several profiles.
struct ProfileResult {
  explicit ProfileResult(const std::vector<std::size_t>& shape)
      : centroid(new_array<float>(shape)),
        x(new_array<float>(shape)),
        y(new_array<float>(shape)),
        z(new_array<float>(shape)),
        dx(new_array<float>(shape)),
        dy(new_array<float>(shape)),
        dz(new_array<float>(shape)),
        validity(new_array<std::uint8_t>(shape)) {}

  [[nodiscard]] light_section::ProfileView view(std::size_t first) const {
    return light_section::from_column(
        {centroid.data(), x.data(), y.data(), z.data(), dx.data(), dy.data(), dz.data(), validity.data()},
        static_cast<int>(first));
  }

  Out<float> centroid, x, y, z, dx, dy, dz;
  Out<std::uint8_t> validity;
};

class Profiler {
 public:
  using Reference = std::variant<light_section::ReferenceProfile, Path>;

  Profiler(const rig::Rig& rig, const std::optional<Reference>& reference)
      : rig_(measured(rig)), reference_(reference_of(rig, reference)), profiler_(rig, reference_) {}

  [[nodiscard]] const rig::Rig& rig() const { return rig_; }
  [[nodiscard]] const light_section::ReferenceProfile& reference() const { return reference_; }

  [[nodiscard]] ProfileResult of_packet(const PacketHandle& packet) const {
    const model::PacketView& view = packet.view();
    ProfileResult result({static_cast<std::size_t>(profiler_.columns())});
    const PacketHandle::Use use(packet);
    require(without_gil([&] { return profiler_.profile(view, result.view(0)); }),
            "the packet has no moments of a good frame of the size of the rig's camera");
    return result;
  }

  [[nodiscard]] ProfileResult of_moments(const Column& m0, const Column& m1, const Column& n) const {
    const auto columns = static_cast<std::size_t>(profiler_.columns());
    require(m0.ndim() == 1 || m0.ndim() == 2, "m0: an array of 1 dimension is needed, or of 2 for several frames");
    for (const Column* other : {&m1, &n}) {
      bool same = other->ndim() == m0.ndim();
      for (std::size_t i = 0; same && i < m0.ndim(); ++i) {
        same = other->shape(i) == m0.shape(i);
      }
      require(same, "m0, m1, n: their shapes differ");
    }
    require(m0.shape(m0.ndim() - 1) == columns, "m0: its columns are not those of the rig's camera");
    const std::size_t frames = m0.ndim() == 2 ? m0.shape(0) : 1;
    constexpr std::size_t kMaxValues = std::size_t{1} << 31U;
    require(frames * columns < kMaxValues, "m0: too many frames at once");
    ProfileResult result(m0.ndim() == 2 ? std::vector<std::size_t>{frames, columns}
                                        : std::vector<std::size_t>{columns});
    without_gil([&] {
      for (std::size_t i = 0; i < frames * columns; i += columns) {
        // The view is one of arrays that may be written; profile only reads them.
        profiler_.profile(
            model::MomentsView{const_cast<std::uint32_t*>(m0.data()) + i, const_cast<std::uint32_t*>(m1.data()) + i,
                               const_cast<std::uint32_t*>(n.data()) + i},
            result.view(i));
      }
    });
    return result;
  }

  [[nodiscard]] const light_section::DifferentialProfiler& profiler() const { return profiler_; }

 private:
  static const rig::Rig& measured(const rig::Rig& rig) {
    rig::expect_measured(rig, rig.name, rig::Millimetres::of_section);
    return rig;
  }
  static light_section::ReferenceProfile reference_of(const rig::Rig& rig, const std::optional<Reference>& reference) {
    if (!reference) {
      return light_section::reference_of_plane(rig);
    }
    const auto* path = std::get_if<Path>(&*reference);
    return path != nullptr ? light_section::load_reference(rig, path->string())
                           : std::get<light_section::ReferenceProfile>(*reference);
  }

  rig::Rig rig_;
  light_section::ReferenceProfile reference_;
  light_section::DifferentialProfiler profiler_;
};

}  // namespace selfproj::python

#endif  // SELFPROJ_PYTHON_BINDINGS_PROFILER_H
