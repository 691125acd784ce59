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
  logic       still_q;   // the lines stood at level_q a clock ago
  logic       busy_q;    // or they did not two clocks ago, or the first levels are to come
  logic       awake;

  sp_sync #(
    .Width(2)
  ) u_sync (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  ({b_i, a_i}),
    .q_o  (now)
  );

  // Two clocks after the lines have come to rest at level_q everything below holds its value: nothing moves then.
  assign awake = now != level_q || busy_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      still_q <= 1'b0;
      busy_q  <= 1'b1;
    end else if (awake) begin
      still_q <= now == level_q;
      busy_q  <= now != level_q || !still_q || !settled_q;
    end
  end

  logic [1:0] changing;  // the last three samples were not the same
  always_comb begin
    changing = '0;
    if (awake) changing = (now ^ before1_q) | (now ^ before2_q);
  end

  always_ff @(posedge clk_i) begin
    if (awake) begin
      before1_q  <= now;
      before2_q  <= before1_q;
      level_q    <= settled_q ? (level_q & changing) | (now & ~changing) : now;
      previous_q <= level_q;
    end
  end

  logic [1:0] moved;
  logic       one_moved;
  always_comb begin
    moved     = '0;
    one_moved = 1'b0;
    if (awake) begin
      moved     = level_q ^ previous_q;
      one_moved = settled_q && (moved == 2'b01 || moved == 2'b10);
    end
  end

  // The lines may stand anywhere at reset: the first levels are taken over without counting.
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      start_q   <= '0;
      settled_q <= 1'b0;
    end else if (awake) begin
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
    end else if (awake) begin
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
