"""Packets and registers of the board, read from model/spec/selfproj.json alone.

Nothing of the project's own programs is used: this is a second reading of the specification.
"""

import json
import pathlib

SPEC = json.loads((pathlib.Path(__file__).resolve().parents[2] / "model" / "spec" / "selfproj.json").read_text())
MAGIC = int.from_bytes(SPEC["packet"]["magic"].encode(), "little")
VERSION = SPEC["version"]["major"] << 8 | SPEC["version"]["minor"]
KINDS = {kind["name"]: kind["value"] for kind in SPEC["kinds"]}
MODES = {mode["name"]: mode["value"] for mode in SPEC["modes"]}
STATUS = {bit["name"]: 1 << bit["value"] for bit in SPEC["packet"]["status"]}
FORMATS = {form["name"]: form for form in SPEC["formats"]}
REGISTERS = {register["name"]: register for register in SPEC["registers"]}
BEAT = next(size["value"] for size in SPEC["sizes"] if size["name"] == "packet_beat_bytes")


def address(name):
    return int(REGISTERS[name]["address"], 16)


def register_word(name, **fields):
    """Returns the word of a register in which these fields have these values, and the others 0."""
    layout = {field["name"]: field for field in REGISTERS[name]["fields"]}
    word = 0
    for field, value in fields.items():
        assert value >> layout[field]["bits"] == 0, f"{name}.{field} has no {value}"
        word |= value << layout[field]["lsb"]
    return word


def register_mask(name):
    return sum(((1 << field["bits"]) - 1) << field["lsb"] for field in REGISTERS[name]["fields"])


def cut(layout, data):
    """Returns the fields of a header or trailer, and how many bytes they take."""
    fields, place = {}, 0
    for field in layout:
        size = field["bits"] // 8
        fields[field["name"]] = int.from_bytes(data[place:place + size], "little")
        place += size
    return fields, place


def check_word(data):
    """Returns the check word over whole beats, as the specification words it."""
    check, polynomial = (int(SPEC["packet"]["check"][name], 16) for name in ("init", "polynomial"))
    for at in range(0, len(data), 16):
        check = (check << 1) ^ (polynomial | 1 << 32 if check >> 31 else 0)
        for i in range(4):
            word = int.from_bytes(data[at + 4 * i:at + 4 * i + 4], "little")
            check ^= (word << 8 * i | word >> (32 - 8 * i)) & 0xFFFFFFFF
    return check


def parse(data):
    """Returns header, payload and trailer of a packet, of which every rule is checked."""
    header, head_size = cut(SPEC["packet"]["header"], data)
    tail_size = sum(field["bits"] for field in SPEC["packet"]["trailer"]) // 8
    assert len(data) == head_size + header["payload_size"] + tail_size, (len(data), header)
    payload = data[head_size:-tail_size]
    trailer, _ = cut(SPEC["packet"]["trailer"], data[-tail_size:])
    assert header["magic"] == MAGIC and header["version"] == VERSION and header["pixel"] == 0, header
    assert header["kind"] in KINDS.values() and len(payload) % BEAT == 0, header
    assert trailer["sequence"] == header["sequence"], (header, trailer)
    assert trailer["check"] == check_word(data[:-4] + bytes(4)), "the check word is wrong"
    assert payload or trailer["status"], "an empty payload says why"
    return header, payload, trailer


def pack(form, **columns):
    """Returns the payload of columns in a format: the words of the fields' values (arrays), and zeros up to a beat."""
    layout = FORMATS[form]
    size = layout["word_bits"] // 8
    out = bytearray()
    for i in range(len(next(iter(columns.values())))):
        word = 0
        for field in layout["fields"]:
            value = int(columns[field["name"]][i])
            assert value >> field["bits"] == 0, (form, field["name"], value)
            word |= value << field["lsb"]
        out += word.to_bytes(size, "little")
    return bytes(out) + bytes(-len(out) % BEAT)
