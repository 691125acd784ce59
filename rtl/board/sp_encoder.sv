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
      up_q    <= 1'b0;
      down_q  <= 1'b0;
      error_q <= 1'b0;
    end else if (awake) begin
      // {b, a} runs 00, 01, 11, 10 where A leads
      up_q    <= one_moved && (level_q[0] ^ previous_q[1]);
      down_q  <= one_moved && !(level_q[0] ^ previous_q[1]);
      error_q <= settled_q && moved == 2'b11;
    end
  end

  // --- Counts: that of the steps in two chains, of which the lower knows a clock ahead what it hands on ---
  logic [15:0] low_q, high_q;
  logic        low_full_q, low_zero_q;
  logic        counted_q;
  logic        ones_q, zeros_q;         // low_q[15:8] are, or were a step ago: steps turn round no sooner than in three clocks
  logic        upper_full, upper_zero;  // all bits of low_q but the lowest

  assign upper_full = ones_q && &low_q[7:1];
  assign upper_zero = zeros_q && !(|low_q[7:1]);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      counted_q <= 1'b0;
      ones_q    <= 1'b0;
      zeros_q   <= 1'b1;
    end else begin
      counted_q <= up_q || down_q;
      if (counted_q) begin
        ones_q  <= low_q[15:8] == 8'hFF;
        zeros_q <= low_q[15:8] == 8'h00;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      low_q      <= '0;
      high_q     <= '0;
      low_full_q <= 1'b0;
      low_zero_q <= 1'b1;
    end else if (up_q || down_q) begin
      low_q      <= low_q + (up_q ? 16'd1 : 16'hFFFF);
      low_full_q <= !low_q[0] && (up_q ? upper_full : upper_zero);
      low_zero_q <= low_q[0] && (up_q ? upper_full : upper_zero);
      if (up_q ? low_full_q : low_zero_q) high_q <= high_q + (up_q ? 16'd1 : 16'hFFFF);
    end
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) errors_o <= '0;
    else if (error_q) errors_o <= errors_o + 16'd1;
  end

  assign count_o = {high_q, low_q};

endmodule

`default_nettype wire
