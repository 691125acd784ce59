// The board between camera and bus: AXI4-Stream video in, packets out, registers on AXI4-Lite.
//
//   video ─▶ sp_frame_tracker ─┬▶ sp_moments_path ─┐
//                              ├▶ sp_codes_path ───┼▶ sp_packet_merge ─▶ packets
//   encoder ─▶ sp_frame_info ──┴▶ sp_image_path ───┘
//   sp_moments_path ─ sums ─▶ sp_verdict_unit ─ verdict ─▶ sp_moments_path, ejector
//   AXI4-Lite ─▶ sp_axil_bridge ─▶ sp_registers ─▶ settings
//
// Guarantees: every accepted frame start gives a moments packet or is counted as lost. Packets are
// whole. The camera is never stalled. Frames of equal settings need no gap if they have at least as
// many beats as a packet plus a few clocks; what is lost at shorter distances is counted.
`default_nettype none

module sp_board #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // image width: a multiple of 4, 12..4096; with more lanes of Lanes, from 3 Lanes on
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // image height: 2..1023, or 2047
  // Bits of a pixel: 8..12. With more than 8, images and codes are of the upper eight.
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  // Pixels in a beat. With more than 4, frames need more rows to follow each other without a gap: see
  // sp_payload_split, sp_image_path and sp_codes_path.
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // 4, 8 or 16
  parameter bit Grey = 1'b1,   // modes grey and grey_over
  parameter bit Runs = 1'b0,   // the strongest run of a column
  parameter bit Image = 1'b1,  // raw-image packets
  parameter bit Region = 1'b0,  // the register region: where on the sensor frames begin
  parameter bit Compact = 1'b0,  // columns divided in the circuit; only with Grey
  parameter bit Verdict = 1'b0,  // verdicts: registers, packets, the pin for an ejector
  parameter int VerdictLogSections = 2,  // log2 of the sections of a part: 0..6
  parameter bit Codes = 1'b0,  // Gray-code decoder, with on-chip memory for its state
  parameter bit CodesMedian = 1'b1,  // 3 x 3 median behind the decoder
  parameter int CodeBits = sp_spec_pkg::CodeCodeBits,  // largest number of code bits: 1..12
  // log2 of the depth of a packet FIFO, in beats of 16 bytes: 3..15; 9 fills a small block RAM
  parameter int MomentsLogDepth = MaxColumns > (Grey ? 512 : 1024) ?
                                  $clog2(MaxColumns * (Grey ? 3 : 2) / 4 + 5) : 9,
  parameter int ImageLogDepth = MaxColumns > 1952 ? $clog2(MaxColumns / 4 + 24) : 9,
  parameter int CodesLogDepth = MaxColumns > 976 ? $clog2(MaxColumns / 2 + 24) : 9
) (
  // Video, in the pixel clock
  input  wire logic         clk_i,                // pixel clock
  input  wire logic         rst_i,                // active high, synchronous, four clocks or more
  input  wire logic         s_axis_tvalid,        // a beat of Lanes pixels
  output logic              s_axis_tready,        // always 1: the camera is never stalled
  input  wire logic [Lanes*PixelBits-1:0] s_axis_tdata,  // leftmost pixel lowest
  input  wire logic         s_axis_tuser,         // start of frame: first beat of a frame
  input  wire logic         s_axis_tlast,         // end of line: last beat of every line
  input  wire logic         encoder_a_i,          // quadrature; any clock
  input  wire logic         encoder_b_i,          // A leads B: the count rises
  output logic              projector_trigger_o,  // pulse of the trigger sequencer
  output logic              camera_trigger_o,     // pulse of the trigger sequencer
  output logic              ejector_o,            // pulse behind a bad part; 0 without Verdict

  // Packets and registers, in the bus clock
  input  wire logic         bus_clk_i,            // bus clock
  input  wire logic         bus_rst_i,            // as rst_i; both resets together
  output logic              m_axis_tvalid,        // packets, AXI4-Stream
  input  wire logic         m_axis_tready,
  output logic      [127:0] m_axis_tdata,         // first byte of a beat in 7..0
  output logic              m_axis_tlast,         // last beat of a packet
  input  wire logic         s_axil_awvalid,       // registers, AXI4-Lite
  output logic              s_axil_awready,
  input  wire logic [7:0]   s_axil_awaddr,        // byte address
  input  wire logic         s_axil_wvalid,
  output logic              s_axil_wready,
  input  wire logic [31:0]  s_axil_wdata,
  input  wire logic [3:0]   s_axil_wstrb,         // must be 1111
  output logic              s_axil_bvalid,
  input  wire logic         s_axil_bready,
  output logic      [1:0]   s_axil_bresp,         // OKAY or SLVERR
  input  wire logic         s_axil_arvalid,
  output logic              s_axil_arready,
  input  wire logic [7:0]   s_axil_araddr,
  output logic              s_axil_rvalid,
  input  wire logic         s_axil_rready,
  output logic      [31:0]  s_axil_rdata,
  output logic      [1:0]   s_axil_rresp          // OKAY or SLVERR
);

  if (VerdictLogSections < 0 || VerdictLogSections > 6) begin : gen_verdict_log_sections
    verdict_log_sections_is_not_in_0_to_6 u_error ();
  end

  // Words of columns are then those of tall images, and headers say so.
  localparam bit Tall = MaxRows > sp_spec_pkg::MaxRows;
  if (Tall && MaxRows != sp_spec_pkg::RowLimit) begin : gen_max_rows
    max_rows_is_not_in_2_to_1023_or_2047 u_error ();
  end
  if (Tall && (PixelBits > 10 || Verdict)) begin : gen_tall
    more_than_1023_rows_exclude_more_than_10_bits_and_verdicts u_error ();
  end

  localparam int GroupBits = $clog2(MaxColumns / Lanes);
  localparam int ColumnBits = $clog2(MaxColumns + 1);
  localparam int RowBits = $clog2(MaxRows + 1);
  localparam int StatusBits = sp_spec_pkg::StatusBits;

  // --- Registers ---
  logic                  request, request_write, answer, answer_error;
  logic [7:0]            request_address;
  logic [31:0]           request_data, answer_data;
  logic                  set_run, set_hold, set_image, set_decode, set_median;
  logic [ColumnBits-1:0] set_columns;
  logic [RowBits-1:0]    set_rows;
  logic [1:0]            set_mode;
  logic [3:0]            set_bits;
  logic [PixelBits-1:0]  set_threshold, threshold;
  logic [7:0]            set_stream, set_code_threshold;
  logic [2*RowBits+2:0]  set_select, select;
  logic [31:0]           set_region, region;
  logic                  set_compact, compact;
  logic [2:0]            set_verdict, verdict;  // {on, packets}
  logic                  register_error, verdict_error;
  logic [31:0]           register_data, verdict_data;
  logic [23:0]           set_timeout, trigger_period, trigger_camera;
  logic                  trigger_run, trigger_on_frame, frame_open, taking;
  logic [7:0]            trigger_last_pattern;
  logic [15:0]           trigger_width, encoder_errors;
  logic [31:0]           frames, broken, stray, lost_moments, lost_image, lost_codes, abandoned,
                         encoder_count;
  logic [63:0]           time_now;

  sp_axil_bridge u_bridge (
    .bus_clk_i       (bus_clk_i),
    .bus_rst_i       (bus_rst_i),
    .s_axil_awvalid_i(s_axil_awvalid),
    .s_axil_awready_o(s_axil_awready),
    .s_axil_awaddr_i (s_axil_awaddr),
    .s_axil_wvalid_i (s_axil_wvalid),
    .s_axil_wready_o (s_axil_wready),
    .s_axil_wdata_i  (s_axil_wdata),
    .s_axil_wstrb_i  (s_axil_wstrb),
    .s_axil_bvalid_o (s_axil_bvalid),
    .s_axil_bready_i (s_axil_bready),
    .s_axil_bresp_o  (s_axil_bresp),
    .s_axil_arvalid_i(s_axil_arvalid),
    .s_axil_arready_o(s_axil_arready),
    .s_axil_araddr_i (s_axil_araddr),
    .s_axil_rvalid_o (s_axil_rvalid),
    .s_axil_rready_i (s_axil_rready),
    .s_axil_rdata_o  (s_axil_rdata),
    .s_axil_rresp_o  (s_axil_rresp),
    .clk_i           (clk_i),
    .rst_i           (rst_i),
    .request_o       (request),
    .write_o         (request_write),
    .address_o       (request_address),
    .write_data_o    (request_data),
    .answer_i        (answer),
    .error_i         (answer_error),
    .read_data_i     (answer_data)
  );

  sp_registers #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .PixelBits (PixelBits),
    .Lanes     (Lanes),
    .Grey      (Grey),
    .Runs      (Runs),
    .Image     (Image),
    .Region    (Region),
    .Compact   (Compact),
    .Verdict   (Verdict),
    .Codes     (Codes),
    .Median    (CodesMedian),
    .MaxBits   (CodeBits)
  ) u_registers (
    .clk_i                 (clk_i),
    .rst_i                 (rst_i),
    .request_i             (request),
    .write_i               (request_write),
    .address_i             (request_address),
    .data_i                (request_data),
    .answer_o              (answer),
    .error_o               (register_error),
    .data_o                (register_data),
    .run_o                 (set_run),
    .hold_o                (set_hold),
    .image_o               (set_image),
    .columns_o             (set_columns),
    .rows_o                (set_rows),
    .mode_o                (set_mode),
    .threshold_o           (set_threshold),
    .stream_o              (set_stream),
    .select_o              (set_select),
    .region_o              (set_region),
    .compact_o             (set_compact),
    .timeout_o             (set_timeout),
    .trigger_run_o         (trigger_run),
    .trigger_on_frame_o    (trigger_on_frame),
    .trigger_last_pattern_o(trigger_last_pattern),
    .trigger_period_o      (trigger_period),
    .trigger_camera_o      (trigger_camera),
    .trigger_width_o       (trigger_width),
    .decode_o              (set_decode),
    .median_o              (set_median),
    .bits_o                (set_bits),
    .code_threshold_o      (set_code_threshold),
    .frame_open_i          (frame_open),
    .take_i                (taking),
    .frames_i              (frames),
    .broken_i              (broken),
    .stray_i               (stray),
    .lost_moments_i        (lost_moments),
    .lost_image_i          (lost_image),
    .lost_codes_i          (lost_codes),
    .abandoned_i           (abandoned),
    .time_i                (time_now),
    .encoder_i             (encoder_count),
    .encoder_errors_i      (encoder_errors)
  );

  // Registers that are not in sp_registers are an error there, and read as 0.
  assign answer_error = register_error && verdict_error;
  assign answer_data  = register_data | verdict_data;

  // --- Frames ---
  logic                  take, captured, image, one_group, two_groups;
  logic [ColumnBits-1:0] columns;
  logic [RowBits-1:0]    rows;
  logic [1:0]            mode;
  logic [7:0]            stream;
  logic                  beat_valid, beat_first_row, beat_last_row, beat_line_start, beat_line_end;
  logic [Lanes*PixelBits-1:0] beat_pixels;
  logic [8*Lanes-1:0]    upper_pixels;  // the upper eight bits of each
  logic [GroupBits-1:0]  beat_group;
  logic [RowBits-1:0]    beat_row;
  logic                  frame_start, stray_before, last_row_start, frame_break, break_in_last_row;
  logic [StatusBits-1:0] break_status;

  sp_frame_tracker #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .PixelBits (PixelBits),
    .Lanes     (Lanes),
    .Region    (Region),
    .Compact   (Compact),
    .Verdict   (Verdict)
  ) u_tracker (
    .clk_i              (clk_i),
    .rst_i              (rst_i),
    .s_axis_tvalid_i    (s_axis_tvalid),
    .s_axis_tready_o    (s_axis_tready),
    .s_axis_tdata_i     (s_axis_tdata),
    .s_axis_tuser_i     (s_axis_tuser),
    .s_axis_tlast_i     (s_axis_tlast),
    .run_i              (set_run),
    .hold_i             (set_hold),
    .image_i            (set_image),
    .columns_i          (set_columns),
    .rows_i             (set_rows),
    .mode_i             (set_mode),
    .threshold_i        (set_threshold),
    .stream_i           (set_stream),
    .select_i           (set_select),
    .region_i           (set_region),
    .compact_i          (set_compact),
    .verdict_i          (set_verdict),
    .timeout_i          (set_timeout),
    .taking_o           (taking),
    .take_o             (take),
    .image_o            (image),
    .columns_o          (columns),
    .rows_o             (rows),
    .mode_o             (mode),
    .threshold_o        (threshold),
    .stream_o           (stream),
    .select_o           (select),
    .region_o           (region),
    .compact_o          (compact),
    .verdict_o          (verdict),
    .one_group_o        (one_group),
    .two_groups_o       (two_groups),
    .beat_valid_o       (beat_valid),
    .beat_pixels_o      (beat_pixels),
    .beat_group_o       (beat_group),
    .beat_row_o         (beat_row),
    .beat_first_row_o   (beat_first_row),
    .beat_last_row_o    (beat_last_row),
    .beat_line_start_o  (beat_line_start),
    .beat_line_end_o    (beat_line_end),
    .frame_start_o      (frame_start),
    .stray_before_o     (stray_before),
    .last_row_start_o   (last_row_start),
    .break_o            (frame_break),
    .break_in_last_row_o(break_in_last_row),
    .break_status_o     (break_status),
    .frame_open_o       (frame_open),
    .broken_o           (broken),
    .stray_o            (stray)
  );

  for (genvar lane = 0; lane < Lanes; lane++) begin : gen_upper
    assign upper_pixels[8*lane+:8] = beat_pixels[PixelBits*lane+PixelBits-8+:8];
  end

  // --- Encoder, trigger, header fields ---
  logic [15:0]           pattern_now, pattern_of_frame;
  logic [sp_spec_pkg::HeaderBits-1:0] info;

  sp_encoder u_encoder (
    .clk_i   (clk_i),
    .rst_i   (rst_i),
    .a_i     (encoder_a_i),
    .b_i     (encoder_b_i),
    .count_o (encoder_count),
    .errors_o(encoder_errors)
  );

  sp_trigger u_trigger (
    .clk_i         (clk_i),
    .rst_i         (rst_i),
    .set_i         (set_hold),
    .run_i         (trigger_run),
    .on_frame_i    (trigger_on_frame),
    .last_pattern_i(trigger_last_pattern),
    .period_i      (trigger_period),
    .camera_i      (trigger_camera),
    .width_i       (trigger_width),
    .captured_i    (captured),
    .projector_o   (projector_trigger_o),
    .camera_o      (camera_trigger_o),
    .pattern_o     (pattern_now)
  );

  sp_frame_info #(
    .ColumnBits(ColumnBits),
    .RowBits   (RowBits),
    .PixelBits (PixelBits),
    .Region    (Region),
    .Compact   (Compact),
    .Verdict   (Verdict)
  ) u_info (
    .clk_i         (clk_i),
    .rst_i         (rst_i),
    .frame_start_i (frame_start),
    .stray_before_i(stray_before),
    .take_i        (take),
    .columns_i     (columns),
    .rows_i        (rows),
    .mode_i        (mode),
    .threshold_i   (threshold),
    .stream_i      (stream),
    .select_i      (select),
    .region_i      (region),
    .compact_i     (compact),
    .verdict_i     (verdict),
    .encoder_i     (encoder_count),
    .pattern_i     (pattern_now),
    .time_o        (time_now),
    .frames_o      (frames),
    .captured_o    (captured),
    .pattern_o     (pattern_of_frame),
    .info_o        (info)
  );

  // --- Moments ---
  logic         moments_out_valid, moments_out_ready, moments_out_last;
  logic [127:0] moments_out_data;
  logic         decision, spoiled, judge_ready, judge, words_valid, words_break, verdict_valid;
  logic [127:0] words, verdict_word;

  sp_moments_path #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .PixelBits (PixelBits),
    .Lanes     (Lanes),
    .Grey      (Grey),
    .Runs      (Runs),
    .Region    (Region),
    .Compact   (Compact),
    .Verdict   (Verdict),
    .LogDepth  (MomentsLogDepth)
  ) u_moments_path (
    .clk_i              (clk_i),
    .rst_i              (rst_i),
    .groups_i           (columns[ColumnBits-1:2]),
    .mode_i             (mode),
    .threshold_i        (threshold),
    .select_i           (select),
    .compact_i          (compact),
    .verdict_i          (verdict),
    .one_group_i        (one_group),
    .two_groups_i       (two_groups),
    .beat_valid_i       (beat_valid),
    .beat_pixels_i      (beat_pixels),
    .beat_group_i       (beat_group),
    .beat_row_i         (beat_row),
    .beat_first_row_i   (beat_first_row),
    .beat_last_row_i    (beat_last_row),
    .beat_line_end_i    (beat_line_end),
    .last_row_start_i   (last_row_start),
    .break_i            (frame_break),
    .break_in_last_row_i(break_in_last_row),
    .break_status_i     (break_status),
    .info_i             (info),
    .lost_o             (lost_moments),
    .decision_o         (decision),
    .spoiled_o          (spoiled),
    .judge_ready_i      (judge_ready),
    .judge_i            (judge),
    .words_valid_o      (words_valid),
    .words_data_o       (words),
    .words_break_o      (words_break),
    .verdict_valid_i    (verdict_valid),
    .verdict_data_i     (verdict_word),
    .bus_clk_i          (bus_clk_i),
    .bus_rst_i          (bus_rst_i),
    .m_valid_o          (moments_out_valid),
    .m_ready_i          (moments_out_ready),
    .m_last_o           (moments_out_last),
    .m_data_o           (moments_out_data)
  );

  // --- Verdict ---
  if (Verdict) begin : gen_verdict
    sp_verdict_unit #(
      .MaxColumns (MaxColumns),
      .MaxRows    (MaxRows),
      .PixelBits  (PixelBits),
      .Grey       (Grey),
      .LogSections(VerdictLogSections)
    ) u_verdict (
      .clk_i          (clk_i),
      .rst_i          (rst_i),
      .request_i      (request),
      .write_i        (request_write),
      .address_i      (request_address),
      .data_i         (request_data),
      .error_o        (verdict_error),
      .data_o         (verdict_data),
      .set_o          (set_verdict),
      .frame_start_i  (frame_start),
      .on_i           (verdict[2]),
      .groups_i       (columns[ColumnBits-1:2]),
      .mode_i         (mode),
      .frame_encoder_i(info[sp_spec_pkg::HeaderEncoderLsb+:24]),
      .encoder_i      (encoder_count[23:0]),
      .decision_i     (decision),
      .spoiled_i      (spoiled),
      .ready_o        (judge_ready),
      .judge_o        (judge),
      .words_valid_i  (words_valid),
      .words_data_i   (words),
      .words_break_i  (words_break),
      .valid_o        (verdict_valid),
      .data_word_o    (verdict_word),
      .ejector_o      (ejector_o)
    );
  end else begin : gen_no_verdict
    logic unused_verdict;
    assign unused_verdict = ^{decision, spoiled, words_valid, words_break, words, verdict[2]};
    assign {verdict_data, set_verdict, judge_ready, judge, verdict_valid, verdict_word, ejector_o} = '0;
    assign verdict_error = 1'b1;
  end

  // --- Raw image ---
  logic         image_out_valid, image_out_ready, image_out_last;
  logic [127:0] image_out_data;
  if (Image) begin : gen_image
    sp_image_path #(
      .MaxColumns(MaxColumns),
      .MaxRows   (MaxRows),
      .Lanes     (Lanes),
      .Region    (Region),
      .Wide      (PixelBits > 8 || Tall),
      .LogDepth  (ImageLogDepth)
    ) u_image_path (
      .clk_i              (clk_i),
      .rst_i              (rst_i),
      .image_i            (image),
      .columns_i          (columns),
      .beat_valid_i       (beat_valid),
      .beat_pixels_i      (upper_pixels),
      .beat_group_i       (beat_group[1:0]),
      .beat_row_i         (beat_row),
      .beat_line_start_i  (beat_line_start),
      .beat_line_end_i    (beat_line_end),
      .break_i            (frame_break),
      .break_status_i     (break_status),
      .info_i             (info),
      .lost_o             (lost_image),
      .bus_clk_i          (bus_clk_i),
      .bus_rst_i          (bus_rst_i),
      .m_valid_o          (image_out_valid),
      .m_ready_i          (image_out_ready),
      .m_last_o           (image_out_last),
      .m_data_o           (image_out_data)
    );
  end else begin : gen_no_image
    logic unused;
    assign unused = ^{image, image_out_ready, beat_line_start, upper_pixels};
    assign {lost_image, image_out_valid, image_out_last, image_out_data} = '0;
  end

  // --- Codes ---
  logic         codes_out_valid, codes_out_ready, codes_out_last;
  logic [127:0] codes_out_data;
  if (Codes) begin : gen_codes
    sp_codes_path #(
      .MaxColumns(MaxColumns),
      .MaxRows   (MaxRows),
      .MaxBits   (CodeBits),
      .Lanes     (Lanes),
      .Median    (CodesMedian),
      .Region    (Region),
      .Wide      (PixelBits > 8 || Tall),
      .LogDepth  (CodesLogDepth)
    ) u_codes_path (
      .clk_i              (clk_i),
      .rst_i              (rst_i),
      .decode_i           (set_decode),
      .median_i           (set_median),
      .bits_i             (set_bits),
      .code_threshold_i   (set_code_threshold),
      .take_i             (take),
      .columns_i          (columns),
      .rows_i             (rows),
      .beat_valid_i       (beat_valid),
      .beat_pixels_i      (upper_pixels),
      .beat_line_start_i  (beat_line_start),
      .beat_line_end_i    (beat_line_end),
      .beat_last_row_i    (beat_last_row),
      .frame_start_i      (frame_start),
      .break_i            (frame_break),
      .break_status_i     (break_status),
      .pattern_i          (pattern_of_frame),
      .info_i             (info),
      .lost_o             (lost_codes),
      .abandoned_o        (abandoned),
      .bus_clk_i          (bus_clk_i),
      .bus_rst_i          (bus_rst_i),
      .m_valid_o          (codes_out_valid),
      .m_ready_i          (codes_out_ready),
      .m_last_o           (codes_out_last),
      .m_data_o           (codes_out_data)
    );
  end else begin : gen_no_codes
    logic unused;
    assign unused = ^{set_decode, set_median, set_bits, set_code_threshold, rows, pattern_of_frame,
                      codes_out_ready};
    assign {lost_codes, abandoned, codes_out_valid, codes_out_last, codes_out_data} = '0;
  end

  // --- The way out ---
  sp_packet_merge #(
    .Image(Image),
    .Codes(Codes)
  ) u_merge (
    .clk_i          (bus_clk_i),
    .rst_i          (bus_rst_i),
    .moments_valid_i(moments_out_valid),
    .moments_ready_o(moments_out_ready),
    .moments_last_i (moments_out_last),
    .moments_data_i (moments_out_data),
    .codes_valid_i  (codes_out_valid),
    .codes_ready_o  (codes_out_ready),
    .codes_last_i   (codes_out_last),
    .codes_data_i   (codes_out_data),
    .image_valid_i  (image_out_valid),
    .image_ready_o  (image_out_ready),
    .image_last_i   (image_out_last),
    .image_data_i   (image_out_data),
    .m_valid_o      (m_axis_tvalid),
    .m_ready_i      (m_axis_tready),
    .m_last_o       (m_axis_tlast),
    .m_data_o       (m_axis_tdata)
  );

endmodule

`default_nettype wire
