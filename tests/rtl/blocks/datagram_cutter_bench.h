// Packets into the cutter, and datagrams out of it, each compared with the next one of the model.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_DATAGRAM_CUTTER_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_DATAGRAM_CUTTER_BENCH_H

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "Vsp_datagram_cutter_small_ports.h"
#include "model/datagram.h"
#include "selfproj/model/little_endian.h"
#include "tests/host/driver/packets.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

inline constexpr std::size_t kBeatBytes = spec::kPacketBeatBytes;
inline constexpr std::size_t kSmallBytes = 80;  // of Vsp_datagram_cutter_small: four beats a piece, eight in the ring
inline constexpr int kSmallIdle = 40;           // its IdleClocks
inline constexpr int kCutterLatency = 4;        // from the last beat of a piece to the first word of its datagram

// A cutter between a source of packets and a network. Each datagram that comes out must be the next one of the model.
template <typename Cutter>
class CutterBench {
 public:
  explicit CutterBench(std::size_t datagram_bytes) : datagram_bytes_(datagram_bytes) {
    cutter_.valid_when({"m_data_o", "m_last_o", "m_bytes_o"}, [this] { return cutter_->m_valid_o != 0; });
    cutter_->enable_i = 0;
    reset();
  }

  // Ends everything that is under way, on both sides.
  void reset() {
    cutter_->s_valid_i = 0;
    cutter_->m_ready_i = 0;
    cutter_.reset();
    packets_.clear();
    taken_.clear();
    due_.clear();
    arriving_.clear();
    shown_.reset();
    at_ = 0;
    ahead_ = false;
    offered_ = false;
    cutter_->enable_i = 0;
  }

  // Begins a session in the next clock. None is open.
  void begin_session(std::uint16_t number) {
    session_ = number;
    model_.emplace(number, datagram_bytes_);
    cutter_->enable_i = 1;
    cutter_->session_i = number;
    clock(0, 100);
    cutter_->session_i = static_cast<SData>(~number);
  }

  // The model goes on as if so many datagrams and packets of the session had come.
  void go_on_after(std::uint32_t datagrams, std::uint32_t packets) {
    model_.emplace(session_, datagram_bytes_, datagrams, packets);
  }

  // One clock, with inputs that come with these chances in percent. Returns whether a word left.
  bool clock(int in, int out) {
    offered_ = offered_ || (!packets_.empty() && in > 0 && (in == 100 || random_.chance(in)));
    cutter_->s_valid_i = offered_;
    if (offered_) {
      const Bytes& packet = packets_.front();
      Word128 beat{};
      for (std::size_t i = 0; i < beat.size(); ++i) {
        beat[i] = model::load_little_endian<std::uint32_t>(packet.data() + at_ + 4 * i);
      }
      set128(cutter_->s_data_i, beat);
      cutter_->s_last_i = at_ + kBeatBytes == packet.size();
    }
    cutter_->m_ready_i = out == 100 || random_.chance(out);
    cutter_.settle();
    EXPECT_TRUE(cutter_->m_valid_o || arriving_.empty()) << "a gap within a datagram, clock " << cutter_.clock();
    const bool left = cutter_->m_valid_o && cutter_->m_ready_i;
    if (cutter_->m_valid_o) {
      see_word(left);
    }
    took_ = offered_ && cutter_->s_ready_o;
    if (took_) {
      offered_ = false;
      at_ += kBeatBytes;
      if (at_ == packets_.front().size()) {
        taken_.push_back(packets_.front());
        packets_.pop_front();
        at_ = 0;
      }
    }
    cutter_.rise();
    return left;
  }

  // Clocks until everything has left and the silence is due once more.
  void drain() {
    for (int i = 0; i < 1000000 && (!packets_.empty() || !taken_.empty() || !due_.empty() || !arriving_.empty()); ++i) {
      clock(100, 100);
    }
    EXPECT_TRUE(taken_.empty() && due_.empty());
  }

  Cutter* operator->() { return cutter_.operator->(); }
  void queue(Bytes packet) { packets_.push_back(std::move(packet)); }
  void set_seed(std::uint64_t seed) { random_ = Random(seed); }
  [[nodiscard]] bool took() const { return took_; }       // a beat, in the last clock
  [[nodiscard]] bool inside() const { return at_ != 0; }  // a packet has begun to come
  [[nodiscard]] std::size_t waiting() const { return packets_.size(); }
  [[nodiscard]] std::int64_t now() const { return cutter_.clock(); }
  [[nodiscard]] const std::vector<Bytes>& datagrams() const { return datagrams_; }

 private:
  void see_word(bool left) {
    const std::uint32_t word = cutter_->m_data_o;
    const std::uint32_t bytes = cutter_->m_bytes_o;
    if (shown_) {
      EXPECT_EQ(word, *shown_) << "a word that waits has changed";
    }
    shown_ = left ? std::nullopt : std::optional(word);
    EXPECT_EQ(cutter_->m_last_o != 0, arriving_.size() + 4 == bytes);
    if (!left) {
      return;
    }
    arriving_.resize(arriving_.size() + 4);
    model::store_little_endian(arriving_.data() + arriving_.size() - 4, word);
    if (cutter_->m_last_o) {
      compare();
      datagrams_.push_back(arriving_);
      arriving_.clear();
    }
  }

  void compare() {
    const auto keep = [this](std::span<const std::uint8_t> one) { due_.emplace_back(one.begin(), one.end()); };
    const std::optional<model::DatagramHeader> header = model::read_datagram_header(arriving_);
    ASSERT_TRUE(header.has_value());
    if (header->length == 0) {
      ASSERT_TRUE(due_.empty()) << "silence within a packet";
      model_->idle(keep);
    } else if (due_.empty()) {
      // A piece may leave before the end of its packet has come.
      ASSERT_TRUE(!taken_.empty() || inside());
      const Bytes& packet = taken_.empty() ? packets_.front() : taken_.front();
      model_->packet(packet, keep);
      ahead_ = taken_.empty();
      if (!ahead_) {
        taken_.pop_front();
      }
    }
    ASSERT_EQ(arriving_, due_.front());
    due_.pop_front();
    if (ahead_ && !taken_.empty()) {
      taken_.pop_front();
      ahead_ = false;
    }
    ASSERT_FALSE(ahead_ && due_.empty()) << "the end of a packet before it has come";
  }

  std::size_t datagram_bytes_;
  std::uint16_t session_ = 0;
  Clocked<Cutter> cutter_;
  Random random_{1};
  std::optional<model::DatagramCutter> model_;
  std::deque<Bytes> packets_;  // to come
  std::size_t at_ = 0;         // bytes of the first of them that have come
  std::deque<Bytes> taken_;    // have come, and no datagram of theirs has left
  std::deque<Bytes> due_;      // datagrams of the packet that leaves
  bool ahead_ = false;         // its end has not come yet
  bool offered_ = false;
  bool took_ = false;
  Bytes arriving_;
  std::optional<std::uint32_t> shown_;
  std::vector<Bytes> datagrams_;
};

inline Bytes random_packet(Random& random, int max_beats) {
  return random.bytes(kBeatBytes * static_cast<std::size_t>(random.between(1, max_beats)));
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_DATAGRAM_CUTTER_BENCH_H
