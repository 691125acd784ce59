"""The modules that put memories beside the translated shells (hls/icsc/sp_*_hls.sv) fit.

Verilator lints them with an empty module in the shell's place that has the ports of the SystemC source. So every port
is connected, at its width. The outer ports must be those of the RTL.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "hls" / "icsc"))
import bench  # noqa: E402

BITS = {
    "bool": 1,
    "Pixels": 32,
    "Group": 9,
    "Row": 10,
    "ModeBits": 2,
    "Pixel": 8,
    "WideUint<128>": 128,
    "Payload": 128,
    "MWord": 56,
    "AWord": 54,
    "OpenWords": 232,
    "BestWords": 152,
    "RestWords": 188,
    "Uint<2>": 2,
    "Uint<64>": 64,
    "CodeStatus": 5,
    "CodeGroup": 9,
    "CodeLine": 52,
    "VerdictCount": 24,
    "VerdictWord": 32,
    "VerdictPlace": 5,
    "VerdictGroups": 10,
    "VerdictColumns": 12,
    "TablePlace": 13,
    "LimitsWord": 35,
    "PastWord": 28,
    "Uint<16>": 16,
    "Uint<kLanes>": 4,
}


def ports(shell):
    return [(direction, BITS[kind], name) for direction, kind, name in
            re.findall(r"sc_core::sc_(in|out)<(\w+(?:<\w+>)?)> (\w+)\{", bench.source(shell))]


def outer_ports(file, parameters):
    """{name: (direction, bits)} of a module's header."""
    head = file.read_text().split(") (", 1)[-1].split(");", 1)[0]
    found = {}
    for direction, width, name in re.findall(r"(input|output)\s+(?:wire )?logic\s*(\[[^\]]*\])?\s*(\w+)", head):
        bits = 1
        if width:
            high = width.strip("[]").split(":")[0]
            bits = int(eval(high, {}, parameters)) + 1  # arithmetic on the parameters
        found[name] = (direction, bits)
    return found


def main():
    failed = 0
    for name, shell, rtl in (("sp_column_moments_hls", "column_moments", "moments/sp_column_moments.sv"),
                             ("sp_column_runs_hls", "column_runs", "moments/sp_column_runs.sv"),
                             ("sp_median3x3_hls", "median3x3", "gray/sp_median3x3.sv"),
                             ("sp_verdict_hls", "verdict", "verdict/sp_verdict.sv")):
        wrapper = ROOT / "hls" / "icsc" / f"{name}.sv"
        module = re.search(r"hls_\w+Shell", wrapper.read_text()).group()
        listed = ports(shell)
        lines = [
            f"  {'input wire' if direction == 'in' else 'output'} logic [{bits - 1}:0] {port}"
            for direction, bits, port in listed
        ]
        with tempfile.TemporaryDirectory() as folder:
            stub = pathlib.Path(folder) / f"{module}.sv"
            stub.write_text(f"module {module} (\n" + ",\n".join(lines) + "\n);\nendmodule\n")
            lint = subprocess.run(
                [
                    "verilator", "--lint-only", "-Wall", "-Wno-UNDRIVEN", "-Wno-UNUSED", "--top-module", name,
                    ROOT / "rtl" / "common" / "sp_ram.sv", stub, wrapper,
                ],
                capture_output=True,
                text=True,
                check=False,
            )
        if lint.returncode or lint.stderr:
            print(f"{name}: {lint.stderr}", file=sys.stderr)
            failed = 1
        parameters = {"PixelBits": 8, "Lanes": 4, "GroupBits": 9, "RowBits": 10, "ColumnBits": 12, "LimitBits": 17,
                      "SectionBits": 1, "LogWords": 5, "sp_spec_pkg__StatusBits": 5}
        source = (ROOT / "rtl" / rtl)
        with tempfile.TemporaryDirectory() as folder:
            plain = pathlib.Path(folder) / "rtl.sv"
            plain.write_text(re.sub(r"//[^\n]*", "", source.read_text()).replace("sp_spec_pkg::", "sp_spec_pkg__"))
            want = outer_ports(plain, parameters)
            plain.write_text(wrapper.read_text().replace(f"module {name} (", f"module {name} #() ("))
            have = outer_ports(plain, parameters)
        if not want or want != have:
            print(f"{name}: ports {have} instead of {want}", file=sys.stderr)
            failed = 1
        print(f"{name}: {len(listed)} ports of the shell, {len(have)} of the RTL")
    return failed


if __name__ == "__main__":
    sys.exit(main())
