// One pixel of the Gray-code decoder: binarization of a pair, running code bits, ambiguity window.
//
// State of a pixel, low bits first: 8 bits, the positive pixel; MaxBits code bits, plane p of m in
// bit m-1-p; MaxBits ambiguity bits in the same order. Every frame stores its pixel in the place of
// the positive. A frame that is a negative (negative_i) also sets the plane that weight_i marks:
//
//   B = (positive - pixel > threshold)  xor  the bit that above_i marks, of the plane before (or 0)
//   ambiguous = |positive - pixel| <= threshold
//
// Bits outside mask_i, left from another m, become 0.
//
// Timing: one pixel in every clock. A pixel and its state come in clock t. The threshold is read in
// t + 1, negative_i to mask_i in t + 2. The new state is valid in t + 3, the code word in t + 4.
`default_nettype none

module sp_gray_lane #(
  parameter int MaxBits = sp_spec_pkg::CodeCodeBits,  // 1..12
  // derived, do not set
  parameter int StateBits = sp_spec_pkg::PixelBits + 2 * MaxBits
) (
  input  wire logic                 clk_i,

  input  wire logic [7:0]           pixel_i,
  input  wire logic [StateBits-1:0] state_i,

  input  wire logic [7:0]           threshold_i,  // one clock later

  input  wire logic                 negative_i,   // this and the next three: two clocks later
  input  wire logic [MaxBits-1:0]   weight_i,
  input  wire logic [MaxBits-1:0]   above_i,
  input  wire logic [MaxBits-1:0]   mask_i,

  output logic      [StateBits-1:0] state_o,      // three clocks later
  input  wire logic                 clear_i,      // three clocks later: the code word becomes 0
  output logic      [15:0]          code_o        // four clocks later
);

  if (MaxBits < 1 || MaxBits > sp_spec_pkg::CodeCodeBits) begin : gen_max_bits
    max_bits_is_not_in_1_to_12 u_error ();
  end

  // --- Difference of the pair ---
  logic signed [8:0]  difference_q;
  logic [7:0]         pixel_q, pixel_q2;
  logic [MaxBits-1:0] planes_q, planes_q2, ambiguous_q, ambiguous_q2;

  always_ff @(posedge clk_i) begin
    difference_q <= {1'b0, state_i[7:0]} - {1'b0, pixel_i};
    {pixel_q, planes_q, ambiguous_q} <= {pixel_i, state_i[8+:MaxBits], state_i[8+MaxBits+:MaxBits]};
  end

  // --- Binarization (4.15) ---
  // lit for certain, dark for certain: the signs of threshold -/+ difference
  logic               lit, dark;
  logic [8:0]         unused_lit, unused_dark;
  logic               lit_q, dark_q;

  assign {lit, unused_lit}   = {2'b00, threshold_i} - 10'(difference_q);
  assign {dark, unused_dark} = {2'b00, threshold_i} + 10'(difference_q);

  always_ff @(posedge clk_i) begin
    lit_q  <= lit;
    dark_q <= dark;
    {pixel_q2, planes_q2, ambiguous_q2} <= {pixel_q, planes_q, ambiguous_q};
  end

  // --- Bits of the plane (4.17, 4.16) ---
  logic               value;
  logic [MaxBits-1:0] kept;  // planes that this frame leaves as they are
  logic [MaxBits-1:0] set_plane, set_ambiguous;
  logic [7:0]         pixel_q3;
  logic [MaxBits-1:0] planes_q3, ambiguous_q3;

  assign value         = lit_q ^ |(planes_q2 & above_i);
  assign kept          = mask_i & ~(negative_i ? weight_i : MaxBits'(0));
  assign set_plane     = negative_i && value ? weight_i : MaxBits'(0);
  assign set_ambiguous = negative_i && !lit_q && !dark_q ? weight_i : MaxBits'(0);

  always_ff @(posedge clk_i) begin
    pixel_q3     <= pixel_q2;
    planes_q3    <= planes_q2 & kept | set_plane;
    ambiguous_q3 <= ambiguous_q2 & kept | set_ambiguous;
  end

  assign state_o = {ambiguous_q3, planes_q3, pixel_q3};

  // --- The code word: measurable where at most one plane is ambiguous ---
  logic measurable;

  assign measurable = (ambiguous_q3 & (ambiguous_q3 - MaxBits'(1))) == MaxBits'(0);

  always_ff @(posedge clk_i) begin
    if (clear_i) code_o <= '0;
    else code_o <= {measurable, 15'(planes_q3)};
  end

`ifdef FORMAL
  // Inputs, as far back as they are needed
  logic [7:0]           f_pixel1_q, f_pixel2_q, f_pixel3_q, f_threshold2_q, f_threshold3_q;
  logic [StateBits-1:0] f_state1_q, f_state2_q, f_state3_q, f_out4_q;
  logic [3*MaxBits:0]   f_frame3_q;
  logic                 f_clear4_q;
  logic [2:0]           f_clocks_q = 3'd0;  // up to 4
  always_ff @(posedge clk_i) begin
    {f_pixel3_q, f_pixel2_q, f_pixel1_q} <= {f_pixel2_q, f_pixel1_q, pixel_i};
    {f_state3_q, f_state2_q, f_state1_q} <= {f_state2_q, f_state1_q, state_i};
    {f_threshold3_q, f_threshold2_q}     <= {f_threshold2_q, threshold_i};
    f_frame3_q                           <= {negative_i, weight_i, above_i, mask_i};
    {f_clear4_q, f_out4_q}               <= {clear_i, state_o};
    if (!f_clocks_q[2]) f_clocks_q <= f_clocks_q + 3'd1;
  end
  // At most one plane is the frame's own, at most one is the plane before it; both are among the m.
  always_comb begin
    assume ((weight_i & (weight_i - MaxBits'(1))) == '0 &&
            (above_i & (above_i - MaxBits'(1))) == '0);
    assume ((weight_i & ~mask_i) == '0 && (above_i & ~mask_i) == '0);
  end

  // Method, section 4: grey values of the pair, G of (4.15), phi, B of (4.17)
  logic               f_negative, f_g, f_phi, f_b;
  logic [MaxBits-1:0] f_weight, f_above, f_mask, f_planes, f_ambiguous;
  logic [9:0]         f_positive_grey, f_negative_grey, f_threshold;
  assign {f_negative, f_weight, f_above, f_mask} = f_frame3_q;
  assign f_positive_grey = 10'(f_state3_q[7:0]);
  assign f_negative_grey = 10'(f_pixel3_q);
  assign f_threshold     = 10'(f_threshold3_q);
  assign f_g         = f_positive_grey > f_negative_grey + f_threshold;
  assign f_phi       = !f_g && f_negative_grey <= f_positive_grey + f_threshold;
  assign f_planes    = f_state3_q[8+:MaxBits];
  assign f_ambiguous = f_state3_q[8+MaxBits+:MaxBits];
  assign f_b         = f_g != ((f_planes & f_above) != '0);

  // Any one plane
  (* anyconst *) logic [3:0] f_plane;
  logic f_one;
  always_comb begin
    f_one = f_out4_q[8+MaxBits+:MaxBits] == '0;
    for (int i = 0; i < MaxBits; i++)
      if (f_out4_q[8+MaxBits+:MaxBits] == MaxBits'(1) << i) f_one = 1'b1;
    assume (f_plane < 4'(MaxBits));
    if (f_clocks_q >= 3'd3) begin
      // Rule 1: the pixel takes the place of the positive.
      assert (state_o[7:0] == f_pixel3_q);
      // Rule 2: a negative sets its own plane to B and phi. Every other plane of the m stays as it
      // is; the planes beyond are 0.
      if (!f_mask[f_plane]) begin
        assert (!state_o[8+f_plane] && !state_o[8+MaxBits+f_plane]);
      end else if (f_negative && f_weight[f_plane]) begin
        assert (state_o[8+f_plane] == f_b && state_o[8+MaxBits+f_plane] == f_phi);
      end else begin
        assert (state_o[8+f_plane] == f_planes[f_plane] &&
                state_o[8+MaxBits+f_plane] == f_ambiguous[f_plane]);
      end
    end
    // Rule 3: the code consists of the planes and is measurable where at most one of them is
    // ambiguous (4.16).
    if (f_clocks_q[2]) begin
      if (f_clear4_q) assert (code_o == '0);
      else begin
        assert (code_o[14:0] == 15'(f_out4_q[8+:MaxBits]));
        assert (code_o[15] == f_one);
      end
    end
  end
  always_ff @(posedge clk_i) if (f_clocks_q[2]) begin
    cover (f_negative && f_phi && !f_clear4_q && !code_o[15]);
  end
`endif

endmodule

`default_nettype wire
