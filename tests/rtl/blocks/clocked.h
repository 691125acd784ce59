// Steps a Verilated model through its clocks.
//
// A clock is the time up to its rising edge. In each clock, set the inputs, call settle() to evaluate the model with
// the clock low (the outputs then have their values of this clock, also those that depend on inputs of this clock), and
// call rise() for the rising edge. Values written by the edge show in the next clock.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_CLOCKED_H
#define SELFPROJ_TESTS_RTL_BLOCKS_CLOCKED_H

#include <verilated.h>

#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>

#include "sim/board/verilated_model.h"
#include "tests/rtl/blocks/recorder.h"

namespace selfproj::test {

// A word of 128 bits as Verilator has it: 32 bits each, lowest first.
using Word128 = std::array<std::uint32_t, 4>;

template <typename Wide>
Word128 word128(const Wide& wide) {
  return {wide[0], wide[1], wide[2], wide[3]};
}

template <typename Wide>
void set128(Wide& wide, const Word128& value) {
  for (std::size_t i = 0; i < 4; ++i) {
    wide[i] = value[i];
  }
}

// What registers begin with: zeros, as in an FPGA, or random values.
enum class Begin : int { zeros = 0, random = 2 };

// A model in its own context.
template <typename Dut>
class Model {
 public:
  explicit Model(Begin begin = kBegin)
      : held_([begin] { return std::make_unique<Held>(begin); }), recorder_(Recorder::claim()) {
    sim::choose_mutant(dut());
    if (recorder_) {
      list_ports(dut(), *recorder_);
    }
  }

  Dut& dut() { return held_->dut; }
  Dut* operator->() { return &held_->dut; }

  void eval() {
    held_->dut.eval();
    if (recorder_) {
      recorder_->sample();
    }
  }

  // For the recorder: these outputs count only while `valid` returns true.
  void valid_when(std::initializer_list<const char*> outputs, const std::function<bool()>& valid) {
    for (const char* output : outputs) {
      if (recorder_) {
        recorder_->valid_when(output, valid);
      }
    }
  }
  void outputs_are_known() {
    if (recorder_) {
      recorder_->outputs_are_known();
    }
  }

 private:
#ifdef SELFPROJ_COVERAGE
  static constexpr Begin kBegin = Begin::zeros;  // because clearing a random value would count as a toggle
#else
  static constexpr Begin kBegin = Begin::random;
#endif
  struct Held {
    explicit Held(Begin begin)
        : dut((context.randReset(static_cast<int>(begin)), context.randSeed(++models), &context)) {}
    ~Held() {
      Verilated::threadContextp(&context);  // from which a model with open registers takes itself out
      dut.final();
    }
    VerilatedContext context;
    Dut dut;
#ifdef SELFPROJ_COVERAGE
    CoverageFile coverage{context};
#endif
  };

  inline static int models = 0;  // each model begins with different values
  sim::Reusable<Held> held_;
  std::unique_ptr<Recorder> recorder_;
};

// A model with the one clock clk_i and the reset rst_i.
template <typename Dut>
class Clocked : public Model<Dut> {
 public:
  void settle() {
    this->dut().clk_i = 0;
    this->eval();
  }
  void rise() {
    this->dut().clk_i = 1;
    this->eval();
    ++clock_;
  }
  void tick() {
    settle();
    rise();
  }

  // Reset for `clocks` clocks; the next clock is number 0.
  void reset(int clocks = 4) {
    if constexpr (requires { this->dut().rst_i; }) {
      this->dut().rst_i = 1;
      for (int i = 0; i < clocks; ++i) {
        tick();
      }
      this->dut().rst_i = 0;
    }
    clock_ = 0;
    this->outputs_are_known();
  }

  // The number of the present clock.
  std::int64_t clock() const { return clock_; }

 private:
  std::int64_t clock_ = 0;
};

// The rising edges of two unrelated clocks in order of time.
class TwoClocks {
 public:
  // Periods and the time of the first edge of b (a's is 0), in any unit.
  TwoClocks(std::int64_t period_a, std::int64_t period_b, std::int64_t phase_b)
      : period_a_(period_a), period_b_(period_b), next_b_(phase_b) {}

  struct Rises {
    bool a;
    bool b;
  };

  // Which clocks rise next, possibly both at the same time.
  Rises next() {
    const Rises rises = {next_a_ <= next_b_, next_b_ <= next_a_};
    now_ = rises.a ? next_a_ : next_b_;
    next_a_ += rises.a ? period_a_ : 0;
    next_b_ += rises.b ? period_b_ : 0;
    return rises;
  }

  std::int64_t now() const { return now_; }
  std::string describe() const { return "periods " + std::to_string(period_a_) + " and " + std::to_string(period_b_); }

  // From now on.
  void set_period_a(std::int64_t period) { period_a_ = period; }

 private:
  std::int64_t period_a_;
  std::int64_t period_b_;
  std::int64_t next_a_ = 0;
  std::int64_t next_b_;
  std::int64_t now_ = 0;
};

// The next rising edges of a model with two clocks. `set` sets the inputs of a side whose clock rises, with that clock
// low; `check` reads the outputs before the edge.
template <typename Dut, typename Set, typename Check>
void step_clocks(Model<Dut>& model, CData& clock_a, CData& clock_b, TwoClocks::Rises rises, Set set, Check check) {
  clock_a = rises.a ? 0 : clock_a;
  clock_b = rises.b ? 0 : clock_b;
  set();
  model.eval();
  check();
  clock_a = rises.a ? 1 : clock_a;
  clock_b = rises.b ? 1 : clock_b;
  model.eval();
}

// Clock pairs for a random case: equal, near to equal, and far apart.
template <typename RandomSource>
TwoClocks random_clocks(RandomSource& random) {
  constexpr std::array<std::array<int, 2>, 9> kPeriods = {{{1000, 1000},
                                                           {1000, 1001},
                                                           {1001, 1000},
                                                           {1000, 1618},
                                                           {1618, 1000},
                                                           {1000, 333},
                                                           {333, 1000},
                                                           {1000, 7919},
                                                           {6613, 800}}};
  const auto& periods = kPeriods[static_cast<std::size_t>(random.between(0, 8))];
  return {periods[0], periods[1], random.between(0, periods[1])};
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_CLOCKED_H
