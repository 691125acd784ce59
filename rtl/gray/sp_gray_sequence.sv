// Sequence rules of the Gray-code decoder: what a frame is to it, from its pattern index and from what came before.
//
// A frame whose index is not the next one, and the first after restart_i or lost_i, is taken only where its index is 0.
// Codes are due from a negative once bits_i pairs have come in succession from index 0.
//
// Timing: outputs stand from the clock after start_i on. restart_i counts before a frame that starts in the same clock;
// lost_i is of that frame, or of the one under way: it stays what it is, but the next one is no longer the next.
// A frame whose codes were due while busy_i is refused: it counts as not the next one.
`default_nettype none

module sp_gray_sequence #(
  parameter int MaxBits = sp_spec_pkg::CodeCodeBits
) (
  input  wire logic               clk_i,
  input  wire logic               rst_i,

  input  wire logic               start_i,
  input  wire logic               decode_i,   // with start_i: the frame is to be decoded
  input  wire logic [15:0]        pattern_i,
  input  wire logic [3:0]         bits_i,     // m, 1..MaxBits
  input  wire logic               restart_i,
  input  wire logic               lost_i,
  input  wire logic               busy_i,     // with start_i: no codes can be taken from this frame

  output logic                    refused_o,  // they would have been due (at once, with start_i)
  output logic                    negative_o,
  output logic                    due_o,      // its codes are to be sent
  output logic      [MaxBits-1:0] weight_o,   // one bit: the plane's in the code
  output logic      [MaxBits-1:0] above_o,    // that of the plane before; 0 in plane 0
  output logic      [MaxBits-1:0] mask_o      // the m planes
);

  logic [4:0]         next_q;   // index expected; 0 while waiting for plane 0
  logic [3:0]         pairs_q;  // in succession, up to m
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
  assign mask     = ~(~MaxBits'(0) << bits_i);

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

endmodule

`default_nettype wire
