# Run by nextpnr-ice40 (--pre-place): a site for every block RAM. The board takes 31 of 32 in its grey build, and left alone the
# placer puts those of the moments into both columns of them, so that their sums reach half across the array and back in a clock.
# Here the sums and the line buffer stand in the right column from the bottom up, the packet FIFO in the left one; what of it
# has no room there is on top of the right one.
import re

LEFT, RIGHT = ([f"X{x}/Y{y}/ram" for y in range(1, 32, 2)] for x in (8, 25))
MOMENTS = ["gen_pair[0].u_m.", "gen_pair[0].u_a.", "gen_pair[1].u_m.", "gen_pair[1].u_a.", "u_line."]  # a lane's two sums side by side

memories = sorted(((name, cell) for name, cell in ctx.cells if cell.type == "ICESTORM_RAM"),
                  key=lambda memory: [int(number) for number in re.findall(r"\d+", memory[0])])
moments = [cell for block in MOMENTS for name, cell in memories if ".u_moments." in name and block in name]
fifo = [cell for name, cell in memories if ".u_fifo." in name]
assert len(moments) + len(fifo) == len(memories), "a memory of neither the moments nor the packet FIFO"
for cell, site in [*zip(moments, RIGHT), *zip(fifo, LEFT + RIGHT[::-1])]:
    cell.setAttr("BEL", site)
