// Which host gets a board's packets, and when a session of sp_datagram_cutter begins.
//
// Guarantees: nothing is sent before the first start_i. Each start_i ends the session that is open.
// After the last datagram of that session has left, a new session begins for the host owner_i. So
// to_o changes only between two datagrams, and a datagram goes only to the host that its session is
// for. If another start_i comes before the new session begins, it replaces the earlier one. The
// session stays open when its owner stops the board, so that the last packets leave. session_o
// counts clocks, and a reset does not stop it.
//
// Latency: if no packet or datagram is under way, a session begins nine clocks after start_i.
`default_nettype none

module sp_link_session (
  input  wire logic        clk_i,
  input  wire logic        rst_i,        // active high, synchronous
  input  wire logic        start_i,      // a session is to begin
  input  wire logic [31:0] owner_i,      // address of the session's host, from start_i on

  // The cutter
  output logic             enable_o,
  output logic      [15:0] session_o,
  input  wire logic        beat_i,       // the cutter takes a beat of a packet
  input  wire logic        beat_last_i,  // that beat is the last of its packet
  input  wire logic        sending_i,    // m_valid_o of the cutter

  output logic      [31:0] to_o          // address of the host that gets the datagrams
);

  logic       inside_q;   // a packet has begun
  logic       begins_q;   // a session is to begin
  logic [2:0] quiet_q;    // clocks without anything under way

  always_ff @(posedge clk_i) begin
    session_o <= session_o + 1'b1;
    if (rst_i) begin
      enable_o <= 1'b0;
      inside_q <= 1'b0;
      begins_q <= 1'b0;
    end else begin
      if (beat_i) inside_q <= !beat_last_i;
      if (start_i) begin
        begins_q <= 1'b1;
        enable_o <= 1'b0;
      end else if (begins_q && quiet_q == '1) begin
        begins_q <= 1'b0;
        enable_o <= 1'b1;
        to_o     <= owner_i;
      end
    end
    if (!begins_q || start_i || inside_q || beat_i || sending_i) quiet_q <= '0;
    else quiet_q <= quiet_q + 1'b1;
  end

endmodule

`default_nettype wire
