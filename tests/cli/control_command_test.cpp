// Tests selfproj board, and that inspect sets up the board, from the command line.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "model/register_file.h"
#include "sim/board/etherbone_board.h"
#include "sim/board/packet_recording.h"
#include "tests/cli/program.h"
#include "tests/support/board_registers.h"

namespace selfproj::test {
namespace {

using Words = std::vector<std::string>;

class BoardCommand : public ::testing::Test {
 protected:
  void SetUp() override { write_text(folder_ / "bar", register_bytes()); }

  [[nodiscard]] Outcome board(Words words) const {
    words.insert(words.begin(), "board");
    words.insert(words.begin() + 2, {"--device", "bar:bar"});
    return run_program(SELFPROJ_PROGRAM, words, folder_.path());
  }
  [[nodiscard]] Outcome run(const Words& words) const { return run_program(SELFPROJ_PROGRAM, words, folder_.path()); }

  ScratchFolder folder_;
};

TEST_F(BoardCommand, InfoStatusSet) {
  EXPECT_NE(board({"info"}).out.find("largest image    2048 x 1023 pixels"), std::string::npos);
  EXPECT_EQ(board({"set", "size.columns=640", "size.rows=48", "measure.mode=grey-over", "measure.threshold=60"}).err,
            "");
  const std::string status = board({"status"}).out;
  EXPECT_NE(status.find("0x14 size             0x00300280  columns=640  rows=48\n"), std::string::npos) << status;
  EXPECT_NE(status.find("threshold=60  mode=2"), std::string::npos) << status;
  EXPECT_EQ(board({"start"}).status, 0);
  EXPECT_NE(board({"status"}).out.find("run=1  hold=0"), std::string::npos);
  EXPECT_EQ(board({"stop"}).status, 0);
  EXPECT_EQ(board({"trigger", "--period", "15120", "--camera-delay", "9", "--patterns", "4"}).out,
            "bar:bar: pulses every 15120 clocks, 4 patterns\n");
  EXPECT_NE(board({"status"}).out.find("0x20 trigger_control  0x00030001"), std::string::npos);
  EXPECT_EQ(board({"trigger", "--off"}).status, 0);
}

// A file takes every value, and its clock stands still.
TEST_F(BoardCommand, SelfTestOfAFileFails) {
  const std::string before = read_text(folder_ / "bar");
  const Outcome outcome = board({"selftest"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.err, "selfproj: bar:bar: 4 of 8 checks failed\n");
  EXPECT_NE(outcome.out.find("good  patterns in timeout\n"), std::string::npos);
  EXPECT_EQ(read_text(folder_ / "bar"), before);
}

TEST_F(BoardCommand, Errors) {
  const auto error = [&](const Words& words) {
    const Outcome outcome = board(words);
    EXPECT_EQ(outcome.status, 2);
    return outcome.err;
  };
  EXPECT_EQ(error({"set", "size=x"}), "selfproj: size=x: 'x' is not a whole number from 0 to 4294967295\n");
  EXPECT_EQ(error({"set", "size"}), "selfproj: size: is not an assignment such as size.columns=512\n");
  EXPECT_EQ(error({"set", "frames=1"}), "selfproj: bar:bar: register frames can only be read\n");
  EXPECT_EQ(error({"set", "decode.bits=1"}),
            "selfproj: bar:bar: this board has no register decode: it has no Gray-code decoder\n");
  write_text(folder_ / "bar", std::string(4096, '\xFF'));
  EXPECT_EQ(error({"info"}), "selfproj: bar:bar: no selfproj board is there: its first register is 0xFFFFFFFF\n");
  EXPECT_EQ(run({"board", "info", "--device", "ring:a"}).err,
            "selfproj: ring:a: has no control of a board beside it; use bar:PATH, litepcie:PATH or udp:HOST\n");
}

// The same commands over the network, to a board at an address of its own.
TEST_F(BoardCommand, OverTheNetwork) {
  const int process = getpid();
  const std::string host = "127.77." + std::to_string(process / 250 % 250) + "." + std::to_string(process % 250 + 1);
  sim::PlayedRegisters registers(1e8);
  const sim::EtherboneServer server(host, host, [&](bool write, std::uint32_t address, std::uint32_t data) {
    return registers.access(write, address, data);
  });
  const auto remote = [&](Words words) {
    words.insert(words.begin(), "board");
    words.insert(words.begin() + 2, {"--device", "udp:" + host});
    return run(words);
  };
  std::string line = "udp:" + host;
  line.resize(28, ' ');
  EXPECT_NE(run({"board", "list", host}).out.find(line + " a board of this specification\n"), std::string::npos);
  EXPECT_NE(remote({"info"}).out.find("largest image    2048 x 1023 pixels"), std::string::npos);
  EXPECT_EQ(remote({"set", "size.columns=640", "size.rows=48"}).err, "");
  EXPECT_EQ(remote({"set", "size.columns=6"}).err,
            "selfproj: udp:" + host + ": the board refuses 0x00300006 in register size\n");
  EXPECT_EQ(remote({"selftest"}).status, 0);
  registers.set_frames(77);
  const std::string status = remote({"status"}).out;
  EXPECT_NE(status.find("columns=640  rows=48\n"), std::string::npos) << status;
  EXPECT_NE(status.find("count=77"), std::string::npos) << status;
  const Outcome nobody = run({"board", "info", "--device", "udp:127.0.0.9"});
  EXPECT_EQ(nobody.status, 2);
  EXPECT_EQ(nobody.err, "selfproj: udp:127.0.0.9: no board answers\n");
}

// A board that plays packets is one that sends such packets.
TEST_F(BoardCommand, APlayedBoard) {
  const auto is_strongest = model::Select::strongest;
  const model::BoardBuild tall = sim::moving_line(1500, 4096, 2, {.threshold = 50, .select = is_strongest}).build();
  EXPECT_EQ(tall.max_rows, spec::kRowLimit);
  EXPECT_EQ(tall.max_columns, spec::kColumnLimit);
  EXPECT_TRUE(tall.runs);
  const model::BoardBuild usual = sim::moving_line(96, 512, 2, {.threshold = 50}).build();
  EXPECT_EQ(usual.max_rows, spec::kMaxRows);
  EXPECT_EQ(usual.max_columns, spec::kMaxColumns);
  EXPECT_FALSE(usual.runs);
}

// inspect gives the board the rig's settings, and leaves it stopped as it was. It notes what these packets have not.
TEST_F(BoardCommand, InspectAppliesTheRig) {
  const Outcome made =
      run_program(SELFPROJ_SIM_PROGRAM, {"board", "--line", "512x96", "--threshold", "20", "--record", "line.slfp"},
                  folder_.path());
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(board({"set", "size.columns=64", "size.rows=3"}).status, 0);
  const Outcome outcome = run({"inspect", "--device", "file:line.slfp", "--control", "bar:bar", "--count", "5"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const std::string status = board({"status"}).out;
  EXPECT_NE(status.find("columns=512  rows=96"), std::string::npos) << status;
  EXPECT_NE(status.find("mode=2"), std::string::npos) << status;
  EXPECT_NE(status.find("run=0  hold=0"), std::string::npos) << status;
  // So are the strongest run and the rows that count. A board that was built without runs is refused.
  std::string rig = run({"rig", "light-section"}).out;
  rig.replace(rig.find("  mode: grey-over\n"), 18,
              "  mode: grey-over\n  runs: {gap_rows: 2, ambiguous_from: 0.5}\n"
              "  window: {first_row: 3, last_row: 90}\n");
  write_text(folder_ / "runs.yaml", rig);
  const Words inspect{"inspect", "--rig", "runs.yaml", "--device", "file:line.slfp", "--count", "5", "--control"};
  const auto with = [&](const std::string& control) {
    Words words = inspect;
    words.push_back(control);
    return run(words);
  };
  EXPECT_EQ(with("bar:bar").err,
            "selfproj: bar:bar: this board is built without the strongest run; select all lit pixels\n");
  model::BoardBuild build;
  build.runs = true;
  write_text(folder_ / "runs", register_bytes(build));
  EXPECT_EQ(with("bar:runs").err,
            "selfproj: file:line.slfp: its packets are of select all, and the rig says strongest (measure.runs)\n");
  const std::string told = run({"board", "status", "--device", "bar:runs"}).out;
  EXPECT_NE(told.find("select=1  gap=2"), std::string::npos) << told;
  EXPECT_NE(told.find("first=3  last=90"), std::string::npos) << told;
  // The input is no output, and the registers' file is no input that an output may replace.
  EXPECT_EQ(run({"inspect", "--device", "file:line.slfp", "--control", "bar:bar", "--json", "bar"}).status, 2);
}

// What record keeps is what came, and images finds the code images in it.
TEST_F(BoardCommand, RecordAndImages) {
  const Outcome made = run_program(SELFPROJ_SIM_PROGRAM,
                                   {"cosim", "--engine", "model", "--rig", "scanner", "--scene", "fist", "--bits", "2",
                                    "--count", "4", "--packets", "codes.packets"},
                                   folder_.path());
  ASSERT_EQ(made.status, 0) << made.err;
  const Outcome recorded = run({"record", "--device", "file:codes.packets", "--out", "copy", "--check"});
  EXPECT_EQ(recorded.status, 0) << recorded.err;
  EXPECT_EQ(read_text(folder_ / "copy"), read_text(folder_ / "codes.packets"));
  EXPECT_EQ(run({"record", "--device", "file:copy", "--out", "part", "--count", "3"}).out.find("3 packets, "), 0U);
  EXPECT_EQ(run({"images", "--device", "file:copy", "--out", "codes", "--check"}).status, 0);
  EXPECT_EQ(read_text(folder_ / "codes" / "code_00000003.png").substr(1, 3), "PNG");
  EXPECT_EQ(read_text(folder_ / "codes" / "measurable_00000003.png").substr(1, 3), "PNG");
  // A line is missing: the image is left out and counted, and nothing is written without an image.
  const Outcome none = run({"images", "--device", "file:part", "--out", "none"});
  EXPECT_EQ(none.status, 1);
  EXPECT_NE(none.err.find("no complete image came, and nothing is written"), std::string::npos) << none.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none"));
  EXPECT_EQ(run({"record", "--device", "file:copy", "--out", "copy"}).status, 2);
}

}  // namespace
}  // namespace selfproj::test
