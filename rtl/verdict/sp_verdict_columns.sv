// Judges the columns of a frame as their moments come: above, below, unlit or good, without a
// division.
//
//   above  128 M1 - d M0 < low M0      below  128 M1 - d M0 > high M0      unlit  M0 = 0
//
// low and high stand in a table with a word {judged, high, low} for each column, in banks and
// sections. Column c has the word of column c - s; where there is none it is not judged. s is
// shift_columns_i, d is shift_rows_i in 1/128 rows.
//
// Input: the payload beats of sp_column_moments or sp_column_runs, in order: four columns in mode
// binary, two in the grey modes. start_i begins a frame, three clocks or more before its first
// beat and two or more after the last beat of the frame before; bank, section, shifts and mode
// stand still from then to done_o. break_i ends a frame early, in the clock of its last beat or
// later. Limits are written at any time to a bank and section that is not in force.
//
// Output: groups of four columns, in order, six clocks after their beat, in the grey modes after
// the second of their two beats. The half of a group that a break cuts off does not leave.
// done_o comes with the last group of a frame, or seven clocks after its break, with whole_o = 0.
// Nothing overflows: products have all their bits.
//
//   beat_valid_i  _/1\___________________________
//   table word    -----<w>-----------------------
//   products      -------------<p>---------------
//   group_valid_o _____________________/1\_______
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
  parameter int SectionBits = LogSections > 0 ? LogSections : 1,
  parameter int TableBits = LogSections + 1 + GroupBits
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  // The table
  input  wire logic                   write_i,
  input  wire logic [1:0]             write_lane_i,   // column modulo 4
  input  wire logic [TableBits-1:0]   write_group_i,  // {bank, section, column / 4}
  input  wire logic [2*LimitBits:0]   write_word_i,   // {judged, high, low}

  // A frame
  input  wire logic                   start_i,
  input  wire logic [ColumnBits-3:0]  groups_i,        // of a line: columns / 4
  input  wire logic                   grey_i,          // two columns a beat
  input  wire logic                   bank_i,
  input  wire logic [SectionBits-1:0] section_i,
  input  wire logic [7:0]             shift_columns_i,  // s, in two's complement
  input  wire logic [13:0]            shift_rows_i,     // d, in two's complement

  // Its moments
  input  wire logic                   beat_valid_i,
  input  wire logic [127:0]           beat_data_i,
  input  wire logic                   break_i,

  output logic                        group_valid_o,
  output logic      [GroupBits-1:0]   group_o,
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

  // --- Stage 0: where a beat stands, and which words of the table are its ---
  logic                        half_q;     // the second two columns of a group
  logic [GroupBits-1:0]        group_q;
  logic                        last_group;
  logic [ColumnBits-3:0]       left_q;     // groups to come behind this one
  logic signed [PlaceBits-1:0] place_q, place_before;  // group_q less s / 4; one before
  logic                        grey, group_end, break_q;
  logic [1:0]                  turn;       // s modulo 4: table lane k has the column of lane k + turn

  assign grey      = Grey && grey_i;
  assign group_end = !grey || half_q;
  assign turn      = shift_columns_i[1:0];

  always_ff @(posedge clk_i) begin
    if (start_i) begin
      half_q   <= 1'b0;
      group_q  <= '0;
      left_q   <= groups_i - (ColumnBits - 2)'(1);
      place_q  <= PlaceBits'(0) - {{(PlaceBits - 6){shift_columns_i[7]}}, shift_columns_i[7:2]};
    end else if (beat_valid_i) begin
      half_q <= grey && !half_q;
      if (group_end) begin
        group_q  <= group_q + GroupBits'(1);
        left_q   <= left_q - (ColumnBits - 2)'(1);
        place_q  <= place_q + PlaceBits'(1);
      end
    end
  end
  assign place_before = place_q - PlaceBits'(1);
  assign last_group   = left_q == '0;

  // --- Stage 1: the beat in the order of the table's lanes, while the table is read ---
  logic [3:0]           s1_here;        // a lane of the beat has a column
  logic [4*M0Bits-1:0]  s1_m0;
  logic [4*M1Bits-1:0]  s1_m1;
  logic [3:0]           s1_came_q, s1_there_q;  // the column came; the table has a word for it
  logic [4*M0Bits-1:0]  s1_m0_q;
  logic [4*M1Bits-1:0]  s1_m1_q;
  logic [4*WordBits-1:0] s1_words;
  logic [GroupBits-1:0] s1_group_q;
  logic                 s1_valid_q, s1_group_end_q, s1_done_q, s1_whole_q;
  logic                 open_q;         // a frame has begun and is not over

  logic unused;
  assign unused = ^beat_data_i;
  for (genvar lane = 0; lane < 4; lane++) begin : gen_beat
    if (Grey) begin : gen_grey
      localparam int Wide = 64 * (lane % 2);
      assign s1_here[lane] = !grey || half_q == (lane > 1);
      assign s1_m0[lane*M0Bits+:M0Bits] = grey ?
          M0Bits'(beat_data_i[Wide+sp_spec_pkg::GreyM0Lsb+:sp_spec_pkg::GreyM0Bits]) :
          M0Bits'(beat_data_i[32*lane+sp_spec_pkg::BinaryRunM0Lsb+:sp_spec_pkg::BinaryRunM0Bits]);
      assign s1_m1[lane*M1Bits+:M1Bits] = grey ?
          M1Bits'(beat_data_i[Wide+sp_spec_pkg::GreyM1Lsb+:sp_spec_pkg::GreyM1Bits]) :
          M1Bits'(beat_data_i[32*lane+sp_spec_pkg::BinaryRunM1Lsb+:sp_spec_pkg::BinaryRunM1Bits]);
    end else begin : gen_binary
      assign s1_here[lane] = 1'b1;
      assign s1_m0[lane*M0Bits+:M0Bits] = beat_data_i[32*lane+sp_spec_pkg::BinaryRunM0Lsb+:M0Bits];
      assign s1_m1[lane*M1Bits+:M1Bits] = beat_data_i[32*lane+sp_spec_pkg::BinaryRunM1Lsb+:M1Bits];
    end
  end

  // Lane (k + turn) of the beat belongs to lane k of the table.
  for (genvar k = 0; k < 4; k++) begin : gen_table
    localparam int A = k, B = (k + 1) % 4, C = (k + 2) % 4, D = (k + 3) % 4;
    logic                        wraps;  // its column lies in the group before
    logic signed [PlaceBits-1:0] place;
    logic                        unused_sign;
    assign wraps  = {1'b0, turn} + 3'(k) > 3'd3;
    assign place  = wraps ? place_before : place_q;
    assign unused_sign = ^place[PlaceBits-1:GroupBits];

    always_ff @(posedge clk_i) begin
      s1_there_q[k] <= place >= 0 && place < PlaceBits'(Groups);
      case (turn)
        2'd0: s1_came_q[k] <= s1_here[A];
        2'd1: s1_came_q[k] <= s1_here[B];
        2'd2: s1_came_q[k] <= s1_here[C];
        default: s1_came_q[k] <= s1_here[D];
      endcase
      case (turn)
        2'd0: begin
          s1_m0_q[k*M0Bits+:M0Bits] <= s1_m0[A*M0Bits+:M0Bits];
          s1_m1_q[k*M1Bits+:M1Bits] <= s1_m1[A*M1Bits+:M1Bits];
        end
        2'd1: begin
          s1_m0_q[k*M0Bits+:M0Bits] <= s1_m0[B*M0Bits+:M0Bits];
          s1_m1_q[k*M1Bits+:M1Bits] <= s1_m1[B*M1Bits+:M1Bits];
        end
        2'd2: begin
          s1_m0_q[k*M0Bits+:M0Bits] <= s1_m0[C*M0Bits+:M0Bits];
          s1_m1_q[k*M1Bits+:M1Bits] <= s1_m1[C*M1Bits+:M1Bits];
        end
        default: begin
          s1_m0_q[k*M0Bits+:M0Bits] <= s1_m0[D*M0Bits+:M0Bits];
          s1_m1_q[k*M1Bits+:M1Bits] <= s1_m1[D*M1Bits+:M1Bits];
        end
      endcase
    end

    logic [TableBits-1:0] address;
    if (LogSections > 0) begin : gen_sections
      assign address = {bank_i, section_i, place[GroupBits-1:0]};
    end else begin : gen_one_section
      logic unused_section;
      assign unused_section = section_i[0];
      assign address = {bank_i, place[GroupBits-1:0]};
    end

    sp_ram #(
      .Width   (WordBits),
      .LogDepth(TableBits)
    ) u_table (
      .wr_clk_i (clk_i),
      .wr_en_i  (write_i && write_lane_i == 2'(k)),
      .wr_addr_i(write_group_i),
      .wr_data_i(write_word_i),
      .rd_clk_i (clk_i),
      .rd_en_i  (1'b1),
      .rd_addr_i(address),
      .rd_data_o(s1_words[k*WordBits+:WordBits])
`ifdef FORMAL
      ,
      .f_addr_i ('0),
      .f_word_o (),
      .f_first_o()
`endif
    );
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      open_q     <= 1'b0;
      break_q    <= 1'b0;
      s1_valid_q <= 1'b0;
      s1_done_q  <= 1'b0;
    end else begin
      // A break in the clock of the last beat comes too late.
      break_q    <= break_i;
      s1_valid_q <= beat_valid_i;
      s1_done_q  <= 1'b0;
      if (start_i) begin
        open_q <= 1'b1;
      end else if (beat_valid_i && group_end && last_group || open_q && break_q) begin
        open_q    <= 1'b0;
        s1_done_q <= 1'b1;
      end
    end
  end
  always_ff @(posedge clk_i) begin
    s1_group_q     <= group_q;
    s1_group_end_q <= group_end;
    s1_whole_q     <= !break_q;
  end

  // --- Stages 2 to 4: products, difference, comparison ---
  logic [4:2]               valid_q, group_end_q, done_q, whole_q;
  logic [GroupBits-1:0]     s2_group_q, s3_group_q, s4_group_q;
  logic [3:0]               s4_above_q, s4_below_q, s4_unlit_q, s4_lit_q, s4_came_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q <= '0;
      done_q  <= '0;
    end else begin
      valid_q <= {valid_q[3:2], s1_valid_q};
      done_q  <= {done_q[3:2], s1_done_q};
    end
  end
  always_ff @(posedge clk_i) begin
    group_end_q <= {group_end_q[3:2], s1_group_end_q};
    whole_q     <= {whole_q[3:2], s1_whole_q};
    {s4_group_q, s3_group_q, s2_group_q} <= {s3_group_q, s2_group_q, s1_group_q};
  end

  for (genvar k = 0; k < 4; k++) begin : gen_judge
    logic [M0Bits-1:0]         s2_m0_q;
    logic [M1Bits-1:0]         s2_m1_q;
    logic signed [M0Bits+13:0] s2_moved_q;  // d M0
    logic [LimitBits-1:0]      s2_low_q, s2_high_q;
    logic                      s2_judged_q, s3_judged_q, s2_came_q, s3_came_q, s3_lit_q;
    logic signed [XBits-1:0]   s3_x_q;
    logic [ProductBits-1:0]    s3_low_q, s3_high_q;
    logic [WordBits-1:0]       word;

    assign word = s1_words[k*WordBits+:WordBits];
    always_ff @(posedge clk_i) begin
      s2_m0_q     <= s1_m0_q[k*M0Bits+:M0Bits];
      s2_m1_q     <= s1_m1_q[k*M1Bits+:M1Bits];
      s2_moved_q  <= $signed(shift_rows_i) * $signed({1'b0, s1_m0_q[k*M0Bits+:M0Bits]});
      s2_came_q   <= s1_came_q[k];
      s2_judged_q <= s1_there_q[k] && word[2*LimitBits];
      s2_high_q   <= word[LimitBits+:LimitBits];
      s2_low_q    <= word[0+:LimitBits];

      s3_came_q   <= s2_came_q;
      s3_judged_q <= s2_judged_q;
      s3_lit_q    <= s2_m0_q != '0;
      s3_low_q    <= s2_low_q * ProductBits'(s2_m0_q);
      s3_high_q   <= s2_high_q * ProductBits'(s2_m0_q);
      s3_x_q      <= $signed(XBits'({s2_m1_q, 7'd0})) - XBits'(s2_moved_q);

      s4_came_q[k]  <= s3_came_q;
      s4_above_q[k] <= s3_judged_q && s3_lit_q && s3_x_q < $signed(XBits'(s3_low_q));
      s4_below_q[k] <= s3_judged_q && s3_lit_q && s3_x_q > $signed(XBits'(s3_high_q));
      s4_unlit_q[k] <= s3_judged_q && !s3_lit_q;
      s4_lit_q[k]   <= s3_lit_q;
    end
  end

  // --- Stages 5 and 6: back into the order of the columns; two beats make a group ---
  logic [3:0] s5_above_q, s5_below_q, s5_unlit_q, s5_lit_q, s5_came_q;
  logic       s5_valid_q, s5_group_end_q, s5_done_q, s5_whole_q;
  logic [GroupBits-1:0] s5_group_q;

  always_ff @(posedge clk_i) begin
    case (turn)
      2'd0: {s5_above_q, s5_below_q, s5_unlit_q, s5_lit_q, s5_came_q} <=
          {s4_above_q, s4_below_q, s4_unlit_q, s4_lit_q, s4_came_q};
      2'd1: {s5_above_q, s5_below_q, s5_unlit_q, s5_lit_q, s5_came_q} <=
          {s4_above_q[2:0], s4_above_q[3], s4_below_q[2:0], s4_below_q[3],
           s4_unlit_q[2:0], s4_unlit_q[3], s4_lit_q[2:0], s4_lit_q[3],
           s4_came_q[2:0], s4_came_q[3]};
      2'd2: {s5_above_q, s5_below_q, s5_unlit_q, s5_lit_q, s5_came_q} <=
          {s4_above_q[1:0], s4_above_q[3:2], s4_below_q[1:0], s4_below_q[3:2],
           s4_unlit_q[1:0], s4_unlit_q[3:2], s4_lit_q[1:0], s4_lit_q[3:2],
           s4_came_q[1:0], s4_came_q[3:2]};
      default: {s5_above_q, s5_below_q, s5_unlit_q, s5_lit_q, s5_came_q} <=
          {s4_above_q[0], s4_above_q[3:1], s4_below_q[0], s4_below_q[3:1],
           s4_unlit_q[0], s4_unlit_q[3:1], s4_lit_q[0], s4_lit_q[3:1],
           s4_came_q[0], s4_came_q[3:1]};
    endcase
    s5_group_q     <= s4_group_q;
    s5_group_end_q <= group_end_q[4];
    s5_whole_q     <= whole_q[4];
  end
  always_ff @(posedge clk_i) begin
    if (rst_i) {s5_valid_q, s5_done_q} <= '0;
    else {s5_valid_q, s5_done_q} <= {valid_q[4], done_q[4]};
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      group_valid_o <= 1'b0;
      done_o        <= 1'b0;
    end else begin
      group_valid_o <= s5_valid_q && s5_group_end_q;
      done_o        <= s5_done_q;
    end
  end
  always_ff @(posedge clk_i) begin
    whole_o <= s5_whole_q;
    group_o <= s5_group_q;
    if (s5_valid_q) begin
      for (int lane = 0; lane < 4; lane++) begin
        if (s5_came_q[lane]) begin
          {above_o[lane], below_o[lane], unlit_o[lane], lit_o[lane]} <=
              {s5_above_q[lane], s5_below_q[lane], s5_unlit_q[lane], s5_lit_q[lane]};
        end
      end
    end
  end

endmodule

`default_nettype wire
