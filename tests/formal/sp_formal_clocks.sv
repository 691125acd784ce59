// For proofs: two free clocks and one reset at the beginning. run_o is high from the moment after
// both resets end.
//
// It assumes that the module that holds it has both resets high until each clock has risen twice,
// and never again.
`default_nettype none

module sp_formal_clocks (
  input  wire logic a_clk_i,
  input  wire logic a_rst_i,
  input  wire logic b_clk_i,
  input  wire logic b_rst_i,
  output logic      a_rise_o,   // the clock has just risen
  output logic      b_rise_o,
  output logic      a_one_o,    // it has risen once in reset, before this moment
  output logic      b_one_o,
  output logic      a_two_o,    // it has risen twice
  output logic      b_two_o,
  output logic      run_o
);

  (* gclk *) logic moment;
  logic       a_clk_q = 1'b1, b_clk_q = 1'b1;
  logic [1:0] a_rises_q = 2'd0, b_rises_q = 2'd0;
  logic       reset_q = 1'b1;
  logic       run_q = 1'b0;

  assign a_rise_o = a_clk_i && !a_clk_q;
  assign b_rise_o = b_clk_i && !b_clk_q;

  always_ff @(posedge moment) begin
    a_clk_q <= a_clk_i;
    b_clk_q <= b_clk_i;
    if (a_rise_o && !a_rises_q[1]) a_rises_q <= a_rises_q + 2'd1;
    if (b_rise_o && !b_rises_q[1]) b_rises_q <= b_rises_q + 2'd1;
    reset_q <= !(a_rises_q[1] && b_rises_q[1]);
    run_q   <= !reset_q;
  end

  always_comb begin
    assume (a_rst_i == reset_q);
    assume (b_rst_i == reset_q);
    assert (a_rises_q != 2'd3 && b_rises_q != 2'd3);
    assert (reset_q || a_rises_q[1] && b_rises_q[1]);
    assert (!run_q || !reset_q);
  end

  assign a_one_o = a_rises_q != 2'd0;
  assign b_one_o = b_rises_q != 2'd0;
  assign a_two_o = a_rises_q[1];
  assign b_two_o = b_rises_q[1];
  assign run_o   = run_q && !reset_q;

endmodule

`default_nettype wire
