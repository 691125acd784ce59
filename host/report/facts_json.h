// Facts as an object of summary.json.
#ifndef SELFPROJ_HOST_REPORT_FACTS_JSON_H
#define SELFPROJ_HOST_REPORT_FACTS_JSON_H

#include <nlohmann/json.hpp>
#include <variant>
#include <vector>

#include "host/report/facts.h"

namespace selfproj {

// The key and value of each fact, in order.
inline nlohmann::ordered_json facts_json(const std::vector<Fact>& facts) {
  nlohmann::ordered_json result = nlohmann::ordered_json::object();
  for (const Fact& fact : facts) {
    std::visit([&](const auto& value) { result[fact.key] = value; }, fact.value);
  }
  return result;
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_FACTS_JSON_H
