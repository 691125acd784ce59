// The frames of the test camera inside the FPGA (rtl/camera/sp_test_camera.sv), which says what they show.
#ifndef SELFPROJ_MODEL_TEST_CAMERA_H
#define SELFPROJ_MODEL_TEST_CAMERA_H

#include <cstdint>
#include <vector>

namespace selfproj {

// Frame `frame` of a run: rows · columns pixels, row by row. Throws std::invalid_argument unless columns is a multiple
// of 8 and there are five rows or more.
std::vector<std::uint8_t> test_camera_frame(int columns, int rows, std::uint32_t frame);

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_TEST_CAMERA_H
