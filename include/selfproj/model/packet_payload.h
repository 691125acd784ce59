// Payloads: their contents, sizes, packing and unpacking. The formats are those of model/spec; docs/packet-reference.md
// has their table.
#ifndef SELFPROJ_MODEL_PACKET_PAYLOAD_H
#define SELFPROJ_MODEL_PACKET_PAYLOAD_H

#include <cstddef>
#include <cstdint>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/little_endian.h"

namespace selfproj::model {

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

// The same of pixels of 9 to 12 bits: words wide_grey in the grey modes. Payloads are as long.
void pack_wide_moments(Mode mode, int columns, const MomentsView& moments, std::uint8_t* payload);
void unpack_wide_moments(Mode mode, int columns, const std::uint8_t* payload, const MomentsView& out);

// The same of a build for more than spec::kMaxRows rows, in mode binary: words tall_binary, which tell nothing of
// further runs. With Select::strongest `runs` come back as 1, or 0 without light, and `second` as 0. In the grey modes
// such a build has the words above.
void pack_tall_binary(int columns, const MomentsView& moments, std::uint8_t* payload);
void unpack_tall_binary(Select select, int columns, const std::uint8_t* payload, const RunsView& out);

// The same with Select::strongest. In mode binary a word tells of `second` only whether it is 8 or more (half the
// strongest run, or more), and comes back as 8 or 0.
void pack_runs(Mode mode, int columns, const RunsView& runs, std::uint8_t* payload);
void unpack_runs(Mode mode, int columns, const std::uint8_t* payload, const RunsView& out);

// The same of pixels of 9 to 12 bits: words wide_grey_run in the grey modes. N comes back as 63 where it is more, and
// the number of runs as 0, 1, or 2 where `second` is not 0, because a word does not tell it.
void pack_wide_runs(Mode mode, int columns, const RunsView& runs, std::uint8_t* payload);
void unpack_wide_runs(Mode mode, int columns, const std::uint8_t* payload, const RunsView& out);

// Either of the two, as `select` says. With Select::all they do not touch `runs` and `second`.
void pack_columns(Select select, Mode mode, int columns, const RunsView& runs, std::uint8_t* payload);
void unpack_columns(Select select, Mode mode, int columns, const std::uint8_t* payload, const RunsView& out);

// A column as the circuit divides it (kind compact), from its moments in a grey mode, as measure_columns gives them:
//
//     centroid = floor(512 M1 / M0 + 1/2)   n = min(N, 63)
//     quality  = 16 runs + min(second, 15)  with Select::strongest
//                floor(64 M0 / (2^bits N))  with Select::all: the mean weight of a lit pixel, in 1/64
//
// 0 where N is 0. With pixels of more than 8 bits, or `tall`, `runs` counts as 1, or as 2 where `second` is not 0,
// because the circuit's words tell no more (wide_grey_run). With M1 <= 2047 M0 and M0 < 2^bits N no field overflows.
// The centroid is within 1/1024 row of M1 / M0, because it is the nearest multiple of 1/512; halves are rounded up.
std::uint32_t compact_word(Select select, std::uint32_t m0, std::uint32_t m1, std::uint32_t n, std::uint8_t runs,
                           std::uint8_t second, int bits = spec::kPixelBits, bool tall = false);

// What unpack_compact gives as M0 of a column with light.
inline constexpr std::uint32_t kCompactM0 = 512;

// Bytes of compact columns: 4 for each, filled up with zeros to a multiple of 16. Throws as moments_payload_bytes.
std::size_t compact_payload_bytes(int columns);

// Writes compact_word of each column, compact_payload_bytes(columns) bytes.
void pack_compact(Select select, int columns, const RunsView& runs, std::uint8_t* payload, int bits = spec::kPixelBits,
                  bool tall = false);

// Reads compact columns back: M0 is kCompactM0 or 0, M1 the centroid in 1/512 rows, so that M1 / M0 is the centroid;
// n, runs and `second` are as the word has them, at most 63, 3 and 15. With Select::all it does not touch `runs` and
// `second`.
void unpack_compact(Select select, int columns, const std::uint8_t* payload, const RunsView& out);

// Writes the first `columns` words of a line of a code image (include/selfproj/model/gray_decoder.h), two bytes each,
// without the zeros that follow. Throws as above.
void pack_codes(int columns, const std::uint16_t* codes, std::uint8_t* payload);

// Reads them back.
void unpack_codes(int columns, const std::uint8_t* payload, std::uint16_t* codes);

// The words of a moments packet, unpacked inside the caller's loop, for code that processes them immediately.

// A field of `bits` bits that begins at bit `lsb`.
template <typename Word>
[[gnu::always_inline]] constexpr Word field_of(Word word, int lsb, int bits) {
  return word >> static_cast<unsigned>(lsb) & ((Word{1} << static_cast<unsigned>(bits)) - 1);
}

// Calls take(i, m0, m1, n) with the moments of column first + i, i = 0..columns - 1, of a payload in mode binary. All
// are unsigned 32-bit integers, and n is m0. Ignores bits that belong to no field.
template <typename Take>
[[gnu::always_inline]] inline void for_each_binary_word(const std::uint8_t* payload, int first, int columns,
                                                        const Take& take) {
  constexpr std::ptrdiff_t kBytes = spec::kBinaryWordBits / 8;
  const std::uint8_t* words = payload + first * kBytes;
  for (int i = 0; i < columns; ++i) {
    const auto word = load_little_endian<std::uint32_t>(words + i * kBytes);
    const std::uint32_t m0 = field_of(word, spec::kBinaryM0Lsb, spec::kBinaryM0Bits);
    take(i, m0, field_of(word, spec::kBinaryM1Lsb, spec::kBinaryM1Bits), m0);
  }
}

// The same for a payload of words tall_binary.
template <typename Take>
[[gnu::always_inline]] inline void for_each_tall_binary_word(const std::uint8_t* payload, int first, int columns,
                                                             const Take& take) {
  constexpr std::ptrdiff_t kBytes = spec::kTallBinaryWordBits / 8;
  const std::uint8_t* words = payload + first * kBytes;
  for (int i = 0; i < columns; ++i) {
    const auto word = load_little_endian<std::uint32_t>(words + i * kBytes);
    const std::uint32_t m0 = field_of(word, spec::kTallBinaryM0Lsb, spec::kTallBinaryM0Bits);
    take(i, m0, field_of(word, spec::kTallBinaryM1Lsb, spec::kTallBinaryM1Bits), m0);
  }
}

// The same for a payload in a grey mode.
template <typename Take>
[[gnu::always_inline]] inline void for_each_grey_word(const std::uint8_t* payload, int first, int columns,
                                                      const Take& take) {
  constexpr std::ptrdiff_t kBytes = spec::kGreyWordBits / 8;
  const std::uint8_t* words = payload + first * kBytes;
  for (int i = 0; i < columns; ++i) {
    const auto word = load_little_endian<std::uint64_t>(words + i * kBytes);
    take(i, static_cast<std::uint32_t>(field_of(word, spec::kGreyM0Lsb, spec::kGreyM0Bits)),
         static_cast<std::uint32_t>(field_of(word, spec::kGreyM1Lsb, spec::kGreyM1Bits)),
         static_cast<std::uint32_t>(field_of(word, spec::kGreyNLsb, spec::kGreyNBits)));
  }
}

// The same for a payload of words wide_grey.
template <typename Take>
[[gnu::always_inline]] inline void for_each_wide_grey_word(const std::uint8_t* payload, int first, int columns,
                                                           const Take& take) {
  constexpr std::ptrdiff_t kBytes = spec::kWideGreyWordBits / 8;
  const std::uint8_t* words = payload + first * kBytes;
  for (int i = 0; i < columns; ++i) {
    const auto word = load_little_endian<std::uint64_t>(words + i * kBytes);
    take(i, static_cast<std::uint32_t>(field_of(word, spec::kWideGreyM0Lsb, spec::kWideGreyM0Bits)),
         static_cast<std::uint32_t>(field_of(word, spec::kWideGreyM1Lsb, spec::kWideGreyM1Bits)),
         static_cast<std::uint32_t>(field_of(word, spec::kWideGreyNLsb, spec::kWideGreyNBits)));
  }
}

// The words with Select::strongest: calls take(i, m0, m1, n, runs, second), the latter two as std::uint8_t, with the
// strongest run of column first + i of a payload in mode binary. `second` is in sixteenths, as in RunsView; here it is
// 8 or 0, because a word tells only whether it is 8 or more.
template <typename Take>
[[gnu::always_inline]] inline void for_each_binary_run_word(const std::uint8_t* payload, int first, int columns,
                                                            const Take& take) {
  constexpr std::ptrdiff_t kBytes = spec::kBinaryRunWordBits / 8;
  const std::uint8_t* words = payload + first * kBytes;
  for (int i = 0; i < columns; ++i) {
    const auto word = load_little_endian<std::uint32_t>(words + i * kBytes);
    const std::uint32_t m0 = field_of(word, spec::kBinaryRunM0Lsb, spec::kBinaryRunM0Bits);
    const std::uint32_t half = field_of(word, spec::kBinaryRunSecondLsb, spec::kBinaryRunSecondBits);
    take(i, m0, field_of(word, spec::kBinaryRunM1Lsb, spec::kBinaryRunM1Bits), m0,
         static_cast<std::uint8_t>(field_of(word, spec::kBinaryRunRunsLsb, spec::kBinaryRunRunsBits)),
         static_cast<std::uint8_t>(8 * half));
  }
}

// The same for a payload in a grey mode.
template <typename Take>
[[gnu::always_inline]] inline void for_each_grey_run_word(const std::uint8_t* payload, int first, int columns,
                                                          const Take& take) {
  constexpr std::ptrdiff_t kBytes = spec::kGreyRunWordBits / 8;
  const std::uint8_t* words = payload + first * kBytes;
  for (int i = 0; i < columns; ++i) {
    const auto word = load_little_endian<std::uint64_t>(words + i * kBytes);
    take(i, static_cast<std::uint32_t>(field_of(word, spec::kGreyRunM0Lsb, spec::kGreyRunM0Bits)),
         static_cast<std::uint32_t>(field_of(word, spec::kGreyRunM1Lsb, spec::kGreyRunM1Bits)),
         static_cast<std::uint32_t>(field_of(word, spec::kGreyRunNLsb, spec::kGreyRunNBits)),
         static_cast<std::uint8_t>(field_of(word, spec::kGreyRunRunsLsb, spec::kGreyRunRunsBits)),
         static_cast<std::uint8_t>(field_of(word, spec::kGreyRunSecondLsb, spec::kGreyRunSecondBits)));
  }
}

// The same for a payload of words wide_grey_run. `runs` is what pack_wide_runs leaves of it.
template <typename Take>
[[gnu::always_inline]] inline void for_each_wide_grey_run_word(const std::uint8_t* payload, int first, int columns,
                                                               const Take& take) {
  constexpr std::ptrdiff_t kBytes = spec::kWideGreyRunWordBits / 8;
  const std::uint8_t* words = payload + first * kBytes;
  for (int i = 0; i < columns; ++i) {
    const auto word = load_little_endian<std::uint64_t>(words + i * kBytes);
    const auto m0 = static_cast<std::uint32_t>(field_of(word, spec::kWideGreyRunM0Lsb, spec::kWideGreyRunM0Bits));
    const auto second =
        static_cast<std::uint8_t>(field_of(word, spec::kWideGreyRunSecondLsb, spec::kWideGreyRunSecondBits));
    take(i, m0, static_cast<std::uint32_t>(field_of(word, spec::kWideGreyRunM1Lsb, spec::kWideGreyRunM1Bits)),
         static_cast<std::uint32_t>(field_of(word, spec::kWideGreyRunNLsb, spec::kWideGreyRunNBits)),
         static_cast<std::uint8_t>((m0 != 0 ? 1 : 0) + (second != 0 ? 1 : 0)), second);
  }
}

// Compact words: calls take(i, centroid, n, quality), unsigned 32-bit integers, of column first + i.
template <typename Take>
[[gnu::always_inline]] inline void for_each_compact_word(const std::uint8_t* payload, int first, int columns,
                                                         const Take& take) {
  constexpr std::ptrdiff_t kBytes = spec::kCompactWordBits / 8;
  const std::uint8_t* words = payload + first * kBytes;
  for (int i = 0; i < columns; ++i) {
    const auto word = load_little_endian<std::uint32_t>(words + i * kBytes);
    take(i, field_of(word, spec::kCompactCentroidLsb, spec::kCompactCentroidBits),
         field_of(word, spec::kCompactNLsb, spec::kCompactNBits),
         field_of(word, spec::kCompactQualityLsb, spec::kCompactQualityBits));
  }
}

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_PACKET_PAYLOAD_H
