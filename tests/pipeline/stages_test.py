"""How stages behave in a chain: wrong and missing folders, second runs, changed options."""
import json
import shutil
import unittest

from stage_case import StageCase, hashes
from tiny_dataset import join_splits, write_tiny_dataset

STAGES = ("sfm", "import", "tetrahedralize", "optimize", "render", "surface", "evaluate")


class StagesTest(StageCase):

    def test_every_stage_has_help_and_ends_with_0(self):
        for stage in (*STAGES, "chart", "bench"):
            with self.subTest(stage):
                result = self.run_stage(stage, "--help")
                self.assert_done(result)
                self.assertIn("--output", result.stdout)

    def test_an_unknown_option_is_a_usage_error(self):
        for stage in STAGES:
            with self.subTest(stage):
                result = self.run_stage(stage, self.folder, "-o", self.folder / "out", "--no-such", "1")
                self.assert_fails(result, 2, "--no-such")
                self.assertFalse((self.folder / "out").exists())

    def test_an_integral_that_does_not_exist_is_a_usage_error(self):
        for stage in ("optimize", "render"):
            for words in ("cubic", "split:0", "split:65", "split:4x"):
                with self.subTest(stage=stage, words=words):
                    result = self.run_stage(stage, self.folder, "-o", self.folder / "out",
                                            "--integral", words)
                    self.assert_fails(result, 2, "--integral", words)
                    self.assertFalse((self.folder / "out").exists())

    def test_only_the_reference_renderer_has_a_precision(self):
        for stage in ("optimize", "render"):
            result = self.run_stage(stage, self.folder, "-o", self.folder / "out", "--precision", "float")
            self.assert_fails(result, 2, "--precision float", "renderer reference")

    def test_the_reference_renderer_has_no_device(self):
        for stage in ("optimize", "render"):
            result = self.run_stage(stage, self.folder, "-o", self.folder / "out", "--renderer", "reference",
                                    "--device", "cpu")
            self.assert_fails(result, 2, "--device cpu", "renderer reference", "leave it out")

    def test_a_missing_input_folder_is_bad_data(self):
        for stage in STAGES:
            with self.subTest(stage):
                missing = self.folder / "not-there"
                result = self.run_stage(stage, missing, "-o", self.folder / "out")
                self.assert_fails(result, 3, str(missing))
                self.assertFalse((self.folder / "out" / "manifest.json").exists())

    def test_a_folder_of_another_stage_is_recognised(self):
        scene = self.tiny_scene()
        for stage in ("optimize", "render", "surface", "evaluate"):
            with self.subTest(stage):
                result = self.run_stage(stage, scene, "-o", self.folder / "out")
                self.assert_fails(result, 3, str(scene), "tetrec-")
                self.assertFalse((self.folder / "out" / "manifest.json").exists())

    def test_a_folder_of_no_stage_is_refused(self):
        plain = self.folder / "plain"
        plain.mkdir()
        (plain / "notes.txt").write_text("mine")
        for stage in ("tetrahedralize", "optimize", "render", "surface", "evaluate"):
            with self.subTest(stage):
                self.assert_fails(self.run_stage(stage, plain, "-o", self.folder / "out"), 3, str(plain))

    def test_foreign_folders_are_not_written_to(self):
        write_tiny_dataset(self.folder / "ball")
        mine = self.folder / "mine"
        mine.mkdir()
        (mine / "notes.txt").write_text("mine")
        result = self.run_stage("import", self.folder / "ball", "-o", mine)
        self.assert_fails(result, 2, str(mine))
        self.assertEqual([path.name for path in mine.iterdir()], ["notes.txt"])

    def test_one_transforms_json_gives_the_same_scene_as_its_splits(self):
        write_tiny_dataset(self.folder / "ball", train=12)
        scenes = []
        names = "test/r_0\ntest/r_1.png\r\n\ntest/r_2\ntest/r_3\n"
        (self.folder / "list.txt").write_text(names)
        bounds = "--bounds=-1,-1,-1,1,1,1"
        for name in ("splits", "joined"):
            scene = self.folder / name
            self.assert_done(self.run_stage("import", self.folder / "ball", "-o", scene, "--downscale", 2, bounds,
                                            "--test-list", self.folder / "list.txt"))
            content = json.loads((scene / "scene.json").read_text())
            content["views"].sort(key=lambda view: view["name"])
            # fl_x and camera_angle_x differ in their last digit.
            for camera in content["cameras"]:
                for key, value in camera.items():
                    camera[key] = round(value, 9)
            scenes.append((content, self.manifest(scene)["counts"], hashes(scene / "images")))
            if name == "splits":
                join_splits(self.folder / "ball")
        self.assertEqual(scenes[0], scenes[1])
        self.assertEqual(scenes[0][1]["test_views"], 4)
        self.assertEqual(scenes[0][1]["train_views"], 14)

    def test_a_second_run_is_up_to_date_and_changes_nothing(self):
        scene = self.tiny_scene()
        before = (scene / "manifest.json").stat().st_mtime_ns
        result = self.run_stage("import", self.folder / "ball", "-o", scene)
        self.assert_done(result)
        self.assertIn("up to date", result.stdout)
        self.assertEqual((scene / "manifest.json").stat().st_mtime_ns, before)

    def test_another_option_starts_over_and_going_back_gives_the_same_bytes(self):
        tetrahedra = self.tiny_tetrahedra()
        scene = tetrahedra.parent / "1_scene"
        first, key = hashes(tetrahedra), self.manifest(tetrahedra)["key"]
        again = ("tetrahedralize", scene, "-o", tetrahedra, "--resolution", 16, "--outer-points", 50)
        self.assert_done(self.run_stage(*again, "--seed", 2))
        self.assertNotEqual(hashes(tetrahedra), first)
        self.assertNotEqual(self.manifest(tetrahedra)["key"], key)
        self.assert_done(self.run_stage(*again))
        self.assertEqual(hashes(tetrahedra), first)
        self.assertEqual(self.manifest(tetrahedra)["key"], key)

    def test_a_changed_input_makes_a_stage_run_again(self):
        scene = self.tiny_scene()
        key = self.manifest(scene)["key"]
        picture = self.folder / "ball" / "train" / "r_0.png"
        picture.write_bytes((self.folder / "ball" / "train" / "r_1.png").read_bytes())
        result = self.run_stage("import", self.folder / "ball", "-o", scene)
        self.assert_done(result)
        self.assertNotIn("up to date", result.stdout)
        self.assertNotEqual(self.manifest(scene)["key"], key)

    def test_another_background_of_the_scene_makes_the_later_stages_run_again(self):
        tetrahedra, field = self.tiny_tetrahedra(), self.folder / "run" / "3_field"
        optimize = ("optimize", tetrahedra, "-o", field, "--time-limit", 0, "--iterations", 2, "--renderer", "reference")
        mesh = hashes(tetrahedra)
        self.assert_done(self.run_stage(*optimize))
        self.assertIn("up to date", self.run_stage(*optimize).stdout)
        self.assert_done(self.run_stage("import", self.folder / "ball", "-o", self.folder / "run" / "1_scene",
                                        "--background", "black"))
        self.assert_done(self.run_stage("tetrahedralize", self.folder / "run" / "1_scene", "-o", tetrahedra,
                                        "--resolution", 16, "--outer-points", 50))
        self.assertEqual(hashes(tetrahedra), mesh)
        result = self.run_stage(*optimize)
        self.assert_done(result)
        self.assertNotIn("up to date", result.stdout)

    def test_without_held_out_views_training_views_are_rendered_and_a_new_scene_refuses_their_scores(self):
        write_tiny_dataset(self.folder / "ball")
        run = self.folder / "run"
        scene, tetrahedra, field, views = (run / name for name in ("1_scene", "2_tetrahedra", "3_field", "4_views"))
        self.assert_done(self.run_stage("import", self.folder / "ball", "-o", scene, "--holdout", 0))
        self.assert_done(self.run_stage("tetrahedralize", scene, "-o", tetrahedra, "--resolution", 8,
                                        "--outer-points", 20))
        self.assert_done(self.run_stage("optimize", tetrahedra, "-o", field, "--time-limit", 0, "--iterations", 2,
                                        "--renderer", "reference"))
        result = self.run_stage("render", field, "-o", views, "--renderer", "reference", "--samples", 1)
        self.assert_done(result)
        self.assertIn("warning: no view is held out", result.stderr)
        self.assertEqual(json.loads((views / "views.json").read_text())["split"], "train")
        self.assert_done(self.run_stage("evaluate", views, "-o", run / "6_report"))
        # An orbit goes by all cameras.
        if shutil.which("ffmpeg"):
            self.assert_done(self.run_stage("render", field, "-o", run / "video", "--renderer", "reference",
                                            "--samples", 1, "--path", "orbit", "--frames", 1, "--size", 16))
        self.assert_done(self.run_stage("import", self.folder / "ball", "-o", scene, "--holdout", 0,
                                        "--background", "black"))
        result = self.run_stage("evaluate", views, "-o", run / "other_report")
        self.assert_fails(result, 3, "1_scene: was recreated since", "run tetrec-tetrahedralize")

    def test_a_stage_folder_may_be_a_link(self):
        elsewhere = self.folder / "disk" / "a" / "tetrahedra"
        elsewhere.mkdir(parents=True)
        (self.folder / "run").mkdir()
        (self.folder / "run" / "2_tetrahedra").symlink_to(elsewhere)
        self.assert_done(self.run_stage("optimize", self.tiny_tetrahedra(), "-o", self.folder / "run" / "3_field",
                                        "--time-limit", 0, "--iterations", 2))

    def test_a_lost_output_is_made_again(self):
        scene = self.tiny_scene()
        before = hashes(scene)
        (scene / "images" / "train" / "r_3.png").unlink()
        self.assert_done(self.run_stage("import", self.folder / "ball", "-o", scene))
        self.assertEqual(hashes(scene), before)

    def test_resume_refuses_a_run_with_other_options(self):
        tetrahedra = self.tiny_tetrahedra()
        result = self.run_stage("tetrahedralize", tetrahedra.parent / "1_scene", "-o", tetrahedra,
                                "--resolution", 8, "--resume")
        self.assert_fails(result, 3, "resolution (was 16, now 8)")

    def test_the_manifest_records_what_was_done(self):
        tetrahedra = self.tiny_tetrahedra()
        manifest = self.manifest(tetrahedra)
        self.assertEqual(manifest["stage"], "tetrahedralize")
        self.assertEqual(manifest["options"]["resolution"], 16)
        self.assertEqual(manifest["previous"], "../1_scene")
        self.assertGreater(manifest["counts"]["tets"], 1000)
        self.assertGreater(manifest["peak_rss_bytes"], 0)
        outputs = {output["path"]: output["sha256"] for output in manifest["outputs"]}
        self.assertEqual(outputs, {k: v for k, v in hashes(tetrahedra).items() if k in outputs})
        self.assertIn("mesh.tet", outputs)
        self.assertIn("field.tetf", outputs)


if __name__ == "__main__":
    unittest.main()
