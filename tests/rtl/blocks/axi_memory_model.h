// A simple model of a memory behind an AXI4 port, with latency and stalls: bursts of 16-byte words, in order.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_AXI_MEMORY_MODEL_H
#define SELFPROJ_TESTS_RTL_BLOCKS_AXI_MEMORY_MODEL_H

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <vector>

#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

class AxiMemory {
 public:
  AxiMemory(Random& random, std::size_t words) : random_(random), words_(words) {}

  std::uint64_t base = 0;  // address of the first word
  int stall_percent = 0;   // share of clocks in which a channel is not ready or gives nothing
  int latency = 1;         // clocks from a read's address to its first word, and from a burst's last word to its answer
  int answer_latency = 0;  // the latter, if it differs
  int write_pause = 0;     // clocks for which no address is taken after a write address

  std::size_t max_unanswered = 0;  // bursts that were written but not answered

  // At the start: sets the base; nothing is requested, and the memory drives nothing. `dut` as below.
  template <typename Dut>
  void at_rest(Dut& dut) const {
    dut.base_i = static_cast<IData>(base);
    dut.rd_en_i = 0;
    dut.wr_en_i = 0;
    dut.end_i = 0;
    dut.m_axi_rvalid_i = 0;
    dut.m_axi_bvalid_i = 0;
    dut.m_axi_arready_i = 0;
    dut.m_axi_awready_i = 0;
    dut.m_axi_wready_i = 0;
  }

  // Before the clock edge: sets the outputs of the memory for this clock. `dut` has the ports of sp_gray_axi_memory.
  template <typename Dut>
  void drive(Dut& dut, std::int64_t now) {
    dut.m_axi_arready_i = !stalls();
    dut.m_axi_awready_i = now >= aw_from_ && !stalls();
    dut.m_axi_wready_i = !stalls();
    dut.m_axi_rvalid_i = !reads_.empty() && reads_.front().from <= now && (offered_r_ || !stalls());
    offered_r_ = dut.m_axi_rvalid_i != 0;  // an offer stays until it is taken
    Word128 word{};
    for (std::uint32_t& part : word) {
      part = static_cast<std::uint32_t>(random_.bits());
    }
    set128(dut.m_axi_rdata_i, dut.m_axi_rvalid_i != 0 ? words_.at(reads_.front().at) : word);
    dut.m_axi_bvalid_i = !answers_.empty() && answers_.front() <= now;
  }

  // At the clock edge: takes over what the circuit offered, and checks the rules of AXI4.
  template <typename Dut>
  void edge(Dut& dut, std::int64_t now) {
    if (waiting_ar_) {
      ASSERT_TRUE(dut.m_axi_arvalid_o != 0 && dut.m_axi_araddr_o == ar_) << "a read's address changed, clock " << now;
    }
    waiting_ar_ = dut.m_axi_arvalid_o != 0 && dut.m_axi_arready_i == 0;
    ar_ = dut.m_axi_araddr_o;
    if (waiting_aw_) {
      ASSERT_TRUE(dut.m_axi_awvalid_o != 0 && dut.m_axi_awaddr_o == aw_ && dut.m_axi_awlen_o == aw_length_)
          << "a write's address changed, clock " << now;
    }
    waiting_aw_ = dut.m_axi_awvalid_o != 0 && dut.m_axi_awready_i == 0;
    aw_ = dut.m_axi_awaddr_o;
    aw_length_ = dut.m_axi_awlen_o;
    if (waiting_w_) {
      ASSERT_TRUE(dut.m_axi_wvalid_o != 0) << "a word to write was taken back, clock " << now;
    }
    waiting_w_ = dut.m_axi_wvalid_o != 0 && dut.m_axi_wready_i == 0;

    if (dut.m_axi_rvalid_i != 0 && dut.m_axi_rready_o != 0) {
      reads_.pop_front();
      offered_r_ = false;
    }
    if (dut.m_axi_bvalid_i != 0 && dut.m_axi_bready_o != 0) {
      answers_.pop_front();
      unanswered_.pop_front();
    }
    if (dut.m_axi_arvalid_o != 0 && dut.m_axi_arready_i != 0) {
      // A memory may answer reads before writes. To read a new word, wait for the answer to its write.
      for (const std::uint64_t burst : unanswered_) {
        ASSERT_NE(dut.m_axi_araddr_o, burst) << "read before its write was answered, clock " << now;
      }
      for (std::uint32_t i = 0; i <= dut.m_axi_arlen_o; ++i) {
        reads_.push_back({(dut.m_axi_araddr_o - base) / 16U + i, now + latency});
      }
    }
    if (dut.m_axi_awvalid_o != 0 && dut.m_axi_awready_i != 0) {
      ASSERT_EQ(dut.m_axi_awaddr_o % 16, 0U);
      ASSERT_EQ(dut.m_axi_awaddr_o / 4096, (dut.m_axi_awaddr_o + 16U * dut.m_axi_awlen_o) / 4096) << "crosses 4 KiB";
      for (std::uint32_t i = 0; i <= dut.m_axi_awlen_o; ++i) {
        writes_.push_back({(dut.m_axi_awaddr_o - base) / 16U + i, i == dut.m_axi_awlen_o});
      }
      unanswered_.push_back(dut.m_axi_awaddr_o);
      max_unanswered = std::max(max_unanswered, unanswered_.size());
      aw_from_ = now + 1 + write_pause;
    }
    if (dut.m_axi_wvalid_o != 0 && dut.m_axi_wready_i != 0) {
      ASSERT_FALSE(writes_.empty()) << "a word before its address, clock " << now;
      ASSERT_EQ(dut.m_axi_wlast_o != 0, writes_.front().last) << "clock " << now;
      words_.at(writes_.front().at) = word128(dut.m_axi_wdata_o);
      if (writes_.front().last) {
        answers_.push_back(now + (answer_latency != 0 ? answer_latency : latency));
      }
      writes_.pop_front();
    }
  }

 private:
  struct Read {
    std::size_t at;
    std::int64_t from;
  };
  struct Write {
    std::size_t at;
    bool last;
  };

  bool stalls() { return stall_percent != 0 && random_.chance(stall_percent); }

  Random& random_;
  std::vector<Word128> words_;
  std::deque<Read> reads_;
  std::deque<Write> writes_;
  std::deque<std::int64_t> answers_;
  std::deque<std::uint64_t> unanswered_;  // addresses of bursts
  std::int64_t aw_from_ = 0;
  bool offered_r_ = false;
  bool waiting_ar_ = false;
  bool waiting_aw_ = false;
  bool waiting_w_ = false;
  std::uint64_t ar_ = 0;
  std::uint64_t aw_ = 0;
  std::uint32_t aw_length_ = 0;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_AXI_MEMORY_MODEL_H
