// Replay: frames that a host sends in datagrams leave as video, as those of a camera. So recorded
// images run through the board. docs/packet-reference.md has the format, model/replay.h is the
// model.
//
//   datagrams ─▶ sp_replay_receiver ─▶ memory ─▶ sp_replay_player ─▶ video
//        bus clock                   ─┼─              pixel clock
//
// Guarantees: only frames that came whole leave, each once and in order, and their beats follow
// each other without a gap. The memory holds one frame. While it leaves, the receiver ignores
// datagrams; the host sees this by the registers and repeats them. Frames up to MaxColumns x
// MaxRows fit. Their rows are stored without gaps, so the memory has MaxColumns / 4 * MaxRows words
// of 32 bits.
//
// Between two frames there are at least eight clocks of each side. Resets: both together, four
// clocks or more.
//
// Latency: the first beat leaves 11 to 12 clocks of clk_i and three of bus_clk_i after the last
// word of the frame came.
`default_nettype none

module sp_replay #(
  parameter int MaxColumns = 512,  // a multiple of 4, 4..2048; with one row 8 or more
  parameter int MaxRows = 127  // 1..1023
) (
  input  wire logic        bus_clk_i,
  input  wire logic        bus_rst_i,  // active high, synchronous to bus_clk_i

  // Datagrams: payloads that came to the UDP port of replay, 1236
  input  wire logic        s_valid_i,  // a word, which is taken at once
  input  wire logic        s_last_i,   // last word of a datagram
  input  wire logic        s_error_i,  // with the last word: the datagram is damaged
  input  wire logic [31:0] s_data_i,   // first byte of a word in 7..0
  input  wire logic [15:0] s_bytes_i,  // bytes of the datagram, with every word
  input  wire logic [31:0] s_from_i,   // address of the sender, with every word

  // From and to sp_link
  input  wire logic        enable_i,   // datagrams are taken
  input  wire logic [31:0] host_i,     // from this address
  input  wire logic        begin_i,    // one clock: a session of replay begins
  input  wire logic [15:0] session_i,  // its number, from begin_i on
  output logic      [31:0] frame_o,    // the frame that is due, or of which a part has come
  output logic      [31:0] offset_o,   // bytes of it that have come
  output logic      [31:0] frames_o,   // whole frames that have left; wraps
  output logic      [31:0] dropped_o,  // frames that were dropped; wraps
  output logic      [31:0] ignored_o,  // datagrams that were ignored; wraps

  // Video, to the board's s_axis ports
  input  wire logic        clk_i,
  input  wire logic        rst_i,      // active high, synchronous to clk_i
  output logic             m_valid_o,
  output logic      [31:0] m_data_o,   // leftmost pixel in 7..0
  output logic             m_start_o,  // first beat of a frame
  output logic             m_end_o     // last beat of a line
);

  localparam int Words = MaxColumns / 4 * MaxRows;
  localparam int LogWords = $clog2(Words);
  localparam int BeatBits = $clog2(MaxColumns / 4 + 1);
  localparam int RowBits = $clog2(MaxRows + 1);

  // The memory and the size of its frame stand still from a change of asked_q until back_q has
  // followed it.
  logic                write, play, done;
  logic [LogWords-1:0] write_address;
  logic [31:0]         write_data;
  logic [BeatBits-1:0] beats;
  logic [RowBits-1:0]  rows;
  logic                asked_q;                 // changes with every whole frame
  logic                back_seen, back_seen_q;  // back_q in the bus clock

  sp_replay_receiver #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows)
  ) u_receiver (
    .clk_i    (bus_clk_i),
    .rst_i    (bus_rst_i),
    .s_valid_i(s_valid_i),
    .s_last_i (s_last_i),
    .s_error_i(s_error_i),
    .s_data_i (s_data_i),
    .s_bytes_i(s_bytes_i),
    .s_from_i (s_from_i),
    .enable_i (enable_i),
    .host_i   (host_i),
    .begin_i  (begin_i),
    .session_i(session_i),
    .write_o  (write),
    .address_o(write_address),
    .data_o   (write_data),
    .play_o   (play),
    .beats_o  (beats),
    .rows_o   (rows),
    .done_i   (done),
    .frame_o  (frame_o),
    .offset_o (offset_o),
    .frames_o (frames_o),
    .dropped_o(dropped_o),
    .ignored_o(ignored_o)
  );

  always_ff @(posedge bus_clk_i) begin
    if (bus_rst_i) asked_q <= 1'b0;
    else if (play) asked_q <= !asked_q;
    back_seen_q <= !bus_rst_i && back_seen;
  end
  assign done = back_seen != back_seen_q;

  logic                read, start, ended;
  logic [LogWords-1:0] read_address;
  logic [31:0]         read_data;
  logic                asked_seen, asked_seen_q;  // asked_q in the pixel clock
  logic                back_q;

  sp_ram #(
    .Width   (32),
    .LogDepth(LogWords),
    .Depth   (Words)
  ) u_memory (
    .wr_clk_i (bus_clk_i),
    .wr_en_i  (write),
    .wr_addr_i(write_address),
    .wr_data_i(write_data),
    .rd_clk_i (clk_i),
    .rd_en_i  (read),
    .rd_addr_i(read_address),
    .rd_data_o(read_data)
  );

  sp_sync u_asked (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  (asked_q),
    .q_o  (asked_seen)
  );

  always_ff @(posedge clk_i) begin
    asked_seen_q <= !rst_i && asked_seen;
    if (rst_i) back_q <= 1'b0;
    else if (ended) back_q <= !back_q;
  end
  assign start = asked_seen != asked_seen_q;

  sp_sync u_back (
    .clk_i(bus_clk_i),
    .rst_i(bus_rst_i),
    .d_i  (back_q),
    .q_o  (back_seen)
  );

  sp_replay_player #(
    .LogWords(LogWords),
    .BeatBits(BeatBits),
    .RowBits (RowBits)
  ) u_player (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .start_i  (start),
    .beats_i  (beats),
    .rows_i   (rows),
    .done_o   (ended),
    .read_o   (read),
    .address_o(read_address),
    .data_i   (read_data),
    .m_valid_o(m_valid_o),
    .m_data_o (m_data_o),
    .m_start_o(m_start_o),
    .m_end_o  (m_end_o)
  );

endmodule

`default_nettype wire
