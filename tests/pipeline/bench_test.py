"""tetrec-bench at its smallest: a table, figures and charts of every renderer."""
import csv
import signal
import unittest

from stage_case import StageCase


class BenchTest(StageCase):

    def test_a_small_benchmark_measures_every_renderer(self):
        out = self.folder / "bench"
        result = self.run_stage("bench", "-o", out, "--tets", "500,2000", "--size", "16,32", "--repeat", 2,
                                "--error-size", 24, "--integral", "mean,split:4,exact")
        self.assert_done(result)
        rows = list(csv.DictReader((out / "bench.csv").read_text().splitlines()))
        # march with three integrals, ppll, projection in two orders; two meshes, two sizes.
        self.assertEqual(len(rows), 6 * 4)
        for row in rows:
            self.assertEqual(row["skipped_at_most_s"], "")
            self.assertEqual(int(row["repetitions"]), 2)
            self.assertGreater(float(row["forward_wall_ms_median"]), 0)
            self.assertGreater(int(row["device_bytes"]), 32 * int(row["tets"]))
            if row["integral"] == "exact" and row["order"] != "centroid":
                # The bounds that the tests of the renderers use.
                self.assertLess(float(row["picture_error_largest"]), 1e-4)
                self.assertLess(float(row["density_gradient_error"]), 1e-3)
        errors = {row["integral"]: float(row["picture_error_rms"])
                  for row in rows if row["renderer"] == "march" and row["tets"] == rows[0]["tets"]}
        self.assertLess(errors["exact"], errors["split:4"])
        self.assertLess(errors["split:4"], errors["mean"])
        self.assertIn("| march, exact", (out / "table.md").read_text())
        self.assertIn("| projection, centroid order, exact", result.stdout)
        for chart in ("accuracy", "scaling"):
            for kind in ("svg", "png"):
                self.assertGreater((out / f"{chart}.{kind}").stat().st_size, 1000)

    def test_the_reference_alone_needs_no_vulkan_driver(self):
        out = self.folder / "bench"
        nowhere = {"VK_ICD_FILENAMES": "/nowhere.json", "VK_DRIVER_FILES": "/nowhere.json"}
        result = self.run_stage("bench", "-o", out, "--renderer", "reference", "--integral", "exact",
                                "--tets", 300, "--size", 16, "--repeat", 1, "--error-size", 16,
                                environment=nowhere)
        self.assert_done(result)
        rows = list(csv.DictReader((out / "bench.csv").read_text().splitlines()))
        self.assertEqual(len(rows), 1)
        self.assertGreater(float(rows[0]["steps_per_ray"]), 1)
        self.assertIn("counted by the reference", (out / "table.md").read_text())
        # It has no error relative to itself.
        self.assertIn("no accuracy chart", result.stderr)
        self.assertTrue((out / "scaling.svg").exists())

    def test_ctrl_c_keeps_the_sizes_that_are_done(self):
        out = self.folder / "bench"
        process = self.start("bench", "-o", out, "--renderer", "march", "--integral", "exact", "--tets", 500,
                             "--size", "16,256", "--repeat", 100000, "--case-seconds", 3, "--error-size", 16)
        for line in process.stderr:
            if line.startswith("16 x 16 px"):
                process.send_signal(signal.SIGINT)
                break
        _, stderr = process.communicate(timeout=60)
        self.skip_without_vulkan(process.returncode, stderr)
        self.assertEqual(process.returncode, 130, stderr)
        self.assertIn("stopped by the user; bench.csv and table.md have what was measured before", stderr)
        rows = list(csv.DictReader((out / "bench.csv").read_text().splitlines()))
        self.assertEqual([row["px"] for row in rows], ["16"])

    def test_cells_and_fixed_point_are_measured_on_request(self):
        out = self.folder / "bench"
        self.assert_done(self.run_stage("bench", "-o", out, "--integral", "exact", "--tets", 500, "--size", 16,
                                        "--repeat", 1, "--error-size", 16, "--storage", "cell",
                                        "--deterministic"))
        rows = list(csv.DictReader((out / "bench.csv").read_text().splitlines()))
        self.assertEqual({row["renderer"] for row in rows}, {"march", "ppll", "projection"})
        for row in rows:
            self.assertEqual((row["storage"], row["deterministic"]), ("cell", "1"))
            if row["order"] != "centroid":
                self.assertLess(float(row["density_gradient_error"]), 1e-3)
        table = (out / "table.md").read_text()
        self.assertIn("attributes per cell", table)
        self.assertIn("64-bit fixed point", table)

    def test_a_large_image_is_measured(self):
        out = self.folder / "bench"
        self.assert_done(self.run_stage("bench", "-o", out, "--renderer", "march", "--integral", "mean",
                                        "--tets", 50, "--size", 2048, "--repeat", 1, "--error-size", 8,
                                        "--case-seconds", 0.01))
        rows = list(csv.DictReader((out / "bench.csv").read_text().splitlines()))
        self.assertEqual((rows[0]["px"], rows[0]["repetitions"]), ("2048", "1"))

    def test_cases_that_would_take_too_long_are_skipped_and_marked(self):
        out = self.folder / "bench"
        self.assert_done(self.run_stage("bench", "-o", out, "--renderer", "march", "--integral", "exact",
                                        "--tets", 500, "--size", "16,512", "--repeat", 1, "--error-size", 16,
                                        "--longest-turn", 1e-4))
        rows = list(csv.DictReader((out / "bench.csv").read_text().splitlines()))
        self.assertEqual([row["repetitions"] for row in rows], ["1", "0"])
        self.assertGreater(float(rows[1]["skipped_at_most_s"]), 1e-4)
        self.assertIn("skipped: up to", (out / "table.md").read_text())

    def test_wrong_options_are_one_clear_line(self):
        for words, part in ((("--integral", "cubic"), "cubic"), (("--size", "4"), "--size"),
                            (("--renderer", "magic"), "magic")):
            with self.subTest(part):
                result = self.run_stage("bench", "-o", self.folder / "bench", *words)
                self.assert_fails(result, 2, part)
                self.assertFalse((self.folder / "bench").exists())


if __name__ == "__main__":
    unittest.main()
