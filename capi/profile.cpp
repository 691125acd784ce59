// Profiles of a light section.
#include "selfproj/light_section/profile.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "capi/convert.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/packet_payload.h"
#include "selfproj/rig/rig.h"

struct selfproj_profiler {  // NOLINT(readability-identifier-naming): a name of C
  selfproj::rig::Rig rig;
  selfproj::light_section::DifferentialProfiler profiler;
  selfproj::light_section::Profile profile;  // room for one
};

namespace selfproj::capi {
namespace {

constexpr std::size_t kOldestProfile = offsetof(selfproj_profile, validity) + sizeof(std::uint8_t*);

selfproj_profile profile_of(const selfproj_profiler* profiler, const selfproj_profile* out) {
  require(profiler != nullptr, "null pointer");
  const selfproj_profile wanted = copy_of(out, kOldestProfile, "profile: null pointer, or size is not set");
  require(wanted.columns == static_cast<std::uint32_t>(profiler->profiler.columns()),
          "profile: columns are not those of the profiler");
  return wanted;
}

// Copies the arrays that are wanted.
void hand_out(const light_section::Profile& from, const selfproj_profile& to) {
  const std::array<std::pair<const std::vector<float>*, float*>, 7> arrays{{{&from.centroid, to.centroid},
                                                                            {&from.x, to.x},
                                                                            {&from.y, to.y},
                                                                            {&from.z, to.z},
                                                                            {&from.dx, to.dx},
                                                                            {&from.dy, to.dy},
                                                                            {&from.dz, to.dz}}};
  for (const auto& [values, target] : arrays) {
    if (target != nullptr) {
      std::copy(values->begin(), values->end(), target);
    }
  }
  if (to.validity != nullptr) {
    std::copy(from.validity.begin(), from.validity.end(), to.validity);
  }
}

}  // namespace
}  // namespace selfproj::capi

using namespace selfproj;
using namespace selfproj::capi;

std::int32_t selfproj_profiler_create(const char* rig, const char* reference, selfproj_profiler** out) {
  return guarded([&] {
    require(rig != nullptr && out != nullptr, "null pointer");
    const rig::Rig loaded = rig::load_any_rig(rig);
    if (loaded.kind != rig::RigKind::light_section) {
      throw UserError(rig, "is not a rig of kind light-section");
    }
    rig::expect_measured(loaded, rig, rig::Millimetres::of_section);
    const light_section::ReferenceProfile curve = reference != nullptr
                                                      ? light_section::load_reference(loaded, reference)
                                                      : light_section::reference_of_plane(loaded);
    auto made = std::make_unique<selfproj_profiler>(
        selfproj_profiler{loaded, light_section::DifferentialProfiler(loaded, curve), light_section::Profile{}});
    made->profile.resize(loaded.camera.columns);
    *out = made.release();
  });
}

void selfproj_profiler_destroy(selfproj_profiler* profiler) { delete profiler; }

std::int32_t selfproj_profiler_size(const selfproj_profiler* profiler, std::int32_t* rows, std::int32_t* columns) {
  return guarded([&] {
    require(profiler != nullptr && rows != nullptr && columns != nullptr, "null pointer");
    *rows = profiler->rig.camera.rows;
    *columns = profiler->rig.camera.columns;
  });
}

std::int32_t selfproj_profile_of_packet(selfproj_profiler* profiler, const selfproj_packet* packet,
                                        const selfproj_profile* out) {
  return guarded([&] {
    const selfproj_profile wanted = profile_of(profiler, out);
    check_packet(packet);
    require(packet->payload != nullptr, "packet: null pointer");
    const selfproj_header& header = packet->header;
    if (header.kind > SELFPROJ_KIND_COMPACT || !model::has_columns(static_cast<std::uint8_t>(header.kind)) ||
        packet->status != 0) {
      return failed(SELFPROJ_BAD_INPUT, "the packet has no moments of a good frame");
    }
    static_cast<void>(mode_of(static_cast<std::int32_t>(std::min<std::uint32_t>(header.mode, SELFPROJ_GREY_OVER + 1))));
    static_cast<void>(select_of(static_cast<std::int32_t>(std::min<std::uint32_t>(header.select, 2))));
    model::PacketView view;
    selfproj_header given{};  // its size need not be set, and an older caller's is smaller
    std::memcpy(&given, &header, std::min(sizeof given, packet->size - offsetof(selfproj_packet, header)));
    given.size = sizeof given;
    view.header = header_of(&given);
    if (!profiler->profiler.unlike_camera(view.header).empty()) {
      return failed(SELFPROJ_BAD_INPUT, "the packet is of a frame of another size than the rig's camera");
    }
    require(packet->payload_bytes >= model::columns_payload_bytes(view.header), "packet: the payload is too short");
    view.payload = {packet->payload, packet->payload_bytes};
    if (!profiler->profiler.profile(view, profiler->profile.view())) {
      return failed(SELFPROJ_BAD_INPUT, "the packet was not measured as the images of the reference were");
    }
    hand_out(profiler->profile, wanted);
    return SELFPROJ_OK;
  });
}

std::int32_t selfproj_profile_of_moments(selfproj_profiler* profiler, const std::uint32_t* m0, const std::uint32_t* m1,
                                         const std::uint32_t* n, const selfproj_profile* out) {
  return guarded([&] {
    const selfproj_profile wanted = profile_of(profiler, out);
    require(m0 != nullptr && m1 != nullptr && n != nullptr, "null pointer");
    // The view is one of arrays that may be written; profile only reads them.
    profiler->profiler.profile(model::MomentsView{const_cast<std::uint32_t*>(m0), const_cast<std::uint32_t*>(m1),
                                                  const_cast<std::uint32_t*>(n)},
                               profiler->profile.view());
    hand_out(profiler->profile, wanted);
  });
}
