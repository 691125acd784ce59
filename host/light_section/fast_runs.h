// The strongest run of each column for the production PC: the results of model/column_runs bit for bit, fast where most
// columns have one run.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_FAST_RUNS_H
#define SELFPROJ_HOST_LIGHT_SECTION_FAST_RUNS_H

#include "model/column_runs.h"

namespace selfproj {

// Writes the same as column_runs for the same arguments, and throws whenever that throws. Allocates nothing and keeps
// no state, so any number of threads may call it at once.
//
// The moments of all lit pixels are those of the strongest run where there is one run. So this counts the runs of all
// columns at once, and goes through the rows only of columns that have several. It takes as long as the rows of these
// columns need: where all columns have several runs it is many times slower.
void fast_column_runs(const ImageView& image, const Measure& measure, const RunsView& out);

// Writes what measure.select asks for: fast_column_moments or fast_column_runs.
void fast_measure_columns(const ImageView& image, const Measure& measure, const RunsView& out);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_FAST_RUNS_H
