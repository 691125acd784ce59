// 3 x 3 lower median of the measurable codes of a stream of code images, 4 codes a step, as
// include/selfproj/model/median3x3.h specifies it, for HLS tools.
//
// The output is a line and a step behind the input. A line leaves while the next one comes. The last line follows at
// once, a beat in each step. Without the median, codes pass unchanged in the same steps.
#ifndef SELFPROJ_HLS_MEDIAN3X3_H
#define SELFPROJ_HLS_MEDIAN3X3_H

#include "hls/recent.h"
#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

// clang-tidy, in this file:
//   unnecessary-value-param: small integers are passed by value, which suits hardware compilers best
//   equals-default: the constructor holds pragmas
//   reserved-identifier, identifier-naming: for variables that clang itself makes to copy arrays of structs
// NOLINTBEGIN(performance-unnecessary-value-param,modernize-use-equals-default)
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
namespace selfproj {
namespace hls {

constexpr int kCodeLanes = spec::kPixelsPerBeat;

using GrayPixel = Uint<spec::kPixelBits>;
using CodeWord = Uint<spec::kCodeWordBits>;
using Code = Uint<spec::kCodeCodeBits + 1>;  // a code; the highest bit says whether it is measurable

// Four codes of a code image, leftmost in the low bits, or none.
struct CodesBeat {
  bool valid = false;
  Uint<kCodeLanes* spec::kCodeWordBits> codes = 0;
  bool start = false;  // first beat of a code image
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

// The median of nine codes, of which number 4 is the centre. A code that does not exist counts as not measurable. If
// more than `half` are measurable, the result is the lower median of their codes, and measurable; else it is 0. The
// rank of a code is the number of codes that are less, or equal and earlier, where measurable ones come first: every
// pair is compared once.
inline Code median_of(const Code codes[9], Uint<4> half) {
#pragma HLS inline
  Uint<4> count = 0;
  Uint<1> earlier[9][9];  // [i][j]: j comes before i
#pragma HLS array_partition variable = earlier complete dim = 0
  Code key[9];  // in order of rank
#pragma HLS array_partition variable = key complete
  for (int i = 0; i < 9; ++i) {
#pragma HLS unroll
    const Uint<1> measurable = codes[i] >> spec::kCodeCodeBits;
    count = count + measurable;
    key[i] = codes[i] ^ (1 << spec::kCodeCodeBits);
  }
  for (int i = 0; i < 9; ++i) {
#pragma HLS unroll
    for (int j = 0; j < 9; ++j) {
#pragma HLS unroll
      if (i < j) {
        const Uint<1> less = key[j] < key[i] ? 1 : 0;
        earlier[i][j] = less;
        earlier[j][i] = 1 - less;
      }
    }
  }
  const Uint<4> target = (count - 1) >> 1;
  Code median = 0;
  for (int i = 0; i < 9; ++i) {
#pragma HLS unroll
    Uint<4> rank = 0;
    for (int j = 0; j < 9; ++j) {
#pragma HLS unroll
      if (i != j) {
        rank = rank + earlier[i][j];
      }
    }
    if (rank == target) {
      median = median | codes[i];  // one of the nine has this rank
    }
  }
  if (count <= half) {
    median = 0;
  }
  return median;
}

// Half the number of existing codes (9, 6, 4, 3 or 2), rounded down.
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
// All codes of the window at once.
#pragma HLS array_partition variable = middle_ complete
#pragma HLS array_partition variable = left_ complete
  }

  // A beat of codes, or none. `broken`: the current image ends before the beat, and what has not left is dropped. After
  // a beat that ends an image, the next one begins at the earliest columns / 4 + 2 steps later.
  CodesBeat step(const CodesBeat& in, bool broken, bool median) {
#pragma HLS inline
// As for the sums of ColumnMoments, the recent_ ones have what the memory does not show yet.
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
    const bool moves = passing || (in.valid && lines_ != 0);  // a beat with a line above it
    const bool first = first_;
    const bool ends_line = passing ? group_ == last_group_ : in.line_end;
    const bool two_above = lines_ == 2;

    const Line near_stored = near_[static_cast<int>(group_)];
    const Line far_stored = far_[static_cast<int>(group_)];
    const Line near = recent_near_.read(group_, near_stored);
    const Line far = recent_far_.read(group_, far_stored);
    Code columns[kCodeLanes][3];  // codes two lines above, one line above, and of this beat
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

    // The previous beat leaves as soon as its right neighbour has come or cannot exist.
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

  // The beat takes the place of the previous one, of which only its left neighbours are kept.
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

  // The previous line, and the one before it
  Memory<Line, kGroups> near_;
  Memory<Line, kGroups> far_;
  Recent<Line, Group> recent_near_;
  Recent<Line, Group> recent_far_;
  bool median_ = false;   // of the current image
  bool passing_ = false;  // its last line is leaving
  Uint<2> lines_ = 0;     // complete lines of it, up to 2
  Group group_ = 0;       // the next group
  Group last_group_ = 0;
  bool first_ = true;  // the next group is the first of its line
  // The beat of the previous step
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
