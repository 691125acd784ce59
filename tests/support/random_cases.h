// Seeded random cases that can be repeated:
//
//     for_cases(200, [&](Random& random) { ... });
//
// This runs 200 cases, up to the first that fails. If the environment variable SELFPROJ_SEED is set, it runs only the
// case with that seed; if SELFPROJ_CASES is set, only that many cases. A failure says how to repeat its case.
#ifndef SELFPROJ_TESTS_SUPPORT_RANDOM_CASES_H
#define SELFPROJ_TESTS_SUPPORT_RANDOM_CASES_H

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

namespace selfproj::test {

// Returns whether all cases run, so that their combined results can be judged.
inline bool runs_all_cases() {
  return std::getenv("SELFPROJ_SEED") == nullptr && std::getenv("SELFPROJ_CASES") == nullptr;
}

// Returns the seeds 1..count: only that of SELFPROJ_SEED if it is set, or only the first SELFPROJ_CASES if that is set.
inline std::vector<std::uint64_t> seeds(int count) {
  if (const char* wanted = std::getenv("SELFPROJ_SEED"); wanted != nullptr) {
    return {std::strtoull(wanted, nullptr, 0)};
  }
  if (const char* wanted = std::getenv("SELFPROJ_CASES"); wanted != nullptr) {
    count = std::clamp(std::atoi(wanted), 1, count);
  }
  std::vector<std::uint64_t> all;
  for (int i = 1; i <= count; ++i) {
    all.push_back(static_cast<std::uint64_t>(i));
  }
  return all;
}

// Returns the command, from the root of the project, that repeats a case of the current test.
inline std::string how_to_repeat(std::uint64_t seed) {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(info->test_suite_name()) + "." + info->name();
  return "seed " + std::to_string(seed) + "; repeat with: SELFPROJ_SEED=" + std::to_string(seed) +
         " ctest --test-dir " SELFPROJ_TEST_DIR " --output-on-failure -R '" + name + "$'";
}

// Random numbers from a seed.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  // Uniform in low..high, both included.
  int between(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }

  // 64 random bits.
  std::uint64_t bits() { return engine_(); }

  // True with the probability `percent` / 100.
  bool chance(int percent) { return between(1, 100) <= percent; }

  // Uniform bytes.
  std::vector<std::uint8_t> bytes(std::size_t count) {
    std::vector<std::uint8_t> all(count);
    std::generate(all.begin(), all.end(), [this] { return static_cast<std::uint8_t>(engine_()); });
    return all;
  }

 private:
  std::mt19937_64 engine_;
};

// Runs `play` for each seed of seeds(count) until a case fails: play(random), play(random, seed) or play(seed).
template <typename Play>
void for_cases(int count, Play play) {
  for (const std::uint64_t seed : seeds(count)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    if constexpr (std::is_invocable_v<Play, Random&>) {
      play(random);
    } else if constexpr (std::is_invocable_v<Play, Random&, std::uint64_t>) {
      play(random, seed);
    } else {
      play(seed);
    }
    if (::testing::Test::HasFailure()) {
      return;
    }
  }
}

// A uniform number in low..high.
inline double uniform(Random& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random.between(0, 1 << 30)) / (1 << 30);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_RANDOM_CASES_H
