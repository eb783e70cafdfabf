"""tetrec-stability in its short forms: what breaks and what holds on a small scene."""
import csv
import json
import unittest

from stage_case import StageCase


class StabilityTest(StageCase):

    def cases(self, out):
        return {case["case"]: case for case in json.loads((out / "stress.json").read_text())["cases"]}

    def test_the_short_stress_test_holds(self):
        out = self.folder / "stability"
        self.assert_done(self.run_stage("stability", "-o", out, "--short"))
        cases = self.cases(out)
        self.assertEqual(cases["clean"]["verdict"], "clean")
        self.assertGreater(cases["clean"]["psnr"], 15)
        for name, case in cases.items():
            with self.subTest(name):
                self.assertNotIn(case["verdict"], ("breaks", "skipped"), case)
                self.assertEqual(case["degenerate_tets"], 0)
        # The start meshes were damaged: a sliver is 10,000 times flatter than its tet was.
        self.assertLess(cases["slivers"]["min_radius_ratio"], 1e-3)
        self.assertNotEqual(cases["huge-tet"]["tets"], cases["clean"]["tets"])
        rows = list(csv.DictReader((out / "stress.csv").read_text().splitlines()))
        self.assertEqual([row["case"] for row in rows], list(cases))
        page = (out / "stress.html").read_text()
        for case in cases.values():
            self.assertIn(case["what"], page)

    def test_the_short_sweep_draws_where_the_article_breaks_and_we_hold(self):
        out = self.folder / "sweep"
        self.assert_done(self.run_stage("stability", "-o", out, "--sweep", "--short"))
        runs = json.loads((out / "sweep.json").read_text())["runs"]
        safe = [run for run in runs if run["method"] == "safe motion"]
        fixed = [run for run in runs if run["method"] == "vertices fixed"]
        fastest = [run for run in runs
                   if run["method"] == "article's motion" and run["parameter"] == "position-rate"
                   and run["value"] == 0.1]
        self.assertEqual(len(safe), len(fixed))
        for run, still in zip(safe, fixed):
            self.assertFalse(run["broken"], run)
            self.assertGreater(run["psnr"], still["psnr"] - 1)
        # Steps of a tenth of the subject's side turn tets of a sixth of it inside out.
        self.assertTrue(fastest[0]["broken"])
        for parameter in {run["parameter"] for run in runs}:
            for measure in ("psnr", "degenerate", "seconds"):
                for kind in ("svg", "png"):
                    chart = out / "charts" / f"{parameter}-{measure}.{kind}"
                    self.assertGreater(chart.stat().st_size, 1000)
        self.assertIn("broken", (out / "charts" / "position-rate-psnr.svg").read_text())
        self.assertIn("article's motion", (out / "sweep.html").read_text())

    def test_a_scene_without_points_skips_their_cases_and_is_not_run_again(self):
        out = self.folder / "stability"
        arguments = ("-o", out, "--scene", self.tiny_scene(train=8), "--iterations", 20, "--case",
                     "three-points,black-photo")
        self.assert_done(self.run_stage("stability", *arguments))
        cases = self.cases(out)
        self.assertEqual(list(cases), ["clean", "black-photo", "clean-points", "three-points"])
        self.assertEqual(cases["three-points"]["verdict"], "skipped")
        self.assertIn("no sparse points", cases["three-points"]["said"])
        manifest = out / "runs" / "clean" / "3_field" / "manifest.json"
        written = manifest.stat().st_mtime_ns
        self.assert_done(self.run_stage("stability", *arguments))
        self.assertEqual(manifest.stat().st_mtime_ns, written)
        self.assertEqual(self.cases(out), cases)

    def test_wrong_options_are_one_clear_line(self):
        out = self.folder / "stability"
        for words, code, part in ((("--case", "flood"), 2, "--case: there is no case 'flood'"),
                                  (("--sweep", "--case", "clean"), 2, "--sweep"),
                                  (("--scene", self.folder), 3, "manifest.json")):
            with self.subTest(part):
                self.assert_fails(self.run_stage("stability", "-o", out, *words), code, part)


if __name__ == "__main__":
    unittest.main()
