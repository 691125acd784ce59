// Simple dual-port memory: one write port and one read port, each with its own clock. It maps to
// block RAM on every family.
//
// It has Depth words (2^LogDepth by default). Writes stay below Depth; a read beyond it gives an
// undefined word. The contents are undefined after configuration.
//
// Guarantees: rd_data_o is the word at rd_addr_i one clock after rd_en_i and holds until the next
// rd_en_i. A read in the clock of a write to the same address gives an undefined word; the users
// prove that they never use one.
`default_nettype none

module sp_ram #(
  parameter int Width = 32,  // 1 or more
  parameter int LogDepth = 9,  // 1..24
  parameter int Depth = 1 << LogDepth  // words: 1..2^LogDepth
) (
  input  wire logic                wr_clk_i,
  input  wire logic                wr_en_i,
  input  wire logic [LogDepth-1:0] wr_addr_i,
  input  wire logic [Width-1:0]    wr_data_i,

  input  wire logic                rd_clk_i,
  input  wire logic                rd_en_i,
  input  wire logic [LogDepth-1:0] rd_addr_i,
  output logic      [Width-1:0]    rd_data_o
`ifdef FORMAL
  ,
  input  wire logic [LogDepth-1:0] f_addr_i,  // an address to observe, for the proofs of the users
  output logic [Width-1:0] f_word_o, output logic [4*Width-1:0] f_first_o  // it; words 0 to 3
`endif
);

  if (Width < 1) begin : gen_width
    width_is_less_than_1 u_error ();
  end
  if (LogDepth < 1 || LogDepth > 24) begin : gen_log_depth
    log_depth_is_not_in_1_to_24 u_error ();
  end
  if (Depth < 1 || Depth > 1 << LogDepth) begin : gen_depth
    depth_is_not_in_1_to_2_to_the_log_depth u_error ();
  end

  (* no_rw_check *) logic [Width-1:0] memory[0:Depth-1];

  always_ff @(posedge wr_clk_i) begin
    if (wr_en_i) memory[wr_addr_i] <= wr_data_i;
  end

`ifdef FORMAL
  // A read and a write of one address in the same clock give any word. (With two clocks, the users
  // prove that this never happens.)
  (* anyseq *) logic [Width-1:0] f_any;
  always_ff @(posedge rd_clk_i) begin
    if (rd_en_i) rd_data_o <= wr_en_i && wr_addr_i == rd_addr_i ? f_any : memory[rd_addr_i];
  end
  assign f_word_o = memory[f_addr_i];
`else
  always_ff @(posedge rd_clk_i) begin
    if (rd_en_i) rd_data_o <= memory[rd_addr_i];
  end
`endif

`ifdef FORMAL
  for (genvar word = 0; word < 4 && word < Depth; word++) begin : gen_f_word
    assign f_first_o[word*Width+:Width] = memory[word];
  end
`endif

endmodule

`default_nettype wire
