// Reads a frame out of the memory of sp_replay, as video.
//
// Guarantees: after start_i all beats of the frame leave without a gap, in the order of their
// addresses. done_o is high for one clock when the last one has left. start_i does not come before.
//
// Latency: the first beat comes four clocks after start_i. Example: two rows of two beats:
//
//   clock       0   1   2   3   4   5   6   7   8   9
//   start_i    /111\___________________________________
//   read_o     ____/111111111111111\___________________
//   address_o  ----<0 ><1 ><2 ><3 >--------------------
//   m_valid_o  ____________/111111111111111\___________
//   m_data_o   ------------<0 ><1 ><2 ><3 >------------
//   m_start_o  ____________/111\_______________________
//   m_end_o    ________________/111\___/111\___________
//   done_o     ____________________________/111\_______
`default_nettype none

module sp_replay_player #(
  parameter int LogWords = 14,  // 1 or more
  parameter int BeatBits = 8,  // 1 or more
  parameter int RowBits = 7  // 1 or more
) (
  input  wire logic                clk_i,
  input  wire logic                rst_i,      // active high, synchronous

  input  wire logic                start_i,    // one clock: play the frame in the memory
  input  wire logic [BeatBits-1:0] beats_i,    // beats of a row, 1 or more, from start_i to done_o
  input  wire logic [RowBits-1:0]  rows_i,     // 1 or more
  output logic                     done_o,

  // Memory
  output logic                     read_o,
  output logic      [LogWords-1:0] address_o,
  input  wire logic [31:0]         data_i,     // one clock after read_o

  // Video
  output logic                     m_valid_o,
  output logic      [31:0]         m_data_o,   // leftmost pixel in 7..0
  output logic                     m_start_o,  // first beat of a frame
  output logic                     m_end_o     // last beat of a line
);

  if (LogWords < 1) begin : gen_log_words
    log_words_is_less_than_1 u_error ();
  end
  if (BeatBits < 1) begin : gen_beat_bits
    beat_bits_is_less_than_1 u_error ();
  end
  if (RowBits < 1) begin : gen_row_bits
    row_bits_is_less_than_1 u_error ();
  end

  logic [BeatBits-1:0] beat_q;   // beat of the row, from 1
  logic [RowBits-1:0]  row_q;    // row, from 1
  logic                first_q;  // the first beat of the frame
  logic                row_end, frame_end;
  // The same, one clock later, when the memory gives the word.
  logic                valid_q2, first_q2, row_end_q2, frame_end_q2;
  logic                frame_end_q3;

  assign row_end   = beat_q == beats_i;
  assign frame_end = row_end && row_q == rows_i;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      read_o       <= 1'b0;
      valid_q2     <= 1'b0;
      m_valid_o    <= 1'b0;
      frame_end_q3 <= 1'b0;
      done_o       <= 1'b0;
    end else begin
      if (start_i) read_o <= 1'b1;
      else if (frame_end) read_o <= 1'b0;
      valid_q2     <= read_o;
      m_valid_o    <= valid_q2;
      frame_end_q3 <= valid_q2 && frame_end_q2;
      done_o       <= frame_end_q3;
    end
    if (start_i) begin
      address_o <= '0;
      beat_q    <= BeatBits'(1);
      row_q     <= RowBits'(1);
      first_q   <= 1'b1;
    end else if (read_o) begin
      address_o <= address_o + 1'b1;
      beat_q    <= row_end ? BeatBits'(1) : beat_q + 1'b1;
      if (row_end) row_q <= row_q + 1'b1;
      first_q   <= 1'b0;
    end
    first_q2     <= first_q;
    row_end_q2   <= row_end;
    frame_end_q2 <= frame_end;
    m_data_o     <= data_i;
    m_start_o    <= first_q2;
    m_end_o      <= row_end_q2;
  end

endmodule

`default_nettype wire
