-- Dissector for Wireshark and tshark: the datagrams of a board on the network, and the packets in them.
--
--   tshark -X lua_script:selfproj.lua -r capture.pcapng -V
--
-- Wireshark reads it at its start from the folder for personal plugins (Help, About, Folders). Datagrams are known by
-- their magic and length at any UDP port. Packets that come in several datagrams are put together from the pieces that
-- are in the capture; pieces out of order and doubled ones are taken, as the driver takes them.
--
-- The format between the markers follows from model/spec/selfproj.json; docs/packet-reference.md says what it means.

-- BEGIN GENERATED format
local format = {
  datagram_magic = 0x4C53,
  beat_bytes = 16,
  header_bytes = 64,
  trailer_bytes = 16,
  datagram_header_bytes = 16,
  check = {init = 0xFFFFFFFF, polynomial = 0x04C11DB7},
  versions = {[0x08691C00] = "1.0", [0xA3603834] = "1.1", [0x1A81A4C9] = "2.0"},
  datagram = {
    {"magic", 0, 16, "the letters SL, S first"},
    {"session", 2, 16, "number that tells this run of the sender from the one before; its counts begin at 0"},
    {"sequence", 4, 32, "datagrams sent before this one in the session; wraps"},
    {"packet", 8, 32, "packets of the session before this one; wraps"},
    {"offset", 12, 16, "first byte of the packet that this datagram holds, a multiple of 16"},
    {"length", 14, 16,
      "bytes of the packet that follow, a multiple of 16; 0: the sender is idle, and `packet` is the number of " ..
      "the next packet"},
  },
  header = {
    {"magic", 0, 32, "the letters SLFP, S first"},
    {"spec_hash", 4, 32, "hash of the specification that the board was built from"},
    {"version", 8, 16, "version of that specification, the major number in 15..8"},
    {"kind", 10, 8, "what the payload holds: see the kinds below"},
    {"stream", 11, 8, "stream number, 0..255, a setting: tells the cameras of a host apart"},
    {"pattern", 12, 16, "index of the projected pattern, from 0"},
    {"mode", 14, 8, "mode of the moments: see the modes below"},
    {"threshold", 15, 8,
      "threshold of the moments, bits 7..0, with those of pixel above them: a pixel is lit where it is greater"},
    {"sequence", 16, 64, "number of the frame, from 0: the frame starts accepted before it since reset"},
    {"time_stamp", 24, 64,
      "edges of the pixel clock after reset that come before the edge that takes the frame's first beat"},
    {"encoder", 32, 32, "encoder count at the frame's first beat, in two's complement"},
    {"lost", 36, 32, "packets of this kind that the board has lost since reset; wraps"},
    {"columns", 40, 16, "columns of the frame, a multiple of 4"},
    {"rows", 42, 16, "rows of the frame"},
    {"payload_size", 44, 32,
      "bytes of payload, with the zeros that fill it up to a multiple of 16; 0 for a frame that broke before its " ..
      "last row began"},
    {"first_line", 48, 16, "first image line that the payload covers, from 1; moments: 1"},
    {"lines", 50, 16,
      "image lines that the payload covers; moments: the rows of the frame, in an empty packet too; codes and " ..
      "image: 1"},
    {"flags", 52, 8, "see the flags below"},
    {"select", 53, 8, "what of a column the moments are taken of: see the selects below"},
    {"first_row", 54, 16, "first row that counts for the moments, from 1; 0: the first"},
    {"last_row", 56, 16, "last row that counts for the moments, from 1; 0: the last"},
    {"gap", 58, 8, "dark rows, 0..3, that two lit pixels of one run may have between them"},
    {"pixel", 59, 8, "pixels of more than 8 bits: see the word header_pixel; 0: pixels have 8"},
    {"region_row", 60, 16, "row of the sensor, from 1, at which the frame begins, a setting; 0: it is not said"},
    {"region_column", 62, 16,
      "column of the sensor, from 1, at which the frame begins, a setting; 0: it is not said"},
  },
  trailer = {
    {"sequence", 0, 64, "the sequence of the header again"},
    {"status", 8, 32, "0: the frame is good; else the status bits below"},
    {"check", 12, 32, "check word over the header, the payload and the first 12 bytes of the trailer"},
  },
  kinds = {[1] = "moments", [2] = "codes", [3] = "image", [4] = "compact", [5] = "verdict"},
  modes = {[0] = "binary", [1] = "grey", [2] = "grey_over"},
  selects = {[0] = "all", [1] = "strongest"},
  flags = {
    {"stray_before", 0, "beats that belonged to no frame were discarded before this frame"},
    {"verdict", 1, "the payload ends with 16 bytes more, the verdict of the frame"},
  },
  status = {
    {"short_line", 0, "a line ended before its last column"},
    {"long_line", 1, "a line went on after its last column"},
    {"start_in_frame", 2, "the next frame started before this one was complete"},
    {"late_memory", 3, "the memory of the Gray-code decoder answered too late"},
    {"incomplete", 4, "no beat came for the time set in the register timeout"},
  },
  words = {
    binary = {bits = 32, fields = {
      {"m1", 0, 20, "1st moment, rows counted from 1"},
      {"m0", 20, 12, "0th moment, which is also the number of lit pixels"},
    }},
    grey = {bits = 64, fields = {
      {"m1", 0, 27, "1st moment, rows counted from 1"},
      {"m0", 27, 18, "0th moment"},
      {"n", 45, 10, "number of lit pixels"},
    }},
    binary_run = {bits = 32, fields = {
      {"m1", 0, 19, "1st moment of the strongest run, rows counted from 1"},
      {"second", 19, 1,
        "1: the second run has at least half the 0th moment of the strongest; 0: less, or there is one run at " ..
        "most"},
      {"m0", 20, 10, "0th moment of the strongest run, which is also the number of its lit pixels"},
      {"runs", 30, 2, "runs of the column; 3: three or more"},
    }},
    grey_run = {bits = 64, fields = {
      {"m1", 0, 27, "1st moment of the strongest run, rows counted from 1"},
      {"m0", 27, 18, "0th moment of the strongest run"},
      {"n", 45, 10, "number of its lit pixels"},
      {"runs", 55, 2, "runs of the column; 3: three or more"},
      {"second", 57, 5,
        "floor(16 M0 of the second run / M0 of the strongest), 16 where they are equal; 0 where there is one run " ..
        "at most"},
    }},
    code = {bits = 16, fields = {
      {"code", 0, 12, "space code, from 0"},
      {"measurable", 15, 1, "1: at most one bit plane is ambiguous; 0: do not use the code"},
    }},
    tall_binary = {bits = 32, fields = {
      {"m1", 0, 21, "1st moment"},
      {"m0", 21, 11,
        "0th moment, which is also the number of lit pixels; with select strongest those of the strongest run, " ..
        "and nothing of the others"},
    }},
    wide_grey = {bits = 64, fields = {
      {"m1", 0, 31, "1st moment"},
      {"m0", 31, 22, "0th moment"},
      {"n", 53, 11, "number of lit pixels"},
    }},
    wide_grey_run = {bits = 64, fields = {
      {"m1", 0, 31, "1st moment of the strongest run, rows counted from 1"},
      {"m0", 31, 22, "0th moment of the strongest run"},
      {"n", 53, 6, "number of its lit pixels; 63: as many or more"},
      {"second", 59, 5,
        "floor(16 M0 of the second run / M0 of the strongest), 16 where they are equal; 0 where there is one run " ..
        "at most"},
    }},
    tall_grey = {bits = 64, fields = {
      {"m1", 0, 31, "1st moment; these are the words wide_grey and wide_grey_run, which fit more rows as well"},
      {"m0", 31, 22, "0th moment"},
      {"n", 53, 11, "number of lit pixels"},
    }},
    header_pixel = {bits = 8, fields = {
      {"threshold_high", 0, 4, "bits 11..8 of the threshold"},
      {"more_bits", 4, 3, "bits of a pixel, less 8; images and codes are of the upper eight bits"},
      {"tall", 7, 1,
        "1: words of columns are those of a build for more than 1,023 rows: tall_binary, wide_grey and " ..
        "wide_grey_run"},
    }},
    compact = {bits = 32, fields = {
      {"centroid", 0, 20, "M1 / M0 in 1/512 rows, rounded to the nearest, halves up; 0: no light"},
      {"n", 20, 6, "number of lit pixels; 63: as many or more"},
      {"quality", 26, 6,
        "select strongest: runs in 5..4, second in 3..0, 15 there for 15 or 16; select all: floor(64 M0 / (256 " ..
        "N)), the mean weight of a lit pixel in 1/64 of 256; pixels of more bits: 2^bits for 256; these, and " ..
        "builds for more than 1,023 rows: runs 1, or 2 where second is not 0"},
    }},
    verdict = {bits = 128, fields = {
      {"first_column", 0, 13, "first column of the leftmost defect, from 1; 0 without one"},
      {"columns", 16, 13, "columns of that defect"},
      {"unlit", 32, 13, "judged columns without light"},
      {"judged", 72, 1, "1: this is a verdict"},
      {"in_part", 73, 1,
        "1: the frame lies in a part; else section, part and bank are those of the part before, 0 before the " ..
        "first"},
      {"defect", 74, 1, "1: it has a defect"},
      {"lacks_light", 75, 1, "1: too many judged columns are unlit"},
      {"bank", 76, 1, "bank of limits in force"},
      {"section", 80, 6, "section of the part, from 0"},
      {"part", 96, 16, "number of the part, from 1: parts that have begun since reset; wraps"},
    }},
  },
}
-- END GENERATED format

local protocol = Proto("selfproj", "selfproj packets")
local fields = {}

-- ---- the fields ----

local INTEGERS = {[8] = ftypes.UINT8, [16] = ftypes.UINT16, [32] = ftypes.UINT32, [64] = ftypes.UINT64}
local IN_HEX = {magic = true, spec_hash = true, check = true, session = true, flags = true, status = true}
local NAMES = {kind = format.kinds, mode = format.modes, select = format.selects, spec_hash = format.versions}

local function keep(key, field)
  fields[key] = field
  protocol.fields[#protocol.fields + 1] = field
end

-- The fields of a table that lies byte by byte, with `prefix` in their filter names.
local function declare(prefix, items)
  for _, item in ipairs(items) do
    local name, bits, description = item[1], item[3], item[4]
    local key = prefix .. name
    local kind = INTEGERS[bits]
    if name == "encoder" then
      kind = ftypes.INT32
    end
    if kind then
      keep(key, ProtoField.new(name, key, kind, NAMES[name], IN_HEX[name] and base.HEX or base.DEC, nil, description))
    else
      keep(key, ProtoField.new(name, key, ftypes.BYTES, nil, base.NONE, nil, description))
    end
  end
end

local function declare_bits(prefix, items, width)
  for _, item in ipairs(items) do
    keep(prefix .. item[1], ProtoField.bool(prefix .. item[1], item[1], width, nil, 2 ^ item[2], item[3]))
  end
end

declare("selfproj.datagram.", format.datagram)
declare("selfproj.", format.header)
declare("selfproj.trailer.", format.trailer)
declare_bits("selfproj.flags.", format.flags, 8)
declare_bits("selfproj.status.", format.status, 32)
for name, word in pairs(format.words) do
  for _, item in ipairs(word.fields) do
    local key = "selfproj." .. name .. "." .. item[1]
    keep(key, ProtoField.new(item[1], key, ftypes.UINT32, nil, base.DEC, nil, item[4]))
  end
end
keep("selfproj.pixels", ProtoField.bytes("selfproj.pixels", "pixels"))

local missing = ProtoExpert.new("selfproj.missing", "Datagrams are missing before this one", expert.group.SEQUENCE,
  expert.severity.WARN)
local doubled = ProtoExpert.new("selfproj.doubled", "This piece was there before", expert.group.SEQUENCE,
  expert.severity.NOTE)
local bad_check = ProtoExpert.new("selfproj.bad_check", "The check word is wrong", expert.group.CHECKSUM,
  expert.severity.ERROR)
local broken_frame = ProtoExpert.new("selfproj.broken_frame", "The frame is broken", expert.group.RESPONSE_CODE,
  expert.severity.NOTE)
protocol.experts = {missing, doubled, bad_check, broken_frame}

-- ---- values out of bytes ----

local bits = bit32 or bit

-- Byte position of a field in its table.
local function byte_of(items, name)
  for _, item in ipairs(items) do
    if item[1] == name then
      return item[2]
    end
  end
end

local function number(buffer, items, name)
  for _, item in ipairs(items) do
    if item[1] == name then
      return buffer(item[2], item[3] / 8):le_uint()
    end
  end
end

-- `count` bits from bit `lsb` on of a word of up to 64 bits at byte `at`, as a number.
local function bits_at(buffer, at, lsb, count)
  local value = 0
  local scale = 1
  local bit_at = lsb
  while bit_at < lsb + count do
    local in_byte = bit_at % 8
    local taken = math.min(8 - in_byte, lsb + count - bit_at)
    local byte = buffer(at + math.floor(bit_at / 8), 1):uint()
    value = value + math.floor(byte / 2 ^ in_byte) % 2 ^ taken * scale
    scale = scale * 2 ^ taken
    bit_at = bit_at + taken
  end
  return value
end

local function rotated(word, by)
  return bits.bor(bits.lshift(word, by), bits.rshift(word, 32 - by))
end

-- Whether the check word is that of the bytes before it.
local function check_holds(buffer)
  local size = buffer:len()
  local c = format.check.init
  for at = 0, size - format.beat_bytes, format.beat_bytes do
    local w = {}
    for i = 0, 3 do
      w[i] = buffer(at + 4 * i, 4):le_uint()
    end
    if at + format.beat_bytes == size then
      w[3] = 0
    end
    local carry = bits.rshift(c, 31) ~= 0
    c = bits.lshift(c, 1)
    if carry then
      c = bits.bxor(c, format.check.polynomial)
    end
    c = bits.bxor(c, w[0], rotated(w[1], 8), rotated(w[2], 16), rotated(w[3], 24))
  end
  return bits.bxor(c, buffer(size - 4, 4):le_uint()) == 0
end

-- ---- packets ----

-- Adds the fields of a table that lies at byte `at`.
local function add_fields(tree, prefix, items, buffer, at)
  local added = {}
  for _, item in ipairs(items) do
    local range = buffer(at + item[2], item[3] / 8)
    added[item[1]] = INTEGERS[item[3]] and tree:add_le(fields[prefix .. item[1]], range)
      or tree:add(fields[prefix .. item[1]], range)
  end
  return added
end

local function add_bits(tree, prefix, items, range)
  for _, item in ipairs(items) do
    tree:add_le(fields[prefix .. item[1]], range)
  end
end

-- The word that a packet's payload consists of; nil for pixels.
local function word_of(buffer)
  local kind = format.kinds[number(buffer, format.header, "kind")]
  if kind == "moments" then
    local run = format.selects[number(buffer, format.header, "select")] == "strongest" and "_run" or ""
    local pixel = number(buffer, format.header, "pixel")
    if format.modes[number(buffer, format.header, "mode")] ~= "binary" then
      return (pixel ~= 0 and "wide_grey" or "grey") .. run
    end
    return pixel >= 128 and "tall_binary" or "binary" .. run  -- bit 7: words of more than 1,023 rows
  end
  return (kind == "codes" and "code") or (kind == "compact" and "compact") or nil
end

local function add_payload(tree, buffer, size)
  local columns = number(buffer, format.header, "columns")
  local payload = buffer(format.header_bytes, size)
  local name = word_of(buffer)
  if not name then
    tree:add(fields["selfproj.pixels"], buffer(format.header_bytes, math.min(columns, size)))
    return
  end
  local word = format.words[name]
  local bytes = word.bits / 8
  local branch = tree:add(payload, string.format("Columns: %d words of %d bits, %s", columns, word.bits, name))
  for column = 0, math.min(columns, math.floor(size / bytes)) - 1 do
    local at = format.header_bytes + column * bytes
    local range = buffer(at, bytes)
    local of_column = branch:add(range, "Column " .. column)
    for _, item in ipairs(word.fields) do
      local value = bits_at(buffer, at, item[2], item[3])
      of_column:add(fields["selfproj." .. name .. "." .. item[1]], range, value)
      of_column:append_text(string.format(", %s %d", item[1], value))
    end
  end
end

-- The header at the begin of `buffer`; returns a description.
local function add_header(tree, buffer)
  local added = add_fields(tree, "selfproj.", format.header, buffer, 0)
  add_bits(added.flags, "selfproj.flags.", format.flags, buffer(byte_of(format.header, "flags"), 1))
  local pixel = byte_of(format.header, "pixel")
  for _, item in ipairs(format.words.header_pixel.fields) do
    added.pixel:add(fields["selfproj.header_pixel." .. item[1]], buffer(pixel, 1),
      bits_at(buffer, pixel, item[2], item[3]))
  end
  return string.format("%s of frame %s, %d x %d", format.kinds[number(buffer, format.header, "kind")] or "?",
    tostring(buffer(byte_of(format.header, "sequence"), 8):le_uint64()), number(buffer, format.header, "columns"),
    number(buffer, format.header, "rows"))
end

-- A whole packet; returns a description.
local function add_packet(tree, buffer)
  local branch = tree:add(protocol, buffer(), "Packet of selfproj")
  local text = add_header(branch, buffer)
  local size = number(buffer, format.header, "payload_size")
  if size > 0 then
    add_payload(branch, buffer, size)
  end
  local at = format.header_bytes + size
  local trailer = branch:add(buffer(at), "Trailer")
  local added = add_fields(trailer, "selfproj.trailer.", format.trailer, buffer, at)
  local status = buffer(at + byte_of(format.trailer, "status"), 4)
  add_bits(added.status, "selfproj.status.", format.status, status)
  if status:le_uint() ~= 0 then
    added.status:add_proto_expert_info(broken_frame)
    text = text .. ", broken"
  end
  if bits and not check_holds(buffer) then
    added.check:add_proto_expert_info(bad_check)
    text = text .. ", bad check word"
  end
  branch:append_text(": " .. text)
  return text
end

-- ---- datagrams ----

local pieces = {}  -- of packets that are not whole: pieces[sender and packet][offset]
local whole = {}   -- whole[frame of the capture]: the bytes of the packet that this frame has completed
local newest = {}  -- newest[sender]: the number of the datagram that is expected next
local seen = {}    -- seen[frame of the capture]: the datagrams missing before it; whether it is doubled

function protocol.init()
  pieces, whole, newest, seen = {}, {}, {}, {}
end

-- The packet whose pieces lie without a gap from byte 0 to its end; nil if there is none.
local function joined(of_packet)
  local bytes = ByteArray.new()
  while of_packet[bytes:len()] do
    bytes:append(of_packet[bytes:len()])
  end
  if bytes:len() < format.header_bytes then
    return nil
  end
  local payload = 0
  for i = 3, 0, -1 do
    payload = payload * 256 + bytes:get_index(byte_of(format.header, "payload_size") + i)
  end
  return bytes:len() == format.header_bytes + payload + format.trailer_bytes and bytes or nil
end

-- Notes a datagram when it is looked at for the first time: what is missing, and the packet that it completes.
local function note(buffer, frame, sender, datagram)
  local expected = newest[sender]
  local ahead = expected and (datagram.sequence - expected) % 2 ^ 32 or 0
  local late = ahead >= 2 ^ 31
  seen[frame] = {missing = late and 0 or ahead, doubled = false}
  if not late then
    newest[sender] = (datagram.sequence + 1) % 2 ^ 32
  end
  if datagram.length == 0 then
    return
  end
  local key = sender .. " " .. datagram.packet
  pieces[key] = pieces[key] or {}
  if pieces[key] == "whole" or pieces[key][datagram.offset] then
    seen[frame].doubled = true
    return
  end
  pieces[key][datagram.offset] = buffer(format.datagram_header_bytes, datagram.length):bytes()
  local packet = joined(pieces[key])
  if packet then
    whole[frame] = packet
    pieces[key] = "whole"
  end
end

local function is_datagram(buffer)
  if buffer:len() < format.datagram_header_bytes or
    number(buffer, format.datagram, "magic") ~= format.datagram_magic then
    return false
  end
  local length = number(buffer, format.datagram, "length")
  local rest = buffer:len() - format.datagram_header_bytes
  return length % format.beat_bytes == 0 and number(buffer, format.datagram, "offset") % format.beat_bytes == 0 and
    (length == rest or length == 0 and rest <= format.beat_bytes)
end

function protocol.dissector(buffer, pinfo, tree)
  if not is_datagram(buffer) then
    return 0
  end
  local datagram = {}
  for _, name in ipairs({"session", "sequence", "packet", "offset", "length"}) do
    datagram[name] = number(buffer, format.datagram, name)
  end
  if not pinfo.visited then
    local sender = string.format("%s:%d %d", tostring(pinfo.src), pinfo.src_port, datagram.session)
    note(buffer, pinfo.number, sender, datagram)
  end
  pinfo.cols.protocol = "selfproj"
  local branch = tree:add(protocol, buffer(), string.format("Datagram of selfproj, packet %d", datagram.packet))
  local added = add_fields(branch, "selfproj.datagram.", format.datagram, buffer, 0)
  local before = seen[pinfo.number] or {missing = 0}
  if before.missing > 0 then
    added.sequence:add_proto_expert_info(missing, ("Datagrams missing before this one: %d"):format(before.missing))
  end
  if before.doubled then
    added.offset:add_proto_expert_info(doubled)
  end
  local text
  if whole[pinfo.number] then
    text = add_packet(tree, whole[pinfo.number]:tvb("Packet"))
  elseif datagram.length == 0 then
    text = string.format("idle, next packet %d", datagram.packet)
  elseif datagram.offset == 0 and datagram.length >= format.header_bytes then
    local header = branch:add(buffer(format.datagram_header_bytes, format.header_bytes), "Header of the packet")
    text = "begin of " .. add_header(header, buffer(format.datagram_header_bytes, format.header_bytes):tvb())
  else
    text = string.format("%d bytes of packet %d from byte %d on", datagram.length, datagram.packet, datagram.offset)
  end
  pinfo.cols.info = text
  return buffer:len()
end

protocol:register_heuristic("udp", function(buffer, pinfo, tree)
  return protocol.dissector(buffer, pinfo, tree) > 0
end)
