// Tells where parts begin and end, which section of a part passes, and which settings are in force.
//
// By light: a part begins with the frame after a whole frame with rule_lit_i lit columns or more,
// and ends with the last of rule_dark_i whole frames in a row that have fewer. By the encoder, with
// rule_by_encoder_i: part k begins with the first frame not before start + k * pitch and ends
// before the first frame that is `length` or more behind that point, modulo 2^24.
//
// frame_i begins a frame. Four clocks later start_o says that all outputs are those of this frame,
// which stand still until the next frame_i, and so must the rule. found_i ends the frame: found_whole_i
// says that it did not break, found_lit_i how many columns were lit. frame_i comes after the found_i
// of the frame before, or found_i does not come at all: then that frame changes nothing.
//
// Settings are taken over in the clock in which a part begins. A section's beginning is written at
// any time to a bank that is not in force; that of section 0 has no meaning.
//
//   frame_i  _/1\_________________
//   start_o  _________________/1\_
`default_nettype none

module sp_verdict_parts #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 8..2048
  parameter int LogSections = 1,  // log2 of the sections of a bank: 0..6
  parameter int SettingsBits = 1,  // taken over where a part begins: 1 or more
  // derived, do not set
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int SectionBits = LogSections > 0 ? LogSections : 1
) (
  input  wire logic                    clk_i,
  input  wire logic                    rst_i,

  // The rule, in force at once
  input  wire logic                    rule_by_encoder_i,
  input  wire logic [ColumnBits-1:0]   rule_lit_i,     // 1 or more
  input  wire logic [7:0]              rule_dark_i,    // 1..255
  input  wire logic [23:0]             rule_start_i,
  input  wire logic [23:0]             rule_length_i,
  input  wire logic [23:0]             rule_pitch_i,

  // Where sections begin, in counts behind the beginning of a part
  input  wire logic                    write_i,
  input  wire logic [LogSections:0]    write_section_i,  // {bank, section}
  input  wire logic [23:0]             write_begin_i,

  input  wire logic                    bank_i,      // to be taken over
  input  wire logic [SettingsBits-1:0] settings_i,  // to be taken over

  input  wire logic                    frame_i,
  input  wire logic [23:0]             encoder_i,   // count of the frame, in the clock of frame_i
  input  wire logic                    found_i,
  input  wire logic                    found_whole_i,
  input  wire logic [ColumnBits-1:0]   found_lit_i,

  output logic                         start_o,
  output logic                         in_part_o,
  output logic                         first_o,     // the frame is the first of its part
  output logic                         fresh_o,     // no whole frame of the part came before
  output logic [15:0]                  part_o,      // parts that began before it; wraps
  output logic [SectionBits-1:0]       section_o,
  output logic                         bank_o,
  output logic [SettingsBits-1:0]      settings_o
);

  if (MaxColumns < 8 || MaxColumns > sp_spec_pkg::MaxColumns || MaxColumns % 4 != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_4_in_8_to_2048 u_error ();
  end
  if (LogSections < 0 || LogSections > 6) begin : gen_log_sections
    log_sections_is_not_in_0_to_6 u_error ();
  end
  if (SettingsBits < 1) begin : gen_settings_bits
    settings_bits_is_less_than_1 u_error ();
  end

  logic [3:1]  step_q;               // clocks after frame_i
  logic [23:0] encoder_q, began_q, next_q;
  logic        chosen_q;                 // the frame before was by the encoder, too
  logic [23:0] next;                     // where the next part begins
  logic [23:0] next_way;
  logic [23:0] s2_way_q;                 // from the part's beginning
  logic        s2_next_q, s3_next_q;     // the next one has been reached
  logic        s3_over_q;                // the part is over
  logic        begins_next_q;
  logic [7:0]  dark_q;
  logic        begins, ends;
  logic        dark;

  always_ff @(posedge clk_i) begin
    if (rst_i) {start_o, step_q} <= '0;
    else {start_o, step_q} <= {step_q, frame_i};
  end

  always_ff @(posedge clk_i) begin
    if (frame_i) encoder_q <= encoder_i;
    s2_way_q      <= encoder_q - began_q;
    s2_next_q     <= !next_way[23];
    s3_over_q     <= s2_way_q >= rule_length_i;
    s3_next_q     <= s2_next_q;
  end

  assign next     = chosen_q ? next_q : rule_start_i;
  assign next_way = encoder_q - next;
  logic unused;
  assign unused = ^next_way[22:0];
  assign ends   = rule_by_encoder_i && in_part_o && s3_over_q;
  assign begins = rule_by_encoder_i ? (!in_part_o || s3_over_q) && s3_next_q : begins_next_q;
  assign dark   = found_lit_i < rule_lit_i;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      in_part_o     <= 1'b0;
      begins_next_q <= 1'b0;
      first_o       <= 1'b0;
      fresh_o       <= 1'b1;
      dark_q        <= '0;
      part_o        <= '1;
    end else if (step_q[3]) begin
      begins_next_q <= 1'b0;
      first_o       <= begins;
      in_part_o     <= (in_part_o && !ends) || begins;
      if (begins) begin
        fresh_o <= 1'b1;
        dark_q  <= '0;
        part_o  <= part_o + 16'd1;
      end
    end else if (found_i && found_whole_i) begin
      fresh_o <= fresh_o && !in_part_o;
      if (!rule_by_encoder_i && !in_part_o) begins_next_q <= !dark;
      if (!rule_by_encoder_i && in_part_o) begin
        dark_q    <= dark ? dark_q + 8'd1 : '0;
        in_part_o <= !(dark && dark_q + 8'd1 >= rule_dark_i);
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (step_q[3]) begin
      chosen_q <= rule_by_encoder_i;
      next_q   <= next + (begins ? rule_pitch_i : '0);
      if (begins) begin
        began_q    <= rule_by_encoder_i ? next : encoder_q;
        bank_o     <= bank_i;
        settings_o <= settings_i;
      end
    end
    if (rst_i) chosen_q <= 1'b0;
  end

  // --- Sections ---
  if (LogSections > 0) begin : gen_sections
    logic [23:0] begin_of_next;  // of the next section
    logic        s3_later_q, last;
    assign last = section_o == '1;
    sp_ram #(
      .Width   (24),
      .LogDepth(LogSections + 1)
    ) u_begins (
      .wr_clk_i (clk_i),
      .wr_en_i  (write_i),
      .wr_addr_i(write_section_i),
      .wr_data_i(write_begin_i),
      .rd_clk_i (clk_i),
      .rd_en_i  (1'b1),
      .rd_addr_i({bank_o, section_o + SectionBits'(1)}),
      .rd_data_o(begin_of_next)
`ifdef FORMAL
      ,
      .f_addr_i ('0),
      .f_word_o (),
      .f_first_o()
`endif
    );
    always_ff @(posedge clk_i) begin
      s3_later_q <= s2_way_q >= begin_of_next;
      if (step_q[3]) begin
        if (begins) section_o <= '0;
        else if (in_part_o && s3_later_q && !last) section_o <= section_o + SectionBits'(1);
      end
    end
  end else begin : gen_one_section
    logic unused_write;
    assign unused_write = ^{write_i, write_section_i, write_begin_i};
    assign section_o = '0;
  end

endmodule

`default_nettype wire
