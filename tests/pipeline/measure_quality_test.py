"""scripts/measure_quality at its smallest: a few steps on the bundled demo's known cameras."""
import json
import pathlib
import subprocess
import sys
import unittest

from stage_case import BIN, StageCase

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "measure_quality"


class MeasureQualityTest(StageCase):

    def measure(self, *arguments):
        return subprocess.run([sys.executable, "-B", SCRIPT, *map(str, arguments)], capture_output=True,
                              text=True, check=False, timeout=600)

    def test_a_scene_gets_every_number_and_a_missing_one_a_reason(self):
        out = self.folder / "quality"
        result = self.measure("--out", out, "--bin", BIN, "--scenes", "demo-nerf,lego", "--iterations", 20,
                              "--data", self.folder / "nowhere", "--optimize-options=--rays 512")
        self.skip_without_vulkan(4 if "needs Vulkan" in result.stdout else 0, result.stdout)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        quality = json.loads((out / "quality.json").read_text())
        demo, lego = quality["scenes"]
        for key in ("psnr", "worst_psnr", "watched_best", "watched_end", "f_score", "tets", "memory_mib"):
            self.assertIsNotNone(demo[key], key)
        self.assertLessEqual(demo["worst_psnr"], demo["psnr"])
        self.assertGreaterEqual(demo["watched_best"], demo["watched_end"])
        self.assertEqual(demo["steps"], 20)
        self.assertIn("lego/transforms_test.json", lego["skipped"])
        text = (out / "quality.md").read_text()
        self.assertIn(f"| {demo['psnr']:.2f} |", text)
        self.assertIn("lego: skipped: ", text)
        self.assertIn("--rays 512", text)

        psnr = demo["psnr"]
        demo["psnr"] = psnr + 1
        after = self.folder / "after.json"
        after.write_text(json.dumps(quality))
        compared = self.measure("--compare", out / "quality.json", after)
        self.assertEqual(compared.returncode, 0, compared.stderr)
        self.assertIn(f"| {psnr:.2f} → {psnr + 1:.2f} |", compared.stdout)
        self.assertNotIn("Measured only once", compared.stdout)  # lego was not measured at all

    def test_a_failing_stage_is_named_and_counts_as_a_failure(self):
        result = self.measure("--out", self.folder / "quality", "--bin", BIN, "--scenes", "demo-nerf",
                              "--tetrahedralize-options=--start nowhere")
        self.assertEqual(result.returncode, 1)
        self.assertIn("tetrec-tetrahedralize ended with 2", result.stdout)
        self.assertIn("--start", result.stdout)

    def test_unknown_scenes_are_a_wrong_command_line(self):
        result = self.measure("--out", self.folder / "quality", "--scenes", "demo,teapot")
        self.assertEqual(result.returncode, 2)
        self.assertIn("teapot", result.stderr)


if __name__ == "__main__":
    unittest.main()
