#!/usr/bin/env python3
"""Installs headers and libraries into an empty folder, and builds the examples of docs/from-outside.md there.

    install_test.py BUILD SIMULATION
"""

import pathlib
import shutil
import sys
import tempfile

import consumer


def main():
    build, simulation = map(pathlib.Path, sys.argv[1:])
    if not shutil.which("pkg-config"):
        print("skipped: pkg-config is not installed")
        return 77
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        prefix = folder / "prefix"
        consumer.run("cmake", "--install", build, "--prefix", prefix, "--component", "development")
        for file in [*prefix.rglob("*.cmake"), *prefix.rglob("*.pc"), *prefix.rglob("*.h")]:
            text = file.read_text(encoding="utf-8")
            consumer.require(str(consumer.ROOT) not in text and str(build) not in text,
                             f"{file} names a folder of the build")
        # Headers that are installed include nothing that is not.
        headers = sorted((prefix / "include").rglob("*.h"))
        consumer.require(len(headers) > 30, f"only {len(headers)} headers")
        every = folder / "every.cpp"
        every.write_text("".join(f"#include <{path.relative_to(prefix / 'include')}>\n" for path in headers),
                         encoding="utf-8")
        consumer.run("c++", "-std=c++20", "-fsyntax-only", "-isystem", "/usr/include/opencv4", "-I", prefix / "include",
                     every)
        packets = folder / "line.slfp"
        consumer.record(simulation, packets)
        lines = consumer.build_cmake_example(prefix, folder / "example", packets).splitlines()
        consumer.require(len(lines) > 10 and all(line.startswith("z ") and "nan" not in line for line in lines),
                         f"not a depth of each frame: {lines[:3]}")
        consumer.require("z 1167.000 mm" in consumer.build_c_example(prefix, folder), "another z in C")
        print(f"{len(headers)} headers; {len(lines)} profiles of {packets.name}; C by pkg-config")
    return 0


if __name__ == "__main__":
    sys.exit(main())
