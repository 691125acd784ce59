#include "host/driver/counters.h"

namespace selfproj {

std::string counters_text(const Counters& counters, std::initializer_list<std::uint64_t Counters::*> which) {
  std::string text;
  for (std::uint64_t Counters::*const counter : which) {
    if (!text.empty()) {
      text += ", ";
    }
    text += name_of(counter).label;
    text += ' ';
    text += std::to_string(counters.*counter);
  }
  return text;
}

}  // namespace selfproj
