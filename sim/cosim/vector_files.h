// The vectors of a co-simulation, for benches in Verilog and VHDL: what goes into the board, and what comes out of it.
#ifndef SELFPROJ_SIM_COSIM_VECTOR_FILES_H
#define SELFPROJ_SIM_COSIM_VECTOR_FILES_H

#include <cstdint>
#include <span>
#include <string>

#include "host/files/output_folder.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/packet.h"
#include "sim/platform/camera_timing.h"
#include "sim/platform/platform.h"

namespace selfproj::sim {

// A folder of text files. Each begins with a comment "// ...", which says what it holds. Then every line is a word in
// hexadecimal digits, as $readmemh takes it. The fields of a word, the most significant first, with their digits:
//
//     registers.hex  address (2), data (8)               writes at the AXI4-Lite port, in this order
//     camera.hex     idle (8), flags (2), pixels (B)     beats of the camera. idle: pixel clocks without a beat before
//                                                        it. flags: 1 for the first beat of a frame, and 2 for the
//                                                        last of a line. pixels: four of B bits, the leftmost lowest
//     encoder.hex    clock (8), levels (2)               changes of the encoder's pins. clock: pixel clocks after the
//                                                        first beat of all. levels: a + 2 b. Both are low before
//     packets.hex    last (2), data (32)                 beats of the packets. last: 1 for the last beat of a packet
//     columns.hex    m0 (8), m1 (8)                      columns of the packets that have any, in their order, as
//                                                        unpack_columns gives them. Nothing stands
//                                                        between frames: each has as many lines as columns
//
// The board takes the registers before the first beat. Limits of a verdict are for a build with as many columns as the
// frames, and as many sections as the table takes, rounded up to a power of two.
class VectorFiles {
 public:
  // Throws UserError if the folder cannot be written to.
  VectorFiles(const std::string& folder, const PlatformOptions& options);

  // A frame as the camera sends it, and a packet as the board does.
  void frame(const model::SensorView& image);
  void packet(const model::PacketView& packet);

  // The folder is there from now on. Throws UserError.
  void commit();

 private:
  files::OutputFolder folder_;
  CameraTiming timing_;
  int pixel_bits_;
  double clocks_a_step_;  // of the encoder; 0: it stands still
  std::uint64_t idle_;    // before the next line
  std::uint64_t frames_ = 0;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_COSIM_VECTOR_FILES_H
