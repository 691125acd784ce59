#!/usr/bin/env python3
"""Writes everything that follows from selfproj.json.

    generate.py            write the files
    generate.py --check    write nothing; exit 1 and name each file that differs

Outputs: the C++ header, the table of registers by name (C++20, register_table.py), the SystemVerilog package,
the registers as SystemRDL (system_rdl.py), what the dissector for Wireshark knows of packets (lua_format.py), and the
tables (tables.py) between the markers `<!-- BEGIN GENERATED name -->` and `<!-- END GENERATED name -->` of the Markdown
files listed in TABLES.
Standard library only. Every number format is proved here: the largest value that can occur is computed from the sizes
and must fit its field. If one does not fit, the generator says so and writes nothing.
"""

import argparse
import ast
import hashlib
import json
import operator
import pathlib
import re
import sys

import lua_format
import register_table
import system_rdl
import tables

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SPEC = HERE / "selfproj.json"
HEADER = HERE.parents[1] / "include" / "selfproj" / "model" / "generated" / "selfproj_spec.h"
REGISTERS = HERE / "generated" / "register_table.h"
DATAGRAM = HERE / "generated" / "datagram_format.h"
PACKAGE = ROOT / "rtl" / "common" / "sp_spec_pkg.sv"
VHDL_PACKAGE = ROOT / "rtl" / "common" / "sp_spec_pkg.vhd"
REGISTERS_RDL = ROOT / "rtl" / "selfproj.rdl"
DISSECTOR = ROOT / "host" / "driver" / "selfproj.lua"
TABLES = {
    ROOT / "docs" / "packet-reference.md": ["formats", "planned", "header", "versions", "trailer", "values", "check",
                                                "reader", "datagram", "replay"],
    ROOT / "docs" / "register-reference.md": ["registers", "fields", "link", "sources"],
    ROOT / "docs" / "circuits" / "gray.md": ["gray_memory"],
}

# Fields of the header that describe the frame, not the packet, each with the bits that a build has.
FRAME_FIELDS = [("stream", "HeaderStreamBits"), ("pattern", "HeaderPatternBits"), ("mode", "ModeBits"),
                ("threshold", "HeaderThresholdBits"), ("sequence", "HeaderSequenceBits"),
                ("time_stamp", "HeaderTimeStampBits"), ("encoder", "HeaderEncoderBits"), ("columns", "column_bits"),
                ("rows", "row_bits"), ("lines", "row_bits"), ("flags", "FlagBits"), ("select", "SelectBits"),
                ("first_row", "row_bits"), ("last_row", "row_bits"), ("gap", "RegMeasureGapBits"),
                ("region_row", "region_bits"), ("region_column", "region_bits"), ("pixel", "wide_bits")]
PROSE = ("description", "effect", "after_reset")  # keys that are for readers only and do not concern programs
LINK_BASE = 0x100  # first address of the registers of the link
REGISTER_WORDS = 64  # addresses of the registers, four bytes each
MAIN_WORDS = 32  # of these, those of the register file; behind them are those of the verdict


class SpecError(Exception):
    """The specification contradicts itself."""


def without_descriptions(node):
    """Returns the part of the specification on which programs must agree: everything except the prose."""
    if isinstance(node, dict):
        return {k: without_descriptions(v) for k, v in node.items() if k not in PROSE}
    if isinstance(node, list):
        return [without_descriptions(v) for v in node]
    return node


def with_whole_descriptions(node):
    """Returns the same tree, with descriptions that are split over lines joined."""
    if isinstance(node, dict):
        return {k: "".join(v) if k in PROSE and isinstance(v, list) else with_whole_descriptions(v)
                for k, v in node.items()}
    if isinstance(node, list):
        return [with_whole_descriptions(v) for v in node]
    return node


def without_later(node):
    """Returns the same tree without the items that were added since the version was laid out (`later`).

    They are new kinds of packet and new registers: no packet of before changes, and who does not know them refuses them.
    What got a meaning since is what it `was`.
    """
    if isinstance(node, dict):
        if "was" in node:
            return node["was"]
        return {key: without_later(value) for key, value in node.items()}
    if isinstance(node, list):
        return [without_later(value) for value in node if not (isinstance(value, dict) and value.get("later"))]
    return node


def spec_hash(spec):
    """First 32 bits of the SHA-256 of the specification without its prose, keys sorted.

    Datagrams, replay and the link only carry packets, frames and accesses, and have their own magic numbers; they do
    not count. Neither does what is only planned, nor what came later without a change of what there was.
    """
    agreed = {key: value for key, value in spec.items() if key not in ("datagram", "replay", "link", "planned")}
    canonical = json.dumps(without_descriptions(without_later(agreed)), sort_keys=True, separators=(",", ":"))
    return int.from_bytes(hashlib.sha256(canonical.encode()).digest()[:4], "big")


def evaluate(expression, names):
    """Integer arithmetic over + - * / and names; / must come out even."""
    operators = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul}

    def value(node):
        if isinstance(node, ast.Constant) and isinstance(node.value, int):
            return node.value
        if isinstance(node, ast.Name) and node.id in names:
            return names[node.id]
        if isinstance(node, ast.BinOp):
            left, right = value(node.left), value(node.right)
            if isinstance(node.op, ast.Div):
                if left % right:
                    raise SpecError(f"'{expression}' is not an integer")
                return left // right
            if type(node.op) in operators:
                return operators[type(node.op)](left, right)
        raise SpecError(f"cannot evaluate '{expression}'")

    return value(ast.parse(expression, mode="eval").body)


class Spec:
    """The specification with everything derived from it."""

    def __init__(self, path):
        self.raw = with_whole_descriptions(json.loads(path.read_text(encoding="utf-8")))
        self.hash = spec_hash(self.raw)
        self.version = self.raw["version"]["major"] << 8 | self.raw["version"]["minor"]
        self.sizes = {s["name"]: s["value"] for s in self.raw["sizes"]}
        self.magic = int.from_bytes(self.raw["packet"]["magic"].encode(), "little")
        self.names = {"rows": self.sizes["max_rows"], "columns": self.sizes["max_columns"],
                      "pixel": (1 << self.sizes["pixel_bits"]) - 1}
        self.header = self._lay_out(self.raw["packet"]["header"])
        self.trailer = self._lay_out(self.raw["packet"]["trailer"])
        self.datagram_magic = int.from_bytes(self.raw["datagram"]["magic"].encode(), "little")
        self.datagram_header = self._lay_out(self.raw["datagram"]["header"])
        self.datagram_header_bytes = self._bytes(self.datagram_header)
        self.replay_magic = int.from_bytes(self.raw["replay"]["magic"].encode(), "little")
        self.replay_header = self._lay_out(self.raw["replay"]["header"])
        self.replay_header_bytes = self._bytes(self.replay_header, self.sizes["pixels_per_beat"], "header of replay")
        self.header_bytes = self._bytes(self.header)
        self.trailer_bytes = self._bytes(self.trailer)
        self._prove_formats()
        self._check_registers()
        self._check_earlier_versions()

    @staticmethod
    def _lay_out(fields):
        lsb = 0
        for field in fields:
            field["lsb"] = lsb
            lsb += field["bits"]
            if field["bits"] in (16, 32, 64) and field["lsb"] % field["bits"]:
                raise SpecError(f"packet field {field['name']} is not aligned")
        return fields

    def _bytes(self, fields, beat_bytes=None, what="header or trailer"):
        total = fields[-1]["lsb"] + fields[-1]["bits"]
        if total % (8 * (beat_bytes or self.sizes["packet_beat_bytes"])):
            raise SpecError(f"{what} is not a whole number of beats")
        return total // 8

    def _prove_formats(self):
        for fmt in self.raw["formats"] + self.raw["planned"]:
            end = 0
            names = self.names
            if "pixel_bits" in fmt:
                names = {"rows": fmt["rows"], "pixel": (1 << fmt["pixel_bits"]) - 1}
            for field in fmt["fields"]:
                field["max_value"] = evaluate(field["max"], names)
                if field["max_value"] >> field["bits"]:
                    raise SpecError(f"{fmt['name']}.{field['name']}: {field['max_value']} needs more than "
                                    f"{field['bits']} bits")
                if field["lsb"] < end or field["lsb"] + field["bits"] > fmt["word_bits"]:
                    raise SpecError(f"{fmt['name']}.{field['name']}: overlaps or leaves its word")
                end = field["lsb"] + field["bits"]

    def _check_earlier_versions(self):
        """An earlier version had the same packet up to its reserved bytes, which were 0."""
        ends = {field["lsb"] // 8 for field in self.header}
        for earlier in self.raw["earlier_versions"]:
            earlier["version"] = earlier["major"] << 8 | earlier["minor"]
            if earlier["version"] >= self.version:
                raise SpecError("an earlier version has a smaller number")
            if earlier["reserved_byte"] not in ends:
                raise SpecError(f"earlier version {earlier['major']}.{earlier['minor']}: its reserved bytes begin "
                                "within a field")

    def _check_registers(self):
        self._check_block(self.raw["registers"], 0)
        self._check_block(self.raw["link"]["registers"], LINK_BASE)

    def _check_block(self, registers, base):
        used = set()
        for reg in registers:
            reg["offset"] = int(reg["address"], 16)
            if reg["offset"] % 4 or reg["offset"] in used or not 0 <= reg["offset"] - base < 4 * REGISTER_WORDS:
                raise SpecError(f"register {reg['name']}: address {reg['address']} is taken or not aligned")
            used.add(reg["offset"])
            symbolic = {"magic": self.magic, "version": self.version, "hash": self.hash}
            reg["reset_value"] = symbolic.get(reg["reset"]) if reg["reset"] in symbolic else int(reg["reset"], 16)
            mask = 0
            for field in reg["fields"]:
                bits = (1 << field["bits"]) - 1 << field["lsb"]
                if mask & bits or bits >> 32:
                    raise SpecError(f"register {reg['name']}: field {field['name']} overlaps or leaves the word")
                mask |= bits


def camel(name):
    return "".join(part.capitalize() for part in name.split("_"))


def hex32(value):
    return f"0x{value:08X}"


def cpp_earlier_versions(spec):
    earlier = spec.raw["earlier_versions"]
    return ["// Earlier versions: their packets differ only in the header, whose bytes from `reserved_byte` on were 0. With",
            "// `control` their registers are those of this version, but for what `capability` says.",
            "struct EarlierVersion {", "  std::uint32_t hash;", "  std::uint16_t version;",
            "  std::size_t reserved_byte;", "  bool control;", "};",
            f"constexpr std::array<EarlierVersion, {len(earlier)}> kEarlierVersions{{{{",
            *(f"    {{{item['hash']}U, 0x{item['version']:04X}, {item['reserved_byte']}, "
              f"{'true' if item['control'] else 'false'}}},  // {item['description']}"
              for item in earlier), "}};"]


def cpp_header(spec):
    out = []
    emit = out.append
    emit("// Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.")
    emit("#ifndef SELFPROJ_SPEC_GENERATED_SELFPROJ_SPEC_H")
    emit("#define SELFPROJ_SPEC_GENERATED_SELFPROJ_SPEC_H")
    emit("")
    emit("#include <array>")
    emit("#include <cstddef>")
    emit("#include <cstdint>")
    emit("")
    emit("namespace selfproj {")
    emit("namespace spec {")
    emit("")
    emit(f"constexpr std::uint32_t kHash = {hex32(spec.hash)}U;")
    emit(f"constexpr std::uint16_t kVersion = 0x{spec.version:04X};")
    emit("")
    out += cpp_earlier_versions(spec)
    emit("")
    emit("// Sizes")
    for size in spec.raw["sizes"]:
        emit(f"constexpr int k{camel(size['name'])} = {size['value']};  // {size['description']}")
    emit("")
    for group, comment in (("modes", "Modes of the moments"),
                           ("selects", "What of a column the moments are taken of"), ("kinds", "Kinds of packet")):
        emit(f"// {comment}")
        prefix = camel(group[:-1])
        for item in spec.raw[group]:
            emit(f"constexpr std::uint8_t k{prefix}{camel(item['name'])} = {item['value']};  // {item['description']}")
        emit("")
    emit("// Payload words; the largest value that can occur fits its field")
    for fmt in spec.raw["formats"]:
        prefix = f"k{camel(fmt['name'])}"
        emit(f"constexpr int {prefix}WordBits = {fmt['word_bits']};")
        for field in fmt["fields"]:
            name = prefix + camel(field["name"])
            emit(f"constexpr int {name}Lsb = {field['lsb']};")
            emit(f"constexpr int {name}Bits = {field['bits']};")
            emit(f"constexpr std::uint64_t {name}Max = {field['max_value']};  // {field['max']}")
            emit(f"static_assert({name}Max >> {name}Bits == 0, \"{fmt['name']}.{field['name']} does not fit\");")
    emit("")
    emit("// Packet: byte offsets")
    emit(f"constexpr std::uint32_t kMagic = {hex32(spec.magic)}U;  // \"{spec.raw['packet']['magic']}\"")
    emit(f"constexpr std::size_t kHeaderBytes = {spec.header_bytes};")
    emit(f"constexpr std::size_t kTrailerBytes = {spec.trailer_bytes};")
    for part, fields in (("Header", spec.header), ("Trailer", spec.trailer)):
        for field in fields:
            emit(f"constexpr std::size_t k{part}{camel(field['name'])} = {field['lsb'] // 8};"
                 f"  // {field['bits']} bits")
    emit("")
    emit("// Header flags and trailer status bits")
    for item in spec.raw["packet"]["flags"]:
        emit(f"constexpr std::uint8_t kFlag{camel(item['name'])} = 1U << {item['value']};  // {item['description']}")
    for item in spec.raw["packet"]["status"]:
        emit(f"constexpr std::uint32_t kStatus{camel(item['name'])} = 1U << {item['value']};"
             f"  // {item['description']}")
    emit("")
    emit("// Check word")
    emit(f"constexpr std::uint32_t kCheckInit = {spec.raw['packet']['check']['init']}U;")
    emit(f"constexpr std::uint32_t kCheckPolynomial = {spec.raw['packet']['check']['polynomial']}U;")
    emit("")
    emit("// Registers: byte addresses, reset values, fields. docs/register-reference.md says what they do.")
    for reg in spec.raw["registers"]:
        name = f"kReg{camel(reg['name'])}"
        emit(f"constexpr std::uint32_t {name} = 0x{reg['offset']:02X};  // {reg['access']}")
        emit(f"constexpr std::uint32_t {name}Reset = {hex32(reg['reset_value'])}U;")
        for field in reg["fields"]:
            field_name = name + camel(field["name"])
            emit(f"constexpr int {field_name}Lsb = {field['lsb']};")
            emit(f"constexpr int {field_name}Bits = {field['bits']};")
    emit("")
    emit("}  // namespace spec")
    emit("}  // namespace selfproj")
    emit("")
    emit("#endif  // SELFPROJ_SPEC_GENERATED_SELFPROJ_SPEC_H")
    return "\n".join(out) + "\n"


def sv_frame_mask():
    """Returns the function that selects the header bits that describe the frame, in a build of that size."""
    terms = [f"~({{HeaderBits{{1'b1}}}} << {bits}) << Header{camel(name)}Lsb" for name, bits in FRAME_FIELDS]
    return ["  // Bits of a header that tell of the frame; columns have column_bits, rows and lines row_bits,",
            "  // the place of a region region_bits, what is said of wide pixels wide_bits",
            "  function automatic logic [HeaderBits-1:0] frame_mask(input int column_bits, input int row_bits,",
            "                                                     input int region_bits, input int wide_bits);",
            "    frame_mask = " + " |\n                 ".join(terms) + ";", "  endfunction"]


def sv_link(spec):
    """The registers of the link, for boards on the network."""
    out = ["  // Registers of the link, for boards on the network"]
    for reg in spec.raw["link"]["registers"]:
        name = f"Link{camel(reg['name'])}"
        out.append(f"  localparam logic [31:0] {name} = 32'h{reg['offset']:08X};")
        if reg["access"] == "ro":
            out.append(f"  localparam logic [31:0] {name}Reset = 32'h{reg['reset_value']:08X};")
        for field in reg["fields"]:
            out.append(f"  localparam int {name}{camel(field['name'])}Lsb = {field['lsb']};")
            out.append(f"  localparam int {name}{camel(field['name'])}Bits = {field['bits']};")
    bits = next(reg for reg in spec.raw["link"]["registers"] if reg["name"] == "source")["fields"][0]["bits"]
    out += [f"  localparam logic [{bits - 1}:0] Source{camel(item['name'])} = {bits}'d{item['value']};"
            for item in spec.raw["link"]["sources"]]
    return out


def sv_replay(spec):
    """The datagrams of replay."""
    out = ["  // Datagrams of replay: port, and the header's fields",
           f"  localparam logic [15:0] ReplayPort = 16'd{spec.raw['replay']['port']};",
           f"  localparam logic [15:0] ReplayMagic = 16'h{spec.replay_magic:04X};",
           f"  localparam int ReplayHeaderBytes = {spec.replay_header_bytes};"]
    return out + [f"  localparam int Replay{camel(field['name'])}{what.capitalize()} = {field[what]};"
                  for field in spec.replay_header for what in ("lsb", "bits")]


def sv_package(spec):
    out = []
    emit = out.append
    emit("// Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.")
    emit("// Refer to its names as sp_spec_pkg::Name; the one package of the project.")
    emit("// verilator lint_off UNUSEDPARAM")
    emit("package sp_spec_pkg;")
    emit("")
    emit(f"  localparam logic [31:0] SpecHash = 32'h{spec.hash:08X};")
    emit(f"  localparam logic [15:0] SpecVersion = 16'h{spec.version:04X};")
    emit("")
    for size in spec.raw["sizes"]:
        emit(f"  localparam int {camel(size['name'])} = {size['value']};")
    emit("")
    for item in spec.raw["modes"]:
        emit(f"  localparam logic [1:0] Mode{camel(item['name'])} = 2'd{item['value']};")
    emit(f"  localparam int ModeBits = {max(item['value'] for item in spec.raw['modes']).bit_length()};")
    for item in spec.raw["selects"]:
        emit(f"  localparam logic [0:0] Select{camel(item['name'])} = 1'd{item['value']};")
    emit(f"  localparam int SelectBits = {max(item['value'] for item in spec.raw['selects']).bit_length()};")
    for item in spec.raw["kinds"]:
        emit(f"  localparam logic [7:0] Kind{camel(item['name'])} = 8'd{item['value']};")
    emit("")
    for fmt in spec.raw["formats"]:
        prefix = camel(fmt["name"])
        emit(f"  localparam int {prefix}WordBits = {fmt['word_bits']};")
        for field in fmt["fields"]:
            emit(f"  localparam int {prefix}{camel(field['name'])}Lsb = {field['lsb']};")
            emit(f"  localparam int {prefix}{camel(field['name'])}Bits = {field['bits']};")
    emit("")
    emit(f"  localparam logic [31:0] Magic = 32'h{spec.magic:08X};")
    emit(f"  localparam int HeaderBytes = {spec.header_bytes};")
    emit(f"  localparam int TrailerBytes = {spec.trailer_bytes};")
    emit(f"  localparam int HeaderBits = {8 * spec.header_bytes};")
    emit(f"  localparam int PacketBeatBits = {8 * spec.sizes['packet_beat_bytes']};")
    for part, fields in (("Header", spec.header), ("Trailer", spec.trailer)):
        for field in fields:
            emit(f"  localparam int {part}{camel(field['name'])}Lsb = {field['lsb']};")
            emit(f"  localparam int {part}{camel(field['name'])}Bits = {field['bits']};")
    emit("")
    for item in spec.raw["packet"]["flags"]:
        emit(f"  localparam int Flag{camel(item['name'])}Bit = {item['value']};")
    emit(f"  localparam int FlagBits = {1 + max(i['value'] for i in spec.raw['packet']['flags'])};")
    for item in spec.raw["packet"]["status"]:
        emit(f"  localparam int Status{camel(item['name'])}Bit = {item['value']};")
    emit(f"  localparam int StatusBits = {1 + max(i['value'] for i in spec.raw['packet']['status'])};")
    emit("")
    emit(f"  localparam logic [31:0] CheckInit = 32'h{int(spec.raw['packet']['check']['init'], 16):08X};")
    emit(f"  localparam logic [31:0] CheckPolynomial = 32'h{int(spec.raw['packet']['check']['polynomial'], 16):08X};")
    emit("")
    emit(f"  localparam logic [15:0] DatagramMagic = 16'h{spec.datagram_magic:04X};")
    emit(f"  localparam int DatagramHeaderBytes = {spec.datagram_header_bytes};")
    for field in spec.datagram_header:
        emit(f"  localparam int Datagram{camel(field['name'])}Lsb = {field['lsb']};")
        emit(f"  localparam int Datagram{camel(field['name'])}Bits = {field['bits']};")
    emit("")
    for reg in spec.raw["registers"]:
        emit(f"  localparam logic [7:0] Reg{camel(reg['name'])} = 8'h{reg['offset']:02X};")
        if reg["access"] == "rw":
            emit(f"  localparam logic [31:0] Reg{camel(reg['name'])}Reset = 32'h{reg['reset_value']:08X};")
        for field in reg["fields"]:
            emit(f"  localparam int Reg{camel(reg['name'])}{camel(field['name'])}Lsb = {field['lsb']};")
            emit(f"  localparam int Reg{camel(reg['name'])}{camel(field['name'])}Bits = {field['bits']};")
    emit("  // Words of the address space of the register file, and of the verdict's registers behind it, in which there")
    emit("  // is a register")
    words = sum(1 << reg["offset"] // 4 for reg in spec.raw["registers"])
    for name, part in (("Register", words % (1 << MAIN_WORDS)), ("Verdict", words >> MAIN_WORDS)):
        emit(f"  localparam logic [{MAIN_WORDS - 1}:0] {name}Words = {MAIN_WORDS}'h{part:0{MAIN_WORDS // 4}X};")
    emit("")
    out += sv_link(spec)
    emit("")
    out += sv_replay(spec)
    emit("")
    out += sv_frame_mask()
    emit("")
    emit("endpackage")
    return "\n".join(out) + "\n"


def vhdl_package(verilog):
    """The constants of the SystemVerilog package in VHDL, under the same names."""
    out = ["-- Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.",
           "-- The constants of sp_spec_pkg.sv, for designs and benches in VHDL-2008.", "library ieee;",
           "use ieee.std_logic_1164.all;", "", "package sp_spec_pkg is", ""]
    pattern = r"  localparam (?:int|logic \[(\d+):0\]) (\w+) = (?:\d+'([dh]))?(\w+);"
    for high, name, base, digits in re.findall(pattern, verilog):
        if not base:
            out.append(f"  constant {name} : natural := {digits};")
        else:
            bits = int(high) + 1
            value = f"{int(digits, 16 if base == 'h' else 10):0{bits}b}"
            out.append(f'  constant {name} : std_ulogic_vector({high} downto 0) := "{value}";')
    return "\n".join([*out, "", "end package;"]) + "\n"


def with_table(path, text, name, lines, mark="<!-- {} -->"):
    begin, end = mark.format(f"BEGIN GENERATED {name}"), mark.format(f"END GENERATED {name}")
    if text.count(begin) != 1 or text.count(end) != 1:
        raise SpecError(f"{path}: markers of table '{name}' are missing or doubled")
    head, rest = text.split(begin)
    _, tail = rest.split(end)
    return head + begin + "\n" + "\n".join(lines) + "\n" + end + tail


def outputs(spec):
    files = {HEADER: cpp_header(spec), REGISTERS: register_table.cpp_register_table(spec),
             DATAGRAM: register_table.cpp_datagram(spec), PACKAGE: sv_package(spec)}
    files[VHDL_PACKAGE] = vhdl_package(files[PACKAGE])
    files[REGISTERS_RDL] = system_rdl.system_rdl(spec, LINK_BASE)
    for path, names in TABLES.items():
        text = path.read_text(encoding="utf-8")
        for name in names:
            text = with_table(path, text, name, tables.MAKERS[name](spec))
        files[path] = text
    files[DISSECTOR] = with_table(DISSECTOR, DISSECTOR.read_text(encoding="utf-8"), "format",
                                  lua_format.lua_format(spec), "-- {}")
    return files


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 where a file differs")
    parser.add_argument("--spec", type=pathlib.Path, default=SPEC, help="the specification to read")
    arguments = parser.parse_args()
    try:
        files = outputs(Spec(arguments.spec))
    except (SpecError, OSError, json.JSONDecodeError) as error:
        print(f"generate.py: {arguments.spec}: {error}", file=sys.stderr)
        return 2
    stale = 0
    for path, text in files.items():
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        stale += 1
        if arguments.check:
            print(f"generate.py: {path.relative_to(ROOT)} differs from what {arguments.spec.name} gives; "
                  "run model/spec/generate.py", file=sys.stderr)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    return 1 if stale and arguments.check else 0


if __name__ == "__main__":
    sys.exit(main())
