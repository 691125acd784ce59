// The front end for serial LVDS sensors on an ECP5 where the sensor's clock line is on pins that feed
// a PLL and no edge clock. The phase of the PLL does not matter: training finds where the edges lie in
// the bits. While the PLL has no lock, the front end waits as while the sensor's clock is away.
`default_nettype none

module ecp5_lvds_sensor_pll #(
  // All but Divider as in sp_lvds_sensor
  parameter int Lanes = 4,  // data lanes: 1, 2, 4, 8 or 16
  parameter int Bits = 10,  // of a word: 10 or 12; with Codes 8 or 10
  parameter bit Codes = 1'b1,
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
  parameter int LogDepth = 9,  // 1..15
  parameter int Divider = 2  // sensor's clock x Divider must be 400 to 800 MHz
) (
  input  wire logic [Lanes:0]  lanes_i,
  input  wire logic            pll_clk_i,   // the sensor's clock line

  input  wire logic            clk_i,
  input  wire logic            rst_i,
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

  logic eclk, good, unused_second;

  ecp5_pll #(
    .Divider(Divider)
  ) u_pll (
    .clk_i   (pll_clk_i),
    .clk_o   (eclk),
    .second_o(unused_second),
    .good_o  (good)
  );

  ecp5_lvds_sensor #(
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
    .lanes_i  (lanes_i),
    .eclk_i   (eclk),
    .good_i   (good),
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .m_valid_o(m_valid_o),
    .m_data_o (m_data_o),
    .m_start_o(m_start_o),
    .m_end_o  (m_end_o),
    .overrun_o(overrun_o),
    .cut_o    (cut_o),
    .lost_o   (lost_o),
    .aligned_o(aligned_o),
    .failed_o (failed_o),
    .damaged_o(damaged_o)
  );

endmodule

`default_nettype wire
