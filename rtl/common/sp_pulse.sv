// A pulse of a given number of clocks.
//
// Guarantees: pulse_o is a register. It is high for width_i clocks, beginning one clock after
// start_i. A start_i during a pulse begins a new one; with width_i = 0 it ends the pulse. clear_i
// ends the pulse, with or without start_i. width_i, some_i and one_i stand still from the clock of
// start_i on.
`default_nettype none

module sp_pulse #(
  parameter int Width = 16  // 4, 8, 12 or 16
) (
  input  wire logic             clk_i,
  input  wire logic             awake_i,  // nothing moves without it
  input  wire logic             clear_i,
  input  wire logic             start_i,
  input  wire logic [Width-1:0] width_i,
  input  wire logic             some_i,  // width_i is not 0
  input  wire logic             one_i,   // width_i is 1
  output logic                  pulse_o
);

  if (Width < 4 || Width > 16 || Width % 4 != 0) begin : gen_width
    width_is_not_4_8_12_or_16 u_error ();
  end

  // The width is compared in pieces, one clock before it counts; so the count runs one clock ahead.
  localparam int Piece = 4;
  localparam int Pieces = Width / Piece;

  logic [Width-1:0]  count_q;  // clocks of the pulse, including the next
  logic [Pieces-1:0] equal_q;  // these pieces of the width are reached
  logic              first_q;  // the only clock of a pulse of one
  logic              on_q;

  assign pulse_o = on_q;

  always_ff @(posedge clk_i) if (awake_i) begin
    first_q <= start_i && one_i;
    on_q    <= !clear_i && (start_i ? some_i : on_q && !first_q && equal_q != '1);
    if (start_i) begin
      count_q <= Width'(2);
      equal_q <= '0;
    end else begin
      count_q <= count_q + Width'(1);
      for (int k = 0; k < Pieces; k++) equal_q[k] <=
          count_q[Piece*k+:Piece] == width_i[Piece*k+:Piece];
    end
  end

endmodule

`default_nettype wire
