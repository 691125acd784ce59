// Numbers as text: fast for the tables, fit to be read for the report.
#ifndef SELFPROJ_HOST_REPORT_NUMBER_TEXT_H
#define SELFPROJ_HOST_REPORT_NUMBER_TEXT_H

#include <cstdint>
#include <string>
#include <vector>

namespace selfproj {

// Characters that append_integer and append_tenth_micrometres write at most.
inline constexpr int kMaxNumberText = 24;

// Writes the number at `to`, which has room for kMaxNumberText characters, and returns the place after it.
char* append_integer(char* to, std::uint64_t value);

// Writes millimetres with four digits after the point, rounded to the nearest, never "-0.0000". The magnitude is below
// 1e12; there is no text for NaN.
char* append_tenth_micrometres(char* to, double millimetres);

// The smallest of 1, 1.5, 2, 3, 5, 7 x 10^k that is not below `value` > 0: the end of a scale.
double round_up(double value);

// The largest of 1, 2, 5 x 10^k not above `value` > 0: the step of a scale, the length of a scale bar.
double round_down(double value);

// The multiples of a round step in low..high, both included where they are multiples: `count` of them or somewhat
// fewer. Empty where high <= low.
std::vector<double> ticks(double low, double high, int count);

// With as few digits as show multiples of `step` apart: "0.5", "20", "-1".
std::string tick_text(double value, double step);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_NUMBER_TEXT_H
