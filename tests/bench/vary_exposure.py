#!/usr/bin/env python3
"""Copies a scene folder and varies exposure and white balance of its training photos: every channel
of every photo is multiplied by a random number between 0.7 and 1.3 (the same for the same seed);
test views stay as they are. vary_exposure.py SCENE OUT [SEED]; OUT/true_exposure.json says by what."""
import hashlib
import json
import pathlib
import random
import shutil
import struct
import sys
import zlib


def chunks(png):
    """The type and content of each chunk of a PNG file."""
    at = 8
    while at < len(png):
        size, kind = struct.unpack_from(">I4s", png, at)
        yield kind, png[at + 8:at + 8 + size]
        at += size + 12


def paeth(a, b, c):
    """The predictor of PNG's filter 4."""
    p = a + b - c
    distances = abs(p - a), abs(p - b), abs(p - c)
    return (a, b, c)[distances.index(min(distances))]


def read_png(path):
    """Width, height, channels and rows of an 8-bit PNG, RGB or RGBA, not interlaced."""
    parts = list(chunks(path.read_bytes()))
    width, height, depth, color, _, _, interlace = struct.unpack(">2I5B", parts[0][1])
    if depth != 8 or color not in (2, 6) or interlace:
        sys.exit(f"{path}: not an 8-bit RGB or RGBA image")
    n = {2: 3, 6: 4}[color]
    data = zlib.decompress(b"".join(content for kind, content in parts if kind == b"IDAT"))
    before, rows = bytearray(width * n), []
    for y in range(height):
        start = y * (width * n + 1)
        method, row = data[start], bytearray(data[start + 1:start + 1 + width * n])
        for x in range(width * n if method else 0):
            a, c = (row[x - n], before[x - n]) if x >= n else (0, 0)
            b = before[x]
            row[x] = (row[x] + (a, b, (a + b) // 2, paeth(a, b, c))[method - 1]) & 255
        rows.append(row)
        before = row
    return width, height, n, rows


def write_png(path, width, height, n, rows):
    """Writes 8-bit RGB (n = 3) or RGBA (n = 4)."""
    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    header = struct.pack(">2I5B", width, height, 8, {3: 2, 4: 6}[n], 0, 0, 0)
    data = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def expose(path, gains):
    """Multiplies the channels of an image file."""
    width, height, n, rows = read_png(path)
    tables = [bytes(min(255, round(gain * value)) for value in range(256)) for gain in gains]
    for row in rows:
        for channel, table in enumerate(tables):
            row[channel::n] = row[channel::n].translate(table)
    write_png(path, width, height, n, rows)


def main():
    source, out = map(pathlib.Path, sys.argv[1:3])
    rng = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    shutil.copytree(source, out)
    truth = {}
    for view in json.loads((out / "scene.json").read_text())["views"]:
        if view["split"] == "train":
            truth[view["name"]] = [rng.uniform(0.7, 1.3) for _ in range(3)]
            expose(out / view["image"], truth[view["name"]])
    (out / "true_exposure.json").write_text(json.dumps(truth, indent=1))
    manifest = json.loads((out / "manifest.json").read_text())
    for output in manifest["outputs"]:
        content = (out / output["path"]).read_bytes()
        output["bytes"], output["sha256"] = len(content), hashlib.sha256(content).hexdigest()
    (out / "manifest.json").write_text(json.dumps(manifest, indent=1))


main()
