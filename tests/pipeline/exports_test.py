"""tetrec-surface's files, as programs that are not ours read them."""
import json
import pathlib
import re
import shutil
import subprocess

from stage_case import StageCase
from tiny_dataset import RADIUS

# Debian's Python, for which Debian's meshio is installed; another may come first in PATH.
PYTHON = pathlib.Path("/usr/bin/python3")
MESHIO = """
import json, sys, meshio
mesh = meshio.read(sys.argv[1])
print(json.dumps([mesh.points.min(axis=0).tolist(), mesh.points.max(axis=0).tolist()]))
"""


class ExportsTest(StageCase):

    def setUp(self):
        super().setUp()
        if not shutil.which("assimp") or subprocess.run([PYTHON, "-c", "import meshio"], check=False,
                                                        capture_output=True).returncode:
            self.skipTest("assimp-utils or python3-meshio is not installed (scripts/setup.sh)")

    def extent(self, path):
        """The smallest and the largest corner of what a file contains."""
        if path.suffix in (".vtu", ".mesh", ".msh"):
            command = [PYTHON, "-c", MESHIO, path]
        else:
            command = ["assimp", "info", path]
        result = subprocess.run(command, check=False, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, f"{path.name}: {result.stdout}{result.stderr}")
        if command[0] == PYTHON:
            return json.loads(result.stdout.splitlines()[-1])
        corners = [re.search(rf"{name} point\s+\(([^)]*)\)", result.stdout) for name in ("Minimum", "Maximum")]
        return [[float(number) for number in corner.group(1).split()] for corner in corners]

    def check_cameras(self, field, scene):
        """Cameras and points, in the input's coordinates, as COLMAP and our own import read them."""
        out = self.folder / "run" / "cameras"
        self.assert_done(self.run_stage("surface", field, "-o", out, "--formats", "colmap,transforms",
                                        "--texture", "off", "--coordinates", "input"))
        views = len(scene["views"])
        self.assertEqual(self.manifest(out)["counts"]["exported_cameras"], views)
        colmap = subprocess.run(["colmap", "model_converter", "--input_path", out / "sparse" / "0",
                                 "--output_path", self.folder, "--output_type", "TXT"],
                                check=False, capture_output=True, text=True)
        self.assertEqual(colmap.returncode, 0, colmap.stdout + colmap.stderr)
        lines = [line.split() for line in (self.folder / "images.txt").read_text().splitlines()
                 if line and not line.startswith("#")]
        self.assertEqual(sorted(line[9] for line in lines),
                         sorted(view["image"].removeprefix("images/") for view in scene["views"]))
        transforms = json.loads((out / "transforms.json").read_text())
        self.assertEqual(len(transforms["frames"]), views)
        lists = [transforms[f"{split}_filenames"] for split in ("train", "val", "test")]
        self.assertEqual(sorted(sum(lists, [])), sorted(frame["file_path"] for frame in transforms["frames"]))
        self.assertTrue(all((out / frame["file_path"]).exists() for frame in transforms["frames"]))
        # A view that the fit left out is not exported.
        left_out = field / "left_out.json"
        left_out.write_text(json.dumps({"schema": 1, "views": [{"name": scene["views"][0]["name"]}]}))
        self.assert_done(self.run_stage("surface", field, "-o", self.folder / "fewer", "--formats", "transforms",
                                        "--texture", "off"))
        self.assertEqual(self.manifest(self.folder / "fewer")["counts"]["exported_cameras"], views - 1)
        left_out.unlink()
        # Data sets of their own, because an import reads nothing outside of its folder.
        for kind in ("posed", "modelled"):
            data = self.folder / kind
            shutil.copytree(self.folder / "run" / "1_scene" / "images", data / "images")
            if kind == "posed":
                text = (out / "transforms.json").read_text().replace("../1_scene/images", "images")
                (data / "transforms.json").write_text(text)
            else:
                shutil.copytree(out / "sparse", data / "sparse")
            again = self.folder / (kind + "_scene")
            self.assert_done(self.run_stage("import", data, "-o", again))
            self.assert_same_cameras(scene, json.loads((again / "scene.json").read_text()))

    def assert_same_cameras(self, scene, other):
        """In the input's coordinates."""
        def poses(some):
            way = some["input_from_world"]
            for view in sorted(some["views"], key=lambda view: pathlib.Path(view["image"]).parts[-2:]):
                pose = view["cam_from_world"]
                centre = [-sum(pose["rotation"][i][j] * pose["translation"][i] for i in range(3)) for j in range(3)]
                yield [way["scale"] * sum(way["rotation"][i][j] * centre[j] for j in range(3)) + way["translation"][i]
                       for i in range(3)]
                for axis in pose["rotation"]:
                    yield [sum(axis[j] * way["rotation"][i][j] for j in range(3)) for i in range(3)]
                camera = some["cameras"][view["camera"]]
                yield [camera[name] for name in ("width", "height", "fx", "fy", "cx", "cy")]
        for one, two in zip(poses(scene), poses(other), strict=True):
            for a, b in zip(one, two, strict=True):
                self.assertAlmostEqual(a, b, places=6)

    def test_every_file_is_upright_in_one_frame_and_others_read_it(self):
        field = self.folder / "run" / "3_field"
        self.assert_done(self.run_stage("optimize", self.tiny_tetrahedra(), "-o", field,
                                        "--time-limit", 0, "--iterations", 150))
        scene = json.loads((self.folder / "run" / "1_scene" / "scene.json").read_text())
        radius = RADIUS / scene["input_from_world"]["scale"]

        # Of the ball and of the space around it only what is above its centre.
        upper = self.folder / "upper"
        self.assert_done(self.run_stage(
            "surface", field, "-o", upper, "--formats", "ply,obj,glb,stl,vtu,mesh,msh",
            "--crop", f"-9,-9,{-0.1 * radius},9,9,9"))
        for path in sorted(upper.iterdir()):
            if path.stem not in ("surface", "field") or path.suffix in (".png", ".mtl"):
                continue
            with self.subTest(path.name):
                low, high = self.extent(path)
                up = 1 if path.suffix in (".obj", ".glb") else 2
                self.assertGreaterEqual(low[up], -0.1 * radius - 1e-6)
                if path.stem == "surface":
                    self.assertAlmostEqual(low[up], -0.1 * radius, places=5)
                for axis in range(3):
                    if axis != up:
                        self.assertLess(low[axis], -0.7 * radius)
                    self.assertGreater(high[axis], 0.7 * radius)
        self.assertEqual(len(list(upper.glob("surface.*"))), 6)  # with surface.png and surface.mtl
        self.assertIn("surface.png", (upper / "surface.mtl").read_text())
        self.assertGreater(self.manifest(upper)["counts"]["texture"]["seen_share"], 0.5)
        self.assertEqual(len(list(upper.glob("field.*"))), 3)
        self.assertGreater(self.manifest(upper)["counts"]["triangles_out_of_crop"], 0)

        few = self.folder / "few"
        faces = self.manifest(upper)["counts"]["triangles"] // 2
        for limit in (faces, 1):
            result = self.run_stage("surface", field, "-o", few, "--texture", "off", "--formats", "ply",
                                    "--max-faces", limit, "--crop", f"-9,-9,{-0.1 * radius},9,9,9")
            self.assert_done(result)
            self.assertEqual(self.manifest(few)["counts"]["triangles"] <= limit, limit == faces)
            self.assertEqual("triangles are left instead of 1," in result.stderr, limit == 1)

        self.check_cameras(field, scene)

        # In the input's coordinates, where the ball has RADIUS, and in metres of a known distance.
        for name, options, expected in (
                ("input", ("--coordinates", "input"), RADIUS),
                ("metres", ("--known-distance", "0,0,0,0,0,0.5,2"), 4 * radius),
                ("tenfold", ("--scale", 10), 10 * radius)):
            with self.subTest(name):
                self.assert_done(self.run_stage("surface", field, "-o", self.folder / name,
                                                "--formats", "glb", *options))
                for file in ("surface.ply", "surface.glb"):
                    _, high = self.extent(self.folder / name / file)
                    for axis in range(3):
                        self.assertAlmostEqual(high[axis] / expected, 1, delta=0.25)
                self.assertFalse((self.folder / name / "surface.obj").exists())
                # What was cropped above had been aligned as a whole.
                for alignment in ("photo_alignment", "texture_alignment"):
                    self.assertEqual(self.manifest(self.folder / name)["counts"][alignment],
                                     self.manifest(upper)["counts"][alignment])
                way_back = self.manifest(self.folder / name)["notes"]["input_from_surface"]
                self.assertAlmostEqual(way_back["scale"] * expected / RADIUS, 1, places=6)

        self.assert_fails(self.run_stage("surface", field, "-o", self.folder / "x", "--crop", "8,8,8,9,9,9"),
                          3, "crop")
        # A slice contains part of the surface, but no whole tet: this is known before the work begins.
        slice_ = self.run_stage("surface", field, "-o", self.folder / "x", "--formats", "vtu",
                                "--crop", f"-9,-9,0,9,9,{0.001 * radius}")
        self.assert_fails(slice_, 3, "no whole tet", "crop")
        self.assertNotIn("level set", slice_.stderr)
        # Without a texture, or without the photos that it would be made from.
        plain = self.folder / "plain"
        self.assert_done(self.run_stage("surface", field, "-o", plain, "--texture", "off"))
        self.assertFalse((plain / "surface.png").exists() or (plain / "surface.mtl").exists())
        self.assertNotIn("texture_alignment", self.manifest(plain)["counts"])
        self.assert_fails(self.run_stage("surface", field, "-o", self.folder / "x", "--texture", "10"),
                          2, "--texture", "64 to 8192")
        shutil.rmtree(self.folder / "run" / "1_scene")
        alone = self.run_stage("surface", field, "-o", self.folder / "alone")
        self.assert_done(alone)
        self.assertIn("only vertex colours", alone.stderr)
        self.assert_fails(self.run_stage("surface", field, "-o", self.folder / "x", "--texture", "1024"),
                          3, "1_scene")

        self.assert_fails(self.run_stage("surface", field, "-o", self.folder / "x", "--formats", "fbx"),
                          2, "--formats", "fbx")
        self.assert_fails(self.run_stage("surface", field, "-o", self.folder / "x", "--known-distance",
                                         "1,1,1,1,1,1,2"), 2, "--known-distance", "two different points")
