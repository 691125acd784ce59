// Judges the columns of a frame as their moments come: above, below, unlit or good, without a
// division.
//
//   above  128 M1 - d M0 < low M0      below  128 M1 - d M0 > high M0      unlit  M0 = 0
//
// low and high stand in a table with a word {judged, high, low} for each column, in banks and
// sections. Column c has the word of column c - s; where there is none it is not judged. s is
// shift_columns_i, d is -shift_rows_i in 1/128 rows.
//
// Each lane of the beat has a memory of its own with the whole table, so that a word is written
// into all four. In lane l, column c has the turn (l - c) modulo 4, which is part of its address:
// with the shift s the lane reads the words of turn s modulo 4, one after another. So no word and
// no moment has to change its lane, however far columns are shifted.
//
// Input: the payload beats of sp_column_moments or sp_column_runs, in order, before a division:
// four columns in mode binary, two in the grey modes. start_i begins a frame, three clocks or more
// before its first beat, and two or more after the last beat or the break of the frame before.
// groups_i counts at start_i; bank, section, shifts and mode stand still from then to the frame's
// last beat. break_i ends a frame before its last group is whole: it comes with or after the last
// beat that came, and never with start_i. Limits are written at any time to a bank and section
// that is not in force.
//
// Output: groups of four columns, in order, four clocks after their beat, in the grey modes after
// the second of their two beats. The half of a group that a break cuts off does not leave.
// done_o comes with the last group of a frame, or five clocks after its break, with whole_o = 0.
// Nothing overflows: products have all their bits.
//
//   clock         0   1   2   3   4   5
//   beat_valid_i  /1\____________________
//   table word    <w>--------------------     read ahead, when beats before it came
//   products      --------<p>------------
//   compared      ------------<c>--------
//   group_valid_o ________________/1\____
`default_nettype none

module sp_verdict_columns #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 8..2048
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 2..1023
  parameter bit Grey = 1'b1,  // modes grey and grey_over
  parameter int LogSections = 1,  // log2 of the sections of a bank: 0..6
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / 4),
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int LimitBits = $clog2(MaxRows + 1) + 7,
  parameter int SectionBits = LogSections > 0 ? LogSections : 1
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  // The table
  input  wire logic                   write_i,
  input  wire logic                   write_bank_i,
  input  wire logic [SectionBits-1:0] write_section_i,
  input  wire logic [GroupBits+1:0]   write_column_i,  // from 0
  input  wire logic [2*LimitBits:0]   write_word_i,    // {judged, high, low}, in 1/128 rows

  // A frame
  input  wire logic                   start_i,
  input  wire logic [ColumnBits-3:0]  groups_i,        // of a line: columns / 4
  input  wire logic                   grey_i,          // two columns a beat
  input  wire logic                   bank_i,
  input  wire logic [SectionBits-1:0] section_i,
  input  wire logic [7:0]             shift_columns_i,  // s, in two's complement
  input  wire logic [13:0]            shift_rows_i,     // -d, in two's complement

  // Its moments
  input  wire logic                   beat_valid_i,
  input  wire logic [127:0]           beat_data_i,
  input  wire logic                   break_i,

  output logic                        group_valid_o,
  output logic      [3:0]             above_o,   // a bit for each column, the leftmost lowest
  output logic      [3:0]             below_o,
  output logic      [3:0]             unlit_o,   // judged and without light
  output logic      [3:0]             lit_o,     // with light, judged or not
  output logic                        done_o,    // the frame is over
  output logic                        whole_o    // and all of it came
);

  if (MaxColumns < 8 || MaxColumns > sp_spec_pkg::MaxColumns || MaxColumns % 4 != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_4_in_8_to_2048 u_error ();
  end
  if (MaxRows < 2 || MaxRows > sp_spec_pkg::MaxRows) begin : gen_max_rows
    max_rows_is_not_in_2_to_1023 u_error ();
  end
  if (LogSections < 0 || LogSections > 6) begin : gen_log_sections
    log_sections_is_not_in_0_to_6 u_error ();
  end

  localparam int M0Bits = $clog2((Grey ? 255 : 1) * MaxRows + 1);
  localparam int M1Bits = $clog2((Grey ? 255 : 1) * MaxRows * (MaxRows + 1) / 2 + 1);
  localparam int ProductBits = M0Bits + LimitBits;
  localparam int XBits = M0Bits + (LimitBits > 13 ? LimitBits : 13) + 2;  // 128 M1 - d M0, signed
  localparam int WordBits = 2 * LimitBits + 1;
  localparam int Groups = MaxColumns / 4;
  // Of a group of the table, or of one as far beside it as columns may be shifted; signed
  localparam int PlaceBits = (GroupBits > 5 ? GroupBits : 5) + 2;
  localparam int TableBits = LogSections + 3 + GroupBits;  // {bank, section, turn, group}

  // --- Stage 0: where a beat stands, and which words of the table are its. A memory is slow, so there
  // is a register behind it, which holds the words of this group; the memory those of the next. ---
  logic                        half_q;     // the second two columns of a group
  logic                        last_group;
  logic [ColumnBits-3:0]       left_q;     // groups to come behind this one
  logic                        first_q, second_q;  // read the words of the first two groups
  logic                        read;               // read the words of a group
  // Of the group whose words are read next, less s / 4, which is rounded down; one before. Two
  // registers, because a subtraction before the comparisons is slow.
  logic signed [PlaceBits-1:0] place_q, before_q;
  logic                        place_in, before_in;    // the table has these groups
  logic                        grey, group_end, break_q;
  logic [1:0]                  turn;       // s modulo 4

  assign grey      = Grey && grey_i;
  assign group_end = !grey || half_q;
  assign turn      = shift_columns_i[1:0];

  assign read      = first_q || second_q || beat_valid_i && group_end;

  always_ff @(posedge clk_i) begin
    {second_q, first_q} <= {first_q, start_i};
    if (start_i) begin
      half_q   <= 1'b0;
      left_q   <= groups_i - (ColumnBits - 2)'(1);
      place_q  <= PlaceBits'(0) - {{(PlaceBits - 6){shift_columns_i[7]}}, shift_columns_i[7:2]};
      before_q <= ~{{(PlaceBits - 6){shift_columns_i[7]}}, shift_columns_i[7:2]};  // -s / 4 - 1
    end else begin
      if (beat_valid_i) half_q <= grey && !half_q;
      if (beat_valid_i && group_end) left_q <= left_q - (ColumnBits - 2)'(1);
      if (read) {place_q, before_q} <= {place_q + PlaceBits'(1), place_q};
    end
  end
  assign place_in   = place_q >= 0 && place_q < PlaceBits'(Groups);
  assign before_in  = before_q >= 0 && before_q < PlaceBits'(Groups);
  assign last_group   = left_q == '0;

  logic unused;
  assign unused = ^{beat_data_i, place_q[PlaceBits-1:GroupBits], before_q[PlaceBits-1:GroupBits]};

  // --- Stages 1 to 3 ---
  logic       open_q;         // a frame has begun and is not over
  logic [3:1] valid_q, group_end_q, done_q, whole_q;
  logic [3:0] s3_above_q, s3_below_q, s3_unlit_q, s3_lit_q, s3_came_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      open_q  <= 1'b0;
      break_q <= 1'b0;
      valid_q <= '0;
      done_q  <= '0;
    end else begin
      // A break in the clock of the last beat comes too late.
      break_q   <= break_i;
      valid_q   <= {valid_q[2:1], beat_valid_i};
      done_q    <= {done_q[2:1], 1'b0};
      if (start_i) begin
        open_q <= 1'b1;
      end else if (beat_valid_i && group_end && last_group || open_q && break_q) begin
        open_q    <= 1'b0;
        done_q[1] <= 1'b1;
      end
    end
  end
  always_ff @(posedge clk_i) begin
    group_end_q <= {group_end_q[2:1], group_end};
    whole_q     <= {whole_q[2:1], !break_q};
  end

  for (genvar lane = 0; lane < 4; lane++) begin : gen_lane
    // The moments of a column, and whether the beat has one for this lane
    logic              s0_came;
    logic [M0Bits-1:0] s0_m0;
    logic [M1Bits-1:0] s0_m1;
    if (Grey) begin : gen_grey
      localparam int Wide = 64 * (lane % 2);
      assign s0_came = !grey || half_q == (lane > 1);
      assign s0_m0   = grey ?
          M0Bits'(beat_data_i[Wide+sp_spec_pkg::GreyM0Lsb+:sp_spec_pkg::GreyM0Bits]) :
          M0Bits'(beat_data_i[32*lane+sp_spec_pkg::BinaryRunM0Lsb+:sp_spec_pkg::BinaryRunM0Bits]);
      assign s0_m1   = grey ?
          M1Bits'(beat_data_i[Wide+sp_spec_pkg::GreyM1Lsb+:sp_spec_pkg::GreyM1Bits]) :
          M1Bits'(beat_data_i[32*lane+sp_spec_pkg::BinaryRunM1Lsb+:sp_spec_pkg::BinaryRunM1Bits]);
    end else begin : gen_binary
      assign s0_came = 1'b1;
      assign s0_m0   = beat_data_i[32*lane+sp_spec_pkg::BinaryRunM0Lsb+:M0Bits];
      assign s0_m1   = beat_data_i[32*lane+sp_spec_pkg::BinaryRunM1Lsb+:M1Bits];
    end

    // Its word: that of the column s columns further left, which stands in the group of the table
    // s / 4 before, or in the one before that. Column c is written to the words with turn lane - c.
    logic                 wraps;
    logic [GroupBits-1:0] place;
    logic [TableBits-1:0] read_at, write_at;
    logic [WordBits-1:0]  word;
    assign wraps = {1'b0, turn} > 3'(lane);
    assign place  = wraps ? before_q[GroupBits-1:0] : place_q[GroupBits-1:0];
    if (LogSections > 0) begin : gen_sections
      assign read_at  = {bank_i, section_i, turn, place};
      assign write_at = {write_bank_i, write_section_i, 2'(lane) - write_column_i[1:0],
                         write_column_i[GroupBits+1:2]};
    end else begin : gen_one_section
      logic unused_section;
      assign unused_section = section_i[0] ^ write_section_i[0];
      assign read_at  = {bank_i, turn, place};
      assign write_at = {write_bank_i, 2'(lane) - write_column_i[1:0],
                         write_column_i[GroupBits+1:2]};
    end

    sp_ram #(
      .Width   (WordBits),
      .LogDepth(TableBits)
    ) u_table (
      .wr_clk_i (clk_i),
      .wr_en_i  (write_i),
      .wr_addr_i(write_at),
      .wr_data_i(write_word_i),
      .rd_clk_i (clk_i),
      .rd_en_i  (read),
      .rd_addr_i(read_at),
      .rd_data_o(word)
`ifdef FORMAL
      ,
      .f_addr_i ('0),
      .f_word_o (),
      .f_first_o()
`endif
    );

    // Products, difference, comparison
    logic [WordBits-1:0]       word_q;           // of this group
    logic                      next_q, there_q;  // the table has the next word, this word
    logic                      s1_came_q, s2_came_q;
    logic [M0Bits-1:0]         s1_m0_q;
    logic [M1Bits-1:0]         s1_m1_q;
    logic signed [M0Bits+13:0] s1_moved_q;  // -d M0
    logic [LimitBits-1:0]      s1_low_q, s1_high_q;
    logic                      s1_judged_q, s2_judged_q, s2_lit_q;
    logic signed [XBits-1:0]   s2_x_q;
    logic [ProductBits-1:0]    s2_low_q, s2_high_q;
    always_ff @(posedge clk_i) begin
      if (read) begin
        word_q  <= word;
        next_q  <= wraps ? before_in : place_in;
        there_q <= next_q;
      end

      s1_m0_q     <= s0_m0;
      s1_m1_q     <= s0_m1;
      s1_moved_q  <= $signed(shift_rows_i) * $signed({1'b0, s0_m0});
      s1_came_q   <= s0_came;
      s1_judged_q <= there_q && word_q[2*LimitBits];
      s1_high_q   <= word_q[LimitBits+:LimitBits];
      s1_low_q    <= word_q[0+:LimitBits];

      s2_came_q   <= s1_came_q;
      s2_judged_q <= s1_judged_q;
      s2_lit_q    <= s1_m0_q != '0;
      s2_low_q    <= s1_low_q * ProductBits'(s1_m0_q);
      s2_high_q   <= s1_high_q * ProductBits'(s1_m0_q);
      s2_x_q      <= $signed(XBits'({s1_m1_q, 7'd0})) + XBits'(s1_moved_q);

      s3_came_q[lane]  <= s2_came_q;
      s3_above_q[lane] <= s2_judged_q && s2_lit_q && s2_x_q < $signed(XBits'(s2_low_q));
      s3_below_q[lane] <= s2_judged_q && s2_lit_q && s2_x_q > $signed(XBits'(s2_high_q));
      s3_unlit_q[lane] <= s2_judged_q && !s2_lit_q;
      s3_lit_q[lane]   <= s2_lit_q;
    end
  end

  // --- Stage 4: two beats make a group ---
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      group_valid_o <= 1'b0;
      done_o        <= 1'b0;
    end else begin
      group_valid_o <= valid_q[3] && group_end_q[3];
      done_o        <= done_q[3];
    end
  end
  always_ff @(posedge clk_i) begin
    whole_o <= whole_q[3];
    if (valid_q[3]) begin
      for (int lane = 0; lane < 4; lane++) begin
        if (s3_came_q[lane]) begin
          {above_o[lane], below_o[lane], unlit_o[lane], lit_o[lane]} <=
              {s3_above_q[lane], s3_below_q[lane], s3_unlit_q[lane], s3_lit_q[lane]};
        end
      end
    end
  end

endmodule

`default_nettype wire
