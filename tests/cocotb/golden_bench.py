"""An example for benches of others: circuits against the golden model from the Python package selfproj.

golden_moments is for sp_column_moments alone, golden_board for sp_board through cocotbext-axi. What comes out must be
the model's to the last bit, while every channel stalls at random. run.py --golden runs both.
"""

import os

import cocotb
import numpy
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge
from cocotbext.axi import AxiResp
from selfproj import model, packets

from board_bench import Board

MAX_COLUMNS, MAX_ROWS = int(os.environ["MAX_COLUMNS"]), int(os.environ["MAX_ROWS"])
SEED = int(os.environ.get("SELFPROJ_SEED", "1"))
FRAMES = 25


class Frames:
    """Random images with random settings."""

    def __init__(self):
        self.random = numpy.random.default_rng(SEED)

    def __iter__(self):
        for number in range(FRAMES):
            shape = int(self.random.integers(1, MAX_ROWS + 1)), 4 * int(self.random.integers(1, MAX_COLUMNS // 4 + 1))
            yield (number, self.random.integers(0, 256, shape, dtype="uint8"), int(self.random.integers(0, 256)),
                   model.Mode(int(self.random.integers(0, 3))))

    def stall(self):
        return self.random.integers(0, 3) == 0


async def beats_of_image(dut, frames, image):
    """Sends an image beat by beat, with its position, as sp_frame_tracker does it."""
    rows, groups = image.shape[0], image.shape[1] // 4
    dut.one_group_i.value, dut.two_groups_i.value = int(groups == 1), int(groups == 2)
    for row in range(rows):
        for group in range(groups):
            while frames.stall():
                await RisingEdge(dut.clk_i)
            dut.beat_valid_i.value = 1
            dut.beat_pixels_i.value = int.from_bytes(image[row, 4 * group:4 * group + 4].tobytes(), "little")
            dut.beat_group_i.value, dut.beat_row_i.value = group, row + 1
            dut.beat_first_row_i.value, dut.beat_last_row_i.value = int(row == 0), int(row == rows - 1)
            dut.beat_line_end_i.value = int(group == groups - 1)
            await RisingEdge(dut.clk_i)
            dut.beat_valid_i.value = 0


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def golden_moments(dut):
    for name in ("beat_valid_i", "break_i", "mode_i", "threshold_i"):
        getattr(dut, name).value = 0
    dut.accept_i.value = dut.rst_i.value = 1
    cocotb.start_soon(Clock(dut.clk_i, 6600, "ps").start())
    await ClockCycles(dut.clk_i, 8)
    dut.rst_i.value = 0
    came = bytearray()

    async def collect():
        while True:
            await RisingEdge(dut.clk_i)
            if dut.moments_valid_o.value == 1:
                came.extend(int(dut.moments_data_o.value).to_bytes(16, "little"))

    cocotb.start_soon(collect())
    frames = Frames()
    for number, image, threshold, mode in frames:
        dut.mode_i.value, dut.threshold_i.value = mode.value, threshold
        await beats_of_image(dut, frames, image)
        await ClockCycles(dut.clk_i, MAX_COLUMNS // 4 + 24)
        wanted = packets.parse(packets.moments_packet(image, threshold, mode)).payload.tobytes()
        assert came == wanted, f"frame {number}, {image.shape}, {mode}, threshold {threshold}"
        came.clear()


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def golden_board(dut):
    board = Board(dut)
    await board.start()
    board.sink.set_pause_generator(board.stalls(50))
    for channel in (board.axil.write_if.aw_channel, board.axil.write_if.w_channel, board.axil.write_if.b_channel,
                    board.axil.read_if.ar_channel, board.axil.read_if.r_channel):
        channel.set_pause_generator(board.stalls(50))
    await board.set("control", run=1)
    for number, image, threshold, mode in Frames():
        rows, columns = image.shape
        await board.set("size", columns=columns, rows=rows)
        await board.set("measure", threshold=threshold, mode=mode.value, stream=number)
        await board.expect_register("size", columns=columns, rows=rows)
        await board.frame(image, gaps=30)
        got = bytes((await board.sink.recv(compact=False)).tdata)
        header = packets.parse(got).header
        assert (header.sequence, header.stream, header.lost) == (number, number, 0)
        # Of the packet, time and encoder are the board's; everything else is the model's.
        assert got == packets.moments_packet(image, threshold, mode, header=header).tobytes(), f"frame {number}"
    assert (await board.read("frames"), await board.read("broken"), await board.read("lost_moments")) == (FRAMES, 0, 0)
    assert (await board.axil.read(0xFC, 4)).resp == AxiResp.SLVERR
