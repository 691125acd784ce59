#include "selfproj/model/column_runs.h"

#include <algorithm>
#include <stdexcept>

namespace selfproj::model {
namespace {

struct Run {
  std::uint32_t m0 = 0;
  std::uint32_t m1 = 0;
  std::uint32_t n = 0;
};

struct RunsOfColumn {
  Run strongest;
  std::uint32_t second = 0;  // M0 of the second
  int count = 0;

  void add(const Run& run) {
    second = std::max(second, std::min(run.m0, strongest.m0));
    if (run.m0 > strongest.m0) {
      strongest = run;
    }
    ++count;
  }
};

template <typename Pixel>
RunsOfColumn runs_of(const PixelView<Pixel>& image, const Measure& measure, int column) {
  RunsOfColumn runs;
  Run run;
  int dark = 0;  // rows since the last lit pixel of the run
  for (int row = 1; row <= image.rows; ++row) {
    const int pixel = image.pixels[(row - 1) * image.stride + column];
    const bool lit = pixel > measure.threshold && measure.window.counts(row);
    dark = lit ? 0 : dark + 1;
    if (lit) {
      const std::uint32_t w = pixel_weight(measure.mode, measure.threshold, pixel);
      run = {run.m0 + w, run.m1 + static_cast<std::uint32_t>(row) * w, run.n + 1};
    }
    if (run.n > 0 && (dark > measure.gap || row == image.rows)) {
      runs.add(run);
      run = {};
    }
  }
  return runs;
}

template <typename Pixel>
void find_runs(const PixelView<Pixel>& image, const Measure& measure, const RunsView& out) {
  for (int column = 0; column < image.columns; ++column) {
    const RunsOfColumn runs = runs_of(image, measure, column);
    const auto& [m0, m1, n] = runs.strongest;
    out.moments.m0[column] = m0;
    out.moments.m1[column] = m1;
    out.moments.n[column] = n;
    out.runs[column] = static_cast<std::uint8_t>(std::min(runs.count, 3));
    out.second[column] = static_cast<std::uint8_t>(m0 == 0 ? 0 : 16 * runs.second / m0);
  }
}

void check_gap(const Measure& measure, const RunsView& out) {
  if (measure.gap < 0 || measure.gap > kMaxGap || out.runs == nullptr || out.second == nullptr) {
    throw std::invalid_argument("column_runs: gap is not in 0..kMaxGap, or null pointer");
  }
}

// Of pixels of more bits an image of 8 is none.
void need_pixels_of_eight_bits(const Measure& measure) {
  if (measure.bits != spec::kPixelBits) {
    throw std::invalid_argument("measure: its pixels have more than 8 bits, those of the image 8");
  }
}

}  // namespace

void column_runs(const ImageView& image, const Measure& measure, const RunsView& out, int max_rows) {
  check_column_runs(image, measure, out, max_rows);
  find_runs(image, measure, out);
}

void column_runs(const WideImageView& image, const Measure& measure, const RunsView& out) {
  check_column_runs(image, measure, out);
  find_runs(image, measure, out);
}

void measure_columns(const ImageView& image, const Measure& measure, const RunsView& out) {
  need_pixels_of_eight_bits(measure);
  if (measure.select == Select::strongest) {
    column_runs(image, measure, out);
  } else {
    column_moments(image, measure.mode, measure.threshold, out.moments, measure.window);
  }
}

void measure_columns(const WideImageView& image, const Measure& measure, const RunsView& out) {
  if (measure.select == Select::strongest) {
    column_runs(image, measure, out);
  } else {
    column_moments(image, measure.bits, measure.mode, measure.threshold, out.moments, measure.window);
  }
}

void measure_tall_columns(const ImageView& image, const Measure& measure, const RunsView& out) {
  need_pixels_of_eight_bits(measure);
  if (measure.select == Select::strongest) {
    column_runs(image, measure, out, kMaxSoftwareRows);
  } else {
    column_moments(image, measure.mode, measure.threshold, out.moments, measure.window, kMaxSoftwareRows);
  }
}

void check_column_runs(const ImageView& image, const Measure& measure, const RunsView& out, int max_rows) {
  check_column_moments(image, measure.mode, measure.threshold, out.moments, max_rows);
  check_gap(measure, out);
}

void check_column_runs(const WideImageView& image, const Measure& measure, const RunsView& out) {
  check_column_moments(image, measure.bits, measure.mode, measure.threshold, out.moments);
  check_gap(measure, out);
}

}  // namespace selfproj::model
