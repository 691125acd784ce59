#!/usr/bin/env python3
"""How much of its time a program in Python spends inside the compiled kernels, over 100,000 images of 96 x 512.

    bench_kernels.py BUILD

Images come as stacks of 100, and for comparison one by one. Both figures are medians over rounds of 100 images. Another
program that takes the processor away stops few of these rounds, and would else be counted wherever it happened to come.
BUILD is a build with preset release, such as build/release; the package is installed as the tests do it. The results go
where SELFPROJ_RESULTS says.
"""

import pathlib
import statistics
import subprocess
import sys
import time

import environment

IMAGES, DIFFERENT, STACK = 100_000, 1000, 100


def measure(light_section, core, images, one_by_one):
    """For each round the seconds that passed, and the share of them inside the kernels."""
    for first in list(range(0, DIFFERENT, STACK)) * (IMAGES // DIFFERENT):
        part = images[first:first + STACK]
        begin, kernels = time.perf_counter_ns(), core.kernel_ns()
        if one_by_one:
            for image in part:
                light_section.moments(image, 20)
        else:
            light_section.moments(part, 20)
        passed, inside = time.perf_counter_ns() - begin, core.kernel_ns() - kernels
        yield passed * 1e-9, inside / passed


def measure_all():
    import numpy
    from selfproj import _core, light_section
    sys.path.insert(0, str(environment.ROOT / "scripts"))
    import results
    images = numpy.random.default_rng(1).integers(0, 256, (DIFFERENT, 96, 512), dtype="uint8")
    found = {"images": IMAGES}
    for name, one_by_one in (("stacks", False), ("one_by_one", True)):
        passed, shares = zip(*measure(light_section, _core, images, one_by_one))
        found[name] = {"share_in_kernels": round(statistics.median(shares), 4),
                       "images_per_second": round(STACK / statistics.median(passed))}
    print(found)
    results.write("bench_python", "Time of a Python program inside the compiled kernels, grey-over moments of 96 x 512",
                  "tests/outside/python/bench_kernels.py build/release", found)


def main():
    if sys.argv[1:] == ["--measure"]:
        measure_all()
        return 0
    if len(sys.argv) != 2:
        print("bench_kernels.py: usage: bench_kernels.py BUILD", file=sys.stderr)
        return 2
    build = pathlib.Path(sys.argv[1]).resolve()
    wrong = environment.install(build, environment.PACKAGE)
    if wrong:
        print(f"bench_kernels.py: {wrong}", file=sys.stderr)
        return 2
    return subprocess.run([environment.PACKAGE.python, __file__, "--measure"], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
