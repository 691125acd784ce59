// External memory for the state of the Gray-code decoder: the memory port of sp_gray_decoder on one side, AXI4 bursts on the
// other.
//
//   memory port ◀─ FIFO ◀─ read bursts, ahead of the frame          a word a clock each way,
//   memory port ─▶ FIFO ─▶ write bursts, behind it                  any latency and stalls
//
// The words of a frame lie one after another from base_i on, 16 bytes each; base_i is a multiple of 16 · BurstWords. After every frame
// (end_i) the writes are finished and acknowledged, and what was read too far is thrown away (up to 2^LogDepth words after the
// frame's last are read); then the first words of the next frame are read. A frame that starts before the first of them
// is there, a word that is not there when it is asked for, and one whose place in the write FIFO might be missing come too
// late (rd_late_o): nothing more of that frame is read or written. Error responses are not looked at.
//
// Timing: rd_data_o and rd_late_o stand two clocks after rd_en_i. A frame's words are written at most WriteDelay clocks after they
// were asked for.
`default_nettype none

module sp_gray_axi_memory #(
  parameter int Width = 128,         // of the state of four pixels; up to 128
  parameter int AddressBits = 32,
  parameter int LogDepth = 8,        // of both FIFOs, in words
  parameter int BurstWords = 16      // at most 16 · 16 bytes: no burst crosses a boundary of 4 KiB
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,
  input  wire logic [AddressBits-1:0] base_i,

  // Memory port of sp_gray_decoder
  input  wire logic                   rd_en_i,
  input  wire logic                   rd_first_i,
  output logic      [Width-1:0]       rd_data_o,
  output logic                        rd_late_o,
  input  wire logic                   wr_en_i,
  input  wire logic [Width-1:0]       wr_data_i,
  input  wire logic                   end_i,

  // AXI4: one identifier, bursts of words of 16 bytes with rising addresses
  output logic                        m_axi_arvalid_o,
  input  wire logic                   m_axi_arready_i,
  output logic      [AddressBits-1:0] m_axi_araddr_o,
  output logic      [7:0]             m_axi_arlen_o,
  input  wire logic                   m_axi_rvalid_i,
  output logic                        m_axi_rready_o,
  input  wire logic [127:0]           m_axi_rdata_i,
  output logic                        m_axi_awvalid_o,
  input  wire logic                   m_axi_awready_i,
  output logic      [AddressBits-1:0] m_axi_awaddr_o,
  output logic      [7:0]             m_axi_awlen_o,
  output logic                        m_axi_wvalid_o,
  input  wire logic                   m_axi_wready_i,
  output logic      [127:0]           m_axi_wdata_o,
  output logic                        m_axi_wlast_o,
  input  wire logic                   m_axi_bvalid_i,
  output logic                        m_axi_bready_o
);

  localparam int WriteDelay = 5;
  localparam int Depth = 1 << LogDepth;

  // --- The frame ---
  logic                draining_q;  // after a frame, until the memory is as if nothing had been read ahead
  logic                fresh_q;     // the word at the FIFO's output is the frame's first
  logic                frame_ok_q;  // no word of it came too late
  logic                drained, clear;
  logic                ok, pop, room;
  logic [WriteDelay:1] ok_q;        // of the words on their way through the decoder

  // --- Reading ahead ---
  logic [LogDepth:0]     reserved_q;     // words asked for and not taken
  logic [LogDepth:0]     outstanding_q;  // ... and not come
  logic                  ar, r, head_valid;
  logic [Width-1:0]      head;
  logic [Width-1:0]      word_q;
  logic                  late_q, fifo_ready_unused;

  assign ar              = m_axi_arvalid_o && m_axi_arready_i;
  assign r               = m_axi_rvalid_i && m_axi_rready_o;
  assign m_axi_arlen_o   = 8'(BurstWords - 1);
  assign m_axi_rready_o  = 1'b1;
  assign ok              = head_valid && room && !draining_q && (rd_first_i ? fresh_q : frame_ok_q);
  assign pop             = rd_en_i && ok;

  always_ff @(posedge clk_i) begin
    if (rst_i || clear) begin
      m_axi_arvalid_o <= 1'b0;
      m_axi_araddr_o  <= base_i;
      reserved_q      <= '0;
      outstanding_q   <= '0;
    end else begin
      if (ar) m_axi_araddr_o <= m_axi_araddr_o + AddressBits'(16 * BurstWords);
      // A burst that was offered stays offered.
      if (!m_axi_arvalid_o || m_axi_arready_i) begin
        m_axi_arvalid_o <= !draining_q && 32'(reserved_q) + (ar ? 2 * BurstWords : BurstWords) <= Depth;
      end
      reserved_q    <= reserved_q + (ar ? (LogDepth + 1)'(BurstWords) : '0) - (LogDepth + 1)'(pop);
      outstanding_q <= outstanding_q + (ar ? (LogDepth + 1)'(BurstWords) : '0) - (LogDepth + 1)'(r);
    end
  end

  sp_fifo #(
    .Width   (Width),
    .LogDepth(LogDepth)
  ) u_ahead (
    .clk_i    (clk_i),
    .rst_i    (rst_i || clear),
    .s_valid_i(r),
    .s_ready_o(fifo_ready_unused),
    .s_data_i (m_axi_rdata_i[Width-1:0]),
    .m_valid_o(head_valid),
    .m_ready_i(pop),
    .m_data_o (head)
  );

  always_ff @(posedge clk_i) begin
    {rd_data_o, word_q} <= {word_q, head};
    {rd_late_o, late_q} <= {late_q, !ok};
  end

  // --- Writing behind ---
  logic [LogDepth:0] level_q;        // words in the FIFO
  logic [LogDepth:0] unannounced_q;  // ... for which no burst was begun
  logic [LogDepth:0] announced_q;    // words of bursts that were begun, not yet sent
  logic [LogDepth:0] bursts_q;       // bursts not yet acknowledged
  logic [7:0]        left_q;         // of the burst that is sent, after the present word; bursts are full but for the last
  logic              put, aw, w, b, part, write_valid, write_ready_unused;
  logic [Width-1:0]  write_word;
  logic [LogDepth:0] burst;
  logic [3:0]        settle_q;       // clocks until the frame's last word is in the FIFO

  assign put            = wr_en_i && ok_q[WriteDelay];
  assign room           = 32'(level_q) <= Depth - 2 * WriteDelay;
  assign part           = draining_q && settle_q == '0 && unannounced_q != '0;
  assign aw             = m_axi_awvalid_o && m_axi_awready_i;
  assign w              = m_axi_wvalid_o && m_axi_wready_i;
  assign b              = m_axi_bvalid_i && m_axi_bready_o;
  assign burst          = (LogDepth + 1)'(m_axi_awlen_o) + (LogDepth + 1)'(1);
  assign m_axi_bready_o = 1'b1;
  assign m_axi_wvalid_o = write_valid && announced_q != '0;
  assign m_axi_wdata_o  = 128'(write_word);
  assign m_axi_wlast_o  = left_q == '0 || announced_q == (LogDepth + 1)'(1) && !m_axi_awvalid_o && unannounced_q == '0 && draining_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      m_axi_awvalid_o <= 1'b0;
      level_q         <= '0;
      unannounced_q   <= '0;
      announced_q     <= '0;
      bursts_q        <= '0;
      left_q          <= 8'(BurstWords - 1);
      ok_q            <= '0;
    end else begin
      ok_q          <= {ok_q[WriteDelay-1:1], pop};
      level_q       <= level_q + (LogDepth + 1)'(put) - (LogDepth + 1)'(w);
      unannounced_q <= unannounced_q + (LogDepth + 1)'(put) - (aw ? burst : '0);
      announced_q   <= announced_q + (aw ? burst : '0) - (LogDepth + 1)'(w);
      bursts_q      <= bursts_q + (LogDepth + 1)'(aw) - (LogDepth + 1)'(b);
      if (w) left_q <= m_axi_wlast_o ? 8'(BurstWords - 1) : left_q - 8'd1;
      if (aw) m_axi_awvalid_o <= 1'b0;
      else if (!m_axi_awvalid_o) m_axi_awvalid_o <= 32'(unannounced_q) >= BurstWords || part;
    end
    if (rst_i || clear) m_axi_awaddr_o <= base_i;
    else if (aw) m_axi_awaddr_o <= m_axi_awaddr_o + AddressBits'(16 * BurstWords);
    if (!m_axi_awvalid_o) m_axi_awlen_o <= 32'(unannounced_q) >= BurstWords ? 8'(BurstWords - 1) : 8'(unannounced_q) - 8'd1;
  end

  sp_fifo #(
    .Width   (Width),
    .LogDepth(LogDepth)
  ) u_behind (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .s_valid_i(put),
    .s_ready_o(write_ready_unused),
    .s_data_i (wr_data_i),
    .m_valid_o(write_valid),
    .m_ready_i(m_axi_wready_i && announced_q != '0),
    .m_data_o (write_word)
  );

  // --- From frame to frame ---
  assign drained = settle_q == '0 && !m_axi_arvalid_o && outstanding_q == '0 && level_q == '0 && bursts_q == '0 &&
                   !m_axi_awvalid_o && unannounced_q == '0;
  assign clear   = draining_q && drained;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      draining_q <= 1'b0;
      fresh_q    <= 1'b1;
      frame_ok_q <= 1'b0;
      settle_q   <= '0;
    end else begin
      if (end_i && !fresh_q && !draining_q) begin
        draining_q <= 1'b1;
        settle_q   <= 4'(WriteDelay + 2);
      end else begin
        if (clear) draining_q <= 1'b0;
        if (settle_q != '0) settle_q <= settle_q - 4'd1;
      end
      if (clear) fresh_q <= 1'b1;
      else if (pop) fresh_q <= 1'b0;
      if (rd_en_i) frame_ok_q <= ok;
    end
  end

  if (Width < 128) begin : gen_narrow
    logic unused;
    assign unused = ^m_axi_rdata_i[127:Width];
  end

endmodule

`default_nettype wire
