// Matching for self-projected structured light: turns (pixel, code) into a projector line, four
// pixels in every clock, with a table in a memory outside this module. include/selfproj/model/gray_match.h is its
// model.
//
//   codes ─▶ address {group, code} ─▶ memory port, 4 lanes ─▶ words
//
// Lane i reads the table of the pixels 4k + i: 2^Bits words of 16 bits per pixel, at address {k,
// code}. k counts the groups of four pixels of a frame in the order of the image, from 0. A code
// that is not measurable or has more than Bits bits gives None; the word of its lane is ignored.
//
// Where a word comes too late (mem_late_i comes with it), its beat and the rest of the frame do not
// leave. One clock after the beat would have left, m_break_o comes with status late memory, and
// late_o counts. A later break of the same frame is not passed on. A frame of more than Groups
// groups wraps.
//
// Timing, for a beat of clock t: the words are asked for in t + 1, are valid in t + 1 + Latency,
// and leave in t + 2 + Latency. A break takes as long. Nothing can be stalled.
`default_nettype none

module sp_gray_match #(
  parameter int Groups = 65536,  // largest image, in groups of four pixels: 2 or more
  parameter int Bits = 4,        // m: 1..8
  parameter int Latency = 2,     // of the memory, in clocks: 1 or more
  // derived, do not set
  parameter int AddressBits = $clog2(Groups) + Bits
) (
  input  wire logic        clk_i,                              // pixel clock
  input  wire logic        rst_i,                              // active high, synchronous

  // Codes of sp_gray_decoder or sp_median3x3, leftmost in 15..0
  input  wire logic        s_valid_i,                          // a beat of four codes
  input  wire logic [63:0] s_codes_i,                          // leftmost code in 15..0
  input  wire logic        s_start_i,                          // first beat of a frame
  input  wire logic        s_line_start_i,                     // first beat of a line
  input  wire logic        s_line_end_i,                       // last beat of a line
  input  wire logic        s_break_i,                          // the frame breaks
  input  wire logic [sp_spec_pkg::StatusBits-1:0] s_status_i,  // why, with s_break_i

  // Memory port: lane i in bits AddressBits * i and 16 * i
  output logic             mem_read_o,                         // four words are asked for
  output logic [4*AddressBits-1:0] mem_address_o,              // lane i in AddressBits * i
  input  wire logic [63:0] mem_data_i,  // lane i in 16 * i, Latency clocks after mem_read_o
  input  wire logic        mem_late_i,  // the words came too late and are void

  // Projector lines in units of 1/64, or None (0xFFFF)
  output logic             m_valid_o,                          // a beat of four lines
  output logic [63:0]      m_lines_o,                          // leftmost in 15..0
  output logic             m_start_o,                          // first beat of a frame
  output logic             m_line_start_o,                     // first beat of a line
  output logic             m_line_end_o,                       // last beat of a line
  output logic             m_break_o,                          // the frame breaks
  output logic [sp_spec_pkg::StatusBits-1:0] m_status_o,       // why, with m_break_o

  output logic [31:0]      late_o                              // frames that lost a word
);

  if (Groups < 2) begin : gen_groups
    groups_is_less_than_2 u_error ();
  end
  if (Bits < 1 || Bits > 8) begin : gen_bits
    bits_is_not_in_1_to_8 u_error ();
  end
  if (Latency < 1) begin : gen_latency
    latency_is_less_than_1 u_error ();
  end

  localparam int StatusBits = sp_spec_pkg::StatusBits;
  localparam int CodeBits = sp_spec_pkg::CodeCodeBits;
  localparam int GroupBits = $clog2(Groups);
  localparam int Depth = 1 + Latency;  // clocks from a beat to its words
  localparam logic [15:0] None = 16'hFFFF;

  // --- Address ---
  logic [GroupBits-1:0] next_q, group;
  logic [3:0]           found;  // codes that have a word

  assign group = s_start_i ? '0 : next_q;

  always_ff @(posedge clk_i) if (s_valid_i) next_q <= group + GroupBits'(1);

  for (genvar i = 0; i < 4; i++) begin : gen_address
    assign found[i] = s_codes_i[16*i+sp_spec_pkg::CodeMeasurableLsb] &&
                      s_codes_i[16*i+Bits+:CodeBits-Bits] == '0;

    always_ff @(posedge clk_i) mem_address_o[AddressBits*i+:AddressBits] <=
        {group, s_codes_i[16*i+:Bits]};
  end

  // --- Signals beside the words; the index counts the clocks after the beat ---
  logic [Depth:1]              valid_q, start_q, line_start_q, line_end_q, break_q;
  logic [4*Depth-1:0]          found_q;
  logic [StatusBits*Depth-1:0] status_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q <= '0;
      break_q <= '0;
    end else begin
      valid_q <= {valid_q[Depth-1:1], s_valid_i};
      break_q <= {break_q[Depth-1:1], s_break_i};
    end
    start_q      <= {start_q[Depth-1:1], s_start_i};
    line_start_q <= {line_start_q[Depth-1:1], s_line_start_i};
    line_end_q   <= {line_end_q[Depth-1:1], s_line_end_i};
    found_q      <= {found_q[4*Depth-5:0], found};
    status_q     <= {status_q[StatusBits*(Depth-1)-1:0], s_status_i};
  end

  assign mem_read_o = valid_q[1];

  // --- Words ---
  logic lost_q;      // a word of the frame came too late
  logic lost_before;  // one came too late before this beat
  logic late;        // first late word of a frame
  logic late_q;      // it was one clock ago

  assign lost_before = lost_q && !start_q[Depth];
  assign late        = valid_q[Depth] && mem_late_i && !lost_before;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      lost_q    <= 1'b0;
      late_q    <= 1'b0;
      m_valid_o <= 1'b0;
      m_break_o <= 1'b0;
      late_o    <= '0;
    end else begin
      if (valid_q[Depth]) lost_q <= lost_before || mem_late_i;
      late_q    <= late;
      m_valid_o <= valid_q[Depth] && !lost_before && !mem_late_i;
      m_break_o <= late_q || break_q[Depth] && !lost_q;
      if (late) late_o <= late_o + 32'd1;
    end
    m_start_o      <= start_q[Depth];
    m_line_start_o <= line_start_q[Depth];
    m_line_end_o   <= line_end_q[Depth];
    m_status_o     <= late_q ? StatusBits'(1) << sp_spec_pkg::StatusLateMemoryBit
                             : status_q[StatusBits*(Depth-1)+:StatusBits];
  end

  for (genvar i = 0; i < 4; i++) begin : gen_word
    always_ff @(posedge clk_i) m_lines_o[16*i+:16] <= found_q[4*(Depth-1)+i] ?
                                                      mem_data_i[16*i+:16] : None;
  end

  logic unused;
  assign unused = &{1'b0, s_codes_i};

endmodule

`default_nettype wire
