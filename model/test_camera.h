// The frames of the test camera inside the FPGA (rtl/camera/sp_test_camera.sv), which says what they show.
#ifndef SELFPROJ_MODEL_TEST_CAMERA_H
#define SELFPROJ_MODEL_TEST_CAMERA_H

#include <cstdint>
#include <vector>

namespace selfproj::model {

// Frame `frame` of a run: rows · columns pixels, row by row. Throws std::invalid_argument unless columns is a multiple
// of 8 and there are five rows or more.
std::vector<std::uint8_t> test_camera_frame(int columns, int rows, std::uint32_t frame);

// What it sees of pattern `index`, 0..2 · bits - 1: the positive of plane index / 2, or the negative where index is
// odd. `bits` is 1..12. The code of the pixel in column x and row y is (x + y) modulo 2^bits; that of the last row
// cannot be measured. Throws as above, and std::invalid_argument if bits or index is out of range.
std::vector<std::uint8_t> test_camera_pattern(int columns, int rows, int bits, int index);

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_TEST_CAMERA_H
