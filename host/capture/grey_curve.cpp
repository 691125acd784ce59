#include "host/capture/grey_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>

#include "host/files/input_file.h"
#include "host/files/numbers.h"
#include "host/files/user_error.h"

namespace selfproj {

double GreyCurve::light_at(double grey) const {
  const auto after =
      std::find_if(points.begin() + 1, points.end() - 1, [&](const Point& point) { return point.grey >= grey; });
  const Point& low = *std::prev(after);
  return low.light + (grey - low.grey) / (after->grey - low.grey) * (after->light - low.light);
}

GreyTable linear_greys(const GreyCurve& curve) {
  const double dark = curve.light_at(0);
  const double bright = curve.light_at(255);
  GreyTable table{};
  int level = 0;
  for (int grey = 0; grey < 256; ++grey) {
    const double wanted = dark + (bright - dark) * grey / 255;
    const auto off = [&](int at) { return std::abs(curve.light_at(at) - wanted); };
    while (level < 255 && off(level + 1) <= off(level)) {  // light does not fall, so that the nearest only rises
      ++level;
    }
    table[static_cast<std::size_t>(grey)] = static_cast<std::uint8_t>(level);
  }
  table[0] = 0;
  return table;
}

GreyCurve load_grey_curve(const std::string& file) {
  std::istringstream text(read_input(file, kMostTextBytes));
  GreyCurve curve;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    if (line.ends_with('\r')) {
      line.pop_back();
    }
    if (number == 1) {
      if (line != "grey,light") {
        throw UserError(file, "does not begin with the line grey,light");
      }
      continue;
    }
    const std::size_t comma = std::min(line.find(','), line.size());
    const std::optional<double> grey = number_of_text<double>(line.substr(0, comma));
    const std::optional<double> light = number_of_text<double>(comma < line.size() ? line.substr(comma + 1) : "");
    if (!grey || !light || std::abs(*light) > 1e9) {
      throw UserError(file, fmt::format("line {}: is no pair grey,light", number));
    }
    if (!curve.points.empty() && (*grey <= curve.points.back().grey || *light < curve.points.back().light)) {
      throw UserError(file, fmt::format("line {}: grey must rise and light must not fall", number));
    }
    curve.points.push_back({*grey, *light});
  }
  if (curve.points.size() < 2 || curve.points.front().grey != 0 || curve.points.back().grey != 255) {
    throw UserError(file, "grey does not go from 0 to 255");
  }
  if (curve.points.back().light <= curve.points.front().light) {
    throw UserError(file, "light does not rise");
  }
  return curve;
}

std::string grey_curve_text(const GreyCurve& curve) {
  std::string text = "grey,light\n";
  for (const GreyCurve::Point& point : curve.points) {
    text += fmt::format("{:g},{:.6g}\n", point.grey, point.light);
  }
  return text;
}

}  // namespace selfproj
