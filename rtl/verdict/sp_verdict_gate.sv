// Chooses the frames that sp_verdict judges: all but those that come too soon.
//
// A frame is judged if sp_verdict is ready for it when the packet of its moments is asked for, that
// is three clocks after the first beat of its last row. With C columns, that beat has to come
// C + 23 clocks or more after the frame's first beat, and C + 18 or more after the verdict of the
// frame before: limits are composed anew for each frame. A frame that waits while they are composed
// for one that was not judged takes its place. Frames that are not judged are told by missed_o;
// their packets count as lost.
//
// Latency: encoder_i is read six clocks after frame_start_i. judge_o stands from the clock behind a
// decision to the next decision.
//
//   frame_start_i     _/1\_________________________________
//   frame_o           _____________/1\_____________________
//   start_i           _____________________/1\_____________    from sp_verdict
//   composed_i        _________________________/1\_________    from sp_verdict, C + 5 clocks later
//   ready_o           _____________________________/11\____
//   decision_i        _____________________________/1\_____
//   judge_o           _________________________________/1111
`default_nettype none

module sp_verdict_gate (
  input  wire logic clk_i,
  input  wire logic rst_i,

  input  wire logic on_i,            // with frame_start_i: the frame is to be judged
  input  wire logic frame_start_i,   // first beat of a frame
  input  wire logic decision_i,      // about the packet of a frame that is to be judged
  input  wire logic spoiled_i,       // with decision_i: the sums are void
  input  wire logic start_i,         // sp_verdict has the frame's settings
  input  wire logic composed_i,      // and its limits: it can take beats
  input  wire logic verdict_i,       // it has judged

  output logic      frame_o,         // sp_verdict shall begin with the frame
  output logic      restart_o,       // with frame_o: the frame before was not to be judged
  output logic      ready_o,
  output logic      judge_o,
  output logic      judging_o,       // sums are those of a frame that is judged
  output logic      missed_o
);

  localparam int EncoderDelay = 6;  // from a frame's start until its encoder count is known

  logic [EncoderDelay-1:1] started_q;
  logic                    known_q;    // the count of a frame that waits is known
  logic                    waits_q;    // the frame is not yet with sp_verdict
  logic                    begins_q;   // sp_verdict begins with a frame, this one or an earlier

  assign frame_o = waits_q && known_q && !begins_q && !judging_o;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      started_q <= '0;
      known_q   <= 1'b0;
      waits_q   <= 1'b0;
      restart_o <= 1'b1;
      ready_o   <= 1'b0;
      missed_o  <= 1'b0;
      begins_q  <= 1'b0;
      judging_o <= 1'b0;
      judge_o   <= 1'b0;
    end else begin
      // A frame that begins breaks the one before, whose count may not be known yet.
      started_q <= {started_q[EncoderDelay-2:1] & {EncoderDelay - 2{!frame_start_i}},
                    frame_start_i};
      known_q   <= !frame_start_i && (started_q[EncoderDelay-1] || known_q);
      waits_q   <= frame_start_i ? on_i : waits_q && !frame_o;
      restart_o <= frame_start_i && !on_i || restart_o && !frame_o;
      // A decision about the frame before may still be due, two clocks after this one's start.
      ready_o   <= !started_q[2] && !decision_i &&
                   (composed_i && !waits_q && !begins_q && !started_q[1] || ready_o);
      missed_o  <= decision_i && !ready_o;
      begins_q  <= frame_o || begins_q && !start_i;
      if (decision_i) judge_o <= ready_o && !spoiled_i;
      judging_o <= decision_i && ready_o && !spoiled_i || judging_o && !verdict_i;
    end
  end

endmodule

`default_nettype wire
