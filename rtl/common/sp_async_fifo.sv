// Dual-clock FIFO: Gray-coded pointers through two-flop synchronizers, block RAM, output register.
//
// Guarantees: it holds 2^LogDepth words plus the one in the output register, takes and gives one
// word per clock, and keeps the order, for any two clocks. wr_free_o is a register that counts the
// free places and never promises one that is not free: places taken by the writer count at once,
// places freed by the reader count four to five write clocks later. The writer looks first and
// never writes while wr_free_o is 0. Reset: both sides together, each in its clock.
`default_nettype none

module sp_async_fifo #(
  parameter int Width = 32,  // 1 or more
  parameter int LogDepth = 4  // 1..15
) (
  input  wire logic             wr_clk_i,
  input  wire logic             wr_rst_i,
  input  wire logic             wr_valid_i,
  input  wire logic [Width-1:0] wr_data_i,
  output logic      [LogDepth:0] wr_free_o,

  input  wire logic             rd_clk_i,
  input  wire logic             rd_rst_i,
  output logic                  rd_valid_o,
  input  wire logic             rd_ready_i,
  output logic      [Width-1:0] rd_data_o
);

  if (LogDepth < 1 || LogDepth > 15) begin : gen_log_depth
    log_depth_is_not_in_1_to_15 u_error ();
  end

  function automatic logic [LogDepth:0] gray_of(input logic [LogDepth:0] binary);
    gray_of = binary ^ (binary >> 1);
  endfunction

  // Write side
  logic [LogDepth:0] wr_ptr_q;
  logic [LogDepth:0] wr_next_q;  // wr_ptr_q + 1: no carry chain before the Gray code
  logic [LogDepth:0] wr_gray_q;
  logic [LogDepth:0] rd_gray_seen;
  logic [LogDepth:0] rd_part_seen, rd_part_q;
  logic [LogDepth:0] rd_bin;
  logic              write;

  // Read side
  logic [LogDepth:0] rd_ptr_q;
  logic [LogDepth:0] rd_gray_q;
  logic [LogDepth:0] wr_gray_seen;
  logic              fetch;

`ifdef FORMAL
  logic [LogDepth:0] f_rd_before, f_rd_meta, f_wr_before, f_wr_meta;  // pointers on their way
  (* anyconst *) logic [LogDepth:0] f_mark;
  logic [Width-1:0] f_there;
`endif

  assign write = wr_valid_i;

  always_ff @(posedge wr_clk_i) begin
    if (wr_rst_i) begin
      wr_ptr_q  <= '0;
      wr_next_q <= (LogDepth + 1)'(1);
      wr_gray_q <= '0;
    end else if (write) begin
      wr_ptr_q  <= wr_next_q;
      wr_next_q <= wr_next_q + 1'b1;
      wr_gray_q <= gray_of(wr_next_q);
    end
  end

  sp_sync #(
    .Width(LogDepth + 1)
  ) u_rd_to_wr (
    .clk_i(wr_clk_i),
    .rst_i(wr_rst_i),
    .d_i  (rd_gray_q),
    .q_o  (rd_gray_seen)
`ifdef FORMAL
    ,
    .f_before_o(f_rd_before),
    .f_meta_o  (f_rd_meta)
`endif
  );

  // Gray to binary: bit i is the exclusive or of all bits from i on, for up to 16 bits; first of
  // four bits, one clock later of all.
  assign rd_part_seen = rd_gray_seen ^ (rd_gray_seen >> 1) ^ (rd_gray_seen >> 2) ^
                        (rd_gray_seen >> 3);
  assign rd_bin       = rd_part_q ^ (rd_part_q >> 4) ^ (rd_part_q >> 8) ^ (rd_part_q >> 12);

  // depth + read - written, and 1 less for the word being written, as a borrow of the difference
  logic [LogDepth:0] free;
  logic              unused_free;
  assign {free, unused_free} = {rd_bin ^ {1'b1, {LogDepth{1'b0}}}, 1'b0} - {wr_ptr_q, write};

  always_ff @(posedge wr_clk_i) begin
    if (wr_rst_i) begin
      rd_part_q <= '0;
      wr_free_o <= {1'b1, {LogDepth{1'b0}}};
    end else begin
      rd_part_q <= rd_part_seen;
      wr_free_o <= free;
    end
  end

  assign fetch = rd_gray_q != wr_gray_seen && (!rd_valid_o || rd_ready_i);

  always_ff @(posedge rd_clk_i) begin
    if (rd_rst_i) begin
      rd_ptr_q   <= '0;
      rd_gray_q  <= '0;
      rd_valid_o <= 1'b0;
    end else begin
      if (fetch) begin
        rd_ptr_q  <= rd_ptr_q + 1'b1;
        rd_gray_q <= gray_of(rd_ptr_q + 1'b1);
      end
      if (fetch) rd_valid_o <= 1'b1;
      else if (rd_ready_i) rd_valid_o <= 1'b0;
    end
  end

  sp_sync #(
    .Width(LogDepth + 1)
  ) u_wr_to_rd (
    .clk_i(rd_clk_i),
    .rst_i(rd_rst_i),
    .d_i  (wr_gray_q),
    .q_o  (wr_gray_seen)
`ifdef FORMAL
    ,
    .f_before_o(f_wr_before),
    .f_meta_o  (f_wr_meta)
`endif
  );

  // A word is read at least two read clocks after its write, and overwritten only after its place
  // was freed.
  sp_ram #(
    .Width   (Width),
    .LogDepth(LogDepth)
  ) u_ram (
    .wr_clk_i (wr_clk_i),
    .wr_en_i  (write),
    .wr_addr_i(wr_ptr_q[LogDepth-1:0]),
    .wr_data_i(wr_data_i),
    .rd_clk_i (rd_clk_i),
    .rd_en_i  (fetch),
    .rd_addr_i(rd_ptr_q[LogDepth-1:0]),
    .rd_data_o(rd_data_o)
`ifdef FORMAL
    ,
    .f_addr_i (f_mark[LogDepth-1:0]),
    .f_word_o (f_there)
`endif
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
  // Inputs change only with their clock. The writer looks first.
  always_comb if (wr_valid_i) assume (!wr_rst_i && wr_free_o != '0);
  always_ff @(posedge f_moment) if (f_run) begin
    if (!f_wr_rise) assume ($stable(wr_valid_i) && $stable(wr_data_i));
    if (!f_rd_rise) assume ($stable(rd_ready_i));
  end

  function automatic logic [LogDepth:0] f_binary(input logic [LogDepth:0] gray);
    f_binary = gray;
    for (int i = 1; i <= LogDepth; i++) f_binary = f_binary ^ (gray >> i);
  endfunction

  logic [Width-1:0] f_word_q;
  logic             f_at_output_q;
  always_ff @(posedge wr_clk_i) if (write && wr_ptr_q == f_mark) f_word_q <= wr_data_i;
  always_ff @(posedge rd_clk_i) begin
    if (rd_rst_i) f_at_output_q <= 1'b0;
    else if (fetch) f_at_output_q <= rd_ptr_q == f_mark;
  end

  logic [LogDepth:0] f_step1a, f_step1b, f_step1, f_step2, f_step3, f_step4, f_step5, f_step6,
      f_step7, f_held, f_before_mark;
  assign f_step1a = rd_bin - (wr_ptr_q + wr_free_o - (LogDepth + 1)'(1 << LogDepth));
  assign f_step1b = f_binary(rd_gray_seen) - rd_bin;
  assign f_step1 = f_binary(f_rd_meta) - f_binary(rd_gray_seen);
  assign f_step2 = f_binary(f_rd_before) - f_binary(f_rd_meta);
  assign f_step3 = rd_ptr_q - f_binary(f_rd_before);
  assign f_step4 = f_binary(wr_gray_seen) - rd_ptr_q;
  assign f_step5 = f_binary(f_wr_meta) - f_binary(wr_gray_seen);
  assign f_step6 = f_binary(f_wr_before) - f_binary(f_wr_meta);
  assign f_step7 = wr_ptr_q - f_binary(f_wr_before);
  assign f_held        = wr_ptr_q - rd_ptr_q;
  assign f_before_mark = f_mark - rd_ptr_q;

  always_comb if (f_run) begin
    // Rule 1: what one side knows of the other's pointer lies behind it. In order: read as the
    // writer sees it, read, written as the reader sees it, written. All of these lie within the
    // depth.
    assert (wr_gray_q == (wr_ptr_q ^ (wr_ptr_q >> 1)));
    assert (wr_next_q == wr_ptr_q + (LogDepth + 1)'(1));
    assert (rd_gray_q == (rd_ptr_q ^ (rd_ptr_q >> 1)));
    assert ((LogDepth + 4)'(f_step1a) + (LogDepth + 4)'(f_step1b) + (LogDepth + 4)'(f_step1) +
            (LogDepth + 4)'(f_step2) + (LogDepth + 4)'(f_step3) + (LogDepth + 4)'(f_step4) +
            (LogDepth + 4)'(f_step5) + (LogDepth + 4)'(f_step6) + (LogDepth + 4)'(f_step7) <=
            (LogDepth + 4)'(1 << LogDepth));
    assert (f_step3 <= (LogDepth + 1)'(1));
    assert (f_step7 <= (LogDepth + 1)'(1));
    // Rule 2: a place that is promised is free.
    assert ((LogDepth + 2)'(wr_free_o) + (LogDepth + 2)'(f_held) <= (LogDepth + 2)'(1 << LogDepth));
    // Rule 3: the memory holds what was written, and the output shows it in order.
    if (f_before_mark < f_held) assert (f_there == f_word_q);
    if (rd_valid_o && f_at_output_q) assert (rd_data_o == f_word_q);
    if (f_at_output_q) assert (rd_ptr_q == f_mark + (LogDepth + 1)'(1));
    // Rule 4: a word is not read while its place is written.
    if (fetch && write) assert (wr_ptr_q[LogDepth-1:0] != rd_ptr_q[LogDepth-1:0]);
  end

  // Reset leaves nothing behind: one clock edge clears the pointers of a side, two clear what has
  // come from the other side.
  always_comb if (!f_run) begin
    if (f_wr_one) assert (wr_ptr_q == '0 && wr_gray_q == '0 && f_rd_meta == '0 && rd_part_q == '0);
    if (f_wr_one) assert (wr_next_q == (LogDepth + 1)'(1));
    if (f_wr_one) assert (wr_free_o == (LogDepth + 1)'(1 << LogDepth));
    if (f_rd_one) assert (rd_ptr_q == '0 && rd_gray_q == '0 && f_wr_meta == '0 && !rd_valid_o &&
                          !f_at_output_q);
    if (f_wr_two) assert (rd_gray_seen == '0 && f_wr_before == '0);
    if (f_rd_two) assert (wr_gray_seen == '0 && f_rd_before == '0);
  end

  // Rule 5: a word that waits at the output does not change.
  always_ff @(posedge f_moment) if (f_run) begin
    if ($past(f_run && rd_valid_o && !rd_ready_i)) assert (rd_valid_o && $stable(rd_data_o));
  end
  always_ff @(posedge f_moment) if (f_run) begin
    cover (wr_free_o == '0);
    cover (f_at_output_q && rd_valid_o && f_mark == (LogDepth + 1)'(1));
  end
`endif

endmodule

`default_nettype wire
