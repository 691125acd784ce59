// On-chip memory for the state of the Gray-code decoder: Words words, never late.
//
// It serves the memory port of sp_gray_decoder: both sides go through the words in the order of the
// frame, starting with its first word. Timing: rd_data_o is valid two clocks after rd_en_i. A word
// can be read from the clock after its write on.
//
// A memory that fills the FPGA is as wide as the FPGA: no address reaches all of it in one clock,
// and no word comes out of it in one. The memory is therefore a row of groups of four banks, each
// group one clock further from both ports. Words are fetched 16 places (2^AheadBits) before they
// are asked for and wait in a ring. The first words of a frame cannot be fetched ahead, so a small
// memory keeps the first 32 (2^HeadBits). Since these are more than 16, every word taken from the
// ring was written before it was fetched, however short the frame before was.
`default_nettype none

module sp_gray_memory #(
  parameter int Width = 128,  // 1 or more
  parameter int Words = 16384,  // 1 or more, in up to 44 banks
  // address bits of a bank: 1..24
  parameter int BankBits = $clog2(Words) > 16 ? $clog2(Words) - 5 : 11
) (
  input  wire logic             clk_i,

  input  wire logic             rd_en_i,
  input  wire logic             rd_first_i,  // first word of the frame
  output logic      [Width-1:0] rd_data_o,

  input  wire logic             wr_en_i,
  input  wire logic             wr_first_i,
  input  wire logic [Width-1:0] wr_data_i
);

  if (Words < 1) begin : gen_words
    words_is_less_than_1 u_error ();
  end
  if (BankBits < 1 || BankBits > 24) begin : gen_bank_bits
    bank_bits_is_not_in_1_to_24 u_error ();
  end

  localparam int HeadBits = 5, AheadBits = HeadBits - 1;
  localparam int LogDepth = $clog2(Words) > HeadBits ? $clog2(Words) : HeadBits + 1;
  localparam int Banks = (Words + (1 << BankBits) - 1) >> BankBits;
  localparam int Groups = (Banks + 3) / 4;
  // a word is in the ring Groups + Tail < 2^AheadBits clocks after rd_en_i
  localparam int Tail = 4;
  if (Groups + Tail >= 1 << AheadBits) begin : gen_groups
    words_are_more_than_44_banks u_error ();
  end

  // --- The ports: their place in the frame ---
  // fetched with this read; written now
  logic [LogDepth-1:0] fetch_next_q, wr_next_q, fetch, wr_addr;
  logic                rd_head_q, wr_head_q, rd_head, wr_head;   // among the first 2^HeadBits words
  logic [HeadBits-1:0] rd_place;                                 // lowest bits of the address read

  assign fetch    = rd_first_i ? LogDepth'(1 << AheadBits) : fetch_next_q;
  assign rd_place = {~fetch[HeadBits-1], fetch[AheadBits-1:0]};
  assign rd_head  = rd_first_i || rd_head_q;
  assign wr_addr  = wr_first_i ? '0 : wr_next_q;
  assign wr_head  = wr_first_i || wr_head_q;

  always_ff @(posedge clk_i) begin
    if (rd_en_i) begin
      fetch_next_q <= fetch + LogDepth'(1);
      rd_head_q    <= rd_head && rd_place != '1;
    end
    if (wr_en_i) begin
      wr_next_q <= wr_addr + LogDepth'(1);
      wr_head_q <= wr_head && wr_addr[HeadBits-1:0] != '1;
    end
  end

  // --- The row of groups. Inputs reach the registers of group g after g + 1 clocks. A word fetched
  // there takes four more clocks to the row of words, where it joins those of the other groups in
  // the order of their reads. The bank is chosen one clock ahead, so that every wire across a group
  // runs from register to register. ---
  // a row: the next input of each group
  logic [Groups-1:0]          rd_en_q, wr_en_q, rd_en_row, wr_en_row;
  logic [Groups*LogDepth-1:0] fetch_q, wr_addr_q, fetch_row, wr_addr_row;
  logic [Groups*Width-1:0]    wr_data_q, words_q;

  assign rd_en_row   = Groups'({rd_en_q, rd_en_i});
  assign wr_en_row   = Groups'({wr_en_q, wr_en_i});
  assign fetch_row   = (Groups * LogDepth)'({fetch_q, fetch});
  assign wr_addr_row = (Groups * LogDepth)'({wr_addr_q, wr_addr});

  always_ff @(posedge clk_i) begin
    rd_en_q   <= rd_en_row;
    wr_en_q   <= wr_en_row;
    fetch_q   <= fetch_row;
    wr_addr_q <= wr_addr_row;
    wr_data_q <= (Groups * Width)'({wr_data_q, wr_data_i});
  end

  for (genvar g = 0; g < Groups; g++) begin : gen_group
    logic [LogDepth-1:0] rd_next, wr_next, rd_here, wr_here;
    logic [3:0]          reads;   // the banks that read now
    logic [3:1]          mine_q;  // the word is of this group; one to three clocks after its read
    logic [1:0]          which1_q, which2_q;
    logic [4*Width-1:0]  banks;
    logic [Width-1:0]    chosen_q;

    assign rd_next = fetch_row[g*LogDepth+:LogDepth];
    assign wr_next = wr_addr_row[g*LogDepth+:LogDepth];
    assign rd_here = fetch_q[g*LogDepth+:LogDepth];
    assign wr_here = wr_addr_q[g*LogDepth+:LogDepth];

    always_ff @(posedge clk_i) begin
      mine_q   <= {mine_q[2:1], reads != '0};
      which1_q <= 2'(32'(rd_here) >> BankBits);
      which2_q <= which1_q;
      if (mine_q[2]) chosen_q <= banks[32'(which2_q)*Width+:Width];
    end

    if (g == 0) begin : gen_first
      always_ff @(posedge clk_i) if (mine_q[3]) words_q[0+:Width] <= chosen_q;
    end else begin : gen_next
      always_ff @(posedge clk_i) words_q[g*Width+:Width] <= mine_q[3] ? chosen_q :
                                                            words_q[(g-1)*Width+:Width];
    end

    for (genvar b = 0; b < 4; b++) begin : gen_bank
      localparam int Bank = 4 * g + b;
      if (Bank < Banks) begin : gen_there
        localparam int Left = Words - (Bank << BankBits);
        localparam int Depth = Left < (1 << BankBits) ? Left : 1 << BankBits;
        localparam int AddrBits = Depth > 1 ? $clog2(Depth) : 1;
        logic             read_q, read2_q, write_q;
        logic [Width-1:0] word, word_q;
        assign banks[b*Width+:Width] = word_q;
        assign reads[b] = read_q;
        always_ff @(posedge clk_i) begin
          read_q  <= rd_en_row[g] && 32'(rd_next) >> BankBits == Bank;
          read2_q <= read_q;
          write_q <= wr_en_row[g] && 32'(wr_next) >> BankBits == Bank;
          if (read2_q) word_q <= word;
        end
        sp_ram #(
          .Width   (Width),
          .LogDepth(AddrBits),
          .Depth   (Depth)
        ) u_ram (
          .wr_clk_i (clk_i),
          .wr_en_i  (write_q),
          .wr_addr_i(AddrBits'(32'(wr_here))),
          .wr_data_i(wr_data_q[g*Width+:Width]),
          .rd_clk_i (clk_i),
          .rd_en_i  (read_q),
          .rd_addr_i(rd_here[AddrBits-1:0]),
          .rd_data_o(word)
        );
      end else begin : gen_none
        assign banks[b*Width+:Width] = '0;
        assign reads[b] = 1'b0;
      end
    end
  end

  // --- Near memories: the ring of fetched words, and the first words of the frame ---
  logic [Tail:1]              arrived_q;  // at the last group, so many clocks ago
  logic [Tail*AheadBits-1:0]  place_q;
  logic [Width-1:0]           ring_word, head_word;
  logic                       head_q;

  always_ff @(posedge clk_i) begin
    arrived_q <= {arrived_q[Tail-1:1], rd_en_q[Groups-1]};
    place_q   <= (Tail * AheadBits)'({place_q, fetch_q[(Groups-1)*LogDepth+:AheadBits]});
    if (rd_en_i) head_q <= rd_head;
    rd_data_o <= head_q ? head_word : ring_word;
  end

  sp_ram #(
    .Width   (Width),
    .LogDepth(AheadBits)
  ) u_ring (
    .wr_clk_i (clk_i),
    .wr_en_i  (arrived_q[Tail]),
    .wr_addr_i(place_q[(Tail-1)*AheadBits+:AheadBits]),
    .wr_data_i(words_q[(Groups-1)*Width+:Width]),
    .rd_clk_i (clk_i),
    .rd_en_i  (rd_en_i),
    .rd_addr_i(rd_place[AheadBits-1:0]),
    .rd_data_o(ring_word)
  );

  sp_ram #(
    .Width   (Width),
    .LogDepth(HeadBits)
  ) u_head (
    .wr_clk_i (clk_i),
    .wr_en_i  (wr_en_i && wr_head),
    .wr_addr_i(wr_addr[HeadBits-1:0]),
    .wr_data_i(wr_data_i),
    .rd_clk_i (clk_i),
    .rd_en_i  (rd_en_i),
    .rd_addr_i(rd_place),
    .rd_data_o(head_word)
  );

endmodule

`default_nettype wire
