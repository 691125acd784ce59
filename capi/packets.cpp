// Payloads and packets.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "capi/convert.h"
#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"

namespace selfproj::capi {
namespace {

constexpr std::size_t kMaxPayloadBytes = std::size_t{1} << 24U;

int checked_columns(std::int32_t columns) {
  require(columns >= 0 && columns <= 0xFFFF, "columns are not in 0..65535");
  return columns;
}

// Hands a packet to the caller.
void write_bytes(const std::vector<std::uint8_t>& packet, std::uint8_t* out, std::size_t capacity,
                 std::size_t* written) {
  *written = packet.size();
  require(out != nullptr && capacity >= packet.size(), "capacity is less than the bytes of the packet");
  std::memcpy(out, packet.data(), packet.size());
}

}  // namespace
}  // namespace selfproj::capi

using namespace selfproj;
using namespace selfproj::capi;

std::int32_t selfproj_payload_bytes(std::uint32_t kind, std::int32_t mode, std::int32_t columns, std::size_t* bytes) {
  return guarded([&] {
    require(bytes != nullptr, "null pointer");
    require(kind >= SELFPROJ_KIND_MOMENTS && kind <= SELFPROJ_KIND_COMPACT, "unknown kind");
    const int count = checked_columns(columns);
    *bytes = kind == SELFPROJ_KIND_MOMENTS ? model::moments_payload_bytes(mode_of(mode), count)
             : kind == SELFPROJ_KIND_CODES ? model::codes_line_payload_bytes(count)
             : kind == SELFPROJ_KIND_IMAGE ? model::image_line_payload_bytes(count)
                                           : model::compact_payload_bytes(count);
  });
}

std::int32_t selfproj_pack_moments(std::int32_t select, std::int32_t mode, std::int32_t columns,
                                   const std::uint32_t* m0, const std::uint32_t* m1, const std::uint32_t* n,
                                   const std::uint8_t* runs, const std::uint8_t* second, std::uint8_t* payload,
                                   std::size_t payload_bytes) {
  return guarded([&] {
    require(payload != nullptr, "null pointer");
    const int count = checked_columns(columns);
    require(payload_bytes == model::moments_payload_bytes(mode_of(mode), count),
            "payload_bytes are not those of the columns");
    // The view is one of arrays that may be written; pack_columns only reads them.
    const model::MomentsView moments{const_cast<std::uint32_t*>(m0), const_cast<std::uint32_t*>(m1),
                                     const_cast<std::uint32_t*>(n)};
    const model::Select what = select_of(select);
    model::pack_columns(model::column_word(what, mode_of(mode)), count,
                        runs_of(what, moments, const_cast<std::uint8_t*>(runs), const_cast<std::uint8_t*>(second)),
                        payload);
  });
}

std::int32_t selfproj_unpack_moments(std::int32_t select, std::int32_t mode, std::int32_t columns,
                                     const std::uint8_t* payload, std::size_t payload_bytes, std::uint32_t* m0,
                                     std::uint32_t* m1, std::uint32_t* n, std::uint8_t* runs, std::uint8_t* second) {
  return guarded([&] {
    require(payload != nullptr, "null pointer");
    const int count = checked_columns(columns);
    require(payload_bytes >= model::moments_payload_bytes(mode_of(mode), count),
            "payload_bytes are too few for the columns");
    const model::Select what = select_of(select);
    model::unpack_columns(model::column_word(what, mode_of(mode)), count, payload,
                          runs_of(what, {m0, m1, n}, runs, second));
  });
}

std::int32_t selfproj_unpack_wide_moments(std::int32_t mode, std::int32_t columns, const std::uint8_t* payload,
                                          std::size_t payload_bytes, std::uint32_t* m0, std::uint32_t* m1,
                                          std::uint32_t* n) {
  return guarded([&] {
    require(payload != nullptr && m0 != nullptr && m1 != nullptr && n != nullptr, "null pointer");
    const int count = checked_columns(columns);
    require(payload_bytes >= model::moments_payload_bytes(mode_of(mode), count),
            "payload_bytes are too few for the columns");
    model::unpack_columns(model::column_word(model::Select::all, mode_of(mode), true), count, payload,
                          {.moments = {m0, m1, n}});
  });
}

std::int32_t selfproj_unpack_wide_runs(std::int32_t mode, std::int32_t columns, const std::uint8_t* payload,
                                       std::size_t payload_bytes, std::uint32_t* m0, std::uint32_t* m1,
                                       std::uint32_t* n, std::uint8_t* runs, std::uint8_t* second) {
  return guarded([&] {
    require(payload != nullptr, "null pointer");
    const int count = checked_columns(columns);
    require(payload_bytes >= model::moments_payload_bytes(mode_of(mode), count),
            "payload_bytes are too few for the columns");
    model::unpack_columns(model::column_word(model::Select::strongest, mode_of(mode), true), count, payload,
                          runs_of(model::Select::strongest, {m0, m1, n}, runs, second));
  });
}

std::int32_t selfproj_unpack_columns(const selfproj_header* header, const std::uint8_t* payload,
                                     std::size_t payload_bytes, std::uint32_t* m0, std::uint32_t* m1, std::uint32_t* n,
                                     std::uint8_t* runs, std::uint8_t* second) {
  return guarded([&] {
    require(payload != nullptr, "null pointer");
    const model::PacketHeader of = header_of(header);
    require(model::has_columns(of.kind), "header: the packet has no columns");
    const model::Select select = select_of(static_cast<std::int32_t>(of.select));
    static_cast<void>(mode_of(static_cast<std::int32_t>(of.mode)));
    require(payload_bytes >= model::columns_payload_bytes(of), "payload_bytes are too few for the columns");
    model::unpack_columns(of, payload, runs_of(select, {m0, m1, n}, runs, second));
  });
}

std::int32_t selfproj_unpack_compact(std::int32_t select, std::int32_t columns, const std::uint8_t* payload,
                                     std::size_t payload_bytes, std::uint32_t* m0, std::uint32_t* m1, std::uint32_t* n,
                                     std::uint8_t* runs, std::uint8_t* second) {
  return guarded([&] {
    require(payload != nullptr, "null pointer");
    const int count = checked_columns(columns);
    require(payload_bytes >= model::compact_payload_bytes(count), "payload_bytes are too few for the columns");
    const model::Select what = select_of(select);
    model::unpack_columns(
        what == model::Select::strongest ? model::ColumnWord::compact_run : model::ColumnWord::compact, count, payload,
        runs_of(what, {m0, m1, n}, runs, second));
  });
}

std::int32_t selfproj_unpack_codes(std::int32_t columns, const std::uint8_t* payload, std::size_t payload_bytes,
                                   std::uint16_t* codes) {
  return guarded([&] {
    require(payload != nullptr && codes != nullptr, "null pointer");
    const int count = checked_columns(columns);
    require(payload_bytes >= model::codes_line_payload_bytes(count), "payload_bytes are too few for the columns");
    model::unpack_codes(count, payload, codes);
  });
}

std::int32_t selfproj_build_packet(const selfproj_header* header, const std::uint8_t* payload,
                                   std::size_t payload_bytes, std::uint32_t status, std::uint8_t* out,
                                   std::size_t capacity, std::size_t* written) {
  return guarded([&] {
    require(written != nullptr && (payload != nullptr || payload_bytes == 0), "null pointer");
    require(payload_bytes <= kMaxPayloadBytes, "more than 16 MiB of payload");
    std::vector<std::uint8_t> packet;
    model::append_packet(header_of(header), {payload, payload_bytes}, status, packet);
    write_bytes(packet, out, capacity, written);
  });
}

std::int32_t selfproj_moments_packet(const selfproj_image* image, const selfproj_measure* measure,
                                     const selfproj_header* header, std::uint8_t* out, std::size_t capacity,
                                     std::size_t* written) {
  return guarded([&] {
    require(written != nullptr, "null pointer");
    const model::Measure how = measure_of(measure);
    const model::ImageView view = image_of(image);
    require(view.columns % spec::kPixelsPerBeat == 0 && view.columns <= spec::kColumnLimit,
            "image: columns are not a multiple of 4 up to 4096");
    std::vector<std::uint8_t> packet;
    model::append_moments_packet(view, how, header_of(header), packet);
    write_bytes(packet, out, capacity, written);
  });
}

std::int32_t selfproj_parse_packet(const std::uint8_t* bytes, std::size_t count, selfproj_packet* packet) {
  return guarded([&] {
    check_packet(packet);
    require(bytes != nullptr || count == 0, "null pointer");
    model::PacketView view;
    const model::PacketError fault = model::parse_packet({bytes, count}, view);
    if (fault != model::PacketError::none) {
      return failed(SELFPROJ_BAD_INPUT, model::to_string(fault));
    }
    write_packet(view, packet);
    return SELFPROJ_OK;
  });
}
