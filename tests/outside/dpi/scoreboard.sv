// A scoreboard that checks someone else's column moments by the model, on random frames.
//
//   +frames=N   frames, 100 unless given      +fault   the circuit's planted fault
//
// Ends with the columns that were compared, or with the first that differs, and $fatal.
module scoreboard;
  import selfproj_dpi_pkg::*;

  localparam int Columns = 32;
  localparam int Rows = 24;

  logic        clk = 0, start = 0, valid = 0, fault;
  logic [7:0]  pixel = 0, threshold = 0;
  logic [15:0] column = 0;
  logic [31:0] their_m0, their_m1, their_n;

  their_moments #(.Columns(Columns)) u_theirs (
    .clk_i(clk), .start_i(start), .valid_i(valid), .pixel_i(pixel), .threshold_i(threshold),
    .fault_i(fault), .column_i(column), .m0_o(their_m0), .m1_o(their_m1), .n_o(their_n));

  always #5 clk = ~clk;

  byte unsigned pixels[Rows * Columns];
  int unsigned m0[Columns], m1[Columns], n[Columns];
  byte unsigned runs[Columns], second[Columns];
  byte unsigned payload[8 * Columns], packet[1024];
  int frames, compared, bytes;

  // The stages give what the whole way gives.
  task automatic check_whole(int frame);
    bytes = selfproj_dpi_packet(pixels, Rows, Columns, GreyOver, 32'(threshold), All, 0, 0, 0,
                                64'(frame), 0, 0, packet);
    if (bytes < 0) $fatal(1, "packet: %s", selfproj_dpi_last_error());
    if (selfproj_dpi_pack(All, GreyOver, Columns, m0, m1, n, runs, second, payload) != 8 * Columns)
      $fatal(1, "pack: %s", selfproj_dpi_last_error());
    if (bytes != 64 + 8 * Columns + 16) $fatal(1, "a packet of %0d bytes", bytes);
    for (int i = 0; i < 8 * Columns; ++i) begin
      if (packet[64 + i] != payload[i]) $fatal(1, "payload byte %0d differs", i);
    end
  endtask

  initial begin
    fault = $test$plusargs("fault") != 0;
    if (!$value$plusargs("frames=%d", frames)) frames = 100;
    for (int frame = 0; frame < frames; ++frame) begin
      threshold = 8'($urandom);
      for (int i = 0; i < Rows * Columns; ++i) begin
        pixels[i] = 8'($urandom);
        @(negedge clk);
        start = i == 0;
        valid = 1;
        pixel = pixels[i];
      end
      @(negedge clk);
      valid = 0;
      if (selfproj_dpi_moments(pixels, Rows, Columns, GreyOver, 32'(threshold), All, 0, 0, 0,
                               m0, m1, n, runs, second) != 0)
        $fatal(1, "moments: %s", selfproj_dpi_last_error());
      for (int i = 0; i < Columns; ++i) begin
        column = 16'(i);
        #1;
        if (their_m0 != m0[i] || their_m1 != m1[i] || their_n != n[i])
          $fatal(1, "frame %0d, column %0d: %0d %0d %0d, the model says %0d %0d %0d", frame, i + 1,
                 their_m0, their_m1, their_n, m0[i], m1[i], n[i]);
        ++compared;
      end
      check_whole(frame);
    end
    // Arguments that are wrong are refused, with a reason.
    if (selfproj_dpi_moments(pixels, Rows + 1, Columns, GreyOver, 0, All, 0, 0, 0, m0, m1, n, runs,
                             second) != -1)
      $fatal(1, "an image larger than its array was taken");
    $display("matched %0d columns in %0d frames", compared, frames);
    $finish;
  end
endmodule
