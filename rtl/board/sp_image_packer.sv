// Raw image: packs the pixels of a line into 16-byte payload beats, leftmost in the lowest byte, zeros after the last.
//
// Beats that were not accepted (accept_i, four clocks after line_start_o) are dropped. A payload beat leaves eight clocks
// after the pixels that complete it. A line that breaks sends what came of it, then words_break_o.
`default_nettype none

module sp_image_packer (
  input  wire logic        clk_i,
  input  wire logic        rst_i,

  // Beats of sp_frame_tracker
  input  wire logic        image_i,  // the frame's image is wanted
  input  wire logic        beat_valid_i,
  input  wire logic [31:0] beat_pixels_i,
  input  wire logic [1:0]  beat_group_i,  // low bits of the group
  input  wire logic        beat_line_start_i,
  input  wire logic        beat_line_end_i,
  input  wire logic        break_i,

  output logic             line_start_o,  // asks for a packet, same clock as the beat
  output logic             break_o,       // breaks the line asked for, same clock as break_i
  input  wire logic        accept_i,

  output logic             words_valid_o,
  output logic [127:0]     words_data_o,
  output logic             words_break_o
);

  logic line_open_q;
  logic valid;

  assign valid        = beat_valid_i && image_i;
  assign line_start_o = valid && beat_line_start_i;
  assign break_o      = break_i && line_open_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) line_open_q <= 1'b0;
    else if (valid) line_open_q <= !beat_line_end_i;
    else if (break_i) line_open_q <= 1'b0;
  end

  // The beats wait for the header: stages 1 to 7. A break stands beside the beat it follows.
  logic [7:1]  valid_q;
  logic [7:2]  break_q;
  logic [7:1]  end_q;
  logic [31:0] pixels1_q, pixels2_q, pixels3_q, pixels4_q, pixels5_q, pixels6_q, pixels7_q;
  logic [1:0]  lane1_q, lane2_q, lane3_q, lane4_q, lane5_q, lane6_q, lane7_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q <= '0;
      break_q <= '0;
    end else begin
      valid_q <= {valid_q[6:5], valid_q[4] && accept_i, valid_q[3:1], valid};
      break_q <= {break_q[6:5], break_q[4] && accept_i, break_q[3:2], break_o};
    end
  end

  always_ff @(posedge clk_i) begin
    end_q <= {end_q[6:1], beat_line_end_i};
    {pixels1_q, lane1_q} <= {beat_pixels_i, beat_group_i};
    {pixels2_q, lane2_q} <= {pixels1_q, lane1_q};
    {pixels3_q, lane3_q} <= {pixels2_q, lane2_q};
    {pixels4_q, lane4_q} <= {pixels3_q, lane3_q};
    {pixels5_q, lane5_q} <= {pixels4_q, lane4_q};
    {pixels6_q, lane6_q} <= {pixels5_q, lane5_q};
    {pixels7_q, lane7_q} <= {pixels6_q, lane6_q};
  end

  // Stage 8: the word
  logic partial_q;  // words_data_o holds pixels that have not left
  logic whole;

  assign whole = valid_q[7] && (lane7_q == 2'd3 || end_q[7]);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      partial_q     <= 1'b0;
      words_valid_o <= 1'b0;
      words_break_o <= 1'b0;
    end else begin
      if (break_q[7]) partial_q <= 1'b0;
      else if (valid_q[7]) partial_q <= !whole;
      words_valid_o <= whole || break_q[7] && (valid_q[7] || partial_q);
      words_break_o <= break_q[7];
    end
  end

  always_ff @(posedge clk_i) begin
    if (valid_q[7]) begin
      case (lane7_q)
        2'd0:    words_data_o <= {96'd0, pixels7_q};
        2'd1:    words_data_o[63:32] <= pixels7_q;
        2'd2:    words_data_o[95:64] <= pixels7_q;
        default: words_data_o[127:96] <= pixels7_q;
      endcase
    end
  end

endmodule

`default_nettype wire
