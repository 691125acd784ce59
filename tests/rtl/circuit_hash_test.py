"""The hash of scripts/lib/yosys.py tells circuits apart, and nothing else; the order of a netlist follows from its names;
scripts/fpga.py names the worst path of a placement."""

import json
import pathlib
import random
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import fpga  # noqa: E402
from lib import yosys  # noqa: E402

ADD = """
module sp_add #(parameter int Width = 4, parameter bit Spare = 1'b0) (
  input wire logic clk_i, input wire logic rst_i, input wire logic [Width-1:0] a_i, output logic [Width-1:0] sum_o);
  logic [Width-1:0] before_q;
  logic [Width-1:0] words [0:15];
  always_ff @(posedge clk_i) begin
    if (rst_i) before_q <= '0;
    else before_q <= a_i + 4'd3;
    words[a_i] <= before_q;
  end
  assign sum_o = before_q ^ words[a_i];
endmodule
"""
TOP = """
module sp_top (input wire logic clk_i, input wire logic rst_i, input wire logic [3:0] a_i, output logic [3:0] sum_o);
  logic [3:0] half;
  sp_add u_first (.clk_i(clk_i), .rst_i(rst_i), .a_i(a_i), .sum_o(half));
  sp_add u_second (.clk_i(clk_i), .rst_i(rst_i), .a_i(half), .sum_o(sum_o));
endmodule
"""
SPARE = """
  if (Spare) begin : gen_image
    logic unused;
    always_ff @(posedge clk_i) unused <= ^before_q;
  end
endmodule
"""


def hash_of(add=ADD, top=TOP, order=("add.sv", "top.sv")):
    texts = {"add.sv": add, "top.sv": top}
    read = f"read_verilog -sv {' '.join(order)}; "
    return yosys.circuit_hash(read, {pathlib.Path(name): texts[name] for name in order}, "sp_top")


class CircuitHash(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.usual = hash_of()

    def test_names_lines_and_order_are_no_part_of_a_circuit(self):
        for what, other in {
            "a register's name": hash_of(add=ADD.replace("before_q", "zz_q")),
            "a memory's name": hash_of(add=ADD.replace("words", "zz")),
            "an instance's name": hash_of(top=TOP.replace("u_first", "u_zz")),
            "eleven lines more": hash_of(add="// a line\n" * 11 + ADD),
            "the order of the files": hash_of(order=("top.sv", "add.sv")),
            "an option that is off": hash_of(add=ADD.replace("\nendmodule\n", SPARE)),
        }.items():
            self.assertEqual(other, self.usual, what)

    def test_every_change_of_a_circuit_is_seen(self):
        for old, new in (("4'd3", "4'd5"), ("a_i + ", "a_i - "), ("'0;", "4'd1;"), ("if (rst_i)", "if (!rst_i)"),
                         ("before_q ^", "before_q &"), ("words[a_i] <= before_q", "words[a_i] <= a_i"),
                         ("words [0:15]", "words [0:7]")):
            self.assertEqual(ADD.count(old), 1, old)
            self.assertNotEqual(hash_of(add=ADD.replace(old, new)), self.usual, new)
        for old, new in ((".a_i(half)", ".a_i(a_i)"), (".a_i(half)", ".a_i({half[0], half[3:1]})"),
                         ("output logic [3:0]", "output logic [2:0]")):
            self.assertEqual(TOP.count(old), 1, old)
            self.assertNotEqual(hash_of(top=TOP.replace(old, new)), self.usual, new)


class Canonical(unittest.TestCase):
    def test_the_order_follows_from_the_names(self):
        cells = {f"cell_{i}": {"type": "SB_LUT4", "attributes": {"src": f"a.sv:{i}"}, "parameters": {},
                               "connections": {"I0": [i + 2], "O": [i + 3]}} for i in range(20)}
        nets = {f"net_{i}": {"bits": [i + 2], "attributes": {}} for i in range(21)}

        def netlist(seed, renumber, wire=5):
            draw = random.Random(seed)

            def number(bits):
                return [1000 - bit if renumber else bit for bit in bits]

            body = {"attributes": {"top": "1"}, "ports": {"a": {"direction": "input", "bits": number([2])}}}
            for kind, items in (("cells", cells), ("netnames", nets)):
                body[kind] = json.loads(json.dumps(dict(draw.sample(list(items.items()), len(items)))))
            for cell in body["cells"].values():
                cell["attributes"]["src"] = f"b.sv:{draw.randrange(99)}"
                cell["connections"] = {port: number(bits) for port, bits in cell["connections"].items()}
            for net in body["netnames"].values():
                net["bits"] = number(net["bits"])
            body["cells"]["cell_3"]["connections"]["I0"] = number([wire])
            return yosys.canonical(json.dumps({"modules": {"top": body}}))

        self.assertEqual(netlist(1, False), netlist(2, False))
        self.assertEqual(netlist(1, False), netlist(3, True))
        self.assertNotEqual(netlist(1, False), netlist(1, False, wire=9))


PATH = """Info: Critical path report for clock 'clk_i$SB_IO_IN_$glb_clk' (posedge -> posedge):
Info: curr total
Info:  0.5  0.5  Source {first}
Info:  3.5  4.0    Net x budget 1.0 ns (1,1) -> (2,2)
Info:                Sink u_board.u_encoder.zero_q_SB_LUT4_I1_LC.I3
Info:  0.3  4.3  Source u_board.u_encoder.zero_q_SB_LUT4_I1_LC.O
Info:  0.6  4.9    Net y budget 1.0 ns (1,1) -> (2,2)
Info:                Sink u_board.u_info.u_time.low_q_SB_DFF_Q_D_LC.I3
Info: 1.4 ns logic, 4.1 ns routing
"""


class WorstPath(unittest.TestCase):
    def test_a_path_is_named_by_the_register_in_which_it_begins(self):
        for first, begins in (("u_video_in.q_o_SB_DFF_Q_37_DFFLC.O", "`u_video_in.q_o` of the pins → `u_encoder`"),
                              ("u_board.u_encoder.reset_q_SB_DFF_Q_DFFLC.O", "`u_encoder.reset_q` → `u_encoder`")):
            self.assertEqual(fpga.worst_path(PATH.format(first=first)), f"{begins} → `u_info.u_time`")
        self.assertEqual(fpga.worst_path("no report"), "?")


if __name__ == "__main__":
    unittest.main()
