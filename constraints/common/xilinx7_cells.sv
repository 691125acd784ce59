// The cells of 7-series FPGAs that the Acorn's top and LitePCIe's core have, for simulation: the
// clocks of PLLs are their inputs, and nothing is delayed. So the simulation gives the pixel clock
// in the place of the card's oscillator.
`default_nettype none

module IBUFDS (
  input  wire logic I,
  input  wire logic IB,
  output logic      O
);
  logic unused;
  assign unused = IB;
  assign O = I;
endmodule

module IBUFDS_GTE2 (
  input  wire logic CEB,
  input  wire logic I,
  input  wire logic IB,
  output logic      O
);
  logic unused;
  assign unused = IB || CEB;
  assign O = I;
endmodule

module BUFG (
  input  wire logic I,
  output logic      O
);
  assign O = I;
endmodule

module BUFGCTRL (
  input  wire logic CE0,
  input  wire logic CE1,
  input  wire logic I0,
  input  wire logic I1,
  input  wire logic S0,
  input  wire logic S1,
  output logic      O
);
  logic unused;
  assign unused = ^{CE0, CE1, I1, S0, S1};
  assign O = I0;
endmodule

module PLLE2_BASE #(
  parameter real CLKIN1_PERIOD = 0.0,
  parameter int CLKFBOUT_MULT = 5,
  parameter int CLKOUT0_DIVIDE = 1
) (
  input  wire logic CLKIN1,
  input  wire logic CLKFBIN,
  input  wire logic PWRDWN,
  input  wire logic RST,
  output logic      CLKFBOUT,
  output logic      CLKOUT0,
  output logic      CLKOUT1,
  output logic      CLKOUT2,
  output logic      CLKOUT3,
  output logic      CLKOUT4,
  output logic      CLKOUT5,
  output logic      LOCKED
);
  logic unused;
  assign unused = CLKFBIN || PWRDWN;
  assign CLKFBOUT = CLKIN1;
  assign CLKOUT0 = CLKIN1;
  assign {CLKOUT1, CLKOUT2, CLKOUT3, CLKOUT4, CLKOUT5} = '0;
  assign LOCKED = !RST;
endmodule

module MMCME2_ADV #(
  parameter BANDWIDTH = "OPTIMIZED",
  parameter CLKFBOUT_MULT_F = 5,
  parameter real CLKIN1_PERIOD = 0.0,
  parameter CLKOUT0_DIVIDE_F = 1,
  parameter CLKOUT0_PHASE = 0,
  parameter CLKOUT1_DIVIDE = 1,
  parameter CLKOUT1_PHASE = 0,
  parameter CLKOUT2_DIVIDE = 1,
  parameter CLKOUT2_PHASE = 0,
  parameter CLKOUT3_DIVIDE = 1,
  parameter CLKOUT3_PHASE = 0,
  parameter DIVCLK_DIVIDE = 1,
  parameter real REF_JITTER1 = 0.0
) (
  input  wire logic CLKFBIN,
  input  wire logic CLKIN1,
  input  wire logic PWRDWN,
  input  wire logic RST,
  output logic      CLKFBOUT,
  output logic      CLKOUT0,
  output logic      CLKOUT1,
  output logic      CLKOUT2,
  output logic      CLKOUT3,
  output logic      LOCKED
);
  logic unused;
  assign unused = CLKFBIN || PWRDWN;
  assign {CLKFBOUT, CLKOUT0, CLKOUT1, CLKOUT2, CLKOUT3} = {5{CLKIN1}};
  assign LOCKED = !RST;
endmodule

module FDCE (
  input  wire logic C,
  input  wire logic CE,
  input  wire logic CLR,
  input  wire logic D,
  output logic      Q
);
  always_ff @(posedge C or posedge CLR) begin
    if (CLR) Q <= 1'b0;
    else if (CE) Q <= D;
  end
endmodule

module FDPE #(
  parameter logic INIT = 1'b1
) (
  input  wire logic C,
  input  wire logic CE,
  input  wire logic D,
  input  wire logic PRE,
  output logic      Q
);
  always_ff @(posedge C or posedge PRE) begin
    if (PRE) Q <= 1'b1;
    else if (CE) Q <= D;
  end
endmodule

`default_nettype wire
