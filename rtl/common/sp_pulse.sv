// A pulse of so many clocks.
//
// Guarantees: pulse_o is high from two clocks after start_i on for width_i clocks; a start_i before that begins anew, and with
// width_i = 0 ends it. clear_i ends it too, two clocks later. width_i stands still from the
// clock before start_i on. awake_i is high in the clock of start_i or clear_i and while anything
// follows of them (two clocks after the last high one everything stands still). The count runs down in two chains of half the width.
`default_nettype none

module sp_pulse #(
  parameter int Width = 16  // even
) (
  input  wire logic             clk_i,
  input  wire logic             awake_i,
  input  wire logic             clear_i,
  input  wire logic             start_i,
  input  wire logic [Width-1:0] width_i,
  output logic                  pulse_o
);

  localparam int Half = Width / 2;

  logic [Half-1:0] low_q, high_q;
  logic            on_q;        // the count is not 0
  logic            low_zero_q;  // its lower half is
  logic            high_zero_q;  // its upper half was, a clock ago: soon enough, since it changes where the lower wraps
  logic            some_q;      // of width_i: it is not 0
  logic            short_q;     // its upper half is

  always_ff @(posedge clk_i) begin
    if (awake_i) begin
      pulse_o <= on_q;
      some_q  <= width_i != '0;
      short_q <= width_i[Width-1:Half] == '0;
      if (clear_i) begin
        on_q <= 1'b0;
      end else if (start_i) begin
        on_q <= some_q;
      end else if (on_q) begin
        on_q <= !(high_zero_q && low_q == Half'(1));
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (start_i) begin
      {high_q, low_q} <= width_i;
      low_zero_q      <= width_i[Half-1:0] == '0;
      high_zero_q     <= short_q;
    end else if (on_q) begin
      low_q       <= low_q - Half'(1);
      low_zero_q  <= low_q == Half'(1);
      high_zero_q <= high_q == '0;
      if (low_zero_q) high_q <= high_q - Half'(1);
    end
  end

endmodule

`default_nettype wire
