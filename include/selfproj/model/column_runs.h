// The strongest run of each column: the definition. Where speed counts, the host uses host/light_section/fast_moments.
//
// Where more than the line is lit, the moments of all lit pixels (include/selfproj/model/column_moments.h) are not
// those of the line. A run of a column is a maximal sequence of lit pixels in which two neighbours have at most g dark
// rows between them, g = 0..3. These dark rows belong to the run and weigh nothing. Rows that do not count are dark.
// Each run has
//
//     M0 = Σ w(ξ)        M1 = Σ ξ · w(ξ)        N = number of its lit pixels        over its pixels,
//
// with the weights w of column_moments and rows ξ counted from 1 in the whole image. The strongest run has the largest
// M0; of equals it is the one with the smaller rows. The second has the largest M0 of the others. A column with one run
// has the moments that column_moments gives.
#ifndef SELFPROJ_MODEL_COLUMN_RUNS_H
#define SELFPROJ_MODEL_COLUMN_RUNS_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::model {

// What of a column is measured; the values are those of the packet header and of the register `measure`.
enum class Select : std::uint8_t {
  all = spec::kSelectAll,              // all lit pixels
  strongest = spec::kSelectStrongest,  // its strongest run
};

// The largest gap, in dark rows.
inline constexpr int kMaxGap = (1 << spec::kRegMeasureGapBits) - 1;

// What the board measures in each column: the settings of the registers `measure` and `window`.
struct Measure {
  Mode mode = Mode::binary;
  int threshold = 128;  // 0..2^bits - 1; a pixel is lit if it is greater
  Select select = Select::all;
  int gap = 0;                  // g, 0..kMaxGap; only with Select::strongest
  RowWindow window = {};        // rows that count
  int bits = spec::kPixelBits;  // of a pixel, 8..kMaxPixelBits

  bool operator==(const Measure&) const = default;
};

// Results that someone else owns: arrays with one entry for each column.
struct RunsView {
  MomentsView moments;             // of the strongest run
  std::uint8_t* runs = nullptr;    // number of runs: 0, 1, 2, or 3 where there are three or more
  std::uint8_t* second = nullptr;  // floor(16 M0 of the second / M0 of the strongest), 0..16; 0 without a second
};

// The results of one image. With Select::all `runs` and `second` are empty.
struct Runs {
  Moments moments;
  std::vector<std::uint8_t> runs;
  std::vector<std::uint8_t> second;

  // Makes room for `columns` >= 0 columns of what `select` gives; entries that are new are 0.
  void resize(Select select, int columns) {
    moments.resize(columns);
    for (auto* values : {&runs, &second}) {
      if (select == Select::strongest) {
        values->resize(static_cast<std::size_t>(columns));
      } else {
        std::vector<std::uint8_t>().swap(*values);  // frees it, so that view() points to nothing
      }
    }
  }

  // Valid until the next resize. With Select::all `runs` and `second` point to nothing.
  RunsView view() { return {moments.view(), runs.data(), second.data()}; }

  bool operator==(const Runs&) const = default;
};

// Writes the strongest run of every column of `image` to `out`, whatever measure.select is. Arguments and errors as
// those of column_moments; throws also if the gap is not in 0..kMaxGap.
void column_runs(const ImageView& image, const Measure& measure, const RunsView& out, int max_rows = spec::kRowLimit);

// The same for pixels of measure.bits bits.
void column_runs(const WideImageView& image, const Measure& measure, const RunsView& out);

// Writes what measure.select asks for: column_moments or column_runs. With Select::all it does not touch out.runs and
// out.second. Throws also unless measure.bits is 8.
void measure_columns(const ImageView& image, const Measure& measure, const RunsView& out);

// The same for pixels of measure.bits bits.
void measure_columns(const WideImageView& image, const Measure& measure, const RunsView& out);

// The same for up to kMaxSoftwareRows rows, more than a circuit takes.
void measure_tall_columns(const ImageView& image, const Measure& measure, const RunsView& out);

// Throws std::invalid_argument under the conditions of column_runs.
void check_column_runs(const ImageView& image, const Measure& measure, const RunsView& out,
                       int max_rows = spec::kRowLimit);
void check_column_runs(const WideImageView& image, const Measure& measure, const RunsView& out);

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_COLUMN_RUNS_H
