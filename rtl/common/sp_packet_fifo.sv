// Dual-clock packet FIFO: a packet shows at the output only once its last word is in.
//
// Guarantees: packets come out whole and in order, for any two clocks. Within a packet the output
// never waits for the writer; a word may come a few read clocks after the one before it. wr_free_o
// counts the free places and never promises one that is not free. The writer begins a packet only
// if all of it has room, and gives each packet at least PacketWords words. Reset: both sides
// together.
`default_nettype none

module sp_packet_fifo #(
  parameter int Width = 128,  // 1 or more
  parameter int LogDepth = 9,  // 1..15
  parameter int PacketWords = 1  // least number of words of a packet: 1..2^LogDepth
) (
  input  wire logic              wr_clk_i,
  input  wire logic              wr_rst_i,
  input  wire logic              wr_valid_i,
  input  wire logic              wr_last_i,
  input  wire logic [Width-1:0]  wr_data_i,
  output logic      [LogDepth:0] wr_free_o,

  input  wire logic              rd_clk_i,
  input  wire logic              rd_rst_i,
  output logic                   rd_valid_o,
  input  wire logic              rd_ready_i,
  output logic                   rd_last_o,
  output logic      [Width-1:0]  rd_data_o
);

  if (Width < 1) begin : gen_width
    width_is_less_than_1 u_error ();
  end
  if (PacketWords < 1 || PacketWords > 1 << LogDepth) begin : gen_packet_words
    packet_words_is_not_in_1_to_2_to_the_log_depth u_error ();
  end

  // Packets are counted modulo more than the FIFO can hold: whole packets, and one with only its
  // last word left.
  localparam int CountBits = $clog2((1 << LogDepth) / PacketWords + 2);

  // Packets written, Gray-coded: one step per packet, so the count may cross as it is.
  logic [CountBits-1:0] written_next_q;  // one more: no carry chain before the Gray code
  logic [CountBits-1:0] written_gray_q;
  logic [CountBits-1:0] written_gray_seen;
  logic [CountBits-1:0] read_q;

  logic              word_valid;
  logic              whole;  // all of the packet at the output is in the FIFO

  function automatic logic [CountBits-1:0] gray_of(input logic [CountBits-1:0] binary);
    gray_of = binary ^ (binary >> 1);
  endfunction

  always_ff @(posedge wr_clk_i) begin
    if (wr_rst_i) begin
      written_next_q <= CountBits'(1);
      written_gray_q <= '0;
    end else if (wr_valid_i && wr_last_i) begin
      written_next_q <= written_next_q + 1'b1;
      written_gray_q <= gray_of(written_next_q);
    end
  end

  sp_sync #(
    .Width(CountBits)
  ) u_written_to_rd (
    .clk_i(rd_clk_i),
    .rst_i(rd_rst_i),
    .d_i  (written_gray_q),
    .q_o  (written_gray_seen)
  );

  assign whole      = written_gray_seen != (read_q ^ (read_q >> 1));
  assign rd_valid_o = word_valid && whole;

  always_ff @(posedge rd_clk_i) begin
    if (rd_rst_i) read_q <= '0;
    else if (rd_valid_o && rd_ready_i && rd_last_o) read_q <= read_q + 1'b1;
  end

  sp_async_fifo #(
    .Width   (Width + 1),
    .LogDepth(LogDepth)
  ) u_fifo (
    .wr_clk_i  (wr_clk_i),
    .wr_rst_i  (wr_rst_i),
    .wr_valid_i(wr_valid_i),
    .wr_data_i ({wr_last_i, wr_data_i}),
    .wr_free_o (wr_free_o),
    .rd_clk_i  (rd_clk_i),
    .rd_rst_i  (rd_rst_i),
    .rd_valid_o(word_valid),
    .rd_ready_i(rd_ready_i && whole),
    .rd_data_o ({rd_last_o, rd_data_o})
  );

`ifdef FORMAL
  // Two free clocks: each may rise at any moment.
  (* gclk *) logic f_moment;
  logic f_wr_rise, f_rd_rise, f_wr_one, f_rd_one, f_wr_two, f_rd_two, f_run;
  sp_formal_clocks u_clocks (
    .a_clk_i (wr_clk_i),
    .a_rst_i (wr_rst_i),
    .b_clk_i (rd_clk_i),
    .b_rst_i (rd_rst_i),
    .a_rise_o(f_wr_rise),
    .b_rise_o(f_rd_rise),
    .a_one_o (f_wr_one),
    .b_one_o (f_rd_one),
    .a_two_o (f_wr_two),
    .b_two_o (f_rd_two),
    .run_o   (f_run)
  );
  // Inputs change only with their clock. The writer looks for a place first, and its packets have
  // PacketWords words or more.
  logic [4:0] f_words_q;  // words of the packet being written, so far
  always_ff @(posedge wr_clk_i) begin
    if (wr_rst_i) f_words_q <= '0;
    else if (wr_valid_i) f_words_q <= wr_last_i ? 5'd0 : f_words_q + 5'd1;
  end
  always_comb if (wr_valid_i) assume (!wr_rst_i && wr_free_o != '0);
  always_comb if (wr_valid_i && wr_last_i) assume (f_words_q >= 5'(PacketWords - 1));
  always_ff @(posedge f_moment) if (f_run) begin
    if (!f_wr_rise) assume ($stable(wr_valid_i) && $stable(wr_last_i) && $stable(wr_data_i));
    if (!f_rd_rise) assume ($stable(rd_ready_i));
  end

  // Rule 1: a packet shows at the output only once its last word is in, and then goes on to its end
  // without waiting for the writer. From its first word to its last, more packets are written than
  // read.
  logic [4:0] f_in_q, f_out_q, f_whole;  // modulo 32: more than fit
  logic       f_inside_q;
  assign f_whole = f_in_q - f_out_q;
  always_ff @(posedge wr_clk_i) begin
    if (wr_rst_i) f_in_q <= '0;
    else f_in_q <= f_in_q + 5'(wr_valid_i && wr_last_i);
  end
  always_ff @(posedge rd_clk_i) begin
    if (rd_rst_i) f_out_q <= '0;
    else f_out_q <= f_out_q + 5'(rd_valid_o && rd_ready_i && rd_last_o);
  end
  always_ff @(posedge rd_clk_i) begin
    if (rd_rst_i) f_inside_q <= 1'b0;
    else if (rd_valid_o && rd_ready_i) f_inside_q <= !rd_last_o;
  end
  always_comb if (f_run) begin
    if (rd_valid_o || f_inside_q) assert (f_whole != '0 && whole);
    assert (f_whole <= 5'((1 << LogDepth) / PacketWords + 1));
  end

  // Rule 2: a word that waits at the output does not change (AXI4-Stream).
  always_ff @(posedge f_moment) if (f_run) begin
    if ($past(f_run && rd_valid_o && !rd_ready_i)) assert (rd_valid_o && $stable(rd_data_o) &&
                                                           $stable(rd_last_o));
    cover (rd_valid_o && f_inside_q && rd_last_o);
  end
`endif

endmodule

`default_nettype wire
