"""The budget of tets bounds the mesh, and a simple scene needs, and keeps, few of them."""
import json
import signal
import unittest

from stage_case import StageCase, hashes
from tiny_dataset import uniform

OPTIMIZE = ("--iterations", 600, "--time-limit", 0, "--rays", 2048)
BUDGET = 3000  # tets


class BudgetTest(StageCase):

    def coarse_tetrahedra(self):
        tetrahedra = self.folder / "run" / "2_tetrahedra"
        self.assert_done(self.run_stage("tetrahedralize", self.tiny_scene(paint=uniform), "-o", tetrahedra,
                                        "--resolution", 7, "--outer-points", 20))
        return tetrahedra

    def test_a_ball_of_one_colour_is_sharp_within_a_small_budget(self):
        field = self.folder / "run" / "3_field"
        self.assert_done(self.run_stage("optimize", self.coarse_tetrahedra(), "-o", field, *OPTIMIZE,
                                        "--budget-tets", BUDGET))
        self.assertLessEqual(max(step["tets"] for step in json.loads((field / "growth.json").read_text())["steps"]),
                             BUDGET)
        self.assertGreater(self.manifest(field)["counts"]["watched_psnr"], 38)

    def test_a_plain_subject_is_coarsened_and_a_resumed_run_to_the_same_bytes(self):
        command = ("optimize", self.tiny_tetrahedra(paint=uniform), "--deterministic", "--time-limit", 0,
                   "--iterations", 500, "--rays", 2048, "--matched-psnr", 32)
        whole, resumed = self.folder / "run" / "whole", self.folder / "run" / "resumed"
        self.assert_done(self.run_stage(*command, "-o", whole))
        self.assertLessEqual(self.manifest(whole)["counts"]["iterations"], 500)
        steps = json.loads((whole / "growth.json").read_text())["steps"]
        self.assertIn("coarsen", [step["decision"] for step in steps])
        self.assertLess(steps[-1]["tets"], steps[0]["tets"] / 4)
        self.assertGreater(self.manifest(whole)["counts"]["watched_psnr"], 32)
        process = self.start(*command, "-o", resumed)
        self.wait_for(lambda: (resumed / "log.txt").exists() and "coarser mesh" in (resumed / "log.txt").read_text(),
                      process, "a trial of a coarser mesh")
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assert_done(self.run_stage(*command, "-o", resumed))
        self.assertEqual(hashes(resumed)["field.tetf"], hashes(whole)["field.tetf"])

    def test_a_start_mesh_beyond_the_budget_is_a_usage_error(self):
        tetrahedra = self.coarse_tetrahedra()
        for option, value in (("--budget-tets", 100), ("--budget-mb", 100)):
            result = self.run_stage("optimize", tetrahedra, "-o", self.folder / "run" / "3_field", *OPTIMIZE,
                                    option, value)
            self.assertEqual(result.returncode, 2)
            self.assertIn("the start mesh ", result.stderr)
            self.assertIn(f"{option} allows {value}: allow more", result.stderr)


if __name__ == "__main__":
    unittest.main()
