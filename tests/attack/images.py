"""Images of every kind that a file can hold, made here to the byte: each is measured as it is, or refused."""
import csv
import os
import struct
import zlib

from materials import EXIF_TURNED, JPEG, chunk
from programs import Fault, Part

MEASURE = "selfproj-sim moments --engine model --mode grey --threshold 0 --out o.csv"
# In several encodings, and with characters that shells, patterns, options and printf know.
NAMES = ["\u7dda".encode(), "fl\xe4che".encode("latin-1"), "\u7dda".encode("shift-jis"),
         b"\xff\xfe\x80", b"[1]", b"a[b-c]d", b"sp ace", b"*", b"?", b"a'b", b'a"b', b"{x}", b"-out", b"a\\b",
         b"\x7f", b"%s", b"a\nb"]
RIGHT, REFUSED, EITHER = "right", "refused", "right or refused"


def packed(values, bits):
    """The values of a row one after another, from the highest bit on."""
    number = 0
    for value in values:
        number = number << bits | value
    spare = -len(values) * bits % 8
    return (number << spare).to_bytes((len(values) * bits + 7) // 8, "big")


def flat(rows):
    return [[value for pixel in row for value in (pixel if isinstance(pixel, tuple) else (pixel,))] for row in rows]


# --- PNG ---

ADAM7 = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))


def png(rows, bits, colour, interlaced=False, before=b""):
    """`rows` of numbers, or of tuples of them; `before`: chunks before the pixels."""
    passes = ADAM7 if interlaced else ((0, 0, 1, 1),)
    data = b""
    for left, top, across, down in passes:
        for row in rows[top::down]:
            if row[left::across]:
                data += b"\0" + packed(flat([row[left::across]])[0], bits)
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), bits, colour, 0, 0, int(interlaced))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + before + chunk(b"IDAT", zlib.compress(data)) +
            chunk(b"IEND", b""))


# --- PNM ---


def pnm(rows, kind, white, comment=b""):
    head = b"P%d\n%s%d %d\n" % (kind, comment, len(rows[0]), len(rows))
    if kind not in (1, 4):
        head += b"%d\n" % white
    if kind <= 3:
        return head + b"\n".join(b" ".join(b"%d" % value for value in row) for row in flat(rows)) + b"\n"
    bits = 1 if kind == 4 else 8 if white < 256 else 16
    return head + b"".join(packed(row, bits) for row in flat(rows))


# --- TIFF ---


def tiff(pages, bits, order="<", big=False, light=1, channels=1, tile=0, strip=0, compression=1, predictor=1, form=1,
         separate=False, more=()):
    """`pages`: rows of numbers or tuples each. `more`: further tags (tag, type, value) of each page."""
    mark = {"<": b"II", ">": b"MM"}[order]
    word, length = ("Q", 8) if big else ("I", 4)
    data = bytearray(mark + (struct.pack(order + "HHHQ", 43, 8, 0, 0) if big else struct.pack(order + "HI", 42, 0)))
    link = 8 if big else 4
    for rows, own in zip(pages, more or [()] * len(pages)):
        pieces = []
        planes = [[[p[i] for p in row] for row in rows] for i in range(channels)] if separate else [rows]
        for plane in planes:
            each = 1 if separate else channels
            for piece in cut(flat(plane), each, tile, strip or len(rows)):
                if predictor == 2:
                    piece = [[(v - (row[i - each] if i >= each else 0)) % (1 << bits) for i, v in enumerate(row)]
                             for row in piece]
                raw = b"".join(piece_bytes(row, bits, order, form) for row in piece)
                pieces.append({1: raw, 8: zlib.compress(raw), 32773: literal_packbits(raw)}[compression])
        places = []
        for piece in pieces:
            places.append(len(data))
            data += piece + b"\0" * (len(piece) % 2)
        tags = [(256, 4, [len(rows[0])]), (257, 4, [len(rows)]), (258, 3, [bits] * channels),
                (259, 3, [compression]), (262, 3, [light]), (277, 3, [channels]), (284, 3, [2 if separate else 1]),
                (317, 3, [predictor]), (339, 3, [form] * channels)]
        sizes = [len(piece) for piece in pieces]
        if tile:
            tags += [(322, 4, [tile]), (323, 4, [tile]), (324, 4, places), (325, 4, sizes)]
        else:
            tags += [(273, 4, places), (278, 4, [strip or len(rows)]), (279, 4, sizes)]
        tags = sorted(tags + [(tag, kind, [value]) for tag, kind, value in own])
        entries = b""
        for tag, kind, values in tags:
            raw = struct.pack(order + "%d%s" % (len(values), {3: "H", 4: "I"}[kind]), *values)
            if len(raw) > length:
                place = len(data)
                data += raw + b"\0" * (len(raw) % 2)
                raw = struct.pack(order + word, place)
            entries += struct.pack(order + "HH" + word, tag, kind, len(values)) + raw.ljust(length, b"\0")
        struct.pack_into(order + word, data, link, len(data))
        data += struct.pack(order + ("Q" if big else "H"), len(tags)) + entries
        link = len(data)
        data += bytes(length)
    return bytes(data)


def cut(rows, channels, tile, strip):
    if not tile:
        return [rows[top:top + strip] for top in range(0, len(rows), strip)]
    pieces = []
    for top in range(0, len(rows), tile):
        for left in range(0, len(rows[0]), tile * channels):
            piece = [(row[left:left + tile * channels] + [0] * tile * channels)[:tile * channels]
                     for row in rows[top:top + tile]]
            pieces.append(piece + [[0] * tile * channels] * (tile - len(piece)))
    return pieces


def piece_bytes(row, bits, order, form):
    if form == 3:
        return struct.pack(order + "%d%s" % (len(row), {32: "f", 64: "d"}[bits]), *row)
    if bits in (16, 32):
        return struct.pack(order + "%d%s" % (len(row), {16: "H", 32: "I"}[bits]), *row)
    return packed(row, bits)


def literal_packbits(raw):
    return b"".join(bytes([len(raw[i:i + 128]) - 1]) + raw[i:i + 128] for i in range(0, len(raw), 128))


# --- BMP ---


def bmp(rows, bits, palette=(), upwards=True):
    """`rows` of numbers of a palette, or of tuples of blue, green, red and perhaps alpha."""
    body = b""
    for row in reversed(rows) if upwards else rows:
        line = packed(flat([row])[0], min(bits, 8))
        body += line + b"\0" * (-len(line) % 4)
    table = b"".join(struct.pack("<BBBB", *entry, 0) for entry in palette)
    head = struct.pack("<IiiHHIIiiII", 40, len(rows[0]), len(rows) * (1 if upwards else -1), 1, bits, 0, len(body),
                       2835, 2835, len(palette), 0)
    start = 14 + len(head) + len(table)
    return b"BM" + struct.pack("<IHHI", start + len(body), 0, 0, start) + head + table + body


def widened(rows, bits):
    white = (1 << bits) - 1
    return [[(2 * 255 * value + white) // (2 * white) for value in row] for row in rows]


def shifted(rows, by):
    return [[value >> by for value in row] for row in rows]


class Images(Part):
    """`kinds` yields (name, extension, bytes, rows that the image means, a tuple of such for pages, or nothing, what must
    happen, options)."""

    def run(self, count):
        kinds = list(self.kinds())
        while len(kinds) < min(count, 100_000):
            kinds += list(self.kinds())
        for kind in kinds if count >= len(kinds) else self.random.sample(kinds, count):
            self.attacker.case("images", kind[0], self.measured, *kind[1:])
        names = [name for name in NAMES if b"/" not in name and b"\0" not in name]
        for name in names if count >= len(names) ** 2 else self.random.sample(names, 4):
            self.attacker.case("images", f"name {name!r}", self.named, name)
        for name in ("extra_bytes_in_jpeg", "folders", "pages_for_one_image"):
            self.attacker.case("images", name, getattr(self, name))

    def picture(self, bits, channels=1):
        columns, rows = 4 * self.random.randrange(1, 12), self.random.randrange(1, 24)

        def value():
            return self.random.randrange(1 << bits)

        return [[value() if channels == 1 else tuple(value() for _ in range(channels)) for _ in range(columns)]
                for _ in range(rows)]

    def kinds(self):
        yield from self.png_kinds()
        yield from self.pnm_kinds()
        yield from self.tiff_kinds()
        yield from self.bmp_kinds()

    def png_kinds(self):
        for interlaced in (False, True):
            how = ", interlaced" if interlaced else ""
            for bits in (1, 2, 4, 8):
                rows = self.picture(bits)
                yield f"png grey {bits}{how}", "png", png(rows, bits, 0, interlaced), widened(rows, bits), RIGHT, ()
                indices = self.picture(bits)
                greys = [self.random.randrange(256) for _ in range(1 << bits)]
                palette = chunk(b"PLTE", b"".join(bytes([grey] * 3) for grey in greys))
                meant = [[greys[i] for i in row] for row in indices]
                data = png(indices, bits, 3, interlaced, palette)
                yield f"png palette {bits}{how}", "png", data, meant, RIGHT, ("--channel", "grey")
                yield f"png palette {bits}, no channel{how}", "png", data, meant, REFUSED, ()
                dark = chunk(b"tRNS", bytes(len(greys)))
                data = png(indices, bits, 3, interlaced, palette + dark)
                yield f"png palette {bits}, transparent{how}", "png", data, meant, EITHER, ("--channel", "red")
            rows = self.picture(8, 3)
            for i, name in enumerate(("red", "green", "blue")):
                meant = [[pixel[i] for pixel in row] for row in rows]
                yield f"png {name}{how}", "png", png(rows, 8, 2, interlaced), meant, RIGHT, ("--channel", name)
            rows = self.picture(8, 4)
            meant = [[pixel[1] for pixel in row] for row in rows]
            yield f"png alpha{how}", "png", png(rows, 8, 6, interlaced), meant, RIGHT, ("--channel", "green")
            rows = self.picture(8, 2)
            meant = [[pixel[0] for pixel in row] for row in rows]
            yield f"png grey alpha{how}", "png", png(rows, 8, 4, interlaced), meant, EITHER, ("--channel", "red")
            rows = self.picture(16)
            data = png(rows, 16, 0, interlaced)
            yield f"png 16{how}", "png", data, None, REFUSED, ()
            yield f"png 16, --shift 8{how}", "png", data, shifted(rows, 8), RIGHT, ("--shift", "8")
            rows = self.picture(12)
            data = png(rows, 16, 0, interlaced)
            yield f"png 12 in 16, --shift 4{how}", "png", data, shifted(rows, 4), RIGHT, ("--shift", "4")
            rows[0][0] = 4096
            data = png(rows, 16, 0, interlaced)
            yield f"png 13 in 16, --shift 4{how}", "png", data, None, REFUSED, ("--shift", "4")
            rows = self.picture(16, 3)
            meant = [[pixel[0] >> 8 for pixel in row] for row in rows]
            yield (f"png 16 red{how}", "png", png(rows, 16, 2, interlaced), meant, RIGHT,
                   ("--shift", "8", "--channel", "red"))
        rows = self.picture(8)
        for name, also in (("gamma", chunk(b"gAMA", struct.pack(">I", 45455))), ("sbit", chunk(b"sBIT", b"\5")),
                           ("turned", chunk(b"eXIf", EXIF_TURNED[10:])), ("black", chunk(b"tRNS", b"\0\0")),
                           ("text", chunk(b"tEXt", b"name\0\xe4\xff"))):
            yield f"png {name}", "png", png(rows, 8, 0, False, also), rows, EITHER if name == "black" else RIGHT, ()
        yield "png with --shift", "png", png(rows, 8, 0), None, REFUSED, ("--shift", "4")
        moving = chunk(b"acTL", struct.pack(">II", 3, 0)) + chunk(b"fcTL", struct.pack(
            ">IIIIIHHBB", 0, len(rows[0]), len(rows), 0, 0, 1, 1, 0, 0))
        yield "png that moves", "png", png(rows, 8, 0, False, moving), None, REFUSED, ()

    def pnm_kinds(self):
        for white in (1, 2, 15, 100, 200, 254, 255, 256, 1000, 1023, 4095, 40000, 65535):
            bits = white.bit_length()
            rows = [[value % (white + 1) for value in row] for row in self.picture(16)]
            if white > 255 and white + 1 == 1 << bits:
                meant = shifted(rows, bits - 8)
            else:
                meant = [[(2 * 255 * value + white) // (2 * white) for value in row] for row in rows]
            for kind in (2, 5):
                yield f"pgm P{kind} {white}", "pgm", pnm(rows, kind, white), meant, RIGHT, ()
            yield (f"pgm with a comment {white}", "pgm", pnm(rows, 5, white, b"# 1 2\n#\xe4\n"), meant, RIGHT, ())
            yield f"pgm cut {white}", "pgm", pnm(rows, 5, white)[:-1], None, REFUSED, ()
            yield f"pgm twice {white}", "pgm", 2 * pnm(rows, 5, white), None, REFUSED, ()
            colours = [[tuple(value % (white + 1) for value in pixel) for pixel in row] for row in self.picture(16, 3)]
            meant = [[(p[2] >> bits - 8) if white > 255 and white + 1 == 1 << bits else
                      (2 * 255 * p[2] + white) // (2 * white) for p in row] for row in colours]
            for kind in (3, 6):
                yield f"ppm P{kind} {white}", "ppm", pnm(colours, kind, white), meant, RIGHT, ("--channel", "blue")
        rows = [[value % 101 for value in row] for row in self.picture(8)]
        rows[-1][-1] = 101
        yield "pgm beyond its maximum", "pgm", pnm(rows, 5, 100), None, REFUSED, ()
        rows = self.picture(1)
        meant = [[255 * (1 - value) for value in row] for row in rows]
        for kind in (1, 4):
            yield f"pbm P{kind}", "pbm", pnm(rows, kind, 1), meant, EITHER, ()
            yield f"pbm P{kind} twice", "pbm", 2 * pnm(rows, kind, 1), None, REFUSED, ()

    def tiff_kinds(self):
        for order in "<>":
            for big in (False, True):
                how = f" {order}{' big' if big else ''}"
                own = {"order": order, "big": big}
                for bits in (1, 2, 4, 8):
                    rows = self.picture(bits)
                    meant = widened(rows, bits)
                    sure = RIGHT if bits == 8 else EITHER
                    yield f"tiff {bits}{how}", "tiff", tiff([rows], bits, **own), meant, sure, ()
                    meant = [[255 - value for value in row] for row in meant]
                    yield f"tiff {bits}, 0 is white{how}", "tiff", tiff([rows], bits, light=0, **own), meant, EITHER, ()
                rows = self.picture(8)
                for name, also in (("tiles", {"tile": 16}), ("strips", {"strip": 3}), ("deflate", {"compression": 8}),
                                   ("packbits", {"compression": 32773}),
                                   ("predictor", {"compression": 8, "predictor": 2})):
                    yield f"tiff {name}{how}", "tiff", tiff([rows], 8, **also, **own), rows, RIGHT, ()
                for turned in range(1, 9):
                    data = tiff([rows], 8, more=[[(274, 3, turned)]], **own)
                    yield f"tiff turned {turned}{how}", "tiff", data, rows, RIGHT, ()
                pages = (rows, [row[::-1] for row in rows])
                yield f"tiff of pages{how}", "tiff", tiff(pages, 8, **own), pages, RIGHT, ()
                small = [row[::4] for row in rows]
                data = tiff([rows, small], 8, more=[[], [(254, 4, 1)]], **own)
                yield f"tiff with a preview{how}", "tiff", data, rows, RIGHT, ()
                deep = self.picture(16)
                data = tiff([deep], 16, **own)
                yield f"tiff 16{how}", "tiff", data, None, REFUSED, ()
                yield f"tiff 16, --shift 8{how}", "tiff", data, shifted(deep, 8), RIGHT, ("--shift", "8")
                yield (f"tiff 16 in tiles{how}", "tiff", tiff([deep], 16, tile=16, **own), shifted(deep, 8), RIGHT,
                       ("--shift", "8"))
                yield (f"tiff 16, 0 is white{how}", "tiff", tiff([deep], 16, light=0, **own), None, REFUSED,
                       ("--shift", "8"))
                for bits in (10, 12, 14):
                    rows = self.picture(bits)
                    yield f"tiff {bits}{how}", "tiff", tiff([rows], bits, **own), shifted(rows, bits - 8), RIGHT, ()
                    by = bits - 8
                    yield (f"tiff {bits}, --shift{how}", "tiff", tiff([rows], bits, **own), shifted(rows, by), RIGHT,
                           ("--shift", str(by)))
                for bits in (8, 16):
                    rows = self.picture(bits - 1)
                    yield (f"tiff signed {bits}{how}", "tiff", tiff([rows], bits, form=2, **own), None, REFUSED,
                           ("--shift", "7") if bits == 16 else ())
                for bits, form in ((32, 1), (32, 3), (64, 3)):
                    yield (f"tiff {bits} of form {form}{how}", "tiff", tiff([self.picture(8)], bits, form=form, **own),
                           None, REFUSED, ())
                colours = self.picture(8, 3)
                for separate in (False, True):
                    meant = [[pixel[0] for pixel in row] for row in colours]
                    yield (f"tiff red {separate}{how}", "tiff",
                           tiff([colours], 8, light=2, channels=3, separate=separate, **own), meant,
                           EITHER if separate else RIGHT, ("--channel", "red"))

    def bmp_kinds(self):
        for upwards in (True, False):
            how = " upwards" if upwards else ""
            for bits in (1, 4, 8):
                rows = self.picture(bits)
                greys = [self.random.randrange(256) for _ in range(1 << bits)]
                meant = [[greys[i] for i in row] for row in rows]
                data = bmp(rows, bits, [(grey,) * 3 for grey in greys], upwards)
                yield f"bmp {bits}{how}", "bmp", data, meant, EITHER, ("--channel", "grey")
            for channels in (3, 4):
                rows = self.picture(8, channels)
                meant = [[pixel[2] for pixel in row] for row in rows]
                yield (f"bmp {8 * channels}{how}", "bmp", bmp(rows, 8 * channels, (), upwards), meant, RIGHT,
                       ("--channel", "red"))

    def measured(self, extension, data, rows, must, options):
        with self.attacker.scratch() as folder:
            name = f"a.{extension}"
            (folder / name).write_bytes(data)
            outcome = self.attacker.attack([*MEASURE.split(), *options, name], folder, [folder / name])
            self.compare(folder, outcome, name, rows, must)

    @staticmethod
    def compare(folder, outcome, name, rows, must):
        if outcome.status == 2 and must != RIGHT and name in outcome.err:
            return
        if outcome.status != 0 or must == REFUSED:
            raise Fault(f"must be {must}: status {outcome.status}, {outcome.err!r}")
        with open(folder / "o.csv", encoding="utf-8", newline="") as table:
            given = [(int(row["m0"]), int(row["m1"])) for row in csv.DictReader(table)]
        wanted = [(sum(column), sum(i * value for i, value in enumerate(column, 1)))
                  for page in (rows if isinstance(rows, tuple) else (rows,)) for column in zip(*page)]
        if given != wanted:
            raise Fault(f"other pixels: {given[:4]}, not {wanted[:4]}")

    # --- files ---

    def extra_bytes_in_jpeg(self):
        """Bytes too many before the end, after it, and between the segments do no harm; damage is still seen."""
        with self.attacker.scratch() as folder:
            tables = {}
            end = JPEG.rindex(b"\xff\xd9")
            for name, data in (("whole", JPEG), ("before", JPEG[:end] + b"\x12\x34" + JPEG[end:]),
                               ("behind", JPEG + bytes(range(200))), ("between", JPEG[:20] + b"\0\0" + JPEG[20:]),
                               ("both", JPEG[:20] + b"\0" + JPEG[20:end] + b"\7\7\7" + JPEG[end:])):
                (folder / "a.jpg").write_bytes(data)
                outcome = self.attacker.attack([*MEASURE.split(), "a.jpg"], folder)
                tables[name] = (folder / "o.csv").read_bytes() if outcome.status == 0 else outcome.err
            wrong = [name for name, table in tables.items() if table != tables["whole"]]
            if wrong or not isinstance(tables["whole"], bytes):
                raise Fault(f"{wrong}: {[tables[name][:200] for name in wrong]}")
            start = JPEG.index(b"\xff\xda") + 14
            for at in range(start, end, 11):
                (folder / "a.jpg").write_bytes(JPEG[:at] + b"\xff\xd9" + JPEG[end:])
                outcome = self.attacker.attack([*MEASURE.split(), "a.jpg"], folder)
                if outcome.status != 2 or "a.jpg" not in outcome.err:
                    raise Fault(f"a JPEG without bytes {at}..{end}: status {outcome.status}, {outcome.err!r}")

    def named(self, name):
        """Files and a folder of this name."""
        rows = self.picture(8)
        with self.attacker.scratch() as folder:
            place = bytes(folder) + b"/" + name
            os.mkdir(place)
            for i in (1, 2):
                with open(place + b"/" + name + b"%d.png" % i, "wb") as file:
                    file.write(png(rows, 8, 0))
            shown = os.fsdecode(b"./" + name)
            one = f"{shown}/{os.fsdecode(name)}1.png"
            for command in (["selfproj", "lines", "--threshold", "20", "--out", f"{shown}/o", one],
                            ["selfproj-sim", "cosim", "--engine", "model", "--threshold", "20", "--frames", shown,
                             "--out", "o2"],
                            ["selfproj-sim", "cosim", "--engine", "model", "--threshold", "20", "--frames", one,
                             "--out", f"{shown}/o3"],
                            ["selfproj-sim", "decode", "--engine", "model", "--bits", "1", "--out", "o4", shown]):
                self.good(command, folder)
            for summary in (place + b"/o", bytes(folder) + b"/o2", place + b"/o3"):
                for kind in (b"summary.json", b"report.html"):
                    with open(summary + b"/" + kind, encoding="utf-8") as text:
                        text.read()

    def pages_for_one_image(self):
        """A TIFF of several pages is refused where each file is one image."""
        rows = self.picture(8)
        with self.attacker.scratch() as folder:
            for name, pages in (("1.tiff", [rows]), ("2.tiff", [rows, rows])):
                (folder / name).write_bytes(tiff(pages, 8))
            outcome = self.attacker.attack("selfproj-sim decode --engine model --bits 1 --out o 1.tiff 2.tiff".split(),
                                           folder)
            if outcome.status != 2 or "2.tiff" not in outcome.err:
                raise Fault(f"pages are left out: status {outcome.status}, {outcome.err!r}")

    def folders(self):
        """What is no image does not count in a folder; a damaged image does."""
        rows = self.picture(8)
        with self.attacker.scratch() as folder:
            seen = folder / "seen"
            (seen / "sub").mkdir(parents=True)
            for i in range(2):
                (seen / f"{i}.PNG").write_bytes(png(rows, 8, 0))
            for other in ("Thumbs.db", "desktop.ini", "notes.txt", ".hidden", "a.json"):
                (seen / other).write_bytes(b"\xd0\xcf\x11\xe0")
            decode = ["selfproj-sim", "decode", "--engine", "model", "--bits", "1", "--out", "o", "seen"]
            outcome = self.good(decode, folder)
            if "left out" not in outcome.err:
                raise Fault(f"nothing is said of what is left out: {outcome.err!r}")
            for other in ("Thumbs.db", "desktop.ini", "notes.txt", "a.json"):
                (seen / other).unlink()
            (seen / "sub").rmdir()
            (seen / "2.png").write_bytes(bytes(100))
            outcome = self.attacker.attack(decode, folder)
            if outcome.status != 2:
                raise Fault(f"a damaged image is left out: status {outcome.status}")
