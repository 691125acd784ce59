// Plays the vectors of a co-simulation through camera_to_dma: writes the registers, sends the camera's beats with
// their pauses, and compares the packets with those of the co-simulation, but for time stamps, which count from another
// reset, and the check words over them.
//
//   selfproj-sim cosim --frames ... --vectors DIR
//   ./vectors +vectors=DIR
//
// The files are described in sim/cosim/vector_files.h. camera_to_dma takes images up to 512 x 127.
`default_nettype none

module vectors_tb;

  logic         reset = 1'b1;
  logic         pixel_clk = 1'b0, bus_clk = 1'b0;
  logic         valid = 1'b0, frame_start = 1'b0, line_end = 1'b0;
  logic [31:0]  pixels = '0;
  logic         dma_valid, dma_last;
  logic [127:0] dma_data;
  logic         wvalid = 1'b0, bvalid;
  logic [7:0]   address = '0;
  logic [31:0]  wdata = '0;
  logic [1:0]   encoder = 2'b00;  // {b, a}
  logic [1:0]   bresp;

  always #3.307 pixel_clk = !pixel_clk;  // 151.2 MHz
  always #4 bus_clk = !bus_clk;          // 125 MHz

  logic        unused_awready, unused_wready, unused_arready, unused_rvalid, unused_ejector;
  logic [1:0]  unused_triggers, unused_rresp;
  logic [31:0] unused_rdata;

  camera_to_dma u_design (
    .reset_i             (reset),
    .pixel_clk_i         (pixel_clk),
    .camera_valid_i      (valid),
    .camera_pixels_i     (pixels),
    .camera_frame_start_i(frame_start),
    .camera_line_end_i   (line_end),
    .encoder_i           (encoder),
    .projector_trigger_o (unused_triggers[0]),
    .camera_trigger_o    (unused_triggers[1]),
    .ejector_o           (unused_ejector),
    .bus_clk_i           (bus_clk),
    .dma_valid_o         (dma_valid),
    .dma_ready_i         (1'b1),
    .dma_data_o          (dma_data),
    .dma_last_o          (dma_last),
    .s_axil_awvalid      (wvalid),
    .s_axil_awready      (unused_awready),
    .s_axil_awaddr       (address),
    .s_axil_wvalid       (wvalid),
    .s_axil_wready       (unused_wready),
    .s_axil_wdata        (wdata),
    .s_axil_wstrb        (4'b1111),
    .s_axil_bvalid       (bvalid),
    .s_axil_bready       (1'b1),
    .s_axil_bresp        (bresp),
    .s_axil_arvalid      (1'b0),
    .s_axil_arready      (unused_arready),
    .s_axil_araddr       (8'h00),
    .s_axil_rvalid       (unused_rvalid),
    .s_axil_rready       (1'b1),
    .s_axil_rdata        (unused_rdata),
    .s_axil_rresp        (unused_rresp)
  );

  string            folder;
  logic [8*120-1:0] comment;  // the first line of the file that was opened last
  int               bits;     // of a pixel

  // Opens a file, and passes its first line, which says what it holds.
  function automatic int opened(input string name);
    opened = $fopen({folder, "/", name}, "r");
    if (opened == 0 || $fgets(comment, opened) == 0) $fatal(1, "cannot read %s/%s", folder, name);
  endfunction

  int           registers_file, camera_file, encoder_file, packets_file;
  logic [39:0]  register_word;  // address, data
  logic [71:0]  beat_word;      // idle clocks, flags, pixels
  logic [39:0]  encoder_word;   // clock, levels
  logic [135:0] packet_word;    // last, data
  int           now = -1;       // pixel clocks after the first beat

  initial begin
    if (!$value$plusargs("vectors=%s", folder)) $fatal(1, "+vectors=DIR is missing");
    registers_file = opened("registers.hex");
    camera_file    = opened("camera.hex");
    if ($sscanf(comment, "// pixels of %d bits", bits) != 1 || bits != 8) begin
      $fatal(1, "%s/camera.hex: pixels have %0d bits; camera_to_dma takes 8", folder, bits);
    end
    encoder_file   = opened("encoder.hex");
    packets_file   = opened("packets.hex");
    #500 reset = 1'b0;
    #500;
    while ($fscanf(registers_file, "%h", register_word) == 1) begin
      @(negedge bus_clk);
      {address, wdata} = register_word;
      wvalid = 1'b1;
      @(negedge bus_clk);  // both are ready while no access is under way
      wvalid = 1'b0;
      while (!bvalid) @(negedge bus_clk);
      if (bresp != 2'b00) $fatal(1, "the board refused to write %h to %h", wdata, address);
    end
    while ($fscanf(camera_file, "%h", beat_word) == 1) begin
      @(negedge pixel_clk);
      if (beat_word[71:40] != 0) begin
        valid = 1'b0;
        repeat (beat_word[71:40]) @(negedge pixel_clk);
      end
      valid       = 1'b1;
      pixels      = beat_word[31:0];
      frame_start = beat_word[32];
      line_end    = beat_word[33];
    end
    @(negedge pixel_clk) valid = 1'b0;
    #100000;
    if ($fscanf(packets_file, "%h", packet_word) == 1) $fatal(1, "packets are missing");
    $display("%0d packets as expected", packets);
    $finish;
  end

  // The encoder's pins change with the beats, at the other edge.
  logic turns;
  always @(negedge pixel_clk) begin
    #0;  // behind valid
    if (now < 0 && valid) begin
      now   = 0;
      turns = $fscanf(encoder_file, "%h", encoder_word) == 1;
    end else if (now >= 0) begin
      now++;
    end
    while (now >= 0 && turns && encoder_word[39:8] == now) begin
      encoder = encoder_word[1:0];
      turns   = $fscanf(encoder_file, "%h", encoder_word) == 1;
    end
  end

  // Bits of the header and of the trailer that are compared
  localparam logic [511:0] HeaderMask = ~({448'b0, {64{1'b1}}} << sp_spec_pkg::HeaderTimeStampLsb);
  localparam logic [127:0] TrailerMask = ~({96'b0, {32{1'b1}}} << sp_spec_pkg::TrailerCheckLsb);

  int           beat = 0, packets = 0;
  logic [127:0] mask;

  always @(posedge bus_clk) begin
    if (dma_valid) begin
      if ($fscanf(packets_file, "%h", packet_word) != 1) $fatal(1, "there are more packets than in packets.hex");
      mask = dma_last ? TrailerMask : beat < 4 ? HeaderMask[128*beat+:128] : ~128'h0;
      if (dma_last !== packet_word[128] || ((dma_data ^ packet_word[127:0]) & mask) !== 128'h0) begin
        $fatal(1, "packet %0d, beat %0d: %b, %h, expected %b, %h", packets + 1, beat + 1, dma_last, dma_data,
               packet_word[128], packet_word[127:0]);
      end
      beat = dma_last ? 0 : beat + 1;
      if (dma_last) packets++;
    end
  end

endmodule
