// Tests the counter in chains and the pipelined multiplier.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <type_traits>

#include "Vsp_counter64_carry_ports.h"
#include "Vsp_counter64_full_ports.h"
#include "Vsp_counter64_ports.h"
#include "Vsp_counter64_wrap_ports.h"
#include "Vsp_scale_odd_ports.h"
#include "Vsp_scale_one_ports.h"
#include "Vsp_scale_ports.h"
#include "Vsp_scale_small_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

template <typename Dut>
void count_from(std::uint64_t reset_value) {
  for_cases(20, [&](Random& random) {
    Clocked<Dut> counter;
    counter->inc_i = 1;  // must not count in reset
    counter.reset();
    std::uint64_t count = reset_value;
    bool counting = false;  // inc_i was high in the previous clock; this shows in the next one
    const int percent = random.between(1, 100);
    for (int i = 0; i < 200; ++i) {
      counter->inc_i = random.chance(percent);
      counter.settle();
      ASSERT_EQ(counter->count_o, count) << "clock " << counter.clock();
      count += counting ? 1 : 0;
      counting = counter->inc_i != 0;
      counter.rise();
    }
  });
}

// Counts without a pause through the first four carries. Only the lowest chain passes a carry on.
template <typename Dut>
void carry_from_the_lowest_only(std::uint64_t count) {
  Clocked<Dut> counter;
  counter->inc_i = 0;
  counter.reset();
  counter->inc_i = 1;
  for (int i = 0; i < 200'000; ++i) {
    counter.settle();
    if (counter->count_o != count) {
      FAIL() << "clock " << i;
    }
    count += i > 0 ? 1 : 0;  // the count rises two clocks after the first inc_i
    counter.rise();
  }
}

constexpr std::uint64_t kCarry = 0x7FFF'FFFF'FFFF'FFFDU;  // all chains except the highest pass a carry on
constexpr std::uint64_t kWrap = 0xFFFF'FFFF'FFFF'FFFDU;
constexpr std::uint64_t kFull = 0x0000'0000'FFFF'FFFDU;

TEST(Counter64, CountsFromZero) { count_from<Vsp_counter64>(0); }
TEST(Counter64, CarriesIntoTheUpperWord) { count_from<Vsp_counter64_carry>(kCarry); }
TEST(Counter64, CarriesInItsThirdClock) { count_from<Vsp_counter64_full>(kFull); }
TEST(Counter64, WrapsAt64Bits) { count_from<Vsp_counter64_wrap>(kWrap); }
TEST(Counter64, CarriesFromItsLowestChainOnly) {
  carry_from_the_lowest_only<Vsp_counter64>(0);
  carry_from_the_lowest_only<Vsp_counter64_carry>(kCarry);
  carry_from_the_lowest_only<Vsp_counter64_full>(kFull);
  carry_from_the_lowest_only<Vsp_counter64_wrap>(kWrap);
}

// Feeds x values, one a clock or with gaps, and holds k for as long as a product needs it. A product comes four clocks
// after its x.
template <typename Dut>
class Scale {
 public:
  Scale() {
    scale_.outputs_are_known();
    scale_.valid_when({"product_o"}, [this] { return scale_->clk_i == 0 && product_is_due_; });
    gap();
    gap();
    gap();
    gap();
  }

  // k must not change for four clocks after each x: wait before a new one.
  void set_k(std::uint64_t k) {
    for (int i = 0; i < 4; ++i) {
      gap();
    }
    k_ = k;
    scale_->k_i = static_cast<std::remove_reference_t<decltype(scale_->k_i)>>(k);
  }

  void feed(std::uint64_t x) {
    scale_->move_i = 1;
    scale_->x_i = static_cast<std::remove_reference_t<decltype(scale_->x_i)>>(x);
    step(x * k_);
  }

  // A clock without an x; the value at the input does not count. If no product is on its way, no register needs to
  // change.
  void gap() {
    scale_->move_i =
        std::any_of(expected_.begin(), expected_.end(), [](const auto& product) { return product.has_value(); });
    scale_->x_i = static_cast<std::remove_reference_t<decltype(scale_->x_i)>>(~scale_->x_i & 1U);
    step(std::nullopt);
  }

 private:
  void step(std::optional<std::uint64_t> product) {
    product_is_due_ = expected_.size() == 4 && expected_.front();
    scale_.settle();
    if (product_is_due_) {
      ASSERT_EQ(scale_->product_o, *expected_.front()) << "clock " << scale_.clock();
    }
    if (expected_.size() == 4) {
      expected_.pop_front();
    }
    expected_.push_back(product);
    scale_.rise();
  }

  Clocked<Dut> scale_;
  std::deque<std::optional<std::uint64_t>> expected_;
  std::uint64_t k_ = 0;
  bool product_is_due_ = false;
};

template <typename Dut>
void every_product(int x_bits, int k_bits) {
  Scale<Dut> scale;
  for (std::uint64_t k = 0; k < 1ULL << k_bits; ++k) {
    scale.set_k(k);
    for (std::uint64_t x = 0; x < 1ULL << x_bits; ++x) {
      scale.feed(x);
      for (std::uint64_t gaps = (x + k) % 16; gaps < 5; ++gaps) {
        scale.gap();
      }
      if (::testing::Test::HasFatalFailure()) {
        FAIL() << x << " * " << k;
      }
    }
  }
  scale.set_k(0);  // until the last products have come out
}

TEST(Scale, EveryProductOf8And4Bits) { every_product<Vsp_scale_small>(8, 4); }
TEST(Scale, EveryProductOf5And1Bits) { every_product<Vsp_scale_one>(5, 1); }

template <typename Dut>
void random_products(int x_bits, int k_bits) {
  const std::uint64_t x_max = (1ULL << x_bits) - 1;
  const std::uint64_t k_max = (1ULL << k_bits) - 1;
  for_cases(20, [&](Random& random) {
    Scale<Dut> scale;
    for (int run = 0; run < 40; ++run) {
      // the largest value, single bits, and random values
      scale.set_k(run == 0 ? k_max : run <= k_bits ? 1ULL << (run - 1) : random.bits() & k_max);
      for (int i = 0; i < 60; ++i) {
        scale.feed(i == 0 ? x_max : i <= x_bits ? 1ULL << (i - 1) : random.bits() & x_max);
        if (run % 2 != 0 && random.chance(40)) {
          scale.gap();
        }
        ASSERT_FALSE(::testing::Test::HasFatalFailure());
      }
    }
    scale.set_k(0);
  });
}

TEST(Scale, RandomProductsOf18And10Bits) { random_products<Vsp_scale>(18, 10); }
TEST(Scale, RandomProductsOf15And7Bits) { random_products<Vsp_scale_odd>(15, 7); }

}  // namespace
}  // namespace selfproj::test
