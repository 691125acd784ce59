#include "host/report/tables.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "selfproj/model/column_runs.h"

namespace selfproj::report {

char* append_integer(char* to, std::uint64_t value) { return std::to_chars(to, to + kMaxNumberText, value).ptr; }

char* append_tenth_micrometres(char* to, double millimetres) {
  constexpr std::uint64_t kUnits = 10000;  // units in a millimetre
  const auto units = std::llround(millimetres * static_cast<double>(kUnits));
  if (units < 0) {
    *to++ = '-';
  }
  const auto magnitude = static_cast<std::uint64_t>(units < 0 ? -units : units);
  to = append_integer(to, magnitude / kUnits);
  *to++ = '.';
  auto rest = magnitude % kUnits;
  for (int i = 3; i >= 0; --i) {
    to[i] = static_cast<char>('0' + rest % 10);
    rest /= 10;
  }
  return to + 4;
}

double round_up(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {1.0, 1.5, 2.0, 3.0, 5.0, 7.0}) {
    if (value <= digit * power * (1 + 1e-9)) {
      return digit * power;
    }
  }
  return 10 * power;
}

double round_down(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value) + 1e-9));
  for (const double digit : {5.0, 2.0}) {
    if (value * (1 + 1e-9) >= digit * power) {
      return digit * power;
    }
  }
  return power;
}

std::vector<double> ticks(double low, double high, int count) {
  std::vector<double> result;
  if (!(high > low) || count < 1) {
    return result;
  }
  // The next round step of at least span / count: 1, 2, 5, 10.
  const double wanted = (high - low) / count;
  double step = round_down(wanted);
  if (step < wanted * (1 - 1e-9)) {
    step = round_down(step * 2.5);
  }
  const double slack = step * 1e-6;
  for (double k = std::ceil((low - slack) / step); k * step <= high + slack; ++k) {
    result.push_back(k == 0 ? 0.0 : k * step);
  }
  return result;
}

std::string tick_text(double value, double step) {
  const int digits = step > 0 ? static_cast<int>(std::ceil(-std::log10(step) - 1e-6)) : 0;
  const std::string text = fmt::format("{:.{}f}", value, digits > 0 ? digits : 0);
  return text.find_first_not_of("-0.") == std::string::npos && text.front() == '-' ? text.substr(1) : text;
}

std::string moments_csv_header(model::Select select) {
  return select == model::Select::strongest ? "frame,column,m0,m1,n,runs,second\n" : "frame,column,m0,m1,n\n";
}

void append_moments_csv(std::string& csv, std::size_t frame, const model::Runs& runs) {
  const model::Moments& moments = runs.moments;
  for (std::size_t i = 0; i < moments.m0.size(); ++i) {
    const auto to = std::back_inserter(csv);
    fmt::format_to(to, "{},{},{},{},{}", frame, i + 1, moments.m0[i], moments.m1[i], moments.n[i]);
    if (!runs.runs.empty()) {
      fmt::format_to(to, ",{},{}", runs.runs[i], runs.second[i]);
    }
    csv += '\n';
  }
}

}  // namespace selfproj::report
