// The board's behaviour on a stream of video beats: which packets it makes of good and of broken frames.
//
// The model of what rtl/board does, without its clock-by-clock timing: it gives every packet the board would send if no
// FIFO were ever full. What a full FIFO does to them is only that some are missing, whole, and counted in the field
// `lost` of the later ones.
#ifndef SELFPROJ_MODEL_BOARD_H
#define SELFPROJ_MODEL_BOARD_H

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "model/column_moments.h"
#include "model/gray_decoder.h"
#include "model/packet.h"

namespace selfproj {

// The settings of the register file that decide about packets.
struct BoardSettings {
  bool run = true;     // frame starts are accepted
  bool image = false;  // raw-image packets too
  int columns = 512;   // a multiple of 4, from 4 up to the build's maximum
  int rows = 96;       // from 1 up to the build's maximum
  Mode mode = Mode::binary;
  int threshold = 128;     // 0..255
  int stream = 0;          // 0..255
  bool codes = false;      // decode Gray codes and send them
  bool median = false;     // through the 3 x 3 median
  int code_bits = 8;       // m, 1..12
  int code_threshold = 5;  // 0..255
  int timeout =
      0;  // clocks without a beat that end an open frame; 0 = never. Valid at once, not from a frame start on.
};

// One beat of the camera: four pixels, leftmost first.
struct VideoBeat {
  std::array<std::uint8_t, spec::kPixelsPerBeat> pixels{};
  bool start = false;     // tuser: first beat of a frame
  bool line_end = false;  // tlast: last beat of a line
};

// What the board reads at its other inputs at a frame's first beat.
struct BoardInputs {
  std::uint64_t clock = 0;    // pixel clocks since reset
  std::uint32_t encoder = 0;  // count, two's complement
  std::uint16_t pattern = 0;  // index
};

// A packet but for the field `lost` of its header, which is 0.
struct BoardPacket {
  PacketHeader header;
  std::vector<std::uint8_t> payload;
  std::uint32_t status = 0;  // 0 or spec::kStatus...
};

class BoardModel {
 public:
  using Sink = std::function<void(BoardPacket&&)>;

  // Packets go to `sink`, those of each kind in the board's order. It must not call back into the model.
  //
  // `median_built`: the median is part of the build, so that codes leave a line later whether it is wanted or not.
  explicit BoardModel(Sink sink, bool median_built = true) : sink_(std::move(sink)), median_built_(median_built) {}

  // Settings as written to the registers: they come into force at the next frame start that may take them over (not
  // within kTakeDistance clocks of the last take-over). `run` counts at once, `timeout` from the next beat on.
  void write(const BoardSettings& settings) { written_ = settings; }

  // A beat at clock inputs.clock, later than every clock given before. Encoder and pattern are read only where
  // beat.start is set.
  void beat(const BoardInputs& inputs, const VideoBeat& beat);

  // No beat has come up to and with this clock.
  void idle(std::uint64_t clock);

  // Counters, as in the registers of the same names.
  [[nodiscard]] std::uint64_t frames() const { return next_sequence_; }
  [[nodiscard]] std::uint64_t broken() const { return broken_; }
  [[nodiscard]] std::uint64_t stray() const { return stray_; }
  [[nodiscard]] std::uint64_t abandoned() const { return abandoned_; }
  [[nodiscard]] bool frame_open() const { return open_; }

  static constexpr std::uint64_t kTakeDistance = 7;

  // A frame that starts less than so many clocks after the last beat of one of fewer beats is not the next one to the
  // decoder (rtl/gray/README.md), and neither is one whose codes are due up to kMedianClocks + columns / 4 clocks after
  // the last beat of the frame with codes before it, where the median is built.
  static constexpr std::uint64_t kDecodeDistance = 6;
  static constexpr std::uint64_t kMedianClocks = 3;

 private:
  void start_frame(const BoardInputs& inputs);
  void end_frame(std::uint32_t status);
  void end_line(std::uint32_t status);
  void start_decoding(std::uint64_t clock);
  void end_code_line(std::uint32_t status);
  void send_codes(int row, int columns, std::uint32_t status);
  [[nodiscard]] PacketHeader header(std::uint8_t kind) const;

  Sink sink_;
  bool median_built_;
  BoardSettings written_;
  BoardSettings settings_;  // in force
  std::uint64_t last_take_ = 0;
  bool taken_ = false;

  bool open_ = false;            // a frame is being taken
  bool stray_seen_ = false;      // beats were discarded since the last frame start
  bool stray_before_ = false;    // ... before the open frame
  BoardInputs inputs_;           // at the open frame's start
  std::uint64_t last_beat_ = 0;  // clock of the last beat of any kind
  int timeout_ = 0;              // after it
  int row_ = 0;                  // of the next beat, from 0
  int column_ = 0;               // of its first pixel, from 0
  std::vector<std::uint8_t> pixels_;
  std::uint64_t next_sequence_ = 0;
  std::uint64_t broken_ = 0;
  std::uint64_t stray_ = 0;

  GrayDecoder decoder_{{.rows = 1, .columns = spec::kPixelsPerBeat}};
  bool due_ = false;                   // the open frame's codes are sent
  std::vector<std::uint16_t> codes_;   // of it
  std::uint64_t last_frame_beat_ = 0;  // clock of the last beat within a frame
  std::uint64_t frame_beats_ = 0;      // of the open or last frame; 0 = there was none
  std::uint64_t last_codes_ = 0;       // clock of the last beat of the last frame with codes, where it was good
  int last_codes_columns_ = -1;        // of that frame; -1 = none
  std::uint64_t abandoned_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_MODEL_BOARD_H
