"""What the dissector for Wireshark knows of packets and datagrams, as tables of Lua; generate.py writes it.

The function takes a generate.Spec and gives the lines that stand between the markers in host/driver/selfproj.lua.
"""

import textwrap

WIDTH = 118


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def entry(indent, values, description):
    """A table of Lua; its last value is the description, on lines of its own where the line would be too long."""
    head = f"{indent}{{{', '.join(values)}, "
    whole = f"{head}{quoted(description)}}},"
    if len(whole) <= WIDTH:
        return [whole]
    pieces = textwrap.wrap(description, WIDTH - len(indent) - 8, drop_whitespace=False)
    lines = [f"{indent}  {quoted(piece)}" for piece in pieces]
    return [head.rstrip(), *[line + " .." for line in lines[:-1]], lines[-1] + "},"]


def fields(name, items):
    """Name, first byte, bits and description of each."""
    out = [f"  {name} = {{"]
    for item in items:
        out += entry("    ", [quoted(item["name"]), str(item["lsb"] // 8), str(item["bits"])], item["description"])
    return out + ["  },"]


def values(name, items):
    return [f"  {name} = {{" + ", ".join(f'[{item["value"]}] = {quoted(item["name"])}' for item in items) + "},"]


def bits(name, items):
    out = [f"  {name} = {{"]
    for item in items:
        out += entry("    ", [quoted(item["name"]), str(item["value"])], item["description"])
    return out + ["  },"]


def words(spec):
    out = ["  words = {"]
    for fmt in spec.raw["formats"]:
        out += [f"    {fmt['name']} = {{bits = {fmt['word_bits']}, fields = {{"]
        for field in fmt["fields"]:
            out += entry("      ", [quoted(field["name"]), str(field["lsb"]), str(field["bits"])],
                         field["description"])
        out += ["    }},"]
    return out + ["  },"]


def lua_format(spec):
    packet = spec.raw["packet"]
    check = packet["check"]
    versions = [f'[{item["hash"]}] = "{item["major"]}.{item["minor"]}"' for item in spec.raw["earlier_versions"]]
    versions.append(f'[0x{spec.hash:08X}] = "{spec.version >> 8}.{spec.version & 255}"')
    out = ["local format = {",
           f"  datagram_magic = 0x{spec.datagram_magic:04X},",
           f"  beat_bytes = {spec.sizes['packet_beat_bytes']},",
           f"  header_bytes = {spec.header_bytes},",
           f"  trailer_bytes = {spec.trailer_bytes},",
           f"  datagram_header_bytes = {spec.datagram_header_bytes},",
           f"  check = {{init = {check['init']}, polynomial = {check['polynomial']}}},",
           "  versions = {" + ", ".join(versions) + "},"]
    out += fields("datagram", spec.datagram_header) + fields("header", spec.header) + fields("trailer", spec.trailer)
    out += values("kinds", spec.raw["kinds"]) + values("modes", spec.raw["modes"])
    out += values("selects", spec.raw["selects"])
    out += bits("flags", packet["flags"]) + bits("status", packet["status"]) + words(spec)
    return out + ["}"]
