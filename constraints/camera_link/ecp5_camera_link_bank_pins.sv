// ecp5_camera_link_bank with its PLL and pins, to place and route it.
//
// The PLL's oscillator runs at Divider times the camera's clock, which must be 400 to 800 MHz: with
// Divider = 7 the camera has 58 to 108 MHz, with 14 it has 29 to 57 MHz. Its phase does not matter.
`default_nettype none

module ecp5_camera_link_bank_pins #(
  parameter int Taps = 8,  // 1..4, 8 or 10
  parameter int Bits = 8,  // 8; with 1 or 2 taps also 10 or 12, with 8 taps also 10
  parameter bit DataValid = 1'b1,  // these as in sp_camera_link
  parameter int Columns = 0,
  parameter int LogWords = 9,
  parameter int LogDepth = Taps >= 4 ? 5 : 4,
  parameter int Divider = 7  // 7 or 14
) (
  input  wire logic [14:0] lanes_i,    // X's data 0 to 3 and clock, Y's, Z's; those without a link are ignored
  input  wire logic        pll_clk_i,  // X's clock lane once more

  input  wire logic        clk_i,
  input  wire logic        rst_i,
  output logic             m_valid_o,
  output logic      [31:0] m_data_o,
  output logic             m_start_o,
  output logic             m_end_o,
  output logic             overrun_o,
  output logic             lost_o,
  output logic             apart_o
);

  if (Divider != 7 && Divider != 14) begin : gen_divider
    divider_is_not_7_or_14 u_error ();
  end

  logic       eclk, good, unused_clk;
  logic [2:0] unused_locked, unused_load, unused_move;

  ecp5_pll #(
    .Divider      (Divider),
    .SecondDivider(2 * Divider / 7)
  ) u_pll (
    .clk_i   (pll_clk_i),
    .clk_o   (unused_clk),
    .second_o(eclk),
    .good_o  (good)
  );

  ecp5_camera_link_bank #(
    .Taps     (Taps),
    .Bits     (Bits),
    .DataValid(DataValid),
    .Columns  (Columns),
    .LogWords (LogWords),
    .LogDepth (LogDepth)
  ) u_link (
    .lanes_i   (lanes_i),
    .eclk_i    (eclk),
    .good_i    (good),
    .clk_i     (clk_i),
    .rst_i     (rst_i),
    .m_valid_o (m_valid_o),
    .m_data_o  (m_data_o),
    .m_start_o (m_start_o),
    .m_end_o   (m_end_o),
    .overrun_o (overrun_o),
    .lost_o    (lost_o),
    .apart_o   (apart_o),
    .locked_o  (unused_locked),
    .tap_load_o(unused_load),
    .tap_move_o(unused_move)
  );

endmodule

`default_nettype wire
