// Drives an ejector: a pulse that begins delay_i counts of the encoder behind a bad part's place
// and lasts length_i counts.
//
// bad_i marks a place, the count place_i. The pin is 1 while the encoder's count is at least
// place + delay and less than place + delay + length, modulo 2^32, from five clocks later on; with
// delay 0 that is at once. Places wait in a queue of 2^LogDepth; one that finds it full is lost, and
// lost_o says so. Places come in the order of the encoder, which counts up.
//
//   bad_i      _/1\_____________
//   ejector_o  ______________/1\     delay 0
`default_nettype none

module sp_ejector #(
  parameter int LogDepth = 3  // log2 of the places that can wait: 1..8
) (
  input  wire logic        clk_i,
  input  wire logic        rst_i,

  input  wire logic [31:0] delay_i,    // counts, less than 2^31
  input  wire logic [15:0] length_i,   // counts; 0: no pulses
  input  wire logic [31:0] encoder_i,  // count

  input  wire logic        bad_i,
  input  wire logic [31:0] place_i,

  output logic             ejector_o,
  output logic             lost_o
);

  if (LogDepth < 1 || LogDepth > 8) begin : gen_log_depth
    log_depth_is_not_in_1_to_8 u_error ();
  end

  logic        full_n, waits, done;
  logic [31:0] place, way_q;  // from the place to the pulse's beginning, and beyond
  logic        aimed_q;       // way_q is that of the place in front

  sp_fifo #(
    .Width   (32),
    .LogDepth(LogDepth)
  ) u_places (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .s_valid_i(bad_i),
    .s_ready_o(full_n),
    .s_data_i (place_i + delay_i),
    .m_valid_o(waits),
    .m_ready_i(done),
    .m_data_o (place)
  );

  assign done = aimed_q && !way_q[31] && way_q >= {16'd0, length_i};

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      aimed_q   <= 1'b0;
      ejector_o <= 1'b0;
      lost_o    <= 1'b0;
    end else begin
      aimed_q   <= waits && !done;
      ejector_o <= aimed_q && !way_q[31] && !done;
      lost_o    <= bad_i && !full_n;
    end
  end
  always_ff @(posedge clk_i) way_q <= encoder_i - place;

endmodule

`default_nettype wire
