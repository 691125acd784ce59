// Skid buffer, FIFOs and packet arbiter: words in order, none lost or doubled, and the timing that their headers state,
// clock by clock, with random stalls on both sides.
#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "Vsp_async_fifo_ports.h"
#include "Vsp_fifo_ports.h"
#include "Vsp_packet_arbiter_ports.h"
#include "Vsp_packet_fifo_ports.h"
#include "Vsp_skid_buffer_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// How eager the two sides are, in percent, changed now and then within a case: stalls come in spells.
struct Eagerness {
  int in = 100;
  int out = 100;

  void maybe_change(Random& random) {
    constexpr std::array<int, 5> kPercent = {0, 10, 50, 90, 100};
    if (random.chance(2)) {
      in = kPercent[static_cast<std::size_t>(random.between(0, 4))];
      out = kPercent[static_cast<std::size_t>(random.between(0, 4))];
    }
  }
};

// Two words at most: the output register and the spare one behind it.
TEST(SkidBuffer, IsATwoWordQueueWithRegisteredOutputs) {
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    Clocked<Vsp_skid_buffer> buffer;
    buffer.valid_when("m_data_o", [&] { return buffer->m_valid_o != 0; });
    buffer->s_valid_i = 0;
    buffer->m_ready_i = 0;
    buffer.reset();
    std::deque<std::uint32_t> queue;
    Eagerness eagerness;
    for (int i = 0; i < 1500; ++i) {
      eagerness.maybe_change(random);
      // no path from an input to an output: the outputs are the same before and after the inputs of the clock are set
      const auto ready_before = buffer->s_ready_o;
      const auto valid_before = buffer->m_valid_o;
      const auto data_before = buffer->m_data_o;
      buffer->s_valid_i = random.chance(eagerness.in);
      buffer->s_data_i = static_cast<std::uint32_t>(random.bits());
      buffer->m_ready_i = random.chance(eagerness.out);
      buffer.settle();
      ASSERT_EQ(buffer->s_ready_o, ready_before);
      ASSERT_EQ(buffer->m_valid_o, valid_before);
      ASSERT_EQ(buffer->m_data_o, data_before);
      ASSERT_EQ(buffer->s_ready_o, queue.size() < 2) << "clock " << buffer.clock();
      ASSERT_EQ(buffer->m_valid_o, !queue.empty()) << "clock " << buffer.clock();
      if (!queue.empty()) {
        ASSERT_EQ(buffer->m_data_o, queue.front()) << "clock " << buffer.clock();
      }
      const bool in = buffer->s_valid_i && buffer->s_ready_o;
      const bool out = buffer->m_valid_o && buffer->m_ready_i;
      if (out) {
        queue.pop_front();
      }
      if (in) {
        queue.push_back(buffer->s_data_i);
      }
      buffer.rise();
    }
  }
}

// The memory and the output register, and when a word moves from one to the other.
TEST(Fifo, FollowsItsReferenceClockByClock) {
  constexpr std::size_t kDepth = 8;
  for (const std::uint64_t seed : seeds(40)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    Clocked<Vsp_fifo> fifo;
    fifo.valid_when("m_data_o", [&] { return fifo->m_valid_o != 0; });
    fifo->s_valid_i = 0;
    fifo->m_ready_i = 0;
    fifo.reset();
    std::deque<std::uint32_t> memory;
    std::optional<std::uint32_t> output;
    Eagerness eagerness;
    bool was_full = false;
    for (int i = 0; i < 1500; ++i) {
      eagerness.maybe_change(random);
      fifo->s_valid_i = random.chance(eagerness.in);
      fifo->s_data_i = static_cast<std::uint32_t>(random.bits());
      fifo->m_ready_i = random.chance(eagerness.out);
      fifo.settle();
      was_full = was_full || memory.size() == kDepth;
      ASSERT_EQ(fifo->s_ready_o, memory.size() < kDepth) << "clock " << fifo.clock();
      ASSERT_EQ(fifo->m_valid_o, output.has_value()) << "clock " << fifo.clock();
      if (output) {
        ASSERT_EQ(fifo->m_data_o, *output) << "clock " << fifo.clock();
      }
      const bool write = fifo->s_valid_i && memory.size() < kDepth;
      const bool fetch = !memory.empty() && (!output || fifo->m_ready_i);
      if (fetch) {
        output = memory.front();
        memory.pop_front();
      } else if (fifo->m_ready_i) {
        output.reset();
      }
      if (write) {
        memory.push_back(fifo->s_data_i);
      }
      fifo.rise();
    }
    EXPECT_TRUE(was_full);
  }
}

TEST(Fifo, AWordIsAtTheOutputTwoClocksAfterItWasWritten) {
  Clocked<Vsp_fifo> fifo;
  fifo->s_valid_i = 0;
  fifo->m_ready_i = 1;
  fifo.reset();
  fifo->s_valid_i = 1;
  fifo->s_data_i = 0xC0FFEE;
  fifo.tick();  // clock 0
  fifo->s_valid_i = 0;
  fifo.settle();
  EXPECT_EQ(fifo->m_valid_o, 0);
  fifo.rise();  // clock 1
  fifo.settle();
  EXPECT_EQ(fifo->m_valid_o, 1);
  EXPECT_EQ(fifo->m_data_o, 0xC0FFEEU);
}

// A number that one clock writes and the other sees two of its edges later, as through a two-flop synchronizer.
struct Crossing {
  std::uint64_t meta = 0;
  std::uint64_t seen = 0;
  void rise(std::uint64_t value) {
    seen = meta;
    meta = value;
  }
};

// Steps a model with a write and a read clock to the next rising edge. `set` gives the inputs of a side that rises;
// `check` looks at the outputs before the edge.
template <typename Dut, typename Set, typename Check>
TwoClocks::Rises step(Model<Dut>& model, TwoClocks& clocks, Set set, Check check) {
  const TwoClocks::Rises rises = clocks.next();
  if (rises.a) {
    model->wr_clk_i = 0;
  }
  if (rises.b) {
    model->rd_clk_i = 0;
  }
  set(rises);
  model.eval();
  check(rises);
  if (rises.a) {
    model->wr_clk_i = 1;
  }
  if (rises.b) {
    model->rd_clk_i = 1;
  }
  model.eval();
  return rises;
}

template <typename Dut>
void reset_both(Model<Dut>& model, TwoClocks& clocks) {
  model->wr_clk_i = 1;
  model->rd_clk_i = 1;
  model->wr_valid_i = 0;
  model->rd_ready_i = 0;
  model->wr_rst_i = 1;
  model->rd_rst_i = 1;
  int a = 0;
  int b = 0;
  while (a < 4 || b < 4) {
    const TwoClocks::Rises rises = step(
        model, clocks, [](auto) {}, [](auto) {});
    a += rises.a;
    b += rises.b;
  }
  // each side leaves its reset in a clock of its own
  int left = 0;
  while (left != 3) {
    left |= [&] {
      const TwoClocks::Rises rises = step(
          model, clocks,
          [&](TwoClocks::Rises r) {
            model->wr_rst_i = r.a ? 0 : model->wr_rst_i;
            model->rd_rst_i = r.b ? 0 : model->rd_rst_i;
          },
          [](auto) {});
      return (rises.a ? 1 : 0) | (rises.b ? 2 : 0);
    }();
  }
  model.outputs_are_known();
}

// The places, the words, and how long each side takes to see what the other did: exactly, since a simulator has no
// metastable flops.
TEST(AsyncFifo, FollowsItsReferenceForAnyTwoClocks) {
  constexpr std::uint64_t kDepth = 8;
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    TwoClocks clocks = random_clocks(random);
    SCOPED_TRACE(clocks.describe());
    Model<Vsp_async_fifo> fifo;
    fifo.valid_when("rd_data_o", [&] { return fifo->rd_valid_o != 0; });
    reset_both(fifo, clocks);

    std::vector<std::uint32_t> written;  // all words
    std::uint64_t fetched = 0;           // words that have gone to the output register
    std::uint64_t read = 0;
    std::optional<std::uint32_t> output;
    Crossing written_there, fetched_there;
    Crossing free_there;  // two registers more
    Eagerness eagerness;
    std::uint64_t most_waiting = 0;
    for (int i = 0; i < 3000; ++i) {
      eagerness.maybe_change(random);
      if (i / 400 == 3) {  // long enough to fill it, however slow the writer's clock is
        eagerness = {100, 0};
      }
      bool write = false, fetch = false, take = false;
      const auto rises = step(
          fifo, clocks,
          [&](TwoClocks::Rises r) {
            if (r.a) {
              fifo->wr_valid_i = random.chance(eagerness.in) && fifo->wr_free_o != 0;  // the writer looks first
              fifo->wr_data_i = static_cast<std::uint32_t>(random.bits());
            }
            if (r.b) {
              fifo->rd_ready_i = random.chance(eagerness.out);
            }
          },
          [&](TwoClocks::Rises) {
            const std::uint64_t free = kDepth - (written.size() - free_there.seen);
            EXPECT_EQ(fifo->wr_free_o, free);
            EXPECT_LE(fifo->wr_free_o, kDepth - (written.size() - fetched)) << "a place is promised that is not there";
            EXPECT_EQ(fifo->rd_valid_o, output.has_value());
            if (output) {
              EXPECT_EQ(fifo->rd_data_o, *output);
            }
            write = fifo->wr_valid_i != 0;
            fetch = written_there.seen != fetched && (!output || fifo->rd_ready_i);
            take = output && fifo->rd_ready_i;
          });
      ASSERT_FALSE(::testing::Test::HasFailure()) << "step " << i;
      // both sides see what was before this edge
      const std::uint64_t written_before = written.size();
      const std::uint64_t fetched_before = fetched;
      if (rises.a) {
        free_there.rise(fetched_there.seen);
        fetched_there.rise(fetched_before);
        if (write) {
          written.push_back(fifo->wr_data_i);
        }
      }
      if (rises.b) {
        written_there.rise(written_before);
        read += take ? 1 : 0;
        if (fetch) {
          output = written[fetched++];
        } else if (take) {
          output.reset();
        }
      }
      most_waiting = std::max(most_waiting, written.size() - fetched);
    }
    EXPECT_EQ(most_waiting, kDepth);  // it was full
    EXPECT_GT(read, 20U);
  }
}

// Packets come out whole: nothing of a packet before its last word is in, and all of it without waiting for the writer.
TEST(PacketFifo, APacketShowsOnlyOnceItIsWhole) {
  constexpr int kDepth = 16;
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    TwoClocks clocks = random_clocks(random);
    SCOPED_TRACE(clocks.describe());
    Model<Vsp_packet_fifo> fifo;
    for (const char* port : {"rd_data_o", "rd_last_o"}) {
      fifo.valid_when(port, [&] { return fifo->rd_valid_o != 0; });
    }
    reset_both(fifo, clocks);

    struct Word {
      std::uint32_t data;
      bool last;
    };
    std::vector<Word> written;
    std::vector<std::size_t> packet_ends;  // words written up to each packet's end
    std::size_t read = 0;
    std::size_t packets_read = 0;
    bool in_packet = false;  // a packet has begun to leave
    int left = 0;            // words of the packet being written
    int longest = 1;
    Crossing whole_there;
    Eagerness eagerness;
    for (int i = 0; i < 4000; ++i) {
      eagerness.maybe_change(random);
      if (random.chance(1)) {
        longest = random.between(1, kDepth);
      }
      bool took = false;
      const auto rises = step(
          fifo, clocks,
          [&](TwoClocks::Rises r) {
            if (r.a) {
              // a packet begins only where all of it has room
              if (left == 0 && random.chance(eagerness.in)) {
                const int length = random.between(1, longest);
                left = length <= fifo->wr_free_o ? length : 0;
              }
              fifo->wr_valid_i = left > 0 && random.chance(std::max(eagerness.in, 10));
              fifo->wr_last_i = left == 1;
              fifo->wr_data_i = static_cast<std::uint32_t>(random.bits());
            }
            if (r.b) {
              fifo->rd_ready_i = random.chance(eagerness.out);
            }
          },
          [&](TwoClocks::Rises r) {
            if (fifo->rd_valid_o) {
              ASSERT_LT(packets_read, whole_there.seen) << "a word of a packet that is not whole";
              ASSERT_LT(read, packet_ends[packets_read]);
              EXPECT_EQ(fifo->rd_data_o, written[read].data);
              EXPECT_EQ(fifo->rd_last_o, written[read].last);
            }
            if (r.b) {
              EXPECT_TRUE(fifo->rd_valid_o || !in_packet) << "a gap within a packet";
              took = fifo->rd_valid_o && fifo->rd_ready_i;
            }
          });
      ASSERT_FALSE(::testing::Test::HasFailure()) << "step " << i;
      const std::size_t whole_before = packet_ends.size();
      if (rises.b) {
        whole_there.rise(whole_before);
      }
      if (took) {
        in_packet = !written[read].last;
        packets_read += in_packet ? 0 : 1;
        ++read;
      }
      if (rises.a && fifo->wr_valid_i) {
        written.push_back({fifo->wr_data_i, fifo->wr_last_i != 0});
        if (--left == 0) {
          packet_ends.push_back(written.size());
        }
      }
    }
    EXPECT_GT(packets_read, 20U);

    // The last packet is written to its end and all are read: every place is free again.
    for (int i = 0; i < 4000; ++i) {
      const auto rises = step(
          fifo, clocks,
          [&](TwoClocks::Rises r) {
            if (r.a) {
              fifo->wr_valid_i = left > 0;
              fifo->wr_last_i = left == 1;
            }
            if (r.b) {
              fifo->rd_ready_i = 1;
            }
          },
          [](TwoClocks::Rises) {});
      left -= rises.a && fifo->wr_valid_i ? 1 : 0;
    }
    EXPECT_FALSE(fifo->rd_valid_o);
    EXPECT_EQ(fifo->wr_free_o, kDepth);
  }
}

// A source of packets for one input of the arbiter: valid stays until its beat is taken.
struct PacketSource {
  std::uint32_t tag;
  std::uint32_t next = 0;  // number of the beat
  int left = 0;            // beats of the packet
  bool valid = false;

  void offer(Random& random, int percent) {
    if (!valid && random.chance(percent)) {
      valid = true;
      left = left == 0 ? random.between(1, 6) : left;
    }
  }
  std::uint32_t data() const { return (tag << 28 | next) * 2654435761U; }  // all different, in all bits
  bool last() const { return left == 1; }
  void taken() {
    ++next;
    --left;
    valid = false;
  }
};

TEST(PacketArbiter, JoinsWholePacketsAndTheFirstStreamGoesFirst) {
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    Clocked<Vsp_packet_arbiter> arbiter;
    for (const char* port : {"m_axis_tdata_o", "m_axis_tlast_o"}) {
      arbiter.valid_when(port, [&] { return arbiter->m_axis_tvalid_o != 0; });
    }
    arbiter->first_valid_i = 0;
    arbiter->second_valid_i = 0;
    arbiter->m_axis_tready_i = 0;
    arbiter.reset();
    PacketSource first{1};
    PacketSource second{2};
    struct Beat {
      std::uint32_t data;
      bool last;
    };
    std::deque<Beat> expected;  // at most two: what the output registers hold
    int inside = 0;             // 1, 2: a packet of that stream has begun
    Eagerness eagerness;
    int percent_second = 50;
    int packets = 0;
    for (int i = 0; i < 2000; ++i) {
      eagerness.maybe_change(random);
      percent_second = random.chance(2) ? random.between(0, 100) : percent_second;
      first.offer(random, eagerness.in);
      second.offer(random, percent_second);
      arbiter->first_valid_i = first.valid;
      arbiter->first_last_i = first.last();
      arbiter->first_data_i = first.data();
      arbiter->second_valid_i = second.valid;
      arbiter->second_last_i = second.last();
      arbiter->second_data_i = second.data();
      arbiter->m_axis_tready_i = random.chance(eagerness.out);
      arbiter.settle();

      ASSERT_EQ(arbiter->m_axis_tvalid_o, !expected.empty());
      if (!expected.empty()) {
        ASSERT_EQ(arbiter->m_axis_tdata_o, expected.front().data);
        ASSERT_EQ(arbiter->m_axis_tlast_o, expected.front().last);
      }
      // a beat is taken in every clock in which there is room, from the stream whose packet it is; else the first's
      // goes first
      const bool room = expected.size() < 2;
      const int from = inside != 0 ? inside : first.valid ? 1 : 2;
      ASSERT_EQ(arbiter->first_valid_i && arbiter->first_ready_o, room && from == 1 && first.valid);
      ASSERT_EQ(arbiter->second_valid_i && arbiter->second_ready_o, room && from == 2 && second.valid);

      if (!expected.empty() && arbiter->m_axis_tready_i) {
        expected.pop_front();
      }
      PacketSource& source = from == 1 ? first : second;
      if (room && source.valid) {
        expected.push_back({source.data(), source.last()});
        packets += source.last() ? 1 : 0;
        inside = source.last() ? 0 : from;
        source.taken();
      }
      arbiter.rise();
    }
    EXPECT_GT(packets, 50);
  }
}

}  // namespace
}  // namespace selfproj::test
