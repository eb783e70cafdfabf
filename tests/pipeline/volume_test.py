"""tetrec-import with volumes: scene folders and refused input."""
import json
import unittest

from stage_case import StageCase, hashes, limit_file_size

TRANSFER_FUNCTION = {"opacity": [[0, 0], [0.3, 0], [1, 1]], "colour": [[0, 1, 0, 0], [1, 0, 0, 1]]}
SIZE = (7, 6, 5)


def samples():
    """A ball that is densest in the middle."""
    for z in range(SIZE[2]):
        for y in range(SIZE[1]):
            for x in range(SIZE[0]):
                off = sum((p - (n - 1) / 2) ** 2 for p, n in zip((x, y, z), SIZE))
                yield max(0, 255 - int(30 * off))


class VolumeTest(StageCase):

    def setUp(self):
        super().setUp()
        self.raw = self.folder / "ball.raw"
        self.raw.write_bytes(bytes(samples()))
        self.header = self.folder / "ball.nhdr"
        self.header.write_text("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 7 6 5\nspacings: 1 1 1\n"
                               "encoding: raw\ndata file: ball.raw\n")
        self.function = self.folder / "tf.json"
        self.function.write_text(json.dumps(TRANSFER_FUNCTION))
        self.scene = self.folder / "run" / "1_scene"

    def import_volume(self, path, *options, **process):
        return self.run_stage("import", path, "-o", self.scene, "--transfer-function", self.function,
                              "--cameras", 16, "--size", 24, *options, **process)

    def raw_options(self):
        return "--dimensions", "7x6x5", "--sample-type", "uint8"

    def test_a_raw_volume_becomes_a_scene_that_the_next_stage_accepts(self):
        self.assert_done(self.import_volume(self.raw, *self.raw_options()))
        scene = json.loads((self.scene / "scene.json").read_text())
        self.assertEqual(len(scene["views"]), 16)
        self.assertTrue(scene["has_alpha"])
        manifest = self.manifest(self.scene)
        self.assertEqual(manifest["counts"]["test_views"], 2)
        self.assertEqual(manifest["counts"]["samples"], [7, 6, 5])
        self.assertIn("ground_truth/volume.nrrd", [output["path"] for output in manifest["outputs"]])
        result = self.run_stage("tetrahedralize", self.scene, "-o", self.folder / "run" / "2_tetrahedra",
                                "--resolution", 8, "--outer-points", 50)
        self.assert_done(result)

    def test_a_second_run_does_nothing_and_a_header_gives_the_same_scene(self):
        self.assert_done(self.import_volume(self.raw, *self.raw_options()))
        finished = self.manifest(self.scene)["finished"]
        self.assert_done(self.import_volume(self.raw, *self.raw_options()))
        self.assertEqual(self.manifest(self.scene)["finished"], finished)
        from_raw = hashes(self.scene)
        self.assert_done(self.import_volume(self.header))
        self.assertEqual(hashes(self.scene), from_raw)

    def test_samples_beside_a_header_are_part_of_the_key(self):
        self.assert_done(self.import_volume(self.header))
        before = hashes(self.scene)
        self.raw.write_bytes(bytes(255 - s for s in samples()))
        self.assert_done(self.import_volume(self.header))
        self.assertNotEqual(hashes(self.scene), before)

    def test_a_value_range_is_part_of_the_key_and_reveals_what_the_types_range_hides(self):
        self.raw.write_bytes(bytes(s // 16 for s in samples()))
        hidden = self.import_volume(self.header)
        self.assert_fails(hidden, 3, "ball.nhdr: nothing in it is visible", "samples range from 0 to 15",
                          "values 76.5 to 255", "a value range LOW,HIGH")
        self.assertIn("refer to the type's range", hidden.stderr)
        self.assertEqual(list(self.scene.glob("ground_truth/*")), [])
        shown = self.import_volume(self.header, "--value-range", "0,15")
        self.assert_done(shown)
        self.assertNotIn("refer to the type's range", shown.stderr)
        manifest, before = self.manifest(self.scene), hashes(self.scene)
        self.assertEqual(manifest["counts"]["clamped_samples"], 0)
        self.assert_done(self.import_volume(self.header, "--value-range", "0,15"))
        self.assertEqual(self.manifest(self.scene)["finished"], manifest["finished"])
        narrow = self.import_volume(self.header, "--value-range", "-1,12")
        self.assert_done(narrow)
        self.assertIn("outside the value range", narrow.stderr)
        self.assertGreater(self.manifest(self.scene)["counts"]["clamped_samples"], 0)
        self.assertNotEqual(hashes(self.scene), before)
        # A refused import keeps the earlier scene.
        before = hashes(self.scene)
        self.assert_fails(self.import_volume(self.header, "--value-range", "200,255"), 3, "is visible")
        self.assertEqual(hashes(self.scene), before)
        self.assert_fails(self.import_volume(self.header, "--value-range", "15,0"), 2, "--value-range is 15,0")
        self.assert_fails(self.import_volume(self.header, "--value-range", "5"), 2, "--value-range")

    def test_a_full_disk_is_noticed_before_the_images_are_rendered(self):
        result = self.import_volume(self.header, preexec_fn=limit_file_size(3000))
        self.assert_fails(result, 4, "ground_truth/volume.nrrd", "cannot write")
        self.assertFalse((self.scene / "images").exists())
        self.assertEqual(list(self.scene.glob("ground_truth/*")), [])
        self.assert_done(self.import_volume(self.header))

    def test_both_shadings_and_seeds_differ(self):
        pictures = []
        for options in ((), ("--shading", "post"), ("--seed", 1)):
            self.assert_done(self.import_volume(self.header, *options))
            pictures.append(hashes(self.scene)["images/train/00001.png"])
        self.assertEqual(len(set(pictures)), 3)

    def test_max_size_bounds_the_images(self):
        self.assert_done(self.import_volume(self.header, "--max-size", 20))
        camera = json.loads((self.scene / "scene.json").read_text())["cameras"][0]
        self.assertEqual((camera["width"], camera["height"]), (20, 20))
        result = self.run_stage("import", self.header, "-o", self.scene, "--transfer-function", self.function,
                                "--cameras", 8, "--rays-per-side", 1, "--max-size", 300)
        self.assert_done(result)
        self.assertIn("views have 256 x 256 pixels, fewer than --max-size allows", result.stderr)

    def test_bad_volumes_are_named(self):
        self.header.write_text(self.header.read_text().replace("7 6 5", "7 6 9"))
        self.assert_fails(self.import_volume(self.header), 3, "ball.raw", "contains 210 bytes")
        self.header.write_text(self.header.read_text().replace("ball.raw", "../ball.raw"))
        self.assert_fails(self.import_volume(self.header), 3, "ball.nhdr, line 7", "inside")
        self.assert_fails(self.import_volume(self.folder / "none.mha"), 3, "none.mha")
        self.assert_fails(self.import_volume(self.raw, "--dimensions", "7x6x6", "--sample-type", "uint8"), 3,
                          "has 210 bytes")
        self.function.write_text("{}")
        self.assert_fails(self.import_volume(self.raw, *self.raw_options()), 3, "tf.json", "opacity is missing")
        self.assertFalse((self.scene / "manifest.json").exists())

    def test_options_that_do_not_go_together_are_refused(self):
        self.assert_fails(self.import_volume(self.raw), 2, "ball.raw", "give its dimensions")
        self.assert_fails(self.import_volume(self.raw, "--dimensions", "7x6x5", "--sample-type", "int8"), 2,
                          "--sample-type: int8", "uint16")
        self.assert_fails(self.import_volume(self.raw, *self.raw_options(), "--byte-order", "middle"), 2,
                          "--byte-order: middle")
        self.assert_fails(self.import_volume(self.raw, "--dimensions", "7x6", "--sample-type", "uint8"), 2,
                          "--dimensions is 7x6", "103x94x161")
        self.assert_fails(self.import_volume(self.header, *self.raw_options()), 2,
                          "--dimensions is for .raw files only", "ball.nhdr")
        self.assert_fails(self.import_volume(self.header, "--format", "colmap"), 2, "--format", "image data sets")
        self.assert_fails(self.import_volume(self.header, "--shading", "both"), 2, "--shading: both")
        self.assert_fails(self.run_stage("import", self.header, "-o", self.scene), 2, "--transfer-function")
        self.assert_fails(self.run_stage("import", self.folder, "-o", self.scene, "--cameras", 9), 2,
                          "--cameras", "volumes")
        self.assertFalse(self.scene.exists())


if __name__ == "__main__":
    unittest.main()
