// Cuts packets into datagrams, the payloads of UDP: each is a header and a piece of one packet.
// model/datagram.h is its model.
//
//   packets, 128 bits ─┬▶ ring of beats ─▶ datagrams, 32 bits
//   header of a piece ─┘
//
// Guarantees: every beat of a packet leaves once, in order, in a datagram whose header says where
// the beat belongs. A datagram starts to leave only when all of it has come. From its first word to
// its last, m_valid_o stays high. All pieces of a packet but the last are as long as DatagramBytes
// allows. Nothing is lost here: when the ring is full, packets wait. The packet FIFO in front of
// this module counts the packets for which it has no room.
//
// A session begins when enable_i is high. It takes the number session_i, and counts its datagrams
// and packets from 0. When enable_i is low, the session ends after the packet that has begun.
// Further packets wait; what is in the ring still leaves. session_i must differ from session to
// session, also after a reset (a counter that never stops will do). A session that has nothing to
// send for IdleClocks sends a datagram without a piece, and another one after each further
// IdleClocks. From these the receiver notices that the last packet was lost. Reset: together with
// the source of the packets.
//
// Latency: the first word of a datagram leaves four clocks after the last beat of its piece came.
// A piece takes one clock more than it has beats. Datagrams leave without a gap between them if
// packets come fast enough. A packet of three beats with DatagramBytes = 48, two beats a piece:
//
//   clock       0   1   2   3   4   5   6   7   8   9       15  16  17      23  24  25
//   s_valid_i  /111111111111111\_______________________...______________...____________
//   s_data_i   <0 ><1 ><2      >-----------------------...--------------...------------
//   s_last_i   ________/1111111\_______________________...______________...____________
//   s_ready_o  11111111\___/111\___/1111111111111111111...11111111111111...111111111111
//   ring       <0 ><1 ><a ><2 ><b >--------------------...--------------...------------  (a)
//   m_valid_o  ____________________/1111111111111111111...11111111111111...1111111\____
//   m_data_o   --------------------<a0><a1><a2><a3><00>...<12><13><b0>  ...<22><23>----
//   m_bytes_o  --------------------<48                 ...        ><32  ...       >----
//   m_last_o   ________________________________________...____/111\_____...____/111\____
//
//   (a) what is written; the header of a piece, a or b, is stored in front of its beats
`default_nettype none

module sp_datagram_cutter #(
  parameter int DatagramBytes = 1472,  // longest datagram: 32..65535; 8972 in jumbo frames
  // log2 of the beats of 16 bytes in the ring: a whole datagram or more, up to 24
  parameter int LogDepth = DatagramBytes > 8192 ? $clog2(DatagramBytes / 16 + 1) : 9,
  parameter int IdleClocks = 5_000_000  // silence after which the receiver is told: 2 or more
) (
  input  wire logic         clk_i,
  input  wire logic         rst_i,      // active high, synchronous
  input  wire logic         enable_i,   // send datagrams
  input  wire logic [15:0]  session_i,  // number of a session that begins in this clock

  // Packets
  input  wire logic         s_valid_i,
  output logic              s_ready_o,
  input  wire logic         s_last_i,   // last beat of a packet
  input  wire logic [127:0] s_data_i,   // first byte of a beat in 7..0

  // Datagrams
  output logic              m_valid_o,  // from the first word of a datagram to its last
  input  wire logic         m_ready_i,
  output logic              m_last_o,   // last word of a datagram
  output logic      [31:0]  m_data_o,   // first byte of a word in 7..0
  output logic      [15:0]  m_bytes_o   // bytes of the datagram, with every word
);

  if (DatagramBytes < 32 || DatagramBytes > 65535) begin : gen_datagram_bytes
    datagram_bytes_is_not_in_32_to_65535 u_error ();
  end
  if (DatagramBytes / 16 > 1 << LogDepth) begin : gen_log_depth
    the_ring_holds_no_whole_datagram u_error ();
  end
  if (IdleClocks < 2) begin : gen_idle_clocks
    idle_clocks_is_less_than_2 u_error ();
  end

  localparam int BeatBytes = sp_spec_pkg::PacketBeatBytes;
  localparam int LogBeatBytes = $clog2(BeatBytes);
  localparam int HeaderBytes = sp_spec_pkg::DatagramHeaderBytes;  // one beat
  localparam int PieceBeats = (DatagramBytes - HeaderBytes) / BeatBytes;
  localparam int CountBits = 16 - LogBeatBytes;  // beats of a packet
  localparam int PieceBits = $clog2(PieceBeats + 1);  // beats of a piece
  localparam int IdleBits = $clog2(IdleClocks);

  // --- Into the ring ---
  logic                 open_q;      // a session is open
  logic                 inside_q;    // a packet has begun; the header of its last piece is missing
  logic                 header_q;    // the header of the piece is written in this clock
  logic                 ended_q;     // with header_q: the piece is the last of its packet
  logic [LogDepth:0]    head_q;      // place of the piece's header; what is before it may leave
  logic [LogDepth:0]    put_q;       // place of the next beat
  logic [LogDepth:0]    get_q;       // place of the next beat to leave
  logic [LogDepth:0]    held;        // beats in the ring, and the place of a header
  logic [PieceBits-1:0] beats_q;     // beats of the piece
  logic [CountBits-1:0] offset_q;    // beats of the packet before the piece
  logic [15:0]          session_q;
  logic [31:0]          sequence_q;
  logic [31:0]          packet_q;
  logic [IdleBits-1:0]  idle_q;      // clocks without anything to send
  logic                 idle_due;
  logic                 take;
  logic                 room;
  logic [127:0]         header;

  assign held      = put_q - get_q;
  assign room      = !held[LogDepth];
  assign s_ready_o = open_q && !header_q && room;
  assign take      = s_valid_i && s_ready_o;
  assign idle_due  = idle_q == IdleBits'(IdleClocks - 1);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      open_q   <= 1'b0;
      inside_q <= 1'b0;
      header_q <= 1'b0;
      ended_q  <= 1'b0;
      head_q   <= '0;
      put_q    <= (LogDepth + 1)'(1);
      beats_q  <= '0;
      offset_q <= '0;
      idle_q   <= '0;
    end else begin
      if (!open_q) open_q <= enable_i;
      else if (!enable_i && !take && (!inside_q || header_q && ended_q)) open_q <= 1'b0;

      header_q <= take ? s_last_i || beats_q == PieceBits'(PieceBeats - 1) :
                  open_q && !inside_q && !header_q && room && idle_due;
      idle_q   <= !open_q || inside_q || take || header_q ? '0 :
                  idle_due ? idle_q : idle_q + 1'b1;
      if (take) begin
        inside_q <= 1'b1;
        ended_q  <= s_last_i;
        beats_q  <= beats_q + 1'b1;
        put_q    <= put_q + 1'b1;
      end else if (header_q) begin
        inside_q <= inside_q && !ended_q;
        ended_q  <= 1'b0;
        beats_q  <= '0;
        offset_q <= ended_q ? '0 : offset_q + CountBits'(beats_q);
        head_q   <= put_q;
        put_q    <= put_q + 1'b1;
      end
    end
    if (!open_q) begin
      session_q  <= session_i;
      sequence_q <= '0;
      packet_q   <= '0;
    end else if (header_q) begin
      sequence_q <= sequence_q + 1'b1;
      packet_q   <= packet_q + 32'(ended_q);
    end
  end

  assign header[sp_spec_pkg::DatagramMagicLsb+:sp_spec_pkg::DatagramMagicBits] =
      sp_spec_pkg::DatagramMagic;
  assign header[sp_spec_pkg::DatagramSessionLsb+:sp_spec_pkg::DatagramSessionBits] = session_q;
  assign header[sp_spec_pkg::DatagramSequenceLsb+:sp_spec_pkg::DatagramSequenceBits] = sequence_q;
  assign header[sp_spec_pkg::DatagramPacketLsb+:sp_spec_pkg::DatagramPacketBits] = packet_q;
  assign header[sp_spec_pkg::DatagramOffsetLsb+:sp_spec_pkg::DatagramOffsetBits] =
      {offset_q, LogBeatBytes'(0)};
  assign header[sp_spec_pkg::DatagramLengthLsb+:sp_spec_pkg::DatagramLengthBits] =
      {CountBits'(beats_q), LogBeatBytes'(0)};

  // A place is written only after its beat has left, and read only after the header behind which it
  // lies is written: never both in one clock.
  logic [127:0] beat;
  logic         fetch;
`ifdef FORMAL
  localparam int FDepth = 4;  // the proof is with LogDepth = 2
  (* anyconst *) logic [LogDepth:0] f_mark;
  logic [127:0]          f_there;
  logic [FDepth*128-1:0] f_words;
`endif

  sp_ram #(
    .Width   (128),
    .LogDepth(LogDepth)
  ) u_ring (
    .wr_clk_i (clk_i),
    .wr_en_i  (take || header_q),
    .wr_addr_i(header_q ? head_q[LogDepth-1:0] : put_q[LogDepth-1:0]),
    .wr_data_i(header_q ? header : s_data_i),
    .rd_clk_i (clk_i),
    .rd_en_i  (fetch),
    .rd_addr_i(get_q[LogDepth-1:0]),
    .rd_data_o(beat)
`ifdef FORMAL
    ,
    .f_addr_i (f_mark[LogDepth-1:0]),
    .f_word_o (f_there),
    .f_first_o(f_words)
`endif
  );

  // --- Out of the ring ---
  logic                 there_q;   // a beat waits behind the output
  logic                 first_q;   // that beat is the first of its datagram, the header
  logic [1:0]           word_q;    // next word of that beat
  logic [PieceBits-1:0] left_q;    // beats of the datagram that are left, including this one
  logic [PieceBits-1:0] length;
  logic                 move;      // the word goes to the output
  logic                 end_beat;  // the beat is the last of its datagram
  logic [31:0]          word;

  assign length   = beat[sp_spec_pkg::DatagramLengthLsb+LogBeatBytes+:PieceBits];
  assign end_beat = first_q ? length == '0 : left_q == PieceBits'(1);
  assign move     = there_q && (!m_valid_o || m_ready_i);
  assign fetch    = get_q != head_q && (!there_q || move && word_q == 2'd3);

  always_comb begin
    case (word_q)
      2'd0: word = beat[31:0];
      2'd1: word = beat[63:32];
      2'd2: word = beat[95:64];
      default: word = beat[127:96];
    endcase
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      get_q     <= '0;
      there_q   <= 1'b0;
      first_q   <= 1'b1;
      word_q    <= '0;
      m_valid_o <= 1'b0;
    end else begin
      if (fetch) begin
        get_q   <= get_q + 1'b1;
        there_q <= 1'b1;
      end else if (move && word_q == 2'd3) begin
        there_q <= 1'b0;
      end
      if (move) begin
        word_q <= word_q + 1'b1;
        if (word_q == 2'd3) first_q <= end_beat;
      end
      if (!m_valid_o || m_ready_i) m_valid_o <= there_q;
    end
    if (move) begin
      m_data_o <= word;
      m_last_o <= word_q == 2'd3 && end_beat;
      if (first_q && word_q == 2'd0)
        m_bytes_o <= {CountBits'(length) + CountBits'(HeaderBytes / BeatBytes), LogBeatBytes'(0)};
      if (word_q == 2'd3) left_q <= first_q ? length : left_q - 1'b1;
    end
  end

`ifdef FORMAL
  // Assumptions: one reset at the beginning; the number of a session is larger than those before.
  logic        f_ran_q = 1'b0;
  logic        f_begins, f_begun_q;  // a session begins; there was one
  logic [15:0] f_session_q;          // number of the last one
  assign f_begins = !open_q && enable_i;
  always_ff @(posedge clk_i) begin
    f_ran_q <= 1'b1;
    if (rst_i) f_begun_q <= 1'b0;
    else if (f_begins) {f_begun_q, f_session_q} <= {1'b1, session_i};
  end
  always_comb assume (rst_i == !f_ran_q);
  always_comb if (f_begins && f_begun_q) assume (session_i > f_session_q);

  // Rule 1: headers are written in order. They number the datagrams of a session from 0. Each
  // header belongs to the next piece of the packet (then the piece before is full), begins the next
  // packet, or reports silence before the next packet.
  logic                 f_wrote_q, f_last_ends_q;  // a header was written; its packet ended with it
  logic [127:0]         f_last_q;                  // the last one written
  logic                 f_new_session, f_open;     // f_open: a session may write a header
  logic [CountBits-1:0] f_at_q;                    // beats of this packet that have come
  logic [31:0]          f_packets_q;               // packets of the session that have come
  logic [15:0]          f_offset, f_length, f_last_offset, f_last_length;
  logic [31:0]          f_number, f_last_number, f_packet, f_last_packet;
  assign {f_length, f_offset, f_packet, f_number} = header[127:32];
  assign {f_last_length, f_last_offset, f_last_packet, f_last_number} = f_last_q[127:32];
  assign f_new_session = !f_wrote_q || f_last_q[31:16] != session_q;
  assign f_open        = open_q || header_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_wrote_q <= 1'b0;
    else if (header_q) {f_wrote_q, f_last_q, f_last_ends_q} <= {1'b1, header, ended_q};
    if (rst_i) f_at_q <= '0;
    else if (take) f_at_q <= s_last_i ? '0 : f_at_q + 1'b1;
    if (!open_q) f_packets_q <= '0;
    else f_packets_q <= f_packets_q + 32'(take && s_last_i);
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (f_at_q == (ended_q ? '0 : offset_q + beats_q));
    if (f_open) assert (f_begun_q && session_q == f_session_q);
    if (open_q) assert (packet_q + 32'(ended_q) == f_packets_q);
    if (f_wrote_q) assert (f_begun_q && f_last_q[31:16] <= f_session_q);
    if (f_open && f_new_session) assert (sequence_q == '0 && packet_q == '0 && offset_q == '0);
    if (f_open && !f_new_session) begin
      assert (sequence_q == f_last_number + 32'd1);
      assert (packet_q == f_last_packet + 32'(f_last_ends_q));
      assert (offset_q == (f_last_ends_q || f_last_length == '0 ? '0 :
                           f_last_offset[15:4] + f_last_length[15:4]));
    end
    if (f_wrote_q) assert (f_last_offset[3:0] == '0 && f_last_length[3:0] == '0);
    if (f_wrote_q && f_last_length == '0) assert (!f_last_ends_q && f_last_offset == '0);
    if (f_wrote_q && f_last_length != '0 && !f_last_ends_q)
      assert (f_last_length == 16'(PieceBeats * BeatBytes) && !f_new_session && inside_q);
    if (header_q) begin
      assert (header[15:0] == sp_spec_pkg::DatagramMagic && header[31:16] == f_session_q);
      if (f_new_session) assert ({f_number, f_packet, f_offset} == '0);
      else begin
        assert (f_number == f_last_number + 32'd1);
        if (f_last_length == '0) assert (f_packet == f_last_packet && f_offset == '0);
        else if (f_last_ends_q) assert (f_packet == f_last_packet + 32'd1 && f_offset == '0);
        else assert (f_packet == f_last_packet && f_offset == f_last_offset + f_last_length &&
                     f_length != '0 && f_last_length == 16'(PieceBeats * BeatBytes));
      end
    end
  end

  // Rule 2: no place is written before its beat has left; the place of a header is kept for it.
  logic [LogDepth:0]   f_whole;  // beats that may leave
  logic [LogDepth+1:0] f_held;   // with those behind them, and the place of a header
  assign f_whole = head_q - get_q;
  assign f_held  = (LogDepth + 2)'(f_whole) + (LogDepth + 2)'(beats_q) + (LogDepth + 2)'(1);
  always_comb if (f_ran_q && !rst_i) begin
    assert (beats_q <= CountBits'(PieceBeats) && held == f_held[LogDepth:0]);
    if (!header_q) assert (beats_q < CountBits'(PieceBeats) && !ended_q);
    assert (inside_q ? open_q : beats_q == '0 && offset_q == '0 && !ended_q);
    if (inside_q && header_q)
      assert (beats_q != '0 && (ended_q || beats_q == CountBits'(PieceBeats)));
    assert (f_held <= (LogDepth + 2)'((1 << LogDepth) + 1));
    if (f_held > (LogDepth + 2)'(1 << LogDepth)) assert (beats_q == '0 && !header_q);
  end

  // Rule 3: what may leave is whole datagrams: a header, then as many beats as it says, and so on.
  logic [FDepth-1:0]     f_is_header_q, f_header_of;  // of the places; as they leave
  logic [CountBits-1:0]  f_rest;  // beats of the datagram at the output, still in the ring
  assign f_rest = !there_q ? '0 : first_q ? length : left_q - 1'b1;
  always_ff @(posedge clk_i) begin
    if (header_q) f_is_header_q[head_q[LogDepth-1:0]] <= 1'b1;
    else if (take) f_is_header_q[put_q[LogDepth-1:0]] <= 1'b0;
  end
  for (genvar i = 0; i < FDepth; i++) begin : gen_f_place
    logic [LogDepth-1:0]  f_place;
    logic [CountBits-1:0] f_beats, f_next;  // of a header: its beats; place of the next header
    assign f_place        = get_q[LogDepth-1:0] + LogDepth'(i);
    assign f_header_of[i] = f_is_header_q[f_place];
    assign f_beats        = f_words[{f_place, 7'd116}+:CountBits];
    assign f_next         = f_beats + CountBits'(i + 1);
    always_comb if (f_ran_q && !rst_i) begin
      if (i < f_whole) begin
        if (CountBits'(i) <= f_rest) assert (f_header_of[i] == (CountBits'(i) == f_rest));
        if (f_header_of[i]) begin
          assert (f_beats <= CountBits'(PieceBeats) && f_next <= CountBits'(f_whole));
          for (int j = i + 1; j < FDepth; j++) begin
            if (CountBits'(j) <= f_next && j < f_whole)
              assert (f_header_of[j] == (CountBits'(j) == f_next));
          end
        end
      end
      if (i > f_whole && (LogDepth + 2)'(i) < f_held) assert (!f_header_of[i]);  // not whole
    end
  end

  // Rule 4: from the first word of a datagram to its last there is no gap. The length is shown all
  // the time, and as many bytes leave. A word that waits does not change.
  logic [15:0] f_words_q;  // words of this datagram that have left
  logic        f_start;    // the next word that moves is the first of a datagram
  logic        f_goes_on_q, f_waits_q, f_moved_q;  // one clock ago: no last word left; none left;
  logic [80:0] f_shows_q;                          // the last of a beat moved; what was shown
  assign f_start = first_q && word_q == '0;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_words_q <= '0;
    else if (m_valid_o && m_ready_i) f_words_q <= m_last_o ? 16'd0 : f_words_q + 16'd1;
    f_goes_on_q <= !rst_i && m_valid_o && !(m_ready_i && m_last_o);
    f_waits_q   <= !rst_i && m_valid_o && !m_ready_i;
    f_moved_q   <= !rst_i && move && word_q == 2'd3;
    f_shows_q   <= {beat[127:96], m_data_o, m_last_o, m_bytes_o};
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (f_rest <= CountBits'(f_whole));
    if (there_q && first_q) assert (beat[127:116] <= CountBits'(PieceBeats));
    if (!first_q) assert (left_q != '0 && left_q <= CountBits'(PieceBeats));
    if (!f_start) assert (there_q && m_valid_o);
    if (f_goes_on_q) assert (m_valid_o && m_bytes_o == f_shows_q[15:0]);
    if (f_waits_q) assert ({m_data_o, m_last_o, m_bytes_o} == f_shows_q[48:0]);
    if (f_moved_q) assert (m_data_o == f_shows_q[80:49]);
    if (!m_valid_o) assert (f_words_q == '0);
    else begin
      assert (m_last_o == f_start && m_last_o == (m_bytes_o == {f_words_q[13:0] + 14'd1, 2'b00}));
      assert (m_bytes_o <= 16'(DatagramBytes) && m_bytes_o[3:0] == '0 && m_bytes_o != '0);
      assert (f_words_q < 16'(DatagramBytes / 4));
      if (!f_start && first_q)
        assert (length + 1'b1 == m_bytes_o[15:4] && f_words_q == 16'(word_q) - 16'd1);
      if (!f_start && !first_q)
        assert ({m_bytes_o[15:4] - left_q, 2'd0} == f_words_q[13:0] + 14'd1 - 14'(word_q));
    end
  end

  // Rule 5: every beat leaves once, in order, after a header with its session, its packet and its
  // place. The last beat of a packet is the last of its datagram. The rule is proved for any one
  // place f_mark of the pointers, and the last beat that came there:
  logic                 f_marked_q, f_shown_q, f_beat_last_q;  // in the ring; shown; s_last_i
  logic [127:0]         f_beat_q, f_header;  // that beat; its header
  logic [31:0]          f_beat_packet_q;
  logic [15:0]          f_beat_session_q;
  logic [CountBits-1:0] f_beat_at_q, f_behind_q;  // its place in the packet, behind the header
  logic [127:0]         f_header_q;               // of the datagram at the output
  logic [LogDepth:0]    f_before, f_header_place;  // places before the beat; place of its header
  assign f_before       = f_mark - get_q;
  assign f_header_place = f_mark - (LogDepth + 1)'(f_behind_q);
  assign f_header       = f_words[{f_header_place[LogDepth-1:0], 7'd0}+:128];
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_marked_q, f_shown_q} <= '0;
    else begin
      if (take && put_q == f_mark) begin
        f_marked_q <= 1'b1;
        {f_beat_q, f_beat_session_q, f_beat_packet_q} <= {s_data_i, f_session_q, f_packets_q};
        {f_beat_last_q, f_beat_at_q, f_behind_q} <= {s_last_i, f_at_q, CountBits'(beats_q) + 1'b1};
      end else if (fetch && get_q == f_mark) f_marked_q <= 1'b0;
      if (fetch) f_shown_q <= f_marked_q && get_q == f_mark;
      else if (move && word_q == 2'd3) f_shown_q <= 1'b0;
    end
    if (there_q && first_q) f_header_q <= beat;
  end
  function automatic logic f_tells(input logic [127:0] f_of);
    f_tells = f_of[31:16] == f_beat_session_q && f_of[95:64] == f_beat_packet_q &&
              f_of[111:100] + f_behind_q == f_beat_at_q + 1'b1 &&
              (f_beat_last_q ? f_of[127:116] == f_behind_q : f_of[127:116] >= f_behind_q);
  endfunction
  always_comb if (f_ran_q && !rst_i) begin
    if (f_marked_q) begin
      assert (f_before < held && f_mark != head_q && !f_is_header_q[f_mark[LogDepth-1:0]]);
      assert (f_there == f_beat_q && f_behind_q != '0 && f_behind_q <= CountBits'(PieceBeats));
      if (f_before >= f_whole) begin  // its header is not written yet
        assert (f_header_place == head_q && f_behind_q <= beats_q);
        assert (f_beat_session_q == session_q && f_beat_packet_q == packet_q);
        assert (f_beat_at_q == offset_q + f_behind_q - 1'b1);
        assert (f_beat_last_q == (ended_q && f_behind_q == beats_q));
      end else if (CountBits'(f_before) >= f_behind_q) begin  // its header is in the ring
        assert (f_is_header_q[f_header_place[LogDepth-1:0]] && f_tells(f_header));
      end else begin  // its header is at the output, or was there
        assert (there_q && f_tells(first_q ? beat : f_header_q));
        assert (f_behind_q + f_rest == CountBits'(f_before) + 1'b1 +
                (first_q ? length : f_header_q[127:116]));
      end
    end
    if (!first_q) assert (left_q <= f_header_q[127:116]);
    if (f_shown_q) begin
      assert (there_q && !first_q && f_before == '1 && beat == f_beat_q && f_tells(f_header_q));
      assert (f_header_q[127:116] - left_q + 1'b1 == f_behind_q);
    end
    if (word_q != '0) assert (m_data_o == beat[{word_q - 2'd1, 5'd0}+:32]);
    cover (f_shown_q && left_q == CountBits'(1) && f_header_q[111:96] != '0);
    cover (there_q && first_q && length == '0 && beat[95:64] == 32'd1);
    cover (there_q && first_q && length != '0 && m_valid_o && beat[31:16] != f_header_q[31:16]);
  end
`endif

endmodule

`default_nettype wire
