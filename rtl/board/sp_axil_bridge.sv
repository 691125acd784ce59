// AXI4-Lite slave in the bus clock. It carries one access at a time into the video clock and brings
// the answer back.
//
// Guarantees: every access is answered. OKAY: the registers took it. SLVERR: the registers refused
// it, wstrb was not all ones, or the video clock gave no answer within 2^TimeoutBits bus clocks
// (the camera is off). After such a time-out every further access gets SLVERR immediately, until
// the late answer has come. If a read and a write both wait, they take turns.
//
// Crossing: the words of request and answer are stable while their toggles pass through two flops.
`default_nettype none

module sp_axil_bridge #(
  parameter int AddressBits = 8,  // 1 or more
  parameter int TimeoutBits = 10  // 1 or more
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

  // Registers, video clock: a request for one clock, its answer in a later one
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

  if (AddressBits < 1) begin : gen_address_bits
    address_bits_is_less_than_1 u_error ();
  end
  if (TimeoutBits < 1) begin : gen_timeout_bits
    timeout_bits_is_less_than_1 u_error ();
  end

  localparam logic [1:0] Okay = 2'b00;
  localparam logic [1:0] SlaveError = 2'b10;

  // Addresses and data that wait
  logic                   aw_full_q, w_full_q, ar_full_q;
  logic [AddressBits-1:0] aw_q, ar_q;
  logic [31:0]            w_q;
  logic                   w_whole_q;  // the write has all four bytes

  assign s_axil_awready_o = !aw_full_q;
  assign s_axil_wready_o  = !w_full_q;
  assign s_axil_arready_o = !ar_full_q;

  // The access under way
  logic                   busy_q;       // the registers have been asked
  logic                   reading_q;    // it is a read
  logic                   was_read_q;   // the access before it was a read
  logic                   late_q;       // the bus was answered without the registers
  logic                   toggle_q;     // changes with every request
  logic                   ask_write_q;
  logic [AddressBits-1:0] ask_address_q;
  logic [31:0]            ask_data_q;
  logic [TimeoutBits-1:0] clocks_q;
  logic                   timed_out_q;
  logic                   seen_back;    // toggle of the answer
  logic                   done;
  logic                   start_write, start_read;
  logic                   refuse;
  logic                   awake;

  // Video side
  logic                   toggle_there, toggle_before_q;
  logic                   back_q;
  logic                   back_error_q;
  logic [31:0]            back_data_q;

  // While nothing waits, is under way or is unanswered, only the inputs move anything.
  assign awake = aw_full_q || w_full_q || ar_full_q || busy_q || s_axil_bvalid_o || s_axil_rvalid_o;

  always_comb begin
    done        = 1'b0;
    start_write = 1'b0;
    start_read  = 1'b0;
    refuse      = 1'b0;
    if (awake) begin
      done = busy_q && seen_back == toggle_q;
      if (!busy_q || late_q) begin
        start_write = aw_full_q && w_full_q && !s_axil_bvalid_o &&
                      (was_read_q || !ar_full_q || s_axil_rvalid_o);
        start_read  = ar_full_q && !s_axil_rvalid_o && !start_write;
      end
      refuse = late_q || start_write && !w_whole_q;
    end
  end

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

      if (awake) begin
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
  end

  always_ff @(posedge bus_clk_i) begin
    if (s_axil_awvalid_i && s_axil_awready_o) aw_q <= s_axil_awaddr_i;
    if (s_axil_wvalid_i && s_axil_wready_o) begin
      w_q       <= s_axil_wdata_i;
      w_whole_q <= &s_axil_wstrb_i;
    end
    if (s_axil_arvalid_i && s_axil_arready_o) ar_q <= s_axil_araddr_i;

    if (awake) begin
      // An error until the registers have answered
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
  end

`ifdef FORMAL
  logic f_there_before, f_there_meta, f_back_before, f_back_meta;
`endif

  sp_sync u_back (
    .clk_i(bus_clk_i),
    .rst_i(bus_rst_i),
    .d_i  (back_q),
    .q_o  (seen_back)
`ifdef FORMAL
    ,
    .f_before_o(f_back_before),
    .f_meta_o  (f_back_meta)
`endif
  );

  // --- Video clock ---
  sp_sync u_there (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  (toggle_q),
    .q_o  (toggle_there)
`ifdef FORMAL
    ,
    .f_before_o(f_there_before),
    .f_meta_o  (f_there_meta)
`endif
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

`ifdef FORMAL
  // Two free clocks: each may rise at any moment.
  (* gclk *) logic f_moment;
  logic f_bus_rise, f_rise, f_bus_one, f_one, f_bus_two, f_two, f_run;
  sp_formal_clocks u_clocks (
    .a_clk_i (bus_clk_i),
    .a_rst_i (bus_rst_i),
    .b_clk_i (clk_i),
    .b_rst_i (rst_i),
    .a_rise_o(f_bus_rise),
    .b_rise_o(f_rise),
    .a_one_o (f_bus_one),
    .b_one_o (f_one),
    .a_two_o (f_bus_two),
    .b_two_o (f_two),
    .run_o   (f_run)
  );
  // Inputs change only with their clock. The registers answer each request once, and nothing else.
  logic f_asked_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_asked_q <= 1'b0;
    else f_asked_q <= (f_asked_q || request_o) && !answer_i;
  end
  always_comb if (answer_i) assume (f_asked_q && !rst_i);
  always_ff @(posedge f_moment) if (f_run) begin
    if (!f_bus_rise) begin
      assume ($stable(s_axil_awvalid_i) && $stable(s_axil_awaddr_i) && $stable(s_axil_wvalid_i) &&
              $stable(s_axil_wdata_i));
      assume ($stable(s_axil_wstrb_i) && $stable(s_axil_bready_i) && $stable(s_axil_rready_i));
      assume ($stable(s_axil_arvalid_i) && $stable(s_axil_araddr_i));
    end
    if (!f_rise) assume ($stable(answer_i) && $stable(error_i) && $stable(read_data_i));
  end

  // Rule 1: every address and every data word that is taken is answered once: taken = answered +
  // waiting + under way + at the output.
  logic [3:0] f_aw_q, f_w_q, f_b_q, f_ar_q, f_r_q;  // modulo 16
  always_ff @(posedge bus_clk_i) begin
    if (bus_rst_i) {f_aw_q, f_w_q, f_b_q, f_ar_q, f_r_q} <= '0;
    else begin
      f_aw_q <= f_aw_q + 4'(s_axil_awvalid_i && s_axil_awready_o);
      f_w_q  <= f_w_q + 4'(s_axil_wvalid_i && s_axil_wready_o);
      f_b_q  <= f_b_q + 4'(s_axil_bvalid_o && s_axil_bready_i);
      f_ar_q <= f_ar_q + 4'(s_axil_arvalid_i && s_axil_arready_o);
      f_r_q  <= f_r_q + 4'(s_axil_rvalid_o && s_axil_rready_i);
    end
  end
  logic f_writing, f_reading;  // at the registers while the bus waits
  assign f_writing = busy_q && !late_q && !reading_q;
  assign f_reading = busy_q && !late_q && reading_q;
  always_comb if (f_run) begin
    assert (f_aw_q == f_b_q + 4'(aw_full_q) + 4'(f_writing) + 4'(s_axil_bvalid_o));
    assert (f_w_q == f_b_q + 4'(w_full_q) + 4'(f_writing) + 4'(s_axil_bvalid_o));
    assert (f_ar_q == f_r_q + 4'(ar_full_q) + 4'(f_reading) + 4'(s_axil_rvalid_o));
    // An answer is at the output or still to come, never both.
    assert (!(f_writing && s_axil_bvalid_o) && !(f_reading && s_axil_rvalid_o));
    // Every answer is OKAY or SLVERR.
    if (s_axil_bvalid_o) assert (s_axil_bresp_o == Okay || s_axil_bresp_o == SlaveError);
    if (s_axil_rvalid_o) assert (s_axil_rresp_o == Okay || s_axil_rresp_o == SlaveError);
    if (f_writing) assert (s_axil_bresp_o == SlaveError);
    if (f_reading) assert (s_axil_rresp_o == SlaveError);
    assert (!late_q || busy_q);
    if (busy_q) assert (ask_write_q == !reading_q);
  end
  always_comb if (!f_run && f_bus_one) begin
    assert (!busy_q && !late_q && !aw_full_q && !w_full_q && !ar_full_q && !s_axil_bvalid_o &&
            !s_axil_rvalid_o);
    assert ({f_aw_q, f_w_q, f_b_q, f_ar_q, f_r_q} == '0);
  end

  // A request makes one round. The places that its toggle has reached are the beginning of the
  // round; while nothing is under way, they are the whole round.
  logic [8:1] f_not_yet;
  assign f_not_yet =
      {seen_back, f_back_meta, f_back_before, back_q, toggle_before_q, toggle_there, f_there_meta,
                      f_there_before} ^ {8{toggle_q}};
  always_comb begin
    if (f_run) begin
      for (int i = 1; i < 8; i++) if (f_not_yet[i]) assert (f_not_yet[i+1]);
      if (!busy_q) assert (f_not_yet == '0);
      assert (f_asked_q == (toggle_before_q != back_q));
    end else begin
      if (f_bus_one) assert (!toggle_q && !f_back_meta);
      if (f_one) assert (!toggle_before_q && !back_q && !f_there_meta && !f_asked_q);
      if (f_bus_two) assert (!seen_back && !f_there_before);
      if (f_two) assert (!toggle_there && !f_back_before);
    end
  end

  // The latest answer of the registers, and for how many bus clocks this one has been awaited
  logic                   f_answered_q, f_error_q;
  logic [31:0]            f_data_q;
  logic [1:0]             f_response;
  logic [TimeoutBits:0]   f_waits_q;
  assign f_response = f_error_q ? SlaveError : Okay;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_answered_q <= 1'b0;
    else if (answer_i) f_answered_q <= 1'b1;
    if (answer_i) {f_error_q, f_data_q} <= {error_i, read_data_i};
  end
  always_ff @(posedge bus_clk_i) begin
    if (!busy_q) f_waits_q <= '0;
    else if (!f_waits_q[TimeoutBits]) f_waits_q <= f_waits_q + 1'b1;
  end
  always_comb if (f_run) begin
    if (f_answered_q) assert (back_error_q == f_error_q && back_data_q == f_data_q);
    else assert (!back_q && toggle_q == busy_q);
    if (busy_q && !late_q) begin
      assert (f_waits_q <= (TimeoutBits + 1)'(1 << TimeoutBits));
      assert (clocks_q == f_waits_q[TimeoutBits-1:0] && timed_out_q == f_waits_q[TimeoutBits]);
    end
  end
  always_comb if (!f_run && f_one) assert (!f_answered_q);

  // Address and data of every access, as the bus gave them in the clock in which it was taken
  logic [AddressBits-1:0] f_aw_address_q, f_ar_address_q, f_ask_address_q;
  logic [31:0]            f_w_data_q, f_ask_data_q;
  logic                   f_w_whole_q;
  always_ff @(posedge bus_clk_i) begin
    if (s_axil_awvalid_i && s_axil_awready_o) f_aw_address_q <= s_axil_awaddr_i;
    if (s_axil_arvalid_i && s_axil_arready_o) f_ar_address_q <= s_axil_araddr_i;
    if (s_axil_wvalid_i && s_axil_wready_o) begin
      {f_w_data_q, f_w_whole_q} <= {s_axil_wdata_i, s_axil_wstrb_i == 4'b1111};
    end
    if ((start_write || start_read) && !busy_q) begin
      f_ask_address_q <= start_write ? f_aw_address_q : f_ar_address_q;
      f_ask_data_q    <= f_w_data_q;
    end
  end
  always_comb if (f_run) begin
    if (aw_full_q) assert (aw_q == f_aw_address_q);
    if (ar_full_q) assert (ar_q == f_ar_address_q);
    if (w_full_q) assert (w_q == f_w_data_q && w_whole_q == f_w_whole_q);
    // Rule 5: the registers are asked for the address and given the data that the bus gave.
    if (busy_q) begin
      assert (address_o == f_ask_address_q);
      if (write_o) assert (write_data_o == f_ask_data_q);
    end
  end

  // Rule 2: an answer that waits does not change.
  always_ff @(posedge f_moment) if (f_run) begin
    if ($past(f_run && s_axil_bvalid_o && !s_axil_bready_i))
      assert (s_axil_bvalid_o && $stable(s_axil_bresp_o));
    if ($past(f_run && s_axil_rvalid_o && !s_axil_rready_i)) begin
      assert (s_axil_rvalid_o && $stable(s_axil_rresp_o) && $stable(s_axil_rdata_o));
    end
    // Rule 3: a request stands still from its start until the bus has its answer.
    if ($past(f_run && busy_q) && busy_q) begin
      assert ($stable(ask_write_q) && $stable(ask_address_q) && $stable(ask_data_q));
    end
    if (request_o) assert (busy_q);
    // Rule 4: response and data are those of the registers where a request has made its round.
    // Other answers are SLVERR: after the time-out, while a late answer is awaited, or without all
    // four bytes.
    if ($past(f_run) && s_axil_bvalid_o && !$past(s_axil_bvalid_o)) begin
      if ($past(busy_q && !late_q) && !busy_q) assert (s_axil_bresp_o == f_response);
      else assert (s_axil_bresp_o == SlaveError && (late_q || $past(late_q || !w_whole_q)));
    end
    if ($past(f_run) && s_axil_rvalid_o && !$past(s_axil_rvalid_o)) begin
      if ($past(busy_q && !late_q) && !busy_q) begin
        assert (s_axil_rresp_o == f_response && s_axil_rdata_o == f_data_q);
      end else assert (s_axil_rresp_o == SlaveError && (late_q || $past(late_q)));
    end
    if (late_q && !$past(late_q)) assert ($past(f_waits_q[TimeoutBits]));
    cover (s_axil_bvalid_o && s_axil_bresp_o == Okay);
    cover (s_axil_rvalid_o && s_axil_rresp_o == Okay);
    cover (late_q && s_axil_rvalid_o);
  end
`endif

endmodule

`default_nettype wire
