#!/usr/bin/env python3
"""Depth images of things that move, streamed by another process, against those of the same images from files.

    depth_stream.py PROGRAMS [--coarse] [--rate FPS] [--seconds S] [--record]

The scenes of the experiments B7 (mouse) and B8 (hands) are rendered under the self-projected stripes of their
references. `selfproj match` makes depth images of the files. `selfproj-sim board` then plays the same images in real
time through a ring, once as the codes that the board decodes and once as raw images, and `selfproj match` makes depth
images of that. Every depth image that comes on line must be equal, bit for bit, to its counterpart, and
what was delivered and what was lost must be what was sent.

--coarse takes images of 64 x 64 pixels instead of 512 x 512, and then plays once more into a small ring and stops the
reader until packets are lost. --record writes the figures into lab/results; they are those of codes.
"""

import argparse
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "scripts"))
import results  # noqa: E402

BITS = 4
PATTERNS = 2 * BITS
EXPERIMENTS = {"B7": ("mouse", "slider", 600), "B8": ("hands", "block", 328)}
COARSE = 8  # pixels of the rig that become one
# Counts of the driver that must be 0 in any case.
FAULTS = ("bad", "flagged", "lost_board", "missing", "repeated", "restarts", "read_errors", "resynchronized")


def coarse_rig(folder):
    """The scanner with a pixel for each 8 x 8."""
    text = (results.ROOT / "host/rig/scanner.yaml").read_text(encoding="utf-8")

    def scaled(key, factor):
        nonlocal text
        text, count = re.subn(rf"^(  {key}: )([\d.]+)", lambda m: f"{m[1]}{float(m[2]) * factor:g}", text, flags=re.M)
        assert count, key

    for key in ("rows", "columns", "lines"):
        scaled(key, 1 / COARSE)
    for key in ("pixel_pitch_um", "line_pitch_um", "column_pitch_um", "max_z_per_line_mm"):
        scaled(key, COARSE)
    scaled("max_lit_px", 1 / COARSE)
    text = text.replace("name: scanner", "name: coarse-scanner")
    (folder / "coarse.yaml").write_text(text, encoding="utf-8")
    return "coarse.yaml"


class Bench:
    """The programs, in a folder, with a rig."""

    def __init__(self, programs, folder, rig):
        self.programs, self.folder, self.rig = programs, folder, rig

    def run(self, program, *words):
        done = subprocess.run([self.programs / program, *map(str, words)], cwd=self.folder, capture_output=True,
                              text=True, check=False)
        assert done.returncode == 0, f"{program} {' '.join(map(str, words))}: {done.stderr}"
        return done.stdout

    def match(self, name):
        return [self.programs / "selfproj", "match", "--rig", self.rig, "--reference", "reference", "--out",
                name + ".out", "--list", name + ".csv"]

    def listed(self, name):
        """Pair → digests of its depth image."""
        lines = (self.folder / (name + ".csv")).read_text(encoding="utf-8").splitlines()
        assert lines[0] == "pair,pixels,depth,difference", lines[0]
        table = {}
        for line in lines[1:]:
            pair, *words = line.split(",")
            assert int(pair) not in table, f"pair {pair} came twice"
            table[int(pair)] = words
        return table

    def frames(self):
        return sorted(str(file.relative_to(self.folder)) for file in (self.folder / "frames").glob("frame_*.png"))

    def prepare(self, scene, reference, count):
        """Images of the scene under the patterns of its reference, and the depth images of two loops of them."""
        self.run("selfproj", "pattern", "gray", "--rig", self.rig, "--out", "codes")
        self.run("selfproj-sim", "capture", "--rig", self.rig, "--scene", reference, "--patterns", "codes", "--out",
                 "captures")
        self.run("selfproj", "pattern", "stripes", "--rig", self.rig, "--scan", "captures", "--gray-code", "--bits",
                 BITS, "--out", "reference")
        patterns = ",".join(f"reference/pattern_{i:02}.png" for i in range(PATTERNS))
        self.run("selfproj-sim", "scene", "render", scene, "--rig", self.rig, "--pattern", patterns, "--count", count,
                 "--out", "frames")
        frames = self.frames()
        assert len(frames) == count, len(frames)
        done = subprocess.run([*self.match("offline"), *frames, *frames], cwd=self.folder, capture_output=True,
                              text=True, check=False)
        assert done.returncode == 0, done.stderr
        return self.listed("offline")

    def ring(self, ring):
        """Packets written into the ring and lost at it; nothing while it has no reader."""
        line = re.search(rf"ring:{ring} +process \d+.*? +process \d+.*? +(\d+) +(\d+) +\d+ +\d+$",
                         self.run("selfproj", "devices"), re.M)
        return (int(line[1]), int(line[2])) if line else None

    def stall(self, ring, host, board):
        """Stops the reader until packets are lost, and the board when the reader has gone on for a while."""
        def until(done):
            while not done(self.ring(ring)):
                assert board.poll() is None, "the board ended too early"
                time.sleep(0.02)
        until(lambda seen: seen and seen[0] > 1000)
        host.send_signal(signal.SIGSTOP)
        until(lambda seen: seen and seen[1] > 100)
        host.send_signal(signal.SIGCONT)
        written = self.ring(ring)[0]
        until(lambda seen: seen and seen[0] > written + 10000)
        board.send_signal(signal.SIGINT)

    def stream(self, name, codes, rate, frames, slots):
        """Plays so many frames through a ring, or where `frames` is None until the reader has been stopped for a while
        and has gone on. Returns what the two processes tell."""
        ring = f"depth-stream-{os.getpid()}-{name}"
        source = ["--images", *self.frames(), *(["--bits", BITS] if codes else [])]
        length = ["--loop"] if frames is None else ["--count", str(frames)]
        board = subprocess.Popen([self.programs / "selfproj-sim", "board", *map(str, source), "--ring", ring, "--rate",
                                  str(rate), *length, "--wait-for-reader", "--keep", "--slots", str(slots)],
                                 cwd=self.folder, stdout=subprocess.PIPE, text=True)
        host = None
        try:
            # The ring exists until both processes have ended, so that the reader gets every packet.
            while not re.search(rf"ring:{ring} +process", self.run("selfproj", "devices")):
                assert board.poll() is None, "the board ended before it began"
                time.sleep(0.05)
            host = subprocess.Popen([*self.match(name), "--device", "ring:" + ring], cwd=self.folder,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            if frames is None:
                self.stall(ring, host, board)
            complaint = host.communicate(timeout=600)[1]
            assert host.returncode == 0, complaint
            said = board.communicate(timeout=600)[0]
        finally:
            for process in (host, board):
                if process is not None:
                    process.kill()  # ends one that is stopped, too
                    process.wait()
            subprocess.run([self.programs / "selfproj", "devices", "--remove", ring], check=False,
                           stderr=subprocess.DEVNULL)
        told = re.search(r"(\d+) frames in ([\d.]+) s: .* (\d+) packets, (\d+) lost in the full ring.*latest frame "
                         r"([\d.]+) ms late", said)
        assert told and frames in (None, int(told[1])), said
        device = json.loads((self.folder / (name + ".out/summary.json")).read_text(encoding="utf-8"))["device"]
        return {"frames": int(told[1]), "seconds": float(told[2]), "packets": int(told[3]), "lost": int(told[4]),
                "latest_frame_ms": float(told[5]), "device": device}

    def judge(self, name, offline, count, codes, sent):
        """Compares a stream with the files, and its counts with each other."""
        online = self.listed(name)
        frames, device = sent["frames"], sent["device"]
        for pair, words in online.items():
            # Within the first loop, or at the same place of the second.
            of = pair if pair < count // 2 else count // 2 + pair % (count // 2)
            assert words == offline[of], f"{name}: depth image {pair} differs from that of the files"
        counters = device["counters"] if "counters" in device else device
        delivered, lost = counters["delivered"], counters["lost_ring"]
        assert delivered + lost == sent["packets"], f"{name}: {delivered} + {lost} of {sent['packets']} packets"
        assert lost == sent["lost"], f"{name}: the board lost {sent['lost']} packets, the host counts {lost}"
        if not lost:
            assert not any(counters[key] for key in FAULTS), counters
        # The board begins to decode anew in each loop; raw images go on without a break.
        whole, rest = divmod(frames, count)
        loops = [count] * whole + ([rest] if rest else [])
        due = sum(max(0, loop // 2 - BITS + 1) for loop in loops) if codes else frames // 2 - BITS + 1
        assert len(online) <= due, (len(online), due)
        if not lost:
            assert len(online) == due, f"{name}: {len(online)} of {due} depth images"
        return {"frames_sent": frames, "packets_sent": sent["packets"], "packets_delivered": delivered,
                "packets_lost": lost, "depth_images_due": due, "depth_images": len(online), "equal": len(online),
                "not_made": due - len(online), "incomplete": device["incomplete"], "latest_frame_ms":
                sent["latest_frame_ms"], "frames_per_s": round(frames / sent["seconds"], 1)}


def main():
    parser = argparse.ArgumentParser(description="Depth images from a stream against those of files.")
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--coarse", action="store_true")
    parser.add_argument("--rate", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=1)
    parser.add_argument("--record", action="store_true")
    args = parser.parse_args()
    found = {}
    for name, (scene, reference, count) in EXPERIMENTS.items():
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            bench = Bench(args.programs.resolve(), folder, coarse_rig(folder) if args.coarse else "scanner")
            count = 48 if args.coarse else count
            offline = bench.prepare(scene, reference, count)
            frames = round(args.rate * args.seconds)
            kinds = {"codes": True, "images": False} if not args.record else {"codes": True}
            for kind, codes in kinds.items():
                sent = bench.stream(kind, codes, args.rate, frames, 65536 if not args.coarse else 16384)
                figures = bench.judge(kind, offline, count, codes, sent)
                print(name, kind, json.dumps(figures), flush=True)
                if args.coarse:
                    sent = bench.stream(kind + "-lost", codes, args.rate, None, 1024)
                    lost = bench.judge(kind + "-lost", offline, count, codes, sent)
                    print(name, kind, "with a reader that was stopped", json.dumps(lost), flush=True)
                    assert lost["packets_lost"] > 0 and lost["not_made"] > 0, lost
                if codes:
                    found[name] = {"rate_per_s": args.rate, "pixels": "64 x 64" if args.coarse else "512 x 512",
                                   "load": round(os.getloadavg()[0], 1), **figures}
    if args.record:
        results.write("depth_stream", "B7 and B8 from another process: depth images on line against those of the files",
                      "tests/cli/depth_stream.py build/bin " + " ".join(sys.argv[2:]), found,
                      results.ROOT / "lab/results")


if __name__ == "__main__":
    main()
