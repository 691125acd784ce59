"""Builds the examples of docs/from-outside.md and a program in C against files that were installed somewhere."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(*command, **options):
    """Runs a command, and ends the test with its output if it fails."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        print(f"{' '.join(map(str, command))}\nreturned {done.returncode}:\n{(done.stdout + done.stderr)[-4000:]}")
        sys.exit(1)
    return done.stdout


def require(holds, text):
    if not holds:
        print(text)
        sys.exit(1)


def blocks(language):
    """The blocks of code in this language on the front page, then those of the page for users."""
    page = "".join((ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "docs/from-outside.md"))
    return re.findall(rf"^```{language}\n(.*?)^```$", page, flags=re.DOTALL | re.MULTILINE)


def record(simulation, file):
    """A packet file of the size of the built-in light section."""
    run(simulation, "board", "--line", "512x96", "--record", file)


def build_cmake_example(prefix, folder, packets):
    """The lines of CMake and C++ of the front page: builds them against `prefix`, and returns what they print."""
    folder.mkdir()
    (folder / "CMakeLists.txt").write_text(blocks("cmake")[0], encoding="utf-8")
    (folder / "profiles.cpp").write_text(blocks("cpp")[0], encoding="utf-8")
    run("cmake", "-S", folder, "-B", folder / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}")
    run("cmake", "--build", folder / "build")
    shutil.copy(packets, folder / "line.slfp")
    return run(folder / "build/profiles", cwd=folder)


def build_c_example(prefix, folder):
    """The program in C99, by pkg-config: returns what it prints."""
    pkgconfig = next(prefix.rglob("pkgconfig"))
    flags = run("pkg-config", "--cflags", "--libs", "selfproj",
                env={**os.environ, "PKG_CONFIG_PATH": str(pkgconfig)}).split()
    run("cc", "-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", ROOT / "tests/outside/c_interface_c99.c", "-o",
        folder / "program", *flags)
    return run(folder / "program", env={**os.environ, "LD_LIBRARY_PATH": str(pkgconfig.parent)})
