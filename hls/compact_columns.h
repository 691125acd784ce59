// Divided columns: the kernel that makes compact payload of the payload of a grey mode, as sp_compact_words does
// (compact_word in include/selfproj/model/packet_payload.h is the definition).
#ifndef SELFPROJ_HLS_COMPACT_COLUMNS_H
#define SELFPROJ_HLS_COMPACT_COLUMNS_H

#include "hls/moments_arithmetic.h"
#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
// NOLINTBEGIN(performance-unnecessary-value-param)
namespace selfproj {
namespace hls {

// Bits of a row, and of the centroid behind the point: it is M1 / M0 in 1/512 rows.
constexpr int kRowBits = spec::kGreyNBits;
constexpr int kFractionBits = 9;
constexpr int kCentroidBits = kRowBits + kFractionBits;
constexpr int kQualityBits = spec::kCompactQualityBits;

// M1 / M0 in 1/512 rows, rounded to the nearest, halves up; M0 is not 0. On paper, a bit in each step: M1 is at most R
// M0, so the rest begins with M1 / 2^kRowBits.
inline Uint<spec::kCompactCentroidBits> centroid_of(Sum0 m0, Sum1 m1) {
#pragma HLS inline
  Uint<spec::kGreyM0Bits + 1> rest = m1 >> kRowBits;
  Uint<kCentroidBits> bits = m1 << kFractionBits;  // what is to come, and the quotient behind it
  for (int i = 0; i < kCentroidBits; ++i) {
#pragma HLS unroll
    Uint<1> next = bits >> (kCentroidBits - 1);
    rest = (rest << 1) | next;
    bits = bits << 1;
    if (rest >= m0) {
      rest = rest - m0;
      bits = bits | 1;
    }
  }
  Uint<spec::kCompactCentroidBits> centroid = bits;
  Uint<spec::kGreyM0Bits + 1> twice = rest << 1;
  if (twice >= m0) {
    centroid = centroid + 1;
  }
  return centroid;
}

// floor(M0 / 4 N), below 64 because M0 is at most 255 N; N is not 0.
inline Uint<spec::kCompactQualityBits> mean_of(Sum0 m0, Row n) {
#pragma HLS inline
  Uint<kRowBits + 1> rest = m0 >> spec::kPixelBits;
  Uint<spec::kCompactQualityBits> bits = m0 >> (spec::kPixelBits - spec::kCompactQualityBits);
  for (int i = 0; i < kQualityBits; ++i) {
#pragma HLS unroll
    Uint<1> next = bits >> (spec::kCompactQualityBits - 1);
    rest = (rest << 1) | next;
    bits = bits << 1;
    if (rest >= n) {
      rest = rest - n;
      bits = bits | 1;
    }
  }
  return bits;
}

// The compact word of a word of a grey mode.
inline Uint<spec::kCompactWordBits> compact_of(Uint<64> word, bool strongest) {
#pragma HLS inline
  Sum1 m1 = word >> spec::kGreyRunM1Lsb;
  Sum0 m0 = word >> spec::kGreyRunM0Lsb;
  Row n = word >> spec::kGreyRunNLsb;
  Uint<2> runs = word >> spec::kGreyRunRunsLsb;
  Uint<5> second = word >> spec::kGreyRunSecondLsb;
  Uint<spec::kCompactWordBits> compact = 0;
  if (n != 0) {
    Uint<spec::kCompactQualityBits> quality = mean_of(m0, n);
    if (strongest) {
      Uint<4> of_second = second;
      if (second >= 16) {
        of_second = 15;
      }
      quality = runs;
      quality = (quality << 4) | of_second;
    }
    Uint<spec::kCompactNBits> lit = n;
    if (n > static_cast<int>(spec::kCompactNMax)) {
      lit = static_cast<int>(spec::kCompactNMax);
    }
    compact = quality;
    compact = (compact << spec::kCompactNBits) | lit;
    compact = (compact << spec::kCompactCentroidBits) | centroid_of(m0, m1);
  }
  return compact;
}
static_assert(spec::kCompactCentroidLsb == 0 && spec::kCompactNLsb == spec::kCompactCentroidBits &&
                  spec::kCompactQualityLsb == spec::kCompactNLsb + spec::kCompactNBits,
              "the fields of a compact word follow each other");

// Turns the payload of a grey mode, two columns a beat (tuser: first beat of a frame, tlast: last), into compact
// payload, four a beat. A frame that broke has no tlast; each frame has a multiple of four columns.
class CompactColumnsKernel {
 public:
  // One clock.
  void step(Stream<AxisBeat<128>>& payload, bool strongest, Stream<AxisBeat<128>>& compact) {
#pragma HLS inline
    AxisBeat<128> beat;
    if (!payload.read_nb(beat)) {
      return;
    }
    Uint<64> low = beat.data.to_uint64();
    AxisData<128> above = beat.data >> 64;
    Uint<64> high = above.to_uint64();
    Uint<64> pair = compact_of(high, strongest);
    pair = (pair << spec::kCompactWordBits) | compact_of(low, strongest);
    if (beat.user != 0) {
      others_ = false;
      first_of_frame_ = true;
    }
    if (others_) {
      AxisData<128> data(pair);
      data = data << 64;
      data = data | AxisData<128>(first_);
      compact.write(axis_beat<128>(data, first_of_frame_, beat.last != 0));
      first_of_frame_ = false;
    } else {
      first_ = pair;
    }
    others_ = !others_;
  }

 private:
  bool others_ = false;          // the next beat has the last two columns of four
  bool first_of_frame_ = false;  // the next four are the first of the frame
  Uint<64> first_ = 0;           // the first two
};

}  // namespace hls
}  // namespace selfproj
// NOLINTEND(performance-unnecessary-value-param)

// The kernel as a function for the tool.
void compact_columns_top(selfproj::hls::Stream<selfproj::hls::AxisBeat<128>>& payload, selfproj::hls::Uint<1> strongest,
                         selfproj::hls::Stream<selfproj::hls::AxisBeat<128>>& compact);

#endif  // SELFPROJ_HLS_COMPACT_COLUMNS_H
