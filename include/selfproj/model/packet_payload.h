// Payloads: their contents, sizes, packing and unpacking. The formats are those of model/spec; docs/packet-reference.md
// has their table.
#ifndef SELFPROJ_MODEL_PACKET_PAYLOAD_H
#define SELFPROJ_MODEL_PACKET_PAYLOAD_H

#include <cstddef>
#include <cstdint>
#include <type_traits>

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

// The words that a payload has for its columns. Those that end in _run are those with Select::strongest: they tell of
// the strongest run, and of what there is besides it as far as they have room.
enum class ColumnWord : std::uint8_t {
  binary,       // of mode binary
  grey,         // of the grey modes
  wide_grey,    // of the grey modes, with pixels of 9 to 12 bits or a build for more than spec::kMaxRows rows
  tall_binary,  // of mode binary and such a build
  compact,      // divided by the circuit, in a grey mode
  binary_run,
  grey_run,
  wide_grey_run,
  tall_binary_run,  // is tall_binary
  compact_run,
};

constexpr bool is_run(ColumnWord word) { return word >= ColumnWord::binary_run; }

// The word of exact columns. `wide`: pixels have more than 8 bits; `tall`: a build for more than spec::kMaxRows rows.
constexpr ColumnWord column_word(Select select, Mode mode, bool wide = false, bool tall = false) {
  const bool run = select == Select::strongest;
  if (mode == Mode::binary) {
    return tall ? (run ? ColumnWord::tall_binary_run : ColumnWord::tall_binary)
                : (run ? ColumnWord::binary_run : ColumnWord::binary);
  }
  return wide || tall ? (run ? ColumnWord::wide_grey_run : ColumnWord::wide_grey)
                      : (run ? ColumnWord::grey_run : ColumnWord::grey);
}

// A column as a word tells it. Where the word has no field, or a smaller one:
//
//     n        m0 in mode binary; at most 63 in wide_grey_run and compact words
//     runs     0, 1, or 2 where `second` is not 0; at most 3
//     second   in sixteenths, as in RunsView: 0 or 8 (half the strongest run, or more) in binary_run, at most 15 in
//              compact_run, else 0
//     m0, m1   of compact words kCompactM0 or 0, and the centroid in 1/512 rows, so that M1 / M0 is the centroid
struct Column {
  std::uint32_t m0, m1, n;
  std::uint8_t runs, second;
};

// M0 of a compact column with light.
inline constexpr std::uint32_t kCompactM0 = 512;

// Writes exact columns as payload words, moments_payload_bytes bytes. `runs` need what the word has. A value wider than
// its field loses its high bits, but N in wide_grey_run is at most 63; measure_columns never gives another one. Throws
// std::invalid_argument if columns are negative, or the words are compact (pack_compact).
void pack_columns(ColumnWord word, int columns, const RunsView& runs, std::uint8_t* payload);

// Reads columns back, as in Column. Does not touch `runs` and `second` unless is_run(word). Ignores bits that belong to
// no field.
void unpack_columns(ColumnWord word, int columns, const std::uint8_t* payload, const RunsView& out);

// The same with Select::all and pixels of 8 bits.
inline void pack_moments(Mode mode, int columns, const MomentsView& moments, std::uint8_t* payload) {
  pack_columns(column_word(Select::all, mode), columns, {.moments = moments}, payload);
}
inline void unpack_moments(Mode mode, int columns, const std::uint8_t* payload, const MomentsView& out) {
  unpack_columns(column_word(Select::all, mode), columns, payload, {.moments = out});
}

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

// Bytes of compact columns: 4 for each, filled up with zeros to a multiple of 16. Throws as moments_payload_bytes.
std::size_t compact_payload_bytes(int columns);

// Writes compact_word of each column, compact_payload_bytes(columns) bytes.
void pack_compact(Select select, int columns, const RunsView& runs, std::uint8_t* payload, int bits = spec::kPixelBits,
                  bool tall = false);

// Writes the first `columns` words of a line of a code image (include/selfproj/model/gray_decoder.h), two bytes each,
// without the zeros that follow. Throws as above.
void pack_codes(int columns, const std::uint16_t* codes, std::uint8_t* payload);

// Reads them back.
void unpack_codes(int columns, const std::uint8_t* payload, std::uint16_t* codes);

// Where a word has its fields. Those without bits are not in it.
struct WordField {
  int lsb = 0;
  int bits = 0;
};
struct WordFields {
  int word_bits = 0;
  WordField m1 = {}, m0 = {}, n = {}, runs = {}, second = {};
};

constexpr WordFields fields_of(ColumnWord word) {
  switch (word) {
    case ColumnWord::binary:
      return {.word_bits = spec::kBinaryWordBits,
              .m1 = {spec::kBinaryM1Lsb, spec::kBinaryM1Bits},
              .m0 = {spec::kBinaryM0Lsb, spec::kBinaryM0Bits}};
    case ColumnWord::grey:
      return {.word_bits = spec::kGreyWordBits,
              .m1 = {spec::kGreyM1Lsb, spec::kGreyM1Bits},
              .m0 = {spec::kGreyM0Lsb, spec::kGreyM0Bits},
              .n = {spec::kGreyNLsb, spec::kGreyNBits}};
    case ColumnWord::wide_grey:
      return {.word_bits = spec::kWideGreyWordBits,
              .m1 = {spec::kWideGreyM1Lsb, spec::kWideGreyM1Bits},
              .m0 = {spec::kWideGreyM0Lsb, spec::kWideGreyM0Bits},
              .n = {spec::kWideGreyNLsb, spec::kWideGreyNBits}};
    case ColumnWord::tall_binary:
    case ColumnWord::tall_binary_run:
      return {.word_bits = spec::kTallBinaryWordBits,
              .m1 = {spec::kTallBinaryM1Lsb, spec::kTallBinaryM1Bits},
              .m0 = {spec::kTallBinaryM0Lsb, spec::kTallBinaryM0Bits}};
    case ColumnWord::binary_run:
      return {.word_bits = spec::kBinaryRunWordBits,
              .m1 = {spec::kBinaryRunM1Lsb, spec::kBinaryRunM1Bits},
              .m0 = {spec::kBinaryRunM0Lsb, spec::kBinaryRunM0Bits},
              .runs = {spec::kBinaryRunRunsLsb, spec::kBinaryRunRunsBits},
              .second = {spec::kBinaryRunSecondLsb, spec::kBinaryRunSecondBits}};
    case ColumnWord::grey_run:
      return {.word_bits = spec::kGreyRunWordBits,
              .m1 = {spec::kGreyRunM1Lsb, spec::kGreyRunM1Bits},
              .m0 = {spec::kGreyRunM0Lsb, spec::kGreyRunM0Bits},
              .n = {spec::kGreyRunNLsb, spec::kGreyRunNBits},
              .runs = {spec::kGreyRunRunsLsb, spec::kGreyRunRunsBits},
              .second = {spec::kGreyRunSecondLsb, spec::kGreyRunSecondBits}};
    case ColumnWord::wide_grey_run:
      return {.word_bits = spec::kWideGreyRunWordBits,
              .m1 = {spec::kWideGreyRunM1Lsb, spec::kWideGreyRunM1Bits},
              .m0 = {spec::kWideGreyRunM0Lsb, spec::kWideGreyRunM0Bits},
              .n = {spec::kWideGreyRunNLsb, spec::kWideGreyRunNBits},
              .second = {spec::kWideGreyRunSecondLsb, spec::kWideGreyRunSecondBits}};
    case ColumnWord::compact:
      return {.word_bits = spec::kCompactWordBits,
              .m1 = {spec::kCompactCentroidLsb, spec::kCompactCentroidBits},
              .n = {spec::kCompactNLsb, spec::kCompactNBits}};
    case ColumnWord::compact_run:  // its quality is 16 runs + second
      return {.word_bits = spec::kCompactWordBits,
              .m1 = {spec::kCompactCentroidLsb, spec::kCompactCentroidBits},
              .n = {spec::kCompactNLsb, spec::kCompactNBits},
              .runs = {spec::kCompactQualityLsb + 4, spec::kCompactQualityBits - 4},
              .second = {spec::kCompactQualityLsb, 4}};
  }
  return {};
}

// A field of `bits` bits that begins at bit `lsb`.
template <typename Word>
[[gnu::always_inline]] constexpr Word field_of(Word word, int lsb, int bits) {
  return word >> static_cast<unsigned>(lsb) & ((Word{1} << static_cast<unsigned>(bits)) - 1);
}

// Calls take(i, column) with the columns first + i, i = 0..columns - 1, of a payload of such words: for code that
// processes them immediately, inside its own loop.
template <ColumnWord Word, typename Take>
[[gnu::always_inline]] inline void for_each_column(const std::uint8_t* payload, int first, int columns,
                                                   const Take& take) {
  constexpr WordFields kAt = fields_of(Word);
  using Bits = std::conditional_t<kAt.word_bits == 32, std::uint32_t, std::uint64_t>;
  constexpr std::ptrdiff_t kBytes = sizeof(Bits);
  const std::uint8_t* words = payload + first * kBytes;
  for (int i = 0; i < columns; ++i) {
    const auto word = load_little_endian<Bits>(words + i * kBytes);
    const auto field = [word](WordField at) { return static_cast<std::uint32_t>(field_of(word, at.lsb, at.bits)); };
    const std::uint32_t m1 = field(kAt.m1);
    const std::uint32_t m0 = kAt.m0.bits != 0 ? field(kAt.m0) : m1 != 0 ? kCompactM0 : 0;
    const std::uint32_t second = kAt.second.bits == 1 ? 8 * field(kAt.second) : field(kAt.second);
    const std::uint32_t runs = kAt.runs.bits != 0 ? field(kAt.runs) : (m0 != 0 ? 1U : 0U) + (second != 0 ? 1U : 0U);
    take(i, Column{m0, m1, kAt.n.bits != 0 ? field(kAt.n) : m0, static_cast<std::uint8_t>(runs),
                   static_cast<std::uint8_t>(second)});
  }
}

// Calls call.operator()<Word>(), where Word is the constant of this value.
template <typename Call>
[[gnu::always_inline]] inline void with_word(ColumnWord word, const Call& call) {
  switch (word) {
    case ColumnWord::binary:
      return call.template operator()<ColumnWord::binary>();
    case ColumnWord::grey:
      return call.template operator()<ColumnWord::grey>();
    case ColumnWord::wide_grey:
      return call.template operator()<ColumnWord::wide_grey>();
    case ColumnWord::tall_binary:
      return call.template operator()<ColumnWord::tall_binary>();
    case ColumnWord::compact:
      return call.template operator()<ColumnWord::compact>();
    case ColumnWord::binary_run:
      return call.template operator()<ColumnWord::binary_run>();
    case ColumnWord::grey_run:
      return call.template operator()<ColumnWord::grey_run>();
    case ColumnWord::wide_grey_run:
      return call.template operator()<ColumnWord::wide_grey_run>();
    case ColumnWord::tall_binary_run:
      return call.template operator()<ColumnWord::tall_binary_run>();
    case ColumnWord::compact_run:
      return call.template operator()<ColumnWord::compact_run>();
  }
}

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_PACKET_PAYLOAD_H
