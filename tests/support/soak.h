// What the soaks share: random cases, from a first seed on, until enough was compared.
//
//     NAME [COUNT...] [FIRST_SEED]
//
// The first failure ends the program with exit status 1; it says the seed, and the command that repeats the case. The
// last line says what was compared. Ctrl-C (and SIGTERM) ends it after the case that runs; what was compared until then
// counts.
#ifndef SELFPROJ_TESTS_SUPPORT_SOAK_H
#define SELFPROJ_TESTS_SUPPORT_SOAK_H

#include <gtest/gtest.h>

#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/files/results_file.h"

namespace selfproj::test {

// The command line, which the main function of soak_main.cpp leaves here.
struct SoakCommand {
  std::string program;
  std::vector<std::uint64_t> numbers;

  // The number at this place, from 0, or this one if it is not there.
  [[nodiscard]] std::uint64_t number(std::size_t place, std::uint64_t by_default) const {
    return place < numbers.size() ? numbers[place] : by_default;
  }
};
inline SoakCommand soak_command;

// Set by SIGINT and SIGTERM.
inline volatile std::sig_atomic_t soak_stops = 0;

// Plays cases until `done`, which they advance, has reached the count at place `which` of the command line, `wanted` by
// default; the first seed stands behind the `counts` counts. Stops at the first failure.
inline void soak(const std::uint64_t& done, std::uint64_t wanted, const std::function<void(std::uint64_t seed)>& play,
                 std::size_t which = 0, std::size_t counts = 1) {
  wanted = soak_command.number(which, wanted);
  std::string repeat = soak_command.program;
  for (std::size_t i = 0; i < counts; ++i) {
    repeat += i == which ? " 1" : " 0";
  }
  for (const int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, [](int) { soak_stops = 1; });
  }
  std::uint64_t tenths = 1;
  for (std::uint64_t seed = soak_command.number(counts, 1); done < wanted && soak_stops == 0; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << "; repeat with: " << repeat << " " << seed);
    play(seed);
    if (::testing::Test::HasFailure()) {
      return;
    }
    if (done < wanted && 10 * done >= tenths * wanted) {
      std::printf("%llu of %llu\n", static_cast<unsigned long long>(done), static_cast<unsigned long long>(wanted));
      std::fflush(stdout);
      tenths = 10 * done / wanted + 1;
    }
  }
}

// Unless something has failed: prints what was compared, and writes it as results.
inline void report_soak(const std::string& name, const std::string& about, const nlohmann::ordered_json& results) {
  if (!::testing::Test::HasFailure()) {
    std::printf("%s: %s\n", about.c_str(), results.dump().c_str());
    files::write_results(name, about, results);
  }
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_SOAK_H
