// Counter in chains of 16 bits, each of which knows a clock ahead that it is about to carry: no path is longer than one
// chain, however wide the counter.
//
// Guarantees: count_o = ResetValue plus the number of clocks with inc_i since reset, modulo 2^Width; always coherent.
`default_nettype none

module sp_counter #(
  parameter int Width = 32,  // a multiple of 16
  parameter logic [Width-1:0] ResetValue = {Width{1'b0}}
) (
  input  wire logic              clk_i,
  input  wire logic              rst_i,
  input  wire logic              inc_i,
  output logic       [Width-1:0] count_o
);

  localparam int Chains = Width / 16;
  localparam logic [15:0] Full = 16'hFFFF;

  logic [Chains-1:0] full;  // the chain is all ones

  // The lowest chain has its next value beside it, so that the carry of the one after that says in time that it is full.
  logic [15:0] low_q, next_q, after;
  logic        low_full_q, next_full;

  assign {next_full, after} = {1'b0, next_q} + 17'd1;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      low_q      <= ResetValue[15:0];
      next_q     <= ResetValue[15:0] + 16'd1;
      low_full_q <= ResetValue[15:0] == Full;
    end else if (inc_i) begin
      low_q      <= next_q;
      next_q     <= after;
      low_full_q <= next_full;
    end
  end

  assign full[0]       = low_full_q;
  assign count_o[15:0] = low_q;

  // The others have time: what stands here is used when the lowest chain is full, 65,535 counts after it changed.
  for (genvar k = 1; k < Chains; k++) begin : gen_chain
    logic [15:0] chain_q, sum;
    logic        full_q, sum_carry;

    assign {sum_carry, sum} = {1'b0, chain_q} + 17'd1;

    always_ff @(posedge clk_i) begin
      if (rst_i) begin
        chain_q <= ResetValue[16*k+:16];
        full_q  <= ResetValue[16*k+:16] == Full;
      end else if (inc_i) begin
        if (&(full | ({Chains{1'b1}} << k))) chain_q <= sum;  // all chains below are full
        full_q <= sum_carry;
      end
    end

    assign full[k]           = full_q;
    assign count_o[16*k+:16] = chain_q;
  end

`ifdef FORMAL
  // What stands beside the lowest chain is true of it (a lemma of the proofs of the users, which reset it once, at the beginning).
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb if (f_ran_q && !rst_i) begin
    assert (next_q == low_q + 16'd1);
    assert (low_full_q == (low_q == Full));
  end
`endif

endmodule

`default_nettype wire
