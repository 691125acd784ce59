#!/usr/bin/env python3
"""mutation.py [--sample N] [--jobs N] [--table FILE] [--folder FOLDER] [MODEL...]: runs the tests of tests/rtl on more
than a thousand mutants of the blocks and the board, or on those of the models named (Vsp_fifo, ...).

It builds them in build/release, unless FOLDER has what tests/netlist/CMakeLists.txt builds: programs mutants_*, and
mutants/MODEL/MODEL.mutants. A mutant is killed if a test that uses the model fails, or takes more than ten times its
usual time. The tests run one by one, the quickest first, at first with one seed. Survivors go to Yosys: a mutant does
not count if every output is proved equal to the original's. Mutants without such a proof then meet all tests with all
seeds. With --sample only the first N mutants of each model run, without proofs: a quick check that the tools still
work. The exit status is 1 if fewer than 95 % of the mutants that are not proved equal are killed.

If SELFPROJ_RESULTS names a folder, the figures of all models are written into its mutation.json. With MODELs, only the
entries of these models are replaced. Each entry has the commit of its own run. Standard library only.
"""

import argparse
import collections
import concurrent.futures
import dataclasses
import datetime
import functools
import itertools
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import results

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "release"
TARGET = 0.95
QUICK_S = 5
PROOF_LIMIT_S = 20
PROOF_MEMORY_BITS = 16384  # each becomes a register; with more, no proof ends in time


class MutationError(Exception):
    """The tests fail without a mutation, or a tool fails."""


@dataclasses.dataclass
class Program:
    path: pathlib.Path
    uses: dict      # model -> tests
    seconds: dict   # test -> time with all seeds
    one_seed: dict  # test -> time with one seed, for the tests that pass with one


@dataclasses.dataclass
class Mutant:
    model: str
    number: int
    line: str        # as Yosys wrote it
    programs: list = dataclasses.field(default_factory=list)  # that use the model
    fate: str = ""   # killed, hangs, equal, survives

    def text(self):
        """Returns the change, and the lines of rtl/ from which it comes."""
        options = collections.defaultdict(list)
        for key, value in re.findall(r"-(\w+) (\S+)", self.line):
            options[key].append(value)
        places = [place.removeprefix("rtl/") for place in options["src"] if place.startswith("rtl/")]
        wire = "".join(f" of {w}[{b}]" for w, b in zip(options["wire"], options["wirebit"]))
        cell = re.sub(r"\$(/\S+/)?", "", options["cell"][0]) if options["cell"] else ""
        return f"{options['mode'][0]} {cell}.{options['port'][0]}[{options['portbit'][0]}]{wire}: " + ", ".join(
            places[:3]
        )


def environment(**more):
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("SELFPROJ_", "GTEST_"))}
    return {**kept, **more}


def look_at(path):
    """Runs the program without a mutation. Returns which test uses which model, and how long each test takes."""
    uses = collections.defaultdict(set)
    seconds, one_seed = {}, {}
    for seed in ({}, {"SELFPROJ_SEED": "1"}):
        result = subprocess.run(
            [path], env=environment(SELFPROJ_MUTANT_USES="1", **seed), capture_output=True, text=True, check=False
        )
        if result.returncode != 0 and not seed:
            raise MutationError(f"{path.name} fails without a mutation")
        test = ""
        for line in result.stdout.splitlines():
            if match := re.match(r"\[ RUN      \] (\S+)", line):
                test = match[1]
            elif match := re.match(r"uses: (\S+)", line):
                uses[match[1]].add(test)
            elif match := re.match(r"\[       OK \] (\S+) \((\d+) ms\)", line):
                (one_seed if seed else seconds)[match[1]] = int(match[2]) / 1000
    return Program(path, uses, seconds, one_seed)


def fails(mutant, times, seed):
    """Runs these tests of the model (program, test: seconds), the quickest first, until one fails. Returns killed or
    hangs."""
    for program, test in sorted(times, key=times.get):
        command = [program, "--gtest_filter=" + test, "--gtest_break_on_failure", "--gtest_brief=1"]
        try:
            result = subprocess.run(
                command,
                env=environment(SELFPROJ_MUTANT=f"{mutant.model} {mutant.number}", **seed),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                timeout=10 + 10 * times[program, test],
                check=False,
            )
        except subprocess.TimeoutExpired:
            return "hangs"
        if result.returncode != 0:
            return "killed"
    return ""


@functools.cache
def memory_bits(netlist):
    """Returns how many bits the memories of a netlist in Yosys's own format have."""
    cells = re.findall(r"^  cell \$mem\S* .*?^  end$", netlist.read_text(), re.M | re.S)
    return sum(int(re.search(r"\\SIZE (\d+)", cell)[1]) * int(re.search(r"\\WIDTH (\d+)", cell)[1]) for cell in cells)


def changes_nothing(mutant, flat):
    """Returns whether the bit was tied to its old value, or nothing reads it: flattened and without unread logic, the
    netlists are the same."""
    with tempfile.TemporaryDirectory() as folder:
        before, after = pathlib.Path(folder) / "before", pathlib.Path(folder) / "after"
        flatten = "setattr -mod -unset keep_hierarchy *; flatten; opt_expr; opt_clean -purge"
        script = (f'read_rtlil "{flat}"; {flatten}; write_rtlil "{before}"; design -reset; '
                  f'read_rtlil "{flat}"; {mutant.line}; {flatten}; write_rtlil "{after}"')
        subprocess.run(["yosys", "-q", "-p", script], capture_output=True, check=True)
        # wires, cells and connections, in whatever order
        parts = [sorted(re.findall(r"^  wire .*?$|^  cell .*?^  end$|^  connect .*?$", path.read_text(), re.M | re.S))
                 for path in (before, after)]
    return parts[0] == parts[1]


MEMORIES = r"\$mem\w*"
REGISTERS = r"\$(?:s|a)?dff\w*"


def cut_at(cells, netlist):
    """Returns the text of a one-module netlist in Yosys's own format without the cells whose types match. Their inputs
    become outputs of the module, and their outputs become its inputs."""
    ports = itertools.count(10000)

    def width(port, sizes):
        if "ABITS" in sizes:
            each = {"ADDR": sizes["ABITS"], "DATA": sizes["WIDTH"]}.get(
                port[3:], sizes["WIDTH"] if port == "WR_EN" else 1
            )
            return each * sizes[port[:2] + "_PORTS"]
        return sizes["WIDTH"] if port in ("D", "Q") else 1

    def outside(cell):
        name = re.match(r"  cell \S+ \\?(\S+)", cell[0])[1]
        lines = []
        sizes = {
            key: int(value) for key, value in re.findall(r"parameter \\(ABITS|WIDTH|RD_PORTS|WR_PORTS) (\d+)", cell[0])
        }
        for port, signal in re.findall(r"^    connect \\(\S+) (.*)$", cell[0], re.M):
            wire = f"\\{name}.{port}"
            gives = port in ("RD_DATA", "Q")
            lines += [
                f"  wire width {width(port, sizes)} {'input' if gives else 'output'} {next(ports)} {wire}",
                f"  connect {signal} {wire}" if gives else f"  connect {wire} {signal}",
            ]
        return "\n".join(lines)

    return re.sub(rf"^  cell {cells} .*?^  end$", outside, netlist, flags=re.M | re.S)


def same_logic(module, before, after, working):
    """Returns whether Yosys proves that two netlists give every output and every input of a register or memory alike,
    whatever the registers and memories hold."""
    cut = [working / "gold.il", working / "gate.il"]
    for path, netlist in zip(cut, (before, after)):
        path.write_text(cut_at(f"(?:{MEMORIES}|{REGISTERS})", netlist.read_text()))
    script = "; ".join([*(f"read_rtlil {path}; rename {module} {path.stem}" for path in cut),
                        "miter -equiv -make_assert -flatten gold gate both; hierarchy -top both; opt -full",
                        f"sat -verify -prove-asserts -timeout {PROOF_LIMIT_S} both"])
    return subprocess.run(["yosys", "-q", "-p", script], capture_output=True, check=False).returncode == 0


def proved_equal(mutant, folder):
    """Returns whether the mutant changes nothing, or Yosys proves it equal: register by register, then by induction
    with small memories inside, then with all memories outside."""
    flat = folder / "mutants" / mutant.model / f"{mutant.model}.il"
    if changes_nothing(mutant, flat):
        return True
    one_module = len(re.findall(r"^module ", flat.read_text(), re.M)) == 1
    with tempfile.TemporaryDirectory() as folder_name:
        working = pathlib.Path(folder_name)
        before, after = working / "before.il", working / "after.il"
        before.write_text(flat.read_text())
        subprocess.run(
            ["yosys", "-q", "-p", f'read_rtlil "{flat}"; {mutant.line}; write_rtlil "{after}"'],
            capture_output=True,
            check=True,
        )
        module = re.search(r"-module (\S+)", mutant.line)[1]
        if one_module and same_logic(module, before, after, working):
            return True
        if re.search(r"-port \S*CLK ", mutant.line):
            return False  # the induction does not look at clocks
        small = memory_bits(flat) <= PROOF_MEMORY_BITS
        if small and induction(module, before, after, working):
            return True
        if memory_bits(flat) == 0 or not one_module:
            return False
        for path in (before, after):
            path.write_text(cut_at(MEMORIES, path.read_text()))
        return induction(module, before, after, working)


def induction(module, before, after, working):
    """Returns whether Yosys proves every output of two netlists equal, by induction over registers.

    At first every register must be equal too. Then those that differ are left out, and the rest must follow without
    them.
    """
    outputs = set(re.findall(r"^  wire .*\boutput \d+ (\S+)$", before.read_text(), re.M))
    differ = set()
    left_out = working / "left_out"
    script = (
        f"read_rtlil {before}; rename {module} gold; memory_map; opt_clean -purge; splitnets; design -stash gold; "
        f"read_rtlil {after}; "
        f"rename {module} gate; memory_map; opt_clean -purge; splitnets; design -stash gate; "
        "design -copy-from gold -as gold gold; design -copy-from gate -as gate gate; "
        f"equiv_make -blacklist {left_out} gold gate both; hierarchy -top both; "
        "equiv_simple; equiv_induct; equiv_status"
    )
    ends = time.monotonic() + PROOF_LIMIT_S
    while (seconds := ends - time.monotonic()) > 0:
        left_out.write_text("".join(name + "\n" for name in sorted(differ)))
        try:
            said = subprocess.run(
                ["yosys", "-p", script], capture_output=True, text=True, timeout=seconds, check=True
            ).stdout
        except subprocess.TimeoutExpired:
            return False
        if "Equivalence successfully proven!" in said:
            return True
        more = set(re.findall(r"^  Unproven \$equiv \S+ (\S+)_gold(?: \[\d+\])? ", said, re.M))
        if not more or more & (outputs | differ):
            return False
        differ |= more
    return False


def try_mutant(mutant, folder, prove):
    def times(of):
        return {(program.path, test): seconds for program in mutant.programs for test, seconds in of(program).items()
                if test in program.uses[mutant.model]}

    quick = {test: seconds for test, seconds in times(lambda program: program.one_seed).items() if seconds < QUICK_S}
    mutant.fate = fails(mutant, quick, {"SELFPROJ_SEED": "1"})
    if not mutant.fate and prove and proved_equal(mutant, folder):
        mutant.fate = "equal"
    if not mutant.fate:
        mutant.fate = fails(mutant, times(lambda program: program.seconds), {}) or "survives"
    return mutant


def collect(folder, names, sample):
    programs = collections.defaultdict(list)
    for path in sorted(folder.glob("mutants_*")):
        if path.is_dir() or path.suffix or not os.access(path, os.X_OK):
            continue
        if names and not any(name.encode() + b"\0" in path.read_bytes() for name in names):
            continue  # it contains none of these models
        program = look_at(path)
        for model in program.uses:
            programs[model].append(program)
    mutants = []
    for model in sorted(set(programs) & set(names) if names else programs):
        listing = folder / "mutants" / model / f"{model}.mutants"
        lines = listing.read_text().splitlines() if listing.exists() else []
        mutants += [
            Mutant(model, number, line, programs[model]) for number, line in enumerate(lines[: sample or None], 1)
        ]
    return mutants


def score_of(figures):
    real = figures["mutants"] - figures["equal"]
    return figures["killed"] / real if real else None


def summed(models):
    """Returns the figures of all models together."""
    total = {key: sum(figures[key] for figures in models.values())
             for key in ("mutants", "killed", "by_time", "equal", "survive")}
    return total | {"score": score_of(total)}


def figures_of(mutants):
    """Returns the figures of each model."""
    by_model = collections.defaultdict(collections.Counter)
    for mutant in mutants:
        by_model[mutant.model][mutant.fate] += 1
    figures = {model: {"mutants": fates.total(), "killed": fates["killed"] + fates["hangs"], "by_time": fates["hangs"],
                       "equal": fates["equal"], "survive": fates["survives"]} for model, fates in by_model.items()}
    return {model: of | {"score": score_of(of)} for model, of in figures.items()}


def table_of(figures):
    lines = ["| model | mutants | killed | of these by time-out | proved equal | survive | score |",
             "|---|---:|---:|---:|---:|---:|---:|"]
    for model, of in [*figures.items(), ("**all**", summed(figures))]:
        score = "–" if of["score"] is None else f"{100 * of['score']:.1f} %"
        lines.append(f"| {model} | {of['mutants']} | {of['killed']} | {of['by_time']} | {of['equal']} | "
                     f"{of['survive']} | {score} |")
    return lines


def merged(earlier, figures, survivors, stamp):
    """Returns the results of `earlier` (a file of results/, or none) with the models of this run in their places.

    An entry that has no commit of its own has that of its file.
    """
    models = {}
    if earlier:
        of_file = {key: earlier[key] for key in ("date", "commit")}
        models = {name: of_file | entry for name, entry in earlier["results"]["models"].items()}
    for name, entry in figures.items():
        own = [text for text in survivors if text.startswith(name + " ")]
        models[name] = entry | stamp | {"survivors": own}
    return {"all": summed(models), "models": models}


def record(figures, survivors, names):
    """Writes the figures into the folder for results. With names, the entries of the other models stay."""
    folder = os.environ.get(results.VARIABLE)
    if not folder:
        return
    path = pathlib.Path(folder) / "mutation.json"
    earlier = json.loads(path.read_text()) if names and path.exists() else None
    stamp = {"date": datetime.datetime.now(datetime.timezone.utc).date().isoformat(), "commit": results.commit(ROOT)}
    results.write("mutation", "Mutants of the blocks and the board under the tests of the RTL", "scripts/mutation.py",
                  merged(earlier, figures, survivors, stamp))


def build():
    """Builds the mutants, and returns their folder."""
    if not (BUILD / "build.ninja").exists():
        subprocess.run(["cmake", "--preset", "release", "--log-level=NOTICE"], cwd=ROOT, check=True)
    subprocess.run(["cmake", "--build", BUILD, "--target", "mutants_all"], check=True)
    return BUILD / "tests" / "netlist"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--table", type=pathlib.Path, help="write the report into this file, too")
    parser.add_argument("--folder", type=pathlib.Path)
    parser.add_argument("models", nargs="*", metavar="MODEL")
    args = parser.parse_args()
    folder = (args.folder or build()).resolve()
    started = time.monotonic()
    mutants = collect(folder, args.models, args.sample)
    if not mutants:
        raise MutationError(f"{folder}: no mutants there; build the target mutants_all")
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for number, mutant in enumerate(
            pool.map(lambda m: try_mutant(m, folder, not args.sample), mutants), 1
        ):
            if mutant.fate == "survives" or number % 100 == 0:
                print(
                    f"{number}/{len(mutants)} {mutant.model} {mutant.number} {mutant.fate}", file=sys.stderr, flush=True
                )
    figures = figures_of(mutants)
    survivors = [f"{mutant.model} {mutant.number}: {mutant.text()}" for mutant in mutants if mutant.fate == "survives"]
    score = summed(figures)["score"] or 0
    if not args.sample:
        record(figures, survivors, args.models)
    text = "\n".join(
        [
            *table_of(figures),
            "",
            *survivors,
            "",
            f"{len(mutants)} mutants, {100 * score:.1f} % of those not proved equal killed, "
            f"{time.monotonic() - started:.0f} s",
        ]
    )
    print(text)
    if args.table:
        args.table.write_text(text + "\n")
    return 0 if score >= TARGET else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (MutationError, subprocess.CalledProcessError) as error:
        sys.exit(f"mutation.py: {error}")
