// Verdicts of the circuit, and the pin of the ejector.
#include "selfproj/model/verdict.h"

#include <gtest/gtest.h>

#include <cstdint>

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
TEST(VerdictSmall, RandomFramesEqualTheModel) { verdict::random_frames<Vsp_verdict_small>(6, 100); }
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

}  // namespace
}  // namespace selfproj::test
