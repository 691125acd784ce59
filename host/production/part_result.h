// The result of an inspection of one part, statistics over many, and both as text.
#ifndef SELFPROJ_HOST_PRODUCTION_PART_RESULT_H
#define SELFPROJ_HOST_PRODUCTION_PART_RESULT_H

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/production/height_map.h"
#include "host/production/placement.h"
#include "selfproj/images/float_image.h"

namespace selfproj::production {

enum class Verdict : std::uint8_t { good, bad, inconclusive };
inline constexpr std::array<const char*, 3> kVerdictNames = {"good", "bad", "inconclusive"};
inline const char* verdict_name(Verdict verdict) { return kVerdictNames[static_cast<std::size_t>(verdict)]; }

// A place where the difference from the reference is outside the band that its region allows.
struct Defect {
  std::string region;
  double along_mm = 0;  // the middle of the place on the placed map
  double across_mm = 0;
  double size_along_mm = 0;
  double size_across_mm = 0;
  double area_mm2 = 0;
  // Distance from the middle of the band, less than 0 if the part is too low. It is the greatest one that an area as
  // large as the smallest defect reaches as a whole.
  double depth_mm = 0;
};

// The figures of a region.
struct RegionFigures {
  std::string name;
  double missing = 0;  // share of its places without a point
  double mean_mm = 0;  // mean difference; 0 if no place has a point
  // The lowest and the highest difference that an area as large as the smallest defect reaches as a whole
  double lowest_mm = 0, highest_mm = 0;
};

// What the verdict by moments (verdict_run.h) found in the frames of a part.
struct PartMoments {
  std::uint64_t frames = 0;  // that were judged
  std::uint64_t defect_frames = 0;
  std::uint64_t dark_frames = 0;  // that lack light
  std::uint64_t first_frame = 0;  // sequence number of the first one with a defect; without meaning where there is none
  int first_column = 0;           // of the defect in that frame, from 1
  int columns = 0;                // the most that a defect of the part has

  [[nodiscard]] bool defect() const { return defect_frames > 0; }
};

// The depth of the deepest one, to either side, in mm; 0 if there is none.
inline double deepest_mm(const std::vector<Defect>& defects) {
  double deepest = 0;
  for (const Defect& defect : defects) {
    deepest = std::max(deepest, std::abs(defect.depth_mm));
  }
  return deepest;
}

struct PartResult {
  std::uint64_t number = 0;  // from 1
  Verdict verdict = Verdict::inconclusive;
  std::string reason;  // one line; empty if good
  std::vector<Defect> defects;
  std::vector<RegionFigures> regions;
  std::optional<Placement> placement;
  std::optional<PartMoments> moments;
  double begin_mm = 0;  // position of the belt at the part's beginning
  double length_mm = 0;
  std::uint64_t first_frame = 0, last_frame = 0;  // sequence numbers
  std::uint64_t frames = 0, missing_frames = 0;
  std::int64_t delay_ns = 0;  // from the arrival of its last frame to this result
};

// The maps of a part, placed on the reference, in mm. NaN where there is no point.
struct PlacedMaps {
  MapGrid grid;
  images::FloatImage height;
  images::FloatImage difference;  // height minus that of the reference
};

// Counts of parts, and the last one: what controllers get.
struct PartCounts {
  std::array<std::uint64_t, 3> verdicts{};  // by Verdict
  std::uint64_t specks = 0;
  std::uint64_t last_part = 0;  // its number; 0: none yet
  Verdict last_verdict = Verdict::inconclusive;
  std::uint64_t last_defects = 0;
  double last_depth_mm = 0;  // of its largest defect
  std::optional<PartMoments> last_moments;
  std::uint64_t by_moments = 0;       // parts with a defect by moments
  std::uint64_t board_disagrees = 0;  // frames that board and model judged differently
  std::int64_t last_delay_ns = 0;
  std::int64_t last_ns = 0;  // when its result was there, steady clock

  [[nodiscard]] std::uint64_t parts() const { return verdicts[0] + verdicts[1] + verdicts[2]; }
};

// Sums about the running means, which lose no digits over millions of parts. The numbers come in order: the n-th has
// the abscissa n.
class RunningFigures {
 public:
  void add(double value) {
    ++count_;
    const auto n = static_cast<double>(count_);
    const double x = n;
    const double dx = x - mean_x_;
    mean_x_ += dx / n;
    const double dy = value - mean_;
    mean_ += dy / n;
    xx_ += dx * (x - mean_x_);
    xy_ += dx * (value - mean_);
    yy_ += dy * (value - mean_);
    min_ = count_ == 1 ? value : std::min(min_, value);
    max_ = count_ == 1 ? value : std::max(max_, value);
  }

  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean() const { return mean_; }
  [[nodiscard]] double min() const { return min_; }
  [[nodiscard]] double max() const { return max_; }

  // Standard deviation; 0 of fewer than two.
  [[nodiscard]] double spread() const {
    return count_ > 1 ? std::sqrt(std::max(0.0, yy_) / static_cast<double>(count_ - 1)) : 0;
  }

  // How much the straight line through all of them rises from one to the next; 0 of fewer than two.
  [[nodiscard]] double trend() const { return count_ > 1 ? xy_ / xx_ : 0; }

  // Its standard error; nothing of fewer than three.
  [[nodiscard]] std::optional<double> trend_error() const {
    return count_ > 2
               ? std::optional(std::sqrt(std::max(0.0, yy_ - xy_ * trend()) / static_cast<double>(count_ - 2) / xx_))
               : std::nullopt;
  }

 private:
  std::uint64_t count_ = 0;
  double mean_ = 0, mean_x_ = 0;
  double xx_ = 0, xy_ = 0, yy_ = 0;
  double min_ = 0, max_ = 0;
};

// The result as one JSON object; docs/parts.md lists the keys. It leaves out `delay_ns`, so it does not depend on when
// it was computed.
nlohmann::ordered_json part_json(const PartResult& result);

// The header line of parts.csv, and the line of one part. Both end with a newline.
std::string part_csv_head();
std::string part_csv(const PartResult& result);

// Statistics over all parts that are good or bad, by the name of the figure. The map stays small: it has at most five
// figures of the placement, and four of each region.
using PartStatistics = std::map<std::string, RunningFigures>;

// Adds the figures of a part, unless it is inconclusive: what it lies or measures then has no meaning.
void add_figures(const PartResult& result, PartStatistics& statistics);

// For each name: number of parts, mean, standard deviation, min, max, and the rise of the fitted straight line
// over 1000 parts.
nlohmann::ordered_json statistics_json(const PartStatistics& statistics);

// A duration as text: "12.3 µs" or "1.23 ms".
std::string time_text(std::int64_t ns);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_PART_RESULT_H
