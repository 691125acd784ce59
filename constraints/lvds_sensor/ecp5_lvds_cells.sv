// Cells of the ECP5 that ecp5_lvds_sensor uses, as far as a simulation without delays needs them.
// (ecp5_cells.sv in ../common has the divider by 3.5.)
`default_nettype none

// verilator lint_off DECLFILENAME
// verilator lint_off UNUSEDSIGNAL
// verilator lint_off UNUSEDPARAM

module ECLKSYNCB (
  input  wire logic ECLKI,
  input  wire logic STOP,
  output logic      ECLKO
);
  assign ECLKO = ECLKI && !STOP;
endmodule

// Only by 2: four edges of CLKI a period
module CLKDIVF #(
  parameter DIV = "2.0",
  parameter GSR = "DISABLED"
) (
  input  wire logic CLKI,
  input  wire logic RST,
  input  wire logic ALIGNWD,
  output logic      CDIVX
);
  logic [1:0] edge_q;
  always @(posedge CLKI or negedge CLKI or posedge RST) begin
    if (RST) begin
      edge_q <= '0;
      CDIVX  <= 1'b0;
    end else begin
      edge_q <= edge_q + 1'b1;
      CDIVX  <= edge_q < 2'd2;
    end
  end
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

`default_nettype wire
