// Gathers the pixels that a camera brings side by side in one clock (its taps) into beats of four.
//
// Guarantees: byte i of a beat is pixel 4n + i of the line, where n counts the line's beats from 0.
// Pixels that do not fill a beat when clear_i comes are dropped, and the next pixel is the first of
// a line. Combinational: the beat is there in the clock of its last pixel. Nothing is stalled.
//
// Three taps, which fill three beats in four clocks:
//
//   clock      0   1   2   3   4   5
//   take_i    /1111111111111111111111
//   pixels_i  <0..2><3..5><6..8>...      one group a clock
//   full_o    ____/11111111111\___/11
//   beat_o    ----<0..3><4..7><8..11>   in clocks 1, 2, 3; clock 4 brings 12..14, no beat
`default_nettype none

module sp_tap_gather #(
  parameter int Taps = 3  // 1, 2 or 3
) (
  input  wire logic              clk_i,
  input  wire logic              rst_i,     // active high, synchronous
  input  wire logic              take_i,    // Taps pixels of a line
  input  wire logic              clear_i,   // no line; not together with take_i
  input  wire logic [8*Taps-1:0] pixels_i,  // leftmost pixel in 7..0
  output logic                   full_o,    // this clock completes a beat
  output logic      [31:0]       beat_o     // leftmost pixel in 7..0
);

  if (Taps < 1 || Taps > 3) begin : gen_taps
    taps_is_not_in_1_to_3 u_error ();
  end

  localparam int Kept = Taps == 2 ? 2 : 3;  // most pixels that can wait

  logic [8*Kept-1:0]        kept_q;  // the last pixels, the newest in the upper bits
  logic [1:0]               fill_q;  // how many of them wait
  logic [8*(Kept+Taps)-1:0] all;     // they and those of this clock

  assign all = {pixels_i, kept_q};

  always_ff @(posedge clk_i) begin
    if (rst_i || clear_i) fill_q <= 2'd0;
    else if (take_i) fill_q <= fill_q + 2'(Taps);
    if (take_i) kept_q <= all[8*Taps+:8*Kept];
  end

  if (Taps == 3) begin : gen_three
    assign full_o = take_i && fill_q != 2'd0;
    always_comb begin
      case (fill_q)
        2'd1: beat_o = all[16+:32];
        2'd2: beat_o = all[8+:32];
        default: beat_o = all[0+:32];
      endcase
    end
  end else begin : gen_dividing
    assign full_o = take_i && fill_q == 2'(4 - Taps);
    assign beat_o = all;
  end

`ifdef FORMAL
  // The pixel at any place of the line, modulo 32
  (* anyconst *) logic [4:0] f_mark;
  logic [4:0] f_count_q;  // pixels of the line
  logic [7:0] f_pixel_q;  // the pixel at f_mark, once it has come
  logic [4:0] f_age, f_place;
  logic       f_past_q = 1'b0;

  always_comb assume (!(take_i && clear_i));
  always_comb if (!f_past_q) assume (rst_i);

  always_ff @(posedge clk_i) begin
    f_past_q <= 1'b1;
    if (rst_i || clear_i) f_count_q <= 5'd0;
    else if (take_i) f_count_q <= f_count_q + 5'(Taps);
    for (int i = 0; i < Taps; i++) begin
      if (take_i && f_count_q + 5'(i) == f_mark) f_pixel_q <= pixels_i[8*i+:8];
    end
  end
  assign f_age   = f_count_q - f_mark;  // 1: it is the newest
  assign f_place = f_mark - f_count_q + 5'(fill_q);  // its byte in the beat of this clock

  always_comb if (f_past_q) begin
    // Rule 1: what waits is the part of the line that no beat has taken.
    assert (fill_q == f_count_q[1:0]);
    if (Taps == 2) assert (!fill_q[0]);
    // Rule 2: pixels wait in the order in which they came.
    for (int d = 1; d <= Kept; d++) begin
      if (f_age == 5'(d) && 2'(d) <= fill_q) assert (kept_q[8*(Kept-d)+:8] == f_pixel_q);
    end
    // Rule 3: a beat is complete as soon as four pixels are there, and not sooner.
    assert (full_o == (take_i && 4'(fill_q) + 4'(Taps) >= 4'd4));
    // Rule 4: each byte of a beat is the pixel of its place.
    for (int i = 0; i < 4; i++) begin
      if (full_o && f_place == 5'(i)) begin
        if (2'(i) < fill_q) assert (beat_o[8*i+:8] == f_pixel_q);
        for (int k = 0; k < Taps; k++) begin
          if (5'(i) == 5'(fill_q) + 5'(k)) assert (beat_o[8*i+:8] == pixels_i[8*k+:8]);
        end
      end
    end
  end
  always_ff @(posedge clk_i) if (f_past_q) begin
    cover (full_o && f_mark == 5'd6 && f_place == 5'd2);
    cover (clear_i && fill_q != 2'd0);
  end
`endif

endmodule

`default_nettype wire
