// One field of a packet header. It is taken in the clock in which it is known, and delayed until
// the header of the frame before has left.
//
// Guarantees: value_o has the value of a frame from Shown clocks after its start until Shown clocks
// after the next start, however close the two starts are. There is one register for each clock
// between Known and Shown.
`default_nettype none

module sp_header_field #(
  parameter int Width = 16,  // 1 or more
  parameter int Known = 3,  // clocks after the frame start
  parameter int Shown = 4   // clocks after the frame start; more than Known
) (
  input  wire logic                 clk_i,

  input  wire logic [Shown-1:Known] started_i,  // bit k: a frame started k clocks ago
  input  wire logic [Width-1:0]     value_i,    // of the frame that started Known clocks ago
  output logic      [Width-1:0]     value_o
);

  if (Width < 1) begin : gen_width
    width_is_less_than_1 u_error ();
  end
  if (Shown <= Known) begin : gen_shown
    shown_is_not_more_than_known u_error ();
  end

  // Values taken Known, Known + 1, ... clocks after the start, the earliest in the lowest bits
  logic [(Shown-Known)*Width-1:0] value_q;

  for (genvar k = Known; k < Shown; k++) begin : gen_stage
    if (k == Known) begin : gen_take
      always_ff @(posedge clk_i) if (started_i[k]) value_q[0+:Width] <= value_i;
    end else begin : gen_hand_on
      always_ff @(posedge clk_i) if (started_i[k]) value_q[(k-Known)*Width+:Width] <=
          value_q[(k-Known-1)*Width+:Width];
    end
  end

  assign value_o = value_q[(Shown-1-Known)*Width+:Width];

endmodule

`default_nettype wire
