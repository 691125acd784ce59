// Registers of the verdict, in the video clock. The specification places addresses and fields
// (sp_spec_pkg).
//
// Guarantees: those of sp_registers, beside which it stands, for addresses from verdict_control on:
// request_i lasts one clock and stands still until the answer five clocks later. By then error_o
// and data_o are there, and a write has taken effect. What a build cannot do is refused, and so are
// writes of limits to a bank that judges or may judge next.
//
// Most registers are words of a memory, which sp_verdict_parts has a copy of: write_o fills it.
// What of them has not been written since the reset reads as 0. Bits outside all fields are kept,
// and mean nothing.
//
//   clock       0   1   2   3   4   5
//   request_i  _/1\___________________
//   good_q     ---------<   >---------
//   put_q      _____________/1\_______   write_o or write_limits_o, or both switches change
//   error_o    ---------------------<    and data_o
`default_nettype none

module sp_verdict_registers #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 8..4096
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 2..1023
  parameter int LogSections = 1,  // log2 of the sections of a bank: 0..6
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / 4),
  parameter int LimitBits = $clog2(MaxRows + 1) + 7,
  parameter int SectionBits = LogSections > 0 ? LogSections : 1,
  parameter int LogWords = LogSections > 3 ? LogSections + 2 : 5
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  input  wire logic                   request_i,
  input  wire logic                   write_i,
  input  wire logic [7:0]             address_i,
  input  wire logic [31:0]            data_i,
  output logic                        error_o,
  output logic      [31:0]            data_o,   // 0 for an address that is not here

  output logic                        on_o,
  output logic                        hold_o,
  output logic                        by_encoder_o,
  output logic      [1:0]             packets_o,        // as verdict_control.packets
  output logic      [15:0]            length_o,         // of the ejector's pulse

  // Words, and from the middle on beginnings of sections, {1, bank, section}
  output logic                        write_o,
  output logic      [LogWords-1:0]    write_word_o,
  output logic                        write_limits_o,
  output logic                        write_bank_o,
  output logic      [SectionBits-1:0] write_section_o,
  output logic      [GroupBits+1:0]   write_column_o,
  output logic      [2*LimitBits:0]   write_limits_word_o,  // {judged, high, low}

  // State
  input  wire logic                   passes_i,   // a part passes
  input  wire logic                   bank_i,     // in force
  input  wire logic [SectionBits-1:0] section_i,
  input  wire logic [15:0]            part_i,     // parts that have begun
  input  wire logic                   bad_i,      // for one clock each: a bad part
  input  wire logic                   missed_i,   // a frame that was not judged
  input  wire logic                   lost_i      // a pulse of the ejector
);

  if (MaxColumns < 8 || MaxColumns > sp_spec_pkg::ColumnLimit || MaxColumns % 4 != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_4_in_8_to_4096 u_error ();
  end
  if (MaxRows < 2 || MaxRows > sp_spec_pkg::MaxRows) begin : gen_max_rows
    max_rows_is_not_in_2_to_1023 u_error ();
  end
  if (LogSections < 0 || LogSections > 6) begin : gen_log_sections
    log_sections_is_not_in_0_to_6 u_error ();
  end

  localparam int Base = 32'(sp_spec_pkg::RegVerdictControl);
  localparam int Control = 0,
                 Defect = (32'(sp_spec_pkg::RegVerdictDefect) - Base) / 4,
                 Light = (32'(sp_spec_pkg::RegVerdictLight) - Base) / 4,
                 LengthWord = (32'(sp_spec_pkg::RegVerdictLength) - Base) / 4,
                 Pitch = (32'(sp_spec_pkg::RegVerdictPitch) - Base) / 4,
                 Ejector = (32'(sp_spec_pkg::RegEjectorLength) - Base) / 4,
                 Table = (32'(sp_spec_pkg::RegVerdictTable) - Base) / 4,
                 Limits = (32'(sp_spec_pkg::RegVerdictLimits) - Base) / 4,
                 Begin = (32'(sp_spec_pkg::RegVerdictBegin) - Base) / 4,
                 State = (32'(sp_spec_pkg::RegVerdictState) - Base) / 4,
                 Parts = (32'(sp_spec_pkg::RegVerdictParts) - Base) / 4;
  localparam int Plain = Begin + 1;  // words that can be written
  // What has to be written before on
  localparam logic [Plain-1:0] Needed =
      (Plain'(1) << (Ejector + 1)) - (Plain'(1) << Defect);
  localparam int LowLsb = sp_spec_pkg::RegVerdictLimitsLowLsb,
                 LowSpan = sp_spec_pkg::RegVerdictLimitsLowBits,
                 BandLsb = sp_spec_pkg::RegVerdictLimitsBandLsb,
                 BandSpan = sp_spec_pkg::RegVerdictLimitsBandBits;
  localparam int ColumnLsb = sp_spec_pkg::RegVerdictTableColumnLsb,
                 ColumnSpan = sp_spec_pkg::RegVerdictTableColumnBits,
                 SectionLsb = sp_spec_pkg::RegVerdictTableSectionLsb,
                 SectionSpan = sp_spec_pkg::RegVerdictTableSectionBits,
                 BankLsb = sp_spec_pkg::RegVerdictTableBankLsb;
  localparam int PacketsLsb = sp_spec_pkg::RegVerdictControlPacketsLsb;

  // --- Request: its register and whether its data is good ---
  logic [2:0]       asked_q;    // the request, one to three clocks ago, the latest lowest
  logic [4:0]       word;       // of the bank
  logic             here, there_q, good, good_q, put, put_q, can_put_q;
  logic [Plain-1:0] put_word_q;  // put_q, for each word
  logic [Plain-1:0] written_q;   // since reset
  logic             named_bank_q;  // that verdict_defect names
  logic             free;          // the bank that verdict_table names may be written
  logic [ColumnSpan-1:0]  column_q;
  logic [SectionSpan-1:0] section_q;

  logic [LowSpan:0]       high;  // the greater limit

  assign word = address_i[6:2];
  assign high = {1'b0, data_i[LowLsb+:LowSpan]} + (LowSpan + 1)'(data_i[BandLsb+:BandSpan]);
  assign here = address_i[7] && address_i[1:0] == 2'b00 && sp_spec_pkg::VerdictWords[word];
  // While settings are held, the next part keeps the bank in force.
  assign free = !(on_o && (write_bank_o == named_bank_q ||
                           (passes_i || hold_o) && write_bank_o == bank_i));

  assign put  = !rst_i && asked_q[1] && write_i && can_put_q && good_q;

  always_comb begin
    good = 1'b1;
    case (word)
      5'(Control): good = data_i[PacketsLsb+:2] != 2'd3 &&
                          (!data_i[sp_spec_pkg::RegVerdictControlOnLsb] ||
                           (written_q & Needed) == Needed);
      5'(Defect): good = data_i[sp_spec_pkg::RegVerdictDefectWidthLsb+:8] != '0 &&
                         data_i[sp_spec_pkg::RegVerdictDefectHitsLsb+:4] != '0;
      5'(Light): good = data_i[sp_spec_pkg::RegVerdictLightLitLsb+:12] != '0 &&
                        data_i[sp_spec_pkg::RegVerdictLightDarkFramesLsb+:8] != '0;
      5'(LengthWord), 5'(Pitch): good = data_i[23:0] != '0;
      5'(Table): good = 32'(data_i[ColumnLsb+:ColumnSpan]) < MaxColumns &&
                        data_i[SectionLsb+:SectionSpan] >> LogSections == '0;
      5'(Limits): good = free && high >> LimitBits == '0;
      5'(Begin): good = free;
      default: good = 1'b1;
    endcase
  end

  always_ff @(posedge clk_i) begin
    asked_q   <= rst_i ? '0 : {asked_q[1:0], request_i};
    there_q   <= here;
    can_put_q <= here && !address_i[6];
    good_q    <= good;
    put_q     <= put;
    for (int i = 0; i < Plain; i++) put_word_q[i] <= word == 5'(i);
    if (!put) put_word_q <= '0;
    if (asked_q[2]) error_o <= write_i ? !put_q : !there_q;
  end

  // --- Writes ---
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      {on_o, hold_o, by_encoder_o, packets_o} <= '0;
      written_q    <= '0;
      named_bank_q <= 1'b0;
    end else begin
      for (int i = 0; i < Plain; i++) if (put_word_q[i]) written_q[i] <= 1'b1;
      if (put_word_q[Control]) begin
        on_o         <= data_i[sp_spec_pkg::RegVerdictControlOnLsb];
        hold_o       <= data_i[sp_spec_pkg::RegVerdictControlHoldLsb];
        by_encoder_o <= data_i[sp_spec_pkg::RegVerdictControlByEncoderLsb];
        packets_o    <= data_i[PacketsLsb+:2];
      end
      if (put_word_q[Defect]) named_bank_q <= data_i[sp_spec_pkg::RegVerdictDefectBankLsb];
    end
  end
  always_ff @(posedge clk_i) begin
    if (put_word_q[Ejector]) length_o <= data_i[15:0];
    if (put_word_q[Table]) begin
      column_q     <= data_i[ColumnLsb+:ColumnSpan];
      section_q    <= data_i[SectionLsb+:SectionSpan];
      write_bank_o <= data_i[BankLsb];
    end
    if (rst_i) {column_q, section_q, write_bank_o, length_o} <= '0;
  end
  logic unused;
  assign unused = ^{column_q, section_q};

  assign write_o         = put_q;
  assign write_limits_o  = put_word_q[Limits];
  assign write_section_o = SectionBits'(section_q);
  assign write_column_o  = (GroupBits + 2)'(column_q);
  assign write_limits_word_o = {data_i[sp_spec_pkg::RegVerdictLimitsJudgedLsb],
                                high[LimitBits-1:0], data_i[LowLsb+:LimitBits]};
  if (LogSections > 0) begin : gen_sections
    assign write_word_o = word == 5'(Begin) ?
        {1'b1, (LogWords - 1)'({write_bank_o, write_section_o})} : LogWords'(word);
  end else begin : gen_one_section
    assign write_word_o = LogWords'(word);
  end

  // --- Reads ---
  logic [31:0] kept, state_word, parts_word, kept_q, state_q, parts_q;
  logic        reads_kept_q, reads_state_q, reads_parts_q;
  logic [15:0] bad_q;
  logic [7:0]  missed_q, lost_q;
`ifdef FORMAL
  (* anyconst *) logic [3:0] f_word;  // any word that can be written
  logic [31:0] f_kept;                // it
`endif

  sp_ram #(
    .Width   (32),
    .LogDepth(5)  // so that it becomes a block RAM; only the lower half is used
  ) u_kept (
    .wr_clk_i (clk_i),
    .wr_en_i  (put_q),
    .wr_addr_i(word),
    .wr_data_i(data_i),
    .rd_clk_i (clk_i),
    .rd_en_i  (1'b1),
    .rd_addr_i(word),
    .rd_data_o(kept)
`ifdef FORMAL
    ,
    .f_addr_i ({1'b0, f_word}),
    .f_word_o (f_kept),
    .f_first_o()
`endif
  );

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      bad_q    <= '0;
      missed_q <= '0;
      lost_q   <= '0;
    end else begin
      bad_q    <= bad_q + 16'(bad_i);
      missed_q <= missed_q + 8'(missed_i);
      lost_q   <= lost_q + 8'(lost_i);
    end
  end

  assign state_word = 32'(passes_i) << sp_spec_pkg::RegVerdictStateInPartLsb |
                      32'(bank_i) << sp_spec_pkg::RegVerdictStateBankLsb |
                      32'(LogSections) << sp_spec_pkg::RegVerdictStateLogSectionsLsb |
                      32'(section_i) << sp_spec_pkg::RegVerdictStateSectionLsb |
                      32'(missed_q) << sp_spec_pkg::RegVerdictStateMissedLsb |
                      32'(lost_q) << sp_spec_pkg::RegVerdictStateEjectorLostLsb;
  assign parts_word = 32'(part_i) << sp_spec_pkg::RegVerdictPartsBegunLsb |
                      32'(bad_q) << sp_spec_pkg::RegVerdictPartsBadLsb;

  always_ff @(posedge clk_i) begin
    reads_kept_q  <= !write_i && can_put_q && written_q[word[3:0]];
    reads_state_q <= !write_i && there_q && word == 5'(State);
    reads_parts_q <= !write_i && there_q && word == 5'(Parts);
    kept_q        <= reads_kept_q ? kept : '0;
    state_q       <= reads_state_q ? state_word : '0;
    parts_q       <= reads_parts_q ? parts_word : '0;
  end
  assign data_o = kept_q | state_q | parts_q;

`ifdef FORMAL
  // Assumptions: one reset at the beginning, for four clocks. One request at a time, for one clock;
  // it stands still until its answer (sp_axil_bridge). A part that begins takes the bank that
  // verdict_defect names or, while settings are held, keeps that of the part before; the bank
  // changes nowhere else (sp_verdict_parts).
  logic [3:0]  f_reset_q = 4'd0;
  logic        f_ran_q;
  logic [2:0]  f_age_q;      // clocks since the request, 1 to 5; 0: none
  logic [40:0] f_asked_q;
  logic        f_passes_q, f_bank_q, f_bank_named_q;
  assign f_ran_q = f_reset_q[3];
  always_ff @(posedge clk_i) begin
    f_reset_q  <= {f_reset_q[2:0], 1'b1};
    f_asked_q  <= {write_i, address_i, data_i};
    f_passes_q <= passes_i;
    f_bank_q   <= bank_i;
    f_age_q    <= rst_i ? '0 : f_age_q == '0 ? 3'(request_i) :
                  f_age_q == 3'd5 ? '0 : f_age_q + 3'd1;
  end
  always_comb begin
    assume (rst_i == !f_ran_q);
    if (rst_i) assume (!request_i && !passes_i && !bank_i);
    if (f_age_q != '0) begin
      assume (!request_i);
      assume ({write_i, address_i, data_i} == f_asked_q);
    end
    if (bank_i != f_bank_q) assume (bank_i == f_bank_named_q);
    else if (passes_i && !f_passes_q) assume (hold_o || bank_i == f_bank_named_q);
  end

  // The settings that are written and which of them there are, by address; the word at any address
  logic        f_on_q, f_hold_q, f_by_encoder_q, f_table_bank_q;
  logic [1:0]  f_packets_q;
  logic [15:0] f_length_q;
  logic [11:0] f_column_q;
  logic [5:0]  f_section_q;
  logic [9:1]  f_there_q;   // verdict_defect to verdict_table
  logic        f_any_there_q, f_free_q, f_good, f_takes, f_took_q;
  logic [31:0] f_any_q;
  logic [17:0] f_high;
  assign f_high = {1'b0, data_i[16:0]} + {4'd0, data_i[30:17]};
  always_comb begin
    case (address_i)
      8'h80: f_good = data_i[5:4] != 2'd3 && (!data_i[0] || f_there_q[8:1] == 8'hFF);
      8'h88: f_good = data_i[7:0] != '0 && data_i[15:12] != '0;
      8'h90: f_good = data_i[11:0] != '0 && data_i[23:16] != '0;
      8'h98, 8'h9C: f_good = data_i[23:0] != '0;
      8'h8C, 8'h94, 8'hA0, 8'hA4: f_good = 1'b1;
      8'hA8: f_good = 32'(data_i[11:0]) < MaxColumns && 32'(data_i[21:16]) < 1 << LogSections;
      8'hAC: f_good = f_free_q && f_high >> LimitBits == '0;
      8'hB0: f_good = f_free_q;
      default: f_good = 1'b0;
    endcase
  end
  assign f_takes = f_age_q == 3'd3 && write_i && f_good;
  always_ff @(posedge clk_i) begin
    // Limits may be written, as seen two clocks before.
    if (f_age_q == 3'd1) begin
      f_free_q <= !f_on_q || f_table_bank_q != f_bank_named_q &&
                             !((passes_i || f_hold_q) && f_table_bank_q == bank_i);
    end
    if (f_age_q == 3'd3) f_took_q <= f_takes;
    if (rst_i) begin
      {f_on_q, f_hold_q, f_by_encoder_q, f_bank_named_q, f_table_bank_q, f_packets_q} <= '0;
      {f_length_q, f_column_q, f_section_q, f_there_q, f_any_there_q}                 <= '0;
    end else if (f_takes) begin
      if (address_i == 8'h80) begin
        {f_packets_q, f_by_encoder_q, f_hold_q, f_on_q} <= {data_i[5:4], data_i[2:0]};
      end
      if (address_i == 8'h88) f_bank_named_q <= data_i[18];
      if (address_i == 8'hA4) f_length_q <= data_i[15:0];
      if (address_i == 8'hA8) begin
        {f_table_bank_q, f_section_q, f_column_q} <= {data_i[24], data_i[21:16], data_i[11:0]};
      end
      for (int word_of = 2; word_of <= 10; word_of++) begin
        if (32'(address_i) == 'h80 + 4 * word_of) f_there_q[word_of-1] <= 1'b1;
      end
      if (address_i == {2'b10, f_word, 2'b00}) {f_any_there_q, f_any_q} <= {1'b1, data_i};
    end
  end

  always_comb if (f_ran_q) begin
    // Rule 1: three clocks behind a request, writes that are allowed and no others are taken.
    assert (put_q == f_takes && write_o == f_takes);
    assert (write_limits_o == (f_takes && address_i == 8'hAC));
    // Rule 2: the settings are what was taken. So a write that is refused changes nothing.
    assert ({on_o, hold_o, by_encoder_o, packets_o, length_o, write_bank_o} ==
            {f_on_q, f_hold_q, f_by_encoder_q, f_packets_q, f_length_q, f_table_bank_q});
    assert (column_q == f_column_q && section_q == f_section_q && named_bank_q == f_bank_named_q);
    // Rule 3: while verdicts are on, neither limits nor beginnings of sections go to a bank that
    // verdict_defect names or that judges a part, even one that has just begun.
    if ((write_limits_o || write_o && write_word_o[LogWords-1]) && on_o) begin
      assert (write_bank_o != f_bank_named_q && !(passes_i && write_bank_o == bank_i));
    end
    // Rule 4: a beginning goes to the section that verdict_table names, and limits to its column.
    if (write_o && write_word_o[LogWords-1]) begin
      assert (address_i == 8'hB0);
      assert (write_word_o[SectionBits:0] == {f_table_bank_q, write_section_o});
    end
    if (write_limits_o) begin
      assert (write_section_o == SectionBits'(f_section_q));
      assert (12'(write_column_o) == f_column_q && 32'(f_section_q) < 1 << LogSections);
      assert (write_limits_word_o[0+:LimitBits] == LimitBits'(data_i[16:0]));
      assert (18'(write_limits_word_o[LimitBits+:LimitBits]) == f_high);
    end
    // Rule 5: the answer tells what was refused, and a read the word that was written last.
    if (f_age_q == 3'd5) begin
      if (write_i) assert (error_o == !f_took_q);
      else begin
        assert (error_o == !(address_i == 8'h80 || address_i == 8'hC0 || address_i == 8'hC4 ||
                             address_i >= 8'h88 && address_i <= 8'hB0 && address_i[1:0] == '0));
        if (address_i == {2'b10, f_word, 2'b00}) begin
          assert (data_o == (error_o || !f_any_there_q ? '0 : f_any_q));
        end
      end
    end
    // The registers agree with that.
    assert (asked_q == {f_age_q == 3'd3, f_age_q == 3'd2, f_age_q == 3'd1});
    assert (f_age_q < 3'd6);
    assert (written_q[9:2] == f_there_q[8:1]);
    assert (written_q[f_word] == f_any_there_q);
    assert (32'(column_q) < MaxColumns && 32'(section_q) < 1 << LogSections);
    if (f_any_there_q) assert (f_kept == f_any_q);
  end
  // Writes in the order of a host, each as soon as it may come; 15: another order
  logic [3:0] f_order_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_order_q <= 4'd0;
    else if (f_age_q == '0 ? !request_i : f_age_q == 3'd3 && !f_takes) f_order_q <= 4'd15;
    else if (f_takes) begin
      if (address_i == 8'h88 + {2'b00, f_order_q, 2'b00} && f_order_q < 4'd8 ||
          address_i == 8'h80 && f_order_q == 4'd8) f_order_q <= f_order_q + 4'd1;
      else f_order_q <= 4'd15;
    end
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    cover (write_limits_o && on_o && f_order_q == 4'd9);
    cover (f_age_q == 3'd5 && write_i && error_o && address_i == 8'h80);
    cover (f_age_q == 3'd5 && !write_i && data_o == 32'h12345678);
  end
`endif

endmodule

`default_nettype wire
