// Judges the columns of a frame as their moments come: above, below, unlit or good, without a
// division.
//
//   above  128 M1 < (low + d) M0      below  128 M1 > (high + d) M0      unlit  M0 = 0
//
// low and high stand in a table with a word {judged, high, low} for each column, in banks and
// sections. Column c has the word of column c - s; where there is none it is not judged. s is
// shift_columns_i, d is -shift_rows_i in 1/128 rows.
//
// From start_i on the limits of the frame are composed, one column a clock: they go from the table
// to four small memories, one for each lane of a beat, with both shifts in them. A limit below 0
// becomes 0, and one that is too great for its bits the greatest. That changes nothing, because
// rows are 1 to MaxRows. Columns that are not judged get the limits 0 and the greatest, so they are
// never out.
//
// Input: the payload beats of sp_column_moments or sp_column_runs, in order, before a division:
// four columns in mode binary, two in the grey modes. start_i begins a frame, in any clock that is
// two or more after the last beat or the break of a frame that was judged; a start_i before ready_o
// takes the place of the one before. groups_i counts at start_i; bank, section, shifts and mode
// stand still from then to the frame's last beat. The first beat comes two clocks after ready_o or
// later. break_i ends a frame before its last group is whole: it comes after ready_o, with or after
// the last beat that came. Limits are written at any time to a bank and section that is not in
// force.
//
// Output: ready_o comes 4 groups_i + 5 clocks after start_i. Groups of four columns come in order,
// four clocks after their beat, in the grey modes after the second of their two beats. The half of
// a group that a break cuts off does not leave. done_o comes with the last group of a frame, or
// five clocks after its break, with whole_o = 0. Nothing overflows: products have all their bits.
//
//   composing                                   judging
//   place             <c>----------------       beat_valid_i  /1\____________________
//   master            ----<c>------------       limits_q      <l>--------------------
//   word_*_q          --------<c>--------       s1_*_q        ----<m>----------------
//   moved_*_q         ------------<c>----       s2_*_q        --------<p>------------
//   low_q, high_q     ----------------<c>       s3_*_q        ------------<c>--------
//   {group_q, lane_q} <c> …          <c+4>      group_valid_o ________________/1\____
`default_nettype none

module sp_verdict_columns #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 8..4096
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 2..1023
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
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

  output logic                        ready_o,         // for beats
  output logic                        group_valid_o,
  output logic      [3:0]             above_o,   // a bit for each column, the leftmost lowest
  output logic      [3:0]             below_o,
  output logic      [3:0]             unlit_o,   // judged and without light
  output logic      [3:0]             lit_o,     // with light, judged or not
  output logic                        done_o,    // the frame is over
  output logic                        whole_o    // and all of it came
);

  if (MaxColumns < 8 || MaxColumns > sp_spec_pkg::ColumnLimit || MaxColumns % 4 != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_4_in_8_to_4096 u_error ();
  end
  if (MaxRows < 2 || MaxRows > sp_spec_pkg::MaxRows) begin : gen_max_rows
    max_rows_is_not_in_2_to_1023 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end
  if (LogSections < 0 || LogSections > 6) begin : gen_log_sections
    log_sections_is_not_in_0_to_6 u_error ();
  end

  localparam int MaxWeight = Grey ? 2 ** PixelBits - 1 : 1;
  localparam int M0Bits = $clog2(MaxWeight * MaxRows + 1);
  localparam int M1Bits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1);
  localparam int ProductBits = M0Bits + LimitBits;
  localparam int WordBits = 2 * LimitBits + 1;
  // Of a column of the table, or of one as far beside it as columns may be shifted, which is beyond
  // the last one then, or below 0 and so far beyond it
  localparam int PlaceBits = (ColumnBits > 8 ? ColumnBits : 8) + 1;
  localparam int MovedBits = (LimitBits > 14 ? LimitBits : 14) + 2;  // of a limit plus d
  localparam int TableBits = LogSections + 3 + GroupBits;  // {bank, section, column}

  // --- Where the frame stands. The limits of group g lie at the address g + 1. ---
  logic                  composing_q;
  logic [ColumnBits-3:0] groups_q;     // of a line
  logic [ColumnBits-3:0] group_q;      // of the word that is composed, or of that to be read next
  logic [1:0]            lane_q;       // of the word that is composed
  logic                  composed;     // the last one
  logic                  second_q;     // read those of the second group, after the first one's
  logic                  read;         // read the limits of a group
  logic                  half_q;       // the second two columns of a group
  // the group that comes next, that after it, is the last one
  logic                  last_q, last_next_q;
  logic                  grey, group_end, break_q;

  assign grey      = Grey && grey_i;
  assign group_end = !grey || half_q;
  assign composed  = composing_q && lane_q == 2'd3 && group_q == groups_q;
  assign read      = ready_o || second_q || beat_valid_i && group_end;

  always_ff @(posedge clk_i) begin
    if (rst_i) {composing_q, ready_o, second_q} <= 3'b000;
    else begin
      composing_q <= start_i || composing_q && !composed;
      ready_o     <= composed && !start_i;
      second_q    <= ready_o && !start_i;
    end
  end
  always_ff @(posedge clk_i) begin
    if (start_i) begin
      groups_q <= groups_i;
      group_q  <= '0;
      lane_q   <= '0;
      half_q   <= 1'b0;
    end else begin
      if (composed) group_q <= (ColumnBits - 2)'(1);
      else if (read || composing_q && lane_q == 2'd3) group_q <= group_q + (ColumnBits - 2)'(1);
      if (composing_q) lane_q <= lane_q + 2'd1;
      if (beat_valid_i) half_q <= grey && !half_q;
    end
    if (read) {last_q, last_next_q} <= {last_next_q, group_q == groups_q};
  end

  // --- Composing: a word of the table, moved, four clocks after its place ---
  logic [PlaceBits-1:0]        place;
  logic [TableBits-1:0]        read_at, write_at;
  logic [WordBits-1:0]         master;
  logic                        there_q, word_there_q;  // the table has this word
  logic                        word_judged, word_judged_q, moved_judged_q, judged_q;
  logic [LimitBits-1:0]        word_low_q, word_high_q, moved_low_q, moved_high_q, low_q, high_q;
  logic        [MovedBits-1:0] low, high;  // in two's complement
  logic                        low_over_q, high_over_q;
  logic                        unused;

  // Whether a limit has more bits than it may have
  function automatic logic over(input logic [MovedBits-1:0] limit);
    over = limit >> LimitBits != '0;
  endfunction

  assign word_judged = word_judged_q && word_there_q;
  assign place = PlaceBits'({group_q, lane_q}) -
                 {{(PlaceBits - 8){shift_columns_i[7]}}, shift_columns_i};
  assign low   = MovedBits'(word_low_q) -
                 {{(MovedBits - 14){shift_rows_i[13]}}, shift_rows_i};
  assign high  = MovedBits'(word_high_q) -
                 {{(MovedBits - 14){shift_rows_i[13]}}, shift_rows_i};
  if (LogSections > 0) begin : gen_sections
    assign read_at  = {bank_i, section_i, place[GroupBits+1:0]};
    assign write_at = {write_bank_i, write_section_i, write_column_i};
    assign unused   = ^beat_data_i;
  end else begin : gen_one_section
    assign read_at  = {bank_i, place[GroupBits+1:0]};
    assign write_at = {write_bank_i, write_column_i};
    assign unused   = ^{beat_data_i, section_i[0], write_section_i[0]};
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
    .rd_en_i  (1'b1),
    .rd_addr_i(read_at),
    .rd_data_o(master)
`ifdef FORMAL
    ,
    .f_addr_i ('0),
    .f_word_o (),
    .f_first_o()
`endif
  );

  always_ff @(posedge clk_i) begin
    there_q <= place < PlaceBits'(MaxColumns);

    // Directly from the memory, which is slow
    {word_judged_q, word_high_q, word_low_q} <= master;
    word_there_q                             <= there_q;

    moved_judged_q <= word_judged;
    moved_low_q    <= low[LimitBits-1:0];
    low_over_q     <= over(low);
    if (low[MovedBits-1] || !word_judged) {low_over_q, moved_low_q} <= '0;
    moved_high_q   <= high[LimitBits-1:0];
    high_over_q    <= over(high) || !word_judged;
    if (high[MovedBits-1] && word_judged) {high_over_q, moved_high_q} <= '0;

    judged_q <= moved_judged_q;
    low_q    <= low_over_q ? '1 : moved_low_q;
    high_q   <= high_over_q ? '1 : moved_high_q;
  end

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
        open_q <= 1'b0;
      end else if (ready_o) begin
        open_q <= 1'b1;
      end else if (beat_valid_i && group_end && last_q || open_q && break_q) begin
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
      localparam int Word = 64 * (lane % 2);
      localparam int M0Lsb = Word + (PixelBits > 8 ? sp_spec_pkg::WideGreyM0Lsb : sp_spec_pkg::GreyM0Lsb);
      localparam int M1Lsb = Word + (PixelBits > 8 ? sp_spec_pkg::WideGreyM1Lsb : sp_spec_pkg::GreyM1Lsb);
      assign s0_came = !grey || half_q == (lane > 1);
      assign s0_m0   = grey ?
          beat_data_i[M0Lsb+:M0Bits] :
          M0Bits'(beat_data_i[32*lane+sp_spec_pkg::BinaryRunM0Lsb+:sp_spec_pkg::BinaryRunM0Bits]);
      assign s0_m1   = grey ?
          beat_data_i[M1Lsb+:M1Bits] :
          M1Bits'(beat_data_i[32*lane+sp_spec_pkg::BinaryRunM1Lsb+:sp_spec_pkg::BinaryRunM1Bits]);
    end else begin : gen_binary
      assign s0_came = 1'b1;
      assign s0_m0   = beat_data_i[32*lane+sp_spec_pkg::BinaryRunM0Lsb+:M0Bits];
      assign s0_m1   = beat_data_i[32*lane+sp_spec_pkg::BinaryRunM1Lsb+:M1Bits];
    end

    // Its limits: those of this group in a register, those of the next one behind the memory,
    // which is slow
    logic [WordBits-1:0] limits, limits_q;
    sp_ram #(
      .Width   (WordBits),
      .LogDepth(GroupBits)
    ) u_limits (
      .wr_clk_i (clk_i),
      .wr_en_i  (composing_q && lane_q == 2'(lane)),
      .wr_addr_i(group_q[GroupBits-1:0]),
      .wr_data_i({judged_q, high_q, low_q}),
      .rd_clk_i (clk_i),
      .rd_en_i  (read),
      .rd_addr_i(group_q[GroupBits-1:0]),
      .rd_data_o(limits)
`ifdef FORMAL
      ,
      .f_addr_i ('0),
      .f_word_o (),
      .f_first_o()
`endif
    );

    // Products and comparisons. 128 M1 ends in seven zeros, so of the last seven bits of a product
    // it only matters whether they are 0, and only for the lower limit.
    logic                   s1_came_q, s2_came_q;
    logic [M0Bits-1:0]      s1_m0_q;
    logic [M1Bits-1:0]      s1_m1_q, s2_m1_q;
    logic [LimitBits-1:0]   s1_low_q, s1_high_q;
    logic                   s1_judged_q, s2_judged_q, s2_lit_q;
    logic [ProductBits-1:0] s2_low_q, s2_high_q;
    logic [ProductBits-6:0] s2_above;  // the borrow of a subtraction
    logic                   unused_bits;
    assign unused_bits = ^{s2_above[ProductBits-7:0], s2_high_q[6:0]};
    assign s2_above = (ProductBits - 5)'({s2_m1_q, 1'b0}) -
                      (ProductBits - 5)'({s2_low_q[ProductBits-1:7], s2_low_q[6:0] != '0});
    always_ff @(posedge clk_i) begin
      if (read) limits_q <= limits;

      s1_m0_q   <= s0_m0;
      s1_m1_q   <= s0_m1;
      s1_came_q <= s0_came;
      {s1_judged_q, s1_high_q, s1_low_q} <= limits_q;

      s2_came_q   <= s1_came_q;
      s2_judged_q <= s1_judged_q;
      s2_lit_q    <= s1_m0_q != '0;
      s2_low_q    <= s1_low_q * ProductBits'(s1_m0_q);
      s2_high_q   <= s1_high_q * ProductBits'(s1_m0_q);
      s2_m1_q     <= s1_m1_q;

      s3_came_q[lane]  <= s2_came_q;
      s3_above_q[lane] <= s2_above[ProductBits-6];
      s3_below_q[lane] <= (ProductBits - 7)'(s2_m1_q) > s2_high_q[ProductBits-1:7];
      s3_unlit_q[lane] <= s2_judged_q;
      if (s2_lit_q) s3_unlit_q[lane] <= 1'b0;
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
