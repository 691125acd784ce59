// Compares the register file with the specification, register by register: reset values, accepted and refused writes,
// reads, and the settings at the outputs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <type_traits>

#include "model/spec/generated/selfproj_spec.h"
#include "tests/rtl/blocks/registers_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::registers {
namespace {

template <typename Dut>
class Registers : public ::testing::Test {};
using Builds = ::testing::Types<Vsp_registers, Vsp_registers_small, Vsp_registers_codes>;
struct BuildNames {
  template <typename Dut>
  static std::string GetName(int) {  // NOLINT(readability-identifier-naming): GoogleTest's name
    return std::is_same_v<Dut, Vsp_registers>         ? "Default"
           : std::is_same_v<Dut, Vsp_registers_small> ? "Small"
                                                      : "Codes";
  }
};
TYPED_TEST_SUITE(Registers, Builds, BuildNames);

TYPED_TEST(Registers, EveryAddressAfterReset) {
  RegistersBench<TypeParam> bench;
  bench.expect_all_reads();
}

TYPED_TEST(Registers, ReadOnlyAndUnknownAddressesRefuseWrites) {
  RegistersBench<TypeParam> bench;
  for (std::uint32_t address = 0; address < 256; ++address) {
    const bool writable = std::any_of(bench.writables.begin(), bench.writables.end(),
                                      [&](const Writable& w) { return w.address == address; });
    if (!writable) {
      bench.expect_write(address, 0);
      bench.expect_write(address, 0x0004'0004);
    }
  }
  bench.expect_all_reads();
}

// Writes each bit of each register alone, all bits, and none.
TYPED_TEST(Registers, EveryBitIsKeptOrRefused) {
  RegistersBench<TypeParam> bench;
  for (const Writable& writable : bench.writables) {
    for (int bit = -2; bit < 32; ++bit) {
      const std::uint32_t data = bit == -2 ? 0 : bit == -1 ? 0xFFFF'FFFFU : 1U << bit;
      bench.expect_write(writable.address, data);
      bench.expect_read(writable.address);
      if (writable.address == spec::kRegTriggerControl) {  // which refuses what comes next while it is on
        bench.expect_write(writable.address, 0);
      }
    }
    bench.expect_write(writable.address, bench.expected_read(writable.address));
  }
  bench.expect_all_reads();
}

TYPED_TEST(Registers, SizesAreRefusedOutsideTheBuild) {
  RegistersBench<TypeParam> bench;
  const int columns = RegistersBench<TypeParam>::kBuild.max_columns;
  const int rows = RegistersBench<TypeParam>::kBuild.max_rows;
  for (const int c : {0, 1, 2, 3, 4, 5, 6, 7, 8, columns - 4, columns - 1, columns, columns + 1, columns + 4, 0x8004}) {
    for (const int r : {0, 1, 2, rows - 1, rows, rows + 1, 0x0401, 0x8001}) {
      bench.expect_write(spec::kRegSize, static_cast<std::uint32_t>(c) | static_cast<std::uint32_t>(r) << 16);
      bench.expect_read(spec::kRegSize);
    }
  }
}

// The sequencer's settings stand still while it works: writes are refused until it is off, and change nothing.
TYPED_TEST(Registers, TheTriggersSettingsStandStillWhileItWorks) {
  constexpr std::uint32_t kRun = 1U << spec::kRegTriggerControlRunLsb;
  constexpr std::uint32_t kOnFrame = 1U << spec::kRegTriggerControlOnFrameLsb;
  const auto last = [](std::uint32_t pattern) { return pattern << spec::kRegTriggerControlLastPatternLsb; };
  for (const std::uint32_t on : {kRun, kOnFrame, kRun | kOnFrame}) {
    RegistersBench<TypeParam> bench;
    const auto expect = [&](std::uint32_t address, std::uint32_t data, bool refused) {
      EXPECT_EQ(bench.access(true, address, data).error, refused) << std::hex << "write " << data << " to " << address;
    };
    expect(spec::kRegTriggerControl, on | last(9), false);
    for (const std::uint32_t address : {spec::kRegTriggerPeriod, spec::kRegTriggerCamera, spec::kRegTriggerWidth}) {
      expect(address, 77, (on & kRun) != 0);
    }
    for (const std::uint32_t other : {on, on | last(9), on | last(3), kRun, kOnFrame, kRun | kOnFrame | last(9)}) {
      expect(spec::kRegTriggerControl, other, true);
    }
    EXPECT_EQ(bench.access(false, spec::kRegTriggerControl, 0).data, on | last(9));
    expect(spec::kRegTimeout, 5, false);  // all else goes on
    expect(spec::kRegTriggerControl, last(4), false);
    for (const std::uint32_t address : {spec::kRegTriggerPeriod, spec::kRegTriggerCamera, spec::kRegTriggerWidth}) {
      expect(address, 88, false);
      EXPECT_EQ(bench.access(false, address, 0).data, 88U);
    }
    expect(spec::kRegTriggerControl, on, false);
  }
}

// A write in the very clock in which other settings are taken over, and in the clocks around it
TYPED_TEST(Registers, SettingsWrittenBesideATakeOverArePending) {
  for (int clocks = 0; clocks < 8; ++clocks) {
    RegistersBench<TypeParam> bench;
    bench.tick();
    bench.tick(true);
    bench.expect_read(spec::kRegStatus);
    bench.take_after(clocks);
    bench.expect_write(spec::kRegSize, 4U | 1U << spec::kRegSizeRowsLsb);
    bench.expect_read(spec::kRegStatus);
    ASSERT_FALSE(::testing::Test::HasFailure()) << clocks << " clocks after the request";
  }
}

TYPED_TEST(Registers, TheHighWordOfTheTimeBelongsToTheLowWordRead) {
  RegistersBench<TypeParam> bench;
  State state;
  state.time = 0x1111'1111'FFFF'FFFF;
  bench.set(state);
  bench.expect_read(spec::kRegTimeLow);
  state.time = 0x1111'1112'0000'0000;
  bench.set(state);
  bench.expect_read(spec::kRegTimeHigh);  // still 0x11111111
  bench.expect_read(spec::kRegTimeLow);
  bench.expect_read(spec::kRegTimeHigh);
}

TYPED_TEST(Registers, SettingsArePendingUntilTheyAreTaken) {
  RegistersBench<TypeParam> bench;
  bench.expect_read(spec::kRegStatus);
  bench.tick(true);
  bench.expect_read(spec::kRegStatus);
  for (const Writable& writable : bench.writables) {
    bench.expect_write(writable.address, bench.expected_read(writable.address));
    bench.expect_read(spec::kRegStatus);
    bench.tick(true);
    bench.expect_read(spec::kRegStatus);
  }
  // a refused write changes nothing, so nothing is pending
  bench.expect_write(spec::kRegSize, 0);
  bench.expect_read(spec::kRegStatus);
}

TYPED_TEST(Registers, RandomAccesses) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    RegistersBench<TypeParam> bench;
    bench.access(false, spec::kRegTimeLow, 0);
    for (int i = 0; i < 400; ++i) {
      State state;
      state.frame_open = random.chance(50);
      state.frames = static_cast<std::uint32_t>(random.bits());
      state.broken = static_cast<std::uint32_t>(random.bits());
      state.stray = static_cast<std::uint32_t>(random.bits());
      state.lost_moments = static_cast<std::uint32_t>(random.bits());
      state.lost_image = static_cast<std::uint32_t>(random.bits());
      state.lost_codes = static_cast<std::uint32_t>(random.bits());
      state.abandoned = static_cast<std::uint32_t>(random.bits());
      state.time = random.bits();
      state.encoder = static_cast<std::uint32_t>(random.bits());
      state.encoder_errors = static_cast<std::uint16_t>(random.bits());
      bench.set(state);
      const auto address =
          static_cast<std::uint32_t>(random.chance(95) ? 4 * random.between(0, 25) : random.between(0, 255));
      if (random.chance(50)) {
        // sizes that fit from time to time
        auto data = static_cast<std::uint32_t>(
            address == spec::kRegSize && random.chance(70) ? random.bits() & 0x03FF'0FFC : random.bits());
        if (address == spec::kRegTriggerControl && random.chance(70)) {
          data &= ~field(0, 2);  // off
        }
        bench.expect_write(address, data);
      } else {
        bench.expect_read(address);
      }
      for (int idle = random.between(-3, 2); idle > 0; --idle) {
        bench.tick(random.chance(30));
      }
      ASSERT_FALSE(::testing::Test::HasFailure());
    }
  }
}

}  // namespace
}  // namespace selfproj::test::registers
