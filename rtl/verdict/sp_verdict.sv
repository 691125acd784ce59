// A verdict from the moments of frames: which frames of a part have a defect.
//
//   words ──▶ sp_verdict_parts ─ settings in force ──┐
//   moments ─▶ sp_verdict_columns ─ out, unlit ─▶ sp_verdict_defects ─▶ verdict of a frame
//
// include/selfproj/model/verdict.h has the definition, which this circuit equals to the last bit.
//
// Input: frame_i, with the encoder's count, begins a frame, after the verdict of the frame before.
// start_o follows fourteen clocks later, one more for each word that is written meanwhile, ready_o
// 4 groups_i + 5 clocks behind it, and two clocks after that or later the first payload beat. Beats
// are those of sp_column_moments or sp_column_runs; groups_i counts at start_o, the mode stands
// still from there to the verdict. A frame with neither beats nor a break has no verdict, and is
// told by a frame_i alone; the next frame_i may come from its start_o on, and what was begun for it ends. write_i
// fills the memory of the registers (sp_verdict_parts), write_limits_i the table, in a bank that is
// not in force.
//
// Output: verdict_valid_o comes 15 clocks after the last beat of a frame, or 16 after its break.
// What it says stays until the next frame_i. Outside of a part there
// is no defect and no unlit column; section, part and bank are those of the part before. first_bad_o
// comes with the first verdict of a part that has a defect or lacks light.
//
//   frame_i         _/1\______________________________________________
//   start_o         _______ … /1\_____________________________________
//   ready_o         _______________ … /1\_____________________________
//   beat_valid_i    _____________________/1\_ … _/1\__________________
//   verdict_valid_o _______________________________________ … ___/1\__
`default_nettype none

module sp_verdict #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 8..4096
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 2..1023
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter bit Grey = 1'b1,  // modes grey and grey_over
  parameter int LogSections = 1,  // log2 of the sections of a bank: 0..6
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / 4),
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int LimitBits = $clog2(MaxRows + 1) + 7,
  parameter int SectionBits = LogSections > 0 ? LogSections : 1,
  parameter int LogWords = LogSections > 3 ? LogSections + 2 : 5
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  // Words and switches of the registers
  input  wire logic                   write_i,
  input  wire logic [LogWords-1:0]    write_word_i,
  input  wire logic [31:0]            write_data_i,
  input  wire logic                   hold_i,
  input  wire logic                   by_encoder_i,

  // Limits, to a bank that is not in force
  input  wire logic                   write_limits_i,
  input  wire logic                   write_bank_i,
  input  wire logic [SectionBits-1:0] write_section_i,
  input  wire logic [GroupBits+1:0]   write_column_i,  // from 0
  input  wire logic [2*LimitBits:0]   write_limits_word_i,  // {judged, high, low}, in 1/128 rows

  // A frame
  input  wire logic                   frame_i,
  input  wire logic                   restart_i,     // with frame_i: no part passes before it
  input  wire logic [23:0]            encoder_i,     // count, modulo 2^24
  input  wire logic [ColumnBits-3:0]  groups_i,      // of a line: columns / 4
  input  wire logic                   grey_i,        // two columns a beat
  output logic                        start_o,       // its settings are in force
  output logic                        ready_o,       // for beats
  input  wire logic                   beat_valid_i,
  input  wire logic [127:0]           beat_data_i,
  input  wire logic                   break_i,

  // Its verdict
  output logic                        verdict_valid_o,
  output logic                        in_part_o,
  output logic                        defect_o,
  output logic                        lacks_light_o,
  output logic      [ColumnBits-1:0]  first_column_o,  // of the leftmost defect, from 1
  output logic      [ColumnBits-1:0]  columns_o,
  output logic      [ColumnBits-1:0]  unlit_o,
  output logic      [SectionBits-1:0] section_o,
  output logic      [15:0]            part_o,
  output logic      [23:0]            count_o,         // of the encoder
  output logic                        bank_o,          // in force
  output logic                        first_bad_o,
  output logic                        passes_o,        // a part passes: the bank in force is needed
  output logic      [31:0]            word_o           // between frames, the register ejector_delay
);

  // --- Parts, and the settings in force ---
  logic                  in_part, first, fresh;
  logic [31:0]           settings, shift;
  logic                  found, found_whole_q, found_defect;
  logic [ColumnBits-1:0] lit;
  logic [7:0]            width;
  logic [2:0]            history;
  logic [3:0]            hits;
  logic [11:0]           most_unlit;
  logic                  above, below;

  // 4,096 columns count as 4,095: no register asks for more.
  function automatic logic [11:0] in_12_bits(input logic [ColumnBits-1:0] count);
    in_12_bits = 12'(count) | {12{ColumnBits > 12 && count[ColumnBits-1]}};
  endfunction

  assign width      = settings[sp_spec_pkg::RegVerdictDefectWidthLsb+:8];
  assign history    = settings[sp_spec_pkg::RegVerdictDefectHistoryLsb+:3];
  assign hits       = settings[sp_spec_pkg::RegVerdictDefectHitsLsb+:4];
  assign most_unlit = settings[sp_spec_pkg::RegVerdictDefectMostUnlitLsb+:12];
  assign above      = settings[sp_spec_pkg::RegVerdictDefectAboveLsb];
  assign below      = settings[sp_spec_pkg::RegVerdictDefectBelowLsb];
  assign bank_o     = settings[sp_spec_pkg::RegVerdictDefectBankLsb];
  assign passes_o   = in_part;
  logic unused;
  assign unused = ^{settings, shift};

  sp_verdict_parts #(
    .LogSections(LogSections)
  ) u_parts (
    .clk_i        (clk_i),
    .rst_i        (rst_i),
    .write_i      (write_i),
    .write_word_i (write_word_i),
    .write_data_i (write_data_i),
    .hold_i       (hold_i),
    .by_encoder_i (by_encoder_i),
    .frame_i      (frame_i),
    .restart_i    (restart_i),
    .encoder_i    (encoder_i),
    .found_i      (found),
    .found_whole_i(found_whole_q),
    .found_lit_i  (in_12_bits(lit)),
    .start_o      (start_o),
    .in_part_o    (in_part),
    .first_o      (first),
    .fresh_o      (fresh),
    .part_o       (part_o),
    .section_o    (section_o),
    .count_o      (count_o),
    .defect_o     (settings),
    .shift_o      (shift),
    .word_o       (word_o)
  );

  // --- Columns and defects ---
  logic                 group_valid, done, whole;
  logic [3:0]           group_above, group_below, group_unlit, group_lit;

  sp_verdict_columns #(
    .MaxColumns (MaxColumns),
    .MaxRows    (MaxRows),
    .PixelBits  (PixelBits),
    .Grey       (Grey),
    .LogSections(LogSections)
  ) u_columns (
    .clk_i          (clk_i),
    .rst_i          (rst_i),
    .write_i        (write_limits_i),
    .write_bank_i   (write_bank_i),
    .write_section_i(write_section_i),
    .write_column_i (write_column_i),
    .write_word_i   (write_limits_word_i),
    .start_i        (start_o),
    .groups_i       (groups_i),
    .grey_i         (grey_i),
    .bank_i         (bank_o),
    .section_i      (section_o),
    .shift_columns_i(shift[sp_spec_pkg::RegVerdictShiftColumnsLsb+:8]),
    .shift_rows_i   (shift[sp_spec_pkg::RegVerdictShiftRowsLsb+:14]),
    .beat_valid_i   (beat_valid_i),
    .beat_data_i    (beat_data_i),
    .break_i        (break_i),
    .ready_o        (ready_o),
    .group_valid_o  (group_valid),
    .above_o        (group_above),
    .below_o        (group_below),
    .unlit_o        (group_unlit),
    .lit_o          (group_lit),
    .done_o         (done),
    .whole_o        (whole)
  );

  sp_verdict_defects #(
    .MaxColumns(MaxColumns)
  ) u_defects (
    .clk_i         (clk_i),
    .rst_i         (rst_i),
    .width_i       (width),
    .history_i     (history),
    .hits_i        (hits),
    .above_i       (above && in_part),
    .below_i       (below && in_part),
    .fresh_i       (fresh || !in_part),
    .start_i       (start_o),
    .group_valid_i (group_valid),
    .group_above_i (group_above),
    .group_below_i (group_below),
    .group_unlit_i (group_unlit & {4{in_part}}),
    .group_lit_i   (group_lit),
    .done_i        (done),
    .found_valid_o (found),
    .defect_o      (found_defect),
    .first_column_o(first_column_o),
    .columns_o     (columns_o),
    .unlit_o       (unlit_o),
    .lit_o         (lit)
  );

  // --- The verdict ---
  logic bad_before_q;  // a frame of this part has been bad
  logic lacks_light, bad;

  always_ff @(posedge clk_i) begin
    if (done) found_whole_q <= whole;
    if (rst_i) found_whole_q <= 1'b0;
  end

  assign lacks_light = in_part && in_12_bits(unlit_o) > most_unlit;
  assign bad         = in_part && found_defect || lacks_light;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      verdict_valid_o <= 1'b0;
      first_bad_o     <= 1'b0;
      bad_before_q    <= 1'b0;
    end else begin
      verdict_valid_o <= found;
      first_bad_o     <= found && bad && !bad_before_q;
      if (start_o && first) bad_before_q <= 1'b0;
      if (found && bad) bad_before_q <= 1'b1;
    end
  end
  always_ff @(posedge clk_i) begin
    if (found) {in_part_o, defect_o, lacks_light_o} <= {in_part, in_part && found_defect, lacks_light};
  end

endmodule

`default_nettype wire
