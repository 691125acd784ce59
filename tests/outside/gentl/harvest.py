"""Harvester, an independent consumer of GenTL, on the producer of this build.

Run by run.py, which names the producer and the programs in the environment.
"""

import logging
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import numpy
from genicam import gentl
from harvesters.core import Harvester

PRODUCER = os.environ["SELFPROJ_PRODUCER"]
SELFPROJ, SIMULATION = os.environ["SELFPROJ_PROGRAM"], os.environ["SELFPROJ_SIMULATION"]
TYPES = pathlib.Path(__file__).resolve().parents[3] / "host/gentl/gentl_types.h"
READY = gentl.DEVICE_ACCESS_STATUS_LIST.DEVICE_ACCESS_STATUS_READWRITE
TIMEOUT = 60  # s, for a machine that is busy
# Another process that opens a device and says what became of it.
SECOND_CONSUMER = """
import sys
from harvesters.core import Harvester
harvester = Harvester()
harvester.add_file(sys.argv[1])
harvester.update()
try:
    harvester.create({"id_": sys.argv[2]})
except Exception as error:
    print(type(error).__name__)
"""
logging.disable(logging.CRITICAL)  # Harvester logs what it raises as well


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}: {done.stdout}{done.stderr}"


def cloud(folder):
    """The points of the cloud that `selfproj inspect` wrote: x, y, z of each, as the bits of its floats."""
    text = (folder / "cloud.ply").read_bytes()
    data = text[text.index(b"end_header\n") + 11:]
    kind = numpy.dtype([("xyz", "<u4", 3), ("rest", "u1", 15)])
    return numpy.frombuffer(data, kind)["xyz"]


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.file = self.folder / "line.slfp"
        run(SIMULATION, "board", "--line", "512x96", "--record", self.file)

    def harvester(self, devices):
        os.environ["SELFPROJ_GENTL_DEVICES"] = devices
        harvester = Harvester()
        self.addCleanup(harvester.reset)
        harvester.add_file(PRODUCER)
        harvester.update()
        return harvester

    def raises(self, kind, text):
        return self.assertRaisesRegex(kind, re.escape(text))

    def ends(self, camera, text):
        with self.raises(gentl.IoException, text):
            camera.fetch(timeout=TIMEOUT)


class Standard(unittest.TestCase):
    def test_values_are_those_of_the_standard(self):
        """Harvester's binding has its own list of them."""
        theirs = {name: int(value) for kind in vars(gentl).values() if isinstance(kind, type)
                  for name, value in getattr(kind, "__members__", {}).items() if "_" in name}
        ours = dict(re.findall(r"\b([A-Z][A-Z0-9_]+) = (-?\d+)\b", TYPES.read_text(encoding="utf-8")))
        self.assertGreater(len(ours), 150)
        self.assertEqual({name: int(value) for name, value in ours.items()}, {name: theirs.get(name) for name in ours})


class Recording(Case):
    def test_points_are_those_of_inspect(self):
        run(SELFPROJ, "inspect", "--device", f"file:{self.file}", "--out", self.folder / "out")
        expected = cloud(self.folder / "out")
        with self.harvester(f"file:{self.file}").create(0) as camera:
            nodes = camera.remote_device.node_map
            self.assertEqual((nodes.Width.value, nodes.Height.value, nodes.PixelFormat.value),
                             (512, 64, "Coord3D_ABC32f"))
            self.assertTrue(nodes.Scan3dInvalidDataFlag.value and numpy.isnan(nodes.Scan3dInvalidDataValue.value))
            nodes.Height.value = 16
            nodes.ChunkModeActive.value = True
            nodes.ComponentSelector.value = "Intensity"
            nodes.ComponentEnable.value = True
            self.assertEqual(nodes.PixelFormat.value, "Mono16")
            camera.start()
            points, frames, line = [], [], 0
            while line < 100:
                with camera.fetch(timeout=TIMEOUT) as buffer:
                    depth, lit = buffer.payload.components
                    frames.append((buffer.module.frame_id, nodes.ChunkFrameID.value, depth.height))
                    values = depth.data.view("<u4").reshape(-1, 3)
                    valid = ~numpy.isnan(depth.data.reshape(-1, 3)[:, 2])
                    self.assertTrue((lit.data[valid] >= 3).all())  # the rig's min_lit_px
                    points.append(values[valid].copy())
                    for i in (0, depth.height - 1):
                        nodes.ChunkScanLineSelector.value = i
                        self.assertEqual((nodes.ChunkLineFrameNumber.value, nodes.ChunkEncoderValue.value),
                                         (line + i, 10 * (line + i)))
                    line += depth.height
                    self.assertEqual(nodes.ChunkCountDelivered.value, line)
                    self.assertEqual(nodes.ChunkCountMissing.value, 0)
            self.assertEqual(frames, [(i, i, 16) for i in range(6)] + [(6, 6, 4)])
            numpy.testing.assert_array_equal(numpy.concatenate(points), expected)
            self.ends(camera, f"file:{self.file}: the recording has ended")

    def test_opens_and_closes(self):
        harvester = self.harvester(f"file:{self.file}")
        for i in range(int(os.environ.get("SELFPROJ_OPENS", "20"))):
            camera = harvester.create(0)
            if i % 5 == 0:
                camera.start()
                with camera.fetch(timeout=TIMEOUT) as buffer:
                    self.assertEqual(buffer.module.frame_id, 0)
                camera.stop()
            camera.destroy()
        print(f"{i + 1} opens and closes")
        self.assertLess(len(os.listdir("/proc/self/fd")), 40)

    def test_a_second_consumer_and_a_wrong_device(self):
        harvester = self.harvester(f"file:{self.file};file:{self.folder}/none")
        with harvester.create(0) as camera:
            with self.assertRaises(gentl.ResourceInUseException):
                harvester.create(0)
            self.assertEqual(camera.remote_device.node_map.DeviceID.value, f"file:{self.file}")
        with self.raises(gentl.IoException, f"{self.folder}/none: No such file or directory"):
            harvester.create(1)

    def test_locked_and_wrong_features(self):
        with self.harvester(f"file:{self.file}").create(0) as camera:
            nodes = camera.remote_device.node_map
            self.assertEqual((nodes.Threshold.value, nodes.MomentsMode.value, nodes.WindowFirstRow.value),
                             (60, "GreyOver", 0))
            with self.assertRaisesRegex(Exception, "not writable"):
                nodes.Threshold.value = 61
            with self.assertRaisesRegex(Exception, "8192"):
                nodes.Height.value = 8193
            nodes.PixelFormat.value = "Coord3D_C32f"
            self.assertEqual(nodes.Scan3dOutputMode.value, "CalibratedC")
            with self.assertRaises(Exception):
                nodes.PixelFormat.value = "Mono16"  # is one of Intensity


class Live(Case):
    def test_a_camera_without_a_board(self):
        """Aravis simulates a camera within this program."""
        harvester = self.harvester("camera:Fake_1?region=512x96&mode=grey&threshold=100&rate=100")
        try:
            camera = harvester.create(0)
        except gentl.IoException as error:
            if "Aravis" in str(error):
                self.skipTest("the producer was built without Aravis")
            raise
        with camera:
            nodes = camera.remote_device.node_map
            self.assertEqual((nodes.Threshold.value, nodes.MomentsMode.value), (100, "Grey"))
            self.assertIn("a camera without a board", nodes.BoardControl.value)
            nodes.Height.value = 16
            nodes.ComponentSelector.value = "Intensity"
            nodes.ComponentEnable.value = True
            nodes.ChunkModeActive.value = True
            camera.start()
            line = 0
            for frame in range(4):
                with camera.fetch(timeout=TIMEOUT) as buffer:
                    depth, lit = buffer.payload.components
                    self.assertEqual((buffer.module.frame_id, depth.width, depth.height), (frame, 512, 16))
                    # The camera's ramp has 256 grey values, of which a column sees 96.
                    self.assertEqual((lit.data.min(), lit.data.max()), (0, 96))
                    for i in range(16):
                        nodes.ChunkScanLineSelector.value = i
                        self.assertGreaterEqual(nodes.ChunkLineFrameNumber.value, line)
                        line = nodes.ChunkLineFrameNumber.value + 1

    def board(self, *words):
        board = subprocess.Popen([SIMULATION, "board", "--replay", str(self.file), *words],
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(board.wait)
        self.addCleanup(board.terminate)
        return board

    def camera(self, harvester, uri):
        """The camera with this ID, once its board is there."""
        for _ in range(100 * TIMEOUT):
            harvester.update()
            if any(info.id_ == uri and info.access_status == READY for info in harvester.device_info_list):
                return harvester.create({"id_": uri})
            time.sleep(0.01)
        raise AssertionError(f"no {uri}")

    def test_a_ring_without_loss_that_goes_away(self):
        # In the suite the ring has room for all of them, so that a busy machine loses none.
        lines, name = int(os.environ.get("SELFPROJ_LINES", "5000")), f"gentl-{os.getpid()}"
        # It stays when the board has gone, so that the second consumer finds it however late it is.
        self.addCleanup(pathlib.Path(f"/dev/shm/selfproj-ring-{name}").unlink, missing_ok=True)
        self.board("--ring", name, "--keep", "--wait-for-reader", "--count", str(lines), "--rate", "10000", "--slots",
                   "8192" if lines < 8192 else "16384")
        harvester = self.harvester("")  # rings of this machine appear by themselves
        with self.camera(harvester, f"ring:{name}") as camera:
            other = subprocess.run([sys.executable, "-c", SECOND_CONSUMER, PRODUCER, f"ring:{name}"],
                                   capture_output=True, text=True, check=False)
            self.assertIn("ResourceInUseException", other.stdout)  # Harvester leaves out the text of this one
            nodes = camera.remote_device.node_map
            nodes.Height.value = 250
            nodes.ChunkModeActive.value = True
            camera.start()
            line = frames = 0
            while line < lines:
                with camera.fetch(timeout=TIMEOUT) as buffer:
                    nodes.ChunkScanLineSelector.value = 0
                    self.assertEqual((nodes.ChunkLineFrameNumber.value, buffer.module.frame_id), (line, frames))
                    frames += 1
                    line += buffer.payload.components[0].height
                    lost = (nodes.ChunkCountLostBoard.value, nodes.ChunkCountLostRing.value,
                            nodes.ChunkCountMissing.value)
                    self.assertEqual(lost, (0, 0, 0))
            print(f"{line} lines, {lost[0] + lost[1] + lost[2]} lost, {frames} buffers")
            self.ends(camera, f"ring:{name}: the board has gone")

    def test_settings_of_a_board(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        address = f"127.{os.getpid() % 250 + 1}.{port % 250 + 1}.3"
        self.board("--loop", "--rate", "500", "--udp", f"127.0.0.1:{port}", "--from", address, "--control", address)
        harvester = self.harvester(f"udp:{address}:{port}?control=udp:{address}")
        for _ in range(TIMEOUT):  # until the board answers
            try:
                camera = harvester.create(0)
                break
            except gentl.IoException:
                time.sleep(0.1)
        with camera:
            nodes = camera.remote_device.node_map
            self.assertEqual(nodes.BoardControl.value, f"udp:{address}")
            for name, value in (("Threshold", 33), ("MomentsMode", "Grey"), ("WindowFirstRow", 5),
                                ("WindowLastRow", 90), ("MomentsSelect", "All")):
                getattr(nodes, name).value = value
                self.assertEqual(getattr(nodes, name).value, value)
            camera.start()
            with camera.fetch(timeout=TIMEOUT) as buffer:
                self.assertEqual(buffer.payload.components[0].height, 64)


if __name__ == "__main__":
    unittest.main()
