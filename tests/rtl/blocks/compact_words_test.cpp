// Compares the divided columns with the model: random words of the grey modes, with gaps and breaks.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <utility>

#include "Vsp_compact_words_ports.h"
#include "Vsp_compact_words_small_ports.h"
#include "selfproj/model/little_endian.h"
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
Column random_column(Random& random, int max_rows, bool strongest) {
  Column column;
  if (random.chance(15)) {
    return column;
  }
  const int n = random.chance(10) ? max_rows : random.chance(20) ? 1 : random.between(1, max_rows);
  const int first = random.chance(20) ? 1 : random.between(1, max_rows - n + 1);
  const int weight = random.chance(20) ? 255 : random.chance(20) ? 1 : random.between(1, 255);
  for (int row = first; row < first + n; ++row) {
    const auto w = static_cast<std::uint32_t>(random.chance(50) ? weight : random.between(1, 255));
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

template <class Dut>
void play(Random& random, int max_rows) {
  Clocked<Dut> words;
  words.valid_when({"data_o"}, [&words] { return words->valid_o != 0; });
  words->words_valid_i = 0;
  words->words_break_i = 0;
  words->compact_i = 0;
  words->strongest_i = 0;
  words.reset();
  std::deque<Word128> expected;  // beats that have not left
  bool broke = false;            // a break that has not been told
  std::uint64_t beats = 0;
  const auto clock = [&] {
    words.settle();
    if (words->valid_o) {
      ASSERT_FALSE(expected.empty());
      EXPECT_EQ(word128(words->data_o), expected.front());
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
      Word128 beat{};
      for (std::size_t pair = 0; pair < 2; ++pair) {
        while (!random.chance(eager)) {
          clock();
        }
        std::array<std::uint32_t, 4> exact{};
        for (std::size_t c = 0; c < 2; ++c) {
          Column column = random_column(random, max_rows, strongest);
          model::RunsView view{{&column.m0, &column.m1, &column.n}, &column.runs, &column.second};
          std::array<std::uint8_t, 16> bytes{};
          model::pack_columns(select, model::Mode::grey, 1, view, bytes.data());
          for (std::size_t k = 0; k < 2; ++k) {
            exact[2 * c + k] = model::load_little_endian<std::uint32_t>(bytes.data() + 4 * k);
          }
          beat[2 * pair + c] = model::compact_word(select, column.m0, column.m1, column.n, column.runs, column.second);
        }
        if (!compact) {
          expected.push_back(exact);
        } else if (pair == 1) {
          expected.push_back(beat);
        }
        set128(words->words_data_i, exact);
        words->words_valid_i = 1;
        if (group == groups - 1 && pair == 1 && random.chance(30)) {
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

}  // namespace
}  // namespace selfproj::test
