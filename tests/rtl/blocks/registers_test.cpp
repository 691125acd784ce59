// Compares the register file with the model, and with the specification, register by register: reset values, accepted
// and refused writes, what is read.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "Vsp_registers_codes_ports.h"
#include "Vsp_registers_ports.h"
#include "Vsp_registers_small_ports.h"
#include "model/register_file.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::registers {
namespace {

struct Build {
  int max_columns;
  int max_rows;
  bool grey;
  bool image;
  int code_bits = 0;  // of the Gray-code decoder, which then has the median; 0: no decoder
  bool runs = false;
  bool region = false;
  bool compact = false;
  bool verdict = false;
};

template <typename Dut>
struct BuildOf;
template <>
struct BuildOf<Vsp_registers> {
  static constexpr Build kBuild = {spec::kMaxColumns, spec::kMaxRows, true, true};
};
template <>
struct BuildOf<Vsp_registers_small> {
  static constexpr Build kBuild = {512, 127, false, false};
};
template <>
struct BuildOf<Vsp_registers_codes> {
  static constexpr Build kBuild = {640, 480, false, true, 9, true, true, true, true};
};

// State inputs, all different and with upper bits set.
struct State {
  bool frame_open = false;
  std::uint32_t frames = 0x8100'0001;
  std::uint32_t broken = 0x8200'0002;
  std::uint32_t stray = 0x8300'0003;
  std::uint32_t lost_moments = 0x8400'0004;
  std::uint32_t lost_image = 0x8500'0005;
  std::uint32_t lost_codes = 0x8A00'000A;
  std::uint32_t abandoned = 0x8B00'000B;
  std::uint64_t time = 0x8600'0006'8700'0007;
  std::uint32_t encoder = 0x8800'0008;
  std::uint16_t encoder_errors = 0x8909;
};

// The writable registers of the specification.
struct Writable {
  std::uint32_t address;
  std::uint32_t reset;
  std::uint32_t mask;  // bits of the fields
};
constexpr std::uint32_t field(int lsb, int bits) { return ((1ULL << bits) - 1) << lsb & 0xFFFF'FFFFU; }

constexpr int kWindowBits = spec::kRegWindowFirstBits - 1;  // the highest is only in builds for more than 1,023 rows

const std::vector<Writable> kWritable = {
    {spec::kRegControl, spec::kRegControlReset,
     field(spec::kRegControlRunLsb, 1) | field(spec::kRegControlHoldLsb, 1) | field(spec::kRegControlImageLsb, 1)},
    {spec::kRegSize, spec::kRegSizeReset,
     field(spec::kRegSizeColumnsLsb, spec::kRegSizeColumnsBits) | field(spec::kRegSizeRowsLsb, spec::kRegSizeRowsBits)},
    {spec::kRegMeasure, spec::kRegMeasureReset,
     field(spec::kRegMeasureThresholdLsb, 8) | field(spec::kRegMeasureModeLsb, 2) |
         field(spec::kRegMeasureStreamLsb, 8) | field(spec::kRegMeasureSelectLsb, 1) |
         field(spec::kRegMeasureGapLsb, 2)},
    {spec::kRegWindow, spec::kRegWindowReset,
     field(spec::kRegWindowFirstLsb, kWindowBits) | field(spec::kRegWindowLastLsb, kWindowBits)},
    {spec::kRegTimeout, spec::kRegTimeoutReset, field(0, spec::kRegTimeoutClocksBits)},
    {spec::kRegTriggerControl, spec::kRegTriggerControlReset,
     field(spec::kRegTriggerControlRunLsb, 1) | field(spec::kRegTriggerControlOnFrameLsb, 1) |
         field(spec::kRegTriggerControlLastPatternLsb, 8)},
    {spec::kRegTriggerPeriod, spec::kRegTriggerPeriodReset, field(0, spec::kRegTriggerPeriodClocksBits)},
    {spec::kRegTriggerCamera, spec::kRegTriggerCameraReset, field(0, spec::kRegTriggerCameraClocksBits)},
    {spec::kRegTriggerWidth, spec::kRegTriggerWidthReset, field(0, spec::kRegTriggerWidthClocksBits)},
};

// Those of the build.
std::vector<Writable> writable_of(const Build& build) {
  std::vector<Writable> all = kWritable;
  if (build.code_bits != 0) {
    all.push_back({spec::kRegDecode, spec::kRegDecodeReset,
                   field(spec::kRegDecodeThresholdLsb, spec::kRegDecodeThresholdBits) |
                       field(spec::kRegDecodeBitsLsb, spec::kRegDecodeBitsBits) | field(spec::kRegDecodeCodesLsb, 1) |
                       field(spec::kRegDecodeMedianLsb, 1)});
  }
  if (build.region) {
    all.push_back({spec::kRegRegion, spec::kRegRegionReset, 0xFFFF'FFFF});
  }
  if (build.compact) {
    all.push_back({spec::kRegCompact, spec::kRegCompactReset, field(spec::kRegCompactOnLsb, 1)});
  }
  return all;
}

struct Answer {
  bool error;
  std::uint32_t data;
};

template <typename Dut>
class RegistersBench {
 public:
  static constexpr Build kBuild = BuildOf<Dut>::kBuild;

  const std::vector<Writable> writables = writable_of(kBuild);

  RegistersBench() {
    registers_.valid_when({"error_o"}, [this] { return registers_->answer_o != 0; });
    registers_.valid_when({"data_o"}, [this] { return registers_->answer_o != 0 && read_is_good_; });
    registers_->request_i = 0;
    registers_->write_i = 0;
    registers_->take_i = 0;
    set(State{});
    registers_.reset();
    for (const Writable& writable : writables) {
      values_[writable.address] = writable.reset;
    }
    const auto columns = std::min(spec::kRegSizeReset & 0xFFFU, static_cast<std::uint32_t>(kBuild.max_columns));
    const auto rows =
        std::min(spec::kRegSizeReset >> spec::kRegSizeRowsLsb, static_cast<std::uint32_t>(kBuild.max_rows));
    values_[spec::kRegSize] = columns << spec::kRegSizeColumnsLsb | rows << spec::kRegSizeRowsLsb;
  }

  Dut* operator->() { return &registers_.dut(); }

  void set(const State& state) {
    state_ = state;
    registers_->frame_open_i = state.frame_open;
    registers_->frames_i = state.frames;
    registers_->broken_i = state.broken;
    registers_->stray_i = state.stray;
    registers_->lost_moments_i = state.lost_moments;
    registers_->lost_image_i = state.lost_image;
    registers_->lost_codes_i = state.lost_codes;
    registers_->abandoned_i = state.abandoned;
    registers_->time_i = state.time;
    registers_->encoder_i = state.encoder;
    registers_->encoder_errors_i = state.encoder_errors;
  }

  // One clock, with or without a request.
  void tick(bool take = false) {
    begin_clock(take);
    check_outputs();
    rise();
  }

  // Settings are taken over in the clock that comes after so many others.
  void take_after(int clocks) { take_after_ = clocks; }

  // Plays a request, and expects its answer exactly five clocks later. Address and data stay, as behind the bridge.
  Answer access(bool write, std::uint32_t address, std::uint32_t data) {
    registers_->request_i = 1;
    registers_->write_i = write;
    registers_->address_i = static_cast<CData>(address);
    registers_->data_i = data;
    tick();
    EXPECT_EQ(registers_->answer_o, 0);
    registers_->request_i = 0;
    tick();
    held_ = write ? 3 : held_;
    EXPECT_EQ(registers_->answer_o, 0);
    begin_clock(false);
    check_outputs();
    read_is_good_ = !write && readable(address);
    rise();
    if (!write && address == spec::kRegTimeLow) {
      time_high_ = static_cast<std::uint32_t>(state_.time >> 32);
    }
    begin_clock(false);
    EXPECT_EQ(registers_->answer_o, 0);
    check_outputs();
    rise();
    const model::RegisterAnswer written = write ? model_.write(address, data) : model::RegisterAnswer{};
    if (write && good(address, data)) {
      for (const Writable& writable : writables) {
        if (writable.address == address) {
          values_[address] = data & writable.mask;
        }
      }
      pending_ = pending_ || address == spec::kRegControl || address == spec::kRegSize ||
                 address == spec::kRegMeasure || address == spec::kRegDecode || address == spec::kRegWindow ||
                 address == spec::kRegRegion || address == spec::kRegCompact;
    }
    begin_clock(false);
    EXPECT_EQ(registers_->answer_o, 0);
    check_outputs();
    rise();
    begin_clock(false);
    EXPECT_EQ(registers_->answer_o, 1) << "five clocks after the request";
    check_outputs();
    const Answer answer = {registers_->error_o != 0, registers_->data_o};
    rise();
    registers_.settle();
    EXPECT_EQ(registers_->answer_o, 0) << "the answer lasts one clock";
    if (address < spec::kRegVerdictControl) {
      const model::RegisterAnswer wanted = write ? written : model_.read(address, of_board(state_));
      EXPECT_EQ(answer.error, wanted.error) << std::hex << (write ? "write to " : "read ") << address;
      EXPECT_TRUE(write || wanted.error || answer.data == wanted.data)
          << std::hex << "read " << address << ": " << answer.data << ", but the model has " << wanted.data;
    }
    return answer;
  }

  // Whether the specification accepts the write, with the current values of the registers.
  [[nodiscard]] bool good(std::uint32_t address, std::uint32_t data) const {
    const bool runs = value(spec::kRegTriggerControl, spec::kRegTriggerControlRunLsb, 1) != 0;
    switch (address) {
      case spec::kRegControl:
        return kBuild.image || (data >> spec::kRegControlImageLsb & 1) == 0;
      case spec::kRegSize: {
        const int columns = static_cast<int>(data & 0xFFFFU);
        const int rows = static_cast<int>(data >> 16);
        return columns >= 4 && columns % 4 == 0 && columns <= kBuild.max_columns && rows >= 1 &&
               rows <= kBuild.max_rows;
      }
      case spec::kRegMeasure: {
        const std::uint32_t mode = data >> spec::kRegMeasureModeLsb & 3;
        const std::uint32_t run_bits = field(spec::kRegMeasureSelectLsb, 1) | field(spec::kRegMeasureGapLsb, 2);
        return (mode == spec::kModeBinary || (kBuild.grey && mode <= spec::kModeGreyOver)) &&
               (kBuild.runs || (data & run_bits) == 0);
      }
      case spec::kRegWindow: {
        const std::uint32_t row = field(0, kWindowBits);
        const auto limit = static_cast<std::uint32_t>(kBuild.max_rows);
        return (data >> spec::kRegWindowFirstLsb & row) <= limit && (data >> spec::kRegWindowLastLsb & row) <= limit;
      }
      case spec::kRegDecode: {
        const int bits = static_cast<int>(data >> spec::kRegDecodeBitsLsb & field(0, spec::kRegDecodeBitsBits));
        return kBuild.code_bits != 0 && bits >= 1 && bits <= kBuild.code_bits;
      }
      case spec::kRegTriggerPeriod:
        return !runs && (data & field(0, spec::kRegTriggerPeriodClocksBits)) != 0;
      case spec::kRegTriggerCamera:
      case spec::kRegTriggerWidth:
        return !runs;
      case spec::kRegTriggerControl: {
        constexpr std::uint32_t kOn = 1U << spec::kRegTriggerControlRunLsb | 1U << spec::kRegTriggerControlOnFrameLsb;
        return (values_.at(address) & kOn) == 0 || (data & kOn) == 0;
      }
      case spec::kRegTimeout:
        return true;
      case spec::kRegRegion:
        return kBuild.region;
      case spec::kRegCompact:
        return kBuild.compact;
      default:
        return false;
    }
  }

  static bool readable(std::uint32_t address) {
    const bool there = address <= (kBuild.code_bits != 0 ? spec::kRegAbandoned : spec::kRegEncoderErrors);
    return (there || address == spec::kRegWindow || (kBuild.region && address == spec::kRegRegion) ||
            (kBuild.compact && address == spec::kRegCompact)) &&
           address % 4 == 0;
  }

  std::uint32_t expected_read(std::uint32_t address) const {
    switch (address) {
      case spec::kRegId:
        return spec::kRegIdReset;
      case spec::kRegVersion:
        return spec::kRegVersionReset;
      case spec::kRegSpecHash:
        return spec::kHash;
      case spec::kRegCapability:
        return static_cast<std::uint32_t>(kBuild.max_columns) << spec::kRegCapabilityMaxColumnsLsb |
               static_cast<std::uint32_t>(kBuild.max_rows) << spec::kRegCapabilityMaxRowsLsb |
               (kBuild.grey ? 1U << spec::kRegCapabilityGreyLsb : 0) |
               (kBuild.image ? 1U << spec::kRegCapabilityImageLsb : 0) |
               (kBuild.runs ? 1U << spec::kRegCapabilityRunsLsb : 0) |
               (kBuild.region ? 1U << spec::kRegCapabilityRegionLsb : 0) |
               (kBuild.code_bits != 0 ? 1U << spec::kRegCapabilityCodesLsb | 1U << spec::kRegCapabilityMedianLsb : 0) |
               static_cast<std::uint32_t>(kBuild.code_bits) << spec::kRegCapabilityCodeBitsLsb;
      case spec::kRegStatus:
        return (state_.frame_open ? 1U << spec::kRegStatusFrameOpenLsb : 0) |
               (pending_ ? 1U << spec::kRegStatusPendingLsb : 0) |
               (kBuild.compact ? 1U << spec::kRegStatusCompactLsb : 0) |
               (kBuild.verdict ? 1U << spec::kRegStatusVerdictLsb : 0);
      case spec::kRegFrames:
        return state_.frames;
      case spec::kRegBroken:
        return state_.broken;
      case spec::kRegStray:
        return state_.stray;
      case spec::kRegLostMoments:
        return state_.lost_moments;
      case spec::kRegLostImage:
        return state_.lost_image;
      case spec::kRegLostCodes:
        return state_.lost_codes;
      case spec::kRegAbandoned:
        return state_.abandoned;
      case spec::kRegTimeLow:
        return static_cast<std::uint32_t>(state_.time);
      case spec::kRegTimeHigh:
        return time_high_;
      case spec::kRegEncoder:
        return state_.encoder;
      case spec::kRegEncoderErrors:
        return state_.encoder_errors;
      default:
        return values_.at(address);
    }
  }

  void expect_read(std::uint32_t address) {
    const Answer answer = access(false, address, 0xFFFF'FFFF);
    EXPECT_EQ(answer.error, !readable(address)) << std::hex << "read " << address;
    if (readable(address)) {
      EXPECT_EQ(answer.data, expected_read(address)) << std::hex << "read " << address;
    }
  }
  void expect_all_reads() {
    access(false, spec::kRegTimeLow, 0);
    for (std::uint32_t address = 0; address < 256; ++address) {
      expect_read(address);
    }
  }
  void expect_write(std::uint32_t address, std::uint32_t data) {
    const bool refused = !good(address, data);
    const Answer answer = access(true, address, data);
    EXPECT_EQ(answer.error, refused) << std::hex << "write " << data << " to " << address;
  }

  std::uint32_t value(std::uint32_t address, int lsb, int bits) const {
    return values_.at(address) >> lsb & field(0, bits);
  }

 private:
  static model::BoardState of_board(const State& state) {
    return {.frame_open = state.frame_open,
            .frames = state.frames,
            .broken = state.broken,
            .stray = state.stray,
            .lost_moments = state.lost_moments,
            .lost_image = state.lost_image,
            .lost_codes = state.lost_codes,
            .abandoned = state.abandoned,
            .time = state.time,
            .encoder = state.encoder,
            .encoder_errors = state.encoder_errors};
  }

  void begin_clock(bool take) {
    registers_->take_i = take || take_after_ == 0;
    --take_after_;
    registers_.settle();
  }
  void rise() {
    pending_ = pending_ && registers_->take_i == 0;
    if (registers_->take_i != 0) {
      model_.taken();
    }
    registers_.rise();
    held_ = std::max(held_ - 1, 0);
  }

  // Checks the settings in every clock.
  void check_outputs() {
    using namespace spec;
    EXPECT_EQ(registers_->run_o, value(kRegControl, kRegControlRunLsb, 1));
    // also in the first clock of new settings and in the two before it
    EXPECT_EQ(registers_->hold_o, value(kRegControl, kRegControlHoldLsb, 1) || held_ > 0 ? 1 : 0);
    EXPECT_EQ(registers_->image_o, value(kRegControl, kRegControlImageLsb, 1));
    EXPECT_EQ(registers_->columns_o, value(kRegSize, kRegSizeColumnsLsb, kRegSizeColumnsBits));
    EXPECT_EQ(registers_->rows_o, value(kRegSize, kRegSizeRowsLsb, kRegSizeRowsBits));
    EXPECT_EQ(registers_->threshold_o, value(kRegMeasure, kRegMeasureThresholdLsb, kRegMeasureThresholdBits));
    EXPECT_EQ(registers_->mode_o, value(kRegMeasure, kRegMeasureModeLsb, kRegMeasureModeBits));
    EXPECT_EQ(registers_->stream_o, value(kRegMeasure, kRegMeasureStreamLsb, kRegMeasureStreamBits));
    const int row_bits = std::bit_width(static_cast<unsigned>(kBuild.max_rows));
    EXPECT_EQ(registers_->select_o, value(kRegMeasure, kRegMeasureGapLsb, 2) |
                                        value(kRegMeasure, kRegMeasureSelectLsb, 1) << 2 |
                                        value(kRegWindow, kRegWindowFirstLsb, kWindowBits) << 3 |
                                        value(kRegWindow, kRegWindowLastLsb, kWindowBits) << (3 + row_bits));
    EXPECT_EQ(registers_->region_o, kBuild.region ? value(kRegRegion, 0, 32) : 0);
    EXPECT_EQ(registers_->compact_o, kBuild.compact ? value(kRegCompact, kRegCompactOnLsb, 1) : 0);
    EXPECT_EQ(registers_->timeout_o, value(kRegTimeout, kRegTimeoutClocksLsb, kRegTimeoutClocksBits));
    EXPECT_EQ(registers_->trigger_run_o, value(kRegTriggerControl, kRegTriggerControlRunLsb, 1));
    EXPECT_EQ(registers_->trigger_on_frame_o, value(kRegTriggerControl, kRegTriggerControlOnFrameLsb, 1));
    EXPECT_EQ(registers_->trigger_last_pattern_o, value(kRegTriggerControl, kRegTriggerControlLastPatternLsb, 8));
    EXPECT_EQ(registers_->trigger_period_o, value(kRegTriggerPeriod, 0, kRegTriggerPeriodClocksBits));
    EXPECT_EQ(registers_->trigger_camera_o, value(kRegTriggerCamera, 0, kRegTriggerCameraClocksBits));
    EXPECT_EQ(registers_->trigger_width_o, value(kRegTriggerWidth, 0, kRegTriggerWidthClocksBits));
    const bool codes = kBuild.code_bits != 0;
    EXPECT_EQ(registers_->decode_o, codes ? value(kRegDecode, kRegDecodeCodesLsb, 1) : 0);
    EXPECT_EQ(registers_->median_o, codes ? value(kRegDecode, kRegDecodeMedianLsb, 1) : 0);
    EXPECT_EQ(registers_->bits_o, codes ? value(kRegDecode, kRegDecodeBitsLsb, kRegDecodeBitsBits) : 0);
    EXPECT_EQ(registers_->code_threshold_o,
              codes ? value(kRegDecode, kRegDecodeThresholdLsb, kRegDecodeThresholdBits) : 0);
  }

  Clocked<Dut> registers_;
  model::RegisterFile model_{{.max_columns = kBuild.max_columns,
                              .max_rows = kBuild.max_rows,
                              .grey = kBuild.grey,
                              .image = kBuild.image,
                              .codes = kBuild.code_bits != 0,
                              .median = kBuild.code_bits != 0,
                              .runs = kBuild.runs,
                              .region = kBuild.region,
                              .compact = kBuild.compact,
                              .verdict_log_sections = kBuild.verdict ? 1 : -1,
                              .code_bits = kBuild.code_bits}};
  State state_;
  std::map<std::uint32_t, std::uint32_t> values_;  // index of a writable register
  bool pending_ = true;                            // the reset values have not been taken over
  int take_after_ = -1;                            // clocks until a take-over; negative: none
  int held_ = 1;                                   // clocks for which hold_o is high regardless of the register
  bool read_is_good_ = false;
  std::uint32_t time_high_ = 0;
};

// --- Tests ---

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
  for_cases(20, [&](Random& random) {
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
  });
}

}  // namespace

}  // namespace selfproj::test::registers
