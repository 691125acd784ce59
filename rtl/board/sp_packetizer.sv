// Builds packets: header, payload beats as they come, trailer with the check word; decides at the start of each whether its
// FIFO has room for all of it.
//
// start_i asks for a packet with payload_beats_i beats of payload, break_first_i for an empty one (a frame that broke before
// its header left). Where the FIFO cannot take all of it, or the packet before is not finished, the packet is dropped
// and counted; the count is in every later header. Each start_i and each break_first_i is thus delivered or counted.
// Once begun a packet is always completed: where the payload ends early (payload_break_i) zeros fill it up. The trailer has
// the status given with start_i, break_first_i or, while the packet is under way, break_later_i.
//
// Timing, in clocks from start_i or break_first_i (e): decision in e + 2, accept_o from e + 3 on until the next decision about
// a start_i, header beats at the FIFO in e + 4 .. e + 7. Payload beats may come from e + 7 on, any number of clocks apart, and
// reach the FIFO one clock later. The packetizer is busy until seven clocks after its last payload beat.
// start_i and break_first_i never come in one clock, and break_later_i before the next request (sp_frame_tracker sees to it).
`default_nettype none

module sp_packetizer #(
  parameter logic [7:0] Kind = sp_spec_pkg::KindMoments,
  parameter int         ColumnBits = 12,
  parameter int         RowBits = 10,
  parameter int         PayloadBits = 11,  // of the number of payload beats
  parameter int         LogDepth = 11      // of the FIFO
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  // Requests
  input  wire logic                   start_i,
  input  wire logic [PayloadBits-1:0] payload_beats_i,
  input  wire logic [RowBits-1:0]     line_i,          // with start_i, kind image: the line; else not used
  input  wire logic                   spoiled_i,       // at the decision: count the packet as lost
  input  wire logic                   break_first_i,
  input  wire logic                   break_later_i,   // the frame broke after its start_i
  input  wire logic [sp_spec_pkg::StatusBits-1:0] start_status_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0] break_status_i,  // with break_first_i and break_later_i
  output logic                        accept_o,

  // Payload
  input  wire logic                   payload_valid_i,
  input  wire logic [127:0]           payload_data_i,
  input  wire logic                   payload_break_i,  // no more will come, after payload_valid_i of the same clock

  // Header fields: see sp_frame_info for when they are read
  input  wire logic [7:0]             stream_i,
  input  wire logic [63:0]            sequence_i,
  input  wire logic [63:0]            time_stamp_i,
  input  wire logic [31:0]            encoder_i,
  input  wire logic [15:0]            pattern_i,
  input  wire logic [ColumnBits-1:0]  columns_i,
  input  wire logic [RowBits-1:0]     rows_i,
  input  wire logic [1:0]             mode_i,
  input  wire logic [7:0]             threshold_i,
  input  wire logic [RowBits-1:0]     lines_i,
  input  wire logic                   stray_before_i,

  // FIFO
  input  wire logic [LogDepth:0]      fifo_free_i,
  output logic                        fifo_valid_o,
  output logic                        fifo_last_o,
  output logic [127:0]                fifo_data_o,

  output logic [31:0]                 lost_o
);

  localparam int StatusBits = sp_spec_pkg::StatusBits;
  localparam int Overhead = (sp_spec_pkg::HeaderBytes + sp_spec_pkg::TrailerBytes) / sp_spec_pkg::PacketBeatBytes;
  localparam int CountBits = LogDepth + 1 > PayloadBits + 1 ? LogDepth + 1 : PayloadBits + 1;
  localparam bit PerLine = Kind != sp_spec_pkg::KindMoments;

  // --- Requests on their way to the decision ---
  logic                   asked, asked_any, awake, awake_q;
  logic [11:0]            asked_q;  // {start_i, break_first_i, break_later_i}, one to four clocks ago, the latest lowest
  logic                   start2, break_first2, break_later2, break_later3;
  logic [PayloadBits-1:0] payload1_q, payload2_q;
  logic [RowBits-1:0]     line1_q, line2_q;
  logic [CountBits-1:0]   need1_q;
  logic                   room2_q;
  logic [StatusBits-1:0]  status1_q, status2_q, status3_q;
  logic                   idle_q;

  assign asked        = start_i || break_first_i || break_later_i;
  assign asked_any    = asked_q != '0;
  assign start2       = asked_q[5];
  assign break_first2 = asked_q[4];
  assign break_later2 = asked_q[3];
  assign break_later3 = asked_q[6];
  // Without a request in the last five clocks, and with no packet under way, nothing below moves.
  assign awake        = asked || awake_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      asked_q <= '0;
      awake_q <= 1'b0;
    end else if (awake) begin
      asked_q <= {asked_q[8:0], start_i, break_first_i, break_later_i};
      awake_q <= asked || asked_any || !idle_q;
    end
  end

  always_ff @(posedge clk_i) begin
    if (asked) begin
      payload1_q <= start_i ? payload_beats_i : PayloadBits'(0);
      need1_q    <= (start_i ? CountBits'(payload_beats_i) : CountBits'(0)) + CountBits'(Overhead);
      line1_q    <= line_i;
      status1_q  <= break_first_i || break_later_i ? break_status_i : start_status_i;
    end
    if (asked_q[2:0] != '0) begin
      payload2_q <= payload1_q;
      room2_q    <= CountBits'(fifo_free_i) >= need1_q;
      line2_q    <= line1_q;
      status2_q  <= status1_q;
    end
    if (break_later2) status3_q <= status2_q;
  end

  // --- State: one of idle_q and these is set ---
  logic [3:0]             header_q;        // beat 0 .. 3 of the header
  logic                   in_payload_q;
  logic                   in_fill_q;       // zeros to the payload's end
  logic [2:0]             trailer_q;       // the check word is complete in the third clock
  logic [2:0]             settle_q;        // until fifo_free_i counts this packet
  logic [PayloadBits-1:0] left_q;          // payload beats to come
  logic                   one_left_q;
  logic                   empty_q;         // no payload
  logic [PayloadBits-1:0] payload_q;       // payload beats of this packet
  logic [RowBits-1:0]     line_q;
  logic [63:0]            sequence_q;
  logic [StatusBits-1:0]  status_q;
  logic [31:0]            check_q;
  logic                   take, take_empty, put_payload, all_put;
  logic [1:0]             lost_now_q;      // late enough for the header of a packet decided on the clock before

  assign take        = start2 && idle_q && room2_q && !spoiled_i;
  assign take_empty  = break_first2 && idle_q && room2_q;
  assign put_payload = in_payload_q && payload_valid_i || in_fill_q;
  assign all_put     = put_payload && one_left_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      idle_q       <= 1'b1;
      header_q     <= '0;
      in_payload_q <= 1'b0;
      in_fill_q    <= 1'b0;
      trailer_q    <= '0;
      settle_q     <= '0;
      accept_o     <= 1'b0;
      lost_now_q   <= '0;
    end else if (awake) begin
      if (start2) accept_o <= take;
      lost_now_q <= {lost_now_q[0], start2 && !take || break_first2 && !take_empty};

      idle_q    <= idle_q && !take && !take_empty || settle_q[2];
      header_q  <= {header_q[2:0], take || take_empty};
      trailer_q <= {trailer_q[1:0], header_q[3] && empty_q || all_put};
      settle_q  <= {settle_q[1:0], trailer_q[2]};

      in_payload_q <= header_q[3] && !empty_q || in_payload_q && !payload_break_i && !all_put;
      in_fill_q    <= (in_fill_q || in_payload_q && payload_break_i) && !all_put;
    end
  end

  // What stands here in the last clock of idle_q is that of the packet.
  always_ff @(posedge clk_i) begin
    if (awake_q && idle_q) begin
      empty_q   <= break_first2;
      payload_q <= payload2_q;
      line_q    <= line2_q;
    end
    if (awake_q) begin
      if (idle_q) status_q <= status2_q;
      else if (break_later3 && accept_o) status_q <= status3_q;
    end
    if (header_q[0]) begin
      sequence_q <= sequence_i;
      left_q     <= payload_q;
      one_left_q <= payload_q == PayloadBits'(1);
    end else if (put_payload) begin
      left_q     <= left_q - PayloadBits'(1);
      one_left_q <= left_q == PayloadBits'(2);
    end
  end

  sp_counter u_lost (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .inc_i  (lost_now_q[1]),
    .count_o(lost_o)
  );

  // --- The beat for the FIFO. Its four words have few sources each: what the header and the trailer have in common stands
  // at the same place. ---
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      fifo_valid_o <= 1'b0;
      fifo_last_o  <= 1'b0;
    end else if (!idle_q) begin
      fifo_valid_o <= header_q != '0 || put_payload || trailer_q[2];
      fifo_last_o  <= trailer_q[2];
    end
  end

  function automatic logic [127:0] beat_if(input logic now, input logic [127:0] beat);
    beat_if = now ? beat : 128'd0;
  endfunction

  always_ff @(posedge clk_i) begin
    if (in_payload_q) begin
      fifo_data_o <= payload_data_i;
    end else if (!idle_q) begin
      fifo_data_o <= beat_if(header_q[0], {threshold_i, 6'd0, mode_i, pattern_i, stream_i, Kind, sp_spec_pkg::SpecVersion,
                                           sp_spec_pkg::SpecHash, sp_spec_pkg::Magic}) |
                     beat_if(header_q[1], {time_stamp_i, 64'd0}) |
                     beat_if(header_q[2], {32'(payload_q) << $clog2(sp_spec_pkg::PacketBeatBytes), 16'(rows_i),
                                           16'(columns_i), lost_o, encoder_i}) |
                     beat_if(header_q[3], {64'd0, 31'd0, stray_before_i, PerLine ? 16'd1 : 16'(lines_i),
                                           PerLine ? 16'(line_q) : 16'd1}) |
                     beat_if(header_q[1] || trailer_q != '0, {64'd0, sequence_q}) |
                     beat_if(trailer_q != '0, {32'd0, 32'(status_q), 64'd0}) |
                     beat_if(trailer_q[2], {check_q, 96'd0});
    end
  end

  // --- Check word, one clock behind the beats. The trailer counts with its check field 0, before it is written. ---
  logic [31:0] folded;
  logic [31:0] w0, w1, w2, w3;

  assign {w3, w2, w1, w0} = fifo_data_o;
  assign folded = w0 ^ {w1[23:0], w1[31:24]} ^ {w2[15:0], w2[31:16]} ^ {w3[7:0], w3[31:8]};

  always_ff @(posedge clk_i) begin
    if (header_q[0]) begin
      check_q <= sp_spec_pkg::CheckInit;
    end else if (fifo_valid_o || trailer_q[1]) begin
      check_q <= {check_q[30:0], 1'b0} ^ (check_q[31] ? sp_spec_pkg::CheckPolynomial : 32'd0) ^ folded;
    end
  end

  if (PerLine) begin : gen_line
    logic unused;
    assign unused = ^lines_i;
  end else begin : gen_frame
    logic unused;
    assign unused = ^line_q;
  end

`ifdef FORMAL
  // Reset once, at the beginning. Requests as sp_frame_tracker gives them; a payload has a beat at least.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb begin
    assume (rst_i == !f_ran_q);
    assume (!(start_i && break_first_i));
    if (start_i) assume (payload_beats_i != '0);
  end
  // The FIFO: it never promises a place that is not there; places come free at any time.
  (* anyseq *) logic [LogDepth:0] f_freed;
  logic [LogDepth:0] f_free_q;
  always_comb begin
    assume (fifo_free_i <= f_free_q);
    assume ((LogDepth + 3)'(f_freed) + (LogDepth + 3)'(f_free_q) <= (LogDepth + 3)'(1 << LogDepth));
  end
  always_ff @(posedge clk_i) begin
    if (rst_i) f_free_q <= (LogDepth + 1)'(1 << LogDepth);
    else f_free_q <= f_free_q + f_freed - (LogDepth + 1)'(fifo_valid_o);
  end

  // Rule 1: delivered + lost = requested, always (but for those on their way to the decision or to the counter).
  logic [3:0] f_asked_q, f_taken_q;  // modulo 16
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_asked_q, f_taken_q} <= '0;
    else begin
      f_asked_q <= f_asked_q + 4'(start_i || break_first_i);
      f_taken_q <= f_taken_q + 4'(take || take_empty);
    end
  end

  // Rule 2: whole packets only: header, payload as announced, trailer; fifo_last_o with the last beat and no other.
  // Rule 3: no beat without a place in the FIFO.
  localparam int FLeftBits = PayloadBits + 1 > 4 ? PayloadBits + 1 : 4;
  logic [FLeftBits-1:0] f_left_q, f_after;  // beats of the packet that have not left; less that at the FIFO
  always_ff @(posedge clk_i) begin
    if (rst_i) f_left_q <= '0;
    else if (take || take_empty) f_left_q <= FLeftBits'(take ? payload2_q : PayloadBits'(0)) + FLeftBits'(Overhead);
    else if (fifo_valid_o) f_left_q <= f_left_q - FLeftBits'(1);
  end
  assign f_after = f_left_q - FLeftBits'(fifo_valid_o);
  always_comb if (f_ran_q && !rst_i) begin
    assert (f_asked_q == f_taken_q + lost_o[3:0] + 4'(asked_q[2]) + 4'(start2) + 4'(asked_q[1]) +
            4'(break_first2) + 4'(lost_now_q[0]) + 4'(lost_now_q[1]));
    assert (!(asked_q[2] && asked_q[1]) && !(start2 && break_first2));
    if (asked_q[1]) assert (payload1_q == '0);
    if (break_first2) assert (payload2_q == '0);
    if (asked_q[2]) assert (payload1_q != '0);
    if (start2) assert (payload2_q != '0);
    if (fifo_valid_o) assert (f_left_q != '0 && f_free_q != '0);
    if (fifo_valid_o) assert (fifo_last_o == (f_left_q == FLeftBits'(1)));
    assert (CountBits'(f_free_q) >= CountBits'(f_left_q));
    if (asked_q[2] || asked_q[1]) assert (need1_q == CountBits'(payload1_q) + CountBits'(Overhead));
    if ((start2 || break_first2) && room2_q && idle_q) begin
      assert (CountBits'(f_free_q) >= CountBits'(payload2_q) + CountBits'(Overhead));
    end
    // A loss on its way to the counter keeps the block awake.
    if (lost_now_q[0]) assert (asked_q[8] || asked_q[7]);
    if (lost_now_q[1]) assert (asked_q[11] || asked_q[10]);
    // Asleep nothing is asked or under way.
    if (!awake_q) assert (asked_q == '0 && idle_q && lost_now_q == '0 && !fifo_valid_o);
    assert ($countones({idle_q, header_q, in_payload_q, in_fill_q, trailer_q, settle_q}) == 1);
    if (idle_q) assert (f_left_q == '0 && !fifo_valid_o);
    if (header_q != '0) begin
      assert (f_after == FLeftBits'(payload_q) + FLeftBits'(Overhead) - FLeftBits'(header_q[1]) - FLeftBits'({header_q[2], 1'b0}) -
              FLeftBits'({header_q[3], header_q[3]}));
      assert (empty_q == (payload_q == '0));
      if (!header_q[0]) assert (left_q == payload_q && one_left_q == (left_q == PayloadBits'(1)));
    end
    if (in_payload_q || in_fill_q) begin
      assert (f_after == FLeftBits'(left_q) + FLeftBits'(1));
      assert (left_q != '0 && one_left_q == (left_q == PayloadBits'(1)));
    end
    if (trailer_q != '0) assert (f_after == FLeftBits'(1));
    if (settle_q != '0) begin
      assert (f_after == '0);
      if (!settle_q[0]) assert (!fifo_valid_o);
    end
    cover (fifo_valid_o && fifo_last_o && f_taken_q == 4'd2 && lost_o == 32'd1);
    cover (in_fill_q && f_left_q == FLeftBits'(3));
  end
`endif

endmodule

`default_nettype wire
