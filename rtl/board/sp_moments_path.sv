// From beats to moments packets: the sums, divided or not, their packets, and the packet FIFO into
// the bus clock.
//
// Guarantees: every frame start gives a packet or is counted in lost_o; packets come out whole.
// This module only connects sp_column_moments, or sp_column_runs, perhaps sp_compact_words or
// sp_payload_split, and sp_packet_output, which have the latency, the formats and the overflow rule.
//
// With Verdict the sums of a frame that is to be judged come out of words_valid_o, 16 bytes a clock,
// whether its packet finds room or not, if judge_ready_i is high at decision_o; else they do not
// come, and the packet is lost. judge_i says from the next clock on how that was decided.
`default_nettype none

module sp_moments_path #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 8..4096; with more lanes of Lanes, from 2 Lanes on
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 2..2047
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  parameter bit Grey = 1'b1,
  parameter bit Runs = 1'b0,    // the strongest run of a column
  parameter bit Region = 1'b1,  // headers say where on the sensor frames begin
  parameter bit Compact = 1'b0,  // packets of kind compact; only with Grey
  parameter bit Verdict = 1'b0,  // sums for sp_verdict, packets with its verdict
  parameter int LogDepth = 11,  // log2 of the depth of the packet FIFO, in beats of 16 bytes: 3..15
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / Lanes),
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  // Video clock domain
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // Beats, breaks and settings in force of sp_frame_tracker; these are the same for a whole frame
  input  wire logic [ColumnBits-3:0] groups_i,  // of a line: columns / 4
  input  wire logic [1:0]            mode_i,
  input  wire logic [PixelBits-1:0]  threshold_i,
  input  wire logic [2*RowBits+2:0]  select_i,  // {last row that counts, first, strongest, gap}
  input  wire logic                  compact_i,
  input  wire logic [2:0]            verdict_i,  // {on, packets} of the register verdict_control
  input  wire logic                  one_group_i,
  input  wire logic                  two_groups_i,
  input  wire logic                  beat_valid_i,
  input  wire logic [Lanes*PixelBits-1:0] beat_pixels_i,
  input  wire logic [GroupBits-1:0]  beat_group_i,
  input  wire logic [RowBits-1:0]    beat_row_i,
  input  wire logic                  beat_first_row_i,
  input  wire logic                  beat_last_row_i,
  input  wire logic                  beat_line_end_i,
  input  wire logic                  last_row_start_i,
  input  wire logic                  break_i,
  input  wire logic                  break_in_last_row_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0]    break_status_i,

  input  wire logic [sp_spec_pkg::HeaderBits-1:0] info_i,  // of sp_frame_info

  output logic      [31:0]           lost_o,

  // Sums for sp_verdict, as they come, and its verdict
  output logic                       decision_o,
  output logic                       spoiled_o,  // with decision_o: the sums are void
  input  wire logic                  judge_ready_i,
  input  wire logic                  judge_i,
  output logic                       words_valid_o,
  output logic      [127:0]          words_data_o,
  output logic                       words_break_o,
  input  wire logic                  verdict_valid_i,
  input  wire logic [127:0]          verdict_data_i,

  // Bus clock domain: packets
  input  wire logic                  bus_clk_i,
  input  wire logic                  bus_rst_i,
  output logic                       m_valid_o,
  input  wire logic                  m_ready_i,
  output logic                       m_last_o,
  output logic      [127:0]          m_data_o
);

  if (Compact && !Grey) begin : gen_compact_needs_grey
    compact_needs_grey u_error ();
  end

  localparam int StatusBits = sp_spec_pkg::StatusBits;
  localparam int PayloadBits = $clog2(MaxColumns * (Grey ? 8 : 4) / 16 + 32'(Verdict) + 1);

  logic                   accept;  // the packet
  logic                   wanted;  // the sums
  logic                   words_valid, words_break, spoiled;
  logic [32*Lanes-1:0]    words_data;
  logic [PayloadBits-1:0] payload_beats, payload_beats_q;
  logic                   last_row_start_q;

  // Four columns per beat in mode binary and in compact packets, else two
  logic pairs, compact;
  logic [PayloadBits-1:0] column_beats;
  assign pairs         = Grey && mode_i != sp_spec_pkg::ModeBinary;
  assign compact       = Compact && pairs && compact_i;
  assign column_beats  = pairs && !compact ? PayloadBits'({groups_i, 1'b0}) : PayloadBits'(groups_i);
  assign payload_beats = !Verdict ? column_beats : verdict_i[1] ? PayloadBits'(1) :
                                    column_beats + PayloadBits'(verdict_i[0]);

  // The start of a last row is passed on one clock late. The header is then read only when the
  // header of a frame that breaks there is out.
  always_ff @(posedge clk_i) begin
    last_row_start_q <= last_row_start_i;
    if (last_row_start_i) payload_beats_q <= payload_beats;
  end

  // No pixel is greater than the largest, so none is lit in a row that does not count.
  logic [RowBits-1:0] first_row, last_row;  // that count; 0: no limit
  logic               counts;
  logic [PixelBits-1:0] threshold;
  assign {last_row, first_row} = select_i[3+:2*RowBits];
  assign counts    = beat_row_i >= first_row && (beat_row_i <= last_row || last_row == '0);
  assign threshold = threshold_i | {PixelBits{!counts}};

  if (Runs) begin : gen_runs
    sp_column_runs #(
      .MaxColumns(MaxColumns),
      .MaxRows   (MaxRows),
      .PixelBits (PixelBits),
      .Lanes     (Lanes),
      .Grey      (Grey)
    ) u_moments (
      .clk_i           (clk_i),
      .rst_i           (rst_i),
      .beat_valid_i    (beat_valid_i),
      .beat_pixels_i   (beat_pixels_i),
      .beat_group_i    (beat_group_i),
      .beat_row_i      (beat_row_i),
      .beat_first_row_i(beat_first_row_i),
      .beat_last_row_i (beat_last_row_i),
      .beat_line_end_i (beat_line_end_i),
      .strongest_i     (select_i[2]),
      .gap_i           (select_i[1:0]),
      .mode_i          (mode_i),
      .threshold_i     (threshold),
      .break_i         (break_i && break_in_last_row_i),
      .accept_i        (wanted),
      .moments_valid_o (words_valid),
      .moments_data_o  (words_data),
      .moments_break_o (words_break),
      .spoiled_o       (spoiled)
    );
    logic unused;
    assign unused = one_group_i ^ two_groups_i;
  end else begin : gen_plain
    sp_column_moments #(
      .MaxColumns(MaxColumns),
      .MaxRows   (MaxRows),
      .PixelBits (PixelBits),
      .Lanes     (Lanes),
      .Grey      (Grey)
    ) u_moments (
      .clk_i           (clk_i),
      .rst_i           (rst_i),
      .beat_valid_i    (beat_valid_i),
      .beat_pixels_i   (beat_pixels_i),
      .beat_group_i    (beat_group_i),
      .beat_row_i      (beat_row_i),
      .beat_first_row_i(beat_first_row_i),
      .beat_last_row_i (beat_last_row_i),
      .beat_line_end_i (beat_line_end_i),
      .one_group_i     (one_group_i),
      .two_groups_i    (two_groups_i),
      .mode_i          (mode_i),
      .threshold_i     (threshold),
      .break_i         (break_i && break_in_last_row_i),
      .accept_i        (wanted),
      .moments_valid_o (words_valid),
      .moments_data_o  (words_data),
      .moments_break_o (words_break),
      .spoiled_o       (spoiled)
    );
    logic unused;
    assign unused = ^select_i[2:0];
  end

  // --- The verdict: it needs the sums of frames whose packets find no room, too ---
  localparam int TailDelay = RowBits - 1;
  // The bits of verdict_data_i that are not always 0
  localparam logic [127:0] TailBits =
      128'({ColumnBits{1'b1}}) << sp_spec_pkg::VerdictFirstColumnLsb |
      128'({ColumnBits{1'b1}}) << sp_spec_pkg::VerdictColumnsLsb |
      128'({ColumnBits{1'b1}}) << sp_spec_pkg::VerdictUnlitLsb |
      128'(1) << sp_spec_pkg::VerdictJudgedLsb | 128'(1) << sp_spec_pkg::VerdictInPartLsb |
      128'(1) << sp_spec_pkg::VerdictDefectLsb | 128'(1) << sp_spec_pkg::VerdictLacksLightLsb |
      128'(1) << sp_spec_pkg::VerdictBankLsb |
      128'({sp_spec_pkg::VerdictSectionBits{1'b1}}) << sp_spec_pkg::VerdictSectionLsb |
      128'({sp_spec_pkg::VerdictPartBits{1'b1}}) << sp_spec_pkg::VerdictPartLsb;
  logic       tail_valid, columns_leave;
  assign spoiled_o     = spoiled;
  logic       active;         // at the decision: the frame is to be judged
  if (Verdict) begin : gen_verdict
    logic [3:1]      decided_q;  // last_row_start_q, one to three clocks ago
    logic [8:0]      asked_q;          // verdict_i of three clocks, the oldest of the frame that is decided on
    logic [1:0]      asked_packets_q;  // its packets, one clock later
    logic            active_q;   // of the frame decided on last
    logic [1:0]      packets_q;  // of the one that was wanted last
    always_ff @(posedge clk_i) begin
      if (rst_i) decided_q <= '0;
      else decided_q <= {decided_q[2:1], last_row_start_q};
    end
    always_ff @(posedge clk_i) begin
      asked_q         <= {asked_q[5:0], verdict_i};
      asked_packets_q <= asked_q[7:6];
      if (rst_i) begin
        active_q  <= 1'b0;
        packets_q <= 2'b00;
      end else begin
        if (decided_q[2]) active_q <= active;
        // Words of the packet before may still leave, which one that is not wanted does not end.
        if (decided_q[3] && wanted) packets_q <= asked_packets_q;
      end
    end
    assign active        = asked_q[8];
    assign decision_o    = decided_q[2] && active;
    assign wanted        = active_q ? judge_i : accept;
    assign columns_leave = !packets_q[1];
    if (Compact) begin : gen_later
      // Divided columns leave later than whole ones, and the verdict behind them.
      logic [TailDelay:1] valid_q;
      always_ff @(posedge clk_i) begin
        if (rst_i) valid_q <= '0;
        else valid_q <= {valid_q[TailDelay-1:1], verdict_valid_i};
      end
      assign tail_valid = valid_q[TailDelay] && packets_q != 2'b00;
    end else begin : gen_at_once
      assign tail_valid = verdict_valid_i && packets_q != 2'b00;
    end
  end else begin : gen_no_verdict
    logic unused_verdict;
    assign unused_verdict = ^{verdict_i, judge_ready_i, judge_i, verdict_valid_i};
    assign active         = 1'b0;
    assign decision_o     = 1'b0;
    assign wanted         = accept;
    assign tail_valid     = 1'b0;
    assign columns_leave  = 1'b1;
  end

  // --- Divided columns ---
  logic                columns_valid, columns_break;
  logic [32*Lanes-1:0] columns_data;
  if (Compact) begin : gen_compact
    // What a packet is made of is known at its start and counts from its acceptance on, four clocks
    // later. The packet before has left by then, and the first words come later still.
    localparam int Decided = 4;
    logic [Decided:1]   started_q;
    logic [2*Decided-1:0] asked_q;
    logic               compact_q, strongest_q;
    always_ff @(posedge clk_i) begin
      if (rst_i) started_q <= '0;
      else started_q <= {started_q[Decided-1:1], last_row_start_i};
    end
    always_ff @(posedge clk_i) begin
      asked_q <= {asked_q[2*Decided-3:0], compact, Runs && select_i[2]};
      if (rst_i) {compact_q, strongest_q} <= 2'b00;
      else if (started_q[Decided] && accept) {compact_q, strongest_q} <= asked_q[2*Decided-2+:2];
    end
    sp_compact_words #(
      .MaxRows  (MaxRows),
      .PixelBits(PixelBits),
      .Lanes    (Lanes)
    ) u_compact (
      .clk_i        (clk_i),
      .rst_i        (rst_i),
      .compact_i    (compact_q),
      .strongest_i  (strongest_q),
      .words_valid_i(words_valid),
      .words_data_i (words_data),
      .words_break_i(words_break),
      .valid_o      (columns_valid),
      .data_o       (columns_data),
      .break_o      (columns_break)
    );
  end else begin : gen_exact
    logic unused_compact;
    assign unused_compact = compact_i;
    assign columns_valid  = words_valid;
    assign columns_data   = words_data;
    assign columns_break  = words_break;
  end

  // --- Payload beats, and those for the verdict, which are never divided ---
  logic         payload_valid, payload_break;
  logic [127:0] payload_data;
  localparam int LogWords = Grey || GroupBits < 2 ? GroupBits + 1 : GroupBits;  // that wait
  if (Lanes > 4 && Verdict && Compact) begin : gen_split_for_verdict
    sp_payload_split #(
      .Lanes   (Lanes),
      .LogDepth(LogWords)
    ) u_split (
      .clk_i        (clk_i),
      .rst_i        (rst_i),
      .words_valid_i(words_valid),
      .words_data_i (words_data),
      .words_break_i(words_break),
      .valid_o      (words_valid_o),
      .data_o       (words_data_o),
      .break_o      (words_break_o)
    );
  end else if (Lanes > 4) begin : gen_payload_for_verdict
    assign words_valid_o = payload_valid;
    assign words_data_o  = payload_data;
    assign words_break_o = payload_break;
  end else begin : gen_words_for_verdict
    assign words_valid_o = words_valid;
    assign words_data_o  = words_data;
    assign words_break_o = words_break;
  end
  if (Lanes > 4) begin : gen_wide
    sp_payload_split #(
      .Lanes   (Lanes),
      .LogDepth(LogWords)
    ) u_split (
      .clk_i        (clk_i),
      .rst_i        (rst_i),
      .words_valid_i(columns_valid),
      .words_data_i (columns_data),
      .words_break_i(columns_break),
      .valid_o      (payload_valid),
      .data_o       (payload_data),
      .break_o      (payload_break)
    );
  end else begin : gen_four
    assign payload_valid = columns_valid;
    assign payload_data  = columns_data;
    assign payload_break = columns_break;
  end

  sp_packet_output #(
    .Kind       (sp_spec_pkg::KindMoments),
    .KindOfFrame(Compact || Verdict),
    .ColumnBits (ColumnBits),
    .RowBits    (RowBits),
    .Region     (Region),
    .Wide       (PixelBits > 8 || MaxRows > sp_spec_pkg::MaxRows),
    .Tail       (Verdict),
    .PayloadBits(PayloadBits),
    .LogDepth   (LogDepth)
  ) u_packets (
    .clk_i          (clk_i),
    .rst_i          (rst_i),
    .start_i        (last_row_start_q),
    .payload_beats_i(payload_beats_q),
    .line_i         (RowBits'(1)),
    .spoiled_i      (spoiled || active && !judge_ready_i),
    .break_i        (break_i),
    .break_later_i  (break_in_last_row_i),
    .start_status_i ({StatusBits{1'b0}}),
    .break_status_i (break_status_i),
    .accept_o       (accept),
    .payload_valid_i(payload_valid && columns_leave),
    .payload_data_i (payload_data),
    .payload_break_i(payload_break),
    .tail_valid_i   (tail_valid),
    .tail_i         (verdict_data_i & TailBits),
    .info_i         (info_i),
    .lost_o         (lost_o),
    .bus_clk_i      (bus_clk_i),
    .bus_rst_i      (bus_rst_i),
    .m_valid_o      (m_valid_o),
    .m_ready_i      (m_ready_i),
    .m_last_o       (m_last_o),
    .m_data_o       (m_data_o)
  );

`ifdef FORMAL
  // Any one pixel of any beat
  (* anyseq *) logic [$clog2(Lanes)-1:0] f_lane;
  logic [PixelBits-1:0] f_pixel;
  logic       f_above, f_below;  // the row is above the first one that counts, below the last one
  assign f_pixel = beat_pixels_i[PixelBits*f_lane+:PixelBits];
  assign f_above = first_row != '0 && beat_row_i < first_row;
  assign f_below = last_row != '0 && beat_row_i > last_row;
  // Rule 1: a pixel is lit where it is greater than the threshold and its row counts.
  always_comb begin
    assert ((f_pixel > threshold) == (f_pixel > threshold_i && !f_above && !f_below));
    cover (f_pixel > threshold && beat_row_i == last_row && beat_row_i == first_row);
    cover (f_pixel > threshold_i && threshold == '1);
  end
`endif

endmodule

`default_nettype wire
