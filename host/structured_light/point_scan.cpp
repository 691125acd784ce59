#include "host/structured_light/point_scan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "host/structured_light/check.h"

namespace selfproj::structured_light {
namespace {

constexpr float kApart = 4;  // lines between two separate places of light

// Keeps the points of which both coordinates are known.
ProjectorPoints both(images::FloatImage line, images::FloatImage column) {
  for (std::size_t i = 0; i < line.values.size(); ++i) {
    if (std::isnan(line.values[i]) || std::isnan(column.values[i])) {
      line.values[i] = column.values[i] = images::kNoValue;
    }
  }
  return {std::move(line), std::move(column)};
}

}  // namespace

AxisScan::AxisScan(int rows, int columns, int contrast) : rows_(rows), columns_(columns), contrast_(contrast) {
  check(rows >= 1 && columns >= 1, "axis scan: rows or columns are less than 1");
  pixels_ = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  ring_.resize(pixels_ * kRing);
  look_.assign(pixels_, static_cast<std::uint8_t>(std::clamp(contrast, 0, 255)));
  best_.assign(pixels_, 0);
  second_.assign(pixels_, 0);
  place_.assign(pixels_, images::kNoValue);
}

void AxisScan::add(const model::ImageView& image) {
  check(image.rows == rows_ && image.columns == columns_, "axis scan: an image has another size");
  std::uint8_t* to = ring_.data() + static_cast<std::size_t>(lines_ % kRing) * pixels_;
  for (int r = 0; r < rows_; ++r) {
    to = std::copy_n(image.pixels + r * image.stride, columns_, to);
  }
  ++lines_;
  // Lines less than kReach from the ends are skipped, because their light is not whole.
  if (lines_ >= kRing) {
    look_at(lines_ - 1 - kReach);
  }
}

void AxisScan::look_at(int line) {
  const auto image = [&](int of) { return ring_.data() + static_cast<std::size_t>(of % kRing) * pixels_; };
  const std::uint8_t* before = image(line - 1);
  const std::uint8_t* here = image(line);
  const std::uint8_t* after = image(line + 1);
  for (std::size_t i = 0; i < pixels_; ++i) {
    if (here[i] > look_[i] && here[i] >= before[i] && here[i] >= after[i]) {
      weigh(line, i);
    }
  }
}

void AxisScan::weigh(int line, std::size_t pixel) {
  const int left = value(line - kReach, pixel) + value(line - kReach + 1, pixel);
  const int right = value(line + kReach, pixel) + value(line + kReach - 1, pixel);
  const float ground = 0.5F * static_cast<float>(std::min(left, right));
  const float contrast = static_cast<float>(value(line, pixel)) - ground;
  if (contrast <= static_cast<float>(contrast_)) {
    return;
  }
  // The neighbouring values above a quarter of the peak and above the noise, without a gap.
  const float least = ground + std::max(0.25F * contrast, 3.0F);
  float light = 0;
  float moment = 0;
  const auto walk = [&](int step) {
    for (int k = step > 0 ? 0 : step; std::abs(k) <= kReach; k += step) {
      const float over = static_cast<float>(value(line + k, pixel)) - least;
      if (over <= 0) {
        return true;
      }
      light += over;
      moment += over * static_cast<float>(k);
    }
    return false;  // no end of it was found
  };
  const bool whole_right = walk(1);
  const bool whole_left = walk(-1);
  if (!whole_right || !whole_left) {
    return;
  }
  const float place = static_cast<float>(line) + moment / light;
  const bool apart = std::abs(place - place_[pixel]) > kApart;  // false for NaN
  if (contrast > best_[pixel]) {
    if (apart) {
      second_[pixel] = best_[pixel];
    }
    best_[pixel] = contrast;
    place_[pixel] = place;
    look_[pixel] = static_cast<std::uint8_t>(std::min(ground + 0.5F * contrast, 255.0F));
  } else if (apart) {
    second_[pixel] = std::max(second_[pixel], contrast);
  }
}

images::FloatImage AxisScan::coordinates() {
  images::FloatImage result(rows_, columns_, images::kNoValue);
  for (std::size_t i = 0; i < pixels_; ++i) {
    if (second_[i] <= 0.5F * best_[i]) {
      result.values[i] = place_[i];
    }
  }
  return result;
}

LinePointScan::LinePointScan(const rig::Rig& rig)
    : lines_(rig.projector.lines),
      columns_(rig.projector.columns),
      line_axis_(rig.camera.rows, rig.camera.columns, rig.measure.code_threshold),
      column_axis_(rig.camera.rows, rig.camera.columns, rig.measure.code_threshold) {}

void LinePointScan::add(const model::ImageView& image) {
  check(next_ < count(), "line scan: there are more images than lines and columns");
  (next_ < lines_ ? line_axis_ : column_axis_).add(image);
  ++next_;
}

ProjectorPoints LinePointScan::points() { return both(line_axis_.coordinates(), column_axis_.coordinates()); }

namespace {

// The code without what follows the planes `above` (a mask). Reflected codes change in one plane only, so two codes
// that differ in plane `bit` alone are mirror images about the edge between them.
float place_of_code(unsigned code, unsigned ambiguous, int max_open) {
  if (ambiguous == 0) {
    return static_cast<float>(code);
  }
  const unsigned top = std::bit_floor(ambiguous);
  const unsigned below = top - 1;
  // All of the finest planes from `top` on are ambiguous: 2 top codes are left open, and their middle is taken.
  if (ambiguous == (top | below)) {
    if (2 * top > static_cast<unsigned>(max_open)) {
      return images::kNoValue;
    }
    const unsigned first = code & ~(ambiguous);
    return static_cast<float>(first) + 0.5F * static_cast<float>(2 * top - 1);
  }
  if (ambiguous != top) {
    return images::kNoValue;
  }
  // One plane alone is ambiguous. If it is taken for 0, the bits of the code from there on have the parity of the
  // planes above. The other choice inverts all of them. An edge lies only between neighbouring codes.
  const unsigned other = code ^ (top | below);
  const int apart = std::abs(static_cast<int>(code) - static_cast<int>(other));
  return apart == 1 ? 0.5F * static_cast<float>(code + other) : images::kNoValue;
}

}  // namespace

images::FloatImage coordinates_of_codes(const AmbiguousCodes& codes, int max_open, int reach, double jump) {
  const int rows = codes.rows;
  const int columns = codes.columns;
  images::FloatImage raw(rows, columns);
  for (std::size_t i = 0; i < raw.values.size(); ++i) {
    raw.values[i] = place_of_code(codes.codes[i], codes.ambiguous[i], max_open);
  }
  images::FloatImage result = raw;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const auto middle = static_cast<double>(raw.row(r)[c]);
      if (std::isnan(middle)) {
        continue;
      }
      // Least squares of place = p + q dr + s dc.
      double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, v = 0, vx = 0, vy = 0;
      int looked = 0;
      for (int dr = -reach; dr <= reach; ++dr) {
        for (int dc = -reach; dc <= reach; ++dc) {
          ++looked;
          if (r + dr < 0 || r + dr >= rows || c + dc < 0 || c + dc >= columns) {
            continue;
          }
          const double place = static_cast<double>(raw.row(r + dr)[c + dc]) - middle;
          if (!(std::abs(place) <= jump * (std::abs(dr) + std::abs(dc)))) {
            continue;
          }
          n += 1;
          x += dr;
          y += dc;
          xx += dr * dr;
          xy += dr * dc;
          yy += dc * dc;
          v += place;
          vx += place * dr;
          vy += place * dc;
        }
      }
      if (2 * n < looked) {
        continue;
      }
      const double det = n * (xx * yy - xy * xy) - x * (x * yy - xy * y) + y * (x * xy - xx * y);
      const double top = v * (xx * yy - xy * xy) - x * (vx * yy - xy * vy) + y * (vx * xy - xx * vy);
      if (std::abs(det) > 1e-9) {
        result.row(r)[c] = static_cast<float>(middle + top / det);
      }
    }
  }
  return result;
}

GrayPointScan::GrayPointScan(const rig::Rig& rig)
    : sequence_(rig.projector.columns, rig.projector.lines),
      columns_({rig.camera.rows, rig.camera.columns, sequence_.column_bits(), rig.measure.code_threshold}),
      lines_({rig.camera.rows, rig.camera.columns, sequence_.row_bits(), rig.measure.code_threshold}),
      positive_(static_cast<std::size_t>(rig.camera.rows) * static_cast<std::size_t>(rig.camera.columns)) {}

void GrayPointScan::add(const model::ImageView& image) {
  check(next_ < count(), "gray scan: there are more images than patterns");
  check(image.rows == lines_.settings().rows && image.columns == lines_.settings().columns,
        "gray scan: an image has another size");
  const bool of_columns = next_ < sequence_.first_of_rows();
  const int pattern = of_columns ? next_ : next_ - sequence_.first_of_rows();
  if (next_ < sequence_.white()) {
    FastGrayDecoder& decoder = of_columns ? columns_ : lines_;
    if (pattern % 2 == 0) {
      for (int r = 0; r < image.rows; ++r) {
        std::copy_n(image.pixels + r * image.stride, image.columns,
                    positive_.data() + static_cast<std::ptrdiff_t>(r) * image.columns);
      }
      decoder.add_frame({positive_.data(), image.rows, image.columns, image.columns}, pattern);
    } else {
      decoder.add_frame(image, pattern);
    }
  }
  ++next_;
}

ProjectorPoints GrayPointScan::points() const {
  const auto coordinates = [](const CodeImageView& image) {
    AmbiguousCodes codes{image.rows, image.columns, image.bits, {}, {}};
    const auto count = static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.columns);
    if (image.codes8 != nullptr) {
      codes.codes.assign(image.codes8, image.codes8 + count);
      codes.ambiguous.assign(image.ambiguous8, image.ambiguous8 + count);
    } else {
      codes.codes.assign(image.codes16, image.codes16 + count);
      codes.ambiguous.assign(image.ambiguous16, image.ambiguous16 + count);
    }
    return coordinates_of_codes(codes);
  };
  return both(coordinates(lines_.codes()), coordinates(columns_.codes()));
}

}  // namespace selfproj::structured_light
