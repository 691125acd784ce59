// Gray-code decoder, 4 pixels a step, as include/selfproj/model/gray_decoder.h and include/selfproj/model/median3x3.h
// specify it, for HLS tools.
//
// Three layers, as in column_moments.h:
//   pure functions     binarization, state and code of one pixel
//   GraySequence, GrayDecoder   the role of a frame; a beat of 4 pixels and their state in, 4 codes out
//   GrayDecoderKernel  one step of the streams: video in, codes out, the median between; gray_decoder_top() is one of
//   them
#ifndef SELFPROJ_HLS_GRAY_DECODER_H
#define SELFPROJ_HLS_GRAY_DECODER_H

#include "hls/median3x3.h"
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

constexpr int kMaxCodeBits = spec::kCodeCodeBits;

using Plane = Uint<kMaxCodeBits>;  // one bit for each plane: plane p of m has bit m-1-p
using PlaneCount = Uint<4>;        // 0..kMaxCodeBits
using PatternIndex = Uint<16>;
// The state of a pixel, from the low bits: the positive, 8 bits; the planes' bits; which of them are ambiguous.
constexpr int kStateBits = spec::kPixelBits + 2 * kMaxCodeBits;
using PixelState = Uint<kStateBits>;

// --- Pure functions ---

// The state of a pixel after a frame. In a negative the one bit in `weight` becomes
//     B = (positive - pixel > threshold)  xor  the bit in `above`, that of the previous plane (plane 0: none)
//     (4.15, 4.17)
// It becomes ambiguous if the two differ by no more than the threshold. Bits outside `mask`, left over from another m,
// become 0.
inline PixelState next_state(GrayPixel pixel, PixelState state, GrayPixel threshold, bool negative, Plane weight,
                             Plane above, Plane mask) {
#pragma HLS inline
  const GrayPixel positive = state;
  const Plane planes = state >> spec::kPixelBits;
  const Plane ambiguous = state >> (spec::kPixelBits + kMaxCodeBits);
  // The threshold less and plus the difference: their signs, in the highest bit, say lit and dark for certain.
  const Uint<spec::kPixelBits + 2> difference = positive - pixel;
  const Uint<spec::kPixelBits + 2> under = threshold - difference;
  const Uint<spec::kPixelBits + 2> over = threshold + difference;
  const bool lit = (under >> (spec::kPixelBits + 1)) != 0;
  const bool dark = (over >> (spec::kPixelBits + 1)) != 0;
  const Plane before = planes & above;
  Plane changed = 0;
  Plane set_plane = 0;
  Plane set_ambiguous = 0;
  if (negative) {
    changed = weight;
    if (lit != (before != 0)) {
      set_plane = weight;
    }
    if (!lit && !dark) {
      set_ambiguous = weight;
    }
  }
  const Plane kept = mask & ~changed;
  const Plane next_planes = (planes & kept) | set_plane;
  const Plane next_ambiguous = (ambiguous & kept) | set_ambiguous;
  PixelState next = next_ambiguous;
  next = (next << kMaxCodeBits) | next_planes;
  next = (next << spec::kPixelBits) | pixel;
  return next;
}

// The code word of a pixel, measurable if at most one plane is ambiguous (4.4, 4.16, 4.18).
inline CodeWord code_word(PixelState state) {
#pragma HLS inline
  const Plane planes = state >> spec::kPixelBits;
  const Plane ambiguous = state >> (spec::kPixelBits + kMaxCodeBits);
  const Plane but_lowest = ambiguous & (ambiguous - 1);
  CodeWord word = planes;
  if (but_lowest == 0) {
    word = word | (1 << spec::kCodeMeasurableLsb);
  }
  return word;
}

inline Plane weight_of_plane(PlaneCount bits, Uint<4> plane) {
#pragma HLS inline
  const Uint<4> place = bits - 1 - plane;
  const Plane weight = 1 << static_cast<int>(place);
  return weight;
}

// A mask of the m planes.
inline Plane mask_of(PlaneCount bits) {
#pragma HLS inline
  const Uint<kMaxCodeBits + 1> all = (1 << static_cast<int>(bits)) - 1;
  const Plane mask = all;
  return mask;
}

// --- Classes with state ---

// The sequence rules of the model: whether a frame is the next one, and its role.
class GraySequence {
 public:
  // Of the current frame
  bool taken = false;
  bool negative = false;
  bool due = false;  // its codes must be sent
  Plane weight = 0;
  Plane above = 0;
  Plane mask = 0;

  void restart() {
#pragma HLS inline
    next_ = 0;
    pairs_ = 0;
  }

  // Whether codes are due from the next frame, if it is the next one in the sequence.
  bool due_next(PlaneCount bits) const {
#pragma HLS inline
    return (next_ & 1) != 0 && pairs_ + 1 >= bits;
  }

  // A frame begins.
  void start(PatternIndex pattern, PlaneCount bits) {
#pragma HLS inline
    const bool fresh = pattern != next_;
    const Uint<5> index = pattern;
    Uint<5> last = bits;
    last = (last << 1) - 1;
    if (fresh) {
      pairs_ = 0;
    }
    taken = !fresh || pattern == 0;
    negative = taken && (index & 1) != 0;
    if (negative && pairs_ != bits) {
      pairs_ = pairs_ + 1;
    }
    due = negative && pairs_ == bits;
    next_ = 0;
    if (taken && index != last) {
      next_ = index + 1;
    }
    mask = mask_of(bits);
    weight = weight_of_plane(bits, index >> 1);
    above = (weight << 1) & mask;
  }

 private:
  Uint<5> next_ = 0;   // expected index; 0 while waiting for plane 0
  Uint<4> pairs_ = 0;  // pairs in succession, up to m
};

// A beat, or none.
struct GrayIn {
  bool valid = false;
  Uint<32> pixels = 0;  // leftmost pixel in the low bits
  bool start = false;   // start of a frame; the members below matter only with it
  bool line_end = false;
  bool last_row = false;
};

// The states of the pixels, and their codes. Images up to MaxColumns x MaxRows.
template <int MaxColumns, int MaxRows>
class GrayDecoder {
 public:
  GrayDecoder(){
// The states of a beat are one word: one read and one write a step.
#pragma HLS aggregate variable = state_ compact = bit
#pragma HLS bind_storage variable = state_ type = ram_s2p impl = auto
  }

  // A beat of the frame that `sequence` has started. A frame must begin at least kMemoryDistance steps after the last
  // beat of one with fewer beats; GrayDecoderKernel ensures this.
  CodesBeat step(const GrayIn& in, const GraySequence& sequence, GrayPixel threshold) {
#pragma HLS inline
// Each word is read once per frame, at least kMemoryDistance steps after its write in the previous frame.
#pragma HLS dependence variable = state_ type = inter direction = RAW distance = 4 true
    static_assert(kMemoryDistance == 4, "the distance in the pragma");
    CodesBeat out;
    if (in.valid) {
      if (in.start) {
        at_ = 0;
      }
      const Word stored = state_[static_cast<int>(at_)];
      Word word;
      for (int lane = kCodeLanes - 1; lane >= 0; --lane) {
#pragma HLS unroll
        const PixelState state = stored.pixels[lane];
        const GrayPixel pixel = in.pixels >> (spec::kPixelBits * lane);
        const PixelState next =
            next_state(pixel, state, threshold, sequence.negative, sequence.weight, sequence.above, sequence.mask);
        word.pixels[lane] = next.to_uint();
        out.codes = (out.codes << spec::kCodeWordBits) | code_word(next);
      }
      if (sequence.taken) {
        state_[static_cast<int>(at_)] = word;
      }
      out.valid = sequence.due;
      out.start = in.start;
      out.line_end = in.line_end;
      out.last_row = in.last_row;
      at_ = at_ + 1;
    }
    return out;
  }

 private:
  static constexpr int kWords = MaxColumns / kCodeLanes * MaxRows;
  static_assert(kStateBits == 32, "a state is stored in 32 bits");

  // Plain words of 32 bits, because the integers of a simulation would take six times the memory for a large image.
  struct Word {
    std::uint32_t pixels[kCodeLanes];
  };

  Memory<Word, kWords> state_;
  Uint<bits_for(kWords)> at_ = 0;
};

// --- Streams ---

// The settings, taken over at each frame's start. A change of any setting except the median makes the decoder wait for
// plane 0.
struct GraySetup {
  Uint<13> columns = 0;  // a multiple of 4 from 4
  Uint<12> rows = 0;     // from 1
  PlaneCount bits = 1;   // m, 1..12
  GrayPixel threshold = 0;
  bool median = false;
};

// Turns video beats (tuser: start of frame, tlast: end of line) into codes, four a beat (tuser: start of a code image,
// tlast: end of a line).
//
// Beats before a start are dropped. A line that ends too early or too late breaks its frame, and so does a start within
// it. The decoder then waits for plane 0, and a code image that had begun to leave is not finished.
template <int MaxColumns, int MaxRows>
class GrayDecoderKernel {
 public:
  // One clock. `pattern` belongs to a frame that starts in it. Returns true while more steps without input would give
  // more output.
  bool step(Stream<AxisBeat<32>>& video, const GraySetup& setup, PatternIndex pattern, Stream<AxisBeat<64>>& codes) {
#pragma HLS inline
    late_memory_step();
    GrayIn in;
    AxisBeat<32> beat;
    bool broken = false;
    if (may_read(setup) && video.read_nb(beat)) {
      broken = place(beat, setup, pattern, in);
    }
    const CodesBeat raw = decoder_.step(in, sequence_, setup_.threshold);
    const CodesBeat out = median_.step(raw, broken, setup_.median);
    if (out.valid) {
      codes.write(axis_beat<64>(out.codes, out.start, out.line_end));
    }
    count(raw);
    return median_left_ != 0;
  }

 private:
  // After a small frame, another small one must wait until the state is written, and a frame with codes must wait until
  // the last line of the one before has left the median. Between two frames with codes there is a positive, so only
  // frames of one or two lines wait.
  bool may_read(const GraySetup& setup) const {
#pragma HLS inline
    return open_ || (since_ == 0 && (median_left_ == 0 || !sequence_.due_next(setup.bits)));
  }

  // Finds the place of the beat, and the role of its frame. Returns true if a frame with codes broke, either the one
  // before or its own.
  bool place(const AxisBeat<32>& beat, const GraySetup& setup, PatternIndex pattern, GrayIn& in) {
#pragma HLS inline
    const bool line_end = beat.last != 0;
    bool broken = false;
    if (beat.user != 0) {
      broken = open_ && sequence_.due;
      if (open_ || setup.columns != setup_.columns || setup.rows != setup_.rows || setup.bits != setup_.bits ||
          setup.threshold != setup_.threshold) {
        sequence_.restart();
      }
      setup_ = setup;
      sequence_.start(pattern, setup.bits);
      open_ = true;
      row_ = 1;
      group_ = 1;
      groups_ = setup.columns >> 2;
      beats_ = 0;
      in.start = true;
    }
    if (open_) {
      in.valid = true;
      in.pixels = beat.data.to_uint();
      in.line_end = group_ == groups_;
      in.last_row = row_ == setup_.rows;
      if (line_end != in.line_end) {
        in.valid = false;
        broken = sequence_.due;
        open_ = false;
        sequence_.restart();
      } else if (line_end) {
        open_ = !in.last_row;
        row_ = row_ + 1;
        group_ = 1;
      } else {
        group_ = group_ + 1;
      }
      if (beats_ != kMemoryDistance) {
        beats_ = beats_ + 1;
      }
      since_ = 0;
      if (beats_ != kMemoryDistance) {
        since_ = kMemoryDistance;
      }
    }
    return broken;
  }

  void count(const CodesBeat& raw) {
#pragma HLS inline
    if (since_ != 0) {
      since_ = since_ - 1;
    }
    if (raw.valid && raw.line_end && raw.last_row) {
      median_left_ = groups_ + 1;
    } else if (median_left_ != 0) {
      median_left_ = median_left_ - 1;
    }
  }

  GrayDecoder<MaxColumns, MaxRows> decoder_;
  GraySequence sequence_;
  Median3x3<MaxColumns> median_;
  GraySetup setup_;     // of the current frame
  bool open_ = false;   // a frame has begun and not ended
  Uint<12> row_ = 1;    // row of the next beat
  Uint<11> group_ = 1;  // group of the next beat, from 1
  Uint<11> groups_ = 1;
  Uint<3> beats_ = 0;         // beats of the frame, up to kMemoryDistance
  Uint<3> since_ = 0;         // steps until what was read has been written
  Uint<11> median_left_ = 0;  // steps until the last code image is out
};

// The largest image of the top function.
constexpr int kTopColumns = 640;
constexpr int kTopRows = 480;

}  // namespace hls
}  // namespace selfproj

// The kernel for a tool: free-running, one clock for each call. It is outside all namespaces, which some tools require
// of a top function. See gray_decoder.cpp.
void gray_decoder_top(selfproj::hls::Stream<selfproj::hls::AxisBeat<32>>& video, selfproj::hls::Uint<13> columns,
                      selfproj::hls::Uint<12> rows, selfproj::hls::PlaneCount bits, selfproj::hls::GrayPixel threshold,
                      selfproj::hls::Uint<1> median, selfproj::hls::PatternIndex pattern,
                      selfproj::hls::Stream<selfproj::hls::AxisBeat<64>>& codes);

// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
// NOLINTEND(performance-unnecessary-value-param,modernize-use-equals-default)

#endif  // SELFPROJ_HLS_GRAY_DECODER_H
