#include "host/report/facts.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <variant>
#include <vector>

namespace selfproj::report {

nlohmann::ordered_json facts_json(const std::vector<Fact>& facts) {
  nlohmann::ordered_json result = nlohmann::ordered_json::object();
  for (const Fact& fact : facts) {
    std::visit([&](const auto& value) { result[fact.key] = value; }, fact.value);
  }
  return result;
}

std::int64_t fact_number(std::uint64_t value) {
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  return static_cast<std::int64_t>(std::min(value, kMax));
}

Fact counter_fact(std::uint64_t driver::Counters::*counter, std::uint64_t value) {
  const driver::CounterName& name = driver::name_of(counter);
  return {name.key, name.label, fact_number(value)};
}

std::vector<Fact> counter_facts(const driver::Counters& counters) {
  std::vector<Fact> facts;
  facts.reserve(driver::kCounterNames.size());
  for (const driver::CounterName& name : driver::kCounterNames) {
    facts.push_back({name.key, name.label, fact_number(counters.*name.field)});
  }
  return facts;
}

std::string losses_text(const driver::Counters& counters,
                        std::initializer_list<std::uint64_t driver::Counters::*> which) {
  std::string text;
  for (std::uint64_t driver::Counters::*const counter : which) {
    if (counters.*counter > 0) {
      text += (text.empty() ? "" : ", ") + driver::counters_text(counters, {counter});
    }
  }
  return text.empty() ? "nothing lost" : text;
}

}  // namespace selfproj::report
