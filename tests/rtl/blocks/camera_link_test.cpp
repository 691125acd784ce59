// Tests the front end for Camera Link with words: a camera with gaps, lines of any length, links that lose their lock,
// and a board that is too slow; and the training of the deserializer with samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "Vsp_camera_link_medium_ports.h"
#include "Vsp_camera_link_one_ports.h"
#include "Vsp_camera_link_three_ports.h"
#include "Vsp_camera_link_two_ports.h"
#include "tests/rtl/blocks/camera_link_bench.h"
#include "tests/rtl/blocks/camera_link_words.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// Frames of any shape come whole, with boards that are faster and slower than the links.
template <typename Dut>
void expect_every_beat_of_links(int taps, int bits) {
  for_cases(12, [&](Random& random, std::uint64_t seed) {
    const std::int64_t board = taps == 4 ? random.between(400, 999) : random.between(300, 1000 * 4 / taps - 20);
    CameraLinkBench<Dut> bench(seed, taps, bits, board, random.between(0, 2000), random.chance(50) ? 0 : 30);
    bench.forget();
    for (int frame = 0; frame < 15; ++frame) {
      bench.send_any();
    }
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 0);
    EXPECT_EQ(bench.overruns() + bench.apart() + bench.lost(), 0);
  });
}
TEST(CameraLink, OneTap) { expect_every_beat_of_links<Vsp_camera_link_one>(1, 10); }
TEST(CameraLink, TwoTaps) { expect_every_beat_of_links<Vsp_camera_link_two>(2, 12); }
TEST(CameraLink, ThreeTaps) { expect_every_beat_of_links<Vsp_camera_link_three>(3, 8); }
TEST(CameraLink, Medium) { expect_every_beat_of_links<Vsp_camera_link_medium>(4, 8); }

// Links that lose their lock: what they send meanwhile is lost, and the frames that it belongs to end there.
template <typename Dut>
void expect_cuts(int taps, int bits) {
  int broken = 0;
  for_cases(12, [&](std::uint64_t seed) {
    Random random(seed + 1000);
    CameraLinkBench<Dut> bench(seed, taps, bits, random.between(400, 700), random.between(0, 900),
                               random.chance(50) ? 0 : 20);
    bench.forget();
    for (int frame = 0; frame < 30; ++frame) {
      bench.send_any();
    }
    int losses = 0;
    while (bench.sending()) {
      bench.clocks(random.between(30, 400));
      bench.lose_lock(taps == 4 ? random.between(0, 1) : 0, random.between(1, 40));
      ++losses;
      bench.clocks(120);
    }
    bench.drain();
    broken += bench.expect_frames_sent();
    EXPECT_EQ(bench.lost(), losses);
    EXPECT_EQ(bench.overruns(), 0);
  });
  if (runs_all_cases()) {
    EXPECT_GT(broken, 20);
  }
}
TEST(CameraLink, AFrameEndsWhereTheLockIsLost) {
  expect_cuts<Vsp_camera_link_one>(1, 10);
  expect_cuts<Vsp_camera_link_three>(3, 8);
}
TEST(CameraLink, MediumEndsAFrameWhereOneLinkIsLost) { expect_cuts<Vsp_camera_link_medium>(4, 8); }

// A board too slow: each frame comes whole, or it is the beginning of one, and counted. Both links of Medium count.
template <typename Dut>
void expect_overruns(int taps) {
  int cut_off = 0;
  int whole = 0;
  for_cases(12, [&](Random& random, std::uint64_t seed) {
    CameraLinkBench<Dut> bench(seed, taps, 8, random.between(1500, 3000));
    bench.forget();
    for (int frame = 0; frame < 30; ++frame) {
      bench.send({.rows = random.between(2, 7),
                  .columns = taps * random.between(taps == 4 ? 10 : 4, 30),
                  .max_gap = random.chance(50) ? 2 : 60});
      bench.all_may_break();
    }
    bench.drain();
    const int broken = bench.expect_frames_sent();
    EXPECT_GE(bench.overruns(), broken);
    EXPECT_LE(bench.overruns(), taps == 4 ? 2 * broken : broken);
    EXPECT_EQ(bench.lost(), 0);
    cut_off += broken;
    whole += 30 - broken;
  });
  if (runs_all_cases()) {
    EXPECT_GT(cut_off, 50);
    EXPECT_GT(whole, 50);
  }
}
TEST(CameraLink, AFrameThatIsTooFastIsCutOffAndCounted) { expect_overruns<Vsp_camera_link_three>(3); }
TEST(CameraLink, MediumCutsAFrameThatIsTooFast) { expect_overruns<Vsp_camera_link_medium>(4); }

// A board that is so slow that it takes nothing before a line has ended: a line of as many beats as the FIFO has places
// comes whole, and of a longer one just as many beats.
template <typename Dut>
void expect_places(int taps, int places) {
  for_cases(6, [&](Random& random, std::uint64_t seed) {
    CameraLinkBench<Dut> bench(seed, taps, 8, 20'000, random.between(0, 900));
    const auto line = [&](int beats) {
      bench.forget();
      bench.send({.rows = 1, .columns = (4 * beats + taps - 1) / taps * taps});
      bench.all_may_break();
      // Y comes two clocks of the board later, so that X and Y tell their overruns in different clocks.
      bench.words(1).insert(bench.words(1).begin(), 45, LinkCamera::Sent{});
      bench.drain(60);
      const int broken = bench.expect_frames_sent();
      EXPECT_EQ(broken, beats > places ? 1 : 0) << beats << " beats";
      EXPECT_EQ(bench.beats().size(), static_cast<std::size_t>(std::min(beats, places)));
      return broken;
    };
    int broken = 0;
    for (int round = 0; round < 12; ++round) {
      line(random.between(1, places - 1));
      line(places);
      if (round % 3 == 2) {
        broken += line(places + random.between(1, 2));
      }
    }
    EXPECT_EQ(bench.overruns(), taps == 4 ? 2 * broken : broken);
    EXPECT_EQ(bench.lost(), 0);
  });
}
TEST(CameraLink, TheFifoHoldsAsManyBeatsAsItHasPlaces) { expect_places<Vsp_camera_link_three>(3, 16); }
TEST(CameraLink, TheFifosOfMediumHoldAsManyBeatsAsTheyHavePlaces) { expect_places<Vsp_camera_link_medium>(4, 32); }

// A word, the end of a line, a whole frame, or the last line of a frame that only one link has: the frame ends there,
// and the next one is whole.
TEST(CameraLink, MediumNoticesLinksThatDoNotAgree) {
  for_cases(30, [&](Random& random, std::uint64_t seed) {
    CameraLinkBench<Vsp_camera_link_medium> bench(seed, 4, 8, random.between(400, 900), random.between(0, 900));
    bench.forget();
    bench.send_any();
    bench.drain();
    const int kind = static_cast<int>(seed % 5);
    const int beats = kind < 3 ? 10 : 6;  // of a line
    bench.send({.rows = 3, .columns = 4 * beats, .max_gap = kind < 3 ? 4 : 1});
    const std::size_t link = kind < 3 ? random.chance(50) : static_cast<std::size_t>(kind - 3);
    std::deque<LinkCamera::Sent>& words = bench.words(link);
    const auto of_line = [link](const LinkCamera::Sent& sent) {
      return sent.links[link].frame && sent.links[link].line;
    };
    Frame& due = bench.frame(1);
    std::vector<std::size_t> pixels;  // where the words with pixels are
    for (std::size_t at = 0; at < words.size(); ++at) {
      if (of_line(words[at])) {
        pixels.push_back(at);
      }
    }
    const auto beat = static_cast<std::size_t>(random.between(10, 18));
    if (kind == 0) {  // a word has no pixel: noticed at the end of the line, and until then the link is one pixel ahead
      words[pixels[beat]].links[link].data = false;
      const std::uint32_t mask = link == 0 ? 0xFFFFFFU : 0xFF000000U;
      for (std::size_t after = beat; after < 18; ++after) {
        due[after].pixels = (due[after].pixels & ~mask) | (due[after + 1].pixels & mask);
      }
      due.resize(18);
    } else if (kind == 1) {  // the rest of a line is missing
      for (std::size_t after = beat + 1; after < 20; ++after) {
        words[pixels[after]].links[link].line = false;
      }
      due.resize(beat);
    } else if (kind == 2) {  // the frame is missing
      for (LinkCamera::Sent& sent : words) {
        sent.links[link].frame = false;
      }
      due.clear();
    } else {  // the last line is missing, and the next frame comes at once
      for (std::size_t after = 12; after < 18; ++after) {
        words[pixels[after]].links[link].line = false;
      }
      due.resize(12);
    }
    if (kind < 3 && random.chance(50)) {
      bench.drain();
    }
    if (random.chance(50)) {  // after that, a frame whose first line has one word on one link: a start and an end
      std::deque<LinkCamera::Sent>& more = bench.words(random.chance(50));
      const std::size_t before = more.size();
      bench.send({.rows = 2, .columns = 96, .max_gap = 1});
      bench.shorten_line(more, before);
      bench.frame(2).clear();
    }
    for (int frame = 0; frame < 3; ++frame) {
      bench.send_any();
    }
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 0);
    EXPECT_GE(bench.apart(), 1);
    EXPECT_EQ(bench.lost(), 0);
  });
}

// Resets in the middle of a frame: what comes after begins with a whole frame. `standing`: the links' clocks stand
// meanwhile, so the links learn of the reset when they run again, in the middle of a frame.
template <typename Dut>
void expect_whole_frames_after_a_reset(int taps, bool standing) {
  for_cases(12, [&](Random& random, std::uint64_t seed) {
    CameraLinkBench<Dut> bench(seed, taps, 8, random.between(400, 900), random.between(0, 900));
    for (int round = 0; round < 3; ++round) {
      bench.send({.rows = 4, .columns = 60, .max_gap = 3});
      bench.clocks(random.between(0, 60));
      bench.stopped = standing;
      bench.clocks(standing ? random.between(0, 20) : 0);
      bench.reset(standing ? random.between(2, 6) : 4);
      bench.forget();
      bench.clocks(standing ? random.between(0, 40) : 0);
      bench.stopped = false;
      bench.drain();
      EXPECT_TRUE(bench.beats().empty()) << "the rest of a frame";
      bench.forget();
      bench.send_any();
      bench.drain();
      EXPECT_EQ(bench.expect_frames_sent(), 0);
    }
    EXPECT_EQ(bench.lost(), 0);
  });
}
TEST(CameraLink, AfterAResetTheNextFrameIsTheFirst) {
  expect_whole_frames_after_a_reset<Vsp_camera_link_medium>(4, false);
}
TEST(CameraLink, AResetWhileTheClockStands) { expect_whole_frames_after_a_reset<Vsp_camera_link_three>(3, true); }
TEST(CameraLink, AResetWhileTheClocksOfMediumStand) {
  expect_whole_frames_after_a_reset<Vsp_camera_link_medium>(4, true);
}

}  // namespace
}  // namespace selfproj::test
