// The front end for serial LVDS sensors on an ECP5 where the sensor's clock line is on pins that feed
// a PLL and no edge clock. The phase of the PLL does not matter: training finds where the edges lie in
// the bits. While the PLL has no lock, the front end waits as while the sensor's clock is away.
`default_nettype none

module ecp5_lvds_sensor_pll #(
  parameter int Lanes = 4,  // all as in ecp5_lvds_sensor
  parameter int Bits = 10,
  parameter bit Codes = 1'b1,
  parameter bit Checked = 1'b0,
  parameter int LogPatience = 13,
  parameter int LogDepth = 9,
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
    .Checked    (Checked),
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
