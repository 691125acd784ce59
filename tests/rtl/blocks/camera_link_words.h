// A camera's words at the ports of sp_camera_link, with links that may lose their lock, and the board's side.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_WORDS_H
#define SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_WORDS_H

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "tests/rtl/blocks/camera_beats.h"
#include "tests/rtl/blocks/camera_link_bench.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// A camera, its links, and the board's side of the front end. Times are in thousandths of the camera's
// clock.
template <typename Dut>
class CameraLinkBench : public LinkOutputs {
 public:
  static constexpr std::int64_t kWord = 1000;

  // `board`: the board's period; `late`: of Y behind X, and Z some part of it; `pauses`: percent of the clocks
  // of all links without a word.
  CameraLinkBench(std::uint64_t seed, int taps, int bits, std::int64_t board, std::int64_t late = 0, int pauses = 0)
      : random_(seed), camera_(random_, taps, bits), taps_(taps), board_(board), pauses_(pauses) {
    for (std::size_t link = 1; link < kLinks; ++link) {
      const std::int64_t behind = link == 1 ? late : late * static_cast<std::int64_t>(seed % 5) / 4;
      links_[link].next = behind % kWord;
      links_[link].late = static_cast<std::size_t>(behind / kWord);
    }
    name_ports(dut_);
    dut_.valid_when({"overrun_o", "lost_o", "apart_o"}, [this] { return known_; });
    dut_->clk_i = 0;
    for (std::size_t link = 0; link < kLinks; ++link) {
      clock(link) = 0;
      set_ports(link, false, false, 0);
    }
    reset();
    known_ = true;
    clocks(100);
  }

  bool stopped = false;  // the links' clocks; what is sent meanwhile waits

  void reset(int length = 4) {
    dut_->rst_i = 1;
    clocks(length);
    dut_->rst_i = 0;
    dut_.outputs_are_known();
  }

  // Queues a frame; its number is that of all frames before.
  void send(const LinkCamera::Shape& shape) {
    note_sent(camera_.send(shape));
    hand_out();
  }

  // A frame of any shape that the board can take; with several links, one that lasts longer than links wait for each
  // other.
  void send_any(int without_data = 20) {
    const int taps = taps_;
    send({.rows = random_.between(1, 6),
          .columns = taps * random_.between(taps >= 4 ? 20 : (3 + taps) / taps, 30),
          .max_gap = random_.chance(50) ? 1 : 9,
          .without_data = random_.chance(50) ? 0 : without_data,
          .frame_ends_line = random_.chance(30)});
  }

  // Until the links have sent everything, and `quiet` clocks of the board more.
  void drain(int quiet = 300) {
    while (std::any_of(links_.begin(), links_.end(), [](const Link& link) { return !link.queue.empty(); })) {
      step();
    }
    clocks(quiet);
  }

  // Clocks of the board.
  void clocks(int count) {
    while (count > 0) {
      count -= step() ? 1 : 0;
    }
  }

  // The link loses its lock for some of its clocks. Words that it sends meanwhile are lost.
  void lose_lock(int link, int clocks) { links_[static_cast<std::size_t>(link)].unlocked = clocks; }

  [[nodiscard]] bool sending() const { return !links_[0].queue.empty(); }
  Random& random() { return random_; }
  void all_may_break() { std::fill(may_break_.begin(), may_break_.end(), true); }
  void may_break(std::size_t frame) { may_break_.at(frame) = true; }
  Frame& frame(std::size_t number) { return sent_.at(number); }  // as it is due
  void forget() {
    beats_.clear();
    sent_.clear();
    may_break_.clear();
    first_ = camera_.frames();
  }

  // Makes the first line from this word on a line of one word.
  static void shorten_line(std::deque<LinkCamera::Sent>& words, std::size_t from) {
    while (!words[from].links[0].line) {
      ++from;
    }
    for (++from; words[from].links[0].frame && words[from].links[0].line; ++from) {
      for (LinkPins& pins : words[from].links) {
        pins.line = false;
      }
    }
  }

  // The words that wait, of X (0), Y (1) or Z (2); a test may change them.
  std::deque<LinkCamera::Sent>& words(std::size_t link) { return links_[link].queue; }

 private:
  struct Link {
    std::deque<LinkCamera::Sent> queue;
    std::int64_t next = 0;
    std::size_t late = 0;  // words behind X
    int unlocked = 4;      // clocks
    bool missed = false;   // something, since the last word that was not lost
  };

  CData& clock(std::size_t link) { return link == 0 ? dut_->x_clk_i : link == 1 ? dut_->y_clk_i : dut_->z_clk_i; }
  void set_ports(std::size_t link, bool locked, bool valid, std::uint32_t word) {
    (link == 0 ? dut_->x_locked_i : link == 1 ? dut_->y_locked_i : dut_->z_locked_i) = locked;
    (link == 0 ? dut_->x_valid_i : link == 1 ? dut_->y_valid_i : dut_->z_valid_i) = valid;
    (link == 0 ? dut_->x_word_i : link == 1 ? dut_->y_word_i : dut_->z_word_i) = word;
  }

  void hand_out() {
    std::size_t first = 0;  // words of X before those that come now
    for (const Link& link : links_) {
      first = std::max(first, link.queue.size() - std::min(link.queue.size(), link.late));
    }
    for (Link& link : links_) {
      link.queue.resize(first + link.late, {.links = {}, .frame = SIZE_MAX});
    }
    for (LinkCamera::Sent& sent : camera_.queue()) {
      while (random_.chance(pauses_)) {
        for (Link& link : links_) {
          link.queue.push_back({.links = {}, .frame = 0, .pause = true});
        }
      }
      for (Link& link : links_) {
        link.queue.push_back(sent);
      }
    }
    camera_.queue().clear();
  }

  void breaks(std::size_t frame) {
    if (frame >= first_ && frame - first_ < may_break_.size()) {
      may_break_[frame - first_] = true;
    }
  }

  // Sets the inputs of a link for its next clock.
  void set(std::size_t number) {
    Link& link = links_[number];
    const bool locked = link.unlocked == 0;
    const bool pause = !link.queue.empty() && link.queue.front().pause;
    link.missed = link.missed || !locked;
    std::uint32_t word = static_cast<std::uint32_t>(random_.bits()) & 0xFFFFFFFU;
    if (!pause) {
      word = link.queue.empty() ? link_word({.data = true}) : link_word(link.queue.front().links[number]);
      if (!link.queue.empty() && link.missed) {
        breaks(link.queue.front().frame);
      }
      link.missed = !locked;
    }
    if (!link.queue.empty()) {
      link.queue.pop_front();
    }
    const bool valid = locked && !pause;
    link.unlocked -= locked ? 0 : 1;
    set_ports(number, locked, valid, word);
  }

  // The next rise of a clock; returns whether it is the board's.
  bool step() {
    const std::int64_t now = std::min({links_[0].next, links_[1].next, links_[2].next, next_board_});
    std::array<bool, kLinks> rises{};
    for (std::size_t number = 0; number < kLinks; ++number) {
      rises[number] = links_[number].next == now && !stopped;
      if (rises[number]) {
        clock(number) = 0;
        set(number);
      }
      links_[number].next += links_[number].next == now ? kWord : 0;
    }
    const bool board = next_board_ == now;
    if (board) {
      dut_->clk_i = 0;
      next_board_ += board_;
    }
    dut_.eval();
    if (board && known_) {
      read_outputs(dut_, true);
    }
    for (std::size_t number = 0; number < kLinks; ++number) {
      clock(number) = rises[number] ? 1 : clock(number);
    }
    dut_->clk_i = board ? 1 : dut_->clk_i;
    dut_.eval();
    return board;
  }

  Random random_;
  LinkCamera camera_;
  int taps_;
  std::int64_t board_;
  int pauses_;
  Model<Dut> dut_;
  std::array<Link, kLinks> links_;
  std::int64_t next_board_ = 0;
  std::size_t first_ = 0;  // number of the first frame in sent_
  bool known_ = false;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_WORDS_H
