// Named numbers and tables, which a report shows and summary.json contains.
#ifndef SELFPROJ_HOST_REPORT_FACTS_H
#define SELFPROJ_HOST_REPORT_FACTS_H

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace selfproj {

// A number or word with a name: `key` in summary.json, `label` with its unit in the report.
struct Fact {
  std::string key;
  std::string label;
  std::variant<std::int64_t, double, std::string> value;
  std::string unit = {};
};

// A table. The first column names the subject of the row. Cells are plain text.
struct ReportTable {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  std::string note = {};  // printed below the table
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_FACTS_H
