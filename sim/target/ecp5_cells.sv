// Cells of the ECP5 that LiteEth's PHY uses, as far as a simulation without delays needs them.
`default_nettype none

// verilator lint_off DECLFILENAME
// verilator lint_off UNUSEDSIGNAL
// verilator lint_off UNUSEDPARAM

module ODDRX1F (
  input  wire logic D0,
  input  wire logic D1,
  input  wire logic SCLK,
  input  wire logic RST,
  output logic      Q
);
  logic first_q, second_q;
  always_ff @(posedge SCLK) {first_q, second_q} <= {D0, D1};
  assign Q = SCLK ? first_q : second_q;
endmodule

module IDDRX1F (
  input  wire logic D,
  input  wire logic SCLK,
  input  wire logic RST,
  output logic      Q0,
  output logic      Q1
);
  logic rising_q, falling_q;
  always_ff @(posedge SCLK) rising_q <= D;
  always_ff @(negedge SCLK) falling_q <= D;
  always_ff @(posedge SCLK) {Q0, Q1} <= {rising_q, falling_q};
endmodule

module DELAYG #(
  parameter DEL_MODE = "",
  parameter DEL_VALUE = 0
) (
  input  wire logic A,
  output logic      Z
);
  assign Z = A;
endmodule

module FD1S3BX (
  input  wire logic D,
  input  wire logic CK,
  input  wire logic PD,
  output logic      Q
);
  always_ff @(posedge CK or posedge PD) begin
    if (PD) Q <= 1'b1;
    else Q <= D;
  end
endmodule

module TRELLIS_IO #(
  parameter DIR = ""
) (
  input  wire logic B,
  input  wire logic I,
  input  wire logic T,
  output logic      O
);
  assign O = B;
endmodule

`default_nettype wire
