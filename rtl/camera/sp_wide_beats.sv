// Words of 8 or 10 pixels, as fast as a camera brings them in a line, into beats of four pixels,
// one a clock, through a FIFO that is emptied in the gaps between lines and frames.
//
// Guarantees: the pixels of a line leave in order, leftmost first, four a beat. Pixels at the end of
// a line that do not fill a beat are dropped. With Columns > 0, a line of Columns pixels, whose last
// word is filled up with others, leaves without these others. In a line of more words nothing is
// left out, so that it stays longer than Columns; a shorter one stays shorter.
//
// Overflow: a word for which the FIFO has no room is lost with the rest of its frame, and overrun_o
// is high for one clock. What waits in the FIFO then still leaves, and nothing else before the next
// frame begins. Words before the first beginning of a frame are left out.
//
// Rate: a word takes two clocks with 8 pixels, and 2 and 3 in turn with 10. So the FIFO fills while
// words come faster than that, and holds 2^LogWords words and two more.
//
// Latency: four clocks for the first beat of a word that meets an empty FIFO.
//
//   clock      0   1   2   3   4   5   6   7      Taps = 8
//   valid_i   /1111111\_______________________
//   data_i    <a ><b >------------------------   eight pixels each
//   m_valid_o ________________/111111111111111
//   m_data_o  ----------------<a0><a1><b0><b1>   a0: the left four of a
`default_nettype none

module sp_wide_beats #(
  parameter int Taps = 8,  // pixels of a word: 8 or 10
  parameter int Columns = 0,  // pixels of a line, a multiple of 4; 0: all of its words
  parameter int LogWords = 9  // log2 of the words in the FIFO: 1..24
) (
  input  wire logic              clk_i,
  input  wire logic              rst_i,      // active high, synchronous

  // Words
  input  wire logic              valid_i,
  input  wire logic [8*Taps-1:0] data_i,     // leftmost pixel in 7..0
  input  wire logic              start_i,    // first word of a frame
  input  wire logic              end_i,      // last word of a line

  // Video
  output logic                   m_valid_o,
  output logic      [31:0]       m_data_o,   // leftmost pixel in 7..0
  output logic                   m_start_o,  // first beat of a frame
  output logic                   m_end_o,    // last beat of a line
  output logic                   overrun_o   // pulse: a frame was cut off for want of room
);

  if (Taps != 8 && Taps != 10) begin : gen_taps
    taps_is_not_8_or_10 u_error ();
  end
  if (Columns < 0 || Columns > 65532 || Columns % 4 != 0) begin : gen_columns
    columns_is_not_a_multiple_of_4_up_to_65532 u_error ();
  end

  // --- Into the FIFO: whole frames, or their beginnings ---
  logic open_q;  // the frame has not been lost
  logic offered, ready;

  assign offered = valid_i && (open_q || start_i);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      open_q    <= 1'b0;
      overrun_o <= 1'b0;
    end else begin
      if (offered) open_q <= ready;
      overrun_o <= offered && !ready;
    end
  end

  logic              fifo_valid, fifo_ready, fifo_start, fifo_end;
  logic [8*Taps-1:0] fifo_word;

  sp_fifo #(
    .Width   (8 * Taps + 2),
    .LogDepth(LogWords)
  ) u_fifo (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .s_valid_i(offered),
    .s_ready_o(ready),
    .s_data_i ({start_i, end_i, data_i}),
    .m_valid_o(fifo_valid),
    .m_ready_i(fifo_ready),
    .m_data_o ({fifo_start, fifo_end, fifo_word})
  );

  // A register of its own, because a block RAM gives its word late in the clock
  logic              valid_q, start_q, end_q;
  logic              done;     // the word's last beat leaves
  logic [8*Taps-1:0] word_q;

  assign fifo_ready = !valid_q || done;

  always_ff @(posedge clk_i) begin
    if (rst_i) valid_q <= 1'b0;
    else if (fifo_ready) valid_q <= fifo_valid;
    if (fifo_ready) {start_q, end_q, word_q} <= {fifo_start, fifo_end, fifo_word};
  end

  // --- Which beats of a word leave ---
  logic [1:0] step_q;   // beats of the word that have left
  logic       two_q;    // with 10 pixels: two pixels of the line wait for their beat
  logic       two;
  logic       short;    // the last word of a line of Columns pixels, which is not full
  logic [1:0] last;     // the last step of the word

  assign two   = two_q && !start_q;
  assign done  = valid_q && step_q == last;

  localparam int Whole = Columns / Taps;                  // words before the short one
  localparam int Waiting = Whole * Taps % 4;              // pixels that wait for their beat then
  localparam int Beats = (Columns % Taps + Waiting) / 4;  // of the short word
  localparam int CountBits = $clog2(Whole + 2);
  logic [CountBits-1:0] count_q, count;                   // words of the line, Whole + 1 at most

  if (Columns % Taps != 0) begin : gen_short
    assign count = start_q ? '0 : count_q;
    assign short = end_q && count == CountBits'(Whole);
    assign last  = short ? 2'(Beats - 1) : {two, !two};

    always_ff @(posedge clk_i) begin
      if (rst_i) count_q <= '0;
      else if (done) begin
        if (end_q) count_q <= '0;
        else if (count <= CountBits'(Whole)) count_q <= count + 1'b1;
      end
    end
  end else begin : gen_whole
    logic unused;
    assign unused  = ^{count, count_q};
    assign count_q = '0;
    assign count   = '0;
    assign short   = 1'b0;
    assign last    = {two, !two};
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) step_q <= '0;
    else if (valid_q) step_q <= done ? '0 : step_q + 1'b1;
  end

  // --- The beats ---
  logic [31:0] beat;

  if (Taps == 8) begin : gen_eight
    logic unused;
    assign unused = short;
    assign two_q  = 1'b0;
    assign beat   = step_q[0] ? word_q[63:32] : word_q[31:0];
  end else begin : gen_ten
    logic [15:0] kept_q;  // the two pixels that wait
    logic        unused;
    assign unused = short;

    always_ff @(posedge clk_i) begin
      if (rst_i) two_q <= 1'b0;
      else if (done) two_q <= !end_q && !two;
      if (done) kept_q <= word_q[79:64];
    end
    always_comb begin
      case ({two, step_q})
        3'b000: beat = word_q[31:0];
        3'b001: beat = word_q[63:32];
        3'b100: beat = {word_q[15:0], kept_q};
        3'b101: beat = word_q[47:16];
        default: beat = word_q[79:48];
      endcase
    end
  end

  always_ff @(posedge clk_i) begin
    m_valid_o <= valid_q && !rst_i;
    m_data_o  <= beat;
    m_start_o <= start_q && step_q == '0;
    m_end_o   <= end_q && step_q == last;
  end

`ifdef FORMAL
  logic f_past_q = 1'b0;
  always_ff @(posedge clk_i) f_past_q <= 1'b1;
  always_comb if (!f_past_q) assume (rst_i);

  // Of the line of word_q, modulo 64: words before it, and beats that have left
  logic [5:0]  f_words_q, f_words, f_beats_q, f_beats;
  logic [15:0] f_before_q;  // the last two pixels of the word before
  logic [5:0]  f_place;     // in word_q, of the first pixel of the beat; 62: two pixels before it
  logic [5:0]  f_left;      // pixels of the word behind the beat
  logic        f_lost_q;    // the rest of the frame is lost
  assign f_words = start_q ? '0 : f_words_q;
  assign f_beats = start_q && step_q == '0 ? '0 : f_beats_q;
  assign f_place = 6'(4) * f_beats - 6'(Taps) * f_words;
  assign f_left  = 6'(Taps - 4) - f_place;
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_words_q, f_beats_q} <= '0;
    else if (valid_q) begin
      f_beats_q <= done && end_q ? '0 : f_beats + 1'b1;
      if (done) f_words_q <= end_q ? '0 : f_words + 1'b1;
    end
    if (done) f_before_q <= word_q[8*Taps-1-:16];
    f_lost_q <= !rst_i && (offered ? !ready : f_lost_q);
  end

  always_comb if (f_past_q) begin
    // Rule 1: what has left of a line is all of it, but for the beats of its present word.
    if (valid_q) assert (f_place == 6'(4) * 6'(step_q) - (two ? 6'd2 : 6'd0));
    if (valid_q) assert (step_q <= last);
    if (!valid_q) assert (step_q == '0 && f_beats_q * 6'd4 - f_words_q * 6'(Taps) ==
                          (two_q ? 6'd62 : 6'd0));
    assert (count_q <= CountBits'(Whole + 1));
    if (Columns % Taps != 0 && count_q <= CountBits'(Whole)) assert (f_words_q == 6'(count_q));
    // Rule 2: each byte of a beat is the pixel of its place.
    for (int i = 0; i < 4; i++) begin
      for (int k = 0; k < Taps; k++) begin
        if (valid_q && 6'(f_place + 6'(i)) == 6'(k)) assert (beat[8*i+:8] == word_q[8*k+:8]);
      end
      if (valid_q && 6'(f_place + 6'(i)) == 6'd62) assert (beat[8*i+:8] == f_before_q[7:0]);
      if (valid_q && 6'(f_place + 6'(i)) == 6'd63) assert (beat[8*i+:8] == f_before_q[15:8]);
    end
    // Rule 3: a word goes when fewer than four of its pixels are left, or where the line has its
    // length; then its last beat has left.
    if (done && !short) assert (f_left < 6'd4);
    if (done && end_q && Columns % Taps != 0 && count == CountBits'(Whole)) begin
      assert (f_place + 6'(Taps) * f_words + 6'd4 == 6'(Columns));
    end
    if (short) assert (end_q && count == CountBits'(Whole));
    // Rule 4: after a loss nothing goes into the FIFO up to the beginning of a frame.
    if (f_lost_q) assert (!open_q && (!offered || start_i));
  end
  always_ff @(posedge clk_i) if (f_past_q) begin
    cover (m_valid_o && m_end_o && !m_start_o);
    cover (overrun_o);
  end
  if (Columns % Taps != 0) begin : gen_rules_of_short
    always_ff @(posedge clk_i) cover (f_past_q && done && short);
  end
  if (Taps == 10) begin : gen_rules_of_ten
    always_ff @(posedge clk_i) cover (f_past_q && valid_q && two && step_q == 2'd2);
  end
`endif

endmodule

`default_nettype wire
