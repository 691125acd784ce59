"""Parts: cut out of the packets of a line, compared with a tolerance (docs/parts.md).

    profiler = selfproj.light_section.Profiler(rig, reference)
    tolerance = selfproj.parts.learn(profiler, selfproj.parts.cut(good, profiler))
    classifier = selfproj.parts.Classifier(profiler, tolerance)
    for part in selfproj.parts.cut(selfproj.driver.open("ring:line1"), profiler):
        print(classifier.classify(part).verdict)
"""

from collections.abc import Iterable, Iterator

from . import pictures as _pictures
from ._core.light_section import Profiler
from ._core.packets import Packet
from ._core.parts import (Classifier, Cutter, Defect, Part, PartResult, Tolerance, learn, load_tolerance,
                          part_of_depth)

__all__ = ["Classifier", "Cutter", "Defect", "Part", "PartResult", "Tolerance", "cut", "learn", "load_tolerance",
           "part_of_depth"]


def cut(packets: Iterable[Packet], profiler: Profiler) -> Iterator[Part]:
    """The parts of packets, such as those of a device, as they become complete.

    InputError if the profiler's rig has no section `parts`.
    """
    cutter = Cutter(profiler)
    for packet in packets:
        part = cutter.add(packet)
        if part is not None:
            yield part
    part = cutter.finish()
    if part is not None:
        yield part


_pictures.shows(Tolerance, lambda tolerance: [_pictures.text_html(tolerance.to_yaml())])
_pictures.shows(Part, lambda part: [_pictures.map_html(part.heights, "height", spacing=2 * (part.pitch_mm,))])
_pictures.shows(PartResult, lambda result: [
    _pictures.text_html("\n".join(filter(None, [result.verdict, result.reason, *map(repr, result.defects)]))),
    _pictures.map_html(result.heights, "height", spacing=2 * (result.pitch_mm,)),
    _pictures.map_html(result.difference, "difference from the reference", signed=True, spacing=2 * (result.pitch_mm,))])
