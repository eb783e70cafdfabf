"""The start from depth maps, on photos with known cameras: no COLMAP, no sparse points."""
import json
import math
import pathlib
import shutil
import struct
import unittest

from stage_case import StageCase

DEMO = pathlib.Path(__file__).resolve().parents[2] / "datasets_spec" / "demo"
# The table top and the room (datasets_spec/demo/README.md).
TABLE_Z, TABLE_RADIUS = -0.7, 1.66
ROOM = ((-4.4, 4.4), (-4.4, 4.4), (-2.1, 3.0))
PHOTOS = 6
PIXEL = 3.0 / 93  # width of a pixel of 96 x 72 where the cameras look, 3 units away


def world_from_gl_camera(cam_from_world):
    """Camera to world with OpenGL's axes, 4 x 4, of COLMAP's world to camera, 3 x 4."""
    axes = [row[:3] for row in cam_from_world]  # right, down, forward
    shift = [row[3] for row in cam_from_world]
    eye = [-sum(axes[i][k] * shift[i] for i in range(3)) for k in range(3)]
    return [[axes[0][k], -axes[1][k], -axes[2][k], eye[k]] for k in range(3)] + [[0, 0, 0, 1]]


def write_demo_dataset(folder, count):
    """The first photos of the demo scene with their exact cameras, as instant-ngp's transforms.json."""
    cameras = json.loads((DEMO / "cameras.json").read_text())
    (folder / "photos").mkdir(parents=True)
    frames = []
    for frame in cameras["frames"][:count]:
        shutil.copy(DEMO / frame["file"], folder / "photos")
        frames.append({"file_path": frame["file"],
                       "transform_matrix": world_from_gl_camera(frame["cam_from_world"])})
    (folder / "transforms.json").write_text(
        json.dumps({"w": cameras["width"], "h": cameras["height"], "fl_x": cameras["fx"],
                    "fl_y": cameras["fy"], "cx": cameras["cx"], "cy": cameras["cy"], "frames": frames}))


def read_dense_points(path):
    """Positions of the points that the depth maps were fused to."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    point = struct.Struct("<3f3f3BI")  # with normal, colour and number of views
    assert b"float z\nproperty float nx" in header and len(body) % point.size == 0, header
    return [row[:3] for row in point.iter_unpack(body)]


def is_on_table(point, subject, tolerance):
    """Whether a point of the demo scene is near the table top, or in the box of what stands there."""
    if abs(point[2] - TABLE_Z) < tolerance and math.hypot(point[0], point[1]) < TABLE_RADIUS + tolerance:
        return True
    return all(low - tolerance < x < high + tolerance
               for x, low, high in zip(point, subject["bounds_min"], subject["bounds_max"]))


def is_on_wall(point, tolerance):
    """Whether a point is near a wall, the floor or the ceiling of the demo scene's room."""
    return any(abs(x - bound) < tolerance for x, bounds in zip(point, ROOM) for bound in bounds)


class DenseStartTest(StageCase):

    def test_photos_with_known_cameras_become_a_start_that_optimize_accepts(self):
        write_demo_dataset(self.folder / "demo", PHOTOS)
        scene, tetrahedra, field = (self.folder / "run" / name
                                    for name in ("1_scene", "2_tetrahedra", "3_field"))
        subject = json.loads((DEMO / "scene.json").read_text())["subject"]
        bounds = ",".join(map(str, [*subject["bounds_min"], *subject["bounds_max"]]))
        self.assert_done(self.run_stage("import", self.folder / "demo", "-o", scene, "--max-size", 96,
                                        "--holdout", 0, f"--bounds={bounds}"))
        self.assert_done(self.run_stage("tetrahedralize", scene, "-o", tetrahedra, "--start", "dense",
                                        "--dense-points", 1000))
        counts = self.manifest(tetrahedra)["counts"]
        self.assertEqual(len(list((tetrahedra / "depth").glob("*.depth"))), PHOTOS)
        self.assertEqual(counts["depth"]["views_without"], 0)
        self.assertGreater(counts["depth"]["confirmed"], 0.3 * counts["depth"]["pixels"])
        self.assertEqual(counts["dense"]["lost_sight_lines"], 0)
        points = counts["points"]
        self.assertEqual(points.pop("read"), sum(points.values()), "each sparse point is used or counted as dropped")
        self.assertGreater(counts["dense"]["full_tets"], 0)
        self.assertGreater(counts["dense"]["free_tets"], 0)
        self.check_points(scene, read_dense_points(tetrahedra / "depth" / "points.ply"), subject)
        self.assert_done(self.run_stage("optimize", tetrahedra, "-o", field, "--iterations", 20,
                                        "--time-limit", 0, "--rays", 512))
        # It refines no mesh in so few steps, but it may drop empty vertices.
        self.assertGreater(self.manifest(field)["counts"]["vertices"], 0.5 * counts["vertices"])

    def check_points(self, scene, points, subject):
        """The photos show little but the table and what stands on it."""
        world = json.loads((scene / "scene.json").read_text())["input_from_world"]
        self.assertEqual(world["rotation"], [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
        in_input = [[world["scale"] * x + t for x, t in zip(point, world["translation"])]
                    for point in points]
        self.assertGreater(len(points), 500)
        on_table = [point for point in in_input if is_on_table(point, subject, 2 * PIXEL)]
        # The walls are about twice as far away.
        on_walls = [point for point in in_input if is_on_wall(point, 4 * PIXEL)]
        self.assertGreater(len(on_table), 0.5 * len(points))
        self.assertGreater(len(on_walls), 0.2 * len(points))
        self.assertGreater(len(on_table) + len(on_walls), 0.95 * len(points))


if __name__ == "__main__":
    unittest.main()
