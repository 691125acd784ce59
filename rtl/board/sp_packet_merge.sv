// Joins the packets of all kinds into one stream, in the bus clock: moments go first, then codes,
// then raw lines.
//
// Guarantees: packets are not mixed, and the packets of each kind keep their order. A kind that the
// build does not have is left out together with its arbiter; its input is never ready. The latency
// is one sp_packet_arbiter for each further kind. Nothing overflows, since what is not taken waits.
`default_nettype none

module sp_packet_merge #(
  parameter bit Image = 1'b1,
  parameter bit Codes = 1'b0
) (
  input  wire logic         clk_i,
  input  wire logic         rst_i,

  input  wire logic         moments_valid_i,
  output logic              moments_ready_o,
  input  wire logic         moments_last_i,
  input  wire logic [127:0] moments_data_i,

  input  wire logic         codes_valid_i,
  output logic              codes_ready_o,
  input  wire logic         codes_last_i,
  input  wire logic [127:0] codes_data_i,

  input  wire logic         image_valid_i,
  output logic              image_ready_o,
  input  wire logic         image_last_i,
  input  wire logic [127:0] image_data_i,

  output logic              m_valid_o,
  input  wire logic         m_ready_i,
  output logic              m_last_o,
  output logic      [127:0] m_data_o
);

  // --- Codes and raw lines ---
  logic         lines_valid, lines_ready, lines_last;
  logic [127:0] lines_data;

  if (Codes && Image) begin : gen_lines
    sp_packet_arbiter #(
      .Width(128)
    ) u_line_arbiter (
      .clk_i          (clk_i),
      .rst_i          (rst_i),
      .first_valid_i  (codes_valid_i),
      .first_ready_o  (codes_ready_o),
      .first_last_i   (codes_last_i),
      .first_data_i   (codes_data_i),
      .second_valid_i (image_valid_i),
      .second_ready_o (image_ready_o),
      .second_last_i  (image_last_i),
      .second_data_i  (image_data_i),
      .m_axis_tvalid_o(lines_valid),
      .m_axis_tready_i(lines_ready),
      .m_axis_tlast_o (lines_last),
      .m_axis_tdata_o (lines_data)
    );
  end else begin : gen_one_kind
    logic unused;
    assign unused        =
        ^{codes_valid_i, codes_last_i, codes_data_i, image_valid_i, image_last_i, image_data_i};
    assign lines_valid   = Codes ? codes_valid_i : image_valid_i;
    assign lines_last    = Codes ? codes_last_i : image_last_i;
    assign lines_data    = Codes ? codes_data_i : image_data_i;
    assign codes_ready_o = Codes && lines_ready;
    assign image_ready_o = !Codes && lines_ready;
  end

  // --- Moments, which go before codes and raw lines ---
  if (Codes || Image) begin : gen_arbiter
    sp_packet_arbiter #(
      .Width(128)
    ) u_arbiter (
      .clk_i          (clk_i),
      .rst_i          (rst_i),
      .first_valid_i  (moments_valid_i),
      .first_ready_o  (moments_ready_o),
      .first_last_i   (moments_last_i),
      .first_data_i   (moments_data_i),
      .second_valid_i (lines_valid),
      .second_ready_o (lines_ready),
      .second_last_i  (lines_last),
      .second_data_i  (lines_data),
      .m_axis_tvalid_o(m_valid_o),
      .m_axis_tready_i(m_ready_i),
      .m_axis_tlast_o (m_last_o),
      .m_axis_tdata_o (m_data_o)
    );
  end else begin : gen_moments_only
    logic unused;
    assign unused          = ^{clk_i, rst_i, lines_valid, lines_last, lines_data};
    assign lines_ready     = 1'b0;
    assign m_valid_o       = moments_valid_i;
    assign m_last_o        = moments_last_i;
    assign m_data_o        = moments_data_i;
    assign moments_ready_o = m_ready_i;
  end

endmodule

`default_nettype wire
