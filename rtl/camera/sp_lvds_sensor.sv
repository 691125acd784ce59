// Front end for image sensors with serial LVDS outputs: data lanes, and a control lane that says what
// they carry (CMV2000; PYTHON).
//
//   the deserializer's words ─▶ sp_lvds_lane, each lane ─▶ sp_lvds_flags or sp_lvds_codes
//          ▲ delays                │                              │
//          └─ sp_lvds_training ◀───┘     sp_lvds_columns or sp_lvds_kernels ─▶ sp_beat_crossing
//                                                     sp_beat_split ─▶ video, in the board's clock
//
// The deserializer stays outside, because its cells are those of an FPGA family. In every clock of
// sensor_clk_i with valid_i it gives Bits successive bits of each lane. All lanes have the same word
// clock; where in these bits a word begins is found here. The sensor's clock line feeds the
// deserializer; the delay of each lane, if there is one, is set by the ports tap_*.
//
// Two kinds of sensors:
//
//   Codes = 0  CMV2000 and the like: the control lane has flags (sp_lvds_flags), each lane
//              carries Columns neighbouring columns (sp_lvds_columns)
//   Codes = 1  PYTHON and the like: the control lane has codes (sp_lvds_codes), the lanes carry
//              kernels of two words (sp_lvds_kernels); Columns and Burst are not used
//
// Guarantees: every frame that begins while all lanes are aligned leaves as beats of four neighbouring
// columns, in order, the leftmost in 7..0, unless something goes wrong that is counted: damaged_o,
// cut_o, lost_o, overrun_o. A pixel is the upper 8 bits of its word. A frame that is cut off ends in
// the middle and never continues, so that the frame tracker of sp_board counts and marks it as broken;
// if it is cut off in its first line, it does not begin. The next frame is whole again.
//
// Damage: a control word that is not legal, a code or flag at a wrong place, and a word of a data lane
// that is not the training word where it must be. damaged_o counts the words in which something of
// these is noticed (modulo 2^16), while all lanes are aligned. A control word that is wrong cuts off
// the frame; a wrong training word does not. Wrong pixels can be noticed only by the check words of the
// PYTHON family, with Checked = 1: a check word that is not that of its line counts as a damaged word.
// It comes when the line has left, and does not cut off the frame.
//
// Loss: a lane is lost when too many of its words are wrong (sp_lvds_loss); of a data lane those count
// where the training word must be. lost_o is high for one clock,
// the frame is cut off, and sp_lvds_training aligns the lane again. aligned_o is low meanwhile. A lane
// that does not train has its bit in failed_o. If the sensor's clock stops within a frame, the frame
// stays open until words come again; the board has a time-out for this.
//
// Rate: four pixels leave in a clock of the board. So a frame of R rows and C columns takes R x C / 4
// clocks of the board, and no frame may come sooner behind the one before. Within a frame, rows may
// come faster, as far as the FIFO holds them: 2^LogDepth groups of Lanes pixels (of four, with fewer
// lanes). If a row comes every t clocks of the board and t < C / 4, the FIFO must hold the part
// 1 - t / (C / 4) of the frame, and a line more.
//
//   16 lanes x 480 Mbit/s, 10 bits, 2048 columns in 129 words (CMV2000), the board at 151.2 MHz:
//   t = 406, C / 4 = 512. 25 rows need 5.2 lines and one more: LogDepth = 10. Without more FIFO than
//   a line, a row must last 163 words instead of 129, or the board's clock must be 190.6 MHz.
//
// Overflow: as in sp_parallel_sensor. A group for which the FIFO has no room ends its frame;
// overrun_o is high for one clock.
//
// Reset: rst_i alone; all lanes are trained anew, with their delays. sensor_clk_i may stop and start
// at any time.
//
// Latency: a pixel word leaves the lanes 2 or 3 words after its bits; sp_lvds_columns holds a whole
// line; the crossing takes a group more, and 3 to 4 clocks of the board, the split one more.
//
//   sensor      a line of Columns words      the next line
//   take        /11111111111111111111\_______/11111111111111111111\____
//   groups      __________________________/11111111111111111111\_______   into the FIFO
`default_nettype none

module sp_lvds_sensor #(
  parameter int Lanes = 16,  // data lanes: 1, 2, 4, 8 or 16
  parameter int Bits = 10,  // of a word: 10 or 12; with Codes 8 or 10
  parameter bit Codes = 1'b0,  // 0: flags and columns (CMV); 1: codes and kernels (PYTHON)
  parameter bit MsbFirst = Codes,  // the highest bit of a word comes first
  parameter int Columns = 128,  // of a lane: 1..4096, a multiple of Lanes
  parameter int Burst = 128,  // words with data valid in a row: 1..4096; Columns is a multiple of it
  parameter bit Checked = 1'b0,  // compare the check words of lines; only codes of 10 bits
  parameter bit CheckSeed = 1'b0,  // each bit of their seed
  parameter logic [11:0] Training = !Codes ? 12'h055 : Bits == 8 ? 12'h0E9 : 12'h3A6,
  parameter logic [11:0] ControlIdle = Codes ? Training : 12'h200,  // the control lane in training
  parameter logic [9:0] FrameEnd = 10'h32A,  // codes: that of a frame's end (sp_lvds_codes)
  parameter logic [11:0] FixedMask = 12'h300,  // flags: bits that all control words share
  parameter logic [11:0] IdleMask = Codes ? 12'hFFF : FixedMask | 12'h007,  // and all idle ones
  parameter int Taps = 128,  // of a lane's delay: 1..128; 1: there is none
  parameter int Settle = 16,  // words until a new tap shows: 1..255
  parameter int LogWindow = 5,  // log2 of the words of a measurement: 2..10
  parameter int LogPatience = 13,  // log2 of the words for it, more than a frame takes: 6..20
  parameter int LogDepth = 9  // log2 of the groups in the FIFO: 1..15
) (
  // Deserializer; lane Lanes is the control lane, bit 0 of a lane arrived first
  input  wire logic                      sensor_clk_i,
  input  wire logic                      valid_i,
  input  wire logic [(Lanes+1)*Bits-1:0] lanes_i,
  output logic      [Lanes:0]            tap_load_o,  // pulses: to tap 0
  output logic      [Lanes:0]            tap_move_o,  // pulses: by one tap
  output logic                           tap_up_o,    // towards more delay

  // Video, to the board's s_axis ports
  input  wire logic                      clk_i,
  input  wire logic                      rst_i,       // active high, synchronous to clk_i
  output logic                           m_valid_o,
  output logic      [31:0]               m_data_o,    // leftmost pixel in 7..0
  output logic                           m_start_o,   // first beat of a frame
  output logic                           m_end_o,     // last beat of a line
  output logic                           overrun_o,   // pulse: a frame was cut off, the FIFO was full
  output logic                           cut_o,       // pulse: a frame was cut off, damaged or lost
  output logic                           lost_o,      // pulse: a lane has lost its alignment
  output logic                           aligned_o,   // all lanes are aligned
  output logic      [Lanes:0]            failed_o,    // lanes whose last training gave no result
  output logic      [15:0]               damaged_o    // words in which damage was noticed
);

  if (Lanes != 1 && Lanes != 2 && Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_1_2_4_8_or_16 u_error ();
  end
  if (Checked && (!Codes || Bits != 10)) begin : gen_checked
    only_codes_of_10_bits_are_checked u_error ();
  end
  if (Bits == (Codes ? 12 : 8)) begin : gen_bits
    codes_have_8_or_10_and_flags_10_or_12_bits u_error ();
  end

  localparam int Group = Lanes < 4 ? 4 : Lanes;  // pixels that cross together

  function automatic logic [11:0] arrival(input logic [11:0] word);
    arrival = '0;
    for (int i = 0; i < 12; i++) if (i < Bits) arrival[i] = 1'(word >> (MsbFirst ? Bits - 1 - i : i));
  endfunction

  // --- Lanes ---
  logic                      sensor_rst;
  logic [4*(Lanes+1)-1:0]    slips;
  logic [Lanes:0]            newer, aligned, failed;
  logic [(Lanes+1)*Bits-1:0] words;
  logic [Bits-1:0]           control;
  logic                      decoded, idle, illegal;
  logic [Lanes:0]            lost;

  assign control = words[Bits*Lanes+:Bits];

  for (genvar i = 0; i <= Lanes; i++) begin : gen_lane
    sp_lvds_lane #(
      .Bits    (Bits),
      .MsbFirst(MsbFirst)
    ) u_lane (
      .clk_i  (sensor_clk_i),
      .en_i   (valid_i),
      .lane_i (lanes_i[Bits*i+:Bits]),
      .slip_i (slips[4*i+:4]),
      .newer_i(newer[i]),
      .word_o (words[Bits*i+:Bits])
    );
  end

  sp_lvds_training #(
    .Lanes      (Lanes),
    .Bits       (Bits),
    .Training   (arrival(Training)),
    .ControlIdle(arrival(ControlIdle)),
    .IdleMask   (arrival(IdleMask)),
    .Taps       (Taps),
    .Settle     (Settle),
    .LogWindow  (LogWindow),
    .LogPatience(LogPatience)
  ) u_training (
    .clk_i     (sensor_clk_i),
    .rst_i     (sensor_rst),
    .en_i      (valid_i),
    .lanes_i   (lanes_i),
    .decoded_i (decoded),
    .idle_i    (idle),
    .lost_i    (lost),
    .slips_o   (slips),
    .newer_o   (newer),
    .aligned_o (aligned),
    .failed_o  (failed),
    .tap_load_o(tap_load_o),
    .tap_move_o(tap_move_o),
    .tap_up_o  (tap_up_o)
  );

  // --- Words behind the last change of a slip are looked at ---
  logic [3:0] steady_q;  // words since all lanes have been aligned, at most 15
  logic       ready_q;

  always_ff @(posedge sensor_clk_i) begin
    if (sensor_rst || !(&aligned)) begin
      steady_q <= '0;
      ready_q  <= 1'b0;
    end else begin
      if (valid_i && steady_q != '1) steady_q <= steady_q + 1'b1;
      ready_q <= steady_q == '1;
    end
  end

  // --- What the control lane says ---
  logic begins, take, last, cut, bad, check;

  if (Codes) begin : gen_codes_of
    sp_lvds_codes #(
      .Bits    (Bits),
      .FrameEnd(FrameEnd)
    ) u_control (
      .clk_i    (sensor_clk_i),
      .rst_i    (sensor_rst),
      .en_i     (valid_i),
      .word_i   (control),
      .aligned_i(ready_q),
      .decoded_o(decoded),
      .illegal_o(illegal),
      .idle_o   (idle),
      .begins_o (begins),
      .take_o   (take),
      .last_o   (last),
      .check_o  (check),
      .cut_o    (cut),
      .bad_o    (bad)
    );
  end else begin : gen_flags
    assign check = 1'b0;
    sp_lvds_flags #(
      .Bits     (Bits),
      .Columns  (Columns),
      .Burst    (Burst),
      .FixedMask(FixedMask),
      .Fixed    (ControlIdle & FixedMask)
    ) u_control (
      .clk_i    (sensor_clk_i),
      .rst_i    (sensor_rst),
      .en_i     (valid_i),
      .word_i   (control),
      .aligned_i(ready_q),
      .decoded_o(decoded),
      .illegal_o(illegal),
      .idle_o   (idle),
      .begins_o (begins),
      .take_o   (take),
      .last_o   (last),
      .cut_o    (cut),
      .bad_o    (bad)
    );
  end

  // --- Pixels and training words, with the decoded control word ---
  logic [8*Lanes-1:0] pixels_q;
  logic [Lanes-1:0]   odd_q;  // not the training word

  for (genvar i = 0; i < Lanes; i++) begin : gen_pixel
    always_ff @(posedge sensor_clk_i) begin
      pixels_q[8*i+:8] <= words[Bits*(i+1)-1-:8];
      odd_q[i]         <= words[Bits*i+:Bits] != Training[Bits-1:0];
    end
  end

  logic [Lanes-1:0] unlike;  // the check word is not that of the line

  if (Checked && Bits == 10) begin : gen_check
    logic [10*Lanes-1:0] words_q;
    always_ff @(posedge sensor_clk_i) words_q <= words[10*Lanes-1:0];
    for (genvar i = 0; i < Lanes; i++) begin : gen_lane_check
      sp_lvds_check #(
        .Seed(CheckSeed)
      ) u_check (
        .clk_i    (sensor_clk_i),
        .decoded_i(decoded),
        .take_i   (take),
        .check_i  (check),
        .word_i   (words_q[10*i+:10]),
        .wrong_o  (unlike[i])
      );
    end
  end else begin : gen_no_check
    logic unused;
    assign unused = check;
    assign unlike = '0;
  end

  // --- Damage: counted, and by lane ---
  logic [Lanes:0] looked, wrong;
  logic [15:0]    count_q, gray_q;
  logic           damaged;
  logic           lost_any_q;  // changes with every loss

  assign looked  = {decoded, {Lanes{idle}}};
  assign wrong   = {illegal, odd_q};
  assign damaged = ready_q && (bad || idle && odd_q != '0 || unlike != '0);

  for (genvar i = 0; i <= Lanes; i++) begin : gen_loss
    sp_lvds_loss u_loss (
      .clk_i    (sensor_clk_i),
      .rst_i    (sensor_rst),
      .aligned_i(aligned[i]),
      .look_i   (looked[i]),
      .wrong_i  (wrong[i]),
      .lost_o   (lost[i])
    );
  end

  always_ff @(posedge sensor_clk_i) begin
    if (sensor_rst) begin
      count_q    <= '0;
      gray_q     <= '0;
      lost_any_q <= 1'b0;
    end else begin
      if (damaged) count_q <= count_q + 1'b1;
      gray_q <= count_q ^ (count_q >> 1);
      if (ready_q && !(&aligned)) lost_any_q <= !lost_any_q;
    end
  end

  // --- Columns in order, in groups ---
  logic               group_begins, full, ending;
  logic [8*Lanes-1:0] group;

  if (Codes) begin : gen_kernels
    sp_lvds_kernels #(
      .Lanes(Lanes)
    ) u_order (
      .clk_i   (sensor_clk_i),
      .rst_i   (sensor_rst),
      .begins_i(begins),
      .take_i  (take),
      .last_i  (last),
      .cut_i   (cut),
      .pixels_i(pixels_q),
      .begins_o(group_begins),
      .full_o  (full),
      .group_o (group),
      .ending_o(ending)
    );
  end else begin : gen_columns
    sp_lvds_columns #(
      .Lanes  (Lanes),
      .Columns(Columns)
    ) u_order (
      .clk_i   (sensor_clk_i),
      .rst_i   (sensor_rst),
      .begins_i(begins),
      .take_i  (take),
      .last_i  (last),
      .cut_i   (cut),
      .pixels_i(pixels_q),
      .begins_o(group_begins),
      .full_o  (full),
      .group_o (group),
      .ending_o(ending)
    );
  end

  // --- Into the board's clock ---
  logic               wide_full;
  logic [8*Group-1:0] wide;
  logic               wide_valid, wide_ready, wide_start, wide_end;
  logic [8*Group-1:0] wide_data;

  if (Lanes < 4) begin : gen_gather
    sp_tap_gather #(
      .Taps(Lanes)
    ) u_gather (
      .clk_i   (sensor_clk_i),
      .rst_i   (sensor_rst),
      .take_i  (full && !cut),
      .clear_i (ending || cut),
      .pixels_i(group),
      .full_o  (wide_full),
      .beat_o  (wide)
    );
  end else begin : gen_direct
    assign wide_full = full;
    assign wide      = group;
  end

  sp_beat_crossing #(
    .Width   (8 * Group),
    .LogDepth(LogDepth)
  ) u_crossing (
    .camera_clk_i(sensor_clk_i),
    .camera_rst_o(sensor_rst),
    .begins_i    (group_begins),
    .full_i      (wide_full),
    .beat_i      (wide),
    .ending_i    (ending),
    .cut_i       (cut),
    .clk_i       (clk_i),
    .rst_i       (rst_i),
    .m_valid_o   (wide_valid),
    .m_ready_i   (wide_ready),
    .m_data_o    (wide_data),
    .m_start_o   (wide_start),
    .m_end_o     (wide_end),
    .overrun_o   (overrun_o),
    .cut_o       (cut_o)
  );

  sp_beat_split #(
    .Parts(Group / 4)
  ) u_split (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .s_valid_i(wide_valid),
    .s_ready_o(wide_ready),
    .s_data_i (wide_data),
    .s_start_i(wide_start),
    .s_end_i  (wide_end),
    .m_valid_o(m_valid_o),
    .m_data_o (m_data_o),
    .m_start_o(m_start_o),
    .m_end_o  (m_end_o)
  );

  // --- Counts and states, each bit by itself or Gray-coded ---
  logic        lost_there, lost_there_q;
  logic [15:0] gray, binary;

  sp_sync #(
    .Width(Lanes + 19)
  ) u_states (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  ({failed, ready_q, lost_any_q, gray_q}),
    .q_o  ({failed_o, aligned_o, lost_there, gray})
  );

  for (genvar i = 0; i < 16; i++) begin : gen_binary
    assign binary[i] = ^gray[15:i];
  end

  always_ff @(posedge clk_i) begin
    lost_there_q <= rst_i ? 1'b0 : lost_there;
    damaged_o    <= binary;
  end
  assign lost_o = lost_there ^ lost_there_q;

endmodule

`default_nettype wire
