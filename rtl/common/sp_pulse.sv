// A pulse of so many clocks.
//
// Guarantees: pulse_o, a register, is high from the clock after start_i on for width_i clocks; a start_i before that begins
// anew, and with width_i = 0 ends it. clear_i ends it too, whatever start_i. width_i, and what is said of it, stand still from
// the clock of start_i on.
`default_nettype none

module sp_pulse #(
  parameter int Width = 16  // a multiple of 4, up to 16
) (
  input  wire logic             clk_i,
  input  wire logic             awake_i,  // else nothing moves
  input  wire logic             clear_i,
  input  wire logic             start_i,
  input  wire logic [Width-1:0] width_i,
  input  wire logic             some_i,  // width_i is not 0
  input  wire logic             one_i,   // it is 1
  output logic                  pulse_o
);

  // The width is compared in pieces, a clock before it counts: the count is a clock ahead.
  localparam int Piece = 4;
  localparam int Pieces = Width / Piece;

  logic [Width-1:0]  count_q;  // clocks of the pulse with the next
  logic [Pieces-1:0] equal_q;  // those pieces of the width have been reached
  logic              first_q;  // the first clock of a pulse of one
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
      for (int k = 0; k < Pieces; k++) equal_q[k] <= count_q[Piece*k+:Piece] == width_i[Piece*k+:Piece];
    end
  end

endmodule

`default_nettype wire
