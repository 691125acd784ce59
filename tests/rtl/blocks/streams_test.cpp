// Tests streams of single words: compares skid buffer, FIFO and dual-clock FIFO with a queue clock by clock.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "Vsp_async_fifo_ports.h"
#include "Vsp_fifo_ports.h"
#include "Vsp_skid_buffer_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/streams_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::streams {
namespace {

// At most two words: the output register and the spare one behind it.
TEST(SkidBuffer, IsATwoWordQueueWithRegisteredOutputs) {
  for_cases(40, [&](Random& random) {
    Clocked<Vsp_skid_buffer> buffer;
    buffer.valid_when({"m_data_o"}, [&] { return buffer->m_valid_o != 0; });
    buffer->s_valid_i = 0;
    buffer->m_ready_i = 0;
    buffer.reset();
    std::deque<std::uint32_t> queue;
    Eagerness eagerness;
    for (int i = 0; i < 1500; ++i) {
      eagerness.maybe_change(random);
      // no path leads from an input to an output: setting the inputs does not change the outputs
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
  });
}

// Models the memory and the output register, and when a word moves from one to the other.
TEST(Fifo, FollowsItsReferenceClockByClock) {
  constexpr std::size_t kDepth = 8;
  for_cases(40, [&](Random& random) {
    Clocked<Vsp_fifo> fifo;
    fifo.valid_when({"m_data_o"}, [&] { return fifo->m_valid_o != 0; });
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
  });
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

// Models the places, the words, and the delay until each side sees the actions of the other. The delay is exact, since
// a simulator has no metastable flip-flops.
TEST(AsyncFifo, FollowsItsReferenceForAnyTwoClocks) {
  constexpr std::uint64_t kDepth = 8;
  for_cases(60, [&](Random& random) {
    TwoClocks clocks = random_clocks(random);
    SCOPED_TRACE(clocks.describe());
    Model<Vsp_async_fifo> fifo;
    fifo.valid_when({"rd_data_o"}, [&] { return fifo->rd_valid_o != 0; });
    reset_both(fifo, clocks);

    std::vector<std::uint32_t> written;  // all words
    std::uint64_t fetched = 0;           // words that have gone to the output register
    std::uint64_t read = 0;
    std::optional<std::uint32_t> output;
    Crossing written_there, fetched_there;
    Crossing free_there;  // two registers more
    Eagerness eagerness;
    std::uint64_t max_waiting = 0;
    for (int i = 0; i < 3000; ++i) {
      eagerness.maybe_change(random);
      if (i / 400 == 3) {  // long enough to fill it even with a slow writer's clock
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
      // both sides see the state before this edge
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
      max_waiting = std::max(max_waiting, written.size() - fetched);
    }
    EXPECT_EQ(max_waiting, kDepth);  // it was full
    EXPECT_GT(read, 20U);
  });
}

}  // namespace
}  // namespace selfproj::test::streams
