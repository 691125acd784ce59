// The front end for Camera Link alone on an ECP5, with PLLs and pins, to place and route it.
//
// A PLL's oscillator runs at Divider times the camera's clock, which must be 400 to 800 MHz: with
// Divider = 7 the camera has 58 to 108 MHz (only with Samples = 1), with 14 it has 29 to 57 MHz.
// The samples are half a bit behind the edges of the clock lane with Samples = 1, and a quarter and
// three quarters with 2, if all delays on the chip are equal; Phase corrects what they are not.
//
// nextpnr places one or two links. It cannot place three with a clock each (../README.md#camera-link).
`default_nettype none

module ecp5_camera_link_pins #(
  parameter int Taps = 3,  // 1..4, 8 or 10
  parameter int Bits = 8,  // as in ecp5_camera_link, as all below but Divider and Phase
  parameter int Samples = 1,  // 1 or 2
  parameter int Divider = 7,  // 7 or 14; with two samples 14
  parameter int Phase = 8 * Divider / (14 * Samples),  // of the samples, in eighths of its period
  parameter logic [34:0] DelaysX = '0,
  parameter logic [34:0] DelaysY = '0,
  parameter logic [34:0] DelaysZ = '0,
  parameter bit DataValid = 1'b1,
  parameter int Columns = 0,
  parameter int LogWords = 9,
  parameter int LogDepth = Taps >= 4 ? 5 : 4
) (
  input  wire logic [4:0]  x_lanes_i,   // data 0 to 3, clock
  input  wire logic        x_pll_clk_i,  // the clock lane once more
  input  wire logic [4:0]  y_lanes_i,
  input  wire logic        y_pll_clk_i,
  input  wire logic [4:0]  z_lanes_i,
  input  wire logic        z_pll_clk_i,

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

  if (Divider != 14 && (Divider != 7 || Samples != 1)) begin : gen_divider
    divider_is_not_14_or_with_one_sample_7 u_error ();
  end

  localparam int EdgeDivider = 2 * Divider / (7 * Samples);

  localparam int Links = Taps <= 3 ? 1 : Taps == 4 ? 2 : 3;

  logic [2:0] eclk, good, unused_clk, unused_locked;

  for (genvar k = 0; k < 3; k++) begin : gen_pll
    if (k < Links) begin : gen_used
      ecp5_pll #(
        .Divider      (Divider),
        .SecondDivider(EdgeDivider),
        .Phase        (Phase)
      ) u_pll (
        .clk_i   (k == 0 ? x_pll_clk_i : k == 1 ? y_pll_clk_i : z_pll_clk_i),
        .clk_o   (unused_clk[k]),
        .second_o(eclk[k]),
        .good_o  (good[k])
      );
    end else begin : gen_unused
      logic unused;
      assign unused  = k == 1 ? y_pll_clk_i : z_pll_clk_i;
      assign eclk[k] = 1'b0;
      assign good[k] = 1'b0;
      assign unused_clk[k] = 1'b0;
    end
  end

  ecp5_camera_link #(
    .Taps     (Taps),
    .Bits     (Bits),
    .Samples  (Samples),
    .DelaysX  (DelaysX),
    .DelaysY  (DelaysY),
    .DelaysZ  (DelaysZ),
    .DataValid(DataValid),
    .Columns  (Columns),
    .LogWords (LogWords),
    .LogDepth (LogDepth)
  ) u_link (
    .x_lanes_i(x_lanes_i),
    .x_eclk_i (eclk[0]),
    .x_good_i (good[0]),
    .y_lanes_i(y_lanes_i),
    .y_eclk_i (eclk[1]),
    .y_good_i (good[1]),
    .z_lanes_i(z_lanes_i),
    .z_eclk_i (eclk[2]),
    .z_good_i (good[2]),
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .m_valid_o(m_valid_o),
    .m_data_o (m_data_o),
    .m_start_o(m_start_o),
    .m_end_o  (m_end_o),
    .overrun_o(overrun_o),
    .lost_o   (lost_o),
    .apart_o  (apart_o),
    .locked_o (unused_locked)
  );

endmodule

`default_nettype wire
