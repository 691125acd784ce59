# Assigns every block RAM to a site, and confines the packetizer and the sums of the moments to regions. nextpnr-ice40
# runs this file with --pre-place.
#
# The grey build of the board takes 31 of 32 block RAMs, and a binary build with runs takes all. Without constraints,
# the placer spreads those of the moments over both columns. Then the sums have to cross half of the array and come back
# in one clock. This file puts the sums and the line buffer into the right column from the bottom up. The packet FIFO
# fills the left column, and the rest of it goes to the top of the right column.
#
# The packetizer stays in the left half beside the FIFO, which it feeds. Without this region it would spread towards the
# moments, from which it takes its data.
#
# The logic of the sums stays in the right half. That of two lanes stays beside the block RAMs of these lanes. All cells
# of a tile share one reset. Where no tile nearby has the right reset, the placer puts a cell somewhere else, and
# without a region that was half the array away from its adder.
import re

LEFT, RIGHT = ([(x, y) for y in range(1, 32, 2)] for x in (8, 25))
# The two sums of a pair of lanes are side by side. The last seven are only in builds with the strongest runs.
MOMENTS = ["gen_pair[0].u_m.", "gen_pair[0].u_a.", "gen_pair[1].u_m.", "gen_pair[1].u_a.", "u_line.",
           "gen_lane[0].u_best.", "gen_lane[1].u_best.", "u_sums.u_d.", "u_sums.u_m.", "u_sums.u_a.",
           "gen_lane[2].u_best.", "gen_lane[3].u_best."]
NEAR = 6  # rows of tiles beyond the block RAMs of two lanes


def lanes_of(name):
    """Returns 0 for a cell of the sums of lanes 0 and 1, 1 for lanes 2 and 3, None for others."""
    found = re.search(r"\.u_sums\..*?\bgen_(pair|lane)\[(\d)\]", name)
    return found and int(found[2]) // (2 if found[1] == "lane" else 1)


memories = sorted(((name, cell) for name, cell in ctx.cells if cell.type == "ICESTORM_RAM"),
                  key=lambda memory: [int(number) for number in re.findall(r"\d+", memory[0])])
moments = [memory for block in MOMENTS for memory in memories if ".u_moments." in memory[0] and block in memory[0]]
fifo = [memory for memory in memories if ".u_fifo." in memory[0]]
assert len(moments) + len(fifo) == len(memories), "a memory of neither the moments nor the packet FIFO"
rows = {0: [], 1: []}
for (name, cell), (x, y) in [*zip(moments, RIGHT), *zip(fifo, LEFT + RIGHT[::-1])]:
    cell.setAttr("BEL", f"X{x}/Y{y}/ram")
    if lanes_of(name) is not None:
        rows[lanes_of(name)].append(y)

ctx.createRectangularRegion("packets", 1, 1, 16, 32)
ctx.createRectangularRegion("sums", 17, 1, 32, 32)
for lanes, of in rows.items():
    ctx.createRectangularRegion(f"sums {lanes}", 17, max(1, min(of) - NEAR), 32, min(32, max(of) + NEAR))
for name, cell in ctx.cells:
    if cell.type == "ICESTORM_LC" and ".u_packetizer." in name:
        ctx.constrainCellToRegion(name, "packets")
    elif cell.type == "ICESTORM_LC" and ".u_sums." in name:
        ctx.constrainCellToRegion(name, "sums" if lanes_of(name) is None else f"sums {lanes_of(name)}")
