// Tests the on-chip memory of the Gray-code decoder: two clocks after a request it gives the word that was last written
// there, for frames of any length in any order with any gaps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "Vsp_gray_memory_one_ports.h"
#include "Vsp_gray_memory_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// Reads frame after frame. Like the decoder it writes each word back, changed, a fixed number of clocks after its read.
constexpr int kWriteBack = 5;
constexpr int kNowhere = -1;

template <typename Dut>
class MemoryBench {
 public:
  MemoryBench(Random& random, int words) : random_(random), words_(static_cast<std::size_t>(words)) {
    memory_.valid_when({"rd_data_o"}, [this] { return asked_.front().has_value(); });
    memory_.reset(0);
  }

  // Plays a frame of the first `length` words. In each clock it requests one with this probability, in percent.
  void frame(int length, int eagerness) {
    for (int place = 0; place < length;) {
      // A word can be read in the clock after its write. It was requested kWriteBack clocks before.
      const bool waits = std::find(write_back_.begin(), write_back_.end(), place) != write_back_.end();
      const bool read = !waits && random_.chance(eagerness);
      clock(read ? place : kNowhere);
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
      place += read ? 1 : 0;
    }
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks && !::testing::Test::HasFatalFailure(); ++i) {
      clock(kNowhere);
    }
  }

  int checked() const { return checked_; }

 private:
  void clock(int read) {
    // Before the write of this clock; the two never touch the same word.
    asked_.push_back(read == kNowhere ? std::nullopt : words_[static_cast<std::size_t>(read)]);
    write_back_.push_back(read);
    const int write = write_back_.front();
    write_back_.pop_front();
    const auto data = static_cast<std::uint32_t>(random_.bits());
    memory_->rd_en_i = read != kNowhere;
    memory_->rd_first_i = read == kNowhere ? random_.chance(50) : read == 0;
    memory_->wr_en_i = write != kNowhere;
    memory_->wr_first_i = write == kNowhere ? random_.chance(50) : write == 0;
    memory_->wr_data_i = data;
    memory_.settle();
    if (asked_.front()) {
      ASSERT_EQ(memory_->rd_data_o, *asked_.front()) << "clock " << memory_.clock();
      ++checked_;
    }
    asked_.pop_front();
    memory_.rise();
    if (write != kNowhere) {
      words_[static_cast<std::size_t>(write)] = data;
    }
  }

  Random& random_;
  Clocked<Dut> memory_;
  std::vector<std::optional<std::uint32_t>> words_;                     // what was written
  std::deque<int> write_back_ = std::deque<int>(kWriteBack, kNowhere);  // addresses read in the last clocks
  // expected words of the last clocks, if known
  std::deque<std::optional<std::uint32_t>> asked_ = std::deque<std::optional<std::uint32_t>>(2);
  int checked_ = 0;
};

template <typename Dut>
void random_frames(int cases, int words) {
  for_cases(cases, [&](Random& random) {
    MemoryBench<Dut> bench(random, words);
    bench.idle(20);  // initial values of the registers
    for (int frame = 0; frame < 30; ++frame) {
      // Often short ones: the next frame then requests words that are not written yet.
      const int length = random.chance(50) ? random.between(1, std::min(words, 60)) : random.between(1, words);
      bench.frame(length, random.chance(50) ? 100 : random.between(20, 99));
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
      bench.idle(random.chance(50) ? 0 : random.between(1, 40));
      ASSERT_FALSE(::testing::Test::HasFatalFailure());
    }
    EXPECT_GT(bench.checked(), 200);
  });
}

// 38 banks in ten groups, of 16 words each, the last of 8.
TEST(GrayMemory, RandomFrames) { random_frames<Vsp_gray_memory>(30, 600); }

// One bank, no longer than the words read ahead, and smaller than the head and the ring together.
TEST(GrayMemoryOne, RandomFrames) { random_frames<Vsp_gray_memory_one>(30, 45); }

}  // namespace
}  // namespace selfproj::test
