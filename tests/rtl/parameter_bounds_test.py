#!/usr/bin/env python3
"""The range that is stated beside a parameter is the range that Verilator, Icarus and Yosys accept.

    parameter_bounds_test.py [MODULE...]

The comment of every `parameter int` states its range. Each bound is tried from both sides: a module with the last good
value elaborates without a message; with the first bad one each of the three programs ends and names a rule (an instance
`u_error`). Every rule in rtl/ is seen in this way. Standard library only.
"""

import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "docs/site")]
import modules  # noqa: E402
from lib import rtl_tree  # noqa: E402

RULE = re.compile(r"^\s+(\w+) u_error \(\);$", re.MULTILINE)
MORE = [ROOT / "constraints" / path
        for path in ("acorn/acorn_dma.sv", "lvds_sensor/ecp5_lvds_sensor.sv", "common/ecp5_pll.sv")]
# What a module needs besides
CELLS = {"ecp5_lvds_sensor": [ROOT / "constraints" / "common" / f"{name}.sv"
                              for name in ("ecp5_cells", "ecp5_gearing_start")],
         "ecp5_pll": [ROOT / "constraints" / "common" / "ecp5_cells.sv"]}

# Bounds that depend on other parameters: good settings as they stand on a command line, then bad ones
BOUNDS = {
    ("sp_ram", "Depth"): (["LogDepth=1 Depth=1", "LogDepth=3 Depth=8"], ["Depth=0", "LogDepth=3 Depth=9"]),
    ("sp_packet_fifo", "PacketWords"): (["PacketWords=1", "LogDepth=3 PacketWords=8"],
                                        ["PacketWords=0", "LogDepth=3 PacketWords=9"]),
    ("sp_counter", "ResetValue"): (["ResetValue=32'hFFFFFFFE"], ["ResetValue=32'h000000FF"]),
    ("sp_board", "CodesLogDepth"): (["Codes=1'b1 CodesLogDepth=3", "Codes=1'b1 CodesLogDepth=15"],
                                    ["Codes=1'b1 CodesLogDepth=2", "Codes=1'b1 CodesLogDepth=16"]),
    ("sp_moments_path", "Compact"): (["Compact=1'b1"], ["Compact=1'b1 Grey=1'b0"]),
    ("sp_moments_path", "Lanes"): (["Lanes=4 Verdict=1'b1", "Lanes=8 Compact=1'b1 Verdict=1'b1", "Lanes=16 MaxColumns=32",
                                    "Lanes=16 MaxColumns=32 Grey=1'b0"],
                                   ["Lanes=3", "Lanes=5", "Lanes=32"]),
    ("sp_board", "Lanes"): (["Lanes=4", "Lanes=8 Codes=1'b1", "Lanes=16 MaxColumns=48 Codes=1'b1"],
                            ["Lanes=3", "Lanes=5", "Lanes=32"]),
    ("sp_board", "MaxRows"): (["MaxRows=2", "MaxRows=1023", "MaxRows=2047", "MaxRows=2047 PixelBits=10"],
                              ["MaxRows=1", "MaxRows=1024", "MaxRows=2046", "MaxRows=2048", "MaxRows=2047 PixelBits=11",
                               "MaxRows=2047 Verdict=1'b1"]),
    ("sp_image_packer", "PixelBytes"): (["PixelBytes=1 Lanes=16", "PixelBytes=2 Lanes=8", "PixelBytes=2 Lanes=16"],
                                        ["PixelBytes=0", "PixelBytes=3"]),
    ("sp_frame_size", "Lanes"): (["Lanes=4", "Lanes=8", "Lanes=16 ColumnBits=13"],
                                 ["Lanes=3", "Lanes=5", "Lanes=16 ColumnBits=12"]),
    ("sp_frame_size", "ColumnBits"): (["GroupBits=9 ColumnBits=11", "GroupBits=9 ColumnBits=12 Lanes=8"],
                                      ["GroupBits=9 ColumnBits=10", "GroupBits=9 ColumnBits=11 Lanes=8"]),
    ("sp_header_field", "Known"): ([], []),
    ("sp_header_field", "Shown"): (["Known=3 Shown=4"], ["Known=3 Shown=3"]),
    ("sp_gray_memory", "Words"): (["Words=1", "Words=88 BankBits=1"], ["Words=0", "Words=89 BankBits=1"]),
    ("sp_gray_memory", "BankBits"): (["Words=2 BankBits=1", "BankBits=24"], ["Words=2 BankBits=0", "BankBits=25"]),
    ("sp_replay", "MaxColumns"): (["MaxColumns=4", "MaxColumns=8 MaxRows=1", "MaxColumns=2048"],
                                  ["MaxColumns=0", "MaxColumns=6", "MaxColumns=4 MaxRows=1", "MaxColumns=2052"]),
    ("sp_test_camera", "FrameClocks"): (["Columns=64 Rows=13 FrameClocks=208"],
                                        ["Columns=64 Rows=13 FrameClocks=207"]),
    ("sp_test_camera", "Columns"): (["Columns=8", "Columns=2048 FrameClocks=49152"],
                                    ["Columns=0", "Columns=12", "Columns=2056 FrameClocks=99999"]),
    ("sp_test_camera", "Rows"): (["Rows=5", "Rows=1023 FrameClocks=130944"],
                                 ["Rows=4", "Rows=1024 FrameClocks=131072"]),
    ("sp_datagram_cutter", "LogDepth"): (["LogDepth=7", "LogDepth=24"], ["LogDepth=6", "LogDepth=25"]),
    ("sp_camera_link", "Taps"): (["Taps=1", "Taps=4", "Taps=8", "Taps=10"],
                                 ["Taps=0", "Taps=5", "Taps=7", "Taps=9", "Taps=11"]),
    ("sp_camera_link", "Columns"): (["Taps=8 Columns=516", "Taps=10 Columns=512"],
                                    ["Taps=8 Columns=514", "Taps=10 Columns=65536", "Taps=4 Columns=512"]),
    ("sp_camera_link", "LogWords"): (["Taps=8 LogWords=1", "Taps=10 LogWords=24"],
                                     ["Taps=8 LogWords=0", "Taps=8 LogWords=25"]),
    ("sp_camera_link_channel", "Eighty"): (["Part=1'b1 Eighty=1", "Part=1'b1 Eighty=4"],
                                           ["Part=1'b1 Eighty=5", "Eighty=1"]),
    ("sp_camera_link_channel", "PlaceBits"): (["PlaceBits=0", "Part=1'b1 PlaceBits=8"],
                                              ["Part=1'b1 PlaceBits=9", "PlaceBits=1"]),
    ("sp_channel_link_align", "LogGood"): (["LogGood=1", "LogGood=19 LogPatience=20"],
                                           ["LogGood=0", "LogGood=20 LogPatience=20"]),
    ("sp_channel_link_align", "LogPatience"): (["LogGood=5 LogPatience=6", "LogPatience=20"],
                                               ["LogGood=4 LogPatience=5", "LogPatience=8", "LogPatience=21"]),
    ("sp_wide_beats", "Columns"): (["Columns=0", "Columns=4", "Columns=512 Taps=10", "Columns=65532 Taps=10"],
                                   ["Columns=2", "Columns=511", "Columns=65536"]),
    ("sp_camera_link_taps", "Bits"): (["Bits=8", "Taps=2 Bits=10", "Taps=1 Bits=12"],
                                      ["Bits=10", "Taps=2 Bits=9", "Taps=1 Bits=14"]),
    ("sp_lvds_flags", "Columns"): (["Columns=1 Burst=1", "Columns=4096"], ["Columns=0", "Columns=4097 Burst=1"]),
    ("sp_lvds_flags", "Burst"): (["Burst=1", "Columns=4096 Burst=4096"], ["Burst=0", "Burst=48"]),
    ("sp_lvds_columns", "Columns"): (["Columns=16", "Columns=4096"], ["Columns=0", "Columns=24", "Columns=4112"]),
    ("ecp5_pll", "Phase"): (["Phase=0", "SecondDivider=4 Phase=31", "SecondDivider=65 Phase=511"],
                            ["SecondDivider=4 Phase=32", "SecondDivider=65 Phase=512"]),
    ("sp_lvds_sensor", "Columns"): (["Columns=16 Burst=16", "Columns=4096"],
                                    ["Columns=0", "Columns=24 Burst=24", "Columns=4112 Burst=16"]),
    ("sp_lvds_sensor", "Checked"): (["Codes=1'b1 Checked=1'b1"], ["Checked=1'b1", "Codes=1'b1 Bits=8 Checked=1'b1"]),
    ("sp_lvds_sensor", "Bits"): (["Bits=10", "Bits=12", "Codes=1'b1 Bits=8", "Codes=1'b1 Bits=10"],
                                 ["Bits=8", "Bits=13", "Codes=1'b1 Bits=12"]),
}
for same, like in ((("sp_replay_receiver", "MaxColumns"), ("sp_replay", "MaxColumns")),
                   (("sp_link", "LogDepth"), ("sp_datagram_cutter", "LogDepth")),
                   (("sp_camera_link_channel", "Bits"), ("sp_camera_link_taps", "Bits")),
                   (("sp_camera_link", "Bits"), ("sp_camera_link_taps", "Bits")),
                   (("sp_lvds_sensor", "Burst"), ("sp_lvds_flags", "Burst")),
                   (("ecp5_lvds_sensor", "Burst"), ("sp_lvds_flags", "Burst")),
                   *((("ecp5_lvds_sensor", name), ("sp_lvds_sensor", name)) for name in ("Columns", "Checked", "Bits"))):
    BOUNDS[same] = BOUNDS[like]
BOUNDS["sp_camera_link", "Bits"] = (BOUNDS["sp_camera_link", "Bits"][0] + ["Taps=8 Bits=10"], [
    "Taps=3 Bits=10", "Taps=4 Bits=10", "Taps=8 Bits=12", "Taps=10 Bits=10", "Bits=9"])
# Rules of sp_packetizer about the specification, not about parameters
OF_SPECIFICATION = {"the_header_has_not_4_beats_or_the_trailer_not_1", "the_sequence_is_not_known_for_the_first_beat",
                    "the_count_of_lost_packets_is_right_in_beats_1_and_2_only"}
# What else is set, so that less is elaborated
WITH = {top: ["MaxColumns=64", "MaxRows=40"]
        for top in ("sp_board", "sp_codes_path", "sp_moments_path", "sp_gray_core")}
# How a program ends where a width becomes 0, or a divisor, before it comes to the rule
ENDS = re.compile(r"ERROR: Static cast with zero or negative size!|Size-changing cast to zero or negative size|"
                  r"Cast size expression must be constant and greater than zero|"
                  r"Internal Error: .*sp_sync.*4-state|LITENDIAN: .*\[-1:0\]")
# Reports of newer versions of Verilator; what Icarus does not support and need not (lint_rtl.sh)
UNINTERESTING = re.compile(r"^- V( e r i l|erilator: )|sorry: constant selects in always_\* processes")
VERILATOR = shutil.which("verilator_bin") or "verilator"  # without its wrapper, which takes longer than the elaboration


def stated(name, comment):
    """The values at the bounds that a comment states: good ones, then bad ones; None where it states no range."""
    step = int((re.search(r"multiple of (\d+)", comment) or [1, 1])[1])
    if found := re.search(r"\b(\d+)\.\.(\d+)\b(?!\^)", comment):
        low, high = map(int, found.groups())
        good, bad = [low, high], [low - step, high + step]
    elif found := re.search(r"\b(\d+) or more", comment):
        good, bad = [int(found[1])], [int(found[1]) - 1]
    elif found := re.search(r"\b(\d+(?:, \d+)*) or (\d+)", comment):
        good = [int(number) for number in [*found[1].split(", "), found[2]]]
        bad = [value for value in range(good[0] - 1, good[-1] + 2) if value not in good]
        bad = [bad[0], bad[len(bad) // 2], bad[-1]]
    elif step > 1:
        good, bad = [step], [0]
    else:
        return None
    bad += [good[0] + step // 2] if step > 1 else []
    return [f"{name}={value}" for value in good], [f"{name}={value}" for value in bad if value >= 0]


def parameters_of(text, module):
    """(name, comment) of the parameters that a user may set and that may be out of range."""
    if not re.search(rf"^module {module} #\(", text, re.MULTILINE):
        return
    for heading, declaration, comment in modules.declarations_in(text, module, r"#\(", r"\) \("):
        comment = comment or heading or ""
        if comment.startswith("derived, do not set"):
            continue
        name = modules.PARAMETER.match(declaration)[1]
        if declaration.startswith("parameter int") or (module, name) in BOUNDS:
            yield name, comment


def run(tool, top, files, settings):
    """Status and messages of a program that elaborates a module."""
    if tool == "verilator":
        command = [VERILATOR, "--lint-only", "-Wall", "-Wno-fatal", "--top-module", top,
                   *(f"-G{one}" for one in settings), *files]
    elif tool == "iverilog":
        command = ["iverilog", "-g2012", "-Wall", "-Wno-timescale", "-t", "null", "-s", top,
                   *(f"-P{top}.{one}" for one in settings), *files]
    else:
        # -defer: every module only with the parameters that it gets
        read = rtl_tree.read_command(top, settings, files=files).replace("-sv", "-sv -defer", 1)
        command = ["yosys", "-q", "-p", f"{read}hierarchy -check -top {top}"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    lines = [line for line in done.stdout.splitlines() if not UNINTERESTING.search(line)]
    return done.returncode, "\n".join(lines)


def tried(tool, top, files, settings, good, rules):
    """What is wrong with a case, and the rules that its messages name."""
    status, output = run(tool, top, list(map(str, files)), settings)
    named = set(re.findall(r"\b\w+\b", output)) & rules
    if good and (status or output):
        return f"{top} {' '.join(settings)}: {tool} refuses it: {output.splitlines()[:3]}", set()
    if not good and (status == 0 or not named and not ENDS.search(output)):
        return f"{top} {' '.join(settings)}: {tool} names no rule: {output.splitlines()[:3]}", set()
    return None, named


def wrong(modules, texts):
    """What is wrong with modules of the sources {path: text}, and the rules that were seen."""
    rules = {name for text in texts.values() for name in RULE.findall(text)}
    faults, jobs, seen = [], [], set()
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for path in (path for path in texts if path.stem in modules):
            files = [*rtl_tree.needed(path.stem, texts), *CELLS.get(path.stem, [])]
            for name, comment in parameters_of(texts[path], path.stem):
                sides = BOUNDS.get((path.stem, name)) or stated(name, comment)
                if not sides:
                    faults.append(f"{path.name}: the comment of {name} states no range")
                    continue
                more = [one for one in WITH.get(path.stem, []) if not one.startswith(f"{name}=")]
                jobs += [pool.submit(tried, tool, path.stem, files, [*settings.split(), *more], side == 0, rules)
                         for side in (0, 1) for settings in sides[side] for tool in ("verilator", "iverilog", "yosys")]
        for job in jobs:
            fault, named = job.result()
            faults += [fault] if fault else []
            seen |= named
    return faults, seen, len(jobs)


def main():
    paths = [*rtl_tree.sources(), *MORE]
    texts = {path: path.read_text(encoding="utf-8") for path in paths}
    modules = set(sys.argv[1:]) or {path.stem for path in paths}
    faults, seen, count = wrong(modules, texts)
    if not sys.argv[1:]:
        for path, text in texts.items():
            faults += [f"{path.name}: no value breaks the rule {name}" for name in RULE.findall(text)
                       if name not in seen | OF_SPECIFICATION]
        # A rule that is taken out is noticed.
        with tempfile.TemporaryDirectory() as folder:
            path = rtl_tree.plant(folder, "common/sp_pulse.sv", "width_is_not_4_8_12_or_16 u_error ();", "")
            if not wrong({"sp_pulse"}, {file: file.read_text(encoding="utf-8") for file in rtl_tree.sources(path)})[0]:
                faults.append("sp_pulse without its rule is not noticed")
    print("\n".join(faults) or f"{count} elaborations at the bounds of the parameters, {len(seen)} rules seen")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
