#include "capi/convert.h"

#include <cstddef>
#include <limits>

#include "capi/errors.h"

namespace selfproj {
namespace {

constexpr int kMostSide = 32768;

static_assert(sizeof(selfproj_measure) == kOldestMeasure);
static_assert(sizeof(selfproj_header) == kOldestHeader);

template <typename Field>
Field field_of(std::uint32_t value) {
  require(value <= std::numeric_limits<Field>::max(), "header: a field does not fit its bits");
  return static_cast<Field>(value);
}

}  // namespace

void check_sides(std::int32_t rows, std::int32_t columns) {
  require(rows >= 1 && rows <= kMostSide && columns >= 1 && columns <= kMostSide,
          "rows or columns are not in 1..32768");
}

ImageView image_of(const selfproj_image* image) {
  require(image != nullptr && image->pixels != nullptr, "image: null pointer");
  check_sides(image->rows, image->columns);
  const std::ptrdiff_t stride = image->stride;
  require(stride <= -image->columns || stride >= image->columns, "image: |stride| is less than columns");
  return {image->pixels, image->rows, image->columns, stride};
}

Mode mode_of(std::int32_t mode) {
  require(mode >= 0 && mode <= SELFPROJ_GREY_OVER, "unknown mode");
  return static_cast<Mode>(mode);
}

Select select_of(std::int32_t select) {
  require(select == SELFPROJ_ALL || select == SELFPROJ_STRONGEST, "unknown select");
  return static_cast<Select>(select);
}

Measure measure_of(const selfproj_measure* measure) {
  const selfproj_measure from = copy_of(measure, kOldestMeasure, "measure: null pointer, or size is not set");
  require(from.threshold >= 0 && from.threshold <= 255, "threshold is not in 0..255");
  require(from.gap >= 0 && from.gap <= kMaxGap, "gap is not in 0..3");
  require(
      from.first_row >= 0 && from.first_row <= spec::kMaxRows && from.last_row >= 0 && from.last_row <= spec::kMaxRows,
      "first_row or last_row are not in 0..1023");
  return {.mode = mode_of(from.mode),
          .threshold = from.threshold,
          .select = select_of(from.select),
          .gap = from.gap,
          .window = {.first = from.first_row, .last = from.last_row}};
}

RunsView runs_of(Select select, const MomentsView& moments, std::uint8_t* runs, std::uint8_t* second) {
  require(moments.m0 != nullptr && moments.m1 != nullptr && moments.n != nullptr, "null pointer");
  require(select == Select::all || (runs != nullptr && second != nullptr), "null pointer");
  return {moments, runs, second};
}

PacketHeader header_of(const selfproj_header* header) {
  const selfproj_header from = copy_of(header, kOldestHeader, "header: null pointer, or size is not set");
  PacketHeader out;
  out.kind = field_of<std::uint8_t>(from.kind);
  out.stream = field_of<std::uint8_t>(from.stream);
  out.lost = from.lost;
  out.sequence = from.sequence;
  out.time_stamp = from.time_stamp;
  out.encoder = from.encoder;
  out.columns = field_of<std::uint16_t>(from.columns);
  out.rows = field_of<std::uint16_t>(from.rows);
  out.pattern = field_of<std::uint16_t>(from.pattern);
  out.mode = field_of<std::uint8_t>(from.mode);
  out.threshold = field_of<std::uint8_t>(from.threshold);
  out.first_line = field_of<std::uint16_t>(from.first_line);
  out.lines = field_of<std::uint16_t>(from.lines);
  out.flags = field_of<std::uint8_t>(from.flags);
  out.select = field_of<std::uint8_t>(from.select);
  out.gap = field_of<std::uint8_t>(from.gap);
  out.first_row = field_of<std::uint16_t>(from.first_row);
  out.last_row = field_of<std::uint16_t>(from.last_row);
  return out;
}

selfproj_header header_from(const PacketHeader& header) {
  selfproj_header out{};
  out.size = sizeof out;
  out.kind = header.kind;
  out.stream = header.stream;
  out.lost = header.lost;
  out.sequence = header.sequence;
  out.time_stamp = header.time_stamp;
  out.encoder = header.encoder;
  out.columns = header.columns;
  out.rows = header.rows;
  out.pattern = header.pattern;
  out.mode = header.mode;
  out.threshold = header.threshold;
  out.first_line = header.first_line;
  out.lines = header.lines;
  out.flags = header.flags;
  out.select = header.select;
  out.gap = header.gap;
  out.first_row = header.first_row;
  out.last_row = header.last_row;
  return out;
}

void check_packet(const selfproj_packet* out) {
  require(out != nullptr && out->size >= offsetof(selfproj_packet, header) + kOldestHeader,
          "packet: null pointer, or size is not set");
}

void write_packet(const PacketView& packet, selfproj_packet* out) {
  check_packet(out);
  selfproj_packet value{};
  value.status = packet.status;
  value.bytes = packet.bytes().data();
  value.byte_count = packet.size;
  value.payload = packet.payload.data();
  value.payload_bytes = packet.payload.size();
  value.header = header_from(packet.header);
  copy_to(value, out);
}

}  // namespace selfproj
