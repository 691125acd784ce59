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
// says that all outputs are those of this frame. They stand still until the next frame_i. found_i
// ends the frame: found_whole_i says that it did not break, and found_lit_i, which stands still
// until the next start_o, how many columns were lit. frame_i comes after the found_i of the frame
// before, or found_i does not come at all: then that frame changes nothing. With restart_i it is the
// first one of all, and no part passes before it.
//
// Between frames word_o is the word of the register ejector_delay, from three clocks after start_o
// on.
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
    .f_addr_i ('0),
    .f_word_o (),
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

endmodule

`default_nettype wire
