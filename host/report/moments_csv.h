#ifndef SELFPROJ_HOST_REPORT_MOMENTS_CSV_H
#define SELFPROJ_HOST_REPORT_MOMENTS_CSV_H

#include <cstddef>
#include <string>

#include "model/column_runs.h"

namespace selfproj {

// The first line of moments.csv: frame,column,m0,m1,n, and with Select::strongest also runs,second.
std::string moments_csv_header(Select select);

// Appends one line for each column of a frame. Frames and columns count from 1; n is the number of lit pixels in every
// mode. `runs` and `second` (in sixteenths of the strongest run) are left out where there are none.
void append_moments_csv(std::string& csv, std::size_t frame, const Runs& runs);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_MOMENTS_CSV_H
