# Run by nextpnr-ice40 (--pre-place): a part of the array for each block whose paths are tight. Left alone the placer sets a carry
# chain down half the array away from its registers with one seed in three.
CORE, TRACKER, TRIGGER, PACKETS = (2, 1, 13, 14), (1, 15, 14, 32), (14, 21, 25, 32), (14, 1, 25, 16)  # x0, y0, x1, y1
BOXES = {
    ("u_board.u_moments_path.u_moments.", "ICESTORM_LC"): CORE,
    ("u_board.u_moments_path.u_moments.", "ICESTORM_RAM"): CORE,  # block RAMs are in columns 8 and 25
    ("u_board.u_moments_path.u_packetizer.", "ICESTORM_LC"): PACKETS,
    ("u_board.u_moments_path.u_fifo.", "ICESTORM_LC"): PACKETS,
    ("u_board.u_tracker.", "ICESTORM_LC"): TRACKER,
    ("u_board.u_trigger.", "ICESTORM_LC"): TRIGGER,
}

for box in set(BOXES.values()):
    ctx.createRectangularRegion(str(box), *box)
for name, cell in ctx.cells:
    for (prefix, kind), box in BOXES.items():
        if name.startswith(prefix) and cell.type == kind:
            ctx.constrainCellToRegion(name, str(box))
