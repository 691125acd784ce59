#include "lab/thing_figures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "lab/structured_light.h"

namespace selfproj {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double quantile(std::vector<float>& values, double share) {
  if (values.empty()) {
    return kNan;
  }
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

// The rows and columns over which a thing extends. A pixel counts if at least six of its 3 x 3 pixels belong to the
// thing: with e = 0, noise that moves a code down by one matches single rows of the background at the other end of the
// window. The extent goes from the first to the last row (column) with at least a quarter as many pixels as the fullest
// one, so that single pixels do not count.
std::pair<double, double> extent(const FloatImage& difference, const Thing& thing, const FloatImage& true_difference) {
  constexpr int kAround = 30;  // pixels around the true extent in which the thing is looked for
  int row_0 = difference.rows;
  int row_1 = 0;
  int column_0 = difference.columns;
  int column_1 = 0;
  for (int r = 0; r < difference.rows; ++r) {
    for (int c = thing.column_0; c < thing.column_1; ++c) {
      if (static_cast<double>(true_difference.row(r)[c]) > thing.least) {
        row_0 = std::min(row_0, r - kAround);
        row_1 = std::max(row_1, r + kAround);
        column_0 = std::min(column_0, c - kAround);
        column_1 = std::max(column_1, c + kAround);
      }
    }
  }
  std::vector<int> of_row(static_cast<std::size_t>(difference.rows), 0);
  std::vector<int> of_column(static_cast<std::size_t>(difference.columns), 0);
  const auto is_over = [&](int r, int c) { return static_cast<double>(difference.row(r)[c]) > thing.least ? 1 : 0; };
  for (int r = std::max(1, row_0); r < std::min(row_1, difference.rows - 1); ++r) {
    for (int c = std::max({1, thing.column_0, column_0});
         c < std::min({thing.column_1, difference.columns - 1, column_1}); ++c) {
      int count = 0;
      for (int dr = -1; dr <= 1; ++dr) {
        for (int dc = -1; dc <= 1; ++dc) {
          count += is_over(r + dr, c + dc);
        }
      }
      if (is_over(r, c) != 0 && count >= 6) {
        ++of_row[static_cast<std::size_t>(r)];
        ++of_column[static_cast<std::size_t>(c)];
      }
    }
  }
  const auto length = [](const std::vector<int>& counts) {
    const int least = std::max(1, *std::max_element(counts.begin(), counts.end()) / 4);
    const auto in = [least](int count) { return count >= least; };
    const auto first = std::find_if(counts.begin(), counts.end(), in);
    const auto last = std::find_if(counts.rbegin(), counts.rend(), in);
    return first == counts.end() ? 0.0 : static_cast<double>(last.base() - first);
  };
  return {length(of_row), length(of_column)};
}

}  // namespace

ThingFigures figures_of(const Thing& thing, const FloatImage& depth, const FloatImage& difference,
                        const FloatImage& truth, const FloatImage& true_difference) {
  ThingFigures f;
  std::vector<float> heights;
  std::vector<float> true_heights;
  for (int r = 0; r < depth.rows; ++r) {
    for (int c = thing.column_0; c < thing.column_1; ++c) {
      if (!(true_difference.row(r)[c] > 1)) {
        continue;
      }
      ++f.pixels;
      true_heights.push_back(true_difference.row(r)[c]);
      const double error = static_cast<double>(depth.row(r)[c]) - static_cast<double>(truth.row(r)[c]);
      if (!std::isnan(error) && !std::isnan(difference.row(r)[c])) {
        ++f.valid;
        f.square += error * error;
        heights.push_back(difference.row(r)[c]);
      }
    }
  }
  constexpr double kShare = 0.95;
  f.height = quantile(heights, kShare);
  f.true_height = quantile(true_heights, kShare);
  std::tie(f.rows, f.columns) = extent(difference, thing, true_difference);
  std::tie(f.true_rows, f.true_columns) = extent(true_difference, thing, true_difference);
  return f;
}

void ThingSummary::add(const ThingFigures& f) {
  ++images_;
  pixels_ += static_cast<double>(f.pixels);
  valid_ += static_cast<double>(f.valid);
  square_ += f.square;
  worst_ = std::max(worst_, f.rms());
  height_ += f.height - f.true_height;
  height_most_ = std::max(height_most_, std::abs(f.height - f.true_height));
  size_most_ = std::max({size_most_, std::abs(f.rows - f.true_rows), std::abs(f.columns - f.true_columns)});
  rows_ += f.rows - f.true_rows;
  columns_ += f.columns - f.true_columns;
}

std::vector<std::string> ThingSummary::cells() const {
  return {std::to_string(images_),
          figure_text(100 * valid_ / pixels_, 1),
          figure_text(rms()),
          figure_text(worst_),
          figure_text(height_ / images_),
          figure_text(height_most_),
          figure_text(rows_ / images_, 1),
          figure_text(columns_ / images_, 1),
          figure_text(size_most_, 0)};
}

}  // namespace selfproj
