"""Packets as boards send them (docs/packet-reference.md).

    for packet in selfproj.packets.split(numpy.memmap("line.slfp")):
        print(packet.header.sequence, packet.moments().m0)
"""

from collections.abc import Iterator
from typing import Any

from ._core.packets import (KIND_CODES, KIND_COMPACT, KIND_IMAGE, KIND_MOMENTS, KIND_VERDICT, Header, Packet, build,
                            moments_packet, parse)

__all__ = ["KIND_CODES", "KIND_COMPACT", "KIND_IMAGE", "KIND_MOMENTS", "KIND_VERDICT", "Header", "Packet", "build",
           "moments_packet", "parse", "split"]


def split(data: Any) -> Iterator[Packet]:
    """The packets of bytes (uint8, or bytes) that hold packets and nothing else, in place.

    ValueError with the fault where there is none. selfproj.driver.open("file:...") looks for the next good one instead.
    """
    offset, count = 0, len(data)
    while offset < count:
        packet = parse(data, offset)
        yield packet
        offset += packet.size
