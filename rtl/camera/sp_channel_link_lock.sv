// Aligns the deserializer of a Channel Link to its 28-bit words, checks every word, and outputs
// those that are right.
//
// In every clock the deserializer brings seven samples of each lane. With Samples = 1 these are the
// seven bits of a word. With Samples = 2 each bit is sampled twice, a quarter of a bit before and
// after its middle, and a word takes two clocks.
//
// Word alignment: the clock lane reads 1100011 in every word. While it reads anything else and the
// link is not locked, align_o rises about every 16 clocks. Each rise must shift the words of all
// lanes by two samples. With Samples = 2, every eighth step does not raise align_o, but exchanges
// the first and the second clock of a word. So every alignment is tried. After 2^LogGood right
// words in a row, locked_o rises.
//
// Guarantees: a word is output only while locked_o is high, only if the clock lane reads 1100011 in
// it, and, with Samples = 2, only if the two samples of each bit agree. Any other word ends the
// lock at once, and error_o is high for one clock. The alignment stays as it is until a later word
// has a wrong clock lane.
//
// Lanes out of place: with Samples = 2, consider a lane that is early or late by more than a
// quarter of a bit, but by less than three quarters minus its jitter. Wherever its bit changes, the
// two samples differ, so no wrong bit is output. A data lane that is off by a whole bit is not
// noticed. With Samples = 1, a data lane that is off by more than half a bit gives wrong bits, and
// nothing in the link tells them from right ones, because data lanes carry no known pattern.
//
// Latency: a word leaves three clocks after its samples were at the input; with Samples = 2, three
// clocks after the samples of its second half were.
//
//   clock      0   1   2   3   4   5      Samples = 2
//   lanes_i   <0a><0b><1a><1b><2a><2b>    0a: the first seven samples of word 0
//   valid_o   ________________/111\___
//   word_o    ----------------<0 >----
`default_nettype none

module sp_channel_link_lock #(
  parameter int Samples = 1,  // samples of each bit: 1 or 2
  parameter int LogGood = 8   // log2 of the right words in a row before it locks: 1 or more
) (
  input  wire logic        clk_i,     // clock of the deserializer's samples
  input  wire logic        rst_i,     // active high, synchronous; high while clk_i is not stable
  input  wire logic [34:0] lanes_i,   // lane n in 7n+6..7n, its first sample in 7n; 4: clock lane
  output logic             align_o,   // each rise shifts the words by two samples
  output logic             locked_o,
  output logic             valid_o,   // word_o holds a word
  output logic      [27:0] word_o,    // bit i is output i of a receiver chip
  output logic             error_o    // pulse: the lock was lost
);

  if (Samples != 1 && Samples != 2) begin : gen_samples
    samples_is_not_1_or_2 u_error ();
  end
  if (LogGood < 1) begin : gen_log_good
    log_good_is_less_than_1 u_error ();
  end

  localparam logic [6:0] Pattern = 7'b1100011;

  // --- The bits of a word, lane by lane, the first one in bit 7n ---
  logic [34:0] lanes_q;
  logic [34:0] bits;
  logic        complete;  // this clock completes a word
  logic        steady;    // the two samples of each bit of the clock lane are equal
  logic        agree;     // those of the data lanes are
  logic        other;     // exchange the first and the second clock of a word

  always_ff @(posedge clk_i) lanes_q <= lanes_i;

  if (Samples == 1) begin : gen_once
    logic unused;
    assign unused   = other;
    assign bits     = lanes_q;
    assign complete = 1'b1;
    assign steady   = 1'b1;
    assign agree    = 1'b1;
  end else begin : gen_twice
    logic        second_q;  // lanes_q is the second half of a word
    logic [34:0] before_q;  // what was in lanes_q one clock before
    logic [34:0] differ;
    always_ff @(posedge clk_i) begin
      before_q <= lanes_q;
      if (rst_i) second_q <= 1'b0;
      else if (!other) second_q <= !second_q;
    end
    for (genvar n = 0; n < 5; n++) begin : gen_lane
      logic [13:0] samples;
      assign samples = {lanes_q[7*n+:7], before_q[7*n+:7]};
      for (genvar i = 0; i < 7; i++) begin : gen_bit
        assign bits[7*n+i]   = samples[2*i];
        assign differ[7*n+i] = samples[2*i] != samples[2*i+1];
      end
    end
    assign complete = second_q;
    assign steady   = differ[34:28] == '0;
    assign agree    = differ[27:0] == '0;
  end

  // --- Is the word right? ---
  logic        complete_q, pattern_q, agree_q;
  logic [27:0] data_q;
  logic        right;

  always_ff @(posedge clk_i) begin
    complete_q <= complete && !rst_i;
    pattern_q  <= bits[34:28] == Pattern && steady;
    agree_q    <= agree;
    data_q     <= bits[27:0];
  end
  assign right = pattern_q && agree_q;

  // --- Training ---
  logic [LogGood:0] good_q;    // words in a row that were right
  logic [3:0]       settle_q;  // clocks until complete_q and later stages show the last shift
  logic [2:0]       tries_q;   // shifts tried, modulo 8
  logic             judge, move;

  assign locked_o = good_q[LogGood];
  assign judge    = complete_q && settle_q == '0;
  assign move     = judge && !pattern_q && !locked_o;
  assign other    = move && Samples == 2 && tries_q == '1;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      good_q   <= '0;
      settle_q <= '1;
      tries_q  <= '0;
      align_o  <= 1'b0;
      valid_o  <= 1'b0;
      error_o  <= 1'b0;
    end else begin
      if (judge) good_q <= !right ? '0 : locked_o ? good_q : good_q + 1'b1;
      if (move) settle_q <= '1;
      else if (settle_q != '0) settle_q <= settle_q - 1'b1;
      if (move) tries_q <= tries_q + 1'b1;
      align_o <= move && !other || align_o && settle_q > 4'd12;
      valid_o <= judge && right && locked_o;
      error_o <= judge && !right && locked_o;
    end
  end

  // The outputs of the receiver chip, lane by lane, in the order in which their bits arrive:
  // 7 6 4 3 2 1 0, 18 15 14 13 12 9 8, 26 25 24 22 21 20 19, 23 17 16 11 10 5 27
  always_ff @(posedge clk_i) begin
    {word_o[0], word_o[1], word_o[2], word_o[3], word_o[4], word_o[6], word_o[7]} <= data_q[6:0];
    {word_o[8], word_o[9], word_o[12], word_o[13], word_o[14], word_o[15], word_o[18]} <=
        data_q[13:7];
    {word_o[19], word_o[20], word_o[21], word_o[22], word_o[24], word_o[25], word_o[26]} <=
        data_q[20:14];
    {word_o[27], word_o[5], word_o[10], word_o[11], word_o[16], word_o[17], word_o[23]} <=
        data_q[27:21];
  end

`ifdef FORMAL
  logic f_past_q = 1'b0;
  always_ff @(posedge clk_i) f_past_q <= 1'b1;
  always_comb if (!f_past_q) assume (rst_i);

  // Words in a row that were right, at most 2^LogGood
  logic [LogGood:0] f_run_q;
  logic             f_right_q, f_wrong_q, f_locked_q, f_align_q, f_reset_q, f_moved_q;
  logic [27:0]      f_data_q;
  logic [4:0]       f_since_q;  // clocks since align_o rose, at most 16
  always_ff @(posedge clk_i) begin
    f_reset_q  <= rst_i;
    f_right_q  <= judge && pattern_q && agree_q;
    f_wrong_q  <= judge && !(pattern_q && agree_q);
    f_locked_q <= locked_o && !rst_i;
    f_align_q  <= align_o;
    f_data_q   <= data_q;
    if (rst_i || judge && !right) f_run_q <= '0;
    else if (judge && !f_run_q[LogGood]) f_run_q <= f_run_q + 1'b1;
    if (rst_i) f_since_q <= 5'd16;
    else if (move && !other) f_since_q <= 5'd0;
    else if (!f_since_q[4]) f_since_q <= f_since_q + 5'd1;
    f_moved_q <= !rst_i && (f_moved_q || move);
  end

  always_comb if (f_past_q) begin
    // Rule 1: a word is given only in a lock, and only if it was right.
    if (valid_o) assert (f_right_q && f_locked_q && locked_o);
    if (valid_o) assert (word_o[27] == f_data_q[27] && word_o[7] == f_data_q[0] &&
                         word_o[26:24] == {f_data_q[14], f_data_q[15], f_data_q[16]});
    // Rule 2: the lock comes after 2^LogGood right words in a row.
    assert (good_q == f_run_q);
    assert (locked_o == f_run_q[LogGood]);
    if (locked_o) assert (good_q[LogGood-1:0] == '0);
    // Rule 3: a wrong word ends the lock at once, and is told.
    if (f_wrong_q && !f_reset_q) assert (!locked_o);
    assert (error_o == (f_wrong_q && f_locked_q && !f_reset_q));
    // Rule 4: the alignment is never moved in a lock, nor less than 16 clocks after a movement.
    if (locked_o) assert (!move);
    if (move) assert (f_since_q >= 5'd15);
    // Rule 5: align_o is high for four clocks from a movement on, and low otherwise.
    assert (align_o == (f_since_q < 5'd4));
    assert (f_since_q <= 5'd16);
    if (!f_since_q[4]) assert (5'(settle_q) == 5'd15 - f_since_q);
  end
  always_ff @(posedge clk_i) if (f_past_q) begin
    cover (valid_o && f_moved_q);
    cover (error_o);
    cover (align_o && !f_align_q);
  end
`endif

endmodule

`default_nettype wire
