// The full sequence of Gray-code patterns for both axes of a projector, in the order in which to project and capture
// them.
#ifndef SELFPROJ_STRUCTURED_LIGHT_GRAY_SEQUENCE_H
#define SELFPROJ_STRUCTURED_LIGHT_GRAY_SEQUENCE_H

#include <cstdint>
#include <vector>

namespace selfproj::structured_light {

// One code for each projector column and each row: plane i of m shows bit m - 1 - i of v ^ (v >> 1), where v is the
// column or row from 0. Each positive is directly followed by its inverse. The columns' planes come first, most
// significant first, then the rows', then white, then black. m is the least number of bits that distinguishes all
// columns, or rows, and at least 1.
class GraySequence {
 public:
  static constexpr int kMaxSide = 1 << 14;

  // Throws std::invalid_argument unless columns and rows are in 1..kMaxSide.
  GraySequence(int columns, int rows);

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int column_bits() const { return column_bits_; }
  [[nodiscard]] int row_bits() const { return row_bits_; }

  // The number of images; the indices of the rows' first image, of the white image and of the black one.
  [[nodiscard]] int count() const { return black() + 1; }
  [[nodiscard]] int first_of_rows() const { return 2 * column_bits_; }
  [[nodiscard]] int white() const { return 2 * (column_bits_ + row_bits_); }
  [[nodiscard]] int black() const { return white() + 1; }

  // Image `index` of the sequence: rows() x columns() values of 0 or 255, row by row. Throws std::out_of_range.
  [[nodiscard]] std::vector<std::uint8_t> image(int index) const;

 private:
  int columns_, rows_;
  int column_bits_, row_bits_;
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_STRUCTURED_LIGHT_GRAY_SEQUENCE_H
