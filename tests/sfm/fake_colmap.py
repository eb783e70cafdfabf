"""A stand-in for COLMAP: the same commands, database and files, with results that FAKE_COLMAP selects.

none: the mapper finds nothing and exits with 0.    junk: two images and 61 points.
half: every second image is registered.             good: all of them, on a ring around a ball of points.
full: the disk is full while features are written.  killed: the extractor dies by SIGKILL.
newer: good, like COLMAP 3.11, whose tables lack poses. rigs: like COLMAP 3.12, which puts images into frames.
renamed COMMAND: like COLMAP 4.0, with other options. unknown COMMAND: like COLMAP 4.0, without the command.
idle COMMAND: like COLMAP 4.0, and does nothing without a message.
late: the last two images are registered only when the mapper runs for the second time. never: not even then.
wide: half of the images are registered, and all if the mapper demands few inliers of each.
folded: like good, but the lens model folds over inside the images.
bent: the same by the lens OPENCV.                  oblong: good, but pixels are oblong by the lens OPENCV.
anamorphic: the same, and other lenses fit badly.
leaving: bent, and the last two images are never registered.
narrow: half of the images are registered by the lens OPENCV, and all by others.
"""
import math
import os
import signal
import sqlite3
import struct
import sys

TABLES = """
CREATE TABLE IF NOT EXISTS cameras (camera_id INTEGER PRIMARY KEY, model, width, height, params, prior_focal_length);
CREATE TABLE IF NOT EXISTS images (image_id INTEGER PRIMARY KEY, name TEXT UNIQUE, camera_id PRIORS);
CREATE TABLE IF NOT EXISTS keypoints (image_id INTEGER PRIMARY KEY, rows, cols, data);
CREATE TABLE IF NOT EXISTS descriptors (image_id INTEGER PRIMARY KEY, rows, cols, data);
CREATE TABLE IF NOT EXISTS matches (pair_id INTEGER PRIMARY KEY, rows, cols, data);
CREATE TABLE IF NOT EXISTS two_view_geometries (pair_id INTEGER PRIMARY KEY, rows, cols, data, config);
"""
PRIORS = ", prior_qw, prior_qx, prior_qy, prior_qz, prior_tx, prior_ty, prior_tz"
VERSIONS = {"newer": "3.11.1", "rigs": "3.12.0", "renamed": "4.0.1", "unknown": "4.0.1", "idle": "4.0.1"}
MODE = os.environ["FAKE_COLMAP"]
VERSION = VERSIONS.get(MODE.split()[0], "3.8")
WIDTH, HEIGHT, FOCAL = 64, 48, 80.0
# COLMAP's number of a lens model, and how many focal lengths and parameters it has.
MODELS = {"SIMPLE_PINHOLE": (0, 1, 3), "PINHOLE": (1, 2, 4), "SIMPLE_RADIAL": (2, 1, 4), "RADIAL": (3, 1, 5),
          "OPENCV": (4, 2, 8)}


def first_lens(name):
    """The number and the parameters of a lens that nothing is known of."""
    number, focal_lengths, count = MODELS[name]
    params = [FOCAL] * focal_lengths + [WIDTH / 2, HEIGHT / 2]
    return number, struct.pack(f"<{count}d", *params, *[0.0] * (count - len(params)))


def open_database(path):
    database = sqlite3.connect(path)
    database.executescript(TABLES.replace("PRIORS", PRIORS if VERSION == "3.8" else ""))
    if MODE == "rigs":
        database.execute("CREATE TABLE IF NOT EXISTS frames (frame_id INTEGER PRIMARY KEY, rig_id)")
    return database


def extract(options):
    names = open(options["image_list_path"]).read().split()
    with open_database(options["database_path"]) as database:
        folders = {}
        for i, name in enumerate(names):
            print(f"Processed file [{i + 1}/{len(names)}]")
            if not os.path.exists(os.path.join(options["image_path"], name)):
                sys.exit("no such image: " + name)
            masks = options.get("ImageReader.mask_path")
            if masks and not os.path.exists(os.path.join(masks, name + ".png")):
                sys.exit("no such mask: " + name)
            number, params = first_lens(options["ImageReader.camera_model"])
            camera = folders.setdefault(os.path.dirname(name), len(folders) + 1)
            database.execute("INSERT OR IGNORE INTO cameras VALUES (?, ?, ?, ?, ?, 0)",
                             (camera, number, WIDTH, HEIGHT, params))
            cursor = database.execute("INSERT INTO images (name, camera_id) VALUES (?, ?)", (name, camera))
            database.execute("INSERT INTO keypoints VALUES (?, 0, 6, X'')", (cursor.lastrowid,))
            database.execute("INSERT INTO descriptors VALUES (?, 0, 128, X'')", (cursor.lastrowid,))
            if MODE == "rigs":
                database.execute("INSERT INTO frames VALUES (?, 1)", (cursor.lastrowid,))


def verify(options):
    with open_database(options["database_path"]) as database:
        ids = dict(database.execute("SELECT name, image_id FROM images"))
        for line in open(options["match_list_path"]):
            first, second = sorted(ids[name] for name in line.split())
            database.execute("INSERT INTO two_view_geometries VALUES (?, 0, 2, X'', 0)", (2147483647 * first + second,))


def ring_pose(k, count):
    """Camera k of a ring of radius 4 about the z axis, level, looking at the middle: q, t (world to camera)."""
    angle = 2 * math.pi * k / count
    c, s = math.cos(angle), math.sin(angle)
    rows = [[-s, c, 0.0], [0.0, 0.0, -1.0], [-c, -s, 0.0]]  # x right, y down, z to the middle
    center = [4 * c, 4 * s, 0.0]
    t = [-sum(row[i] * center[i] for i in range(3)) for row in rows]
    # Quaternion of a rotation matrix, by its largest component (Shepperd 1978).
    m = rows
    candidates = [m[0][0] + m[1][1] + m[2][2], m[0][0], m[1][1], m[2][2]]
    largest = candidates.index(max(candidates))
    if largest == 0:
        q = [1 + candidates[0], m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]
    else:
        i, j, l = [(0, 1, 2), (1, 2, 0), (2, 0, 1)][largest - 1]
        q = [m[l][j] - m[j][l], 0, 0, 0]
        q[1 + i] = 1 + m[i][i] - m[j][j] - m[l][l]
        q[1 + j] = m[j][i] + m[i][j]
        q[1 + l] = m[l][i] + m[i][l]
    length = math.sqrt(sum(v * v for v in q))
    return [v / length for v in q], t


def write_model(folder, names, point_count, shape="square", error=0.4):
    number, params = {"folded": (2, (FOCAL, WIDTH / 2, HEIGHT / 2, -30.0)),  # SIMPLE_RADIAL
                      "oblong": (1, (FOCAL, 1.2 * FOCAL, WIDTH / 2, HEIGHT / 2)),  # PINHOLE
                      "square": (1, (FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2))}[shape]
    os.makedirs(folder)
    with open(os.path.join(folder, "cameras.bin"), "wb") as f:
        f.write(struct.pack("<QIiQQ4d", 1, 1, number, WIDTH, HEIGHT, *params))
    with open(os.path.join(folder, "images.bin"), "wb") as f:
        f.write(struct.pack("<Q", len(names)))
        for k, name in enumerate(names):
            q, t = ring_pose(k, len(names))
            f.write(struct.pack("<I7dI", k + 1, *q, *t, 1) + name.encode() + b"\0")
            f.write(struct.pack("<Q", point_count))
            for point in range(point_count):
                f.write(struct.pack("<2dQ", 1.0, 1.0, point + 1))
    with open(os.path.join(folder, "points3D.bin"), "wb") as f:
        f.write(struct.pack("<Q", point_count))
        for point in range(point_count):
            # A spiral on the unit ball.
            z = 1 - 2 * (point + 0.5) / point_count
            r, turn = math.sqrt(1 - z * z), 2.4 * point
            f.write(struct.pack("<Q3d3Bd", point + 1, r * math.cos(turn), r * math.sin(turn), z, 200, 100, 50, error))
            f.write(struct.pack("<Q", len(names)))
            for k in range(len(names)):
                f.write(struct.pack("<II", k + 1, point))


def map_scene(options):
    database = open_database(options["database_path"])
    names = [row[0] for row in database.execute("SELECT name FROM images ORDER BY image_id")]
    lenses = list(database.execute("SELECT model, params FROM cameras ORDER BY camera_id"))
    known = {first_lens(name): name for name in MODELS}
    if not known.keys() >= set(lenses):
        sys.exit("unexpected cameras: " + repr(lenses))
    with open(os.environ["FAKE_COLMAP_CALLS"], "a") as calls:
        calls.write("lenses " + " ".join(known[lens] for lens in lenses) + "\n")
    is_opencv = known[lenses[0]] == "OPENCV"
    shape = "folded" if MODE == "folded" or (MODE in ("bent", "leaving") and is_opencv) else \
        "oblong" if MODE in ("oblong", "anamorphic") and is_opencv else "square"
    folder = os.path.join(options["output_path"], "0")
    if MODE == "none":
        print("WARNING: No images with matches found in the database.")
    elif MODE == "junk":
        write_model(folder, names[:2], 61)
    elif MODE in ("never", "leaving") or (MODE == "late" and open(os.environ["FAKE_COLMAP_CALLS"]).read().count("mapper") < 2):
        write_model(folder, names[:-2], 300, shape)
    elif MODE == "half" or (MODE == "narrow" and is_opencv) or (MODE == "wide" and int(options["Mapper.abs_pose_min_num_inliers"]) >= 30):
        write_model(folder, names[::2], 300)
    else:
        write_model(os.path.join(options["output_path"], "0"), names[:2], 61)  # the first is not the largest
        write_model(os.path.join(options["output_path"], "1"), names, 300, shape,
                    0.6 if MODE == "anamorphic" and not is_opencv else 0.4)


def main():
    command = sys.argv[1]
    options = {sys.argv[i][2:]: sys.argv[i + 1] for i in range(2, len(sys.argv) - 1, 2)}
    with open(os.environ["FAKE_COLMAP_CALLS"], "a") as calls:
        calls.write(command + "\n")
    if command == "help":
        print(f"COLMAP {VERSION} -- Structure-from-Motion and Multi-View Stereo")
    elif MODE == "renamed " + command:
        sys.exit(f"E0101 option_manager.cc:9] Failed to parse options - unrecognised option '{sys.argv[-2]}'.")
    elif MODE == "unknown " + command:
        sys.exit(f"E0101 colmap.cc:9] Command `{command}` not recognized. To list the available commands, run `colmap help`.")
    elif MODE == "idle " + command:
        pass
    elif command == "feature_extractor":
        extract(options)
        if MODE == "full":
            print("SQLite error [database.cc, line 500]: database or disk is full")
        if MODE == "killed":
            sys.stdout.flush()
            os.kill(os.getpid(), signal.SIGKILL)
    elif command == "matches_importer":
        verify(options)
    elif command == "mapper":
        map_scene(options)


main()
