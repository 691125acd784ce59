// The model of selfproj for benches in SystemVerilog: one function a stage, and one for the whole
// way from an image to a packet. Compile it with selfproj_dpi.c, and link with libselfproj.so.
//
// Images are arrays of bytes, row by row, at least rows * columns of them. The functions return 0,
// or a negative value if something is wrong; then they have written nothing, and last_error() says
// what it was. Results have the bits of the circuits: see selfproj.h, which has the ranges of all
// arguments.
package selfproj_dpi_pkg;

  // Modes, what is measured, kinds of packets: the values of selfproj.h.
  localparam int Binary = 0;
  localparam int Grey = 1;
  localparam int GreyOver = 2;
  localparam int All = 0;
  localparam int Strongest = 1;

  import "DPI-C" function string selfproj_dpi_last_error();

  // Stage 1: column moments. m0, m1, n have at least `columns` entries. With Strongest also the
  // number of runs and the sixteenths of the second run; with All those stay as they are.
  import "DPI-C" function int selfproj_dpi_moments(
    input byte unsigned pixels[], input int rows, input int columns, input int mode,
    input int threshold, input int select, input int gap, input int first_row, input int last_row,
    inout int unsigned m0[], inout int unsigned m1[], inout int unsigned n[],
    inout byte unsigned runs[], inout byte unsigned second[]);

  // Stage 2: the payload of these moments. Returns its bytes.
  import "DPI-C" function int selfproj_dpi_pack(
    input int select, input int mode, input int columns, input int unsigned m0[],
    input int unsigned m1[], input int unsigned n[], input byte unsigned runs[],
    input byte unsigned second[], inout byte unsigned payload[]);

  // The whole way: the packet that the board sends for a frame. Returns its bytes.
  import "DPI-C" function int selfproj_dpi_packet(
    input byte unsigned pixels[], input int rows, input int columns, input int mode,
    input int threshold, input int select, input int gap, input int first_row, input int last_row,
    input longint unsigned sequence_number, input longint unsigned time_stamp,
    input int unsigned encoder, inout byte unsigned packet[]);

  // Gray codes: a decoder for images of one size. take returns 1 if a code image was written.
  import "DPI-C" function chandle selfproj_dpi_gray_create(
    input int rows, input int columns, input int bits, input int threshold);
  import "DPI-C" function void selfproj_dpi_gray_destroy(input chandle gray);
  import "DPI-C" function int selfproj_dpi_gray_take(
    input chandle gray, input byte unsigned pixels[], input int rows, input int columns,
    input int pattern, input int good, inout shortint unsigned codes[]);

  // The 3 x 3 median of a code image.
  import "DPI-C" function int selfproj_dpi_median3x3(
    input shortint unsigned codes[], input int rows, input int columns,
    inout shortint unsigned filtered[]);

  // Matching of `count` code words by a table with count << bits words.
  import "DPI-C" function int selfproj_dpi_match(
    input shortint unsigned codes[], input int count, input int bits,
    input shortint unsigned match_table[], inout shortint unsigned lines[]);

endpackage
