// The driver's counters as facts of a report, with their names from host/driver/counters.h.
#ifndef SELFPROJ_HOST_REPORT_COUNTER_FACTS_H
#define SELFPROJ_HOST_REPORT_COUNTER_FACTS_H

#include <cstdint>
#include <vector>

#include "host/driver/counters.h"
#include "host/report/report.h"

namespace selfproj {

// The names of one counter with a value.
inline Fact counter_fact(std::uint64_t Counters::*counter, std::uint64_t value) {
  const CounterName& name = name_of(counter);
  return {name.key, name.label, static_cast<std::int64_t>(value)};
}

// All counters.
inline std::vector<Fact> counter_facts(const Counters& counters) {
  std::vector<Fact> facts;
  facts.reserve(kCounterNames.size());
  for (const CounterName& name : kCounterNames) {
    facts.push_back({name.key, name.label, static_cast<std::int64_t>(counters.*name.field)});
  }
  return facts;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_COUNTER_FACTS_H
