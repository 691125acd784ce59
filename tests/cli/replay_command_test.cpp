// Tests selfproj board replay and board source from the command line.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/driver/etherbone.h"
#include "host/images/image_files.h"
#include "host/images/prepared_images.h"
#include "model/replay.h"
#include "tests/cli/program.h"
#include "tests/support/network_board.h"

namespace selfproj::test {
namespace {

using Words = std::vector<std::string>;

// Files arrive at the board in natural order, turned as the options say.
TEST(ReplayCommand, ImagesAndSources) {
  const ScratchFolder folder;
  const int process = getpid();
  const std::string host = "127.78." + std::to_string(process / 250 % 250) + "." + std::to_string(process % 250 + 1);
  ReplayBoard board({.sources = 0b101, .replay = {.columns = 64, .rows = 48}}, 5, 1, host,
                    {.etherbone = driver::kEtherbonePort, .replay = spec::kReplayPort});
  const auto command = [&](const std::string& device, Words words) {
    words.insert(words.begin(), "board");
    words.insert(words.begin() + 2, {"--device", device});
    return run_program(SELFPROJ_PROGRAM, words, folder.path());
  };
  const std::string uri = "udp:" + host;
  std::vector<model::ReplayFrame> sent;
  std::filesystem::create_directory(folder / "images");
  for (int i = 1; i <= 11; ++i) {
    images::Image image{
        .rows = 16, .columns = 8, .pixels = std::vector<std::uint8_t>(128, static_cast<std::uint8_t>(i))};
    image.pixels[8] = 200;  // second row
    write_text(folder / "images" / ("img" + std::to_string(i) + ".png"), images::encode_png(image));
    sent.push_back({.columns = 16, .rows = 8, .pixels = images::transposed(image).pixels});
  }
  const Words replay{"replay", "--transpose", "images"};
  EXPECT_EQ(command(uri, replay).err,
            "selfproj: " + uri + ": this board is stopped and drops frames; start it with selfproj board start\n");
  EXPECT_EQ(command(uri, {"start"}).err, "");
  EXPECT_EQ(command(uri, replay).err,
            "selfproj: images/img1.png: gives frames of 16 x 8 pixels, and the board is set to 512 x 96\n");
  EXPECT_EQ(command(uri, {"set", "size.columns=16", "size.rows=8"}).err, "");
  const Outcome outcome = command(uri, replay);
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.out.find(uri + ": 11 frames left as video; "), 0U) << outcome.out;
  EXPECT_EQ(command(uri, {"source"}).out, uri + ": frames of the source camera\n");
  EXPECT_EQ(command(uri, {"source", "replay"}).out, uri + ": frames of the source replay\n");
  EXPECT_NE(command(uri, {"source", "test-camera"}).err.find(": the board refuses this source of frames"),
            std::string::npos);
  EXPECT_EQ(command("bar:bar", {"source", "camera"}).err,
            "selfproj: bar:bar: is no board on the network; use udp:HOST\n");
  EXPECT_EQ(command(uri, {"source", "sensor"}).status, 2);
  board.stop();
  EXPECT_TRUE(board.frames() == sent);
}

}  // namespace
}  // namespace selfproj::test
