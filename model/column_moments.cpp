#include "selfproj/model/column_moments.h"

#include <stdexcept>
#include <string>

namespace selfproj::model {

void column_moments(const ImageView& image, Mode mode, int threshold, const MomentsView& out, const RowWindow& window,
                    int max_rows) {
  check_column_moments(image, mode, threshold, out, max_rows);
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

void check_column_moments(const ImageView& image, Mode mode, int threshold, const MomentsView& out, int max_rows) {
  const auto require = [](bool good, const char* what) {
    if (!good) {
      throw std::invalid_argument(std::string("column_moments: ") + what);
    }
  };
  require(image.rows >= 1 && image.rows <= max_rows, "rows are not in 1..kMaxRows");
  require(image.columns >= 1, "columns are less than 1");
  require(threshold >= 0 && threshold <= 255, "threshold is not in 0..255");
  require(mode == Mode::binary || mode == Mode::grey || mode == Mode::grey_over, "unknown mode");
  require(image.pixels != nullptr && out.m0 != nullptr && out.m1 != nullptr && out.n != nullptr, "null pointer");
}

void Moments::resize(int columns) {
  for (auto* values : {&m0, &m1, &n}) {
    values->resize(static_cast<std::size_t>(columns));
  }
}

MomentsView Moments::view() { return {m0.data(), m1.data(), n.data()}; }

}  // namespace selfproj::model
