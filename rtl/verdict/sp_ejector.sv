// Drives an ejector: a pulse that begins delay_i counts of the encoder behind a bad part's place
// and lasts length_i counts.
//
// bad_i marks a place, the count place_i. The pin is 1 while the encoder's count is at least
// place + delay and less than place + delay + length, modulo 2^24, from six clocks later on; with
// delay 0 that is at once. Places wait in a queue of 2^LogDepth, and one more at its end; one that
// finds it full is lost, and lost_o says so. Places come in the order of the encoder, which counts
// up. delay_i counts in the clock of bad_i.
//
//   bad_i      _/1\_________________
//   ejector_o  __________________/1\     delay 0
`default_nettype none

module sp_ejector #(
  parameter int LogDepth = 5  // log2 of the places that can wait: 1..9
) (
  input  wire logic        clk_i,
  input  wire logic        rst_i,

  input  wire logic [22:0] delay_i,    // counts
  input  wire logic [15:0] length_i,   // counts; 0: no pulses
  input  wire logic [23:0] encoder_i,  // count

  input  wire logic        bad_i,
  input  wire logic [23:0] place_i,

  output logic             ejector_o,
  output logic             lost_o
);

  if (LogDepth < 1 || LogDepth > 9) begin : gen_log_depth
    log_depth_is_not_in_1_to_9 u_error ();
  end

  logic        full_n, waits, done, put_q;
  logic [23:0] place, put_place_q;
  logic [23:0] way_q;    // from the pulse's beginning to the encoder
  logic        aimed_q;  // way_q is that of the place in front

  sp_fifo #(
    .Width   (24),
    .LogDepth(LogDepth)
  ) u_places (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .s_valid_i(put_q),
    .s_ready_o(full_n),
    .s_data_i (put_place_q),
    .m_valid_o(waits),
    .m_ready_i(done),
    .m_data_o (place)
  );

  assign done = aimed_q && !way_q[23] && way_q >= {8'd0, length_i};

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      put_q     <= 1'b0;
      aimed_q   <= 1'b0;
      ejector_o <= 1'b0;
      lost_o    <= 1'b0;
    end else begin
      put_q     <= bad_i;
      aimed_q   <= waits && !done;
      ejector_o <= aimed_q && !way_q[23] && !done;
      lost_o    <= put_q && !full_n;
    end
  end
  always_ff @(posedge clk_i) begin
    put_place_q <= place_i + {1'b0, delay_i};
    way_q       <= encoder_i - place;
  end

endmodule

`default_nettype wire
