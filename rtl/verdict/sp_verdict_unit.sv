// What a board has for its verdict: registers, the circuit, the pin for an ejector.
//
//   registers ─▶ sp_verdict_registers ─ words, limits ─▶ sp_verdict ◀─ sums of sp_moments_path
//   frames ────▶ sp_verdict_gate ─ which are judged ─────▶   │
//                             sp_ejector ◀─ bad parts ───────┴─▶ verdict, for the packet
//
// This module only connects them. It decides with sp_moments_path which frames are judged
// (sp_verdict_gate), and gives the verdict of each of them 15 clocks after the last of its sums, 16
// after a break. The pin follows six clocks later, if its delay is 0.
`default_nettype none

module sp_verdict_unit #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 8..4096
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 2..1023
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter bit Grey = 1'b1,  // modes grey and grey_over
  parameter int LogSections = 1,  // log2 of the sections of a bank: 0..6
  // derived, do not set
  parameter int ColumnBits = $clog2(MaxColumns + 1)
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // Registers, as sp_verdict_registers
  input  wire logic                  request_i,
  input  wire logic                  write_i,
  input  wire logic [7:0]            address_i,
  input  wire logic [31:0]           data_i,
  output logic                       error_o,
  output logic      [31:0]           data_o,
  output logic      [2:0]            set_o,  // {on, packets} as written; packets are 0 while on is 0

  // Frames and settings in force
  input  wire logic                  frame_start_i,
  input  wire logic                  on_i,
  input  wire logic [ColumnBits-3:0] groups_i,
  input  wire logic [1:0]            mode_i,
  input  wire logic [23:0]           frame_encoder_i,  // six clocks after a frame's start
  input  wire logic [23:0]           encoder_i,        // now

  // Sums of sp_moments_path, and what is decided about them
  input  wire logic                  decision_i,
  input  wire logic                  spoiled_i,
  output logic                       ready_o,
  output logic                       judge_o,
  input  wire logic                  words_valid_i,
  input  wire logic [127:0]          words_data_i,
  input  wire logic                  words_break_i,

  // The verdict of a frame
  output logic                       valid_o,
  output logic      [127:0]          data_word_o,
  output logic                       ejector_o
);

  localparam int GroupBits = $clog2(MaxColumns / 4);
  localparam int LimitBits = $clog2(MaxRows + 1) + 7;
  localparam int SectionBits = LogSections > 0 ? LogSections : 1;
  localparam int LogWords = LogSections > 3 ? LogSections + 2 : 5;

  logic                   on, hold, by_encoder;
  logic [1:0]             packets;
  logic [15:0]            ejector_length;
  logic                   write_word, write_limits, write_bank;
  logic [LogWords-1:0]    word_address;
  logic [SectionBits-1:0] write_section, section;
  logic [GroupBits+1:0]   write_column;
  logic [2*LimitBits:0]   limits_word;
  logic                   frame, restart, start, composed, judging, missed, lost, passes, bank;
  logic                   in_part, defect, lacks_light, first_bad;
  logic [ColumnBits-1:0]  first_column, defect_columns, unlit;
  logic [15:0]            part;
  logic [23:0]            count;
  logic [31:0]            delay_word;

  assign set_o = {on, packets & {2{on}}};

  sp_verdict_registers #(
    .MaxColumns (MaxColumns),
    .MaxRows    (MaxRows),
    .LogSections(LogSections)
  ) u_registers (
    .clk_i              (clk_i),
    .rst_i              (rst_i),
    .request_i          (request_i),
    .write_i            (write_i),
    .address_i          (address_i),
    .data_i             (data_i),
    .error_o            (error_o),
    .data_o             (data_o),
    .on_o               (on),
    .hold_o             (hold),
    .by_encoder_o       (by_encoder),
    .packets_o          (packets),
    .length_o           (ejector_length),
    .write_o            (write_word),
    .write_word_o       (word_address),
    .write_limits_o     (write_limits),
    .write_bank_o       (write_bank),
    .write_section_o    (write_section),
    .write_column_o     (write_column),
    .write_limits_word_o(limits_word),
    .passes_i           (passes && !restart),
    .bank_i             (bank),
    .section_i          (section),
    .part_i             (part),
    .bad_i              (first_bad),
    .missed_i           (missed),
    .lost_i             (lost)
  );

  sp_verdict_gate u_gate (
    .clk_i        (clk_i),
    .rst_i        (rst_i),
    .on_i         (on_i),
    .frame_start_i(frame_start_i),
    .decision_i   (decision_i),
    .spoiled_i    (spoiled_i),
    .start_i      (start),
    .composed_i   (composed),
    .verdict_i    (valid_o),
    .frame_o      (frame),
    .restart_o    (restart),
    .ready_o      (ready_o),
    .judge_o      (judge_o),
    .judging_o    (judging),
    .missed_o     (missed)
  );

  sp_verdict #(
    .MaxColumns (MaxColumns),
    .MaxRows    (MaxRows),
    .PixelBits  (PixelBits),
    .Grey       (Grey),
    .LogSections(LogSections)
  ) u_verdict (
    .clk_i              (clk_i),
    .rst_i              (rst_i),
    .write_i            (write_word),
    .write_word_i       (word_address),
    .write_data_i       (data_i),
    .hold_i             (hold),
    .by_encoder_i       (by_encoder),
    .write_limits_i     (write_limits),
    .write_bank_i       (write_bank),
    .write_section_i    (write_section),
    .write_column_i     (write_column),
    .write_limits_word_i(limits_word),
    .frame_i            (frame),
    .restart_i          (restart),
    .encoder_i          (frame_encoder_i),
    .groups_i           (groups_i),
    .grey_i             (mode_i != sp_spec_pkg::ModeBinary),
    .start_o            (start),
    .ready_o            (composed),
    .beat_valid_i       (words_valid_i && judging),
    .beat_data_i        (words_data_i),
    .break_i            (words_break_i && judging),
    .verdict_valid_o    (valid_o),
    .in_part_o          (in_part),
    .defect_o           (defect),
    .lacks_light_o      (lacks_light),
    .first_column_o     (first_column),
    .columns_o          (defect_columns),
    .unlit_o            (unlit),
    .section_o          (section),
    .part_o             (part),
    .count_o            (count),
    .bank_o             (bank),
    .first_bad_o        (first_bad),
    .passes_o           (passes),
    .word_o             (delay_word)
  );

  sp_ejector u_ejector (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .delay_i  (delay_word[22:0]),
    .length_i (ejector_length),
    .encoder_i(encoder_i),
    .bad_i    (first_bad),
    .place_i  (count),
    .ejector_o(ejector_o),
    .lost_o   (lost)
  );
  logic unused;
  assign unused = ^delay_word[31:23];

  always_comb begin
    data_word_o = '0;
    data_word_o[sp_spec_pkg::VerdictJudgedLsb]                  = 1'b1;
    data_word_o[sp_spec_pkg::VerdictInPartLsb]                  = in_part;
    data_word_o[sp_spec_pkg::VerdictFirstColumnLsb+:ColumnBits] = first_column;
    data_word_o[sp_spec_pkg::VerdictColumnsLsb+:ColumnBits]     = defect_columns;
    data_word_o[sp_spec_pkg::VerdictUnlitLsb+:ColumnBits]       = unlit;
    data_word_o[sp_spec_pkg::VerdictDefectLsb]                  = defect;
    data_word_o[sp_spec_pkg::VerdictLacksLightLsb]              = lacks_light;
    data_word_o[sp_spec_pkg::VerdictBankLsb]                    = bank;
    data_word_o[sp_spec_pkg::VerdictSectionLsb+:SectionBits]    = section;
    data_word_o[sp_spec_pkg::VerdictPartLsb+:16]                = part;
  end

endmodule

`default_nettype wire
