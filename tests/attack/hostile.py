#!/usr/bin/env python3
"""Hostile clients of a line's page and Modbus server, until standard input ends.

    hostile.py PAGE MODBUS KIND=COUNT...

PAGE and MODBUS are ports of this machine. Each client comes again as soon as it is closed. When all have come once, one
line is written.
"""
import asyncio
import contextlib
import random
import struct
import sys

REQUEST = struct.pack(">HHHBBHH", 1, 0, 6, 1, 4, 0, 21)
GET = "GET {} HTTP/1.1\r\nHost: localhost\r\n\r\n"


async def until_closed(reader):
    with contextlib.suppress(OSError):
        while await reader.read(65536):
            pass


async def silent(reader, _writer):
    await until_closed(reader)


async def drip_text(reader, writer, text, pause):
    closed = asyncio.ensure_future(until_closed(reader))
    for byte in text:
        writer.write(bytes([byte]))
        await writer.drain()
        await asyncio.sleep(pause)
        if closed.done():
            return
    await closed


async def page_drips(reader, writer):
    await drip_text(reader, writer, b"GET / HTTP/1.1\r\nHost: localhost\r\n" + b"X: y\r\n" * 10000, 1)


async def page_drips_its_body(reader, writer):
    head = b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\n"
    await drip_text(reader, writer, head + bytes(10000), 0.2)


async def page_never_ends(_reader, writer):
    """Headers without end, as fast as they are taken."""
    writer.write(b"GET / HTTP/1.1\r\n" if random.random() < 0.5 else b"GET /")
    while True:
        writer.write(b"a: " + b"b" * 4000 + b"\r\n" if random.random() < 0.5 else b"a" * 4000)
        await writer.drain()


async def page_takes_nothing(_reader, writer):
    """Watches, or asks for files, and reads nothing."""
    writer.transport.pause_reading()
    writer.write(GET.format(random.choice(("/stream", "/part", "/camera", "/three.js"))).encode() * 10)
    await asyncio.sleep(60)


async def page_is_greedy(reader, writer):
    """Asks for the largest things without a pause."""
    while True:
        writer.write(GET.format(random.choice(("/", "/part", "/camera", "/three.js", "/live.js"))).encode())
        if not await reader.read(1 << 20):
            return


async def page_watches(reader, writer):
    writer.write(GET.format("/stream").encode())
    await until_closed(reader)


async def page_sends_garbage(reader, writer):
    writer.write(random.randbytes(random.randrange(1, 3000)) + b"\r\n\r\n")
    await asyncio.wait_for(reader.read(100), 1)


async def modbus_drips(reader, writer):
    await drip_text(reader, writer, REQUEST * 1000, 0.04)


async def modbus_drips_slowly(reader, writer):
    await drip_text(reader, writer, REQUEST * 1000, 0.4)


async def modbus_takes_nothing(_reader, writer):
    writer.transport.pause_reading()
    while True:
        writer.write(REQUEST * 100)
        await writer.drain()


async def modbus_is_greedy(reader, writer):
    while True:
        writer.write(REQUEST * 20)
        if not await reader.read(1 << 16):
            return


async def modbus_sends_garbage(reader, writer):
    length = random.randrange(400)
    writer.write(random.choice((random.randbytes(length + 1), REQUEST[:4] + struct.pack(">H", length) + b"\x01\x06" +
                                random.randbytes(length))))
    await asyncio.wait_for(reader.read(100), 1)


async def page_hangs_up(_reader, writer):
    writer.write(GET.format("/stream").encode())
    await writer.drain()


# What is asked of page and Modbus server.
PAGE = {
    "page_silent": silent,
    **{f.__name__: f
       for f in (page_drips, page_drips_its_body, page_never_ends, page_takes_nothing, page_is_greedy, page_watches,
                 page_sends_garbage, page_hangs_up)}
}
MODBUS = {
    "modbus_silent": silent,
    **{f.__name__: f
       for f in (modbus_drips, modbus_drips_slowly, modbus_takes_nothing, modbus_is_greedy, modbus_sends_garbage)}
}


async def client(port, behave, here):
    while True:
        writer = None
        try:
            reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=1 << 22)
            here.set()
            await behave(reader, writer)
        except (OSError, asyncio.TimeoutError, asyncio.IncompleteReadError):
            pass
        if writer is not None:
            writer.transport.abort()
        await asyncio.sleep(0.01)


async def main():
    page, modbus = int(sys.argv[1]), int(sys.argv[2])
    tasks, came = [], []
    for word in sys.argv[3:]:
        kind, count = word.split("=")
        port, behave = (page, PAGE[kind]) if kind in PAGE else (modbus, MODBUS[kind])
        for _ in range(int(count)):
            came.append(asyncio.Event())
            tasks.append(asyncio.ensure_future(client(port, behave, came[-1])))
    for event in came:
        await event.wait()
    print("here", flush=True)
    await asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
    for task in tasks:
        task.cancel()


if __name__ == "__main__":
    asyncio.run(main())
