// Verdicts of the circuit, and the pin of the ejector.
#include "selfproj/model/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "Vsp_ejector_ports.h"
#include "Vsp_verdict_ports.h"
#include "Vsp_verdict_small_ports.h"
#include "Vsp_verdict_whole_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/verdict_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

template <>
constexpr verdict::Build verdict::kBuild<Vsp_verdict> = {64, 15, 4, true};
template <>
constexpr verdict::Build verdict::kBuild<Vsp_verdict_small> = {512, 127, 1, false};

namespace {

using verdict::set;

TEST(Verdict, RandomFramesEqualTheModel) { verdict::random_frames<Vsp_verdict>(20, 250); }
TEST(VerdictSmall, RandomFramesEqualTheModel) { verdict::random_frames<Vsp_verdict_small>(24, 150); }
TEST(VerdictWhole, RandomFramesEqualTheModel) { verdict::random_frames<Vsp_verdict_whole>(4, 150); }

// The pin follows its definition, six clocks late.
TEST(Ejector, PulsesByTheEncoder) {
  int pulses = 0;
  for_cases(30, [&](Random& random) {
    Clocked<Vsp_ejector> ejector;
    const auto delay = static_cast<std::uint32_t>(random.chance(30) ? 0 : random.between(1, 40));
    const int length = random.between(1, 12);
    ejector->delay_i = delay;
    set(ejector->length_i, length);
    ejector->bad_i = 0;
    std::uint32_t encoder = model::kCountMask - 63;  // wraps
    ejector->encoder_i = encoder;
    ejector.reset();
    std::vector<std::uint32_t> places;
    int quiet = 0;  // clocks in which the encoder stood
    for (int i = 0; i < 3000; ++i) {
      const bool steps = quiet >= 9 && random.chance(40);
      quiet = steps ? 0 : quiet + 1;
      encoder = (encoder + (steps ? 1U : 0U)) & model::kCountMask;
      ejector->encoder_i = encoder;
      ejector->bad_i =
          quiet == 1 && random.chance(5) && (places.empty() || ((encoder - places.back()) & model::kCountMask) > 12);
      ejector->place_i = encoder;
      if (ejector->bad_i) {
        places.push_back(encoder);
      }
      ejector.settle();
      ASSERT_FALSE(ejector->lost_o);
      if (quiet >= 9) {  // by now the pin has followed
        const bool wanted = std::ranges::any_of(places, [&](std::uint32_t place) {
          return ((encoder - (place + delay)) & model::kCountMask) < static_cast<std::uint32_t>(length);
        });
        ASSERT_EQ(ejector->ejector_o != 0, wanted) << "clock " << i;
        pulses += wanted ? 1 : 0;
      }
      ejector.rise();
    }
  });
  if (runs_all_cases()) {
    EXPECT_GT(pulses, 1000);
  }
}

// Any delay and length, an encoder that runs far between two looks, and more bad parts than can wait.
TEST(Ejector, LongWaysAndAFullQueue) {
  constexpr std::size_t kPlaces = 33;  // that can wait
  constexpr int kSettled = 150;        // clocks in which all places behind the encoder leave
  int pulses = 0, lost = 0;
  for_cases(40, [&](Random& random) {
    Clocked<Vsp_ejector> ejector;
    const int shorter = random.chance(50) ? random.between(0, 2) : random.between(0, 22);
    const auto delay = static_cast<std::uint32_t>(random.bits() & 0x7F'FFFF) >> shorter;
    const auto length = std::max(1U, static_cast<std::uint32_t>(random.bits() & 0xFFFF) >> random.between(0, 15));
    const int step_bits = random.between(1, 20);
    const int aims = random.chance(60) ? 30 : 0;
    ejector->delay_i = delay;
    set(ejector->length_i, length);
    ejector->bad_i = 0;
    auto encoder = static_cast<std::uint32_t>(random.bits()) & model::kCountMask;
    ejector->encoder_i = encoder;
    ejector.reset();
    std::vector<std::uint32_t> places;  // that wait
    const auto look = [&](int clocks) {
      int told = 0;
      for (int i = 0; i < clocks; ++i) {
        ejector.settle();
        told += ejector->lost_o;
        ejector.rise();
        ejector->bad_i = 0;
      }
      const auto way = [&](std::uint32_t place) { return (encoder - place - delay) & model::kCountMask; };
      std::erase_if(places, [&](std::uint32_t place) { return way(place) >= length && way(place) < 1U << 23; });
      const bool wanted = std::ranges::any_of(places, [&](std::uint32_t place) { return way(place) < length; });
      ejector.settle();
      EXPECT_EQ(ejector->ejector_o != 0, wanted);
      pulses += wanted ? 1 : 0;
      return told;
    };
    for (int i = 0; i < 100 && !HasFailure(); ++i) {
      auto step = static_cast<std::uint32_t>(random.between(1, 1 << step_bits));
      if (!places.empty() && random.chance(aims)) {  // to where a pulse begins or ends, if that is ahead
        const std::uint32_t edge = places.front() + delay + (random.chance(50) ? 0 : length);
        const std::uint32_t way =
            (edge + static_cast<std::uint32_t>(random.between(-2, 2)) - encoder) & model::kCountMask;
        step = way < 1U << 23 ? way : step;
      }
      encoder = (encoder + step) & model::kCountMask;
      ejector->encoder_i = encoder;
      ASSERT_EQ(look(kSettled), 0);
      if (random.chance(70)) {
        ejector->bad_i = 1;
        ejector->place_i = encoder;
        const bool is_lost = places.size() == kPlaces;
        if (!is_lost) {
          places.push_back(encoder);
        }
        lost += is_lost ? 1 : 0;
        ASSERT_EQ(look(20), is_lost ? 1 : 0);
      }
    }
  });
  if (runs_all_cases()) {
    EXPECT_GT(pulses, 500);
    EXPECT_GT(lost, 50);
  }
}

}  // namespace
}  // namespace selfproj::test
