#include "host/report/moments_csv.h"

#include <fmt/format.h>

#include <cstddef>
#include <iterator>
#include <string>

#include "model/column_runs.h"

namespace selfproj {

std::string moments_csv_header(Select select) {
  return select == Select::strongest ? "frame,column,m0,m1,n,runs,second\n" : "frame,column,m0,m1,n\n";
}

void append_moments_csv(std::string& csv, std::size_t frame, const Runs& runs) {
  const Moments& moments = runs.moments;
  for (std::size_t i = 0; i < moments.m0.size(); ++i) {
    const auto to = std::back_inserter(csv);
    fmt::format_to(to, "{},{},{},{},{}", frame, i + 1, moments.m0[i], moments.m1[i], moments.n[i]);
    if (!runs.runs.empty()) {
      fmt::format_to(to, ",{},{}", runs.runs[i], runs.second[i]);
    }
    csv += '\n';
  }
}

}  // namespace selfproj
