#include "host/calibration/chessboard_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace selfproj::calibration {
namespace {

constexpr double kMargin = 15;
constexpr double kRuler = 100;
constexpr double kTextFromBelow = 8;  // where printers still print, and far enough from the board to be no part of it

// The largest side, not rounded.
double side_that_fits(const Chessboard& chessboard, const Paper& paper) {
  return std::min((paper.width_mm - 2 * kMargin) / (chessboard.columns + 1),
                  (paper.height_mm - 2 * kMargin) / (chessboard.rows + 1));
}

}  // namespace

const std::vector<Paper>& papers() {
  static const std::vector<Paper> all = {
      {"A4", 297, 210}, {"A3", 420, 297}, {"A2", 594, 420}, {"A1", 841, 594}, {"A0", 1189, 841}};
  return all;
}

std::optional<double> largest_square(const Chessboard& chessboard, const Paper& paper) {
  constexpr double kWholeFrom = 10;
  const double side = side_that_fits(chessboard, paper);
  if (side < 1) {
    return std::nullopt;
  }
  return side >= kWholeFrom ? std::floor(side) : std::floor(10 * side) / 10;
}

std::string chessboard_svg(const Chessboard& chessboard, const Paper& paper) {
  const double side = chessboard.square_mm;
  if (!(side > 0) || side > side_that_fits(chessboard, paper)) {
    throw std::invalid_argument("chessboard: does not fit on the paper");
  }
  const double width = side * (chessboard.columns + 1);
  const double height = side * (chessboard.rows + 1);
  const double left = 0.5 * (paper.width_mm - width);
  const double top = 0.5 * (paper.height_mm - height);
  std::string squares;
  for (int row = 0; row <= chessboard.rows; ++row) {
    for (int column = row % 2; column <= chessboard.columns; column += 2) {
      fmt::format_to(std::back_inserter(squares), "M{:g} {:g}h{:g}v{:g}h-{:g}z", left + column * side, top + row * side,
                     side, side, side);
    }
  }
  const double text = paper.height_mm - kTextFromBelow;
  const double ruler = 0.5 * paper.width_mm - kRuler / 2;
  return fmt::format(
      R"(<?xml version="1.0" encoding="UTF-8"?>
<svg xmlns="http://www.w3.org/2000/svg" width="{0:g}mm" height="{1:g}mm" viewBox="0 0 {0:g} {1:g}">
<style>@page {{ size: {0:g}mm {1:g}mm; margin: 0 }}</style>
<rect width="{0:g}" height="{1:g}" fill="white"/>
<path fill="black" shape-rendering="crispEdges" d="{2}"/>
<text x="{3:g}" y="{4:g}" font-family="sans-serif" font-size="3" fill="#777" text-anchor="middle">{5}</text>
<path stroke="black" stroke-width="0.2" fill="none" d="M{6:g} {7:g}v2m0 -1h{8:g}m0 -1v2"/>
</svg>
)",
      paper.width_mm, paper.height_mm, squares, 0.5 * paper.width_mm, text,
      fmt::format("{} x {} inner corners, squares of {:g} mm, {:g} x {:g} mm in all. Printed at its true size, this "
                  "line is {:g} mm long:",
                  chessboard.columns, chessboard.rows, side, width, height, kRuler),
      ruler, text + 1.5, kRuler);
}

}  // namespace selfproj::calibration
