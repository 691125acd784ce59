// Packs the lines of an image, raw or of codes, into 16-byte payload beats: leftmost pixel in the
// lowest byte, zeros after the last pixel. A line is sent once it is complete.
//
// The words of a line wait in a ring of at least two lines, so that lines may follow each other
// without a gap. line_done_o asks for a packet when the line has ended or broken. After accept_i
// the words leave, one per clock. A line that broke leaves with the words that it has, followed by
// words_break_o. A beat of 16 codes has two words: they lie in the ring as one, lower half first,
// and a line takes twice as long to leave as to come in.
//
// Timing: line_done_o comes one clock after the last beat of the line, or in the clock of break_i.
// accept_i is read three clocks later. The words leave from seven clocks after line_done_o on.
`default_nettype none

module sp_image_packer #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4; of Lanes
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 1 or more
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  parameter int PixelBytes = 1,  // 1 or 2: pixels of 8 bits, or codes of 16
  // derived, do not set
  parameter int BeatBits = 8 * PixelBytes * Lanes,
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int WordBits = $clog2(MaxColumns * PixelBytes / 16 + 2),
  parameter int LogDepth =
    MaxColumns * PixelBytes > 256 ? $clog2(MaxColumns / 8 * PixelBytes) : 5
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // Beats of sp_frame_tracker
  input  wire logic                  image_i,  // the image of this frame is wanted
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic                  beat_valid_i,
  input  wire logic [BeatBits-1:0]   beat_pixels_i,
  input  wire logic [1:0]            beat_group_i,  // low bits of the group
  input  wire logic [RowBits-1:0]    beat_row_i,
  input  wire logic                  beat_line_start_i,
  input  wire logic                  beat_line_end_i,
  input  wire logic                  break_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0] break_status_i,

  // Packets
  output logic                       line_done_o,
  output logic      [WordBits-1:0]   line_words_o,   // of the whole line
  output logic      [RowBits-1:0]    line_row_o,
  output logic [sp_spec_pkg::StatusBits-1:0] line_status_o,
  input  wire logic                  accept_i,

  output logic                       words_valid_o,
  output logic      [127:0]          words_data_o,
  output logic                       words_break_o
);

  if (MaxColumns < Lanes || MaxColumns % Lanes != 0) begin : gen_max_columns
    max_columns_is_not_a_multiple_of_lanes u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end
  if (MaxRows < 1) begin : gen_max_rows
    max_rows_is_less_than_1 u_error ();
  end
  if (PixelBytes != 1 && PixelBytes != 2) begin : gen_pixel_bytes
    pixel_bytes_is_not_1_or_2 u_error ();
  end

  localparam int RingBits = BeatBits > 128 ? BeatBits : 128;
  localparam int Parts = RingBits / 128;  // words of an entry of the ring: 1 or 2

  logic                line_open_q;
  logic                line_ended_q;  // the last beat of a line was one clock ago
  logic                breaks;
  logic                valid;
  logic [WordBits-1:0] line_words_q;

  assign valid         = beat_valid_i && image_i;
  assign breaks        = break_i && line_open_q;
  assign line_done_o   = line_ended_q || breaks;
  assign line_status_o = breaks ? break_status_i : '0;
  assign line_words_o  = line_words_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      line_open_q  <= 1'b0;
      line_ended_q <= 1'b0;
    end else begin
      line_ended_q <= valid && beat_line_end_i;
      if (valid) line_open_q <= !beat_line_end_i;
      else if (break_i) line_open_q <= 1'b0;
    end
    if (valid && beat_line_start_i) begin
      line_words_q <= WordBits'((32'(columns_i) * PixelBytes + 32'd12) >> 4);
      line_row_o   <= beat_row_i;
    end
  end

  // --- Words into the ring: a word is written one clock after its last beat; an incomplete word,
  // or the last one, in the clock in which its line is done ---
  logic [95:0]         gathered_q;  // the beats of a word but the last, zeros above
  logic                partial_q;   // gathered_q holds beats not yet written
  logic                whole_q;     // word_q waits to be written
  logic [RingBits-1:0] word_q;
  logic                write, last_of_word;
  logic [LogDepth-1:0] wr_ptr_q, next_ptr;
  logic [LogDepth-1:0] line_ptr_q;  // where the line begins
  logic [WordBits-1:0] count_q, next_count;

  assign write      = whole_q || line_done_o && partial_q;
  assign next_ptr   = wr_ptr_q + LogDepth'(write);
  assign next_count = count_q + WordBits'(write);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      partial_q  <= 1'b0;
      whole_q    <= 1'b0;
      wr_ptr_q   <= '0;
      line_ptr_q <= '0;
      count_q    <= '0;
    end else begin
      whole_q <= valid && last_of_word;
      if (valid) partial_q <= !last_of_word;
      else if (line_done_o) partial_q <= 1'b0;
      wr_ptr_q <= next_ptr;
      count_q  <= line_done_o ? '0 : next_count;
      if (line_done_o) line_ptr_q <= next_ptr;
    end
  end

  if (BeatBits == 32) begin : gen_four_beats
    assign last_of_word = beat_group_i == 2'd3;

    always_ff @(posedge clk_i) begin
      if (valid) begin
        case (beat_group_i)
          2'd0:    gathered_q <= {64'd0, beat_pixels_i};
          2'd1:    gathered_q[63:32] <= beat_pixels_i;
          2'd2:    gathered_q[95:64] <= beat_pixels_i;
          default: word_q <= {beat_pixels_i, gathered_q};
        endcase
      end
    end
  end else if (BeatBits == 64) begin : gen_two_beats
    assign last_of_word = beat_group_i[0];

    always_ff @(posedge clk_i) begin
      if (valid && !last_of_word) gathered_q <= {32'd0, beat_pixels_i};
      if (valid && last_of_word) word_q <= {beat_pixels_i, gathered_q[63:0]};
    end

    logic unused;
    assign unused = beat_group_i[1];
  end else begin : gen_one_beat
    assign last_of_word = 1'b1;
    assign gathered_q   = '0;

    always_ff @(posedge clk_i) if (valid) word_q <= beat_pixels_i;

    logic unused;
    assign unused = ^beat_group_i;
  end

  // --- Words out of the ring: those of a line whose packet was accepted ---
  logic [3:1]          done_q;
  logic [LogDepth-1:0] ptr1_q, ptr2_q, ptr3_q;
  logic [WordBits-1:0] count1_q, count2_q, count3_q;
  logic [3:1]          broken_q;
  logic                go_q;
  logic                reading_q, read_q;
  logic                part_q;     // the half that is due of the entry
  logic                part1_q;    // the half of entry_read that is word_read
  logic                last_part;  // this is the last of its entry
  logic                last_word;
  logic [LogDepth-1:0] rd_ptr_q;
  logic [WordBits-1:0] left_q;  // entries
  logic                line_broken_q, break_read_q;
  logic [RingBits-1:0] entry_read;
  logic [127:0]        word_read;

  if (Parts == 1) begin : gen_whole
    assign {part_q, part1_q} = 2'b00;
    assign last_part         = 1'b1;
    assign word_read         = entry_read;
    logic unused;
    assign unused = part_q ^ part1_q;
  end else begin : gen_halves
    always_ff @(posedge clk_i) begin
      part_q  <= reading_q && !part_q;
      part1_q <= part_q;
    end
    assign last_part = part_q;
    assign word_read = part1_q ? entry_read[128+:128] : entry_read[127:0];
  end

  assign last_word = left_q == WordBits'(1) && last_part;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      done_q        <= '0;
      go_q          <= 1'b0;
      reading_q     <= 1'b0;
      read_q        <= 1'b0;
      break_read_q  <= 1'b0;
      words_valid_o <= 1'b0;
      words_break_o <= 1'b0;
    end else begin
      done_q <= {done_q[2:1], line_done_o};
      go_q   <= done_q[3] && accept_i;
      if (go_q) reading_q <= 1'b1;
      else if (last_word) reading_q <= 1'b0;
      read_q        <= reading_q;
      break_read_q  <= reading_q && last_word && line_broken_q;
      words_valid_o <= read_q;
      words_break_o <= break_read_q;
    end
  end

  always_ff @(posedge clk_i) begin
    {ptr1_q, count1_q} <= {line_ptr_q, next_count};
    {ptr2_q, count2_q} <= {ptr1_q, count1_q};
    {ptr3_q, count3_q} <= {ptr2_q, count2_q};
    broken_q <= {broken_q[2:1], breaks};
    if (read_q) words_data_o <= word_read;
    if (done_q[3] && accept_i) begin
      rd_ptr_q      <= ptr3_q;
      left_q        <= count3_q;
      line_broken_q <= broken_q[3];
    end else if (reading_q && last_part) begin
      rd_ptr_q <= rd_ptr_q + LogDepth'(1);
      left_q   <= left_q - WordBits'(1);
    end
  end

  // A line is read at once when it is accepted. At the earliest, the line after the next overwrites
  // it. Where an entry has two words a line takes twice as long to leave: the ring has room for four.
  sp_ram #(
    .Width   (RingBits),
    .LogDepth(LogDepth)
  ) u_ring (
    .wr_clk_i (clk_i),
    .wr_en_i  (write),
    .wr_addr_i(wr_ptr_q),
    .wr_data_i(whole_q ? word_q : RingBits'({32'd0, gathered_q})),
    .rd_clk_i (clk_i),
    .rd_en_i  (reading_q && !part_q),
    .rd_addr_i(rd_ptr_q),
    .rd_data_o(entry_read)
  );

endmodule

`default_nettype wire
