// Tests the front end for Camera Link Full (8 taps) and 80 bit (10 taps, or 8 of 10 bits) with words: three links that
// come at different times, lines that come faster than their beats leave, links that lose their lock, and damaged
// words.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string_view>
#include <vector>

#include "Vsp_camera_link_eight_tens_ports.h"
#include "Vsp_camera_link_eight_tens_short_ports.h"
#include "Vsp_camera_link_eighty_ports.h"
#include "Vsp_camera_link_eighty_short_ports.h"
#include "Vsp_camera_link_full_ports.h"
#include "Vsp_camera_link_full_short_ports.h"
#include "tests/rtl/blocks/camera_link_bench.h"
#include "tests/rtl/blocks/camera_link_words.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// The board's clocks, in thousandths of a word, with which beats leave as fast as words come.
int fast_board(Random& random, int taps) { return random.between(300, 4000 / taps - 20); }

// Lines of any length, and links whose delays differ by as much as is allowed.
template <typename Dut>
void expect_every_beat_of_three(int taps, int bits = 8) {
  for_cases(12, [&](Random& random, std::uint64_t seed) {
    const int board = fast_board(random, taps);
    CameraLinkBench<Dut> bench(seed, taps, bits, board, random.between(0, 13 * board), random.chance(50) ? 0 : 30);
    bench.forget();
    for (int frame = 0; frame < 15; ++frame) {
      bench.send_any(is_eighty(taps, bits) ? 0 : 20);
    }
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 0);
    EXPECT_EQ(bench.overruns() + bench.apart() + bench.lost(), 0);
  });
}
TEST(CameraLinkFull, EveryBeat) { expect_every_beat_of_three<Vsp_camera_link_full>(8); }
TEST(CameraLinkEighty, EveryBeat) { expect_every_beat_of_three<Vsp_camera_link_eighty>(10); }
TEST(CameraLinkEightTens, EveryBeat) { expect_every_beat_of_three<Vsp_camera_link_eight_tens>(8, 10); }

// A board that takes the words of a line more slowly than they come: the FIFO holds what waits.
template <typename Dut>
void expect_the_fifo_holds(int taps, int bits = 8) {
  for_cases(8, [&](Random& random, std::uint64_t seed) {
    const int board = random.between(4000 / taps, 900);
    CameraLinkBench<Dut> bench(seed, taps, bits, board, random.between(0, 13 * board));
    bench.forget();
    for (int frame = 0; frame < 4; ++frame) {
      bench.send({.rows = 10, .columns = taps * random.between(40, 51)});  // fewer than 512 words
      bench.drain(2000);
    }
    EXPECT_EQ(bench.expect_frames_sent(), 0);
    EXPECT_EQ(bench.overruns() + bench.apart() + bench.lost(), 0);
  });
}
TEST(CameraLinkFull, WordsWaitForTheBoard) { expect_the_fifo_holds<Vsp_camera_link_full>(8); }
TEST(CameraLinkEighty, WordsWaitForTheBoard) { expect_the_fifo_holds<Vsp_camera_link_eighty>(10); }
TEST(CameraLinkEightTens, WordsWaitForTheBoard) { expect_the_fifo_holds<Vsp_camera_link_eight_tens>(8, 10); }

// Lines of `columns` pixels, no multiple of the taps, lose what fills their last word; all others are as they were
// sent.
template <typename Dut>
void expect_short_lines(int taps, int columns, int bits = 8) {
  for_cases(10, [&](Random& random, std::uint64_t seed) {
    CameraLinkBench<Dut> bench(seed, taps, bits, fast_board(random, taps), random.between(0, 900));
    bench.forget();
    for (int frame = 0; frame < 15; ++frame) {
      const int words = (columns + taps - 1) / taps;
      const int others = words + (random.chance(50) ? random.between(1, 6) : -random.between(1, 6));
      bench.send({.rows = random.between(1, 6),
                  .columns = random.chance(60) ? columns : taps * others,
                  .max_gap = random.chance(50) ? 1 : 9});
    }
    bench.drain();
    EXPECT_EQ(bench.expect_frames_sent(), 0);
    EXPECT_EQ(bench.overruns() + bench.apart() + bench.lost(), 0);
  });
}
TEST(CameraLinkFull, LinesThatDoNotFillTheirLastWord) { expect_short_lines<Vsp_camera_link_full_short>(8, 212); }
TEST(CameraLinkEighty, LinesThatDoNotFillTheirLastWord) { expect_short_lines<Vsp_camera_link_eighty_short>(10, 216); }
TEST(CameraLinkEightTens, LinesThatDoNotFillTheirLastWord) {
  expect_short_lines<Vsp_camera_link_eight_tens_short>(8, 212, 10);
}

// The FIFO is too small for the lines: each frame comes whole, or it is the beginning of one, and counted once.
template <typename Dut>
void expect_overruns_of_words(int taps, int bits = 8) {
  int cut_off = 0;
  int whole = 0;
  for_cases(12, [&](Random& random, std::uint64_t seed) {
    CameraLinkBench<Dut> bench(seed, taps, bits, random.between(4000 / taps, 990));
    bench.forget();
    for (int frame = 0; frame < 30; ++frame) {
      bench.send({.rows = random.between(2, 7),
                  .columns = taps * random.between(30, 60),
                  .max_gap = random.chance(50) ? 2 : 60});
      bench.all_may_break();
    }
    bench.drain(1000);
    const int broken = bench.expect_frames_sent();
    EXPECT_EQ(bench.overruns(), broken);
    EXPECT_EQ(bench.lost() + bench.apart(), 0);
    cut_off += broken;
    whole += 30 - broken;
  });
  if (runs_all_cases()) {
    EXPECT_GT(cut_off, 50);
    EXPECT_GT(whole, 20);
  }
}
TEST(CameraLinkFull, WordsWithoutRoomEndTheFrame) { expect_overruns_of_words<Vsp_camera_link_full_short>(8); }
TEST(CameraLinkEighty, WordsWithoutRoomEndTheFrame) { expect_overruns_of_words<Vsp_camera_link_eighty_short>(10); }
TEST(CameraLinkEightTens, WordsWithoutRoomEndTheFrame) {
  expect_overruns_of_words<Vsp_camera_link_eight_tens_short>(8, 10);
}

// A board whose clock is slower than that of the links: their own FIFOs fill, which counts as well.
TEST(CameraLinkFull, LinksFasterThanTheBoardAreCounted) {
  int cut_off = 0;
  for_cases(6, [&](Random& random, std::uint64_t seed) {
    CameraLinkBench<Vsp_camera_link_full_short> bench(seed, 8, 8, random.between(2500, 4000));
    bench.forget();
    for (int frame = 0; frame < 10; ++frame) {
      bench.send({.rows = 3, .columns = 8 * random.between(30, 90), .max_gap = 4});
      bench.all_may_break();
      bench.drain(400);
    }
    const int broken = bench.expect_frames_sent();
    EXPECT_GE(bench.overruns(), broken);
    EXPECT_EQ(bench.lost(), 0);
    cut_off += broken;
  });
  if (runs_all_cases()) {
    EXPECT_GT(cut_off, 20);
  }
}

// A board that is so slow that it takes nothing before a line has ended: the links' FIFOs hold a line of 16 words, and
// of a longer one as many. Y and Z come some clocks of the board later, so that all links tell their overruns.
template <typename Dut>
void expect_places_of_links(int taps, int bits = 8) {
  constexpr int kPlaces = 16;
  for_cases(4, [&](Random& random, std::uint64_t seed) {
    CameraLinkBench<Dut> bench(seed, taps, bits, 20'000, random.between(0, 900));
    int broken = 0;
    for (int round = 0; round < 12; ++round) {
      const int words = round % 3 == 0   ? random.between(1, kPlaces - 1)
                        : round % 3 == 1 ? kPlaces
                                         : kPlaces + random.between(1, 2);
      bench.forget();
      bench.send({.rows = 1, .columns = taps * words});
      bench.all_may_break();
      bench.words(1).insert(bench.words(1).begin(), 45, LinkCamera::Sent{});
      bench.words(2).insert(bench.words(2).begin(), 90, LinkCamera::Sent{});
      bench.drain(100);
      EXPECT_EQ(bench.expect_frames_sent(), words > kPlaces ? 1 : 0) << words << " words";
      EXPECT_EQ(bench.beats().size(), static_cast<std::size_t>(std::min(words, kPlaces) * taps / 4));
      broken += words > kPlaces ? 1 : 0;
    }
    EXPECT_EQ(bench.overruns(), 3 * broken);
    EXPECT_EQ(bench.lost() + bench.apart(), 0);
  });
}
TEST(CameraLinkFull, TheFifosOfTheLinksHoldAsManyWordsAsTheyHavePlaces) {
  expect_places_of_links<Vsp_camera_link_full_short>(8);
}
TEST(CameraLinkEighty, TheFifosOfTheLinksHoldAsManyWordsAsTheyHavePlaces) {
  expect_places_of_links<Vsp_camera_link_eighty_short>(10);
}
TEST(CameraLinkEightTens, TheFifosOfTheLinksHoldAsManyWordsAsTheyHavePlaces) {
  expect_places_of_links<Vsp_camera_link_eight_tens_short>(8, 10);
}

// The FIFO of 16 words holds what constraints/camera_link/rate.py says, but for a few words that are on their way.
template <typename Dut>
void expect_room_for_what_waits(int taps, int bits = 8) {
  int cut_off = 0;
  int whole = 0;
  for_cases(60, [&](Random& random, std::uint64_t seed) {
    const int board = random.between(4000 / taps, 990);
    const int rows = random.between(1, 10);
    const int words = random.between(30, 70);
    const int gap = random.between(1, 30);
    const double taken = 1000.0 / board * words / (taps * words / 4);  // NOLINT(bugprone-integer-division): whole beats
    const double of_line = words - taken * words;
    const double of_frame = rows * words - taken * (rows * (words + gap) - gap);
    const double most = std::max(of_line, of_frame);
    if (most > 13 && most < 22) {
      return;
    }
    CameraLinkBench<Dut> bench(seed, taps, bits, board, random.between(0, 900));
    bench.forget();
    bench.send({.rows = rows, .columns = taps * words, .min_gap = gap, .max_gap = gap});
    bench.all_may_break();
    bench.drain(1000);
    const int broken = bench.expect_frames_sent();
    EXPECT_EQ(broken, most > 16 ? 1 : 0) << most << " words";
    EXPECT_EQ(bench.overruns(), broken);
    cut_off += broken;
    whole += 1 - broken;
  });
  if (runs_all_cases()) {
    EXPECT_GT(cut_off, 10);
    EXPECT_GT(whole, 10);
  }
}
TEST(CameraLinkFull, TheFifoHoldsWhatTheFormulaSays) { expect_room_for_what_waits<Vsp_camera_link_full_short>(8); }
TEST(CameraLinkEighty, TheFifoHoldsWhatTheFormulaSays) { expect_room_for_what_waits<Vsp_camera_link_eighty_short>(10); }

// A cable that is pulled in the middle of frames and put back, of one link or of all, for words or for whole frames.
template <typename Dut>
void expect_cuts_of_three(int taps, int bits = 8) {
  int broken = 0;
  int whole = 0;
  for_cases(12, [&](std::uint64_t seed) {
    Random random(seed + 1000);
    const int board = fast_board(random, taps);
    CameraLinkBench<Dut> bench(seed, taps, bits, board, random.between(0, 5 * board), random.chance(50) ? 0 : 20);
    bench.forget();
    for (int frame = 0; frame < 40; ++frame) {
      const int rows = random.between(2, 6);
      const int words = random.between(40, 50);
      bench.send({.rows = rows, .columns = taps * words, .max_gap = 9, .least_words = rows * (words + 9) + 80});
    }
    int losses = 0;
    while (bench.sending()) {
      bench.clocks(random.between(30, 1500));
      const bool all = random.chance(30);
      const int link = random.between(0, 2);
      for (int number = 0; number < kLinks; ++number) {
        if (all || number == link) {
          const int most = random.chance(40) ? 4 : 60;  // words for which the others just wait, or more
          bench.lose_lock(number, random.chance(70) ? random.between(1, most) : random.between(200, 1500));
        }
      }
      ++losses;
      bench.clocks(4200);
    }
    bench.drain();
    const int cut = bench.expect_frames_sent();
    broken += cut;
    whole += 40 - cut;
    EXPECT_GE(bench.lost(), losses);
    EXPECT_EQ(bench.overruns(), 0);
  });
  if (runs_all_cases()) {
    EXPECT_GT(broken, 20);
    EXPECT_GT(whole, 200);
  }
}
TEST(CameraLinkFull, AFrameEndsWhereACableIsPulled) { expect_cuts_of_three<Vsp_camera_link_full_short>(8); }
TEST(CameraLinkEighty, AFrameEndsWhereACableIsPulled) { expect_cuts_of_three<Vsp_camera_link_eighty_short>(10); }
TEST(CameraLinkEightTens, AFrameEndsWhereACableIsPulled) {
  expect_cuts_of_three<Vsp_camera_link_eight_tens_short>(8, 10);
}

// Resets in the middle of a frame: what comes after begins with a whole frame.
template <typename Dut>
void expect_whole_frames_after_a_reset(int taps, int bits = 8) {
  for_cases(6, [&](Random& random, std::uint64_t seed) {
    CameraLinkBench<Dut> bench(seed, taps, bits, fast_board(random, taps), random.between(0, 900));
    for (int round = 0; round < 3; ++round) {
      bench.send({.rows = 4, .columns = 40 * taps, .max_gap = 3});
      bench.clocks(random.between(20, 100));
      bench.reset();
      bench.forget();
      bench.drain();
      EXPECT_TRUE(bench.beats().empty()) << "the rest of a frame";
      bench.forget();
      bench.send({.rows = random.between(1, 4), .columns = taps * random.between(30, 40)});
      bench.drain();
      EXPECT_EQ(bench.expect_frames_sent(), 0);
    }
    EXPECT_EQ(bench.lost(), 0);
  });
}
TEST(CameraLinkFull, AfterAResetTheNextFrameIsTheFirst) {
  expect_whole_frames_after_a_reset<Vsp_camera_link_full_short>(8);
}
TEST(CameraLinkEighty, AfterAResetTheNextFrameIsTheFirst) {
  expect_whole_frames_after_a_reset<Vsp_camera_link_eighty_short>(10);
}
TEST(CameraLinkEightTens, AfterAResetTheNextFrameIsTheFirst) {
  expect_whole_frames_after_a_reset<Vsp_camera_link_eight_tens_short>(8, 10);
}

// --- Damaged words ---

// What a link tells of a frame: its words with pixels, each with its number in the line.
struct Place {
  std::size_t at = 0;  // word of the frame
  int number = 0;
  bool start = false;  // of a frame; in Y and Z of the 80-bit configuration, of a line
  bool end = false;
};

std::vector<Place> places_of(const std::deque<LinkCamera::Sent>& words, std::size_t link) {
  std::vector<Place> places;
  bool low = true;
  bool begins = false;
  int number = 0;
  for (std::size_t at = 0; at < words.size(); ++at) {
    const LinkPins& pins = words[at].links[link];
    const std::uint32_t word = link_word(pins);
    const bool yz = pins.kind == LinkPins::Kind::eighty_yz || pins.kind == LinkPins::Kind::eight_tens_yz;
    const bool line = (word >> (pins.kind == LinkPins::Kind::eighty_yz ? 27U : 24U) & 1U) != 0;
    const bool frame = yz ? line : (word >> 25U & 1U) != 0;
    begins = begins || (frame && low);
    low = !frame;
    if (!(frame && line)) {
      if (number > 0 && !places.empty()) {
        places.back().end = true;
      }
      number = 0;
      continue;
    }
    if (pins.kind != LinkPins::Kind::ports || (word >> 26U & 1U) != 0) {
      places.push_back({.at = at, .number = number, .start = begins});
      begins = false;
    }
    ++number;
  }
  return places;
}

// Pixel `tap` of a word of all links.
std::uint8_t pixel_of(const LinkCamera::Sent& sent, int taps, int bits, int tap) {
  unsigned pixel = 0;
  std::array<std::uint32_t, kLinks> words{};
  std::transform(sent.links.begin(), sent.links.end(), words.begin(), link_word);
  for (int bit = 0; bit < 8; ++bit) {
    LinkPlace place{static_cast<std::size_t>(tap) / 3, 0};
    if (taps == 10) {
      place = place_of_ten_taps(tap, bit);
    } else if (bits == 10) {
      place = place_of_eight_tens(tap, bit + 2);
    } else {
      const std::array<char, 2> name = {static_cast<char>('A' + tap % 3), static_cast<char>('0' + bit)};
      place.output = static_cast<unsigned>(
          std::find(kOutputs.begin(), kOutputs.end(), std::string_view(name.data(), 2)) - kOutputs.begin());
    }
    pixel |= (words[place.link] >> place.output & 1U) << static_cast<unsigned>(bit);
  }
  return static_cast<std::uint8_t>(pixel);
}

// The frame as its links bring it, which agree.
Frame frame_of(const std::deque<LinkCamera::Sent>& words, const std::vector<Place>& places, int taps, int bits) {
  Frame frame;
  std::vector<std::uint8_t> line;
  for (const Place& place : places) {
    for (int tap = 0; tap < taps; ++tap) {
      line.push_back(pixel_of(words[place.at], taps, bits, tap));
    }
    if (place.end) {
      for (std::size_t i = 0; i + 4 <= line.size(); i += 4) {
        const std::uint32_t beat = line[i] | static_cast<std::uint32_t>(line[i + 1]) << 8U |
                                   static_cast<std::uint32_t>(line[i + 2]) << 16U |
                                   static_cast<std::uint32_t>(line[i + 3]) << 24U;
        frame.push_back({beat, frame.empty(), i + 8 > line.size()});
      }
      line.clear();
    }
  }
  return frame;
}

// Whether beats are rows of this many beats, so that the board takes them for a whole frame.
bool has_size(const Frame& frame, int rows, int beats) {
  if (frame.size() != static_cast<std::size_t>(rows) * static_cast<std::size_t>(beats)) {
    return false;
  }
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (frame[i].end != ((i + 1) % static_cast<std::size_t>(beats) == 0)) {
      return false;
    }
  }
  return true;
}

// Every other frame has 1 % damaged words in one link or in all, each with one to three wrong bits. Where the links
// differ in what is a pixel, or where lines and frames begin and end, the frame must not pass for a whole one, and must
// be counted; wrong bits of pixels are in the beats as they came. The next frame is right.
template <typename Dut>
void expect_damage_counted(int taps, int bits = 8) {
  int seen = 0;
  int unseen = 0;
  for_cases(20, [&](Random& random, std::uint64_t seed) {
    const int board = fast_board(random, taps);
    CameraLinkBench<Dut> bench(seed, taps, bits, board, random.between(0, 5 * board));
    for (int round = 0; round < 6; ++round) {
      const int rows = random.between(4, 10);
      const int words = 2 * random.between(20, 25);
      const int count = rows * (words + 4) + 20;
      bench.forget();
      const auto shape = [&](int gap) {
        return LinkCamera::Shape{.rows = rows, .columns = taps * words, .max_gap = gap, .least_words = count + 100};
      };
      bench.send(shape(4));
      const bool all = random.chance(50);
      const auto one = static_cast<std::size_t>(random.between(0, 2));
      for (std::size_t link = 0; link < kLinks; ++link) {
        for (int at = 0; at < count; ++at) {
          if ((all || link == one) && random.chance(1)) {
            for (int flips = random.between(1, 3); flips > 0; --flips) {
              const int bit = random.chance(60) ? random.between(0, 27) : random.between(24, 27);
              for (std::size_t copy = 0; copy < kLinks; ++copy) {  // so that words(0) tells all of them
                std::deque<LinkCamera::Sent>& queue = bench.words(copy);
                queue[queue.size() - bench.words(0).size() + static_cast<std::size_t>(at)].links[link].flips ^=
                    1U << static_cast<unsigned>(bit);
              }
            }
          }
        }
      }
      const std::deque<LinkCamera::Sent> sent = bench.words(0);
      std::array<std::vector<Place>, kLinks> places;
      for (std::size_t link = 0; link < kLinks; ++link) {
        places[link] = places_of(sent, link);
      }
      const auto differ = [&](const std::vector<Place>& x, const std::vector<Place>& other) {
        return !std::equal(x.begin(), x.end(), other.begin(), other.end(), [&](const Place& a, const Place& b) {
          return a.at == b.at && a.end == b.end && (is_eighty(taps, bits) || a.start == b.start);
        });
      };
      const bool visible = differ(places[0], places[1]) || differ(places[0], places[2]);
      const int before = bench.apart();
      bench.send(shape(4));
      const Frame next = bench.frame(1);
      bench.drain();
      (visible ? seen : unseen) += 1;

      // Frames as they came out
      std::vector<Frame> came;
      for (const Beat& beat : bench.beats()) {
        if (beat.start) {
          came.emplace_back();
        }
        ASSERT_FALSE(came.empty()) << "beats before a frame begins";
        came.back().push_back(beat);
      }
      ASSERT_FALSE(came.empty());
      EXPECT_TRUE(came.back() == next) << "the next frame is not right";
      came.pop_back();
      const Frame due = frame_of(sent, places[0], taps, bits);
      if (visible) {
        EXPECT_GE(bench.apart(), before + 1);
      } else {
        EXPECT_EQ(bench.apart(), before);
      }
      for (const Frame& frame : came) {
        EXPECT_TRUE(!has_size(frame, rows, taps * words / 4) || frame == due)
            << "a damaged frame passes for a whole one";
      }
      EXPECT_EQ(bench.overruns() + bench.lost(), 0);
    }
  });
  if (runs_all_cases()) {
    EXPECT_GT(seen, 30);
    EXPECT_GT(unseen, 4);
  }
}
TEST(CameraLinkFull, DamagedWordsAreCountedAndTheNextFrameIsRight) {
  expect_damage_counted<Vsp_camera_link_full_short>(8);
}
TEST(CameraLinkEighty, DamagedWordsAreCountedAndTheNextFrameIsRight) {
  expect_damage_counted<Vsp_camera_link_eighty_short>(10);
}
TEST(CameraLinkEightTens, DamagedWordsAreCountedAndTheNextFrameIsRight) {
  expect_damage_counted<Vsp_camera_link_eight_tens_short>(8, 10);
}

}  // namespace
}  // namespace selfproj::test
