#!/usr/bin/env python3
"""Tests displays: an X server of its own with two of them, side by side and of different sizes.

    two_displays_test.py PROGRAM

PROGRAM is selfproj. Where Xorg or a tool is not installed, the exit status is 77.
"""

import os
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = ""
FIRST, SECOND = (640, 480), (800, 600)
CONFIGURATION = """
Section "Device"
  Identifier "card"
  Driver "dummy"
  VideoRam 65536
EndSection
Section "Monitor"
  Identifier "monitor"
  HorizSync 1-1000
  VertRefresh 1-1000
EndSection
Section "Screen"
  Identifier "screen"
  Device "card"
  Monitor "monitor"
  DefaultDepth 24
  SubSection "Display"
    Modes "640x480"
    Virtual 1600 1200
  EndSubSection
EndSection
"""


def start_server(folder):
    """An X server whose outputs are FIRST and, to the right of it, SECOND; (process, name of the display)."""
    (folder / "xorg.conf").write_text(CONFIGURATION)
    ours, theirs = os.pipe()
    server = subprocess.Popen(["Xorg", "-config", folder / "xorg.conf", "-logfile", folder / "log", "-noreset",
                               "-nolisten", "tcp", "-displayfd", str(theirs), "-novtswitch", "-nocursor"],
                              pass_fds=[theirs], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(theirs)
    with os.fdopen(ours) as answer:
        number = answer.readline().strip()
    if not number:
        server.wait()
        return None, ""
    display = f":{number}"
    place = f"{SECOND[0]}x{SECOND[1]}"
    # The last one lets the server look again at what is connected.
    for words in (["--addmode", "DUMMY1", place], ["--output", "DUMMY1", "--mode", place, "--right-of", "DUMMY0"],
                  ["--query"]):
        subprocess.run(["xrandr", *words], env={**os.environ, "DISPLAY": display}, check=True,
                       stdout=subprocess.DEVNULL)
    return server, display


def picture(display):
    """The whole screen as rows of grey values; every pixel must be grey."""
    data = subprocess.run(["xwd", "-root", "-silent"], env={**os.environ, "DISPLAY": display}, capture_output=True,
                          check=True).stdout
    head = struct.unpack(">25I", data[:100])
    width, height, step, stride, colours = head[4], head[5], head[11] // 8, head[12], head[19]
    pixels = data[head[0] + 12 * colours:]
    rows = []
    for row in range(height):
        line = pixels[row * stride:row * stride + step * width]
        assert line[0::step] == line[1::step] == line[2::step], "a pixel has a colour"
        rows.append(line[0::step])
    return rows


class TwoDisplays(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="selfproj-test-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.server, self.display = start_server(self.folder)
        self.assertIsNotNone(self.server, (self.folder / "log").read_text())
        self.addCleanup(self.stop)

    def stop(self):
        self.server.terminate()
        self.server.wait()

    def start(self, *words):
        return subprocess.Popen([PROGRAM, *words], cwd=self.folder, env={**os.environ, "DISPLAY": self.display},
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def run_to_end(self, *words):
        process = self.start(*words)
        out, err = process.communicate(timeout=60)
        return process.returncode, out, err

    def test_devices_lists_both(self):
        status, out, _ = self.run_to_end("devices")
        self.assertEqual(status, 0)
        self.assertRegex(out, r"--display 0 +640 x 480 .*DUMMY0\n--display 1 +800 x 600 .*DUMMY1\n")

    def test_a_pattern_fills_the_chosen_one_pixel_by_pixel(self):
        columns, rows = SECOND
        pattern = random.Random(1).randbytes(columns * rows)
        (self.folder / "p.pgm").write_bytes(b"P5\n%d %d\n255\n" % SECOND + pattern)
        before = picture(self.display)
        process = self.start("project", "--display", "1", "--seconds", "4", "p.pgm")
        wanted = [pattern[i * columns:(i + 1) * columns] for i in range(rows)]
        for _ in range(100):
            seen = picture(self.display)
            if [line[FIRST[0]:] for line in seen[:rows]] == wanted:
                break
            time.sleep(0.05)
        else:
            self.fail("the second display never shows the pattern")
        self.assertEqual([line[:FIRST[0]] for line in seen[:FIRST[1]]], [line[:FIRST[0]] for line in before[:FIRST[1]]],
                         "the first display has changed")
        out, err = process.communicate(timeout=60)
        self.assertEqual((process.returncode, out), (0, "1 pattern shown on display 1\n"), err)
        self.assertEqual(picture(self.display), before, "the displays are not left as they were found")

    def test_a_pattern_of_the_other_display_is_refused(self):
        (self.folder / "p.pgm").write_bytes(b"P5\n%d %d\n255\n" % FIRST + bytes(FIRST[0] * FIRST[1]))
        status, _, err = self.run_to_end("project", "--display", "1", "p.pgm")
        self.assertEqual(status, 2)
        self.assertRegex(err, r"^selfproj: p.pgm: [^\n]*800 x 600[^\n]*\n$")
        status, _, err = self.run_to_end("project", "--display", "2", "p.pgm")
        self.assertEqual(status, 2)
        self.assertRegex(err, r"^selfproj: --display 2: [^\n]*\n$")


def main():
    global PROGRAM
    PROGRAM = sys.argv.pop(1)
    if not all(shutil.which(tool) for tool in ("Xorg", "xrandr", "xwd")):
        print("Xorg, xrandr or xwd is not installed")
        return 77
    unittest.main()


if __name__ == "__main__":
    sys.exit(main())
