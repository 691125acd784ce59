#include "capi/convert.h"

#include <array>
#include <cstddef>
#include <cstdio>
#include <limits>

#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::capi {
namespace {

std::array<char, 1024>& last_error() {
  thread_local std::array<char, 1024> text{};
  return text;
}

constexpr int kMaxSide = 32768;

static_assert(sizeof(selfproj_measure) == kOldestMeasure);
static_assert(offsetof(selfproj_header, pixel_bits) == kOldestHeader);

// The fields of a header, in C and in the model.
template <typename Header, typename Packet, typename Each>
void each_field(Header& header, Packet& packet, const Each& each) {
  each(header.kind, packet.kind);
  each(header.stream, packet.stream);
  each(header.lost, packet.lost);
  each(header.sequence, packet.sequence);
  each(header.time_stamp, packet.time_stamp);
  each(header.encoder, packet.encoder);
  each(header.columns, packet.columns);
  each(header.rows, packet.rows);
  each(header.pattern, packet.pattern);
  each(header.mode, packet.mode);
  each(header.threshold, packet.threshold);
  each(header.first_line, packet.first_line);
  each(header.lines, packet.lines);
  each(header.flags, packet.flags);
  each(header.select, packet.select);
  each(header.gap, packet.gap);
  each(header.first_row, packet.first_row);
  each(header.last_row, packet.last_row);
  each(header.region_row, packet.region_row);
  each(header.region_column, packet.region_column);
  each(header.pixel_bits, packet.pixel_bits);
  each(header.tall, packet.tall);
}

}  // namespace

std::int32_t failed(std::int32_t result, const char* text) noexcept {
  static_cast<void>(std::snprintf(last_error().data(), last_error().size(), "%s", text));
  return result;
}

void check_sides(std::int32_t rows, std::int32_t columns) {
  require(rows >= 1 && rows <= kMaxSide && columns >= 1 && columns <= kMaxSide, "rows or columns are not in 1..32768");
}

model::ImageView image_of(const selfproj_image* image) {
  require(image != nullptr && image->pixels != nullptr, "image: null pointer");
  check_sides(image->rows, image->columns);
  const std::ptrdiff_t stride = image->stride;
  require(stride <= -image->columns || stride >= image->columns, "image: |stride| is less than columns");
  return {image->pixels, image->rows, image->columns, stride};
}

model::Mode mode_of(std::int32_t mode) {
  require(mode >= 0 && mode <= SELFPROJ_GREY_OVER, "unknown mode");
  return static_cast<model::Mode>(mode);
}

model::Select select_of(std::int32_t select) {
  require(select == SELFPROJ_ALL || select == SELFPROJ_STRONGEST, "unknown select");
  return static_cast<model::Select>(select);
}

model::Measure measure_of(const selfproj_measure* measure) {
  const selfproj_measure from = copy_of(measure, kOldestMeasure, "measure: null pointer, or size is not set");
  require(from.threshold >= 0 && from.threshold <= 255, "threshold is not in 0..255");
  require(from.gap >= 0 && from.gap <= model::kMaxGap, "gap is not in 0..3");
  require(from.first_row >= 0 && from.first_row <= spec::kRowLimit && from.last_row >= 0 &&
              from.last_row <= spec::kRowLimit,
          "first_row or last_row are not in 0..2047");
  return {.mode = mode_of(from.mode),
          .threshold = from.threshold,
          .select = select_of(from.select),
          .gap = from.gap,
          .window = {.first = from.first_row, .last = from.last_row}};
}

model::RunsView runs_of(model::Select select, const model::MomentsView& moments, std::uint8_t* runs,
                        std::uint8_t* second) {
  require(moments.m0 != nullptr && moments.m1 != nullptr && moments.n != nullptr, "null pointer");
  require(select == model::Select::all || (runs != nullptr && second != nullptr), "null pointer");
  return {moments, runs, second};
}

model::PacketHeader header_of(const selfproj_header* header) {
  const selfproj_header from = copy_of(header, kOldestHeader, "header: null pointer, or size is not set");
  model::PacketHeader out;
  each_field(from, out, []<typename Field>(const auto& value, Field& field) {
    require(value <= std::numeric_limits<Field>::max(), "header: a field does not fit its bits");
    field = static_cast<Field>(value);
  });
  if (out.pixel_bits == 0) {  // not set
    out.pixel_bits = spec::kPixelBits;
  }
  require(out.pixel_bits >= spec::kPixelBits && out.pixel_bits <= model::kMaxPixelBits &&
              out.threshold < 1 << out.pixel_bits,
          "header: pixel_bits are not in 8..12, or threshold has more");
  return out;
}

selfproj_header header_from(const model::PacketHeader& header) {
  selfproj_header out{};
  out.size = sizeof out;
  each_field(out, header, [](auto& value, const auto& field) { value = field; });
  return out;
}

void check_packet(const selfproj_packet* out) {
  require(out != nullptr && out->size >= offsetof(selfproj_packet, header) + kOldestHeader,
          "packet: null pointer, or size is not set");
}

void write_packet(const model::PacketView& packet, selfproj_packet* out) {
  check_packet(out);
  require(!model::has_wide_words(packet.header) ||
              out->size >= offsetof(selfproj_packet, header) + offsetof(selfproj_header, tall) + sizeof(std::uint32_t),
          "packet: its pixels have more than 8 bits, or its board more than 1023 rows, of which this version of "
          "selfproj_packet cannot tell");
  selfproj_packet value{};
  value.status = packet.status;
  value.bytes = packet.bytes().data();
  value.byte_count = packet.size;
  value.payload = packet.payload.data();
  value.payload_bytes = packet.payload.size();
  value.header = header_from(packet.header);
  value.header.size = std::min<std::uint32_t>(
      value.header.size, out->size - static_cast<std::uint32_t>(offsetof(selfproj_packet, header)));
  copy_to(value, out);
}

}  // namespace selfproj::capi

std::uint32_t selfproj_abi_version() { return SELFPROJ_ABI_VERSION; }

std::uint32_t selfproj_spec_hash() { return selfproj::spec::kHash; }

const char* selfproj_last_error() { return selfproj::capi::last_error().data(); }
