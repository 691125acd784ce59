// 3 x 3 lower median of the measurable codes of a stream of code images, 4 codes a step: what model/median3x3.h
// specifies, for HLS tools.
//
// The image is a line and a step behind its input. A line leaves while the next one comes; the last one follows at
// once, a beat a step. Without the median codes pass unchanged, at the same steps.
#ifndef SELFPROJ_HLS_MEDIAN3X3_H
#define SELFPROJ_HLS_MEDIAN3X3_H

#include "hls/recent.h"
#include "hls/types.h"
#include "model/spec/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers go by value, as the compilers of hardware take them best
//   equals-default: the constructor holds pragmas
//   reserved-identifier, identifier-naming: of the variables that clang makes itself to copy arrays of structs
// NOLINTBEGIN(performance-unnecessary-value-param,modernize-use-equals-default)
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
namespace selfproj {
namespace hls {

constexpr int kCodeLanes = spec::kPixelsPerBeat;

using GrayPixel = Uint<spec::kPixelBits>;
using CodeWord = Uint<spec::kCodeWordBits>;
using Code = Uint<spec::kCodeCodeBits + 1>;  // a code, and above it whether it is measurable

// Four codes of a code image, leftmost in the low bits; or none.
struct CodesBeat {
  bool valid = false;
  Uint<kCodeLanes* spec::kCodeWordBits> codes = 0;
  bool start = false;  // of a code image
  bool line_end = false;
  bool last_row = false;
};

// --- Pure functions ---

inline Code code_of(CodeWord word) {
#pragma HLS inline
  const Uint<1> measurable = word >> spec::kCodeMeasurableLsb;
  Code code = measurable;
  code = (code << spec::kCodeCodeBits) | (word & ((1 << spec::kCodeCodeBits) - 1));
  return code;
}

inline CodeWord word_of(Code code) {
#pragma HLS inline
  const Uint<1> measurable = code >> spec::kCodeCodeBits;
  CodeWord word = measurable;
  word = (word << spec::kCodeMeasurableLsb) | (code & ((1 << spec::kCodeCodeBits) - 1));
  return word;
}

// Of nine codes, the centre number 4; one that does not exist counts as not measurable. Where more than `half` of them
// are measurable the lower median of their codes, measurable, else 0. A code's rank is the number of those that are
// less, or equal and earlier, the measurable ones first: every pair is compared once.
inline Code median_of(const Code codes[9], Uint<4> half) {
#pragma HLS inline
  Uint<4> count = 0;
  Uint<4> rank[9];
#pragma HLS array_partition variable = rank complete
  Code key[9];  // in the order of ranks
#pragma HLS array_partition variable = key complete
  for (int i = 0; i < 9; ++i) {
#pragma HLS unroll
    const Uint<1> measurable = codes[i] >> spec::kCodeCodeBits;
    count = count + measurable;
    rank[i] = 0;
    key[i] = codes[i] ^ (1 << spec::kCodeCodeBits);
  }
  for (int i = 0; i < 9; ++i) {
#pragma HLS unroll
    for (int j = 0; j < 9; ++j) {
#pragma HLS unroll
      if (i < j) {
        if (key[j] < key[i]) {
          rank[i] = rank[i] + 1;
        } else {
          rank[j] = rank[j] + 1;
        }
      }
    }
  }
  const Uint<4> target = (count - 1) >> 1;
  Code median = 0;
  for (int i = 0; i < 9; ++i) {
#pragma HLS unroll
    if (rank[i] == target && count > half) {
      median = codes[i];
    }
  }
  return median;
}

// Half the number of the codes that exist, rounded down, of 9, 6, 4, 3 or 2.
inline Uint<4> half_of(bool above, bool below, bool outer) {
#pragma HLS inline
  Uint<4> half = 1;
  if (above && below) {
    half = outer ? 3 : 4;
  } else if (above || below) {
    half = outer ? 2 : 3;
  }
  return half;
}

// --- Class with state ---

template <int MaxColumns>
class Median3x3 {
 public:
  Median3x3(){
// The four codes of a beat are one word of each line buffer: one read and one write a step.
#pragma HLS aggregate variable = near_ compact = bit
#pragma HLS aggregate variable = far_ compact = bit
#pragma HLS bind_storage variable = near_ type = ram_s2p impl = bram
#pragma HLS bind_storage variable = far_ type = ram_s2p impl = bram
// The window: all of its codes at once.
#pragma HLS array_partition variable = middle_ complete
#pragma HLS array_partition variable = left_ complete
  }

  // A beat of codes, or none; `broken`: the image under way ends here, before the beat, and what has not left will not.
  // After a beat that ends an image the next one begins at the earliest columns / 4 + 2 steps later.
  CodesBeat step(const CodesBeat& in, bool broken, bool median) {
#pragma HLS inline
// As for the sums of ColumnMoments: the recent_ ones have what the memory does not show yet.
#pragma HLS dependence variable = near_ type = inter direction = RAW distance = 4 true
#pragma HLS dependence variable = far_ type = inter direction = RAW distance = 4 true
    static_assert(kMemoryDistance == 4, "the distance in the pragma");
    if (broken) {
      passing_ = false;
      middle_valid_ = false;
    }
    if (in.valid && in.start) {
      lines_ = 0;
      group_ = 0;
      first_ = true;
      median_ = median;
    }
    const bool passing = passing_;
    const bool moves = passing || (in.valid && lines_ != 0);  // a beat that has a line above it
    const bool first = first_;
    const bool ends_line = passing ? group_ == last_group_ : in.line_end;
    const bool two_above = lines_ == 2;

    const Line near_stored = near_[static_cast<int>(group_)];
    const Line far_stored = far_[static_cast<int>(group_)];
    const Line near = recent_near_.read(group_, near_stored);
    const Line far = recent_far_.read(group_, far_stored);
    Code columns[kCodeLanes][3];  // of this beat: the codes of two lines above, of one above, and its own
#pragma HLS array_partition variable = columns complete dim = 0
    Line now;
    for (int lane = 0; lane < kCodeLanes; ++lane) {
#pragma HLS unroll
      const CodeWord word = in.codes >> (spec::kCodeWordBits * lane);
      now.codes[lane] = code_of(word);
      columns[lane][0] = 0;
      columns[lane][1] = near.codes[lane];
      columns[lane][2] = 0;
      if (two_above) {
        columns[lane][0] = far.codes[lane];
      }
      if (!passing) {
        columns[lane][2] = now.codes[lane];
      }
    }
    if (in.valid) {
      near_[static_cast<int>(group_)] = now;
      recent_near_.write(group_, now);
      if (lines_ != 0) {
        far_[static_cast<int>(group_)] = near;
        recent_far_.write(group_, near);
      }
    }

    // The beat before leaves, once its right neighbour is there or does not exist.
    CodesBeat out;
    out.valid = middle_valid_ && (middle_last_ || (moves && !first));
    if (out.valid) {
      filter(columns, out);
    }

    if (moves) {
      shift(columns, first);
      middle_first_ = first;
      middle_last_ = ends_line;
      middle_above_ = two_above;
      middle_below_ = !passing;
      middle_valid_ = true;
    } else if (out.valid) {
      middle_valid_ = false;
    }
    if (in.valid || passing) {
      advance(in, passing, ends_line);
    }
    return out;
  }

 private:
  struct Line {
    Code codes[kCodeLanes];
  };

  // The medians of the four codes in the middle.
  void filter(const Code columns[kCodeLanes][3], CodesBeat& out) const {
#pragma HLS inline
    Code window[kCodeLanes + 2][3];
#pragma HLS array_partition variable = window complete dim = 0
    for (int row = 0; row < 3; ++row) {
#pragma HLS unroll
      window[0][row] = left_[row];
      for (int lane = 0; lane < kCodeLanes; ++lane) {
#pragma HLS unroll
        window[lane + 1][row] = middle_[lane][row];
      }
      window[kCodeLanes + 1][row] = 0;
      if (!middle_last_) {
        window[kCodeLanes + 1][row] = columns[0][row];
      }
    }
    for (int lane = kCodeLanes - 1; lane >= 0; --lane) {
#pragma HLS unroll
      Code nine[9];
#pragma HLS array_partition variable = nine complete
      for (int i = 0; i < 9; ++i) {
#pragma HLS unroll
        nine[i] = window[lane + i / 3][i % 3];
      }
      const bool outer = (lane == 0 && middle_first_) || (lane == kCodeLanes - 1 && middle_last_);
      Code code = nine[4];
      if (median_) {
        code = median_of(nine, half_of(middle_above_, middle_below_, outer));
      }
      out.codes = (out.codes << spec::kCodeWordBits) | word_of(code);
    }
    out.start = middle_first_ && !middle_above_;
    out.line_end = middle_last_;
    out.last_row = !middle_below_;
  }

  // The beat takes the place of the one before, of which its left neighbours are kept.
  void shift(const Code columns[kCodeLanes][3], bool first) {
#pragma HLS inline
    for (int row = 0; row < 3; ++row) {
#pragma HLS unroll
      left_[row] = 0;
      if (!first) {
        left_[row] = middle_[kCodeLanes - 1][row];
      }
      for (int lane = 0; lane < kCodeLanes; ++lane) {
#pragma HLS unroll
        middle_[lane][row] = columns[lane][row];
      }
    }
  }

  void advance(const CodesBeat& in, bool passing, bool ends_line) {
#pragma HLS inline
    first_ = ends_line;
    if (ends_line) {
      last_group_ = group_;
      group_ = 0;
      passing_ = !passing && in.last_row;
      if (!passing && lines_ != 2) {
        lines_ = lines_ + 1;
      }
    } else {
      group_ = group_ + 1;
    }
  }

  static constexpr int kGroups = MaxColumns / kCodeLanes;
  using Group = Uint<bits_for(kGroups - 1)>;

  // The line before, and the one before that
  Memory<Line, kGroups> near_;
  Memory<Line, kGroups> far_;
  Recent<Line, Group> recent_near_;
  Recent<Line, Group> recent_far_;
  bool median_ = false;   // of the image under way
  bool passing_ = false;  // its last line leaves
  Uint<2> lines_ = 0;     // complete ones of it, up to 2
  Group group_ = 0;       // the next one
  Group last_group_ = 0;
  bool first_ = true;  // the next group is its line's first
  // The beat of the step before
  Code middle_[kCodeLanes][3];
  Code left_[3];
  bool middle_valid_ = false;
  bool middle_first_ = false;
  bool middle_last_ = false;
  bool middle_above_ = false;
  bool middle_below_ = false;
};

}  // namespace hls
}  // namespace selfproj

// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
// NOLINTEND(performance-unnecessary-value-param,modernize-use-equals-default)

#endif  // SELFPROJ_HLS_MEDIAN3X3_H
