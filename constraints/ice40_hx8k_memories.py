# nextpnr-ice40 runs this file (--pre-place): a site for every block RAM. The board takes 31 of 32 in its grey build. By
# itself the placer spreads the moments' block RAMs over both columns, so that their sums go half across the array and
# back in one clock. Here the sums and the line buffer are in the right column from the bottom up, and the packet FIFO
# is in the left one; the rest of the FIFO is on top of the right one.
import re

LEFT, RIGHT = ([f"X{x}/Y{y}/ram" for y in range(1, 32, 2)] for x in (8, 25))
# The two sums of a lane are side by side.
MOMENTS = ["gen_pair[0].u_m.", "gen_pair[0].u_a.", "gen_pair[1].u_m.", "gen_pair[1].u_a.", "u_line."]

memories = sorted(((name, cell) for name, cell in ctx.cells if cell.type == "ICESTORM_RAM"),
                  key=lambda memory: [int(number) for number in re.findall(r"\d+", memory[0])])
moments = [cell for block in MOMENTS for name, cell in memories if ".u_moments." in name and block in name]
fifo = [cell for name, cell in memories if ".u_fifo." in name]
assert len(moments) + len(fifo) == len(memories), "a memory of neither the moments nor the packet FIFO"
for cell, site in [*zip(moments, RIGHT), *zip(fifo, LEFT + RIGHT[::-1])]:
    cell.setAttr("BEL", site)
