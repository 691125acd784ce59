// Counter in chains of 16 bits, each of which knows from registers when it has to count: no path is longer than one chain,
// however wide the counter.
//
// Guarantees: count_o = ResetValue plus the number of clocks with inc_i since reset, modulo 2^Width; always coherent.
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
  logic [Chains-1:1] go_q;    // the chain counts next: all those below are full
  logic [Chains-1:1] full_q;  // the chain is

  assign count_o = count_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      count_q <= ResetValue;
      for (int k = 1; k < Chains; k++) begin
        go_q[k]   <= (~ResetValue & ((Width'(1) << (16 * k)) - Width'(1))) == '0;
        full_q[k] <= ResetValue[16*k+:16] == Full;
      end
    end else if (inc_i) begin
      count_q[15:0] <= count_q[15:0] + 16'd1;
      go_q          <= '0;
      if (count_q[15:0] == Full - 16'd1) begin
        for (int k = 1; k < Chains; k++) go_q[k] <= &(full_q | ({(Chains - 1) {1'b1}} << (k - 1)));
      end
      if (go_q[1]) begin
        for (int k = 1; k < Chains; k++) begin
          if (go_q[k]) begin
            count_q[16*k+:16] <= count_q[16*k+:16] + 16'd1;
            full_q[k]         <= count_q[16*k+:16] == Full - 16'd1;
          end
        end
      end
    end
  end

`ifdef FORMAL
  // The lowest chain hands on when it is full (a lemma of the proofs of the users, which reset it once, at the beginning).
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb if (f_ran_q && !rst_i) assert (go_q[1] == (count_q[15:0] == Full));
`endif

endmodule

`default_nettype wire
