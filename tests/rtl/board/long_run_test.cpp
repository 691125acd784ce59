// Tests the board after days of operation. Its counters start at high values, carry into their upper bits and wrap. The
// headers and registers that contain them are compared with the model as in every other test.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>

#include "Vboard_codes.h"
#include "tests/rtl/board/random_codes.h"
#include "tests/rtl/board/scoreboard.h"
#include "tests/rtl/inner_register.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// Advances an sp_counter of `bits` bits, and leaves it in the same state as real counting.
void count(const std::string& counter, int bits, std::uint64_t more) {
  constexpr int kLow = 8;                // bits of the lowest chain
  const int size = bits > 32 ? 14 : 12;  // of those above it
  const std::uint64_t ones = (1ULL << size) - 1;
  InnerRegister low(counter + ".low_q");
  InnerRegister shown(counter + ".told_q");
  InnerRegister upper(counter + ".upper_q");
  const std::uint64_t ahead = (low.get() - shown.get()) & 0xFFU;  // counts that do not show yet
  const std::uint64_t value = (upper.get() << kLow | shown.get()) + more;
  std::uint32_t full = 0;
  std::uint32_t below = 0;
  for (int k = 0; k < (bits - kLow) / size; ++k) {
    full |= (value >> (kLow + size * k) & ones) == ones ? 1U << k : 0;
    below |= (full | ~0U << k) == ~0U ? 1U << k : 0;
  }
  low.set((value + ahead) & 0xFFU);
  shown.set(value & 0xFFU);
  upper.set(value >> kLow & ((1ULL << (bits - kLow)) - 1));
  InnerRegister(counter + ".go_q").set(ahead != 0 && ((value + ahead) & 0xFFU) == 0 ? 1 : 0);
  InnerRegister(counter + ".full_q").set(full);
  InnerRegister(counter + ".below_q").set(below);
}

void set_counters(Scoreboard<Vboard_codes>& board, const BoardCounts& counts) {
  Vboard_codes& model = board.device().model();
  Verilated::threadContextp(model.contextp());
  const std::string top = "TOP.sp_board.";
  count(top + "u_info.u_time", 64, counts.clocks);
  count(top + "u_info.u_frames", 64, counts.frames);
  count(top + "u_tracker.u_broken", 32, counts.broken);
  count(top + "u_tracker.u_stray", 32, counts.stray);
  count(top + "u_moments_path.u_packets.u_packetizer.u_lost", 32, counts.lost.at(spec::kKindMoments));
  count(top + "gen_image.u_image_path.u_packets.u_packetizer.u_lost", 32, counts.lost.at(spec::kKindImage));
  count(top + "gen_codes.u_codes_path.u_packets.u_packetizer.u_lost", 32, counts.lost.at(spec::kKindCodes));
  InnerRegister abandoned(top + "gen_codes.u_codes_path.u_core.u_decoder.abandoned_o");
  abandoned.set((abandoned.get() + counts.abandoned) & 0xFFFF'FFFFU);
  model.eval();  // updates what follows from the registers
  board.counted_before(counts);
}

// The time in the registers lags that of the headers by six clocks.
void expect_time(Scoreboard<Vboard_codes>& board) {
  sim::BoardDevice<Vboard_codes>& device = board.device();
  const std::uint64_t earliest = board.counted_before().clocks + device.clock() - 6;
  const std::uint64_t low = device.read(spec::kRegTimeLow);
  const std::uint64_t time = low | std::uint64_t{device.read(spec::kRegTimeHigh)} << 32U;
  EXPECT_LT(time - earliest, 100U) << std::hex << time << ", not before " << earliest;
}

// Starts just below each carry from chain to chain, below the middle, and below the end.
TEST(CodesBoard, CountersCarryAndWrapAfterALongRun) {
  constexpr std::array<std::uint64_t, 8> kPlaces = {0x0000'0000'0001'0000, 0x0000'0001'0000'0000, 0x0001'0000'0000'0000,
                                                    0x8000'0000'0000'0000, 0x0000'0000'0000'0000, 0x0123'4567'8000'0000,
                                                    0x5A5A'A5A5'FFFF'0000, 0xFEDC'BA98'7654'0000};
  CodeCounts counts;
  for_cases(24, [&](std::uint64_t seed) {
    play_random_sequences<Vboard_codes>(
        seed, true, 15, counts,
        [&](Scoreboard<Vboard_codes>& board, Random& random) {
          const std::uint64_t place = kPlaces[seed % kPlaces.size()];
          const auto below = [&](int most) { return place - static_cast<std::uint64_t>(random.between(1, most)); };
          const auto low_below = [&](int most) { return static_cast<std::uint32_t>(below(most)); };
          set_counters(board, {.clocks = below(20000),
                               .frames = below(100),
                               .broken = low_below(10),
                               .stray = low_below(20),
                               .abandoned = low_below(4),
                               .lost = {{spec::kKindMoments, low_below(20)},
                                        {spec::kKindImage, low_below(20)},
                                        {spec::kKindCodes, low_below(20)}}});
          expect_time(board);
        },
        expect_time);
  });
  EXPECT_GT(counts.delivered, 0U);
}

}  // namespace
}  // namespace selfproj::test
