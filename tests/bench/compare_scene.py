#!/usr/bin/env python3
"""Compares cameras and depth maps with the truth of a photo collection of make_scenes.py.

  tests/bench/compare_scene.py KIND 1_scene 2_tetrahedra

Prints the focal lengths, the errors of the cameras after a similarity that fits their centres to the
true ones, and how many of the depth maps' pixels are kept, right (within 2 %) and wrong (by more than
10 %). The subject of the turntable stands still there, and the camera goes around it.
"""
import json
import math
import pathlib
import struct
import sys

import numpy as np

import make_scenes


def true_photos(kind):
    """Worlds and cameras of the photos, in a frame in which nothing moves."""
    photos = [(world, camera) for world, camera, _ in make_scenes.KINDS[kind]()]
    if kind != "turntable":
        return photos
    still = photos[0][0]
    turned = []
    for i, (_, camera) in enumerate(photos):
        angle = -2 * math.pi * i / len(photos)
        turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
        turned.append((still, make_scenes.Camera(turn @ camera.position, turn @ camera.target, camera.width_degrees)))
    return turned


def similarity(found, true):
    """Scale and rotation that take found points to true ones best (Umeyama 1991), and the distances left."""
    a, b = found - found.mean(0), true - true.mean(0)
    u, s, v = np.linalg.svd(b.T @ a)
    signs = np.array([1, 1, np.sign(np.linalg.det(u @ v))])
    rotation = u @ np.diag(signs) @ v
    scale = (s * signs).sum() / (a * a).sum()
    return scale, rotation, np.linalg.norm(scale * a @ rotation.T - b, axis=1)


def read_depths(path):
    """Intrinsics and depths of a map of tetrec-tetrahedralize."""
    content = path.read_bytes()
    width, height, fx, fy, cx, cy = struct.unpack_from("<2I4d", content, 12)
    return (fx, fy, cx, cy), np.frombuffer(content, "<f4", width * height, 52).reshape(height, width)


def true_depths(world, camera, intrinsics, shape):
    fx, fy, cx, cy = intrinsics
    x, y = np.meshgrid((np.arange(shape[1]) + 0.5 - cx) / fx, (np.arange(shape[0]) + 0.5 - cy) / fy)
    direction = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], 1) @ camera.axes()
    length = np.linalg.norm(direction, axis=1)
    t, _ = make_scenes.nearest(world.things, np.broadcast_to(camera.position, direction.shape), direction / length[:, None])
    return (t / length).reshape(shape)


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in make_scenes.KINDS:
        print(__doc__, file=sys.stderr)
        return 2
    kind, scene_folder, start_folder = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
    scene = json.loads((scene_folder / "scene.json").read_text())
    photos = true_photos(kind)
    truths = [photos[int(pathlib.Path(view["name"]).stem) - 1] for view in scene["views"]]
    rotations = [np.array(view["cam_from_world"]["rotation"]) for view in scene["views"]]
    centers = np.array([-r.T @ np.array(view["cam_from_world"]["translation"])
                        for r, view in zip(rotations, scene["views"])])
    scale, turn, distances = similarity(centers, np.array([camera.position for _, camera in truths]))
    angles = [math.degrees(math.acos(min(1, max(-1, (np.trace(r @ turn.T @ camera.axes().T) - 1) / 2))))
              for r, (_, camera) in zip(rotations, truths)]
    found = scene["cameras"][0]
    focal = 0.5 * found["width"] / math.tan(math.radians(truths[0][1].width_degrees) / 2)
    print(f"focal lengths {found['fx']:.1f} and {found['fy']:.1f} px, true {focal:.1f}")
    print(f"centres off by {distances.mean():.4f} on average, {distances.max():.4f} at most; "
          f"turned by {np.mean(angles):.3f} and {max(angles):.3f} degrees")
    pixels = kept = right = wrong = 0
    for i, (world, camera) in enumerate(truths):
        path = start_folder / "depth" / f"{i:04}.depth"
        if not path.exists():
            continue
        intrinsics, depths = read_depths(path)
        ratio = np.abs(depths * scale / true_depths(world, camera, intrinsics, depths.shape) - 1)[depths > 0]
        pixels, kept = pixels + depths.size, kept + ratio.size
        right, wrong = right + (ratio < 0.02).sum(), wrong + (ratio > 0.1).sum()
    if pixels:
        print(f"depths of {100 * kept / pixels:.1f} % of the pixels, right {100 * right / pixels:.1f} %, "
              f"wrong {100 * wrong / pixels:.1f} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
