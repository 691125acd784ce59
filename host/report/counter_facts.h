// The driver's counters as facts of a report, with their names from host/driver/counters.h.
#ifndef SELFPROJ_HOST_REPORT_COUNTER_FACTS_H
#define SELFPROJ_HOST_REPORT_COUNTER_FACTS_H

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "host/driver/counters.h"
#include "host/report/report.h"

namespace selfproj {

// The same number, or the greatest that a fact can have.
inline std::int64_t fact_number(std::uint64_t value) {
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  return static_cast<std::int64_t>(std::min(value, kMost));
}

// The names of one counter with a value.
inline Fact counter_fact(std::uint64_t Counters::*counter, std::uint64_t value) {
  const CounterName& name = name_of(counter);
  return {name.key, name.label, fact_number(value)};
}

// All counters.
inline std::vector<Fact> counter_facts(const Counters& counters) {
  std::vector<Fact> facts;
  facts.reserve(kCounterNames.size());
  for (const CounterName& name : kCounterNames) {
    facts.push_back({name.key, name.label, fact_number(counters.*name.field)});
  }
  return facts;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_COUNTER_FACTS_H
