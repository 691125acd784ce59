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

`ifdef FORMAL
  // Assumptions: one reset at the beginning. A frame that is to be judged has one decision or none:
  // four clocks behind its start or later, and two behind the start of the next frame at the latest
  // (its last row begins before that, and the frame three clocks or more before it). start_i
  // answers frame_o once, at any time later, and composed_i start_i. verdict_i ends the sums of a
  // frame that is judged.
  logic       f_ran_q = 1'b0;
  logic [2:0] f_age_q;      // clocks since the last frame began, 7 at most; 0: none has
  logic       f_on_q;       // it is to be judged
  logic       f_decided_q;  // its decision came
  logic       f_given_q;    // frame_o told of it, and of none after it
  logic [1:0] f_due_q;      // clocks in which the decision about the frame before may still come
  logic       f_given_due_q;  // frame_o told of that one
  logic       f_begins_q;   // start_i is due
  logic       f_composing_q;  // composed_i is due
  logic       f_off_q;      // a frame that is not to be judged has begun since the last frame_o
  logic       f_judging_q, f_judge_q, f_new, f_given;
  assign f_new   = decision_i && f_due_q == '0;
  assign f_given = f_due_q != '0 ? f_given_due_q : f_given_q;
  always_ff @(posedge clk_i) begin
    f_ran_q <= 1'b1;
    if (rst_i) begin
      {f_age_q, f_on_q, f_decided_q, f_given_q, f_due_q, f_begins_q, f_composing_q} <= '0;
      {f_off_q, f_judging_q, f_judge_q}                                       <= 3'b100;
    end else begin
      f_begins_q  <= frame_o || f_begins_q && !start_i;
      f_composing_q <= start_i || f_composing_q && !composed_i;
      f_off_q     <= frame_start_i && !on_i || f_off_q && !frame_o;
      f_judging_q <= decision_i && ready_o && !spoiled_i || f_judging_q && !verdict_i;
      if (decision_i) f_judge_q <= ready_o && !spoiled_i;
      f_due_q     <= decision_i || f_due_q == '0 ? '0 : f_due_q - 2'd1;
      if (f_new) f_decided_q <= 1'b1;
      if (frame_start_i) begin
        f_age_q     <= 3'd1;
        f_on_q      <= on_i;
        f_decided_q <= 1'b0;
        f_given_q   <= 1'b0;
        if (f_on_q && !f_decided_q && !f_new && f_age_q >= 3'd3) begin
          f_due_q       <= 2'd2;
          f_given_due_q <= f_given_q || frame_o;
        end
      end else begin
        if (f_age_q != 3'd0 && f_age_q != 3'd7) f_age_q <= f_age_q + 3'd1;
        if (frame_o) f_given_q <= 1'b1;
      end
    end
  end
  always_comb begin
    assume (rst_i == !f_ran_q);
    if (rst_i) assume (!frame_start_i && !decision_i && !start_i && !composed_i && !verdict_i);
    if (f_new) assume (f_on_q && !f_decided_q && f_age_q >= 3'd4);
    if (start_i) assume (f_begins_q);
    if (composed_i) assume (f_composing_q);
    if (verdict_i) assume (f_judging_q);
  end

  always_comb if (f_ran_q) begin
    // Rule 1: sp_verdict begins with a frame that is to be judged, once, six clocks behind its
    // start or later, when it is free; and at once then.
    assert (frame_o == (f_age_q >= 3'd6 && f_on_q && !f_given_q && !f_begins_q && !f_judging_q));
    // Rule 2: restart_o says whether another frame began since the one before, or none was before.
    if (frame_o) assert (restart_o == f_off_q);
    // Rule 3: a frame is judged only if sp_verdict has begun with this very frame, and never while
    // another is. A frame whose limits are composed is not missed.
    if (decision_i && ready_o) assert (f_given && !f_begins_q && !f_composing_q && !f_judging_q);
    if (f_new && f_given_q && !f_begins_q && !f_composing_q) assert (ready_o);
    // Rule 4: sums are those of a judged frame from its decision to its verdict.
    assert (judging_o == f_judging_q && judge_o == f_judge_q);
    // The registers agree with that.
    assert (begins_q == f_begins_q);
    assert (known_q == (f_age_q >= 3'd6));
    assert (waits_q == (f_on_q && !f_given_q));
    assert (restart_o == f_off_q);
    for (int clock = 1; clock < EncoderDelay; clock++) begin
      assert (started_q[clock] == (32'(f_age_q) == clock));
    end
    if (f_age_q == '0) assert (!f_on_q && !f_begins_q && !f_composing_q && !ready_o);
    assert (f_due_q != 2'd3 && !((f_begins_q || f_composing_q) && f_judging_q));
    if (f_due_q != '0) assert (f_age_q != '0 && f_age_q + {1'b0, f_due_q} <= 3'd3);
    if (f_given_q) assert (f_on_q);
    if (ready_o) begin
      assert (!f_begins_q && !f_composing_q && !f_judging_q);
      assert (f_given_q || !f_on_q || f_age_q < 3'd3);
      if (f_due_q != '0) assert (f_given_due_q);
    end
    if (f_given_q && !f_begins_q && !f_composing_q && !f_decided_q) assert (ready_o);
  end
  // Rule 5: each decision is answered in the next clock: the frame is judged, or its sums are void,
  // or it is missed.
  always_ff @(posedge clk_i) if (f_ran_q) begin
    assert (missed_o == ($past(decision_i && !ready_o) && !$past(rst_i)));
    if ($past(decision_i && !rst_i)) assert (missed_o || judging_o || $past(ready_o && spoiled_i));
    cover (missed_o && judging_o);
    cover (judging_o && f_age_q == 3'd2 && f_on_q);  // a decision two clocks behind the next start
    cover (frame_o && restart_o && f_judge_q);
    cover (frame_o && !restart_o && f_decided_q);  // behind a frame that was missed
  end
`endif

endmodule

`default_nettype wire
