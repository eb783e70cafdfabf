# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes Cycles' remarks (render times) out of pictures: the same scene is to give the same bytes."""
import struct


def without_remarks(data):
    return png_without_text(data) if data.startswith(b"\x89PNG") else jpeg_without_comments(data)


def png_without_text(data):
    kept, at = [data[:8]], 8
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind not in (b"tEXt", b"zTXt", b"iTXt", b"tIME"):
            kept.append(data[at:at + size + 12])
        at += size + 12
    return b"".join(kept)


def jpeg_without_comments(data):
    kept, at = [data[:2]], 2
    while data[at + 1] != 0xDA:  # start of scan: nothing but pixels from here
        size = struct.unpack_from(">H", data, at + 2)[0] + 2
        if data[at + 1] != 0xFE:
            kept.append(data[at:at + size])
        at += size
    return b"".join(kept) + data[at:]
