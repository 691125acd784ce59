#include "sim/experiment/moments_csv.h"

#include <fmt/format.h>

#include <cstddef>
#include <iterator>
#include <string>

#include "model/column_moments.h"

namespace selfproj {

void append_moments_csv(std::string& csv, std::size_t frame, const Moments& moments) {
  for (std::size_t i = 0; i < moments.m0.size(); ++i) {
    fmt::format_to(std::back_inserter(csv), "{},{},{},{},{}\n", frame, i + 1, moments.m0[i], moments.m1[i],
                   moments.n[i]);
  }
}

}  // namespace selfproj
