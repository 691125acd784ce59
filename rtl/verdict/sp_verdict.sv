// A verdict from the moments of frames: which frames of a part have a defect.
//
//   frame ───▶ sp_verdict_parts ─ settings in force ─┐
//   moments ─▶ sp_verdict_columns ─ out, unlit ─▶ sp_verdict_defects ─▶ verdict of a frame
//
// include/selfproj/model/verdict.h has the definition, which this circuit equals to the last bit.
//
// Input: frame_i, with the encoder's count, begins a frame: seven clocks or more before its first
// payload beat and, so that no frame is left out, after the verdict of the frame before. Beats are
// those of sp_column_moments or sp_column_runs; mode and size stand still from frame_i to the
// verdict. A frame without beats has no verdict, and is told by a frame_i alone.
//
// Output: verdict_valid_o comes 17 clocks after the last beat of a frame, or 18 after its break, for
// each frame whose beats came. What it says stays until the next frame_i; outside of a part only
// in_part_o, defect_o and lacks_light_o, all 0, have a meaning. first_bad_o comes with the first
// verdict of a part that has a defect or lacks light.
//
//   frame_i         _/1\______________________________
//   beat_valid_i    ____________/1\_ … _/1\___________
//   verdict_valid_o _______________________ … ___/1\__
`default_nettype none

module sp_verdict #(
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

  // Limits, and where sections begin: to a bank that is not in force
  input  wire logic                   write_limits_i,
  input  wire logic [1:0]             write_lane_i,   // column modulo 4
  input  wire logic [TableBits-1:0]   write_group_i,  // {bank, section, column / 4}
  input  wire logic [2*LimitBits:0]   write_word_i,   // {judged, high, low}, in 1/128 rows
  input  wire logic                   write_begin_i,
  input  wire logic [LogSections:0]   write_section_i,  // {bank, section}
  input  wire logic [23:0]            write_count_i,    // behind the beginning of a part

  // Settings, taken over where a part begins
  input  wire logic [7:0]             width_i,       // w, 1..255 columns
  input  wire logic [2:0]             history_i,     // h - 1
  input  wire logic [3:0]             hits_i,        // m, 1..h
  input  wire logic                   above_i,       // defects above are asked for
  input  wire logic                   below_i,
  input  wire logic [11:0]            most_unlit_i,  // u; 4095: light is not judged
  input  wire logic [7:0]             shift_columns_i,  // s, in two's complement
  input  wire logic [13:0]            shift_rows_i,     // d, in two's complement, 1/128 rows
  input  wire logic                   bank_i,

  // The rule for parts, in force at once
  input  wire logic                   rule_by_encoder_i,
  input  wire logic [ColumnBits-1:0]  rule_lit_i,    // t, 1 or more
  input  wire logic [7:0]             rule_dark_i,   // e, 1..255
  input  wire logic [23:0]            rule_start_i,
  input  wire logic [23:0]            rule_length_i,
  input  wire logic [23:0]            rule_pitch_i,

  // A frame
  input  wire logic                   frame_i,
  input  wire logic [23:0]            encoder_i,     // count, modulo 2^24
  input  wire logic [ColumnBits-3:0]  groups_i,      // of a line: columns / 4
  input  wire logic                   grey_i,        // two columns a beat
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
  output logic                        bank_o,          // in force
  output logic                        first_bad_o
);

  localparam int SettingsBits = 8 + 3 + 4 + 2 + 12 + 8 + 14;

  // --- Parts, and the settings in force ---
  logic [SettingsBits-1:0] settings;
  logic                    start, in_part, first, fresh, above, below;
  logic [7:0]              width, shift_columns;
  logic [2:0]              history;
  logic [3:0]              hits;
  logic [11:0]             most_unlit;
  logic [13:0]             shift_rows;
  logic                    found, found_whole_q, found_defect;
  logic [ColumnBits-1:0]   lit;

  assign {width, history, hits, above, below, most_unlit, shift_columns, shift_rows} = settings;

  sp_verdict_parts #(
    .MaxColumns  (MaxColumns),
    .LogSections (LogSections),
    .SettingsBits(SettingsBits)
  ) u_parts (
    .clk_i            (clk_i),
    .rst_i            (rst_i),
    .rule_by_encoder_i(rule_by_encoder_i),
    .rule_lit_i       (rule_lit_i),
    .rule_dark_i      (rule_dark_i),
    .rule_start_i     (rule_start_i),
    .rule_length_i    (rule_length_i),
    .rule_pitch_i     (rule_pitch_i),
    .write_i          (write_begin_i),
    .write_section_i  (write_section_i),
    .write_begin_i    (write_count_i),
    .bank_i           (bank_i),
    .settings_i       ({width_i, history_i, hits_i, above_i, below_i, most_unlit_i,
                        shift_columns_i, shift_rows_i}),
    .frame_i          (frame_i),
    .encoder_i        (encoder_i),
    .found_i          (found),
    .found_whole_i    (found_whole_q),
    .found_lit_i      (lit),
    .start_o          (start),
    .in_part_o        (in_part),
    .first_o          (first),
    .fresh_o          (fresh),
    .part_o           (part_o),
    .section_o        (section_o),
    .bank_o           (bank_o),
    .settings_o       (settings)
  );

  // --- Columns and defects ---
  logic                 group_valid, done, whole;
  logic [GroupBits-1:0] group;
  logic [3:0]           group_above, group_below, group_unlit, group_lit;

  sp_verdict_columns #(
    .MaxColumns (MaxColumns),
    .MaxRows    (MaxRows),
    .Grey       (Grey),
    .LogSections(LogSections)
  ) u_columns (
    .clk_i          (clk_i),
    .rst_i          (rst_i),
    .write_i        (write_limits_i),
    .write_lane_i   (write_lane_i),
    .write_group_i  (write_group_i),
    .write_word_i   (write_word_i),
    .start_i        (start),
    .groups_i       (groups_i),
    .grey_i         (grey_i),
    .bank_i         (bank_o),
    .section_i      (section_o),
    .shift_columns_i(shift_columns),
    .shift_rows_i   (shift_rows),
    .beat_valid_i   (beat_valid_i),
    .beat_data_i    (beat_data_i),
    .break_i        (break_i),
    .group_valid_o  (group_valid),
    .group_o        (group),
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
    .start_i       (start),
    .group_valid_i (group_valid),
    .group_i       (group),
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

  assign lacks_light = in_part && 12'(unlit_o) > most_unlit;
  assign bad         = in_part && found_defect || lacks_light;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      verdict_valid_o <= 1'b0;
      first_bad_o     <= 1'b0;
      bad_before_q    <= 1'b0;
    end else begin
      verdict_valid_o <= found;
      first_bad_o     <= found && bad && !bad_before_q;
      if (start && first) bad_before_q <= 1'b0;
      if (found && bad) bad_before_q <= 1'b1;
    end
  end
  always_ff @(posedge clk_i) begin
    if (found) {in_part_o, defect_o, lacks_light_o} <= {in_part, in_part && found_defect, lacks_light};
  end

endmodule

`default_nettype wire
