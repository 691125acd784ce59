// A first frame through camera_to_dma: sets up the registers, sends one image of 8 x 4 pixels, and
// prints the packet that comes out.
`default_nettype none

module first_frame_tb;

  logic         reset = 1'b1;
  logic         pixel_clk = 1'b0, bus_clk = 1'b0;
  logic         valid = 1'b0, frame_start = 1'b0, line_end = 1'b0;
  logic [31:0]  pixels = '0;
  logic         dma_valid, dma_last;
  logic [127:0] dma_data;
  logic         awvalid = 1'b0, awready, wvalid = 1'b0, wready, bvalid;
  logic         arvalid = 1'b0, arready, rvalid;
  logic [7:0]   address = '0;
  logic [31:0]  wdata = '0, rdata;
  logic [1:0]   bresp, rresp, triggers;

  always #3.307 pixel_clk = !pixel_clk;  // 151.2 MHz
  always #8 bus_clk = !bus_clk;          // 62.5 MHz

  logic unused_ejector;
  camera_to_dma u_design (
    .reset_i             (reset),
    .pixel_clk_i         (pixel_clk),
    .camera_valid_i      (valid),
    .camera_pixels_i     (pixels),
    .camera_frame_start_i(frame_start),
    .camera_line_end_i   (line_end),
    .encoder_i           (2'b00),
    .projector_trigger_o (triggers[0]),
    .camera_trigger_o    (triggers[1]),
    .ejector_o           (unused_ejector),
    .bus_clk_i           (bus_clk),
    .dma_valid_o         (dma_valid),
    .dma_ready_i         (1'b1),
    .dma_data_o          (dma_data),
    .dma_last_o          (dma_last),
    .s_axil_awvalid      (awvalid),
    .s_axil_awready      (awready),
    .s_axil_awaddr       (address),
    .s_axil_wvalid       (wvalid),
    .s_axil_wready       (wready),
    .s_axil_wdata        (wdata),
    .s_axil_wstrb        (4'b1111),
    .s_axil_bvalid       (bvalid),
    .s_axil_bready       (1'b1),
    .s_axil_bresp        (bresp),
    .s_axil_arvalid      (arvalid),
    .s_axil_arready      (arready),
    .s_axil_araddr       (address),
    .s_axil_rvalid       (rvalid),
    .s_axil_rready       (1'b1),
    .s_axil_rdata        (rdata),
    .s_axil_rresp        (rresp)
  );

  task automatic write_register(input logic [7:0] where, input logic [31:0] value);
    @(negedge bus_clk);
    address = where;
    wdata   = value;
    awvalid = 1'b1;
    wvalid  = 1'b1;
    @(negedge bus_clk);  // both are ready while no access is under way
    awvalid = 1'b0;
    wvalid  = 1'b0;
    while (!bvalid) @(negedge bus_clk);
    if (bresp != 2'b00) $fatal(1, "the board refused to write %h to %h", value, where);
  endtask

  task automatic read_register(input logic [7:0] where, output logic [31:0] value);
    @(negedge bus_clk);
    address = where;
    arvalid = 1'b1;
    @(negedge bus_clk);
    arvalid = 1'b0;
    while (!rvalid) @(negedge bus_clk);
    if (rresp != 2'b00) $fatal(1, "the board refused to read %h", where);
    value = rdata;
  endtask

  task automatic send_beat(input logic [31:0] four_pixels, input logic first, input logic last);
    @(negedge pixel_clk);
    valid       = 1'b1;
    pixels      = four_pixels;
    frame_start = first;
    line_end    = last;
    @(negedge pixel_clk);
    valid = 1'b0;
  endtask

  // The packet, beat by beat
  int           beat = 0;
  logic [511:0] header;

  always @(posedge bus_clk) begin
    if (dma_valid) begin
      if (beat < 4) header[128*beat+:128] = dma_data;
      else if (dma_last) begin
        $display("trailer: status %0d", dma_data[sp_spec_pkg::TrailerStatusLsb+:32]);
        $finish;
      end else begin
        for (int k = 0; k < 4; k++) begin
          $display("column %0d: m0 %0d, m1 %0d", 4 * (beat - 4) + k + 1,
                   dma_data[32*k+sp_spec_pkg::BinaryM0Lsb+:sp_spec_pkg::BinaryM0Bits],
                   dma_data[32*k+sp_spec_pkg::BinaryM1Lsb+:sp_spec_pkg::BinaryM1Bits]);
        end
      end
      if (beat == 3) begin
        $display("header: frame %0d, %0d x %0d, %0d bytes of payload",
                 header[sp_spec_pkg::HeaderSequenceLsb+:64],
                 header[sp_spec_pkg::HeaderColumnsLsb+:16], header[sp_spec_pkg::HeaderRowsLsb+:16],
                 header[sp_spec_pkg::HeaderPayloadSizeLsb+:32]);
      end
      beat++;
    end
  end

  logic [31:0] word;

  initial begin
    #500 reset = 1'b0;
    #500;

    // 1. Is it this board, built from this specification?
    read_register(sp_spec_pkg::RegId, word);
    if (word != sp_spec_pkg::Magic) $fatal(1, "no selfproj board");
    read_register(sp_spec_pkg::RegSpecHash, word);
    if (word != sp_spec_pkg::SpecHash) $fatal(1, "another specification");
    // 2. Settings: 8 columns, 4 rows; mode binary, threshold 100
    write_register(sp_spec_pkg::RegSize, 32'd8 << sp_spec_pkg::RegSizeColumnsLsb |
                                         32'd4 << sp_spec_pkg::RegSizeRowsLsb);
    write_register(sp_spec_pkg::RegMeasure, 32'd100 << sp_spec_pkg::RegMeasureThresholdLsb |
                                            32'd0 << sp_spec_pkg::RegMeasureModeLsb);
    // 3. Run
    write_register(sp_spec_pkg::RegControl, 32'd1 << sp_spec_pkg::RegControlRunLsb);
    // 4. A frame: row 2 is lit in columns 1 to 4, row 3 in columns 4 to 8
    send_beat(32'h00000000, 1'b1, 1'b0);
    send_beat(32'h00000000, 1'b0, 1'b1);
    send_beat(32'hFFFFFFFF, 1'b0, 1'b0);
    send_beat(32'h00000000, 1'b0, 1'b1);
    send_beat(32'hFF000000, 1'b0, 1'b0);
    send_beat(32'hFFFFFFFF, 1'b0, 1'b1);
    send_beat(32'h00000000, 1'b0, 1'b0);
    send_beat(32'h00000000, 1'b0, 1'b1);
    // 5. The packet is printed above as it comes.
    #20000 $fatal(1, "no packet came");
  end

endmodule

`default_nettype wire
