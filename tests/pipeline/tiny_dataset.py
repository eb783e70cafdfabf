"""A NeRF-synthetic data set of a shaded ball, rendered in closed form as 32x32 RGBA images."""
import json
import math
import struct
import zlib

SIZE = 32
RADIUS = 0.6  # of the ball around the origin
DISTANCE = 3.0  # of the cameras
FOV_RAD = 0.8


def write_png(path, width, height, rgba):
    """Writes 8-bit RGBA, with `rgba` row by row."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    stride = 4 * width
    rows = b"".join(b"\0" + rgba[y * stride:(y + 1) * stride] for y in range(height))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 6, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def subtract(a, b):
    return [x - y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(a):
    length = math.sqrt(dot(a, a))
    return [x / length for x in a]


def world_from_camera(eye):
    """The columns (x right, y up, z back, as in OpenGL) of a camera that looks at the origin."""
    back = unit(eye)
    right = unit(cross([0, 0, 1] if abs(back[2]) < 0.99 else [0, 1, 0], back))
    return right, cross(back, right), back


def by_normal(hit, direction):
    """The ball's usual colour."""
    return [h / RADIUS for h in hit]


def by_direction(hit, direction):
    """A colour that depends on where the camera is, and on nothing else."""
    return direction


def uniform(hit, direction):
    return [0.7, -0.2, 0.3]


def seen(eye, direction, paint):
    """Colour and alpha along a ray."""
    b = dot(eye, direction)
    inside = b * b - dot(eye, eye) + RADIUS * RADIUS
    if inside <= 0:
        return (0, 0, 0, 0)
    hit = [e + (-b - math.sqrt(inside)) * d for e, d in zip(eye, direction)]
    return tuple(int(127.5 + 100 * p) for p in paint(hit, direction)) + (255,)


def picture(eye, paint=by_normal):
    """RGBA bytes of an image; 2 x 2 rays per pixel are averaged with premultiplied alpha."""
    right, up, back = world_from_camera(eye)
    scale = 2 * math.tan(FOV_RAD / 2) / SIZE
    pixels = bytearray()
    for y in range(SIZE):
        for x in range(SIZE):
            total = [0.0, 0.0, 0.0, 0.0]
            for dy in (0.25, 0.75):
                for dx in (0.25, 0.75):
                    u, v = (x + dx - SIZE / 2) * scale, (SIZE / 2 - y - dy) * scale
                    ray = unit([u * r + v * p - k for r, p, k in zip(right, up, back)])
                    color = seen(eye, ray, paint)
                    for c in range(3):
                        total[c] += color[c] * color[3] / 255
                    total[3] += color[3]
            alpha = total[3] / 4
            pixels += bytes(int(t / 4 * 255 / alpha) if alpha else 0 for t in total[:3])
            pixels.append(int(alpha))
    return bytes(pixels)


def eyes(count, offset):
    """Camera centres, spread evenly over a sphere by the golden angle."""
    for i in range(count):
        z = 1 - 2 * (i + offset) / count
        angle = 2.399963 * (i + offset)
        flat = math.sqrt(max(0.0, 1 - z * z))
        yield [DISTANCE * flat * math.cos(angle), DISTANCE * flat * math.sin(angle), DISTANCE * z]


def turned(columns, angle_rad):
    """The columns of a camera that turned about its own y axis."""
    right, up, back, eye = columns
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return [[c * r - s * b for r, b in zip(right, back)], up,
            [s * r + c * b for r, b in zip(right, back)], eye]


def write_tiny_dataset(folder, train=40, validation=2, test=4, turned_rad=0.0, paint=by_normal):
    """Writes transforms_*.json and the images of a ball of colour `paint` into `folder`. Every second
    training camera is said to be turned by `turned_rad`, to the left and to the right by turns."""
    for split, count, offset in (("train", train, 0.5), ("val", validation, 0.3), ("test", test, 0.4)):
        (folder / split).mkdir(parents=True)
        frames = []
        for i, eye in enumerate(eyes(count, offset)):
            write_png(folder / split / f"r_{i}.png", SIZE, SIZE, picture(eye, paint))
            columns = [*world_from_camera(eye), eye]
            if split == "train" and i % 2 == 1:
                columns = turned(columns, turned_rad if i % 4 == 1 else -turned_rad)
            matrix = [[column[row] for column in columns] for row in range(3)] + [[0, 0, 0, 1]]
            frames.append({"file_path": f"./{split}/r_{i}", "transform_matrix": matrix})
        (folder / f"transforms_{split}.json").write_text(
            json.dumps({"camera_angle_x": FOV_RAD, "frames": frames}))


def write_tiny_photos(folder):
    """Writes the ball in front of black; a mask hides a magenta quarter of every image, and is grey elsewhere,
    which counts like white."""
    write_tiny_dataset(folder)
    (folder / "masks").mkdir()
    number = 0
    for split in ("train", "val", "test"):
        path = folder / f"transforms_{split}.json"
        content = json.loads(path.read_text())
        for i, frame in enumerate(content["frames"]):
            eye = [row[3] for row in frame["transform_matrix"][:3]]
            straight = picture(eye)
            rgba, mask = bytearray(), bytearray()
            for pixel in range(SIZE * SIZE):
                y, x = divmod(pixel, SIZE)
                color, alpha = straight[4 * pixel:4 * pixel + 3], straight[4 * pixel + 3]
                hidden = 2 * y // SIZE * 2 + 2 * x // SIZE == number % 4
                rgba += (b"\xff\0\xff" if hidden else
                         bytes(c * alpha // 255 for c in color)) + b"\xff"
                mask += bytes(3 * [0 if hidden else 160]) + b"\xff"
            number += 5
            write_png(folder / split / f"r_{i}.png", SIZE, SIZE, rgba)
            frame["mask_path"] = f"masks/{split}_{i}.png"
            write_png(folder / frame["mask_path"], SIZE, SIZE, mask)
        path.write_text(json.dumps(content))


def join_splits(folder):
    """Converts the data set to instant-ngp's form: a single transforms.json with the lens in pixels."""
    frames = []
    for split in ("train", "val", "test"):
        path = folder / f"transforms_{split}.json"
        frames += json.loads(path.read_text())["frames"]
        path.unlink()
    focal = SIZE / 2 / math.tan(FOV_RAD / 2)
    (folder / "transforms.json").write_text(
        json.dumps({"w": SIZE, "h": float(SIZE), "fl_x": focal, "cx": SIZE / 2, "cy": SIZE / 2,
                    "k1": 0, "k2": 0, "p1": 0, "p2": 0, "is_fisheye": False, "aabb_scale": 1,
                    "frames": frames}))
