  // The body of Yosys's black box DP16KD: 9, 18 or 36 bits. With 36, port A writes and B reads.
  // As in the vendor's simulation models, the array answers one clock after the enabled address and
  // holds its answer; OUTREG is a register behind it with an enable of its own (OCE).
  // Not modelled, because Yosys ties them for rtl/: chip selects, resets, first contents.
  localparam Wide = DATA_WIDTH_B == 36;
  localparam RegisterA = REGMODE_A == "OUTREG", RegisterB = REGMODE_B == "OUTREG";

  reg  [17:0] memory[0:1023];
  reg  [17:0] array_a, array_b, register_a, register_b;
  wire [13:0] address_a = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7,
                           ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0};
  wire [13:0] address_b = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7,
                           ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0};
  wire [17:0] write_a = {DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9,
                         DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0};
  wire [17:0] write_b = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9,
                         DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1, DIB0};

  assign {DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9,
          DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1, DOA0} = RegisterA ? register_a : array_a;
  assign {DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9,
          DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1, DOB0} = RegisterB ? register_b : array_b;

  generate
    if (CLKAMUX != "CLKA" || CLKBMUX != "CLKB" || (DATA_WIDTH_A == 36) != Wide ||
        DATA_WIDTH_A < 9 || DATA_WIDTH_B < 9) begin
      $error("a DP16KD that dp16kd.vh does not model");
    end

    if (Wide) begin
      always @(posedge CLKA) begin
        if (CEA && WEA) begin
          if (ADA0) memory[{address_a[13:5], 1'b0}][8:0] <= write_a[8:0];
          if (ADA1) memory[{address_a[13:5], 1'b0}][17:9] <= write_a[17:9];
          if (ADA2) memory[{address_a[13:5], 1'b1}][8:0] <= write_b[8:0];
          if (ADA3) memory[{address_a[13:5], 1'b1}][17:9] <= write_b[17:9];
        end
      end

      always @(posedge CLKB) begin
        if (CEB) begin
          {array_b, array_a} <= {memory[{address_b[13:5], 1'b1}], memory[{address_b[13:5], 1'b0}]};
        end
        if (OCEA) register_a <= array_a;
        if (OCEB) register_b <= array_b;
      end
    end else begin
      always @(posedge CLKA) begin
        if (CEA && WEA) begin
          if (DATA_WIDTH_A == 18 ? ADA0 : !ADA3) memory[address_a[13:4]][8:0] <= write_a[8:0];
          if (DATA_WIDTH_A == 18 ? ADA1 : ADA3) begin
            memory[address_a[13:4]][17:9] <= DATA_WIDTH_A == 18 ? write_a[17:9] : write_a[8:0];
          end
        end else if (CEA) begin
          array_a <= memory[address_a[13:4]] >> (DATA_WIDTH_A == 9 && ADA3 ? 9 : 0);
        end
        if (OCEA) register_a <= array_a;
      end

      always @(posedge CLKB) begin
        if (CEB && WEB) begin
          if (DATA_WIDTH_B == 18 ? ADB0 : !ADB3) memory[address_b[13:4]][8:0] <= write_b[8:0];
          if (DATA_WIDTH_B == 18 ? ADB1 : ADB3) begin
            memory[address_b[13:4]][17:9] <= DATA_WIDTH_B == 18 ? write_b[17:9] : write_b[8:0];
          end
        end else if (CEB) begin
          array_b <= memory[address_b[13:4]] >> (DATA_WIDTH_B == 9 && ADB3 ? 9 : 0);
        end
        if (OCEB) register_b <= array_b;
      end
    end
  endgenerate
