#include "selfproj/model/column_moments.h"

#include <stdexcept>
#include <string>

namespace selfproj::model {

namespace {

template <typename Pixel>
void sum_up(const PixelView<Pixel>& image, Mode mode, int threshold, const MomentsView& out, const RowWindow& window) {
  for (int column = 0; column < image.columns; ++column) {
    std::uint32_t m0 = 0;
    std::uint32_t m1 = 0;
    std::uint32_t n = 0;
    for (int row = 1; row <= image.rows; ++row) {
      if (!window.counts(row)) {
        continue;
      }
      const int pixel = image.pixels[(row - 1) * image.stride + column];
      const std::uint32_t w = pixel_weight(mode, threshold, pixel);
      m0 += w;
      m1 += static_cast<std::uint32_t>(row) * w;
      n += pixel > threshold ? 1 : 0;
    }
    out.m0[column] = m0;
    out.m1[column] = m1;
    out.n[column] = n;
  }
}

void require(bool good, const char* what) {
  if (!good) {
    throw std::invalid_argument(std::string("column_moments: ") + what);
  }
}

template <typename Pixel>
void check(const PixelView<Pixel>& image, Mode mode, const MomentsView& out, int max_rows) {
  if (image.rows < 1 || image.rows > max_rows) {
    throw std::invalid_argument("moments: " + std::to_string(image.rows) + " rows; 1 to " + std::to_string(max_rows) +
                                " can be summed");
  }
  require(image.columns >= 1, "columns are less than 1");
  require(mode == Mode::binary || mode == Mode::grey || mode == Mode::grey_over, "unknown mode");
  require(image.pixels != nullptr && out.m0 != nullptr && out.m1 != nullptr && out.n != nullptr, "null pointer");
}

}  // namespace

void column_moments(const ImageView& image, Mode mode, int threshold, const MomentsView& out, const RowWindow& window,
                    int max_rows) {
  check_column_moments(image, mode, threshold, out, max_rows);
  sum_up(image, mode, threshold, out, window);
}

void column_moments(const WideImageView& image, int bits, Mode mode, int threshold, const MomentsView& out,
                    const RowWindow& window) {
  check_column_moments(image, bits, mode, threshold, out);
  sum_up(image, mode, threshold, out, window);
}

void check_column_moments(const ImageView& image, Mode mode, int threshold, const MomentsView& out, int max_rows) {
  check(image, mode, out, max_rows);
  require(threshold >= 0 && threshold <= 255, "threshold is not in 0..255");
}

void check_column_moments(const WideImageView& image, int bits, Mode mode, int threshold, const MomentsView& out) {
  check(image, mode, out, row_limit(bits));
  require(bits >= 8 && bits <= kMaxPixelBits, "bits are not in 8..12");
  require(threshold >= 0 && threshold < 1 << bits, "threshold is not in 0..2^bits - 1");
}

void Moments::resize(int columns) {
  for (auto* values : {&m0, &m1, &n}) {
    values->resize(static_cast<std::size_t>(columns));
  }
}

MomentsView Moments::view() { return {m0.data(), m1.data(), n.data()}; }

}  // namespace selfproj::model
