"""The report in a browser."""
import json
import pathlib
import subprocess

from stage_case import StageCase

PYTHON = pathlib.Path("/usr/bin/python3")  # Debian's, for which Debian's selenium is installed


class ReportPageTest(StageCase):

    def test_the_report_opens_without_errors_and_its_scene_and_sliders_answer(self):
        if not (pathlib.Path("/usr/bin/chromedriver").exists() and subprocess.run(
                [PYTHON, "-c", "import selenium"], check=False, capture_output=True).returncode == 0):
            self.skipTest("chromium-driver or python3-selenium is not installed (scripts/setup.sh)")
        run = self.folder / "run"
        self.assert_done(self.run_stage("optimize", self.tiny_tetrahedra(), "-o", run / "3_field",
                                        "--time-limit", 0, "--iterations", 100))
        self.assert_done(self.run_stage("render", run / "3_field", "-o", run / "4_views"))
        self.assert_done(self.run_stage("surface", run / "3_field", "-o", run / "5_surface"))
        self.assert_done(self.run_stage("evaluate", run / "4_views", run / "5_surface", "-o",
                                        run / "6_report"))
        report = run / "6_report" / "report.html"
        if "three.js (Debian's package libjs-three) was missing" in report.read_text():
            self.skipTest("this build has no three.js (scripts/setup.sh, then configure again)")
        self.assertLess(report.stat().st_size, 15_000_000)
        self.assertIn("Permission is hereby granted", report.read_text())
        result = subprocess.run([PYTHON, "-B", pathlib.Path(__file__).with_name("open_report.py"), report],
                                check=False, capture_output=True, text=True, timeout=300)
        self.assertEqual(result.returncode, 0, result.stderr)
        for width, page in json.loads(result.stdout).items():
            with self.subTest(width=width):
                self.assertEqual(page["console"], [])
                self.assertEqual((page["state"], page["message"]), ("ready", ""))
                # Keys, dragging and each control change what is seen.
                for before, after in zip(page["pictures"], page["pictures"][1:]):
                    self.assertNotEqual(before, after, page["pictures"])
                self.assertEqual(page["slider"], "40%")
                self.assertLessEqual(page["too_wide_px"], 0)
