"""Makes the C++20 headers that only host programs need: registers by name, format of datagrams. For generate.py."""


def text(words):
    return '"' + words.replace("\\", "\\\\").replace('"', '\\"') + '"'


def camel(name):
    return "".join(part.capitalize() for part in name.split("_"))


def cpp_register_table(spec):
    registers = spec.raw["registers"]
    out = ["// Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.",
           "#ifndef SELFPROJ_SPEC_GENERATED_REGISTER_TABLE_H",
           "#define SELFPROJ_SPEC_GENERATED_REGISTER_TABLE_H",
           "",
           "#include <array>",
           "#include <cstdint>",
           "#include <span>",
           "#include <string_view>",
           "",
           "namespace selfproj::spec {",
           "",
           "struct RegisterField {",
           "  std::string_view name;",
           "  int lsb = 0;",
           "  int bits = 0;",
           "  std::string_view description;",
           "",
           "  // Its bits in the register's word.",
           "  [[nodiscard]] constexpr std::uint32_t mask() const {",
           "    return static_cast<std::uint32_t>(((std::uint64_t{1} << bits) - 1) << lsb);",
           "  }",
           "};",
           "",
           "struct Register {",
           "  std::string_view name;",
           "  std::uint32_t address = 0;  // bytes",
           "  bool writable = false;",
           "  bool setting = false;  // takes effect at a frame start",
           "  std::uint32_t reset = 0;",
           "  std::string_view description;",
           "  std::span<const RegisterField> fields;",
           "",
           "  // The bits of all fields.",
           "  [[nodiscard]] constexpr std::uint32_t mask() const {",
           "    std::uint32_t bits = 0;",
           "    for (const RegisterField& field : fields) {",
           "      bits |= field.mask();",
           "    }",
           "    return bits;",
           "  }",
           "};",
           ""]
    for reg in registers:
        fields = reg["fields"]
        out.append(f"inline constexpr std::array<RegisterField, {len(fields)}> kFieldsOf{camel(reg['name'])}{{{{")
        for field in fields:
            out.append(f"    {{{text(field['name'])}, {field['lsb']}, {field['bits']}, {text(field['description'])}}},")
        out.append("}};")
    out += ["", "// In the order of their addresses.",
            f"inline constexpr std::array<Register, {len(registers)}> kRegisters{{{{"]
    for reg in sorted(registers, key=lambda one: one["offset"]):
        flags = ", ".join("true" if flag else "false" for flag in (reg["access"] == "rw", reg.get("setting", False)))
        out.append(f"    {{{text(reg['name'])}, 0x{reg['offset']:02X}, {flags}, 0x{reg['reset_value']:08X}U,"
                   f" {text(reg['description'])}, kFieldsOf{camel(reg['name'])}}},")
    out += ["}};", "", "// The registers of the link, for boards on the network."]
    for reg in spec.raw["link"]["registers"]:
        name = f"kLink{camel(reg['name'])}"
        out.append(f"inline constexpr std::uint32_t {name} = 0x{reg['offset']:X};  // {reg['access']}")
        if reg["access"] == "ro":
            out.append(f"inline constexpr std::uint32_t {name}Reset = 0x{reg['reset_value']:08X}U;")
        for field in reg["fields"]:
            out.append(f"inline constexpr int {name}{camel(field['name'])}Lsb = {field['lsb']};")
            out.append(f"inline constexpr int {name}{camel(field['name'])}Bits = {field['bits']};")
    out += ["", "// Where the frames come from: values of the register source."]
    out += [f"inline constexpr std::uint32_t kSource{camel(item['name'])} = {item['value']};  // {item['description']}"
            for item in spec.raw["link"]["sources"]]
    out += ["", "}  // namespace selfproj::spec", "", "#endif  // SELFPROJ_SPEC_GENERATED_REGISTER_TABLE_H"]
    return "\n".join(out) + "\n"


def header_offsets(prefix, fields):
    out = []
    for field in fields:
        name = "MagicAt" if field["name"] == "magic" else camel(field["name"])
        out.append(f"inline constexpr std::size_t k{prefix}{name} = {field['lsb'] // 8};  // {field['bits']} bits")
    return out


def cpp_datagram(spec):
    datagram, replay = spec.raw["datagram"], spec.raw["replay"]
    out = ["// Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.",
           "#ifndef SELFPROJ_SPEC_GENERATED_DATAGRAM_FORMAT_H",
           "#define SELFPROJ_SPEC_GENERATED_DATAGRAM_FORMAT_H",
           "",
           "#include <cstddef>",
           "#include <cstdint>",
           "",
           "namespace selfproj::spec {",
           "",
           "// Byte offsets in the header of a datagram; docs/packet-reference.md says what the fields mean.",
           f'inline constexpr std::uint16_t kDatagramMagic = 0x{spec.datagram_magic:04X};  // "{datagram["magic"]}"',
           f"inline constexpr std::size_t kDatagramHeaderBytes = {spec.datagram_header_bytes};"]
    out += header_offsets("Datagram", spec.datagram_header)
    out += ["", "// The same for the datagrams of replay, and the port at which boards receive them.",
            f"inline constexpr std::uint16_t kReplayPort = {replay['port']};",
            f'inline constexpr std::uint16_t kReplayMagic = 0x{spec.replay_magic:04X};  // "{replay["magic"]}"',
            f"inline constexpr std::size_t kReplayHeaderBytes = {spec.replay_header_bytes};"]
    out += header_offsets("Replay", spec.replay_header)
    return "\n".join(out + ["", "}  // namespace selfproj::spec", "",
                            "#endif  // SELFPROJ_SPEC_GENERATED_DATAGRAM_FORMAT_H"]) + "\n"
