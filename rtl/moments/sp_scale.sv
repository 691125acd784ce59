// Pipelined multiplier x * k without a multiplier block: radix-4 digits of k, one adder per stage.
//
// Guarantees: product_o = x_i * k_i, four clocks with move_i after x_i, one product per clock. k_i
// comes one clock with move_i after its x_i.
`default_nettype none

module sp_scale #(
  parameter int XBits = 18,  // 1 or more
  parameter int KBits = 10  // 1..12
) (
  input  wire logic                   clk_i,
  input  wire logic                   move_i,  // nothing moves without it
  input  wire logic [XBits-1:0]       x_i,
  input  wire logic [KBits-1:0]       k_i,
  output logic      [XBits+KBits-1:0] product_o
);

  if (XBits < 1) begin : gen_xbits
    xbits_is_less_than_1 u_error ();
  end
  if (KBits < 1 || KBits > 12) begin : gen_k_bits
    k_bits_is_not_in_1_to_12 u_error ();
  end

  localparam int Digits = (KBits + 1) / 2;
  localparam int Pairs = (Digits + 1) / 2;
  localparam int PBits = XBits + KBits;

  logic [2*Digits-1:0] k;
  logic [XBits-1:0]    x1_q;
  logic [XBits+1:0]    triple1_q;

  assign k = {{(2 * Digits - KBits) {1'b0}}, k_i};

  // Stage 1: three times x
  always_ff @(posedge clk_i) begin
    if (move_i) begin
      x1_q      <= x_i;
      triple1_q <= {2'b00, x_i} + {1'b0, x_i, 1'b0};
    end
  end

  // Stage 2: the multiple of x for each digit, at its place
  logic [PBits*Digits-1:0] digit2_q;
  for (genvar d = 0; d < Digits; d++) begin : gen_digit
    logic [1:0]       digit;
    logic [XBits+1:0] multiple;
    assign digit    = k[2*d+:2];
    // A multiplexer with a 0 would become a separate reset for each digit, so there is none.
    assign multiple = {(XBits + 2) {digit == 2'd1}} & {2'b00, x1_q} |
                      {(XBits + 2) {digit == 2'd2}} & {1'b0, x1_q, 1'b0} |
                      {(XBits + 2) {digit == 2'd3}} & triple1_q;
    always_ff @(posedge clk_i) begin
      if (move_i) digit2_q[d*PBits+:PBits] <= PBits'({{PBits{1'b0}}, multiple} << (2 * d));
    end
  end

  // Stage 3: sums of two digits; the last may be alone
  logic [PBits*Pairs-1:0] pair3_q;
  for (genvar p = 0; p < Pairs; p++) begin : gen_pair
    if (2 * p + 1 < Digits) begin : gen_two
      always_ff @(posedge clk_i) begin
        if (move_i) pair3_q[p*PBits+:PBits] <= digit2_q[2*p*PBits+:PBits] +
                                               digit2_q[(2*p+1)*PBits+:PBits];
      end
    end else begin : gen_one
      always_ff @(posedge clk_i) begin
        if (move_i) pair3_q[p*PBits+:PBits] <= digit2_q[2*p*PBits+:PBits];
      end
    end
  end

  // Stage 4: the sum of up to three pairs
  if (Pairs == 1) begin : gen_sum1
    always_ff @(posedge clk_i) if (move_i) product_o <= pair3_q[0*PBits+:PBits];
  end else if (Pairs == 2) begin : gen_sum2
    always_ff @(posedge clk_i) if (move_i) product_o <= pair3_q[0*PBits+:PBits] +
                                                        pair3_q[1*PBits+:PBits];
  end else begin : gen_sum3
    always_ff @(posedge clk_i) if (move_i) product_o <= pair3_q[0*PBits+:PBits] +
                                                        pair3_q[1*PBits+:PBits] +
                                                        pair3_q[2*PBits+:PBits];
  end

endmodule

`default_nettype wire
