"""The vectors of a co-simulation, played through the circuits in Icarus and to a design in VHDL in GHDL.

    vectors_test.py SELFPROJ-SIM [--vhdl]

Without --vhdl `cosim --vectors` writes what the model computes, and the RTL must send it; --vhdl compares what a
design behind the board reads (status 77: there is no GHDL). A changed word must be found in both.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from lib import rtl_tree  # noqa: E402

EXAMPLE = ROOT / "tests" / "rtl" / "example"
SKIPPED = 77


def run(folder, *words):
    done = subprocess.run(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.returncode, done.stdout


def must(folder, *words):
    status, out = run(folder, *words)
    if status:
        sys.exit(f"{' '.join(map(str, words))}: status {status}\n{out}")
    return out


def change(path, word):
    """Changes bit 7 of a word, counted from 0: a pixel becomes lit, or a moment another."""
    lines = path.read_text(encoding="ascii").splitlines(keepends=True)
    old = lines[word + 1].rstrip()  # behind the comment
    lines[word + 1] = f"{int(old, 16) ^ 0x80:0{len(old)}x}\n"
    path.write_text("".join(lines), encoding="ascii")


# Recorded images, in mode binary; and a scene in mode grey-over, with an encoder that turns
RUNS = {"images": ["--frames", "frames/*.png", "--roi", "64x16+200+40", "--threshold", "60"],
        "scene": ["--scene", "stairs", "--first", "500", "--count", "2", "--mode", "grey-over"]}
COLUMNS = {"images": 128, "scene": 1024}


def vectors(folder, program, run):
    must(folder, program, "cosim", *RUNS[run], "--engine", "model", "--vectors", run)


def circuits(folder):
    must(folder, "iverilog", "-g2012", "-o", "vectors", "-s", "vectors_tb",
         *map(str, rtl_tree.sources_of("sp_board")), str(EXAMPLE / "camera_to_dma.sv"), str(EXAMPLE / "vectors_tb.sv"))
    return lambda name: run(folder, "vvp", "-n", "vectors", f"+vectors={name}")


def vhdl(folder):
    if shutil.which("ghdl") is None:
        print("skipped: there is no GHDL (scripts/setup.sh tests)")
        sys.exit(SKIPPED)
    must(folder, "ghdl", "-a", "--std=08", str(ROOT / "rtl" / "common" / "sp_spec_pkg.vhd"),
         str(EXAMPLE / "column_reader.vhd"), str(EXAMPLE / "column_reader_tb.vhd"))
    return lambda name: run(folder, "ghdl", "--elab-run", "--std=08", "column_reader_tb", f"-gFOLDER={name}")


def main():
    program, with_vhdl = sys.argv[1], "--vhdl" in sys.argv
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        must(folder, program, "scene", "render", "stairs", "--count", "2", "--out", "frames")
        bench = vhdl(folder) if with_vhdl else circuits(folder)
        for name, columns in COLUMNS.items():
            vectors(folder, program, name)
            status, out = bench(name)
            wanted = f"{columns} columns in 2 packets" if with_vhdl else "2 packets"
            if status or f"{wanted} as expected" not in out:
                sys.exit(f"{name}: status {status}\n{out}")
        for file in ("packets.hex", "columns.hex") if with_vhdl else ("camera.hex",):
            vectors(folder, program, "images")
            change(folder / "images" / file, 10)
            status, out = bench("images")
            if status == 0:
                sys.exit(f"a changed word of {file} was not found\n{out}")
        if not with_vhdl:
            camera = folder / "images" / "camera.hex"
            camera.write_text(camera.read_text(encoding="ascii").replace("pixels of 8 bits", "pixels of 12 bits"),
                              encoding="ascii")
            status, out = bench("images")
            if status == 0 or "pixels have 12 bits; camera_to_dma takes 8" not in out:
                sys.exit(f"pixels of 12 bits: status {status}\n{out}")
    print("as expected")


if __name__ == "__main__":
    main()
