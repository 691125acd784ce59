// Words of 8 or 10 pixels, as fast as a camera brings them in a line, into beats of four pixels,
// one a clock, through a FIFO that is emptied in the gaps between lines and frames.
//
// Guarantees: the pixels of a line leave in order, leftmost first, four a beat. Pixels at the end of
// a line that do not fill a beat are dropped. With Columns > 0, a line of Columns pixels, whose last
// word is filled up with others, leaves without these others. In a line of more words nothing is
// left out, so that it stays longer than Columns; a shorter one stays shorter.
//
// Overflow: a word for which the FIFO has no room is lost with the rest of its frame, and overrun_o
// is high for one clock. Nothing else leaves before the next frame begins. Words before the first
// beginning of a frame are left out.
//
// Rate: a word takes two clocks with 8 pixels, and 2 and 3 in turn with 10. So the FIFO fills while
// words come faster than that, and holds 2^LogWords words and one more.
//
// Latency: three clocks for the first beat of a word that meets an empty FIFO.
//
//   clock      0   1   2   3   4   5   6      Taps = 8
//   valid_i   /1111111\___________________
//   data_i    <a  ><b  >------------------   eight pixels each
//   m_valid_o ____________/111111111111111
//   m_data_o  ------------<a lo><a hi><b lo   from clock 3 on, one each clock
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

  logic              word_valid, word_ready, word_start, word_end;
  logic [8*Taps-1:0] word;

  sp_fifo #(
    .Width   (8 * Taps + 2),
    .LogDepth(LogWords)
  ) u_fifo (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .s_valid_i(offered),
    .s_ready_o(ready),
    .s_data_i ({start_i, end_i, data_i}),
    .m_valid_o(word_valid),
    .m_ready_i(word_ready),
    .m_data_o ({word_start, word_end, word})
  );

  // --- Which beats of a word leave ---
  logic [1:0] step_q;   // beats of the word that have left
  logic       two_q;    // with 10 pixels: two pixels of the line wait for their beat
  logic       two;
  logic       short;    // the last word of a line of Columns pixels, which is not full
  logic [1:0] last;     // the last step of the word
  logic       done;     // the word's last beat leaves

  assign two  = two_q && !word_start;
  assign done = word_valid && step_q == last;
  assign word_ready = done;

  if (Columns % Taps != 0) begin : gen_short
    localparam int Whole = Columns / Taps;                  // words before the short one
    localparam int Waiting = Whole * Taps % 4;              // pixels that wait for their beat then
    localparam int Beats = (Columns % Taps + Waiting) / 4;  // of the short word
    localparam int CountBits = $clog2(Whole + 2);
    logic [CountBits-1:0] count_q, count;                   // words of the line, Whole + 1 at most

    assign count = word_start ? '0 : count_q;
    assign short = word_end && count == CountBits'(Whole);
    assign last  = short ? 2'(Beats - 1) : {two, !two};

    always_ff @(posedge clk_i) begin
      if (rst_i) count_q <= '0;
      else if (done) begin
        if (word_end) count_q <= '0;
        else if (count <= CountBits'(Whole)) count_q <= count + 1'b1;
      end
    end
  end else begin : gen_whole
    assign short = 1'b0;
    assign last  = {two, !two};
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) step_q <= '0;
    else if (word_valid) step_q <= done ? '0 : step_q + 1'b1;
  end

  // --- The beats ---
  logic [31:0] beat;

  if (Taps == 8) begin : gen_eight
    logic unused;
    assign unused = short;
    assign two_q  = 1'b0;
    assign beat   = step_q[0] ? word[63:32] : word[31:0];
  end else begin : gen_ten
    logic [15:0] kept_q;  // the two pixels that wait
    logic        unused;
    assign unused = short;

    always_ff @(posedge clk_i) begin
      if (rst_i) two_q <= 1'b0;
      else if (done) two_q <= !word_end && !two;
      if (done) kept_q <= word[79:64];
    end
    always_comb begin
      case ({two, step_q})
        3'b000: beat = word[31:0];
        3'b001: beat = word[63:32];
        3'b100: beat = {word[15:0], kept_q};
        3'b101: beat = word[47:16];
        default: beat = word[79:48];
      endcase
    end
  end

  always_ff @(posedge clk_i) begin
    m_valid_o <= word_valid && !rst_i;
    m_data_o  <= beat;
    m_start_o <= word_start && step_q == '0;
    m_end_o   <= word_end && step_q == last;
  end

endmodule

`default_nettype wire
