// Beats of video, as the front ends of cameras give them to the board.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_BEATS_H
#define SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_BEATS_H

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

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_BEATS_H
