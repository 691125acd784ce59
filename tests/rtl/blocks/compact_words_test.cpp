// Compares the divided columns with the model: random words of the grey modes, with gaps and breaks.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <utility>

#include "Vsp_compact_words_ports.h"
#include "Vsp_compact_words_small_ports.h"
#if __has_include("Vsp_compact_words_twelve_ports.h")  // not among the quick tests
#define SELFPROJ_WIDE
#include "Vsp_compact_words_eight_ports.h"
#include "Vsp_compact_words_twelve_ports.h"
#endif
#include "selfproj/model/little_endian.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// Moments that a column of an image of at most `max_rows` rows can have: the extremes are frequent.
struct Column {
  std::uint32_t m0 = 0, m1 = 0, n = 0;
  std::uint8_t runs = 0, second = 0;
};
Column random_column(Random& random, int max_rows, bool strongest, int largest) {
  Column column;
  if (random.chance(15)) {
    return column;
  }
  const int n = random.chance(10) ? max_rows : random.chance(20) ? 1 : random.between(1, max_rows);
  const int first = random.chance(20) ? 1 : random.between(1, max_rows - n + 1);
  const int weight = random.chance(20) ? largest : random.chance(20) ? 1 : random.between(1, largest);
  for (int row = first; row < first + n; ++row) {
    const auto w = static_cast<std::uint32_t>(random.chance(50) ? weight : random.between(1, largest));
    column.m0 += w;
    column.m1 += w * static_cast<std::uint32_t>(row);
    ++column.n;
  }
  if (strongest) {
    column.runs = static_cast<std::uint8_t>(random.between(1, 3));
    column.second = static_cast<std::uint8_t>(column.runs > 1 ? random.between(0, 16) : 0);
  }
  return column;
}

template <class Dut, int Lanes = 4>
void play(Random& random, int max_rows, int bits = 8) {
  constexpr std::size_t kHalf = Lanes / 2;  // columns at once
  using Words = std::array<std::uint32_t, Lanes>;
  model::PacketHeader header;
  header.kind = spec::kKindMoments;
  header.mode = static_cast<std::uint8_t>(model::Mode::grey);
  header.columns = 1;
  header.pixel_bits = static_cast<std::uint8_t>(bits);
  Clocked<Dut> words;
  words.valid_when({"data_o"}, [&words] { return words->valid_o != 0; });
  words->words_valid_i = 0;
  words->words_break_i = 0;
  words->compact_i = 0;
  words->strongest_i = 0;
  words.reset();
  std::deque<Words> expected;  // groups that have not left
  bool broke = false;          // a break that has not been told
  std::uint64_t beats = 0;
  const auto clock = [&] {
    words.settle();
    if (words->valid_o) {
      ASSERT_FALSE(expected.empty());
      Words found;
      for (std::size_t i = 0; i < Lanes; ++i) {
        found[i] = words->data_o[i];
      }
      EXPECT_EQ(found, expected.front());
      expected.pop_front();
      ++beats;
    }
    if (words->break_o) {
      EXPECT_TRUE(broke && expected.empty());
      broke = false;
    }
    words.rise();
    words->words_valid_i = 0;
    words->words_break_i = 0;
  };
  for (int frame = 0; frame < 40; ++frame) {
    const bool compact = random.chance(75);
    const bool strongest = random.chance(50);
    words->compact_i = compact;
    words->strongest_i = strongest;
    const model::Select select = strongest ? model::Select::strongest : model::Select::all;
    const int groups = random.between(1, 40);
    const int eager = random.chance(50) ? 100 : random.between(20, 100);
    for (int group = 0; group < groups; ++group) {
      Words beat{};
      for (std::size_t half = 0; half < 2; ++half) {
        while (!random.chance(eager)) {
          clock();
        }
        Words exact{};
        for (std::size_t c = 0; c < kHalf; ++c) {
          Column column = random_column(random, max_rows, strongest, (1 << bits) - 1);
          model::RunsView view{{&column.m0, &column.m1, &column.n}, &column.runs, &column.second};
          std::array<std::uint8_t, 16> bytes{};
          header.select = static_cast<std::uint8_t>(select);
          model::pack_columns(header, view, bytes.data());
          for (std::size_t k = 0; k < 2; ++k) {
            exact[2 * c + k] = model::load_little_endian<std::uint32_t>(bytes.data() + 4 * k);
          }
          beat[kHalf * half + c] =
              model::compact_word(select, column.m0, column.m1, column.n, column.runs, column.second, bits);
        }
        if (!compact) {
          expected.push_back(exact);
        } else if (half == 1) {
          expected.push_back(beat);
        }
        for (std::size_t i = 0; i < Lanes; ++i) {
          words->words_data_i[i] = exact[i];
        }
        words->words_valid_i = 1;
        if (group == groups - 1 && half == 1 && random.chance(30)) {
          words->words_break_i = 1;
          broke = true;
        }
        clock();
        ASSERT_FALSE(::testing::Test::HasFailure()) << "frame " << frame;
      }
    }
    for (int i = 0; i < 30; ++i) {
      clock();
    }
    EXPECT_TRUE(expected.empty() && !broke) << "a beat or a break has not left";
  }
  EXPECT_GT(beats, 500U);
}

TEST(CompactWords, RandomWordsGapsAndBreaks) {
  for_cases(20, [](Random& random) { play<Vsp_compact_words>(random, spec::kMaxRows); });
}
TEST(CompactWordsSmall, RandomWordsGapsAndBreaks) {
  for_cases(20, [](Random& random) { play<Vsp_compact_words_small>(random, 40); });
}

#ifdef SELFPROJ_WIDE
TEST(CompactWords, PixelsOfTwelveBits) {
  for_cases(20, [](Random& random) { play<Vsp_compact_words_twelve>(random, spec::kMaxRows, 12); });
}
TEST(CompactWords, EightLanesOfTenBits) {
  for_cases(20, [](Random& random) { play<Vsp_compact_words_eight, 8>(random, 40, 10); });
}
#endif

}  // namespace
}  // namespace selfproj::test
