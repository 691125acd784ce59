// Counter in chains. Registers tell each chain when it has to count, so no path is longer than one
// chain, however wide the counter is.
//
// Guarantees: count_o = ResetValue plus the number of clocks with inc_i from reset to the clock
// before the last, modulo 2^Width; it is always coherent. The lowest 8 bits of ResetValue are not
// all ones, since they must not wrap before the second clock after reset. Latency: count_o counts a
// clock with inc_i two clocks later.
`default_nettype none

module sp_counter #(
  parameter int Width = 32,  // 32 or 64
  parameter logic [Width-1:0] ResetValue = {Width{1'b0}}  // the lowest 8 bits are not all ones
) (
  input  wire logic              clk_i,
  input  wire logic              rst_i,
  input  wire logic              inc_i,
  output logic       [Width-1:0] count_o
);

  if (Width != 32 && Width != 64) begin : gen_width
    width_is_not_32_or_64 u_error ();
  end
  if (ResetValue[7:0] == 8'hFF) begin : gen_reset_value
    reset_value_ends_in_eight_ones u_error ();
  end

  // The lowest chain is short, because its input comes from far away. The others follow above it.
  localparam int Low = 8;
  localparam int Size = Width > 32 ? 14 : 12;
  localparam int Chains = (Width - Low) / Size;

  logic [Low-1:0]    low_q;          // lowest chain, one clock ahead of the others
  logic              go_q;           // the lowest chain has wrapped
  logic [Low-1:0]    told_q;         // lowest chain, at the time of the others
  logic [Width-1:Low] upper_q;
  logic [Chains-1:0] full_q, full;   // this chain is all ones; late, but in time
  logic [Chains-1:0] below_q;        // all chains below it, except the lowest, are all ones

  assign count_o       = {upper_q, told_q};

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      low_q  <= ResetValue[Low-1:0];
      told_q <= ResetValue[Low-1:0];
      go_q   <= 1'b0;
    end else begin
      told_q <= low_q;
      go_q   <= 1'b0;
      if (inc_i) {go_q, low_q} <= {1'b0, low_q} + (Low + 1)'(1);
    end
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      upper_q <= ResetValue[Width-1:Low];
    end else if (go_q) begin
      for (int k = 0; k < Chains; k++) begin
        if (below_q[k]) upper_q[Low+Size*k+:Size] <= upper_q[Low+Size*k+:Size] + Size'(1);
      end
    end
  end

  // The carry of each chain, taken as a bit of a sum so that it stays at the end of its chain; a
  // carry by itself would be routed elsewhere. It is wrong in reset, where it does not matter.
  for (genvar k = 0; k < Chains; k++) begin : gen_full
    logic [Size-1:0] unused;
    assign {full[k], unused} = {rst_i, upper_q[Low+Size*k+:Size]} + (Size + 1)'(1);
  end

  // These follow while the lowest chain counts through its upper half, before they are needed.
  always_ff @(posedge clk_i) begin
    if (low_q[Low-1]) begin
      full_q <= full;
      for (int k = 0; k < Chains; k++) below_q[k] <= &(full_q | ({Chains{1'b1}} << k));
    end
  end

`ifdef FORMAL
  // A reset at the beginning, to a value whose lowest chain is in its lower half. Lemmas: count_o
  // is one behind after a clock with inc_i, and the lowest chain passes a carry where it wraps.
  logic f_ran_q = 1'b0;
  logic f_inc_q;
  always_ff @(posedge clk_i) begin
    f_ran_q <= 1'b1;
    f_inc_q <= inc_i && !rst_i;
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (low_q == told_q + Low'(f_inc_q));
    assert (go_q == (f_inc_q && low_q == '0));
  end

  // Rule: the chains above the lowest count by one as a whole, where the lowest has wrapped. A
  // lemma: which chains are full is known two clocks after the lowest has reached its upper half,
  // and it takes longer to wrap.
  logic [1:0]         f_high_q;  // clocks with low_q[Low-1], up to 2
  logic [Width-1:Low] f_upper_q;
  logic               f_go_q;
  logic [Chains-1:0]  f_full, f_below;
  always_comb begin
    f_below = '1;
    for (int k = 0; k < Chains; k++) f_full[k] = upper_q[Low+Size*k+:Size] == '1;
    for (int k = 1; k < Chains; k++) f_below[k] = f_below[k-1] && f_full[k-1];
  end
  always_ff @(posedge clk_i) begin
    if (rst_i || !low_q[Low-1]) f_high_q <= 2'd0;
    else if (!f_high_q[1]) f_high_q <= f_high_q + 2'd1;
    f_upper_q <= rst_i ? ResetValue[Width-1:Low] : upper_q;
    f_go_q    <= !rst_i && go_q;
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (upper_q == f_upper_q + (Width - Low)'(f_go_q));
    if (low_q[Low-1] && f_high_q >= 2'd1) assert (full_q == f_full);
    if ((low_q[Low-1] && f_high_q >= 2'd2) || go_q) assert (below_q == f_below);
    assert (f_high_q != 2'd3);
    if (low_q[Low-1]) assert (f_high_q == 2'd2 || low_q[Low-2:0] <= (Low - 1)'(f_high_q));
    // A carry is long past when the chains are looked at again.
    if (go_q) assert (low_q == '0 && !f_go_q);
    if (f_go_q) assert (low_q <= Low'(1));
  end
  always_ff @(posedge clk_i) if (f_ran_q) cover (f_go_q && upper_q == (Width - Low)'(1));
  always_comb if (!f_ran_q) assume (rst_i);
`endif

endmodule

`default_nettype wire
