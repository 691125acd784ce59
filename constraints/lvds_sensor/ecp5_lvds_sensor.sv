// The front end for serial LVDS sensors on an ECP5: lanes into video for the board.
//
//   lane ─▶ DELAYF ─▶ IDDRX2F ─▶ sp_lvds_gear ─▶ sp_lvds_sensor ─▶ video
//   eclk_i ─▶ ECLKSYNCB ─▶ CLKDIVF, by 2 ─▶ clock of the words
//
// eclk_i is the sensor's clock line, half of the bit rate: 240 MHz for 480 Mbit/s. Each of its edges
// takes a sample. IDDRX2F gives four samples in a clock of half of that, sp_lvds_gear makes words of
// them. Where the edges lie in the bits is found by training: DELAYF has 128 taps of about 25 ps
// (Lattice's simulation model of it), 3.2 ns together, a bit or more from 320 Mbit/s on. DIRECTION is
// low for more delay, a fall of MOVE changes it (the same model). A lane that is slower than that needs
// a PLL with a phase of its own for eclk_i.
//
// good_i low holds the divider and the words: while the sensor's clock is away. The lanes are not
// trained anew afterwards, only aligned. The cells start by clk_i, so it must run.
`default_nettype none

module ecp5_lvds_sensor #(
  // All as in sp_lvds_sensor
  parameter int Lanes = 16,  // data lanes: 1, 2, 4, 8 or 16
  parameter int Bits = 10,  // of a word: 10 or 12; with Codes 8 or 10
  parameter bit Codes = 1'b0,
  parameter bit MsbFirst = Codes,
  parameter int Columns = 128,  // of a lane: 1..4096, a multiple of Lanes
  parameter int Burst = 128,  // words with data valid in a row: 1..4096; Columns is a multiple of it
  parameter bit Checked = 1'b0,
  parameter bit CheckSeed = 1'b0,
  parameter logic [11:0] Training = !Codes ? 12'h055 : Bits == 8 ? 12'h0E9 : 12'h3A6,
  parameter logic [11:0] ControlIdle = Codes ? Training : 12'h200,
  parameter logic [9:0] FrameEnd = 10'h32A,
  parameter logic [11:0] FixedMask = 12'h300,
  parameter logic [11:0] IdleMask = Codes ? 12'hFFF : FixedMask | 12'h007,
  parameter int Taps = 128,  // of a lane's delay: 1..128
  parameter int Settle = 16,  // words until a new tap shows: 1..255
  parameter int LogWindow = 5,  // 2..10
  parameter int LogPatience = 13,  // 6..20
  parameter int LogDepth = 9  // 1..15
) (
  input  wire logic [Lanes:0]  lanes_i,     // the last one is the control lane
  input  wire logic            eclk_i,
  input  wire logic            good_i,      // eclk_i is good

  input  wire logic            clk_i,
  input  wire logic            rst_i,       // active high, synchronous to clk_i
  output logic                 m_valid_o,
  output logic      [31:0]     m_data_o,
  output logic                 m_start_o,
  output logic                 m_end_o,
  output logic                 overrun_o,
  output logic                 cut_o,
  output logic                 lost_o,
  output logic                 aligned_o,
  output logic      [Lanes:0]  failed_o,
  output logic      [15:0]     damaged_o
);

  logic                      eclk, sclk, stop, cells_rst, valid, tap_up;
  logic [2:0]                good_q;
  logic [4*(Lanes+1)-1:0]    samples;
  logic [Bits*(Lanes+1)-1:0] words;
  logic [Lanes:0]            tap_load, tap_move;

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
    .DIV("2.0")
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

  for (genvar n = 0; n <= Lanes; n++) begin : gen_lane
    logic delayed, unused;

    DELAYF #(
      .DEL_MODE ("USER_DEFINED"),
      .DEL_VALUE(0)
    ) u_delay (
      .A        (lanes_i[n]),
      .LOADN    (!tap_load[n]),
      .MOVE     (tap_move[n]),
      .DIRECTION(!tap_up),
      .Z        (delayed),
      .CFLAG    (unused)
    );

    IDDRX2F u_samples (
      .D      (delayed),
      .SCLK   (sclk),
      .ECLK   (eclk),
      .RST    (cells_rst),
      .ALIGNWD(1'b0),
      .Q0     (samples[4*n]),
      .Q1     (samples[4*n+1]),
      .Q2     (samples[4*n+2]),
      .Q3     (samples[4*n+3])
    );
  end

  sp_lvds_gear #(
    .Lanes(Lanes + 1),
    .Bits (Bits)
  ) u_gear (
    .clk_i  (sclk),
    .rst_i  (!good_q[2]),
    .bits_i (samples),
    .valid_o(valid),
    .words_o(words)
  );

  sp_lvds_sensor #(
    .Lanes      (Lanes),
    .Bits       (Bits),
    .Codes      (Codes),
    .MsbFirst   (MsbFirst),
    .Columns    (Columns),
    .Burst      (Burst),
    .Checked    (Checked),
    .CheckSeed  (CheckSeed),
    .Training   (Training),
    .ControlIdle(ControlIdle),
    .FrameEnd   (FrameEnd),
    .FixedMask  (FixedMask),
    .IdleMask   (IdleMask),
    .Taps       (Taps),
    .Settle     (Settle),
    .LogWindow  (LogWindow),
    .LogPatience(LogPatience),
    .LogDepth   (LogDepth)
  ) u_front (
    .sensor_clk_i(sclk),
    .valid_i     (valid),
    .lanes_i     (words),
    .tap_load_o  (tap_load),
    .tap_move_o  (tap_move),
    .tap_up_o    (tap_up),
    .clk_i       (clk_i),
    .rst_i       (rst_i),
    .m_valid_o   (m_valid_o),
    .m_data_o    (m_data_o),
    .m_start_o   (m_start_o),
    .m_end_o     (m_end_o),
    .overrun_o   (overrun_o),
    .cut_o       (cut_o),
    .lost_o      (lost_o),
    .aligned_o   (aligned_o),
    .failed_o    (failed_o),
    .damaged_o   (damaged_o)
  );

endmodule

`default_nettype wire
