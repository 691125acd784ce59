// Keeps the strongest of the ended runs of the columns of one lane, and M0 of the second.
//
// A run that has ended (s4_run_i) meets the strongest one and the second of its column: it takes
// the place of the strongest if its M0 is greater (of equals the earlier one stays), or else that
// of the second if its M0 is greater than that. What is left of the comparison leaves as best_o,
// and is kept with s5_keep_i. A word of a column is
//
//   {runs that have ended, up to 3; M0 of the second; M0 of the strongest; its other values}
//
// Guarantees: a word is right two clocks after its column's word before it, or later. Two runs of
// one column never end in neighbouring rows, so that is enough for images of any width. s3_none_i
// makes the word that was read all 0: no run has ended.
//
//   stage        2   3   4   5   6
//   read_i      _/1\_______________   the word is read
//   s4_run_i    _________/1\_______   M0 is compared
//   s5_keep_i   _____________/1\___   the new word is written
//   s5_rest_i   -------------< r >-   N, R and A of the run, or M1
//   best_o      -----------------< B
`default_nettype none

module sp_run_best #(
  parameter int GroupBits = 9,  // 1..24
  parameter int M0Bits = 18,  // 1 or more
  parameter int RestBits = 47,  // 1 or more
  // derived, do not set
  parameter int WordBits = 2 + 2 * M0Bits + RestBits
) (
  input  wire logic                 clk_i,

  input  wire logic                 read_i,
  input  wire logic [GroupBits-1:0] read_group_i,
  input  wire logic                 s3_none_i,       // no run has ended before
  // there was a beat of the column two clocks ago, three clocks ago
  input  wire logic                 s3_after_new_i,
  input  wire logic                 s3_after_last_i,
  input  wire logic                 s4_run_i,        // a run has ended, or the frame ends with it
  input  wire logic [M0Bits-1:0]    s4_m0_i,
  input  wire logic                 s5_keep_i,
  input  wire logic [GroupBits-1:0] s5_group_i,
  input  wire logic [RestBits-1:0]  s5_rest_i,

  output logic      [WordBits-1:0]  best_o
);

  if (M0Bits < 1) begin : gen_m0_bits
    m0_bits_is_less_than_1 u_error ();
  end
  if (RestBits < 1) begin : gen_rest_bits
    rest_bits_is_less_than_1 u_error ();
  end

  logic [WordBits-1:0] raw, s4_word_q, new_word;
  logic                s6_kept_q;  // best_o was written
  logic [1:0]          s4_runs, s5_runs_q;
  logic [M0Bits-1:0]   s4_second, s4_best, s5_second_q, s5_best_q, s5_m0_q;
  logic [RestBits-1:0] s5_rest_q;   // of the word that was read
  logic                s5_run_q;    // s4_run_i
  logic                s5_beats_best_q, s5_beats_second_q;  // by M0
  logic [RestBits-1:0] s4_rest;
  assign {s4_runs, s4_second, s4_best, s4_rest} = s4_word_q;

  always_ff @(posedge clk_i) begin
    s4_word_q         <= s3_none_i ? '0 :
                         s3_after_new_i && s5_keep_i ? new_word :
                         s3_after_last_i && s6_kept_q ? best_o : raw;
    s5_run_q          <= s4_run_i;
    s5_m0_q           <= s4_m0_i;
    s5_beats_best_q   <= s4_run_i && s4_m0_i > s4_best;
    s5_beats_second_q <= s4_run_i && s4_m0_i > s4_second;
    {s5_runs_q, s5_second_q, s5_best_q, s5_rest_q} <= {s4_runs, s4_second, s4_best, s4_rest};
    best_o            <= new_word;
    s6_kept_q         <= s5_keep_i;
  end

  assign new_word = {
    s5_runs_q + 2'(s5_run_q && s5_runs_q != 2'd3),
    s5_beats_best_q ? s5_best_q : s5_beats_second_q ? s5_m0_q : s5_second_q,
    s5_beats_best_q ? {s5_m0_q, s5_rest_i} : {s5_best_q, s5_rest_q}
  };

  sp_ram #(
    .Width   (WordBits),
    .LogDepth(GroupBits)
  ) u_word (
    .wr_clk_i (clk_i),
    .wr_en_i  (s5_keep_i),
    .wr_addr_i(s5_group_i),
    .wr_data_i(new_word),
    .rd_clk_i (clk_i),
    .rd_en_i  (read_i),
    .rd_addr_i(read_group_i),
    .rd_data_o(raw)
  );

`ifdef FORMAL
  // Rule: the new word has one run more, up to 3, and of the strongest, the second and the run that
  // has ended, the strongest two; of equals the earlier one comes first. Without a run it is the
  // word that was read. (A word that was written keeps the second no stronger than the strongest.)
  logic f_ran_q = 1'b0, f_ran2_q = 1'b0;
  always_ff @(posedge clk_i) {f_ran2_q, f_ran_q} <= {f_ran_q, 1'b1};
  logic [1:0]          f_runs_q;
  logic [M0Bits-1:0]   f_second_q, f_best_q, f_m0_q;
  logic [RestBits-1:0] f_rest_q;
  logic                f_run_q;
  always_ff @(posedge clk_i) begin
    {f_runs_q, f_second_q, f_best_q, f_rest_q} <= s4_word_q;
    {f_run_q, f_m0_q}                          <= {s4_run_i, s4_m0_i};
  end
  logic [WordBits-1:0] f_new;
  always_comb begin
    f_new = {f_runs_q, f_second_q, f_best_q, f_rest_q};
    if (f_run_q) begin
      f_new[WordBits-1-:2] = f_runs_q == 2'd3 ? 2'd3 : f_runs_q + 2'd1;
      if (f_m0_q > f_best_q) f_new[WordBits-3:0] = {f_best_q, f_m0_q, s5_rest_i};
      else if (f_m0_q > f_second_q) f_new[WordBits-3-:M0Bits] = f_m0_q;
    end
  end
  always_comb if (f_ran_q) begin
    assert (new_word == f_new);
  end
  always_ff @(posedge clk_i) if (f_ran2_q) begin
    assert (best_o == $past(f_new));
    cover (f_run_q && f_runs_q == 2'd3 && f_m0_q == f_best_q && f_m0_q > f_second_q);
  end
`endif

endmodule

`default_nettype wire
