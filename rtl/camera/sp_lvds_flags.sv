// Decodes the control lane of a serial sensor of the CMV kind: flags in every word.
//
// Bit 0 of a control word is data valid, bit 1 line valid, bit 2 frame valid. Without data valid the
// data lanes carry training words. So they are used by the open interface of the EagleSat project for
// the CMV2000 (interface.vhd), whose idle control word is 10'h200. The other flags of the sensor
// (overhead, integration) are not needed here, and nothing is assumed of them.
//
// A word is legal if its bits under FixedMask are those of Fixed, data valid comes only with line
// valid, and line valid only with frame valid. That bit 9 is 1 follows from the idle word. That bit
// 8 is 0 in every word is not in that source: take it out of FixedMask if a sensor differs.
//
// Guarantees: a burst is Burst words with data valid, one after the other, then at least one without.
// A line is Columns words with data valid (in one or more bursts). A frame begins with frame valid,
// after two words without, and ends with two words without. take_o marks each pixel word of a frame
// that began while aligned_i was high, last_o the last one of its line.
//
// Broken input: a word that is not legal; a burst of another length; a frame that ends within a line
// or without one; frame valid low for a single word. Each of these makes bad_o high; a word that is
// not legal, illegal_o too. The rest of the frame is left out, and cut_o is high once. The same comes,
// without bad_o, if aligned_i falls within a frame. Faults of order in the rest are not counted again.
//
// Latency: the outputs are pulses one clock after en_i.
//
//   word       <200><207><207><205><207>...      Burst = 4
//   take_o     ________/1111111\____________
//   bad_o      ________________/111\_________    line valid is missing: not legal
//   cut_o      ________________/111\_________
`default_nettype none

module sp_lvds_flags #(
  parameter int Bits = 10,  // of a word: 8, 10 or 12
  parameter int Columns = 128,  // words of a line: 1..4096
  parameter int Burst = 128,  // words of a burst: 1..4096; Columns is a multiple of it
  parameter logic [11:0] FixedMask = 12'h300,
  parameter logic [11:0] Fixed = 12'h200
) (
  input  wire logic            clk_i,
  input  wire logic            rst_i,      // active high, synchronous
  input  wire logic            en_i,       // a control word
  input  wire logic [Bits-1:0] word_i,
  input  wire logic            aligned_i,  // all lanes are aligned
  output logic                 decoded_o,  // a word was decoded
  output logic                 illegal_o,  // it is not legal
  output logic                 idle_o,     // the data lanes carry training words with it
  output logic                 begins_o,   // a frame begins, with its first word or before it
  output logic                 take_o,     // a pixel word
  output logic                 last_o,     // the last one of its line
  output logic                 cut_o,      // the rest of the frame is lost
  output logic                 bad_o       // something is wrong
);

  if (Bits != 8 && Bits != 10 && Bits != 12) begin : gen_bits
    bits_is_not_8_10_or_12 u_error ();
  end
  if (Columns < 1 || Columns > 4096) begin : gen_columns
    columns_is_not_in_1_to_4096 u_error ();
  end
  if (Burst < 1 || Burst > 4096 || Columns % Burst != 0) begin : gen_burst
    burst_is_not_in_1_to_4096_or_does_not_divide_columns u_error ();
  end

  localparam int BurstBits = Burst < 1 ? 1 : $clog2(Burst + 1);
  localparam int ColumnBits = Columns < 2 ? 1 : $clog2(Columns);

  logic        data, line, frame, legal;
  logic        in_frame_q;  // since frame valid rose
  logic        low_q;       // the last word was without frame valid
  logic        open_q;      // the frame is taken
  logic        any_q;       // it has a line
  logic [BurstBits-1:0]  burst_q;   // words of the burst
  logic [ColumnBits-1:0] column_q;  // words of the line
  logic        begins, ends, wrong, open;

  assign data   = word_i[0];
  assign line   = word_i[1];
  assign frame  = word_i[2];
  assign legal  = (word_i & FixedMask[Bits-1:0]) == (Fixed[Bits-1:0] & FixedMask[Bits-1:0]) &&
                  (line || !data) && (frame || !line);
  assign begins = legal && frame && !in_frame_q;
  assign ends   = legal && !frame && in_frame_q && low_q;
  assign open   = open_q || begins;
  // Of a frame that is taken
  assign wrong  = !legal || data && burst_q == BurstBits'(Burst) ||
                  !data && burst_q != '0 && burst_q != BurstBits'(Burst) || !frame && column_q != '0 ||
                  frame && in_frame_q && low_q || ends && !any_q;

  always_ff @(posedge clk_i) begin
    decoded_o <= en_i && !rst_i;
    illegal_o <= en_i && !legal && !rst_i;
    idle_o    <= en_i && legal && !data;
    begins_o  <= en_i && begins && aligned_i && !rst_i;
    take_o    <= en_i && aligned_i && open && data && !wrong;
    last_o    <= en_i && data && column_q == ColumnBits'(Columns - 1);
    cut_o     <= !rst_i && open_q && (!aligned_i || en_i && wrong);
    bad_o     <= en_i && aligned_i && (!legal || open_q && wrong) && !rst_i;
    if (rst_i || !aligned_i) begin
      in_frame_q <= 1'b1;
      low_q      <= 1'b0;
      open_q     <= 1'b0;
      burst_q    <= '0;
      column_q   <= '0;
    end else if (en_i) begin
      if (begins) in_frame_q <= 1'b1;
      else if (ends) in_frame_q <= 1'b0;
      if (legal) low_q <= in_frame_q && !frame;
      open_q   <= open && !wrong && !ends;
      any_q    <= any_q && !begins || data && column_q == ColumnBits'(Columns - 1);
      burst_q  <= open && !wrong && data ? burst_q + 1'b1 : '0;
      if (!open || wrong) column_q <= '0;
      else if (data) column_q <= column_q == ColumnBits'(Columns - 1) ? '0 : column_q + 1'b1;
    end
  end

`ifdef FORMAL
  // Assumptions: one reset at the beginning; when it ends, no lane is aligned.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb assume (rst_i == !f_ran_q && !(rst_i && aligned_i));

  // The word that the outputs are about, and what they have said of the words before it
  logic            f_en_q, f_aligned_q;
  logic [Bits-1:0] f_word_q;
  logic            f_legal;
  logic [12:0]     f_row_q, f_row;      // pixel words of a row, Columns at most
  logic            f_frame_q, f_frame;  // a frame has begun, and has neither ended nor been cut off
  logic [1:0]      f_lows_q, f_lows;    // legal words without frame valid in a row, 2 at most
  assign f_legal = ((f_word_q ^ Fixed[Bits-1:0]) & FixedMask[Bits-1:0]) == '0 &&
                   f_word_q[2:0] != 3'b001 && f_word_q[2:0] != 3'b010 &&
                   f_word_q[2:0] != 3'b011 && f_word_q[2:0] != 3'b101;
  assign f_row   = !f_aligned_q || cut_o ? '0 : !take_o ? f_row_q :
                   last_o ? '0 : f_row_q + 13'd1;
  assign f_frame = f_aligned_q && !cut_o &&
                   (begins_o || f_frame_q && f_lows != 2'd2);
  assign f_lows  = !f_aligned_q ? '0 : !(f_en_q && f_legal) ? f_lows_q :
                   f_word_q[2] ? '0 : f_lows_q == 2'd2 ? 2'd2 : f_lows_q + 2'd1;
  always_ff @(posedge clk_i) begin
    f_en_q      <= en_i && !rst_i;
    f_aligned_q <= aligned_i && !rst_i;
    if (en_i) f_word_q <= word_i;
    f_row_q   <= rst_i ? '0 : f_row;
    f_frame_q <= !rst_i && f_frame;
    f_lows_q  <= rst_i ? '0 : f_lows;
  end

  always_comb if (f_ran_q) begin
    // Rule 1: nothing comes without a word. A frame begins only with frame valid, after two words
    // without.
    if (!f_en_q) assert (!decoded_o && !begins_o && !take_o);
    if (begins_o) assert (f_aligned_q && f_legal && f_word_q[2] && f_lows_q == 2'd2);
    // Rule 2: pixel words have all three flags and lie in a frame. A row has Columns of them.
    if (take_o) assert (f_aligned_q && f_legal && f_word_q[0] && (begins_o || f_frame_q));
    if (take_o) assert (last_o == (f_row_q == 13'(Columns - 1)));
    // Rule 3: a word that is not legal is noticed, and ends row and frame. So do, in a row, a word
    // without frame valid and the loss of a lane.
    assert (illegal_o == (f_en_q && !f_legal));
    if (f_en_q && f_aligned_q && !f_legal) assert (bad_o && !take_o && cut_o == f_frame_q);
    if (f_en_q && f_row_q != '0 && !f_word_q[2]) assert (cut_o);
    if (f_frame_q && !f_aligned_q) assert (cut_o);
    // Rule 4: only what has begun is cut off, and each frame once.
    if (cut_o) assert (f_frame_q && !take_o);
    // The registers agree with that.
    assert (open_q == f_frame && 13'(column_q) == f_row && f_row < 13'(Columns));
    assert (f_lows == (in_frame_q ? 2'(low_q) : 2'd2));
    assert (open_q ? in_frame_q : column_q == '0);
    assert (burst_q <= BurstBits'(Burst) && (burst_q == '0 || open_q));
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    cover (take_o && last_o);
    cover (cut_o && illegal_o);
    cover (f_frame_q && !f_frame && f_aligned_q && !cut_o);
  end
`endif

endmodule

`default_nettype wire
