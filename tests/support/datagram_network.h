// A network that drops, doubles, reorders and cuts datagrams.
#ifndef SELFPROJ_TESTS_SUPPORT_DATAGRAM_NETWORK_H
#define SELFPROJ_TESTS_SUPPORT_DATAGRAM_NETWORK_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/support/random_cases.h"

namespace selfproj::test {

struct Faults {
  int dropped = 0;  // percent of datagrams
  int doubled = 0;
  int reordered = 0;
  int cut = 0;
};

// What a network made of datagrams, and what it did.
struct Network {
  using Bytes = std::vector<std::uint8_t>;

  std::vector<Bytes> datagrams;
  std::uint64_t dropped = 0;
  std::uint64_t doubled = 0;
  std::uint64_t cut = 0;

  Network(const std::vector<Bytes>& sent, const Faults& faults, Random& random) {
    std::vector<std::pair<std::size_t, Bytes>> timed;  // when it arrives
    for (std::size_t i = 0; i < sent.size(); ++i) {
      const auto arrival = [&] {
        return 2 * i + static_cast<std::size_t>(random.chance(faults.reordered) ? random.between(3, 40) : 0);
      };
      if (random.chance(faults.dropped)) {
        ++dropped;
        continue;
      }
      timed.emplace_back(arrival(), sent[i]);
      if (random.chance(faults.cut)) {
        ++cut;
        timed.back().second.resize(static_cast<std::size_t>(random.between(0, static_cast<int>(sent[i].size()) - 1)));
        continue;
      }
      if (random.chance(faults.doubled)) {
        ++doubled;
        timed.emplace_back(arrival(), sent[i]);
      }
    }
    std::stable_sort(timed.begin(), timed.end(),
                     [](const auto& one, const auto& other) { return one.first < other.first; });
    for (auto& [time, datagram] : timed) {
      datagrams.push_back(std::move(datagram));
    }
  }
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_DATAGRAM_NETWORK_H
