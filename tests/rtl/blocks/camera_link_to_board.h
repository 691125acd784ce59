// A camera of 96 x 512 pixels at more than 10,000 frames a second, from the bits of its LVDS lanes on: through the
// front end for Camera Link Full or 80 bit and the board, whose packets must be those of the model.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_TO_BOARD_H
#define SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_TO_BOARD_H

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "Vboard.h"
#include "selfproj/model/board.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"
#include "sim/board/board_device.h"
#include "tests/rtl/blocks/camera_link_bench.h"
#include "tests/rtl/blocks/camera_link_lanes.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

inline constexpr int kRows = 96;
inline constexpr int kColumns = 512;
inline constexpr std::int64_t kCameraBit = 1680;  // ps: 85.03 MHz
inline constexpr int kFrameWords = 8500;          // of the camera: 10,003 frames a second
inline constexpr double kFramesPerSecond = 10'000;

struct CameraRun {
  std::uint64_t frames = 0;       // with packets equal to the model's
  std::uint64_t clocks = 0;       // of the board, for these frames
  std::uint64_t broken = 0;       // that the board counted
  std::uint64_t interrupted = 0;  // frames in which a cable was pulled

  // By the clocks of camera and board, of all frames that were sent.
  [[nodiscard]] double frames_per_second() const {
    const double seconds = static_cast<double>(clocks) * static_cast<double>(sim::BoardDeviceOptions{}.video_period_ps);
    return static_cast<double>(frames + interrupted) / (seconds * 1e-12);
  }
};

// A line of light over every column, and noise.
inline std::vector<std::uint8_t> image_of_a_line(Random& random) {
  std::vector<std::uint8_t> image(static_cast<std::size_t>(kRows) * kColumns);
  for (std::uint8_t& pixel : image) {
    pixel = static_cast<std::uint8_t>(random.bits() & 31U);
  }
  const int from = random.between(12, 80);
  for (int column = 0; column < kColumns; ++column) {
    const int row = from + (random.chance(10) ? random.between(-9, 9) : (column * 7 / kColumns));
    for (int off = -2; off <= 2; ++off) {
      image[static_cast<std::size_t>((row + off) * kColumns + column)] =
          static_cast<std::uint8_t>(random.between(150, 255));
    }
  }
  return image;
}

// Plays this many frames. `pulled`: in this frame the cables of these links (bits 0 to 2) are pulled and put back; 0:
// none. Lines follow each other after `gap` words.
template <typename Dut>
void play_camera(std::uint64_t seed, int taps, int frames, CameraRun& run, int gap, int pulled = -1,
                 unsigned links = 0) {
  Random random(seed);
  const auto period = static_cast<std::int64_t>(sim::BoardDeviceOptions{}.video_period_ps);
  LvdsBench<Dut> camera(seed, taps, 1, kCameraBit, period);
  camera.disturb();
  ASSERT_TRUE(camera.lock());

  std::deque<std::vector<std::uint8_t>> images;  // whose packets have not come
  std::uint64_t sequence = 0;
  std::uint64_t whole = 0;
  sim::BoardDevice<Vboard> board({.seed = seed});
  board.on_clock([&](std::uint64_t /*clock*/) {
    camera.board_clock();
    for (const Beat& beat : camera.beats()) {
      model::VideoBeat video{.start = beat.start, .line_end = beat.end};
      for (std::size_t i = 0; i < spec::kPixelsPerBeat; ++i) {
        video.pixels[i] = static_cast<std::uint8_t>(beat.pixels >> (8 * i));
      }
      board.send(video);
    }
    camera.clear_beats();
  });
  const model::Measure measure{.mode = model::Mode::grey, .threshold = 128};
  const std::size_t bytes = model::moments_payload_bytes(measure.mode, kColumns);
  board.on_packet([&](std::span<const std::uint8_t> packet_bytes) {
    model::PacketView packet;
    ASSERT_EQ(model::parse_packet(packet_bytes, packet), model::PacketError::none);
    ASSERT_EQ(packet.header.lost, 0U);
    ASSERT_EQ(packet.header.sequence, sequence++);
    if (packet.status != 0) {
      return;  // of the frame in which a cable was pulled; the board counts it
    }
    model::Moments moments;
    moments.resize(kColumns);
    std::vector<std::uint8_t> payload(bytes);
    const auto equals = [&] {  // the packet and the first image
      const model::ImageView image{images.front().data(), kRows, kColumns, kColumns};
      model::column_moments(image, measure.mode, measure.threshold, moments.view());
      model::pack_moments(measure.mode, kColumns, moments.view(), payload.data());
      return std::equal(packet.payload.begin(), packet.payload.end(), payload.begin(), payload.end());
    };
    ASSERT_FALSE(images.empty());
    if (pulled >= 0 && !equals()) {  // the image before this one was lost
      images.pop_front();
      ASSERT_FALSE(images.empty());
    }
    EXPECT_TRUE(equals()) << "packet " << packet.header.sequence;
    images.pop_front();
    ++whole;
  });
  board.write(
      model::BoardSettings{.columns = kColumns, .rows = kRows, .mode = measure.mode, .threshold = measure.threshold});

  const std::uint64_t begin = board.clock();
  for (int frame = 0; frame < frames && !::testing::Test::HasFailure(); ++frame) {
    images.push_back(image_of_a_line(random));
    camera.send({.rows = kRows,
                 .columns = kColumns,
                 .min_gap = gap,
                 .max_gap = gap,
                 .least_words = kFrameWords,
                 .pixels = images.back().data()});
    if (frame == pulled) {
      board.run(static_cast<std::uint64_t>(random.between(2000, 9000)));
      for (int link = 0; link < kLinks; ++link) {
        if ((links >> static_cast<unsigned>(link) & 1U) != 0) {
          camera.stop(link, 40);
        }
      }
      ++run.interrupted;
    }
    while (camera.sending()) {
      board.run(1);
    }
  }
  run.clocks += board.clock() - begin;
  board.drain(3000);
  run.frames += whole;
  run.broken += board.read(spec::kRegBroken);
  EXPECT_EQ(board.read(spec::kRegBroken), pulled >= 0 ? 1U : 0U);
  EXPECT_EQ(whole + (pulled >= 0 ? 1U : 0U), static_cast<std::uint64_t>(frames));
  EXPECT_EQ(board.read(spec::kRegLostMoments), 0U);
  EXPECT_EQ(camera.overruns(), 0);
  EXPECT_EQ(camera.lost() > 0, links != 0);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_TO_BOARD_H
