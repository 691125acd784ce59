// Counter in chains of 16 bits, each of which knows from registers when it has to count: no path is longer than one chain,
// however wide the counter.
//
// Guarantees: count_o = ResetValue plus the number of clocks with inc_i since reset, modulo 2^Width; always coherent. The
// lowest chain of ResetValue is not FFFE or FFFF: it must not be full before the third clock after reset.
`default_nettype none

module sp_counter #(
  parameter int Width = 32,  // 32, 48 or 64
  parameter logic [Width-1:0] ResetValue = {Width{1'b0}}
) (
  input  wire logic              clk_i,
  input  wire logic              rst_i,
  input  wire logic              inc_i,
  output logic       [Width-1:0] count_o
);

  localparam int Chains = Width / 16;
  localparam logic [15:0] Full = 16'hFFFF;

  logic [Width-1:0]  count_q;
  logic [15:0]       next_q, after;    // the lowest chain after the next inc_i, and after the one after that
  logic              go_q, next_full;  // the lowest chain is full
  logic [Chains-1:1] full_q, full;     // the chain is; late, but nobody asks before 65,535 counts later
  logic [Chains-1:1] below_q;          // all those below it but the lowest are
  logic [1:0]        moved_q;          // a chain above the lowest counted one and two clocks ago

  assign count_o            = count_q;
  // The carries that the chains make anyhow, each as a bit of a sum: so it stays at the end of its chain, where a carry by
  // itself is routed elsewhere. In reset it is wrong and does not matter.
  assign {next_full, after} = {rst_i, next_q} + 17'd1;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      count_q <= ResetValue;
      next_q  <= ResetValue[15:0] + 16'd1;
      go_q    <= ResetValue[15:0] == Full;
    end else if (inc_i) begin
      count_q[15:0] <= next_q;
      next_q        <= after;
      go_q          <= next_full;
      if (go_q) begin
        for (int k = 1; k < Chains; k++) begin
          if (below_q[k]) count_q[16*k+:16] <= count_q[16*k+:16] + 16'd1;
        end
      end
    end
  end

  for (genvar k = 1; k < Chains; k++) begin : gen_full
    logic [15:0] unused;
    assign {full[k], unused} = {rst_i, count_q[16*k+:16]} + 17'd1;
  end

  // Reset lasts longer than a clock: they have followed in the third clock after it.
  always_ff @(posedge clk_i) begin
    moved_q <= {moved_q[0], rst_i || inc_i && go_q};
    if (moved_q != '0) begin
      full_q <= full;
      for (int k = 1; k < Chains; k++) below_q[k] <= &(full_q | ({(Chains - 1) {1'b1}} << (k - 1)));
    end
  end

`ifdef FORMAL
  // The lowest chain hands on when it is full (a lemma of the proofs of the users, which reset it once, at the beginning).
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb if (f_ran_q && !rst_i) begin
    assert (go_q == (count_q[15:0] == Full));
    assert (next_q == count_q[15:0] + 16'd1);
  end;
`endif

endmodule

`default_nettype wire
