// AXI4-Lite slave in the bus clock; carries one access at a time into the video clock and its answer back.
//
// Guarantees: every access is answered. OKAY where the registers took it; SLVERR where they refused it, where wstrb is not
// all ones, or where the video clock gave no answer within 2^TimeoutBits bus clocks (the camera is off): until the late answer
// has come every further access gets SLVERR at once. Reads and writes take turns where both wait.
// Crossing: request and answer words are stable while their toggles travel through two flops.
`default_nettype none

module sp_axil_bridge #(
  parameter int AddressBits = 8,
  parameter int TimeoutBits = 10
) (
  input  wire logic                   bus_clk_i,
  input  wire logic                   bus_rst_i,

  // AXI4-Lite
  input  wire logic                   s_axil_awvalid_i,
  output logic                        s_axil_awready_o,
  input  wire logic [AddressBits-1:0] s_axil_awaddr_i,
  input  wire logic                   s_axil_wvalid_i,
  output logic                        s_axil_wready_o,
  input  wire logic [31:0]            s_axil_wdata_i,
  input  wire logic [3:0]             s_axil_wstrb_i,
  output logic                        s_axil_bvalid_o,
  input  wire logic                   s_axil_bready_i,
  output logic [1:0]                  s_axil_bresp_o,
  input  wire logic                   s_axil_arvalid_i,
  output logic                        s_axil_arready_o,
  input  wire logic [AddressBits-1:0] s_axil_araddr_i,
  output logic                        s_axil_rvalid_o,
  input  wire logic                   s_axil_rready_i,
  output logic [31:0]                 s_axil_rdata_o,
  output logic [1:0]                  s_axil_rresp_o,

  // Registers, video clock: request for one clock, answer in a later one
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,
  output logic                        request_o,
  output logic                        write_o,
  output logic [AddressBits-1:0]      address_o,
  output logic [31:0]                 write_data_o,
  input  wire logic                   answer_i,
  input  wire logic                   error_i,
  input  wire logic [31:0]            read_data_i
);

  localparam logic [1:0] Okay = 2'b00;
  localparam logic [1:0] SlaveError = 2'b10;

  // Addresses and data that wait
  logic                   aw_full_q, w_full_q, ar_full_q;
  logic [AddressBits-1:0] aw_q, ar_q;
  logic [31:0]            w_q;
  logic                   w_whole_q;  // all bytes are written

  assign s_axil_awready_o = !aw_full_q;
  assign s_axil_wready_o  = !w_full_q;
  assign s_axil_arready_o = !ar_full_q;

  // The access under way
  logic                   busy_q;       // the registers have been asked
  logic                   reading_q;    // it is a read
  logic                   was_read_q;   // the access before was one
  logic                   late_q;       // its answer was given without the registers
  logic                   toggle_q;     // changes with every request
  logic                   ask_write_q;
  logic [AddressBits-1:0] ask_address_q;
  logic [31:0]            ask_data_q;
  logic [TimeoutBits-1:0] clocks_q;
  logic                   timed_out_q;
  logic                   seen_back;    // the answer's toggle
  logic                   done;
  logic                   idle;
  logic                   start_write, start_read;
  logic                   refuse;

  // video side
  logic                   toggle_there, toggle_before_q;
  logic                   back_q;
  logic                   back_error_q;
  logic [31:0]            back_data_q;

  assign done        = busy_q && seen_back == toggle_q;
  assign idle        = !busy_q || late_q;
  assign start_write = idle && aw_full_q && w_full_q && !s_axil_bvalid_o && (was_read_q || !ar_full_q || s_axil_rvalid_o);
  assign start_read  = idle && ar_full_q && !s_axil_rvalid_o && !start_write;
  assign refuse      = late_q || start_write && !w_whole_q;

  always_ff @(posedge bus_clk_i) begin
    if (bus_rst_i) begin
      aw_full_q       <= 1'b0;
      w_full_q        <= 1'b0;
      ar_full_q       <= 1'b0;
      s_axil_bvalid_o <= 1'b0;
      s_axil_rvalid_o <= 1'b0;
      busy_q          <= 1'b0;
      late_q          <= 1'b0;
      toggle_q        <= 1'b0;
      was_read_q      <= 1'b0;
    end else begin
      if (s_axil_awvalid_i && s_axil_awready_o) aw_full_q <= 1'b1;
      else if (start_write) aw_full_q <= 1'b0;
      if (s_axil_wvalid_i && s_axil_wready_o) w_full_q <= 1'b1;
      else if (start_write) w_full_q <= 1'b0;
      if (s_axil_arvalid_i && s_axil_arready_o) ar_full_q <= 1'b1;
      else if (start_read) ar_full_q <= 1'b0;

      if (s_axil_bready_i) s_axil_bvalid_o <= 1'b0;
      if (s_axil_rready_i) s_axil_rvalid_o <= 1'b0;

      if (done) begin
        busy_q <= 1'b0;
        late_q <= 1'b0;
        if (!late_q && !reading_q) s_axil_bvalid_o <= 1'b1;
        if (!late_q && reading_q) s_axil_rvalid_o <= 1'b1;
      end else if (busy_q && !late_q && timed_out_q) begin
        late_q <= 1'b1;
        if (reading_q) s_axil_rvalid_o <= 1'b1;
        else s_axil_bvalid_o <= 1'b1;
      end

      if (start_write || start_read) begin
        was_read_q <= start_read;
        if (refuse) begin
          if (start_write) s_axil_bvalid_o <= 1'b1;
          else s_axil_rvalid_o <= 1'b1;
        end else begin
          busy_q   <= 1'b1;
          toggle_q <= !toggle_q;
        end
      end
    end
  end

  always_ff @(posedge bus_clk_i) begin
    if (s_axil_awvalid_i && s_axil_awready_o) aw_q <= s_axil_awaddr_i;
    if (s_axil_wvalid_i && s_axil_wready_o) begin
      w_q       <= s_axil_wdata_i;
      w_whole_q <= &s_axil_wstrb_i;
    end
    if (s_axil_arvalid_i && s_axil_arready_o) ar_q <= s_axil_araddr_i;

    // Until the registers have answered, an error
    if (start_write || start_read) begin
      if (!busy_q) begin
        reading_q     <= start_read;
        ask_write_q   <= start_write;
        ask_address_q <= start_write ? aw_q : ar_q;
        ask_data_q    <= w_q;
      end
      if (start_write) s_axil_bresp_o <= SlaveError;
      else s_axil_rresp_o <= SlaveError;
    end

    if (!busy_q) begin
      clocks_q    <= '0;
      timed_out_q <= 1'b0;
    end else begin
      clocks_q    <= clocks_q + TimeoutBits'(1);
      timed_out_q <= &clocks_q;
    end

    if (done && !late_q) begin
      if (reading_q) begin
        s_axil_rdata_o <= back_data_q;
        s_axil_rresp_o <= back_error_q ? SlaveError : Okay;
      end else begin
        s_axil_bresp_o <= back_error_q ? SlaveError : Okay;
      end
    end
  end

  sp_sync u_back (
    .clk_i(bus_clk_i),
    .rst_i(bus_rst_i),
    .d_i  (back_q),
    .q_o  (seen_back)
  );

  // --- Video clock ---
  sp_sync u_there (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  (toggle_q),
    .q_o  (toggle_there)
  );

  assign request_o    = toggle_there != toggle_before_q;
  assign write_o      = ask_write_q;
  assign address_o    = ask_address_q;
  assign write_data_o = ask_data_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      toggle_before_q <= 1'b0;
      back_q          <= 1'b0;
    end else begin
      toggle_before_q <= toggle_there;
      if (answer_i) back_q <= !back_q;
    end
    if (answer_i) begin
      back_error_q <= error_i;
      back_data_q  <= read_data_i;
    end
  end

endmodule

`default_nettype wire
