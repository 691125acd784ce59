// Chooses one of several sources of video for the board.
//
// Guarantees: after a change of select_i, beats come only from the new source, and the first of
// them begins a frame. The frame of the old source that has begun is cut off, so that sp_board
// counts and marks it as broken; beats of two sources never make one frame. While no bit of
// select_i is set, or several, the source remains.
//
// Latency: a beat leaves one clock after it came. A change of select_i counts after three to four
// clocks.
`default_nettype none

module sp_video_switch #(
  parameter int Sources = 2  // 1 or more
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,      // active high, synchronous; then source 0

  input  wire logic [Sources-1:0]    select_i,   // a bit for each source; registers of any clock

  // The sources, source 0 in the lowest bits
  input  wire logic [Sources-1:0]    s_valid_i,
  input  wire logic [Sources*32-1:0] s_data_i,
  input  wire logic [Sources-1:0]    s_start_i,  // first beat of a frame
  input  wire logic [Sources-1:0]    s_end_i,    // last beat of a line

  // Video, to the board's s_axis ports
  output logic                       m_valid_o,
  output logic      [31:0]           m_data_o,   // leftmost pixel in 7..0
  output logic                       m_start_o,
  output logic                       m_end_o
);

  logic [Sources-1:0] wanted;    // select_i in this clock
  logic [Sources-1:0] chosen_q;  // one bit
  logic               open_q;    // a frame of this source has begun
  logic               change;
  logic               valid, start;
  logic [31:0]        data;

  sp_sync #(
    .Width(Sources)
  ) u_wanted (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  (select_i),
    .q_o  (wanted)
  );

  assign change = wanted != chosen_q && wanted != '0 && (wanted & (wanted - 1'b1)) == '0;
  assign valid  = (s_valid_i & chosen_q) != '0;
  assign start  = (s_start_i & chosen_q) != '0;

  always_comb begin
    data = '0;
    for (int i = 0; i < Sources; i++) data |= s_data_i[32*i+:32] & {32{chosen_q[i]}};
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      chosen_q  <= Sources'(1);
      open_q    <= 1'b0;
      m_valid_o <= 1'b0;
    end else begin
      if (change) chosen_q <= wanted;
      open_q    <= !change && (open_q || valid && start);
      m_valid_o <= valid && (open_q || start) && !change;
    end
    m_data_o  <= data;
    m_start_o <= start;
    m_end_o   <= (s_end_i & chosen_q) != '0;
  end

endmodule

`default_nettype wire
