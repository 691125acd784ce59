// Quadrature encoder input, counted fourfold.
//
// A leads B: the count rises. A level counts once it has been the same in three clocks (shorter pulses are suppressed); a
// step in which both lines change is no step and counts as an error. Both counts wrap.
// Latency: a change of a line that was sampled by clock edge e is in count_o for clock edge e + 7, in errors_o for e + 6.
`default_nettype none

module sp_encoder (
  input  wire logic clk_i,
  input  wire logic rst_i,

  input  wire logic a_i,  // any clock
  input  wire logic b_i,

  output logic [31:0] count_o,
  output logic [15:0] errors_o
);

  typedef struct packed {
    logic        settled;  // level has come from the pins
    logic [3:0]  start;    // clocks since reset, as many ones
    logic [1:0]  level;    // without short pulses
    logic        step;     // one line has changed level a clock ago
    logic        down;     // B leads
    logic        error;    // both have changed
  } lines_t;

  typedef struct packed {
    logic       moved;    // a step was a clock ago
    logic       down;     // its direction
    logic       hand_on;  // the lowest chain wrapped with it
    logic       further;  // and so will the middle one then
    logic [7:0] low;
  } chain_t;

  lines_t      lines_q;
  chain_t      chain_q;
  logic [15:0] errors_q;
  logic [31:0] count_q;
  logic        zero_q, full_q;        // its middle chain is 0, is all ones
  logic [1:0]  now;                   // {b, a}, synchronized
  logic [1:0]  before1_q, before2_q;  // one clock ago, two clocks ago
  logic [1:0]  changes;               // a line takes another level
  logic        awake_q;               // the lines did not stand at level a clock ago, or it is soon after reset
  logic [2:0]  stirred_q;             // awake_q, one to three clocks ago
  logic        follow_q;              // the counts may move: awake up to four clocks ago

  sp_sync #(
    .Width(2)
  ) u_sync (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  ({b_i, a_i}),
    .q_o  (now)
  );

  // The level of a line changes where three samples are the same, and other than it.
  assign changes = (lines_q.level ^ now) & ~(now ^ before1_q) & ~(now ^ before2_q);

  // Once the lines have come to rest everything below holds its value: nothing moves then.
  always_ff @(posedge clk_i) begin
    before2_q <= before1_q;
    before1_q <= now;
    awake_q   <= rst_i || now != lines_q.level || !lines_q.settled;
    stirred_q <= {stirred_q[1:0], awake_q};
    follow_q  <= awake_q || stirred_q != '0;
  end

  // The lines may stand anywhere at reset: the first levels are taken over without counting. Reset lasts longer than a clock,
  // so that all is awake in it.
  always_ff @(posedge clk_i) begin
    if (awake_q) begin
      lines_q.settled <= !rst_i && lines_q.start[3];
      lines_q.start   <= rst_i ? 4'd0 : {lines_q.start[2:0], 1'b1};
      lines_q.level   <= lines_q.settled ? lines_q.level ^ changes : now;
      lines_q.step    <= lines_q.settled && ^changes;
      lines_q.down    <= lines_q.level[0] ^ changes[0] ^ lines_q.level[1] ^ 1'b1;  // {b, a} runs 00, 01, 11, 10 where A leads
      lines_q.error   <= lines_q.settled && &changes;
    end
  end

  always_ff @(posedge clk_i) if (follow_q) begin
    if (rst_i) errors_q <= '0;
    else errors_q <= errors_q + 16'(lines_q.error);
  end

  // --- Count, in three chains: the lowest a clock ahead of what is told, the others follow it ---
  always_ff @(posedge clk_i) if (follow_q) begin
    if (rst_i) begin
      chain_q <= '0;
    end else begin
      chain_q.moved   <= lines_q.step;
      chain_q.down    <= lines_q.down;
      chain_q.further <= lines_q.down ? zero_q : full_q;
      {chain_q.hand_on, chain_q.low} <= {1'b0, chain_q.low} + {{8{lines_q.step && lines_q.down}}, lines_q.step};
    end
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      count_q <= '0;
    end else begin
      if (chain_q.moved) count_q[7:0] <= chain_q.low;
      if (chain_q.hand_on) count_q[19:8] <= count_q[19:8] + {{11{chain_q.down}}, 1'b1};
      if (chain_q.hand_on && chain_q.further) count_q[31:20] <= count_q[31:20] + {{11{chain_q.down}}, 1'b1};
    end
  end

  always_ff @(posedge clk_i) if (follow_q) begin
    // A clock late: the lowest chain wraps again no sooner than three clocks later, when a line has gone back.
    zero_q <= count_q[19:8] == 12'h000;
    full_q <= count_q[19:8] == 12'hFFF;
  end

  assign count_o  = count_q;
  assign errors_o = errors_q;

endmodule

`default_nettype wire
