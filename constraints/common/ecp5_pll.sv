// A PLL of an ECP5 that follows a clock of the camera, with a second clock beside it.
//
// Its oscillator runs at Divider times clk_i, which must be 400 to 800 MHz. The second clock is that
// divided by SecondDivider, and Phase eighths of the oscillator's period behind clk_o.
`default_nettype none

module ecp5_pll #(
  parameter int Divider = 7,  // 1..128
  parameter int SecondDivider = Divider,  // 1..128
  parameter int Phase = 0  // 0 or more, less than 8 * SecondDivider, and at most 8 * (129 - SecondDivider) - 1
) (
  input  wire logic clk_i,
  output logic      clk_o,     // as clk_i, its edges where clk_i has them
  output logic      second_o,
  output logic      good_o     // both follow clk_i
);

  if (Divider < 1 || Divider > 128) begin : gen_divider
    divider_is_not_in_1_to_128 u_error ();
  end
  if (SecondDivider < 1 || SecondDivider > 128) begin : gen_second_divider
    second_divider_is_not_in_1_to_128 u_error ();
  end
  if (Phase < 0 || Phase >= 8 * SecondDivider || SecondDivider + Phase / 8 > 128) begin : gen_phase
    phase_is_not_less_than_a_period_or_too_long_for_the_pll u_error ();
  end

  logic unused_2, unused_3, unused_intlock, unused_refclk, unused_clkintfb;

  (* ICP_CURRENT = "12", LPF_RESISTOR = "8" *)
  EHXPLLL #(
    .PLLRST_ENA     ("DISABLED"),
    .INTFB_WAKE     ("DISABLED"),
    .STDBY_ENABLE   ("DISABLED"),
    .DPHASE_SOURCE  ("DISABLED"),
    .OUTDIVIDER_MUXA("DIVA"),
    .OUTDIVIDER_MUXB("DIVB"),
    .OUTDIVIDER_MUXC("DIVC"),
    .OUTDIVIDER_MUXD("DIVD"),
    .CLKI_DIV       (1),
    .CLKFB_DIV      (1),
    .FEEDBK_PATH    ("CLKOP"),
    .CLKOP_ENABLE   ("ENABLED"),
    .CLKOP_DIV      (Divider),
    .CLKOP_CPHASE   (Divider - 1),
    .CLKOP_FPHASE   (0),
    .CLKOS_ENABLE   ("ENABLED"),
    .CLKOS_DIV      (SecondDivider),
    .CLKOS_CPHASE   (SecondDivider - 1 + Phase / 8),
    .CLKOS_FPHASE   (Phase % 8)
  ) u_pll (
    .CLKI        (clk_i),
    .CLKFB       (clk_o),
    .RST         (1'b0),
    .STDBY       (1'b0),
    .PHASESEL0   (1'b0),
    .PHASESEL1   (1'b0),
    .PHASEDIR    (1'b1),
    .PHASESTEP   (1'b1),
    .PHASELOADREG(1'b1),
    .PLLWAKESYNC (1'b0),
    .ENCLKOP     (1'b0),
    .ENCLKOS     (1'b0),
    .ENCLKOS2    (1'b0),
    .ENCLKOS3    (1'b0),
    .CLKOP       (clk_o),
    .CLKOS       (second_o),
    .CLKOS2      (unused_2),
    .CLKOS3      (unused_3),
    .LOCK        (good_o),
    .INTLOCK     (unused_intlock),
    .REFCLK      (unused_refclk),
    .CLKINTFB    (unused_clkintfb)
  );

endmodule

`default_nettype wire
