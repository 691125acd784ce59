// Tests the packer of raw image lines. It requests a packet when a line is done, and sends its words in order, with
// zeros after the last pixel, in the clocks that its header states. Some lines are not wanted, not accepted, or broken.
#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "Vsp_image_packer_ports.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kAcceptDelay = 3;  // from line_done_o
constexpr int kWordDelay = 7;    // likewise
constexpr int kDecision = 2;     // sp_packetizer: from the request to the decision
constexpr int kBusyAfter = 7;    // sp_packetizer: from the last payload beat to the next decision

struct Beat {
  std::uint32_t pixels = 0;
  int group = 0;
  int row = 1;
  bool start = false;
  bool end = false;
};

class ImagePackerBench {
 public:
  explicit ImagePackerBench(Random& random) : random_(random) {
    packer_.valid_when({"words_data_o"}, [this] { return packer_->words_valid_o != 0; });
    packer_.valid_when({"line_words_o", "line_row_o", "line_status_o"}, [this] { return packer_->line_done_o != 0; });
    packer_->image_i = 0;
    packer_->beat_valid_i = 0;
    packer_->break_i = 0;
    packer_->accept_i = 0;
    packer_.reset();
  }

  bool image = true;
  int columns = 4;
  int refusals = 0;  // percent

  // One clock, with or without a beat, and with or without a break of the previous frame.
  void clock(const std::optional<Beat>& beat, bool breaks) {
    const std::int64_t now = packer_.clock();
    SCOPED_TRACE(::testing::Message() << "clock " << now);
    const auto status = static_cast<std::uint32_t>(random_.between(1, 31));
    packer_->break_i = breaks;
    packer_->break_status_i = static_cast<CData>(status);
    packer_->beat_valid_i = beat.has_value();
    packer_->image_i = image;
    packer_->columns_i = static_cast<SData>(columns);
    if (beat) {
      packer_->beat_pixels_i = beat->pixels;
      packer_->beat_group_i = static_cast<CData>(beat->group & 3);
      packer_->beat_row_i = static_cast<SData>(beat->row);
      packer_->beat_line_start_i = beat->start;
      packer_->beat_line_end_i = beat->end;
    }
    // accept_i counts three clocks after a request, and at no other time
    packer_->accept_i = random_.chance(50);
    if (!asked_.empty() && asked_.front().clock + kAcceptDelay == now) {
      packer_->accept_i = asked_.front().accept;
      asked_.pop_front();
    }
    packer_.settle();

    const bool broken = breaks && open_;
    const bool done = ended_ || broken;
    ASSERT_EQ(packer_->line_done_o, done ? 1 : 0);
    if (done) {
      ASSERT_EQ(packer_->line_status_o, broken ? status : 0);
      ASSERT_EQ(packer_->line_words_o, (line_columns_ + 15) / 16);
      ASSERT_EQ(packer_->line_row_o, line_row_);
      line_done(now, broken);
    }
    ended_ = false;
    open_ = open_ && !broken;
    const auto found = expected_.find(now);
    ASSERT_EQ(packer_->words_valid_o, found != expected_.end() ? 1 : 0);
    ASSERT_EQ(packer_->words_break_o, found != expected_.end() && found->second.ends_early ? 1 : 0);
    if (found != expected_.end()) {
      ASSERT_EQ(word128(packer_->words_data_o), found->second.word);
      expected_.erase(found);
      ++words;
    }
    if (beat && image) {
      take(*beat);
    }
    packer_.rise();
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks && !::testing::Test::HasFatalFailure(); ++i) {
      clock(std::nullopt, false);
    }
  }

  int words = 0;
  int lines_taken = 0;

 private:
  struct Word {
    Word128 word;
    bool ends_early;
  };
  struct Asked {
    std::int64_t clock;
    bool accept;
  };

  void take(const Beat& beat) {
    if (beat.start) {
      pixels_.clear();
      line_columns_ = columns;
      line_row_ = beat.row;
    }
    pixels_.push_back(beat.pixels);
    open_ = !beat.end;
    ended_ = beat.end;
  }

  void line_done(std::int64_t now, bool broken) {
    const bool accept = now + kDecision >= idle_from_ && !random_.chance(refusals);
    asked_.push_back({now, accept});
    if (!accept) {
      return;
    }
    ++lines_taken;
    const int count = static_cast<int>((pixels_.size() + 3) / 4);
    for (int i = 0; i < count; ++i) {
      Word128 word{};
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t at = 4 * static_cast<std::size_t>(i) + k;
        word[k] = at < pixels_.size() ? pixels_[at] : 0;
      }
      expected_[now + kWordDelay + i] = {word, broken && i == count - 1};
    }
    idle_from_ = now + kWordDelay + (line_columns_ + 15) / 16 - 1 + kBusyAfter;
  }

  Random& random_;
  Clocked<Vsp_image_packer> packer_;
  std::map<std::int64_t, Word> expected_;  // by clock
  std::deque<Asked> asked_;
  std::vector<std::uint32_t> pixels_;  // of the line
  bool open_ = false;                  // a line has begun and not ended
  bool ended_ = false;                 // it ended in the clock before
  int line_columns_ = 0;
  int line_row_ = 0;
  std::int64_t idle_from_ = 0;
};

// Without gaps every line of 60 columns or more is taken. Of shorter lines as many are taken as packets can follow each
// other.
TEST(ImagePacker, LinesOfEveryLengthWithoutGaps) {
  Random random(1);
  std::vector<int> lengths = {512, 511, 509};  // in beats; 512 is the largest
  for (int beats = 1; beats <= 40; ++beats) {
    lengths.push_back(beats);
  }
  for (const int beats : lengths) {
    SCOPED_TRACE(::testing::Message() << 4 * beats << " columns");
    ImagePackerBench bench(random);
    bench.columns = 4 * beats;
    for (int line = 1; line <= 9; ++line) {
      for (int i = 0; i < beats; ++i) {
        bench.clock(Beat{static_cast<std::uint32_t>(random.bits()), i, line, i == 0, i == beats - 1}, false);
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
    }
    bench.idle(200);
    EXPECT_EQ(bench.words, bench.lines_taken * ((beats + 3) / 4));
    EXPECT_EQ(bench.lines_taken == 9, beats >= 15);
  }
}

TEST(ImagePacker, RandomLinesGapsRefusalsAndBreaks) {
  for_cases(150, [&](Random& random) {
    ImagePackerBench bench(random);
    const int gaps = random.chance(50) ? 0 : random.between(1, 60);
    const int breaks = random.between(0, 20);
    bench.refusals = random.between(0, 40);
    bool break_next = false;  // the break comes with the next clock, or with the next frame's first beat
    for (int frame = 0; frame < 30; ++frame) {
      const bool image = random.chance(85);
      const int columns = 4 * (random.chance(5) ? random.between(1, 512) : random.between(1, 40));
      const int beats = columns / 4;
      bool broken = false;
      const int first_row = random.between(1, 1017);  // any value will do
      const int rows = random.between(1, 6);
      for (int row = first_row; row < first_row + rows && !broken; ++row) {
        for (int i = 0; i < beats && !broken; ++i) {
          while (random.chance(gaps)) {
            bench.clock(std::nullopt, break_next);
            break_next = false;
          }
          // the settings in force change with a frame's first beat
          bench.image = image;
          bench.columns = columns;
          broken = random.chance(breaks) && random.chance(20);
          bench.clock(Beat{static_cast<std::uint32_t>(random.bits()), i, row, i == 0, !broken && i == beats - 1},
                      break_next);
          break_next = false;
          ASSERT_FALSE(::testing::Test::HasFatalFailure());
        }
        if (!broken && random.chance(2)) {
          bench.clock(std::nullopt, true);  // a break between lines does not concern the packer
          break;
        }
      }
      if (broken) {
        bench.idle(random.chance(60) ? 0 : random.between(0, 12));
        if (random.chance(50)) {
          bench.clock(std::nullopt, true);
        } else {
          break_next = true;
        }
      }
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    bench.clock(std::nullopt, break_next);
    bench.idle(200);
    EXPECT_GT(bench.words, 20);
  });
}

}  // namespace
}  // namespace selfproj::test
