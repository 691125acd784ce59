// Gray-code decoder: what the circuit sp_gray_decoder computes from a sequence of frames, to the last bit.
//
// The projector shows m pairs of patterns, plane p = 0..m-1, where plane 0 is the most significant bit. The frame with
// pattern index 2p is the positive of plane p, and that with 2p + 1 is its negative. For each pixel and pair, with the
// threshold T (method.md section 4; numbers are the equations of the thesis), the decoder computes
//
//     G = 1 where positive - negative > T,   0 where it is < -T,   ambiguous between; ambiguous counts as G = 0 (4.15)
//     B_p = B_{p-1} xor G,   B_0 = G                                                                             (4.17)
//     C = Σ_p 2^(m-1-p) B_p          over the newest value of each plane                                         (4.18)
//     measurable: at most one ambiguous value among the newest m pairs                                     (4.4, 4.16)
//
// A plane keeps its B until its turn comes again, so a code image is due after every pair.
//
// Which pairs count: a frame is the next one if its index is one above that of the frame before, modulo 2m. After the
// start, after a change of settings, after a flagged frame, and after a frame that was not the next one (one was
// missing, or its index is not in 0..2m-1), the decoder waits for a frame with index 0 and takes it immediately. From
// there m pairs must come in succession before the first code image leaves. The decoder cannot see the loss of a whole
// number of cycles.
#ifndef SELFPROJ_MODEL_GRAY_DECODER_H
#define SELFPROJ_MODEL_GRAY_DECODER_H

#include <cstdint>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::model {

// The word of a pixel of a code image: its space code, and whether it is measurable.
inline constexpr std::uint16_t kCodeMask = (1U << spec::kCodeCodeBits) - 1;
inline constexpr std::uint16_t kCodeMeasurable = std::uint16_t{1} << spec::kCodeMeasurableLsb;
static_assert(spec::kCodeCodeLsb == 0, "the code has the low bits of its word");

constexpr unsigned code_of(std::uint16_t word) { return word & kCodeMask; }
constexpr bool is_measurable(std::uint16_t word) { return (word & kCodeMeasurable) != 0; }

// A change of any of these makes the decoder wait for plane 0.
struct GraySettings {
  int rows = 512;     // 1 or more (on the board at most spec::kMaxRows)
  int columns = 512;  // 1 or more (on the board a multiple of 4, and at most spec::kColumnLimit)
  int bits = 8;       // m: pairs in a cycle, 1..kMaxBits
  int threshold = 5;  // T, 0..255

  bool operator==(const GraySettings&) const = default;
};

class GrayDecoder {
 public:
  static constexpr int kMaxBits = spec::kCodeCodeBits;
  static constexpr std::uint16_t kCode = kCodeMask;
  static constexpr std::uint16_t kMeasurable = kCodeMeasurable;

  // Waits for plane 0. Throws std::invalid_argument if a setting is out of range.
  explicit GrayDecoder(const GraySettings& settings);

  // Changes the settings; equal ones change nothing. Throws as above, and then changes nothing.
  void configure(const GraySettings& settings);

  [[nodiscard]] const GraySettings& settings() const { return settings_; }

  // Waits for plane 0, as after the start.
  void restart() { pairs_ = next_ = 0; }

  // Takes a whole frame with its pattern index; `good` is false for a flagged frame. If a code image is due, writes it
  // to `codes` and returns true; otherwise does not touch `codes`. The image has rows · columns words, row by row: the
  // code in bits 11..0, and bit 15 set if it is measurable. In the code of an unmeasurable pixel ambiguous values count
  // as 0. Throws std::invalid_argument if the image has not the size of the settings, or a pointer is null.
  bool add_frame(const ImageView& image, int pattern, bool good, std::uint16_t* codes);

  // The same piece by piece, for frames that may break after some of their pixels were decoded: call begin with the
  // first pixel, pixels for each piece of a line, and end with `good` false if the frame broke.
  //
  // begin returns whether the frame's pixels give codes. pixels takes `count` pixels of row `row` from column `column`
  // on (both from 0, within the settings). It writes as many words to `codes` if codes are due; otherwise `codes` is
  // not used.
  bool begin(int pattern);
  void pixels(int row, int column, int count, const std::uint8_t* values, std::uint16_t* codes);
  void end(bool good);

 private:
  // The decoder's state of a pixel: 32 bits in the circuit.
  struct Pixel {
    std::uint8_t positive = 0;
    std::uint16_t planes = 0;     // B_p in bit m-1-p: the code
    std::uint16_t ambiguous = 0;  // ambiguous values, in the same bits
  };

  // The role of the current frame for the decoder.
  enum class Role : std::uint8_t { ignored, positive, negative };

  GraySettings settings_;
  std::vector<Pixel> pixels_;
  int next_ = 0;   // index of the next frame of the sequence; 0 while waiting for plane 0
  int pairs_ = 0;  // pairs that came in succession since plane 0, up to m
  Role role_ = Role::ignored;
  int plane_ = 0;     // plane of the current frame
  bool due_ = false;  // the lines of the current frame give codes
};

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_GRAY_DECODER_H
