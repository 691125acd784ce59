// Tells where parts begin and end, which section of a part passes, and which settings are in force.
//
// By light: a part begins with the frame after a whole frame with `lit` lit columns or more, and
// ends before the frame that follows `dark_frames` whole frames in a row that have fewer. By the
// encoder: part k begins with the first frame not before start + k * pitch and ends before the
// first frame that is `length` or more behind that point, modulo 2^24. A part ends where the way of
// telling them changes.
//
// The words of sp_verdict_registers are kept in a memory, which write_i fills. The rule for parts
// is read from it for each frame, one word after the other, so it counts at once; the settings
// where a part begins, and only while hold_i is 0. With hold_i from the beginning no part begins.
//
// frame_i begins a frame. Fourteen clocks later, and one more for each write_i meanwhile, start_o
// says that all outputs are those of this frame. All but fresh_o and word_o stand still until the
// next frame_i. found_i
// ends the frame: found_whole_i says that it did not break, and found_lit_i, which stands still
// until the next start_o, how many columns were lit. frame_i comes after the found_i of the frame
// before, or found_i does not come at all: then that frame changes nothing. With restart_i it is the
// first one of all, and no part passes before it.
//
// From start_o to the next frame_i word_o is the word of the register ejector_delay, three clocks
// after it was written.
//
//   frame_i  _/1\_ … ______
//   step_q   -----<1> … <13>---
//   start_o  _______ … ____/1\_
`default_nettype none

module sp_verdict_parts #(
  parameter int LogSections = 1,  // log2 of the sections of a bank: 0..6
  // derived, do not set
  parameter int SectionBits = LogSections > 0 ? LogSections : 1,
  parameter int LogWords = LogSections > 3 ? LogSections + 2 : 5
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  // Words of the registers, and from the middle on the counts at which sections begin, {1, bank,
  // section}
  input  wire logic                   write_i,
  input  wire logic [LogWords-1:0]    write_word_i,
  input  wire logic [31:0]            write_data_i,
  input  wire logic                   hold_i,
  input  wire logic                   by_encoder_i,

  input  wire logic                   frame_i,
  input  wire logic                   restart_i,   // with frame_i
  input  wire logic [23:0]            encoder_i,   // count of the frame, in the clock of frame_i
  input  wire logic                   found_i,
  input  wire logic                   found_whole_i,
  input  wire logic [11:0]            found_lit_i,

  output logic                        start_o,
  output logic                        in_part_o,
  output logic                        first_o,     // the frame is the first of its part
  output logic                        fresh_o,     // no whole frame of the part came before
  output logic      [15:0]            part_o,      // parts that have begun; wraps
  output logic      [SectionBits-1:0] section_o,
  output logic      [23:0]            count_o,     // of the encoder
  output logic      [31:0]            defect_o,    // in force: the registers verdict_defect
  output logic      [31:0]            shift_o,     // and verdict_shift
  output logic      [31:0]            word_o
);

  if (LogSections < 0 || LogSections > 6) begin : gen_log_sections
    log_sections_is_not_in_0_to_6 u_error ();
  end

  localparam int Base = 32'(sp_spec_pkg::RegVerdictControl);
  localparam logic [LogWords-1:0]
      Defect = LogWords'((32'(sp_spec_pkg::RegVerdictDefect) - Base) / 4),
      Shift = LogWords'((32'(sp_spec_pkg::RegVerdictShift) - Base) / 4),
      Light = LogWords'((32'(sp_spec_pkg::RegVerdictLight) - Base) / 4),
      Start = LogWords'((32'(sp_spec_pkg::RegVerdictStart) - Base) / 4),
      Length = LogWords'((32'(sp_spec_pkg::RegVerdictLength) - Base) / 4),
      Pitch = LogWords'((32'(sp_spec_pkg::RegVerdictPitch) - Base) / 4),
      Delay = LogWords'((32'(sp_spec_pkg::RegEjectorDelay) - Base) / 4);
  localparam int Steps = 13;

  logic [Steps:1]      step_q;        // one bit, or none
  logic                goes_on;       // not beside a write, which the memory cannot be read beside
  logic [LogWords-1:0] address;
  logic [31:0]         read_word, word_q;  // the word that was read; one clock later
  logic                by_encoder_q, hold_q;  // of this frame
  logic                chosen_q;      // the frame before was by the encoder
  logic                chooses;       // this is the first one by the encoder
  logic                waits_q;       // for the first part by the encoder
  logic [23:0]         point_q;       // where the part begins, or the one before began, or the first will
  logic [23:0]         way_q;         // from there to the frame
  logic [24:0]         beyond;        // way less the word; the borrow says that it is not as far
  logic                over_q;        // the part is over, by the encoder
  logic                reached_q;     // the next one begins
  logic                begins_next_q, begins, stays;
  logic                due_q;         // the light of the frame before has to be looked at
  logic                dark_q;        // it was too little
  logic [7:0]          dark_frames_q;
  logic                taken_q;       // settings are in force

  assign goes_on = !write_i;
  assign chooses = by_encoder_q && !chosen_q;
  assign beyond  = {1'b0, way_q} - {1'b0, word_q[23:0] & {24{!waits_q}}};
  assign begins  = (!hold_q || taken_q) &&
                   (by_encoder_q ? (!in_part_o || over_q) && reached_q : begins_next_q);
  assign stays   = in_part_o && !(by_encoder_q && over_q);
  assign word_o  = word_q;
  logic unused;
  assign unused = ^beyond[22:0];

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      step_q  <= '0;
      start_o <= 1'b0;
    end else begin
      start_o <= step_q[Steps] && goes_on;
      if (goes_on) step_q <= {step_q[Steps-1:1], frame_i};
      else if (frame_i) step_q[1] <= 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (frame_i) begin
      count_o      <= encoder_i;
      by_encoder_q <= by_encoder_i;
      hold_q       <= hold_i;
    end
    way_q <= count_o - point_q;
    if (goes_on) begin
      if (step_q[3]) dark_q <= found_lit_i < word_q[sp_spec_pkg::RegVerdictLightLitLsb+:12];
      if (step_q[4] && due_q) dark_frames_q <= dark_q ? dark_frames_q + 8'd1 : '0;
      if (step_q[6]) over_q <= !beyond[24];
      if (step_q[10]) reached_q <= !beyond[23];
    end
    // The first part by the encoder begins where the word says; the next ones one pitch farther
    // each, parts by light where they do.
    if (step_q[7] && chooses) point_q <= '0;
    else if (goes_on && (step_q[8] && chooses || step_q[11] && begins && !(by_encoder_q && waits_q)))
      point_q <= point_q + (by_encoder_q ? word_q[23:0] : way_q);
    if (step_q[11] && begins) dark_frames_q <= '0;
    if (goes_on && first_o && !hold_q) begin
      if (step_q[12]) defect_o <= word_q;
      if (step_q[13]) shift_o <= word_q;
    end
`ifndef SYNTHESIS
    // What it was before does not matter, which is proved, but an x would stay.
    if (rst_i) point_q <= '0;
`endif
    // Before the first part no column may count as out.
    if (rst_i) defect_o <= 32'd1 << sp_spec_pkg::RegVerdictDefectWidthLsb |
                           32'd1 << sp_spec_pkg::RegVerdictDefectHitsLsb;
  end

  always_ff @(posedge clk_i) begin
    if (rst_i || frame_i && restart_i) begin
      in_part_o     <= 1'b0;
      first_o       <= 1'b0;
      begins_next_q <= 1'b0;
      chosen_q      <= 1'b0;
      due_q         <= 1'b0;
    end else if (goes_on) begin
      if (step_q[5]) begin
        if (by_encoder_q != chosen_q) in_part_o <= 1'b0;
        else if (due_q && !by_encoder_q) begin
          begins_next_q <= !in_part_o && !dark_q;
          in_part_o     <= in_part_o && !(dark_q && dark_frames_q >=
                                          word_q[sp_spec_pkg::RegVerdictLightDarkFramesLsb+:8]);
        end
        due_q <= 1'b0;
      end
      if (step_q[11]) begin
        begins_next_q <= 1'b0;
        chosen_q      <= by_encoder_q;
        first_o       <= begins;
        in_part_o     <= stays || begins;
      end
      if (found_i && found_whole_i) due_q <= 1'b1;
    end else if (found_i && found_whole_i) due_q <= 1'b1;
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      taken_q <= 1'b0;
      waits_q <= 1'b0;
      fresh_o <= 1'b1;
      part_o  <= '0;
    end else begin
      if (step_q[8] && chooses) waits_q <= 1'b1;
      if (step_q[11] && goes_on && (begins || !by_encoder_q)) waits_q <= 1'b0;
      if (step_q[11] && goes_on && begins) begin
        fresh_o <= 1'b1;
        part_o  <= part_o + 16'd1;
      end else if (found_i && found_whole_i && in_part_o) fresh_o <= 1'b0;
      if (step_q[13] && first_o && !hold_q) taken_q <= 1'b1;
    end
  end

  // --- The words ---
  logic [LogWords-1:0] next_section;
`ifdef FORMAL
  (* anyconst *) logic [LogWords-1:0] f_place;  // any word
  logic [31:0] f_there;                         // it
`endif
  always_comb begin
    address = step_q[3:1] != '0 ? Light :
              step_q[4] ? Length :
              step_q[5] ? next_section :
              step_q[6] ? Start :
              step_q[9:7] != '0 ? Pitch :
              step_q[10] ? Defect :
              step_q[11] ? Shift : Delay;
  end

  sp_ram #(
    .Width   (32),
    .LogDepth(LogWords)
  ) u_words (
    .wr_clk_i (clk_i),
    .wr_en_i  (write_i),
    .wr_addr_i(write_word_i),
    .wr_data_i(write_data_i),
    .rd_clk_i (clk_i),
    .rd_en_i  (goes_on),
    .rd_addr_i(address),
    .rd_data_o(read_word)
`ifdef FORMAL
    ,
    .f_addr_i (f_place),
    .f_word_o (f_there),
    .f_first_o()
`endif
  );

  always_ff @(posedge clk_i) if (goes_on) word_q <= read_word;

  // --- Sections ---
  if (LogSections > 0) begin : gen_sections
    logic later_q, bank;
    assign bank         = defect_o[sp_spec_pkg::RegVerdictDefectBankLsb];
    assign next_section = {1'b1, (LogWords - 1)'({bank, section_o + SectionBits'(1)})};
    always_ff @(posedge clk_i) begin
      if (rst_i) section_o <= '0;
      else if (goes_on) begin
        if (step_q[7]) later_q <= !beyond[24];
        if (step_q[11]) begin
          if (begins) section_o <= '0;
          else if (stays && later_q && section_o != '1) section_o <= section_o + SectionBits'(1);
        end
      end
    end
  end else begin : gen_one_section
    assign next_section = Delay;
    assign section_o    = '0;
  end

`ifdef FORMAL
  // Assumptions: one reset at the beginning. frame_i comes behind the start_o of the frame before.
  // found_i comes once or not at all, between start_o and the next frame_i; found_lit_i stands
  // still from then to the next start_o. Words are written at any time.
  logic        f_ran_q = 1'b0;
  logic [3:0]  f_step_q;   // 0: none
  logic        f_last;     // start_o follows
  logic        f_open_q;   // found_i may come
  logic        f_found_q;  // it came
  logic [11:0] f_lit_q;
  logic        f_any_q;    // a frame has begun since the reset
  assign f_last = f_step_q == 4'd13 && !write_i;
  always_ff @(posedge clk_i) begin
    f_ran_q <= 1'b1;
    f_lit_q <= found_lit_i;
    if (rst_i) {f_step_q, f_open_q, f_found_q, f_any_q} <= '0;
    else begin
      if (frame_i) f_step_q <= 4'd1;
      else if (f_last) f_step_q <= 4'd0;
      else if (f_step_q != '0 && !write_i) f_step_q <= f_step_q + 4'd1;
      f_open_q  <= (start_o || f_open_q) && !found_i && !frame_i;
      f_found_q <= (found_i || f_found_q) && !start_o;
      f_any_q   <= f_any_q || frame_i;
    end
  end
  always_comb begin
    assume (rst_i == !f_ran_q);
    if (rst_i || f_step_q != '0 || start_o) assume (!frame_i);
    if (!f_open_q || frame_i) assume (!found_i);
    if (f_found_q) assume (found_lit_i == f_lit_q);
  end

  // Rule 1: start_o comes fourteen clocks behind frame_i, and one more for each write meanwhile.
  logic f_start_q;
  always_ff @(posedge clk_i) f_start_q <= f_last && !rst_i;
  always_comb if (f_ran_q) begin
    assert (start_o == f_start_q && f_step_q <= 4'd13);
    assert (step_q == (f_step_q == '0 ? '0 : 13'd1 << (f_step_q - 4'd1)));
  end

  // Rule 2: a word is what was last written to its place before it was read, any place.
  logic                f_known_q, f_known1_q, f_known2_q;
  logic [31:0]         f_word_q, f_word1_q, f_word2_q;
  logic [LogWords-1:0] f_from1_q, f_from2_q;  // places of read_word and of word_q
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_known_q, f_known1_q, f_known2_q} <= '0;
    else begin
      if (write_i && write_word_i == f_place) {f_known_q, f_word_q} <= {1'b1, write_data_i};
      if (!write_i) begin
        f_known1_q <= f_known_q && address == f_place;
        f_known2_q <= f_known1_q;
      end
    end
    if (!write_i) begin
      {f_word2_q, f_word1_q} <= {f_word1_q, f_word_q};
      {f_from2_q, f_from1_q} <= {f_from1_q, address};
    end
  end
  always_comb if (f_ran_q) begin
    if (f_known_q) assert (f_there == f_word_q);
    if (f_known1_q) assert (read_word == f_word1_q);
    if (f_known2_q) assert (word_q == f_word2_q);
  end

  // The definition (model/verdict.cpp). State behind the frame before:
  logic        f_in_q, f_due_q, f_chosen_q, f_waits_q, f_taken_q, f_fresh_q, f_first_q;
  logic [7:0]  f_dark_q;
  logic [15:0] f_part_q;
  logic [31:0] f_defect_q, f_shift_q;
  logic [SectionBits-1:0] f_section_q;
  // The frame, and the words as they were used for it
  logic        f_by_q, f_hold_q;
  logic [23:0] f_count_q;
  logic [11:0] f_lit_word_q;
  logic [7:0]  f_frames_q;
  logic [31:0] f_defect_word_q, f_shift_word_q;
  // What follows. Where the encoder is (over_q, reached_q, later_q) is taken from the circuit.
  logic        f_changed, f_looks, f_is_dark, f_by_light, f_in1, f_in2, f_begins, f_waits;
  logic        f_in, f_taken;
  logic        f_was_in_q;
  logic [7:0]  f_dark1;
  logic        f_later;
  logic [31:0] f_defect, f_shift;
  logic [SectionBits-1:0] f_section;
  if (LogSections > 0) begin : gen_f_later
    assign f_later = gen_sections.later_q;
  end else begin : gen_f_one_section
    assign f_later = 1'b0;
  end
  always_comb begin
    f_changed  = f_by_q != f_chosen_q;
    f_looks    = !f_changed && f_due_q && !f_by_q;
    f_is_dark  = found_lit_i < f_lit_word_q;
    f_dark1    = f_is_dark ? f_dark_q + 8'd1 : 8'd0;
    f_by_light = f_looks && !f_in_q && !f_is_dark;
    f_in1      = f_in_q && !f_changed && !(f_looks && f_is_dark && f_dark1 >= f_frames_q);
    f_waits    = f_changed || f_waits_q;
    f_in2      = f_in1 && !(f_by_q && over_q);
    f_begins   = (f_taken_q || !f_hold_q) && (f_by_q ? !f_in2 && reached_q : f_by_light);
    f_in       = f_in2 || f_begins;
    f_section  = f_begins ? '0 :
                 f_in2 && LogSections > 0 && f_section_q != '1 && f_later ?
                 f_section_q + SectionBits'(1) : f_section_q;
    f_taken    = f_taken_q || f_begins && !f_hold_q;
    f_defect   = f_begins && !f_hold_q ? f_defect_word_q : f_defect_q;
    f_shift    = f_begins && !f_hold_q ? f_shift_word_q : f_shift_q;
  end
  always_ff @(posedge clk_i) begin
    if (frame_i) {f_by_q, f_hold_q, f_count_q} <= {by_encoder_i, hold_i, encoder_i};
    if (!write_i) begin
      case (f_step_q)
        4'd3: f_lit_word_q <= word_q[11:0];
        4'd5: f_frames_q <= word_q[23:16];
        4'd12: f_defect_word_q <= word_q;
        4'd13: f_shift_word_q <= word_q;
        default: ;
      endcase
    end
    if (rst_i) begin
      {f_in_q, f_due_q, f_chosen_q, f_waits_q, f_taken_q, f_part_q, f_section_q} <= '0;
      {f_first_q, f_fresh_q, f_defect_q}                                       <= {2'b01, defect_o};
    end else if (frame_i && restart_i) begin
      {f_in_q, f_due_q, f_chosen_q, f_first_q} <= '0;
    end else if (f_last) begin
      {f_in_q, f_chosen_q, f_waits_q, f_taken_q} <= {f_in, f_by_q, f_waits && !f_begins, f_taken};
      {f_first_q, f_due_q, f_section_q}          <= {f_begins, 1'b0, f_section};
      f_defect_q <= f_defect;
      f_shift_q <= f_begins && !f_hold_q ? word_q : f_shift_q;
      f_dark_q  <= f_begins ? 8'd0 : f_due_q ? f_dark1 : f_dark_q;
      f_part_q  <= f_part_q + 16'(f_begins);
      f_fresh_q <= f_begins || f_fresh_q;
    end else if (found_i && found_whole_i) begin
      {f_due_q, f_fresh_q} <= {1'b1, f_fresh_q && !f_in_q};
    end
  end

  // Places that are read, step by step
  function automatic logic [LogWords-1:0] f_address(input logic [3:0] step);
    f_address = step <= 4'd3 ? LogWords'(4) : step == 4'd4 ? LogWords'(6) :
                step == 4'd5 ? next_section : step == 4'd6 ? LogWords'(5) :
                step <= 4'd9 ? LogWords'(7) : step == 4'd10 ? LogWords'(2) :
                step == 4'd11 ? LogWords'(3) : LogWords'(8);
  endfunction

  // Rule 3: behind start_o everything is as the definition says, until the next frame_i, with where
  // the encoder is.
  // Rule 4: settings, and with them the bank, change only for the first frame of a part, between
  // its frame_i and its start_o, and not if they are held. Held from the beginning, no part begins.
  // Rule 5: within a part sections go forward, one by one.
  logic                   f_free_q;    // a frame has come that was not held
  logic [31:0]            f_defect_before_q;
  logic                   f_settled_q; // defect_o was not just reset
  logic [SectionBits-1:0] f_section_before_q;
  always_ff @(posedge clk_i) begin
    f_free_q           <= !rst_i && (f_free_q || frame_i && !hold_i);
    f_defect_before_q  <= defect_o;
    f_section_before_q <= section_o;
    f_settled_q        <= f_ran_q;
    if (f_last) f_was_in_q <= f_in_q;
  end
  always_comb if (f_ran_q) begin
    if (f_step_q == '0) begin
      assert ({in_part_o, first_o} == {f_in_q, f_first_q});
      assert ({section_o, part_o} == {f_section_q, f_part_q});
      assert (fresh_o == f_fresh_q);
      if (f_any_q) assert (count_o == f_count_q);
      if (f_taken_q) assert ({defect_o, shift_o} == {f_defect_q, f_shift_q});
      if (f_any_q) assert (f_from2_q == Delay && f_from1_q == Delay);
    end
    if (f_settled_q && defect_o != f_defect_before_q) begin
      assert (f_step_q == 4'd13 && first_o && in_part_o && !f_hold_q);
    end
    if (!f_free_q) assert (!in_part_o && !taken_q && part_o == '0);
    if (f_settled_q && section_o != f_section_before_q) begin
      assert (first_o ? section_o == '0 : section_o == f_section_before_q + SectionBits'(1) &&
                                          section_o != '0 && in_part_o);
    end
    // The places of the words that are used
    if (f_step_q >= 4'd2) begin
      assert (f_from1_q == f_address(f_step_q - 4'd1));
      assert (f_step_q == 4'd2 || f_from2_q == f_address(f_step_q - 4'd2));
    end
  end

  // The registers agree with the definition, in each step as far as it has come.
  always_comb if (f_ran_q) begin
    if (!f_free_q) assert (!f_taken_q && (f_step_q == '0 || f_hold_q));
    if (f_in_q) assert (f_taken_q);
    if (f_step_q == '0 || f_step_q <= 4'd12) assert (taken_q == f_taken_q);
    if (f_chosen_q && f_waits_q) assert (!f_in_q);
    if (f_open_q || start_o) assert (f_step_q == '0);
    if (!f_any_q) begin
      assert (f_step_q == '0 && !start_o && !f_open_q && !f_found_q && !f_in_q && !f_due_q);
    end
    if (f_due_q) assert (f_found_q);
    if (f_step_q <= 4'd11) begin
      assert (chosen_q == f_chosen_q && section_o == f_section_q && part_o == f_part_q);
      assert (fresh_o == f_fresh_q && first_o == f_first_q);
    end
    if (f_step_q <= 4'd12 && f_taken_q) assert (defect_o == f_defect_q);
    if (f_taken_q) assert (shift_o == f_shift_q);
    if (f_step_q <= 4'd5) begin
      assert (in_part_o == f_in_q && due_q == f_due_q && !begins_next_q);
    end else begin
      assert (!due_q);
    end
    if (f_step_q <= 4'd7 && f_chosen_q) assert (waits_q == f_waits_q);
    if ((f_step_q <= 4'd7 || f_step_q <= 4'd11 && !f_by_q) && f_in_q && !f_chosen_q) begin
      assert (!waits_q);
    end
    if (f_step_q <= 4'd4 && f_in_q && !f_chosen_q) assert (dark_frames_q == f_dark_q);
    if (f_step_q >= 4'd1) begin
      assert ({by_encoder_q, hold_q, count_o} == {f_by_q, f_hold_q, f_count_q});
    end
    if (f_step_q >= 4'd4 && f_due_q) assert (dark_q == f_is_dark);
    if (f_step_q >= 4'd5 && f_step_q <= 4'd11 && f_in_q && !f_chosen_q &&
        !(f_step_q == 4'd11 && f_begins)) begin
      assert (dark_frames_q == (f_due_q ? f_dark1 : f_dark_q));
    end
    if (f_step_q >= 4'd6 && f_step_q <= 4'd11) begin
      assert (in_part_o == f_in1 && begins_next_q == f_by_light);
    end
    if (f_step_q == 4'd8 && f_by_q && !f_changed) assert (waits_q == f_waits_q);
    if (f_step_q >= 4'd9 && f_step_q <= 4'd11 && f_by_q) assert (waits_q == f_waits);
    if (f_step_q >= 4'd12) begin
      assert (waits_q == (f_by_q && f_waits && !f_begins));
      assert ({in_part_o, first_o, chosen_q, begins_next_q} == {f_in, f_begins, f_by_q, 1'b0});
      assert (section_o == f_section && part_o == f_part_q + 16'(f_begins));
      assert (fresh_o == (f_begins || f_fresh_q));
      if (f_begins) assert (dark_frames_q == '0);
      else if (f_in && !f_by_q) assert (dark_frames_q == (f_due_q ? f_dark1 : f_dark_q));
    end
    if (f_step_q == 4'd13) begin
      if (f_taken) assert (defect_o == f_defect);
      assert (taken_q == f_taken_q || taken_q && f_taken);
    end
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    // a second part by the encoder, with other settings; a part by light that ends; a part that is
    // held; a section farther
    cover (start_o && first_o && f_by_q && f_part_q == 16'd2 && !f_hold_q);
    cover (start_o && !in_part_o && f_part_q == 16'd1 && !f_by_q && f_was_in_q);
    cover (start_o && first_o && f_hold_q);
    cover (start_o && section_o == SectionBits'(1));
  end
`endif

endmodule

`default_nettype wire
