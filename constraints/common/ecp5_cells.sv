// Cells of the ECP5 that LiteEth's PHY and the deserializers for Camera Link and LVDS sensors use, as
// far as a simulation without delays needs them.
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

// --- The deserializers', as Lattice's technical note FPGA-TN-02035 describes them; that each rise
// of ALIGNWD moves the words by two samples is from there, too ---

module ECLKSYNCB (
  input  wire logic ECLKI,
  input  wire logic STOP,
  output logic      ECLKO
);
  assign ECLKO = ECLKI && !STOP;
endmodule

// By 3.5, seven edges of CLKI a period, or by 2, four. After a rise of ALIGNWD it pauses for two edges.
module CLKDIVF #(
  parameter DIV = "3.5",
  parameter GSR = "DISABLED"
) (
  input  wire logic CLKI,
  input  wire logic RST,
  input  wire logic ALIGNWD,
  output logic      CDIVX
);
  localparam logic [2:0] Edges = DIV == "2.0" ? 3'd4 : 3'd7;
  logic [2:0] edge_q;
  logic [1:0] pause_q;
  logic       align_q;
  always @(posedge CLKI or negedge CLKI or posedge RST) begin
    if (RST) begin
      edge_q  <= '0;
      pause_q <= '0;
      align_q <= 1'b0;
      CDIVX   <= 1'b0;
    end else begin
      align_q <= ALIGNWD;
      if (ALIGNWD && !align_q) pause_q <= 2'd2;
      else if (pause_q != '0) pause_q <= pause_q - 1'b1;
      if (pause_q == '0) begin
        edge_q <= edge_q == Edges - 1'b1 ? '0 : edge_q + 1'b1;
        CDIVX  <= edge_q < Edges >> 1;
      end
    end
  end
endmodule

// The seven samples before a rise of SCLK, the last one taken by the edge of ECLK that raises it
module IDDR71B #(
  parameter GSR = "ENABLED"
) (
  input  wire logic D,
  input  wire logic ECLK,
  input  wire logic SCLK,
  input  wire logic RST,
  input  wire logic ALIGNWD,
  output logic      Q0,
  output logic      Q1,
  output logic      Q2,
  output logic      Q3,
  output logic      Q4,
  output logic      Q5,
  output logic      Q6
);
  logic [6:0] shift_q;
  always @(posedge ECLK or negedge ECLK) shift_q <= {D, shift_q[6:1]};
  always_ff @(posedge SCLK) {Q6, Q5, Q4, Q3, Q2, Q1, Q0} <= shift_q;
endmodule

// The tap changes with the fall of MOVE, but delays nothing.
module DELAYF #(
  parameter DEL_MODE = "",
  parameter DEL_VALUE = 0
) (
  input  wire logic A,
  input  wire logic LOADN,
  input  wire logic MOVE,
  input  wire logic DIRECTION,
  output logic      Z,
  output logic      CFLAG
);
  assign Z     = A;
  assign CFLAG = 1'b0;
endmodule

// The four samples before a rise of SCLK, the last one taken by the edge of ECLK that raises it
module IDDRX2F #(
  parameter GSR = "ENABLED"
) (
  input  wire logic D,
  input  wire logic SCLK,
  input  wire logic ECLK,
  input  wire logic RST,
  input  wire logic ALIGNWD,
  output logic      Q0,
  output logic      Q1,
  output logic      Q2,
  output logic      Q3
);
  logic [3:0] shift_q;
  always @(posedge ECLK or negedge ECLK) shift_q <= {D, shift_q[3:1]};
  always_ff @(posedge SCLK) {Q3, Q2, Q1, Q0} <= shift_q;
endmodule

// The PLL: ports and parameters only, for what elaborates ecp5_pll. No simulation runs it.
module EHXPLLL #(
  parameter PLLRST_ENA = "",
  parameter INTFB_WAKE = "",
  parameter STDBY_ENABLE = "",
  parameter DPHASE_SOURCE = "",
  parameter OUTDIVIDER_MUXA = "",
  parameter OUTDIVIDER_MUXB = "",
  parameter OUTDIVIDER_MUXC = "",
  parameter OUTDIVIDER_MUXD = "",
  parameter CLKI_DIV = 1,
  parameter CLKFB_DIV = 1,
  parameter FEEDBK_PATH = "",
  parameter CLKOP_ENABLE = "",
  parameter CLKOP_DIV = 8,
  parameter CLKOP_CPHASE = 0,
  parameter CLKOP_FPHASE = 0,
  parameter CLKOS_ENABLE = "",
  parameter CLKOS_DIV = 8,
  parameter CLKOS_CPHASE = 0,
  parameter CLKOS_FPHASE = 0
) (
  input  wire logic CLKI, CLKFB, RST, STDBY, PHASESEL0, PHASESEL1, PHASEDIR, PHASESTEP, PHASELOADREG,
  input  wire logic PLLWAKESYNC, ENCLKOP, ENCLKOS, ENCLKOS2, ENCLKOS3,
  output logic      CLKOP, CLKOS, CLKOS2, CLKOS3, LOCK, INTLOCK, REFCLK, CLKINTFB
);
  assign {CLKOP, CLKOS, CLKOS2, CLKOS3, LOCK, INTLOCK, REFCLK, CLKINTFB} = '0;
endmodule

`default_nettype wire
