"""The tables of the documents that follow from the specification; generate.py writes them.

Each function takes a generate.Spec and gives the lines of Markdown that stand between the markers of its name.
"""

import textwrap

WIDTH = 120


def hex32(value):
    return f"0x{value:08X}"


def bit_range(lsb, bits):
    return str(lsb) if bits == 1 else f"{lsb + bits - 1}..{lsb}"


def formats(spec):
    out = [f"Largest image: {spec.sizes['column_limit']} columns, {spec.sizes['max_rows']} rows and pixels 0..255 where "
           "nothing else is said.",
           "", "| word | bits | field | meaning | largest value | it fits |", "|---|---|---|---|---|---|"]
    for fmt in spec.raw["formats"]:
        pixels = f", pixels of {fmt['pixel_bits']}" if "pixel_bits" in fmt else ""
        if fmt.get("rows", spec.sizes["max_rows"]) != spec.sizes["max_rows"]:
            pixels += f", {fmt['rows']:,} rows"
        for field in fmt["fields"]:
            out.append(f"| {fmt['name']}, {fmt['word_bits']} bits{pixels} | {bit_range(field['lsb'], field['bits'])} | "
                       f"{field['name']} | {field['description']} | {field['max'].replace('*', ' · ')} | "
                       f"{field['max_value']:,} < 2^{field['bits']} = {1 << field['bits']:,} |")
    return out


def planned(spec):
    """Words that version 2 has room for, and that nothing builds yet."""
    out = ["| word | pixels | rows | bits | field | meaning | it fits |", "|---|---:|---:|---|---|---|---|"]
    for fmt in spec.raw["planned"]:
        out.append(f"| **{fmt['name']}**, {fmt['word_bits']} bits | {fmt['pixel_bits']} bits | {fmt['rows']:,} | | | "
                   f"{fmt['description']} | |")
        out += [f"| | | | {bit_range(f['lsb'], f['bits'])} | {f['name']} | {f['description']} | "
                f"{f['max_value']:,} < 2^{f['bits']} |" for f in fmt["fields"]]
    return out


def fields_by_byte(fields):
    out = ["| byte | bits | field | meaning |", "|---:|---:|---|---|"]
    return out + [f"| {f['lsb'] // 8} | {f['bits']} | {f['name']} | {f['description']} |" for f in fields]


def header(spec):
    return [f"Specification version {spec.version >> 8}.{spec.version & 255}, hash `{hex32(spec.hash)}`.",
            ""] + fields_by_byte(spec.header)


def versions(spec):
    """The earlier versions that readers take."""
    out = ["| version | hash | reserved bytes of its header | what it had not |", "|---|---|---|---|"]
    return out + [f"| {item['major']}.{item['minor']} | `{item['hash']}` | {item['reserved_byte']}.."
                  f"{spec.header_bytes - 1} | {item['description']} |" for item in spec.raw["earlier_versions"]]


def trailer(spec):
    return fields_by_byte(spec.trailer)


def values(spec):
    """Modes, selects, kinds, flags and status bits."""
    packet = spec.raw["packet"]
    out = []
    for title, items in (("kind", spec.raw["kinds"]), ("mode", spec.raw["modes"]),
                         ("select", spec.raw["selects"]),
                         ("bit of flags", packet["flags"]), ("bit of status", packet["status"])):
        out += ["", f"| {title} | name | meaning |", "|---:|---|---|"]
        out += [f"| {item['value']} | {item['name']} | {item['description']} |" for item in items]
    return out[1:]


def check(spec):
    rule = spec.raw["packet"]["check"]
    return textwrap.wrap(f"The check word c begins at {rule['init']}; P is {rule['polynomial']}. {rule['description']}",
                         WIDTH)


STRUCT_LETTER = {8: "B", 16: "H", 32: "I", 64: "Q"}


def struct_format(fields):
    """The format for Python's struct module; fields of other sizes are passed over."""
    return "<" + "".join(STRUCT_LETTER.get(field["bits"], f"{field['bits'] // 8}x") for field in fields)


def reader(spec):
    """A shell block with a program in Python that lists the packets of a file."""
    named = [field["name"] for field in spec.header if field["bits"] in STRUCT_LETTER]
    lines = textwrap.wrap(" ".join(named), WIDTH - 20)
    names = ["names = ('" + lines[0]] + ["         '" + line for line in lines[1:]]
    names = [line + " '" for line in names[:-1]] + [names[-1] + "').split()"]
    return ["```sh", "selfproj-sim cosim --engine model --count 3 --packets three.packets",
            "python3 - three.packets <<'EOF'",
            "import struct, sys", "", *names,
            f"header = struct.Struct('{struct_format(spec.header)}')",
            f"trailer = struct.Struct('{struct_format(spec.trailer)}')  # sequence, status, check",
            "data = open(sys.argv[1], 'rb').read()", "at = 0", "while at < len(data):",
            "    packet = dict(zip(names, header.unpack_from(data, at)))",
            f"    assert packet['magic'] == {hex32(spec.magic)} and packet['spec_hash'] == {hex32(spec.hash)}",
            "    payload = data[at + header.size:at + header.size + packet['payload_size']]",
            "    sequence, status, check = trailer.unpack_from(data, at + header.size + len(payload))",
            "    print(f\"kind {packet['kind']}, frame {sequence}: {packet['columns']} x {packet['rows']}, \"",
            "          f\"{len(payload)} bytes, status {status}\")",
            "    at += header.size + len(payload) + trailer.size", "EOF", "```"]


def registers(spec):
    out = ["| address | register | access | after reset | what it is |", "|---|---|---|---|---|"]
    for reg in spec.raw["registers"]:
        reset = reg.get("after_reset", hex32(reg["reset_value"]))
        out.append(f"| 0x{reg['offset']:02X} | {reg['name']} | {reg['access']} | {reset} | "
                   f"{reg['description'].split(';')[0]} |")
    return out


def sentence(text):
    return text[0].upper() + text[1:] + "."


def fields(spec):
    """A section for each register."""
    out = []
    for reg in spec.raw["registers"]:
        out += ["", f"### 0x{reg['offset']:02X} {reg['name']}", "",
                *textwrap.wrap(sentence(reg["description"]), WIDTH), ""]
        if reg["access"] == "ro":
            out += ["| bits | field | meaning |", "|---:|---|---|"]
            out += [f"| {bit_range(f['lsb'], f['bits'])} | {f['name']} | {f['description']} |" for f in reg["fields"]]
            continue
        out += ["| bits | field | after reset | meaning | takes effect |", "|---:|---|---:|---|---|"]
        for field in reg["fields"]:
            reset = reg["reset_value"] >> field["lsb"] & (1 << field["bits"]) - 1
            effect = "next frame start" if reg.get("setting") else field["effect"]
            out.append(f"| {bit_range(field['lsb'], field['bits'])} | {field['name']} | {reset:,} | "
                       f"{field['description']} | {effect} |")
    return out[1:]


# Block RAM of parts: name, blocks, and the shapes (depth, width) of one block with one port that reads and one that
# writes, from the makers' data sheets.
RAMB16 = [(512, 36), (1024, 18), (2048, 9), (4096, 4), (8192, 2), (16384, 1)]
RAMB36 = [(512, 72), (1024, 36), (2048, 18), (4096, 9), (8192, 4), (16384, 2), (32768, 1)]
EBR18 = [(512, 36), (1024, 18), (2048, 9), (4096, 4), (8192, 2), (16384, 1)]
M10K = [(256, 40), (512, 20), (1024, 10), (2048, 5), (4096, 2), (8192, 1)]
PARTS = [
    ("XC3S5000", "Spartan-3", 104, RAMB16),
    ("LFE5U-85", "ECP5", 208, EBR18),
    ("5CSEBA6", "Cyclone V", 557, M10K),
    ("XC7A100T", "Artix-7", 135, RAMB36),
    ("XC7A200T", "Artix-7", 365, RAMB36),
    ("XC7K325T", "Kintex-7", 445, RAMB36),
    ("XCKU060", "Kintex UltraScale", 1080, RAMB36),
]
GRAY_IMAGES = [(128, 128, 4), (256, 256, 4), (256, 256, 8), (512, 96, 8), (512, 384, 4), (512, 512, 4), (512, 512, 8),
               (640, 480, 8), (640, 480, 12), (1024, 768, 10), (1280, 1023, 10), (2048, 1023, 12)]


def gray_memory(spec):
    lanes = spec.sizes["pixels_per_beat"]
    out = ["| image | m | bits a pixel | word | words | kbit | " + " | ".join(f"{p[0]} ({p[1]}, {p[2]})" for p in PARTS)
           + " |", "|---|---:|---:|---:|---:|---:|" + "---:|" * len(PARTS)]
    for columns, rows, bits in GRAY_IMAGES:
        state = spec.sizes["pixel_bits"] + 2 * bits
        words = columns * rows // lanes
        bank = 1 << max(11, (words - 1).bit_length() - 5 if words > 1 << 16 else 0)  # BankBits of sp_gray_memory
        banks = [min(bank, words - at) for at in range(0, words, bank)]
        cells = []
        for _, _, blocks, shapes in PARTS:
            needed = sum(min(-(-lanes * state // width) * -(-length // depth) for depth, width in shapes)
                         for length in banks)
            cells.append(f"{needed:,}" if needed <= blocks else "–")
        out.append(f"| {columns} × {rows} | {bits} | {state} | {lanes * state} | {words:,} | "
                   f"{words * lanes * state / 1024:,.0f} | " + " | ".join(cells) + " |")
    return out


def link(spec):
    out = ["| address | register | access | bits | meaning |", "|---|---|---|---|---|"]
    for reg in spec.raw["link"]["registers"]:
        for field in reg["fields"]:
            out.append(f"| 0x{reg['offset']:03X} | {reg['name']} | {reg['access']} | "
                       f"{bit_range(field['lsb'], field['bits'])} | {field['description']} |")
    return out


def datagram(spec):
    return fields_by_byte(spec.raw["datagram"]["header"])


def sources(spec):
    out = ["| source | name | frames |", "|---:|---|---|"]
    return out + [f"| {item['value']} | {item['name']} | {item['description']} |"
                  for item in spec.raw["link"]["sources"]]


def replay(spec):
    return fields_by_byte(spec.replay_header)


MAKERS = {"formats": formats, "planned": planned, "header": header, "versions": versions, "trailer": trailer,
          "values": values, "check": check, "reader": reader, "datagram": datagram, "link": link, "replay": replay,
          "sources": sources, "registers": registers, "fields": fields, "gray_memory": gray_memory}
