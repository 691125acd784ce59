// The result of an inspection of one part.
#ifndef SELFPROJ_HOST_PRODUCTION_PART_RESULT_H
#define SELFPROJ_HOST_PRODUCTION_PART_RESULT_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/images/float_image.h"
#include "host/production/map_grid.h"
#include "host/production/placement.h"

namespace selfproj {

enum class Verdict : std::uint8_t { ok, not_ok, cannot_tell };
inline constexpr std::array<const char*, 3> kVerdictNames = {"OK", "not OK", "cannot tell"};
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

struct PartResult {
  std::uint64_t number = 0;  // from 1
  Verdict verdict = Verdict::cannot_tell;
  std::string reason;  // one line; empty if OK
  std::vector<Defect> defects;
  std::vector<RegionFigures> regions;
  std::optional<Placement> placement;
  double begin_mm = 0;  // position of the belt at the part's beginning
  double length_mm = 0;
  std::uint64_t first_frame = 0, last_frame = 0;  // sequence numbers
  std::uint64_t frames = 0, missing_frames = 0;
  std::int64_t delay_ns = 0;  // from the arrival of its last frame to this result
};

// The maps of a part, placed on the reference, in mm. NaN where there is no point.
struct PlacedMaps {
  MapGrid grid;
  FloatImage height;
  FloatImage difference;  // height minus that of the reference
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_PART_RESULT_H
