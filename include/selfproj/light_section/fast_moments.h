// Column moments and strongest runs for the production PC: the results of model/column_moments and model/column_runs
// bit for bit, the moments at the speed of memory, the runs fast where most columns have one.
#ifndef SELFPROJ_LIGHT_SECTION_FAST_MOMENTS_H
#define SELFPROJ_LIGHT_SECTION_FAST_MOMENTS_H

#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"

namespace selfproj::light_section {

// Writes the same moments as column_moments for the same arguments, and throws whenever that throws. Reads the image
// once. Fast for images of at least 64 columns. Allocates nothing and keeps no state, so any number of threads may call
// it at once.
void fast_column_moments(const model::ImageView& image, model::Mode mode, int threshold, const model::MomentsView& out);

// The same for pixels of `bits` bits, 8 to model::kMaxPixelBits, one in each word of 16.
void fast_column_moments(const model::WideImageView& image, int bits, model::Mode mode, int threshold,
                         const model::MomentsView& out);

// Writes the same as column_runs for the same arguments, and throws whenever that throws. Allocates nothing and keeps
// no state, so any number of threads may call it at once.
//
// The moments of all lit pixels are those of the strongest run where there is one run. So this counts the runs of all
// columns at once, and goes through the rows only of columns that have several. It takes as long as the rows of these
// columns need: where all columns have several runs it is many times slower.
void fast_column_runs(const model::ImageView& image, const model::Measure& measure, const model::RunsView& out);
void fast_column_runs(const model::WideImageView& image, const model::Measure& measure, const model::RunsView& out);

// Writes what measure.select asks for: fast_column_moments or fast_column_runs.
void fast_measure_columns(const model::ImageView& image, const model::Measure& measure, const model::RunsView& out);

// The same for pixels of measure.bits bits.
void fast_measure_columns(const model::WideImageView& image, const model::Measure& measure, const model::RunsView& out);

}  // namespace selfproj::light_section

#endif  // SELFPROJ_LIGHT_SECTION_FAST_MOMENTS_H
