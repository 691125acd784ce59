#!/usr/bin/env python3
"""Finds the highest frame rates at which the simulated FPGA of an ECPIX-5 (simulate.sh) loses nothing.

    rates.py [--kinds KIND,...] [--sizes ROWS,...] [--percent P] [--jumbo] [--json FILE] [--keep]
             (takes half an hour)

The trigger sequencer sets the rate of the test camera. The camera's images have 512 columns and ROWS rows (default: 96
and 16). At its highest rate it makes no pause between frames. A KIND is binary or grey (moments; grey means grey-over),
or images (raw images with grey moments). The default is all three. With large images the pixel clock limits the rate.
For each kind the sizes are tried in descending order, down to the first one at which the link limits the rate.

The rate is found by halving intervals until a rate that loses nothing lies within P percent (default: 1) of one that
loses. The FPGA's memory for packets can hide an overload for a while. So each rate is tried for 1.2 times as long as
the memory could hide an overload of P percent, and the rate found is too high by at most P percent. The board's own
counters say what it loses. Every recorded packet must equal that of the models. Packets that the PC's kernel loses are
counted separately. --json writes the figures into a file, --keep into the folder results. The exit status is 77 if
simulate.sh cannot run. Standard library only.
"""

import argparse
import json
import math
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
import results  # noqa: E402

SIMULATION = HERE / "simulate.sh"
DEVICE = ["--device", "udp:192.168.1.50"]
COLUMNS = 512
PIXEL_CLOCK = 125e6  # Hz; four pixels in each clock
CABLE = 125e6        # bytes a second
MEMORY = 80 * 1024   # bytes of packets: the link's ring, and the FIFOs of moments and raw images
# Bytes in addition to the payload. Of each packet: its header and trailer. Of each datagram on the cable: its own
# header, UDP, IP, Ethernet with its check sequence, and the preamble and gap of an Ethernet frame.
PACKET, DATAGRAM = 64 + 16, 16 + 8 + 20 + 18 + 20
MOMENT = {"binary": 4, "grey": 8, "images": 8}  # bytes a column
SETTINGS = {"binary": ["measure.mode=binary", "control.image=0"],
            "grey": ["measure.mode=grey-over", "control.image=0"],
            "images": ["measure.mode=grey-over", "control.image=1"]}
LOST = ["lost_moments", "lost_image"]
SETTLE = 375_000  # pixel clocks; by then the link has sent all that it holds, and has reported 2 ms of silence


class RatesError(Exception):
    """Says what went wrong."""


def cable_bytes(kind, rows, jumbo):
    """Returns the bytes that a frame takes on the cable, gaps included."""
    piece = (9000 if jumbo else 1500) - 28 - 16
    piece -= piece % 16
    packets = [PACKET + COLUMNS * MOMENT[kind], *([PACKET + COLUMNS] * rows if kind == "images" else [])]
    return sum(packet + math.ceil(packet / piece) * DATAGRAM for packet in packets)


class Board:
    """The simulated board. This class works only in a COMMAND that simulate.sh runs."""

    def __init__(self, rows):
        self.rows = rows
        self.folder = pathlib.Path(os.environ["work"])

    @staticmethod
    def do(*words):
        # On a busy machine an answer may come too late for the program.
        for _ in range(10):
            done = subprocess.run(["selfproj", "board", words[0], *DEVICE, *words[1:]], capture_output=True, text=True,
                                  check=False)
            if not done.returncode:
                return done.stdout
        raise RatesError(f"selfproj board {words[0]}: {done.stderr.strip()}")

    def counters(self):
        """Returns the frames, the lost packets, and the low word of the time in pixel clocks."""
        text = self.do("status")
        value = {name: int(re.search(rf"^0x\w+ {name} .*\b(?:count|low)=(\d+)", text, re.M)[1])
                 for name in ["frames", *LOST, "time_low"]}
        return value["frames"], sum(value[name] for name in LOST), value["time_low"]

    def record(self):
        """Starts to record. Returns the process when it listens on its port."""
        process = subprocess.Popen(["selfproj", "record", *DEVICE, "--out", self.folder / "packets"],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        (self.folder / "record.pid").write_text(f"{process.pid}\n", encoding="utf-8")
        while process.poll() is None and ":04D3 " not in pathlib.Path("/proc/net/udp").read_text(encoding="utf-8"):
            time.sleep(0.05)  # until port 1235 (04D3 in hexadecimal) is open
        return process

    def run(self, kind, period, least):
        """Runs at least `least` frames, or until a packet is lost. Returns the figures."""
        self.do("set", "measure.threshold=100", f"size.rows={self.rows}", *SETTINGS[kind])
        self.do("trigger", "--period", str(period))
        frames_before, lost_before, _ = self.counters()
        process = self.record()
        self.do("start")
        frames, lost = 0, 0
        while frames < least and not lost:
            time.sleep(0.2)
            now, lost_now, _ = self.counters()
            frames, lost = now - frames_before, lost_now - lost_before
        self.do("stop")
        frames, lost, stopped = self.counters()
        while (self.counters()[2] - stopped) % 2**32 < SETTLE:
            time.sleep(0.2)
        self.do("trigger", "--off")
        frames, lost, _ = self.counters()
        (self.folder / "record.pid").unlink()
        process.send_signal(signal.SIGINT)
        said = process.communicate()[0]
        if process.returncode:
            raise RatesError(f"selfproj record: {said.strip()}")
        lost_host = int(re.search(r"lost in the network ([\d,]+)", said)[1].replace(",", ""))
        return self.compared(kind, period, frames - frames_before, lost - lost_before, lost_host)

    def compared(self, kind, period, frames, lost, lost_host):
        """Returns the figures of a run. Raises RatesError unless the recorded packets equal those of the models."""
        done = subprocess.run([os.environ["compare"], self.folder / "packets", f"{COLUMNS}x{self.rows}",
                               f"triggered={period}"], capture_output=True, text=True, check=False)
        if not done.stdout:
            raise RatesError(f"compare_packets: {done.stderr.strip()}")
        compared = json.loads(done.stdout)
        sent = frames * (1 + self.rows * (kind == "images")) - lost
        if compared["packets"] == sent:
            lost_host = 0  # the recorder got the end of the session before, and counted the losses of that one
        figures = {"period": period, "per_s": round(PIXEL_CLOCK / period, 1), "frames": frames,
                   "lost_board": lost, "lost_host": lost_host, **compared}
        if figures["equal"] != figures["packets"] or figures["packets"] + lost_host != sent:
            raise RatesError(f"{kind}, {period} clocks: {sent} packets were sent, {figures['packets']} recorded, "
                             f"{figures['equal']} of them the models', {lost_host} lost on the way to the PC")
        print(f"{kind}, {COLUMNS} x {self.rows}: {figures['per_s']:,.0f} frames/s ({period:,} clocks): {frames:,} "
              f"frames, {lost:,} packets lost by the board, {lost_host:,} by the PC", flush=True)
        return figures


def search(trial, fastest, percent):
    """Returns the figures of the fastest rate without a loss, and of the slowest rate with one (None if there is none).

    `trial` takes a period in pixel clocks. `fastest` is the shortest period of the camera."""
    good, bad = trial(fastest), None
    while good["lost_board"]:
        bad, good = good, trial(2 * good["period"])
    while bad and good["period"] > bad["period"] * (1 + percent / 100) and good["period"] > bad["period"] + 1:
        middle = trial(round(math.sqrt(good["period"] * bad["period"])))
        if middle["lost_board"]:
            bad = middle
        else:
            good = middle
    return good, bad


def inside(words):
    """Measures the kinds with images of one size, and writes the figures."""
    rows = words.sizes[0]
    board, found = Board(rows), {}
    seconds = seconds_of(words.percent)
    for kind in words.kinds:
        runs = []

        def trial(period, kind=kind, runs=runs):
            runs.append(board.run(kind, period, math.ceil(seconds * PIXEL_CLOCK / period)))
            return runs[-1]

        good, bad = search(trial, COLUMNS // 4 * rows, words.percent)
        found[kind] = good | {
            "limit": "link" if bad else "pixel clock", "loses": bad,
            "cable": round(cable_bytes(kind, rows, words.jumbo) * good["per_s"] / CABLE, 4), "runs": len(runs),
            **{f"all_{key}": sum(run[key] for run in runs) for key in ("frames", "packets", "equal", "lost_host")}}
    words.inside.write_text(json.dumps(found), encoding="utf-8")


def seconds_of(percent):
    """Returns the simulated seconds for which a rate is tried."""
    return 1.2 * MEMORY / (CABLE * percent / 100)


def measure(words):
    """Returns the figures by kinds and rows."""
    found = {kind: {} for kind in words.kinds}
    left = words.kinds
    for rows in words.sizes:
        with tempfile.TemporaryDirectory(prefix="target-rates.") as folder:
            file = pathlib.Path(folder) / "found.json"
            jumbo = ["--jumbo"] * words.jumbo
            status = subprocess.run([SIMULATION, *jumbo, "--rows", str(rows), "--", sys.executable, "-B", __file__,
                                     *jumbo, "--kinds", ",".join(left), "--sizes", str(rows),
                                     "--percent", str(words.percent), "--inside", file], check=False).returncode
            if status:
                sys.exit(status)  # simulate.sh has printed the reason
            of_size = json.loads(file.read_text(encoding="utf-8"))
        for kind, figures in of_size.items():
            found[kind][str(rows)] = figures
        left = [kind for kind in left if of_size[kind]["limit"] == "pixel clock"]
        if not left:
            break
    every = [figures for of in found.values() for figures in of.values()]
    totals = {key: sum(figures[f"all_{key}"] for figures in every)
              for key in ("frames", "packets", "equal", "lost_host")}
    return found | {"percent": words.percent, "milliseconds": round(1000 * seconds_of(words.percent), 1),
                    "runs": sum(figures["runs"] for figures in every), "all": totals}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)

    def kinds(text):
        if unknown := [kind for kind in text.split(",") if kind not in SETTINGS]:
            raise argparse.ArgumentTypeError(f"'{unknown[0]}' is not one of {', '.join(SETTINGS)}")
        return list(dict.fromkeys(text.split(",")))

    def sizes(text):
        if not re.fullmatch(r"\d+(,\d+)*", text) or not all(5 <= int(rows) <= 127 for rows in text.split(",")):
            raise argparse.ArgumentTypeError(f"'{text}' is not a list of numbers of rows from 5 to 127")
        return sorted({int(rows) for rows in text.split(",")}, reverse=True)

    def percent(text):
        if not re.fullmatch(r"\d+(\.\d+)?", text) or not 0.1 <= float(text) <= 50:
            raise argparse.ArgumentTypeError(f"'{text}' is not a number from 0.1 to 50")
        return float(text)

    parser.add_argument("--kinds", type=kinds, default=list(SETTINGS), metavar="KIND,...")
    parser.add_argument("--sizes", type=sizes, default=[96, 16], metavar="ROWS,...")
    parser.add_argument("--percent", type=percent, default=1.0, metavar="P")
    parser.add_argument("--jumbo", action="store_true")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE")
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--inside", type=pathlib.Path, help=argparse.SUPPRESS)  # in simulate.sh, for this script
    return parser.parse_args()


def main():
    words = arguments()
    try:
        if words.inside:
            inside(words)
            return
        found = measure(words)
        if words.json:
            words.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    except (RatesError, OSError) as error:
        sys.exit(f"rates.py: {error}")
    for kind in words.kinds:
        for rows, figures in found[kind].items():
            print(f"{kind}, {COLUMNS} x {rows}: {figures['per_s']:,.0f} frames/s without a loss, limited by the "
                  f"{figures['limit']}, {figures['cable']:.0%} of the cable")
    if words.keep:
        results.write(f"target_rates{'_jumbo' * words.jumbo}",
                      "The highest frame rates without a loss of the FPGA of an ECPIX-5 in simulation",
                      " ".join(["constraints/ecpix5/rates.py", *sys.argv[1:]]), found, ROOT / "results")


if __name__ == "__main__":
    main()
