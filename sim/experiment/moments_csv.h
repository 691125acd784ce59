#ifndef SELFPROJ_SIM_EXPERIMENT_MOMENTS_CSV_H
#define SELFPROJ_SIM_EXPERIMENT_MOMENTS_CSV_H

#include <cstddef>
#include <string>

#include "model/column_moments.h"

namespace selfproj {

// The first line of moments.csv.
inline constexpr const char* kMomentsCsvHeader = "frame,column,m0,m1,n\n";

// Appends one line for each column of a frame. Frames and columns count from 1; n is the number of lit pixels in every
// mode.
void append_moments_csv(std::string& csv, std::size_t frame, const Moments& moments);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_EXPERIMENT_MOMENTS_CSV_H
