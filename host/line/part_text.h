// Results of parts as text.
#ifndef SELFPROJ_HOST_LINE_PART_TEXT_H
#define SELFPROJ_HOST_LINE_PART_TEXT_H

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "host/parts/part_result.h"
#include "host/parts/running_figures.h"

namespace selfproj {

// The result as one object; docs/parts.md lists the keys. It holds nothing that depends on when it was computed.
nlohmann::ordered_json part_json(const PartResult& result);

// The head of the table of parts, and the line of a part; both end with a newline.
std::string part_csv_head();
std::string part_csv(const PartResult& result);

// Statistics over the parts: of each part's figures, by name. The number of names is that of the regions and some.
using PartStatistics = std::map<std::string, RunningFigures>;

// Adds the figures of a part that was placed; others have none that say something.
void add_figures(const PartResult& result, PartStatistics& statistics);

// For each name: count, mean, spread, least, greatest, and how much it rises in 1000 parts.
nlohmann::ordered_json statistics_json(const PartStatistics& statistics);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LINE_PART_TEXT_H
