"""Devices that bring packets, and images from packets of lines (docs/driver.md).

    with selfproj.driver.open("ring:line1") as device:
        for packet in device:
            print(packet.header.sequence, packet.moments().m0)
"""

from ._core.driver import Device, ImageAssembler, Wait, open  # pylint: disable=redefined-builtin

__all__ = ["Device", "ImageAssembler", "Wait", "open"]
