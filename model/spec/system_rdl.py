"""Makes the registers as SystemRDL 2.0, for those who put a board into a system of their own. For generate.py.

selfproj_board has the registers of sp_board, at its AXI4-Lite port. selfproj_link has those that sp_link adds, and
selfproj_network is what the network sees: both.
"""

# Words that are no names in SystemRDL, among those that a register or a field might be called
RESERVED = {"abstract", "all", "alias", "bit", "compact", "default", "encode", "enum", "external", "field", "internal", "level",
            "longint", "mem", "number", "property", "r", "ref", "reg", "regfile", "rw", "signal", "string", "struct",
            "this", "type", "unsigned", "w"}


def name_of(word):
    return "\\" + word if word in RESERVED else word


def text(words):
    return '"' + words.replace("\\", "\\\\").replace('"', '\\"') + '"'


def register(reg, base):
    # What is known only of a build, or of a board that runs, has no reset value.
    known = reg["access"] == "rw" or reg["reset"] not in ("0", 0)
    access = "sw = rw; hw = r;" if reg["access"] == "rw" else "sw = r; hw = w;"
    out = ["  reg {", f"    name = {text(reg['name'])};"]
    if "description" in reg:
        out.append(f"    desc = {text(reg['description'])};")
    out.append(f"    default {access.replace('; hw', '; default hw')}")
    for field in reg["fields"]:
        reset = reg["reset_value"] >> field["lsb"] & (1 << field["bits"]) - 1
        value = f" = {field['bits']}'h{reset:X}" if known else ""
        out += ["    field {", f"      desc = {text(field['description'])};",
                f"    }} {name_of(field['name'])}[{field['lsb'] + field['bits'] - 1}:{field['lsb']}]{value};"]
    return out + [f"  }} {name_of(reg['name'])} @ 0x{reg['offset'] - base:X};"]


def address_map(name, title, registers, base):
    out = ["", f"addrmap {name} {{", f"  name = {text(title)};", "  default regwidth = 32;",
           "  default accesswidth = 32;", "  littleendian;"]
    for reg in sorted(registers, key=lambda one: one["offset"]):
        out += register(reg, base)
    return out + ["};"]


def system_rdl(spec, link_base):
    out = ["// Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.",
           f"// Specification version {spec.version >> 8}.{spec.version & 255}, hash 0x{spec.hash:08X}."]
    out += address_map("selfproj_board", "Registers of sp_board", spec.raw["registers"], 0)
    out += address_map("selfproj_link", "Registers of sp_link", spec.raw["link"]["registers"], link_base)
    out += ["", "addrmap selfproj_network {", '  name = "Registers of a board on the network";', "  littleendian;",
            "  selfproj_board board @ 0x0;", f"  selfproj_link link @ 0x{link_base:X};", "};"]
    return "\n".join(out) + "\n"
