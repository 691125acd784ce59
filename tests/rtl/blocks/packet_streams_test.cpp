// Tests streams of packets: the packet FIFO between two clocks, and the arbiter that joins two streams.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "Vsp_packet_arbiter_ports.h"
#include "Vsp_packet_fifo_of_five_ports.h"
#include "Vsp_packet_fifo_ports.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/streams_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test::streams {
namespace {

// A packet FIFO with a writer and a reader, and the words that have gone in and come out. Packets have at least
// `shortest` words.
template <typename Fifo>
class PacketFifoBench {
 public:
  static constexpr int kDepth = 16;

  PacketFifoBench(Random& random, TwoClocks& clocks, int shortest)
      : random_(random), clocks_(clocks), shortest_(shortest), longest_(shortest) {
    fifo_.valid_when({"rd_data_o", "rd_last_o"}, [this] { return fifo_->rd_valid_o != 0; });
    reset_both(fifo_, clocks_);
  }

  [[nodiscard]] std::size_t packets_read() const { return packets_read_; }

  // Steps to the next edge, with random words and stalls on both sides.
  void random_step() {
    eagerness_.maybe_change(random_);
    if (random_.chance(1)) {
      longest_ = random_.between(shortest_, kDepth);
    }
    bool took = false;
    const auto rises = step(
        fifo_, clocks_, [&](TwoClocks::Rises r) { drive(r); }, [&](TwoClocks::Rises r) { took = check(r); });
    const std::size_t whole_before = packet_ends_.size();
    if (rises.b) {
      whole_there_.rise(whole_before);
    }
    if (took) {
      in_packet_ = !written_[read_].last;
      packets_read_ += in_packet_ ? 0 : 1;
      ++read_;
    }
    if (rises.a && fifo_->wr_valid_i) {
      written_.push_back({fifo_->wr_data_i, fifo_->wr_last_i != 0});
      if (--left_ == 0) {
        packet_ends_.push_back(written_.size());
      }
    }
  }

  // Writes the last packet to its end and reads everything. Every place must then be free.
  void expect_all_read() {
    for (int i = 0; i < 4000; ++i) {
      const auto rises = step(
          fifo_, clocks_,
          [&](TwoClocks::Rises r) {
            if (r.a) {
              fifo_->wr_valid_i = left_ > 0;
              fifo_->wr_last_i = left_ == 1;
            }
            if (r.b) {
              fifo_->rd_ready_i = 1;
            }
          },
          [](TwoClocks::Rises) {});
      left_ -= rises.a && fifo_->wr_valid_i ? 1 : 0;
    }
    EXPECT_FALSE(fifo_->rd_valid_o);
    EXPECT_EQ(fifo_->wr_free_o, kDepth);
  }

 private:
  struct Word {
    std::uint32_t data;
    bool last;
  };

  void drive(TwoClocks::Rises rises) {
    if (rises.a) {
      // a packet begins only if all of it fits
      if (left_ == 0 && random_.chance(eagerness_.in)) {
        const int length = random_.between(shortest_, longest_);
        left_ = length <= fifo_->wr_free_o ? length : 0;
      }
      fifo_->wr_valid_i = left_ > 0 && random_.chance(std::max(eagerness_.in, 10));
      fifo_->wr_last_i = left_ == 1;
      fifo_->wr_data_i = static_cast<std::uint32_t>(random_.bits());
    }
    if (rises.b) {
      fifo_->rd_ready_i = random_.chance(eagerness_.out);
    }
  }

  // Whether the reader takes a word at this edge.
  bool check(TwoClocks::Rises rises) {
    if (fifo_->rd_valid_o) {
      if (packets_read_ >= whole_there_.seen || read_ >= packet_ends_[packets_read_]) {
        ADD_FAILURE() << "a word of a packet that is not whole";
        return false;
      }
      EXPECT_EQ(fifo_->rd_data_o, written_[read_].data);
      EXPECT_EQ(fifo_->rd_last_o, written_[read_].last);
    }
    if (!rises.b) {
      return false;
    }
    EXPECT_TRUE(fifo_->rd_valid_o || !in_packet_) << "a gap within a packet";
    return fifo_->rd_valid_o && fifo_->rd_ready_i;
  }

  Random& random_;
  TwoClocks& clocks_;
  int shortest_;
  int longest_;
  Model<Fifo> fifo_;
  std::vector<Word> written_;
  std::vector<std::size_t> packet_ends_;  // words written up to each packet's end
  std::size_t read_ = 0;
  std::size_t packets_read_ = 0;
  bool in_packet_ = false;  // a packet has begun to leave
  int left_ = 0;            // words of the packet being written
  Crossing whole_there_;
  Eagerness eagerness_;
};

// Packets come out whole. No word of a packet leaves before its last word is in, and then all of it leaves without
// waiting for the writer.
template <typename Fifo>
void expect_whole_packets(int shortest) {
  for_cases(60, [&](Random& random) {
    TwoClocks clocks = random_clocks(random);
    SCOPED_TRACE(clocks.describe());
    PacketFifoBench<Fifo> bench(random, clocks, shortest);
    for (int i = 0; i < 4000; ++i) {
      bench.random_step();
      ASSERT_FALSE(::testing::Test::HasFailure()) << "step " << i;
    }
    EXPECT_GT(bench.packets_read(), 20U);
    bench.expect_all_read();
  });
}

TEST(PacketFifo, APacketShowsOnlyOnceItIsWhole) { expect_whole_packets<Vsp_packet_fifo>(1); }

// If packets have at least five words, the FIFO counts them with fewer bits.
TEST(PacketFifo, PacketsOfFiveWordsAtLeast) { expect_whole_packets<Vsp_packet_fifo_of_five>(5); }

// A source of packets for one input of the arbiter. Valid stays until the beat is taken.
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
  for_cases(60, [&](Random& random) {
    Clocked<Vsp_packet_arbiter> arbiter;
    arbiter.valid_when({"m_axis_tdata_o", "m_axis_tlast_o"}, [&] { return arbiter->m_axis_tvalid_o != 0; });
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
      // every clock with room takes a beat: of the stream whose packet is under way, else of the first stream
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
  });
}

}  // namespace
}  // namespace selfproj::test::streams
