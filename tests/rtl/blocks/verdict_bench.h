// Compares verdicts of a circuit with the model, frame by frame, while limits are written and settings change.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_VERDICT_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_VERDICT_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/verdict.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::verdict {

using model::FrameVerdict;
using model::PartRule;
using model::VerdictSettings;

constexpr int kStartDelay = 14;    // from frame_i
constexpr int kVerdictDelay = 15;  // from the last beat of a frame
constexpr int kBreakDelay = 16;    // from its break
constexpr int kReadyDelay = 5;     // from start_o, and one clock more for each column
constexpr int kFirstBeat = 2;      // least clocks from ready_o

template <typename Port, typename Value>
void set(Port& port, Value value) {
  port = static_cast<Port>(value);
}

struct Build {
  int columns, rows, sections;
  bool grey;
};
template <typename Dut>
constexpr Build kBuild = {spec::kMaxColumns, spec::kMaxRows, 2, true};  // by default

// Frames of moments of any size, with gaps and breaks.
template <typename Dut>
class Bench {
 public:
  static constexpr Build kOf = kBuild<Dut>;

  explicit Bench(Random& random) : random_(random), model_(kOf.columns, kOf.sections) {
    dut_.valid_when({"first_column_o", "columns_o", "unlit_o", "section_o", "part_o", "bank_o", "in_part_o", "defect_o",
                     "lacks_light_o", "count_o", "word_o"},
                    [this] { return known_; });
    dut_->write_limits_i = dut_->write_i = dut_->frame_i = dut_->beat_valid_i = dut_->break_i = 0;
    dut_->restart_i = dut_->hold_i = dut_->by_encoder_i = 0;
    dut_->groups_i = 1;
    dut_->grey_i = 0;
    dut_.reset();
    write_words();
    write_delay(static_cast<std::uint32_t>(random_.bits()));
    for (int bank = 0; bank < 2; ++bank) {
      write_bank(bank);
    }
  }

  int parts = 0, defects = 0, dark = 0, broken = 0, sections = 0;  // of frames that were compared

  void draw_settings() {
    settings_.width = random_.chance(70) ? random_.between(1, 4) : random_.between(1, 255);
    settings_.history = random_.between(1, model::kMaxHistory);
    settings_.hits = random_.between(1, random_.chance(90) ? settings_.history : 15);
    settings_.above = random_.chance(70);
    settings_.below = random_.chance(70);
    settings_.most_unlit = random_.chance(30) ? 4095 : random_.between(0, kOf.columns / 2);
    settings_.shift_columns = random_.chance(30) ? 0 : random_.between(-20, 20);
    settings_.shift_rows = random_.chance(30) ? 0 : random_.between(-300, 300);
    if (random_.chance(10)) {
      settings_.shift_columns = random_.between(-model::kMaxShiftColumns, model::kMaxShiftColumns);
      settings_.shift_rows = random_.between(-model::kMaxShiftRows, model::kMaxShiftRows);
    }
    if (random_.chance(5)) {
      settings_.shift_columns = random_.chance(50) ? -model::kMaxShiftColumns : model::kMaxShiftColumns;
      settings_.shift_rows = random_.chance(50) ? -model::kMaxShiftRows : model::kMaxShiftRows;
    }
    settings_.bank = random_.between(0, 1);
    hold_ = random_.chance(20);
    write_words();
  }

  void draw_rule() {
    rule_.by_encoder = random_.chance(50);
    rule_.lit = random_.between(1, 8);
    rule_.dark_frames = random_.between(1, 3);
    rule_.start = encoder_ + static_cast<std::uint32_t>(random_.between(-50, 50));
    rule_.length = static_cast<std::uint32_t>(random_.between(1, 60));
    rule_.pitch = rule_.length + static_cast<std::uint32_t>(random_.between(1, 40));
    write_words();
  }

  // Writes all of a bank.
  void write_bank(int bank) {
    for (int section = 0; section < kOf.sections; ++section) {
      for (int column = 0; column < kOf.columns; ++column) {
        write(bank, section, column);
      }
      if (section > 0) {
        begin_section(bank, section);
      } else {
        put_begin(bank, 0, 0);  // is read, but says nothing
      }
    }
  }
  // Writes limits of a bank that judges nothing now, in one clock; and where one of its sections begins.
  void write_one() { write(free_bank(), random_.between(0, kOf.sections - 1), random_.between(0, kOf.columns - 1)); }
  void begin_one() { begin_section(free_bank(), random_.between(1, kOf.sections - 1)); }

  void frame() {
    encoder_ += static_cast<std::uint32_t>(random_.between(0, 6));
    if (!model_.in_part() && random_.chance(50)) {
      columns_ = 4 * random_.between(1, kOf.columns > 512 && random_.chance(90) ? 16 : kOf.columns / 4);
    }
    const int columns = columns_;
    const bool grey = kOf.grey && random_.chance(50);
    const int beats = columns / (grey ? 2 : 4);
    const bool breaks = random_.chance(15);
    const bool silent = breaks && random_.chance(30);  // it breaks before its last row
    const int come = silent ? 0 : breaks ? random_.between(0, beats - 1) : beats;
    draw_moments(columns, grey);

    const bool restarts = random_.chance(2);
    if (restarts) {
      model_.stop();
    }
    dut_->frame_i = 1;
    dut_->restart_i = restarts;
    dut_->encoder_i = encoder_ & model::kCountMask;
    set(dut_->groups_i, columns / 4);
    dut_->grey_i = grey;
    const bool writes = random_.chance(20);  // meanwhile; the reads of the circuit wait
    int wait = kStartDelay;
    if (writes && random_.chance(20)) {
      write_delay(0);  // its clock is that of the frame
    } else {
      clock();
    }
    dut_->frame_i = 0;
    dut_->restart_i = random_.chance(50);
    dut_->hold_i = random_.chance(50);  // counted with the frame
    dut_->encoder_i = static_cast<IData>(random_.bits()) & model::kCountMask;
    const auto count = static_cast<std::size_t>(come) * (grey ? 2 : 4);
    const FrameVerdict wanted =
        model_.frame(settings_, hold_, rule_, encoder_, {m0_.data(), count}, {m1_.data(), count}, !breaks);
    for (int i = 1; i < wait; ++i) {
      dut_.settle();
      ASSERT_FALSE(dut_->start_o);
      if (writes && random_.chance(20)) {
        write_delay(static_cast<std::uint32_t>(random_.bits()));
        ++wait;
      } else {
        clock();
      }
    }
    dut_.settle();
    ASSERT_TRUE(dut_->start_o);
    dut_->hold_i = hold_;
    clock();
    set(dut_->groups_i, random_.between(1, kOf.columns / 4));  // counted with start_o
    const int composing = columns + kReadyDelay;
    const int waited = silent ? random_.between(1, 2 * composing)
                              : composing + kFirstBeat + (random_.chance(50) ? 0 : random_.between(0, 9));
    for (int i = 1; i < waited; ++i) {
      dut_.settle();
      ASSERT_EQ(dut_->ready_o != 0, i == composing) << "clock " << i << ", " << columns << " columns";
      if (random_.chance(writes ? 5 : 0)) {
        write_one();
      } else {
        clock();
      }
    }
    if (silent) {
      return;
    }
    const int gaps = random_.chance(50) ? 0 : random_.between(1, 80);
    std::int64_t due = 0;
    for (int beat = 0; beat < come; ++beat) {
      while (random_.chance(gaps)) {
        clock();
      }
      send(beat, grey);
      due = dut_.clock() + kVerdictDelay;
      const bool here = breaks && beat + 1 == come && random_.chance(30);
      dut_->break_i = here;
      clock();
      if (here) {
        due = dut_.clock() - 1 + kBreakDelay;
      }
      dut_->beat_valid_i = 0;
      dut_->break_i = 0;
      broke_ = here;
    }
    if (breaks && !std::exchange(broke_, false)) {
      dut_->break_i = 1;
      due = dut_.clock() + kBreakDelay;
      clock();
      dut_->break_i = 0;
    }
    while (dut_.clock() < due) {
      clock();
    }
    compare(wanted, columns);
    broken += breaks ? 1 : 0;
  }

 private:
  int free_bank() { return model_.in_part() ? 1 - model_.bank() : random_.between(0, 1); }

  void write_delay(std::uint32_t delay) {
    delay_ = delay;
    write_word(spec::kRegEjectorDelay, delay);
  }
  void write_word(std::uint32_t address, std::uint32_t data) {
    put_word((address - spec::kRegVerdictControl) / 4, data);
  }
  void put_word(std::uint32_t word, std::uint32_t data) {
    dut_->write_i = 1;
    set(dut_->write_word_i, static_cast<int>(word));
    dut_->write_data_i = data;
    clock();
    dut_->write_i = 0;
  }

  void write_words() {
    for (const auto& [address, data] : model::verdict_writes(settings_, rule_)) {
      write_word(address, data);
    }
    dut_->hold_i = hold_;
    dut_->by_encoder_i = rule_.by_encoder;
  }

  void write(int bank, int section, int column) {
    const int middle = model::kRowParts * random_.between(1, kOf.rows);
    const int band =
        random_.chance(50) ? random_.between(0, 2 * model::kRowParts) : model::kRowParts * random_.between(0, 2);
    const int limit_bits = std::bit_width(static_cast<unsigned>(kOf.rows)) + 7;
    model::ColumnLimits limits = {static_cast<std::uint32_t>(std::max(0, middle - band)),
                                  static_cast<std::uint32_t>(std::min(model::kRowParts * kOf.rows, middle + band)),
                                  random_.chance(90)};
    if (random_.chance(5)) {
      limits.high = static_cast<std::uint32_t>(random_.between(0, (1 << limit_bits) - 1));
      limits.low = static_cast<std::uint32_t>(random_.between(0, static_cast<int>(limits.high)));
    }
    model_.write(bank, section, column, limits);
    limits_[place(bank, section, column)] = limits;
    dut_->write_limits_i = 1;
    dut_->write_bank_i = bank != 0;
    set(dut_->write_section_i, section);
    set(dut_->write_column_i, column);
    set(dut_->write_limits_word_i, (static_cast<std::uint64_t>(limits.judged) << 2 * limit_bits) |
                                       (static_cast<std::uint64_t>(limits.high) << limit_bits) | limits.low);
    clock();
    dut_->write_limits_i = 0;
  }

  void begin_section(int bank, int section) {
    const auto count = static_cast<std::uint32_t>(random_.between(0, 60));
    model_.begin_section(bank, section, count);
    put_begin(bank, section, count);
  }
  void put_begin(int bank, int section, std::uint32_t count) {
    put_word(16U + static_cast<std::uint32_t>(bank * kOf.sections + section), count);
  }

  static std::size_t place(int bank, int section, int column) {
    return static_cast<std::size_t>((bank * kOf.sections + section) * kOf.columns + column);
  }

  // Half of the columns lie near limits, if the frame is in that section, or at one of them.
  void draw_moments(int columns, bool grey) {
    m0_.assign(static_cast<std::size_t>(columns), 0);
    m1_ = m0_;
    const int unlit = random_.chance(50) ? 3 : random_.between(0, 100);
    for (std::size_t c = 0; c < m0_.size(); ++c) {
      if (random_.chance(unlit)) {
        continue;
      }
      const int most = (grey ? 255 : 1) * kOf.rows;
      const int m0 = random_.between(1, most);
      int row_parts = random_.between(model::kRowParts, model::kRowParts * kOf.rows);
      int rest = random_.between(0, model::kRowParts - 1);
      const int from = static_cast<int>(c) - settings_.shift_columns;
      if (from >= 0 && from < kOf.columns && random_.chance(50)) {
        const auto& of = limits_[place(model_.bank(), random_.between(0, kOf.sections - 1), from)];
        const int near = random_.chance(40) ? 0 : random_.between(-2 * model::kRowParts, 2 * model::kRowParts);
        row_parts = static_cast<int>(random_.chance(50) ? of.low : of.high) + settings_.shift_rows + near;
        row_parts = std::clamp(row_parts, model::kRowParts, model::kRowParts * kOf.rows);
        rest = random_.chance(50) ? 0 : model::kRowParts - 1;
      }
      m0_[c] = static_cast<std::uint32_t>(m0);
      m1_[c] = static_cast<std::uint32_t>((static_cast<std::int64_t>(row_parts) * m0 + rest) / model::kRowParts);
      m1_[c] = std::min(m1_[c], static_cast<std::uint32_t>(most * (kOf.rows + 1) / 2));
      if (random_.chance(20)) {  // in the middle of a row, where many limits are
        m0_[c] = static_cast<std::uint32_t>(random_.between(1, most / kOf.rows));
        m1_[c] = m0_[c] * static_cast<std::uint32_t>(random_.between(1, kOf.rows));
      }
    }
  }

  void send(int beat, bool grey) {
    Word128 data = {};
    for (int i = 0; i < (grey ? 2 : 4); ++i) {
      const auto column = static_cast<std::size_t>(beat * (grey ? 2 : 4) + i);
      if (grey) {
        const std::uint64_t word = static_cast<std::uint64_t>(m1_[column]) << spec::kGreyM1Lsb |
                                   static_cast<std::uint64_t>(m0_[column]) << spec::kGreyM0Lsb |
                                   random_.bits() << spec::kGreyNLsb;
        data[static_cast<std::size_t>(2 * i)] = static_cast<std::uint32_t>(word);
        data[static_cast<std::size_t>(2 * i + 1)] = static_cast<std::uint32_t>(word >> 32);
      } else {
        data[static_cast<std::size_t>(i)] =
            m1_[column] << spec::kBinaryRunM1Lsb | m0_[column] << spec::kBinaryRunM0Lsb |
            (random_.chance(50) ? 1U << spec::kBinaryRunSecondLsb : 0) |
            static_cast<std::uint32_t>(random_.between(0, 3)) << spec::kBinaryRunRunsLsb;
      }
    }
    set128(dut_->beat_data_i, data);
    dut_->beat_valid_i = 1;
  }

  void clock() {
    dut_.settle();
    EXPECT_FALSE(dut_->verdict_valid_o) << "clock " << dut_.clock();
    EXPECT_FALSE(dut_->first_bad_o) << "clock " << dut_.clock();
    dut_.rise();
    known_ = false;
  }

  void compare(const FrameVerdict& wanted, int columns) {
    dut_.settle();
    ASSERT_TRUE(dut_->verdict_valid_o) << "clock " << dut_.clock();

    known_ = true;
    ASSERT_EQ(dut_->in_part_o != 0, wanted.in_part);
    ASSERT_EQ(dut_->defect_o != 0, wanted.defect);
    ASSERT_EQ(dut_->lacks_light_o != 0, wanted.lacks_light);
    ASSERT_EQ(dut_->unlit_o, wanted.unlit) << columns << " columns";
    ASSERT_EQ(dut_->first_column_o, wanted.first_column);
    ASSERT_EQ(dut_->columns_o, wanted.columns);
    ASSERT_EQ(dut_->section_o, wanted.section);
    ASSERT_EQ(dut_->part_o, wanted.part);
    ASSERT_EQ(dut_->bank_o, wanted.bank);
    ASSERT_EQ(dut_->passes_o != 0, model_.in_part());
    ASSERT_EQ(dut_->count_o, encoder_ & model::kCountMask);
    ASSERT_EQ(dut_->first_bad_o != 0, wanted.first_bad);
    ASSERT_EQ(dut_->word_o, delay_);
    parts = static_cast<int>(model_.parts());
    defects += wanted.defect ? 1 : 0;
    dark += wanted.lacks_light ? 1 : 0;
    sections = std::max(sections, wanted.section);
    dut_.rise();
    known_ = false;
    dut_.settle();
    ASSERT_FALSE(dut_->verdict_valid_o);
  }

  Random& random_;
  Clocked<Dut> dut_;
  model::Verdict model_;
  VerdictSettings settings_;
  PartRule rule_;
  std::uint32_t encoder_ = 0xFFFF'FF00;  // wraps
  std::vector<std::uint32_t> m0_, m1_;
  bool known_ = false, broke_ = false;
  int columns_ = kOf.columns;
  bool hold_ = false;
  std::uint32_t delay_ = 0;
  std::vector<model::ColumnLimits> limits_ = std::vector<model::ColumnLimits>(place(2, 0, 0));
};

template <typename Dut>
void random_frames(int cases, int frames) {
  int defects = 0, dark = 0, broken = 0, parts = 0, sections = 0;
  for_cases(cases, [&](Random& random) {
    Bench<Dut> bench(random);
    bench.draw_settings();
    bench.draw_rule();
    for (int i = 0; i < frames; ++i) {
      if (random.chance(10)) {
        bench.draw_settings();
      }
      if (random.chance(3)) {
        bench.draw_rule();
      }
      for (int writes = random.chance(30) ? random.between(1, 20) : 0; writes > 0; --writes) {
        bench.write_one();
      }
      if (Bench<Dut>::kOf.sections > 1 && random.chance(5)) {
        bench.begin_one();
      }
      bench.frame();
      ASSERT_FALSE(testing::Test::HasFatalFailure()) << "frame " << i;
    }
    defects += bench.defects;
    dark += bench.dark;
    broken += bench.broken;
    parts += bench.parts;
    sections = std::max(sections, bench.sections);
  });
  if (runs_all_cases()) {
    EXPECT_GT(defects, cases);
    EXPECT_GT(dark, cases);
    EXPECT_GT(broken, cases);
    EXPECT_GT(parts, 2 * cases);
    EXPECT_EQ(sections, Bench<Dut>::kOf.sections - 1);
  }
}

}  // namespace selfproj::test::verdict

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_VERDICT_BENCH_H
