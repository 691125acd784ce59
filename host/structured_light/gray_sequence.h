// The full sequence of Gray-code patterns for both axes of a projector, in the order of projecting and capturing.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_GRAY_SEQUENCE_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_GRAY_SEQUENCE_H

#include <cstdint>
#include <vector>

namespace selfproj {

// A code a projector pixel: plane i of m shows bit m - 1 - i of v ^ (v >> 1), v the pixel's column or row, from 0; each
// positive is directly followed by its inverse. First the columns' planes, most significant first, then the rows', then
// white, then black. m is the least number of bits that tells all columns, or rows, apart, and at least 1.
class GraySequence {
 public:
  static constexpr int kMaxSide = 1 << 14;

  // Throws std::invalid_argument where columns or rows are not in 1..kMaxSide.
  GraySequence(int columns, int rows);

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int column_bits() const { return column_bits_; }
  [[nodiscard]] int row_bits() const { return row_bits_; }

  // Number of images, and where those of the rows, the white and the black one begin.
  [[nodiscard]] int count() const { return black() + 1; }
  [[nodiscard]] int first_of_rows() const { return 2 * column_bits_; }
  [[nodiscard]] int white() const { return 2 * (column_bits_ + row_bits_); }
  [[nodiscard]] int black() const { return white() + 1; }

  // Image `index` of the sequence, 0 or 255, rows() x columns(), row by row. Throws std::out_of_range.
  [[nodiscard]] std::vector<std::uint8_t> image(int index) const;

 private:
  int columns_, rows_;
  int column_bits_, row_bits_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_GRAY_SEQUENCE_H
