// The frame's fields in the header of a packet: sequence, time stamp, encoder count, pattern index,
// settings.
//
// info_o is a header in which all other fields are 0. The specification places the fields
// (sp_spec_pkg).
//
// A header of four beats is written at most seven clocks after the event that causes it, while the
// next frame may already have begun. Each field is therefore taken so late that the header before
// it is out, and so early that its own header has not read it yet. For an event in clock e,
// sp_packetizer reads beat b of the header in clock e + 3 + b, and the sequence, which it keeps for
// the trailer, one clock before its beat. The event is one clock after the beat that causes it (the
// first of a last row, the last of a line), or the clock of the next frame start if that breaks the
// frame. So the fields of a frame that starts in clock c show in beat b from clock c + 4 + b on:
//
//   clk_i           _/1\_/2\_/3\_/4\_/5\_/6\_/7\_/8\_/9\_
//   frame_start_i   _/ A \___________________/ B \_______     (c = 1)
//   captured_o      _________/ A \_______________________     the trigger may advance the index
//   pattern_i       _____________< A >___________________
//   pattern_o       _________________< A                      c + 4, as header beat 0
//   info_o, beat 0  _________________< A                      c + 4
//   info_o, beat 1  _____________________< A                  c + 5; beats 2, 3: c + 6, c + 7
//
// Time stamp and encoder count are nevertheless those of the frame's first beat at the video input:
// the time counter runs ahead by the delay, and sp_encoder is late by the same number of clocks.
// They are known too late for the first beats: sequence and time stamp can stand in beat 1 or
// later, the encoder count in beat 2 or later.
//
// Columns and rows have the bits of the build; the bits above are 0. Nothing overflows except by
// wrapping: time and sequence after 2^64, frames_o after 2^32.
`default_nettype none

module sp_frame_info #(
  parameter int ColumnBits = 12,  // 1..16
  parameter int RowBits = 10,  // 1..16
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter bit Region = 1'b1,  // region_i counts; else its fields are 0
  parameter bit Compact = 1'b0,  // compact_i counts
  parameter bit Verdict = 1'b0  // verdict_i counts; without both the kind is 0
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // Frame starts and settings in force, of sp_frame_tracker
  input  wire logic                  frame_start_i,
  input  wire logic                  stray_before_i,
  input  wire logic                  take_i,
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic [RowBits-1:0]    rows_i,
  input  wire logic [1:0]            mode_i,
  input  wire logic [PixelBits-1:0]  threshold_i,
  input  wire logic [7:0]            stream_i,
  input  wire logic [2*RowBits+2:0]  select_i,  // {last row that counts, first, strongest, gap}
  input  wire logic [31:0]           region_i,  // {column, row}
  input  wire logic                  compact_i,
  input  wire logic [2:0]            verdict_i,  // {on, packets} of the register verdict_control

  input  wire logic [31:0]           encoder_i,
  input  wire logic [15:0]           pattern_i,

  // clocks since reset, minus 6; from the second clock on
  output logic [63:0]                time_o,
  output logic [31:0]                frames_o,    // accepted frames
  // the pattern index is captured after the next clock
  output logic                       captured_o,
  output logic [15:0]                pattern_o,   // of the frame, from its fourth clock on
  output logic [sp_spec_pkg::HeaderBits-1:0] info_o
);

  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end
  if (ColumnBits < 1 || ColumnBits > sp_spec_pkg::HeaderColumnsBits) begin : gen_column_bits
    column_bits_is_not_in_1_to_16 u_error ();
  end
  if (RowBits < 1 || RowBits > sp_spec_pkg::HeaderRowsBits) begin : gen_row_bits
    row_bits_is_not_in_1_to_16 u_error ();
  end

  localparam int BeatBits = sp_spec_pkg::PacketBeatBits;
  // Beats of the fields
  localparam int StreamBeat = sp_spec_pkg::HeaderStreamLsb / BeatBits;
  localparam int PatternBeat = sp_spec_pkg::HeaderPatternLsb / BeatBits;
  localparam int KindBeat = sp_spec_pkg::HeaderKindLsb / BeatBits;
  localparam int ModeBeat = sp_spec_pkg::HeaderModeLsb / BeatBits;
  localparam int ThresholdBeat = sp_spec_pkg::HeaderThresholdLsb / BeatBits;
  localparam int PixelBeat = sp_spec_pkg::HeaderPixelLsb / BeatBits;
  localparam int SequenceBeat = sp_spec_pkg::HeaderSequenceLsb / BeatBits;
  localparam int TimeStampBeat = sp_spec_pkg::HeaderTimeStampLsb / BeatBits;
  localparam int EncoderBeat = sp_spec_pkg::HeaderEncoderLsb / BeatBits;
  localparam int ColumnsBeat = sp_spec_pkg::HeaderColumnsLsb / BeatBits;
  localparam int RowsBeat = sp_spec_pkg::HeaderRowsLsb / BeatBits;
  localparam int LinesBeat = sp_spec_pkg::HeaderLinesLsb / BeatBits;
  localparam int FlagsBeat = sp_spec_pkg::HeaderFlagsLsb / BeatBits;
  localparam int SelectBeat = sp_spec_pkg::HeaderSelectLsb / BeatBits;
  localparam int GapBeat = sp_spec_pkg::HeaderGapLsb / BeatBits;
  localparam int FirstRowBeat = sp_spec_pkg::HeaderFirstRowLsb / BeatBits;
  localparam int LastRowBeat = sp_spec_pkg::HeaderLastRowLsb / BeatBits;
  localparam int RegionRowBeat = sp_spec_pkg::HeaderRegionRowLsb / BeatBits;
  localparam int RegionColumnBeat = sp_spec_pkg::HeaderRegionColumnLsb / BeatBits;

  // Clocks from the edge that takes the first beat at the video input to the edge that captures the
  // time
  localparam logic [63:0] CaptureDelay = 64'd6;

  logic [6:1]  started_q;  // frame_start_i, one to six clocks ago
  logic [6:1]  taken_q;    // take_i, one to six clocks ago
  logic [6:1]  stray_q;    // stray_before_i, one to six clocks ago
  logic        awake_q;    // a frame started in the last six clocks; else only the time moves
  logic [63:0] accepted;   // accepted frames

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      started_q <= '0;
      taken_q   <= '0;
      stray_q   <= '0;
      awake_q   <= 1'b0;
    end else if (frame_start_i || awake_q) begin
      started_q <= {started_q[5:1], frame_start_i};
      taken_q   <= {taken_q[5:1], take_i};
      stray_q   <= {stray_q[5:1], stray_before_i};
      awake_q   <= frame_start_i || started_q[5:1] != '0;
    end
  end

  // --- Counters ---
  sp_counter #(
    .Width     (64),
    .ResetValue(64'd1 - CaptureDelay)  // count_o follows two clocks later, not one
  ) u_time (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .inc_i  (1'b1),
    .count_o(time_o)
  );

  // The first frame has sequence 0: the number of frames before it, as counted three clocks after
  // the start.
  sp_counter #(
    .Width(64)
  ) u_frames (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .inc_i  (started_q[2]),
    .count_o(accepted)
  );

  assign frames_o   = accepted[31:0];
  assign captured_o = started_q[2];

  // --- Fields that are there for one clock only ---
  logic [15:0] pattern;
  logic [63:0] sequence_number, time_stamp;
  logic [31:0] encoder;

  sp_header_field #(
    .Width(16),
    .Known(3),
    .Shown(4)
  ) u_pattern (
    .clk_i    (clk_i),
    .started_i(started_q[3]),
    .value_i  (pattern_i),
    .value_o  (pattern_o)
  );

  if (PatternBeat == 0) begin : gen_pattern
    assign pattern = pattern_o;
  end else begin : gen_pattern_later
    sp_header_field #(
      .Width(16),
      .Known(4),
      .Shown(4 + PatternBeat)
    ) u_later (
      .clk_i    (clk_i),
      .started_i(started_q[3+PatternBeat:4]),
      .value_i  (pattern_o),
      .value_o  (pattern)
    );
  end

  sp_header_field #(
    .Width(64),
    .Known(3),
    .Shown(3 + SequenceBeat)
  ) u_sequence (
    .clk_i    (clk_i),
    .started_i(started_q[2+SequenceBeat:3]),
    .value_i  (accepted),
    .value_o  (sequence_number)
  );

  sp_header_field #(
    .Width(64),
    .Known(4),
    .Shown(4 + TimeStampBeat)
  ) u_time_stamp (
    .clk_i    (clk_i),
    .started_i(started_q[3+TimeStampBeat:4]),
    .value_i  (time_o),
    .value_o  (time_stamp)
  );

  sp_header_field #(
    .Width(32),
    .Known(5),
    .Shown(4 + EncoderBeat)
  ) u_encoder (
    .clk_i    (clk_i),
    .started_i(started_q[3+EncoderBeat:5]),
    .value_i  (encoder_i),
    .value_o  (encoder)
  );

  // --- Settings stand still for at least seven clocks: each is taken when its beat needs it ---
  logic [7:0]            stream_q, threshold_q, pixel;
  logic [1:0]            mode_q;
  logic [ColumnBits-1:0] columns_q;
  logic [RowBits-1:0]    rows_q, lines_q;
  logic                  strongest_q;
  logic [1:0]            gap_q;
  logic [RowBits-1:0]    first_row_q, last_row_q;
  logic [15:0]           region_row, region_column;
  logic                  stray_before_q;  // belongs to the frame, not to the settings

  always_ff @(posedge clk_i) begin
    if (taken_q[3+StreamBeat]) stream_q <= stream_i;
    if (taken_q[3+ModeBeat]) mode_q <= mode_i;
    if (taken_q[3+ThresholdBeat]) threshold_q <= threshold_i[7:0];
    if (taken_q[3+ColumnsBeat]) columns_q <= columns_i;
    if (taken_q[3+RowsBeat]) rows_q <= rows_i;
    if (taken_q[3+LinesBeat]) lines_q <= rows_i;
    if (taken_q[3+SelectBeat]) strongest_q <= select_i[2];
    if (taken_q[3+GapBeat]) gap_q <= select_i[1:0];
    if (taken_q[3+FirstRowBeat]) first_row_q <= select_i[3+:RowBits];
    if (taken_q[3+LastRowBeat]) last_row_q <= select_i[3+RowBits+:RowBits];
    if (started_q[3+FlagsBeat]) stray_before_q <= stray_q[3+FlagsBeat];
  end

  if (Region) begin : gen_region
    always_ff @(posedge clk_i) begin
      if (taken_q[3+RegionRowBeat]) region_row <= region_i[15:0];
      if (taken_q[3+RegionColumnBeat]) region_column <= region_i[31:16];
    end
  end else begin : gen_no_region
    logic unused;

    assign region_row    = 16'd0;
    assign region_column = 16'd0;
    assign unused        = ^region_i;
  end

  // Pixels of more than 8 bits: how many more, and the upper bits of the threshold. Words of tall
  // images: that they are.
  localparam logic [7:0] Tall = 8'(RowBits > $clog2(sp_spec_pkg::MaxRows + 1))
                                << sp_spec_pkg::HeaderPixelTallLsb;
  if (PixelBits > 8) begin : gen_pixel
    logic [PixelBits-9:0] threshold_high_q;
    always_ff @(posedge clk_i) begin
      if (taken_q[3+PixelBeat]) threshold_high_q <= threshold_i[PixelBits-1:8];
    end
    assign pixel = Tall | 8'(PixelBits - 8) << sp_spec_pkg::HeaderPixelMoreBitsLsb |
                   8'(threshold_high_q) << sp_spec_pkg::HeaderPixelThresholdHighLsb;
  end else begin : gen_no_pixel
    assign pixel = Tall;
  end

  // The kind of the frame's packet, only where there are several, and the flag of a verdict
  logic [7:0] kind;
  logic       compact, alone, verdict;  // columns divided; a verdict alone; one behind the columns
  if (Compact) begin : gen_compact
    logic compact_q;
    always_ff @(posedge clk_i) begin
      if (taken_q[3+KindBeat]) compact_q <= compact_i && mode_i != sp_spec_pkg::ModeBinary;
    end
    assign compact = compact_q;
  end else begin : gen_no_compact
    logic unused;

    assign compact = 1'b0;
    assign unused  = compact_i;
  end
  if (Verdict) begin : gen_verdict
    logic alone_q, verdict_q;
    always_ff @(posedge clk_i) begin
      if (taken_q[3+KindBeat]) alone_q <= verdict_i[1];
      if (taken_q[3+FlagsBeat]) verdict_q <= verdict_i[0];
    end
    assign {alone, verdict} = {alone_q, verdict_q};
    logic unused;
    assign unused = verdict_i[2];
  end else begin : gen_no_verdict
    logic unused;

    assign {alone, verdict} = 2'b00;
    assign unused           = ^verdict_i;
  end
  assign kind = !Compact && !Verdict ? 8'd0 : alone ? sp_spec_pkg::KindVerdict :
                compact ? sp_spec_pkg::KindCompact : sp_spec_pkg::KindMoments;

  always_comb begin
    info_o = '0;
    info_o[sp_spec_pkg::HeaderKindLsb+:8]                = kind;
    info_o[sp_spec_pkg::HeaderStreamLsb+:8]              = stream_q;
    info_o[sp_spec_pkg::HeaderPatternLsb+:16]            = pattern;
    info_o[sp_spec_pkg::HeaderModeLsb+:2]                = mode_q;
    info_o[sp_spec_pkg::HeaderThresholdLsb+:8]           = threshold_q;
    info_o[sp_spec_pkg::HeaderPixelLsb+:8]               = pixel;
    info_o[sp_spec_pkg::HeaderSequenceLsb+:64]           = sequence_number;
    info_o[sp_spec_pkg::HeaderTimeStampLsb+:64]          = time_stamp;
    info_o[sp_spec_pkg::HeaderEncoderLsb+:32]            = encoder;
    info_o[sp_spec_pkg::HeaderColumnsLsb+:ColumnBits]    = columns_q;
    info_o[sp_spec_pkg::HeaderRowsLsb+:RowBits]          = rows_q;
    info_o[sp_spec_pkg::HeaderLinesLsb+:RowBits]         = lines_q;
    info_o[sp_spec_pkg::HeaderSelectLsb]                 = strongest_q;
    info_o[sp_spec_pkg::HeaderGapLsb+:2]                 = gap_q;
    info_o[sp_spec_pkg::HeaderFirstRowLsb+:RowBits]      = first_row_q;
    info_o[sp_spec_pkg::HeaderLastRowLsb+:RowBits]       = last_row_q;
    info_o[sp_spec_pkg::HeaderRegionRowLsb+:16]          = region_row;
    info_o[sp_spec_pkg::HeaderRegionColumnLsb+:16]       = region_column;
    info_o[sp_spec_pkg::HeaderFlagsLsb+sp_spec_pkg::FlagStrayBeforeBit] = stray_before_q;
    info_o[sp_spec_pkg::HeaderFlagsLsb+sp_spec_pkg::FlagVerdictBit]     = verdict;
  end

endmodule

`default_nettype wire
