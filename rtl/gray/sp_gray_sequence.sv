// Sequence rules of the Gray-code decoder: the role of a frame, from its pattern index and the
// frames before it.
//
// A frame with the expected index is taken. Any other frame, and the first one after restart_i or
// lost_i, is taken only if its index is 0. Codes are due from a negative once bits_i pairs have
// come in succession, starting with index 0.
//
// Timing: the outputs are valid from the clock after start_i on. restart_i counts before a frame
// that starts in the same clock. lost_i belongs to the frame that starts in its clock, or to the
// open one: that frame stays what it is, but the frame after it no longer follows. A frame whose
// codes were due while busy_i was high is refused; it counts as a frame with the wrong index.
`default_nettype none

module sp_gray_sequence #(
  parameter int MaxBits = sp_spec_pkg::CodeCodeBits  // 1..12
) (
  input  wire logic               clk_i,
  input  wire logic               rst_i,

  input  wire logic               start_i,
  input  wire logic               decode_i,   // with start_i: decode this frame
  input  wire logic [15:0]        pattern_i,
  input  wire logic [3:0]         bits_i,     // m, 1..MaxBits
  input  wire logic               restart_i,
  input  wire logic               lost_i,
  input  wire logic               busy_i,     // with start_i: codes of this frame cannot be taken

  output logic                    refused_o,  // with start_i: codes are due but cannot be taken
  output logic                    negative_o,
  output logic                    due_o,      // the codes of the frame are to be sent
  output logic      [MaxBits-1:0] weight_o,   // one bit: the plane's place in the code
  output logic      [MaxBits-1:0] above_o,    // one bit: the plane before; 0 in plane 0
  output logic      [MaxBits-1:0] mask_o      // the m planes
);

  if (MaxBits < 1 || MaxBits > sp_spec_pkg::CodeCodeBits) begin : gen_max_bits
    max_bits_is_not_in_1_to_12 u_error ();
  end

  logic [4:0]         next_q;   // expected index; 0 while waiting for plane 0
  logic [3:0]         pairs_q;  // pairs in succession, up to m
  logic [4:0]         index;
  logic               fresh, follows, taken, negative, enough;
  logic [3:0]         pairs_up;
  logic [MaxBits-1:0] weight, mask;

  assign index    = pattern_i[4:0];
  assign fresh    = restart_i || pattern_i != 16'(next_q);
  assign follows  = decode_i && (!fresh || pattern_i == 16'd0);
  assign taken    = follows && !refused_o;
  assign negative = taken && index[0];
  assign enough   = pairs_up == bits_i;
  assign pairs_up = pairs_q == bits_i ? pairs_q : pairs_q + 4'd1;
  assign refused_o = start_i && busy_i && follows && index[0] && enough;
  assign weight   = MaxBits'(1) << (bits_i - 4'd1 - index[4:1]);
  assign mask     = ~({MaxBits{1'b1}} << bits_i);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      next_q     <= '0;
      pairs_q    <= '0;
      negative_o <= 1'b0;
      due_o      <= 1'b0;
    end else if (start_i) begin
      negative_o <= negative;
      due_o      <= negative && enough;
      next_q     <= !taken || lost_i || index == {bits_i, 1'b0} - 5'd1 ? 5'd0 : index + 5'd1;
      if (!taken || lost_i || fresh) pairs_q <= '0;
      else if (negative) pairs_q <= pairs_up;
    end else if (restart_i || lost_i) begin
      next_q  <= '0;
      pairs_q <= '0;
    end
  end

  always_ff @(posedge clk_i) begin
    if (start_i) begin
      weight_o <= weight;
      above_o  <= weight << 1 & mask;
      mask_o   <= mask;
    end
  end

`ifdef FORMAL
  // One reset at the beginning; m changes only with a restart.
  logic f_ran_q = 1'b0;
  logic [3:0] f_bits_q;
  always_ff @(posedge clk_i) {f_ran_q, f_bits_q} <= {1'b1, bits_i};
  always_comb begin
    assume (rst_i == !f_ran_q);
    assume (bits_i >= 4'd1 && bits_i <= 4'(MaxBits));
    if (f_ran_q && bits_i != f_bits_q) assume (restart_i);
  end

  // Frames taken in succession, starting with index 0, up to 2 m; and the index that comes next.
  logic [4:0] f_length_q, f_length, f_grown, f_next_q, f_next;
  logic       f_goes_on, f_taken, f_due, f_refused;
  assign f_length  = restart_i ? 5'd0 : f_length_q;
  assign f_next    = restart_i ? 5'd0 : f_next_q;
  assign f_goes_on = f_length != 5'd0 && pattern_i == 16'(f_next);
  assign f_grown   = !f_goes_on ? 5'd1 : f_length == {bits_i, 1'b0} ? f_length : f_length + 5'd1;
  assign f_due     = decode_i && (f_goes_on || pattern_i == '0) && pattern_i[0] &&
                     f_grown == {bits_i, 1'b0};
  assign f_refused = f_due && busy_i;
  assign f_taken   = decode_i && (f_goes_on || pattern_i == '0) && !f_refused;
  logic f_due_q, f_negative_q, f_known_q, f_weight_right_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      {f_length_q, f_next_q, f_due_q, f_negative_q, f_known_q} <= '0;
    end else if (start_i) begin
      f_length_q   <= f_taken && !lost_i ? f_grown : 5'd0;
      f_next_q     <= !f_taken || lost_i || pattern_i[4:0] == {bits_i, 1'b0} - 5'd1 ? 5'd0 :
                      pattern_i[4:0] + 5'd1;
      f_due_q      <= f_due && f_taken;
      f_negative_q <= f_taken && pattern_i[0];
      f_known_q    <= 1'b1;
    end else if (restart_i || lost_i) begin
      {f_length_q, f_next_q} <= '0;
    end
  end

  always_comb if (f_ran_q && !rst_i) begin
    // Rule 1: codes are due from a negative exactly when m pairs have come in succession from index
    // 0.
    assert (due_o == f_due_q);
    assert (negative_o == f_negative_q);
    // Rule 2: a frame is refused only if its codes would be due and cannot be taken.
    assert (refused_o == (start_i && f_refused));
    if (due_o) assert (negative_o);
    // The registers say the same in other words.
    assert (next_q == f_next_q);
    assert (pairs_q == f_length_q[4:1]);
    if (!restart_i) begin
      assert (f_length_q <= {bits_i, 1'b0} && f_next_q < {bits_i, 1'b0});
      if (f_length_q < {bits_i, 1'b0}) assert (f_next_q == f_length_q);
      if (f_length_q == '0) assert (f_next_q == '0);
    end
  end
  // Rule 3: plane p of m weighs 2^(m-1-p) (4.18), and the plane before it twice as much.
  always_ff @(posedge clk_i) if (f_ran_q && !$past(rst_i)) begin
    if ($past(start_i && f_taken)) begin
      assert (weight_o << ($past(pattern_i[4:1])) == MaxBits'(1) << ($past(bits_i) - 4'd1));
      assert (above_o == ($past(pattern_i[4:1]) == 4'd0 ? MaxBits'(0) : weight_o << 1));
      assert (mask_o == MaxBits'((1 << $past(bits_i)) - 1));
    end
    cover (due_o && mask_o == MaxBits'(3) && above_o == '0);
    cover ($past(refused_o));
  end
`endif

endmodule

`default_nettype wire
