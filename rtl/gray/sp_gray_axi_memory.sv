// External memory for the state of the Gray-code decoder: the memory port of sp_gray_decoder on one
// side, AXI4 bursts on the other.
//
//   memory port ◀─ FIFO ◀─ read bursts, ahead of the frame          a word per clock each way,
//   memory port ─▶ FIFO ─▶ write bursts, behind it                  any latency and stalls
//
// The words of a frame lie one after another from base_i on, 16 bytes each. base_i is a multiple of
// 16 · BurstWords. After every frame (end_i) the module completes the writes and waits for their
// answers. It discards the words that it has read beyond the frame's last one, up to 2^LogDepth of
// them. Then it reads the first words of the next frame.
//
// rd_late_o says that a word came too late. After that nothing more of the frame is read or
// written. It happens when a frame starts before its first word has come, when a later word does
// not come in time, and when the write FIFO might have no room. At most 2^(LogDepth + 1) - 1 bursts
// are written and not yet answered. Error responses are ignored.
//
// Timing: rd_data_o and rd_late_o are valid two clocks after rd_en_i. A word of a frame is written
// at most WriteDelay clocks after it was asked for.
`default_nettype none

module sp_gray_axi_memory #(
  parameter int Width = 128,         // state of four pixels: 1..128
  parameter int AddressBits = 32,  // 13..64
  parameter int LogDepth = 8,        // log2 of the words in each of the two FIFOs: 4..24
  parameter int BurstWords = 16      // 1, 2, 4, 8 or 16: no burst may cross a boundary of 4 KiB
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

  // AXI4: one identifier, bursts of 16-byte words with rising addresses
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

  if (Width < 1 || Width > 128) begin : gen_width
    width_is_not_in_1_to_128 u_error ();
  end
  if (AddressBits < 13 || AddressBits > 64) begin : gen_address_bits
    address_bits_is_not_in_13_to_64 u_error ();
  end
  if (LogDepth < 4) begin : gen_log_depth
    log_depth_is_less_than_4 u_error ();
  end
  if (BurstWords < 1 || 16 % BurstWords != 0) begin : gen_burst_words
    burst_words_is_not_1_2_4_8_or_16 u_error ();
  end

  localparam int WriteDelay = 5;
  localparam int Depth = 1 << LogDepth;

  // --- The frame ---
  logic                draining_q;  // a frame has ended, and its transfers are not complete
  logic                fresh_q;     // the word at the output of the FIFO is the first of a frame
  logic                frame_ok_q;  // no word of the frame came too late
  logic                drained, clear;
  logic                ok, pop, room;
  logic [WriteDelay:1] ok_q;        // pop of the last clocks: words inside the decoder

`ifdef FORMAL
  // words into the FIFOs, and out of them
  logic [LogDepth:0] f_ahead_written, f_ahead_read, f_behind_written, f_behind_read;
`endif

  // --- Reading ahead ---
  logic [LogDepth:0]     reserved_q;     // words asked for and not taken
  logic [LogDepth:0]     outstanding_q;  // words asked for that have not come
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
        m_axi_arvalid_o <= !draining_q &&
                           32'(reserved_q) + (ar ? 2 * BurstWords : BurstWords) <= Depth;
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
`ifdef FORMAL
    ,
    .f_written_o(f_ahead_written),
    .f_read_o   (f_ahead_read)
`endif
  );

  always_ff @(posedge clk_i) begin
    {rd_data_o, word_q} <= {word_q, head};
    {rd_late_o, late_q} <= {late_q, !ok};
  end

  // --- Writing behind ---
  logic [LogDepth:0] level_q;        // words in the FIFO
  logic [LogDepth:0] unannounced_q;  // words in the FIFO whose burst has not begun
  logic [LogDepth:0] announced_q;    // words of the bursts that have begun, not yet sent
  logic [LogDepth:0] bursts_q;       // bursts not yet answered; no more begin than this can count
  logic [7:0]        left_q;         // words of the burst after the present one
  logic              put, aw, w, b, part, write_valid, write_ready_unused;
  logic [Width-1:0]  write_word;
  logic [LogDepth:0] burst;
  logic [3:0]        settle_q;       // clocks until the last word of the frame is in the FIFO

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
  assign m_axi_wlast_o  = left_q == '0 ||
                          announced_q == (LogDepth + 1)'(1) && !m_axi_awvalid_o &&
                          unannounced_q == '0 && draining_q;

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
      else if (!m_axi_awvalid_o) m_axi_awvalid_o <= (32'(unannounced_q) >= BurstWords || part) &&
                                                    !(&bursts_q);
    end
    if (rst_i || clear) m_axi_awaddr_o <= base_i;
    else if (aw) m_axi_awaddr_o <= m_axi_awaddr_o + AddressBits'(16 * BurstWords);
    if (!m_axi_awvalid_o) m_axi_awlen_o <= 32'(unannounced_q) >= BurstWords ? 8'(BurstWords - 1) :
                                           8'(unannounced_q) - 8'd1;
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
`ifdef FORMAL
    ,
    .f_written_o(f_behind_written),
    .f_read_o   (f_behind_read)
`endif
  );

  // --- From one frame to the next ---
  assign drained = settle_q == '0 && !m_axi_arvalid_o && outstanding_q == '0 && level_q == '0 &&
                   bursts_q == '0 &&
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

`ifdef FORMAL
  // Assumptions: one reset at the beginning; base_i does not change; a word that was asked for is
  // written back, unless it came too late. Words may be asked for, and frames may begin and end, at
  // any time.
  localparam int FBurstBytes = 16 * BurstWords;
  // counts modulo a power of two that is larger than any number under way
  localparam int FBits = LogDepth + 2;
  logic f_ran_q = 1'b0;
  logic [WriteDelay:1] f_asked_q = '0;
  (* anyconst *) logic [AddressBits-1:0] f_base;
  always_ff @(posedge clk_i) begin
    f_ran_q   <= 1'b1;
    f_asked_q <= {f_asked_q[WriteDelay-1:1], rd_en_i && !rst_i};
  end
  always_comb begin
    assume (rst_i == !f_ran_q);
    assume (base_i == f_base && f_base % AddressBits'(FBurstBytes) == '0);
    assume (wr_en_i == f_asked_q[WriteDelay]);
  end

  (* anyconst *) logic [FBits-1:0] f_burst;  // for rule 4

  // Counts since reading ahead for the frame began, modulo a power of two
  logic [AddressBits-1:0] f_ar_q, f_aw_q;          // read bursts; write bursts
  logic [FBits-1:0]       f_r_q, f_pop_q;          // words that came; words taken
  logic [FBits-1:0]       f_put_q, f_w_q;          // words given; words sent
  logic [FBits-1:0]       f_last_q, f_b_q;         // bursts sent completely; answered
  logic [7:0]             f_beat_q;                // words sent of the current burst
  logic [LogDepth:0]      f_short_q;               // words of the short burst, once begun
  always_ff @(posedge clk_i) begin
    if (rst_i || clear) {f_ar_q, f_aw_q, f_r_q, f_pop_q, f_put_q, f_w_q, f_last_q, f_b_q, f_beat_q,
                         f_short_q} <= '0;
    else begin
      f_ar_q   <= f_ar_q + AddressBits'(ar);
      f_aw_q   <= f_aw_q + AddressBits'(aw);
      f_r_q    <= f_r_q + FBits'(r);
      f_pop_q  <= f_pop_q + FBits'(pop);
      f_put_q  <= f_put_q + FBits'(put);
      f_w_q    <= f_w_q + FBits'(w);
      f_last_q <= f_last_q + FBits'(w && m_axi_wlast_o);
      f_b_q    <= f_b_q + FBits'(b);
      if (w) f_beat_q <= m_axi_wlast_o ? 8'd0 : f_beat_q + 8'd1;
      if (aw && 32'(m_axi_awlen_o) < BurstWords - 1) f_short_q <= burst;
    end
  end
  logic [FBits-1:0] f_coming, f_unsent, f_unanswered, f_ahead, f_on_way, f_whole, f_next, f_left;
  // words asked for that have not come
  assign f_coming     = FBits'(f_ar_q) * FBits'(BurstWords) - f_r_q;
  assign f_ahead      = f_r_q - f_pop_q;  // words that came and were not taken
  assign f_on_way     = f_pop_q - f_put_q;                            // words taken and not given
  assign f_unsent     = FBits'(f_aw_q) - f_last_q;  // bursts begun and not sent completely
  assign f_unanswered = f_last_q - f_b_q;  // bursts sent and not answered
  assign f_whole      = f_last_q * FBits'(BurstWords);                // words of the bursts sent
  assign f_next       = f_whole + FBits'(f_beat_q);                   // and of the current burst
  assign f_left       = f_burst - f_last_q;  // bursts to send before the one of rule 4
  // The memory keeps to AXI4 as well: it sends only words that were asked for, and answers only
  // complete bursts.
  always_comb begin
    if (f_coming == '0) assume (!m_axi_rvalid_i);
    if (f_unanswered == '0) assume (!m_axi_bvalid_i);
  end

  // Rule 1 (AXI4): what is offered stays unchanged until it is taken. (What the memory offers is
  // always taken.)
  always_ff @(posedge clk_i) if (f_ran_q && !$past(rst_i)) begin
    if ($past(m_axi_arvalid_o && !m_axi_arready_i)) begin
      assert (m_axi_arvalid_o && $stable(m_axi_araddr_o) && $stable(m_axi_arlen_o));
    end
    if ($past(m_axi_awvalid_o && !m_axi_awready_i)) begin
      assert (m_axi_awvalid_o && $stable(m_axi_awaddr_o) && $stable(m_axi_awlen_o));
    end
    if ($past(m_axi_wvalid_o && !m_axi_wready_i)) begin
      assert (m_axi_wvalid_o && $stable(m_axi_wdata_o) && $stable(m_axi_wlast_o));
    end
  end

  // Rule 2 (AXI4): no burst crosses a boundary of 4 KiB or is longer than BurstWords.
  // Rule 3: bursts lie one after another, starting at the base.
  logic [AddressBits-1:0] f_ar_end, f_aw_end;  // the last bytes
  assign f_ar_end = m_axi_araddr_o + (AddressBits'(m_axi_arlen_o) << 4) + AddressBits'(15);
  assign f_aw_end = m_axi_awaddr_o + (AddressBits'(m_axi_awlen_o) << 4) + AddressBits'(15);
  always_comb if (f_ran_q && !rst_i) begin
    if (m_axi_arvalid_o) begin
      assert (m_axi_araddr_o[AddressBits-1:12] == f_ar_end[AddressBits-1:12] &&
              32'(m_axi_arlen_o) < BurstWords);
    end
    if (m_axi_awvalid_o) begin
      assert (m_axi_awaddr_o[AddressBits-1:12] == f_aw_end[AddressBits-1:12] &&
              32'(m_axi_awlen_o) < BurstWords);
    end
    assert (m_axi_araddr_o == f_base + f_ar_q * AddressBits'(FBurstBytes));
    assert (m_axi_awaddr_o == f_base + f_aw_q * AddressBits'(FBurstBytes));
  end

  // Rule 4 (AXI4), for any one burst: it has as many words as its address announced, the last one
  // is marked, and none goes before the address.
  logic [7:0] f_length_q;
  always_ff @(posedge clk_i) if (aw && FBits'(f_aw_q) == f_burst) f_length_q <= m_axi_awlen_o;
  always_comb if (f_ran_q && !rst_i && m_axi_wvalid_o) begin
    assert (f_unsent != '0);
    if (f_last_q == f_burst) assert (m_axi_wlast_o == (f_beat_q == f_length_q));
  end

  // Rule 5: word n of a frame lies at base + 16 n. Reading: the FIFO passes on words in order
  // (sp_fifo), and every read burst is full. Writing: the first word of a burst is the one that its
  // address stands for.
  logic [LogDepth:0] f_behind;
  assign f_behind = f_behind_written - f_behind_read;
  always_comb if (f_ran_q && !rst_i) begin
    assert (f_ahead_written == f_r_q[LogDepth:0] && f_ahead_read == f_pop_q[LogDepth:0]);
    assert (f_behind == f_put_q[LogDepth:0] - f_w_q[LogDepth:0]);
    if (r) assert (fifo_ready_unused);
    if (put) assert (write_ready_unused);
    if (m_axi_arvalid_o) assert (32'(m_axi_arlen_o) == BurstWords - 1);
    if (m_axi_wvalid_o && f_beat_q == 8'd0) assert (f_w_q == f_whole);
  end
  logic f_ran2_q = 1'b0;
  always_ff @(posedge clk_i) f_ran2_q <= f_ran_q;
  always_ff @(posedge clk_i) if (f_ran2_q) begin
    if ($past(rd_en_i, 2) && !$past(rst_i, 2)) begin
      assert (rd_late_o == !$past(pop, 2));
      if (!rd_late_o) assert (rd_data_o == $past(head, 2));
    end
  end

  // Rule 6: the next frame is read only when this one is done: no word is still to come, and every
  // word taken was given, sent and answered.
  always_comb if (f_ran_q && !rst_i && clear) begin
    assert (f_coming == '0 && f_pop_q == f_put_q && f_put_q == f_w_q && f_unsent == '0 &&
            f_unanswered == '0);
    assert (!m_axi_arvalid_o && !m_axi_awvalid_o && !m_axi_wvalid_o && !put);
  end

  // Invariants that the rules need: the registers mean what their comments say.
  always_comb if (f_ran_q && !rst_i) begin
    assert (32'(outstanding_q) == 32'(f_coming) && 32'(reserved_q) == 32'(f_coming) + 32'(f_ahead));
    assert (32'(reserved_q) + (m_axi_arvalid_o ? BurstWords : 0) <= Depth);
    assert (FBits'(level_q) == f_put_q - f_w_q && f_on_way == FBits'($countones(ok_q)));
    assert ((ok_q & ~f_asked_q) == '0);
    assert (32'(level_q) + $countones(ok_q) <= Depth - WriteDelay + 1);
    assert (32'(level_q) == 32'(unannounced_q) + 32'(announced_q));
    assert (32'(bursts_q) == 32'(f_unsent) + 32'(f_unanswered));
    if (m_axi_awvalid_o) begin
      assert (!(&bursts_q) && 32'(burst) <= 32'(unannounced_q) && burst != '0);
      if (32'(burst) != BurstWords) assert (burst == unannounced_q && draining_q && settle_q == '0);
    end
    // Words of the bursts begun: all are full except a short one at the end.
    assert (32'(f_beat_q) < BurstWords && 32'(left_q) == BurstWords - 1 - 32'(f_beat_q));
    if (f_unsent == '0) assert (announced_q == '0 && f_beat_q == 8'd0);
    else if (f_short_q == '0) assert (32'(announced_q) == 32'(f_unsent) * BurstWords -
                                      32'(f_beat_q));
    else assert (32'(announced_q) == (32'(f_unsent) - 1) * BurstWords + 32'(f_short_q) -
                 32'(f_beat_q));
    if (announced_q == '0) assert (f_unsent == '0);
    if (f_short_q != '0) begin
      assert (unannounced_q == '0 && !m_axi_awvalid_o && draining_q && settle_q == '0 &&
              32'(f_short_q) < BurstWords);
    end
    if (f_short_q == '0 || f_unsent != '0) assert (f_w_q == f_next);
    if (f_left < f_unsent) begin
      assert (32'(f_length_q) == (f_short_q != '0 && 32'(f_left) + 1 == 32'(f_unsent) ?
                                  32'(f_short_q) : BurstWords) - 1);
    end
    // After a frame nothing more is taken, and the words taken come back in time.
    assert (draining_q || settle_q == '0);
    assert (!(draining_q && fresh_q));
    if (draining_q) begin
      assert (32'(settle_q) <= WriteDelay + 2);
      for (int i = 1; i <= WriteDelay; i++)
        if (ok_q[i]) assert (32'(settle_q) + i > WriteDelay + 2);
    end
  end

  // Reached: a short burst after a full one, sent and answered; words that come too late, because a
  // word is missing and because there is no room.
  always_comb if (f_ran_q && !rst_i) begin
    cover (clear && f_short_q != '0 && f_aw_q == AddressBits'(2));
    cover (rd_en_i && !rd_first_i && frame_ok_q && !head_valid && !draining_q);
    cover (rd_en_i && !rd_first_i && frame_ok_q && head_valid && !room);
  end
`endif

endmodule

`default_nettype wire
