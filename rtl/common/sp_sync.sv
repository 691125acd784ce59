// Two-flop synchronizer, each bit on its own.
//
// Guarantees: d_i appears on q_o after two to three clocks of clk_i. Bits that must arrive together have to be Gray
// coded, at most one of them changing per clock of the receiver.
`default_nettype none

module sp_sync #(
  parameter int Width = 1
) (
  input  wire logic             clk_i,
  input  wire logic             rst_i,
  input  wire logic [Width-1:0] d_i,
  output logic      [Width-1:0] q_o
);

  (* async_reg = "true" *) logic [Width-1:0] meta_q;
  (* async_reg = "true" *) logic [Width-1:0] sync_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      meta_q <= '0;
      sync_q <= '0;
    end else begin
      meta_q <= d_i;
      sync_q <= meta_q;
    end
  end

  assign q_o = sync_q;

endmodule

`default_nettype wire
