// Decodes the control lane of a serial sensor of the PYTHON kind: a code in every word.
//
// The codes are those of the data sheets of onsemi (NOIP1SN025KA, tables 24 to 26; NOIP1SN5000A,
// tables 32 and 33). Words of 8 bits have the upper 8 bits of each code.
//
//   frame start  10'h2AA   line start  10'h0AA   black pixels  10'h015   training   10'h3A6
//   frame end    10'h32A   line end    10'h12A   image pixels  10'h035   check word 10'h059
//
// The word behind each of the four in the left columns identifies the window, 0 to 15. That a frame
// or line start and the window's number come with the first two pixel words of the line, and a line
// or frame end and the number with the last two, is not in the excerpts of the data sheet that were
// at hand; an open decoder (python_decode) does it so. It also knows BlackStart, before a line of
// black pixels, and another frame end, 10'h3AA: set FrameEnd if a sensor sends that.
//
// Guarantees: a frame begins with a frame start and ends behind a frame end. Lines are the words
// from a start to the number behind an end, an even count. take_o marks each pixel word of a frame
// that began while aligned_i was high, last_o the last one of its line, check_o the check word behind
// such a line. Lines of black pixels are left out.
//
// Broken input: a word that is no code where one must be, or a code at a wrong place. Each makes
// bad_o high; a word that is no code, illegal_o too. The rest of the frame is left out, and cut_o is
// high once. The same comes, without bad_o, if aligned_i falls within a frame. Faults of order in the
// rest are not counted again. A frame start between the lines of a frame ends that and begins the
// next one; bad_o is high.
//
// Latency: the outputs are pulses one clock after en_i.
//
//   word       <TR ><FS ><0  ><IMG><IMG><FE ><0  ><CRC><TR >
//   begins_o   _________/111\_______________________________
//   take_o     _________/11111111111111111111111111111\_____
//   last_o     __________________________________/111\______
`default_nettype none

module sp_lvds_codes #(
  parameter int Bits = 10,  // of a word: 8 or 10
  parameter logic [9:0] FrameStart = 10'h2AA,
  parameter logic [9:0] FrameEnd = 10'h32A,
  parameter logic [9:0] LineStart = 10'h0AA,
  parameter logic [9:0] LineEnd = 10'h12A,
  parameter logic [9:0] BlackStart = 10'h22A,
  parameter logic [9:0] Black = 10'h015,
  parameter logic [9:0] Image = 10'h035,
  parameter logic [9:0] Check = 10'h059,
  parameter logic [9:0] Train = 10'h3A6
) (
  input  wire logic            clk_i,
  input  wire logic            rst_i,      // active high, synchronous
  input  wire logic            en_i,       // a control word
  input  wire logic [Bits-1:0] word_i,
  input  wire logic            aligned_i,  // all lanes are aligned
  output logic                 decoded_o,  // a word was decoded
  output logic                 illegal_o,  // it is no code
  output logic                 idle_o,     // the data lanes carry training words with it
  output logic                 begins_o,   // a frame begins, with its first word
  output logic                 take_o,     // a pixel word
  output logic                 last_o,     // the last one of its line
  output logic                 check_o,    // the check word behind a line that was taken
  output logic                 cut_o,      // the rest of the frame is lost
  output logic                 bad_o       // something is wrong
);

  if (Bits != 8 && Bits != 10) begin : gen_bits
    bits_is_not_8_or_10 u_error ();
  end

  logic frame_start, frame_end, line_start, line_end, black_start, black, pixels, check, train;
  logic number, start, finish, code;
  logic open_q;    // the frame is taken
  logic line_q;    // within a line of pixels
  logic dark_q;    // within a line of black pixels
  logic mark_q;    // the last word was a start or an end, at its place or not
  logic number_q;  // the window's number must come
  logic last_q;    // and it ends the line
  logic end_q;     // and the frame
  logic odd_q;     // the line has an odd number of words
  logic taken_q;   // the last word was the last one of a line that was taken
  logic open, fits, wrong, take;

  assign frame_start = word_i == FrameStart[9-:Bits];
  assign frame_end   = word_i == FrameEnd[9-:Bits];
  assign line_start  = word_i == LineStart[9-:Bits];
  assign line_end    = word_i == LineEnd[9-:Bits];
  assign black_start = word_i == BlackStart[9-:Bits];
  assign black       = word_i == Black[9-:Bits];
  assign pixels      = word_i == Image[9-:Bits];
  assign check       = word_i == Check[9-:Bits];
  assign train       = word_i == Train[9-:Bits];
  if (Bits == 10) begin : gen_number
    assign number = word_i[Bits-1:4] == '0;
  end else begin : gen_number_of_8
    assign number = word_i[Bits-1] == 1'b0 && word_i[1:0] == 2'b00;  // in bits 6..2
  end
  assign start  = frame_start || line_start || black_start;
  assign finish = frame_end || line_end;
  assign code   = start || finish || black || pixels || check || train || number && mark_q;

  // Where the word may come
  assign fits = number_q ? number :
                line_q ? pixels || finish :
                dark_q ? black || pixels || finish :
                start || train || check;
  assign open  = open_q || frame_start && fits;
  assign wrong = !fits || line_q && last_q && !odd_q;
  assign take  = !wrong && (line_q || open && (frame_start || line_start));

  always_ff @(posedge clk_i) begin
    decoded_o <= en_i && !rst_i;
    illegal_o <= en_i && !code && !rst_i;
    idle_o    <= en_i && train;
    begins_o  <= en_i && frame_start && fits && aligned_i && !rst_i;
    take_o    <= en_i && take && aligned_i;
    last_o    <= en_i && last_q;
    check_o   <= en_i && check && taken_q && aligned_i;
    cut_o     <= !rst_i && open_q && (!aligned_i || en_i && wrong);
    bad_o     <= en_i && aligned_i && (!code || open_q && (wrong || frame_start)) && !rst_i;
    if (en_i) taken_q <= take && last_q;
    if (en_i) mark_q <= start || finish;
    if (rst_i || !aligned_i) {open_q, line_q, dark_q, number_q, last_q, end_q} <= '0;
    else if (en_i) begin
      if (wrong) {open_q, line_q, dark_q, number_q, last_q, end_q} <= '0;
      else begin
        open_q <= open && !end_q;
        if (start) begin
          line_q <= frame_start || line_start && open;
          dark_q <= !(frame_start || line_start && open);
        end else if (last_q) {line_q, dark_q} <= '0;
        number_q <= start || finish;
        last_q   <= finish;
        end_q    <= frame_end;
      end
      odd_q <= start ? 1'b1 : !odd_q;
    end
  end

`ifdef FORMAL
  // Assumptions: one reset at the beginning; when it ends, no lane is aligned.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb assume (rst_i == !f_ran_q && !(rst_i && aligned_i));

  // The word that the outputs are about, and what they have said of the words before it
  logic            f_en_q, f_aligned_q;
  logic [Bits-1:0] f_word_q, f_before_q;
  logic            f_row_q, f_row;      // pixel words of a row came, and the last one has not
  logic            f_odd_q, f_odd;      // an odd number of them
  logic            f_frame_q, f_frame;  // a frame has begun, and has neither ended nor been cut off
  assign f_row   = f_aligned_q && !cut_o && (f_en_q ? take_o && !last_o : f_row_q);
  assign f_odd   = f_en_q ? take_o && !(f_row_q && f_odd_q) : f_odd_q;
  assign f_frame = f_aligned_q && !cut_o &&
                   (f_en_q ? begins_o || f_frame_q && f_before_q != FrameEnd[9-:Bits] : f_frame_q);
  always_ff @(posedge clk_i) begin
    f_en_q      <= en_i && !rst_i;
    f_aligned_q <= aligned_i && !rst_i;
    if (en_i) {f_before_q, f_word_q} <= {f_word_q, word_i};
    {f_row_q, f_odd_q, f_frame_q} <= {f_row, f_odd, f_frame} & {3{!rst_i}};
  end

  always_comb if (f_ran_q) begin
    // Rule 1: nothing comes without a word. A frame begins only with its code.
    if (!f_en_q) assert (!decoded_o && !begins_o && !take_o && !check_o);
    if (begins_o) assert (f_aligned_q && take_o && f_word_q == FrameStart[9-:Bits]);
    // Rule 2: a row begins only with its code, and in a frame. It has an even number of words.
    if (take_o && !f_row_q)
      assert (f_word_q == FrameStart[9-:Bits] || f_word_q == LineStart[9-:Bits]);
    if (take_o) assert (f_aligned_q && (begins_o || f_frame_q));
    if (take_o && last_o) assert (f_row_q && f_odd_q);
    // Rule 3: a word that is no code is noticed, and ends row and frame. So does, in a row, each
    // word that is not taken, and the loss of a lane.
    if (f_en_q && f_aligned_q && illegal_o) assert (bad_o && !take_o && cut_o == f_frame_q);
    if (f_row_q && f_en_q && !take_o) assert (cut_o);
    if (f_frame_q && !f_aligned_q) assert (cut_o);
    // Rule 4: only what has begun is cut off, and each frame once.
    if (cut_o) assert (f_frame_q && !take_o);
    // The registers agree with that.
    assert (line_q == f_row && open_q == f_frame);
    assert ((!line_q || open_q && odd_q == f_odd) && !(line_q && dark_q));
    assert ((!end_q || last_q) && (!last_q || number_q) && (!number_q || mark_q));
    if (open_q) assert (end_q == (f_word_q == FrameEnd[9-:Bits]));
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    cover (take_o && last_o && f_frame_q);
    cover (cut_o && illegal_o);
    cover (begins_o && f_frame_q);
  end
`endif

endmodule

`default_nettype wire
