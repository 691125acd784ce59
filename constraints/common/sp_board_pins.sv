// sp_board behind a few pins, for place and route on parts with fewer pins than its buses have
// wires.
//
// A shift register feeds every input of the board. Another one collects every output (xor with the
// stage before). Each runs in the clock of its ports, and no path between them and the board is
// longer than a wire. The reports leave these registers out.
`default_nettype none

// The inputs, kept apart from the board. A tool that optimizes across registers would otherwise see
// that all inputs are one stream, so that no beat comes without a reset one clock before, and would
// remove whatever a reset keeps from working.
(* keep_hierarchy *)
module sp_pins_in #(
  parameter int Width = 2  // 2 or more
) (
  input  wire logic             clk_i,
  input  wire logic             d_i,
  output logic      [Width-1:0] q_o
);

  if (Width < 2) begin : gen_width
    width_is_less_than_2 u_error ();
  end

  always_ff @(posedge clk_i) q_o <= {q_o[Width-2:0], d_i};

endmodule

module sp_board_pins #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,
  parameter int MaxRows = sp_spec_pkg::MaxRows,
  parameter int PixelBits = sp_spec_pkg::PixelBits,
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,
  parameter bit Grey = 1'b1,
  parameter bit Runs = 1'b0,
  parameter bit Image = 1'b0,
  parameter bit Verdict = 1'b0,
  parameter int VerdictLogSections = 0,
  parameter bit Codes = 1'b0,
  parameter bit CodesMedian = 1'b0,
  parameter int CodeBits = sp_spec_pkg::CodeCodeBits
) (
  input  wire logic clk_i,
  input  wire logic video_i,
  output logic      video_o,
  input  wire logic bus_clk_i,
  input  wire logic bus_i,
  output logic      bus_o
);

  // Video clock, in: reset, valid, data, start, end, encoder; out: ready, triggers, ejector
  localparam int Data = Lanes * PixelBits;
  localparam int VideoIn = 1 + 1 + Data + 1 + 1 + 2;
  localparam int VideoOut = 3 + 32'(Verdict);
  // Bus clock, in: reset, packet ready, AXI4-Lite; out: packets, AXI4-Lite
  localparam int BusIn = 1 + 1 + 1 + 8 + 1 + 32 + 4 + 1 + 1 + 8 + 1;
  localparam int BusOut = 1 + 128 + 1 + 1 + 1 + 1 + 2 + 1 + 1 + 32 + 2;

  logic [VideoIn-1:0]  video_in;
  logic [VideoOut-1:0] video_out, video_out_q;
  logic [BusIn-1:0]    bus_in;
  logic [BusOut-1:0]   bus_out, bus_out_q;

  sp_pins_in #(
    .Width(VideoIn)
  ) u_video_in (
    .clk_i(clk_i),
    .d_i  (video_i),
    .q_o  (video_in)
  );

  sp_pins_in #(
    .Width(BusIn)
  ) u_bus_in (
    .clk_i(bus_clk_i),
    .d_i  (bus_i),
    .q_o  (bus_in)
  );

  always_ff @(posedge clk_i) begin
    video_out_q <= video_out ^ {video_out_q[VideoOut-2:0], video_out_q[VideoOut-1]};
  end

  always_ff @(posedge bus_clk_i) begin
    bus_out_q <= bus_out ^ {bus_out_q[BusOut-2:0], bus_out_q[BusOut-1]};
  end

  assign video_o = video_out_q[VideoOut-1];
  assign bus_o   = bus_out_q[BusOut-1];

  logic ejector;
  if (Verdict) begin : gen_ejector
    assign video_out[VideoOut-1] = ejector;
  end else begin : gen_no_ejector
    logic unused;
    assign unused = ejector;
  end

  sp_board #(
    .MaxColumns (MaxColumns),
    .MaxRows    (MaxRows),
    .PixelBits  (PixelBits),
    .Lanes      (Lanes),
    .Grey       (Grey),
    .Runs       (Runs),
    .Image      (Image),
    .Verdict    (Verdict),
    .VerdictLogSections(VerdictLogSections),
    .Codes      (Codes),
    .CodesMedian(CodesMedian),
    .CodeBits   (CodeBits)
  ) u_board (
    .clk_i              (clk_i),
    .rst_i              (video_in[0]),
    .s_axis_tvalid      (video_in[1]),
    .s_axis_tready      (video_out[0]),
    .s_axis_tdata       (video_in[2+:Data]),
    .s_axis_tuser       (video_in[Data+2]),
    .s_axis_tlast       (video_in[Data+3]),
    .encoder_a_i        (video_in[Data+4]),
    .encoder_b_i        (video_in[Data+5]),
    .projector_trigger_o(video_out[1]),
    .camera_trigger_o   (video_out[2]),
    .ejector_o          (ejector),
    .bus_clk_i          (bus_clk_i),
    .bus_rst_i          (bus_in[0]),
    .m_axis_tvalid      (bus_out[0]),
    .m_axis_tready      (bus_in[1]),
    .m_axis_tdata       (bus_out[1+:128]),
    .m_axis_tlast       (bus_out[129]),
    .s_axil_awvalid     (bus_in[2]),
    .s_axil_awready     (bus_out[130]),
    .s_axil_awaddr      (bus_in[3+:8]),
    .s_axil_wvalid      (bus_in[11]),
    .s_axil_wready      (bus_out[131]),
    .s_axil_wdata       (bus_in[12+:32]),
    .s_axil_wstrb       (bus_in[44+:4]),
    .s_axil_bvalid      (bus_out[132]),
    .s_axil_bready      (bus_in[48]),
    .s_axil_bresp       (bus_out[133+:2]),
    .s_axil_arvalid     (bus_in[49]),
    .s_axil_arready     (bus_out[135]),
    .s_axil_araddr      (bus_in[50+:8]),
    .s_axil_rvalid      (bus_out[136]),
    .s_axil_rready      (bus_in[58]),
    .s_axil_rdata       (bus_out[137+:32]),
    .s_axil_rresp       (bus_out[169+:2])
  );

endmodule

`default_nettype wire
