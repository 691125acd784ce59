#include "lab/evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "selfproj/images/float_image.h"

namespace selfproj::lab {
namespace {

bool is_step(float a, float b, double min_step) {
  if (std::isnan(a) || std::isnan(b)) {
    return std::isnan(a) != std::isnan(b);
  }
  return std::abs(static_cast<double>(a) - static_cast<double>(b)) > min_step;
}

// Sets the entries up to `reach` steps away from set ones, along lines of `count` entries that are `stride` apart.
void spread(Mask& mask, std::size_t begin, int count, std::size_t stride, int reach) {
  std::vector<int> last_set(static_cast<std::size_t>(count));
  int last = -reach - 1;
  for (int i = 0; i < count; ++i) {
    last = mask[begin + static_cast<std::size_t>(i) * stride] != 0 ? i : last;
    last_set[static_cast<std::size_t>(i)] = last;
  }
  int next = count + reach + 1;
  for (int i = count - 1; i >= 0; --i) {
    auto& entry = mask[begin + static_cast<std::size_t>(i) * stride];
    next = entry != 0 ? i : next;
    if (i - last_set[static_cast<std::size_t>(i)] <= reach || next - i <= reach) {
      entry = 1;
    }
  }
}

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Mask near_steps(const images::FloatImage& truth, double min_step, int columns, int rows) {
  Mask along_rows(truth.values.size(), 0);
  Mask along_columns(truth.values.size(), 0);
  const auto width = static_cast<std::size_t>(truth.columns);
  for (int r = 0; r < truth.rows; ++r) {
    for (int c = 0; c < truth.columns; ++c) {
      const std::size_t at = static_cast<std::size_t>(r) * width + static_cast<std::size_t>(c);
      if (c + 1 < truth.columns && is_step(truth.values[at], truth.values[at + 1], min_step)) {
        along_rows[at] = along_rows[at + 1] = 1;
      }
      if (r + 1 < truth.rows && is_step(truth.values[at], truth.values[at + width], min_step)) {
        along_columns[at] = along_columns[at + width] = 1;
      }
    }
  }
  for (int r = 0; r < truth.rows && columns > 0; ++r) {
    spread(along_rows, static_cast<std::size_t>(r) * width, truth.columns, 1, columns - 1);
  }
  for (int c = 0; c < truth.columns && rows > 0; ++c) {
    spread(along_columns, static_cast<std::size_t>(c), truth.rows, width, rows - 1);
  }
  Mask result(truth.values.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const bool near = (columns > 0 && along_rows[i] != 0) || (rows > 0 && along_columns[i] != 0);
    result[i] = static_cast<std::uint8_t>(near || std::isnan(truth.values[i]));
  }
  return result;
}

Mask around_steps(const images::FloatImage& truth, double min_step, int columns, int rows) {
  Mask result = near_steps(truth, min_step, 1, 1);
  const auto width = static_cast<std::size_t>(truth.columns);
  for (int r = 0; r < truth.rows; ++r) {
    spread(result, static_cast<std::size_t>(r) * width, truth.columns, 1, columns - 1);
  }
  for (int c = 0; c < truth.columns; ++c) {
    spread(result, static_cast<std::size_t>(c), truth.rows, width, rows - 1);
  }
  return result;
}

HeightErrors height_errors(const images::FloatImage& height, const images::FloatImage& x, const images::FloatImage& y,
                           const Mask& left_out, const TrueHeight& truth) {
  const std::size_t size = height.values.size();
  if (x.values.size() != size || y.values.size() != size || left_out.size() != size) {
    throw std::invalid_argument("maps of different sizes");
  }
  HeightErrors result;
  double sum = 0;
  double squares = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const bool point = !std::isnan(height.values[i]);
    if (left_out[i] != 0) {
      result.left_out += point ? 1 : 0;
    } else if (!point) {
      ++result.missing;
    } else {
      const int frame = static_cast<int>(i / static_cast<std::size_t>(height.columns));
      const double error = static_cast<double>(height.values[i]) -
                           truth(frame, static_cast<double>(x.values[i]), static_cast<double>(y.values[i]));
      result.max = std::max(result.max, std::abs(error));
      sum += error;
      squares += error * error;
      ++result.points;
    }
  }
  if (result.points > 0) {
    result.mean = sum / static_cast<double>(result.points);
    result.rms = std::sqrt(squares / static_cast<double>(result.points));
  }
  return result;
}

RegionValues values_in(const images::FloatImage& map, const Mask& mask, std::uint8_t label) {
  if (mask.size() != map.values.size()) {
    throw std::invalid_argument("a mask of another size");
  }
  std::vector<double> values;
  double sum = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == label && !std::isnan(map.values[i])) {
      values.push_back(static_cast<double>(map.values[i]));
      sum += values.back();
    }
  }
  RegionValues result;
  result.count = static_cast<std::int64_t>(values.size());
  result.mean = values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(values.size());
  result.median = values.empty() ? std::numeric_limits<double>::quiet_NaN() : median_of(values);
  return result;
}

double depth_of(const images::FloatImage& difference, const Mask& mask, std::uint8_t region,
                std::uint8_t surroundings) {
  return values_in(difference, mask, surroundings).median - values_in(difference, mask, region).median;
}

CentroidRange centroid_range(const images::FloatImage& centroid, const Mask& left_out, int first_row, int rows) {
  if (left_out.size() != centroid.values.size()) {
    throw std::invalid_argument("a mask of another size");
  }
  std::vector<double> ranges;
  for (int r = std::max(first_row, 0); r < std::min(first_row + rows, centroid.rows); ++r) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    int count = 0;
    for (int c = 0; c < centroid.columns; ++c) {
      const auto at =
          static_cast<std::size_t>(r) * static_cast<std::size_t>(centroid.columns) + static_cast<std::size_t>(c);
      const auto value = static_cast<double>(centroid.values[at]);
      if (left_out[at] == 0 && !std::isnan(value)) {
        low = std::min(low, value);
        high = std::max(high, value);
        ++count;
      }
    }
    if (count >= 2) {
      ranges.push_back(high - low);
    }
  }
  if (ranges.empty()) {
    return {};
  }
  CentroidRange result;
  result.greatest = *std::max_element(ranges.begin(), ranges.end());
  result.median = median_of(ranges);
  return result;
}

}  // namespace selfproj::lab
