#!/usr/bin/env python3
"""Writes the seeds of the fuzz targets: make_seeds.py FOLDER makes FOLDER/TARGET/NAME. Each seed is a
small valid file, written here by hand from the format's description, not by the code under test."""
import json
import math
import pathlib
import struct
import sys


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


def transforms_json():
    """One frame."""
    matrix = [row + [t] for row, t in zip(IDENTITY, (0, 0, 4))] + [[0, 0, 0, 1]]
    return json.dumps({"camera_angle_x": 0.69,
                       "frames": [{"file_path": "./train/r_0", "transform_matrix": matrix}]}).encode()


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


def colmap_text_seeds():
    """The same kind of model as text, with comments, a name with a space and an empty second line."""
    cameras = "# cameras\n1 PINHOLE 40 30 50 50 20 15\n2 OPENCV 40 30 50 50 20 15 0.1 -0.01 1e-3 0\n"
    images = "# images\n1 1 0 0 0 0.1 0 4 1 a b.jpg\n20 15 1 3.5 4 -1\n2 1 0 0 0 0.2 0 4 1 c.jpg\n\n"
    points = "# points\n1 0 0 3.14159 10 20 30 0.5 1 0 2 0\n"
    for kind, content in enumerate((cameras, images, points)):
        yield f"model{kind}", bytes([kind]) + content.encode()


SEEDS = {
    "ply": ply_seeds,
    "tet_mesh": lambda: [("two_tets.tet", tet_mesh_bytes())],
    "field": lambda: [("two_tets.tetf", field_bytes()), ("two_cells.tetf", cell_field_bytes())],
    "scene": lambda: [("scene.json", scene_json())],
    "transforms": lambda: [("transforms_train.json", transforms_json())],
    "colmap_model": colmap_seeds,
    "colmap_text": colmap_text_seeds,
}


def main():
    if len(sys.argv) != 2:
        print("usage: make_seeds.py FOLDER", file=sys.stderr)
        return 2
    for target, seeds in SEEDS.items():
        folder = pathlib.Path(sys.argv[1]) / target
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in seeds():
            (folder / name).write_bytes(content)
    return 0


if __name__ == "__main__":
    sys.exit(main())
