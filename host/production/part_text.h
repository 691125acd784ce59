// Results of parts as text.
#ifndef SELFPROJ_HOST_PRODUCTION_PART_TEXT_H
#define SELFPROJ_HOST_PRODUCTION_PART_TEXT_H

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "host/production/part_result.h"
#include "host/production/running_figures.h"

namespace selfproj {

// The result as one JSON object; docs/parts.md lists the keys. It leaves out `delay_ns`, so it does not depend on when
// it was computed.
nlohmann::ordered_json part_json(const PartResult& result);

// The header line of parts.csv, and the line of one part. Both end with a newline.
std::string part_csv_head();
std::string part_csv(const PartResult& result);

// Statistics over all placed parts, by the name of the figure. The map stays small: it has at most five figures of the
// placement, and four of each region.
using PartStatistics = std::map<std::string, RunningFigures>;

// Adds the figures of a part that was placed. Other parts are left out, because their figures have no meaning.
void add_figures(const PartResult& result, PartStatistics& statistics);

// For each name: number of parts, mean, standard deviation, least, greatest, and the rise of the fitted straight line
// over 1000 parts.
nlohmann::ordered_json statistics_json(const PartStatistics& statistics);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_PART_TEXT_H
