// Holds each beat of a line back until the next one comes or the line ends, so that the last beat
// of a line can be marked; and leaves out the rest of a frame that is lost.
//
// Guarantees: beats leave in order, each once, with m_start_o on the first of a frame and m_end_o
// on the last of a line. From a beat on for which there is no room, and after cut_i, nothing leaves
// before the next frame begins. After a reset, nothing leaves before a frame begins.
//
// Latency: combinational. A beat leaves in the clock of the next one's full_i, or of ending_i. It
// needs room_i there; where that is low, lost_o is high and the beat does not leave.
//
//   clock      0   1   2   3   4   5
//   begins_i  /111\___________________
//   full_i    ____/111\___/111\_______   beats 0 and 1
//   ending_i  ____________________/111
//   m_valid_o ____________/111\___/111
//   m_data_o  ------------<0 >----<1 >   beat 1 with m_end_o
`default_nettype none

module sp_beat_hold #(
  parameter int Width = 32  // bits of a beat: 1 or more
) (
  input  wire logic             clk_i,
  input  wire logic             rst_i,     // active high, synchronous
  input  wire logic             begins_i,  // a frame begins, with its first beat or before it
  input  wire logic             full_i,    // a beat is complete
  input  wire logic [Width-1:0] beat_i,
  input  wire logic             ending_i,  // the line has ended; not together with full_i
  input  wire logic             cut_i,     // the rest of the frame is lost
  input  wire logic             room_i,    // a beat may leave
  output logic                  m_valid_o,
  output logic      [Width-1:0] m_data_o,
  output logic                  m_start_o,
  output logic                  m_end_o,
  output logic                  lost_o     // there is no room for a beat
);

  if (Width < 1) begin : gen_width
    width_is_less_than_1 u_error ();
  end

  logic first_q;  // no beat of the frame is complete yet
  logic open_q;   // the frame has not been lost
  logic whole_q;  // a beat waits in m_data_o
  logic first, open, leaves;

  assign first     = first_q || begins_i;
  assign open      = open_q || begins_i;
  assign leaves    = whole_q && (full_i || ending_i) && !rst_i;
  assign lost_o    = leaves && !room_i;
  assign m_valid_o = leaves && room_i;
  assign m_end_o   = ending_i;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      open_q  <= 1'b0;
      whole_q <= 1'b0;
    end else begin
      open_q <= open && !lost_o && !cut_i;
      if (lost_o || cut_i) whole_q <= 1'b0;
      else if (full_i) whole_q <= open;
      else if (ending_i) whole_q <= 1'b0;
    end
    if (full_i) begin
      m_data_o  <= beat_i;
      m_start_o <= first;
    end
    first_q <= first && !full_i;
  end

`ifdef FORMAL
  logic f_past_q = 1'b0;
  always_ff @(posedge clk_i) f_past_q <= 1'b1;
  always_comb if (!f_past_q) assume (rst_i);
  // Frames begin behind the end of a line.
  logic f_line_q;  // a beat of the line is complete
  always_comb assume (!(full_i && ending_i));
  always_comb if (f_line_q) assume (!begins_i);
  always_ff @(posedge clk_i) begin
    if (rst_i || ending_i || cut_i) f_line_q <= 1'b0;
    else if (full_i) f_line_q <= 1'b1;
  end

  // Beats of a frame, modulo 16: complete, and left. A frame is good until it is lost.
  (* anyconst *) logic [3:0] f_mark;
  logic [3:0]  f_came_q, f_left_q;
  logic [Width-1:0] f_beat_q;  // beat f_mark, once it has come
  logic        f_good_q, f_any_q;
  logic [3:0]  f_came;
  assign f_came = begins_i ? 4'd0 : f_came_q;
  always_ff @(posedge clk_i) begin
    f_came_q <= f_came + 4'(full_i);
    f_left_q <= (begins_i ? 4'd0 : f_left_q) + 4'(m_valid_o);
    f_any_q  <= !begins_i && f_any_q || full_i;
    f_good_q <= !rst_i && !lost_o && !cut_i && (f_good_q || begins_i);
    if (full_i && f_came == f_mark) f_beat_q <= beat_i;
  end

  always_comb if (f_past_q) begin
    // Rule 1: while a frame is good, all its beats but the one that waits have left; one waits only
    // within a line.
    assert (open_q == f_good_q);
    if (f_good_q) assert (f_left_q + 4'(whole_q) == f_came_q);
    if (f_good_q) assert (first_q == !f_any_q && (f_any_q || f_came_q == 4'd0));
    assert (!whole_q || f_good_q && f_any_q);
    assert (whole_q == (f_line_q && f_good_q));
    // Rule 2: what waits is the beat that came last.
    if (whole_q && f_came_q == f_mark + 4'd1) assert (m_data_o == f_beat_q);
    if (whole_q && m_start_o) assert (f_came_q == 4'd1);
    // Rule 3: beats leave in order, the first one marked, and the last of a line.
    if (m_valid_o && f_left_q == f_mark) assert (m_data_o == f_beat_q);
    if (m_valid_o) assert (f_good_q && m_end_o == ending_i && !begins_i);
    if (m_valid_o && m_start_o) assert (f_left_q == 4'd0);
    // Rule 4: nothing leaves from a frame that is lost, and a beat without room is told.
    if (!f_good_q) assert (!m_valid_o && !lost_o);
    if (lost_o) assert (!room_i);
  end
  always_ff @(posedge clk_i) if (f_past_q) begin
    cover (m_valid_o && m_end_o && f_left_q == 4'd2);
    cover (lost_o);
  end
`endif

endmodule

`default_nettype wire
