#!/usr/bin/env python3
"""Writes what a program of a build is made of, in CycloneDX 1.5 (JSON), for whoever ships or audits it.

    sbom.py BUILD PROGRAM > PROGRAM.cdx.json        sbom.py build/release build/bin/selfproj

Lists the program with its SHA-256, and each Debian package of which it contains something: shared libraries that it
links (with the SHA-256 of the file), libraries that it loads when they are there, and packages whose headers were
compiled into it. Each has its version, its package URL, and the licences that its copyright file names.
"""

import argparse
import datetime
import hashlib
import json
import pathlib
import re
import subprocess
import sys

LOADED = ("libopencv_imgcodecs.so", "libSDL2-2.0.so")  # by dlopen


def output_of(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    return done.stdout


def linked_files(program):
    files = re.findall(r"=> (/\S+)", output_of("ldd", program))
    cache = output_of("ldconfig", "-p")
    for name in LOADED:
        files += re.findall(rf"^\s*{re.escape(name)}\S* .*=> (/\S+)", cache, re.MULTILINE)[:1]
    return sorted({pathlib.Path(file).resolve() for file in files})


def headers(build, program):
    """The headers outside of the project from which the program's objects were compiled."""
    program = program.resolve()
    names = [program, program.relative_to(build.resolve())] if program.is_relative_to(build.resolve()) else [program]
    objects = {file for name in names
               for file in output_of("ninja", "-C", build, "-t", "inputs", name).splitlines() if file.endswith(".o")}
    found, ours = set(), False
    for line in output_of("ninja", "-C", build, "-t", "deps").splitlines():
        if not line.startswith(" "):
            ours = line.split(":")[0] in objects
        elif ours and line.strip().startswith("/usr/"):
            found.add(pathlib.Path(line.strip()).resolve())
    return sorted(found)


def packages_of(files):
    """{file: package} by dpkg; a merged /usr is known to it by both names."""
    owners = {}
    files = [str(file) for file in files]
    for first in range(0, len(files), 500):
        part = files[first:first + 500]
        names = part + [file.removeprefix("/usr") for file in part if file.startswith("/usr/lib")]
        for line in output_of("dpkg", "-S", *names).splitlines():
            package, _, file = line.partition(": ")
            owners[file if file.startswith("/usr") else "/usr" + file] = package.split(",")[0]
    return owners


def licences_of(package):
    file = pathlib.Path("/usr/share/doc") / package.split(":")[0] / "copyright"
    text = file.read_text(encoding="utf-8", errors="replace") if file.exists() else ""
    return sorted(set(re.findall(r"^License: *(\S.*?)\s*$", text, re.MULTILINE))) or ["see " + str(file)]


def sha256(file):
    return [{"alg": "SHA-256", "content": hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()}]


def component(package, files):
    query = "${Package}\t${Version}\t${Architecture}\t${Homepage}"
    name, version, architecture, page = output_of("dpkg-query", "-W", f"-f={query}", package).split("\t")
    result = {"type": "library", "name": name, "version": version,
              "purl": f"pkg:deb/debian/{name}@{version}?arch={architecture}",
              "licenses": [{"license": {"name": licence}} for licence in licences_of(package)]}
    if page:
        result["externalReferences"] = [{"type": "website", "url": page}]
    if files:
        result["components"] = [{"type": "file", "name": str(file), "hashes": sha256(file)} for file in files]
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("program", type=pathlib.Path)
    arguments = parser.parse_args()
    if not arguments.program.is_file() or not (arguments.build / "build.ninja").is_file():
        print(f"sbom.py: {arguments.program} in {arguments.build}: no program of a build with Ninja", file=sys.stderr)
        return 2
    linked = linked_files(arguments.program)
    owners = packages_of([*linked, *headers(arguments.build, arguments.program)])
    files = {}
    for file, package in owners.items():
        files.setdefault(package, [])
        if pathlib.Path(file) in linked:
            files[package].append(file)
    json.dump({"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
               "metadata": {"timestamp": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
                            "component": {"type": "application", "name": arguments.program.name,
                                          "hashes": sha256(arguments.program)}},
               "components": [component(package, files[package]) for package in sorted(files)]}, sys.stdout, indent=1)
    print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
