// Quadrature encoder input, counted fourfold.
//
// A leads B: the count rises. A level counts once it has been the same in three clocks (shorter pulses are suppressed); a
// step in which both lines change is no step and counts as an error. Both counts wrap.
// Latency: a change of a line that was sampled by clock edge e is in count_o for clock edge e + 7.
`default_nettype none

module sp_encoder (
  input  wire logic clk_i,
  input  wire logic rst_i,

  input  wire logic a_i,  // any clock
  input  wire logic b_i,

  output logic [31:0] count_o,
  output logic [15:0] errors_o
);

  logic [1:0] now;       // {b, a}, synchronized
  logic [1:0] before1_q;
  logic [1:0] before2_q;
  logic [1:0] level_q;   // without short pulses
  logic [1:0] previous_q;
  logic       settled_q;  // level_q has come from the pins
  logic [3:0] start_q;
  logic       up_q, down_q, error_q;

  sp_sync #(
    .Width(2)
  ) u_sync (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  ({b_i, a_i}),
    .q_o  (now)
  );

  logic [1:0] changing;  // the last three samples were not the same
  assign changing = (now ^ before1_q) | (now ^ before2_q);

  always_ff @(posedge clk_i) begin
    before1_q <= now;
    before2_q <= before1_q;
    level_q    <= rst_i || !settled_q ? now : (level_q & changing) | (now & ~changing);
    previous_q <= level_q;
  end

  logic [1:0] moved;
  logic       one_moved;
  assign moved     = level_q ^ previous_q;
  assign one_moved = settled_q && (moved == 2'b01 || moved == 2'b10);

  // The lines may stand anywhere at reset: the first levels are taken over without counting.
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      start_q   <= '0;
      settled_q <= 1'b0;
    end else begin
      start_q   <= {start_q[2:0], 1'b1};
      settled_q <= start_q[3];
    end
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      up_q     <= 1'b0;
      down_q   <= 1'b0;
      error_q  <= 1'b0;
      count_o  <= '0;
      errors_o <= '0;
    end else begin
      // {b, a} runs 00, 01, 11, 10 where A leads
      up_q    <= one_moved && (level_q[0] ^ previous_q[1]);
      down_q  <= one_moved && !(level_q[0] ^ previous_q[1]);
      error_q <= settled_q && moved == 2'b11;
      if (up_q || down_q) count_o <= count_o + (up_q ? 32'd1 : 32'hFFFF_FFFF);
      if (error_q) errors_o <= errors_o + 16'd1;
    end
  end

endmodule

`default_nettype wire
