// A column-moment circuit that is not of this project: one pixel a clock, sums in an array, read
// out one column a clock. Mode grey_over only. With fault_i the pixel that equals the threshold in
// row 3 counts, too: a fault that few images show.
module their_moments #(
  parameter int Columns = 32
) (
  input  logic        clk_i,
  input  logic        start_i,  // the first pixel of a frame
  input  logic        valid_i,
  input  logic [7:0]  pixel_i,
  input  logic [7:0]  threshold_i,
  input  logic        fault_i,
  input  logic [15:0] column_i,  // to read out, from 0
  output logic [31:0] m0_o,
  output logic [31:0] m1_o,
  output logic [31:0] n_o
);
  logic [31:0] m0[Columns];
  logic [31:0] m1[Columns];
  logic [31:0] n[Columns];
  logic [15:0] row, column;

  logic [15:0] row_now, column_now;
  logic        lit;
  logic [$clog2(Columns)-1:0] at, asked;
  assign row_now = start_i ? 16'd1 : row;
  assign column_now = start_i ? 16'd0 : column;
  assign at = column_now[$clog2(Columns)-1:0];
  assign asked = column_i[$clog2(Columns)-1:0];
  assign lit = pixel_i > threshold_i ||
               (fault_i && row_now == 3 && pixel_i == threshold_i && pixel_i != 0);

  always_ff @(posedge clk_i) begin
    if (valid_i) begin
      // Their weight; with the fault it is 1 where it must be 0.
      automatic logic [31:0] weight = 32'(pixel_i) - 32'(threshold_i);
      if (pixel_i == threshold_i) weight = 1;
      if (!lit) weight = 0;
      m0[at] <= (row_now == 1 ? 0 : m0[at]) + weight;
      m1[at] <= (row_now == 1 ? 0 : m1[at]) + 32'(row_now) * weight;
      n[at] <= (row_now == 1 ? 0 : n[at]) + 32'(lit);
      column <= column_now == 16'(Columns - 1) ? 0 : column_now + 1;
      row <= column_now == 16'(Columns - 1) ? row_now + 1 : row_now;
    end
  end

  assign m0_o = m0[asked];
  assign m1_o = m1[asked];
  assign n_o = n[asked];
endmodule
