// A pulse of so many clocks.
//
// Guarantees: pulse_o, a register, is high from the clock after start_i on for width_i clocks; a start_i before that begins
// anew, and with width_i = 0 ends it. clear_i ends it too, whatever start_i. width_i, and what is said of it, stand still from
// the clock of start_i on. With no pulse under way nothing moves. The count runs down in two chains of half the width.
`default_nettype none

module sp_pulse #(
  parameter int Width = 16  // even
) (
  input  wire logic             clk_i,
  input  wire logic             clear_i,
  input  wire logic             start_i,
  input  wire logic [Width-1:0] width_i,
  input  wire logic             some_i,   // width_i is not 0
  input  wire logic             short_i,  // its upper half is
  output logic                  pulse_o
);

  localparam int Half = Width / 2;

  typedef struct packed {
    logic            on;         // the count is not 0
    logic            low_zero;   // its lower half is
    logic            high_zero;  // its upper half was, a clock ago: soon enough, since it changes where the lower wraps
    logic [Half-1:0] high;
    logic [Half-1:0] low;
  } count_t;

  count_t count_q;

  assign pulse_o = count_q.on;

  always_ff @(posedge clk_i) begin
    if (start_i || count_q.on) begin
      if (start_i) begin
        {count_q.high, count_q.low} <= width_i;
        count_q.low_zero            <= width_i[Half-1:0] == '0;
        count_q.high_zero           <= short_i;
      end else begin
        count_q.low       <= count_q.low - Half'(1);
        count_q.low_zero  <= count_q.low == Half'(1);
        count_q.high_zero <= count_q.high == '0;
        if (count_q.low_zero) count_q.high <= count_q.high - Half'(1);
      end
      count_q.on <= start_i ? some_i : !(count_q.high_zero && count_q.low == Half'(1));
    end
    if (clear_i) count_q.on <= 1'b0;
  end

endmodule

`default_nettype wire
