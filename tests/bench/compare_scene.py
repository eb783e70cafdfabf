#!/usr/bin/env python3
"""Compares cameras, depth maps and surfaces with the truth of a photo collection of make_scenes.py.

  tests/bench/compare_scene.py KIND 1_scene 2_tetrahedra|5_surface ...

Prints the focal lengths and the errors of the cameras after a similarity that fits their centres to the
true ones. Of a start it prints how many of the depth maps' pixels are kept, right (within 2 %) and wrong
(by more than 10 %); of a surface, by its depths from some of the cameras, how much of the subject's
bounds it covers, how exact it is there and how far its normals are off. The subject of the turntable
stands still there, and the camera goes around it; people who walk through are left out.
"""
import json
import math
import pathlib
import struct
import sys

import numpy as np

import make_scenes

SAMPLES = 4_000_000  # of a surface
CAMERAS = 8          # from which surfaces are seen
TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4"}


def true_photos(kind):
    """Worlds and cameras of the photos, in a frame in which nothing moves."""
    photos = [(world, camera) for world, camera, _ in make_scenes.KINDS[kind]()]
    still = photos[0][0]  # without people, who walk through later photos
    if kind == "passers":
        return [(still, camera) for _, camera in photos]
    if kind != "turntable":
        return photos
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


def read_triangles(path):
    """Corners of the triangles of a binary PLY file of tetrec-surface, triangles x 3 x 3."""
    header, _, body = path.read_bytes().partition(b"end_header\n")
    fields, counts = {}, {}
    for words in map(str.split, header.decode().splitlines()):
        if words[0] == "element":
            element = words[1]
            fields[element], counts[element] = [], int(words[2])
        elif words[:2] == ["property", "list"]:  # of triangles: 3 vertices, 3 x 2 texture coordinates
            fields[element] += [(words[4] + " count", TYPES[words[2]]),
                                (words[4], TYPES[words[3]], (3 if words[4] == "vertex_indices" else 6,))]
        elif words[0] == "property":
            fields[element].append((words[2], TYPES[words[1]]))
    vertices = np.frombuffer(body, fields["vertex"], counts["vertex"])
    faces = np.frombuffer(body, fields["face"], counts["face"], vertices.nbytes)
    positions = np.stack([vertices[axis] for axis in "xyz"], 1).astype(float)
    return positions[faces["vertex_indices"]]


def sample_triangles(triangles):
    """Places spread evenly over the triangles, and the normals there."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    random = np.random.default_rng(0)
    chosen = random.choice(len(triangles), SAMPLES, p=areas / areas.sum())
    a, b = np.sqrt(random.random(SAMPLES))[:, None], random.random(SAMPLES)[:, None]
    corners = triangles[chosen]
    places = (1 - a) * corners[:, 0] + a * (1 - b) * corners[:, 1] + a * b * corners[:, 2]
    return places, normals[chosen] / areas[chosen, None]


def nearest_samples(in_cam, intrinsics, shape):
    """For each pixel the index of the nearest sample in it, -1 if there is none."""
    fx, fy, cx, cy = intrinsics
    order = np.argsort(-in_cam[:, 2])
    order = order[in_cam[order, 2] > 0]
    x = np.floor(in_cam[order, 0] / in_cam[order, 2] * fx + cx)
    y = np.floor(in_cam[order, 1] / in_cam[order, 2] * fy + cy)
    inside = (x >= 0) & (x < shape[1]) & (y >= 0) & (y < shape[0])
    nearest = np.full(shape, -1)
    nearest[y[inside].astype(int), x[inside].astype(int)] = order[inside]
    return nearest


def compare_surface(folder, scene, truths, scale):
    places, normals = sample_triangles(read_triangles(folder / "surface.ply"))
    camera = scene["cameras"][0]
    shape = camera["height"] // 2, camera["width"] // 2
    intrinsics = [camera[key] / 2 for key in ("fx", "fy", "cx", "cy")]
    bounds = [np.array(scene["subject_bounds"][end]) for end in ("min", "max")]
    x, y = np.meshgrid((np.arange(shape[1]) + 0.5 - intrinsics[2]) / intrinsics[0],
                       (np.arange(shape[0]) + 0.5 - intrinsics[3]) / intrinsics[1])
    errors, angles, subject = [], [], 0
    for i in range(0, len(truths), max(1, len(truths) // CAMERAS)):
        pose = scene["views"][i]["cam_from_world"]
        rotation, translation = np.array(pose["rotation"]), np.array(pose["translation"])
        nearest = nearest_samples(places @ rotation.T + translation, intrinsics, shape)
        depth = true_depths(*truths[i], intrinsics, shape) / scale
        points = np.stack([x, y, np.ones(shape)], -1) * depth[..., None]
        in_world = (points - translation) @ rotation
        is_subject = ((in_world > bounds[0]) & (in_world < bounds[1])).all(-1)
        subject += is_subject.sum()
        seen = is_subject & (nearest >= 0)
        error = (places[nearest] @ rotation.T + translation)[..., 2] / depth - 1
        errors.append(error[seen])
        slope_y, slope_x = np.gradient(points, axis=(0, 1))
        true_normals = np.cross(slope_x, slope_y)
        true_normals /= np.linalg.norm(true_normals, axis=-1, keepdims=True) + 1e-30
        # Where the true depth does not jump, and the surface is the true one.
        smooth = seen & (np.abs(slope_x[..., 2]) + np.abs(slope_y[..., 2]) < 0.05 * depth) & (np.abs(error) < 0.02)
        cosines = np.abs(((normals[nearest] @ rotation.T) * true_normals).sum(-1))[smooth]
        angles.append(np.degrees(np.arccos(np.clip(cosines, 0, 1))))
    error, angle = np.concatenate(errors), np.concatenate(angles)
    share = lambda chosen: 100 * chosen.mean()
    print(f"surface over {100 * error.size / subject:.1f} % of the subject's pixels; of these, depths within 1 % "
          f"{share(np.abs(error) < 0.01):.1f} %, within 2 % {share(np.abs(error) < 0.02):.1f} %, too far "
          f"{share(error > 0.02):.1f} %, too near {share(error < -0.02):.1f} %; normals off by {angle.mean():.1f} degrees")


def compare_depths(folder, truths, scale):
    pixels = kept = right = wrong = 0
    for i, (world, camera) in enumerate(truths):
        path = folder / "depth" / f"{i:04}.depth"
        if not path.exists():
            continue
        intrinsics, depths = read_depths(path)
        ratio = np.abs(depths * scale / true_depths(world, camera, intrinsics, depths.shape) - 1)[depths > 0]
        pixels, kept = pixels + depths.size, kept + ratio.size
        right, wrong = right + (ratio < 0.02).sum(), wrong + (ratio > 0.1).sum()
    if pixels:
        print(f"depths of {100 * kept / pixels:.1f} % of the pixels, right {100 * right / pixels:.1f} %, "
              f"wrong {100 * wrong / pixels:.1f} %")


def main():
    if len(sys.argv) < 4 or sys.argv[1] not in make_scenes.KINDS:
        print(__doc__, file=sys.stderr)
        return 2
    kind, scene_folder, *folders = sys.argv[1], *map(pathlib.Path, sys.argv[2:])
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
    for folder in folders:
        if (folder / "surface.ply").exists():
            compare_surface(folder, scene, truths, scale)
        elif (folder / "depth").exists():
            compare_depths(folder, truths, scale)
        else:
            sys.exit(f"{folder}: contains neither a surface.ply nor depth maps")
    return 0


if __name__ == "__main__":
    sys.exit(main())
