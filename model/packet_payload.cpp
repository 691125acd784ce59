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

// The words of runs and of wide pixels are as long as those of moments.
static_assert(spec::kBinaryRunWordBits == spec::kBinaryWordBits && spec::kGreyRunWordBits == spec::kGreyWordBits &&
              spec::kWideGreyWordBits == spec::kGreyWordBits && spec::kWideGreyRunWordBits == spec::kGreyWordBits &&
              spec::kTallBinaryWordBits == spec::kBinaryWordBits);
// The words of a grey mode and more rows are wide ones.
static_assert(spec::kTallGreyM0Lsb == spec::kWideGreyM0Lsb && spec::kTallGreyNLsb == spec::kWideGreyNLsb &&
              spec::kTallGreyM0Lsb == spec::kWideGreyRunM0Lsb && spec::kTallGreyNLsb == spec::kWideGreyRunNLsb);

constexpr int kHalf = 8;  // the second run has half of the strongest, in sixteenths

constexpr std::uint32_t ones32(int bits) { return (std::uint32_t{1} << bits) - 1; }
constexpr std::uint64_t ones64(int bits) { return (std::uint64_t{1} << bits) - 1; }

constexpr std::size_t whole_beats(std::size_t bytes) {
  return (bytes + spec::kPacketBeatBytes - 1) / spec::kPacketBeatBytes * spec::kPacketBeatBytes;
}

std::size_t moments_bytes(Mode mode, std::size_t columns) {
  return whole_beats(columns * (mode == Mode::binary ? kBinaryBytes : kGreyBytes));
}

// Where a word of a grey mode has its fields
struct GreyFields {
  int m1_lsb, m1_bits, m0_lsb, m0_bits, n_lsb, n_bits;
};
constexpr GreyFields kGrey{spec::kGreyM1Lsb,  spec::kGreyM1Bits, spec::kGreyM0Lsb,
                           spec::kGreyM0Bits, spec::kGreyNLsb,   spec::kGreyNBits};
constexpr GreyFields kWideGrey{spec::kWideGreyM1Lsb,  spec::kWideGreyM1Bits, spec::kWideGreyM0Lsb,
                               spec::kWideGreyM0Bits, spec::kWideGreyNLsb,   spec::kWideGreyNBits};

template <const GreyFields& At>
void store_grey_words(std::size_t count, const MomentsView& moments, std::uint8_t* __restrict words) {
  const std::uint32_t* m0 = moments.m0;
  const std::uint32_t* m1 = moments.m1;
  const std::uint32_t* n = moments.n;
  for (std::size_t i = 0; i < count; ++i) {
    store_little_endian(words + i * kGreyBytes, (m1[i] & ones64(At.m1_bits)) << At.m1_lsb |
                                                    (m0[i] & ones64(At.m0_bits)) << At.m0_lsb |
                                                    (n[i] & ones64(At.n_bits)) << At.n_lsb);
  }
}

// What unpacked runs are written with.
auto store_runs(const RunsView& to) {
  return [to](int i, std::uint32_t m0, std::uint32_t m1, std::uint32_t n, std::uint8_t runs, std::uint8_t second) {
    to.moments.m0[i] = m0;
    to.moments.m1[i] = m1;
    to.moments.n[i] = n;
    to.runs[i] = runs;
    to.second[i] = second;
  };
}

std::size_t checked(int columns) {
  if (columns < 0) {
    throw std::invalid_argument("packet: columns are negative");
  }
  return static_cast<std::size_t>(columns);
}

std::size_t checked(Mode mode, int columns) {
  if (!is_known(mode)) {
    throw std::invalid_argument("packet: unknown mode");
  }
  return checked(columns);
}

}  // namespace

bool is_known(Mode mode) { return mode == Mode::binary || mode == Mode::grey || mode == Mode::grey_over; }

bool is_known(Select select) { return select == Select::all || select == Select::strongest; }

std::size_t moments_payload_bytes(Mode mode, int columns) { return moments_bytes(mode, checked(mode, columns)); }

std::size_t image_line_payload_bytes(int columns) { return whole_beats(checked(columns) * kPixelBytes); }

std::size_t codes_line_payload_bytes(int columns) { return whole_beats(checked(columns) * kCodeBytes); }

void pack_moments(Mode mode, int columns, const MomentsView& moments, std::uint8_t* payload) {
  const std::size_t count = checked(mode, columns);
  const std::uint32_t* m0 = moments.m0;
  const std::uint32_t* m1 = moments.m1;
  std::uint8_t* __restrict words = payload;
  std::size_t used = 0;
  if (mode == Mode::binary) {
    for (std::size_t i = 0; i < count; ++i) {
      store_little_endian(words + i * kBinaryBytes, (m1[i] & ones32(spec::kBinaryM1Bits)) << spec::kBinaryM1Lsb |
                                                        (m0[i] & ones32(spec::kBinaryM0Bits)) << spec::kBinaryM0Lsb);
    }
    used = count * kBinaryBytes;
  } else {
    store_grey_words<kGrey>(count, moments, words);
    used = count * kGreyBytes;
  }
  std::fill(payload + used, payload + moments_bytes(mode, count), std::uint8_t{0});
}

void unpack_moments(Mode mode, int columns, const std::uint8_t* payload, const MomentsView& out) {
  checked(mode, columns);
  std::uint32_t* __restrict to_m0 = out.m0;
  std::uint32_t* __restrict to_m1 = out.m1;
  std::uint32_t* __restrict to_n = out.n;
  const auto store = [&](int i, std::uint32_t m0, std::uint32_t m1, std::uint32_t n) {
    to_m0[i] = m0;
    to_m1[i] = m1;
    to_n[i] = n;
  };
  if (mode == Mode::binary) {
    for_each_binary_word(payload, 0, columns, store);
  } else {
    for_each_grey_word(payload, 0, columns, store);
  }
}

void pack_wide_moments(Mode mode, int columns, const MomentsView& moments, std::uint8_t* payload) {
  if (mode == Mode::binary) {
    pack_moments(mode, columns, moments, payload);
    return;
  }
  const std::size_t count = checked(mode, columns);
  store_grey_words<kWideGrey>(count, moments, payload);
  std::fill(payload + count * kGreyBytes, payload + moments_bytes(mode, count), std::uint8_t{0});
}

void unpack_wide_moments(Mode mode, int columns, const std::uint8_t* payload, const MomentsView& out) {
  if (mode == Mode::binary) {
    unpack_moments(mode, columns, payload, out);
    return;
  }
  checked(mode, columns);
  for_each_wide_grey_word(payload, 0, columns, [&](int i, std::uint32_t m0, std::uint32_t m1, std::uint32_t n) {
    out.m0[i] = m0;
    out.m1[i] = m1;
    out.n[i] = n;
  });
}

void pack_tall_binary(int columns, const MomentsView& moments, std::uint8_t* payload) {
  const std::size_t count = checked(columns);
  for (std::size_t i = 0; i < count; ++i) {
    store_little_endian(payload + i * kBinaryBytes,
                        (moments.m1[i] & ones32(spec::kTallBinaryM1Bits)) << spec::kTallBinaryM1Lsb |
                            (moments.m0[i] & ones32(spec::kTallBinaryM0Bits)) << spec::kTallBinaryM0Lsb);
  }
  std::fill(payload + count * kBinaryBytes, payload + moments_bytes(Mode::binary, count), std::uint8_t{0});
}

void unpack_tall_binary(Select select, int columns, const std::uint8_t* payload, const RunsView& out) {
  for_each_tall_binary_word(payload, 0, columns, [&](int i, std::uint32_t m0, std::uint32_t m1, std::uint32_t n) {
    out.moments.m0[i] = m0;
    out.moments.m1[i] = m1;
    out.moments.n[i] = n;
    if (select == Select::strongest) {
      out.runs[i] = m0 != 0 ? 1 : 0;
      out.second[i] = 0;
    }
  });
}

void pack_runs(Mode mode, int columns, const RunsView& runs, std::uint8_t* payload) {
  const std::size_t count = checked(mode, columns);
  const MomentsView& moments = runs.moments;
  std::uint8_t* word = payload;
  for (std::size_t i = 0; i < count; ++i) {
    if (mode == Mode::binary) {
      const std::uint32_t half = runs.second[i] >= kHalf ? 1 : 0;
      store_little_endian(word, (moments.m1[i] & ones32(spec::kBinaryRunM1Bits)) << spec::kBinaryRunM1Lsb |
                                    half << spec::kBinaryRunSecondLsb |
                                    (moments.m0[i] & ones32(spec::kBinaryRunM0Bits)) << spec::kBinaryRunM0Lsb |
                                    (runs.runs[i] & ones32(spec::kBinaryRunRunsBits)) << spec::kBinaryRunRunsLsb);
      word += kBinaryBytes;
    } else {
      store_little_endian(word, (moments.m1[i] & ones64(spec::kGreyRunM1Bits)) << spec::kGreyRunM1Lsb |
                                    (moments.m0[i] & ones64(spec::kGreyRunM0Bits)) << spec::kGreyRunM0Lsb |
                                    (moments.n[i] & ones64(spec::kGreyRunNBits)) << spec::kGreyRunNLsb |
                                    (runs.runs[i] & ones64(spec::kGreyRunRunsBits)) << spec::kGreyRunRunsLsb |
                                    (runs.second[i] & ones64(spec::kGreyRunSecondBits)) << spec::kGreyRunSecondLsb);
      word += kGreyBytes;
    }
  }
  std::fill(word, payload + moments_bytes(mode, count), std::uint8_t{0});
}

void unpack_runs(Mode mode, int columns, const std::uint8_t* payload, const RunsView& out) {
  checked(mode, columns);
  if (mode == Mode::binary) {
    for_each_binary_run_word(payload, 0, columns, store_runs(out));
  } else {
    for_each_grey_run_word(payload, 0, columns, store_runs(out));
  }
}

void pack_wide_runs(Mode mode, int columns, const RunsView& runs, std::uint8_t* payload) {
  if (mode == Mode::binary) {
    pack_runs(mode, columns, runs, payload);
    return;
  }
  const std::size_t count = checked(mode, columns);
  const MomentsView& moments = runs.moments;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t n = std::min<std::uint64_t>(moments.n[i], spec::kWideGreyRunNMax);
    store_little_endian(payload + i * kGreyBytes,
                        (moments.m1[i] & ones64(spec::kWideGreyRunM1Bits)) << spec::kWideGreyRunM1Lsb |
                            (moments.m0[i] & ones64(spec::kWideGreyRunM0Bits)) << spec::kWideGreyRunM0Lsb |
                            n << spec::kWideGreyRunNLsb |
                            (runs.second[i] & ones64(spec::kWideGreyRunSecondBits)) << spec::kWideGreyRunSecondLsb);
  }
  std::fill(payload + count * kGreyBytes, payload + moments_bytes(mode, count), std::uint8_t{0});
}

void unpack_wide_runs(Mode mode, int columns, const std::uint8_t* payload, const RunsView& out) {
  checked(mode, columns);
  if (mode == Mode::binary) {
    for_each_binary_run_word(payload, 0, columns, store_runs(out));
  } else {
    for_each_wide_grey_run_word(payload, 0, columns, store_runs(out));
  }
}

void pack_columns(Select select, Mode mode, int columns, const RunsView& runs, std::uint8_t* payload) {
  if (select == Select::strongest) {
    pack_runs(mode, columns, runs, payload);
  } else {
    pack_moments(mode, columns, runs.moments, payload);
  }
}

void unpack_columns(Select select, Mode mode, int columns, const std::uint8_t* payload, const RunsView& out) {
  if (select == Select::strongest) {
    unpack_runs(mode, columns, payload, out);
  } else {
    unpack_moments(mode, columns, payload, out.moments);
  }
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

void unpack_compact(Select select, int columns, const std::uint8_t* payload, const RunsView& out) {
  const RunsView to = out;
  const bool strongest = select == Select::strongest;
  for_each_compact_word(payload, 0, columns,
                        [&](int i, std::uint32_t centroid, std::uint32_t n, std::uint32_t quality) {
                          to.moments.m0[i] = centroid != 0 ? kCompactM0 : 0;
                          to.moments.m1[i] = centroid;
                          to.moments.n[i] = n;
                          if (strongest) {
                            to.runs[i] = static_cast<std::uint8_t>(quality >> 4U);
                            to.second[i] = static_cast<std::uint8_t>(quality & 15U);
                          }
                        });
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
