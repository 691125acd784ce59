#!/usr/bin/env python3
"""The example of a scoreboard in SystemVerilog: it agrees with a right circuit, and finds the planted fault.

    dpi_test.py BUILD
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import consumer


def main():
    library = pathlib.Path(sys.argv[1]).resolve() / "capi"
    capi = consumer.ROOT / "capi"
    bench = consumer.ROOT / "tests/outside/dpi"
    with tempfile.TemporaryDirectory() as name:
        environment = {**os.environ, "CCACHE_BASEDIR": name, "OBJCACHE": shutil.which("ccache") or ""}
        consumer.run("verilator", "--binary", "--top-module", "scoreboard", "-CFLAGS",
                     f"-I{consumer.ROOT / 'include'} -O0 -std=c++20", "-LDFLAGS", f"-L{library} -Wl,-rpath,{library} -lselfproj", "-MAKEFLAGS",
                     "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0", "--Mdir", name, capi / "dpi/selfproj_dpi_pkg.sv",
                     bench / "their_moments.sv", bench / "scoreboard.sv", capi / "dpi/selfproj_dpi.c", env=environment)
        program = pathlib.Path(name) / "Vscoreboard"
        out = consumer.run(program, "+frames=100")
        consumer.require("matched 3200 columns in 100 frames" in out, out)
        faulty = subprocess.run([program, "+frames=100", "+fault"], capture_output=True, text=True, check=False)
        consumer.require(faulty.returncode != 0 and "the model says" in faulty.stdout + faulty.stderr,
                         f"the planted fault was not found: {faulty.stdout}{faulty.stderr}")
        print("matched 3200 columns; the planted fault was found")
    return 0


if __name__ == "__main__":
    sys.exit(main())
