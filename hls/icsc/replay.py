#!/usr/bin/env python3
"""replay.py SHELLS FOLDER [SUITE[.TEST]]: lints the translated shells in the folder SHELLS with Verilator, and replays
the benches of the RTL in them: all, or those of one SUITE (ColumnMoments, ColumnRuns, GrayDecoder, Median3x3,
VerdictWhole), or one of them.

Each test of the benches whose first module is one of the five blocks records its inputs and outputs (recorder.h). They
are replayed in the translation, together with its memories: an output that differs is a fault. The recordings and the
simulations are in FOLDER. SELFPROJ_RTL_BLOCKS names the program with the benches. The exit status is 1 if an output
differs or a block is not compared, and 2 if a file is missing.
"""
import collections
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
REPLAY = ROOT / "tests" / "rtl" / "blocks" / "icarus_replay.py"
# The module with the ports of the RTL, the suite of its benches, the translated file, and a port by whose width the
# recordings are known that fit. (Some ports of the decoder are wider than in its benches. The rest is 0.)
Block = collections.namedtuple("Block", "top suite shell port bits")
BLOCKS = [Block("sp_column_moments_hls", "ColumnMoments", "column_moments_shell.sv", "beat_group_i", 9),
          Block("sp_column_runs_hls", "ColumnRuns", "column_runs_shell.sv", "beat_group_i", 9),
          Block("hls_GrayDecoderShell", "GrayDecoder", "gray_decoder_shell.sv", "mem_data_i", 128),
          Block("sp_median3x3_hls", "Median3x3", "median3x3_shell.sv", "s_codes_i", 64),
          Block("sp_verdict_hls", "VerdictWhole", "verdict_shell.sv", "write_column_i", 11)]
STEPS = "100000"


def files(block, shells):
    """Returns the translation, and the module that puts memories beside it; the decoder's stays outside."""
    around = ROOT / "hls" / "icsc" / f"{block.top}.sv"
    memories = [ROOT / "rtl" / "common" / "sp_ram.sv", around] if around.exists() else []
    return [shells / block.shell, *memories]


def lint(block, shells):
    # ICSC has a style of its own: it leaves it to SystemVerilog to extend and cut numbers. Only the messages that may
    # mean a fault count.
    command = ["verilator", "--lint-only", "-Wno-WIDTH", "-Wno-style", "--top-module", block.top,
               *map(str, files(block, shells))]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode or done.stderr:
        print(f"replay.py: {block.top}: {done.stderr}", file=sys.stderr)
        return False
    return True


def record(block, test, program, folder):
    """Returns the recording of a test, or None where its first module is not the block."""
    recording = folder / f"{block.suite}_{test}"
    environment = os.environ | {"SELFPROJ_RECORD": str(recording), "SELFPROJ_SEED": "1",
                                "SELFPROJ_RECORD_STEPS": os.environ.get("SELFPROJ_RECORD_STEPS", STEPS)}
    done = subprocess.run([program, f"--gtest_filter={block.suite}.{test}"], env=environment, capture_output=True,
                          text=True, check=False)
    if done.returncode:
        sys.exit(f"replay.py: {program}: {block.suite}.{test} failed")
    ports = recording.with_name(recording.name + ".ports").read_text()
    return recording if f" {block.port} {block.bits}\n" in ports else None


def replay(block, recording, shells, folder):
    done = subprocess.run([sys.executable, REPLAY, "--verilator", "--top", block.top, "--vectors", recording, "--out",
                           folder, *files(block, shells)], capture_output=True, text=True, check=False)
    print(done.stdout, end="", flush=True)
    if done.returncode:
        print(f"replay.py: {block.top}: {recording.name}: {done.stderr or 'outputs differ'}", file=sys.stderr)
        return False
    return True


def main():
    suite, _, only = (sys.argv[3] if len(sys.argv) == 4 else "").partition(".")
    blocks = [block for block in BLOCKS if suite in ("", block.suite)]
    if len(sys.argv) not in (3, 4) or not blocks:
        suites = ", ".join(block.suite for block in BLOCKS)
        print(f"replay.py: SHELLS FOLDER [SUITE[.TEST]], with a suite of {suites}", file=sys.stderr)
        return 2
    shells, folder = map(pathlib.Path, sys.argv[1:3])
    program = os.environ.get("SELFPROJ_RTL_BLOCKS", "build/release/tests/rtl/blocks/rtl_blocks")
    for path in [program, *(file for block in blocks for file in files(block, shells))]:
        if not pathlib.Path(path).is_file():
            print(f"replay.py: {path}: no such file", file=sys.stderr)
            return 2
    folder.mkdir(parents=True, exist_ok=True)
    good = True
    for block in blocks:
        good = lint(block, shells) and good
        of_block = f"--gtest_filter={block.suite}.{only or '*'}"
        listed = subprocess.run([program, of_block, "--gtest_list_tests"], capture_output=True, text=True,
                                check=True).stdout
        tests = re.findall(r"^  (\w+)", listed, re.M)
        recordings = [recording for test in tests if (recording := record(block, test, program, folder))]
        if not recordings:
            print(f"replay.py: {block.top}: no bench records it", file=sys.stderr)
            good = False
        for recording in recordings:
            good = replay(block, recording, shells, folder) and good
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
