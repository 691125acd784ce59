// Numbers as text: fast ones for tables, readable ones for pictures; and the lines of moments.csv.
#ifndef SELFPROJ_HOST_REPORT_TABLES_H
#define SELFPROJ_HOST_REPORT_TABLES_H

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "selfproj/model/column_runs.h"

namespace selfproj::report {

// The most characters that append_integer and append_tenth_micrometres write.
inline constexpr int kMaxNumberText = 24;

// Writes the number at `to`, which must have room for kMaxNumberText characters. Returns the place after it.
char* append_integer(char* to, std::uint64_t value);

// Writes millimetres with four digits after the point, rounded to the nearest, and never "-0.0000". The magnitude must
// be below 1e12. NaN is not allowed.
char* append_tenth_micrometres(char* to, double millimetres);

// The smallest of 1, 1.5, 2, 3, 5, 7 x 10^k that is not below `value` > 0, for the end of a scale.
double round_up(double value);

// The largest of 1, 2, 5 x 10^k that is not above `value` > 0, for the step of a scale or the length of a scale bar.
double round_down(double value);

// The multiples of a round step in low..high, including both ends if they are multiples: at most `count` or somewhat
// fewer. Empty if high <= low.
std::vector<double> ticks(double low, double high, int count);

// The shortest text that distinguishes multiples of `step`: "0.5", "20", "-1".
std::string tick_text(double value, double step);

// The first line of moments.csv: frame,column,m0,m1,n, and with Select::strongest also runs,second.
std::string moments_csv_header(model::Select select);

// Appends one line for each column of a frame. Frames and columns count from 1; n is the number of lit pixels in every
// mode. `runs` and `second` (in sixteenths of the strongest run) are left out where there are none.
void append_moments_csv(std::string& csv, std::size_t frame, const model::Runs& runs);

}  // namespace selfproj::report

#endif  // SELFPROJ_HOST_REPORT_TABLES_H
