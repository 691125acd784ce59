// The board's behaviour on a stream of video beats: which packets it makes of good and of broken frames.
//
// This models what rtl/board does, without its clock-by-clock timing. It gives every packet that the board would send
// if no FIFO were ever full. A full FIFO only removes whole packets, and the field `lost` of the later ones counts
// them.
#ifndef SELFPROJ_MODEL_BOARD_H
#define SELFPROJ_MODEL_BOARD_H

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/verdict.h"

namespace selfproj::model {

// The settings of the register file that determine the packets.
struct BoardSettings {
  bool run = true;     // the board accepts frame starts
  bool hold = false;   // frame starts take no settings over
  bool image = false;  // the board also sends raw-image packets
  int columns = 512;   // a multiple of 4, from 4 up to the build's maximum
  int rows = 96;       // from 1 up to the build's maximum
  Mode mode = Mode::binary;
  int threshold = 128;  // 0..2^bits - 1 of the build's pixels
  Select select = Select::all;
  int gap = 0;                // 0..3
  RowWindow window = {};      // rows that count for the moments, each up to the build's maximum
  int stream = 0;             // 0..255
  int region_row = 0;         // row of the sensor, from 1, at which frames begin; 0: not said; only reported
  int region_column = 0;      // the same for columns
  bool compact = false;       // columns in grey modes come divided, in packets of kind compact
  bool verdict = false;       // frames are judged
  int verdict_packets = 0;    // 0: packets as without; 1: with the verdict; 2: with nothing but it
  bool verdict_hold = false;  // parts take no settings over; counts at the frame start, as the next two
  VerdictSettings verdict_settings = {};
  PartRule part_rule = {};
  bool codes = false;      // the board decodes Gray codes and sends them
  bool median = false;     // the codes pass through the 3 x 3 median
  int code_bits = 8;       // m, 1..12
  int code_threshold = 5;  // 0..255
  // Clocks without a beat after which an open frame ends; 0 = never. A new value counts at once.
  int timeout = 0;

  // What the moments measure.
  [[nodiscard]] Measure measure() const {
    return {.mode = mode, .threshold = threshold, .select = select, .gap = gap, .window = window};
  }
};

constexpr int kMaxLanes = 16;  // pixels in the widest beat

// One beat of the camera: the build's 4, 8 or 16 pixels, of its bits, leftmost first; what is behind them does not
// count.
struct VideoBeat {
  std::array<std::uint16_t, kMaxLanes> pixels{};
  bool start = false;     // tuser: first beat of a frame
  bool line_end = false;  // tlast: last beat of a line
};

// What the board reads at its other inputs at the first beat of a frame.
struct BoardInputs {
  std::uint64_t clock = 0;    // pixel clocks since reset
  std::uint32_t encoder = 0;  // count, two's complement
  std::uint16_t pattern = 0;  // index of the projected pattern
};

// A packet without the field `lost` of its header, which is 0 here.
struct BoardPacket {
  PacketHeader header;
  std::vector<std::uint8_t> payload;
  std::uint32_t status = 0;  // 0 or spec::kStatus...
};

class BoardModel {
 public:
  using Sink = std::function<void(BoardPacket&&)>;

  // The model hands packets to `sink`; those of each kind come in the board's order. The sink must not call back into
  // the model.
  //
  // `median_built`: the build contains the median. Codes then leave one line later, whether or not the median is used.
  // `pixel_bits`: bits of a pixel in the build, 8..kMaxPixelBits. With more than 8, moments are of all of them, images
  // and codes of the upper 8. `lanes`: pixels in a beat, 4, 8 or 16; columns are a multiple of them. `tall`:
  // the build is for more than spec::kMaxRows rows.
  explicit BoardModel(Sink sink, bool median_built = true, int pixel_bits = spec::kPixelBits,
                      int lanes = spec::kPixelsPerBeat, bool tall = false)
      : sink_(std::move(sink)), median_built_(median_built), pixel_bits_(pixel_bits), lanes_(lanes), tall_(tall) {}

  // Judges frames with `verdict`, which holds the limits and must live longer. The model judges all frames; the board
  // leaves out those that come too soon (register verdict_state, missed).
  void judge_with(Verdict& verdict) { verdict_ = &verdict; }

  // Settings as written to the registers. They come into force at the next frame start that may take them over, which
  // is one that is at least kTakeDistance clocks after the last take-over, while `hold` is low. `run` and `hold` count
  // at once, `timeout` from the next beat. No frame starts before the first take-over.
  void write(const BoardSettings& settings) { written_ = settings; }

  // A beat at clock inputs.clock, which must be later than all clocks given before. Encoder and pattern are read only
  // if beat.start is set.
  void beat(const BoardInputs& inputs, const VideoBeat& beat);

  // Says that no beat has come up to and including this clock.
  void idle(std::uint64_t clock);

  // Counters, equal to the registers of the same names.
  [[nodiscard]] std::uint64_t frames() const { return next_sequence_; }
  [[nodiscard]] std::uint64_t broken() const { return broken_; }
  [[nodiscard]] std::uint64_t stray() const { return stray_; }
  [[nodiscard]] std::uint64_t abandoned() const { return abandoned_; }
  [[nodiscard]] bool frame_open() const { return open_; }

  static constexpr std::uint64_t kTakeDistance = 7;

  // A frame that broke before its last row does not count for parts if the next one starts less than kSeenDistance
  // clocks after it.
  static constexpr std::uint64_t kSeenDistance = 6;

  // Two frames are not consecutive for the decoder if the later one starts less than kDecodeDistance clocks after the
  // last beat of one with fewer beats (docs/circuits/gray.md). If the median is built, the same holds for a frame whose
  // codes are due no later than kMedianClocks + columns / lanes clocks after the last beat of the previous frame with
  // codes; with 8 and 16 lanes median_pause clocks later, because the last line waits (sp_median3x3).
  static constexpr std::uint64_t kDecodeDistance = 6;
  static constexpr std::uint64_t kMedianClocks = 3;
  static constexpr std::uint64_t median_pause(int lanes, int columns) {
    return lanes == 4 ? 0U : 14U + (lanes == 16 ? static_cast<std::uint64_t>(columns / 16) : 0U);
  }

 private:
  void start_frame(const BoardInputs& inputs);
  void end_frame(std::uint32_t status);
  void end_line(std::uint32_t status);
  void start_decoding(std::uint64_t clock);
  void end_code_line(std::uint32_t status);
  void send_codes(int row, int columns, std::uint32_t status);
  [[nodiscard]] Measure measure() const;
  [[nodiscard]] PacketHeader header(std::uint8_t kind) const;
  void judge(const RunsView& columns, int complete, BoardPacket& packet);
  void pass_broken();

  Sink sink_;
  bool median_built_;
  int pixel_bits_;
  int lanes_;
  bool tall_;
  BoardSettings written_;
  BoardSettings settings_;  // in force
  Verdict* verdict_ = nullptr;
  BoardSettings at_start_;      // as written when the open frame started
  bool broken_passes_ = false;  // it broke before its last row, and the verdict does not know yet
  std::uint64_t last_take_ = 0;
  bool taken_ = false;

  bool open_ = false;                       // a frame is being taken
  bool stray_seen_ = false;                 // beats were discarded since the last frame start
  bool stray_before_ = false;               // beats were discarded before the open frame
  BoardInputs inputs_;                      // inputs at the start of the open frame
  std::uint64_t last_beat_ = 0;             // clock of the last beat of any kind
  int timeout_ = 0;                         // timeout in force after that beat
  int row_ = 0;                             // row of the next beat, from 0
  int column_ = 0;                          // column of the next beat's first pixel, from 0
  std::vector<std::uint8_t> pixels_;        // their upper eight bits
  std::vector<std::uint16_t> wide_pixels_;  // all bits, if they have more
  std::uint64_t next_sequence_ = 0;
  std::uint64_t broken_ = 0;
  std::uint64_t stray_ = 0;

  GrayDecoder decoder_{{.rows = 1, .columns = spec::kPixelsPerBeat}};
  bool due_ = false;                   // the board sends codes for the open frame
  std::vector<std::uint16_t> codes_;   // codes of the open frame
  std::uint64_t last_frame_beat_ = 0;  // clock of the last beat within a frame
  std::uint64_t frame_beats_ = 0;      // beats of the open or last frame; 0 = there was none
  std::uint64_t last_codes_ = 0;       // clock of the last beat of the last good frame with codes
  int last_codes_columns_ = -1;        // columns of that frame; -1 = there was none
  std::uint64_t abandoned_ = 0;
};

// Appends the good packet of the moments of `image`, as the board sends it. Its columns are a multiple of 4. Of
// `header` counts what describe_frame and payload_size do not say; of its kind, whether it is that of compact columns,
// which mode binary has not.
void append_moments_packet(const ImageView& image, const Measure& measure, PacketHeader header,
                           std::vector<std::uint8_t>& out);

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_BOARD_H
