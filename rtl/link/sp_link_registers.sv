// The registers of a board as the network sees them: those of sp_board, and above them those of the
// mailbox for writes (docs/register-reference.md). model/write_mailbox.h is the model of the
// mailbox.
//
// Guarantees: each request is answered once. An access below the address LinkId goes to the board.
// The registers of the link begin at LinkId. A write of LinkValue is performed if its ticket is the
// one after that of the last write performed. So a write is performed once, however often its
// datagram comes. A read that the board or the link refuses gives 0.
//
// The registers LinkSource and LinkReplaySession are written by the mailbox, too, and by nothing
// else. source_o takes only values that the build has. replay_begin_o is high for a clock, and
// replay_session_o is new, when a session of replay begins.
//
// A host that writes 1 into the bit run of the register control while it is 0 owns the board until
// that bit is 0 again. During this time a write from any other address changes nothing, neither in
// the board nor in the mailbox. Every host may read. start_o is high for a clock when the board
// gets an owner, and owner_o has the owner's address from then on.
//
// Latency: an access of the board, also by the mailbox, is answered after three clocks or more,
// depending on the board's AXI4-Lite port. All other accesses are answered after
// one clock. Reset: together with the board.
`default_nettype none

module sp_link_registers #(
  parameter logic [3:0] Sources = 4'b0001,  // bit i: the build has source i of the register source
  parameter int ReplayColumns = 0,  // of the largest frame of replay: 0..2048; 0 without replay
  parameter int ReplayRows = 0  // of it: 0..1023
) (
  input  wire logic        clk_i,
  input  wire logic        rst_i,      // active high, synchronous

  // Accesses from the network
  input  wire logic        request_i,  // one clock; the inputs below hold until answer_o
  input  wire logic        write_i,
  input  wire logic [31:0] address_i,  // in bytes
  input  wire logic [31:0] data_i,
  input  wire logic [31:0] from_i,     // address of the host that asks
  output logic             answer_o,   // one clock
  output logic      [31:0] data_o,

  output logic             start_o,    // the board has a new owner
  output logic      [31:0] owner_o,    // address of the owner

  // Source of the video
  output logic      [1:0]  source_o,
  output logic             replay_begin_o,
  output logic      [15:0] replay_session_o,
  input  wire logic [31:0] replay_frame_i,    // what the registers of these names show
  input  wire logic [31:0] replay_offset_i,
  input  wire logic [31:0] replay_frames_i,
  input  wire logic [31:0] replay_dropped_i,
  input  wire logic [31:0] replay_ignored_i,

  // AXI4-Lite, to the board
  output logic             m_axil_awvalid_o,
  input  wire logic        m_axil_awready_i,
  output logic      [7:0]  m_axil_awaddr_o,
  output logic             m_axil_wvalid_o,
  input  wire logic        m_axil_wready_i,
  output logic      [31:0] m_axil_wdata_o,
  output logic      [3:0]  m_axil_wstrb_o,  // always 1111
  input  wire logic        m_axil_bvalid_i,
  output logic             m_axil_bready_o,  // always 1
  input  wire logic [1:0]  m_axil_bresp_i,
  output logic             m_axil_arvalid_o,
  input  wire logic        m_axil_arready_i,
  output logic      [7:0]  m_axil_araddr_o,
  input  wire logic        m_axil_rvalid_i,
  output logic             m_axil_rready_o,  // always 1
  input  wire logic [31:0] m_axil_rdata_i,
  input  wire logic [1:0]  m_axil_rresp_i
);

  if (ReplayColumns < 0 || ReplayColumns > sp_spec_pkg::MaxColumns) begin : gen_replay_columns
    replay_columns_is_not_in_0_to_2048 u_error ();
  end
  if (ReplayRows < 0 || ReplayRows > sp_spec_pkg::MaxRows) begin : gen_replay_rows
    replay_rows_is_not_in_0_to_1023 u_error ();
  end

  localparam int AddressBits = sp_spec_pkg::LinkAddressBytesBits;
  localparam int RunBit = sp_spec_pkg::RegControlRunLsb;

  // --- The mailbox ---
  logic [31:0]            asked_ticket_q;
  logic [AddressBits-1:0] asked_address_q;
  logic [31:0]            ticket_q, value_q;  // of the last write performed
  logic [AddressBits-1:0] address_q;
  logic                   refused_q;

  logic                   waits_q;    // an access waits for the board
  logic                   mailed_q;   // that access is a write of the mailbox
  logic                   running_q;  // the board has an owner
  logic                   foreign;    // a write that changes nothing
  logic                   of_board, ticket_is_next, performs;
  logic                   mails_board;             // a write that the mailbox passes to the board
  logic                   sets_source, sets_session;
  logic [31:0]            there;      // what a register of the link holds
  logic                   refused;    // by the board, with its answer

  assign of_board = address_i < sp_spec_pkg::LinkId;
  assign foreign  = write_i && running_q && from_i != owner_o;
  assign performs = write_i && address_i == sp_spec_pkg::LinkValue && ticket_is_next;
  assign ticket_is_next = asked_ticket_q == ticket_q + 32'd1;
  assign mails_board    = performs && 32'(asked_address_q) < sp_spec_pkg::LinkId;
  assign sets_source    = 32'(asked_address_q) == sp_spec_pkg::LinkSource && data_i < 32'd4 &&
                          Sources[data_i[1:0]];
  assign sets_session   = 32'(asked_address_q) == sp_spec_pkg::LinkReplaySession &&
                          data_i[31:16] == '0 && ReplayColumns != 0;

  always_comb begin
    case (address_i)
      sp_spec_pkg::LinkId: there = sp_spec_pkg::LinkIdReset;
      sp_spec_pkg::LinkTicket: there = ticket_q;
      sp_spec_pkg::LinkAddress: there = {{(32 - AddressBits){1'b0}}, address_q};
      sp_spec_pkg::LinkValue: there = value_q;
      sp_spec_pkg::LinkAnswer: there = 32'(refused_q) << sp_spec_pkg::LinkAnswerRefusedLsb;
      sp_spec_pkg::LinkSource: there = 32'(source_o);
      sp_spec_pkg::LinkReplaySession: there = 32'(replay_session_o);
      sp_spec_pkg::LinkVideo: there = 32'(Sources) << sp_spec_pkg::LinkVideoSourcesLsb |
                                      32'(ReplayRows) << sp_spec_pkg::LinkVideoReplayRowsLsb |
                                      32'(ReplayColumns);
      sp_spec_pkg::LinkReplayFrame: there = replay_frame_i;
      sp_spec_pkg::LinkReplayOffset: there = replay_offset_i;
      sp_spec_pkg::LinkReplayFrames: there = replay_frames_i;
      sp_spec_pkg::LinkReplayDropped: there = replay_dropped_i;
      sp_spec_pkg::LinkReplayIgnored: there = replay_ignored_i;
      default: there = 32'd0;
    endcase
  end

  assign m_axil_wstrb_o  = 4'b1111;
  assign m_axil_bready_o = 1'b1;
  assign m_axil_rready_o = 1'b1;
  assign refused         = write_i ? m_axil_bresp_i[1] : m_axil_rresp_i[1];

  always_ff @(posedge clk_i) begin
    answer_o       <= 1'b0;
    start_o        <= 1'b0;
    replay_begin_o <= 1'b0;
    if (rst_i) begin
      source_o         <= sp_spec_pkg::SourceCamera;
      replay_session_o <= '0;
      asked_ticket_q   <= '0;
      asked_address_q  <= '0;
      ticket_q         <= '0;
      address_q        <= '0;
      value_q          <= '0;
      refused_q        <= 1'b0;
      waits_q          <= 1'b0;
      running_q        <= 1'b0;
      m_axil_awvalid_o <= 1'b0;
      m_axil_wvalid_o  <= 1'b0;
      m_axil_arvalid_o <= 1'b0;
    end else begin
      if (m_axil_awready_i) m_axil_awvalid_o <= 1'b0;
      if (m_axil_wready_i) m_axil_wvalid_o <= 1'b0;
      if (m_axil_arready_i) m_axil_arvalid_o <= 1'b0;

      if (request_i) begin
        if (!foreign && (of_board || mails_board)) begin
          waits_q          <= 1'b1;
          mailed_q         <= !of_board;
          m_axil_awvalid_o <= write_i;
          m_axil_wvalid_o  <= write_i;
          m_axil_arvalid_o <= !write_i;
          m_axil_awaddr_o  <= of_board ? address_i[7:0] : asked_address_q[7:0];
          m_axil_araddr_o  <= address_i[7:0];
          m_axil_wdata_o   <= data_i;
        end else begin
          answer_o <= 1'b1;
          data_o   <= there;
          if (!foreign && write_i) begin
            if (address_i == sp_spec_pkg::LinkTicket) asked_ticket_q <= data_i;
            if (address_i == sp_spec_pkg::LinkAddress) asked_address_q <= data_i[AddressBits-1:0];
            if (performs) begin
              ticket_q       <= asked_ticket_q;
              address_q      <= asked_address_q;
              value_q        <= data_i;
              refused_q      <= !sets_source && !sets_session;
              replay_begin_o <= sets_session;
              if (sets_source) source_o <= data_i[1:0];
              if (sets_session) replay_session_o <= data_i[15:0];
            end
          end
        end
      end

      if (waits_q && (m_axil_bvalid_i || m_axil_rvalid_i)) begin
        waits_q  <= 1'b0;
        answer_o <= 1'b1;
        data_o   <= refused ? 32'd0 : m_axil_rdata_i;
        if (mailed_q) begin
          ticket_q  <= asked_ticket_q;
          address_q <= asked_address_q;
          value_q   <= data_i;
          refused_q <= refused;
        end
        if (write_i && !refused && m_axil_awaddr_o == sp_spec_pkg::RegControl) begin
          running_q <= data_i[RunBit];
          start_o   <= data_i[RunBit] && !running_q;
          if (!running_q) owner_o <= from_i;
        end
      end
    end
  end

  logic unused;
  assign unused = ^{m_axil_bresp_i[0], m_axil_rresp_i[0]};

endmodule

`default_nettype wire
