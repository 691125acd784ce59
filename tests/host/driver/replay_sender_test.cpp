// Tests the host of replay against the model of the board, over a network that loses, doubles and reorders datagrams.
#include "host/driver/replay_sender.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/driver/control.h"
#include "host/driver/etherbone.h"
#include "model/spec/generated/register_table.h"
#include "tests/support/error_of.h"
#include "tests/support/network_board.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr model::VideoBuild kBuild = {.sources = 0b111, .replay = {.columns = 512, .rows = 127}};

std::unique_ptr<driver::RegisterPort> port_of(const ReplayBoard& board) {
  return driver::make_etherbone_port(board.etherbone_place(), {.patience = std::chrono::milliseconds(200)});
}

model::ReplayFrame random_frame(Random& random, int columns, int rows) {
  model::ReplayFrame frame{.columns = columns, .rows = rows};
  frame.pixels = random.bytes(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  return frame;
}

model::ImageView view(const model::ReplayFrame& frame) {
  return {frame.pixels.data(), frame.rows, frame.columns, frame.columns};
}

// Every frame arrives once, as it was sent, and in order, whatever the network does. Then the board shows again what it
// showed before.
TEST(ReplaySender, EveryFrameThroughABadNetwork) {
  for (const auto& [percent, before] : {std::pair{0, spec::kSourceCamera}, {10, spec::kSourceTestCamera}}) {
    Random random(1);
    ReplayBoard board(kBuild, percent, 7);
    const std::unique_ptr<driver::RegisterPort> port = port_of(board);
    EXPECT_EQ(port->write(spec::kRegControl, 1), driver::Written::applied);
    driver::set_video_source(*port, before);
    std::vector<model::ReplayFrame> sent;
    for (int session = 0; session < 2; ++session) {
      driver::ReplaySender sender(*port, "127.0.0.3", {.port = board.replay_port()});
      for (int i = 0; i < 25; ++i) {
        sent.push_back(random_frame(random, 4 * random.between(1, 128), random.between(1, 127)));
        sender.send(view(sent.back()));
      }
      EXPECT_EQ(sender.frames(), 25U);
      EXPECT_EQ(sender.repeated() > 0, percent > 0);
      EXPECT_GE(sender.datagrams(), 25U);
      sender.end();
    }
    board.stop();
    EXPECT_TRUE(board.frames() == sent);
    EXPECT_EQ(board.source(), before);
    EXPECT_EQ(board.lost() > 10, percent > 0);
  }
}

// Of nearly 400 datagrams one in ten is lost, so that a frame is sent again dozens of times, from another place each
// time. Twelve tries are enough as long as the board makes progress.
TEST(ReplaySender, AFrameIsSentAgainAsLongAsThereIsProgress) {
  Random random(1);
  ReplayBoard board(kBuild, 10, 7);
  const std::unique_ptr<driver::RegisterPort> port =
      driver::make_etherbone_port(board.etherbone_place(), {.patience = std::chrono::milliseconds(20)});
  EXPECT_EQ(port->write(spec::kRegControl, 1), driver::Written::applied);
  driver::ReplaySender sender(*port, "127.0.0.3", {.port = board.replay_port(), .datagram_bytes = 128, .tries = 12});
  const model::ReplayFrame frame = random_frame(random, 512, 80);
  sender.send(view(frame));
  EXPECT_GT(sender.repeated(), 400U);
  board.stop();
  EXPECT_EQ(board.frames(), std::vector<model::ReplayFrame>{frame});
}

TEST(ReplaySender, Errors) {
  Random random(1);
  {
    const ReplayBoard none({}, 0, 1);
    const std::unique_ptr<driver::RegisterPort> port = port_of(none);
    EXPECT_NE(error_of([&] { const driver::ReplaySender sender(*port, "127.0.0.3"); }).find("this board has no replay"),
              std::string::npos);
    EXPECT_NE(error_of([&] { driver::set_video_source(*port, spec::kSourceReplay); }).find("the board refuses"),
              std::string::npos);
  }
  const ReplayBoard board(kBuild, 0, 1);
  const std::unique_ptr<driver::RegisterPort> port = port_of(board);
  driver::ReplaySender sender(*port, "127.0.0.3", {.port = board.replay_port(), .tries = 3});
  EXPECT_NE(error_of([&] { sender.send(view(random_frame(random, 516, 4))); }).find("the largest has 512 x 127"),
            std::string::npos);
  EXPECT_NE(error_of([&] { sender.send(view(random_frame(random, 6, 4))); }).find("no multiple of 4"),
            std::string::npos);
  // Nobody has started it.
  EXPECT_NE(error_of([&] { sender.send(view(random_frame(random, 8, 4))); }).find("takes no frames from this host"),
            std::string::npos);
}

}  // namespace
}  // namespace selfproj::test
