// Tests the control of boards: names, settings, refusals; registers in files that are mapped into memory.
#include "host/driver/control.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/driver/boards.h"
#include "host/driver/register_port.h"
#include "selfproj/files/user_error.h"
#include "tests/cli/program.h"
#include "tests/support/board_registers.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

TEST(Control, EveryRegisterAndFieldByName) {
  model::RegisterFile board(
      {.codes = true, .median = true, .region = true, .compact = true, .verdict_log_sections = 2, .code_bits = 12});
  driver::Control control(port_of(board));
  for (const spec::Register& one : spec::kRegisters) {
    for (const spec::RegisterField& field : one.fields) {
      const std::string name = std::string(one.name) + "." + std::string(field.name);
      EXPECT_EQ(control.read(name), driver::field_of(control.read(one.name), field.lsb, field.bits)) << name;
    }
    if (!one.writable) {
      EXPECT_EQ(error_of([&] { control.write(one.name, 0); }),
                "sim:: register " + std::string(one.name) + " can only be read");
    }
  }
  EXPECT_EQ(error_of([] { driver::register_part("sizes"); }), "sizes: there is no such register");
  for (const std::string wrong : {"size.x", "size.column", "size.", "size.columns.x"}) {
    EXPECT_EQ(error_of([&] { driver::register_part(wrong); }), wrong + ": register size has no such field");
  }
}

TEST(Control, AFieldLeavesTheOthers) {
  model::RegisterFile board;
  driver::Control control(port_of(board));
  control.write("size.columns", 64);
  EXPECT_EQ(control.read("size.rows"), 96U);
  EXPECT_EQ(control.read("size.columns"), 64U);
  EXPECT_EQ(error_of([&] { control.write("measure.mode", 4); }), "sim:: measure.mode cannot hold 4: it has 2 bits");
  EXPECT_EQ(error_of([&] { control.write("measure.mode", 3); }),
            "sim:: the board refuses 0x00000380 in register measure");
  EXPECT_EQ(error_of([&] { static_cast<void>(control.read("decode")); }),
            "sim:: this board has no register decode: it has no Gray-code decoder");
}

// The threshold of pixels of more than 8 bits is in two fields of the register, and one value here.
TEST(Control, AThresholdOfTwelveBits) {
  model::RegisterFile board({.pixel_bits = 12});
  driver::Control control(port_of(board));
  control.write("measure.threshold", 4000);
  EXPECT_EQ(control.read("measure.threshold"), 4000U);
  control.write("measure.threshold", 200);
  EXPECT_EQ(control.read("measure.threshold"), 200U);
  EXPECT_EQ(error_of([&] { control.write("measure.threshold_high", 0); }),
            "sim:: measure.threshold_high is part of measure.threshold, which holds all bits");
}

// While settings are written, frames go on with the old ones.
TEST(Control, SettingsChangeTogether) {
  model::RegisterFile board;
  int together = 0;
  driver::Control control(std::make_unique<sim::AccessPort>(
      [&](bool write, std::uint32_t address, std::uint32_t data) -> model::RegisterAnswer {
        if (write && address != spec::kRegControl) {
          EXPECT_TRUE(board.settings().hold);
          ++together;
        }
        return write ? board.write(address, data) : board.read(address, {});
      }));
  control.write_together({{driver::register_part("control.run"), 1},
                          {driver::register_part("size.rows"), 7},
                          {driver::register_part("measure.threshold"), 60},
                          {driver::register_part("size.columns"), 128}});
  EXPECT_EQ(together, 2);  // one write a register
  EXPECT_EQ(board.settings().columns, 128);
  EXPECT_EQ(board.settings().rows, 7);
  EXPECT_EQ(board.settings().threshold, 60);
  EXPECT_TRUE(board.settings().run && !board.settings().hold);
  // A refused value ends the hold, too.
  EXPECT_THROW(control.write_together({{driver::register_part("size.columns"), 6}}), UserError);
  EXPECT_FALSE(board.settings().hold);
  EXPECT_EQ(board.settings().columns, 128);
}

// Nothing is written before all is known to fit.
TEST(Control, WhatDoesNotFitChangesNothing) {
  model::RegisterFile board;
  int writes = 0;
  driver::Control control(std::make_unique<sim::AccessPort>([&](bool write, std::uint32_t address, std::uint32_t data) {
    writes += write ? 1 : 0;
    return write ? board.write(address, data) : board.read(address, {});
  }));
  const auto together = [&](const char* name, std::uint32_t value) {
    return error_of([&] {
      control.write_together({{driver::register_part("size.columns"), 64}, {driver::register_part(name), value}});
    });
  };
  EXPECT_EQ(together("measure.threshold", 256), "sim:: measure.threshold cannot hold 256: it has 8 bits");
  EXPECT_EQ(together("frames", 0), "sim:: register frames can only be read");
  EXPECT_EQ(together("decode", 0), "sim:: this board has no register decode: it has no Gray-code decoder");
  EXPECT_EQ(writes, 0);
  control.write("measure.threshold", 255);
  EXPECT_EQ(board.settings().threshold, 255);
  EXPECT_EQ(writes, 1);
}

// A refused value in the middle: the earlier ones stay, the later ones are not written, and the board does not run.
TEST(Control, ARefusalInTheMiddleOfSeveralWrites) {
  model::RegisterFile board;
  driver::Control control(port_of(board));
  const model::BoardSettings before = board.settings();
  EXPECT_EQ(error_of([&] {
              control.write_together({{driver::register_part("timeout.clocks"), 77},
                                      {driver::register_part("control.run"), 1},
                                      {driver::register_part("measure.mode"), 3},
                                      {driver::register_part("size.columns"), 128}});
            }).find("sim:: the board refuses"),
            0U);
  EXPECT_EQ(board.settings().columns, 128);
  EXPECT_EQ(board.settings().mode, before.mode);
  EXPECT_EQ(board.settings().timeout, before.timeout);
  EXPECT_FALSE(board.settings().run);
  EXPECT_FALSE(board.settings().hold);
}

// The order of the addresses, and `control` last; registers that are no settings need no hold.
TEST(Control, TheOrderOfSeveralWrites) {
  model::RegisterFile board;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> writes;
  driver::Control control(std::make_unique<sim::AccessPort>([&](bool write, std::uint32_t address, std::uint32_t data) {
    if (write) {
      writes.emplace_back(address, data);
    }
    return write ? board.write(address, data) : board.read(address, {});
  }));
  control.write_together({{driver::register_part("trigger_width"), 5}, {driver::register_part("trigger_period"), 900}});
  EXPECT_EQ(writes, (std::vector<std::pair<std::uint32_t, std::uint32_t>>{{spec::kRegTriggerPeriod, 900},
                                                                          {spec::kRegTriggerWidth, 5}}));
  writes.clear();
  constexpr std::uint32_t kHold = 1U << spec::kRegControlHoldLsb;
  control.write_together({{driver::register_part("size"), 8U << 16U | 64U}});
  EXPECT_EQ(writes, (std::vector<std::pair<std::uint32_t, std::uint32_t>>{
                        {spec::kRegControl, kHold}, {spec::kRegSize, 8U << 16U | 64U}, {spec::kRegControl, 0}}));
  writes.clear();
  control.write_together({{driver::register_part("control.image"), 1}, {driver::register_part("size.rows"), 9}});
  EXPECT_EQ(writes, (std::vector<std::pair<std::uint32_t, std::uint32_t>>{
                        {spec::kRegControl, kHold},
                        {spec::kRegSize, 9U << 16U | 64U},
                        {spec::kRegControl, 1U << spec::kRegControlImageLsb}}));
}

// All that a board's settings are
auto all_of(const model::BoardSettings& settings) {
  const auto& [run, hold, image, columns, rows, mode, threshold, select, gap, window, stream, region_row, region_column,
               compact, verdict, verdict_packets, verdict_hold, verdict_settings, part_rule, codes, median, code_bits,
               code_threshold, timeout] = settings;
  return std::tuple(run, hold, image, columns, rows, mode, threshold, select, gap, window.first, window.last, stream,
                    region_row, region_column, compact, verdict, verdict_packets, verdict_hold, verdict_settings,
                    part_rule, codes, median, code_bits, code_threshold, timeout);
}

constexpr model::BoardBuild kEverything{.codes = true,
                                        .median = true,
                                        .runs = true,
                                        .region = true,
                                        .compact = true,
                                        .verdict_log_sections = 2,
                                        .code_bits = 12};

// Each differs from what it is after a reset.
model::BoardSettings every_setting() {
  return {.run = false,
          .hold = true,
          .image = true,
          .columns = 64,
          .rows = 50,
          .mode = model::Mode::grey_over,
          .threshold = 77,
          .select = model::Select::strongest,
          .gap = 3,
          .window = {.first = 5, .last = 40},
          .stream = 9,
          .region_row = 11,
          .region_column = 21,
          .compact = true,
          .verdict = true,
          .verdict_packets = 2,
          .verdict_hold = true,
          .verdict_settings = {.width = 16,
                               .history = 7,
                               .hits = 5,
                               .above = false,
                               .most_unlit = 77,
                               .shift_columns = -12,
                               .shift_rows = 40,
                               .bank = 1},
          .part_rule = {.by_encoder = true, .lit = 30, .dark_frames = 2, .start = 1234, .length = 2000, .pitch = 3000},
          .codes = true,
          .median = true,
          .code_bits = 7,
          .code_threshold = 13,
          .timeout = 5000};
}

TEST(Control, EverySettingReachesTheBoard) {
  model::RegisterFile board(kEverything);
  driver::Control control(port_of(board));
  const model::BoardSettings reset = board.settings();
  control.set_ejector(100, 20);
  control.set(every_setting());
  EXPECT_EQ(all_of(board.settings()), all_of(every_setting()));
  control.set(reset);
  EXPECT_EQ(all_of(board.settings()), all_of(reset));
}

// The writes that vectors and co-simulations have, which leave out what the board has already: also where they switch
// a part off.
TEST(Control, WritesFromOneSetOfSettingsToTheNext) {
  model::RegisterFile board(kEverything);
  const model::BoardSettings reset = board.settings();
  driver::Control(port_of(board)).set_ejector(100, 20);
  model::BoardSettings before = reset;
  for (const model::BoardSettings& settings : {every_setting(), reset, every_setting()}) {
    for (const auto& [address, data] : model::setting_writes(settings, before, true)) {
      EXPECT_FALSE(board.write(address, data).error) << address;
    }
    EXPECT_EQ(all_of(board.settings()), all_of(settings));
    before = settings;
  }
}

TEST(Control, WhatABuildHasNotIsRefused) {
  model::RegisterFile board;
  driver::Control control(port_of(board));
  const auto refusal = [&](const model::BoardSettings& settings) { return error_of([&] { control.set(settings); }); };
  EXPECT_EQ(refusal({.codes = true}), "sim:: this board has no Gray-code decoder");
  EXPECT_EQ(refusal({.region_row = 1}), "sim:: this board has no register for the region of the sensor");
  EXPECT_EQ(refusal({.region_column = 1}), "sim:: this board has no register for the region of the sensor");
  EXPECT_EQ(refusal({.compact = true}), "sim:: this board has no compact columns");
  EXPECT_EQ(refusal({.verdict = true}), "sim:: this board gives no verdicts");
  EXPECT_EQ(all_of(board.settings()), all_of(model::RegisterFile().settings()));
  for (const char* const name : {"region", "compact", "verdict_control"}) {
    EXPECT_EQ(error_of([&] { static_cast<void>(control.read(name)); }),
              "sim:: this board has no register " + std::string(name) + ": it was built without it");
  }
}

// A board for 8 pixels a clock takes columns that are a multiple of 8.
TEST(Control, ColumnsOfMoreLanes) {
  model::RegisterFile board({.lanes = 8});
  driver::Control control(port_of(board));
  const auto refusal = [&](int columns) { return error_of([&] { control.set({.columns = columns, .rows = 8}); }); };
  EXPECT_EQ(refusal(20), "sim:: this board takes 8 pixels a clock: 20 columns are no multiple of them");
  EXPECT_EQ(refusal(24), "none");
  EXPECT_EQ(error_of([&] { control.write("size.columns", 20); }),
            "sim:: the board refuses 0x00080014 in register size");
}

// What the register `capability` and its companions say of a build, each by itself.
TEST(Control, WhatTheBoardIs) {
  const auto all = [](const model::BoardBuild& build) {
    return std::tuple(build.max_columns, build.max_rows, build.pixel_bits, build.lanes, build.grey, build.image,
                      build.codes, build.median, build.runs, build.region, build.compact, build.verdict_log_sections,
                      build.code_bits);
  };
  for (const model::BoardBuild& build :
       {model::BoardBuild{}, kEverything, model::BoardBuild{.max_columns = 512, .max_rows = 100, .grey = false},
        model::BoardBuild{.max_columns = spec::kColumnLimit}, model::BoardBuild{.max_columns = spec::kColumnLimit - 4},
        model::BoardBuild{.image = false}, model::BoardBuild{.codes = true, .code_bits = 9},
        model::BoardBuild{.codes = true, .median = true, .code_bits = 1}, model::BoardBuild{.runs = true},
        model::BoardBuild{.region = true}, model::BoardBuild{.compact = true},
        model::BoardBuild{.verdict_log_sections = 0}, model::BoardBuild{.pixel_bits = 12},
        model::BoardBuild{.lanes = 8}, model::BoardBuild{.pixel_bits = 10, .lanes = 16}}) {
    model::RegisterFile board(build);
    EXPECT_EQ(all(driver::Control(port_of(board)).build()), all(build));
  }
}

TEST(Control, EveryCountOfTheBoard) {
  const auto all = [](const model::BoardState& state) {
    return std::tuple(state.frame_open, state.frames, state.broken, state.stray, state.lost_moments, state.lost_image,
                      state.lost_codes, state.abandoned, state.time, state.encoder, state.encoder_errors,
                      state.verdict_missed, state.ejector_lost);
  };
  const model::BoardState state{.frame_open = true,
                                .frames = 0xFFFF'FFF1,
                                .broken = 2,
                                .stray = 3,
                                .lost_moments = 4,
                                .lost_image = 5,
                                .lost_codes = 6,
                                .abandoned = 7,
                                .time = 0xF000'0000'8000'0000,
                                .encoder = 0xFFFF'FFF8,
                                .encoder_errors = 0xFFF9,
                                .verdict_missed = 250,
                                .ejector_lost = 251};
  model::RegisterFile board(kEverything);
  EXPECT_EQ(all(driver::Control(port_of(board, state)).state()), all(state));
  // Without the decoder and verdicts theirs are 0, and are not asked for.
  model::RegisterFile less;
  model::BoardState rest = state;
  rest.lost_codes = rest.abandoned = 0;
  rest.verdict_missed = rest.ejector_lost = 0;
  EXPECT_EQ(all(driver::Control(port_of(less, state)).state()), all(rest));
}

TEST(Control, PatternsOnFrames) {
  for (const int patterns : {1, 12, 256}) {
    model::RegisterFile board;
    driver::Control control(port_of(board));
    control.count_patterns_on_frames(patterns);
    EXPECT_EQ(control.read("trigger_control.last_pattern"), static_cast<std::uint32_t>(patterns - 1));
    EXPECT_EQ(control.read("trigger_control.on_frame"), 1U);
    EXPECT_EQ(control.read("trigger_control.run"), 0U);
  }
}

TEST(Control, TheEjectorsPulse) {
  model::RegisterFile board(kEverything);
  driver::Control control(port_of(board));
  control.set_ejector(100, 20);
  EXPECT_EQ(board.value(spec::kRegEjectorDelay), 100U);
  EXPECT_EQ(board.value(spec::kRegEjectorLength), 20U);
}

TEST(Control, TheControlOfADevice) {
  for (const auto& [device, control] :
       std::vector<std::pair<std::string, std::string>>{{"udp:board", "udp:board"},
                                                        {"udp:192.168.1.50:1235", "udp:192.168.1.50"},
                                                        {"bar:/dev/uio0+0x1000", "bar:/dev/uio0+0x1000"},
                                                        {"litepcie:/dev/litepcie0", "litepcie:/dev/litepcie0"},
                                                        {"file:/dev/xdma0_c2h_3", "bar:/dev/xdma0_user"},
                                                        {"file:xdma12_c2h_0", "bar:xdma12_user"},
                                                        {"file:/dev/other0_c2h_0", ""},
                                                        {"file:/dev/xdma0_h2c_0", ""},
                                                        {"ring:line1", ""},
                                                        {"sim:", ""},
                                                        {"", ""}}) {
    EXPECT_EQ(driver::control_uri(device), control) << device;
  }
  EXPECT_EQ(error_of([] { driver::open_control("bar:"); }), "bar:: the path of the file is missing");
  EXPECT_EQ(error_of([] { driver::open_control("usb:0"); }),
            "usb:0: is not the control of a board; use bar:PATH, litepcie:PATH or udp:HOST");
}

// The upper half is held when the lower one is read.
TEST(Control, TheTimeOfTheBoard) {
  constexpr std::uint64_t kTime = 0x123456789ABC;
  model::RegisterFile board;
  driver::Control control(port_of(board, {.time = kTime}));
  EXPECT_EQ(control.state().time, kTime);
}

TEST(Control, LimitsReachTheVerdict) {
  model::RegisterFile board({.max_columns = 8, .max_rows = 40, .verdict_log_sections = 1});
  model::Verdict verdict(8, 2);
  board.judge_with(verdict);
  driver::Control control(port_of(board));
  EXPECT_EQ(control.build().verdict_log_sections, 1);
  control.set_ejector(0, 5);
  const std::vector<model::ColumnLimits> limits(8, {.low = 9 * 128, .high = 11 * 128, .judged = true});
  const std::vector<model::SectionLimits> sections = {{.begin = 0, .limits = limits}, {.begin = 50, .limits = limits}};
  control.set_limits(0, sections);
  model::BoardSettings settings = board.settings();
  settings.verdict = true;
  settings.columns = 8;
  settings.rows = 40;
  control.set(settings);
  // Bank 0 judges next.
  EXPECT_EQ(error_of([&] { control.set_limits(0, sections); }),
            "sim:: the board refuses 0x82000480 in register verdict_limits");
  control.set_limits(1, sections);
  const std::vector<std::uint32_t> m0(8, 2);
  const std::vector<std::uint32_t> good(8, 20);
  std::vector<std::uint32_t> bad = good;
  bad[3] = 24;
  const auto frame = [&](const std::vector<std::uint32_t>& m1) {
    return verdict.frame(board.settings().verdict_settings, false, board.settings().part_rule, 0, m0, m1, true);
  };
  frame(good);
  EXPECT_FALSE(frame(good).defect);
  EXPECT_EQ(frame(bad).first_column, 4);
  EXPECT_EQ(control.read("verdict_parts.bad"), 1U);
  EXPECT_EQ(error_of([&] { control.set_limits(1, std::vector<model::SectionLimits>(3)); }),
            "sim:: the table has 3 sections, but this board has 2");
  std::vector<model::SectionLimits> wide = {{.begin = 0, .limits = {{.low = 0, .high = model::kMaxBand + 1}}}};
  EXPECT_EQ(error_of([&] { control.set_limits(1, wide); }),
            "sim:: the limits of column 1 are not in order, or 128 rows and more apart");
}

TEST(Control, OtherBoards) {
  for (const std::uint32_t wrong : {spec::kRegId, spec::kRegVersion, spec::kRegSpecHash}) {
    model::RegisterFile board;
    const auto port = [&](bool write, std::uint32_t address, std::uint32_t data) {
      model::RegisterAnswer answer = write ? board.write(address, data) : board.read(address, {});
      answer.data ^= address == wrong ? 1U : 0U;
      return answer;
    };
    const std::string error = error_of([&] { driver::Control control(std::make_unique<sim::AccessPort>(port)); });
    EXPECT_NE(error.find(wrong == spec::kRegId ? "no selfproj board" : "another specification"), std::string::npos)
        << error;
  }
}

// A board of version 1.1 has the registers of today but the region; one of 1.0 had others.
TEST(Control, EarlierVersions) {
  for (const spec::EarlierVersion& earlier : spec::kEarlierVersions) {
    model::RegisterFile board;
    const auto port = [&](bool write, std::uint32_t address, std::uint32_t data) {
      model::RegisterAnswer answer = write ? board.write(address, data) : board.read(address, {});
      answer.data = address == spec::kRegVersion    ? earlier.version
                    : address == spec::kRegSpecHash ? earlier.hash
                                                    : answer.data;
      return answer;
    };
    std::unique_ptr<driver::Control> control;
    const std::string error =
        error_of([&] { control = std::make_unique<driver::Control>(std::make_unique<sim::AccessPort>(port)); });
    EXPECT_EQ(error.find("another specification") == std::string::npos, earlier.version == 0x0101) << error;
    if (earlier.version == 0x0101) {
      control->set({.columns = 256, .rows = 20});
      EXPECT_EQ(board.settings().columns, 256);
      EXPECT_EQ(error_of([&] { control->set({.columns = 256, .rows = 20, .region_row = 39, .region_column = 1}); }),
                "sim:: this board has no register for the region of the sensor");
      EXPECT_EQ(error_of([&] { control->set({.mode = model::Mode::grey, .compact = true}); }),
                "sim:: this board has no compact columns");
      EXPECT_EQ(error_of([&] { control->write("window.last", 2047); }),
                "sim:: window: 2047 is a row beyond the board's 1023");
    }
  }
}

TEST(BarPort, OrdinaryFile) {
  const ScratchFolder folder;
  const std::string bytes = register_bytes();
  write_text(folder / "bar", std::string(4096, '\0') + bytes);
  const std::string uri = "bar:" + (folder / "bar").string() + "+0x1000";
  {
    const std::unique_ptr<driver::Control> control = driver::open_control(uri);
    EXPECT_EQ(control->uri(), uri);
    control->write("size.columns", 1024);
    control->write("trigger_period", 0x123456);
    EXPECT_EQ(control->read("size.columns"), 1024U);
  }
  std::string want = bytes;
  want.replace(spec::kRegSize, 4, std::string("\x00\x04\x60\x00", 4));
  want.replace(spec::kRegTriggerPeriod, 4, std::string("\x56\x34\x12\x00", 4));
  EXPECT_EQ(read_text(folder / "bar"), std::string(4096, '\0') + want);
}

TEST(BarPort, MemoryAndARegisterThatDoesNotTakeItsValue) {
  const int memory = memfd_create("registers", MFD_CLOEXEC);
  ASSERT_GE(memory, 0);
  const std::string bytes = register_bytes();
  ASSERT_EQ(write(memory, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  driver::Control control(driver::make_bar_port(memory, "bar:memory"));
  control.write("measure.threshold", 77);
  // Memory keeps the bits that a board ignores, so the value read differs from the one that a board would hold.
  EXPECT_EQ(error_of([&] { control.write("measure", 0xFF00'0001); }),
            "bar:memory: the board refuses 0xFF000001 in register measure");
  // Shortened by another process: the registers read as 0, and the program goes on.
  ASSERT_EQ(ftruncate(memory, 0), 0);
  EXPECT_EQ(control.read("measure"), 0U);
  close(memory);
}

// The registers may begin at any multiple of 4, and end with the file.
TEST(BarPort, AtAnyPlaceOfAFile) {
  const ScratchFolder folder;
  for (const std::size_t offset : {std::size_t{0}, std::size_t{4}, std::size_t{4100}}) {
    const std::string bytes = std::string(offset, '\xFF') + register_bytes();
    write_text(folder / "a+b", bytes);
    const std::string place = (folder / "a+b").string() + "+" + std::to_string(offset);
    const std::unique_ptr<driver::RegisterPort> port = driver::make_bar_port(place);
    EXPECT_EQ(port->word(spec::kRegId), spec::kMagic) << offset;
    const std::uint32_t last = spec::kRegisters.back().address;
    EXPECT_EQ(port->write(last, 0x01020304), driver::Written::unknown);
    EXPECT_EQ(port->word(last), 0x01020304U);
    for (const std::uint32_t wrong : {2U, last + 2, last + 4}) {
      EXPECT_EQ(error_of([&] { static_cast<void>(port->word(wrong)); }),
                "bar:" + place + ": has no register at " + std::to_string(wrong));
    }
    EXPECT_EQ(read_text(folder / "a+b").substr(bytes.size() - 4), std::string("\x04\x03\x02\x01"));
    write_text(folder / "a+b", bytes.substr(0, bytes.size() - 1));
    EXPECT_EQ(error_of([&] { driver::make_bar_port(place); }), "bar:" + place + ": is too short for the registers: " +
                                                                   std::to_string(bytes.size()) + " bytes are needed");
  }
}

TEST(BarPort, Offsets) {
  const ScratchFolder folder;
  write_text(folder / "bar", register_bytes());
  const std::string path = (folder / "bar").string();
  for (const char* const offset : {"", "x", "0x", "2", "4z", "-4", "0x10000000004", "99999999999999999999"}) {
    EXPECT_EQ(error_of([&] { driver::make_bar_port(path + "+" + offset); }),
              "bar:" + path + "+" + offset + ": '" + offset + "' is no offset: a multiple of 4, up to 2^40");
  }
  for (const char* const offset : {"0x10", "1099511627776"}) {
    EXPECT_NE(error_of([&] { driver::make_bar_port(path + "+" + offset); }).find("is too short"), std::string::npos);
  }
}

// After many that were opened and closed: the first register of a file that is gone reads as 0, too.
TEST(BarPort, ManyOneAfterAnother) {
  const int memory = memfd_create("registers", MFD_CLOEXEC);
  const std::string bytes = register_bytes();
  ASSERT_EQ(write(memory, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(driver::make_bar_port(memory, "bar:memory")->word(0), spec::kMagic);
  }
  const std::unique_ptr<driver::RegisterPort> port = driver::make_bar_port(memory, "bar:memory");
  ASSERT_EQ(ftruncate(memory, 0), 0);
  EXPECT_EQ(port->word(0), 0U);
  close(memory);
}

TEST(BarPort, WhatCannotBeOpened) {
  const ScratchFolder folder;
  write_text(folder / "short", "SLFP");
  const std::string path = (folder / "short").string();
  EXPECT_NE(error_of([&] { driver::open_control("bar:" + path); }).find("too short"), std::string::npos);
  EXPECT_NE(error_of([&] { driver::open_control("bar:" + path + "+6"); }).find("'6' is no offset"), std::string::npos);
  EXPECT_NE(error_of([&] { driver::open_control("bar:" + (folder / "none").string()); }).find("No such file"),
            std::string::npos);
  EXPECT_NE(error_of([&] { driver::open_control("bar:" + folder.path().string()); }).find("directory"),
            std::string::npos);
  EXPECT_EQ(error_of([] { driver::open_control("ring:line1"); }),
            "ring:line1: has no control of a board beside it; use bar:PATH, litepcie:PATH or udp:HOST");
  EXPECT_EQ(driver::control_uri("file:/dev/xdma1_c2h_0"), "bar:/dev/xdma1_user");
  EXPECT_EQ(driver::control_uri("file:line.slfp"), "");
}

TEST(BoardList, FilesOfADeviceFolder) {
  const ScratchFolder folder;
  write_text(folder / "xdma0_user", register_bytes());
  write_text(folder / "uio3", std::string(512, '\0'));
  write_text(folder / "null", "");
  const std::vector<driver::BoardPlace> boards = driver::list_boards(folder.path());
  ASSERT_EQ(boards.size(), 2U);
  EXPECT_EQ(boards[0].uri, "bar:" + (folder / "uio3").string());
  EXPECT_EQ(boards[0].problem, "no selfproj board is there: its first register is 0x00000000");
  EXPECT_EQ(boards[1].problem, "");
}

TEST(BoardList, FilesBeforeHostsAndWhatIsNone) {
  const ScratchFolder folder;
  for (const char* const name : {"xdma1_user", "xdma0_user", "xdma0_c2h_0", "uio0", "my_user", "litepcie1", "auio"}) {
    write_text(folder / name, "");
  }
  const std::string path = folder.path().string();
  std::vector<std::string> uris;
  for (const driver::BoardPlace& board : driver::list_boards(folder.path(), {"", ":x"})) {
    uris.push_back(board.uri);
    EXPECT_NE(board.problem, "");
    EXPECT_NE(board.problem.find(board.uri), 0U) << "the URI is not said twice";
  }
  EXPECT_EQ(uris, (std::vector<std::string>{"bar:" + path + "/uio0", "bar:" + path + "/xdma0_user",
                                            "bar:" + path + "/xdma1_user", "litepcie:" + path + "/litepcie1",
                                            "udp:", "udp::x"}));
  EXPECT_TRUE(driver::list_boards(folder / "none").empty());
}

// Each fault is named once, and the registers have their old values afterwards.
TEST(BoardTest, EachFaultByItsName) {
  struct Fault {
    const char* what;
    const char* fault;
  };
  for (const Fault& fault :
       {Fault{"the pixel clock", "it stands still"}, Fault{"refusal of size.columns=2", "accepted"},
        Fault{"refusal of trigger_period.clocks=0", "accepted"},
        Fault{"patterns in timeout", "wrote 16777214, read 16777206"},
        Fault{"refusal of size.rows=0", "refused, but changed"}}) {
    SCOPED_TRACE(fault.what);
    const std::string what = fault.what;
    model::RegisterFile board;
    std::uint64_t time = 0;
    std::uint32_t period = 1;
    std::uint32_t size = board.value(spec::kRegSize);
    const auto access = [&](bool write, std::uint32_t address, std::uint32_t data) -> model::RegisterAnswer {
      time += what == "the pixel clock" ? 0 : 20;
      if (address == spec::kRegTriggerPeriod && what == "refusal of trigger_period.clocks=0") {
        period = write ? data : period;
        return {.data = period};
      }
      if (address == spec::kRegSize && what.starts_with("refusal of size")) {
        const bool columns = what == "refusal of size.columns=2";
        const bool good = data % 4 == 0 && data >> 16U != 0;
        const bool takes = columns ? data >> 16U != 0 : data % 4 == 0;
        size = write && takes ? data : size;
        return {.error = write && (columns ? !takes : !good), .data = size};
      }
      model::RegisterAnswer answer = write ? board.write(address, data) : board.read(address, {.time = time});
      if (!write && address == spec::kRegTimeout && what == "patterns in timeout") {
        answer.data &= ~8U;  // a bit that is not connected
      }
      return answer;
    };
    driver::Control control(std::make_unique<sim::AccessPort>(access));
    std::vector<std::string> found;
    for (const driver::BoardTestResult& result : driver::test_board(control)) {
      if (!result.fault.empty()) {
        found.push_back(result.what + ": " + result.fault);
      }
    }
    EXPECT_EQ(found, std::vector<std::string>{what + ": " + fault.fault});
    EXPECT_EQ(period, 1U);
    const model::RegisterFile fresh;
    for (const std::uint32_t address : {spec::kRegTriggerCamera, spec::kRegTriggerWidth}) {
      EXPECT_EQ(board.value(address), fresh.value(address)) << address;
    }
  }
}

// A bit that cannot be set is found, and every register has its old value afterwards.
TEST(BoardTest, RegistersHaveTheirOldValuesWhereABitIsStuck) {
  for (const std::uint32_t stuck :
       {spec::kRegTimeout, spec::kRegTriggerPeriod, spec::kRegTriggerCamera, spec::kRegTriggerWidth}) {
    SCOPED_TRACE(stuck);
    model::RegisterFile board;
    const model::RegisterFile fresh;
    std::uint64_t time = 0;
    const auto access = [&](bool write, std::uint32_t address, std::uint32_t data) -> model::RegisterAnswer {
      constexpr std::uint32_t kBit = 1U << 9U;
      const std::uint32_t taken = address == stuck ? (data & ~kBit) | (fresh.value(stuck) & kBit) : data;
      time += 20;
      return write ? board.write(address, taken) : board.read(address, {.time = time});
    };
    driver::Control control(std::make_unique<sim::AccessPort>(access));
    const auto results = driver::test_board(control);
    EXPECT_TRUE(std::any_of(results.begin(), results.end(),
                            [](const driver::BoardTestResult& result) { return !result.fault.empty(); }));
    for (const std::uint32_t address :
         {spec::kRegTimeout, spec::kRegTriggerPeriod, spec::kRegTriggerCamera, spec::kRegTriggerWidth}) {
      EXPECT_EQ(board.value(address), fresh.value(address)) << address;
    }
  }
}

// Trigger pulses alone are enough to refuse the test.
TEST(BoardTest, NotWhileItGivesTriggerPulses) {
  model::RegisterFile board;
  driver::Control control(port_of(board));
  control.write("trigger_control.run", 1);
  EXPECT_EQ(error_of([&] { driver::test_board(control); }),
            "sim:: the board runs; stop it and its trigger pulses before the test");
}

TEST(BoardTest, GoodBoardAndBoardsWithAFault) {
  model::RegisterFile board;
  std::uint64_t time = 0;
  std::uint32_t stuck = 0;  // a bit that is always 1 on the way back
  const auto access = [&](bool write, std::uint32_t address, std::uint32_t data) {
    time += 20;
    model::RegisterAnswer answer = write ? board.write(address, data) : board.read(address, {.time = time});
    answer.data |= !write && address == spec::kRegTriggerCamera ? stuck : 0;
    return answer;
  };
  driver::Control control(std::make_unique<sim::AccessPort>(access));
  for (const driver::BoardTestResult& result : driver::test_board(control)) {
    EXPECT_EQ(result.fault, "") << result.what;
  }
  model::RegisterFile fresh;
  for (const spec::Register& one : spec::kRegisters) {
    EXPECT_EQ(board.value(one.address), fresh.value(one.address)) << one.name;
  }
  stuck = 1U << 5U;
  int faults = 0;
  for (const driver::BoardTestResult& result : driver::test_board(control)) {
    faults += result.fault.empty() ? 0 : 1;
  }
  EXPECT_EQ(faults, 1);
  board.write(spec::kRegControl, 1);
  EXPECT_THROW(driver::test_board(control), UserError);
}

}  // namespace
}  // namespace selfproj::test
