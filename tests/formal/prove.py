#!/usr/bin/env python3
"""Proves the rules inside the RTL modules (`ifdef FORMAL) with Yosys and yosys-smtbmc and z3, or with Yosys's own ABC.

    prove.py [NAME...]           the proofs named, or all; prints a line of each: its rules and kind
    prove.py --faults [NAME...]  the planted faults: each must make its proof fail
    prove.py --list              what the tests run, a name a line: proofs, then faults

A proof of depth K by induction shows that no trace of K steps from the beginning breaks a rule, and that K steps which
keep the rules are never followed by one that breaks them. A proof by reachability shows that no trace at all breaks a
rule. A bounded proof shows that no trace of K steps from the beginning breaks a rule. Covers show that traces up to the
given depth reach every cover statement, so that the rules do not hold merely because no trace exists. Induction uses
z3; ABC does the rest, because it finds traces from the beginning sooner.

Standard library only.
"""

import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import results  # noqa: E402
from lib import rtl_tree  # noqa: E402
from proofs import FAULTS, PROOFS  # noqa: E402


class ProofError(Exception):
    """A tool failed, or a fault could not be planted."""


def run(command, limit_s, folder):
    try:
        return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=limit_s, check=False)
    except FileNotFoundError as error:
        raise ProofError(f"{error.filename}: not installed; scripts/setup.sh installs it") from error
    except subprocess.TimeoutExpired as error:
        raise ProofError(f"{command[0]}: no answer within {limit_s} s") from error


def write_models(proof, rtl, folder, *kinds):
    """Returns the paths of models of the module with its rules: flat, memories as registers, free clocks as data.

    The kinds are smt2 (SMT-LIB), rules (AIGER), and covers (AIGER with the covers in place of the rules). What a part
    of the module assumes, the module has to guarantee: it becomes an assertion.
    """
    two_clocks = "clk2fflogic; " if proof.clocks == 2 else ""
    helpers = sorted((ROOT / "tests/formal").glob("sp_formal_*.sv"))
    files = rtl_tree.sources_of(proof.module, rtl, helpers)
    read = rtl_tree.read_command(proof.module, proof.parameters, files=files, formal=True)
    script = (read + f"hierarchy -check -top {proof.module}; proc; chformal -cover -remove A:top %n; "
              f"chformal {'-assume2assert' if proof.lemmas else '-remove'} A:top *sp_formal_* %u %n; "
              f"prep -nordff -flatten; memory_map; {two_clocks}opt -full; dffunmap; design -save model")
    # a cover is reached if the assertion of its opposite fails
    contrary = folder / "contrary.v"
    contrary.write_text("(* techmap_celltype = \"$cover\" *) module contrary(input A, EN); "
                        "\\$assert _TECHMAP_REPLACE_ (.A(!A), .EN(EN)); endmodule\n")
    statements = {"rules": "chformal -cover -remove",
                  "covers": f"chformal -assert -remove; techmap -map {contrary}"}
    paths = []
    for kind in kinds:
        path = folder / (f"{proof.name}.smt2" if kind == "smt2" else f"{proof.name}.{kind}.aig")
        paths.append(path)
        script += "; design -load model; "
        if kind == "smt2":
            script += f"write_smt2 -wires {path}"
        else:
            script += (f"{statements[kind]}; opt -full; setundef -undriven -anyseq; formalff -clk2ff -ff2anyinit; "
                       f"techmap; simplemap; dffunmap; delete -output; opt_clean; abc -g AND -fast; opt_clean; "
                       f"write_aiger -B -zinit {path}")
    result = run(["yosys", "-q", "-p", script], proof.limit_s, folder)
    if result.returncode != 0 or not all(path.exists() for path in paths):
        said = [line for line in (result.stdout + result.stderr).splitlines() if not line.startswith(">")]
        raise ProofError(f"Yosys failed on {proof.module}: " + "\n".join(said[-3:]))
    return paths


def solve(proof, smt2, options, folder):
    """(passed, output) of yosys-smtbmc."""
    result = run(["yosys-smtbmc", "-s", "z3", "--unroll", "--noprogress", *options, str(smt2)], proof.limit_s, folder)
    output = result.stdout + result.stderr
    if "Status: PASSED" in output:
        return True, output
    if "Status: FAILED" in output:
        return False, output
    raise ProofError(f"yosys-smtbmc gave no verdict on {proof.name}:\n{output[-2000:]}")


def counts_of(aiger):
    """Returns how many rules or covers an AIGER file has, and how many assumptions."""
    # "aig", the largest index, inputs, latches, outputs, gates; then rules and assumptions, if there are any
    header = [int(word) for word in aiger.read_bytes().split(b"\n", 1)[0].split()[1:]] + [0, 0]
    return header[5], header[6]


def said_by_abc(proof, aiger, search, folder):
    """Returns what ABC prints about a search for steps in which a rule is broken and no assumption ever was."""
    # without assumptions, `fold` would take the last rule for one
    fold = "fold; " if counts_of(aiger)[1] else ""
    result = run(["yosys-abc", "-c", f"read {aiger.name}; {fold}strash; {search}"], proof.limit_s, folder)
    return result.stdout + result.stderr


def solve_aiger(proof, aiger, depth, folder, every=False):
    """Returns the steps in which ABC breaks a rule: the first one, or one for every rule that can be broken."""
    # with two clocks, many registers are equal
    search = "scorr; dc2; bmc3 -g" if proof.clocks == 2 else "bmc3"
    output = said_by_abc(proof, aiger, f"{search} -F {depth}{' -a' * every}", folder)
    broken = re.findall(r"Output +\d+ .*was asserted in frame +(\d+)", output)
    if not broken and f"No output asserted in {depth} frames" not in output:
        raise ProofError(f"ABC gave no verdict on {proof.name}:\n{output[-2000:]}")
    return [int(step) for step in broken]


def proved_by_reachability(proof, aiger, folder):
    """Returns whether ABC finds an invariant from which every rule follows, or a trace that breaks one."""
    output = said_by_abc(proof, aiger, "scorr; dc2; pdr", folder)
    if "Property proved" not in output and "was asserted in frame" not in output:
        raise ProofError(f"ABC gave no verdict on {proof.name}:\n{output[-2000:]}")
    return "Property proved" in output


def wrong(output):
    """Returns the lines that say what failed, without the clock."""
    lines = [re.sub(r"^##\s+\S+\s+", "", line) for line in output.splitlines()]
    return [line for line in lines if "failed" in line.lower()]


def check(proof, model, folder):
    """Raises ProofError if a rule does not hold."""
    if proof.kind == "bounded":
        if broken := solve_aiger(proof, model, proof.depth, folder):
            raise ProofError(f"{proof.name}: a rule is broken in step {broken[0]}")
        return
    if proof.kind == "reachability":
        if not proved_by_reachability(proof, model, folder):
            raise ProofError(f"{proof.name}: a rule is broken")
        return
    for options in (["-t", str(proof.depth)], ["-i", "-t", str(proof.depth)]):
        passed, output = solve(proof, model, options, folder)
        if not passed:
            raise ProofError(f"{proof.name} ({' '.join(options)}):\n" + "\n".join(wrong(output)))


def cover(proof, aiger, folder):
    """Returns the number of covers; raises ProofError if one is not reached."""
    covers = counts_of(aiger)[0]
    reached = len(solve_aiger(proof, aiger, proof.cover, folder, every=True))
    if reached < covers or covers == 0:
        raise ProofError(f"{proof.name}: {covers - reached} of {covers} covers not reached within {proof.cover} steps")
    return covers


def prove(proof, folder):
    """Returns one line of the table; raises ProofError if a rule does not hold or a cover is not reached."""
    begin = time.monotonic()
    rules = "smt2" if proof.kind == "induction" else "rules"
    model, aiger = write_models(proof, ROOT / "rtl", folder, rules, "covers")
    check(proof, model, folder)
    covers = cover(proof, aiger, folder)
    parameters = ", ".join(proof.parameters)
    return (f"| `{proof.module}` ({parameters}) | {proof.kind} | {proof.depth} | {proof.clocks} | {covers} | "
            f"{time.monotonic() - begin:.0f} s |")


def expect_failure(fault, folder):
    """Returns one line about the fault; raises ProofError if its proof does not find it."""
    proof = next(proof for proof in PROOFS if proof.name == fault.proof)
    rtl = rtl_tree.plant(folder, fault.file, fault.old, fault.new)
    if proof.kind == "induction" and not fault.bounded:
        model, = write_models(proof, rtl, folder, "smt2")
        found = not solve(proof, model, ["-i", "-t", str(proof.depth)], folder)[0]
    else:
        model, = write_models(proof, rtl, folder, "rules")
        found = solve_aiger(proof, model, fault.bounded or proof.depth, folder)
    if not found:
        raise ProofError(f"{fault.name}: not found by {proof.name}")
    return f"{fault.name}: found"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", action="store_true", help="the planted faults instead")
    parser.add_argument("--list", action="store_true", help="the names")
    parser.add_argument("names", nargs="*", metavar="NAME")
    arguments = parser.parse_args()
    if arguments.list:
        print("\n".join([proof.name for proof in PROOFS] + [fault.name for fault in FAULTS]))
        return 0
    known = FAULTS if arguments.faults else PROOFS
    unknown = set(arguments.names) - {entry.name for entry in known}
    if unknown:
        print(f"prove.py: {sorted(unknown)[0]}: no such {'fault' if arguments.faults else 'proof'}", file=sys.stderr)
        return 2
    failed = False
    for entry in known:
        if arguments.names and entry.name not in arguments.names:
            continue
        with tempfile.TemporaryDirectory(prefix="prove.") as folder:
            try:
                action = expect_failure if arguments.faults else prove
                print(action(entry, pathlib.Path(folder)), flush=True)
            except (ProofError, rtl_tree.PlantError) as error:
                print(f"prove.py: {error}", file=sys.stderr)
                failed = True
    if not failed and not arguments.names:
        keep(arguments.faults)
    return 1 if failed else 0


def keep(faults):
    """All proofs, or all planted faults, as results, with the time of one core."""
    times = os.times()
    cpu = {"cpu_s": round(times.user + times.system + times.children_user + times.children_system)}
    if faults:
        results.write("formal_faults", "Planted faults that the proofs of the RTL's blocks have to find",
                      "tests/formal/prove.py --faults", {"planted": len(FAULTS), "missed": 0, **cpu})
    else:
        kinds = [proof.kind for proof in PROOFS]
        results.write("formal", "Proofs of the rules inside the RTL's blocks", "tests/formal/prove.py",
                      {**{kind: kinds.count(kind) for kind in sorted(set(kinds))}, **cpu})


if __name__ == "__main__":
    sys.exit(main())
