"""The board in cocotb, against NumPy. The tests are run by run.py.

Registers are written through cocotbext-axi with stalls on every channel, packets leave under random back-pressure, and
frames come with faults. A camera drives the video input beat by beat; the packets are parsed by packets.py, and what
they must hold is computed here from the images.
"""

import itertools
import logging
import os
import random

import cocotb
import numpy
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, Timer
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiResp, AxiStreamBus, AxiStreamSink

import packets

MAX_COLUMNS, MAX_ROWS = int(os.environ["MAX_COLUMNS"]), int(os.environ["MAX_ROWS"])
SEED = int(os.environ.get("SELFPROJ_SEED", "1"))
BUS_PORTS = {"s_axil": "awvalid awready awaddr wvalid wready wdata wstrb bvalid bready bresp "
                       "arvalid arready araddr rvalid rready rdata rresp",
             "m_axis": "tvalid tready tdata tlast"}


def moments(image, mode, threshold):
    """Returns M0, M1 and N of each column: rows count from 1, and a pixel is lit where it is above the threshold."""
    lit = image > threshold
    weight = {"binary": lit, "grey": image * lit, "grey_over": (image - threshold) * lit}[mode].astype(numpy.int64)
    rows = numpy.arange(1, image.shape[0] + 1)[:, None]
    return weight.sum(0), (weight * rows).sum(0), lit.sum(0)


def payload_of(image, mode, threshold):
    m0, m1, n = moments(image, mode, threshold)
    return packets.pack("binary", m0=m0, m1=m1) if mode == "binary" else packets.pack("grey", m0=m0, m1=m1, n=n)


def look_up_ports(dut):
    """Looks up the ports of the buses by name. Call this before cocotbext-axi makes a bus.

    Verilator 5.006 has a second variable for each port, inside the top module, and copies the port to it in every
    evaluation. A bus looks for its signals with dir(dut), which finds these copies, so what it writes would be lost.
    A look-up by name finds the port, and cocotb keeps what it found first.
    """
    for bus, names in BUS_PORTS.items():
        for name in names.split():
            getattr(dut, f"{bus}_{name}")


class Board:
    def __init__(self, dut):
        look_up_ports(dut)
        self.dut = dut
        self.random = random.Random(SEED)
        self.numbers = numpy.random.default_rng(SEED)
        self.edges = 0  # of the pixel clock after reset
        self.sequence = 0
        self.starts = []  # edges before the first beat of each frame

    async def start(self):
        dut = self.dut
        for name in ("s_axil", "m_axis"):  # cocotbext-axi tells every access otherwise
            logging.getLogger(f"cocotb.{dut._name}.{name}").setLevel(logging.WARNING)
        for name in ("s_axis_tvalid", "s_axis_tdata", "s_axis_tuser", "s_axis_tlast", "encoder_a_i", "encoder_b_i"):
            getattr(dut, name).value = 0
        dut.rst_i.value = 1
        dut.bus_rst_i.value = 1
        cocotb.start_soon(Clock(dut.clk_i, 6600, "ps").start())
        cocotb.start_soon(Clock(dut.bus_clk_i, 16, "ns").start())
        self.axil = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.bus_clk_i, dut.bus_rst_i)
        self.sink = AxiStreamSink(AxiStreamBus.from_prefix(dut, "m_axis"), dut.bus_clk_i, dut.bus_rst_i)
        await Timer(200, "ns")
        await RisingEdge(dut.bus_clk_i)
        dut.bus_rst_i.value = 0
        await RisingEdge(dut.clk_i)
        dut.rst_i.value = 0
        cocotb.start_soon(self.count())
        await ClockCycles(dut.bus_clk_i, 20)

    async def count(self):
        while True:
            await RisingEdge(self.dut.clk_i)
            self.edges += 1

    def stalls(self, percent):
        return (self.random.randrange(100) < percent for _ in itertools.count())

    async def write(self, name, word):
        return (await self.axil.write(packets.address(name), word.to_bytes(4, "little"))).resp

    async def read(self, name):
        answer = await self.axil.read(packets.address(name), 4)
        assert answer.resp == AxiResp.OKAY, name
        return int.from_bytes(answer.data, "little")

    async def set(self, name, **fields):
        assert await self.write(name, packets.register_word(name, **fields)) == AxiResp.OKAY, (name, fields)

    async def expect_register(self, name, **fields):
        assert await self.read(name) == packets.register_word(name, **fields), (name, fields)

    # --- The camera ---
    async def beat(self, pixels, start, end):
        dut = self.dut
        dut.s_axis_tvalid.value = 1
        dut.s_axis_tdata.value = int.from_bytes(bytes(int(pixel) for pixel in pixels), "little")
        dut.s_axis_tuser.value = int(start)
        dut.s_axis_tlast.value = int(end)
        if start:
            self.starts.append(self.edges)
            self.sequence += 1
        await RisingEdge(dut.clk_i)
        dut.s_axis_tvalid.value = 0

    async def frame(self, image, gaps=0, short_in=None, long_in=None, stop_in=None, between=0):
        """Sends an image. In the row `short_in` (from 0) the last beat but one ends the line, in `long_in` the last one
        does not and another one comes; with row `stop_in` it stops after the first beat. There are `between` clocks
        from row to row."""
        rows, columns = image.shape
        for row in range(rows):
            groups = [image[row, at:at + 4] for at in range(0, columns, 4)]
            if row == short_in:
                groups.pop()
            if row == long_in:
                groups.append(groups[-1])
            for i, group in enumerate(groups):
                while self.random.randrange(100) < gaps:
                    await RisingEdge(self.dut.clk_i)
                await self.beat(group, row == 0 and i == 0, i == len(groups) - 1)
                if row in (short_in, long_in) and i == len(groups) - 1 or row == stop_in:
                    return
            await ClockCycles(self.dut.clk_i, between + 1)

    def image(self, rows, columns):
        """A random image with a bright line."""
        image = self.numbers.integers(0, 90, (rows, columns))
        at = self.numbers.integers(0, rows, columns)
        image[at, numpy.arange(columns)] = self.numbers.integers(100, 256, columns)
        return image

    async def packet(self):
        frame = await self.sink.recv(compact=False)
        return packets.parse(bytes(frame.tdata))

    async def setting(self, columns, rows, mode, threshold, stream=0):
        await self.set("size", columns=columns, rows=rows)
        await self.set("measure", threshold=threshold, mode=packets.MODES[mode], stream=stream)

    async def expect(self, image, mode, threshold, status=0, payload=None):
        """Compares the next packet with the moments of an image, or with this payload."""
        header, got, trailer = await self.packet()
        want = payload_of(image, mode, threshold) if payload is None else payload
        assert trailer["status"] == status, (trailer, status)
        assert got == want, f"frame {header['sequence']}: another payload"
        for field, value in {"kind": packets.KINDS["moments"], "columns": image.shape[1], "rows": image.shape[0],
                             "mode": packets.MODES[mode], "threshold": threshold, "lines": image.shape[0],
                             "first_line": 1, "payload_size": len(want)}.items():
            assert header[field] == value, (field, header)
        return header


@cocotb.test(timeout_time=150, timeout_unit="us")
async def registers_with_stalls_on_every_channel(dut):
    board = Board(dut)
    await board.start()
    for channel in (board.axil.write_if.aw_channel, board.axil.write_if.w_channel, board.axil.write_if.b_channel,
                    board.axil.read_if.ar_channel, board.axil.read_if.r_channel):
        channel.set_pause_generator(board.stalls(60))
    assert await board.read("id") == packets.MAGIC
    assert await board.read("version") == packets.VERSION
    capability = await board.read("capability")
    assert capability & 0xFFF == MAX_COLUMNS and capability >> 12 & 0x3FF == MAX_ROWS, hex(capability)
    # Every setting keeps what is written, and nothing else; read-only registers refuse and keep.
    values = {}
    legal = {"size": lambda: packets.register_word("size", columns=4 * board.random.randint(1, MAX_COLUMNS // 4),
                                                   rows=board.random.randint(1, MAX_ROWS)),
             "measure": lambda: packets.register_word("measure", threshold=board.random.randrange(256),
                                                      mode=board.random.randrange(3),
                                                      stream=board.random.randrange(256))}
    for name in ("timeout", "trigger_period", "trigger_camera", "trigger_width"):
        legal[name] = lambda: board.random.randrange(1 << 32)
    fixed = ("id", "version", "spec_hash", "capability", "frames", "broken", "stray", "lost_moments", "encoder")
    before = {name: await board.read(name) for name in fixed}
    for _ in range(60):
        name = board.random.choice([*legal, *fixed])
        word = legal[name]() if name in legal else board.random.randrange(1 << 32)
        answer = await board.write(name, word)
        assert answer == (AxiResp.OKAY if name in legal else AxiResp.SLVERR), (name, hex(word))
        if name in legal:
            values[name] = word & packets.register_mask(name)
        name = board.random.choice([*values, *fixed])
        assert await board.read(name) == (values | before)[name], name
    # Values that no build can do, and addresses without a register
    for name, word in (("size", packets.register_word("size", columns=6, rows=4)),
                       ("size", packets.register_word("size", columns=8, rows=MAX_ROWS + 1)),
                       ("measure", packets.register_word("measure", mode=3))):
        assert await board.write(name, word) == AxiResp.SLVERR, (name, word)
    for at in (0xFC, 0x80):
        assert (await board.axil.read(at, 4)).resp == AxiResp.SLVERR, hex(at)
        assert (await board.axil.write(at, bytes(4))).resp == AxiResp.SLVERR, hex(at)


@cocotb.test(timeout_time=150, timeout_unit="us")
async def frames_under_random_back_pressure(dut):
    board = Board(dut)
    await board.start()
    board.sink.set_pause_generator(board.stalls(50))
    await board.set("control", run=1)
    first, hash_word = None, await board.read("spec_hash")
    for number in range(18):
        rows, columns = board.random.randint(1, MAX_ROWS), 4 * board.random.randint(1, MAX_COLUMNS // 4)
        mode, threshold = board.random.choice(list(packets.MODES)), board.random.randrange(256)
        with_image = number % 3 == 2
        await board.setting(columns, rows, mode, threshold, stream=number)
        await board.set("control", run=1, image=int(with_image))
        image = board.image(rows, columns)
        # A line of the raw image takes longer to leave than to come if it is short: packets that overlap would be lost.
        await board.frame(image, gaps=board.random.choice((0, 40)), between=60 if with_image else 0)
        lines = {}
        header = None
        while header is None or len(lines) < (rows if with_image else 0):
            head, payload, trailer = await board.packet()
            assert trailer["status"] == 0 and head["sequence"] == number and head["stream"] == number, head
            assert head["spec_hash"] == hash_word and head["lost"] == 0, head
            if head["kind"] == packets.KINDS["image"]:
                lines[head["first_line"]] = payload
            else:
                assert header is None and payload == payload_of(image, mode, threshold), f"frame {number}"
                header = head
        for row in range(rows if with_image else 0):
            want = bytes(image[row].astype(numpy.uint8))
            assert lines[row + 1] == want + bytes(-columns % packets.BEAT), (number, row)
        # The stamps of frames are as far apart as their first beats.
        first = first if first is not None else header["time_stamp"] - board.starts[0]
        assert header["time_stamp"] - board.starts[number] == first, header
    assert await board.read("frames") == 18 and await board.read("broken") == 0


@cocotb.test(timeout_time=150, timeout_unit="us")
async def what_a_full_fifo_drops_is_counted(dut):
    board = Board(dut)
    await board.start()
    await board.setting(MAX_COLUMNS, 4, "grey", 50)
    await board.set("control", run=1)
    board.sink.pause = True
    images = [board.image(4, MAX_COLUMNS) for _ in range(24)]
    for image in images:
        await board.frame(image)
        await ClockCycles(dut.clk_i, 200)
    board.sink.pause = False
    await ClockCycles(dut.bus_clk_i, 1500)
    lost = await board.read("lost_moments")
    assert 0 < lost < 24, lost
    seen = []
    while not board.sink.empty():
        header, payload, _ = await board.packet()
        assert payload == payload_of(images[header["sequence"]], "grey", 50), header["sequence"]
        seen.append(header["sequence"])
    assert len(seen) + lost == 24, (seen, lost)
    # The next header says how many are missing.
    image = board.image(4, MAX_COLUMNS)
    await board.frame(image)
    header = await board.expect(image, "grey", 50)
    assert header["lost"] == lost and header["sequence"] == 24, header


@cocotb.test(timeout_time=150, timeout_unit="us")
async def frames_with_faults(dut):
    board = Board(dut)
    await board.start()
    board.sink.set_pause_generator(board.stalls(30))
    rows, columns = 6, 16
    broken = 0
    for mode in packets.MODES:
        await board.setting(columns, rows, mode, 60)
        await board.set("timeout", clocks=400)
        await board.set("control", run=1)
        for fault, options in (("short_line", {"short_in": 2}), ("long_line", {"long_in": 3}),
                               ("incomplete", {"stop_in": 4}), ("start_in_frame", {"stop_in": 1}),
                               ("short_line", {"short_in": rows - 1})):
            image = board.image(rows, columns)
            await board.frame(image, gaps=20, **options)
            broken += 1
            good = board.image(rows, columns)
            if fault != "start_in_frame":
                await ClockCycles(dut.clk_i, 600)
            await board.frame(good, gaps=20)
            payload = b""
            if options.get("short_in") == rows - 1:  # columns whose last pixel came keep their moments
                kept = payload_of(image, mode, 60)
                size = len(kept) // columns * (columns - 4)
                payload = kept[:size] + bytes(len(kept) - size)
            await board.expect(image, mode, 60, status=packets.STATUS[fault], payload=payload)
            await board.expect(good, mode, 60)
            await ClockCycles(dut.clk_i, 100)
    assert await board.read("broken") == broken
    assert await board.read("frames") == 2 * broken


@cocotb.test(timeout_time=150, timeout_unit="us")
async def the_encoder_counts_its_steps(dut):
    board = Board(dut)
    await board.start()
    place = 0
    for _ in range(120):
        place += board.random.choice((1, 1, -1))
        dut.encoder_a_i.value, dut.encoder_b_i.value = ((0, 0), (1, 0), (1, 1), (0, 1))[place % 4]
        await ClockCycles(dut.clk_i, board.random.randint(6, 12))
    await ClockCycles(dut.clk_i, 20)
    assert await board.read("encoder") == place % (1 << 32) and await board.read("encoder_errors") == 0
