// Tests the front end for parallel sensors with a sensor whose clock jitters, stops and is too fast.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <type_traits>
#include <vector>

#include "Vsp_parallel_sensor_ports.h"
#include "Vsp_parallel_sensor_two_ports.h"
#include "tests/rtl/blocks/camera_beats.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// A sensor and the board's side of its front end.
template <typename Sensor>
class SensorBench {
 public:
  SensorBench(std::uint64_t seed, std::int64_t sensor_period, std::int64_t board_period, int bits, int per_clock,
              bool stopped = false)
      : random_(seed),
        clocks_(sensor_period, board_period, random_.between(0, 900)),
        period_(sensor_period),
        bits_(bits),
        per_clock_(per_clock),
        stopped_(stopped) {
    name_ports(sensor_);
    sensor_.valid_when({"overrun_o"}, [this] { return known_; });
    sensor_->sensor_clk_i = 0;
    sensor_->clk_i = 0;
    sensor_->frame_i = 0;
    sensor_->line_i = 0;
    sensor_->data_i = 0;
    sensor_->rst_i = 0;
    board_clock();  // so that simulators see an edge of the asynchronous reset; hardware looks at its level
    reset();
    known_ = true;
  }

  void reset() {
    sensor_->rst_i = 1;
    for (int i = 0; i < 4; ++i) {
      board_clock();
    }
    sensor_->rst_i = 0;
    sensor_.outputs_are_known();
  }

  // Queues a frame and the clocks without line valid behind each line, the last ones without frame valid. Returns it as
  // the board is to get it.
  Frame send(int rows, int columns, int max_gap) {
    Frame due;
    for (int row = 0; row < rows; ++row) {
      std::uint32_t beat = 0;
      for (int column = 0; column < columns; column += per_clock_) {
        Pins pins{true, true, 0};
        for (int i = 0; i < per_clock_; ++i) {
          const auto pixel = static_cast<std::uint32_t>(random_.between(0, (1 << bits_) - 1));
          pins.data |= pixel << static_cast<unsigned>(bits_ * i);
          beat = beat >> 8U | pixel >> static_cast<unsigned>(bits_ - 8) << 24U;
        }
        pins_.push_back(pins);
        if ((column + per_clock_) % 4 == 0) {
          due.push_back({beat, due.empty(), column + per_clock_ + 4 > columns});
        }
      }
      const bool last = row + 1 == rows;
      for (int gap = random_.between(1, max_gap); gap > 0; --gap) {
        // Line valid without frame valid is nothing.
        pins_.push_back({!last, last && random_.chance(50), static_cast<std::uint32_t>(random_.bits()) & mask()});
      }
    }
    return due;
  }

  void lead(int clocks) {
    for (int i = 0; i < clocks; ++i) {
      pins_.push_back({true, false, 0});
    }
  }

  // Until everything is in, and `quiet` clocks of the board more.
  void drain(int quiet = 200) {
    while (!pins_.empty()) {
      step();
    }
    for (int i = 0; i < quiet; ++i) {
      board_clock();
    }
  }

  void board_clock() {
    while (!step().b) {
    }
  }

  void stop_sensor() { stopped_ = true; }
  void start_sensor() { stopped_ = false; }

  [[nodiscard]] const std::vector<Beat>& beats() const { return beats_; }
  [[nodiscard]] int overruns() const { return overruns_; }
  void forget() { beats_.clear(); }

 private:
  struct Pins {
    bool frame = false;
    bool line = false;
    std::uint32_t data = 0;
  };

  [[nodiscard]] std::uint32_t mask() const { return (1U << static_cast<unsigned>(bits_ * per_clock_)) - 1; }

  TwoClocks::Rises step() {
    TwoClocks::Rises rises = clocks_.next();
    if (rises.a) {
      clocks_.set_period_a(period_ - period_ / 4 + random_.between(0, static_cast<int>(period_ / 2)));
      rises.a = !stopped_;
    }
    step_clocks(
        sensor_, sensor_->sensor_clk_i, sensor_->clk_i, rises,
        [&] {
          if (rises.a) {
            const Pins pins = pins_.empty() ? Pins{} : pins_.front();
            if (!pins_.empty()) {
              pins_.pop_front();
            }
            sensor_->frame_i = pins.frame;
            sensor_->line_i = pins.line;
            sensor_->data_i = static_cast<std::remove_reference_t<decltype(sensor_->data_i)>>(pins.data);
          }
        },
        [&] {
          if (rises.b && known_) {
            if (sensor_->m_valid_o) {
              beats_.push_back(beat_of(sensor_));
            }
            overruns_ += sensor_->overrun_o;
          }
        });
    return rises;
  }

  Random random_;
  TwoClocks clocks_;
  std::int64_t period_;
  int bits_;
  int per_clock_;
  Model<Sensor> sensor_;
  std::deque<Pins> pins_;
  std::vector<Beat> beats_;
  int overruns_ = 0;
  bool stopped_;
  bool known_ = false;
};

// Lines of any length, gaps of one clock and more, and clocks in any relation as long as the board takes what comes.
template <typename Sensor>
void expect_every_beat(int bits, int per_clock) {
  constexpr std::array<std::array<int, 2>, 5> kPeriods = {
      {{1000, 2000}, {1000, 1000}, {1000, 333}, {1618, 1000}, {1000, 1300}}};
  for_cases(10, [&](Random& random, std::uint64_t seed) {
    const auto& periods = kPeriods[seed % kPeriods.size()];
    SensorBench<Sensor> bench(seed, periods[0] * per_clock, periods[1], bits, per_clock);
    bench.drain();
    std::vector<Beat> due;
    for (int frame = 0; frame < 20; ++frame) {
      bench.lead(random.between(0, 3));
      const int columns = random.chance(50) ? 4 * random.between(1, 12) : per_clock * random.between(4, 23);
      const Frame sent = bench.send(random.between(1, 6), columns, random.chance(50) ? 1 : 9);
      due.insert(due.end(), sent.begin(), sent.end());
    }
    bench.drain();
    ASSERT_EQ(bench.beats(), due);
    EXPECT_EQ(bench.overruns(), 0);
  });
}
TEST(ParallelSensor, OnePixelAClock) { expect_every_beat<Vsp_parallel_sensor>(10, 1); }
TEST(ParallelSensor, TwoPixelsAClock) { expect_every_beat<Vsp_parallel_sensor_two>(12, 2); }

// A board too slow for the sensor: each frame comes whole, or it is the beginning of one, and counted.
TEST(ParallelSensor, AFrameThatIsTooFastIsCutOffAndCounted) {
  int cut_off = 0;
  int whole = 0;
  for_cases(10, [&](Random& random, std::uint64_t seed) {
    SensorBench<Vsp_parallel_sensor_two> bench(seed, 1000, random.between(2500, 5000), 12, 2);
    bench.drain();
    std::vector<Frame> sent;
    for (int frame = 0; frame < 30; ++frame) {
      sent.push_back(bench.send(random.between(2, 7), 4 * random.between(4, 20), random.chance(50) ? 2 : 60));
    }
    bench.drain();
    const int lost = expect_frames(bench.beats(), sent, std::vector<bool>(sent.size(), true));
    whole += static_cast<int>(sent.size()) - lost;
    EXPECT_EQ(bench.overruns(), lost);
    cut_off += lost;
  });
  if (runs_all_cases()) {
    EXPECT_GT(cut_off, 50);
    EXPECT_GT(whole, 50);
  }
}

// Resets in the middle of a frame, with the sensor's clock running or not: what comes after begins with a whole frame.
TEST(ParallelSensor, AfterAResetTheNextFrameIsTheFirst) {
  for_cases(20, [&](Random& random, std::uint64_t seed) {
    SensorBench<Vsp_parallel_sensor> bench(seed, 1000, random.between(300, 1500), 10, 1);
    for (int round = 0; round < 3; ++round) {
      bench.drain();
      bench.forget();
      bench.send(4, 24, 3);
      for (int clocks = random.between(0, 60); clocks > 0; --clocks) {
        bench.board_clock();
      }
      if (random.chance(50)) {
        bench.stop_sensor();
        bench.reset();
        bench.forget();
        for (int clocks = random.between(0, 60); clocks > 0; --clocks) {
          bench.board_clock();
        }
        bench.start_sensor();
      } else {
        bench.reset();
        bench.forget();
      }
      bench.drain();
      EXPECT_TRUE(bench.beats().empty()) << "the rest of a frame";
      bench.forget();
      const Frame due = bench.send(3, 20, 5);
      bench.drain();
      ASSERT_EQ(bench.beats(), due);
    }
    EXPECT_EQ(bench.overruns(), 0);
  });
}

// Nothing leaves before the sensor's clock has begun, whatever the registers held when the power came.
TEST(ParallelSensor, WaitsForTheFirstClocksOfTheSensor) {
  for_cases(20, [&](Random& random, std::uint64_t seed) {
    SensorBench<Vsp_parallel_sensor> bench(seed, 1000, random.between(300, 1500), 10, 1, true);
    for (int clocks = random.between(20, 100); clocks > 0; --clocks) {
      bench.board_clock();
    }
    bench.start_sensor();
    bench.drain();
    EXPECT_TRUE(bench.beats().empty()) << "what was in the registers";
    bench.forget();
    const Frame due = bench.send(3, 20, 5);
    bench.drain();
    ASSERT_EQ(bench.beats(), due);
    EXPECT_EQ(bench.overruns(), 0);
  });
}

}  // namespace
}  // namespace selfproj::test
