// What the vendor's block for PCI Express does, as far as LitePCIe sees it, for simulation: packets of the transaction
// layer, 128 bits a clock, from and to pcie_host.h. litepcie_core.py writes the module around it.
  import "DPI-C" context function void pcie_host_clock(
    input bit taken, input bit last, input bit [15:0] keep, input bit [127:0] sent, input bit given,
    input bit msi, output bit ready, output bit valid, output bit is_read, output bit [127:0] offered);

  bit         ready_q, valid_q, read_q;
  bit [127:0] offered_q;

  always @(posedge sys_clk) begin : clock
    bit         ready, valid, is_read;
    bit [127:0] offered;
    pcie_host_clock(s_axis_tx_tvalid && ready_q, s_axis_tx_tlast, s_axis_tx_tkeep, s_axis_tx_tdata,
                    m_axis_rx_tready && valid_q, cfg_interrupt, ready, valid, is_read, offered);
    ready_q   <= ready;
    valid_q   <= valid;
    read_q    <= is_read;
    offered_q <= offered;
  end

  assign user_clk_out       = sys_clk;
  assign user_reset_out     = !sys_rst_n;
  assign user_lnk_up        = sys_rst_n;
  assign pipe_txoutclk_out  = sys_clk;
  assign s_axis_tx_tready   = ready_q;
  assign m_axis_rx_tvalid   = valid_q;
  assign m_axis_rx_tlast    = valid_q;
  assign m_axis_rx_tdata    = offered_q;
  assign m_axis_rx_tkeep    = read_q ? 16'h0FFF : 16'hFFFF;
  // A packet begins at byte 0 and ends at byte 11 or 15 of the same beat.
  assign m_axis_rx_tuser    = 32'h0020_4000 | (read_q ? 32'h0016_0000 : 32'h001E_0000);
  assign cfg_interrupt_rdy  = cfg_interrupt;
  assign cfg_interrupt_msienable = 1'b1;
  assign cfg_command        = 16'h0006;  // memory, bus master
  assign cfg_dcommand       = 16'h2020;  // payloads of 256 bytes, requests of 512
  assign cfg_bus_number     = 8'd1;
  assign cfg_device_number  = 5'd0;
  assign cfg_function_number = 3'd0;
