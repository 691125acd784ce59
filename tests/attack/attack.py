#!/usr/bin/env python3
"""Attacks the programs from outside: see scripts/attack.sh."""
import argparse
import json
import pathlib
import resource
import sys
import tempfile
import time

import materials
from captures import Captures
from cases import Cases
from clients import HostileClients
from files import Files, missed_pairs
from images import Images
from limits import Limits
from options import Options
from outputs import Outputs
from programs import Attacker
from rings import Rings
from screen import own_screen
from soak import Soak

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Cases of each part: a short run, which is a test, and a long one.
COUNTS = {
    "cases": (4, 1000),
    "pairs": (4, 1000),
    "files": (20, 10000),
    "images": (24, 20000),
    "options": (32, 10000),
    "captures": (1, 8),
    "kills": (4, 500),
    "evil": (3, 300),
    "shorten": (1, 50),
    "restarts": (1, 60),
    "clients": (2, 100),
    "hostile-clients": (3, 120),
    "soak": (60, 4 * 3600)
}


def parts_of(attacker, made, counts, short):
    share = 4 if short else 1
    outputs = Outputs(attacker, made)
    rings = Rings(attacker, made)
    return {
        "cases": lambda: Cases(attacker, made).run(counts["cases"]),
        "captures": lambda: Captures(attacker, made).run(counts["captures"]),
        "onto-inputs": lambda: outputs.onto_inputs(share, counts["pairs"]),
        "standard-output": lambda: outputs.standard_output(share),
        "accounts": rings.accounts,
        "evil": lambda: rings.repeat("evil rings", counts["evil"], rings.evil),
        "shorten": lambda: rings.repeat("shortened rings", counts["shorten"], rings.shortened),
        "restarts": lambda: rings.repeat("kills and restarts", counts["restarts"], rings.restarts),
        "kills": lambda: outputs.kills(counts["kills"]),
        "files": lambda: Files(attacker, made).run(counts["files"]),
        "images": lambda: Images(attacker, made).run(counts["images"]),
        "options": lambda: Options(attacker, made).run(counts["options"]),
        "clients": lambda: HostileClients(attacker, made, wide=False).run(counts["clients"]),
        "hostile-clients": lambda: HostileClients(attacker, made, wide=not short).measure(counts["hostile-clients"]),
        "soak": lambda: Soak(attacker, made, wide=not short).measure(counts["soak"]),
        "limits": lambda: Limits(attacker, made).run()
    }


def main():
    parser = argparse.ArgumentParser(prog="attack.sh", description="Attacks the programs from outside.")
    parser.add_argument("--programs",
                        default=str(ROOT / "build" / "bin"),
                        metavar="DIR",
                        help="where selfproj and selfproj-sim are")
    parser.add_argument("--short", action="store_true", help="the short run, which is a test")
    parser.add_argument("--seed", type=int, default=1, help="of all that is random")
    parser.add_argument("--share", type=float, default=1.0, help="of the cases of the long run")
    parser.add_argument("--only",
                        nargs="+",
                        metavar="PART",
                        help="parts to run, of: cases onto-inputs standard-output accounts "
                        "captures evil shorten restarts kills files images options clients hostile-clients limits, and soak, "
                        "which runs only if named")
    parser.add_argument("--record", action="store_true", help="keep the figures in the folder results")
    options = parser.parse_args()
    counts = {
        name: short if options.short else max(1, round(options.share * long))
        for name, (short, long) in COUNTS.items()
    }
    begin = time.monotonic()
    figures = {}
    with own_screen() as screen, tempfile.TemporaryDirectory(prefix="selfproj-attack-") as work:
        attacker = Attacker(options.programs, work, options.seed, screen)
        folder = pathlib.Path(work) / "materials"
        folder.mkdir()
        made = materials.make(attacker, folder, options.short)
        parts = parts_of(attacker, made, counts, options.short)
        for name, part in parts.items():
            left_out = name not in options.only if options.only else name == "soak"
            if left_out or (options.short and name == "limits"):
                continue
            started, runs, cpu = time.monotonic(), attacker.runs, cpu_of_children()
            outcome = part()
            seconds = time.monotonic() - started
            _, count = attacker.cases.popitem()
            figures[name] = {
                **count, "runs": attacker.runs - runs,
                "seconds": round(seconds),
                "seed": options.seed
            }
            print(f"{name}: {figures[name]['cases']} cases, {figures[name]['faults']} faults, {seconds:.1f} s, "
                  f"{cpu_of_children() - cpu:.1f} s of CPU",
                  flush=True)
            if options.record and name == "limits":
                keep("reader_limits", "Memory and time of every reader of files",
                     "scripts/attack.sh --only limits --record", outcome)
                keep("check_word", "The share of all pairs of flipped bits in a packet of grey moments that the check "
                     "word misses, by number of columns", "scripts/attack.sh --only limits --record",
                     {str(columns): missed_pairs(columns) for columns in (64, 512, 2048)})
            elif options.record:
                record(figures)
            if options.record and name == "soak" and outcome:
                keep("line_soak", "Two lines at work, by a ring and over a network: boards and programs are ended and "
                     "killed, clients are slow, silent and greedy", "scripts/attack.sh --only soak --record", outcome)
            if options.record and name == "hostile-clients" and outcome:
                keep("hostile_clients", "A line at work, alone and with slow, silent and greedy clients of its page and "
                     "Modbus server", "scripts/attack.sh --only hostile-clients --record", outcome)
    faults = len(attacker.faults)
    print(f"{attacker.runs} runs in {time.monotonic() - begin:.0f} s, seed {options.seed}: {faults} faults")
    return 1 if faults else 0


def cpu_of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def keep(name, about, command, figures):
    sys.path.insert(0, str(ROOT / "scripts"))
    import results  # noqa: PLC0415: only where figures are kept
    results.write(name, about, command, figures, folder=ROOT / "results")


def record(figures):
    """Into the folder results; the figures of parts that were not run now stay."""
    file = ROOT / "results" / "attack.json"
    before = json.loads(file.read_text())["results"]["parts"] if file.exists() else {}
    parts = {**before, **figures}
    keep("attack", "Cases of the attack from outside, and what failed in them", "scripts/attack.sh --record", {
        "parts": parts,
        **{key: sum(part[key] for part in parts.values()) for key in ("cases", "faults", "runs")}
    })


if __name__ == "__main__":
    sys.exit(main())
