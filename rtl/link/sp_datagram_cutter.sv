// Cuts packets into datagrams, the payloads of UDP: each is a header and a piece of one packet.
// model/datagram_cutter.h is its model.
//
//   packets, 128 bits ─┬▶ ring of beats ─▶ datagrams, 32 bits
//   header of a piece ─┘
//
// Guarantees: every beat of a packet leaves once, in order, in the datagram whose header tells of
// it. A datagram leaves only after all of it has come. From its first word to its last, m_valid_o
// stays high. All pieces of a packet but the last are as long as DatagramBytes allows. Nothing is
// lost here: where the ring is full, packets wait, and the packet FIFO before it counts what it has
// no room for.
//
// A session begins when enable_i is high. It takes the number session_i, and counts its datagrams
// and packets from 0. When enable_i is low, the session ends after the packet that has begun.
// Further packets wait; what is in the ring still leaves. session_i must differ from session to
// session, also after a reset (a counter that never stands still will do). A session with nothing
// to send for IdleClocks sends a datagram without a piece, and another one after each further
// IdleClocks. So the receiver notices that a last packet was lost. Reset: together with the source
// of the packets.
//
// Latency: the first word of a datagram leaves four clocks after the last beat of its piece came.
// A piece takes one clock more than it has beats. Datagrams leave without a gap between them if
// they come fast enough. A packet of three beats with DatagramBytes = 48, so in pieces of two:
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
//   (a) what is written: the header of a piece, a or b, goes before its beats
`default_nettype none

module sp_datagram_cutter #(
  parameter int DatagramBytes = 1472,  // longest datagram: 32..65535; 8972 in jumbo frames
  // log2 of the beats of 16 bytes in the ring: a whole datagram or more
  parameter int LogDepth = DatagramBytes > 8192 ? $clog2(DatagramBytes / 16 + 1) : 9,
  parameter int IdleClocks = 5_000_000  // silence after which the receiver is told: 2 or more
) (
  input  wire logic         clk_i,
  input  wire logic         rst_i,      // active high, synchronous
  input  wire logic         enable_i,   // datagrams are wanted
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

  localparam int BeatBytes = sp_spec_pkg::PacketBeatBytes;
  localparam int LogBeatBytes = $clog2(BeatBytes);
  localparam int HeaderBytes = sp_spec_pkg::DatagramHeaderBytes;  // one beat
  localparam int PieceBeats = (DatagramBytes - HeaderBytes) / BeatBytes;
  localparam int CountBits = 16 - LogBeatBytes;  // beats of a packet
  localparam int IdleBits = $clog2(IdleClocks);

`ifndef SYNTHESIS
  initial begin
    if (DatagramBytes < HeaderBytes + BeatBytes || DatagramBytes > 65535)
      $fatal(1, "sp_datagram_cutter: DatagramBytes is %0d, not in 32..65535", DatagramBytes);
    if (1 << LogDepth < PieceBeats + 1)
      $fatal(1, "sp_datagram_cutter: a ring of %0d beats holds no datagram", 1 << LogDepth);
    if (IdleClocks < 2)
      $fatal(1, "sp_datagram_cutter: IdleClocks is %0d, less than 2", IdleClocks);
  end
`endif

  // --- Into the ring ---
  logic                 open_q;      // a session is open
  logic                 inside_q;    // a packet has begun; the header of its last piece is missing
  logic                 header_q;    // the header of the piece is written in this clock
  logic                 ended_q;     // with it: the piece is the last of its packet
  logic [LogDepth:0]    head_q;      // place of the piece's header; what is before it may leave
  logic [LogDepth:0]    put_q;       // place of the next beat
  logic [LogDepth:0]    get_q;       // place of the next beat to leave
  logic [LogDepth:0]    held;        // beats in the ring, and the place of a header
  logic [CountBits-1:0] beats_q;     // beats of the piece
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

      header_q <= take ? s_last_i || beats_q == CountBits'(PieceBeats - 1) :
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
        offset_q <= ended_q ? '0 : offset_q + beats_q;
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
      {beats_q, LogBeatBytes'(0)};

  // A place is written only after its beat has left, and read only after the header behind which it
  // lies is written: never both in one clock.
  logic [127:0] beat;
  logic         fetch;

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
  );

  // --- Out of the ring ---
  logic                 there_q;   // a beat waits behind the output
  logic                 first_q;   // it is the first of its datagram, the header
  logic [1:0]           word_q;    // its next word
  logic [CountBits-1:0] left_q;    // beats of the datagram that are left, with this one
  logic [CountBits-1:0] length;
  logic                 move;      // the word goes to the output
  logic                 end_beat;  // the beat is the last of its datagram
  logic [31:0]          word;

  assign length   = beat[sp_spec_pkg::DatagramLengthLsb+LogBeatBytes+:CountBits];
  assign end_beat = first_q ? length == '0 : left_q == CountBits'(1);
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
        m_bytes_o <= {length + CountBits'(HeaderBytes / BeatBytes), LogBeatBytes'(0)};
      if (word_q == 2'd3) left_q <= first_q ? length : left_q - 1'b1;
    end
  end

endmodule

`default_nettype wire
