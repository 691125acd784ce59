// Gray-code decoder: four pixels in every clock; a code image after every pair of patterns.
//
//   beats ─┬──────────── 3 clocks ───────────┐
//          └▶ memory port, read ─▶ state ─▶ 4 × sp_gray_lane ─▶ memory port, write
//   pattern index ─▶ sp_gray_sequence ──────────┘       └─────▶ codes
//
// The state of the four pixels of a beat is one word of a memory outside this module. Every frame
// that is decoded reads and writes all its words in order.
//
// Three things make the decoder give up a frame and wait for plane 0; abandoned_o counts them:
// * A word comes too late (mem_late_i comes with it). This beat leaves with codes 0 and without the
//   end of its line, codes_break_o with status late memory follows, and nothing more of the frame
//   leaves.
// * A frame starts less than TooClose clocks after the last beat of a frame of fewer beats. Words
//   are written TooClose clocks after their beat, so this frame could read a word that is not
//   written yet.
// * The codes of a frame are due, and busy_i is high four clocks after its start.
//
// Timing, for a beat of clock t: the word is asked for in t + 1, is there in t + 3 and is written
// in t + 6; the codes leave in t + 7. The pattern index is read four clocks after the start of the
// frame. The settings, columns_i and rows_i are read with take_i. A break of sp_frame_tracker
// leaves seven clocks later, after the codes of the clocks before it and before those of its own
// clock.
`default_nettype none

module sp_gray_decoder #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // largest image width, a multiple of 4; of Lanes
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // largest image height: 1 or more
  parameter int MaxBits = sp_spec_pkg::CodeCodeBits,  // largest m: 1..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  // derived, do not set
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int WordBits = Lanes * (sp_spec_pkg::PixelBits + 2 * MaxBits)
) (
  input  wire logic                  clk_i,                   // pixel clock
  input  wire logic                  rst_i,                   // active high, synchronous

  // Settings, read in the clock of take_i only
  input  wire logic                  take_i,                  // the settings below are taken over
  input  wire logic                  decode_i,                // decode the frames
  input  wire logic [3:0]            bits_i,                  // m, 1..MaxBits
  input  wire logic [7:0]            threshold_i,  // ambiguous where the pair differs by no more
  input  wire logic [ColumnBits-1:0] columns_i,               // a change restarts the decoder
  input  wire logic [RowBits-1:0]    rows_i,                  // a change restarts the decoder

  // Beats and breaks of sp_frame_tracker
  input  wire logic                  beat_valid_i,            // a beat of Lanes pixels
  input  wire logic [8*Lanes-1:0]    beat_pixels_i,           // leftmost pixel in 7..0
  input  wire logic                  beat_line_start_i,       // first beat of a line
  input  wire logic                  beat_line_end_i,         // last beat of a line
  input  wire logic                  beat_last_row_i,         // the row is the last of the frame
  input  wire logic                  frame_start_i,           // first beat of a frame
  input  wire logic                  break_i,                 // the frame breaks
  input  wire logic [sp_spec_pkg::StatusBits-1:0] break_status_i,  // why, with break_i
  input  wire logic [15:0]           pattern_i,  // read four clocks after the start of a frame

  // Memory port
  output logic                       mem_read_o,              // the next word is asked for
  output logic                       mem_read_first_o,        // first word of the frame
  input  wire logic [WordBits-1:0]   mem_data_i,              // two clocks after mem_read_o
  input  wire logic                  mem_late_i,              // the word came too late and is void
  output logic                       mem_write_o,             // the next word is written
  output logic                       mem_write_first_o,       // first word of the frame
  output logic      [WordBits-1:0]   mem_data_o,              // with mem_write_o
  output logic                       mem_end_o,  // the frame is over: no write of it comes later

  // Codes: leftmost in 15..0
  input  wire logic                  busy_i,  // codes of a frame that starts cannot be taken
  output logic                       codes_valid_o,           // a beat of Lanes codes
  output logic      [16*Lanes-1:0]   codes_o,                 // format code of the packets
  output logic                       codes_start_o,           // first beat of a frame
  output logic                       codes_line_start_o,      // first beat of a line
  output logic                       codes_line_end_o,        // last beat of a line
  output logic                       codes_last_row_o,        // the row is the last of the frame
  output logic                       codes_break_o,           // the frame breaks
  output logic [sp_spec_pkg::StatusBits-1:0] codes_status_o,  // why, with codes_break_o

  output logic      [31:0]           abandoned_o              // frames given up, as listed above
);

  if (MaxColumns < Lanes || MaxColumns % Lanes != 0) begin : gen_max_columns
    max_columns_is_not_a_multiple_of_lanes u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end
  if (MaxRows < 1) begin : gen_max_rows
    max_rows_is_less_than_1 u_error ();
  end

  localparam int StatusBits = sp_spec_pkg::StatusBits;
  localparam int StateBits = WordBits / Lanes;
  localparam int TooClose = 6;

  // --- Signals beside the pixels; the index counts the clocks after the beat ---
  logic [7:1]            valid_q, start_q, line_start_q, line_end_q, last_row_q, break_q;
  logic [StatusBits-1:0] status1_q, status2_q, status3_q, status4_q, status5_q, status6_q,
      status7_q;
  logic [4:1]            close_q, took_q;
  logic [8*Lanes-1:0]    pixels1_q, pixels2_q, pixels3_q;
  logic                  decode_q;  // the frame of stage 1 is decoded

  // --- Settings. They come at least seven clocks apart, but a frame that keeps those before it may
  // start just before; it is in stage 4 when its settings are read. ---
  logic [3:0]            bits_q, bits4_q;
  logic [7:0]            threshold_q, threshold4_q;
  logic [ColumnBits-1:0] columns_q;
  logic [RowBits-1:0]    rows_q;
  logic                  changed_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) decode_q <= 1'b0;
    else if (take_i) decode_q <= decode_i;
    if (take_i) begin
      changed_q <=
          {bits_i, threshold_i, columns_i, rows_i} != {bits_q, threshold_q, columns_q, rows_q};
      {bits_q, threshold_q, columns_q, rows_q} <= {bits_i, threshold_i, columns_i, rows_i};
    end
    if (took_q[3]) {bits4_q, threshold4_q} <= {bits_q, threshold_q};
  end

  // --- Frames that come too soon ---
  logic [2:0] beats_q;  // beats of the frame so far, up to TooClose
  logic       close;

  assign close = frame_start_i && |valid_q[TooClose-1:1] && beats_q != 3'(TooClose);

  always_ff @(posedge clk_i) begin
    if (rst_i) beats_q <= 3'(TooClose);
    else if (frame_start_i) beats_q <= 3'd1;
    else if (beat_valid_i && beats_q != 3'(TooClose)) beats_q <= beats_q + 3'd1;
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q <= '0;
      start_q <= '0;
      break_q <= '0;
      took_q  <= '0;
      close_q <= '0;
    end else begin
      valid_q <= {valid_q[6:1], beat_valid_i};
      start_q <= {start_q[6:1], frame_start_i};
      break_q <= {break_q[6:1], break_i};
      took_q  <= {took_q[3:1], take_i};
      close_q <= {close_q[3:1], close};
    end
  end

  always_ff @(posedge clk_i) begin
    line_start_q <= {line_start_q[6:1], beat_line_start_i};
    line_end_q   <= {line_end_q[6:1], beat_line_end_i};
    last_row_q   <= {last_row_q[6:1], beat_last_row_i};
    {status1_q, status2_q, status3_q, status4_q} <=
        {break_status_i, status1_q, status2_q, status3_q};
    {status5_q, status6_q, status7_q} <= {status4_q, status5_q, status6_q};
    {pixels1_q, pixels2_q, pixels3_q} <= {beat_pixels_i, pixels1_q, pixels2_q};
  end

  // --- Frames whose state comes too late ---
  logic [6:2] asked_q;             // a word was asked for
  logic       lost_before;         // the frame of stage 3 was lost before this beat
  // the frame was lost with this beat or before it; it was lost before it
  logic       lost4_q, again4_q;
  logic       lost5_q, again5_q;
  logic       late_q;              // first late word of a frame

  assign mem_read_o       = valid_q[1] && decode_q;
  assign mem_read_first_o = start_q[1];
  assign lost_before      = lost4_q && !start_q[3];

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      asked_q <= '0;
      lost4_q <= 1'b0;
      late_q  <= 1'b0;
    end else begin
      asked_q <= {asked_q[5:2], mem_read_o};
      if (asked_q[3]) lost4_q <= lost_before || mem_late_i;
      late_q <= asked_q[3] && mem_late_i && !lost_before;
    end
    again4_q <= lost_before;
    lost5_q  <= lost4_q;
    again5_q <= again4_q;
  end

  // --- What the frame is: positive or negative, codes due or not ---
  logic               negative, due, refused;
  logic [MaxBits-1:0] weight, above, mask;

  sp_gray_sequence #(
    .MaxBits(MaxBits)
  ) u_sequence (
    .clk_i     (clk_i),
    .rst_i     (rst_i),
    .start_i   (start_q[4]),
    .decode_i  (asked_q[4]),
    .pattern_i (pattern_i),
    .bits_i    (bits4_q),
    .restart_i (break_q[4] || close_q[4] || took_q[4] && changed_q),
    .lost_i    (asked_q[4] && lost4_q),
    .busy_i    (busy_i),
    .refused_o (refused),
    .negative_o(negative),
    .due_o     (due),
    .weight_o  (weight),
    .above_o   (above),
    .mask_o    (mask)
  );

  // --- Pixels ---
  logic lost6_q;

  for (genvar i = 0; i < Lanes; i++) begin : gen_lane
    sp_gray_lane #(
      .MaxBits(MaxBits)
    ) u_lane (
      .clk_i      (clk_i),
      .pixel_i    (pixels3_q[8*i+:8]),
      .state_i    (mem_data_i[StateBits*i+:StateBits]),
      .threshold_i(threshold4_q),
      .negative_i (negative),
      .weight_i   (weight),
      .above_i    (above),
      .mask_i     (mask),
      .state_o    (mem_data_o[StateBits*i+:StateBits]),
      .clear_i    (lost6_q),
      .code_o     (codes_o[16*i+:16])
    );
  end

  // --- Memory port, write ---
  assign mem_write_o       = asked_q[6];
  assign mem_write_first_o = start_q[6];
  assign mem_end_o         = break_q[7] || valid_q[7] && line_end_q[7] && last_row_q[7];

  // --- Codes out ---
  logic show6_q, end6_q;
  logic late6_q, late7_q, late8_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      show6_q       <= 1'b0;
      late6_q       <= 1'b0;
      late7_q       <= 1'b0;
      late8_q       <= 1'b0;
      codes_valid_o <= 1'b0;
      codes_start_o <= 1'b0;
      abandoned_o   <= '0;
    end else begin
      show6_q       <= asked_q[5] && due && !again5_q;
      late6_q       <= asked_q[5] && due && !again5_q && lost5_q;
      late7_q       <= late6_q;
      late8_q       <= late7_q;
      codes_valid_o <= show6_q;
      codes_start_o <= show6_q && start_q[6];
      if (late_q || close_q[4] && asked_q[4] || refused) abandoned_o <= abandoned_o + 32'd1;
    end
    end6_q             <= line_end_q[5] && !lost5_q;
    lost6_q            <= lost5_q;
    codes_line_start_o <= line_start_q[6];
    codes_line_end_o   <= end6_q;
    codes_last_row_o   <= last_row_q[6];
  end

  assign codes_break_o  = break_q[7] || late8_q;
  assign codes_status_o = late8_q ? StatusBits'(1) << sp_spec_pkg::StatusLateMemoryBit : status7_q;

  logic unused;
  assign unused = start_q[7] | line_start_q[7];

endmodule

`default_nettype wire
