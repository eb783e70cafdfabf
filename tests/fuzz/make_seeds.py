#!/usr/bin/env python3
"""Writes the seeds of the fuzz targets: make_seeds.py FOLDER makes FOLDER/TARGET/NAME. Each seed is a
small valid file, written here by hand from the format's description, not by the code under test."""
import argparse
import json
import math
import pathlib
import struct
import zlib


def ply_seeds():
    """All three encodings, lists and scalars, comments."""
    header = ("ply\nformat {} 1.0\ncomment seed\nelement vertex 3\nproperty float x\n"
              "property double y\nproperty uchar red\nelement face 1\n"
              "property list uchar int vertex_indices\nend_header\n")
    yield "ascii.ply", (header.format("ascii") + "0 1 2\n3 4 5\n6 7 8\n3 0 1 2\n").encode()
    for order, name in (("<", "binary_little_endian"), (">", "binary_big_endian")):
        vertices = b"".join(struct.pack(order + "fdB", i, i + 0.5, i) for i in range(3))
        yield f"{name}.ply", header.format(name).encode() + vertices + struct.pack(
            order + "B3i", 3, 0, 1, 2)


def tet_mesh_bytes():
    """Two tets that share the face 1 2 3, positively oriented."""
    positions = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
    tets = [(0, 1, 2, 3), (4, 1, 3, 2)]
    none = 0xFFFFFFFF
    neighbors = [(1, none, none, none), (0, none, none, none)]
    out = b"TETRECM1" + struct.pack("<QQ", len(positions), len(tets))
    for rows, kind in ((positions, "3f"), (tets, "4I"), (neighbors, "4I")):
        out += b"".join(struct.pack("<" + kind, *row) for row in rows)
    return out


def field_bytes():
    """The two tets with density and colour."""
    return (b"TETRECF1" + tet_mesh_bytes() + struct.pack("<5f", 0, 0.5, 1, 2, 3)
            + struct.pack("<15f", *(i / 15 for i in range(15))))


def cell_field_bytes():
    """The two tets, each with a density and a colour."""
    return b"TETRECF2" + tet_mesh_bytes() + struct.pack("<2f6f", 0, 3, *(i / 6 for i in range(6)))


def layout_bytes(storage, *more):
    """Colour, density and `more` attributes: (name, components, activation, rate class)."""
    attributes = [(b"color", 3, 1, 0), (b"density", 1, 2, 1), *more]
    out = struct.pack("<II", storage, len(attributes))
    for name, components, activation, rate in attributes:
        out += struct.pack("<I", len(name)) + name + struct.pack("<3I", components, activation, rate)
    return out


def extra_field_bytes(storage, rows):
    """The two tets, or their five vertices, with five more values each, and two that are not negative."""
    more = [(b"extra", 5, 0, 0), (b"more_2", 2, 2, 1)]
    return (b"TETRECF3" + layout_bytes(storage, *more) + tet_mesh_bytes()
            + struct.pack(f"<{11 * rows}f", *(i / 11 for i in range(11 * rows))))


IDENTITY = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]


def scene_json():
    """One camera, one view, two points."""
    scene = {
        "schema": 1, "background": "scene", "has_alpha": False, "point_count": 2,
        "subject_bounds": {"min": [-1, -1, -1], "max": [1, 1, 1]},
        "input_from_world": {"scale": 1.0, "rotation": IDENTITY, "translation": [0, 0, 0]},
        "cameras": [{"width": 4, "height": 3, "fx": 5.0, "fy": 5.0, "cx": 2.0, "cy": 1.5}],
        "views": [{"name": "0001", "image": "images/0001.png", "camera": 0, "split": "train",
                   "cam_from_world": {"rotation": IDENTITY, "translation": [0, 0, 4]}}],
    }
    return json.dumps(scene).encode()


def transforms_seeds():
    """NeRF-synthetic; instant-ngp; nerfstudio: the first byte says which file the rest is (see
    transforms.cc)."""
    matrix = [row + [t] for row, t in zip(IDENTITY, (0, 0, 4))] + [[0, 0, 0, 1]]
    first = {"file_path": "./train/r_0", "transform_matrix": matrix}
    second = {"file_path": "train/r_1.png", "transform_matrix": matrix[:3], "mask_path": "mask.png",
              "fl_x": 51.0, "depth_file_path": "d.png"}
    files = {
        "nerf_synthetic": ("n", {"camera_angle_x": 0.69, "frames": [first]}),
        "instant_ngp": ("t", {"w": 40.0, "h": 30, "x_fov": 45.0, "camera_angle_y": 0.5, "k1": 0.1,
                              "k2": 0, "p1": 0, "p2": 0.01, "is_fisheye": False, "aabb_scale": 4,
                              "scale": 0.33, "offset": [0.5, 0.5, 0.5], "frames": [first, second]}),
        "nerfstudio": ("t", {"w": 40, "h": 30, "fl_x": 50.0, "fl_y": 50.0, "cx": 20.0, "cy": 15.0,
                             "camera_model": "OPENCV_FISHEYE", "k1": 0.1, "k2": 0.1, "k3": 0.1,
                             "k4": 0.1, "train_filenames": ["train/r_1.png"],
                             "val_filenames": ["train/r_0"], "test_filenames": ["./train/r_0"],
                             "frames": [first, second]}),
        "more": ("t", {"w": 40, "h": 30, "fl_x": 50.0, "distortion_params": [0.1, 0, 0, 0, 0, 0.01],
                       "rolling_shutter": [0, 0, 0], "from_na": False, "white_transparent": True,
                       "unread": 1, "frames": [first | {"sharpness": 9.5, "k1": 0.2},
                                               second | {"file_path": "gone"}]}),
        "box": ("t", {"camera_angle_x": 0.69, "aabb": [[0, 0, 0], [1, 1, 1]], "frames": [first]}),
    }
    for name, (kind, content) in files.items():
        yield name, (kind + json.dumps(content)).encode()


def png(width, height, depth, color_type, rows, *more):
    """A PNG of uncompressed rows, each without its filter byte."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">2I5B", width, height, depth, color_type, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + b"".join(chunk(*c) for c in more)
            + chunk(b"IDAT", pixels) + chunk(b"IEND", b""))


def color_profile():
    """An ICC profile of Display P3's primaries, relative to D50, with a gamma of 2.2."""
    def fixed(*numbers):
        return struct.pack(f">{len(numbers)}i", *(round(65536 * n) for n in numbers))

    def xyz(*numbers):
        return b"XYZ \0\0\0\0" + fixed(*numbers)

    white = (0.9642, 1.0, 0.8249)
    curve = b"curv\0\0\0\0" + struct.pack(">IHH", 1, 0x0233, 0)
    tags = {b"rXYZ": xyz(0.5151, 0.2412, -0.0011), b"gXYZ": xyz(0.2920, 0.6922, 0.0419),
            b"bXYZ": xyz(0.1571, 0.0666, 0.7841), b"wtpt": xyz(*white),
            b"rTRC": curve, b"gTRC": curve, b"bTRC": curve}
    table, bodies, front = b"", b"", 132 + 12 * len(tags)
    for name, body in tags.items():
        table += name + struct.pack(">2I", front + len(bodies), len(body))
        bodies += body
    header = struct.pack(">I4sI12s12s4s28s", front + len(bodies), b"", 0x02400000, b"mntrRGB XYZ ", b"",
                         b"acsp", b"") + fixed(*white) + bytes(48)
    return header + struct.pack(">I", len(tags)) + table + bodies


def jpeg(profile=b""):
    """8 x 8 grey, flat: one Huffman code for the mean, one for the end of the block."""
    def segment(code, body):
        return b"\xff" + bytes([code]) + struct.pack(">H", len(body) + 2) + body

    one_code = bytes([1] + 15 * [0] + [0])  # symbol 0 by the code 0
    # An orientation, and beyond two places an index that means Adobe RGB.
    exif = (b"Exif\0\0II*\0" + struct.pack("<IH2H2I2H2II", 8, 2, 0x0112, 3, 1, 6, 0x8769, 4, 1, 38, 0)
            + struct.pack("<H2H3I", 1, 0xA005, 4, 1, 56, 0) + struct.pack("<H2HI4sI", 1, 1, 2, 4, b"R03", 0))
    profiled = segment(0xE2, b"ICC_PROFILE\0\1\1" + profile) if profile else b""
    return (b"\xff\xd8" + segment(0xE1, exif) + profiled + segment(0xDB, bytes([0] + 64 * [1]))
            + segment(0xC0, bytes([8, 0, 8, 0, 8, 1, 1, 0x11, 0]))
            + segment(0xC4, b"\x00" + one_code) + segment(0xC4, b"\x10" + one_code)
            + segment(0xDA, bytes([1, 1, 0, 0, 63, 0])) + b"\x3f\xff\xd9")


def exr(channels, compression, pixels):
    """2 x 1 pixels in one scan line: `pixels` are its bytes. Rec. 709 by its own word."""
    def attribute(name, kind, body):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(body)) + body

    half = 1
    listed = b"".join(name + b"\0" + struct.pack("<I4B2I", half, 0, 0, 0, 0, 1, 1)
                      for name in channels) + b"\0"
    window = struct.pack("<4i", 0, 0, 1, 0)
    header = (b"\x76\x2f\x31\x01" + struct.pack("<I", 2) + attribute(b"channels", b"chlist", listed)
              + attribute(b"chromaticities", b"chromaticities",
                          struct.pack("<8f", 0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329))
              + attribute(b"compression", b"compression", bytes([compression]))
              + attribute(b"dataWindow", b"box2i", window)
              + attribute(b"displayWindow", b"box2i", window)
              + attribute(b"lineOrder", b"lineOrder", b"\0")
              + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
              + attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0))
              + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0")
    return header + struct.pack("<QiI", len(header) + 8, 0, len(pixels)) + pixels


def tiff(bits, samples, kind, pixels, *more):
    """A TIFF file of 2 x 1 pixels; `kind` is its photometric interpretation, `more` are (tag, type, count, value)."""
    entries = [(256, 3, 1, 2), (257, 3, 1, 1), (258, 3, 1, bits), (259, 3, 1, 1), (262, 3, 1, kind), (273, 4, 1, 8),
               (277, 3, 1, samples), (278, 3, 1, 1), (279, 4, 1, len(pixels)), *more]
    return (b"II*\0" + struct.pack("<I", 8 + len(pixels)) + pixels + struct.pack("<H", len(entries))
            + b"".join(struct.pack("<HHII", *entry) for entry in sorted(entries)) + struct.pack("<I", 0))


def image_seeds():
    """PNG of every colour type, 8 and 16 bits; JPEG with EXIF; TIFF; EXR; colour profiles."""
    yield "grey.png", png(2, 2, 8, 0, [b"\x10\x20", b"\x30\x40"])
    yield "rgb.png", png(2, 1, 8, 2, [bytes(range(6))])
    yield "palette.png", png(2, 1, 8, 3, [b"\0\1"], (b"PLTE", bytes(range(6))), (b"tRNS", b"\x80"))
    yield "grey_alpha.png", png(2, 1, 8, 4, [bytes(range(4))])
    yield "rgba.png", png(2, 1, 8, 6, [bytes(range(8))])
    yield "deep.png", png(1, 1, 16, 6, [bytes(range(8))])
    yield "bits.png", png(8, 1, 1, 0, [b"\x5a"])
    yield "grey.jpg", jpeg()
    yield "p3.jpg", jpeg(color_profile())
    yield "p3.png", png(2, 1, 8, 2, [bytes(range(6))], (b"iCCP", b"P3\0\0" + zlib.compress(color_profile())))
    yield "rgb.tif", tiff(8, 3, 2, bytes(range(6)))
    yield "rgba.tif", tiff(8, 4, 2, bytes(range(8)), (338, 3, 1, 2), (274, 3, 1, 6))
    yield "deep.tif", tiff(16, 1, 1, bytes(range(4)))
    yield "white0.tif", tiff(1, 1, 0, b"\x80")
    yield "tiles.tif", tiff(8, 1, 1, bytes(256), (322, 3, 1, 16), (323, 3, 1, 16), (324, 4, 1, 8), (325, 4, 1, 256))
    yield "rgba.exr", exr([b"A", b"B", b"G", b"R"], 0, struct.pack("<8e", *(i / 8 for i in range(8))))
    yield "grey.exr", exr([b"Y"], 0, struct.pack("<2e", 0.5, 2))
    # A find: the mark of another format, which a decoder took for its own.
    dicom = bytearray(exr([b"Y"], 0, struct.pack("<2e", 0.5, 2)))
    dicom[128:132] = b"DICM"
    yield "dicom.exr", bytes(dicom)


def colmap_seeds():
    """A model of one PINHOLE camera, two pictures, one point: the first byte says which of the three
    files the rest is (see colmap_model.cc)."""
    cameras = struct.pack("<QIiQQ4d", 1, 1, 1, 40, 30, 50.0, 50.0, 20.0, 15.0)
    images = struct.pack("<Q", 2)
    for i in (1, 2):
        images += struct.pack("<I7dI", i, 1, 0, 0, 0, 0.1 * i, 0, 4, 1) + b"%04d.jpg\0" % i
        images += struct.pack("<Q2dQ", 1, 20.0, 15.0, 1)
    points = struct.pack("<QQ3d3BdQ4I", 1, 1, 0.0, 0.0, math.pi, 10, 20, 30, 0.5, 2, 1, 0, 2, 0)
    for kind, content in enumerate((cameras, images, points)):
        yield f"model{kind}", bytes([kind]) + content
    lenses = struct.pack("<Q", 2)
    lenses += struct.pack("<IiQQ16d", 1, 11, 40, 30, 50.0, 50.0, 20.0, 15.0, *[0.01] * 12)
    lenses += struct.pack("<IiQQ6d", 2, 16, 40, 30, 50.0, 50.0, 20.0, 15.0, 0.6, 1.2)
    yield "lenses", b"\0" + lenses


def colmap_text_seeds():
    """The same kind of model as text, with comments, a name with a space and an empty second line."""
    cameras = "# cameras\n1 PINHOLE 40 30 50 50 20 15\n2 OPENCV 40 30 50 50 20 15 0.1 -0.01 1e-3 0\n"
    cameras += "3 EUCM 40 30 50 50 20 15 0.6 1.2\n"
    images = "# images\n1 1 0 0 0 0.1 0 4 1 a b.jpg\n20 15 1 3.5 4 -1\n2 1 0 0 0 0.2 0 4 1 c.jpg\n\n"
    points = "# points\n1 0 0 3.14159 10 20 30 0.5 1 0 2 0\n"
    for kind, content in enumerate((cameras, images, points)):
        yield f"model{kind}", bytes([kind]) + content.encode()


def volume_seeds():
    """2 x 3 x 4 bytes in each format; the first byte says which (see volume.cc)."""
    samples = bytes(range(24))
    nrrd = (b"NRRD0004\n# seed\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nspacings: 1 1 2\n"
            b"space origin: (0,1,2)\n")
    yield "raw.nrrd", b"\0" + nrrd + b"encoding: raw\n\n" + samples
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    yield "gzip.nrrd", b"\0" + nrrd + b"encoding: gzip\n\n" + packer.compress(samples) + packer.flush()
    yield "detached.nhdr", (b"\1NRRD0005\ntype: unsigned short\nendian: big\ndimension: 3\nsizes: 2 2 2\n"
                            b"space directions: (1,0,0) (0,2,0) (0,0,3)\nencoding: raw\n"
                            b"byte skip: 8\ndata file: data.raw\n")
    yield "ends.nrrd", (b"\0NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nspacings: 1 2 3\n"
                        b"axis mins: -1 0 5\naxis maxs: 0 6 14\ncenterings: node cell none\n"
                        b"kinds: space domain ???\nspace: left-posterior-superior\n"
                        b"encoding: raw\n\n" + samples)
    yield "ends_alone.nrrd", (b"\0NRRD0002\ntype: uchar\ndimension: 3\nsizes: 2 3 4\naxismins: 0 0 0\n"
                              b"axismaxs: 2 3 4\ncenters: cell cell cell\nencoding: raw\n\n" + samples)
    yield "space.nrrd", (b"\0NRRD0005\ntype: uchar\ndimension: 3\nspace dimension: 3\nsizes: 2 3 4\n"
                         b"spacedirections: (1,0,0) (0,2,0) (0,0,3)\nspaceorigin: (0,1,2)\n"
                         b"encoding: raw\n\n" + samples)
    meta = b"ObjectType = Image\nNDims = 3\nDimSize = 2 3 4\nElementSpacing = 1 2 3\nElementType = MET_UCHAR\n"
    yield "local.mha", b"\2" + meta + b"ElementDataFile = LOCAL\n" + samples
    yield "packed.mha", (b"\2" + meta + b"CompressedData = True\nElementDataFile = LOCAL\n"
                         + zlib.compress(samples))
    yield "float.mha", (b"\2NDims = 3\nDimSize = 2 2 2\nElementType = MET_FLOAT\n"
                        b"ElementByteOrderMSB = False\nElementDataFile = LOCAL\n"
                        + struct.pack("<8f", *range(8)))
    yield "detached.mhd", b"\3" + meta + b"HeaderSize = -1\nElementDataFile = data.raw\n"


def stereo_depth_bytes():
    """2 x 1 pixels, the second without a depth."""
    return (b"TETRECD1" + struct.pack("<3I4d", 3, 2, 1, 2.5, 2.5, 1, 0.5)
            + struct.pack("<2f2B", 1.5, 0, 2, 0))


def checkpoint_bytes(layout, rows):
    """The two tets with `rows` rows of colour and density, their moments and rates, moving vertices, and what else a
    run remembers of its two views; without a checksum."""
    trials = struct.pack("<4I", 1, 1, 0, 1)  # harmonics unlocked, judged, closed; fine rays
    growth = struct.pack("<Qd4Q3d2Q", 12, 2.5, 5, 2, 0, 10 ** 8, 21.0, 0.5, 0.1, 0, 0)
    out = b"TETRECKI" + struct.pack("<QdQQQdQ", 20, 1.5, 640, 4096, 4, 1, 16)
    out += struct.pack("<IIQdQ4dQ", 1, 0, 0, 21.0, 2, 1.5, 16, 0.25, 32, 1) + growth
    out += struct.pack("<IIdQQ4d", 0, 1, 0.5, 10, 2, 1.5, 16, 0.25, 32)  # of coarsening
    out += struct.pack("<3QdQ", 12, 1, 8, 21.0, 100) + trials
    mesh = tet_mesh_bytes()[len(b"TETRECM1"):]
    out += mesh[:16] + layout + mesh[16:]
    out += struct.pack(f"<{4 * rows}f", *(i / 9 for i in range(4 * rows)))
    out += struct.pack(f"<{8 * rows}f", *(i / 99 for i in range(8 * rows)))
    out += rows * struct.pack("<3f", 1, math.inf, -math.inf)
    out += struct.pack("<d4QQ", 0.5, 3, 5, 4, 3, 5) + struct.pack("<40f", *(i / 40 for i in range(40)))
    exposure, sums = (1.1, 1, 0.9, 0, 0.01, 0), 3 * (0.5, 0.25, 0.25, 1, 0.5)
    out += struct.pack("<Q42d", 2, *exposure, *exposure, *sums, *sums)
    pose = (1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 4, 3.5)
    return out + struct.pack("<IQ26dIQ2B2f", 2, 2, *pose, *pose, 1, 2, 0, 1, 0, 5.5)


def run_file_seeds():
    """The files of a run's folders; the first byte says which (see run_files.cc)."""
    pose = {"rotation": IDENTITY, "translation": [0, 0, 4]}
    views = {"schema": 1, "views": []}
    step = {"iteration": 12, "seconds": 2.5, "vertices": 5, "tets": 2, "empty_tets": None, "peak_rss_bytes": 10 ** 8,
            "psnr": 21.0, "gain": 0.5, "gain_standard_error": 0.1, "degenerate_tets": 0, "decision": "refine"}
    rendered = {"name": "a", "split": "test", "render": "renders/a.png", "ground_truth": "truth/a.png",
                "mask": None, "depth": "depth/a.png", "refined": "refined/a.png", "refined_shift_px": 0.5}
    stage = {"schema": 1, "stage": "optimize", "key": "k"}
    log = ("iteration,seconds,rays,loss,train_psnr,heldout_psnr,tets,vertices,phase,degenerate_tets\n"
           "0,0.000,0,,,21.5,2,5,optimise,\n20,1.500,640,0.01,20.1,22.000,2,5,end,1\n")
    files = (
        views | {"views": [{"name": "a", "rotation_deg": 0.5, "move": 0.1, "shift_px": 2.0, "cam_from_world": pose}]},
        {"schema": 1, "input_from_world": {"scale": 2.0, "rotation": sum(IDENTITY, []), "translation": [0, 1, 2]},
         "subject_bounds": {"min": [-1, -1, -1], "max": [1, 1, 1]}, "cameras_in_world": [[0, 0, 4]],
         "scene": "../1_scene"},
        {"schema": 1, "steps": [step, step | {"empty_tets": 1, "decision": "end"}]},
        views | {"views": [{"name": "a", "gain": [1.1, 1, 0.9], "offset": [0, 0.01, 0]}]},
        views | {"background": "white", "split": "test", "rays_per_pixel": 4, "resolution": [4, 3],
                 "views": [rendered, rendered | {"name": "b", "render": "renders/b.png", "seen": "seen/b.png"}]},
        log,
        stage | {"previous": "../2_tetrahedra", "outputs": []},
        stage | {"status": "running", "error": "what went wrong", "pid": 1, "own": ["field.tetf"]},
        views | {"views": [{"name": "a"}]})
    for kind, content in enumerate(files):
        text = content if isinstance(content, str) else json.dumps(content)
        yield f"file{kind}", bytes([kind]) + text.encode()
    rows = {"schema": 1, "input_from_world": {"scale": 1, **pose},
            "subject_bounds": {"min": [0, 0, 0], "max": [1, 1, 1]}}
    output = {"path": "manifest.json", "bytes": 115, "sha256": "0"}  # its own size
    yield "manifest_of_itself", b"\6" + json.dumps(stage | {"outputs": [output]}).encode()
    yield "world_in_rows", b"\1" + json.dumps(rows).encode()


def picture_request_seeds():
    """A picture of each kind of camera."""
    yield "free", b"mode=slice&w=200&h=100&eye=1,-2.5,3&fov=90&forward=0,0,-2&up=0,1,0&slice=2.5"
    yield "view", b"mode=photo&w=300&h=300&view=0&draft=1"


def transfer_function_seeds():
    """Our format and ParaView's."""
    yield "ours.json", json.dumps({"opacity": [[0, 0], [0.5, 1]],
                                   "colour": [[0, 1, 0, 0], [1, 0, 0.5, 1]]}).encode()
    yield "paraview.json", json.dumps([{"ColorSpace": "RGB", "RGBPoints": [0, 1, 0, 0, 255, 0, 0, 1],
                                        "Points": [0, 0, 0.5, 0, 255, 1, 0.5, 0]}]).encode()
    # A step between two of the smallest floats: its slope was infinite, colours no numbers.
    yield "step.json", json.dumps({"opacity": [[0, 0], [3.5e-43, 1]],
                                   "colour": [[0, 1, 0, 0], [1, 0, 0.5, 1]]}).encode()


SEEDS = {
    "ply": ply_seeds,
    "tet_mesh": lambda: [("two_tets.tet", tet_mesh_bytes())],
    "stereo_depth": lambda: [("two_pixels.depth", stereo_depth_bytes())],
    "field": lambda: [("two_tets.tetf", field_bytes()), ("two_cells.tetf", cell_field_bytes()),
                      ("extra.tetf", extra_field_bytes(0, 5)),
                      ("extra_cells.tetf", extra_field_bytes(1, 2))],
    "checkpoint": lambda: [("vertices", checkpoint_bytes(layout_bytes(0), 5)),
                           ("cells", checkpoint_bytes(layout_bytes(1), 2))],
    "run_files": run_file_seeds,
    "picture_request": picture_request_seeds,
    "scene": lambda: [("scene.json", scene_json())],
    "image": image_seeds,
    "transforms": transforms_seeds,
    "colmap_model": colmap_seeds,
    "colmap_text": colmap_text_seeds,
    "volume": volume_seeds,
    "transfer_function": transfer_function_seeds,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", metavar="FOLDER", type=pathlib.Path, help="gets a folder of seeds for each target")
    out = parser.parse_args().folder
    for target, seeds in SEEDS.items():
        folder = out / target
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in seeds():
            (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
