// Between the structures of the C interface and those of the model.
#ifndef SELFPROJ_CAPI_CONVERT_H
#define SELFPROJ_CAPI_CONVERT_H

#include <cstdint>

#include "capi/selfproj.h"
#include "model/column_moments.h"
#include "model/column_runs.h"
#include "model/packet.h"

namespace selfproj {

// The sizes of the structures in their first version.
inline constexpr std::uint32_t kOldestMeasure = 28;
inline constexpr std::uint32_t kOldestHeader = 88;

// Throws std::invalid_argument unless rows and columns are in 1..32768.
void check_sides(std::int32_t rows, std::int32_t columns);

// Throws std::invalid_argument if the image is null, has a null pointer, a size below 1, more than 32768 rows or
// columns, or rows that overlap.
ImageView image_of(const selfproj_image* image);

// Throw std::invalid_argument if the value is no mode, or no select.
Mode mode_of(std::int32_t mode);

Select select_of(std::int32_t select);

// Throws std::invalid_argument if the measure is null, or a field is out of range.
Measure measure_of(const selfproj_measure* measure);

// Arrays of the caller for what `select` says. Throws std::invalid_argument if one that is needed is null.
RunsView runs_of(Select select, const MomentsView& moments, std::uint8_t* runs, std::uint8_t* second);

// Throws std::invalid_argument if `header` is null or a field does not fit its bits. payload_size stays 0.
PacketHeader header_of(const selfproj_header* header);

selfproj_header header_from(const PacketHeader& header);

// Fills the caller's packet, whose size must be set; throws std::invalid_argument if it is null or too small.
void write_packet(const PacketView& packet, selfproj_packet* out);
void check_packet(const selfproj_packet* out);

}  // namespace selfproj

#endif  // SELFPROJ_CAPI_CONVERT_H
