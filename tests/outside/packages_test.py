#!/usr/bin/env python3
"""Makes the packages of Debian, installs them with dpkg into a root of their own, tries them, and removes them.

    packages_test.py BUILD SIMULATION
"""

import ctypes
import pathlib
import re
import shutil
import sys
import tempfile

import consumer


def fields_of(package):
    out = consumer.run("dpkg-deb", "--field", package)
    return dict(line.split(": ", 1) for line in out.splitlines() if ": " in line)


def dpkg(root, *words):
    """Runs dpkg on a root that has its own list of packages; what they depend on is outside of it."""
    return consumer.run("dpkg", f"--root={root}", "--force-not-root,depends,script-chrootless", *words)


def main():
    build = pathlib.Path(sys.argv[1])
    for tool in ("cpack", "dpkg", "dpkg-deb", "dpkg-shlibdeps", "apt-get", "pkg-config"):
        if not shutil.which(tool):
            print(f"skipped: {tool} is not installed")
            return 77
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        consumer.run("cpack", "--config", build / "CPackConfig.cmake", "-B", folder / "packages")
        packages = sorted((folder / "packages").glob("*.deb"))
        fields = {fields_of(package)["Package"]: fields_of(package) for package in packages}
        consumer.require(sorted(fields) == ["libselfproj-dev", "selfproj"], f"other packages: {sorted(fields)}")
        needed = {word.rstrip("0123456789") for word in re.split("[ ,]+", fields["selfproj"]["Depends"])}
        consumer.require({"libopencv-core", "libopencv-imgcodecs"} <= needed,
                         f"the programs' libraries are no dependencies: {sorted(needed)}")

        # What they depend on is there, says apt, which changes nothing.
        consumer.run("apt-get", "--simulate", "install", *packages)
        root = folder / "root"
        for part in ("info", "updates", "triggers"):
            (root / "var/lib/dpkg" / part).mkdir(parents=True)
        (root / "var/lib/dpkg/status").touch()
        dpkg(root, "--install", *packages)
        for package in fields:
            status = dpkg(root, "--status", package)
            consumer.require("Status: install ok installed" in status, f"{package}: not installed")
        consumer.require("calibrate" in consumer.run(root / "usr/bin/selfproj", "--help"), "selfproj --help")
        packets = folder / "line.slfp"
        consumer.record(root / "usr/bin/selfproj-sim", packets)
        consumer.run(root / "usr/bin/selfproj", "inspect", "--device", f"file:{packets}", "--check")
        producer = ctypes.CDLL(str(root / "usr/lib/selfproj/libselfproj.cti"))
        consumer.require(producer.GCInitLib() == 0 and producer.GCCloseLib() == 0, "the GenTL producer")
        consumer.require("z 1167.000 mm" in consumer.build_c_example(root / "usr", folder), "the program in C")
        dpkg(root, "--purge", *fields)
        left = [path for path in (root / "usr").rglob("*") if not path.is_dir()]
        consumer.require(not left, f"left behind: {left[:3]}")
        print(", ".join(f"{package.name} {package.stat().st_size // 1024} kB" for package in packages))
    return 0


if __name__ == "__main__":
    sys.exit(main())
