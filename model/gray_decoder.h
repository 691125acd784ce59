// Gray-code decoder: what the circuit sp_gray_decoder computes of a sequence of frames, to the last bit.
//
// The projector shows m pairs of patterns, plane p = 0..m-1, plane 0 being the most significant bit: the frame with
// pattern index 2p is the positive of plane p, that with 2p + 1 its negative. Of a pair the decoder takes, pixel by
// pixel, with the threshold T (method.md section 4; numbers are the thesis' equations)
//
//     G = 1 where positive - negative > T,   0 where it is < -T,   ambiguous between; ambiguous counts as G = 0 (4.15)
//     B_p = B_{p-1} xor G,   B_0 = G                                                                             (4.17)
//     C = Σ_p 2^(m-1-p) B_p          over the newest value of each plane                                         (4.18)
//     measurable: at most one ambiguous value among the newest m pairs                                     (4.4, 4.16)
//
// and a plane keeps its B until its turn comes again, so that a code image is due after every pair.
//
// Which pairs count: a frame is the next one where its index is one above that of the frame before, modulo 2m. After
// the start, a change of settings, a frame that was flagged, or one that was not the next (because one was missing, or
// its index is not in 0..2m-1), the decoder waits for a frame with index 0, and such a frame is taken at once. No code
// image leaves until m pairs have come in succession from there. A loss of exactly a whole number of cycles cannot be
// seen.
#ifndef SELFPROJ_MODEL_GRAY_DECODER_H
#define SELFPROJ_MODEL_GRAY_DECODER_H

#include <cstdint>
#include <vector>

#include "model/code_word.h"
#include "model/column_moments.h"
#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {

// A change of any of these makes the decoder wait for plane 0.
struct GraySettings {
  int rows = 512;     // 1 or more (on the board at most spec::kMaxRows)
  int columns = 512;  // 1 or more (on the board a multiple of 4, and at most spec::kMaxColumns)
  int bits = 8;       // m: pairs in a cycle, 1..kMaxBits
  int threshold = 5;  // T, 0..255

  bool operator==(const GraySettings&) const = default;
};

class GrayDecoder {
 public:
  static constexpr int kMaxBits = spec::kCodeCodeBits;
  static constexpr std::uint16_t kCode = kCodeMask;
  static constexpr std::uint16_t kMeasurable = kCodeMeasurable;

  // Waits for plane 0. Throws std::invalid_argument where a setting is out of range.
  explicit GrayDecoder(const GraySettings& settings);

  // Takes over other settings; equal ones change nothing. Throws as above, and then changes nothing.
  void configure(const GraySettings& settings);

  [[nodiscard]] const GraySettings& settings() const { return settings_; }

  // Waits for plane 0, as after the start.
  void restart() { pairs_ = next_ = 0; }

  // Takes a whole frame with its pattern index; `good` is false for a frame that was flagged. Where a code image is
  // due, writes it to `codes`, rows · columns words row by row, and returns true: the code in bits 11..0, bit 15 where
  // it is measurable. Else `codes` is not touched. An unmeasurable code is that in which ambiguous values count as 0.
  // Throws std::invalid_argument where the image has not the size of the settings, or a pointer is null.
  bool take(const ImageView& image, int pattern, bool good, std::uint16_t* codes);

  // The same piece by piece, for frames that may break after some of their pixels have been decoded: begin with the
  // first pixel, pixels for each piece of a line, end with `good` false where the frame broke.
  //
  // begin returns whether the frame's pixels give codes. pixels takes `count` pixels of row `row` from column `column`
  // on (both from 0; within the settings) and writes as many words to `codes` where codes are due, which is else not
  // read.
  bool begin(int pattern);
  void pixels(int row, int column, int count, const std::uint8_t* values, std::uint16_t* codes);
  void end(bool good);

 private:
  // What is kept of a pixel: 32 bits in the circuit.
  struct Pixel {
    std::uint8_t positive = 0;
    std::uint16_t planes = 0;     // B_p in bit m-1-p: the code
    std::uint16_t ambiguous = 0;  // likewise
  };

  // What the frame under way is to the decoder.
  enum class Role : std::uint8_t { ignored, positive, negative };

  GraySettings settings_;
  std::vector<Pixel> pixels_;
  int next_ = 0;   // index of the next frame of the sequence; 0 while waiting for plane 0
  int pairs_ = 0;  // in succession since plane 0, up to m
  Role role_ = Role::ignored;
  int plane_ = 0;     // of the frame under way
  bool due_ = false;  // its lines give codes
};

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_GRAY_DECODER_H
