#include "selfproj/driver/image_assembler.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "selfproj/model/packet.h"

namespace selfproj::driver {

ImageAssembler::ImageAssembler(std::uint8_t kind, int stream, int max_rows, int max_columns)
    : kind_(kind), stream_(stream), max_rows_(max_rows), max_columns_(max_columns) {
  if ((kind != spec::kKindImage && kind != spec::kKindCodes) || stream < 0 || stream > UINT8_MAX || max_rows < 1 ||
      max_columns < 1) {
    throw std::invalid_argument("image assembler: kind, stream or size cannot be");
  }
  const std::size_t size = static_cast<std::size_t>(max_rows) * static_cast<std::size_t>(max_columns);
  if (kind == spec::kKindImage) {
    pixels_.reserve(size);
  } else {
    codes_.reserve(size);
  }
}

bool ImageAssembler::add(const model::PacketView& packet) {
  const model::PacketHeader& header = packet.header;
  if (header.kind != kind_ || header.stream != stream_) {
    return false;
  }
  const bool same_frame = seen_ && header.same_frame(header_);
  if (!same_frame) {
    incomplete_ += open_ ? 1 : 0;
    header_ = header;
    seen_ = true;
    open_ = header.columns <= max_columns_ && header.rows <= max_rows_;
    too_large_ += open_ ? 0 : 1;
    next_line_ = open_ ? 1 : 0;
    if (open_) {
      const std::size_t size = std::size_t{header.rows} * header.columns;
      pixels_.resize(kind_ == spec::kKindImage ? size : 0);
      codes_.resize(kind_ == spec::kKindCodes ? size : 0);
    }
  }
  if (!open_) {
    return false;
  }
  if (packet.status != 0 || header.first_line != next_line_ || header.columns != header_.columns ||
      header.rows != header_.rows) {
    ++incomplete_;
    open_ = false;
    return false;
  }
  const std::size_t columns = header.columns;
  const std::size_t stride = packet.payload.size() / header.lines;  // includes the bytes that fill up the last beat
  for (std::size_t line = 0; line < header.lines; ++line) {
    const std::uint8_t* bytes = packet.payload.data() + line * stride;
    const std::size_t first = (static_cast<std::size_t>(next_line_) - 1 + line) * columns;
    if (kind_ == spec::kKindImage) {
      std::copy_n(bytes, columns, pixels_.begin() + static_cast<std::ptrdiff_t>(first));
    } else {
      model::unpack_codes(header.columns, bytes, codes_.data() + first);
    }
  }
  next_line_ += header.lines;
  if (next_line_ <= header.rows) {
    return false;
  }
  open_ = false;
  ++complete_;
  return true;
}

}  // namespace selfproj::driver
