// Gray-code decoder and 3 × 3 median for the production PC: the results of model/gray_decoder and model/median3x3 bit
// for bit, with a memory layout that suits the processor.
//
// Each image of a pair is read once. Only the code and the ambiguity bits of each pixel are kept, in one byte each up
// to m = 8 bits and in two above. These arrays are the code image. An update thus reads 4 bytes a pixel and writes 2 (m
// <= 8).
#ifndef SELFPROJ_STRUCTURED_LIGHT_FAST_DECODER_H
#define SELFPROJ_STRUCTURED_LIGHT_FAST_DECODER_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/gray_decoder.h"

namespace selfproj::structured_light {

// A code image in place: rows · columns entries, row by row, in bytes (m <= 8) or in words (m > 8). The arrays of the
// other width are null. The code of pixel i is codes[i]. It is measurable if at most one bit of ambiguous[i] is set: (a
// & (a - 1)) == 0.
struct CodeImageView {
  int rows = 0;
  int columns = 0;
  int bits = 0;  // m
  const std::uint8_t* codes8 = nullptr;
  const std::uint8_t* ambiguous8 = nullptr;
  const std::uint16_t* codes16 = nullptr;
  const std::uint16_t* ambiguous16 = nullptr;
};

// Writes the image as the model and the board do: rows · columns words, the code in bits 11..0, bit 15 measurable.
void code_words(const CodeImageView& image, std::uint16_t* out);

// The same, but measurable only if no pair is ambiguous, which is stricter than the model.
void unambiguous_code_words(const CodeImageView& image, std::uint16_t* out);

class FastGrayDecoder {
 public:
  static constexpr int kMaxSide = 1 << 15;

  // Rows and columns are 1..kMaxSide, which may exceed the circuit's maxima; bits and threshold are as in the model.
  // Throws std::invalid_argument otherwise. Allocates all memory here.
  explicit FastGrayDecoder(const model::GraySettings& settings);

  // Waits for plane 0, as after the start.
  void restart() { pairs_ = next_ = 0; }

  // Takes a frame with its pattern index, by the sequence rules of GrayDecoder. A positive is only read when its
  // negative comes, so its pixels must stay unchanged until then. Returns true if a new code image is due; it stays in
  // codes() until the next frame is taken. `good` is false for a flagged frame. Throws std::invalid_argument if the
  // image has not the size of the settings, or its pointer is null.
  bool add_frame(const model::ImageView& image, int pattern, bool good = true);

  [[nodiscard]] const model::GraySettings& settings() const { return settings_; }
  [[nodiscard]] CodeImageView codes() const;

 private:
  model::GraySettings settings_;
  int next_ = 0;   // index of the next frame of the sequence; 0 while waiting for plane 0
  int pairs_ = 0;  // pairs in succession since plane 0, up to m
  bool downwards_ = true;
  model::ImageView positive_;
  std::vector<std::uint8_t> codes8_, ambiguous8_;  // m <= 8
  std::vector<std::uint16_t> codes16_, ambiguous16_;
};

// The median of a code image as in model/median3x3: words as code_words writes them, 0 if not measurable. Holds a few
// lines of scratch memory for images up to `columns` wide.
class FastMedian {
 public:
  // Throws std::invalid_argument unless columns are in 1..FastGrayDecoder::kMaxSide.
  explicit FastMedian(int columns);

  // Writes rows · columns words. Throws std::invalid_argument if the image is wider than `columns`, or empty.
  void filter(const CodeImageView& image, std::uint16_t* out);

 private:
  int columns_;
  std::vector<std::uint8_t> scratch8_;
  std::vector<std::uint16_t> scratch16_;
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_STRUCTURED_LIGHT_FAST_DECODER_H
