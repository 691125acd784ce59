// Etherbone, as LiteX speaks it: hosts read and write registers by requests in the payloads of UDP
// datagrams, and answers return in the same way. host/driver/etherbone.h has the format.
//
//   requests ─▶ words ─▶ judge ─▶ accesses, one after the other ─▶ words ─▶ answers
//
// Guarantees: a datagram that is exactly one record of at most 2^LogWords words is performed as a
// whole: first its writes, then its reads, in order. If it reads, it is answered; a probe is
// answered, too. All other datagrams are ignored: those that are cut, too long, of another format
// or marked by s_error_i, and those that come while a request is performed. The sender has to
// repeat them. Words after s_bytes_i (an Ethernet frame is filled up to 60 bytes) do not count. So
// the source never waits, and an answer is never longer than its request. An answer goes to the
// address that the request came from, and leaves without a gap.
//
// Accesses: request_o is high for one clock. Address, data and sender do not change until answer_i,
// which comes in a later clock. Reset: together with the registers.
//
// Latency: the first request_o comes three clocks after the last word of a record, or two clocks if
// the record only reads. The first word of an answer comes two clocks after the last answer_i.
// Example: a record that reads one register, with an access of two clocks:
//
//   clock       0   1   2   3   4   5   6   7   8   9  10  11  12
//   s_valid_i  /1111111111111111111\_______________________________
//   s_data_i   <h ><0 ><r ><t ><a >--------------------------------  (a)
//   s_last_i   ________________/111\_______________________________
//   request_o  ________________________/111\_______________________
//   answer_i   ________________________________/111\_______________
//   m_valid_o  ________________________________________/11111111111
//   m_data_o   ----------------------------------------<h ><0 ><r >
//
//   (a) head of the packet, head of the record, tag, address
`default_nettype none

module sp_etherbone #(
  parameter int LogWords = 6  // log2 of the words of 4 bytes of the longest datagram: 3..9
) (
  input  wire logic        clk_i,
  input  wire logic        rst_i,      // active high, synchronous

  // Requests
  input  wire logic        s_valid_i,  // a word, which is taken at once
  input  wire logic        s_last_i,   // last word of a datagram
  input  wire logic        s_error_i,  // with the last word: the datagram is damaged
  input  wire logic [31:0] s_data_i,   // first byte of a word in 7..0
  input  wire logic [15:0] s_bytes_i,  // bytes of the datagram, with every word
  input  wire logic [31:0] s_from_i,   // address of the sender, with every word

  // Answers
  output logic             m_valid_o,  // from the first word of a datagram to its last
  input  wire logic        m_ready_i,
  output logic             m_last_o,
  output logic      [31:0] m_data_o,   // first byte of a word in 7..0
  output logic      [15:0] m_bytes_o,  // bytes of the datagram, with every word
  output logic      [31:0] m_to_o,     // address of the receiver, with every word

  // Registers
  output logic             request_o,
  output logic             write_o,
  output logic      [31:0] address_o,  // in bytes
  output logic      [31:0] data_o,
  output logic      [31:0] from_o,     // address of the sender of the request
  input  wire logic        answer_i,
  input  wire logic [31:0] data_i      // what was read, with answer_i
);

  if (LogWords < 3 || LogWords > 9) begin : gen_log_words
    log_words_is_not_in_3_to_9 u_error ();
  end

  localparam logic [31:0] Head = 32'h4410_6F4E;  // of every packet, without flags
  localparam int ProbeBit = 16;
  localparam int ProbeAnswerBit = 17;

  localparam logic [2:0] Take = 3'd0;
  localparam logic [2:0] Judge = 3'd1;
  localparam logic [2:0] Base = 3'd2;   // the first address of the writes
  localparam logic [2:0] Ask = 3'd3;
  localparam logic [2:0] Await = 3'd4;
  localparam logic [2:0] Send = 3'd5;

  function automatic logic [31:0] swapped(input logic [31:0] word);
    swapped = {word[7:0], word[15:8], word[23:16], word[31:24]};
  endfunction

  // --- A request comes ---
  logic [2:0]        state_q;
  logic              inside_q;   // a datagram has begun
  logic              mine_q;     // that datagram is taken
  logic              first;      // first word of a datagram that is taken
  logic              taken;      // a word is taken
  logic [LogWords:0] count_q;    // words taken; the top bit: there is no room for more
  logic [LogWords:0] count;
  logic [31:0]       head_q;
  logic [15:0]       record_q;   // numbers of writes and of reads
  logic [15:0]       bytes_q;
  logic              damaged_q;

  assign first = s_valid_i && !inside_q && state_q == Take;
  assign taken = first || s_valid_i && inside_q && mine_q;
  assign count = first ? '0 : count_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      inside_q <= 1'b0;
      mine_q   <= 1'b0;
    end else if (s_valid_i) begin
      inside_q <= !s_last_i;
      if (!inside_q) mine_q <= state_q == Take;
    end
    if (taken) begin
      if (!count[LogWords]) count_q <= count + 1'b1;
      bytes_q   <= s_bytes_i;
      from_o    <= s_from_i;
      damaged_q <= s_error_i;
      if (count == (LogWords + 1)'(0)) head_q <= s_data_i;
      if (count == (LogWords + 1)'(2)) record_q <= s_data_i[31:16];
    end
  end

  // --- What it is ---
  logic [7:0]  writes, reads;
  logic [15:0] words;  // of a record with so many accesses
  logic        whole, is_probe, is_record;

  assign writes    = record_q[7:0];
  assign reads     = record_q[15:8];
  assign words     = 16'd3 + (writes == '0 ? 16'd0 : 16'(writes) + 16'd1) +
                     (reads == '0 ? 16'd0 : 16'(reads) + 16'd1);
  assign whole     = !damaged_q && head_q[15:0] == Head[15:0] && head_q[31:20] == Head[31:20] &&
                     bytes_q >= 16'd8;
  assign is_probe  = whole && head_q[ProbeBit];
  assign is_record = whole && !head_q[ProbeBit] && !head_q[ProbeAnswerBit] &&
                     bytes_q == {words[13:0], 2'b00} && 16'(count_q) >= words;

  // --- Accesses and the answer ---
  logic [LogWords-1:0] at_q;     // the word that is looked at
  logic [LogWords-1:0] tag_q;    // place of the tag
  logic [7:0]          left_q;   // accesses of this kind that are left
  logic [1:0]          sent_q;   // words of the head that have left, at most 3
  logic                probe_q;
  logic [31:0]         base_q;   // address of the next write
  logic [31:0]         word;     // at at_q
  logic                move;     // the next word goes to the output
  logic                last;     // it is the last

  // Words of the request. The value of a register that was read replaces its address, so that the
  // answer lies here in the end.
  logic [31:0] memory [1 << LogWords];
  logic        put;
  always_ff @(posedge clk_i) begin
    if (put) memory[state_q == Take ? count[LogWords-1:0] : at_q] <=
        state_q == Take ? s_data_i : swapped(data_i);
  end
  assign word = memory[at_q];
  assign put  = state_q == Take ? taken && !count[LogWords] : answer_i && !write_o;

  assign request_o = state_q == Ask;
  assign address_o = write_o ? base_q : swapped(word);
  assign data_o    = swapped(word);
  assign move      = state_q == Send && (!m_valid_o || m_ready_i && !m_last_o);
  assign last      = probe_q ? sent_q == 2'd1 : sent_q == 2'd3 && left_q == '0;
  assign m_to_o    = from_o;
  assign m_bytes_o = probe_q ? 16'd8 : 16'd16 + {6'd0, reads, 2'b00};

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      state_q   <= Take;
      m_valid_o <= 1'b0;
    end else begin
      case (state_q)
        Take: if (taken && s_last_i) state_q <= Judge;
        Judge: begin
          state_q <= is_probe ? Send : !is_record ? Take : writes != '0 ? Base :
                     reads != '0 ? Ask : Take;
        end
        Base: state_q <= Ask;
        Ask: state_q <= Await;
        Await: if (answer_i) begin
          state_q <= left_q != 8'd1 ? Ask : !write_o ? Send : reads != '0 ? Ask : Take;
        end
        default: if (m_valid_o && m_ready_i && m_last_o) state_q <= Take;
      endcase
      if (move) m_valid_o <= 1'b1;
      else if (m_ready_i) m_valid_o <= 1'b0;
    end

    case (state_q)
      Judge: begin
        probe_q <= is_probe;
        write_o <= writes != '0;
        left_q  <= writes != '0 ? writes : reads;
        at_q    <= writes != '0 ? LogWords'(3) : LogWords'(4);
        tag_q   <= LogWords'(3);
        sent_q  <= '0;
      end
      Base: begin
        base_q <= swapped(word);
        at_q   <= at_q + 1'b1;
      end
      Await: if (answer_i) begin
        at_q   <= at_q + 1'b1;
        left_q <= left_q - 1'b1;
        base_q <= base_q + 32'd4;
        if (left_q == 8'd1) begin
          if (write_o) begin
            write_o <= 1'b0;
            left_q  <= reads;
            at_q    <= at_q + LogWords'(2);
            tag_q   <= at_q + LogWords'(1);
          end else begin
            at_q   <= tag_q;
            left_q <= reads;
          end
        end
      end
      default: if (move) begin
        if (sent_q != 2'd3) sent_q <= sent_q + 1'b1;
        else begin
          at_q   <= at_q + 1'b1;
          left_q <= left_q - 1'b1;
        end
      end
    endcase
    if (move) begin
      m_last_o <= last;
      case (sent_q)
        2'd0: m_data_o <= Head | (probe_q ? 32'(1 << ProbeAnswerBit) : 32'd0);
        2'd1: m_data_o <= 32'd0;
        2'd2: m_data_o <= {8'd0, reads, 16'h0F00};
        default: m_data_o <= word;
      endcase
    end
  end

endmodule

`default_nettype wire
