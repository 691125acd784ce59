// Beats of video, as the front ends of cameras give them to the board.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_BEATS_H
#define SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_BEATS_H

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace selfproj::test {

struct Beat {
  std::uint32_t pixels = 0;
  bool start = false;
  bool end = false;

  bool operator==(const Beat&) const = default;
};

using Frame = std::vector<Beat>;

// What a camera's front end offers.
template <typename Dut>
Beat beat_of(Dut& dut) {
  return {dut->m_data_o, dut->m_start_o != 0, dut->m_end_o != 0};
}

// The ports that count only with a beat, for the recorder.
template <typename Camera>
void name_ports(Camera& camera) {
  camera.valid_when({"m_data_o", "m_start_o", "m_end_o"}, [&camera] { return camera->m_valid_o != 0; });
}

// Checks beats against the frames that were sent: each comes whole, or ends early and never goes on. Only the frames of
// `may_break` may end early or be missing. Returns how many are not whole.
inline int expect_frames(const std::vector<Beat>& beats, const std::vector<Frame>& sent,
                         const std::vector<bool>& may_break) {
  std::size_t at = 0;
  int broken = 0;
  for (std::size_t number = 0; number < sent.size(); ++number) {
    const Frame& frame = sent[number];
    std::size_t same = 0;
    while (same < frame.size() && at < beats.size() && beats[at] == frame[same]) {
      ++at;
      ++same;
    }
    broken += same < frame.size() ? 1 : 0;
    EXPECT_TRUE(same == frame.size() || may_break[number]) << "frame " << number << " ends after " << same << " beats";
  }
  EXPECT_EQ(at, beats.size()) << "a beat that belongs to no frame, or to another one";
  return broken;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_BEATS_H
