// What the header says of a frame: sequence, time stamp, encoder count, pattern index, settings.
//
// A header of four beats is written at most seven clocks after the event that causes it, while the next frame may already
// have begun. Each field is therefore captured so late that the header before it is out, and so early that its own is not
// yet: a header caused by an event of clock e (sp_packetizer) reads its beat i in clock e + 3 + i. The event is one clock after
// the beat that causes it (a last row's first, a line's last), or in the clock of the next frame's start where that breaks the
// frame; so a frame that starts in clock c shows in beat i from clock c + 4 + i on.
//
// The time stamp is nevertheless that of the frame's first beat at the video input (the counter runs ahead by the
// delay), and so is the encoder count (sp_encoder is late by the same number of clocks).
`default_nettype none

module sp_frame_info #(
  parameter int ColumnBits = 12,
  parameter int RowBits = 10
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  input  wire logic                  frame_start_i,
  input  wire logic                  stray_before_i,
  input  wire logic                  take_i,
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic [RowBits-1:0]    rows_i,
  input  wire logic [1:0]            mode_i,
  input  wire logic [7:0]            threshold_i,
  input  wire logic [7:0]            stream_i,

  input  wire logic [31:0]           encoder_i,
  input  wire logic [15:0]           pattern_i,

  output logic [63:0]                time_o,      // clocks since reset, less 6; from the second clock on
  output logic [31:0]                frames_o,    // frames accepted
  output logic                       captured_o,  // the pattern index is captured at the end of the next clock
  // header beat 0 (the sequence is taken with it)
  output logic [7:0]                 stream_o,
  output logic [15:0]                pattern_o,
  output logic [1:0]                 mode_o,
  output logic [7:0]                 threshold_o,
  output logic [63:0]                sequence_o,
  // header beat 1
  output logic [63:0]                time_stamp_o,
  // header beat 2
  output logic [31:0]                encoder_o,
  output logic [ColumnBits-1:0]      columns_o,
  output logic [RowBits-1:0]         rows_o,
  // header beat 3
  output logic [RowBits-1:0]         lines_o,     // rows_o, a clock later
  output logic                       stray_before_o
);

  // Clocks from the edge that takes a frame's first beat at the video input to the edge that captures the time.
  localparam logic [63:0] CaptureDelay = 64'd6;

  logic [17:0] events_q;  // {frame_start_i, take_i, stray_before_i}, one to six clocks ago, the latest lowest
  logic        start2, start3, start4, start5, start6, take3, take5, take6;  // of it, so many clocks ago
  logic [63:0] accepted;  // frames
  logic        awake_q;  // a frame started in the last six clocks; else nothing moves but the time

  assign start2 = events_q[5];
  assign start3 = events_q[8];
  assign start4 = events_q[11];
  assign start5 = events_q[14];
  assign start6 = events_q[17];
  assign take3  = events_q[7];
  assign take5  = events_q[13];
  assign take6  = events_q[16];

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      events_q <= '0;
      awake_q  <= 1'b0;
    end else if (frame_start_i || awake_q) begin
      events_q <= {events_q[14:0], frame_start_i, take_i, stray_before_i};
      awake_q  <= frame_start_i || (events_q[14:0] & 15'b100_100_100_100_100) != '0;
    end
  end

  sp_counter #(
    .Width     (64),
    .ResetValue(64'd1 - CaptureDelay)  // it tells its count two clocks later, not one
  ) u_time (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .inc_i  (1'b1),
    .count_o(time_o)
  );

  // The first frame has sequence 0: the number of those before it, as it is told in the clock start3.
  sp_counter #(
    .Width(64)
  ) u_frames (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .inc_i  (start2),
    .count_o(accepted)
  );

  assign frames_o   = accepted[31:0];
  assign captured_o = start2;

  always_ff @(posedge clk_i) begin
    if (take3) begin
      stream_o    <= stream_i;
      mode_o      <= mode_i;
      threshold_o <= threshold_i;
    end
    if (start3) begin
      pattern_o  <= pattern_i;
      sequence_o <= accepted;
    end
    if (start4) time_stamp_o <= time_o;
    if (start5) encoder_o <= encoder_i;
    if (take5) begin
      columns_o <= columns_i;
      rows_o    <= rows_i;
    end
    if (take6) lines_o <= rows_o;
    if (start6) stray_before_o <= events_q[15];
  end

endmodule

`default_nettype wire
