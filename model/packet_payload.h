// Payloads: their contents, sizes, packing and unpacking. The formats are those of model/spec; docs/packet-reference.md
// has their table.
#ifndef SELFPROJ_MODEL_PACKET_PAYLOAD_H
#define SELFPROJ_MODEL_PACKET_PAYLOAD_H

#include <cstddef>
#include <cstdint>

#include "model/column_moments.h"
#include "model/column_runs.h"

namespace selfproj {

// Whether the value is one of the three modes.
bool is_known(Mode mode);

// Whether the value is one of the two selects.
bool is_known(Select select);

// Bytes of the moments of `columns` >= 0 columns: 4 for each column in mode binary, 8 in the grey modes, filled up with
// zeros to a multiple of 16. Throws std::invalid_argument if columns are negative or the mode is unknown.
std::size_t moments_payload_bytes(Mode mode, int columns);

// Bytes of one line of a raw image: 1 for each pixel, filled up with zeros to a multiple of 16. Throws as above.
std::size_t image_line_payload_bytes(int columns);

// Bytes of one line of a code image: 2 for each pixel, filled up with zeros to a multiple of 16. Throws as above.
std::size_t codes_line_payload_bytes(int columns);

// Writes the moments of `columns` columns as payload words, moments_payload_bytes(mode, columns) bytes. Ignores n in
// mode binary. A value wider than its field loses its high bits; column_moments never gives one.
void pack_moments(Mode mode, int columns, const MomentsView& moments, std::uint8_t* payload);

// Reads the moments back. In mode binary n becomes m0. Ignores bits that belong to no field.
void unpack_moments(Mode mode, int columns, const std::uint8_t* payload, const MomentsView& out);

// The same with Select::strongest. In mode binary a word tells of `second` only whether it is 8 or more (half the
// strongest run, or more), and comes back as 8 or 0.
void pack_runs(Mode mode, int columns, const RunsView& runs, std::uint8_t* payload);
void unpack_runs(Mode mode, int columns, const std::uint8_t* payload, const RunsView& out);

// Either of the two, as `select` says. With Select::all they do not touch `runs` and `second`.
void pack_columns(Select select, Mode mode, int columns, const RunsView& runs, std::uint8_t* payload);
void unpack_columns(Select select, Mode mode, int columns, const std::uint8_t* payload, const RunsView& out);

// Writes the first `columns` words of a line of a code image (model/code_word.h), two bytes each, without the zeros
// that follow. Throws as above.
void pack_codes(int columns, const std::uint16_t* codes, std::uint8_t* payload);

// Reads them back.
void unpack_codes(int columns, const std::uint8_t* payload, std::uint16_t* codes);

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_PACKET_PAYLOAD_H
