#include "host/calibration/chessboard.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/line_removal.h"
#include "host/files/numbers.h"

namespace selfproj::calibration {
namespace {

// Distance from each corner to its nearest neighbour.
std::vector<double> spacings(const std::vector<cv::Point2f>& corners) {
  std::vector<double> nearest;
  nearest.reserve(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < corners.size(); ++j) {
      if (j != i) {
        least = std::min(least, cv::norm(corners[i] - corners[j]));
      }
    }
    nearest.push_back(least);
  }
  return nearest;
}

// The image of a corner: two crossing edges, equally blurred, under light that may fall off across the window,
//
//     I(x, y) = (a + b x + c y) (1 + d erf(u / (s sqrt 2)) erf(v / (s sqrt 2)))
//
// where u and v are the distances of (x, y) from the edges. The edges go through (x0, y0) and have normals at the
// angles t1 and t2.
struct CornerModel {
  static constexpr int kParameters = 9;
  // x0, y0, t1, t2, s, a, b, c, d
  static constexpr int kX = 0, kY = 1, kAngle1 = 2, kAngle2 = 3, kBlur = 4, kLight = 5, kLightX = 6, kLightY = 7,
                       kContrast = 8;
  using Parameters = cv::Vec<double, kParameters>;

  // Grey value at (x, y) from the window's middle, and its derivatives by the parameters.
  static double value(const Parameters& p, double x, double y, Parameters& d) {
    const double c1 = std::cos(p[kAngle1]);
    const double s1 = std::sin(p[kAngle1]);
    const double c2 = std::cos(p[kAngle2]);
    const double s2 = std::sin(p[kAngle2]);
    const double dx = x - p[kX];
    const double dy = y - p[kY];
    const double u = c1 * dx + s1 * dy;
    const double v = c2 * dx + s2 * dy;
    const double k = 1 / (p[kBlur] * std::numbers::sqrt2);
    const double e1 = std::erf(u * k);
    const double e2 = std::erf(v * k);
    const double light = p[kLight] + p[kLightX] * x + p[kLightY] * y;
    const double shape = 1 + p[kContrast] * e1 * e2;
    constexpr double kSlope = 2 * std::numbers::inv_sqrtpi;  // of erf at 0
    const double by_u = light * p[kContrast] * kSlope * k * std::exp(-u * u * k * k) * e2;
    const double by_v = light * p[kContrast] * kSlope * k * std::exp(-v * v * k * k) * e1;
    d[kX] = -by_u * c1 - by_v * c2;
    d[kY] = -by_u * s1 - by_v * s2;
    d[kAngle1] = by_u * (c1 * dy - s1 * dx);
    d[kAngle2] = by_v * (c2 * dy - s2 * dx);
    d[kBlur] = -(by_u * u + by_v * v) / p[kBlur];
    d[kLight] = shape;
    d[kLightX] = shape * x;
    d[kLightY] = shape * y;
    d[kContrast] = light * e1 * e2;
    return light * shape;
  }
};

struct Pixel {
  double x, y, grey;
};

double squares(const std::vector<Pixel>& pixels, const CornerModel::Parameters& p) {
  CornerModel::Parameters unused;
  double sum = 0;
  for (const Pixel& pixel : pixels) {
    const double off = pixel.grey - CornerModel::value(p, pixel.x, pixel.y, unused);
    sum += off * off;
  }
  return sum;
}

// Levenberg-Marquardt; returns whether it converged.
bool fit(const std::vector<Pixel>& pixels, CornerModel::Parameters& p) {
  using Model = CornerModel;
  constexpr int kSteps = 40;
  constexpr double kClose = 1e-5;  // pixels
  constexpr double kMinBlur = 0.1;
  constexpr double kWorst = 1e6;
  double damping = 1e-3;
  double sum = squares(pixels, p);
  for (int step = 0; step < kSteps; ++step) {
    cv::Matx<double, Model::kParameters, Model::kParameters> normal;
    Model::Parameters right = Model::Parameters::all(0);
    Model::Parameters d;
    for (const Pixel& pixel : pixels) {
      const double off = pixel.grey - Model::value(p, pixel.x, pixel.y, d);
      right += off * d;
      normal += d * d.t();
    }
    bool better = false;
    while (!better && damping < kWorst) {
      auto damped = normal;
      for (int i = 0; i < Model::kParameters; ++i) {
        damped(i, i) *= 1 + damping;
      }
      bool ok = false;
      const Model::Parameters change = damped.inv(cv::DECOMP_CHOLESKY, &ok) * right;
      const Model::Parameters tried = p + change;
      const double there = ok && tried[Model::kBlur] > kMinBlur ? squares(pixels, tried) : sum + 1;
      better = there <= sum;
      damping = better ? std::max(1e-9, damping / 10) : damping * 10;
      if (better) {
        p = tried;
        sum = there;
        if (std::abs(change[Model::kX]) + std::abs(change[Model::kY]) < kClose) {
          return true;
        }
      }
    }
    if (!better) {
      return false;
    }
  }
  return false;
}

// Moves each corner to where the model of a corner fits best, in a window that reaches no other corner. A corner
// without a fit stays.
void refine(const cv::Mat& grey, const Chessboard& chessboard, const std::vector<double>& spacing,
            std::vector<cv::Point2f>& corners) {
  using Model = CornerModel;
  constexpr double kShare = 0.4;  // half the window's side, in parts of the spacing
  constexpr double kMin = 3;
  constexpr double kFarthest = 0.3;  // in parts of the spacing; whatever is farther away is something else
  const std::vector<cv::Point2f> found = corners;
  const auto at = [&](int column, int row) {
    return cv::Point2d(found[static_cast<std::size_t>(std::clamp(row, 0, chessboard.rows - 1) * chessboard.columns +
                                                      std::clamp(column, 0, chessboard.columns - 1))]);
  };
  for (int i = 0; i < chessboard.corners(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const cv::Point2d middle = found[index];
    const int column = i % chessboard.columns;
    const int row = i / chessboard.columns;
    const double half = std::max(kMin, kShare * spacing[index]);
    const cv::Point2d along = at(column + 1, row) - at(column - 1, row);  // the edges go through the neighbours
    const cv::Point2d down = at(column, row + 1) - at(column, row - 1);
    Model::Parameters p;
    p[Model::kAngle1] = std::atan2(along.x, -along.y);
    p[Model::kAngle2] = std::atan2(down.x, -down.y);
    p[Model::kBlur] = 1;
    std::vector<Pixel> pixels;
    double sum = 0;
    double sides = 0;
    for (int y = std::max(0, static_cast<int>(std::ceil(middle.y - half)));
         y <= std::min(grey.rows - 1, static_cast<int>(std::floor(middle.y + half))); ++y) {
      for (int x = std::max(0, static_cast<int>(std::ceil(middle.x - half)));
           x <= std::min(grey.cols - 1, static_cast<int>(std::floor(middle.x + half))); ++x) {
        const Pixel pixel{x - middle.x, y - middle.y, static_cast<double>(grey.at<std::uint8_t>(y, x))};
        const bool one = (std::cos(p[Model::kAngle1]) * pixel.x + std::sin(p[Model::kAngle1]) * pixel.y > 0) ==
                         (std::cos(p[Model::kAngle2]) * pixel.x + std::sin(p[Model::kAngle2]) * pixel.y > 0);
        sum += pixel.grey;
        sides += one ? pixel.grey : -pixel.grey;
        pixels.push_back(pixel);
      }
    }
    p[Model::kLight] = sum / static_cast<double>(pixels.size());
    p[Model::kContrast] = sum > 0 ? sides / sum : 0;
    if (fit(pixels, p) && std::hypot(p[Model::kX], p[Model::kY]) < kFarthest * spacing[index]) {
      corners[index] = cv::Point2f(cv::Point2d(middle.x + p[Model::kX], middle.y + p[Model::kY]));
    }
  }
}

}  // namespace

namespace {

// Corners as a detector found them, row by row.
struct Lattice {
  int columns = 0;
  int rows = 0;
  std::vector<cv::Point2f> corners;

  [[nodiscard]] cv::Point2f at(int column, int row) const {
    return corners[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                   static_cast<std::size_t>(column)];
  }
};

// The part of a lattice from this corner on.
Lattice part_of(const Lattice& whole, int left, int top, int columns, int rows) {
  Lattice part{columns, rows, {}};
  for (int row = top; row < top + rows; ++row) {
    for (int column = left; column < left + columns; ++column) {
      part.corners.push_back(whole.at(column, row));
    }
  }
  return part;
}

// The same corners with columns as rows, not mirrored.
Lattice turned(const Lattice& lattice) {
  Lattice result{lattice.rows, lattice.columns, {}};
  for (int row = 0; row < result.rows; ++row) {
    for (int column = 0; column < result.columns; ++column) {
      result.corners.push_back(lattice.at(lattice.columns - 1 - row, column));
    }
  }
  return result;
}

// Detectors may number corners as if they saw the board in a mirror.
void make_right_handed(Lattice& lattice) {
  const cv::Point2f along = lattice.at(1, 0) - lattice.at(0, 0);
  const cv::Point2f down = lattice.at(0, 1) - lattice.at(0, 0);
  if (along.cross(down) >= 0) {
    return;
  }
  for (int row = 0; row < lattice.rows; ++row) {
    const auto first = lattice.corners.begin() + static_cast<std::ptrdiff_t>(row) * lattice.columns;
    std::reverse(first, first + lattice.columns);
  }
}

// How much a place looks like the corner of four squares: by how much the darker of two opposite ones is brighter than
// the brighter of the other two, as a share of all; negative where `along` and `down`, which lead to the next corners,
// enclose a dark one, and 0 where neither pair is. At the edge of a board three of them are alike, which gives 0.
// Nothing if a part of it is outside the image.
std::optional<double> crossing(const cv::Mat& grey, cv::Point2f place, cv::Point2f along, cv::Point2f down) {
  std::array<double, 4> squares{};
  for (const float u : {-0.5F, -0.25F, 0.25F, 0.5F}) {
    for (const float v : {-0.5F, -0.25F, 0.25F, 0.5F}) {
      const cv::Point pixel(place + u * along + v * down);
      if (pixel.x < 0 || pixel.y < 0 || pixel.x >= grey.cols || pixel.y >= grey.rows) {
        return std::nullopt;
      }
      squares.at((u > 0 ? 1 : 0) + (v > 0 ? 2 : 0)) += grey.at<std::uint8_t>(pixel);
    }
  }
  const auto [near, right, left, far] = squares;
  const double sum = near + right + left + far;
  const double bright = std::min(near, far) - std::max(left, right);
  const double dark = std::min(left, right) - std::max(near, far);
  return sum <= 0 ? 0 : (std::max(bright, 0.0) - std::max(dark, 0.0)) / sum;
}

// The crossings of a line of corners, with the signs that they have in a chessboard: the mean. `outside`: of the line
// that would follow beyond this one, as far as it is in the image; nothing if less than half of it is.
class Crossings {
 public:
  Crossings(const cv::Mat& grey, const Lattice& lattice) : grey_(grey), lattice_(lattice) {
    std::vector<double> all;
    for (int row = 0; row < lattice.rows; ++row) {
      for (int column = 0; column < lattice.columns; ++column) {
        all.push_back(signed_at(column, row, 0, 0).value_or(0));
      }
    }
    typical_ = files::median_of(all);
    const auto good = [this](double value) {
      return value * typical_ > 0 && std::abs(value) > kClear * std::abs(typical_);
    };
    share_ = static_cast<double>(std::count_if(all.begin(), all.end(), good)) / static_cast<double>(all.size());
  }

  // The share of corners that look like the others.
  [[nodiscard]] double share() const { return share_; }

  // Whether the outer line on this side (or the one that would follow `beyond` it) is made of corners of the board.
  [[nodiscard]] bool is_line(int side, bool beyond) const {
    const bool column = side < 2;
    const bool first = side % 2 == 0;
    const int step = beyond ? (first ? -1 : 1) : 0;
    const int count = column ? lattice_.rows : lattice_.columns;
    std::vector<double> line;
    for (int i = 0; i < count; ++i) {
      const auto value = column ? signed_at(first ? 0 : lattice_.columns - 1, i, step, 0)
                                : signed_at(i, first ? 0 : lattice_.rows - 1, 0, step);
      if (value) {
        line.push_back(*value / typical_);
      }
    }
    return 2 * line.size() >= static_cast<std::size_t>(count) && files::median_of(line) > kClear;
  }

 private:
  static constexpr double kClear = 0.35;  // in parts of the typical crossing

  // The crossing at a corner, or a step of one square beyond it.
  [[nodiscard]] std::optional<double> signed_at(int column, int row, int step_x, int step_y) const {
    const int c = std::clamp(column, 1, lattice_.columns - 1);
    const int r = std::clamp(row, 1, lattice_.rows - 1);
    const cv::Point2f along = lattice_.at(c, row) - lattice_.at(c - 1, row);
    const cv::Point2f down = lattice_.at(column, r) - lattice_.at(column, r - 1);
    const auto value = crossing(
        grey_, lattice_.at(column, row) + static_cast<float>(step_x) * along + static_cast<float>(step_y) * down, along,
        down);
    return value && (column + row + step_x + step_y) % 2 != 0 ? -*value : value;
  }

  const cv::Mat& grey_;
  const Lattice& lattice_;
  double typical_ = 0;
  double share_ = 0;
};

// Takes away outer lines that a detector has seen where no corners are, until the lattice has the chessboard's size in
// one of its two positions. Returns whether it has.
bool trim(const cv::Mat& grey, const Chessboard& chessboard, Lattice& lattice) {
  const auto fits = [&](int columns, int rows) { return lattice.columns >= columns && lattice.rows >= rows; };
  if (!fits(chessboard.columns, chessboard.rows) ||
      (fits(chessboard.rows, chessboard.columns) && lattice.columns < lattice.rows)) {
    if (!fits(chessboard.rows, chessboard.columns)) {
      return false;
    }
    lattice = turned(lattice);
  }
  while (lattice.columns > chessboard.columns || lattice.rows > chessboard.rows) {
    const Crossings crossings(grey, lattice);
    std::optional<Lattice> smaller;
    for (int side = 0; side < 4 && !smaller; ++side) {
      const bool column = side < 2;
      if ((column ? lattice.columns > chessboard.columns : lattice.rows > chessboard.rows) &&
          !crossings.is_line(side, false)) {
        smaller = part_of(lattice, side == 0 ? 1 : 0, side == 2 ? 1 : 0, lattice.columns - (column ? 1 : 0),
                          lattice.rows - (column ? 0 : 1));
      }
    }
    if (!smaller) {
      return false;
    }
    lattice = std::move(*smaller);
  }
  make_right_handed(lattice);
  return true;
}

// What OpenCV's older detector finds: more where the light is uneven or something crosses the board. It takes a part of
// a larger board for the whole one, so the lines that would follow must be none.
std::optional<Lattice> find_by_squares(const cv::Mat& grey, const Chessboard& chessboard) {
  constexpr double kMostCorners = 0.7;  // a line of light may hide those that it crosses
  constexpr double kShareOfSpacing = 0.3;
  Lattice lattice{chessboard.columns, chessboard.rows, {}};
  if (!cv::findChessboardCorners(grey, {chessboard.columns, chessboard.rows}, lattice.corners)) {
    return std::nullopt;
  }
  const int half = std::max(2, static_cast<int>(kShareOfSpacing * files::median_of(spacings(lattice.corners))));
  cv::cornerSubPix(grey, lattice.corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 0.001});
  make_right_handed(lattice);
  const Crossings crossings(grey, lattice);
  if (crossings.share() < kMostCorners) {
    return std::nullopt;
  }
  for (int side = 0; side < 4; ++side) {
    if (crossings.is_line(side, true)) {
      return std::nullopt;
    }
  }
  return lattice;
}

}  // namespace

FoundChessboard find_chessboard(const images::Image& image, const Chessboard& chessboard) {
  const cv::Mat grey(image.rows, image.columns, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()));  // NOLINT
  FoundChessboard found;
  cv::Mat seen;
  cv::Mat kinds;  // one entry for each corner of the chessboard found, whatever its size
  const bool any =
      cv::findChessboardCornersSB(grey, {chessboard.columns, chessboard.rows}, seen,
                                  cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY | cv::CALIB_CB_LARGER, kinds);
  Lattice lattice;
  if (any) {
    lattice = {kinds.cols, kinds.rows, seen.reshape(2, kinds.cols * kinds.rows)};
  }
  const bool whole = any && kinds.cols == chessboard.columns && kinds.rows == chessboard.rows;
  if (!whole && !(any && trim(grey, chessboard, lattice))) {
    std::optional<Lattice> other = find_by_squares(grey, chessboard);
    if (!other) {
      found.reason = any ? fmt::format("a board of {} x {} inner corners is seen, not one of {} x {}", kinds.cols,
                                       kinds.rows, chessboard.columns, chessboard.rows)
                         : fmt::format("no chessboard of {} x {} inner corners is completely visible",
                                       chessboard.columns, chessboard.rows);
      return found;
    }
    lattice = std::move(*other);
    found.by_squares = true;
  }
  const std::vector<double> spacing = spacings(lattice.corners);
  refine(grey, chessboard, spacing, lattice.corners);
  found.corners.assign(lattice.corners.begin(), lattice.corners.end());
  found.spacing_px = files::median_of(spacing);
  return found;
}

FoundChessboard find_chessboard_under_line(const images::Image& image, const images::Image& light,
                                           const Chessboard& chessboard) {
  constexpr double kBeside = 0.35;    // of the corners' distance
  constexpr double kThin = 1.0 / 40;  // of the image's shorter side
  const int most = std::max(3, static_cast<int>(kThin * std::min(image.rows, image.columns)));
  const std::optional<LightBand> band = line_of_light(light.pixels.empty() ? thin_light(image, most) : light);
  FoundChessboard found = band ? find_chessboard(without_band(image, *band), chessboard) : FoundChessboard{};
  const auto above = std::count_if(found.corners.begin(), found.corners.end(),
                                   [&](const cv::Point2d& corner) { return band->off(corner) > 0; });
  if (above == 0 || above == static_cast<std::ptrdiff_t>(found.corners.size())) {  // the line is beside the board
    FoundChessboard plain = find_chessboard(image, chessboard);
    return plain.corners.empty() && !found.corners.empty() ? found : plain;
  }
  for (const cv::Point2d& corner : found.corners) {
    found.hidden.push_back(std::abs(band->off(corner)) < band->half + kBeside * found.spacing_px);
  }
  return found;
}

namespace {

using Values = std::vector<double>;  // one for each corner

double dot(const Values& a, const Values& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += a[i] * b[i];
  }
  return sum;
}

// Legendre's polynomial of this degree.
double legendre(int degree, double x) {
  double before = 0;
  double now = 1;
  for (int n = 0; n < degree; ++n) {
    const double next = ((2 * n + 1) * x * now - n * before) / (n + 1);
    before = now;
    now = next;
  }
  return now;
}

// The places of the corners from -1 to 1 along both sides.
struct Grid {
  explicit Grid(const Chessboard& chessboard) : board(chessboard) {
    for (int i = 0; i < board.corners(); ++i) {
      x.push_back(2.0 * (i % board.columns) / (board.columns - 1) - 1);
      const int row = i / board.columns;
      y.push_back(2.0 * row / (board.rows - 1) - 1);
    }
  }

  // P_i(x) P_j(y) without the part that is a motion of the plane, and with root mean square `rms`; 0 if there are too
  // few corners to tell it from a lower degree.
  [[nodiscard]] Values mode(int i, int j, double rms) const {
    Values values(x.size(), 0.0);
    if (i >= board.columns || j >= board.rows) {
      return values;
    }
    for (std::size_t k = 0; k < x.size(); ++k) {
      values[k] = legendre(i, x[k]) * legendre(j, y[k]);
    }
    for (const Values& moved : {Values(x.size(), 1.0), x, y}) {  // orthogonal to each other
      const double share = dot(values, moved) / dot(moved, moved);
      for (std::size_t k = 0; k < x.size(); ++k) {
        values[k] -= share * moved[k];
      }
    }
    scale(values, dot(values, values), rms);
    return values;
  }

  void scale(Values& values, double squares, double rms) const {
    constexpr double kNothing = 1e-9;
    const double length = std::sqrt(squares / static_cast<double>(x.size()));
    for (double& value : values) {
      value *= length > kNothing ? rms / length : 0;
    }
  }

  Chessboard board;
  Values x, y;
};

}  // namespace

std::vector<CornerModes> board_modes(const Chessboard& chessboard) {
  constexpr int kMinDegree = 2;
  constexpr int kMaxDegree = 5;
  const Grid grid(chessboard);
  std::vector<CornerModes> modes(grid.x.size());
  std::size_t bend = 0;
  for (int degree = kMinDegree; degree <= kMaxDegree; ++degree) {
    for (int j = 0; j <= degree; ++j, ++bend) {
      const Values values = grid.mode(degree - j, j, 1.0 / (degree - 1));
      for (std::size_t k = 0; k < modes.size(); ++k) {
        modes[k].bend[bend] = values[k];
      }
    }
  }
  // Stretched along x and squeezed along y; sheared without a turn; bent within the plane.
  const double width = chessboard.columns - 1;
  const double height = chessboard.rows - 1;
  Values along(grid.x);
  Values across(grid.y);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    along[k] *= width;
    across[k] *= height;
  }
  const double squares = dot(along, along) + dot(across, across);
  grid.scale(along, squares, 1);
  grid.scale(across, squares, 1);
  std::size_t stretch = 2;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    modes[k].stretch[0] = {along[k], -across[k]};
    modes[k].stretch[1] = {across[k], along[k]};
  }
  for (int j = 0; j <= kMinDegree; ++j, stretch += 2) {
    const Values values = grid.mode(kMinDegree - j, j, 1);
    for (std::size_t k = 0; k < modes.size(); ++k) {
      modes[k].stretch[stretch] = {values[k], 0};
      modes[k].stretch[stretch + 1] = {0, values[k]};
    }
  }
  return modes;
}

}  // namespace selfproj::calibration
