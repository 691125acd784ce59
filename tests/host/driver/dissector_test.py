#!/usr/bin/env python3
"""dissector_test.py SELFPROJ_SIM: what tshark shows of datagrams with host/driver/selfproj.lua.

Captures are made of packets of every kind by the tables of docs/packet-reference.md, and of datagrams that the
simulated board sends. Pieces are lost, doubled and out of order. Every value that tshark shows is compared. Exit
status 77: tshark is not installed.
"""

import os
import pathlib
import random
import shutil
import socket
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
SCRIPT = ROOT / "host" / "driver" / "selfproj.lua"
HEADER = struct.Struct("<4sIHBBHBBQQiIHHIHHBBHHBBHH")
MOST = 1456  # bytes of a packet in a datagram

# Bits of the words, lowest first; None: bits that belong to no field.
WORDS = {
    ("moments", "binary", "all"): ("binary", 32, [("m1", 20), ("m0", 12)]),
    ("moments", "grey", "all"): ("grey", 64, [("m1", 27), ("m0", 18), ("n", 10)]),
    ("moments", "grey", "wide"): ("wide_grey", 64, [("m1", 31), ("m0", 22), ("n", 11)]),  # pixels of more than 8 bits
    ("moments", "grey", "wide strongest"): ("wide_grey_run", 64, [("m1", 31), ("m0", 22), ("n", 6), ("second", 5)]),
    ("moments", "binary", "tall"): ("tall_binary", 32, [("m1", 21), ("m0", 11)]),  # of a build for more than 1,023 rows
    ("moments", "grey", "tall"): ("wide_grey", 64, [("m1", 31), ("m0", 22), ("n", 11)]),
    ("moments", "binary", "tall strongest"): ("tall_binary", 32, [("m1", 21), ("m0", 11)]),
    ("moments", "binary", "strongest"): ("binary_run", 32, [("m1", 19), ("second", 1), ("m0", 10), ("runs", 2)]),
    ("moments", "grey", "strongest"): ("grey_run", 64, [("m1", 27), ("m0", 18), ("n", 10), ("runs", 2),
                                                        ("second", 5)]),
    ("compact", "grey", "all"): ("compact", 32, [("centroid", 20), ("n", 6), ("quality", 6)]),
    ("compact", "grey", "strongest"): ("compact", 32, [("centroid", 20), ("n", 6), ("quality", 6)]),
    ("codes", "binary", "all"): ("code", 16, [("code", 12), (None, 3), ("measurable", 1)]),
}
KINDS = {"moments": 1, "codes": 2, "image": 3, "compact": 4}
MODES = {"binary": 0, "grey": 1, "grey_over": 2}


def rotated(word, by):
    return (word << by | word >> (32 - by)) & 0xFFFFFFFF


def check_word(data):
    c = 0xFFFFFFFF
    for w0, w1, w2, w3 in struct.iter_unpack("<4I", data + bytes(4)):
        c = (c << 1) & 0xFFFFFFFF ^ (0x04C11DB7 if c >> 31 else 0)
        c ^= w0 ^ rotated(w1, 8) ^ rotated(w2, 16) ^ rotated(w3, 24)
    return c


def packet(r, spec_hash, kind, mode, select, columns, good_check=True):
    """A packet of random values: its bytes, and what tshark has to show of it, by name of the field."""
    word = WORDS.get((kind, "grey" if mode == "grey_over" else mode, select))
    shown = {}
    payload = b""
    if word:
        name, bits, items = word
        for _ in range(columns):
            value = lsb = 0
            for item, width in items:
                drawn = r.getrandbits(width) if item else 0
                value |= drawn << lsb
                lsb += width
                if item:
                    shown.setdefault(f"selfproj.{name}.{item}", []).append(str(drawn))
            payload += value.to_bytes(bits // 8, "little")
    else:
        payload = r.randbytes(columns)
        shown["selfproj.pixels"] = [payload.hex()]
    payload += bytes(-len(payload) % 16)
    status = r.choice([0, 1, 16])
    more_bits, threshold_high = (r.randint(1, 4), r.getrandbits(4)) if "wide" in select else (0, 0)
    tall = int("tall" in select)
    of_header = {"version": 0x0200, "kind": KINDS[kind], "stream": r.getrandbits(8), "pattern": r.getrandbits(16),
                 "mode": MODES[mode], "threshold": r.getrandbits(8), "sequence": r.getrandbits(64),
                 "time_stamp": r.getrandbits(64), "encoder": r.getrandbits(32) - (1 << 31), "lost": r.getrandbits(32),
                 "columns": columns, "rows": 96, "payload_size": len(payload), "first_line": 1, "lines": 1,
                 "flags": r.getrandbits(1), "select": int("strongest" in select), "first_row": 3, "last_row": 90,
                 "gap": r.randrange(4), "pixel": tall << 7 | more_bits << 4 | threshold_high,
                 "region_row": r.getrandbits(16), "region_column": r.getrandbits(16)}
    shown |= {"selfproj." + key: [str(value)] for key, value in of_header.items() if key != "flags"}
    shown["selfproj.flags.stray_before"] = [str(of_header["flags"])]
    shown["selfproj.header_pixel.more_bits"] = [str(more_bits)]
    shown["selfproj.header_pixel.tall"] = [str(tall)]
    shown["selfproj.header_pixel.threshold_high"] = [str(threshold_high)]
    shown["selfproj.status.short_line"] = [str(status & 1)]
    shown["selfproj.status.incomplete"] = [str(status >> 4)]
    shown["selfproj.bad_check"] = [] if good_check else ["1"]
    data = HEADER.pack(b"SLFP", spec_hash, *of_header.values()) + payload
    data += struct.pack("<QI", of_header["sequence"], status)
    return data + struct.pack("<I", check_word(data) ^ (0 if good_check else 1 << r.randrange(32))), shown


def datagrams(data, number, session, first):
    pieces = [data[at:at + MOST] for at in range(0, len(data), MOST)]
    return [struct.pack("<2sHIIHH", b"SL", session, first + i, number, i * MOST, len(piece)) + piece
            for i, piece in enumerate(pieces)]


def write_capture(path, payloads):
    """A capture of raw IP packets from 10.0.0.2, port 1235."""
    with path.open("wb") as file:
        file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 101))
        for i, payload in enumerate(payloads):
            udp = struct.pack(">HHHH", 1235, 40000, 8 + len(payload), 0) + payload
            ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), i & 0xFFFF, 0, 64, 17, 0, bytes([10, 0, 0, 2]),
                             bytes([10, 0, 0, 1])) + udp
            file.write(struct.pack("<IIII", i, 0, len(ip), len(ip)) + ip)


def shown_by_tshark(path, names):
    """Of each frame of the capture: the values of the fields, as lists of words."""
    # Wireshark 4.4 runs no script for root, so another user runs it, in a folder that is open to all.
    folder = path.parent
    folder.chmod(0o755)
    command = ["tshark", "-X", f"lua_script:{shutil.copy(SCRIPT, folder)}", "-r", str(path), "-T", "fields", "-E", "separator=/t",
               "-E", "aggregator=;"]
    done = subprocess.run(command + [word for name in names for word in ("-e", name)], capture_output=True, text=True,
                          check=True, env={**os.environ, "HOME": str(folder)},
                          **({"user": "nobody", "group": "nogroup", "extra_groups": []} if os.geteuid() == 0 else {}))
    assert "Lua" not in done.stderr, done.stderr
    rows = [line.split("\t") for line in done.stdout.splitlines()]
    return [{name: cell.split(";") if cell else [] for name, cell in zip(names, row)} for row in rows]


def agree(shown, wanted):
    for name, values in wanted.items():
        seen = [{"True": "1", "False": "0"}.get(value, value) for value in shown[name]]
        assert seen == values, f"{name}: {seen[:9]} instead of {values[:9]}"


def every_kind(folder, r, spec_hash):
    """Each packet appears whole in the frame that completes it, whatever the order of its pieces."""
    wanted = {}  # frame of the capture: what it shows
    payloads, sent = [], 0
    for number in range(60):
        kind, mode, select = r.choice([*WORDS, ("moments", "grey_over", "all"), ("image", "grey", "all")])
        data, shown = packet(r, spec_hash, kind, mode, select, 4 * r.randint(1, 512), good_check=r.random() < 0.8)
        pieces = datagrams(data, number, 7, sent)
        sent += len(pieces)
        fate = r.random()
        if fate < 0.2:
            r.shuffle(pieces)
        elif fate < 0.4:
            pieces.append(pieces[0])  # comes twice
        payloads += pieces
        whole_at = len(payloads) - (1 if 0.2 <= fate < 0.4 else 0)
        wanted[whole_at - 1] = shown
    payloads.append(struct.pack("<2sHIIHH", b"SL", 7, sent, 60, 0, 0) + bytes(2))
    payloads.append(b"SL is also the begin of this datagram, which is another protocol's")
    path = folder / "kinds.pcap"
    write_capture(path, payloads)
    names = sorted({name for shown in wanted.values() for name in shown})
    frames = shown_by_tshark(path, ["_ws.col.Info", "selfproj.doubled", *names])
    assert len(frames) == len(payloads)
    for at, shown in wanted.items():
        agree(frames[at], shown)
    only_whole = [name for name in names if name.startswith("selfproj.status")]
    for at in set(range(len(frames))) - set(wanted):
        assert not any(frames[at][name] for name in only_whole), f"frame {at} shows a packet that is not whole"
    assert frames[-2]["_ws.col.Info"] == ["idle, next packet 60"], frames[-2]
    assert not any(frames[-1][name] for name in names), "another protocol was taken for ours"
    return len(wanted)


def lost_pieces(folder, r, spec_hash):
    """A packet of which a piece is lost does not appear, and the next datagram says how many are missing."""
    data = [packet(r, spec_hash, "moments", "grey", "all", 512)[0] for _ in range(3)]
    payloads = [piece for i, one in enumerate(data) for piece in datagrams(one, i, 1, 3 * i)]
    assert len(payloads) == 9
    del payloads[4]
    write_capture(folder / "lost.pcap", payloads)
    frames = shown_by_tshark(folder / "lost.pcap",
                             ["selfproj.missing", "_ws.expert.message", "selfproj.trailer.sequence"])
    assert [i for i, frame in enumerate(frames) if frame["selfproj.missing"]] == [4]
    assert frames[4]["_ws.expert.message"] == ["Datagrams missing before this one: 1"], frames[4]
    assert [i for i, frame in enumerate(frames) if frame["selfproj.trailer.sequence"]] == [2, 7]


def of_the_board(folder, program):
    """What the simulated board sends; returns the hash of its specification."""
    size = 64 + 512 * 8 + 16
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(20)
        host = f"127.0.0.1:{listener.getsockname()[1]}"
        with subprocess.Popen([program, "board", "--line", "512x96", "--udp", host,
                               "--rate", "100", "--count", "5"], stdout=subprocess.DEVNULL):
            received, stream = [], b""
            while len(stream) < 5 * size:
                received.append(listener.recv(65536))
                stream += received[-1][16:16 + struct.unpack_from("<H", received[-1], 14)[0]]
    whole = [stream[at:at + size] for at in range(0, len(stream), size)]
    write_capture(folder / "board.pcap", received)
    frames = shown_by_tshark(folder / "board.pcap", ["selfproj.trailer.sequence", "selfproj.grey.m1",
                                                     "selfproj.grey.m0", "selfproj.bad_check", "selfproj.lines",
                                                     "selfproj.first_line"])
    shown = [frame for frame in frames if frame["selfproj.trailer.sequence"]]
    assert [frame["selfproj.trailer.sequence"] for frame in shown] == [[str(i)] for i in range(5)]
    for frame, data in zip(shown, whole):
        words = [word for word, in struct.iter_unpack("<Q", data[64:-16])]
        assert frame["selfproj.grey.m1"] == [str(word & 0x7FFFFFF) for word in words]
        assert frame["selfproj.grey.m0"] == [str(word >> 27 & 0x3FFFF) for word in words]
        assert not frame["selfproj.bad_check"]
        assert frame["selfproj.first_line"] == ["1"] and frame["selfproj.lines"] == ["96"], frame
    return struct.unpack_from("<I", whole[0], 4)[0]


def main():
    if not shutil.which("tshark"):
        print("skipped: tshark is not installed")
        return 77
    r = random.Random(20261125)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        spec_hash = of_the_board(folder, sys.argv[1])
        count = every_kind(folder, r, spec_hash)
        lost_pieces(folder, r, spec_hash)
    print(f"{count} packets of every kind and 5 of the board: every field is as it was sent")
    return 0


if __name__ == "__main__":
    sys.exit(main())
