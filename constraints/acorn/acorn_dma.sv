// Packets to LitePCIe's DMA writer: whole ones only, and zeros behind the last of a burst.
//
// The DMA fills the host's buffers one after another, and the host sees a buffer when the next one
// is full, too. Without the zeros the last packets of a burst would stay unseen until more came.
//
// Guarantees: while enable_i is high, packets pass unchanged and without a gap of this module's
// making. The first beat after enable_i rises begins a packet and a buffer. While it is low,
// packets are discarded. When IdleClocks have passed without a beat of a packet, zeros follow up to
// the end of the buffer, and fill the next one; never within a packet. A packet that comes
// meanwhile goes first. A beat that is offered stays until it is taken, unless enable_i falls.
//
// Overflow: none here. While the DMA is not ready, the packets wait at s_ready_o.
//
// Latency: one clock. With buffers of four beats, a packet of three beats, and IdleClocks = 3:
//
//   clock       0   1   2   3   4   5   6   7   8   9  10  11  12  13
//   s_data_i   <p0><p1><p2>--------------------------------------------
//   s_last_i   ________/111\___________________________________________
//   m_data_o   ----<p0><p1><p2>----------------<0 ><0 ><0 ><0 ><0 >----
//   buffer         <0                             ><1             >
`default_nettype none

module acorn_dma #(
  parameter int LogBuffer = 9,  // log2 of the beats of a buffer: 1 or more; 9 is 8 KiB
  parameter int IdleClocks = 12_500  // 1 or more; 0.1 ms at 125 MHz
) (
  input  wire logic         clk_i,
  input  wire logic         rst_i,      // active high, synchronous
  input  wire logic         enable_i,   // the DMA runs; its first buffer begins when this rises

  // Packets
  input  wire logic         s_valid_i,
  output logic              s_ready_o,
  input  wire logic         s_last_i,
  input  wire logic [127:0] s_data_i,

  // To the DMA
  output logic              m_valid_o,
  input  wire logic         m_ready_i,
  output logic              m_last_o,   // last beat of a packet
  output logic      [127:0] m_data_o
);

  if (LogBuffer < 1) begin : gen_log_buffer
    log_buffer_is_less_than_1 u_error ();
  end
  if (IdleClocks < 1) begin : gen_idle_clocks
    idle_clocks_is_less_than_1 u_error ();
  end

  localparam int IdleBits = $clog2(IdleClocks + 1);

  logic                 open_q;    // packets pass
  logic                 within_q;  // the next beat of the packets is not the first of one
  logic                 free;      // the output takes a beat in this clock
  logic                 taken;     // a beat of a packet is taken in this clock
  logic                 passes;    // and goes to the output
  logic                 fills;     // a beat of zeros goes to the output
  logic                 buffer_end;  // what goes to the output is the last beat of a buffer
  logic [LogBuffer-1:0] place_q;   // place in the buffer of the next beat to the output
  logic                 seen_q;    // a packet has passed since the last zeros began
  logic [IdleBits-1:0]  idle_q;    // clocks without a beat of a packet
  logic [1:0]           fill_q;    // buffers to be ended with zeros; 0 within a packet

  assign free       = !m_valid_o || m_ready_i;
  assign s_ready_o  = !open_q || free;
  assign taken      = s_valid_i && s_ready_o;
  assign passes     = taken && open_q;
  assign fills      = open_q && free && !s_valid_i && fill_q != '0;
  assign buffer_end = (passes || fills) && place_q == '1;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      within_q <= 1'b0;
      open_q   <= 1'b0;
    end else begin
      if (taken) within_q <= !s_last_i;
      open_q <= enable_i && (open_q || (taken ? s_last_i : !within_q));
    end
    if (rst_i || !enable_i) begin
      m_valid_o <= 1'b0;
      place_q   <= '0;
      seen_q    <= 1'b0;
      idle_q    <= '0;
      fill_q    <= '0;
    end else begin
      if (free) m_valid_o <= passes || fills;
      if (passes || fills) place_q <= place_q + 1'b1;
      if (passes) begin
        seen_q <= 1'b1;
        idle_q <= '0;
        fill_q <= '0;
      end else begin
        if (seen_q && !within_q && idle_q == IdleBits'(IdleClocks)) begin
          seen_q <= 1'b0;
          fill_q <= place_q == '0 ? 2'd1 : 2'd2;
        end else if (buffer_end) begin
          fill_q <= fill_q - 1'b1;
        end
        if (idle_q != IdleBits'(IdleClocks)) idle_q <= idle_q + 1'b1;
      end
    end
    if (free) begin
      m_data_o <= passes ? s_data_i : '0;
      m_last_o <= passes && s_last_i;
    end
  end

endmodule

`default_nettype wire
