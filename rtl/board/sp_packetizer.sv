// Builds packets: header, payload beats as they come, trailer with the check word. Before each
// packet it decides whether its FIFO has room for all of it. The specification places the fields
// (sp_spec_pkg).
//
// start_i asks for a packet with payload_beats_i beats of payload. A break without break_later_i
// asks for an empty packet, for a frame that broke before its header left. Overflow: if the FIFO
// cannot take the whole packet, or the packet before is not finished, the packet is dropped and
// counted; all later headers carry the count, which wraps. So each request is delivered or counted.
// A packet that has begun is always completed: zeros fill a payload that ends early
// (payload_break_i). With Tail a payload may end with a beat of its own, tail_i, which comes behind
// the others. The trailer has the status given with the request, or with a break and
// break_later_i while the packet is under way.
//
// Latency: the decision follows two clocks after the request, the beats of the header four to seven
// clocks after it, a payload beat one clock after it came, the trailer four clocks after the last
// payload beat came. A packet of two payload beats, with a gap before the second:
//
//   clock             0   1   2   3   4   5   6   7   8   9  10  11  12  13  14  15  16
//   start_i          _/1\_______________________________________________________________
//   fifo_free_i      -----< F >---------------------------------------------------------  (a)
//   decision         _________/1\_______________________________________________________  (b)
//   accept_o         -------------/1111111111111111111111111111111111111111111111111111111  (c)
//   info_i, beat     -------------<0 ><1 ><2 ><3 >---------------------------------------  (d)
//   payload_valid_i  _____________________________/1\_____/2\___________________________  (e)
//   fifo_valid_o     _________________/H0\/H1\/H2\/H3\/1 \____/2 \________/T \____________
//   state            -------------<H0><H1><H2><H3><Payload   ><Trailer   ><Settle    >---
//   busy             _____________/111111111111111111111111111111111111111111111111111\___
//
//   (a) counts in this clock   (b) take; spoiled_i counts in this clock
//   (c) until the next decision about a start   (d) the sequence one clock before its beat
//   (e) from clock 7 on
//
// The packetizer is busy until seven clocks after its last payload beat. The two requests never
// come in one clock, and a later break comes before the next request; sp_frame_tracker sees to
// both.
`default_nettype none

module sp_packetizer #(
  parameter logic [7:0] Kind = sp_spec_pkg::KindMoments,
  parameter bit         KindOfFrame = 1'b0,  // the kind is that of info_i, one packet per frame
  parameter int         ColumnBits = 12,  // 1..16
  parameter int         RowBits = 10,  // 1..16
  parameter bit         Region = 1'b1,  // headers say where on the sensor frames begin
  parameter bit         Wide = 1'b0,  // headers have the byte pixel
  parameter bit         Tail = 1'b0,  // there is tail_i, and the flag for it in info_i
  parameter int         PayloadBits = 11,  // of the number of payload beats: 1..28
  parameter int         LogDepth = 11      // log2 of the depth of the FIFO: 3 or more
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  // Requests
  input  wire logic                   start_i,
  input  wire logic [PayloadBits-1:0] payload_beats_i,
  input  wire logic [RowBits-1:0]     line_i,  // kinds codes and image: the line, with start_i
  input  wire logic                   spoiled_i,       // at the decision: count the packet as lost
  input  wire logic                   break_i,         // the frame broke
  input  wire logic                   break_later_i,   // with its start_i or after it
  input  wire logic [sp_spec_pkg::StatusBits-1:0] start_status_i,  // with start_i
  input  wire logic [sp_spec_pkg::StatusBits-1:0] break_status_i,  // with break_i
  output logic                        accept_o,

  // Payload
  input  wire logic                   payload_valid_i,
  input  wire logic [127:0]           payload_data_i,
  // after payload_valid_i of this clock, no more comes
  input  wire logic                   payload_break_i,
  input  wire logic                   tail_valid_i,    // never with payload_valid_i
  input  wire logic [127:0]           tail_i,

  // The frame's fields of the header; sp_frame_info says when each beat of them is read
  input  wire logic [sp_spec_pkg::HeaderBits-1:0] info_i,

  // FIFO
  input  wire logic [LogDepth:0]      fifo_free_i,
  output logic                        fifo_valid_o,
  output logic                        fifo_last_o,
  output logic [127:0]                fifo_data_o,

  output logic [31:0]                 lost_o
);

  if (ColumnBits < 1 || ColumnBits > sp_spec_pkg::HeaderColumnsBits) begin : gen_column_bits
    column_bits_is_not_in_1_to_16 u_error ();
  end
  if (RowBits < 1 || RowBits > sp_spec_pkg::HeaderRowsBits) begin : gen_row_bits
    row_bits_is_not_in_1_to_16 u_error ();
  end
  if (PayloadBits < 1 || PayloadBits > 28) begin : gen_payload_bits
    payload_bits_is_not_in_1_to_28 u_error ();
  end
  if (LogDepth < 3) begin : gen_log_depth
    log_depth_is_less_than_3 u_error ();
  end

  localparam int StatusBits = sp_spec_pkg::StatusBits;
  localparam int Overhead =
      (sp_spec_pkg::HeaderBytes + sp_spec_pkg::TrailerBytes) / sp_spec_pkg::PacketBeatBytes;
  localparam int CountBits = LogDepth + 1 > PayloadBits + 1 ? LogDepth + 1 : PayloadBits + 1;
  localparam bit PerLine = Kind != sp_spec_pkg::KindMoments;

  // --- Places of the fields: the beat of the header, and the lowest bit in it ---
  localparam int HeaderBits = sp_spec_pkg::HeaderBits;
  localparam int BeatBits = sp_spec_pkg::PacketBeatBits;
  localparam int SequenceBeat = sp_spec_pkg::HeaderSequenceLsb / BeatBits;
  localparam int SequenceAt = sp_spec_pkg::HeaderSequenceLsb % BeatBits;
  localparam int LostBeat = sp_spec_pkg::HeaderLostLsb / BeatBits;
  localparam int LostAt = sp_spec_pkg::HeaderLostLsb % BeatBits;
  localparam int SizeBeat = sp_spec_pkg::HeaderPayloadSizeLsb / BeatBits;
  localparam int SizeAt = sp_spec_pkg::HeaderPayloadSizeLsb % BeatBits;
  localparam int LineBeat = sp_spec_pkg::HeaderFirstLineLsb / BeatBits;
  localparam int LineAt = sp_spec_pkg::HeaderFirstLineLsb % BeatBits;

  localparam logic [7:0] KindBits = KindOfFrame ? 8'hFF : 8'h00;  // of info_i
  localparam logic [7:0] OwnKind = Kind & ~KindBits;

  // The bits taken from info_i. A packet of a line has its own number of lines, and the sequence is
  // kept for the trailer.
  localparam logic [HeaderBits-1:0] FrameBits =
    HeaderBits'(KindBits) << sp_spec_pkg::HeaderKindLsb |
    sp_spec_pkg::frame_mask(ColumnBits, RowBits, Region ? 16 : 0, Wide ? 8 : 0) &
    ~(HeaderBits'(!Tail) << (sp_spec_pkg::HeaderFlagsLsb + sp_spec_pkg::FlagVerdictBit)) &
    ~(~({HeaderBits{1'b1}} << 64) << sp_spec_pkg::HeaderSequenceLsb) &
    ~(~({HeaderBits{1'b1}} << (PerLine ? 16 : 0)) << sp_spec_pkg::HeaderLinesLsb);
  // What all packets have in common
  localparam logic [HeaderBits-1:0] Common =
    HeaderBits'(sp_spec_pkg::Magic) << sp_spec_pkg::HeaderMagicLsb |
    HeaderBits'(sp_spec_pkg::SpecHash) << sp_spec_pkg::HeaderSpecHashLsb |
    HeaderBits'(sp_spec_pkg::SpecVersion) << sp_spec_pkg::HeaderVersionLsb |
    HeaderBits'(OwnKind) << sp_spec_pkg::HeaderKindLsb |
    HeaderBits'(1) << (PerLine ? sp_spec_pkg::HeaderLinesLsb : sp_spec_pkg::HeaderFirstLineLsb);

  // What this module is made for
  if (sp_spec_pkg::HeaderBytes != 64 || sp_spec_pkg::TrailerBytes != 16) begin : gen_sizes
    the_header_has_not_4_beats_or_the_trailer_not_1 u_error ();
  end
  if (SequenceBeat < 1) begin : gen_sequence
    the_sequence_is_not_known_for_the_first_beat u_error ();
  end
  if (LostBeat < 1 || LostBeat > 2) begin : gen_lost
    the_count_of_lost_packets_is_right_in_beats_1_and_2_only u_error ();
  end

  // --- Requests on their way to the decision, and the state of the block ---
  localparam int StateBits = 12;

  typedef struct packed {
    logic                 asked4;    // a request four clocks ago
    logic                 asked3;    // three clocks ago
    logic                 later3;    // and it is a later break
    logic [5:0]           asked;     // {start, break first, break later}, one and two clocks ago
    logic                 awake;     // a request in the last five clocks, or a packet
    logic                 lost_now;  // a loss, late enough for the header before it
    logic                 valid;     // a beat is at the FIFO
    logic                 last;      // it is the last of the packet
    logic                 numbered;  // the beat being made has the sequence
    logic                 busy;      // a packet is under way
    logic [StateBits-1:0] state;     // then one bit of these is set, see below
  } control_t;

  // Bits of asked, two clocks ago
  localparam int Start2 = 5, BreakFirst2 = 4, BreakLater2 = 3;

  control_t               q;
  logic                   asked, awake;
  // payload beats asked for, one and two clocks ago
  logic [PayloadBits-1:0] payload1_q, payload2_q;
  logic                   one2_q;                  // payload2_q is 1
  logic [RowBits-1:0]     line1_q, line2_q;        // line_i, likewise
  logic [CountBits-1:0]   need1_q;                 // places of the FIFO that the packet needs
  logic                   room, room2_q;           // the FIFO has them
  logic [CountBits-1:0]   unused_room;
  logic [StatusBits-1:0]  status1_q, status2_q;    // status, likewise
  logic [StatusBits-1:0]  status3_q;               // of a later break, for the packet under way

  assign asked = start_i || break_i;
  // Nothing below moves while the block sleeps.
  assign awake = asked || q.awake;
  // Free places minus those needed. The carry is taken as a bit of the sum, so that it stays at the
  // end of its chain. Not used in reset.
  assign {room, unused_room} = {rst_i, CountBits'(fifo_free_i)} + {1'b0, ~need1_q} +
                               (CountBits + 1)'(1);

  always_ff @(posedge clk_i) begin
    if (asked) begin
      if (start_i) begin
        payload1_q <= payload_beats_i;
        need1_q    <= CountBits'(payload_beats_i) + CountBits'(Overhead);
      end else begin
        payload1_q <= '0;
        need1_q    <= CountBits'(Overhead);
      end
      line1_q   <= line_i;
      status1_q <= break_i ? break_status_i : start_status_i;
    end
    if (q.asked[2:0] != '0) begin
      payload2_q <= payload1_q;
      one2_q     <= payload1_q == PayloadBits'(1);
      room2_q    <= room;
      line2_q    <= line1_q;
      status2_q  <= status1_q;
    end
    if (q.asked[BreakLater2]) status3_q <= status2_q;
  end

  // --- State bits, the lowest first ---
  localparam int Header = 0;     // 4 bits: beats 0 to 3 of the header
  localparam int Payload = 4;
  localparam int Fill = 5;       // zeros to the end of the payload
  localparam int Trailer = 6;    // 3 bits: the check word is complete in the third
  localparam int Settle = 9;     // 3 bits: until fifo_free_i counts this packet

  logic [PayloadBits-1:0] left_q;          // payload beats to come; in the header, all of them
  logic                   one_left_q;      // left_q is 1
  logic                   empty_q;         // the packet has no payload
  logic [RowBits-1:0]     line_q;          // kinds codes and image: the line
  logic [63:0]            sequence_q;      // kept from the header for the trailer
  logic [StatusBits-1:0]  status_q;        // for the trailer
  logic [31:0]            check_q;         // of the beats before the one at the FIFO
  // What check_q does. Nothing else reads these two, so they can stand beside its 32 bits, which no
  // bit of the state has to reach in a clock.
  logic                   clear_q;         // the packet has ended
  logic                   fold_q;          // the beat at the FIFO goes into the check word
  logic                   take, take_empty;  // a packet with, without payload begins
  logic                   put_payload;       // the beat being made is payload
  logic                   tail;              // and the last of it
  logic                   all_put;           // and the last of it

  logic unused_tail;
  assign unused_tail = !Tail && (tail_valid_i ^ ^tail_i);
  assign take        = q.asked[Start2] && room2_q && !spoiled_i && !q.busy;
  assign take_empty  = q.asked[BreakFirst2] && room2_q && !q.busy;
  assign tail        = Tail && tail_valid_i;
  assign put_payload = q.state[Payload] && (payload_valid_i || tail) || q.state[Fill];
  assign all_put     = put_payload && one_left_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      q      <= '0;
      fold_q <= 1'b0;
    end else if (awake) begin
      q.asked4   <= q.asked3;
      q.asked3   <= q.asked[5:3] != '0;
      q.later3   <= q.asked[BreakLater2];
      q.asked    <= {q.asked[2:0], start_i, break_i && !break_later_i, break_i && break_later_i};
      q.valid    <= q.state[Header+:4] != '0 || put_payload || q.state[Trailer+2];
      q.last     <= q.state[Trailer+2];
      fold_q     <= q.state[Header+:4] != '0 || put_payload || q.state[Trailer];
      q.awake    <= asked || q.asked != '0 || q.asked3 || q.asked4 || q.busy;
      q.lost_now <= q.asked[Start2] && !take || q.asked[BreakFirst2] && !take_empty;

      q.busy     <= take || take_empty || q.busy && !q.state[Settle+2];
      q.state    <= {q.state[Settle+:2], q.state[Trailer+2],
                     q.state[Trailer+:2], q.state[Header+3] && empty_q || all_put,
                     (q.state[Fill] || q.state[Payload] && payload_break_i) && !all_put,
                     q.state[Header+3] && !empty_q ||
                         q.state[Payload] && !payload_break_i && !all_put,
                     q.state[Header+:3], take || take_empty};
      q.numbered <= q.state[Header+SequenceBeat-1] || q.state[Header+3] && empty_q || all_put ||
                    q.state[Trailer+:2] != '0;
    end
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) clear_q <= 1'b1;
    else clear_q <= q.state[Settle];
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) accept_o <= 1'b0;
    else if (q.asked[Start2]) accept_o <= take;
  end

  // The values in the last clock before busy are those of the packet.
  always_ff @(posedge clk_i) begin
    if (q.awake) begin
      if (!q.busy) begin
        empty_q    <= q.asked[BreakFirst2];
        left_q     <= payload2_q;
        one_left_q <= one2_q;
        line_q     <= line2_q;
        status_q   <= status2_q;
      end else begin
        if (put_payload) begin
          left_q     <= left_q - PayloadBits'(1);
          one_left_q <= left_q == PayloadBits'(2);
        end
        if (q.later3 && accept_o) status_q <= status3_q;
      end
    end
  end

  sp_counter u_lost (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .inc_i  (q.lost_now),
    .count_o(lost_o)
  );

  // --- The beat for the FIFO. Header and trailer have their common fields at the same place, so
  // each of the four words has few sources. ---
  assign fifo_valid_o = q.valid;
  assign fifo_last_o  = q.last;

  function automatic logic [127:0] beat_if(input logic now, input logic [127:0] beat);
    beat_if = {128{now}} & beat;
  endfunction

  // Check word, one clock behind the beats. The trailer counts before its check field is written,
  // which is then 0.
  function automatic logic [31:0] folded(input logic [31:0] w0, input logic [31:0] w1,
                                         input logic [31:0] w2,
                                         input logic [31:0] w3);
    folded = w0 ^ {w1[23:0], w1[31:24]} ^ {w2[15:0], w2[31:16]} ^ {w3[7:0], w3[31:8]};
  endfunction

  always_ff @(posedge clk_i) begin
    if (clear_q) begin
      check_q <= sp_spec_pkg::CheckInit;
    end else if (fold_q) begin
      check_q <= {check_q[30:0], 1'b0} ^ (check_q[31] ? sp_spec_pkg::CheckPolynomial : 32'd0) ^
                 folded(fifo_data_o[31:0], fifo_data_o[63:32],
                        fifo_data_o[95:64], fifo_data_o[127:96]);
    end
  end

  // A beat of the header without its sequence
  function automatic logic [127:0] header_beat(
    input int beat, input logic [127:0] info, input logic [127:0] frame_bits,
        input logic [127:0] common
  );
    header_beat = info & frame_bits | common | beat_if(beat == LostBeat, 128'(lost_o) << LostAt) |
                  beat_if(beat == SizeBeat,
                          128'(left_q) << (SizeAt + $clog2(sp_spec_pkg::PacketBeatBytes))) |
                  beat_if(beat == LineBeat && PerLine, 128'(line_q) << LineAt);
  endfunction

  logic [127:0] sequence_word;  // the sequence, where the beat being made has it
  if (SequenceAt == sp_spec_pkg::TrailerSequenceLsb) begin : gen_same_place
    assign sequence_word = 128'(sequence_q) << SequenceAt;
  end else begin : gen_two_places
    assign sequence_word = q.state[Header+SequenceBeat] ?
        128'(sequence_q) << SequenceAt :
        128'(sequence_q) << sp_spec_pkg::TrailerSequenceLsb;
  end

  always_ff @(posedge clk_i) begin
    if (q.busy) begin
      if (q.state[Header+SequenceBeat-1]) begin
        sequence_q <= info_i[sp_spec_pkg::HeaderSequenceLsb+:64];
      end
      fifo_data_o <=
        beat_if(q.state[Header],
                header_beat(0, info_i[0+:128], FrameBits[0+:128], Common[0+:128])) |
        beat_if(q.state[Header+1],
                header_beat(1, info_i[128+:128], FrameBits[128+:128], Common[128+:128])) |
        beat_if(q.state[Header+2],
                header_beat(2, info_i[256+:128], FrameBits[256+:128], Common[256+:128])) |
        beat_if(q.state[Header+3],
                header_beat(3, info_i[384+:128], FrameBits[384+:128], Common[384+:128])) |
        beat_if(q.numbered, sequence_word) |
        beat_if(q.state[Payload] && !tail, payload_data_i) |
        beat_if(q.state[Payload] && tail, tail_i) |
        beat_if(q.state[Trailer+:3] != '0, 128'(status_q) << sp_spec_pkg::TrailerStatusLsb) |
        beat_if(q.state[Trailer+2], 128'(check_q) << sp_spec_pkg::TrailerCheckLsb);
    end
  end

`ifdef FORMAL
  // One reset at the beginning. Requests come as sp_frame_tracker gives them; a payload has at
  // least one beat.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb begin
    assume (rst_i == !f_ran_q);
    assume (!(start_i && break_i && !break_later_i));
    if (start_i) assume (payload_beats_i != '0);
  end
  // The FIFO never promises a place that is not there. Places become free at any time.
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

  // Rule 1: delivered + lost = requested, always, except for requests on their way to the decision
  // or to the counter.
  logic [3:0] f_asked_q, f_taken_q;  // modulo 16
  logic       f_counting_q;          // a loss that the counter does not show yet
  logic       f_fresh_q = 1'b0;      // the clock behind the reset
  always_ff @(posedge clk_i) f_fresh_q <= rst_i;
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_asked_q, f_taken_q, f_counting_q} <= '0;
    else begin
      f_counting_q <= q.lost_now;
      f_asked_q    <= f_asked_q + 4'(start_i || break_i && !break_later_i);
      f_taken_q    <= f_taken_q + 4'(take || take_empty);
    end
  end

  // Rule 2: only whole packets: header, payload as announced, trailer; fifo_last_o with the last
  // beat and no other.
  // Rule 3: no beat without a place in the FIFO.
  localparam int FLeftBits = PayloadBits + 1 > 4 ? PayloadBits + 1 : 4;
  logic [FLeftBits-1:0] f_left_q, f_after;  // beats still to leave; without the one at the FIFO
  always_ff @(posedge clk_i) begin
    if (rst_i) f_left_q <= '0;
    else if (take || take_empty) f_left_q <= FLeftBits'(take ? payload2_q : PayloadBits'(0)) +
                                             FLeftBits'(Overhead);
    else if (fifo_valid_o) f_left_q <= f_left_q - FLeftBits'(1);
  end
  assign f_after = f_left_q - FLeftBits'(fifo_valid_o);

  // Rule 4: the trailer has the status that came with the request, or that of a later break if the
  // latest request before it was accepted.
  logic [StatusBits-1:0] f_status1_q, f_status2_q, f_status3_q;  // as they came in
  logic [StatusBits-1:0] f_status_q, f_sent_q;  // of the packet; one clock ago
  logic                  f_accepted_q;
  always_ff @(posedge clk_i) begin
    f_status1_q <= break_i ? break_status_i : start_status_i;
    {f_status2_q, f_status3_q} <= {f_status1_q, f_status2_q};
    f_sent_q <= f_status_q;
    if (rst_i) f_accepted_q <= 1'b0;
    else if (q.asked[Start2]) f_accepted_q <= take;
    if (take || take_empty) f_status_q <= f_status2_q;
    else if (q.later3 && f_accepted_q) f_status_q <= f_status3_q;
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (accept_o == f_accepted_q);
    if (q.asked[2:0] != '0) assert (status1_q == f_status1_q);
    if (q.asked[Start2:BreakLater2] != '0) assert (status2_q == f_status2_q);
    if (q.later3) assert (status3_q == f_status3_q);
    if (q.busy) assert (status_q == f_status_q);
    if (fifo_valid_o && fifo_last_o) begin
      assert (fifo_data_o[sp_spec_pkg::TrailerStatusLsb+:StatusBits] == f_sent_q);
    end
  end

  always_comb if (f_ran_q && !rst_i) begin
    assert (f_asked_q == f_taken_q + lost_o[3:0] + 4'(q.asked[2]) + 4'(q.asked[Start2]) +
            4'(q.asked[1]) +
            4'(q.asked[BreakFirst2]) + 4'(q.lost_now) + 4'(f_counting_q));
    assert (!(q.asked[2] && q.asked[1]) && !(q.asked[Start2] && q.asked[BreakFirst2]));
    if (q.asked[1]) assert (payload1_q == '0);
    if (q.asked[BreakFirst2]) assert (payload2_q == '0);
    if (q.asked[2]) assert (payload1_q != '0);
    if (q.asked[Start2]) assert (payload2_q != '0);
    if (fifo_valid_o) assert (f_left_q != '0 && f_free_q != '0);
    if (fifo_valid_o) assert (fifo_last_o == (f_left_q == FLeftBits'(1)));
    assert (CountBits'(f_free_q) >= CountBits'(f_left_q));
    if (q.asked[2] || q.asked[1]) assert (need1_q == CountBits'(payload1_q) + CountBits'(Overhead));
    if ((q.asked[Start2] || q.asked[BreakFirst2]) && room2_q && !q.busy) begin
      assert (CountBits'(f_free_q) >= CountBits'(payload2_q) + CountBits'(Overhead));
    end
    if (q.asked[Start2:BreakFirst2] != '0) assert (one2_q == (payload2_q == PayloadBits'(1)));
    // A loss on its way to the counter keeps the block awake.
    if (q.lost_now || q.later3) assert (q.asked3);
    if (f_counting_q) assert (q.asked4);
    // While the block sleeps nothing is asked or under way.
    if (!q.awake) begin
      assert (q.asked == '0 && !q.asked3 && !q.asked4 && !q.busy && !fifo_valid_o);
    end
    assert ($countones(q.state) == 32'(q.busy));
    // A packet's check word begins with its initial value.
    assert (clear_q == (q.state[Settle+1] || f_fresh_q));
    if (!q.busy || q.state[Settle+2] || q.state[Header]) begin
      assert (check_q == sp_spec_pkg::CheckInit || f_fresh_q);
    end
    assert (fold_q == (fifo_valid_o && !fifo_last_o || q.state[Trailer+1]));
    assert (q.numbered == (q.state[Header+SequenceBeat] || q.state[Trailer+:3] != '0));
    if (!q.busy) assert (f_left_q == '0 && !fifo_valid_o);
    if (q.state[Header+:4] != '0) begin
      assert (f_after == FLeftBits'(left_q) + FLeftBits'(Overhead) - FLeftBits'(q.state[Header+1]) -
              FLeftBits'({q.state[Header+2], 1'b0}) -
              FLeftBits'({q.state[Header+3], q.state[Header+3]}));
      assert (empty_q == (left_q == '0));
      if (!empty_q) assert (one_left_q == (left_q == PayloadBits'(1)));
    end
    if (q.state[Payload] || q.state[Fill]) begin
      assert (f_after == FLeftBits'(left_q) + FLeftBits'(1));
      assert (left_q != '0 && one_left_q == (left_q == PayloadBits'(1)));
    end
    if (q.state[Trailer+:3] != '0) assert (f_after == FLeftBits'(1));
    if (q.state[Settle+:3] != '0) begin
      assert (f_after == '0);
      if (!q.state[Settle]) assert (!fifo_valid_o);
    end
    cover (fifo_valid_o && fifo_last_o && f_taken_q == 4'd2 && lost_o == 32'd1);
    cover (q.state[Fill] && f_left_q == FLeftBits'(3));
  end
`endif

endmodule

`default_nettype wire
