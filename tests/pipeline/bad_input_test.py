"""Bad data and a bad environment: one clear line, the right exit code, nothing half done."""
import json
import shutil
import subprocess
import unittest

from stage_case import StageCase, limit_file_size
from tiny_dataset import join_splits, write_png, write_tiny_dataset


class BadInputTest(StageCase):

    def photos(self, count):
        """Photos without texture, as PNGs."""
        write_tiny_dataset(self.folder / "ball")
        folder = self.folder / "photos"
        folder.mkdir()
        for i in range(count):
            shutil.copy(self.folder / "ball" / "train" / f"r_{i}.png", folder)
        return folder

    def test_sfm_of_no_photos(self):
        result = self.run_stage("sfm", self.photos(0), "-o", self.folder / "out")
        self.assert_fails(result, 3, str(self.folder / "photos"))

    def test_a_start_refuses_options_of_others(self):
        scene = self.folder / "scene"
        write_tiny_dataset(self.folder / "ball")
        self.assert_done(self.run_stage("import", self.folder / "ball", "-o", scene))
        for start, option in (("carve", "--dense-points"), ("grid", "--far-share"), ("dense", "--resolution"),
                              ("points", "--depth-size"), ("tetgen", "--outer-points")):
            self.assert_fails(self.run_stage("tetrahedralize", scene, "-o", self.folder / "out", "--start", start,
                                             option, 1), 2, option, f"no effect with --start {start}")

    def test_refused_data_leaves_the_scene_that_is_there(self):
        scene = self.tiny_scene()
        manifest = self.manifest(scene)
        self.assert_fails(self.run_stage("import", self.folder / "ball", "-o", scene, "--masks", "subject"), 3,
                          "masks: subject needs masks")
        picture = self.folder / "ball" / "train" / "r_2.png"
        whole = picture.read_bytes()
        picture.write_bytes(whole[:100])
        self.assert_fails(self.run_stage("import", self.folder / "ball", "-o", scene), 3, "r_2.png")
        picture.write_bytes(whole)
        transforms = self.folder / "ball" / "transforms_train.json"
        transforms.write_text(transforms.read_text()[:-9])
        self.assert_fails(self.run_stage("import", self.folder / "ball", "-o", scene), 3, "transforms_train.json")
        self.assertEqual(self.manifest(scene), manifest)
        self.assertTrue((scene / "scene.json").exists())
        self.assertEqual(sorted(path.name for path in scene.iterdir() if path.is_dir()), ["images"])

    def test_sfm_of_one_photo_or_two(self):
        photos = self.photos(1)
        self.assert_fails(self.run_stage("sfm", photos, "-o", self.folder / "out"), 3, "only 1 photo (r_0.png)")
        shutil.copy(photos / "r_0.png", photos / "r_1.png")
        self.assert_fails(self.run_stage("sfm", photos, "-o", self.folder / "out"), 3, "only 2 photos", "at least 3")

    def test_sfm_of_photos_without_features_finds_no_model(self):
        result = self.run_stage("sfm", self.photos(4), "-o", self.folder / "out")
        self.assert_fails(result, 3)
        self.assertFalse((self.folder / "out" / "manifest.json").exists())

    def test_sfm_names_a_truncated_photo(self):
        photos = self.photos(4)
        whole = (photos / "r_2.png").read_bytes()
        (photos / "r_2.png").write_bytes(whole[:len(whole) // 2])
        strict = self.run_stage("sfm", photos, "-o", self.folder / "out", "--max-unreadable", 0)
        self.assert_fails(strict, 3, "1 of 4 photos cannot be read, and max-unreadable is 0", "r_2.png")
        self.assertIn("warning: 1 of 4 photos cannot be read and are left out: ",
                      self.run_stage("sfm", photos, "-o", self.folder / "out").stderr)

    def test_sfm_of_masks_that_do_not_fit(self):
        photos, masks = self.photos(4), self.folder / "masks"
        masks.mkdir()

        def run(exit_code, *parts, folder=masks):
            self.assert_fails(self.run_stage("sfm", photos, "-o", self.folder / "out", "--masks", folder),
                              exit_code, *parts)

        run(2, "--masks is", "the folder of the photos", folder=photos)
        run(3, "4 of 4 photos have no mask: r_0.png")
        for i in range(4):
            write_png(masks / f"r_{i}.png", 32, 32, bytes((0, 0, 0, 255)) * 32 * 32)
        run(3, "the masks of 4 of 4 photos leave no pixel", "inverted")
        write_png(masks / "r_1.png", 32, 24, bytes([255]) * 4 * 32 * 24)
        (masks / "r_2.png").write_text("no image")
        run(3, "2 of 4 masks cannot be used", "r_1.png: mask of 32 x 24 pixels for a photo of 32 x 32", "r_2.png")
        (self.folder / "walk.mp4").write_text("no video")
        self.assert_fails(self.run_stage("sfm", self.folder / "walk.mp4", "-o", self.folder / "out",
                                         "--masks", masks), 2, "--masks is", "PHOTOS is a video")

    def test_sfm_of_heic_without_its_reader_in_path(self):
        photos = self.photos(4)
        (photos / "a.heic").write_bytes(b"\0\0\0\x18ftypheic" + bytes(100))
        result = self.run_stage("sfm", photos, "-o", self.folder / "out", environment={"PATH": str(self.folder)})
        self.assert_fails(result, 4, "a.heic: heif-convert", "apt-get install", "libheif-examples")

    def test_a_heic_photo_that_cannot_be_written_is_no_damaged_photo(self):
        photos, programs = self.photos(4), self.folder / "programs"
        (photos / "a.heic").write_bytes(b"\0\0\0\x18ftypheic" + bytes(100))
        programs.mkdir()
        # Like the real one on a full disk, it reports success.
        (programs / "heif-convert").write_text("#!/bin/sh\nprintf '\\377\\330\\377\\340' > photo.jpg\n")
        (programs / "heif-convert").chmod(0o755)
        result = self.run_stage("sfm", photos, "-o", self.folder / "out", environment={"PATH": str(programs)})
        self.assert_fails(result, 4, "heif-convert did not write all of", "free some space")
        self.assertEqual(list((self.folder / "out" / "photos").iterdir()), [])

    def test_sfm_without_colmap_in_path(self):
        result = self.run_stage("sfm", self.photos(4), "-o", self.folder / "out",
                                environment={"PATH": str(self.folder)})
        self.assert_fails(result, 4, "colmap")

    def test_triangulation_without_colmap_in_path(self):
        write_tiny_dataset(self.folder / "ball")
        result = self.run_stage("import", self.folder / "ball", "--triangulate", "-o", self.folder / "out",
                                environment={"PATH": str(self.folder)})
        self.assert_fails(result, 4, "colmap")

    def test_import_of_a_colmap_text_model_names_the_line(self):
        model = self.folder / "set" / "sparse"
        model.mkdir(parents=True)
        (model / "cameras.txt").write_text("# cameras\n1 PINHOLE 64 48 60 sixty 32 24\n")
        (model / "images.txt").write_text("")
        (model / "points3D.txt").write_text("")
        result = self.run_stage("import", self.folder / "set", "-o", self.folder / "out")
        self.assert_fails(result, 3, "cameras.txt: line 2", "sixty")

    def test_import_names_a_truncated_picture(self):
        write_tiny_dataset(self.folder / "ball")
        picture = self.folder / "ball" / "train" / "r_2.png"
        picture.write_bytes(picture.read_bytes()[:100])
        result = self.run_stage("import", self.folder / "ball", "-o", self.folder / "out")
        self.assert_fails(result, 3, "r_2.png")

    def test_import_names_a_missing_picture(self):
        write_tiny_dataset(self.folder / "ball")
        (self.folder / "ball" / "test" / "r_1.png").unlink()
        result = self.run_stage("import", self.folder / "ball", "-o", self.folder / "out")
        self.assert_fails(result, 3, "test/r_1", "1 of 46 images are missing", "skip missing images", "tetrec-sfm")

    def test_missing_pictures_are_skipped_and_counted(self):
        write_tiny_dataset(self.folder / "ball", train=8)
        (self.folder / "ball" / "train" / "r_1.png").unlink()
        out = self.folder / "out"
        result = self.run_stage("import", self.folder / "ball", "-o", out, "--skip-missing")
        self.assert_done(result)
        self.assertIn("left out: 1: train/r_1", result.stderr)
        counts = self.manifest(out)["counts"]
        self.assertEqual((counts["pictures_skipped"], counts["train_views"]), (1, 7))
        # The option is part of the key: without it the folder is not up to date.
        self.assert_fails(self.run_stage("import", self.folder / "ball", "-o", out), 3, "train/r_1")

    def test_import_of_broken_json_states_where(self):
        write_tiny_dataset(self.folder / "ball")
        (self.folder / "ball" / "transforms_train.json").write_text('{"camera_angle_x": 0.8, "frames": [')
        result = self.run_stage("import", self.folder / "ball", "-o", self.folder / "out")
        self.assert_fails(result, 3, "transforms_train.json")

    def test_import_options_that_contradict_each_other(self):
        write_tiny_dataset(self.folder / "ball", train=8)
        (self.folder / "list.txt").write_text("test/r_9\n")
        for options, parts in ((("--downscale", 2, "--max-size", 100), ("--downscale", "--max-size")),
                               (("--test-list", self.folder / "list.txt", "--holdout", 8),
                                ("--test-list", "--holdout")),
                               (("--downscale", 0.5), ("--downscale is 0.5", "1 to 1024")),
                               (("--bounds", "0,0,0,1,1"), ("--bounds",)),
                               (("--bounds", "0,0,0,1,-1,1"), ("--bounds is 0,0,0,1,-1,1",))):
            with self.subTest(options):
                result = self.run_stage("import", self.folder / "ball", "-o", self.folder / "out", *options)
                self.assert_fails(result, 2, *parts)
                self.assertFalse((self.folder / "out").exists())
        result = self.run_stage("import", self.folder / "ball", "-o", self.folder / "out", "--test-list",
                                self.folder / "list.txt")
        self.assert_fails(result, 3, "list.txt: line 1", "test/r_9")

    def test_import_of_an_unsupported_lens(self):
        write_tiny_dataset(self.folder / "ball", train=8)
        join_splits(self.folder / "ball")
        path = self.folder / "ball" / "transforms.json"
        transforms = json.loads(path.read_text())
        for field, value, part in (("camera_model", "EQUIRECTANGULAR", "OPENCV_FISHEYE"),
                                   ("fl_x", -3, "fl_x is -3"), ("w", 33, "33 x 32")):
            with self.subTest(field):
                path.write_text(json.dumps(transforms | {field: value}))
                result = self.run_stage("import", self.folder / "ball", "-o", self.folder / "out")
                self.assert_fails(result, 3, part)

    def test_a_damaged_field_is_refused(self):
        tetrahedra = self.tiny_tetrahedra()
        field = tetrahedra / "field.tetf"
        damaged = bytearray(field.read_bytes())
        damaged[8:24] = b"TETRECM1" + b"\xff" * 8  # as many vertices as a u64 holds
        field.write_bytes(damaged)
        result = self.run_stage("optimize", tetrahedra, "-o", self.folder / "run" / "3_field")
        self.assert_fails(result, 3, "field.tetf")

    def test_contradicting_options_leave_a_finished_run_alone(self):
        out = self.folder / "run" / "3_field"
        tetrahedra = self.tiny_tetrahedra()
        self.assert_done(self.run_stage("optimize", tetrahedra, "-o", out, "--iterations", 2, "--time-limit", 0))
        field = (out / "field.tetf").read_bytes()
        for option, value in (("--order", "centroid"), ("--fragment-memory", 64), ("--fragment-sort", "heap")):
            result = self.run_stage("optimize", tetrahedra, "-o", out, "--iterations", 2, "--time-limit", 0,
                                    option, value)
            self.assert_fails(result, 2, option)
        self.assertEqual((out / "field.tetf").read_bytes(), field)

    def test_a_deterministic_optimize_refuses_a_limit_of_time(self):
        tetrahedra = self.folder / "never read"
        for arguments in ((), ("--iterations", 100), ("--time-limit", 10)):  # the default is a limit, too
            result = self.run_stage("optimize", tetrahedra, "-o", self.folder / "run" / "3_field",
                                    "--deterministic", *arguments)
            self.assert_fails(result, 2, "--deterministic", "--time-limit 0")

    def test_optimize_without_a_vulkan_device(self):
        nowhere = str(self.folder / "no-driver.json")
        result = self.run_stage("optimize", self.tiny_tetrahedra(), "-o", self.folder / "run" / "3_field",
                                environment={"VK_ICD_FILENAMES": nowhere, "VK_DRIVER_FILES": nowhere})
        self.assert_fails(result, 4, "Vulkan")

    def test_surface_does_not_go_on_without_a_device_that_was_asked_for(self):
        field = self.folder / "run" / "3_field"
        self.assert_done(self.run_stage("optimize", self.tiny_tetrahedra(), "-o", field, "--time-limit", 0,
                                        "--iterations", 2, "--renderer", "reference", "--watched-views", 0))
        nowhere = str(self.folder / "no-driver.json")
        for device in ("gpu", "99"):
            result = self.run_stage("surface", field, "-o", self.folder / "run" / "5_surface", "--device", device,
                                    environment={"VK_ICD_FILENAMES": nowhere, "VK_DRIVER_FILES": nowhere})
            self.assert_fails(result, 4, "Vulkan")

    def test_a_surface_made_without_a_device_is_made_again(self):
        field, surface = self.folder / "run" / "3_field", self.folder / "run" / "5_surface"
        self.assert_done(self.run_stage("optimize", self.tiny_tetrahedra(), "-o", field, "--time-limit", 0,
                                        "--iterations", 2, "--renderer", "reference", "--watched-views", 0))
        nowhere = str(self.folder / "no-driver.json")
        without = {"VK_ICD_FILENAMES": nowhere, "VK_DRIVER_FILES": nowhere}
        result = self.run_stage("surface", field, "-o", surface, environment=without)
        self.assert_done(result)
        self.assertIn("level of density instead of opacity", result.stderr)
        self.assertEqual(len(self.manifest(surface)["degraded"]), 1)
        self.assertNotIn("up to date", self.run_stage("surface", field, "-o", surface).stdout)
        self.assertEqual(self.manifest(surface)["notes"]["level"], "opacity")
        self.assertIn("up to date", self.run_stage("surface", field, "-o", surface).stdout)

    def test_a_failed_write_leaves_no_manifest_and_the_next_run_repairs_it(self):
        scene = self.tiny_scene()
        out = self.folder / "run" / "2_tetrahedra"
        result = self.run_stage("tetrahedralize", scene, "-o", out, restore_signals=False,
                                preexec_fn=limit_file_size(64 * 1024))
        self.assert_fails(result, 4, "mesh.tet")
        self.assertFalse((out / "manifest.json").exists())
        self.assertEqual(self.status(out), "failed")
        self.assertEqual([path.name for path in out.iterdir() if path.name.startswith("mesh.tet")], [])
        self.assert_done(self.run_stage("tetrahedralize", scene, "-o", out))

    def test_a_full_disk_is_reported_in_one_line(self):
        self.program("import")
        write_tiny_dataset(self.folder / "ball")
        disk = self.folder / "disk"
        disk.mkdir()
        mount = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c",
                 'mount -t tmpfs -o size=64k tmpfs "$1" && shift && exec "$@"', "sh", str(disk)]
        if subprocess.run([*mount, "true"], capture_output=True, check=False).returncode:
            self.skipTest("this machine does not allow mounting a small disk (unshare, tmpfs)")
        result = subprocess.run(
            [*mount, str(self.program("import")), str(self.folder / "ball"), "-o", str(disk / "out")],
            capture_output=True, text=True, check=False)
        result.args = [self.program("import")]
        self.assert_fails(result, 4, str(disk))

    def test_an_output_folder_that_cannot_be_made_is_an_environment_error(self):
        write_tiny_dataset(self.folder / "ball")
        (self.folder / "file").write_text("in the way")
        result = self.run_stage("import", self.folder / "ball", "-o", self.folder / "file" / "out")
        self.assert_fails(result, 4, str(self.folder / "file"))


if __name__ == "__main__":
    unittest.main()
