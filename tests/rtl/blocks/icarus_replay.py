#!/usr/bin/env python3
"""icarus_replay.py --top MODULE --vectors NAME [--parameter P=V]... [--verilator] --out FOLDER FILE...

Replays the inputs of a Verilated model (NAME.ports and NAME.vectors, see recorder.h) in Icarus, and compares every
output after every evaluation. FILEs are the Verilog sources, RTL or a netlist, of the module. An x in the recording
marks an output that is not valid there. Everywhere else the output must be equal to the last bit, and an x of Icarus is
wrong. Prints the number of outputs and evaluations compared. The exit status is 1 if one differs or nothing was
compared.

With --verilator, Verilator takes the place of Icarus, for sources that Icarus does not read. It knows no x.
"""
import argparse
import pathlib
import re
import subprocess
import sys

# Icarus 11 says "sorry" if always_comb reads a constant part of a vector. It then waits for the whole vector, which
# changes no result.
HARMLESS = re.compile(r"sorry: constant selects in always_\* processes are not currently supported")
SHOWN = 10  # mismatches that are printed one by one


def read_ports(path):
    ports = []
    for line in path.read_text(encoding="utf-8").splitlines():
        direction, name, bits = line.split()
        ports.append((direction, name, int(bits)))
    if not ports:
        sys.exit(f"icarus_replay.py: {path}: no ports")
    return ports


def two_valued(vectors, ports, path):
    """Writes the recording with two numbers for each output, its value and whether that counts."""
    outputs = [direction == "output" for direction, _, _ in ports]
    with vectors.open() as lines, path.open("w") as file:
        for line in lines:
            fields = line.split()
            if len(fields) != len(ports):
                sys.exit(f"icarus_replay.py: {vectors}: the recording is broken")
            print(*(f"{'0 0' if 'x' in field else field + ' 1'}" if output else field
                    for field, output in zip(fields, outputs)), file=file)


def bench(top, parameters, ports, vectors, two_values):
    inputs = [(name, bits) for direction, name, bits in ports if direction == "input"]
    outputs = [(name, bits) for direction, name, bits in ports if direction == "output"]
    declare = [f"  reg [{bits - 1}:0] {name};" for name, bits in inputs]
    for name, bits in outputs:
        declare += [f"  wire [{bits - 1}:0] {name};", f"  reg [{bits - 1}:0] want_{name};"]
    if two_values:
        declare += [f"  reg counts_{name};" for name, _ in outputs]
    wants = [f"want_{name}, counts_{name}" if two_values else f"want_{name}" for name, _ in outputs]
    fields = len(inputs) + (2 if two_values else 1) * len(outputs)
    # In a bench like this, Verilator runs clocked processes before what follows from inputs that change in the same
    # moment. The recorded models do it the other way round, so the clock is last here.
    reads = [f"next_{name}" if two_values else name for name, _ in inputs]
    moves = ""
    if two_values:
        declare += [f"  reg [{bits - 1}:0] next_{name};" for name, bits in inputs]
        moves = "".join(f"        {name} = next_{name};\n" for name, _ in inputs if name != "clk_i")
        moves += "        #1;\n        clk_i = next_clk_i;\n"
    values = ", ".join(reads + wants)
    checks = "\n".join(
        f"""        if ({f"counts_{name}" if two_values else f"^want_{name} !== 1'bx"}) begin
          compared = compared + 1;
          if ({name} !== want_{name}) begin
            wrong = wrong + 1;
            if (wrong <= {SHOWN}) $display("evaluation %0d: {name} is %h, not %h", step, {name}, want_{name});
          end
        end""" for name, _ in outputs)
    override = " #(" + ", ".join(f".{p}({v})" for p, v in parameters) + ")" if parameters else ""
    connect = ",\n    ".join(f".{name}({name})" for _, name, _ in ports)
    return f"""`timescale 1ns / 1ns
module icarus_bench;
{chr(10).join(declare)}
  integer file, got, step, compared, wrong;

  {top}{override} dut (
    {connect}
  );

  initial begin
    step = 0;
    compared = 0;
    wrong = 0;
    file = $fopen("{vectors}", "r");
    got = {fields};
    while (got == {fields}) begin
      got = $fscanf(file, "{' '.join(['%h'] * fields)}\\n", {values});
      if (got == {fields}) begin
{moves}        #1;
        step = step + 1;
{checks}
      end
    end
    if (!$feof(file)) $display("the recording is broken after evaluation %0d", step);
    else $display("end: %0d evaluations, %0d outputs compared, %0d wrong", step, compared, wrong);
    $finish;
  end
endmodule
"""


def run(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    lines = [line for line in done.stdout.splitlines() if not HARMLESS.search(line)]
    return done.returncode, lines


def icarus(files, source, binary):
    """Compiles the bench, and returns the command that runs it."""
    # -Wno-timescale: the circuits have none and inherit the bench's
    status, lines = run(["iverilog", "-g2012", "-Wall", "-Wno-timescale", "-s", "icarus_bench", "-o", str(binary),
                         *map(str, files), str(source)])
    if status != 0 or lines:
        sys.exit("\n".join(["icarus_replay.py: iverilog:"] + lines))
    return ["vvp", "-N", str(binary)]


def verilator(files, source, binary):
    """Compiles the bench, and returns the command that runs it."""
    folder = binary.with_suffix(".dir")
    status, lines = run(["verilator", "--binary", "-Wno-lint", "-Wno-style", "-Wno-fatal", "-CFLAGS", "-std=c++20",
                         "--Mdir", str(folder), "--top-module", "icarus_bench", "-o", binary.name, *map(str, files),
                         str(source)])
    if status != 0:
        sys.exit("\n".join(["icarus_replay.py: verilator:"] + lines))
    return [str(folder.resolve() / binary.name)]


def main():
    parser = argparse.ArgumentParser(description="Replays a recording in Icarus and compares every output.")
    parser.add_argument("--top", required=True, help="the module")
    parser.add_argument(
        "--vectors", required=True, type=pathlib.Path, help="the recording, without .ports and .vectors"
    )
    parser.add_argument("--parameter", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--verilator", action="store_true", help="replay in Verilator instead")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder for bench and simulation")
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    args = parser.parse_args()

    ports = read_ports(args.vectors.with_name(args.vectors.name + ".ports"))
    vectors = args.vectors.with_name(args.vectors.name + ".vectors").resolve()
    args.out.mkdir(parents=True, exist_ok=True)
    name = args.vectors.name
    source = args.out / f"{name}_bench.v"
    binary = args.out / f"{name}_bench.vvp"
    parameters = [tuple(p.split("=", 1)) for p in args.parameter]
    if args.verilator:
        two_valued(vectors, ports, args.out / f"{name}.two_valued")
        vectors = (args.out / f"{name}.two_valued").resolve()
    source.write_text(bench(args.top, parameters, ports, vectors, args.verilator), encoding="utf-8")
    status, lines = run((verilator if args.verilator else icarus)(args.files, source, binary))
    lines = [line for line in lines if not re.match(r"- .*\$finish", line)]
    print("\n".join(f"{name}: {line}" for line in lines))
    end = re.fullmatch(r"end: (\d+) evaluations, (\d+) outputs compared, (\d+) wrong", lines[-1] if lines else "")
    if status != 0 or end is None or int(end[2]) == 0 or int(end[3]) != 0:
        sys.exit(1)


main()
