#!/usr/bin/env python3
"""Tests that every file that a command writes is read again by every command that takes such a file.

    pairs_test.py PROGRAMS MAKE_PARTS

PROGRAMS is the folder of selfproj and selfproj-sim, MAKE_PARTS a program that writes packets of parts. The rigs have every key that a rig may have, those in sections
within sections as well, and are small.
"""

import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import depth_stream

programs = pathlib.Path()
make_parts = ""

# What a rig may have beside what the built-in ones have.
BOARD = "board:\n  pixel_clock_hz: 1.25e+08\n"
RUNS = "  runs:\n    gap_rows: 1\n    ambiguous_from: 0.75\n"
WINDOW = "  window:\n    first_row: 2\n    last_row: 95\n"
PARTS = ("parts:\n  cut: profile\n  belt: encoder\n  grid_mm: 1\n  above_mm: 5\n  min_width_mm: 4\n  gap_mm: 3\n"
         "  pause_ms: 50\n  min_length_mm: 5\n  length_mm: 200\n")
SCANNER_PARTS = "parts:\n  cut: image\n  grid_mm: 2\n  pause_ms: 50\n"
# The built-in rig as a calibration would write it: camera and projector through lenses, and the way of the belt.
LENS = "  k1: 0\n  k2: 0\n  p1: 0\n  p2: 0\n  k3: 0\n"
CALIBRATION = ("camera_lens:\n  fx_px: 625\n  fy_px: 5000\n  cx_px: 31.5\n  cy_px: 47.5\n" + LENS
               + "projector_lens:\n  fx_px: 2849.00284900285\n  fy_px: -3257.328990228013\n  cx_px: 255.5\n"
               "  cy_px: 876.0211726384365\n" + LENS
               + "projector_pose:\n  rotation_x_deg: -20\n  rotation_y_deg: 0\n  rotation_z_deg: 0\n"
               "  translation_x_mm: 0\n  translation_y_mm: -132.74\n  translation_z_mm: -664.47\n")
BELT = ("belt_pose:\n  direction_x: 0\n  direction_y: 1\n  direction_z: 0\n  normal_x: 0\n  normal_y: 0\n"
        "  normal_z: 1\n")
LIGHT_PLANE = ("light_plane:\n  normal_x: 0\n  normal_y: 0.8575636838703195\n  normal_z: 0.5143777953893088\n"
               "  distance_mm: 600.2789\n")


def png_of(rows, columns, lit):
    """A pattern for the projector, white in the rows `lit`."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    pixels = b"".join(b"\0" + bytes([255 * (row in lit)]) * columns for row in range(rows))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(pixels)) + chunk(b"IEND", b""))


def without(text, section):
    return re.sub(rf"^{section}:\n(?:  .*\n)+", "", text, flags=re.M)


class Pairs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.folder = pathlib.Path(scratch.name)
        light = cls.shell("selfproj rig light-section")
        light = light.replace("  columns: 512\n  pixel_pitch", "  columns: 64\n  pixel_pitch")
        every_key = re.sub(r"(  max_z_per_line_mm: .*\n)", r"\g<1>" + RUNS + WINDOW, light) + PARTS
        every_key = every_key.replace("measure:\n", BOARD + "measure:\n", 1)
        cls.write("light.yaml", every_key)
        cls.write("lenses.yaml", every_key + CALIBRATION + BELT)
        laser = without(every_key, "projector") + CALIBRATION[:CALIBRATION.index("projector_lens")]
        cls.write("laser.yaml", laser + LIGHT_PLANE + BELT)
        scanner = (cls.folder / depth_stream.coarse_rig(cls.folder)).read_text(encoding="utf-8")
        cls.write("scanner.yaml", scanner.replace("measure:\n", BOARD + "measure:\n", 1) + SCANNER_PARTS)

    @classmethod
    def write(cls, name, text):
        (cls.folder / name).write_text(text, encoding="utf-8")

    @classmethod
    def shell(cls, line, status=0):
        environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "LC_ALL": "C"}
        done = subprocess.run(["bash", "-eu", "-c", line], cwd=cls.folder, env=environment, capture_output=True,
                              text=True, timeout=300, check=False)
        assert done.returncode == status, f"{line}\n{done.stdout[-2000:]}{done.stderr}"
        return done.stdout

    def read_as_written(self, rig):
        """`selfproj rig` reads what it wrote, and no value is lost. Returns the file it wrote."""
        self.shell(f"selfproj rig {rig} > a.yaml; selfproj rig a.yaml > b.yaml; cmp a.yaml b.yaml")
        return (self.folder / "a.yaml").read_text(encoding="utf-8")

    def test_rigs(self):
        for rig in ("light.yaml", "lenses.yaml", "laser.yaml", "scanner.yaml"):
            text = self.read_as_written(rig)
            given = (self.folder / rig).read_text(encoding="utf-8")
            for line in re.findall(r"^ *[a-z_0-9]+:(?= |$)", given, flags=re.M):
                self.assertIn(line.strip(), text)

    def light_section(self, rig):
        """Every file of a light section, and every command that takes it."""
        out = rig.replace(".", "_")
        self.shell(f"""
            mkdir {out}; cp {rig} {out}/given.yaml; cd {out}
            selfproj rig given.yaml > given2.yaml
            selfproj pattern --rig given2.yaml --sweep --every 8 --out lines
            selfproj pattern --rig given2.yaml --line 200 --out line
            selfproj pattern gray --rig given2.yaml --out gray
            for height in 0 15 30 45; do
              selfproj-sim capture --rig given2.yaml --patterns lines --plate $height --out at$height
            done
            selfproj calibrate heights --rig given2.yaml --every 8 --heights 0,15,30,45 --out heights \
              at0 at15 at30 at45
            selfproj rig heights/rig.yaml > rig.yaml
            selfproj calibrate heights --rig rig.yaml --every 8 --heights 15 --check at15
            selfproj calibrate heights --rig rig.yaml --every 8 --heights 0,15,30,45 --out again at0 at15 at30 at45
            selfproj-sim capture --rig given2.yaml --patterns lines --scene stairs --stopped --out scan
            selfproj pattern --rig rig.yaml --scan scan --every 8 --out good
            selfproj-sim scene render stairs --rig given2.yaml --pattern good/pattern.tiff --first 690 --count 20 \
              --truth truth.tiff --out seen
            selfproj pattern --rig rig.yaml --reference good --residual seen --out part
            selfproj pattern --rig rig.yaml --reference part --residual seen --out part2
            selfproj-sim cosim --rig rig.yaml --engine model --frames 'seen/*.png' --packets a.packets --out cosim
            selfproj-sim board --images seen/*.png --threshold 20 --select strongest --gap 1 --rows 2..95 \
              --record b.packets
            selfproj record --device file:a.packets --count 20 --out c.packets
            for reference in good part part/reference.csv part2; do
              selfproj inspect --rig rig.yaml --device file:a.packets --reference $reference --check --count 20 \
                --out result
            done
            selfproj-sim board --replay a.packets --record d.packets
            cmp a.packets c.packets
            for packets in b c d; do
              selfproj inspect --rig rig.yaml --device file:$packets.packets --reference part --check --count 20 \
                --out result
            done
            selfproj pattern --rig rig.yaml --reference result/height.tiff --out by_heights
            selfproj pattern --rig rig.yaml --reference truth.tiff --out by_truth
            selfproj inspect --rig rig.yaml --device file:a.packets --reference by_truth --out result2
        """)
        text = self.read_as_written(f"{out}/heights/rig.yaml")
        for key in ("runs:", "gap_rows: 1", "ambiguous_from: 0.75", "window:", "first_row: 2", "pixel_clock_hz:",
                    "corrections_mm:", "min_width_mm:"):
            self.assertIn(key, text)

    def test_light_section(self):
        self.light_section("light.yaml")

    def test_packets_measured_otherwise_than_the_reference(self):
        self.shell("""
            mkdir other; cd other
            selfproj pattern --rig ../light.yaml --sweep --every 8 --out lines
            selfproj-sim capture --rig ../light.yaml --patterns lines --scene stairs --stopped --out scan
            selfproj pattern --rig ../light.yaml --scan scan --every 8 --out good
            selfproj-sim scene render stairs --rig ../light.yaml --pattern good/pattern.tiff --first 690 --count 2 \
              --out seen
            selfproj-sim cosim --rig ../light.yaml --engine model --frames 'seen/*.png' --select all \
              --packets all.packets
        """)
        self.shell("cd other; selfproj inspect --rig ../light.yaml --device file:all.packets --reference good "
                   "--out result 2> said.txt", 2)
        said = (self.folder / "other/said.txt").read_text(encoding="utf-8")
        self.assertRegex(said, r"^selfproj: file:all.packets: .*all lit pixels.*the strongest run, gap 1")
        self.assertEqual(said.count("\n"), 1)

    def test_scanner(self):
        self.shell("""
            mkdir scanner; cd scanner
            selfproj rig ../scanner.yaml > rig.yaml
            selfproj accuracy --rig rig.yaml --out accuracy
            selfproj pattern gray --rig rig.yaml --out codes
            selfproj-sim capture --rig rig.yaml --scene plane --patterns codes --out captures
            selfproj pattern stripes --rig rig.yaml --scan captures --gray-code --bits 4 --out reference
            selfproj-sim scene render desk --rig rig.yaml --bits 6 --count 12 --out frames
            selfproj depth --rig rig.yaml --bits 6 --out depth frames/frame_*.png
            selfproj depth --rig rig.yaml --bits 6 --background depth/depth.tiff --compare depth/cloud.ply \
              --out depth2 frames/frame_*.png
            mkdir stripes; cp reference/pattern_*.png stripes
            selfproj-sim capture --rig rig.yaml --scene block --patterns stripes --out block
            selfproj match --rig rig.yaml --reference reference --e 8 --out match block/image_*.png
            selfproj depth --rig rig.yaml --bits 6 --compare match/cloud.ply --out depth3 frames/frame_*.png
            selfproj-sim board --images frames/*.png --bits 6 --record codes.packets
            selfproj record --device file:codes.packets --out again.packets
            selfproj depth --rig rig.yaml --bits 6 --device file:again.packets --out depth4
            selfproj images --device file:again.packets --out images
            selfproj pattern gray --rig rig.yaml --bits 7 --out lines
            selfproj-sim capture --rig rig.yaml --scene desk --patterns lines --out by_lines
            selfproj depth --rig rig.yaml --bits 7 --out depth5 by_lines/image_*.png
            selfproj-sim capture --rig rig.yaml --scene desk --patterns codes --out by_both
            selfproj depth --rig rig.yaml --bits 7 --row-bits 7 --out depth6 by_both
            selfproj depth --rig rig.yaml --bits 7 --out depth7 by_both/image_{14..27}.png
            selfproj compare --out compared5 depth6/depth.tiff depth5/depth.tiff
            selfproj compare --out compared7 depth6/depth.tiff depth7/depth.tiff
            cmp lines/pattern_00.png codes/pattern_14.png
            cmp lines/pattern_13.png codes/pattern_27.png
        """)
        # The lines' code alone rounds more than both codes together, and gives the same surface otherwise.
        for compared in ("compared5", "compared7"):
            found = json.loads((self.folder / "scanner" / compared / "summary.json").read_text(encoding="utf-8"))
            self.assertLess(abs(found["mean_mm"]), 2)
            self.assertGreater(found["compared"], 1000)

    # With lenses, and with a laser line in place of the projector.
    def test_calibrated_rigs(self):
        self.shell("""
            mkdir calibrated; cd calibrated
            for rig in lenses laser; do
              selfproj rig ../$rig.yaml > $rig.yaml
              selfproj-sim scene render plane --rig ../light.yaml --count 2 --out seen_$rig
              selfproj-sim board --images seen_$rig/frame_*.png --threshold 20 --select strongest --gap 1 \
                --rows 2..95 --record $rig.packets
              selfproj inspect --rig $rig.yaml --device file:$rig.packets --out result_$rig
            done
            selfproj pattern --rig lenses.yaml --sweep --every 8 --out lines
        """)

    # A calibrated camera and a laser, for which one line of a projector stands. That command takes its own rig, too.
    def test_camera_and_laser(self):
        patterns = self.folder / "white_and_line"
        patterns.mkdir()
        (patterns / "0.png").write_bytes(png_of(768, 1024, range(768)))
        (patterns / "1.png").write_bytes(png_of(768, 1024, range(450, 455)))
        self.shell("""
            mkdir laser; cd laser; mkdir boards lines
            selfproj-sim capture --rig scanner --chessboard 9x7 --square 20 --poses 5 --patterns ../white_and_line \
              --out poses
            for pose in poses/pose_0?; do
              cp $pose/image_00.png boards/${pose##*/}.png; cp $pose/image_01.png lines/${pose##*/}.png
            done
            selfproj calibrate camera --rig ../light.yaml --chessboard 9x7 --square 20 --distortion 0 --laser lines \
              --out line boards
            selfproj calibrate camera --rig line/rig.yaml --chessboard 9x7 --square 20 --distortion 0 --laser lines \
              --out again boards
            cmp line/rig.yaml again/rig.yaml; cmp line/camera.yaml again/camera.yaml
            selfproj lines --threshold 30 --out found lines/*.png
        """)
        text = self.read_as_written("laser/line/rig.yaml")
        for key in ("light_plane:", "camera_lens:", "gap_rows: 1", "first_row: 2", "pixel_clock_hz:"):
            self.assertIn(key, text)

    # A laser has references of its own; another rig's is refused.
    def test_references_and_a_laser(self):
        self.shell("""
            mkdir references; cd references
            printf 'y_mm,z_mm\\n-50,1167\\n0,1147\\n50,1167\\n' > roof.csv
            selfproj pattern --rig ../light.yaml --reference roof.csv --out roof
            selfproj-sim scene render plane --rig ../light.yaml --count 2 --out seen
            selfproj-sim board --images seen/frame_*.png --threshold 20 --select strongest --gap 1 --rows 2..95 \
              --record a.packets
            selfproj inspect --rig ../light.yaml --reference roof --device file:a.packets --out result
        """)
        self.shell("cd references; selfproj inspect --reference roof --device file:a.packets --rig ../laser.yaml "
                   "--out refused 2> said.txt", 2)
        self.assertRegex((self.folder / "references/said.txt").read_text(encoding="utf-8"),
                         r"^selfproj: roof/reference.csv: was made for another rig.*\n$")
        self.assertFalse((self.folder / "references/refused").exists())
        self.shell("""
            cd references
            selfproj pattern --reference roof.csv --rig ../laser.yaml --out of_laser
            selfproj inspect --reference of_laser --device file:a.packets --rig ../laser.yaml --out by_laser
        """)

    def test_tolerances(self):
        self.shell(f"""
            mkdir parts; {make_parts} parts; cd parts
            selfproj rig rig.yaml > again.yaml
            selfproj record --device file:good.packets --out recorded.packets
            selfproj tolerance learn --rig rig.yaml --device file:good.packets --out a.yaml
            selfproj tolerance learn --rig again.yaml --device file:recorded.packets --out b.yaml
            cmp a.yaml b.yaml
            for tolerance in a b; do
              selfproj inspect --rig again.yaml --device file:run.packets --tolerance $tolerance.yaml \
                --parts parts_$tolerance --out result_$tolerance
            done
            cmp parts_a/parts.csv parts_b/parts.csv
            selfproj verdict table --rig rig.yaml --tolerance a.yaml --start 5980 --pitch 3000 --out v.yaml
            selfproj verdict table --rig again.yaml --tolerance b.yaml --start 5980 --pitch 3000 --out w.yaml
            tail -n +2 v.yaml > v; tail -n +2 w.yaml > w; cmp v w
            selfproj verdict show w.yaml
            selfproj verdict table --rig rig.yaml --tolerance a.yaml --start 5980 --pitch 3000 --shift -0.5 \
              --out shifted.yaml
            selfproj verdict show shifted.yaml | grep 'for parts that lie -0.5 mm across'
            selfproj inspect --rig again.yaml --device file:run.packets --tolerance a.yaml --verdict w.yaml --parts by_w
            (cat w.yaml | selfproj inspect --rig again.yaml --device file:run.packets --tolerance a.yaml \
              --verdict /dev/stdin --verdict-board --parts by_pipe 2>&1 || true) | grep 'needs a board with registers'
        """)


if __name__ == "__main__":
    make_parts = str(pathlib.Path(sys.argv.pop(2)).resolve())
    programs = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
