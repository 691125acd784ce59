// 3 x 3 median of a stream of code images, a beat of codes per clock, one line behind its input.
//
//   codes ─▶ line before ─▶ line before that        two line buffers
//     │          │              │
//     └──────────┴──────────────┴▶ window of Lanes + 2 x 3 ─▶ Lanes × sp_median9
//
// A line leaves while the next one comes in. The last line of a frame follows at once, one beat per
// clock; with 8 lanes after a pause of 11 clocks, with 16 lanes of 11 and one for each beat of a
// line, which the packet of the line before takes (sp_codes_path). No other frame may begin during
// that time (busy_o) and three clocks after it; sp_gray_decoder sees to this. Without s_median_i
// codes pass unchanged, with the same timing.
//
// When a frame breaks within a line, the line before it is cut too. It ends at the break, one beat
// short, because that beat lacks its right-hand neighbour. The broken line itself does not leave. A
// break between two lines has no effect. Only frames whose codes are wanted come in (s_valid_i);
// s_break_i may belong to another frame and is then ignored.
//
// Timing: group g of a line leaves five clocks after group g + 1 of the line below came in. The
// last group leaves six clocks after the last one below, and a break six clocks after it came in.
// While the last line of a frame leaves, its own groups count as those of the line below.
`default_nettype none

module sp_median3x3 #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // largest image width, a multiple of 4; of Lanes
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat  // pixels in a beat: 4, 8 or 16
) (
  input  wire logic        clk_i,                              // pixel clock
  input  wire logic        rst_i,                              // active high, synchronous

  // Codes of sp_gray_decoder
  input  wire logic        s_valid_i,                          // a beat of Lanes codes
  input  wire logic [16*Lanes-1:0] s_codes_i,                          // leftmost code in 15..0
  input  wire logic        s_start_i,                          // first beat of a frame
  input  wire logic        s_line_start_i,                     // first beat of a line
  input  wire logic        s_line_end_i,                       // last beat of a line
  input  wire logic        s_last_row_i,                       // the row is the last of the frame
  input  wire logic        s_break_i,                          // a frame breaks
  input  wire logic [sp_spec_pkg::StatusBits-1:0] s_status_i,  // why, with s_break_i
  input  wire logic        s_median_i,  // with s_start_i, for the whole frame: send the median
  output logic             busy_o,  // a frame is open, or its last line is still leaving

  // Codes
  output logic             m_valid_o,                          // a beat of Lanes codes
  output logic      [16*Lanes-1:0] m_codes_o,                          // leftmost code in 15..0
  output logic             m_start_o,                          // first beat of a frame
  output logic             m_line_start_o,                     // first beat of a line
  output logic             m_line_end_o,                       // last beat of a line
  output logic             m_break_o,                          // the frame breaks
  output logic [sp_spec_pkg::StatusBits-1:0] m_status_o        // why, with m_break_o
);

  if (MaxColumns < Lanes || MaxColumns % Lanes != 0) begin : gen_max_columns
    max_columns_is_not_a_multiple_of_lanes u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end

  localparam int StatusBits = sp_spec_pkg::StatusBits;
  localparam int CodeBits = sp_spec_pkg::CodeCodeBits;
  localparam int Width = CodeBits + 1;  // {measurable, code}
  localparam int GroupBits = MaxColumns > Lanes ? $clog2(MaxColumns / Lanes) : 1;

  // --- Place of the beat. A step reads both line buffers: a beat from the second line on, or a
  // beat of the last line while it leaves. ---
  logic                 open_q;         // a frame is open
  logic                 passing_q;      // its last line leaves
  logic [1:0]           lines_q, lines;  // complete lines of the frame, up to 2
  logic [GroupBits-1:0] group_q, group;  // group of the next beat
  logic [GroupBits-1:0] last_group_q;   // last group of the lines
  logic [GroupBits-1:0] pass_group_q;
  logic                 step, ends;
  logic                 pass;           // the last line begins to leave in the next clock
  logic                 left;           // its last beat has been read
  logic                 settled;        // codes of another frame may come

  assign lines = s_start_i ? 2'd0 : lines_q;
  assign group = s_line_start_i ? '0 : group_q;
  assign ends  = s_valid_i && s_line_end_i && s_last_row_i;
  assign step  = s_valid_i && lines != 2'd0 || passing_q;
  assign left  = passing_q && pass_group_q == last_group_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      open_q    <= 1'b0;
      passing_q <= 1'b0;
      busy_o    <= 1'b0;
    end else begin
      if (s_valid_i) open_q <= !ends;
      else if (s_break_i) open_q <= 1'b0;
      if (pass) passing_q <= 1'b1;
      else if (pass_group_q == last_group_q) passing_q <= 1'b0;
      if (s_valid_i) busy_o <= 1'b1;
      else if (s_break_i && open_q || settled) busy_o <= 1'b0;
    end
    if (s_valid_i) begin
      group_q <= group + GroupBits'(1);
      lines_q <= lines + 2'(s_line_end_i && lines != 2'd2);
      if (s_line_end_i) last_group_q <= group;
    end
    pass_group_q <= passing_q ? pass_group_q + GroupBits'(1) : '0;
  end

  if (Lanes == 4) begin : gen_at_once
    assign pass    = ends;
    assign settled = left;
  end else begin : gen_pause
    logic [GroupBits+3:0] pause_q;  // clocks until then
    always_ff @(posedge clk_i) begin
      if (rst_i) pause_q <= '0;
      else if (ends) pause_q <= (GroupBits + 4)'(11) + (Lanes == 16 ? (GroupBits + 4)'(group) + 1'b1 : '0);
      else if (pause_q != '0) pause_q <= pause_q - 1'b1;
    end
    assign pass = pause_q == (GroupBits + 4)'(1);
    // Three clocks later than with 4 lanes: sp_codes_path tells frames of one line apart by then.
    logic [1:0] left_q;
    always_ff @(posedge clk_i) {settled, left_q} <= {left_q, left};
  end

  // --- Line buffers: near holds the line before, far the line before that. They are written one
  // clock after they are read. A read that meets the write of its own group (lines of one group)
  // takes the word that is written. ---
  logic [Lanes*Width-1:0]   now1_q;
  logic                 valid1_q, step1_q, first1_q, last1_q, top1_q, bottom1_q, same1_q;
  logic [GroupBits-1:0] group1_q, step_group;
  logic [Lanes*Width-1:0]   near_ram, far_ram, near, far, near_written_q, far_written_q;
  logic [Lanes*Width-1:0]   codes;
  logic                 median_q;

  for (genvar i = 0; i < Lanes; i++) begin : gen_in
    assign codes[Width*i+:Width] =
        {s_codes_i[16*i+sp_spec_pkg::CodeMeasurableLsb], s_codes_i[16*i+:CodeBits]};
    logic unused;
    assign unused = ^s_codes_i[16*i+CodeBits+:16-CodeBits];
  end

  assign step_group = passing_q ? pass_group_q : group;
  assign near       = same1_q ? near_written_q : near_ram;
  assign far        = same1_q ? far_written_q : far_ram;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid1_q <= 1'b0;
      step1_q  <= 1'b0;
    end else begin
      valid1_q <= s_valid_i;
      step1_q  <= step;
    end
    now1_q    <= codes;
    group1_q  <= group;
    first1_q  <= step_group == '0;
    last1_q   <= passing_q ? pass_group_q == last_group_q : s_line_end_i;
    top1_q    <= passing_q ? lines_q == 2'd2 : lines == 2'd2;
    bottom1_q <= !passing_q;
    same1_q   <= valid1_q && group1_q == step_group;
    {near_written_q, far_written_q} <= {now1_q, near};
    if (s_valid_i && s_start_i) median_q <= s_median_i;
  end

  sp_ram #(
    .Width   (Lanes * Width),
    .LogDepth(GroupBits)
  ) u_near (
    .wr_clk_i (clk_i),
    .wr_en_i  (valid1_q),
    .wr_addr_i(group1_q),
    .wr_data_i(now1_q),
    .rd_clk_i (clk_i),
    .rd_en_i  (step),
    .rd_addr_i(step_group),
    .rd_data_o(near_ram)
  );

  sp_ram #(
    .Width   (Lanes * Width),
    .LogDepth(GroupBits)
  ) u_far (
    .wr_clk_i (clk_i),
    .wr_en_i  (valid1_q && step1_q),
    .wr_addr_i(group1_q),
    .wr_data_i(near),
    .rd_clk_i (clk_i),
    .rd_en_i  (step),
    .rd_addr_i(step_group),
    .rd_data_o(far_ram)
  );

  // --- The window: columns of three codes, the top one in the low bits. The group in its middle is
  // the one before the group of the step. ---
  localparam int Column = 3 * Width;

  logic [Lanes*Column-1:0] columns;      // of the step
  logic [Lanes*Column-1:0] middle_q;     // of the step before
  logic [Column-1:0]   left_q;       // the column to the left of it
  logic                middle_valid_q, middle_first_q, middle_last_q, middle_top_q, middle_bottom_q;
  logic                leaves;
  logic [(Lanes+2)*Column-1:0] window_q;
  logic                window_valid_q, window_first_q, window_last_q, window_top_q, window_bottom_q;

  for (genvar i = 0; i < Lanes; i++) begin : gen_column
    assign columns[Column*i+:Column] =
        {bottom1_q ? now1_q[Width*i+:Width] : Width'(0), near[Width*i+:Width],
                                        top1_q ? far[Width*i+:Width] : Width'(0)};
  end

  assign leaves = middle_valid_q && (middle_last_q || step1_q && !first1_q);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      middle_valid_q <= 1'b0;
      window_valid_q <= 1'b0;
    end else begin
      if (step1_q) middle_valid_q <= 1'b1;
      else if (leaves) middle_valid_q <= 1'b0;
      window_valid_q <= leaves;
    end
    if (step1_q) begin
      middle_q        <= columns;
      left_q          <= first1_q ? '0 : middle_q[(Lanes-1)*Column+:Column];
      middle_first_q  <= first1_q;
      middle_last_q   <= last1_q;
      middle_top_q    <= top1_q;
      middle_bottom_q <= bottom1_q;
    end
    window_q        <= {middle_last_q ? Column'(0) : columns[0+:Column], middle_q, left_q};
    window_first_q  <= middle_first_q;
    window_last_q   <= middle_last_q;
    window_top_q    <= middle_top_q;
    window_bottom_q <= middle_bottom_q;
  end

  // --- The medians. Half of the codes that exist: 4 of 9, 3 of 6, 2 of 4, 1 of 2 or 3. ---
  logic [3:0]         half_inner, half_outer;
  logic [Lanes*Width-1:0] medians;

  always_comb begin
    case ({window_top_q, window_bottom_q})
      2'b11:   {half_inner, half_outer} = {4'd4, 4'd3};  // 9 and 6 codes
      2'b00:   {half_inner, half_outer} = {4'd1, 4'd1};  // 3 and 2
      default: {half_inner, half_outer} = {4'd3, 4'd2};  // 6 and 4
    endcase
  end

  for (genvar i = 0; i < Lanes; i++) begin : gen_median
    logic outer;
    assign outer = i == 0 && window_first_q || i == Lanes - 1 && window_last_q;
    sp_median9 #(
      .CodeBits(CodeBits)
    ) u_median (
      .clk_i   (clk_i),
      .codes_i (window_q[Column*i+:3*Column]),
      .median_i(median_q),
      .half_i  (outer ? half_outer : half_inner),
      .code_o  (medians[Width*i+:Width])
    );
    assign m_codes_o[16*i+:16] = {medians[Width*i+CodeBits], 3'd0, medians[Width*i+:CodeBits]};
  end

  // --- Signals beside the codes ---
  logic [2:1]            valid_q, start_q, first_q, last_q;
  logic [5:1]            break_q;
  logic [StatusBits-1:0] status1_q, status2_q, status3_q, status4_q, status5_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q   <= '0;
      m_valid_o <= 1'b0;
      m_start_o <= 1'b0;
      break_q   <= '0;
      m_break_o <= 1'b0;
    end else begin
      {m_valid_o, valid_q} <= {valid_q, window_valid_q};
      {m_start_o, start_q} <= {start_q, window_valid_q && window_first_q && !window_top_q};
      {m_break_o, break_q} <= {break_q, s_break_i && open_q};
    end
    {m_line_start_o, first_q} <= {first_q, window_first_q};
    {m_line_end_o, last_q}    <= {last_q, window_last_q};
    {m_status_o, status5_q, status4_q} <= {status5_q, status4_q, status3_q};
    {status3_q, status2_q, status1_q}  <= {status2_q, status1_q, s_status_i};
  end

endmodule

`default_nettype wire
