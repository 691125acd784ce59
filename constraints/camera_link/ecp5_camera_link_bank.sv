// The front end for Camera Link on an ECP5, with the lanes of all links in one bank: its one edge clock
// serves them all. It comes from X's clock.
//
//   lane ─▶ DELAYF ─▶ IDDR71B ─▶ sp_channel_link_align ─▶ sp_camera_link ─▶ video
//   eclk_i ─▶ ECLKSYNCB ─▶ CLKDIVF, by 3.5 ─▶ clock of the words
//
// eclk_i has 3.5 times the camera's clock, in any phase. Each of its edges takes a sample, one of each
// bit. sp_channel_link_align finds each link's delay by its clock lane: DELAYF has 128 taps of about
// 25 ps (Lattice's simulation model of it), 3.2 ns together, more than a bit from 45 MHz on. A fall of
// MOVE adds a tap (the same model).
//
// good_i low holds everything: while X's clock is away, no link brings words. Y and Z may come and go;
// that does not disturb X. rst_i, high for four clocks of the camera or more, also starts the search on
// all links.
`default_nettype none

module ecp5_camera_link_bank #(
  // As in sp_camera_link
  parameter int Taps = 8,  // 1..3 (Base), 4 (Medium), 8 (Full) or 10 (80 bit)
  parameter int Bits = 8,  // 8; with 1 or 2 taps also 10 or 12, with 8 taps also 10
  parameter bit DataValid = 1'b1,
  parameter int Columns = 0,  // of a line, with 8 or 10 taps
  parameter int LogWords = 9,  // with 8 or 10 taps
  parameter int LogDepth = Taps >= 4 ? 5 : 4,
  // As in sp_channel_link_align
  parameter int DelayTaps = 128,
  parameter int Settle = 16,
  parameter int LogWindow = 8,
  parameter int LogGood = 8,
  parameter int LogPatience = 11
) (
  input  wire logic [14:0] lanes_i,     // X's data 0 to 3 and clock, Y's, Z's; those without a link are ignored
  input  wire logic        eclk_i,
  input  wire logic        good_i,      // eclk_i is good (the PLL's lock)

  input  wire logic        clk_i,
  input  wire logic        rst_i,       // active high, synchronous to clk_i
  output logic             m_valid_o,
  output logic      [31:0] m_data_o,
  output logic             m_start_o,
  output logic             m_end_o,
  output logic             overrun_o,
  output logic             lost_o,
  output logic             apart_o,

  // X, Y, Z, in the clock of the words: what a link does. To look at them, and for simulations of the
  // delays.
  output logic      [2:0]  locked_o,    // low without that clock
  output logic      [2:0]  tap_load_o,
  output logic      [2:0]  tap_move_o
);

  localparam int Links = Taps <= 3 ? 1 : Taps == 4 ? 2 : 3;

  logic        eclk, sclk, stop, cells_rst, restart;
  logic [2:0]  good_q, locked, valid, tap_load, tap_move;
  logic [83:0] words;

  ecp5_gearing_start u_start (
    .clk_i (clk_i),
    .good_i(good_i),
    .stop_o(stop),
    .rst_o (cells_rst)
  );

  ECLKSYNCB u_sync (
    .ECLKI(eclk_i),
    .STOP (stop),
    .ECLKO(eclk)
  );

  CLKDIVF #(
    .DIV("3.5")
  ) u_divider (
    .CLKI   (eclk),
    .RST    (cells_rst),
    .ALIGNWD(1'b0),
    .CDIVX  (sclk)
  );

  always_ff @(posedge sclk or posedge cells_rst) begin
    if (cells_rst) good_q <= '0;
    else good_q <= {good_q[1:0], 1'b1};
  end

  sp_sync u_restart (
    .clk_i(sclk),
    .rst_i(1'b0),
    .d_i  (rst_i),
    .q_o  (restart)
  );

  assign tap_load_o = tap_load;
  assign tap_move_o = tap_move;

  for (genvar k = 0; k < 3; k++) begin : gen_link
    if (k < Links) begin : gen_used
      logic        unused;
      logic [34:0] samples;

      for (genvar n = 0; n < 5; n++) begin : gen_lane
        logic delayed, unused_flag;

        DELAYF #(
          .DEL_MODE ("USER_DEFINED"),
          .DEL_VALUE(0)
        ) u_delay (
          .A        (lanes_i[5*k+n]),
          .LOADN    (!tap_load[k]),
          .MOVE     (tap_move[k]),
          .DIRECTION(1'b0),
          .Z        (delayed),
          .CFLAG    (unused_flag)
        );

        IDDR71B u_samples (
          .D      (delayed),
          .ECLK   (eclk),
          .SCLK   (sclk),
          .RST    (cells_rst),
          .ALIGNWD(1'b0),
          .Q0     (samples[7*n]),
          .Q1     (samples[7*n+1]),
          .Q2     (samples[7*n+2]),
          .Q3     (samples[7*n+3]),
          .Q4     (samples[7*n+4]),
          .Q5     (samples[7*n+5]),
          .Q6     (samples[7*n+6])
        );
      end

      sp_channel_link_align #(
        .Taps       (DelayTaps),
        .Settle     (Settle),
        .LogWindow  (LogWindow),
        .LogGood    (LogGood),
        .LogPatience(LogPatience)
      ) u_align (
        .clk_i     (sclk),
        .rst_i     (!good_q[2] || restart),
        .lanes_i   (samples),
        .tap_load_o(tap_load[k]),
        .tap_move_o(tap_move[k]),
        .locked_o  (locked[k]),
        .valid_o   (valid[k]),
        .word_o    (words[28*k+:28]),
        .error_o   (unused)
      );
      assign locked_o[k] = locked[k] && good_q[2];
    end else begin : gen_unused
      logic unused;
      assign unused          = ^lanes_i[5*k+:5];
      assign locked[k]       = 1'b0;
      assign locked_o[k]     = 1'b0;
      assign valid[k]        = 1'b0;
      assign tap_load[k]     = 1'b0;
      assign tap_move[k]     = 1'b0;
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
    .x_clk_i   (sclk),
    .x_locked_i(locked[0]),
    .x_valid_i (valid[0]),
    .x_word_i  (words[27:0]),
    .y_clk_i   (sclk),
    .y_locked_i(locked[1]),
    .y_valid_i (valid[1]),
    .y_word_i  (words[55:28]),
    .z_clk_i   (sclk),
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
