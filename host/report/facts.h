// Named numbers and tables: what a report shows and summary.json keeps.
#ifndef SELFPROJ_HOST_REPORT_FACTS_H
#define SELFPROJ_HOST_REPORT_FACTS_H

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace selfproj {

// A number or word that has a name: in summary.json under `key`, in the report as `label` with its unit.
struct Fact {
  std::string key;
  std::string label;
  std::variant<std::int64_t, double, std::string> value;
  std::string unit = {};
};

// A table: the first column names what the row is about. Cells are plain text.
struct ReportTable {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  std::string note = {};  // below it
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_FACTS_H
