"""sbom_test.py BUILD PROGRAM: scripts/sbom.py lists what the program links, loads and was compiled from."""

import hashlib
import json
import pathlib
import subprocess
import sys
import unittest

SBOM = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "sbom.py"
BUILD = PROGRAM = None


class Sbom(unittest.TestCase):
    def test_packages_of_each_kind(self):
        done = subprocess.run([sys.executable, "-B", SBOM, BUILD, PROGRAM], capture_output=True, text=True, check=True)
        sbom = json.loads(done.stdout)
        program = sbom["metadata"]["component"]
        self.assertEqual(program["hashes"][0]["content"], hashlib.sha256(PROGRAM.read_bytes()).hexdigest())
        packages = {component["name"]: component for component in sbom["components"]}
        linked = [name for name in packages if name.startswith("libyaml-cpp") and not name.endswith("-dev")]
        self.assertEqual(len(linked), 1)
        for name in (*linked, "nlohmann-json3-dev", "libcli11-dev", "libreaderwriterqueue-dev"):
            self.assertIn(f"{name}@{packages[name]['version']}", packages[name]["purl"])
            self.assertTrue(packages[name]["licenses"][0]["license"]["name"])
        self.assertIn("libyaml-cpp", packages[linked[0]]["components"][0]["name"])
        self.assertEqual(len(packages[linked[0]]["components"][0]["hashes"][0]["content"]), 64)
        self.assertTrue(any(name.startswith("libopencv-imgcodecs") for name in packages), "it is loaded, not linked")
        self.assertFalse({"verilator", "libgtest-dev"} & set(packages), "nothing of other programs")

    def test_what_is_no_program(self):
        done = subprocess.run([sys.executable, "-B", SBOM, BUILD, BUILD], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (2, "", 1))


if __name__ == "__main__":
    BUILD, PROGRAM = map(pathlib.Path, sys.argv[1:])
    unittest.main(argv=sys.argv[:1])
