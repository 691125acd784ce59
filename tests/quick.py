#!/usr/bin/env python3
"""Lets ctest leave out the quick tests that cannot have another result than when they last passed.

    quick.py select BUILD FILE...   writes BUILD/CTestCustom.cmake, with which ctest leaves out the tests of programs that
                                    have not changed
    quick.py passed BUILD           notes that all tests of the last selection have passed

A test is left out only if it is a program of the build, and neither the program nor one of the files named has changed
since it passed. A program whose tests run selfproj or selfproj-sim depends on these as well. Standard library only.
"""

import hashlib
import json
import pathlib
import re
import subprocess
import sys

PROGRAMS = re.compile(rb"/bin/selfproj(-sim)?\0")  # the path of a program that the tests run


def tests_of(build):
    """Returns {program: names of its tests}. Tests of scripts are not among them."""
    shown = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True, check=True)
    tests = {}
    for test in json.loads(shown.stdout)["tests"]:
        program = pathlib.Path(test.get("command", [""])[0])
        if program.is_file() and build in program.parents:
            tests.setdefault(program, []).append(test["name"])
    return tests


def state_of(program, common, programs):
    text = program.read_bytes()
    digest = hashlib.sha256(common + text)
    if PROGRAMS.search(text):
        for other in programs:
            digest.update(other.read_bytes())
    return digest.hexdigest()


def main():
    build = pathlib.Path(sys.argv[2]).resolve()
    known = build / "passed.json"
    ahead = build / "selected.json"
    if sys.argv[1] == "passed":
        ahead.replace(known)
        return
    common = b"".join(hashlib.sha256(pathlib.Path(name).read_bytes()).digest() for name in sorted(sys.argv[3:]))
    programs = sorted(build.glob("bin/selfproj*"))
    passed = json.loads(known.read_text()) if known.exists() else {}
    states, names = {}, []
    for program, tests in tests_of(build).items():
        states[str(program)] = state_of(program, common, programs)
        if passed.get(str(program)) == states[str(program)]:
            names += tests
    ahead.write_text(json.dumps(states))
    lines = "".join(f"  [==[{name}]==]\n" for name in names)
    (build / "CTestCustom.cmake").write_text(f"set(CTEST_CUSTOM_TESTS_IGNORE\n{lines})\n")
    if names:
        print(f"{len(names)} tests are left out: their programs have not changed since they passed")


if __name__ == "__main__":
    main()
