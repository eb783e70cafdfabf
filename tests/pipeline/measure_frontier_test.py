"""scripts/measure_frontier at its smallest: seconds on the bundled demo's known cameras."""
import json
import pathlib
import subprocess
import sys
import unittest

from stage_case import BIN, StageCase

REPO = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = REPO / "scripts" / "measure_frontier"


class MeasureFrontierTest(StageCase):

    def frontier(self, *arguments):
        return subprocess.run([sys.executable, "-B", SCRIPT, *map(str, arguments), "--bin", BIN], capture_output=True,
                              text=True, check=False, timeout=800)

    def test_every_configuration_gets_its_numbers_and_its_place_in_the_chart(self):
        run = self.folder / "run"
        scene = self.run_stage("import", REPO / "datasets_spec" / "demo" / "nerf", "--downscale", 2,
                               "-o", run / "1_scene")
        self.assertEqual(scene.returncode, 0, scene.stderr)
        start = self.run_stage("tetrahedralize", run / "1_scene", "-o", run / "2_tetrahedra", "--resolution", 12)
        self.assertEqual(start.returncode, 0, start.stderr)
        result = self.frontier(run, "--seconds", "2,4", "--ablation-seconds", "2", "--only", "ours,article,sh-0",
                               "--optimize-options=--rays 512")
        self.skip_without_vulkan(4 if "needs Vulkan" in result.stdout else 0, result.stdout)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        frontier = json.loads((run / "frontier" / "frontier.json").read_text())
        self.assertEqual([(entry["name"], entry["limit"]) for entry in frontier["entries"]],
                         [("ours", 2), ("ours", 4), ("article", 2), ("article", 4), ("sh-0", 2)])
        for entry in frontier["entries"]:
            for key in ("psnr", "ssim", "worst_psnr", "seconds", "tets", "memory_mib", "steps"):
                self.assertGreater(entry[key], 0, key)
        text = (run / "frontier" / "frontier.md").read_text()
        self.assertEqual(text.count("| Tetrec's defaults |"), 2)
        chart = (run / "frontier" / "frontier.svg").read_text()
        for words in ("Tetrec's defaults", "article: colour and density", "without harmonics", "memory [MiB]"):
            self.assertIn(words, chart.replace("&apos;", "'").replace("&#39;", "'"))
        # What is done stays.
        again = self.frontier(run, "--seconds", "2", "--only", "ours", "--optimize-options=--rays 512")
        self.assertEqual(again.returncode, 0, again.stdout)
        self.assertIn("up to date", (run / "frontier" / "ours_2" / "stages.txt").read_text())

    def test_wrong_words_are_a_wrong_command_line(self):
        run = self.folder / "empty"
        self.assertEqual(self.frontier(run).returncode, 2)
        self.assertIn("make -C pipeline tetrahedra", self.frontier(run).stderr)
        self.assertIn("no configuration ours2", self.frontier(run, "--only", "ours2").stderr)
        self.assertEqual(self.frontier(run, "--seconds", "0").returncode, 2)


if __name__ == "__main__":
    unittest.main()
