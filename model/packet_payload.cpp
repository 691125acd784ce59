#include "selfproj/model/packet_payload.h"

#include <algorithm>
#include <stdexcept>

#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/little_endian.h"

namespace selfproj::model {
namespace {

constexpr std::size_t kBinaryBytes = spec::kBinaryWordBits / 8;
constexpr std::size_t kGreyBytes = spec::kGreyWordBits / 8;
constexpr std::size_t kCompactBytes = spec::kCompactWordBits / 8;
constexpr std::size_t kCodeBytes = spec::kCodeWordBits / 8;
constexpr std::size_t kPixelBytes = spec::kPixelBits / 8;

// moments_payload_bytes has no other words.
static_assert(spec::kBinaryRunWordBits == spec::kBinaryWordBits && spec::kGreyRunWordBits == spec::kGreyWordBits &&
              spec::kWideGreyWordBits == spec::kGreyWordBits && spec::kWideGreyRunWordBits == spec::kGreyWordBits &&
              spec::kTallBinaryWordBits == spec::kBinaryWordBits);
// The words of a grey mode and more rows are wide ones.
static_assert(spec::kTallGreyM0Lsb == spec::kWideGreyM0Lsb && spec::kTallGreyNLsb == spec::kWideGreyNLsb &&
              spec::kTallGreyM0Lsb == spec::kWideGreyRunM0Lsb && spec::kTallGreyNLsb == spec::kWideGreyRunNLsb);

constexpr int kHalf = 8;  // the second run has half of the strongest, in sixteenths

constexpr std::uint32_t ones32(int bits) { return (std::uint32_t{1} << bits) - 1; }

constexpr std::size_t whole_beats(std::size_t bytes) {
  return (bytes + spec::kPacketBeatBytes - 1) / spec::kPacketBeatBytes * spec::kPacketBeatBytes;
}

std::size_t checked(int columns) {
  if (columns < 0) {
    throw std::invalid_argument("packet: columns are negative");
  }
  return static_cast<std::size_t>(columns);
}

template <ColumnWord Word>
void store_words(std::size_t count, const RunsView& runs, std::uint8_t* __restrict words) {
  constexpr WordFields kAt = fields_of(Word);
  using Bits = std::conditional_t<kAt.word_bits == 32, std::uint32_t, std::uint64_t>;
  const RunsView from = runs;  // by value, so that no store can change it
  const auto in_place = [](Bits value, WordField at) { return (value & ((Bits{1} << at.bits) - 1)) << at.lsb; };
  for (std::size_t i = 0; i < count; ++i) {
    Bits word = in_place(from.moments.m1[i], kAt.m1) | in_place(from.moments.m0[i], kAt.m0);
    if constexpr (kAt.n.bits != 0) {
      const std::uint32_t n = from.moments.n[i];
      word |= in_place(Word == ColumnWord::wide_grey_run ? std::min<Bits>(n, spec::kWideGreyRunNMax) : n, kAt.n);
    }
    if constexpr (kAt.runs.bits != 0) {
      word |= in_place(from.runs[i], kAt.runs);
    }
    if constexpr (kAt.second.bits != 0) {
      word |= in_place(kAt.second.bits == 1 ? from.second[i] >= kHalf : from.second[i], kAt.second);
    }
    store_little_endian(words + i * sizeof(Bits), word);
  }
}

}  // namespace

bool is_known(Mode mode) { return mode == Mode::binary || mode == Mode::grey || mode == Mode::grey_over; }

bool is_known(Select select) { return select == Select::all || select == Select::strongest; }

std::size_t moments_payload_bytes(Mode mode, int columns) {
  if (!is_known(mode)) {
    throw std::invalid_argument("packet: unknown mode");
  }
  return whole_beats(checked(columns) * (mode == Mode::binary ? kBinaryBytes : kGreyBytes));
}

std::size_t image_line_payload_bytes(int columns) { return whole_beats(checked(columns) * kPixelBytes); }

std::size_t codes_line_payload_bytes(int columns) { return whole_beats(checked(columns) * kCodeBytes); }

void pack_columns(ColumnWord word, int columns, const RunsView& runs, std::uint8_t* payload) {
  const std::size_t count = checked(columns);
  with_word(word, [&]<ColumnWord Word>() {
    if constexpr (Word == ColumnWord::compact || Word == ColumnWord::compact_run) {
      throw std::invalid_argument("packet: compact words are not exact");
    } else {
      store_words<Word>(count, runs, payload);
      const std::size_t used = count * fields_of(Word).word_bits / 8;
      std::fill(payload + used, payload + whole_beats(used), std::uint8_t{0});
    }
  });
}

void unpack_columns(ColumnWord word, int columns, const std::uint8_t* payload, const RunsView& out) {
  checked(columns);
  std::uint32_t* __restrict m0 = out.moments.m0;
  std::uint32_t* __restrict m1 = out.moments.m1;
  std::uint32_t* __restrict n = out.moments.n;
  std::uint8_t* __restrict runs = out.runs;
  std::uint8_t* __restrict second = out.second;
  with_word(word, [&]<ColumnWord Word>() {
    for_each_column<Word>(payload, 0, columns, [=](int i, const Column& column) {
      m0[i] = column.m0;
      m1[i] = column.m1;
      n[i] = column.n;
      if constexpr (is_run(Word)) {
        runs[i] = column.runs;
        second[i] = column.second;
      }
    });
  });
}

std::uint32_t compact_word(Select select, std::uint32_t m0, std::uint32_t m1, std::uint32_t n, std::uint8_t runs,
                           std::uint8_t second, int bits, bool tall) {
  if (n == 0 || m0 == 0) {
    return 0;
  }
  constexpr std::uint32_t kMostSecond = 15;
  const auto centroid = static_cast<std::uint32_t>((std::uint64_t{kCompactM0} * m1 + m0 / 2) / m0);
  const std::uint32_t told = bits == spec::kPixelBits && !tall ? runs : second != 0 ? 2 : 1;
  const std::uint32_t quality = select == Select::strongest ? 16U * told + std::min<std::uint32_t>(second, kMostSecond)
                                                            : (m0 >> (bits - spec::kCompactQualityBits)) / n;
  return (centroid & ones32(spec::kCompactCentroidBits)) << spec::kCompactCentroidLsb |
         std::min<std::uint32_t>(n, spec::kCompactNMax) << spec::kCompactNLsb |
         (quality & ones32(spec::kCompactQualityBits)) << spec::kCompactQualityLsb;
}

std::size_t compact_payload_bytes(int columns) { return whole_beats(checked(columns) * kCompactBytes); }

void pack_compact(Select select, int columns, const RunsView& runs, std::uint8_t* payload, int bits, bool tall) {
  const bool strongest = select == Select::strongest;
  const MomentsView& of = runs.moments;
  std::uint8_t* word = payload;
  for (std::size_t i = 0; i < checked(columns); ++i) {
    store_little_endian(word,
                        compact_word(select, of.m0[i], of.m1[i], of.n[i], strongest ? runs.runs[i] : std::uint8_t{0},
                                     strongest ? runs.second[i] : std::uint8_t{0}, bits, tall));
    word += kCompactBytes;
  }
  std::fill(word, payload + compact_payload_bytes(columns), std::uint8_t{0});
}

void pack_codes(int columns, const std::uint16_t* codes, std::uint8_t* payload) {
  const std::size_t count = checked(columns);
  for (std::size_t i = 0; i < count; ++i) {
    store_little_endian(payload + i * kCodeBytes, codes[i]);
  }
}

void unpack_codes(int columns, const std::uint8_t* payload, std::uint16_t* codes) {
  const std::size_t count = checked(columns);
  for (std::size_t i = 0; i < count; ++i) {
    codes[i] = load_little_endian<std::uint16_t>(payload + i * kCodeBytes);
  }
}

}  // namespace selfproj::model
