#!/usr/bin/env python3
"""Tests that the generator refuses a specification that contradicts itself, and notices when a file is out of date.

Runs generate.py --check, which writes nothing, on changed copies of selfproj.json. Standard library only.
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

TEST_FOLDER = pathlib.Path(__file__).resolve().parent
SPEC_FOLDER = TEST_FOLDER.parent.parent / "model" / "spec"


def named(items, name):
    """Returns the one of `items` with this name."""
    return next(item for item in items if item["name"] == name)


PROSE = ("name", "later", "description", "effect", "after_reset")


def beyond_the_hash(node, path="", counts=False):
    """Yields a line for each named item that the hash leaves out, with its values, in order, and without the prose."""
    if isinstance(node, list):
        for item in node:
            yield from beyond_the_hash(item, path, counts)
        return
    counts = counts or bool(node.get("later")) or "was" in node
    if path:
        path += " " + node.get("name", "")
    values = [f"{key}={value}" for key, value in node.items() if isinstance(value, (int, str)) and key not in PROSE]
    if counts and values:
        yield " ".join([*path.split(), *values])
    for key, value in node.items():
        if isinstance(value, (dict, list)) and key not in ("description", "planned", "was"):
            yield from beyond_the_hash(value, f"{path} {key}", counts or key in ("datagram", "replay", "link"))


class GeneratorTest(unittest.TestCase):

    def check(self, change):
        """Runs the check on a specification that change(spec) has altered; gives exit status and messages."""
        spec = json.loads((SPEC_FOLDER / "selfproj.json").read_text(encoding="utf-8"))
        change(spec)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "changed.json"
            path.write_text(json.dumps(spec), encoding="utf-8")
            result = subprocess.run([sys.executable, SPEC_FOLDER / "generate.py", "--check", "--spec", path],
                                    capture_output=True, text=True, check=False)
        return result.returncode, result.stderr

    def refused(self, change, reason):
        status, messages = self.check(change)
        self.assertEqual(status, 2, messages)
        self.assertIn(reason, messages)
        self.assertEqual(messages.count("\n"), 1, "an error is one line")

    @staticmethod
    def field(spec, fmt, name):
        return named(named(spec["formats"], fmt)["fields"], name)

    def test_unchanged(self):
        self.assertEqual(self.check(lambda spec: None), (0, ""))

    def test_out_of_date(self):
        status, messages = self.check(lambda spec: named(spec["sizes"], "max_rows").update(value=1000))
        self.assertEqual(status, 1)
        self.assertIn("selfproj_spec.h differs", messages)
        self.assertIn("sp_spec_pkg.sv differs", messages)
        self.assertIn("packet-reference.md differs", messages)
        self.assertIn("register-reference.md differs", messages)

    def test_prose_in_pieces_is_put_together(self):
        status, messages = self.check(lambda spec: spec["modes"][0].update(description=["a lit pixel ", "weighs 1"]))
        self.assertEqual((status, messages), (0, ""))

    def test_effect_does_not_change_the_hash(self):
        def change(spec):
            named(spec["registers"], "control")["fields"][0]["effect"] = "some day"
        status, messages = self.check(change)
        self.assertEqual(status, 1)
        self.assertEqual(re.findall(r"(\S+) differs", messages), ["docs/register-reference.md"])

    def test_prose_does_not_change_the_hash(self):
        status, messages = self.check(lambda spec: named(spec["modes"], "grey").update(description="other words"))
        self.assertEqual(status, 1)
        self.assertNotIn("sp_spec_pkg.sv", messages)  # has the hash, but not the description

    def test_what_came_later_does_not_change_the_hash(self):
        spec = json.loads((SPEC_FOLDER / "selfproj.json").read_text(encoding="utf-8"))
        sys.path.insert(0, str(SPEC_FOLDER))
        import generate
        self.assertEqual(generate.spec_hash(spec), 0x1A81A4C9)  # of version 2.0
        named(spec["kinds"], "compact").pop("later")
        self.assertNotEqual(generate.spec_hash(spec), 0x1A81A4C9)

    def test_what_the_hash_leaves_out_is_as_boards_and_hosts_have_it(self):
        """Nothing but this list notices if such an item moves. What is added to the specification is added to it."""
        spec = json.loads((SPEC_FOLDER / "selfproj.json").read_text(encoding="utf-8"))
        self.maxDiff = None
        self.assertEqual(list(beyond_the_hash(spec)),
                         (TEST_FOLDER / "beyond_the_hash.txt").read_text(encoding="utf-8").splitlines())

    def test_formats_that_do_not_fit(self):
        for fmt, name, bits in (("binary", "m1", 18), ("binary", "m0", 9), ("grey", "m1", 26), ("grey", "m0", 17),
                                ("grey", "n", 9), ("binary_run", "m1", 18), ("binary_run", "m0", 9),
                                ("binary_run", "runs", 1),
                                ("grey_run", "n", 9), ("grey_run", "second", 4), ("code", "code", 11),
                                ("compact", "centroid", 18), ("compact", "n", 5)):
            with self.subTest(format=fmt, field=name):
                self.refused(lambda spec: self.field(spec, fmt, name).update(bits=bits), f"{fmt}.{name}: ")

    def test_image_too_large_for_the_formats(self):
        self.refused(lambda spec: named(spec["sizes"], "max_rows").update(value=1024), "needs more than")

    def test_fields_that_overlap(self):
        self.refused(lambda spec: self.field(spec, "binary", "m0").update(lsb=19), "overlaps")

    def test_field_beyond_its_word(self):
        self.refused(lambda spec: self.field(spec, "grey", "n").update(lsb=55), "leaves its word")

    def test_unknown_name_in_an_expression(self):
        self.refused(lambda spec: self.field(spec, "binary", "m0").update(max="lines"), "cannot evaluate")

    def test_header_not_whole_beats(self):
        self.refused(lambda spec: named(spec["packet"]["header"], "region_column").update(bits=48), "whole number of beats")

    def test_field_not_aligned(self):
        def change(spec):
            header = spec["packet"]["header"]
            header.insert(0, header.pop([f["name"] for f in header].index("stream")))
        self.refused(change, "not aligned")

    def test_register_address_taken(self):
        self.refused(lambda spec: named(spec["registers"], "size").update(address="0x10"), "is taken")

    def test_register_field_too_wide(self):
        self.refused(lambda spec: named(spec["registers"], "frames")["fields"][0].update(bits=33), "leaves the word")

    def test_earlier_version_that_is_none(self):
        self.refused(lambda spec: spec["earlier_versions"][0].update(spec["version"]), "smaller number")
        self.refused(lambda spec: spec["earlier_versions"][0].update(reserved_byte=55), "within a field")

    def test_missing_file(self):
        result = subprocess.run([sys.executable, SPEC_FOLDER / "generate.py", "--check", "--spec", "no such file"],
                                capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 2)
        self.assertIn("no such file", result.stderr)


if __name__ == "__main__":
    unittest.main()
