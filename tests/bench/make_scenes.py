#!/usr/bin/env python3
"""Renders photo collections of kinds that the standard scenes lack, for measurements of what carries over.

  tests/bench/make_scenes.py OUT [KIND ...]

Each kind becomes a folder of JPEG photos, OUT/KIND, for `tetrec-sfm OUT/KIND -o 1_scene`:
  yard       36 photos from a walk around boxes and balls on grass, under clouds
  forward    24 photos in one direction, of boxes and balls before a painted wall
  turntable  36 photos by a camera that stands still; the subject turns before a plain wall
  room       40 photos from inside a furnished room, looking outwards
  wide       15 photos around a subject in steps of 24 degrees
  few        9 photos of the yard: every second one of half of the walk
  uneven     the photos of the yard, each with its own exposure
  aerial     42 photos straight down on a village, in strips, as a drone flies them
  plant      36 photos of a plant with thin leaves, in two circles
  passers    the photos of the yard; people walk through every second one

Surfaces are diffuse with a faint highlight, lit by one sun and an even sky. The same kind always gives
the same photos. Needs python3-numpy and ffmpeg; all kinds take about half an hour on two cores.
Exit codes: 0 done, 2 wrong command line, 4 a program is missing.
"""
import argparse
import dataclasses
import functools
import math
import multiprocessing
import pathlib
import shutil
import subprocess
import sys

import numpy as np

SIZE = (720, 540)  # of a photo, in pixels
RAYS = 2           # per pixel side
NOISE = 2048       # side of the noise pictures, in pixels
FAR = 1e9
SUN = np.array([0.5, -0.35, 0.79])


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


@functools.lru_cache(maxsize=None)
def noise(seed):
    """A picture of noise of all scales, in 0..1, that continues over its borders."""
    rng = np.random.default_rng(seed)
    total = np.zeros((NOISE, NOISE), np.float32)
    cells = 8
    while cells <= NOISE:
        grid = rng.random((cells, cells), dtype=np.float32)
        at = np.arange(NOISE) * cells / NOISE
        low, share = at.astype(int), (at % 1).astype(np.float32)
        rows = grid[low] * (1 - share)[:, None] + grid[(low + 1) % cells] * share[:, None]
        total += rows[:, low] * (1 - share) + rows[:, (low + 1) % cells] * share
        cells *= 2
    low, high = np.quantile(total, (0.01, 0.99))
    return np.clip((total - low) / (high - low), 0, 1)


def sample(seed, u, v):
    """The noise at places whose unit is the side of the picture."""
    u, v = u * NOISE % NOISE, v * NOISE % NOISE
    x, y = u.astype(int) % NOISE, v.astype(int) % NOISE
    a, b = (u - np.floor(u)).astype(np.float32), (v - np.floor(v)).astype(np.float32)
    right, below, picture = (x + 1) % NOISE, (y + 1) % NOISE, noise(seed)
    return ((picture[y, x] * (1 - a) + picture[y, right] * a) * (1 - b)
            + (picture[below, x] * (1 - a) + picture[below, right] * a) * b)


def painted(seed, colors, size, bricks=0.0):
    """A paint: noise between two linear colours, repeated after `size`; with rows of bricks if asked."""
    first, second = (np.array(c, np.float32) for c in colors)

    def color_at(u, v):
        share = sample(seed, u / size, v / size)[:, None]
        color = first * (1 - share) + second * share
        if bricks:
            row = np.floor(v / bricks)
            along = u / (2 * bricks) + 0.5 * (row % 2)
            joint = (v / bricks % 1 < 0.12) | (along % 1 < 0.06)
            tone = sample(seed + 1, np.floor(along) * 0.137 + 0.01, row * 0.211 + 0.01)[:, None]
            color = np.where(joint[:, None], 0.5 * color + 0.2, color * (0.6 + 0.7 * tone))
        return color
    return color_at


@dataclasses.dataclass
class Box:
    """A box that is turned about the vertical; hollow: seen from inside."""
    center: tuple
    half: tuple
    turn: float
    paint: object
    hollow: bool = False

    def axes(self):
        c, s = math.cos(self.turn), math.sin(self.turn)
        return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])

    def hit(self, origin, direction):
        turn = self.axes()
        o, d = (origin - np.array(self.center)) @ turn.T, direction @ turn.T
        d = np.where(np.abs(d) < 1e-12, 1e-12, d)
        near, far = (-np.sign(d) * self.half - o) / d, (np.sign(d) * self.half - o) / d
        enter, leave = near.max(-1), far.min(-1)
        t = leave if self.hollow else enter
        return np.where((enter < leave) & (t > 1e-4), t, FAR)

    def look(self, point, direction):
        turn = self.axes()
        p = (point - np.array(self.center)) @ turn.T
        axis = np.argmax(np.abs(p) / self.half, -1)
        side = np.sign(np.take_along_axis(p, axis[:, None], 1)[:, 0])
        normal = turn[axis] * side[:, None] * (-1 if self.hollow else 1)
        others = np.array([[1, 2], [0, 2], [0, 1]])[axis]
        u, v = np.take_along_axis(p, others, 1).T
        # Each side shows another part of the paint.
        return normal, self.paint(u + 3.1 * axis + 1.7 * side, v)


@dataclasses.dataclass
class Ball:
    center: tuple
    radius: float
    paint: object
    turn: float = 0.0

    def hit(self, origin, direction):
        o = origin - np.array(self.center)
        b, c = (o * direction).sum(-1), (o * o).sum(-1) - self.radius**2
        root = b * b - c
        t = -b - np.sqrt(np.maximum(root, 0))
        return np.where((root > 0) & (t > 1e-4), t, FAR)

    def look(self, point, direction):
        normal = (point - np.array(self.center)) / self.radius
        angle = np.arctan2(normal[:, 1], normal[:, 0]) - self.turn
        return normal, self.paint(self.radius * angle, self.radius * np.arcsin(np.clip(normal[:, 2], -1, 1)))


@dataclasses.dataclass
class Leaf:
    """A flat ellipse, with the same paint on both sides."""
    center: tuple
    along: np.ndarray   # to its tip, as long as half of the leaf
    across: np.ndarray  # to its edge, at right angles to that
    paint: object

    def hit(self, origin, direction):
        towards = np.array(self.center) - origin
        beside = (towards * towards).sum(-1) - (towards * direction).sum(-1)**2
        near = beside < self.along @ self.along  # most rays pass far from a leaf
        normal = unit(np.cross(self.along, self.across))
        slope = direction[near] @ normal
        t = towards[near] @ normal / np.where(np.abs(slope) < 1e-9, 1e-9, slope)
        u, v = self.place(origin[near] + t[:, None] * direction[near])
        distances = np.full(len(direction), FAR)
        distances[near] = np.where((u * u + v * v < 1) & (t > 1e-4), t, FAR)
        return distances

    def look(self, point, direction):
        normal = unit(np.cross(self.along, self.across))
        u, v = self.place(point)
        size = np.linalg.norm(self.along)
        return -np.sign(direction @ normal)[:, None] * normal, self.paint(size * u, size * v)

    def place(self, point):
        offset = point - np.array(self.center)
        return offset @ self.along / (self.along @ self.along), offset @ self.across / (self.across @ self.across)


@dataclasses.dataclass
class Ground:
    paint: object

    def hit(self, origin, direction):
        t = -origin[:, 2] / np.where(np.abs(direction[:, 2]) < 1e-9, 1e-9, direction[:, 2])
        return np.where((t > 1e-4) & (t < 400), t, FAR)

    def look(self, point, direction):
        return np.broadcast_to([0.0, 0.0, 1.0], point.shape), self.paint(point[:, 0], point[:, 1])


def cloudy(direction):
    """Linear colour of the sky: clouds on a plane high above, fading into haze."""
    up = np.maximum(direction[:, 2], 0.02)
    cloud = sample(90, direction[:, 0] / up * 0.11, direction[:, 1] / up * 0.11)
    cloud = np.clip((cloud - 0.45) * 3, 0, 1)[:, None] * np.clip(up / 0.15, 0, 1)[:, None]
    blue = np.array([0.18, 0.36, 0.75]) + (1 - up[:, None])**4 * np.array([0.45, 0.38, 0.15])
    return blue * (1 - cloud) + np.array([0.95, 0.95, 0.97]) * cloud


def plain(direction):
    """A grey wall behind everything, a little darker towards its sides."""
    return np.broadcast_to([0.42, 0.42, 0.44], direction.shape) * (0.9 + 0.1 * direction[:, :1]**2)


def nearest(things, origin, direction):
    """Distance and index of the thing that each ray meets first; FAR if none."""
    best, which = np.full(len(direction), FAR), np.full(len(direction), -1)
    for i, thing in enumerate(things):
        t = thing.hit(origin, direction)
        closer = t < best
        best, which = np.where(closer, t, best), np.where(closer, i, which)
    return best, which


@dataclasses.dataclass
class World:
    things: list
    sky: object
    sun: np.ndarray
    sunlight: float = 0.75
    ambient: float = 0.45

    def light(self, origin, direction):
        """Linear colours along rays."""
        color = self.sky(direction).astype(np.float64)
        t, which = nearest(self.things, origin, direction)
        for i, thing in enumerate(self.things):
            here = which == i
            if not here.any():
                continue
            point = origin[here] + t[here, None] * direction[here]
            normal, paint = thing.look(point, direction[here])
            facing = np.maximum(normal @ self.sun, 0)
            blockers = [other for other in self.things if not getattr(other, "hollow", False)]
            shadow, _ = nearest(blockers, point + 1e-3 * normal, np.broadcast_to(self.sun, point.shape))
            lit = (shadow >= FAR)[:, None] * self.sunlight
            mirrored = direction[here] - 2 * (direction[here] * normal).sum(-1, keepdims=True) * normal
            shine = 0.25 * np.maximum(mirrored @ self.sun, 0)[:, None]**20
            even = self.ambient * (0.75 + 0.25 * normal[:, 2:3])
            color[here] = paint * (even + lit * facing[:, None]) + lit * shine
        return color


@dataclasses.dataclass
class Camera:
    position: np.ndarray
    target: np.ndarray
    width_degrees: float = 62
    up: tuple = (0, 0, 1)

    def axes(self):
        """Rows: to the right, down and ahead in the world."""
        ahead = unit(self.target - self.position)
        right = unit(np.cross(ahead, self.up))
        return np.stack([right, np.cross(ahead, right), ahead])

    def rays(self):
        w, h = SIZE[0] * RAYS, SIZE[1] * RAYS
        right, down, ahead = self.axes()
        focal = 0.5 * w / math.tan(math.radians(self.width_degrees) / 2)
        x, y = np.meshgrid((np.arange(w) + 0.5 - w / 2) / focal, (np.arange(h) + 0.5 - h / 2) / focal)
        direction = unit(ahead + x[..., None] * right + y[..., None] * down).reshape(-1, 3)
        return np.broadcast_to(self.position, direction.shape), direction


def srgb(linear):
    return np.where(linear < 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9)**(1 / 2.4) - 0.055)


def develop(linear, exposure, seed):
    """8-bit sRGB of the mean of each pixel's rays, with a photo's noise."""
    pixels = linear.reshape(SIZE[1], RAYS, SIZE[0], RAYS, 3).mean((1, 3)) * exposure
    coded = srgb(np.clip(pixels, 0, 1))
    grain = np.random.default_rng(seed).normal(0, 1.0, coded.shape)
    return np.clip(255 * coded + grain, 0, 255).round().astype(np.uint8)


GRASS = painted(1, ((0.05, 0.12, 0.03), (0.30, 0.42, 0.14)), 30)
STONE = painted(3, ((0.25, 0.22, 0.2), (0.6, 0.55, 0.5)), 14)


def brick(seed):
    rng = np.random.default_rng(seed)
    color = np.array([0.35, 0.2, 0.12]) + rng.random(3) * [0.35, 0.3, 0.3]
    return painted(10 + 2 * seed, (color * 0.45, np.minimum(color * 1.5, 1)), 8, 0.22)


def blotchy(seed):
    rng = np.random.default_rng(seed + 100)
    return painted(40 + seed, (rng.random(3) * 0.35, 0.3 + 0.6 * rng.random(3)), 3)


def subject(turn=0.0):
    """Boxes and balls within 1.6 of the origin on the ground, turned about the vertical."""
    c, s = math.cos(turn), math.sin(turn)

    def at(x, y, z):
        return (c * x - s * y, s * x + c * y, z)
    return [Box(at(0, 0, 0.6), (0.55, 0.4, 0.6), 0.3 + turn, blotchy(8)),
            Box(at(0.1, 0.0, 1.4), (0.25, 0.3, 0.2), 0.9 + turn, blotchy(1)),
            Ball(at(0.9, -0.6, 0.35), 0.35, blotchy(2), turn), Ball(at(-0.95, 0.5, 0.25), 0.25, blotchy(3), turn),
            Box(at(-0.8, -0.8, 0.3), (0.1, 0.5, 0.3), 0.7 + turn, blotchy(4)),
            Box(at(0.7, 0.9, 0.7), (0.06, 0.06, 0.7), 0.2 + turn, blotchy(5)),
            Ball(at(0.7, 0.9, 1.5), 0.18, blotchy(6), turn)]


def yard():
    houses = [Box((7, 3, 1.5), (1.5, 2.2, 1.5), 0.3, brick(1)), Box((-6, 5, 1.2), (2, 1.2, 1.2), -0.4, brick(2)),
              Box((-5, -7, 2), (1.4, 1.6, 2), 0.8, brick(3)), Box((4, -8, 1), (2.5, 0.8, 1), 0.1, brick(4)),
              Box((1, 10, 2.2), (1.2, 1.2, 2.2), 0.5, brick(5)), Ball((9, -4, 1), 1, blotchy(7))]
    world = World([Ground(GRASS), *subject(), *houses], cloudy, unit(SUN))
    cameras = []
    for i in range(36):
        angle = 2 * math.pi * i / 36
        reach = 4.2 + 0.4 * math.sin(3 * angle)
        position = np.array([reach * math.cos(angle), reach * math.sin(angle), 1.6 + 0.3 * math.sin(5 * angle)])
        cameras.append(Camera(position, np.array([0, 0, 0.9])))
    return [(world, camera, 1.0) for camera in cameras]


def forward():
    wall = Box((0, 3, 2), (8, 0.1, 4), 0, painted(60, ((0.15, 0.2, 0.3), (0.7, 0.6, 0.45)), 18))
    shelf = [Box((-1.6 + 0.8 * i, 1.2 + 0.3 * (i % 2), 0.5 + 0.1 * i), (0.22, 0.3, 0.5 + 0.1 * i), 0.3 * i, blotchy(10 + i))
             for i in range(5)]
    things = [Ground(STONE), wall, *shelf, Ball((-0.6, 0, 0.35), 0.35, blotchy(15)), Ball((0.9, -0.3, 0.28), 0.28, blotchy(16))]
    world = World(things, cloudy, unit(np.array([0.4, -0.7, 0.6])))
    cameras = []
    for i in range(24):
        x, z = (i % 6 - 2.5) * 0.28, (i // 6 - 1.5) * 0.22
        position = np.array([x + 0.05 * math.sin(7 * i), -3.4 + 0.1 * math.sin(3 * i), 1.2 + z])
        cameras.append(Camera(position, np.array([0.3 * x, 1, 0.8])))
    return [(world, camera, 1.0) for camera in cameras]


def turntable():
    camera = Camera(np.array([0, -4.6, 2.1]), np.array([0, 0, 0.65]), 45)
    sun = unit(np.array([0.5, -0.7, 0.6]))
    photos = []
    for i in range(36):
        disc = Box((0, 0, -0.1), (1.5, 1.5, 0.1), 2 * math.pi * i / 36, blotchy(20))
        photos.append((World([disc, *subject(2 * math.pi * i / 36)], plain, sun), camera, 1.0))
    return photos


def room():
    walls = Box((0, 0, 1.5), (4, 3.2, 1.5), 0, painted(62, ((0.3, 0.28, 0.25), (0.75, 0.7, 0.6)), 18), hollow=True)
    rng = np.random.default_rng(5)
    things = [walls]
    for i in range(9):
        angle = 2 * math.pi * (i + 0.3 * rng.random()) / 9
        half = 0.25 + 0.35 * rng.random(3)
        things.append(Box((3 * math.cos(angle), 2.4 * math.sin(angle), half[2]), tuple(half), angle, blotchy(22 + i)))
    things += [Ball((2.2, 0.4, 0.4), 0.4, blotchy(32)), Ball((-1.9, -1.2, 0.35), 0.35, blotchy(33))]
    world = World(things, plain, unit(np.array([0.3, 0.2, 0.93])), 0.4, 0.65)
    photos = []
    for i in range(40):
        angle = 2 * math.pi * i / 40
        position = np.array([0.9 * math.cos(angle + 2.5), 0.8 * math.sin(angle + 2.5), 1.4 + 0.25 * math.sin(7 * angle)])
        photos.append((world, Camera(position, position + np.array([math.cos(angle), math.sin(angle), -0.2]), 75), 1.0))
    return photos


def wide():
    world = yard()[0][0]
    photos = []
    for i in range(15):
        angle = math.radians(24 * i)
        position = np.array([3.9 * math.cos(angle), 3.9 * math.sin(angle), 1.7 + 0.2 * math.sin(3 * angle)])
        photos.append((world, Camera(position, np.array([0, 0, 0.7])), 1.0))
    return photos


def few():
    return yard()[:18:2]


def uneven():
    exposures = np.random.default_rng(8).uniform(0.65, 1.35, 36)
    return [(world, camera, exposure) for (world, camera, _), exposure in zip(yard(), exposures)]


def aerial():
    rng = np.random.default_rng(12)
    things = [Ground(GRASS), Box((0, 0, 0.02), (0.6, 12, 0.02), 0.2, STONE)]
    for i in range(16):
        x, y = (i % 4 - 1.5) * 3.6 + rng.uniform(-0.6, 0.6), (i // 4 - 1.5) * 3.2 + rng.uniform(-0.6, 0.6)
        half, turn = (rng.uniform(0.5, 1.0), rng.uniform(0.4, 0.8), rng.uniform(0.3, 0.9)), rng.uniform(0, 3)
        things.append(Box((x, y, half[2]), half, turn, brick(20 + i)))
        if i % 2:
            things.append(Ball((x + 1.4, y + 0.9, 0.45), 0.45, blotchy(50 + i)))
    world = World(things, cloudy, unit(SUN))
    photos = []
    for i in range(42):
        x, y = (i % 7 - 3) * 1.7, (i // 7 - 2.5) * 1.9
        position = np.array([x + rng.uniform(-0.1, 0.1), y + rng.uniform(-0.1, 0.1), 9 + rng.uniform(-0.1, 0.1)])
        tilt = np.array([*rng.uniform(-0.15, 0.15, 2), -9])
        photos.append((world, Camera(position, position + tilt, 55, (0, 1 if i // 7 % 2 else -1, 0)), 1.0))
    return photos


def plant():
    rng = np.random.default_rng(21)
    things = [Ground(STONE), Box((0, 0, 0.22), (0.3, 0.3, 0.22), 0.5, blotchy(70))]
    for i in range(14):
        turn, lean = 2.4 * i, 0.15 + 0.5 * (i % 5) / 4
        stem = unit(np.array([math.cos(turn) * lean, math.sin(turn) * lean, 1.0]))
        length = 0.5 + 0.6 * rng.random()
        foot = np.array([0.1 * math.cos(turn), 0.1 * math.sin(turn), 0.44])
        side = unit(np.cross(stem, [0, 0, 1]))
        for across in (side, np.cross(stem, side)):
            things.append(Leaf(tuple(foot + stem * length / 2), stem * length / 2, across * 0.016, blotchy(71)))
        for j in range(3):
            spread = turn + (j - 1) * 1.1
            along = unit(np.array([math.cos(spread), math.sin(spread), rng.uniform(-0.5, 0.4)])) * rng.uniform(0.16, 0.28)
            across = unit(np.cross(along, [rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), 1])) * 0.35 * np.linalg.norm(along)
            tip = foot + stem * length * (0.6 + 0.2 * j)
            things.append(Leaf(tuple(tip + along), along, across, painted(73 + j, ((0.05, 0.14, 0.03), (0.35, 0.6, 0.2)), 2)))
    world = World(things, cloudy, unit(SUN))
    photos = []
    for i in range(36):
        angle, high = 2 * math.pi * i / 18, i >= 18
        reach = 2.6 if high else 3.0
        position = np.array([reach * math.cos(angle), reach * math.sin(angle), 2.2 if high else 1.1])
        photos.append((world, Camera(position, np.array([0, 0, 0.7]), 50), 1.0))
    return photos


def passers():
    rng = np.random.default_rng(31)
    photos = []
    for i, (world, camera, exposure) in enumerate(yard()):
        things = list(world.things)
        for who in range(2 if i % 2 else 0):
            angle, reach = rng.uniform(0, 2 * math.pi), rng.uniform(2.0, 3.0)
            x, y = reach * math.cos(angle), reach * math.sin(angle)
            things += [Box((x, y, 0.55), (0.16, 0.22, 0.55), angle, blotchy(80 + who)), Ball((x, y, 1.25), 0.15, blotchy(82))]
        photos.append((dataclasses.replace(world, things=things), camera, exposure))
    return photos


KINDS = {kind.__name__: kind for kind in (yard, forward, turntable, room, wide, few, uneven, aerial, plant, passers)}


def photo(job):
    kind, index = job
    world, camera, exposure = KINDS[kind]()[index]
    return develop(world.light(*camera.rays()), exposure, [list(KINDS).index(kind), index])


def read_command_line(doc, known):
    """The output folder, and the kinds that are asked for: all that are known if none is."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"of {', '.join(known)} (default: all)")
    options = parser.parse_args()
    for kind in options.kinds:
        if kind not in known:
            parser.error(f"{kind}: not one of {', '.join(known)}")
    if not shutil.which("ffmpeg"):
        print("ffmpeg is missing; install the package ffmpeg", file=sys.stderr)
        sys.exit(4)
    return options.out, options.kinds or list(known)


def main():
    out, kinds = read_command_line(__doc__, KINDS)
    with multiprocessing.Pool() as pool:
        for kind in kinds:
            folder = out / kind
            folder.mkdir(parents=True, exist_ok=True)
            photos = pool.map(photo, [(kind, i) for i in range(len(KINDS[kind]()))], chunksize=1)
            subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgb24",
                            "-video_size", f"{SIZE[0]}x{SIZE[1]}", "-i", "-", "-q:v", "2", str(folder / "%04d.jpg")],
                           input=b"".join(p.tobytes() for p in photos), check=True)
            print(f"{folder}: {len(photos)} photos")


if __name__ == "__main__":
    main()
