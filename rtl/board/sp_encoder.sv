// Quadrature encoder input, counted fourfold.
//
// The count rises while A leads B. A level counts once it has been the same for three clocks, so
// shorter pulses are suppressed. If both lines change in one step, errors_o counts it in the place
// of count_o. Both wrap. Latency: if clock edge e samples a change of a line, clock edge e + 7
// samples the new count_o, and edge e + 6 the new errors_o. The reset takes effect a clock later.
`default_nettype none

module sp_encoder (
  input  wire logic clk_i,
  input  wire logic rst_i,

  input  wire logic a_i,  // from any clock
  input  wire logic b_i,

  output logic [31:0] count_o,
  output logic [15:0] errors_o
);

  typedef struct packed {
    logic        settled;  // level has been taken from the pins
    logic [3:0]  start;    // clocks since reset, as that many ones
    logic [1:0]  level;    // of the lines, without short pulses
    logic        step;     // one line changed its level one clock ago
    logic        down;     // B leads
    logic        error;    // both lines changed
  } lines_t;

  typedef struct packed {
    logic       moved;    // there was a step one clock ago
    logic       down;     // its direction
    logic       hand_on;  // the lowest chain wrapped with it
    logic       further;  // the middle chain will wrap, too
    logic [7:0] low;
  } chain_t;

  // The reset goes through a register beside the encoder, so that the encoder's paths have no long
  // wire. The attributes keep Yosys from merging this register with those of other blocks.
  (* keep *) logic reset_q;  // rst_i, one clock ago
  (* keep *) always_ff @(posedge clk_i) reset_q <= rst_i;

  lines_t      lines_q;
  chain_t      chain_q;
  logic [15:0] errors_q;
  logic [31:0] count_q;
  logic        zero_q, full_q;        // the middle chain is all zeros, all ones
  logic [1:0]  now;                   // {b, a}, synchronized
  logic [1:0]  before1_q, before2_q;  // one and two clocks ago
  logic [1:0]  changes;               // lines that take a new level
  logic        awake_q;               // one clock ago, a line differed from level or reset was on
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

  // The level of a line changes when three samples are equal and differ from it.
  assign changes = (lines_q.level ^ now) & ~(now ^ before1_q) & ~(now ^ before2_q);

  // Once the lines are at rest, everything below holds its value.
  always_ff @(posedge clk_i) begin
    before2_q <= before1_q;
    before1_q <= now;
    awake_q   <= reset_q || now != lines_q.level || !lines_q.settled;
    stirred_q <= {stirred_q[1:0], awake_q};
    follow_q  <= awake_q || stirred_q != '0;
  end

  // The lines may have any level at reset: the first levels are taken over without counting. The
  // reset lasts longer than one clock, so awake_q is high in it.
  always_ff @(posedge clk_i) begin
    if (awake_q) begin
      lines_q.settled <= !reset_q && lines_q.start[3];
      lines_q.start   <= reset_q ? 4'd0 : {lines_q.start[2:0], 1'b1};
      lines_q.level   <= lines_q.settled ? lines_q.level ^ changes : now;
      lines_q.step    <= lines_q.settled && ^changes;
      // {b, a} runs 00, 01, 11, 10 where A leads
      lines_q.down    <= lines_q.level[0] ^ changes[0] ^ lines_q.level[1] ^ 1'b1;
      lines_q.error   <= lines_q.settled && &changes;
    end
  end

  always_ff @(posedge clk_i) if (follow_q) begin
    if (reset_q) errors_q <= '0;
    else errors_q <= errors_q + 16'(lines_q.error);
  end

  // --- The count, in three carry chains. The lowest is one clock ahead of count_o ---
  always_ff @(posedge clk_i) if (follow_q) begin
    if (reset_q) begin
      chain_q <= '0;
    end else begin
      chain_q.moved   <= lines_q.step;
      chain_q.down    <= lines_q.down;
      chain_q.further <= lines_q.down ? zero_q : full_q;
      {chain_q.hand_on, chain_q.low} <= {1'b0, chain_q.low} +
                                        {{8{lines_q.step && lines_q.down}}, lines_q.step};
    end
  end

  always_ff @(posedge clk_i) begin
    if (reset_q) begin
      count_q <= '0;
    end else begin
      if (chain_q.moved) count_q[7:0] <= chain_q.low;
      if (chain_q.hand_on) count_q[19:8] <= count_q[19:8] + {{11{chain_q.down}}, 1'b1};
      if (chain_q.hand_on && chain_q.further) count_q[31:20] <= count_q[31:20] +
              {{11{chain_q.down}}, 1'b1};
    end
  end

  always_ff @(posedge clk_i) if (follow_q) begin
    // These are one clock late. That is early enough: the lowest chain wraps again after three
    // clocks at the earliest, when a line has gone back.
    zero_q <= count_q[19:8] == 12'h000;
    full_q <= count_q[19:8] == 12'hFFF;
  end

  assign count_o  = count_q;
  assign errors_o = errors_q;

endmodule

`default_nettype wire
