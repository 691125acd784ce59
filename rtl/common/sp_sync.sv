// Two-flop synchronizer, each bit by itself.
//
// Guarantees: d_i appears on q_o after two to three clocks of clk_i. Bits that must arrive together
// have to be Gray-coded, with at most one of them changing per clock of the receiver.
`default_nettype none

module sp_sync #(
  parameter int Width = 1  // 1 or more
) (
  input  wire logic             clk_i,
  input  wire logic             rst_i,
  input  wire logic [Width-1:0] d_i,
  output logic      [Width-1:0] q_o
`ifdef FORMAL
  ,
  output logic      [Width-1:0] f_before_o,  // d_i one moment ago
  output logic      [Width-1:0] f_meta_o     // the first flop
`endif
);

  if (Width < 1) begin : gen_width
    width_is_less_than_1 u_error ();
  end

  (* async_reg = "true" *) logic [Width-1:0] meta_q;
  (* async_reg = "true" *) logic [Width-1:0] sync_q;
`ifdef FORMAL
  logic [Width-1:0] f_caught;
`endif

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      meta_q <= '0;
      sync_q <= '0;
    end else begin
`ifdef FORMAL
      meta_q <= f_caught;
`else
      meta_q <= d_i;
`endif
      sync_q <= meta_q;
    end
  end

`ifdef FORMAL
  // A bit that changes beside the clock edge is caught old or new, each bit by itself.
  (* gclk *) logic f_moment;
  (* anyseq *) logic [Width-1:0] f_late;
  logic [Width-1:0] f_before_q;
  always_ff @(posedge f_moment) f_before_q <= d_i;
  assign f_caught   = d_i & ~f_late | f_before_q & f_late;
  assign f_before_o = f_before_q;
  assign f_meta_o   = meta_q;

  // Rule: a bit leaves one clock after the first flop has caught it, so that it has had a clock to
  // settle.
  logic             f_ran_q = 1'b0;
  logic [Width-1:0] f_settled_q;
  always_ff @(posedge clk_i) begin
    f_ran_q     <= 1'b1;
    f_settled_q <= rst_i ? '0 : meta_q;
  end
  always_comb if (f_ran_q) assert (q_o == f_settled_q);
  always_ff @(posedge clk_i) if (f_ran_q) cover (q_o == '1);
`endif

  assign q_o = sync_q;

endmodule

`default_nettype wire
