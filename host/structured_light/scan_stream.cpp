#include "host/structured_light/scan_stream.h"

#include <cstddef>
#include <cstdint>

namespace selfproj::structured_light {

ScanStream::Got ScanStream::add(const model::PacketView& packet) {
  if (kind_ != Got::image && codes_.add(packet)) {
    kind_ = Got::codes;
    return Got::codes;
  }
  if (kind_ != Got::codes && images_.add(packet)) {
    kind_ = Got::image;
    newest_ = 1 - newest_;
    pixels_.at(newest_) = images_.pixels();
    follows_ = last_ && *last_ + 1 == images_.header().sequence;
    last_ = images_.header().sequence;
    return Got::image;
  }
  return Got::nothing;
}

const model::PacketHeader& ScanStream::header() const {
  return kind_ == Got::image ? images_.header() : codes_.header();
}

model::ImageView ScanStream::image() const {
  return {pixels_.at(newest_).data(), images_.header().rows, images_.header().columns, images_.header().columns};
}

std::uint64_t ScanStream::incomplete() const {
  return kind_ ? (kind_ == Got::image ? images_ : codes_).incomplete() : codes_.incomplete() + images_.incomplete();
}

}  // namespace selfproj::structured_light
