// Tests selfproj-sim board, selfproj inspect and selfproj devices from the command line: two processes and a ring.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/driver/clock.h"
#include "host/driver/ring_memory.h"
#include "host/driver/ring_writer.h"
#include "selfproj/driver/device.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "sim/board/packet_recording.h"
#include "tests/cli/program.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

using Words = std::vector<std::string>;

class Board : public ::testing::Test {
 protected:
  void SetUp() override { driver::remove_ring(ring_); }
  void TearDown() override { driver::remove_ring(ring_); }

  [[nodiscard]] Outcome board(Words words) const {
    words.insert(words.begin(), "board");
    return run_program(SELFPROJ_SIM_PROGRAM, words, folder_.path());
  }
  [[nodiscard]] Outcome host(const Words& words) const { return run_program(SELFPROJ_PROGRAM, words, folder_.path()); }

  // Starts a board in a separate process that plays when a reader comes. Its ring exists when this returns. Where no
  // reader comes, it is ended with status 124 (coreutils' timeout), so that the test fails instead of waiting for ever.
  [[nodiscard]] std::future<Outcome> board_beside(Words words) const {
    words.insert(words.begin(), {"120", SELFPROJ_SIM_PROGRAM, "board"});
    words.insert(words.end(), {"--ring", ring_, "--wait-for-reader", "--keep"});
    auto outcome =
        std::async(std::launch::async, [=, this] { return run_program("/usr/bin/timeout", words, folder_.path()); });
    const auto there = [&] {
      const auto rings = driver::list_rings();
      return std::any_of(rings.begin(), rings.end(),
                         [&](const driver::RingInfo& ring) { return ring.name == ring_ && ring.board; });
    };
    while (!there() && outcome.wait_for(std::chrono::milliseconds(10)) == std::future_status::timeout) {
    }
    return outcome;
  }

  [[nodiscard]] nlohmann::json json(const std::string& file) const {
    return nlohmann::json::parse(read_text(folder_ / file));
  }

  ScratchFolder folder_;
  std::string ring_ = "cli-test-" + std::to_string(getpid());
};

TEST_F(Board, RecordsAMovingLine) {
  const Outcome made = board({"--line", "64x96", "--line-frames", "7", "--count", "20", "--record", "line.slfp"});
  ASSERT_EQ(made.status, 0) << made.err;
  const auto device = driver::open_device("file:" + (folder_ / "line.slfp").string());
  model::PacketView packet;
  std::uint64_t frame = 0;
  std::vector<std::vector<std::uint8_t>> payloads;
  for (; device->next(packet, {}) == driver::Next::packet; ++frame) {
    EXPECT_EQ(packet.header.sequence, frame);
    EXPECT_EQ(packet.header.time_stamp, 15120 * frame);
    EXPECT_EQ(packet.header.encoder, 10 * frame);
    payloads.emplace_back(packet.payload.begin(), packet.payload.end());
  }
  EXPECT_EQ(frame, 20U);
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 20}));
  EXPECT_EQ(payloads[3], payloads[10]);
  EXPECT_NE(payloads[3], payloads[4]);
}

TEST_F(Board, ReplaysARecordingWithItsHolesClosed) {
  // Moments and two image lines a frame, in binary mode, with frames missing and an encoder that wraps.
  sim::PacketRecording recording;
  std::vector<std::uint8_t> packet;
  for (const std::uint64_t sequence : {100U, 101U, 105U}) {
    model::PacketHeader header;
    header.sequence = sequence;
    header.lost = 3;
    header.encoder = static_cast<std::uint32_t>(-3 + 2 * static_cast<int>(sequence - 100));
    header.columns = 16;
    header.rows = 2;
    for (std::uint16_t line = 0; line <= 2; ++line) {
      header.kind = line == 0 ? spec::kKindMoments : spec::kKindImage;
      header.first_line = line;
      header.lines = line == 0 ? 0 : 1;
      packet.clear();
      model::append_packet(header, std::vector<std::uint8_t>(line == 0 ? 64 : 16, static_cast<std::uint8_t>(sequence)),
                           0, packet);
      recording.add(header, packet);
    }
  }
  EXPECT_EQ(recording.frames(), 3U);
  EXPECT_EQ(recording.packets(), 9U);
  const std::vector<std::int32_t> encoders{-3, -1, 7, 12, 14, 22, 27};  // on average 5 from frame to frame
  for (std::uint64_t frame = 0; frame < 7; ++frame) {
    std::uint16_t line = 0;
    recording.play(frame, 1000.5, [&](std::size_t size, const auto& stamp) {
      std::vector<std::uint8_t> room(size);
      stamp(room.data());
      model::PacketView view;
      ASSERT_EQ(model::parse_packet(room, view), model::PacketError::none);
      EXPECT_EQ(view.size, size);
      EXPECT_EQ(view.header.sequence, frame);
      EXPECT_EQ(view.header.time_stamp, static_cast<std::uint64_t>(1000.5 * static_cast<double>(frame)));
      EXPECT_EQ(static_cast<std::int32_t>(view.header.encoder), encoders[static_cast<std::size_t>(frame)]);
      EXPECT_EQ(view.header.lost, 0U);
      EXPECT_EQ(view.header.first_line, line++);
      EXPECT_EQ(view.payload[5], (std::vector<int>{100, 101, 105}[frame % 3]));
    });
    EXPECT_EQ(line, 3);
  }
}

TEST_F(Board, MovingLineIsWhereItShouldBe) {
  for (const int rows : {96, 1500}) {
    for (const model::Mode mode : {model::Mode::binary, model::Mode::grey_over}) {
      const sim::PacketRecording recording = sim::moving_line(rows, 32, 8, {.mode = mode, .threshold = 60});
      model::Moments moments;
      moments.resize(32);
      for (std::uint64_t frame = 0; frame < 8; ++frame) {
        recording.play(frame, 1, [&](std::size_t size, const auto& stamp) {
          std::vector<std::uint8_t> room(size);
          stamp(room.data());
          model::PacketView packet;
          ASSERT_EQ(model::parse_packet(room, packet), model::PacketError::none);
          model::unpack_columns(packet.header, packet.payload.data(), {.moments = moments.view()});
        });
        for (std::size_t column = 0; column < 32; ++column) {
          const double phase = static_cast<double>(column) / 32 + static_cast<double>(frame) / 8;
          const double right =  // rows count from 1
              0.5 * (rows - 1) + 0.25 * rows * std::sin(2 * 3.14159265358979 * phase) + 1;
          EXPECT_NEAR(static_cast<double>(moments.m1[column]) / moments.m0[column], right,
                      mode == model::Mode::binary ? 0.5 : 0.05);
        }
      }
    }
  }
}

// The main case: two processes. There are more slots than frames, so that nothing can be lost however busy the machine
// is.
TEST_F(Board, EveryFrameBecomesAProfile) {
  auto other = board_beside({"--line", "512x96", "--rate", "10000", "--count", "2000"});
  const Outcome inspected = host({"inspect", "--device", "ring:" + ring_, "--json", "counts.json", "--check"});
  const Outcome played = other.get();
  EXPECT_EQ(played.status, 0) << played.err;
  EXPECT_EQ(inspected.status, 0) << inspected.err;
  EXPECT_EQ(inspected.out.find("2000 profiles, "), 0U) << inspected.out;
  const auto counts = json("counts.json");
  EXPECT_EQ(counts["profiles"], 2000);
  EXPECT_GT(counts["points"], 2000 * 400);
  for (const char* none : {"lost_board", "lost_ring", "missing", "bad", "flagged", "other_spec", "repeated", "restarts",
                           "reattached", "read_errors", "bytes_discarded", "resynchronized"}) {
    EXPECT_EQ(counts[none], 0) << none;
  }
  EXPECT_GT(counts["delay_p50_us"], 0);
  EXPECT_GE(counts["delay_p99_us"], counts["delay_p50_us"]);
  EXPECT_GE(counts["delay_max_us"], counts["delay_p99_us"]);
}

// The ring is far too small for a board that does not wait. Every frame becomes a profile or is counted as lost. The
// scanner's codes, live: a board replays code packets in a separate process, and `selfproj depth` reads its ring. The
// newest depth image equals that of the simulation from the same packets.
TEST_F(Board, CodesThroughARingBecomeDepthImages) {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows = rig.camera.columns = 64;
  rig.camera.pixel_pitch_mm *= 8;
  rig.projector.lines /= 8;
  rig.projector.columns /= 8;
  rig.projector.line_pitch_mm *= 8;
  rig.projector.column_pitch_mm *= 8;
  rig.measure.max_z_per_line_mm *= 8;
  std::ofstream(folder_ / "small.yaml") << rig::to_yaml(rig);
  const Outcome simulated =
      run_program(SELFPROJ_SIM_PROGRAM,
                  {"cosim", "--scene", "fist", "--engine", "model", "--rig", "small.yaml", "--bits", "5", "--count",
                   "40", "--packets", "codes.slfp", "--out", "simulated"},
                  folder_.path());
  ASSERT_EQ(simulated.status, 0) << simulated.err;
  // 16 code images of 64 lines and 40 frames of moments: all of it has room in the ring
  auto other = board_beside({"--replay", "codes.slfp", "--rate", "500", "--slots", "2048"});
  const Outcome depth = host({"depth", "--rig", "small.yaml", "--bits", "5", "--device", "ring:" + ring_, "--count",
                              "16", "--max-z", "565", "--background", "simulated/background.tiff", "--out", "host"});
  const Outcome played = other.get();
  EXPECT_EQ(played.status, 0) << played.err;
  ASSERT_EQ(depth.status, 0) << depth.err;
  EXPECT_TRUE(read_text(folder_ / "host" / "depth.tiff") == read_text(folder_ / "simulated" / "depth.tiff"));
  const auto device = json("host/summary.json")["device"];
  for (const char* counter : {"lost_board", "lost_ring", "bad", "flagged", "incomplete"}) {
    EXPECT_EQ(device[counter], 0) << counter;
  }
  EXPECT_EQ(json("host/summary.json")["depth_images"], 16);
  // a line of moved.csv for each
  const std::string moved = read_text(folder_ / "host" / "moved.csv");
  EXPECT_EQ(std::count(moved.begin(), moved.end(), '\n'), 17);
}

TEST_F(Board, WhatIsLostIsCounted) {
  auto other = board_beside({"--line", "512x96", "--rate", "0", "--count", "100000", "--slots", "4"});
  const Outcome inspected = host({"inspect", "--device", "ring:" + ring_, "--json", "counts.json"});
  EXPECT_EQ(other.get().status, 0);
  EXPECT_EQ(inspected.status, 0) << inspected.err;
  const auto counts = json("counts.json");
  EXPECT_EQ(counts["profiles"].get<int>() + counts["lost_ring"].get<int>(), 100000);
  EXPECT_GT(counts["lost_ring"], 0);
  EXPECT_LE(counts["missing"], counts["lost_ring"]);
  EXPECT_EQ(counts["bad"], 0);
}

TEST_F(Board, CheckFailsWhereSomethingIsMissing) {
  ASSERT_EQ(board({"--line", "512x96", "--count", "20", "--record", "line.slfp"}).status, 0);
  std::string stream = read_text(folder_ / "line.slfp");
  stream.erase(5 * stream.size() / 20 + 100, 1);
  write_text(folder_ / "cut.slfp", stream);
  const Words words{"inspect", "--device", "file:cut.slfp", "--json", "counts.json"};
  EXPECT_EQ(host(words).status, 0);
  EXPECT_EQ(json("counts.json")["profiles"], 19);
  EXPECT_EQ(json("counts.json")["bad"], 1);
  EXPECT_EQ(json("counts.json")["missing"], 1);
  Words checked = words;
  checked.emplace_back("--check");
  const Outcome outcome = host(checked);
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("--check: 19 profiles, 2 faults"), std::string::npos) << outcome.err;
}

// A board of 125 MHz without an encoder: the position of the belt follows from the time stamps and from the length of a
// clock. 10,000 frames a second at 1 m/s are 0.1 mm a frame; a line that stands still is always the same point.
TEST_F(Board, TimeStampsOfAnotherPixelClock) {
  ASSERT_EQ(board({"--line", "512x96", "--line-frames", "1", "--count", "5", "--pixel-clock-hz", "125e6", "--record",
                   "line.slfp"})
                .status,
            0);
  const std::string stream = read_text(folder_ / "line.slfp");
  const std::vector<std::uint8_t> bytes(stream.begin(), stream.end());
  model::PacketView last;
  ASSERT_EQ(model::parse_packet(std::span(bytes).last(bytes.size() / 5), last), model::PacketError::none);
  ASSERT_EQ(last.header.time_stamp, 4U * 12500U);
  ASSERT_EQ(last.header.encoder, 0U);
  std::string yaml = rig::to_yaml(rig::load_rig("light-section"));
  yaml.insert(yaml.find("measure:\n"), "board:\n  pixel_clock_hz: 125e6\n");
  write_text(folder_ / "rig.yaml", yaml);

  // the distance in x, mm, from a point of the first frame to the same point of the last, in cloud.ply
  const auto way = [&](const Words& more) {
    Words words{"inspect", "--device", "file:line.slfp", "--out", "results"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = host(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const std::string cloud = read_text(folder_ / "results" / "cloud.ply");
    const std::size_t points = cloud.find("end_header\n") + std::strlen("end_header\n");
    // x y z difference, red green blue, intensity quality
    constexpr std::size_t kPointBytes = 6 * sizeof(float) + 3;
    const std::size_t frame = (cloud.size() - points) / 5;  // bytes: all five have the same points
    EXPECT_EQ(frame % kPointBytes, 0U);
    const auto x_at = [&](std::size_t at) {
      float x = 0;
      std::memcpy(&x, cloud.data() + at, sizeof x);
      return static_cast<double>(x);
    };
    const double moved = std::abs(x_at(points + 4 * frame) - x_at(points));
    EXPECT_NEAR(json("results/summary.json")["belt"]["mm"].get<double>(), moved, 2e-4);
    return moved;
  };
  EXPECT_NEAR(way({"--rig", "rig.yaml"}), 0.4, 2e-4);
  EXPECT_NEAR(way({"--pixel-clock-hz", "125e6"}), 0.4, 2e-4);
  EXPECT_NEAR(way({"--rig", "rig.yaml", "--pixel-clock-hz", "250e6"}), 0.2, 2e-4) << "the option counts, not the rig";
  EXPECT_NEAR(way({}), 0.4 * 125 / 151.2, 2e-4) << "as if it were a board of 151.2 MHz";
  const Outcome wrong = host({"inspect", "--device", "file:line.slfp", "--pixel-clock-hz", "0"});
  EXPECT_NE(wrong.status, 0);
  EXPECT_NE(wrong.err.find("--pixel-clock-hz"), std::string::npos) << wrong.err;
}

TEST_F(Board, WritesTheOutputsOfAnInspection) {
  ASSERT_EQ(board({"--line", "512x96", "--count", "5", "--record", "line.slfp"}).status, 0);
  const Outcome outcome = host({"inspect", "--device", "file:line.slfp", "--out", "results", "--keep", "3"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* file : {"moments.csv", "profile.csv", "cloud.ply", "height.tiff", "difference.tiff",
                           "difference.png", "summary.json", "report.html"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / "results" / file)) << file;
  }
  EXPECT_NE(outcome.out.find("3 frames (of 5, --keep 3) → results"), std::string::npos) << outcome.out;
  const std::string moments = read_text(folder_ / "results" / "moments.csv");
  EXPECT_EQ(std::count(moments.begin(), moments.end(), '\n'), 1 + 3 * 512);
}

// The line crosses the middle row in column 1: there the surface is the reference itself, whichever is given.
TEST_F(Board, DifferenceFromTheGivenReference) {
  ASSERT_EQ(board({"--line", "512x96", "--count", "1", "--record", "line.slfp"}).status, 0);
  write_text(folder_ / "curve.csv", "y_mm,z_mm\n-90,1165\n90,1165\n");
  ASSERT_EQ(host({"pattern", "--reference", "curve.csv", "--out", "reference"}).status, 0);
  for (const auto& [words, z] : {std::pair<Words, double>{{}, 1167}, {{"--reference", "reference"}, 1165}}) {
    Words all{"inspect", "--device", "file:line.slfp", "--out", "results"};
    all.insert(all.end(), words.begin(), words.end());
    const Outcome outcome = host(all);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const std::string profile = read_text(folder_ / "results" / "profile.csv");
    const std::string first = profile.substr(profile.find('\n') + 1);
    EXPECT_EQ(first.find("1,1,"), 0U);
    std::istringstream fields(first);
    std::string field;
    for (int i = 0; i < 5; ++i) {
      std::getline(fields, field, ',');
    }
    EXPECT_NEAR(std::stod(field), z, 0.05);
  }
}

TEST_F(Board, DiskFull) {
  ASSERT_EQ(board({"--line", "512x96", "--count", "5", "--record", "line.slfp"}).status, 0);
  for (const Words& words : {Words{"inspect", "--device", "file:line.slfp", "--json", "/dev/full"}}) {
    const Outcome outcome = host(words);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("No space left on device"), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(board({"--line", "512x96", "--record", "/dev/full"}).status, 2);
  // A limit on the size of files, instead of a full disk that would have to be made.
  const std::string limited = "ulimit -f 20; trap '' XFSZ; exec \"$0\" inspect --device file:line.slfp --out results";
  const Outcome outcome = run_program("/bin/sh", {"-c", limited, SELFPROJ_PROGRAM}, folder_.path());
  EXPECT_EQ(outcome.status, 2) << outcome.err;
  EXPECT_EQ(folder_.names(), (Words{"line.slfp"})) << "something half written is left";
}

TEST_F(Board, Devices) {
  driver::RingWriter writer(ring_, 16);
  const Outcome listed = host({"devices"});
  EXPECT_EQ(listed.status, 0);
  const auto at = listed.out.find("ring:" + ring_);
  ASSERT_NE(at, std::string::npos) << listed.out;
  EXPECT_NE(listed.out.find("process " + std::to_string(getpid()), at), std::string::npos) << listed.out;
  EXPECT_EQ(host({"devices", "--remove", ring_}).status, 0);
  const Outcome again = host({"devices", "--remove", ring_});
  EXPECT_EQ(again.status, 2);
  EXPECT_EQ(again.err, "selfproj: ring:" + ring_ + ": there is no such ring\n");
}

TEST_F(Board, Errors) {
  ASSERT_EQ(board({"--line", "64x96", "--count", "5", "--record", "small.slfp"}).status, 0);
  write_text(folder_ / "text", "no packets");
  const std::vector<Words> wrong_board{
      {},
      {"--line", "512x96"},
      {"--ring", ring_},
      {"--line", "510x96", "--ring", ring_},
      {"--line", "512", "--ring", ring_},
      {"--line", "512x96x3", "--ring", ring_},
      {"--line", "512x96", "--replay", "small.slfp", "--ring", ring_},
      {"--line", "512x96", "--ring", ring_, "--record", "x"},
      {"--line", "512x96", "--ring", "a/b"},
      {"--line", "512x96", "--ring", ring_, "--slots", "100"},
      {"--line", "512x96", "--ring", ring_, "--rate", "-1"},
      {"--line", "512x96", "--ring", ring_, "--rate", "nan"},
      {"--line", "512x96", "--record", "text/folder"},
      {"--replay", "none", "--ring", ring_},
      {"--replay", "text", "--ring", ring_},
      {"--replay", ".", "--ring", ring_},
  };
  for (const Words& words : wrong_board) {
    const Outcome outcome = board(words);
    EXPECT_EQ(outcome.status, 2) << ::testing::PrintToString(words);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  const std::vector<Words> wrong_inspect{
      {},
      {"--device", "ring:" + ring_},
      {"--device", "file:none"},
      {"--device", "usb:0"},
      {"--device", "sim:"},
      {"--device", "file:small.slfp"},  // of another width than the rig
      {"--device", "file:small.slfp", "--rig", "scanner"},
      {"--device", "file:small.slfp", "--rig", "none.yaml"},
      {"--device", "file:small.slfp", "--out", "text"},
      {"--device", "file:small.slfp", "--reference", "none"},
      {"--device", "file:small.slfp", "--json", "text/folder"},
      {"--device", "file:small.slfp", "--seconds", "-3"},
      {"--device", "file:small.slfp", "--keep", "0"},
  };
  for (Words words : wrong_inspect) {
    words.insert(words.begin(), "inspect");
    const Outcome outcome = host(words);
    EXPECT_EQ(outcome.status, 2) << ::testing::PrintToString(words);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_EQ(folder_.names(), (Words{"small.slfp", "text"}));
}

TEST(DurationHistogram, PercentilesAgainstTheSortedNumbers) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    driver::DurationHistogram histogram;
    std::vector<std::int64_t> all;
    for (int i = random.between(1, 3000); i > 0; --i) {
      const auto ns = static_cast<std::int64_t>(random.bits() >> random.between(2, 63));
      histogram.add(ns);
      all.push_back(ns);
    }
    std::sort(all.begin(), all.end());
    EXPECT_EQ(histogram.longest_ns(), all.back());
    for (const double share : {0.0, 0.5, 0.9, 0.99, 1.0}) {
      const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(all.size())));
      const std::int64_t exact = all[rank == 0 ? 0 : rank - 1];
      EXPECT_GE(histogram.percentile_ns(share), exact);
      EXPECT_LE(histogram.percentile_ns(share), exact + exact / 32);
    }
  }
  EXPECT_EQ(driver::DurationHistogram().percentile_ns(0.5), 0);
}

}  // namespace
}  // namespace selfproj::test
