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

  typedef struct packed {
    logic        settled;   // level has come from the pins
    logic [3:0]  start;     // clocks since reset, as many ones
    logic [1:0]  still;     // the lines stood at level, a clock and two clocks ago
    logic [1:0]  previous;  // level a clock ago
    logic [1:0]  level;     // without short pulses
    logic        step;      // one line has changed
    logic        counted;   // the step before this is counted
    logic        down;      // B leads
    logic        error;     // both have changed
    logic [15:0] errors;    // so many times
  } lines_t;

  typedef struct packed {
    logic        ones;      // bits 15..8 are, or were a step ago: steps turn round no sooner than in three clocks
    logic        zeros;
    logic        low_full;  // bits 15..0
    logic        low_zero;
    logic [15:0] high;
    logic [15:0] low;
  } count_t;

  lines_t     lines_q;
  count_t     count_q;
  logic [1:0] now;                 // {b, a}, synchronized
  logic [1:0] before1_q, before2_q;  // one clock ago, two clocks ago
  logic       awake_q;             // the lines did not stand at level a clock ago, or something follows of that they did not

  sp_sync #(
    .Width(2)
  ) u_sync (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  ({b_i, a_i}),
    .q_o  (now)
  );

  // The level of a line: its value where the last three samples are the same, else as before.
  function automatic logic [1:0] level_of(input logic [1:0] level, input logic [1:0] s0, input logic [1:0] s1,
                                          input logic [1:0] s2);
    level_of = (level & (s0 | s1 | s2)) | (s0 & s1 & s2);
  endfunction

  // Three clocks after the lines have come to rest everything below holds its value: nothing moves then.
  always_ff @(posedge clk_i) begin
    before2_q <= before1_q;
    before1_q <= now;
    awake_q   <= rst_i || now != lines_q.level || lines_q.still != 2'b11 || !lines_q.settled;
  end

  // The lines may stand anywhere at reset: the first levels are taken over without counting. Reset lasts longer than a clock,
  // so that all is awake in it.
  always_ff @(posedge clk_i) begin
    if (awake_q) begin
      lines_q.settled  <= !rst_i && lines_q.start[3];
      lines_q.start    <= rst_i ? 4'd0 : {lines_q.start[2:0], 1'b1};
      lines_q.still    <= {lines_q.still[0], now == lines_q.level};
      lines_q.previous <= lines_q.level;
      lines_q.level    <= lines_q.settled ? level_of(lines_q.level, now, before1_q, before2_q) : now;
      lines_q.step     <= lines_q.settled && ^(lines_q.level ^ lines_q.previous);
      lines_q.counted  <= lines_q.step;
      lines_q.down     <= !(lines_q.level[0] ^ lines_q.previous[1]);  // {b, a} runs 00, 01, 11, 10 where A leads
      lines_q.error    <= lines_q.settled && &(lines_q.level ^ lines_q.previous);
      if (rst_i) lines_q.errors <= '0;
      else if (lines_q.error) lines_q.errors <= lines_q.errors + 16'd1;
    end
  end

  // --- Counts: that of the steps in two chains, of which the lower knows a clock ahead what it hands on ---
  // The next step of this direction makes the lower chain full (up) or zero, whatever its lowest bit.
  function automatic logic is_near(input logic down, input logic [6:0] low, input logic ones, input logic zeros);
    is_near = down ? zeros && low == '0 : ones && &low;
  endfunction

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      count_q.ones     <= 1'b0;
      count_q.zeros    <= 1'b1;
      count_q.low_full <= 1'b0;
      count_q.low_zero <= 1'b1;
      count_q.high     <= '0;
      count_q.low      <= '0;
    end else if ({lines_q.step, lines_q.counted} != '0) begin
      if (lines_q.step) begin
        count_q.low      <= count_q.low + {{15{lines_q.down}}, 1'b1};
        count_q.low_full <= !count_q.low[0] && is_near(lines_q.down, count_q.low[7:1], count_q.ones, count_q.zeros);
        count_q.low_zero <= count_q.low[0] && is_near(lines_q.down, count_q.low[7:1], count_q.ones, count_q.zeros);
        if (lines_q.down ? count_q.low_zero : count_q.low_full) begin
          count_q.high <= count_q.high + {{15{lines_q.down}}, 1'b1};
        end
      end
      if (lines_q.counted) begin
        count_q.ones  <= count_q.low[15:8] == 8'hFF;
        count_q.zeros <= count_q.low[15:8] == 8'h00;
      end
    end
  end

  assign count_o  = {count_q.high, count_q.low};
  assign errors_o = lines_q.errors;

endmodule

`default_nettype wire
