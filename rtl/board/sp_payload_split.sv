// Splits the words of a board with 8 or 16 lanes into payload beats of 16 bytes.
//
// sp_column_moments and sp_column_runs give 4 Lanes bytes at once, as their columns come. A payload
// beat is a quarter of that with 16 lanes, half of it with 8. The words wait in a FIFO meanwhile.
//
// Guarantees: the beats of a word leave in successive clocks, the lowest bytes first, and words
// without a gap while there are any. break_o comes with the last beat of the word that
// words_break_i came with, or behind the words before it, as the end of the payload. A payload of
// W words has left 4 + W Lanes / 4 clocks after its first word at the latest, if its words come
// without a gap.
//
// Overflow: the FIFO holds the words of one frame, and sp_packetizer takes no packet before that of
// the frame before is complete. So from the beginning of a last row to that of the next one whose
// packet is wanted, too, there must be a clock for each payload beat and 40 more: with C columns
// C / 2 + 40 in the grey modes, C / 4 + 40 in mode binary, and in compact packets as many more as
// MaxRows has bits. What comes sooner is counted as lost.
//
// Eight lanes:
//
//   clock           0   1   2   3   4   5   6   7
//   words_valid_i  _/A\_/B\________________________
//   valid_o        _____________/A0\/A1\/B0\/B1\___
`default_nettype none

module sp_payload_split #(
  parameter int Lanes = 8,  // 8 or 16
  parameter int LogDepth = 9  // log2 of the words that wait: 2..24
) (
  input  wire logic                clk_i,
  input  wire logic                rst_i,

  input  wire logic                words_valid_i,
  input  wire logic [32*Lanes-1:0] words_data_i,
  input  wire logic                words_break_i,  // no further word of this frame comes

  output logic                     valid_o,
  output logic      [127:0]        data_o,
  output logic                     break_o
);

  if (Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_8_or_16 u_error ();
  end
  if (LogDepth < 2 || LogDepth > 24) begin : gen_log_depth
    log_depth_is_not_in_2_to_24 u_error ();
  end

  localparam int Parts = Lanes / 4;
  localparam int PartBits = $clog2(Parts);

  logic                waits, holds, breaks;  // there is an entry; it has a word; it ends the frame
  logic [32*Lanes-1:0] word;
  logic [PartBits-1:0] part_q;                // the part of the word that leaves
  logic                done;                  // the entry leaves with this part
  logic                unused_ready;          // there is always room: see above

  sp_fifo #(
    .Width   (32 * Lanes + 2),
    .LogDepth(LogDepth)
  ) u_words (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .s_valid_i(words_valid_i || words_break_i),
    .s_ready_o(unused_ready),
    .s_data_i ({words_valid_i, words_break_i, words_data_i}),
    .m_valid_o(waits),
    .m_ready_i(done),
    .m_data_o ({holds, breaks, word})
  );

  assign done = !holds || part_q == PartBits'(Parts - 1);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      part_q  <= '0;
      valid_o <= 1'b0;
      break_o <= 1'b0;
    end else begin
      if (waits) part_q <= done ? '0 : part_q + 1'b1;
      valid_o <= waits && holds;
      break_o <= waits && breaks && done;
    end
  end

  always_ff @(posedge clk_i) data_o <= word[128*part_q+:128];

`ifdef FORMAL
  // Assumptions: one reset at the beginning; there is room for what comes.
  // Rule: any one bit of any one part of any one word comes out in the place in which it went in.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  (* anyconst *) logic [2:0]          f_mark;  // one of the first eight words
  (* anyconst *) logic [PartBits-1:0] f_part;
  (* anyconst *) logic [6:0]          f_bit;
  logic [2:0]          f_in_q;                 // words that went in
  logic [PartBits+2:0] f_out_q;                // parts that came out
  logic                f_data_q;
  logic                f_gone_q, f_breaks_q;   // the word has gone in; it ends its frame
  always_comb begin
    assume (rst_i == !f_ran_q);
    assume (unused_ready && (!words_valid_i || f_in_q != '1));
  end
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_in_q, f_out_q, f_gone_q, f_breaks_q} <= '0;
    else begin
      if (words_valid_i) f_in_q <= f_in_q + 3'd1;
      if (valid_o) f_out_q <= f_out_q + 1'b1;
      if (words_valid_i && f_in_q == f_mark) {f_gone_q, f_breaks_q} <= {1'b1, words_break_i};
    end
    if (words_valid_i && f_in_q == f_mark) f_data_q <= words_data_i[{f_part, f_bit}];
  end
  always_comb if (f_ran_q) begin
    if (valid_o && f_out_q == {f_mark, f_part}) begin
      assert (f_gone_q && data_o[f_bit] == f_data_q);
      assert (break_o == (f_breaks_q && f_part == '1));
    end
    if (break_o && !valid_o) assert (f_out_q[PartBits-1:0] == '0);
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    cover (valid_o && break_o && f_out_q == (PartBits + 3)'(2 * Parts - 1));
    cover (break_o && !valid_o && f_out_q == (PartBits + 3)'(Parts));
  end
`endif

endmodule

`default_nettype wire
