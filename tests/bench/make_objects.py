#!/usr/bin/env python3
"""Renders objects with known cameras in the format of NeRF-synthetic, unlike its lego.

  tests/bench/make_objects.py OUT [KIND ...]

Each kind becomes a data set for `tetrec-import OUT/KIND -o 1_scene`, with 100 training, 2 validation and
20 test pictures of 200x200 pixels with alpha:
  gloss  balls and boxes that mirror each other, lamps and clouds, some of them hardly and some like chrome
  wires  a ball in a cage of wires that are as thin as a pixel
  glass  things behind and inside tinted panes that let 40 to 75 % of the light through

The same kind always gives the same pictures. Needs python3-numpy and ffmpeg; all kinds take about ten
minutes on two cores.
Exit codes: 0 done, 2 wrong command line, 4 a program is missing.
"""
import dataclasses
import json
import math
import multiprocessing
import subprocess

import numpy as np

from make_scenes import FAR, SUN, Ball, Box, blotchy, cloudy, nearest, read_command_line, srgb, unit

SIDE = 200                 # of a picture, in pixels
RAYS = 2                   # per pixel side
ANGLE_OF_VIEW = 0.6911112  # along the width, as in NeRF-synthetic [rad]
REACH = 4.03               # of the cameras from the origin, as there
VIEWS = {"train": 100, "val": 2, "test": 20}
LAYERS = 8                 # of panes that a ray passes at most
LAMPS = [unit(SUN), unit(np.array([-0.7, 0.2, 0.6])), unit(np.array([0.1, 0.9, 0.4]))]


@dataclasses.dataclass
class Rod:
    """A round bar without caps."""
    start: np.ndarray
    end: np.ndarray
    radius: float
    paint: object

    def hit(self, origin, direction):
        length = np.linalg.norm(self.end - self.start)
        axis = (self.end - self.start) / length
        towards = 0.5 * (self.start + self.end) - origin
        beside = (towards * towards).sum(-1) - (towards * direction).sum(-1)**2
        near = beside < (length / 2 + self.radius)**2  # most rays pass far from a rod
        o, d = origin[near] - self.start, direction[near]
        o_along, d_along = o @ axis, d @ axis
        o_across, d_across = o - o_along[:, None] * axis, d - d_along[:, None] * axis
        a, b = (d_across * d_across).sum(-1), (o_across * d_across).sum(-1)
        root = b * b - a * ((o_across * o_across).sum(-1) - self.radius**2)
        t = (-b - np.sqrt(np.maximum(root, 0))) / np.maximum(a, 1e-12)
        along = o_along + t * d_along
        distances = np.full(len(direction), FAR)
        distances[near] = np.where((root > 0) & (t > 1e-4) & (along >= 0) & (along <= length), t, FAR)
        return distances

    def look(self, point, direction):
        axis = unit(self.end - self.start)
        along = (point - self.start) @ axis
        normal = unit(point - self.start - along[:, None] * axis)
        return normal, self.paint(along, normal[:, 0] * self.radius)


@dataclasses.dataclass
class Coated:
    """A thing that mirrors a share of the light, more of it at flat angles (Schlick), or lets some through."""
    thing: object
    mirrors: float = 0.0
    opacity: float = 1.0

    def hit(self, origin, direction):
        return self.thing.hit(origin, direction)

    def look(self, point, direction):
        return self.thing.look(point, direction)


def lamps_and_clouds(direction):
    """Linear colour of what things mirror; pictures do not show it."""
    color = 0.7 * cloudy(direction)
    color[direction[:, 2] < 0] = [0.25, 0.2, 0.15]
    for lamp in LAMPS:
        color += 2.5 * np.clip((direction @ lamp - 0.93) / 0.03, 0, 1)[:, None]
    return color


def light(things, origin, direction, mirrored=False):
    """Linear colours along rays, times alpha, and alpha. What is seen in a mirror has no shadows."""
    color, through = np.zeros(direction.shape), np.ones(len(direction))
    opacities = np.array([getattr(thing, "opacity", 1.0) for thing in things])
    origin, live = np.array(origin, float), np.arange(len(direction))
    for _ in range(LAYERS):
        t, which = nearest(things, origin[live], direction[live])
        live, t, which = live[which >= 0], t[which >= 0], which[which >= 0]
        origin[live] += t[:, None] * direction[live]
        for i, thing in enumerate(things):
            rays = live[which == i]
            if not len(rays):
                continue
            color[rays] += (through[rays] * opacities[i])[:, None] * shade(things, thing, origin[rays], direction[rays], mirrored)
            through[rays] *= 1 - opacities[i]
        origin[live] += 1e-4 * direction[live]
        live = live[through[live] > 0.005]
    return color, 1 - through


def shade(things, thing, point, direction, mirrored):
    """Linear colour of a thing at points that rays meet."""
    normal, paint = thing.look(point, direction)
    normal = np.where(((normal * direction).sum(-1) > 0)[:, None], -normal, normal)
    outside, sun = point + 1e-3 * normal, unit(SUN)
    lit = np.ones((len(point), 1))
    if not mirrored:
        opacities = np.array([getattr(other, "opacity", 1.0) for other in things])
        distance, which = nearest(things, outside, np.broadcast_to(sun, point.shape))
        lit -= np.where(distance < FAR, opacities[which], 0)[:, None]
    facing = np.maximum(normal @ sun, 0)[:, None]
    color = paint * (0.45 * (0.7 + 0.3 * normal[:, 2:3]) + 0.75 * lit * facing)
    away = direction - 2 * (direction * normal).sum(-1, keepdims=True) * normal
    mirrors = getattr(thing, "mirrors", 0.0)
    if mirrors == 0:
        return color + lit * 0.25 * np.maximum(away @ sun, 0)[:, None]**20
    share = mirrors + (1 - mirrors) * (1 - np.clip(-(direction * normal).sum(-1, keepdims=True), 0, 1))**5
    around = lamps_and_clouds(away)
    if not mirrored:
        seen, alpha = light(things, outside, away, mirrored=True)
        around = seen + (1 - alpha)[:, None] * around
    return (1 - share) * color + share * around


def gloss():
    things = [Box((0, 0, -0.35), (0.9, 0.9, 0.03), 0.2, blotchy(20))]
    for i, mirrors in enumerate((0.05, 0.2, 0.5, 0.8, 0.04, 0.3, 0.65, 0.1, 0.9)):
        x, y = (i % 3 - 1) * 0.62, (i // 3 - 1) * 0.62
        box, ball = Box((x, y, -0.1), (0.2, 0.2, 0.22), i, blotchy(30 + i)), Ball((x, y, -0.06), 0.26, blotchy(30 + i))
        things.append(Coated(box if i % 4 == 3 else ball, mirrors))
    return things


def wires():
    center, radius = np.array([0, 0, 0.4]), 0.5

    def on_cage(around, down):
        return center + radius * np.array([math.sin(down) * math.cos(around), math.sin(down) * math.sin(around), math.cos(down)])
    things = [Box((0, 0, -0.8), (0.5, 0.5, 0.05), 0.4, blotchy(60)), Ball(tuple(center), 0.2, blotchy(64)),
              Rod(np.array([0, 0, -0.8]), np.array([0, 0, 0.0]), 0.03, blotchy(61))]
    for i in range(12):
        for j in range(12):
            around, down, step = math.pi * i / 6, math.pi * j / 12, math.pi / 12
            things.append(Rod(on_cage(around, down), on_cage(around, down + step), 0.008, blotchy(62)))
    for j in range(1, 8):
        for i in range(16):
            around, down, step = math.pi * i / 8, math.pi * j / 8, math.pi / 8
            things.append(Rod(on_cage(around, down), on_cage(around + step, down), 0.008, blotchy(63)))
    for i in range(6):
        foot, tip = math.pi * i / 3, math.pi * i / 3 + 0.5
        things.append(Rod(np.array([0.45 * math.cos(foot), 0.45 * math.sin(foot), -0.75]),
                          np.array([0.9 * math.cos(tip), 0.9 * math.sin(tip), 0.2]), 0.012, blotchy(65 + i)))
    return things


def glass():
    def tint(*color):
        return lambda u, v: np.broadcast_to(color, (len(u), 3))
    return [Box((0, 0, -0.6), (0.9, 0.9, 0.05), 0.3, blotchy(50)),
            Ball((-0.35, -0.3, -0.2), 0.18, blotchy(51)), Box((0.4, 0.3, -0.3), (0.15, 0.15, 0.25), 0.1, blotchy(52)),
            Rod(np.array([0.3, -0.6, -0.55]), np.array([0.3, -0.6, 0.3]), 0.05, blotchy(53)), Ball((-0.5, 0.5, -0.3), 0.25, blotchy(54)),
            Coated(Ball((-0.35, -0.3, -0.15), 0.4, tint(0.1, 0.3, 0.6)), 0.08, 0.35),
            Coated(Box((0.4, 0.3, -0.1), (0.35, 0.3, 0.45), 0.5, tint(0.5, 0.15, 0.1)), 0.05, 0.25),
            Coated(Box((0.3, -0.6, 0.3), (0.35, 0.35, 0.01), 0.5, tint(0.8, 0.8, 0.75)), 0.0, 0.6)]


KINDS = {kind.__name__: kind for kind in (gloss, wires, glass)}


def pose(position):
    """World from camera, which looks at the origin along its -z."""
    back = unit(position)
    right = unit(np.cross([0, 0, 1.0], back))
    world_from_cam = np.eye(4)
    world_from_cam[:3] = np.stack([right, np.cross(back, right), back, position], axis=1)
    return world_from_cam


def poses(split):
    """Training and validation views from anywhere above, test views on an orbit that rises and sinks."""
    rng, count = np.random.default_rng(list(VIEWS).index(split)), VIEWS[split]
    for i in range(count):
        around, above = rng.uniform(0, 2 * math.pi), math.asin(rng.uniform(0.02, 0.98))
        if split == "test":
            around = 2 * math.pi * i / count
            above = math.radians(30 + 15 * math.sin(3 * around))
        yield pose(REACH * np.array([math.cos(above) * math.cos(around), math.cos(above) * math.sin(around), math.sin(above)]))


def picture(job):
    """8-bit RGBA. Rays are coded before they are averaged, as when a larger picture is reduced."""
    kind, world_from_cam = job
    side = SIDE * RAYS
    focal = 0.5 * side / math.tan(ANGLE_OF_VIEW / 2)
    x, y = np.meshgrid((np.arange(side) + 0.5 - side / 2) / focal, (np.arange(side) + 0.5 - side / 2) / focal)
    right, up, back, position = world_from_cam[:3].T
    direction = unit(x[..., None] * right - y[..., None] * up - back).reshape(-1, 3)
    color, alpha = light(KINDS[kind](), np.broadcast_to(position, direction.shape), direction)
    coded = srgb(np.clip(color / np.maximum(alpha, 1e-6)[:, None], 0, 1)) * alpha[:, None]
    of_pixels = np.concatenate([coded, alpha[:, None]], 1).reshape(SIDE, RAYS, SIDE, RAYS, 4).mean((1, 3))
    of_pixels[..., :3] /= np.maximum(of_pixels[..., 3:], 1e-6)
    return np.clip(255 * of_pixels, 0, 255).round().astype(np.uint8)


def write_split(out, split, pool):
    views = list(poses(split))
    (out / split).mkdir(parents=True, exist_ok=True)
    pictures = pool.map(picture, [(out.name, view) for view in views], chunksize=1)
    subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgba",
                    "-video_size", f"{SIDE}x{SIDE}", "-i", "-", "-start_number", "0", str(out / split / "r_%d.png")],
                   input=b"".join(p.tobytes() for p in pictures), check=True)
    frames = [{"file_path": f"./{split}/r_{i}", "transform_matrix": view.tolist()} for i, view in enumerate(views)]
    (out / f"transforms_{split}.json").write_text(json.dumps({"camera_angle_x": ANGLE_OF_VIEW, "frames": frames}, indent=1))


def main():
    out, kinds = read_command_line(__doc__, KINDS)
    with multiprocessing.Pool() as pool:
        for kind in kinds:
            for split in VIEWS:
                write_split(out / kind, split, pool)
            print(f"{out / kind}: {sum(VIEWS.values())} pictures")


if __name__ == "__main__":
    main()
