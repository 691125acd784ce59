#!/usr/bin/env python3
"""How much of its time a program in Python spends inside the compiled kernels, over 100,000 images of 96 x 512.

    bench_kernels.py BUILD

Images come as stacks of 1000, and for comparison one by one. BUILD is a build with preset release, such as
build/release; the package is installed as the tests do it. The results go where SELFPROJ_RESULTS says.
"""

import pathlib
import subprocess
import sys
import time

import environment

IMAGES, STACK = 100_000, 1000


def measure(light_section, core, images, one_by_one):
    """Seconds that passed, and seconds inside the kernels."""
    begin, kernels = time.perf_counter(), core.kernel_ns()
    for _ in range(IMAGES // STACK):
        if one_by_one:
            for image in images:
                light_section.moments(image, 20)
        else:
            light_section.moments(images, 20)
    return time.perf_counter() - begin, (core.kernel_ns() - kernels) * 1e-9


def measure_all():
    import numpy
    from selfproj import _core, light_section
    sys.path.insert(0, str(environment.ROOT / "scripts"))
    import results
    images = numpy.random.default_rng(1).integers(0, 256, (STACK, 96, 512), dtype="uint8")
    found = {"images": IMAGES}
    for name, one_by_one in (("stacks", False), ("one_by_one", True)):
        passed, inside = measure(light_section, _core, images, one_by_one)
        found[name] = {"share_in_kernels": round(inside / passed, 4), "images_per_second": round(IMAGES / passed)}
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
    wrong = environment.install(build) if environment.PACKAGE.get() else "PyPI is not reached"
    if wrong:
        print(f"bench_kernels.py: {wrong}", file=sys.stderr)
        return 2
    return subprocess.run([environment.PACKAGE.python, __file__, "--measure"], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
