// Tests the order in which the groups of a last row are drained, with a reference written down from the guarantees of
// the module.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

#include "Vsp_drain_order_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr int kMostGroups = 16;  // 2^GroupBits of this build

// Rows of any length, with gaps, that end or break. The next row begins as soon as the last group of the row before is
// read and its break is told, which may be in the clock of the first push.
class DrainOrderBench {
 public:
  explicit DrainOrderBench(Random& random) : random_(random) {
    order_.valid_when({"drain_group_o"}, [this] { return order_->drain_o != 0; });
    order_.valid_when({"weights_o"}, [this] { return drained_; });
    order_->push_i = 0;
    order_->break_i = 0;
    order_.reset();
  }

  int rows = 0;  // that have left
  int met = 0;   // that have begun in the clock in which the break of the one before was told

  void clock() {
    order_->push_i = 0;
    order_->break_i = 0;
    order_.settle();  // the outputs come from registers: what may be pushed follows from them
    if (!open_ && out() && !order_->drain_o && !order_->active_o && random_.chance(eager)) {
      begin();
    }
    if (open_ && random_.chance(eager)) {
      push();
    }
    if (open_ && breaks_ && !pushed_.empty() && random_.chance(20)) {
      order_->break_i = 1;
      open_ = false;
      broke_ = true;
    }
    order_.settle();
    look();
    order_.rise();
    ++now_;
    ++quiet_;
  }

  int eager = 100;

 private:
  [[nodiscard]] bool out() { return reads_ == pushed_.size() && (!broke_ || order_->break_o != 0); }

  void begin() {
    rows += pushed_.empty() ? 0 : 1;
    met += order_->break_o != 0 ? 1 : 0;
    told_now_ = order_->break_o != 0;
    pushed_.clear();
    reads_ = 0;
    open_ = true;
    broke_ = false;
    breaks_ = random_.chance(50);
    groups_ = random_.between(1, kMostGroups);
  }

  void push() {
    const auto weight = static_cast<std::uint8_t>(random_.bits());
    order_->push_i = 1;
    order_->push_group_i = static_cast<CData>(pushed_.size());
    order_->push_weights_i = weight;
    pushed_.push_back({now_, weight});
    const bool last = static_cast<int>(pushed_.size()) == groups_;
    order_->push_end_i = last && !breaks_;
    open_ = !last || breaks_;
    if (last && breaks_) {
      order_->break_i = 1;
      open_ = false;
      broke_ = true;
    }
  }

  void look() {
    if (drained_) {
      EXPECT_EQ(order_->weights_o, weight_);
      EXPECT_FALSE(order_->drain_o) << "in neighbouring clocks";
    }
    drained_ = order_->drain_o != 0;
    if (drained_) {
      ASSERT_LT(reads_, pushed_.size());
      EXPECT_EQ(order_->drain_group_o, reads_);
      EXPECT_LE(pushed_[reads_].clock + 2, now_);
      weight_ = pushed_[reads_].weight;
      ++reads_;
      EXPECT_TRUE(order_->active_o || (!open_ && reads_ == pushed_.size()));
    }
    if (order_->break_o && !told_now_) {
      EXPECT_TRUE(broke_ && !open_ && reads_ == pushed_.size());
      broke_ = false;
    }
    told_now_ = false;
    if (open_ || drained_ || order_->push_i || order_->break_o) {
      quiet_ = 0;
    }
    EXPECT_LT(quiet_, 3 * kMostGroups) << "a row or its break has not left";
  }

  struct Pushed {
    std::int64_t clock;
    std::uint8_t weight;
  };

  Random& random_;
  Clocked<Vsp_drain_order> order_;
  std::vector<Pushed> pushed_;  // of this row, or of the last one
  std::size_t reads_ = 0;
  std::int64_t now_ = 0;
  int quiet_ = 0;
  int groups_ = 0;
  bool open_ = false, breaks_ = false, broke_ = false, drained_ = false, told_now_ = false;
  std::uint8_t weight_ = 0;
};

TEST(DrainOrder, RowsThatFollowEachOtherAtOnce) {
  int met = 0;
  for_cases(20, [&](Random& random) {
    DrainOrderBench bench(random);
    bench.eager = random.chance(50) ? 100 : random.between(20, 100);
    for (int i = 0; i < 3000; ++i) {
      bench.clock();
      ASSERT_FALSE(HasFailure()) << "clock " << i;
    }
    EXPECT_GT(bench.rows, 20);
    met += bench.met;
  });
  EXPECT_GT(met, 100);
}

}  // namespace
}  // namespace selfproj::test
