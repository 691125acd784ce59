// Reports when no beat has come for too long.
//
// Guarantees: if the last beat is at the input in clock 0 and none comes in the timeout_i clocks
// after it, expired_o is high in the second clock after those and in no other. The caller ignores
// expired_o if a beat has come by then. timeout_i counts as it is beside the last beat; if it was
// 0, expired_o stays low. The count wraps after 2^24 clocks without a beat, when the frame is long
// over.
//
//   clock         0   1   2  ...  n  n+1 n+2      n = timeout_i of clock 0
//   beat_i       _/1\______ ... ___________
//   count        ---< 1 < 2  ... < n >------
//   equal        ---------- ... -----<all>--
//   expired_o    __________ ... ________/1\
//
// The count consists of two chains of 12 bits and is compared in four pieces, each with a register,
// to be quick.
`default_nettype none

module sp_frame_timeout (
  input  wire logic        clk_i,

  input  wire logic        beat_i,     // a beat is at the input
  input  wire logic        beat1_i,    // a beat came one clock ago
  input  wire logic [23:0] timeout_i,  // clocks; 0: never
  output logic             expired_o
);

  typedef struct packed {
    logic        low_full;  // low is all ones: high counts with the next clock
    logic [3:0]  equal;     // these six bits equalled those of limit_q one clock ago
    logic [11:0] high;
    logic [11:0] low;
  } pause_t;

  pause_t      pause_q;       // clocks since the last beat
  logic [23:0] limit_q;       // timeout_i beside the last beat
  logic        limit_some_q;  // limit_q is not 0; known one clock later
  logic [1:0]  some_q;        // halves of timeout_i that were not 0 one clock ago

  always_ff @(posedge clk_i) begin
    some_q <= {timeout_i[23:12] != '0, timeout_i[11:0] != '0};
    if (beat1_i) limit_some_q <= some_q != '0;
    expired_o <= !beat1_i && limit_some_q && pause_q.equal == '1;
    if (beat_i) begin
      limit_q          <= timeout_i;
      pause_q.low_full <= 1'b0;
      pause_q.equal    <= '0;
      pause_q.high     <= '0;
      pause_q.low      <= 12'd1;
    end else begin
      pause_q.low_full <= pause_q.low == 12'hFFE;
      pause_q.low      <= pause_q.low + 12'd1;
      if (pause_q.low_full) pause_q.high <= pause_q.high + 12'd1;
      pause_q.equal[0] <= pause_q.low[5:0] == limit_q[5:0];
      pause_q.equal[1] <= pause_q.low[11:6] == limit_q[11:6];
      pause_q.equal[2] <= pause_q.high[5:0] == limit_q[17:12];
      pause_q.equal[3] <= pause_q.high[11:6] == limit_q[23:18];
    end
  end

`ifdef FORMAL
  // Clocks since the last beat, modulo 2^24, and the time-out beside it. A beat of which beat1_i
  // tells nothing (in reset) starts no count.
  logic        f_ran_q = 1'b0;
  logic        f_known_q = 1'b0;  // there was a beat that counts
  logic        f_first_q = 1'b0;  // there was a beat one clock ago
  logic [23:0] f_clocks_q, f_limit_q;
  logic        f_known;
  assign f_known = f_known_q && (beat1_i || !f_first_q);
  always_comb if (f_ran_q && beat1_i) assume (f_first_q);
  always_ff @(posedge clk_i) begin
    f_ran_q   <= 1'b1;
    f_first_q <= beat_i;
    f_known_q <= beat_i || f_known;
    if (beat_i) {f_clocks_q, f_limit_q} <= {24'd1, timeout_i};
    else f_clocks_q <= f_clocks_q + 24'd1;
  end

  // Rule: expired_o is high in the second clock after timeout_i clocks without a beat, and in no
  // other.
  logic [2:1]  f_counts_q = 2'b00;    // f_known, one and two clocks ago
  logic        f_over, f_over1_q, f_over2_q;  // now, one and two clocks ago
  logic [3:0]  f_equal;
  logic [23:0] f_before;              // the count one clock ago
  assign f_over   = !beat_i && f_clocks_q == f_limit_q && f_limit_q != '0;
  assign f_before = f_clocks_q - 24'd1;
  for (genvar k = 0; k < 4; k++) begin : gen_rule
    assign f_equal[k] = !f_first_q && f_before[6*k+:6] == f_limit_q[6*k+:6];
  end
  always_ff @(posedge clk_i) begin
    {f_over1_q, f_over2_q} <= {f_over, f_over1_q};
    f_counts_q             <= f_known ? {f_counts_q[1], 1'b1} : 2'b00;
  end
  always_comb if (f_known) begin
    assert ({pause_q.high, pause_q.low} == f_clocks_q && limit_q == f_limit_q);
    assert (pause_q.low_full == (pause_q.low == '1) && pause_q.equal == f_equal);
    if (f_first_q) assert (some_q == {limit_q[23:12] != '0, limit_q[11:0] != '0});
    else assert (limit_some_q == (limit_q != '0));
    if (f_counts_q[1]) assert (f_over1_q == (f_equal == '1 && f_limit_q != '0));
    if (f_counts_q[2]) assert (expired_o == f_over2_q);
    cover (expired_o && f_limit_q == 24'd3);
  end
`endif

endmodule

`default_nettype wire
