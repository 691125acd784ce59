"""The Python package against the C interface and the programs: equal on random input of every function.

Run by run.py, which names the library and the programs in the environment. SELFPROJ_SEED draws other cases.
"""

import copy
import enum
import gc
import json
import os
import pathlib
import pickle
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
import zlib
from inspect import ismodule

import c_interface as c
import notebooks
import numpy
import pictures
import plyfile
import selfproj
from selfproj import (_core, calibration, cameras, driver, light_section, model, packets, parts, structured_light)
from selfproj import pictures as selfproj_pictures

SEED = int(os.environ.get("SELFPROJ_SEED", "1"))
PARTS = """
parts: {cut: profile, belt: encoder, grid_mm: 0.25, above_mm: 2, min_width_mm: 2, gap_mm: 3, pause_ms: 5,
        min_length_mm: 5, length_mm: 60}
"""
SELFPROJ, SIMULATION = os.environ["SELFPROJ_PROGRAM"], os.environ["SELFPROJ_SIMULATION"]


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}: {done.stdout}{done.stderr}"


def same(one, other):
    numpy.testing.assert_array_equal(one, other)
    assert one.dtype == other.dtype, (one.dtype, other.dtype)


class Case(unittest.TestCase):
    def setUp(self):
        self.random = numpy.random.default_rng(SEED)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def between(self, low, high):
        return int(self.random.integers(low, high + 1))

    def pixels(self, *shape):
        return self.random.integers(0, 256, shape, dtype="uint8")

    def measure(self):
        return {"threshold": self.between(0, 255), "mode": model.Mode(self.between(0, 2)),
                "select": model.Select(self.between(0, 1)), "gap": self.between(0, 3),
                "first_row": self.between(0, 4), "last_row": self.between(0, 60)}


class Model(Case):
    def test_moments(self):
        for _ in range(60):
            rows, columns = self.between(1, 60), self.between(5, 70)  # 3 and 4 are colours
            store = self.pixels(3, rows, columns + self.between(0, 5))
            images, how = store[::-1, :, :columns], self.measure()
            if self.between(0, 1):
                images = images[:, ::-1]
            for function in (model.moments, light_section.moments):
                several = function(images, **how)
                for number, image in enumerate(images):
                    one, wanted = function(image, **how), c.moments(image, how)
                    for name, values in zip(("m0", "m1", "n", "runs", "second"), wanted):
                        if name in ("runs", "second") and how["select"] == model.Select.ALL:
                            self.assertIsNone(getattr(one, name))
                            continue
                        same(getattr(one, name), values)
                        same(getattr(several, name)[number], values)

    def test_moments_of_more_bits(self):
        for _ in range(20):
            bits, rows, columns = self.between(8, 12), self.between(1, 60), self.between(5, 70)
            image = self.random.integers(0, 1 << bits, (rows, columns), dtype="uint16")
            threshold, first = self.between(0, (1 << bits) - 1), self.between(0, rows)
            row = numpy.arange(1, rows + 1)[:, None]
            lit = (image > threshold) & (row >= first)
            for mode, weight in ((model.Mode.BINARY, 1), (model.Mode.GREY, image.astype("int64")),
                                 (model.Mode.GREY_OVER, image.astype("int64") - threshold)):
                for function in (model.moments, light_section.moments):
                    given = function(image, threshold, bits=bits, mode=mode, first_row=first)
                    same(given.m0, numpy.where(lit, weight, 0).sum(0).astype("uint32"))
                    same(given.m1, numpy.where(lit, row * weight, 0).sum(0).astype("uint32"))
                    same(given.n, lit.sum(0).astype("uint32"))
            if bits > 8:  # values that 8 bits have, further up: the same runs, with weights as many times as large
                how = {"select": model.Select.STRONGEST, "gap": self.between(0, 3), "first_row": first}
                for mode in (model.Mode.BINARY, model.Mode.GREY):
                    narrow = model.moments((image >> bits - 8).astype("uint8"), threshold >> bits - 8, mode=mode, **how)
                    times = 1 if mode == model.Mode.BINARY else 1 << bits - 8
                    for function in (model.moments, light_section.moments):
                        wide = function(image >> bits - 8 << bits - 8, threshold >> bits - 8 << bits - 8, bits=bits,
                                        mode=mode, **how)
                        same(wide.m1, narrow.m1 * times)
                        same(wide.n, narrow.n)
                        same(wide.runs, narrow.runs)
                        same(wide.second, narrow.second)
        with self.assertRaisesRegex(ValueError, "threshold"):
            model.moments(image, 1 << bits, bits=bits)

    def test_decoders_and_median(self):
        for _ in range(12):
            rows, columns, bits, threshold = (self.between(1, 12), self.between(1, 40), self.between(1, 12),
                                              self.between(0, 60))
            shape = (rows, columns, bits, threshold)
            decoders = [model.GrayDecoder(*shape), structured_light.GrayDecoder(*shape)]
            medians, wanted = structured_light.GrayDecoder(*shape, median=True), c.Gray(*shape)
            for frame in range(6 * bits):
                image, good = self.pixels(rows, columns), self.between(0, 30) > 0
                pattern = self.between(-1, 2 * bits) if self.between(0, 30) == 0 else frame % (2 * bits)
                codes = wanted.take(image, pattern, good)
                given = [decoder.take(image, pattern, good) for decoder in (*decoders, medians)]
                if codes is None:
                    self.assertEqual(given, [None] * 3)
                    continue
                same(given[0], codes)
                same(given[1], codes)
                same(given[2], c.median3x3(codes))
                same(model.median3x3(codes), given[2])
            for decoder in (*decoders, medians):
                decoder.restart()
                self.assertIsNone(decoder.take(image, 1))

    def test_match(self):
        for _ in range(10):
            bits = self.between(1, 8)
            codes = (self.pixels(7, self.between(1, 9)).astype("uint16") % (1 << bits + 1) |
                     self.random.choice([0, 0x8000], 1).astype("uint16"))
            table = self.random.integers(0, 1 << 16, (*codes.shape, 1 << bits), dtype="uint16")
            same(model.match(codes, table), c.match(codes, table))


class Packets(Case):
    def test_equal_those_of_the_c_interface(self):
        for _ in range(40):
            image, how = self.pixels(self.between(1, 60), 4 * self.between(1, 30)), self.measure()
            fields = {"stream": self.between(0, 255), "lost": self.between(0, 2**32 - 1), "pattern": 7,
                      "sequence": self.between(0, 2**62), "time_stamp": self.between(0, 2**62), "encoder": 9}
            header = packets.Header()
            for name, value in fields.items():
                setattr(header, name, value)
            data = packets.moments_packet(image, header=header, **how)
            same(data, c.packet(image, how, **fields))
            packet = packets.parse(data)
            self.assertEqual({name: getattr(packet.header, name) for name in fields}, fields)
            given, wanted = packet.moments(), c.moments(image, how)
            for name, values in zip(("m0", "m1", "n"), wanted):
                same(getattr(given, name), values)
            if how["select"] == model.Select.STRONGEST:
                same(given.runs, wanted[3])
            same(packets.build(packet.header, packet.payload, 5), c.built(packet.payload, 5, **{
                name: getattr(packet.header, name) for name, _ in c.Header._fields_
                if name not in ("size", "reserved")}))
            damaged = data.copy()
            damaged[self.between(0, data.size - 1)] ^= 1
            with self.assertRaisesRegex(ValueError, "no packet: "):
                packets.parse(damaged)

    def test_bytes_are_not_copied_and_live_as_long_as_needed(self):
        data = packets.moments_packet(self.pixels(9, 16), 20)
        both = numpy.concatenate([data, data])
        first, second = packets.split(both)
        self.assertTrue(numpy.shares_memory(second.payload, both))
        self.assertTrue(numpy.shares_memory(first.bytes, both))
        self.assertFalse(numpy.shares_memory(first.copy().bytes, both))
        payload, wanted = packets.parse(data.tobytes()).payload, data[64:-16].copy()
        del both, first, second
        gc.collect()
        self.pixels(200, 200)  # whoever frees memory too early gets other bytes
        same(payload, wanted)
        self.assertFalse(payload.flags.writeable)

    def test_lines_become_images(self):
        for kind, dtype in ((packets.KIND_IMAGE, "uint8"), (packets.KIND_CODES, "uint16")):
            image = (self.random.integers(0, 1 << 12, (5, 20)) % 256).astype(dtype)
            assembler, given = driver.ImageAssembler(kind), None
            for row in range(5):
                header = packets.Header()
                header.kind, header.columns, header.rows, header.first_line, header.lines = kind, 20, 5, row + 1, 1
                line = numpy.zeros((image[row].nbytes + 15) // 16 * 16, "uint8")
                line[:image[row].nbytes] = image[row].view("uint8")
                packet = packets.parse(packets.build(header, line))
                self.assertIsNone(given)
                given = assembler.add(packet)
                if dtype == "uint16":
                    same(packet.codes(), image[row])
            same(given, image)
            self.assertEqual((assembler.complete, assembler.incomplete), (1, 0))


class LightSection(Case):
    def test_devices_profiles_and_maps_equal_those_of_inspect(self):
        file, out = self.folder / "line.slfp", self.folder / "out"
        run(SIMULATION, "board", "--line", "512x96", "--record", file)
        run(SELFPROJ, "inspect", "--device", f"file:{file}", "--out", out)
        rig = light_section.load_rig("light-section")
        profiler = light_section.Profiler(rig)
        inspection = light_section.Inspection(profiler)
        heights = []
        with driver.open(f"file:{file}") as device:
            for packet in device:
                self.assertTrue(inspection.add(packet))
                profile, moments = profiler.profile(packet), packet.moments()
                heights.append(rig.plane_z_mm - profile.z)
                for name, values in c.profile("light-section", moments.m0, moments.m1, moments.n).items():
                    same(getattr(profile, name), values)
                    same(getattr(profiler.profile_of_moments(moments.m0, moments.m1, moments.n), name), values)
            self.assertTrue(device.ended)
            self.assertEqual(device.counters()["delivered"], len(inspection))
        same(inspection.height(), light_section.load_tiff(str(out / "height.tiff")))
        same(inspection.difference(), light_section.load_tiff(str(out / "difference.tiff")))
        numpy.testing.assert_allclose(numpy.stack(heights), inspection.height(), atol=1e-4)
        self.assertEqual(inspection.belt_mm().shape, (len(inspection),))
        self.assertAlmostEqual(inspection.spacing_mm[0], inspection.belt_mm()[-1] / (len(inspection) - 1), delta=1e-6)
        self.assertAlmostEqual(inspection.spacing_mm[1], float(numpy.nanmedian(numpy.diff(profile.y))), delta=0.02)
        light_section.save_tiff(str(out / "again.tiff"), inspection.height())
        self.assertEqual((out / "again.tiff").read_bytes(), (out / "height.tiff").read_bytes())
        several = profiler.profile_of_moments(*(numpy.stack([values] * 3) for values in
                                                (moments.m0, moments.m1, moments.n)))
        same(several.z[2], profile.z)
        self.assertEqual((rig.name, rig.kind, rig.rows, rig.columns), ("light-section", "light-section", 96, 512))

    def test_a_device_does_not_move_on_while_arrays_lead_to_its_packet(self):
        file = self.folder / "two.slfp"
        header = packets.Header()
        first = packets.moments_packet(self.pixels(9, 16), 20, header=header)
        header.sequence, header.time_stamp = 1, 1000
        numpy.concatenate([first, packets.moments_packet(self.pixels(9, 16), 20, header=header)]).tofile(file)
        device = driver.open(f"file:{file}")
        packet = device.next(timeout=1)
        payload = packet.payload
        kept = packet.copy()
        for move in (device.next, device.release, device.close):
            with self.assertRaises(BufferError):
                move()
        wanted = payload.copy()
        del payload
        device.release()
        with self.assertRaisesRegex(ValueError, "moved on"):
            packet.moments()
        same(kept.payload, wanted)
        held = device.next()
        del device
        gc.collect()
        self.assertEqual(held.moments().m0.size, 16)


class StructuredLight(Case):
    def test_patterns(self):
        sequence = structured_light.GraySequence(24, 10)
        self.assertEqual((sequence.count, sequence.column_bits, sequence.row_bits), (20, 5, 4))
        bits = pictures.gray_bits(24, 10)
        for index in range(18):
            same(sequence.image(index), numpy.where(bits[index // 2] ^ index % 2, 255, 0).astype("uint8"))
        self.assertEqual((sequence.image(18).min(), sequence.image(19).max()), (255, 0))
        with self.assertRaises(IndexError):
            sequence.image(20)

    def test_scans_equal_those_of_depth(self):
        recorded, out = self.folder / "recorded", self.folder / "out"
        run(SIMULATION, "scene", "render", "desk", "--bits", "4", "--count", "8", "--out", recorded)
        run(SELFPROJ, "depth", "--rig", "scanner", "--bits", "4", "--median", "--out", out, recorded)
        scan = structured_light.scan([str(recorded)], rig="scanner", bits=4, median=True)
        same(scan.depth, light_section.load_tiff(str(out / "depth.tiff")))
        points = structured_light.load_ply(str(out / "cloud.ply"))
        same(scan.points(), points)
        vertices = plyfile.PlyData.read(out / "cloud.ply")["vertex"]  # by a reader that is not ours
        same(numpy.stack([vertices[axis] for axis in "xyz"], 1), points)
        last = [selfproj.read_image(file) for file in sorted(recorded.iterdir())[-2:]]
        seen = numpy.isfinite(scan.depth)
        same(vertices["intensity"], numpy.maximum(*last)[seen].astype("float32"))
        same(vertices["quality"], abs(last[0].astype("float32") - last[1])[seen])
        files = sorted(recorded.iterdir())
        images = [selfproj.read_image(file) for file in files]
        for given in (recorded, files, images, numpy.stack(images), numpy.stack(images)[:, ::-1][:, ::-1]):
            same(structured_light.scan(given, rig="scanner", bits=4, median=True).depth, scan.depth)
        with self.assertRaisesRegex(ValueError, "for files"):
            structured_light.scan(numpy.stack(images), rig="scanner", bits=4, channel="red")
        with self.assertRaisesRegex(selfproj.InputError, "image 3.*size"):
            structured_light.scan([*images[:3], images[3][:-1], *images[4:]], rig="scanner", bits=4)
        backwards = sorted(recorded.iterdir(), reverse=True)
        with self.assertRaisesRegex(selfproj.InputError, "another order"):
            structured_light.scan(backwards, rig="scanner", bits=4)
        structured_light.scan(backwards, rig="scanner", bits=4, unchecked=True)
        wide = structured_light.scan(files, rig="scanner", bits=4, median=True, lines=1024, unchecked=True)
        run(SELFPROJ, "depth", "--rig", "scanner", "--bits", "4", "--median", "--lines", "1024", "--unchecked", "--out",
            self.folder / "wide", recorded)
        same(wide.depth, light_section.load_tiff(self.folder / "wide/depth.tiff"))
        codes = numpy.full((512, 512), 0x8007, "uint16")
        same(pickle.loads(pickle.dumps(wide.triangulation)).depth(codes), wide.triangulation.depth(codes))
        structured_light.save_ply(out / "axes.ply", scan.points(), axes=scan.triangulation.axes)
        self.assertIn(b"\ncomment points in mm, x down the image, y right, z away (left-handed)\n",
                      (out / "axes.ply").read_bytes())
        self.assertTrue(scan.triangulation.rows_are_x)
        # The same by hand.
        decoder = structured_light.GrayDecoder(512, 512, 4, median=True)
        for index, file in enumerate(sorted(recorded.iterdir())):
            codes = decoder.take(selfproj.read_image(str(file)), index)
        triangulation = structured_light.triangulation(light_section.load_rig("scanner"), 4)
        same(triangulation.depth(codes), scan.depth)
        same(triangulation.points(scan.depth), points)
        colours = self.pixels(*points.shape)
        structured_light.save_ply(str(out / "again.ply"), points, colours)
        same(structured_light.load_ply(str(out / "again.ply")), points)
        seen = numpy.isfinite(scan.depth)
        light = {"intensity": scan.intensity[seen], "quality": scan.quality[seen]}
        structured_light.save_ply(out / "measured.ply", points, colours, **light)
        ours, theirs = (plyfile.PlyData.read(out / name)["vertex"] for name in ("measured.ply", "cloud.ply"))
        for name in ("x", "y", "z", *light):
            same(ours[name], theirs[name])
        with self.assertRaisesRegex(ValueError, "give both or none"):
            structured_light.save_ply(out / "measured.ply", points, intensity=light["intensity"])
        with self.assertRaisesRegex(ValueError, "one is needed for each point"):
            structured_light.save_ply(out / "measured.ply", points[1:], **light)


class Stripes(Case):
    def test_reference_and_depth_equal_those_of_the_commands(self):
        codes, seen, reference = self.folder / "codes", self.folder / "seen", self.folder / "reference"
        run(SELFPROJ, "pattern", "gray", "--rig", "scanner", "--out", codes)
        run(SIMULATION, "capture", "--rig", "scanner", "--scene", "plane", "--patterns", codes, "--out", seen)
        run(SELFPROJ, "pattern", "stripes", "--scan", seen, "--gray-code", "--out", reference)
        rig = light_section.load_rig("scanner")
        stripes = structured_light.stripes_of_scan(rig, numpy.stack([selfproj.read_image(file)
                                                                     for file in sorted(seen.iterdir())]))
        same(stripes.line, light_section.load_tiff(reference / "x_r_line.tiff"))
        again = structured_light.stripes_of_points(rig, stripes.line, stripes.column)
        loaded = structured_light.load_stripes(rig, reference)
        for other in (again, loaded, pickle.loads(pickle.dumps(stripes))):
            same(other.camera_row, stripes.camera_row)
        patterns = self.folder / "patterns"
        patterns.mkdir()
        for index in range(2 * stripes.bits):
            name = f"pattern_{index:02}.png"
            same(stripes.pattern(index), selfproj.read_image(reference / name))
            (patterns / name).write_bytes((reference / name).read_bytes())
        with self.assertRaises(IndexError):
            stripes.pattern(2 * stripes.bits)
        stripes.save(self.folder / "saved")
        self.assertEqual((self.folder / "saved/reference.yaml").read_bytes(),
                         (reference / "reference.yaml").read_bytes())
        with self.assertRaisesRegex(selfproj.InputError, "another order"):
            structured_light.stripes_of_scan(rig, sorted(seen.iterdir(), reverse=True))

        block, out = self.folder / "block", self.folder / "out"
        run(SIMULATION, "capture", "--rig", "scanner", "--scene", "block", "--patterns", patterns, "--out", block)
        images = sorted(block.iterdir())
        run(SELFPROJ, "match", "--reference", reference, "--e", "8", "--out", out, *images)
        scanner = structured_light.StripeScanner(stripes, e=8)
        scan = scanner.scan(numpy.stack([selfproj.read_image(file) for file in images]))
        same(scan.depth, light_section.load_tiff(out / "depth.tiff"))
        same(scan.difference, light_section.load_tiff(out / "difference.tiff"))
        self.assertGreater(numpy.isfinite(scan.depth).mean(), 0.3)
        for index, file in enumerate(images):  # the same by hand
            taken = scanner.take(selfproj.read_image(file), index)
        same(taken.depth, scan.depth)
        same(pickle.loads(pickle.dumps(scan)).points(), scan.points())
        self.assertEqual(scanner.table.shape, (512, 512, 16))
        decoder = model.GrayDecoder(512, 512, 4)
        for index, file in enumerate(images):
            words = decoder.take(selfproj.read_image(file), index)
        matched = model.match(words, scanner.table) != 0xFFFF
        self.assertTrue((matched | ~numpy.isfinite(scan.depth)).all())
        for thing in (stripes, scan):
            self.assertIn("data:image/png;base64,", thing._repr_html_())
        down, right = selfproj.pictures.spacing_of_points(scan.depth, scan.points())
        self.assertAlmostEqual(down / right, 1, delta=0.1)  # pixels are squares
        self.assertTrue(0.2 < right < 3, right)  # mm
        with self.assertRaisesRegex(selfproj.InputError, "images: down the image the code does not count on"):
            scanner.scan(numpy.stack([selfproj.read_image(file)[::-1] for file in images]))


class References(Case):
    def test_equal_those_of_the_commands(self):
        rig = light_section.load_rig("light-section")
        heights = numpy.where(abs(numpy.arange(rig.columns) - 250) < 120, 12.5, 0.0)
        light_section.save_tiff(self.folder / "part.tiff", heights[None].astype("float32"))
        run(SELFPROJ, "pattern", "--reference", self.folder / "part.tiff", "--out", self.folder / "part")
        reference = light_section.reference_of_heights(rig, heights)
        reference.save(rig, self.folder / "saved")
        self.assertEqual((self.folder / "saved/reference.csv").read_bytes(),
                         (self.folder / "part/reference.csv").read_bytes())
        self.assertIn("<svg", reference._repr_html_())
        moments = light_section.moments(self.pixels(96, 512), 20)
        profiles = [light_section.Profiler(rig, given).profile_of_moments(moments.m0, moments.m1, moments.n)
                    for given in (reference, self.folder / "part", pickle.loads(pickle.dumps(reference)))]
        for other in profiles[1:]:
            same(other.z, profiles[0].z)
        plane = light_section.reference_of_plane(rig)
        self.assertTrue(plane.valid.all() and abs(plane.z - rig.plane_z_mm).max() < 1e-6)

    def test_sweeps_and_heights_equal_those_of_the_commands(self):
        every, lines = 16, self.folder / "lines"
        run(SELFPROJ, "pattern", "--sweep", "--every", every, "--out", lines)
        rig = light_section.load_rig("light-section")
        numbers = light_section.sweep_lines(rig, every)
        self.assertEqual(len(numbers), len(list(lines.iterdir())))
        pattern = light_section.pattern_of_line(rig, numbers[3])
        same(numpy.rint(255 * pattern).astype("uint8"), selfproj.read_image(sorted(lines.iterdir())[3]))
        sweeps = []
        for height in (0, 10, 20):
            seen = self.folder / f"at{height}"
            run(SIMULATION, "capture", "--rig", "light-section", "--plate", height, "--patterns", lines, "--out", seen)
            sweeps.append(numpy.stack([selfproj.read_image(file) for file in sorted(seen.iterdir())]))
        run(SELFPROJ, "pattern", "--scan", self.folder / "at10", "--every", every, "--out", self.folder / "plate")
        swept = light_section.reference_of_sweep(rig, sweeps[1], every)
        same(swept.z, light_section.load_reference(rig, self.folder / "plate").z)
        fit = light_section.fit_heights(rig, sweeps, heights_mm=[0, 10, 20], every=every)
        run(SELFPROJ, "calibrate", "heights", "--heights", "0,10,20", "--every", every, "--out", self.folder / "fit",
            *(self.folder / f"at{height}" for height in (0, 10, 20)))
        self.assertEqual(fit.rig.to_yaml(), light_section.load_rig(self.folder / "fit/rig.yaml").to_yaml())
        self.assertEqual([level["height_mm"] for level in fit.levels], [0, 10, 20])
        with self.assertRaisesRegex(ValueError, "one is needed for each line"):
            light_section.reference_of_sweep(rig, sweeps[0][1:], every)
        # The same light in 12 bits: 16 times the values and the threshold.
        text = rig.to_yaml()
        threshold = int(text.split("  threshold: ")[1].split("\n")[0])
        (self.folder / "twelve.yaml").write_text(
            text.replace(f"  threshold: {threshold}\n", f"  threshold: {16 * threshold}\n  pixel_bits: 12\n"))
        twelve = light_section.load_rig(self.folder / "twelve.yaml")
        wide = [16 * sweep.astype("uint16") for sweep in sweeps]
        same(light_section.reference_of_sweep(twelve, wide[1], every).z, swept.z)
        self.assertEqual(light_section.fit_heights(twelve, wide, heights_mm=[0, 10, 20], every=every).rms_mm, fit.rms_mm)
        of_twelve = self.folder / "of-twelve"
        run(SIMULATION, "capture", "--rig", self.folder / "twelve.yaml", "--plate", 10, "--patterns", lines, "--out",
            of_twelve)
        run(SELFPROJ, "pattern", "--rig", self.folder / "twelve.yaml", "--scan", of_twelve, "--every", every, "--out",
            self.folder / "plate-of-twelve")
        same(light_section.reference_of_sweep(twelve, of_twelve, every).z,
             light_section.load_reference(twelve, self.folder / "plate-of-twelve").z)
        read = [selfproj.read_image(file, bits=twelve.pixel_bits) for file in sorted(of_twelve.glob("*.png"))]
        self.assertEqual((read[0].dtype, twelve.pixel_bits, rig.pixel_bits), ("uint16", 12, 8))
        same(light_section.reference_of_sweep(twelve, read, every).z,
             light_section.reference_of_sweep(twelve, of_twelve, every).z)
        for given, images, words in ((twelve, sweeps[1], "uint16 are needed"), (rig, wide[1], "uint8 are needed")):
            with self.assertRaisesRegex(ValueError, words):
                light_section.reference_of_sweep(given, images, every)
        with self.assertRaisesRegex(selfproj.InputError, "has a pixel of 65535; the rig's have 12 bits"):
            light_section.reference_of_sweep(twelve, wide[1] | 0xFFFF, every)
        with self.assertRaisesRegex(selfproj.InputError, r"\(scale_tolerance\): all are likely wrong"):
            light_section.fit_heights(rig, sweeps, heights_mm=[0, 10, 20], every=every, scale_tolerance=1e-6)


class Calibration(Case):
    def test_a_laser_on_a_chessboard(self):
        normal, distance = numpy.array([0.0, 0.87, 0.5]) / numpy.hypot(0.87, 0.5), 420.0
        boards, lines = pictures.laser_poses(normal, distance)
        camera = calibration.calibrate_camera(boards, corners=(7, 5), square_mm=40, bent=False)
        self.assertEqual(camera.left_out, [])
        numpy.testing.assert_allclose(numpy.diag(camera.matrix)[:2], 400, atol=2)
        laser = calibration.laser_plane(camera, lines)
        turn = numpy.degrees(numpy.arccos(min(1.0, abs(laser.normal @ normal))))
        self.assertLess(turn, 0.3)
        self.assertLess(laser.rms_mm, 0.5)
        self.assertIn("light_plane", laser.rig(light_section.load_rig("light-section")).to_yaml())
        with self.assertRaisesRegex(ValueError, "one of each pose"):
            calibration.laser_plane(camera, lines[1:])

    def test_a_laser_and_its_belt_equal_those_of_the_commands(self):
        box = self.folder / "box"
        run(SIMULATION, "production", "--rig", "laser", "--belt", "clock", "--rate", "50", "--good", "1", "--parts",
            "1", "--images", "--out", box)
        corners, held = ("--chessboard", "9x6", "--square", "6"), box / "held"
        run(SELFPROJ, "calibrate", "camera", *corners, "--out", self.folder / "camera", held / "boards", "--laser",
            held / "lines")
        camera = calibration.calibrate_camera(held / "boards", corners=(9, 6), square_mm=6)
        laser = calibration.laser_plane(camera, held / "lines")
        drawn = light_section.load_rig("light-section")
        rig = light_section.load_rig(self.folder / "camera/rig.yaml")
        self.assertEqual(laser.rig(drawn).to_yaml(), rig.to_yaml())
        with self.assertRaisesRegex(selfproj.InputError, "the drawing's and never measured.*assume='belt' to load_rig"):
            light_section.Profiler(rig)
        light_section.Profiler(light_section.load_rig(self.folder / "camera/rig.yaml", assume="belt"))

        boards, seconds = sorted((box / "carried/boards").iterdir()), [0, 0.64, 1.28, 1.92]
        lines, heights = [box / name / "image_00.png" for name in ("empty", "block")], [0, 20]
        run(SELFPROJ, "calibrate", "belt", "--rig", self.folder / "camera/rig.yaml", *corners, "--seconds",
            ",".join(map(str, seconds)), "--laser", *lines, "--heights", "0,20", "--out", self.folder / "line", *boards)
        arrays = [[selfproj.read_image(file) for file in files] for files in (boards, lines)]
        for images, light in ((boards, lines), (numpy.stack(arrays[0]), arrays[1])):
            belt = calibration.calibrate_belt(rig, images, corners=(9, 6), square_mm=6, seconds=seconds, laser=light,
                                              heights_mm=heights)
            self.assertEqual(belt.rig.to_yaml(), light_section.load_rig(self.folder / "line/rig.yaml").to_yaml())
        report = json.loads((self.folder / "line/report.json").read_text("utf-8"))
        self.assertEqual([round(value, 9) for value in belt.along_mm],
                         [round(place["along_mm"], 9) for place in report["places"]])
        self.assertEqual([level["height_mm"] for level in belt.heights], heights)
        for words, name in (({"square_mm": 12, "moves_mm": [0, 5, 10, 15]}, "moves_mm.*square_mm is wrong"),
                            ({"moves_mm": [0, 5]}, "moves_mm: one for each image"),
                            ({"laser": lines}, "heights_mm: one for each image of the laser"),
                            ({"laser": lines, "heights_mm": [0, 40]}, "thickness_mm and square_mm right")):
            with self.assertRaisesRegex(ValueError, name):
                calibration.calibrate_belt(rig, boards, corners=(9, 6), **{"square_mm": 6, **words})

    def test_equals_that_of_calibrate(self):
        folders = pictures.write_chessboard_poses(self.folder, structured_light.GraySequence(96, 80))
        out = self.folder / "out"
        run(SELFPROJ, "calibrate", "--chessboard", "7x5", "--square", "40", "--projector", "96x80", "--out", out,
            *folders)
        captures = [calibration.decode_capture([str(folder)], projector=(96, 80)) for folder in folders]
        result = calibration.calibrate(captures, corners=(7, 5), square_mm=40, projector=(96, 80))
        self.assertEqual(result.refusal, "")
        result.save(str(self.folder / "again.yaml"))
        self.assertEqual((self.folder / "again.yaml").read_bytes(), (out / "calibration.yaml").read_bytes())
        report, wanted = json.loads(result.json()), json.loads((out / "report.json").read_text(encoding="utf-8"))
        wanted["warnings"] = [text for text in wanted["warnings"] if not text.startswith("no rig.yaml")]
        self.assertEqual(report, wanted)
        found = calibration.read_calibration(str(out / "calibration.yaml"))
        same(found.camera_matrix[2], numpy.array([0.0, 0.0, 1.0]))
        numpy.testing.assert_allclose(found.rotation @ found.rotation.T, numpy.eye(3), atol=1e-9)
        self.assertEqual((found.projector_size, found.translation.shape, found.camera_distortion.shape),
                         ((96, 80), (3,), (8,)))
        numpy.testing.assert_allclose(found.camera_matrix, result.calibration.camera_matrix, rtol=1e-9)
        corners = calibration.find_chessboard(captures[0].mean, (7, 5))
        stack = numpy.stack([selfproj.read_image(file) for file in sorted(folders[0].iterdir())])
        same(calibration.decode_capture(stack, projector=(96, 80)).projector_row, captures[0].projector_row)
        self.assertEqual(captures[0].contradiction, "")
        self.assertIn("data:image/png", captures[0]._repr_html_())
        self.assertEqual(corners.shape, (35, 2))
        self.assertIsNone(calibration.find_chessboard(self.pixels(50, 50), (7, 5)))
        column = captures[0].projector_column
        again = pickle.loads(pickle.dumps(captures[0]))
        same(again.projector_column, column)
        same(again.mean, captures[0].mean)
        twin = calibration.calibrate([pickle.loads(pickle.dumps(capture)) for capture in captures], corners=(7, 5),
                                     square_mm=40, projector=(96, 80))
        self.assertEqual(twin.json(), result.json())
        same(pickle.loads(pickle.dumps(found)).camera_matrix, found.camera_matrix)
        self.assertTrue((column.max() < 96) and (column >= 0).mean() > 0.1 and column.dtype == numpy.int16)


class Cameras(Case):
    def test_the_simulated_camera(self):
        try:
            camera = cameras.open("camera:Fake_1?region=64x48+0+0")
        except selfproj.InputError as error:
            self.assertIn("without Aravis", str(error))
            return
        with camera:
            camera.start()
            image = camera.next(timeout=20)
            self.assertEqual((image.pixels.shape, image.pixels.dtype, camera.rows), ((48, 64), "uint8", 48))
            self.assertIn("data:image/png", image._repr_html_())
            self.assertGreaterEqual(camera.counters()["complete"], 1)
        self.assertEqual(repr(camera), "Camera(closed)")
        with self.assertRaisesRegex(ValueError, "closed"):
            camera.next()

    def test_refusals(self):
        for uri in ("camera:no-such-camera", "ring:x", "camera:Fake_1?colour=blue"):
            with self.assertRaises(selfproj.InputError):
                cameras.open(uri)


class Pictures(Case):
    def test_maps_and_images(self):
        values = self.random.random((30, 40), dtype="float32")
        values[0] = numpy.nan
        for signed in (False, True):
            png = selfproj_pictures.map_png(values, "a map", signed_values=signed)
            self.assertTrue(png.startswith(b"\x89PNG"))
        file = self.folder / "image.png"
        image = self.pixels(7, 9)
        file.write_bytes(selfproj_pictures.image_png(image))
        same(selfproj.read_image(file), image)
        with self.assertRaises(ValueError):
            selfproj_pictures.map_png(values, low=2, high=1)


class Notebooks(Case):
    def test_parts_of_the_production_notebook_equal_those_of_inspect(self):
        names = notebooks.run("production", self.folder)
        run(SELFPROJ, "tolerance", "learn", "--rig", self.folder / "rig.yaml", "--device",
            f"file:{self.folder}/good.slfp", "--out", self.folder / "learned.yaml")
        learned = (self.folder / "learned.yaml").read_text(encoding="utf-8").split("\n", 1)[1]
        self.assertEqual(learned, (self.folder / "tolerance.yaml").read_text(encoding="utf-8"))
        run(SELFPROJ, "inspect", "--rig", self.folder / "rig.yaml", "--device", f"file:{self.folder}/run.slfp",
            "--tolerance", self.folder / "learned.yaml", "--parts", self.folder / "parts", "--out", self.folder / "out")
        wanted = [json.loads(line) for line in (self.folder / "parts/parts.jsonl").read_text("utf-8").splitlines()]
        found = [json.loads(result.json()) for result in names["results"]]
        for number, part in enumerate(found, 1):
            self.assertEqual({**part, "part": number}, wanted[number - 1])
        self.assertEqual(len(found), len(wanted))
        tolerance = names["tolerance"]
        self.assertEqual(pickle.loads(pickle.dumps(tolerance)).to_yaml(), tolerance.to_yaml())
        self.assertEqual(parts.load_tolerance(self.folder / "tolerance.yaml").to_yaml(), tolerance.to_yaml())
        part = names["good"][0]
        same(pickle.loads(pickle.dumps(part)).heights, part.heights)
        twin = parts.Part(part.heights, part.pitch_mm, part.along_mm, part.across_mm)
        # Heights alone say where edges are to a cell only; parts of a board also know how full their cells are.
        by_heights = json.loads(names["classifier"].classify(twin).json())
        self.assertLess(by_heights["placement"]["residual_mm"], part.pitch_mm)
        self.assertEqual(by_heights["defects"], [])
        for thing in (part, names["results"][1]):
            self.assertIn("data:image/png;base64,", thing._repr_html_())
        for result in names["results"]:
            again = pickle.loads(pickle.dumps(result))
            self.assertEqual((again.json(), again.pitch_mm, repr(again)), (result.json(), result.pitch_mm, repr(result)))
            same(again.heights, result.heights)
            same(again.difference, result.difference)
        self.assertEqual(repr(pickle.loads(pickle.dumps(names["results"][1].defects))),
                         repr(names["results"][1].defects))


class Refusals(Case):
    def test_wrong_types_and_shapes(self):
        image, codes = self.pixels(8, 12), numpy.zeros((8, 12), "uint16")
        table, words = numpy.zeros((8, 12, 4), "uint16"), numpy.zeros(512, "uint32")
        profiler = light_section.Profiler(light_section.load_rig("light-section"))
        decoder = model.GrayDecoder(8, 12, 3)
        scanner = structured_light.triangulation(light_section.load_rig("scanner"), 8)
        calls = {
            lambda bad: model.moments(bad, 20): image,
            lambda bad: light_section.moments(bad, 20): image,
            lambda bad: packets.moments_packet(bad, 20): image,
            lambda bad: decoder.take(bad, 0): image,
            lambda bad: structured_light.GrayDecoder(8, 12, 3).take(bad, 0): image,
            lambda bad: calibration.find_chessboard(bad, (7, 5)): image,
            model.median3x3: codes,
            lambda bad: model.match(codes, bad): table,
            lambda bad: profiler.profile_of_moments(bad, words, words): words,
            scanner.depth: numpy.zeros((512, 512), "uint16"),
            scanner.points: numpy.zeros((512, 512), "float32"),
            packets.parse: numpy.zeros(64, "uint8"),
            lambda bad: light_section.save_tiff("/dev/null", bad): numpy.zeros((3, 4), "float32"),
            lambda bad: structured_light.save_ply("/dev/null", bad): numpy.zeros((5, 3), "float32"),
        }
        for function, right in calls.items():
            strided = numpy.zeros((*right.shape[:-1], 2 * right.shape[-1]), right.dtype)[..., ::2]
            for bad in (right.astype("float64"), right.astype("int8"), right[None, None], right[..., :0], strided,
                        right.tolist(), "text", None, 7):
                with self.assertRaises((TypeError, ValueError), msg=f"{function}: {bad!r}"):
                    function(bad)

    def test_values_out_of_range(self):
        image = self.pixels(8, 12)
        for bad in ({"threshold": 256}, {"threshold": -1}, {"threshold": 1, "gap": 4, "select": model.Select.STRONGEST},
                    {"threshold": 2**40}, {"threshold": 1.5}, {"threshold": 1, "mode": 3}):
            with self.assertRaises((TypeError, ValueError), msg=str(bad)):
                model.moments(image, **bad)
        for bad in ((0, 4, 3), (4, 0, 3), (4, 4, 0), (4, 4, 13), (4, 4, 3, 300)):
            for kind in (model.GrayDecoder, structured_light.GrayDecoder):
                with self.assertRaises(ValueError, msg=str(bad)):
                    kind(*bad)
        with self.assertRaises(TypeError):
            packets.Header().columns = 1 << 16
        for function, name in ((light_section.load_rig, "no-such-rig"), (driver.open, "file:/no/such/file"),
                               (selfproj.read_image, "/no/such/file"), (calibration.read_calibration, "/no/such/file")):
            with self.assertRaisesRegex(selfproj.InputError, name.removeprefix("file:")):
                function(name)


class Messages(Case):
    """Errors name the arguments of Python, not the options of the commands."""

    def test_arguments_are_named(self):
        names = ("grey.pgm", "colour.ppm", "deep.png", "white.pgm")
        grey, colour, deep, white = (self.folder / name for name in names)
        grey.write_bytes(b"P5 8 4 255\n" + bytes(32))
        colour.write_bytes(b"P6 8 4 255\n" + bytes(96))
        white.write_bytes(b"P5 8 4 4095\n" + b"\x0f\xff" * 32)
        write_png16(deep, numpy.full((4, 8), 40000, "uint16"))
        scanner = light_section.load_rig("scanner")
        plain = numpy.zeros((16, 512, 512), "uint8")
        calls = [
            (lambda: selfproj.read_image(colour), "choose a channel with channel red"),
            (lambda: selfproj.read_image(grey, channel="red"), "channel red needs a colour image"),
            (lambda: selfproj.read_image(grey, shift=4), "shift goes only with"),
            (lambda: selfproj.read_image(deep), "shift=4 takes values of 12"),
            (lambda: selfproj.read_image(white, shift=2), "with shift=2 values up to"),
            (lambda: structured_light.scan(plain[:, :, :64], rig="scanner", bits=8), "^rig scanner: is for images of"),
            (lambda: structured_light.stripes_of_scan(scanner, plain), "^images: "),
            (lambda: calibration.decode_capture(plain, projector=(20000, 8)), "^projector: "),
            (lambda: calibration.decode_capture(plain, projector=(9000, 8)), "^projector: "),
            (lambda: selfproj.read_image(grey, channel="purple"), "^channel: .*red"),
            (lambda: selfproj.read_image(white, shift=99), "shift"),
            (lambda: light_section.load_rig("laser", assume="wheels"), "^assume"),
        ]
        for call, text in calls:
            with self.assertRaisesRegex(ValueError, text, msg=text) as raised:
                call()
            self.assertNotIn("--", str(raised.exception))

    def test_names_of_files_stay(self):
        name = self.folder / "a --rig.png"
        with self.assertRaisesRegex(selfproj.InputError, "a --rig.png"):
            selfproj.read_image(name)


def write_png16(file, values):
    """A grey PNG of 16 bits."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in values)
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", *values.shape[::-1], 16, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def public_classes():
    """Returns the classes with a public name, and those of the compiled part."""
    modules = {name: thing for name, thing in vars(selfproj).items() if name in selfproj.__all__ and ismodule(thing)}
    named = {thing for module in (selfproj, *modules.values()) for name, thing in vars(module).items()
             if name in module.__all__ and isinstance(thing, type)}
    compiled = {thing for module in (_core, *(getattr(_core, name) for name in modules))
                for thing in vars(module).values() if isinstance(thing, type)}
    return named, compiled


# Their objects hold what is no data: class, and what its error says of it.
STREAMS = {
    cameras.Camera: "holds an open camera", driver.Device: "holds an open device",
    driver.ImageAssembler: "is in the midst of a stream", parts.Cutter: "is in the midst of a stream",
    light_section.Inspection: "is collecting frames", model.GrayDecoder: "is in the midst of a cycle of images",
    structured_light.GrayDecoder: "is in the midst of a cycle of images",
    structured_light.StripeScanner: "is in the midst of a cycle of images",
}


class Pickles(Case):
    def equal(self, one, other):
        """All that two objects show: their texts, properties, and methods that give data."""
        clouds = structured_light.Scan, structured_light.StripeScan
        if isinstance(one, numpy.ndarray):
            same(one, other)
        elif isinstance(one, (list, tuple)):
            self.assertEqual(len(one), len(other))
            for a, b in zip(one, other):
                self.equal(a, b)
        elif type(one) in public_classes()[0] and not isinstance(one, (enum.Enum, Exception)):
            self.assertEqual((type(other), repr(other)), (type(one), repr(one)))
            self.assertNotIn("object at 0x", repr(one))
            for name in dir(one):
                a, b = getattr(one, name), getattr(other, name)
                if not callable(a):
                    if name[0] != "_":
                        self.equal(a, b)
                elif name in ("to_yaml", "json", "__str__") or (isinstance(one, clouds) and name == "points"):
                    self.equal(a(), b())
        else:
            numpy.testing.assert_equal(repr(other), repr(one))

    def of_packets(self):
        image = self.pixels(20, 16)
        header = packets.Header()
        header.sequence, header.encoder = self.between(0, 2**62), 7
        yield header
        yield packets.parse(packets.moments_packet(image, 20, header=header))
        for images in (image, numpy.stack([image] * 2)):
            for select in (model.Select.ALL, model.Select.STRONGEST):
                yield model.moments(images, 20, select=select)
        yield from (model.Mode.GREY, model.Select.ALL, driver.Wait.BLOCKING, light_section.Validity.UNLIT)
        yield selfproj.InputError("file: reason")

    def of_light_sections(self):
        rig = light_section.load_rig("light-section")
        profiler = light_section.Profiler(rig, light_section.reference_of_heights(rig, numpy.full(rig.columns, 12.5)))
        moments = light_section.moments(self.pixels(96, 512), 20)
        words = moments.m0, moments.m1, moments.n
        again = pickle.loads(pickle.dumps(profiler))
        same(again.profile_of_moments(*words).dz, profiler.profile_of_moments(*words).dz)
        yield from (rig, profiler, profiler.reference, profiler.profile_of_moments(*words))
        lines, sweeps = self.folder / "lines", []
        run(SELFPROJ, "pattern", "--sweep", "--every", 64, "--out", lines)
        for height in (0, 10, 20):
            seen = self.folder / f"at{height}"
            run(SIMULATION, "capture", "--rig", "light-section", "--plate", height, "--patterns", lines, "--out", seen)
            sweeps.append(seen)
        yield light_section.fit_heights(rig, sweeps, heights_mm=[0, 10, 20], every=64)

    def of_structured_light(self):
        rig = light_section.load_rig("scanner")
        row, column = numpy.mgrid[0:rig.rows, 0:rig.columns]
        by_rig = structured_light.triangulation(rig, 8)
        z = [by_rig.depth(numpy.full(row.shape, 0x8000 + code, "uint16"))[:, 0] for code in range(256)]
        away = numpy.nan_to_num(abs(numpy.stack(z) - 540), nan=1e6)
        codes = numpy.argmin(away, 0)[:, None] + 0 * column  # of a plane
        scan = structured_light.scan(pictures.gray_images(codes, 8), rig="scanner", bits=8)
        self.assertGreater(numpy.isfinite(scan.depth).mean(), 0.5)
        yield from (scan, scan.triangulation, structured_light.GraySequence(5, 6))
        words = (codes | 0x8000).astype("uint16")
        same(pickle.loads(pickle.dumps(by_rig)).depth(words), scan.depth)
        yield by_rig
        stripes = structured_light.stripes_of_points(rig, (100 + row).astype("float32"),
                                                     (200 + column).astype("float32"))
        stripe_codes = (numpy.arange(rig.rows)[:, None] // 2 % 16 + 0 * column).astype("uint16")
        yield stripes
        yield structured_light.StripeScanner(stripes).scan(pictures.gray_images(stripe_codes, 4))

        with_parts = self.folder / "scanner.yaml"
        with_parts.write_text(rig.to_yaml() + "\nparts: {cut: image, grid_mm: 1, pause_ms: 50}\n", "utf-8")
        rig = light_section.load_rig(with_parts)
        depth = numpy.full((rig.rows, rig.columns), rig.plane_z_mm, "float32")
        depth[200:300, 200:300] -= 25
        reference, bad = (rig, depth), depth.copy()
        bad[230:260, 230:260] += 5
        tolerance = parts.learn(reference, [parts.part_of_depth(rig, depth)] * 5)
        classifier = parts.Classifier(reference, tolerance)
        part = parts.part_of_depth(rig, bad)
        result = classifier.classify(part)
        self.assertEqual((result.verdict, len(result.defects)), ("bad", 1))
        self.equal(pickle.loads(pickle.dumps(classifier)).classify(part), result)
        yield from (part, tolerance, classifier, result, result.defects[0])

    def of_calibrations(self):
        normal = numpy.array([0.0, 0.87, 0.5]) / numpy.hypot(0.87, 0.5)
        boards, lines = pictures.laser_poses(normal, 420.0)
        board = {"corners": (7, 5), "square_mm": 40}
        drawn = light_section.load_rig("light-section")
        for bent in (False, True):
            camera = calibration.calibrate_camera([*boards, self.pixels(240, 320)], **board, bent=bent)
            self.assertEqual(len(camera.left_out), 1)
            found = [calibration.laser_plane(one, [*lines, lines[0]]) for one in
                     (camera, pickle.loads(pickle.dumps(camera)))]
            self.equal(found[1], found[0])
            self.equal(pickle.loads(pickle.dumps(found[0])).rig(drawn), found[0].rig(drawn))
            yield from (camera, found[0])
        yield calibration.calibrate_belt(found[0].rig(drawn), pictures.belt_places([0, 20, 50]), **board,
                                         moves_mm=[0, 20, 50])
        folders = pictures.write_chessboard_poses(self.folder, structured_light.GraySequence(96, 80))
        captures = [calibration.decode_capture(folder, projector=(96, 80)) for folder in folders]
        result = calibration.calibrate(captures, **board, projector=(96, 80))
        yield from (captures[0], result, result.calibration)
        for number, one in enumerate((result, pickle.loads(pickle.dumps(result)))):
            one.save(self.folder / f"{number}.yaml")
        saved = [(self.folder / f"{number}.yaml").read_bytes() for number in (0, 1)]
        self.assertEqual(*saved)
        yield structured_light.scan(folders[0], calibration=self.folder / "0.yaml", bits=7, row_bits=7,
                                    unchecked=True)

    def of_cameras(self):
        try:
            with cameras.open("camera:Fake_1?region=64x48+0+0") as camera:
                camera.start()
                yield camera.next(timeout=20)
                yield camera
        except selfproj.InputError as error:
            self.assertIn("without Aravis", str(error))
            yield from (cameras.Camera, cameras.CameraImage)  # cannot be had

    def of_streams(self):
        (self.folder / "empty.slfp").write_bytes(b"")
        rig = light_section.load_rig("scanner")
        line, column = numpy.mgrid[0:rig.rows, 0:rig.columns].astype("float32")
        with_parts = self.folder / "rig.yaml"
        with_parts.write_text(light_section.load_rig("light-section").to_yaml() + PARTS, "utf-8")
        profiler = light_section.Profiler(light_section.load_rig(with_parts))
        yield driver.open(f"file:{self.folder}/empty.slfp")
        yield driver.ImageAssembler(packets.KIND_IMAGE)
        yield from (parts.Cutter(profiler), light_section.Inspection(profiler))
        yield from (model.GrayDecoder(8, 12, 3), structured_light.GrayDecoder(8, 12, 3))
        yield structured_light.StripeScanner(structured_light.stripes_of_points(rig, line, column))

    def test_every_class(self):
        named, compiled = public_classes()
        self.assertEqual(compiled - named, set(), "classes without a public name")
        seen = set()
        for things in (self.of_packets(), self.of_light_sections(), self.of_structured_light(), self.of_calibrations(),
                       self.of_cameras(), self.of_streams()):
            for thing in things:
                if isinstance(thing, type):
                    seen.add(thing)
                    continue
                seen.add(type(thing))
                self.assertNotIn("object at 0x", repr(thing))
                if type(thing) in STREAMS:
                    for use in (pickle.dumps, copy.copy):
                        with self.assertRaisesRegex(TypeError, f"{type(thing).__name__}: .* {STREAMS[type(thing)]}"):
                            use(thing)
                    continue
                again = pickle.loads(pickle.dumps(thing))
                self.equal(thing, again)
                if hasattr(thing, "_repr_html_"):
                    self.assertEqual(again._repr_html_(), thing._repr_html_())
        self.assertEqual(named - seen, set(), "classes that were not tried")


class Data(Case):
    def test_version(self):
        self.assertRegex(selfproj.__version__, r"^\d+\.\d+")

    def test_paths_and_names_of_any_encoding(self):
        name = os.fsdecode(b"fl\xe4che ")
        values = self.random.random((3, 4), dtype="float32")
        light_section.save_tiff(self.folder / (name + ".tiff"), values)
        same(light_section.load_tiff(self.folder / (name + ".tiff")), values)
        packets.moments_packet(self.pixels(9, 16), 20).tofile(self.folder / name)
        with driver.open(f"file:{self.folder / name}") as device:
            self.assertEqual(device.uri, f"file:{self.folder / name}")
            self.assertEqual(len(list(device)), 1)
        for function in (selfproj.read_image, light_section.load_rig, structured_light.load_ply,
                         calibration.read_calibration):
            with self.assertRaisesRegex(selfproj.InputError, "fl\N{REPLACEMENT CHARACTER}che"):
                function(self.folder / (name + ".none"))

    def test_images_of_more_than_8_bits(self):
        values = self.random.integers(0, 4096, (5, 8), dtype="uint16")
        file = self.folder / "a.pgm"
        file.write_bytes(b"P5 8 5 4095\n" + values.astype(">u2").tobytes())
        same(selfproj.read_image(file), (values >> 4).astype("uint8"))
        same(selfproj.read_image(file, shift=4), (values >> 4).astype("uint8"))
        with self.assertRaisesRegex(ValueError, "colour image"):
            model.moments(self.pixels(8, 12, 3), 20)
        with self.assertRaisesRegex(ValueError, "none are given"):
            calibration.calibrate([], corners=(9, 7), square_mm=1, projector=(8, 8))


class Threads(Case):
    def test_python_ends_while_threads_wait(self):
        code = """
import os, selfproj.driver, sys, threading, time
pipe, _ = os.pipe()
for _ in range(4):
    threading.Thread(target=lambda: selfproj.driver.open(f"file:/dev/fd/{pipe}").next(), daemon=True).start()
time.sleep(float(sys.argv[1]))
"""
        for _ in range(6):
            done = subprocess.run([sys.executable, "-c", code, str(self.random.random() / 4)], capture_output=True,
                                  text=True, check=False, timeout=60)
            self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_others_run_while_a_kernel_runs(self):
        images = self.pixels(60, 200, 2000)
        sys.setswitchinterval(10)  # only a kernel that releases the GIL lets another thread run
        self.addCleanup(sys.setswitchinterval, 0.005)

        def times_that_this_thread_ran():
            done, times = threading.Event(), 0

            def work():
                model.moments(images, 20)
                done.set()

            worker = threading.Thread(target=work)
            worker.start()
            while not done.wait(0.0005):
                times += 1
            worker.join()
            return times

        # On a busy machine a kernel may end before this thread gets a processor.
        self.assertTrue(any(times_that_this_thread_ran() > 2 for _ in range(10)))

    def test_an_object_with_a_state_is_for_one_thread_at_a_time(self):
        decoder = model.GrayDecoder(1000, 2000, 8)
        image, refused = self.pixels(1000, 2000), []

        def work():
            for index in range(16):
                try:
                    decoder.take(image, index)
                except RuntimeError as error:
                    refused.append(str(error))

        workers = [threading.Thread(target=work) for _ in range(3)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        self.assertIn("another thread is using this object", refused)


class Documentation(unittest.TestCase):
    def test_everything_has_a_text_and_a_type(self):
        types = pathlib.Path(selfproj.__file__).parent / "_core"
        for module in (model, packets, driver, light_section, structured_light, calibration, parts, cameras,
                       selfproj_pictures):
            name = module.__name__.split(".")[-1]
            self.assertTrue(module.__doc__)
            known = (types / f"{name}.pyi").read_text(encoding="utf-8")
            compiled = {word for word in dir(getattr(selfproj._core, name)) if not word.startswith("_")}
            self.assertLessEqual(compiled, set(module.__all__) | {"Select", "Mode"}, name)
            for word in module.__all__:
                thing = getattr(module, word)
                self.assertTrue(isinstance(thing, int) or thing.__doc__, word)
                if word not in ("split", "cut"):  # written in Python
                    self.assertRegex(known, rf"(?m)^(def|class) {word}\b|^{word}: ", word)

    def test_a_type_checker_reads_the_types(self):
        def checked(*lines):
            with tempfile.TemporaryDirectory() as folder:
                source = pathlib.Path(folder) / "user.py"
                source.write_text("\n".join(lines) + "\n", encoding="utf-8")
                done = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", folder, source], cwd=folder,
                                      capture_output=True, text=True, check=False)
                return done.stdout + done.stderr

        program = ("import selfproj", "from selfproj import light_section, packets, parts, structured_light",
                   "version: str = selfproj.__version__",
                   "rig: light_section.Rig = light_section.load_rig('light-section')",
                   "scan: structured_light.Scan = structured_light.scan('captures', bits=8, rig='scanner')")
        self.assertIn("Success: no issues found in 1 source file", checked(*program))
        self.assertIn("user.py:6: error", checked(*program, "number: int = scan.depth"))


if __name__ == "__main__":
    unittest.main()
