// From beats to code packets, one per line: the Gray-code decoder, the packer, the packets, and the
// packet FIFO into the bus clock.
//
// Guarantees: every line whose codes began gives a packet or is counted in lost_o; packets come out
// whole. Lines of 88 columns and more may follow each other without a gap; with 8 lanes they need a
// gap of 11 clocks, with 16 lanes and C columns one of C / 16 + 11.
//
// Codes come seven clocks after their pixels, or one line later with the median. By then the header
// fields of sp_frame_info may belong to a later frame. They are therefore held from the first codes
// of a frame on, each so late that the header before it is out (sp_frame_info says when headers
// read). If a later frame has started by then, which needs frames closer than that delay, the
// packets of the frame are dropped and counted.
`default_nettype none

module sp_codes_path #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4; of Lanes
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 1 or more
  parameter int MaxBits = sp_spec_pkg::CodeCodeBits,  // 1..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  parameter bit Median = 1'b1,
  parameter bit Region = 1'b1,  // headers say where on the sensor frames begin
  parameter bit Wide = 1'b0,  // headers have the byte pixel
  parameter int LogDepth = 9,  // log2 of the depth of the packet FIFO, in beats of 16 bytes: 3..15
  // derived, do not set
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  // Video clock domain
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // Settings as written that sp_frame_tracker does not take over
  input  wire logic                  decode_i,
  input  wire logic                  median_i,
  input  wire logic [3:0]            bits_i,
  input  wire logic [7:0]            code_threshold_i,

  // Beats, settings in force and breaks of sp_frame_tracker
  input  wire logic                  take_i,
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic [RowBits-1:0]    rows_i,
  input  wire logic                  beat_valid_i,
  input  wire logic [8*Lanes-1:0]    beat_pixels_i,
  input  wire logic                  beat_line_start_i,
  input  wire logic                  beat_line_end_i,
  input  wire logic                  beat_last_row_i,
  input  wire logic                  frame_start_i,
  input  wire logic                  break_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0]    break_status_i,

  input  wire logic [15:0]           pattern_i,  // of sp_frame_info
  input  wire logic [sp_spec_pkg::HeaderBits-1:0] info_i,  // of sp_frame_info

  output logic      [31:0]           lost_o,
  output logic      [31:0]           abandoned_o,

  // Bus clock domain: packets
  input  wire logic                  bus_clk_i,
  input  wire logic                  bus_rst_i,
  output logic                       m_valid_o,
  input  wire logic                  m_ready_i,
  output logic                       m_last_o,
  output logic      [127:0]          m_data_o
);

  localparam int StatusBits = sp_spec_pkg::StatusBits;
  localparam int PayloadBits = $clog2(MaxColumns / 8 + 2);

  // --- Settings: sp_frame_tracker takes over those of one clock before take_i ---
  logic       decode_q, median_q;
  logic [3:0] bits_q;
  logic [7:0] code_threshold_q;

  always_ff @(posedge clk_i) begin
    {decode_q, median_q, bits_q, code_threshold_q} <=
        {decode_i, median_i, bits_i, code_threshold_i};
  end

  // --- Codes ---
  logic                  raw_start, codes_valid, codes_start, codes_line_start, codes_line_end,
      codes_break;
  logic [16*Lanes-1:0]   codes;
  logic [StatusBits-1:0] codes_status;

  sp_gray_core #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .MaxBits   (MaxBits),
    .Lanes     (Lanes),
    .Median    (Median)
  ) u_core (
    .clk_i             (clk_i),
    .rst_i             (rst_i),
    .take_i            (take_i),
    .decode_i          (decode_q),
    .bits_i            (bits_q),
    .threshold_i       (code_threshold_q),
    .columns_i         (columns_i),
    .rows_i            (rows_i),
    .median_i          (median_q),
    .beat_valid_i      (beat_valid_i),
    .beat_pixels_i     (beat_pixels_i),
    .beat_line_start_i (beat_line_start_i),
    .beat_line_end_i   (beat_line_end_i),
    .beat_last_row_i   (beat_last_row_i),
    .frame_start_i     (frame_start_i),
    .break_i           (break_i),
    .break_status_i    (break_status_i),
    .pattern_i         (pattern_i),
    .raw_start_o       (raw_start),
    .codes_valid_o     (codes_valid),
    .codes_o           (codes),
    .codes_start_o     (codes_start),
    .codes_line_start_o(codes_line_start),
    .codes_line_end_o  (codes_line_end),
    .codes_break_o     (codes_break),
    .codes_status_o    (codes_status),
    .abandoned_o       (abandoned_o)
  );

  // --- Place of the codes ---
  logic               odd_q;  // low bit of the group
  logic [RowBits-1:0] row_q, row;

  assign row = codes_start ? RowBits'(1) : row_q;

  always_ff @(posedge clk_i) begin
    if (codes_valid) begin
      odd_q <= codes_line_start || !odd_q;
      row_q <= row + RowBits'(codes_line_end);
    end
  end

  // --- Header fields, held ---
  logic [6:1]            out_q;      // codes_start, one to six clocks ago
  logic [6:1]            begun_q;    // frame_start_i, one to six clocks ago
  logic                  later_q;    // a frame later than that of the raw codes has started
  logic                  later1_q, later2_q;  // the same for raw codes one and two clocks ago
  logic                  spoiled_q;  // the header fields are those of a later frame
  logic [ColumnBits-1:0] columns_before_q;  // columns_i one clock ago
  logic [ColumnBits-1:0] line_columns, line_columns_q;  // of the frame that the codes belong to
  logic [sp_spec_pkg::HeaderBits-1:0] held_q;  // info_i

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      out_q   <= '0;
      begun_q <= '0;
    end else begin
      out_q   <= {out_q[5:1], codes_start};
      begun_q <= {begun_q[5:1], frame_start_i};
    end
    later_q  <= frame_start_i || (raw_start ? |begun_q : later_q);
    later1_q <= raw_start ? |begun_q : later_q;
    later2_q <= later1_q;
    if (out_q[2]) spoiled_q <= later2_q;
  end

  // A beat of the header is held one clock after sp_frame_info has it. The half with the sequence
  // is held one clock earlier, since sp_packetizer reads it one clock before its beat. The sequence
  // fills a half, because fields of 64 bits are aligned.
  localparam int HalfBits = sp_spec_pkg::PacketBeatBits / 2;
  localparam logic [sp_spec_pkg::HeaderBits-1:0] FrameBits =
      sp_spec_pkg::frame_mask(ColumnBits, RowBits, Region ? 16 : 0, Wide ? 8 : 0) &
      ~(sp_spec_pkg::HeaderBits'(1) << (sp_spec_pkg::HeaderFlagsLsb + sp_spec_pkg::FlagVerdictBit));
  for (genvar half = 0; half < sp_spec_pkg::HeaderBits / HalfBits; half++) begin : gen_half
    localparam bit HasSequence = half == sp_spec_pkg::HeaderSequenceLsb / HalfBits;
    always_ff @(posedge clk_i) begin
      if (out_q[half/2+(HasSequence?2:3)])
        held_q[half*HalfBits+:HalfBits] <=
            info_i[half*HalfBits+:HalfBits] & FrameBits[half*HalfBits+:HalfBits];
    end
  end

  // The columns in force one clock before the first codes of the frame. If a later frame has
  // started by then, the packets are dropped anyway.
  assign line_columns = codes_start ? columns_before_q : line_columns_q;

  always_ff @(posedge clk_i) begin
    columns_before_q <= columns_i;
    line_columns_q   <= line_columns;
  end

  // --- Packets ---
  logic                   line_done, accept, words_valid, words_break;
  logic [127:0]           words_data;
  logic [PayloadBits-1:0] line_words;
  logic [RowBits-1:0]     line_row;
  logic [StatusBits-1:0]  line_status;

  sp_image_packer #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .Lanes     (Lanes),
    .PixelBytes(2)
  ) u_packer (
    .clk_i            (clk_i),
    .rst_i            (rst_i),
    .image_i          (1'b1),
    .columns_i        (line_columns),
    .beat_valid_i     (codes_valid),
    .beat_pixels_i    (codes),
    .beat_group_i     ({1'b0, !codes_line_start && odd_q}),
    .beat_row_i       (row),
    .beat_line_start_i(codes_line_start),
    .beat_line_end_i  (codes_line_end),
    .break_i          (codes_break),
    .break_status_i   (codes_status),
    .line_done_o      (line_done),
    .line_words_o     (line_words),
    .line_row_o       (line_row),
    .line_status_o    (line_status),
    .accept_i         (accept),
    .words_valid_o    (words_valid),
    .words_data_o     (words_data),
    .words_break_o    (words_break)
  );

  sp_packet_output #(
    .Kind       (sp_spec_pkg::KindCodes),
    .ColumnBits (ColumnBits),
    .RowBits    (RowBits),
    .Region     (Region),
    .Wide       (Wide),
    .PayloadBits(PayloadBits),
    .LogDepth   (LogDepth)
  ) u_packets (
    .clk_i          (clk_i),
    .rst_i          (rst_i),
    .start_i        (line_done),
    .payload_beats_i(line_words),
    .line_i         (line_row),
    .spoiled_i      (spoiled_q),
    .break_i        (1'b0),
    .break_later_i  (1'b0),
    .start_status_i (line_status),
    .break_status_i ({StatusBits{1'b0}}),
    .accept_o       (accept),
    .payload_valid_i(words_valid),
    .payload_data_i (words_data),
    .payload_break_i(words_break),
    .tail_valid_i   (1'b0),
    .tail_i         (128'd0),
    .info_i         (held_q),
    .lost_o         (lost_o),
    .bus_clk_i      (bus_clk_i),
    .bus_rst_i      (bus_rst_i),
    .m_valid_o      (m_valid_o),
    .m_ready_i      (m_ready_i),
    .m_last_o       (m_last_o),
    .m_data_o       (m_data_o)
  );

endmodule

`default_nettype wire
