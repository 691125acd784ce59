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

`ifdef FORMAL
  // Assumptions: one reset at the beginning. The encoder counts up, once in seven clocks at most.
  // Delay and length stand still. Places come at least four clocks apart, each behind the one
  // before and none ahead of the encoder. No more than four in a proof; and for the solver's
  // sake the encoder begins just before it wraps, and numbers are small.
  logic        f_ran_q = 1'b0;
  logic [23:0] f_encoder_q, f_encoder2_q, f_behind, f_step;
  logic [22:0] f_delay_q;
  logic [15:0] f_length_q;
  logic [3:0]  f_still_q, f_since_q;  // clocks since the last count, and the last place; 7 at most
  logic [2:0]  f_bad_q;               // bad_i, so many clocks ago
  logic [23:0] f_place1_q, f_place2_q, f_last_q;
  logic        f_any_q;               // a place came
  logic        f_full_q;              // four places came
  logic        f_refused_q;           // the queue was full one clock ago
  assign f_behind = encoder_i - place_i;
  assign f_step   = place_i - f_last_q;
  always_ff @(posedge clk_i) begin
    f_ran_q                     <= 1'b1;
    {f_encoder2_q, f_encoder_q} <= {f_encoder_q, encoder_i};
    {f_delay_q, f_length_q}     <= {delay_i, length_i};
    f_refused_q                 <= !full_n;
    {f_place2_q, f_place1_q}    <= {f_place1_q, place_i};
    if (bad_i) f_last_q <= place_i;
    if (rst_i) {f_still_q, f_since_q, f_bad_q, f_any_q} <= {8'h77, 4'b0};
    else begin
      f_still_q <= encoder_i != f_encoder_q ? 4'd1 : f_still_q == 4'd7 ? 4'd7 : f_still_q + 4'd1;
      f_since_q <= bad_i ? 4'd1 : f_since_q == 4'd7 ? 4'd7 : f_since_q + 4'd1;
      f_bad_q   <= {f_bad_q[1:0], bad_i};
      f_any_q   <= f_any_q || bad_i;
    end
  end
  always_comb begin
    assume (rst_i == !f_ran_q);
    if (rst_i) assume (!bad_i && encoder_i == 24'hFFFFFE);
    if (f_ran_q) begin
      assume (encoder_i == f_encoder_q || encoder_i == f_encoder_q + 24'd1 && f_still_q == 4'd7);
      assume (delay_i == f_delay_q && length_i == f_length_q);
      assume (delay_i < 23'd8 && length_i < 16'd8);
    end
    if (bad_i) begin
      assume (f_since_q >= 4'd4 && f_behind < 24'd8 && !f_full_q);
      if (f_any_q) assume (f_step != '0 && f_step < 24'd16);
    end
  end

  // The beginnings of the pulses of all places that were not lost, and where the encoder is in them
  logic [95:0] f_begin_q;
  logic [3:0]  f_there_q, f_now, f_in;  // of these places; the encoder is there, was two clocks ago
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_there_q, f_full_q} <= '0;
    else begin
      if (f_bad_q[1] && !lost_o) begin
        f_there_q <= {f_there_q[2:0], 1'b1};
        f_begin_q <= {f_begin_q[71:0], f_place2_q + {1'b0, f_delay_q}};
      end
      f_full_q <= f_full_q || f_there_q[2] && bad_i;
    end
  end
  for (genvar i = 0; i < 4; i++) begin : gen_f_place
    logic [23:0] way, was;
    assign way      = encoder_i - f_begin_q[24*i+:24];
    assign was      = f_encoder2_q - f_begin_q[24*i+:24];
    assign f_now[i] = f_there_q[i] && way < {8'd0, length_i};
    assign f_in[i]  = f_there_q[i] && was < {8'd0, length_i};
  end

  always_comb if (f_ran_q) begin
    // Rule 1: a place is lost only if the queue is full, and lost_o says so two clocks behind it.
    assert (lost_o == (f_bad_q[1] && f_refused_q));
    if (lost_o) assert ($countones(f_there_q) > 1 << LogDepth);
    // Rule 2: no pulse where no place has one.
    if (ejector_o) assert (f_in != '0);
    // Rule 3: none is left out: the pin is 1 wherever one has, from six clocks behind the count and
    // behind the place on.
    if (f_still_q >= 4'd6 && f_since_q >= 4'd6 && encoder_i == f_encoder_q) begin
      assert (ejector_o == (f_now != '0));
    end
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    cover (lost_o);
    cover (ejector_o && f_now == 4'b0001 && f_there_q == 4'b0011 && f_length_q == 16'd1);
    cover (ejector_o && f_begin_q[23:0] < 24'd2 && f_last_q == 24'hFFFFFF);
    cover (!ejector_o && f_still_q == 4'd7 && f_in == '0 && f_there_q == 4'b0011 &&
           gen_f_place[0].way[23] && !gen_f_place[1].way[23]);
  end
`endif

endmodule

`default_nettype wire
