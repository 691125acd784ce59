// Tests the platform: real timing, results independent of the decoupling of time, and the model in place of the RTL.
#include "sim/platform/platform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"
#include "sim/board/packet_scoreboard.h"
#include "tests/rtl/board/frames.h"
#include "tests/support/random_cases.h"

#ifdef SELFPROJ_HAS_RTL_PLATFORM
#include <filesystem>

#include "Vboard.h"
#include "sim/board/board_device.h"
#endif

namespace selfproj::test {
namespace {

constexpr std::uint64_t kClockPs = model::pixel_clock_period_ps(model::kDefaultPixelClockHz);

struct Arrival {
  std::vector<std::uint8_t> bytes;
  std::uint64_t time_ps;
  bool operator==(const Arrival&) const = default;
};

// A run of the platform over frames in memory.
struct Played {
  std::vector<Arrival> arrivals;
  sim::PacketScoreboard scoreboard;
  sim::PlatformReport report;
  sim::CameraTiming timing;

  [[nodiscard]] std::vector<std::vector<std::uint8_t>> packets() const {
    std::vector<std::vector<std::uint8_t>> all;
    for (const Arrival& arrival : arrivals) {
      all.push_back(arrival.bytes);
    }
    return all;
  }
};

Played run(const sim::PlatformOptions& options, const std::vector<TestImage>& frames) {
  Played played;
  std::size_t next = 0;
  sim::Platform platform(
      options,
      [&]() -> std::optional<model::ImageView> {
        return next < frames.size() ? std::optional(frames[next++].view()) : std::nullopt;
      },
      [&](std::span<const std::uint8_t> bytes, std::uint64_t time_ps) {
        played.arrivals.push_back({{bytes.begin(), bytes.end()}, time_ps});
        played.scoreboard.compare(bytes);
      },
      [&](model::BoardPacket&& packet) { played.scoreboard.expect(std::move(packet)); });
  platform.run();
  played.scoreboard.finish();
  played.report = platform.report();
  played.timing = platform.timing();
  return played;
}

void expect_all_right(const Played& run) {
  EXPECT_EQ(run.scoreboard.mismatches(), 0U) << run.scoreboard.first_mismatch();
  EXPECT_EQ(run.scoreboard.matched(), run.arrivals.size());
  EXPECT_EQ(run.report.packets, run.arrivals.size());
  EXPECT_EQ(run.report.board.frames, run.report.frames);
  EXPECT_EQ(run.report.board.broken, 0U);
  EXPECT_EQ(run.report.board.stray, 0U);
  EXPECT_EQ(run.report.board.lost_moments, run.scoreboard.of(spec::kKindMoments).lost);
  EXPECT_EQ(run.report.board.lost_image, run.scoreboard.of(spec::kKindImage).lost);
}

std::vector<TestImage> random_images(Random& random, int count, int rows, int columns) {
  std::vector<TestImage> images;
  for (int i = 0; i < count; ++i) {
    images.push_back(random_image(random, rows, columns));
  }
  return images;
}

sim::PlatformOptions random_options(Random& random) {
  sim::PlatformOptions options;
  options.settings = {.image = random.chance(30),
                      .columns = 4 * random.between(1, 24),
                      .rows = random.between(1, 20),
                      .mode = static_cast<model::Mode>(random.between(0, 2)),
                      .threshold = random.between(0, 255),
                      .stream = random.between(0, 255)};
  options.frame_rate_hz = random.between(10000, 40000);
  options.encoder_steps_per_s = random.chance(20) ? 0 : random.between(1000, 5000000);
  options.bus.period_ps = static_cast<std::uint64_t>(random.between(3000, 12000));
  options.bus.phase_ps = static_cast<std::uint64_t>(random.between(0, 5000));
  options.seed = random.bits();
  return options;
}

TEST(CameraTiming, OfOtherPixelClocks) {
  EXPECT_EQ(model::pixel_clock_period_ps(151.2e6), 6614U);
  EXPECT_EQ(model::pixel_clock_period_ps(125e6), 8000U);
  EXPECT_EQ(sim::camera_timing(64, 512, 10000, 125e6).frame_clocks, 12500U);
  EXPECT_EQ(sim::camera_timing(96, 512, 10000, 125e6).frame_clocks, 96U * 132U) << "no faster than the lines allow";
  EXPECT_THROW(sim::camera_timing(64, 512, 126e6, 125e6), std::invalid_argument);
}

TEST(CameraTiming, OfRigA) {
  const sim::CameraTiming timing = sim::camera_timing(96, 512, 10000);
  EXPECT_EQ(timing.frame_clocks, 15120U);
  EXPECT_EQ(timing.beats(), 12288U);
  EXPECT_EQ(timing.line_clocks, 157U);
}

TEST(CameraTiming, AFrameRateTooHighIsAsFastAsPossible) {
  const sim::CameraTiming timing = sim::camera_timing(480, 640, 10000, model::kDefaultPixelClockHz, 4);
  EXPECT_EQ(timing.line_clocks, 164U);
  EXPECT_EQ(timing.frame_clocks, 480U * 164U);
}

TEST(CameraTiming, RefusesWhatTheBoardDoes) {
  EXPECT_THROW(sim::camera_timing(0, 512, 1000), std::invalid_argument);
  EXPECT_THROW(sim::camera_timing(96, 510, 1000), std::invalid_argument);
  EXPECT_THROW(sim::camera_timing(96, 4096, 1000), std::invalid_argument);
  EXPECT_THROW(sim::camera_timing(1024, 512, 1000), std::invalid_argument);
  EXPECT_THROW(sim::camera_timing(96, 512, 0), std::invalid_argument);
  EXPECT_THROW(sim::camera_timing(96, 512, std::nan("")), std::invalid_argument);
}

std::vector<sim::PlatformEngine> engines() {
#ifdef SELFPROJ_HAS_RTL_PLATFORM
  return {sim::PlatformEngine::rtl, sim::PlatformEngine::hls, sim::PlatformEngine::model};
#else
  return {PlatformEngine::model};
#endif
}

class EveryEngine : public ::testing::TestWithParam<sim::PlatformEngine> {};

// With another pixel clock a second has another number of clocks, and so have a frame and a step of the encoder.
TEST_P(EveryEngine, ABoardOfAnotherPixelClock) {
  Random random(4);
  sim::PlatformOptions options{.engine = GetParam(),
                               .settings = {.rows = 64, .mode = model::Mode::binary, .threshold = 100}};
  options.pixel_clock_hz = 125e6;
  options.encoder_steps_per_s = 100000;
  const Played got = run(options, random_images(random, 5, 64, 512));
  expect_all_right(got);
  ASSERT_EQ(got.arrivals.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    model::PacketView packet;
    ASSERT_EQ(model::parse_packet(got.arrivals[i].bytes, packet), model::PacketError::none);
    EXPECT_EQ(packet.header.time_stamp, sim::Platform::kFirstClock + i * 12500);
    EXPECT_NEAR(packet.header.encoder, 10.0 * static_cast<double>(i), 1);
    const std::uint64_t last_beat = (packet.header.time_stamp + 63 * 195 + 127) * 8000;
    EXPECT_GT(got.arrivals[i].time_ps, last_beat);
    EXPECT_LT(got.arrivals[i].time_ps, last_beat + 700 * 8000);
  }
  options.pixel_clock_hz = 0;
  EXPECT_THROW(run(options, {}), std::invalid_argument);
}

TEST_P(EveryEngine, FramesComeAtTheirTimeWithTheBeltsWay) {
  Random random(3);
  sim::PlatformOptions options{.engine = GetParam(), .settings = {.mode = model::Mode::grey_over, .threshold = 100}};
  options.encoder_steps_per_s = 100000;  // 1 m/s at 0.01 mm
  const Played got = run(options, random_images(random, 5, 96, 512));
  expect_all_right(got);
  ASSERT_EQ(got.arrivals.size(), 5U);
  for (std::size_t i = 0; i < got.arrivals.size(); ++i) {
    model::PacketView packet;
    ASSERT_EQ(model::parse_packet(got.arrivals[i].bytes, packet), model::PacketError::none);
    EXPECT_EQ(packet.header.sequence, i);
    EXPECT_EQ(packet.header.time_stamp, sim::Platform::kFirstClock + i * 15120);
    EXPECT_EQ(packet.header.encoder, i * 10);
    // The packet leaves within the blank clocks at the end of the frame and the first clocks of the next one.
    const std::uint64_t last_beat = (packet.header.time_stamp + 95 * 157 + 127) * kClockPs;
    EXPECT_GT(got.arrivals[i].time_ps, last_beat);
    EXPECT_LT(got.arrivals[i].time_ps, last_beat + 700 * kClockPs);
  }
}

TEST_P(EveryEngine, RandomFramesEqualTheModel) {
  for (const std::uint64_t seed : seeds(30)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    sim::PlatformOptions options = random_options(random);
    options.engine = GetParam();
    options.bus.stall_percent = random.chance(50) ? 0 : random.between(0, 90);
    options.quantum_lines = static_cast<std::uint64_t>(random.between(1, 40));
    const int count = random.between(1, 12);
    const Played got = run(options, random_images(random, count, options.settings.rows, options.settings.columns));
    expect_all_right(got);
    EXPECT_EQ(got.report.frames, static_cast<std::uint64_t>(count));
    if (HasFailure()) {
      return;
    }
  }
}

TEST_P(EveryEngine, WhatTheSourceThrowsComesOut) {
  const auto throwing = [&] {
    sim::Platform platform(
        {.engine = GetParam()}, []() -> std::optional<model::ImageView> { throw UserError("frame.png", "is torn"); },
        [](std::span<const std::uint8_t>, std::uint64_t) {});
    platform.run();
  };
  EXPECT_THROW(throwing(), UserError);
  Random random(1);
  const auto frames = random_images(random, 3, 96, 512);
  int left = 3;
  const auto throwing_sink = [&] {
    sim::Platform platform(
        {.engine = GetParam()},
        [&]() -> std::optional<model::ImageView> {
          return left-- > 0 ? std::optional(frames.front().view()) : std::nullopt;
        },
        [](std::span<const std::uint8_t>, std::uint64_t) { throw std::runtime_error("full"); });
    platform.run();
  };
  EXPECT_THROW(throwing_sink(), std::runtime_error);
  // And the next platform works.
  expect_all_right(run({.engine = GetParam()}, frames));
}

TEST(Platform, NoFramesNoPackets) {
  const Played got = run({.engine = sim::PlatformEngine::model}, {});
  EXPECT_EQ(got.report.frames, 0U);
  EXPECT_TRUE(got.arrivals.empty());
}

TEST(Platform, RefusesOptionsThatMakeNoSense) {
  const auto make = [](const sim::PlatformOptions& options) { sim::Platform platform(options, {}, {}); };
  EXPECT_THROW(make({.engine = sim::PlatformEngine::model, .quantum_lines = 0}), std::invalid_argument);
  EXPECT_THROW(make({.engine = sim::PlatformEngine::model, .encoder_steps_per_s = 1e9}), std::invalid_argument);
  EXPECT_THROW(make({.engine = sim::PlatformEngine::model, .bus = {.stall_percent = 96}}), std::invalid_argument);
  EXPECT_THROW(make({.engine = sim::PlatformEngine::model, .trace_file = "x.fst"}), std::invalid_argument);
  EXPECT_THROW(make({.engine = sim::PlatformEngine::model, .settings = {.columns = 5}}), std::invalid_argument);
}

// The packets are the same at the same picosecond, whatever the quantum, even with stalls and hold-ups that make the
// board lose some.
TEST_P(EveryEngine, DecouplingOfTimeChangesNothing) {
  for (const std::uint64_t seed : seeds(4)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    sim::PlatformOptions options = random_options(random);
    options.engine = GetParam();
    options.bus.stall_percent = random.between(0, 90);
    options.bus.hold_ups_a_second = 5000;
    options.bus.hold_up_s = 1e-3;
    const std::vector<TestImage> frames = random_images(random, 30, options.settings.rows, options.settings.columns);
    const Played line = run(options, frames);
    expect_all_right(line);
    EXPECT_GT(line.report.hold_ups, 0U);
    for (const std::uint64_t quantum : {2U, 7U, 1000U}) {
      options.quantum_lines = quantum;
      const Played other = run(options, frames);
      EXPECT_TRUE(line.arrivals == other.arrivals) << "quantum of " << quantum << " lines";
    }
    if (HasFailure()) {
      return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Platform, EveryEngine, ::testing::ValuesIn(engines()), [](const auto& engine) {
  return engine.param == sim::PlatformEngine::rtl ? "Rtl" : engine.param == sim::PlatformEngine::hls ? "Hls" : "Model";
});

#ifdef SELFPROJ_HAS_RTL_PLATFORM

// Packets are byte-identical, and the model's times are within four clocks as long as the bus is always ready.
TEST(Platform, ModelInPlaceOfTheRtl) {
  std::uint64_t worst = 0;
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    sim::PlatformOptions options = random_options(random);
    options.settings.image = false;
    if (seed <= 3) {
      options.settings.columns = 512;
      options.settings.rows = 96;
      options.settings.mode = static_cast<model::Mode>(seed - 1);
    }
    const std::vector<TestImage> frames = random_images(random, 8, options.settings.rows, options.settings.columns);
    const Played rtl = run(options, frames);
    options.engine = sim::PlatformEngine::model;
    const Played model = run(options, frames);
    ASSERT_TRUE(rtl.packets() == model.packets());
    for (std::size_t i = 0; i < rtl.arrivals.size(); ++i) {
      const auto difference = static_cast<std::int64_t>(rtl.arrivals[i].time_ps - model.arrivals[i].time_ps);
      worst = std::max(worst, static_cast<std::uint64_t>(std::abs(difference)));
    }
  }
  EXPECT_LE(worst, 4 * kClockPs);
}

// The platform does to the board what a plain loop does: same beats at the same clocks, same packets at the same time.
TEST(Platform, SameAsThePlainHarness) {
  Random random(5);
  const model::BoardSettings settings{.columns = 64, .rows = 12, .mode = model::Mode::grey, .threshold = 90};
  const std::vector<TestImage> frames = random_images(random, 20, settings.rows, settings.columns);
  sim::PlatformOptions options{.settings = settings, .frame_rate_hz = 100000, .seed = 9};
  options.bus.stall_percent = 60;
  const Played platform = run(options, frames);
  expect_all_right(platform);

  sim::BoardDevice<Vboard> device({.seed = 9, .bus_stall_percent = 60});
  std::vector<Arrival> arrivals;
  device.run(1);
  const std::uint64_t origin = device.time_ps();
  device.on_packet([&](std::span<const std::uint8_t> bytes) {
    arrivals.push_back({{bytes.begin(), bytes.end()}, device.time_ps() - origin});
  });
  device.write(settings);
  device.run(sim::Platform::kFirstClock - device.clock());
  for (const TestImage& frame : frames) {
    for (int row = 0; row < settings.rows; ++row) {
      for (int column = 0; column < settings.columns; column += 4) {
        const std::uint8_t* pixels = frame.view().pixels + row * settings.columns + column;
        device.send(model::VideoBeat{.pixels = {pixels[0], pixels[1], pixels[2], pixels[3]},
                                     .start = row == 0 && column == 0,
                                     .line_end = column + 4 == settings.columns});
      }
      const bool last = row == settings.rows - 1;
      device.gap(static_cast<std::uint32_t>(
          (last ? platform.timing.frame_clocks - 11 * platform.timing.line_clocks : platform.timing.line_clocks) - 16));
    }
  }
  device.drain(2000);
  EXPECT_TRUE(platform.arrivals == arrivals);
}

// A bus that takes nothing for longer than the FIFO lasts: packets are lost, whole and counted, and all others match.
TEST(Platform, HoldUpsLosePacketsThatAreCounted) {
  Random random(8);
  sim::PlatformOptions options{.settings = {.columns = 256, .rows = 8, .mode = model::Mode::grey},
                               .frame_rate_hz = 80000};
  options.bus.hold_ups_a_second = 500;
  options.bus.hold_up_s = 2e-3;
  const Played got = run(options, random_images(random, 600, 8, 256));
  expect_all_right(got);
  EXPECT_GT(got.report.board.lost_moments, 0U);
  EXPECT_GT(got.arrivals.size(), 100U);
  EXPECT_EQ(got.arrivals.size() + got.report.board.lost_moments, 600U);
}

TEST(Platform, WaveformFromAFrameOn) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  const std::string all = folder / ("selfproj_all_" + std::to_string(getpid()) + ".fst");
  const std::string last = folder / ("selfproj_last_" + std::to_string(getpid()) + ".fst");
  Random random(4);
  sim::PlatformOptions options{.settings = {.columns = 64, .rows = 8}, .frame_rate_hz = 50000};
  const std::vector<TestImage> frames = random_images(random, 10, 8, 64);
  const Played plain = run(options, frames);
  options.trace_file = all;
  EXPECT_TRUE(run(options, frames).arrivals == plain.arrivals);
  options.trace_file = last;
  options.trace_from = 10;
  EXPECT_TRUE(run(options, frames).arrivals == plain.arrivals);
  EXPECT_GT(std::filesystem::file_size(last), 1000U);
  EXPECT_GT(std::filesystem::file_size(all), 2 * std::filesystem::file_size(last));
  std::filesystem::remove(all);
  std::filesystem::remove(last);
}

#endif

}  // namespace
}  // namespace selfproj::test
