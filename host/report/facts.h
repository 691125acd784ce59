// Named numbers and tables, which a report shows and summary.json contains.
#ifndef SELFPROJ_HOST_REPORT_FACTS_H
#define SELFPROJ_HOST_REPORT_FACTS_H

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

#include "selfproj/driver/counters.h"

namespace selfproj::report {

// A number or word with a name: `key` in summary.json, `label` with its unit in the report.
struct Fact {
  std::string key;
  std::string label;
  std::variant<std::int64_t, double, std::string> value;
  std::string unit = {};
};

// The key and value of each fact, in order, as an object of summary.json.
nlohmann::ordered_json facts_json(const std::vector<Fact>& facts);

// The same number, or the greatest that a fact can have.
std::int64_t fact_number(std::uint64_t value);

// A counter of the driver as a fact, with its names from include/selfproj/driver/counters.h: one with a value; all of
// them.
Fact counter_fact(std::uint64_t driver::Counters::*counter, std::uint64_t value);
std::vector<Fact> counter_facts(const driver::Counters& counters);

// What may be lost or go wrong with packets of any kind.
inline constexpr std::initializer_list<std::uint64_t driver::Counters::*> kLosses = {
    &driver::Counters::lost_board, &driver::Counters::lost_ring, &driver::Counters::lost_network,
    &driver::Counters::missing, &driver::Counters::bad};

// What was lost or went wrong, for a terminal: those of these counters that are not 0, or "nothing lost".
std::string losses_text(const driver::Counters& counters,
                        std::initializer_list<std::uint64_t driver::Counters::*> which = kLosses);

// A table. The first column names the subject of the row. Cells are plain text.
struct ReportTable {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  std::string note = {};  // printed below the table
};

}  // namespace selfproj::report

#endif  // SELFPROJ_HOST_REPORT_FACTS_H
