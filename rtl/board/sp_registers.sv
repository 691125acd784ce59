// Register file, in the video clock. The specification places addresses, fields and reset values
// (sp_spec_pkg).
//
// Guarantees: request_i lasts one clock. answer_o comes five clocks later, when a write has taken
// effect. error_o comes with it if the address has no register, a read-only register is written,
// this build cannot do the value, or the sequencer is at work (below); the register then keeps its
// value. Bits outside all fields are ignored, except in size, where they must be 0. hold_o is high
// during every write. A request stands still until its answer, and there is one at a time, so
// nothing overflows.
//
// What sp_trigger cannot take while it works, it is never given: while trigger_run_o is high,
// trigger_period, trigger_camera and trigger_width refuse every write. While trigger_run_o or
// trigger_on_frame_o is high, trigger_control refuses every write that does not clear both.
//
//   clock       0   1   2   3   4   5   6
//   request_i  _/1\_______________________   write_i, address_i, data_i stand until the answer
//   hit_q      ---------<   >-------------   the register that is asked for
//   put_q      _____________/1\___________   a write: that register takes data_i
//   settings   -----------------<new         new from the clock before the answer on
//   answer_o   _____________________/1\___   with error_o, and data_o of a read
`default_nettype none

module sp_registers #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 4..4096; of Lanes
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 1..2047
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  parameter bit Grey = 1'b1,
  parameter bit Runs = 1'b0,  // the strongest run of a column
  parameter bit Image = 1'b1,
  parameter bit Region = 1'b0,  // the register region
  parameter bit Compact = 1'b0,  // the register compact
  parameter bit Verdict = 1'b0,  // only reported: sp_verdict_registers has its registers
  parameter bit Codes = 1'b0,  // Gray-code decoder
  parameter bit Median = 1'b0,
  parameter int MaxBits = sp_spec_pkg::CodeCodeBits,  // 1..12
  // derived, do not set
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  input  wire logic                   request_i,
  input  wire logic                   write_i,
  input  wire logic [7:0]             address_i,
  input  wire logic [31:0]            data_i,
  output logic                        answer_o,
  output logic                        error_o,
  output logic [31:0]                 data_o,

  // Settings
  output logic                        run_o,
  // also high in the first clock of new settings and the two before
  output logic                        hold_o,
  output logic                        image_o,
  output logic      [ColumnBits-1:0]  columns_o,
  output logic      [RowBits-1:0]     rows_o,
  output logic      [1:0]             mode_o,
  output logic      [PixelBits-1:0]   threshold_o,
  output logic      [7:0]             stream_o,
  output logic      [2*RowBits+2:0]   select_o,  // {last row that counts, first, strongest, gap}
  output logic      [31:0]            region_o,  // {column, row}; 0 without Region
  output logic                        compact_o,  // 0 without Compact
  output logic      [23:0]            timeout_o,
  output logic                        trigger_run_o,
  output logic                        trigger_on_frame_o,
  output logic      [7:0]             trigger_last_pattern_o,
  output logic      [23:0]            trigger_period_o,
  output logic      [23:0]            trigger_camera_o,
  output logic      [15:0]            trigger_width_o,
  output logic                        decode_o,
  output logic                        median_o,
  output logic      [3:0]             bits_o,
  output logic      [7:0]             code_threshold_o,

  // State
  input  wire logic                   frame_open_i,
  // sp_frame_tracker takes the settings over with the end of this clock
  input  wire logic                   take_i,
  input  wire logic [31:0]            frames_i,
  input  wire logic [31:0]            broken_i,
  input  wire logic [31:0]            stray_i,
  input  wire logic [31:0]            lost_moments_i,
  input  wire logic [31:0]            lost_image_i,
  input  wire logic [31:0]            lost_codes_i,
  input  wire logic [31:0]            abandoned_i,
  input  wire logic [63:0]            time_i,
  input  wire logic [31:0]            encoder_i,
  input  wire logic [15:0]            encoder_errors_i
);

  if (MaxColumns < Lanes || MaxColumns > sp_spec_pkg::ColumnLimit || MaxColumns % Lanes != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_lanes_up_to_4096 u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end
  if (MaxRows < 1 || MaxRows > sp_spec_pkg::RowLimit) begin : gen_max_rows
    max_rows_is_not_in_1_to_2047 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end
  if (MaxBits < 1 || MaxBits > sp_spec_pkg::CodeCodeBits) begin : gen_max_bits
    max_bits_is_not_in_1_to_12 u_error ();
  end

  localparam int SizeColumnsLsb = sp_spec_pkg::RegSizeColumnsLsb,
                 SizeColumnsBits = sp_spec_pkg::RegSizeColumnsBits;
  localparam int SizeRowsLsb = sp_spec_pkg::RegSizeRowsLsb,
                 SizeRowsBits = sp_spec_pkg::RegSizeRowsBits;
  localparam int ModeLsb = sp_spec_pkg::RegMeasureModeLsb,
                 ModeBits = sp_spec_pkg::RegMeasureModeBits;
  localparam int ThresholdLsb = sp_spec_pkg::RegMeasureThresholdLsb,
                 ThresholdHighLsb = sp_spec_pkg::RegMeasureThresholdHighLsb,
                 ThresholdHighBits = sp_spec_pkg::RegMeasureThresholdHighBits;
  localparam int SelectLsb = sp_spec_pkg::RegMeasureSelectLsb,
                 GapLsb = sp_spec_pkg::RegMeasureGapLsb;
  localparam int WindowFirstLsb = sp_spec_pkg::RegWindowFirstLsb,
                 WindowLastLsb = sp_spec_pkg::RegWindowLastLsb,
                 // its highest bit only where rows need it
                 WindowBits = sp_spec_pkg::RegWindowFirstBits - 32'(MaxRows <= sp_spec_pkg::MaxRows);
  localparam int DecodeBitsLsb = sp_spec_pkg::RegDecodeBitsLsb,
                 DecodeBitsBits = sp_spec_pkg::RegDecodeBitsBits;
  // Width of each of the two with the unused bits above it, which must be 0
  localparam int SizeColumnsSpan = (SizeColumnsLsb < SizeRowsLsb ? SizeRowsLsb : 32) -
                                   SizeColumnsLsb;
  localparam int SizeRowsSpan = (SizeRowsLsb < SizeColumnsLsb ? SizeColumnsLsb : 32) - SizeRowsLsb;

  localparam int SpecColumns = 32'(sp_spec_pkg::RegSizeReset[SizeColumnsLsb+:SizeColumnsBits]);
  localparam int SpecRows = 32'(sp_spec_pkg::RegSizeReset[SizeRowsLsb+:SizeRowsBits]);
  localparam logic [ColumnBits-1:0] ResetColumns =
      ColumnBits'(SpecColumns < MaxColumns ? SpecColumns : MaxColumns);
  localparam logic [RowBits-1:0] ResetRows = RowBits'(SpecRows < MaxRows ? SpecRows : MaxRows);

  // --- Request, two clocks later: its register, one of 32, and whether its data is good ---
  localparam int Words = 32;
  // The registers that this build has, by words
  localparam logic [Words-1:0] CodesWords = Words'(1) << sp_spec_pkg::RegDecode / 4 |
                                            Words'(1) << sp_spec_pkg::RegLostCodes / 4 |
                                            Words'(1) << sp_spec_pkg::RegAbandoned / 4;
  localparam logic [Words-1:0] RegionWords = Words'(1) << sp_spec_pkg::RegRegion / 4;
  localparam logic [Words-1:0] CompactWords = Words'(1) << sp_spec_pkg::RegCompact / 4;
  localparam logic [Words-1:0] Present = sp_spec_pkg::RegisterWords &
                                         ~(Codes ? {Words{1'b0}} : CodesWords) &
                                         ~(Region ? {Words{1'b0}} : RegionWords) &
                                         ~(Compact ? {Words{1'b0}} : CompactWords);
  // no gap between them, so their end is enough
  localparam bit NoHoles = (Present & (Present + Words'(1))) == '0;
  localparam logic [7:0] LastRegister = 8'(4 * ($clog2({1'b0, Present} + (Words + 1)'(1)) - 1));

  logic [4:0]       asked_q;    // the request, one to five clocks ago, the latest lowest
  logic             there_q;    // this build has the register
  logic [Words-1:0] hit_q;
  logic             read_good_q;
  logic             size_good_q, measure_good_q, window_good_q, image_good_q, period_good_q;
  logic             decode_good_q;
  logic             image_wanted, trigger_wanted;
  logic             hold_q;     // as written
  logic             pending_q;  // settings were written and not yet taken over
  logic             rst_q;      // one clock ago

  // What this build can do
  localparam int ColumnsShown = MaxColumns % 2 ** sp_spec_pkg::RegCapabilityMaxColumnsBits;
  localparam int RowsShown = MaxRows > sp_spec_pkg::MaxRows ? 0 : MaxRows;
  localparam logic [31:0] Capability = 32'(ColumnsShown) << sp_spec_pkg::RegCapabilityMaxColumnsLsb |
                                       32'(RowsShown) << sp_spec_pkg::RegCapabilityMaxRowsLsb |
                                       32'(Grey) << sp_spec_pkg::RegCapabilityGreyLsb |
                                       32'(Runs) << sp_spec_pkg::RegCapabilityRunsLsb |
                                       32'(Region) << sp_spec_pkg::RegCapabilityRegionLsb |
                                       32'(Image) << sp_spec_pkg::RegCapabilityImageLsb |
                                       32'(Codes) << sp_spec_pkg::RegCapabilityCodesLsb |
                                       32'(Codes && Median) << sp_spec_pkg::RegCapabilityMedianLsb |
                                       32'(Codes ? MaxBits : 0)
                                           << sp_spec_pkg::RegCapabilityCodeBitsLsb;

  // Writes, one clock later still
  localparam int WriteControl = 0, WriteSize = 1, WriteMeasure = 2, WriteDecode = 3,
                 WriteTimeout = 4, WriteTrigger = 5, WritePeriod = 6, WriteCamera = 7,
                 WriteWidth = 8, WriteWindow = 9, Others = 10;
  localparam int WriteRegion = Region ? Others : 0;  // with Region
  localparam int WriteCompact = Compact ? Others + 32'(Region) : 0;  // with Compact
  localparam int Writes = Others + 32'(Region) + 32'(Compact);
  // This register takes data_i: one bit for one clock, or none. In reset all are set, and every
  // register takes its reset value; so this bit alone is its enable.
  logic [Writes-1:0] put_q;

  assign image_wanted   = data_i[sp_spec_pkg::RegControlImageLsb];
  assign trigger_wanted = data_i[sp_spec_pkg::RegTriggerControlRunLsb] ||
                          data_i[sp_spec_pkg::RegTriggerControlOnFrameLsb];
  assign answer_o       = asked_q[4];

  // In reset hold_o is high, because the size of the reset is new. Reset lasts four clocks, so it
  // passes through the middle bits of asked_q by itself.
  always_ff @(posedge clk_i) begin
    rst_q        <= rst_i;
    asked_q[0]   <= rst_i ? 1'b0 : request_i;
    asked_q[3:1] <= asked_q[2:0];
    asked_q[4]   <= rst_i ? 1'b0 : asked_q[3];
    hold_o       <= rst_i || asked_q[2:0] != '0 && write_i || hold_q;
    pending_q    <= put_q[WriteControl] || put_q[WriteSize] || put_q[WriteMeasure] ||
                    put_q[WriteDecode] || put_q[WriteWindow] || Region && put_q[WriteRegion] ||
                    Compact && put_q[WriteCompact] ||
                    pending_q && !take_i;
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      put_q              <= '1;
      put_q[WriteDecode] <= Codes;
    end else begin
      put_q <= '0;
      if (asked_q[1] && write_i) begin
        put_q[WriteControl] <= hit_q[sp_spec_pkg::RegControl/4] && image_good_q;
        put_q[WriteSize]    <= hit_q[sp_spec_pkg::RegSize/4] && size_good_q;
        put_q[WriteMeasure] <= hit_q[sp_spec_pkg::RegMeasure/4] && measure_good_q;
        put_q[WriteDecode]  <= hit_q[sp_spec_pkg::RegDecode/4] && decode_good_q;
        put_q[WriteWindow]  <= hit_q[sp_spec_pkg::RegWindow/4] && window_good_q;
        put_q[WriteTimeout] <= hit_q[sp_spec_pkg::RegTimeout/4];
        if (Region) put_q[WriteRegion] <= hit_q[sp_spec_pkg::RegRegion/4];
        if (Compact) put_q[WriteCompact] <= hit_q[sp_spec_pkg::RegCompact/4];
        put_q[WriteTrigger] <= hit_q[sp_spec_pkg::RegTriggerControl/4] &&
                               !((trigger_run_o || trigger_on_frame_o) && trigger_wanted);
        put_q[WritePeriod]  <= hit_q[sp_spec_pkg::RegTriggerPeriod/4] && period_good_q &&
                               !trigger_run_o;
        put_q[WriteCamera]  <= hit_q[sp_spec_pkg::RegTriggerCamera/4] && !trigger_run_o;
        put_q[WriteWidth]   <= hit_q[sp_spec_pkg::RegTriggerWidth/4] && !trigger_run_o;
      end
    end
  end

  // --- Writes ---
  logic [31:0] control_data, measure_data, trigger_data;
  assign control_data = rst_q ? sp_spec_pkg::RegControlReset : data_i;
  assign measure_data = rst_q ? sp_spec_pkg::RegMeasureReset : data_i;
  assign trigger_data = rst_q ? sp_spec_pkg::RegTriggerControlReset : data_i;
  always_ff @(posedge clk_i) begin
    if (put_q != '0) begin
      if (put_q[WriteControl]) begin
        run_o   <= control_data[sp_spec_pkg::RegControlRunLsb];
        hold_q  <= control_data[sp_spec_pkg::RegControlHoldLsb];
        image_o <= control_data[sp_spec_pkg::RegControlImageLsb];
      end
      if (put_q[WriteSize]) begin
        columns_o <= rst_q ? ResetColumns : data_i[sp_spec_pkg::RegSizeColumnsLsb+:ColumnBits];
        rows_o    <= rst_q ? ResetRows : data_i[sp_spec_pkg::RegSizeRowsLsb+:RowBits];
      end
      if (put_q[WriteMeasure]) begin
        threshold_o <= PixelBits'({measure_data[ThresholdHighLsb+:ThresholdHighBits],
                                   measure_data[ThresholdLsb+:8]});
        mode_o      <= measure_data[ModeLsb+:ModeBits];
        stream_o    <= measure_data[sp_spec_pkg::RegMeasureStreamLsb+:8];
        select_o[2:0] <= Runs ? {measure_data[SelectLsb], measure_data[GapLsb+:2]} : 3'd0;
      end
      if (put_q[WriteWindow]) begin
        select_o[3+:2*RowBits] <=
            rst_q ? '0 : {data_i[WindowLastLsb+:RowBits], data_i[WindowFirstLsb+:RowBits]};
      end
      if (put_q[WriteTimeout]) begin
        timeout_o <= rst_q ? sp_spec_pkg::RegTimeoutReset[sp_spec_pkg::RegTimeoutClocksLsb+:24] :
                     data_i[sp_spec_pkg::RegTimeoutClocksLsb+:24];
      end
      if (put_q[WriteTrigger]) begin
        trigger_run_o          <= trigger_data[sp_spec_pkg::RegTriggerControlRunLsb];
        trigger_on_frame_o     <= trigger_data[sp_spec_pkg::RegTriggerControlOnFrameLsb];
        trigger_last_pattern_o <= trigger_data[sp_spec_pkg::RegTriggerControlLastPatternLsb+:8];
      end
      if (put_q[WritePeriod]) begin
        trigger_period_o <=
            rst_q ? sp_spec_pkg::RegTriggerPeriodReset[sp_spec_pkg::RegTriggerPeriodClocksLsb+:24] :
            data_i[sp_spec_pkg::RegTriggerPeriodClocksLsb+:24];
      end
      if (put_q[WriteCamera]) begin
        trigger_camera_o <=
            rst_q ? sp_spec_pkg::RegTriggerCameraReset[sp_spec_pkg::RegTriggerCameraClocksLsb+:24] :
            data_i[sp_spec_pkg::RegTriggerCameraClocksLsb+:24];
      end
      if (put_q[WriteWidth]) begin
        trigger_width_o <=
            rst_q ? sp_spec_pkg::RegTriggerWidthReset[sp_spec_pkg::RegTriggerWidthClocksLsb+:16] :
            data_i[sp_spec_pkg::RegTriggerWidthClocksLsb+:16];
      end
    end
  end

  // --- Reads take three clocks: one of twelve pairs of words (the others are zero), then eight of
  // the pairs, then all ---
  logic [31:0] fixed_q, control_q, size_q, period_q, width_q, frames_q, broken_q, lost_q, codes_q,
      time_q, encoder_q, decode_q;
  logic [31:0] set_q, moving_q;  // four pairs each
  logic [31:0] time_high_q;
  logic [31:0] control_word, size_word, measure_word, trigger_word, status_word, decode_word;
  logic [31:0] timeout_word, period_word, camera_word, width_word, errors_word, window_word;
  logic [31:0] decode_or_region, last_words;

  assign control_word = 32'(run_o) << sp_spec_pkg::RegControlRunLsb |
                        32'(hold_q) << sp_spec_pkg::RegControlHoldLsb |
                        32'(image_o) << sp_spec_pkg::RegControlImageLsb;
  assign size_word    = 32'(columns_o) << sp_spec_pkg::RegSizeColumnsLsb |
                        32'(rows_o) << sp_spec_pkg::RegSizeRowsLsb;
  assign measure_word = 32'(threshold_o[7:0]) << ThresholdLsb |
                        (32'(threshold_o) >> 8) << ThresholdHighLsb |
                        32'(mode_o) << ModeLsb | 32'(select_o[2]) << SelectLsb |
                        32'(select_o[1:0]) << GapLsb |
                        32'(stream_o) << sp_spec_pkg::RegMeasureStreamLsb;
  assign trigger_word = 32'(trigger_run_o) << sp_spec_pkg::RegTriggerControlRunLsb |
                        32'(trigger_on_frame_o) << sp_spec_pkg::RegTriggerControlOnFrameLsb |
                        32'(trigger_last_pattern_o) << sp_spec_pkg::RegTriggerControlLastPatternLsb;
  assign window_word  = 32'(select_o[3+:RowBits]) << WindowFirstLsb |
                        32'(select_o[3+RowBits+:RowBits]) << WindowLastLsb;
  assign timeout_word = 32'(timeout_o) << sp_spec_pkg::RegTimeoutClocksLsb;
  assign period_word  = 32'(trigger_period_o) << sp_spec_pkg::RegTriggerPeriodClocksLsb;
  assign camera_word  = 32'(trigger_camera_o) << sp_spec_pkg::RegTriggerCameraClocksLsb;
  assign width_word   = 32'(trigger_width_o) << sp_spec_pkg::RegTriggerWidthClocksLsb;
  assign errors_word  = 32'(encoder_errors_i) << sp_spec_pkg::RegEncoderErrorsCountLsb;
  assign status_word  = 32'($clog2(Lanes) - 2) << sp_spec_pkg::RegStatusLanesLsb |
                        32'(PixelBits - 8) << sp_spec_pkg::RegStatusMoreBitsLsb |
                        32'(Compact) << sp_spec_pkg::RegStatusCompactLsb |
                        32'(Verdict) << sp_spec_pkg::RegStatusVerdictLsb |
                        32'(frame_open_i) << sp_spec_pkg::RegStatusFrameOpenLsb |
                        32'(pending_q) << sp_spec_pkg::RegStatusPendingLsb;
  assign decode_word  = 32'(code_threshold_o) << sp_spec_pkg::RegDecodeThresholdLsb |
                        32'(bits_o) << sp_spec_pkg::RegDecodeBitsLsb |
                        32'(decode_o) << sp_spec_pkg::RegDecodeCodesLsb |
                        32'(median_o) << sp_spec_pkg::RegDecodeMedianLsb;

  logic window_fits;
  if (MaxRows == (1 << WindowBits) - 1) begin : gen_any_row
    assign window_fits = 1'b1;
  end else begin : gen_limit
    assign window_fits = data_i[WindowFirstLsb+:WindowBits] <= WindowBits'(MaxRows) &&
                         data_i[WindowLastLsb+:WindowBits] <= WindowBits'(MaxRows);
  end

  // The word, if its register is asked for
  function automatic logic [31:0] word_if(input logic hit, input logic [31:0] word);
    word_if = {32{hit}} & word;
  endfunction

  // With the low word, which time_q takes in this clock
  always_ff @(posedge clk_i) begin
    if (rst_q || asked_q[1] && !write_i && hit_q[sp_spec_pkg::RegTimeLow/4]) begin
      time_high_q <= rst_q ? 32'd0 : time_i[63:32];
    end
  end

  always_ff @(posedge clk_i) begin
    if (asked_q[0]) begin
      there_q <= address_i[1:0] == 2'd0 && address_i <= LastRegister &&
                 (NoHoles || Present[address_i[6:2]]);
      hit_q   <= {{(Words - 1) {1'b0}}, !address_i[7] && address_i[1:0] == 2'd0} << address_i[6:2];
      size_good_q    <= data_i[SizeColumnsLsb+:$clog2(Lanes)] == '0 &&
                        data_i[SizeColumnsLsb+:SizeColumnsSpan] != '0 &&
                        data_i[SizeColumnsLsb+:SizeColumnsSpan] <= SizeColumnsSpan'(MaxColumns) &&
                        data_i[SizeRowsLsb+:SizeRowsSpan] != '0 &&
                        data_i[SizeRowsLsb+:SizeRowsSpan] <= SizeRowsSpan'(MaxRows);
      measure_good_q <= (data_i[ModeLsb+:ModeBits] == sp_spec_pkg::ModeBinary ||
                         Grey && data_i[ModeLsb+:ModeBits] <= sp_spec_pkg::ModeGreyOver) &&
                        (Runs || !data_i[SelectLsb] && data_i[GapLsb+:2] == 2'd0) &&
                        (PixelBits == 8 ||
                         data_i[ThresholdHighLsb+:ThresholdHighBits] >> (PixelBits - 8) == '0);
      window_good_q  <= window_fits;
      image_good_q  <= Image || !image_wanted;
      period_good_q <= data_i[sp_spec_pkg::RegTriggerPeriodClocksLsb+:24] != 24'd0;
      decode_good_q  <= Codes && data_i[DecodeBitsLsb+:DecodeBitsBits] != '0 &&
                        data_i[DecodeBitsLsb+:DecodeBitsBits] <= DecodeBitsBits'(MaxBits) &&
                        (Median || !data_i[sp_spec_pkg::RegDecodeMedianLsb]);
    end
    if (asked_q[1]) begin
      read_good_q <= there_q && !write_i;
      fixed_q     <= word_if(hit_q[sp_spec_pkg::RegId/4], sp_spec_pkg::Magic) |
                     word_if(hit_q[sp_spec_pkg::RegVersion/4], 32'(sp_spec_pkg::SpecVersion)) |
                     word_if(hit_q[sp_spec_pkg::RegSpecHash/4], sp_spec_pkg::SpecHash) |
                     word_if(hit_q[sp_spec_pkg::RegCapability/4], Capability);
      control_q   <= word_if(hit_q[sp_spec_pkg::RegControl/4], control_word) |
                     word_if(hit_q[sp_spec_pkg::RegTriggerControl/4], trigger_word);
      size_q      <= word_if(hit_q[sp_spec_pkg::RegSize/4], size_word) |
                     word_if(hit_q[sp_spec_pkg::RegMeasure/4], measure_word);
      period_q    <= word_if(hit_q[sp_spec_pkg::RegTriggerPeriod/4], period_word) |
                     word_if(hit_q[sp_spec_pkg::RegTriggerCamera/4], camera_word);
      width_q     <= word_if(hit_q[sp_spec_pkg::RegTimeout/4], timeout_word) |
                     word_if(hit_q[sp_spec_pkg::RegTriggerWidth/4], width_word);
      frames_q    <= word_if(hit_q[sp_spec_pkg::RegStatus/4], status_word) |
                     word_if(hit_q[sp_spec_pkg::RegFrames/4], frames_i);
      broken_q    <= word_if(hit_q[sp_spec_pkg::RegBroken/4], broken_i) |
                     word_if(hit_q[sp_spec_pkg::RegStray/4], stray_i);
      lost_q      <= word_if(hit_q[sp_spec_pkg::RegLostMoments/4], lost_moments_i) |
                     word_if(hit_q[sp_spec_pkg::RegLostImage/4], lost_image_i);
      codes_q     <= word_if(Codes && hit_q[sp_spec_pkg::RegLostCodes/4], lost_codes_i) |
                     word_if(Codes && hit_q[sp_spec_pkg::RegAbandoned/4], abandoned_i);
      time_q      <= word_if(hit_q[sp_spec_pkg::RegTimeLow/4], time_i[31:0]) |
                     word_if(hit_q[sp_spec_pkg::RegTimeHigh/4], time_high_q);
      encoder_q   <= word_if(hit_q[sp_spec_pkg::RegEncoder/4], encoder_i) |
                     word_if(hit_q[sp_spec_pkg::RegEncoderErrors/4], errors_word);
      decode_q    <= word_if(Codes && hit_q[sp_spec_pkg::RegDecode/4], decode_word) |
                     word_if(hit_q[sp_spec_pkg::RegWindow/4], window_word);
    end
    if (asked_q[2]) begin
      error_o  <= put_q == '0 && !read_good_q;
      set_q    <= control_q | size_q | period_q | width_q;
      moving_q <= fixed_q | frames_q | time_q | encoder_q;
    end
    if (asked_q[3]) data_o <= set_q | moving_q | broken_q | lost_q | codes_q | last_words;
  end

  // --- Region: a build without it has nothing to set ---
  if (Region) begin : gen_region
    logic [31:0] region_q;  // its word, if it is asked for

    always_ff @(posedge clk_i) begin
      if (put_q[WriteRegion]) region_o <= rst_q ? sp_spec_pkg::RegRegionReset : data_i;
      if (asked_q[1]) region_q <= word_if(hit_q[sp_spec_pkg::RegRegion/4], region_o);
    end
    assign decode_or_region = decode_q | region_q;
  end else begin : gen_no_region
    assign region_o         = 32'd0;
    assign decode_or_region = decode_q;
  end

  // --- Compact columns: likewise ---
  if (Compact) begin : gen_compact
    logic compact_q;  // the bit, if its word is asked for

    always_ff @(posedge clk_i) begin
      if (put_q[WriteCompact]) begin
        compact_o <= rst_q ? sp_spec_pkg::RegCompactReset[sp_spec_pkg::RegCompactOnLsb] :
                     data_i[sp_spec_pkg::RegCompactOnLsb];
      end
      if (asked_q[1]) compact_q <= hit_q[sp_spec_pkg::RegCompact/4] && compact_o;
    end
    assign last_words = decode_or_region | 32'(compact_q) << sp_spec_pkg::RegCompactOnLsb;
  end else begin : gen_no_compact
    assign compact_o  = 1'b0;
    assign last_words = decode_or_region;
  end

  // --- Decoder: a build without one has nothing to set ---
  if (Codes) begin : gen_codes
    localparam int SpecBits = 32'(sp_spec_pkg::RegDecodeReset[sp_spec_pkg::RegDecodeBitsLsb+:4]);
    localparam logic [3:0] ResetBits = 4'(SpecBits < MaxBits ? SpecBits : MaxBits);

    always_ff @(posedge clk_i) begin
      if (put_q[WriteDecode]) begin
        if (rst_q) begin
          decode_o         <= sp_spec_pkg::RegDecodeReset[sp_spec_pkg::RegDecodeCodesLsb];
          median_o         <= sp_spec_pkg::RegDecodeReset[sp_spec_pkg::RegDecodeMedianLsb];
          bits_o           <= ResetBits;
          code_threshold_o <= sp_spec_pkg::RegDecodeReset[sp_spec_pkg::RegDecodeThresholdLsb+:8];
        end else begin
          decode_o         <= data_i[sp_spec_pkg::RegDecodeCodesLsb];
          median_o         <= data_i[sp_spec_pkg::RegDecodeMedianLsb];
          bits_o           <= data_i[sp_spec_pkg::RegDecodeBitsLsb+:4];
          code_threshold_o <= data_i[sp_spec_pkg::RegDecodeThresholdLsb+:8];
        end
      end
    end
  end else begin : gen_no_codes
    logic unused;

    assign decode_o         = 1'b0;
    assign median_o         = 1'b0;
    assign bits_o           = 4'd0;
    assign code_threshold_o = 8'd0;
    assign unused           = ^{lost_codes_i, abandoned_i};
  end

`ifdef FORMAL
  // One reset at the beginning, for four clocks.
  logic [3:0] f_reset_q = 4'd0;
  logic       f_ran_q;
  assign f_ran_q = f_reset_q[3];
  always_ff @(posedge clk_i) f_reset_q <= {f_reset_q[2:0], 1'b1};
  always_comb assume (rst_i == !f_ran_q);
  // One request at a time, for one clock; it stands still until its answer (sp_axil_bridge).
  logic f_busy_q;
  always_ff @(posedge clk_i) f_busy_q <= !rst_i && (request_i || f_busy_q && !answer_o);
  logic [40:0] f_asked_q;  // the request, one clock ago
  always_ff @(posedge clk_i) f_asked_q <= {write_i, address_i, data_i};
  always_comb if (f_busy_q) begin
    assume (!request_i);
    assume ({write_i, address_i, data_i} == f_asked_q);
  end

  // hold_o, so many clocks ago
  logic [2:1] f_hold_q;
  always_ff @(posedge clk_i) f_hold_q <= rst_i ? 2'b11 : {f_hold_q[1], hold_o};

  // Rule 1: the settings of sp_trigger stand still while it works.
  // Rule 2: hold_o is high in the first clock of new settings and in the two before it.
  always_ff @(posedge clk_i) if (f_ran_q && !rst_q && !$past(rst_q)) begin
    if (trigger_run_o) begin
      assert ($stable(trigger_period_o) && $stable(trigger_camera_o) && $stable(trigger_width_o));
    end
    if ((trigger_run_o || trigger_on_frame_o) && $past(trigger_run_o || trigger_on_frame_o)) begin
      assert ($stable(trigger_run_o) && $stable(trigger_on_frame_o));
      assert ($stable(trigger_last_pattern_o));
    end
    if (!($stable(columns_o) && $stable(rows_o) && $stable(mode_o) && $stable(threshold_o) &&
          $stable(stream_o) && $stable(select_o) && $stable(region_o) &&
          $stable(compact_o) && $stable(image_o) && $stable(decode_o) &&
          $stable(median_o) && $stable(bits_o) && $stable(code_threshold_o)))
      assert (hold_o && f_hold_q == 2'b11);
    cover (answer_o && error_o && write_i && trigger_run_o &&
           address_i == sp_spec_pkg::RegTriggerPeriod);
    cover (!$stable(trigger_last_pattern_o));
  end

  // Rule 3: a write that is answered with an error has changed nothing: no register took it.
  // What it has changed could also be the word that a read of time_low keeps:
  // Rule 4: time_high is the upper word of the time in the clock of the last read of time_low.
  logic        f_took_q;
  logic [31:0] f_high_q;
  always_ff @(posedge clk_i) begin
    if (asked_q[2]) f_took_q <= put_q != '0;
    if (rst_q) f_high_q <= 32'd0;
    else if (asked_q[1] && !write_i && address_i == sp_spec_pkg::RegTimeLow)
      f_high_q <= time_i[63:32];
  end
  always_comb if (f_ran_q && !rst_q) begin
    assert (time_high_q == f_high_q);
    if (asked_q[1]) begin
      assert (hit_q[sp_spec_pkg::RegTimeLow/4] == (address_i == sp_spec_pkg::RegTimeLow));
    end
  end
  always_comb if (f_ran_q && !rst_q) begin
    if (asked_q[4:3] != '0 && write_i) assert (error_o == !f_took_q);
    assert ((asked_q & (asked_q - 5'd1)) == '0);
    assert (f_busy_q == (asked_q != '0));
    assert ((put_q & (put_q - Writes'(1))) == '0);
    if (put_q != '0) assert (asked_q[2] && write_i);
    if (asked_q[4:1] != '0) assert ((hit_q & (hit_q - Words'(1))) == '0);
    if (asked_q[2] && write_i) assert (!read_good_q);
    if (asked_q[2:1] != '0 && write_i) assert (hold_o);
    if (asked_q[2] && write_i) assert (f_hold_q[1]);
    if (asked_q[3] && write_i) assert (hold_o && f_hold_q == 2'b11);
    if (put_q[WritePeriod] || put_q[WriteCamera] || put_q[WriteWidth]) assert (!trigger_run_o);
    if (put_q[WriteTrigger]) begin
      assert (!(trigger_run_o || trigger_on_frame_o) || !trigger_wanted);
    end
  end
`endif

endmodule

`default_nettype wire
