// Puts frames together from the datagrams of a host, for sp_replay. docs/packet-reference.md has
// the format, model/replay.h is the model.
//
//   datagrams ─▶ header ─▶ judge ─▶ words into the memory ─▶ play_o, once a frame is whole
//
// Guarantees: a datagram is taken if all of it comes without an error, it is from host_i and of
// session_i, its size is one that fits, and its first byte is the next one of the frame. The first
// datagram of a later frame is taken too. It drops the frame before, if that is not whole. All
// other datagrams are ignored and counted. So a frame is whole only if each of its words came with
// a datagram of this frame, at its place, and nothing has been written over it since. After play_o
// the memory does not change until done_i; datagrams that come meanwhile are ignored.
//
// While enable_i is low, and with begin_i, what has come of a frame is forgotten. begin_i makes
// frame 0 the next one. A datagram that has begun before is ignored.
//
// Each clock takes a word, so that the source never waits. Words after s_bytes_i do not count.
// Latency: a word is in the memory, and the registers show a datagram, three clocks after its last
// word. play_o comes in the same clock. Example: a frame of two beats in one datagram:
//
//   clock       0   1   2   3   4   5   6   7   8   9  10
//   s_valid_i  /111111111111111111111111111\_______________
//   s_data_i   <m ><f ><o ><l ><r ><p0><p1>----------------  (a)
//   s_last_i   ________________________/111\_______________
//   write_o    ____________________________/1111111\_______
//   address_o  ----------------------------<0 ><1 >--------
//   play_o     ____________________________________/111\___
//
//   (a) the header's words: magic, session; frame; offset; length, columns; rows
`default_nettype none

module sp_replay_receiver #(
  parameter int MaxColumns = 512,  // a multiple of 4, 4..2048; with one row 8 or more
  parameter int MaxRows = 127,  // 1..1023
  // derived, do not set
  parameter int LogWords = $clog2(MaxColumns / 4 * MaxRows),
  parameter int BeatBits = $clog2(MaxColumns / 4 + 1),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  input  wire logic                clk_i,
  input  wire logic                rst_i,      // active high, synchronous

  // Datagrams
  input  wire logic                s_valid_i,  // a word, which is taken at once
  input  wire logic                s_last_i,   // last word of a datagram
  input  wire logic                s_error_i,  // with the last word: the datagram is damaged
  input  wire logic [31:0]         s_data_i,   // first byte of a word in 7..0
  input  wire logic [15:0]         s_bytes_i,  // bytes of the datagram, with every word
  input  wire logic [31:0]         s_from_i,   // address of the sender, with every word

  // Who may send
  input  wire logic                enable_i,   // datagrams are taken
  input  wire logic [31:0]         host_i,     // from this address
  input  wire logic                begin_i,    // one clock: a session of replay begins
  input  wire logic [15:0]         session_i,  // its number, from begin_i on

  // Memory
  output logic                     write_o,
  output logic      [LogWords-1:0] address_o,
  output logic      [31:0]         data_o,

  // Whole frames
  output logic                     play_o,     // one clock: the frame in the memory is whole
  output logic      [BeatBits-1:0] beats_o,    // beats of a row, from play_o to done_i
  output logic      [RowBits-1:0]  rows_o,
  input  wire logic                done_i,     // one clock: it has left

  // Registers
  output logic      [31:0]         frame_o,    // the frame that is due, or of which a part has come
  output logic      [31:0]         offset_o,   // bytes of it that have come
  output logic      [31:0]         frames_o,   // whole frames that have left; wraps
  output logic      [31:0]         dropped_o,  // frames that were dropped; wraps
  output logic      [31:0]         ignored_o   // datagrams that were ignored; wraps
);

  if (MaxColumns < 4 || MaxColumns > sp_spec_pkg::MaxColumns || MaxColumns % 4 != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_4_in_4_to_2048 u_error ();
  end
  if (MaxRows < 1 || MaxRows > sp_spec_pkg::MaxRows) begin : gen_max_rows
    max_rows_is_not_in_1_to_1023 u_error ();
  end
  if (MaxColumns * MaxRows < 8) begin : gen_beats
    a_frame_of_one_beat_cannot_be_replayed u_error ();
  end

  localparam int HeaderWords = sp_spec_pkg::ReplayHeaderBytes / 4;
  localparam int CountBits = LogWords + 1;  // words of a frame
  localparam int PieceBits = sp_spec_pkg::ReplayLengthBits - 2;  // words of a datagram
  localparam int SumBits = (CountBits > PieceBits ? CountBits : PieceBits) + 1;
  localparam logic [2:0] FirstWord = 3'(HeaderWords);  // first word behind the header
  localparam logic [2:0] LaterWord = FirstWord + 3'd1;

  // --- The header comes, one clock after the input ---
  logic        valid_q, last_q, error_q;
  logic [31:0] data_q, from_q;
  logic [15:0] bytes_q;
  logic [2:0]  at_q;       // place of the word in the datagram
  logic        alive_q;    // magic and session are right, and nothing has ended the session since
  logic [31:0] number_q;   // fields of the header
  logic [31:0] start_q;
  logic [15:0] length_q, columns_q, rows_q;
  logic        forget;     // what has come of a frame is forgotten

  assign forget = begin_i || !enable_i;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q <= 1'b0;
      at_q    <= '0;
      alive_q <= 1'b0;
    end else begin
      valid_q <= s_valid_i;
      if (valid_q) at_q <= last_q ? '0 : at_q == LaterWord ? LaterWord : at_q + 1'b1;
      if (forget) alive_q <= 1'b0;
      else if (valid_q && at_q == '0)
        alive_q <= data_q == {session_i, sp_spec_pkg::ReplayMagic};
    end
    last_q  <= s_last_i;
    error_q <= s_error_i;
    data_q  <= s_data_i;
    bytes_q <= s_bytes_i;
    from_q  <= s_from_i;
    if (valid_q) begin
      if (at_q == 3'd1) number_q <= data_q;
      if (at_q == 3'd2) start_q <= data_q;
      if (at_q == 3'd3) {columns_q, length_q} <= data_q;
      if (at_q == 3'd4) rows_q <= data_q[15:0];
    end
  end

  // --- The judge looks at it in the clock of the first word behind the header ---
  logic                 busy_q;    // a whole frame is leaving
  logic [CountBits-1:0] next_q;    // words of the frame frame_o that have come
  logic [CountBits-1:0] words_q;   // words of this frame
  logic [CountBits-1:0] words;     // words of a frame of the header's size
  logic [31:0]          ahead;     // frames from the one that is due to the datagram's
  logic [SumBits-1:0]   stop;      // end of the piece, in words
  logic                 fits;      // the size is possible, and the piece lies in the frame
  logic                 same_size, begins, goes_on, judged;

  assign words     = CountBits'(columns_q[2+:BeatBits]) * CountBits'(rows_q[0+:RowBits]);
  assign ahead     = number_q - frame_o;
  assign stop      = SumBits'(start_q[2+:CountBits]) + SumBits'(length_q[2+:PieceBits]);
  assign fits      = columns_q[1:0] == '0 && columns_q != '0 && columns_q <= 16'(MaxColumns) &&
                     rows_q != '0 && rows_q <= 16'(MaxRows) &&
                     start_q[1:0] == '0 && start_q < 32'(4 * (MaxColumns / 4) * MaxRows) &&
                     length_q[1:0] == '0 && length_q != '0 && stop <= SumBits'(words);
  assign same_size = columns_q == 16'({beats_o, 2'b00}) && rows_q == 16'(rows_o);
  assign begins    = start_q == '0 && !ahead[31] && (next_q == '0 || ahead != '0);
  assign goes_on   = start_q[2+:CountBits] == next_q && next_q != '0 && ahead == '0 && same_size;
  assign judged    = alive_q && !forget && !busy_q && from_q == host_i && fits &&
                     17'(bytes_q) == 17'(length_q) + 17'(sp_spec_pkg::ReplayHeaderBytes) &&
                     (begins || goes_on);

  // --- Its words go into the memory, two clocks after the input ---
  logic                 valid_q2, last_q2, error_q2;
  logic [31:0]          data_q2;
  logic                 good_q;    // the judge has taken the datagram of this word
  logic [CountBits-1:0] put_q;     // place of the word
  logic [PieceBits-1:0] left_q;    // words of the datagram that are left, with this one
  logic [31:0]          ahead_q;   // frames that are dropped if the datagram is whole
  logic [CountBits-1:0] after;     // words of the frame, with this one
  logic                 put, ends, taken, whole;

  assign put   = valid_q2 && good_q && left_q != '0;
  assign after = put_q + CountBits'(put);
  assign ends  = valid_q2 && last_q2;
  assign taken = ends && good_q && !error_q2 && left_q <= PieceBits'(1) && !forget;
  assign whole = taken && after == words_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q2 <= 1'b0;
      good_q   <= 1'b0;
    end else begin
      valid_q2 <= valid_q;
      if (forget || valid_q && at_q == '0) good_q <= 1'b0;
      else if (valid_q && at_q == FirstWord) good_q <= judged;
    end
    last_q2  <= last_q;
    error_q2 <= error_q;
    data_q2  <= data_q;
    if (valid_q && at_q == FirstWord) begin
      put_q   <= start_q[2+:CountBits];
      left_q  <= length_q[2+:PieceBits];
      ahead_q <= ahead;
      if (judged) begin
        beats_o <= columns_q[2+:BeatBits];
        rows_o  <= rows_q[0+:RowBits];
        words_q <= words;
      end
    end else if (put) begin
      put_q  <= after;
      left_q <= left_q - 1'b1;
    end
  end

  // --- What has come ---
  always_ff @(posedge clk_i) begin
    write_o   <= put && !rst_i;
    address_o <= put_q[LogWords-1:0];
    data_o    <= data_q2;
    if (rst_i) begin
      play_o    <= 1'b0;
      busy_q    <= 1'b0;
      next_q    <= '0;
      frame_o   <= '0;
      frames_o  <= '0;
      dropped_o <= '0;
      ignored_o <= '0;
    end else begin
      play_o <= whole;
      if (whole) busy_q <= 1'b1;
      else if (done_i) busy_q <= 1'b0;
      if (done_i) frames_o <= frames_o + 1'b1;
      if (ends && !taken) ignored_o <= ignored_o + 1'b1;
      if (taken) dropped_o <= dropped_o + ahead_q;
      if (begin_i) frame_o <= '0;
      else if (taken) frame_o <= number_q + 32'(whole);
      if (forget || whole) next_q <= '0;
      else if (taken) next_q <= after;
      else if (valid_q && at_q == FirstWord && judged && begins) next_q <= '0;
    end
  end

  assign offset_o = 32'({next_q, 2'b00});

`ifdef FORMAL
  // Assumptions: one reset at the beginning; done_i only while a frame leaves.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb assume (rst_i == !f_ran_q);
  always_comb if (done_i) assume (busy_q && !play_o);

  // Rule 1: in a frame that is whole, each word came with a datagram of that frame that was taken,
  // and was not forgotten since. The rule is proved for any one place of the memory:
  (* anyconst *) logic [LogWords-1:0] f_place;
  logic                 f_here;           // the word at the place is written
  logic                 f_begins;         // the frame begins again
  logic                 f_pending_q;      // it is of the datagram that comes
  logic                 f_sure_q;         // that datagram was taken
  logic [31:0]          f_number_q;       // its frame
  logic [CountBits-1:0] f_at;
  logic                 f_open;           // the datagram that comes was taken by the judge
  assign f_at     = CountBits'(f_place);
  assign f_open   = good_q && (at_q != '0 || ends);
  assign f_here   = put && put_q == f_at;
  assign f_begins = valid_q && at_q == FirstWord && judged && begins;
  always_ff @(posedge clk_i) begin
    if (rst_i || forget || f_begins) {f_pending_q, f_sure_q} <= 2'b00;
    else if (taken && (f_here || f_pending_q)) {f_pending_q, f_sure_q} <= 2'b01;
    else if (f_here) {f_pending_q, f_sure_q} <= 2'b10;
    else if (valid_q && at_q == '0) f_pending_q <= 1'b0;
    if (f_here) f_number_q <= number_q;
  end
  always_comb if (f_ran_q && !rst_i) begin
    if (f_at < next_q) assert (f_sure_q && f_number_q == frame_o);
    if (f_open && f_at >= next_q && f_at < put_q) assert (f_pending_q && f_number_q == number_q);
    if (play_o && f_at < words_q) assert (f_sure_q && f_number_q + 32'd1 == frame_o);
  end

  // Rule 2: a datagram that is taken continues the frame where it stands, or begins it. All of its
  // words came without an error, lie in the frame, and come from the host.
  logic                 f_sender_q;  // the datagram's sender was the host, when it was judged
  logic [PieceBits-1:0] f_got_q;     // words of the datagram that are written
  always_ff @(posedge clk_i) begin
    if (valid_q && at_q == FirstWord) f_sender_q <= from_q == host_i;
    if (valid_q && at_q == FirstWord) f_got_q <= '0;
    else f_got_q <= f_got_q + PieceBits'(put);
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (at_q <= LaterWord);
    if (next_q != '0) assert (next_q < words_q);
    if (next_q != '0 || busy_q || good_q)
      assert (words_q <= CountBits'(MaxColumns / 4 * MaxRows) && words_q != '0 &&
              words_q == CountBits'(beats_o) * CountBits'(rows_o));
    if (good_q) begin
      assert (at_q == '0 || at_q == LaterWord);
      if (valid_q2) assert (last_q2 == (at_q == '0));
    end
    if (f_open) begin
      assert (f_sender_q && !busy_q && next_q <= put_q);
      assert (SumBits'(put_q) + SumBits'(left_q) <= SumBits'(words_q));
      assert (ahead_q == number_q - frame_o && !ahead_q[31]);
      if (next_q != '0) assert (ahead_q == '0);
      assert (f_got_q + left_q == length_q[2+:PieceBits]);
    end
    if (taken)
      assert (f_open && !error_q2 && f_got_q + PieceBits'(put) == length_q[2+:PieceBits]);
  end

  // Rule 3: while a frame leaves, the memory stands still.
  always_comb if (f_ran_q && !rst_i) begin
    if (busy_q) assert (next_q == '0 && !put);
    if (play_o) assert (busy_q);
    if (busy_q && !play_o) assert (!write_o);
  end

  // Rule 4: frames that left, the one that leaves, and those that were dropped are all before the
  // one that is due. (Their lower bits; the upper ones count in the same way, but sums of 32 bits
  // take z3 too long.)
  localparam int FBits = 6;
  logic [FBits-1:0] f_before_q;  // such frames before the session began
  logic [FBits-1:0] f_all;
  assign f_all = frames_o[FBits-1:0] + dropped_o[FBits-1:0] + FBits'(busy_q);
  always_ff @(posedge clk_i) begin
    if (rst_i) f_before_q <= '0;
    else if (begin_i) f_before_q <= f_all;
  end
  always_comb if (f_ran_q && !rst_i) assert (frame_o[FBits-1:0] == f_all - f_before_q);

  always_comb if (f_ran_q && !rst_i) begin
    cover (play_o && words_q > CountBits'(1) && dropped_o != '0);
    cover (frames_o == 32'd1 && ignored_o != '0 && next_q != '0);
  end
`endif

endmodule

`default_nettype wire
