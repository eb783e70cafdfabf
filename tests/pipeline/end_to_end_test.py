"""Small scenes from input to report: the programs fit together and the result is the subject."""
import csv
import json
import math
import os
import pathlib
import shutil
import re
import sqlite3
import struct
import subprocess
import unittest

from stage_case import StageCase
from tiny_dataset import (DISTANCE, FOV_RAD, RADIUS, SIZE, write_png, write_tiny_dataset,
                          write_tiny_photos)

ROOT = pathlib.Path(__file__).resolve().parents[2]
DEMO_PHOTOS = ROOT / "datasets_spec" / "demo" / "photos"
# Real data, if present.
DATASETS = pathlib.Path(os.environ.get("TETREC_DATASETS", ROOT / ".." / "shared" / "datasets"))
# Width of a pixel at the centre of the ball.
PIXEL = 2 * DISTANCE * math.tan(FOV_RAD / 2) / SIZE


def read_points(path):
    """Positions of the sparse points, which come first in each vertex of points.ply."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    sizes = {"double": 8, "float": 4, "uchar": 1, "uint": 4}
    words = [line.split() for line in header.decode().splitlines()]
    stride = sum(sizes[line[1]] for line in words if line[0] == "property")
    count = next(int(line[2]) for line in words if line[:2] == ["element", "vertex"])
    return [struct.unpack_from("<3d", body, stride * i) for i in range(count)]


def read_ply(path):
    """Positions and triangles of a surface as tetrec-surface writes it."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    counts = {words[1]: int(words[2]) for words in map(str.split, header.decode().splitlines())
              if words[0] == "element"}
    vertex = struct.Struct("<3f3B" if b"uchar red" in header else "<3f")
    face = struct.Struct("<B3iB6f" if b"texcoord" in header else "<B3i")
    positions = [vertex.unpack_from(body, i * vertex.size)[:3] for i in range(counts["vertex"])]
    start = counts["vertex"] * vertex.size
    triangles = [face.unpack_from(body, start + i * face.size)[1:4] for i in range(counts["face"])]
    return positions, triangles


def read_scene_points(path):
    """Positions and reprojection errors [px] of a scene's points.ply."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    point = struct.Struct("<3d3BfI")
    assert b"property double z\nproperty uchar red" in header and len(body) % point.size == 0, header
    rows = list(point.iter_unpack(body))
    return [row[:3] for row in rows], [row[6] for row in rows]


class EndToEndTest(StageCase):

    def test_a_ball_is_reconstructed_from_its_images(self):
        run = self.folder / "run"
        tetrahedra = self.tiny_tetrahedra()
        self.assert_done(self.run_stage("optimize", tetrahedra, "-o", run / "3_field",
                                        "--time-limit", 0, "--iterations", 400))
        self.assert_done(self.run_stage("render", run / "3_field", "-o", run / "4_views"))
        self.assert_done(self.run_stage("surface", run / "3_field", "-o", run / "5_surface",
                                        "--coordinates", "input"))
        self.assert_done(self.run_stage("evaluate", run / "4_views", run / "5_surface", "-o",
                                        run / "6_report"))

        rows = list(csv.DictReader((run / "3_field" / "metrics.csv").read_text().splitlines()))
        losses = [float(row["loss"]) for row in rows if row["loss"]]  # empty: nothing measured
        self.assertLess(losses[-1], 0.2 * losses[0])
        growth = json.loads((run / "3_field" / "growth.json").read_text())["steps"]
        self.assertIn("refine", [step["decision"] for step in growth])

        metrics = json.loads((run / "6_report" / "metrics.json").read_text())
        self.assertEqual(metrics["schema"], 1)
        self.assertEqual(metrics["background"], "white")
        self.assertEqual(metrics["resolution"], [SIZE, SIZE])
        self.assertEqual(metrics["rays_per_pixel"], 4)
        self.assertEqual(len(metrics["views"]), 4)
        # An image of the background alone has about 9 dB; 31 dB after a third of the iterations.
        self.assertGreater(metrics["psnr"], 27)

        # In the input's coordinates: the ball of RADIUS around the origin, half of it to within a
        # pixel and nine tenths to within three.
        positions, triangles = read_ply(run / "5_surface" / "surface.ply")
        errors = sorted(abs(math.dist(p, (0, 0, 0)) - RADIUS) for p in positions)
        self.assertLess(errors[len(errors) // 2], PIXEL)
        self.assertLess(errors[9 * len(errors) // 10], 3 * PIXEL)
        # Every edge of a closed surface is met once in each direction.
        edges = [(t[i], t[(i + 1) % 3]) for t in triangles for i in range(3)]
        self.assertEqual(len(edges), len(set(edges)))
        self.assertEqual(set(edges), {(b, a) for a, b in edges})

        report = (run / "6_report" / "report.html").read_text()
        self.assertIn("normals of view", report)
        self.assertIsNone(metrics["depth"])  # the true depth is not known
        self.assertIsNone(metrics["normals"])
        for view in json.loads((run / "4_views" / "views.json").read_text())["views"]:
            self.assertTrue((run / "4_views" / view["normals"]).read_bytes().startswith(b"v/1\x01"), view)
        # The page's policy keeps its scripts from the network; three.js names sites in comments.
        self.assertIn("default-src 'none'", report)
        markup = re.sub(r"<script>.*?</script>", "", report, flags=re.DOTALL)
        for outside in ("http://", "https://", "src=\"/", "file:"):
            self.assertFalse(outside in markup.replace("http://www.w3.org/", ""), outside)

        self.assert_done(self.run_stage("chart", run, "-o", self.folder / "chart"))
        self.assertTrue((self.folder / "chart" / "chart.svg").exists())
        self.assertTrue((self.folder / "chart" / "chart.png").exists())
        chart = json.loads((self.folder / "chart" / "chart.json").read_text())
        self.assertRegex(chart["runs"][0]["protocol"], r"^\d+ held-out views")
        judged = chart["runs"][0]["tets_judged_psnr_and_error"]
        self.assertEqual((self.folder / "chart" / "growth.svg").exists(), len(judged) > 1)

    def test_points_are_triangulated_on_lego(self):
        lego = DATASETS / "lego"
        if not lego.exists():
            self.skipTest(f"no data set at {lego} (TETREC_DATASETS)")
        out = self.folder / "scene"
        self.assert_done(self.run_stage("import", lego, "-o", out, "--triangulate"))
        scene = json.loads((out / "scene.json").read_text())
        self.assertEqual(scene["cameras"][0]["width"], 400)
        positions, errors_px = read_scene_points(out / "points.ply")
        self.assertEqual(len(positions), scene["point_count"])
        self.assertGreaterEqual(len(positions), 3000)
        self.assertLess(sum(errors_px) / len(errors_px), 1)
        place = scene["input_from_world"]
        box = scene["subject_bounds"]
        # The model's own extent, in the input's coordinates, a few hundredths wider.
        model = ((-0.68, 0.68), (-1.19, 1.19), (-0.53, 1.08))
        for position in positions:
            for axis in range(3):
                self.assertTrue(box["min"][axis] <= position[axis] <= box["max"][axis], position)
                in_input = place["scale"] * position[axis] + place["translation"][axis]
                self.assertTrue(model[axis][0] <= in_input <= model[axis][1], (axis, in_input))

    def test_masked_pixels_are_neither_learned_nor_judged(self):
        photos = self.folder / "photos"
        write_tiny_photos(photos)
        psnr = {}
        for masks in ("ignore", "none"):
            run = self.folder / masks
            self.assert_done(self.run_stage("import", photos, "-o", run / "1_scene", "--masks", masks,
                                            "--bounds", "-1,-1,-1,1,1,1"))
            scene = json.loads((run / "1_scene" / "scene.json").read_text())
            self.assertEqual((scene["has_alpha"], scene["has_masks"]), (False, masks == "ignore"))
            self.assert_done(self.run_stage("tetrahedralize", run / "1_scene", "-o", run / "2_tetrahedra",
                                            "--start", "grid", "--resolution", 12))
            self.assert_done(self.run_stage("optimize", run / "2_tetrahedra", "-o", run / "3_field",
                                            "--time-limit", 0, "--iterations", 300,
                                            "--background", "scene"))
            self.assert_done(self.run_stage("render", run / "3_field", "-o", run / "4_views"))
            self.assert_done(self.run_stage("evaluate", run / "4_views", "-o", run / "6_report"))
            metrics = json.loads((run / "6_report" / "metrics.json").read_text())
            psnr[masks] = metrics["psnr"]
            self.assertEqual(metrics["masked_views"], 4 if masks == "ignore" else 0)
            views = json.loads((run / "4_views" / "views.json").read_text())["views"]
            for view in views:
                self.assertEqual("seen" in view, masks == "ignore")
                if masks == "ignore":
                    self.assertTrue((run / "4_views" / view["seen"]).exists())
        self.assertGreater(psnr["ignore"], 29)
        self.assertLess(psnr["none"], 15)

    def test_views_whose_names_have_dots_and_slashes_keep_an_image_each(self):
        dataset, run = self.folder / "ball", self.folder / "run"
        write_tiny_dataset(dataset)
        transforms = dataset / "transforms_test.json"
        content = json.loads(transforms.read_text())
        names = ["frame.0000", "frame.0001", "a_b", "a/b"]
        (dataset / "test" / "a").mkdir()
        for i, (frame, name) in enumerate(zip(content["frames"], names, strict=True)):
            (dataset / "test" / f"r_{i}.png").rename(dataset / "test" / f"{name}.png")
            frame["file_path"] = f"./test/{name}.png"
        transforms.write_text(json.dumps(content))
        self.assert_done(self.run_stage("import", dataset, "-o", run / "1_scene"))
        self.assert_done(self.run_stage("tetrahedralize", run / "1_scene", "-o", run / "2_tetrahedra",
                                        "--start", "grid", "--resolution", 6))
        self.assert_done(self.run_stage("optimize", run / "2_tetrahedra", "-o", run / "3_field",
                                        "--time-limit", 0, "--iterations", 20))
        self.assert_done(self.run_stage("render", run / "3_field", "-o", run / "4_views"))
        self.assert_done(self.run_stage("evaluate", run / "4_views", "-o", run / "6_report"))
        views = json.loads((run / "4_views" / "views.json").read_text())["views"]
        self.assertEqual([view["name"] for view in views], [f"test/{name}" for name in names])
        self.assertEqual(len({view["mask"] for view in views}), 4)
        for kind in ("render", "ground_truth"):
            images = {(run / "4_views" / view[kind]).read_bytes() for view in views}
            self.assertEqual(len(images), 4, kind)
        # Four different views are scored, not one of them four times.
        scores = json.loads((run / "6_report" / "metrics.json").read_text())["views"]
        self.assertEqual(len({score["mse"] for score in scores}), 4, scores)

    def test_cells_go_through_every_stage(self):
        run = self.folder / "run"
        tetrahedra = self.tiny_tetrahedra()
        self.assert_done(self.run_stage("optimize", tetrahedra, "-o", run / "3_field", "--time-limit", 0,
                                        "--iterations", 200, "--storage", "cell",
                                        "--loss", "l1+dssim:0.2"))
        self.assertEqual((run / "3_field" / "field.tetf").read_bytes()[:8], b"TETRECF2")
        self.assert_done(self.run_stage("render", run / "3_field", "-o", run / "4_views"))
        self.assert_done(self.run_stage("surface", run / "3_field", "-o", run / "5_surface",
                                        "--coordinates", "input"))
        self.assert_done(self.run_stage("evaluate", run / "4_views", run / "5_surface", "-o",
                                        run / "6_report"))
        metrics = json.loads((run / "6_report" / "metrics.json").read_text())
        # An image of the background alone has about 9 dB.
        self.assertGreater(metrics["psnr"], 22)
        positions, _ = read_ply(run / "5_surface" / "surface.ply")
        errors = sorted(abs(math.dist(p, (0, 0, 0)) - RADIUS) for p in positions)
        self.assertLess(errors[len(errors) // 2], 3 * PIXEL)

    def test_the_reference_renderer_trains_and_renders_without_a_vulkan_driver(self):
        run = self.folder / "run"
        tetrahedra = self.tiny_tetrahedra()
        none = {"VK_ICD_FILENAMES": "/nowhere.json", "VK_DRIVER_FILES": "/nowhere.json"}
        self.assert_fails(self.run_stage("optimize", tetrahedra, "-o", run / "march", "--time-limit", 0,
                                         "--iterations", 1, environment=none), 4, "Vulkan")
        fields = []
        for name in ("a", "b"):
            fields.append(self.folder / name / "3_field")
            self.assert_done(self.run_stage(
                "optimize", tetrahedra, "-o", fields[-1], "--renderer", "reference", "--time-limit", 0,
                "--iterations", 60, "--rays", 512, "--rounds", 1, "--background", "scene", environment=none))
        # Although --deterministic was not given.
        self.assertEqual((fields[0] / "field.tetf").read_bytes(), (fields[1] / "field.tetf").read_bytes())
        rows = list(csv.DictReader((fields[0] / "metrics.csv").read_text().splitlines()))
        losses = [float(row["loss"]) for row in rows if row["loss"]]
        self.assertLess(losses[-1], 0.6 * losses[0])
        self.assertEqual(self.manifest(fields[0])["device"]["name"], "CPU, double precision")
        self.assert_done(self.run_stage("render", fields[0], "-o", run / "4_views", "--renderer", "reference",
                                        "--precision", "float", "--samples", 1, environment=none))
        # Four views; for each pixel a ray for the image and one for the depth.
        self.assertEqual(self.manifest(run / "4_views")["counts"]["rays"], 4 * 2 * SIZE * SIZE)

    def test_ten_photos_with_masks_become_a_scene_and_a_mesh(self):
        photos, masks = self.folder / "photos", self.folder / "masks"
        photos.mkdir()
        masks.mkdir()
        # White in an ellipse around the middle.
        rows = [bytes(255 * (((x - 320) / 200) ** 2 + ((y - 240) / 170) ** 2 < 1) for x in range(640))
                for y in range(480)]
        pixels = b"".join(bytes((level, level, level, 255)) for row in rows for level in row)
        for path in sorted(DEMO_PHOTOS.glob("*.jpg"))[:10]:
            shutil.copy(path, photos)
            write_png(masks / f"{path.stem}.png", 640, 480, pixels)
        if shutil.which("heif-enc"):
            subprocess.run(["heif-enc", "-q", "95", photos / "0003.jpg", "-o", photos / "0003.heic"], check=True,
                           capture_output=True)
            (photos / "0003.jpg").unlink()
        scene = self.folder / "run" / "1_scene"
        self.assert_done(self.run_stage("sfm", photos, "-o", scene, "--max-size", 160, "--max-features", 1500,
                                        "--masks", masks))
        self.assertTrue(json.loads((scene / "scene.json").read_text())["has_masks"])
        self.assert_points_are_in_masks(scene, rows)
        content = json.loads((scene / "scene.json").read_text())
        # Ten neighbouring views in steps of 9 degrees: all are registered, every 8th is held out.
        self.assertEqual(len(content["views"]), 10)
        self.assertEqual([view["split"] for view in content["views"]].count("test"), 2)
        self.assertTrue(all(max(camera["width"], camera["height"]) <= 160
                            for camera in content["cameras"]))
        self.assertGreater(content["point_count"], 200)
        tetrahedra = self.folder / "run" / "2_tetrahedra"
        self.assert_done(self.run_stage("tetrahedralize", scene, "-o", tetrahedra))
        self.assertGreater(self.manifest(tetrahedra)["counts"]["tets"], 1000)

    def assert_points_are_in_masks(self, scene, rows):
        """No feature is where the mask is black, and so nothing that a sparse point is made of; each point is
        seen where at least two masks are white."""
        (database,) = scene.glob("colmap/*/features.db")
        features = 0
        for count, columns, data in sqlite3.connect(database).execute("SELECT rows, cols, data FROM keypoints"):
            values = struct.unpack(f"<{count * columns}f", data)
            features += count
            for x, y in zip(values[::columns], values[1::columns]):
                self.assertEqual(rows[int(y)][int(x)], 255, (x, y))
        self.assertGreater(features, 5000)
        content = json.loads((scene / "scene.json").read_text())
        for point in read_points(scene / "points.ply"):
            seen = 0
            for view in content["views"]:
                camera, pose = content["cameras"][view["camera"]], view["cam_from_world"]
                x, y, z = (sum(r * p for r, p in zip(row, point)) + t
                           for row, t in zip(pose["rotation"], pose["translation"]))
                u, v = camera["fx"] * x / z + camera["cx"], camera["fy"] * y / z + camera["cy"]
                # The ellipse, 2 % larger for the lens, which is not quite a pinhole.
                dx, dy = u / camera["width"] - 0.5, v / camera["height"] - 0.5
                seen += z > 0 and (dx * 640 / 200) ** 2 + (dy * 480 / 170) ** 2 < 1.02 ** 2
            self.assertGreaterEqual(seen, 2, point)

    def test_a_name_with_spaces_and_quotes_is_a_name(self):
        dataset = self.folder / "a 'ball' $(touch oops); \"x\""
        write_tiny_dataset(dataset, train=12)
        scene, tetrahedra = self.folder / "1 scene's", self.folder / "2 $HOME"
        self.assert_done(self.run_stage("import", dataset, "-o", scene))
        # TetGen is another program: names must reach it whole.
        self.assert_done(self.run_stage("tetrahedralize", scene, "-o", tetrahedra, "--start", "tetgen",
                                        "--resolution", 6))
        self.assertTrue((tetrahedra / "field.tetf").exists())


if __name__ == "__main__":
    unittest.main()
