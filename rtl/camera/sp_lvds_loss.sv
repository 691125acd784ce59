// Says when a lane of sp_lvds_sensor is lost: when too many of its words are wrong.
//
// A level rises by five with each wrong word and falls by one with each right word, down to 0. A wrong
// word that finds it at 27 or more means that the lane is lost.
//
// Guarantees: a lane is not lost before seven words have been wrong since it was aligned; so one whose
// words are right is never lost. It is lost with the seventh wrong word in a row, at the latest. With
// no more than one wrong word in six it stays.
//
// Overflow: none; the level ends at 31.
//
// Latency: lost_o comes one clock behind the word.
//
//   look_i   /111111111111111\_______   seven words in a row
//   wrong_i  /1111111111111\_________
//   lost_o   ______________/1\_______   the seventh was wrong, too
`default_nettype none

module sp_lvds_loss (
  input  wire logic clk_i,
  input  wire logic rst_i,
  input  wire logic aligned_i,  // low: the lane is in training
  input  wire logic look_i,     // a word of which it is known what it must be
  input  wire logic wrong_i,    // with it: it is another one
  output logic      lost_o      // pulse
);

  localparam logic [4:0] Wrong = 5'd5;
  localparam logic [4:0] Most = 5'd27;

  logic [4:0] level_q;

  always_ff @(posedge clk_i) begin
    lost_o <= 1'b0;
    if (rst_i || !aligned_i) level_q <= '0;
    else if (look_i) begin
      if (!wrong_i) level_q <= level_q == '0 ? '0 : level_q - 1'b1;
      else if (level_q < Most) level_q <= level_q + Wrong;
      else lost_o <= 1'b1;
    end
  end

`ifdef FORMAL
  logic f_past_q = 1'b0;
  always_ff @(posedge clk_i) f_past_q <= 1'b1;
  always_comb if (!f_past_q) assume (rst_i);

  logic [2:0] f_wrong_q;   // wrong words since the lane was aligned, at most 7
  logic [2:0] f_row_q;     // the last ones of them in a row, at most 7
  logic [2:0] f_apart_q;   // right words since the last wrong one, at most 5
  logic       f_seldom_q;  // there have always been five right ones between two wrong ones
  always_ff @(posedge clk_i) begin
    if (rst_i || !aligned_i) begin
      f_wrong_q  <= '0;
      f_row_q    <= '0;
      f_apart_q  <= 3'd5;
      f_seldom_q <= 1'b1;
    end else if (look_i) begin
      if (wrong_i && f_wrong_q != '1) f_wrong_q <= f_wrong_q + 1'b1;
      f_row_q <= !wrong_i ? '0 : f_row_q == '1 ? '1 : f_row_q + 1'b1;
      f_apart_q <= wrong_i ? '0 : f_apart_q == 3'd5 ? 3'd5 : f_apart_q + 1'b1;
      f_seldom_q <= f_seldom_q && !(wrong_i && f_apart_q != 3'd5);
    end
  end

  logic f_seven_q, f_row_of_seven_q, f_was_seldom_q;  // with the word of which lost_o tells
  always_ff @(posedge clk_i) begin
    f_seven_q        <= look_i && wrong_i && f_wrong_q >= 3'd6;
    f_row_of_seven_q <= aligned_i && !rst_i && look_i && wrong_i && f_row_q >= 3'd6;
    f_was_seldom_q   <= f_seldom_q && !(look_i && wrong_i && f_apart_q != 3'd5);
  end

  always_comb if (f_past_q) begin
    // Rule 1: no lane is lost before the seventh wrong word.
    if (lost_o) assert (f_seven_q);
    // Rule 2: the seventh wrong word in a row, and each one after it, says so.
    if (f_row_of_seven_q) assert (lost_o);
    // Rule 3: five right words between any two wrong ones keep the lane.
    if (f_was_seldom_q) assert (!lost_o);
    // The level agrees with that.
    if (f_wrong_q != '1) assert (level_q <= 5'(5 * f_wrong_q));
    assert (level_q >= (f_row_q >= 3'd6 ? Most : 5'(5 * f_row_q)));
    if (f_seldom_q) assert (level_q <= 5'd5 - 5'(f_apart_q));
    assert (f_apart_q <= 3'd5);
  end
  always_ff @(posedge clk_i) if (f_past_q) begin
    cover (lost_o && f_row_q == 3'd1);
    cover (f_seldom_q && f_wrong_q == 3'd2);
  end
`endif

endmodule

`default_nettype wire
