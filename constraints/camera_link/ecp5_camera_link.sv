// The front end for Camera Link on an ECP5: lanes of one or two cables into video for the board.
//
//   lanes ─▶ ecp5_channel_link ─▶ sp_channel_link_lock ─▶ sp_camera_link ─▶ video
//
// The edge clocks come from PLLs outside; ecp5_camera_link_pins has them. A link's own clock,
// divided from its edge clock, has the camera's frequency with Samples = 1, and twice it with 2.
// Base leaves the ports of Y alone, and Base and Medium those of Z.
`default_nettype none

module ecp5_camera_link #(
  parameter int Taps = 2,  // 1..3 (Base), 4 (Medium), 8 (Full) or 10 (80 bit)
  parameter int Bits = 8,  // 8; with 1 or 2 taps also 10 or 12, with 8 taps also 10
  parameter int Samples = 1,  // of each bit: 1 or 2; two notice lanes out of place
  parameter int LogGood = 8,  // log2 of the right words before a link is locked: 1 or more
  parameter logic [34:0] DelaysX = '0,  // see ecp5_channel_link
  parameter logic [34:0] DelaysY = '0,
  parameter logic [34:0] DelaysZ = '0,
  // As in sp_camera_link
  parameter bit DataValid = 1'b1,
  parameter int Columns = 0,  // of a line, with 8 or 10 taps
  parameter int LogWords = 9,  // with 8 or 10 taps
  parameter int LogDepth = Taps >= 4 ? 5 : 4
) (
  input  wire logic [4:0]  x_lanes_i,   // data 0 to 3, clock
  input  wire logic        x_eclk_i,    // 3.5 or 7 times the camera's clock
  input  wire logic        x_good_i,    // that clock is good (the PLL's lock)
  input  wire logic [4:0]  y_lanes_i,
  input  wire logic        y_eclk_i,
  input  wire logic        y_good_i,
  input  wire logic [4:0]  z_lanes_i,
  input  wire logic        z_eclk_i,
  input  wire logic        z_good_i,

  input  wire logic        clk_i,
  input  wire logic        rst_i,       // active high, synchronous to clk_i
  output logic             m_valid_o,
  output logic      [31:0] m_data_o,
  output logic             m_start_o,
  output logic             m_end_o,
  output logic             overrun_o,
  output logic             lost_o,
  output logic             apart_o,
  output logic      [2:0]  locked_o     // X, Y, Z; each in its link's clock, and low without it
);

  localparam int Links = Taps <= 3 ? 1 : Taps == 4 ? 2 : 3;

  logic [2:0]  sclk, locked, valid;
  logic [83:0] words;

  for (genvar k = 0; k < 3; k++) begin : gen_link
    if (k < Links) begin : gen_used
      logic        good, stop, cells_rst, align, unused;
      logic [2:0]  good_q;
      logic [34:0] samples;

      assign good = k == 0 ? x_good_i : k == 1 ? y_good_i : z_good_i;

      ecp5_gearing_start u_start (
        .clk_i (clk_i),
        .good_i(good),
        .stop_o(stop),
        .rst_o (cells_rst)
      );

      ecp5_channel_link #(
        .Delays(k == 0 ? DelaysX : k == 1 ? DelaysY : DelaysZ)
      ) u_link (
        .lanes_i  (k == 0 ? x_lanes_i : k == 1 ? y_lanes_i : z_lanes_i),
        .eclk_i   (k == 0 ? x_eclk_i : k == 1 ? y_eclk_i : z_eclk_i),
        .stop_i   (stop),
        .rst_i    (cells_rst),
        .align_i  (align),
        .sclk_o   (sclk[k]),
        .samples_o(samples)
      );

      // It falls with the PLL's lock, whose fall also stops the clock. So training begins anew, and
      // the frame is cut off, when the clock is back.
      always_ff @(posedge sclk[k] or posedge cells_rst) begin
        if (cells_rst) good_q <= '0;
        else good_q <= {good_q[1:0], 1'b1};
      end

      sp_channel_link_lock #(
        .Samples(Samples),
        .LogGood(LogGood)
      ) u_lock (
        .clk_i   (sclk[k]),
        .rst_i   (!good_q[2]),
        .lanes_i (samples),
        .align_o (align),
        .locked_o(locked[k]),
        .valid_o (valid[k]),
        .word_o  (words[28*k+:28]),
        .error_o (unused)
      );
      assign locked_o[k] = locked[k] && good_q[2];
    end else begin : gen_unused
      logic unused;
      assign unused         = k == 1 ? ^{y_lanes_i, y_eclk_i, y_good_i, DelaysY} :
                                       ^{z_lanes_i, z_eclk_i, z_good_i, DelaysZ};
      assign sclk[k]        = 1'b0;
      assign locked[k]      = 1'b0;
      assign locked_o[k]    = 1'b0;
      assign valid[k]       = 1'b0;
      assign words[28*k+:28] = '0;
    end
  end

  sp_camera_link #(
    .Taps     (Taps),
    .Bits     (Bits),
    .DataValid(DataValid),
    .Columns  (Columns),
    .LogWords (LogWords),
    .LogDepth (LogDepth)
  ) u_front (
    .x_clk_i   (sclk[0]),
    .x_locked_i(locked[0]),
    .x_valid_i (valid[0]),
    .x_word_i  (words[27:0]),
    .y_clk_i   (sclk[1]),
    .y_locked_i(locked[1]),
    .y_valid_i (valid[1]),
    .y_word_i  (words[55:28]),
    .z_clk_i   (sclk[2]),
    .z_locked_i(locked[2]),
    .z_valid_i (valid[2]),
    .z_word_i  (words[83:56]),
    .clk_i     (clk_i),
    .rst_i     (rst_i),
    .m_valid_o (m_valid_o),
    .m_data_o  (m_data_o),
    .m_start_o (m_start_o),
    .m_end_o   (m_end_o),
    .overrun_o (overrun_o),
    .lost_o    (lost_o),
    .apart_o   (apart_o)
  );

endmodule

`default_nettype wire
