"""SIGKILL and Ctrl-C in the middle: the same command continues and ends as if nothing had happened."""
import csv
import json
import pathlib
import shutil
import signal
import time
import unittest

from stage_case import StageCase, hashes
from tiny_dataset import by_direction, write_tiny_dataset

DEMO_PHOTOS = pathlib.Path(__file__).resolve().parents[2] / "datasets_spec" / "demo" / "photos"


class InterruptTest(StageCase):

    def interrupt(self, number, delay, *command):
        """Starts a stage and sends the signal after `delay` seconds; returns its exit code."""
        process = self.start(*command)
        time.sleep(delay)
        process.send_signal(number)
        process.communicate(timeout=60)
        return process.returncode

    def check_kills(self, folder, *command):
        """Kills the stage at growing delays, then lets it end; the bytes must be those of an
        uninterrupted run in `folder`_whole."""
        whole = folder.with_name(folder.name + "_whole")
        self.assert_done(self.run_stage(*command, "-o", whole))
        killed = 0
        for delay in (0.005, 0.02, 0.05, 0.1, 0.2, 0.4):
            code = self.interrupt(signal.SIGKILL, delay, *command, "-o", folder)
            killed += code == -signal.SIGKILL
            # A stage may be killed between its last write, that of the manifest, and its exit.
            if code == 0 or (folder / "manifest.json").exists():
                break
            self.assertEqual(code, -signal.SIGKILL)
        self.assertGreater(killed, 0)
        self.assert_done(self.run_stage(*command, "-o", folder))
        self.assertEqual(hashes(folder), hashes(whole))

    def test_a_killed_import_ends_with_the_same_bytes(self):
        write_tiny_dataset(self.folder / "ball")
        self.check_kills(self.folder / "scene", "import", self.folder / "ball")

    def test_a_killed_import_of_a_volume_ends_with_the_same_bytes(self):
        raw, function = self.folder / "ball.raw", self.folder / "tf.json"
        raw.write_bytes(bytes(16 * ((x - 8)**2 + (y - 8)**2 < 40) * z for z in range(16) for y in range(16)
                              for x in range(16)))
        function.write_text(json.dumps({"opacity": [[0, 0], [1, 1]], "colour": [[0, 1, 0, 0]]}))
        self.check_kills(self.folder / "scene", "import", raw, "--dimensions", "16x16x16",
                         "--sample-type", "uint8", "--transfer-function", function, "--cameras", 32,
                         "--size", 96)

    def test_killed_tetrahedra_end_with_the_same_bytes(self):
        self.check_kills(self.folder / "tetrahedra", "tetrahedralize", self.tiny_scene())

    def test_killed_render_surface_and_evaluate_end_as_if_nothing_had_happened(self):
        field = self.folder / "run" / "3_field"
        self.assert_done(self.run_stage("optimize", self.tiny_tetrahedra(), "-o", field,
                                        "--time-limit", 0, "--iterations", 30))
        views, surface = self.folder / "run" / "4_views", self.folder / "run" / "5_surface"
        self.check_kills(views, "render", field)
        self.check_kills(surface, "surface", field)
        # The report contains the times of the stages, so its bytes differ from run to run.
        report, command = self.folder / "run" / "6_report", ("evaluate", views, surface)
        self.assertEqual(self.interrupt(signal.SIGKILL, 0.02, *command, "-o", report), -signal.SIGKILL)
        self.assertFalse((report / "manifest.json").exists())
        self.assert_done(self.run_stage(*command, "-o", report))

    def test_a_killed_sfm_ends_colmap_too_and_finishes_when_run_again(self):
        photos = self.folder / "photos"
        photos.mkdir()
        for path in sorted(DEMO_PHOTOS.glob("*.jpg"))[:6]:
            shutil.copy(path, photos)
        out = self.folder / "scene"
        command = ("sfm", photos, "-o", out, "--max-size", 160, "--max-features", 1500)
        process = self.start(*command)
        self.wait_for(lambda: (out / "log.txt").exists() and "matching" in (out / "log.txt").read_text(),
                      process, "matching")
        process.kill()
        process.communicate()
        deadline = time.monotonic() + 30
        while self.processes_on(out) and time.monotonic() < deadline:
            time.sleep(0.1)
        self.assertEqual(self.processes_on(out), [])
        self.assertFalse((out / "manifest.json").exists())
        self.assert_done(self.run_stage(*command))
        self.assertTrue((out / "scene.json").exists())

    def test_a_killed_triangulation_continues_and_ends_with_the_same_bytes(self):
        command = ("import", DEMO_PHOTOS.parent / "nerf", "--triangulate", "--max-size", 200, "-o")
        out, whole = self.folder / "scene", self.folder / "whole"
        process = self.start(*command, out)
        self.wait_for(lambda: (out / "log.txt").exists() and "matches in" in (out / "log.txt").read_text(),
                      process, "the matches")
        process.kill()
        process.communicate()
        self.assertFalse((out / "manifest.json").exists())
        self.assert_done(self.run_stage(*command, out))
        self.assertFalse((out / "work").exists())
        self.assert_done(self.run_stage(*command, whole))
        for name in ("points.ply", "scene.json"):
            self.assertEqual((out / name).read_bytes(), (whole / name).read_bytes(), name)

    def processes_on(self, folder):
        """Command lines of the processes that name the folder."""
        lines = []
        for path in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
            try:
                line = path.read_bytes().replace(b"\0", b" ").decode(errors="replace")
            except OSError:
                continue  # it has ended
            if str(folder) in line:
                lines.append(line)
        return lines

    def test_ctrl_c_ends_with_130_and_the_same_command_finishes_the_work(self):
        scene = self.tiny_scene()
        out = self.folder / "tetrahedra"
        command = ("tetrahedralize", scene, "-o", out, "--start", "grid", "--resolution", 64)
        process = self.start(*command)
        self.wait_for((out / "log.txt").exists, process, "the log")
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, errors)
        # Work that cannot be stopped in its middle is finished, and its result stays.
        status = self.status(out)
        self.assertIn(status, ("interrupted", "done"))
        self.assertEqual((out / "manifest.json").exists(), status == "done")
        self.assert_done(self.run_stage(*command, "--resume"))
        self.assertEqual(self.status(out), "done")

    def optimization(self):
        """A run of a few seconds with a checkpoint every second, and its command."""
        out = self.folder / "run" / "3_field"
        return out, ("optimize", self.tiny_tetrahedra(), "-o", out, "--time-limit", 12)

    def wait_for_rows(self, out, process, rows=3):
        def ready():
            return (out / "metrics.csv").exists() and len(
                (out / "metrics.csv").read_text().splitlines()) > rows
        self.wait_for(ready, process, "metrics.csv")

    def check_resumed(self, out, rows_before):
        """The resumed run finished, and its history contains that of the first part."""
        self.assertEqual(self.status(out), "done")
        rows = (out / "metrics.csv").read_text().splitlines()
        self.assertEqual(rows[:rows_before], self.rows[:rows_before])
        # The final row has the last PSNR and may repeat the iteration of the row before.
        iterations = [int(row["iteration"]) for row in csv.DictReader(rows) if row["phase"] != "end"]
        self.assertEqual(iterations, sorted(set(iterations)))

    def test_ctrl_c_in_optimize_writes_a_checkpoint_and_resumes(self):
        out, command = self.optimization()
        process = self.start(*command)
        self.wait_for_rows(out, process)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, errors)
        self.assertEqual(self.status(out), "interrupted")
        self.rows = (out / "metrics.csv").read_text().splitlines()
        self.assert_done(self.run_stage(*command, "--resume"))
        self.check_resumed(out, len(self.rows))

    def test_a_killed_optimize_continues_from_its_checkpoint(self):
        out, command = self.optimization()
        process = self.start(*command)
        self.wait_for_rows(out, process)
        process.kill()
        process.communicate()
        self.rows = (out / "metrics.csv").read_text().splitlines()
        self.assertFalse((out / "manifest.json").exists())
        self.assert_done(self.run_stage(*command))
        # Work after the last checkpoint is repeated: at least the header stays.
        self.check_resumed(out, 1)

    def interrupt_and_resume(self, out, command, rows):
        """Sends Ctrl-C to an optimisation once metrics.csv has this many rows, and lets it end."""
        process = self.start(*command, "-o", out)
        self.wait_for_rows(out, process, rows)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assert_done(self.run_stage(*command, "-o", out, "--resume"))
        self.assertIn("continues from iteration", (out / "log.txt").read_text())

    def test_a_killed_optimize_whose_vertices_move_gives_the_same_bytes(self):
        command = ("optimize", self.tiny_tetrahedra(), "--deterministic", "--time-limit", 0, "--iterations", 300,
                   "--rays", 512, "--move", "safe", "--checkpoint-interval", 0)
        whole, killed = self.folder / "run" / "whole", self.folder / "run" / "killed"
        self.assert_done(self.run_stage(*command, "-o", whole))
        process = self.start(*command, "-o", killed)
        self.wait_for_rows(killed, process, rows=20)
        process.kill()
        process.communicate()
        before = json.loads((killed / "status.json").read_text())["seconds"]
        self.assertGreater(before, 0)
        self.assert_done(self.run_stage(*command, "-o", killed))
        self.assertIn("continues from iteration", (killed / "log.txt").read_text())
        self.assertEqual(hashes(killed)["field.tetf"], hashes(whole)["field.tetf"])
        # The time of the killed process counts, too.
        seconds = self.manifest(killed)["seconds"]
        self.assertGreater(seconds["total"], before)
        self.assertGreaterEqual(seconds["total"], seconds["optimize"])
        counts = [self.manifest(folder)["counts"] for folder in (whole, killed)]
        self.assertGreater(counts[0]["vertex_moves"], 0)
        for name in ("vertex_moves", "shortened_moves", "stopped_moves", "min_volume", "min_radius_ratio"):
            self.assertEqual(counts[0][name], counts[1][name], name)

    def test_a_resumed_optimize_gives_the_same_bytes_with_each_refinement(self):
        tetrahedra = self.tiny_tetrahedra()
        for refine, score in (("prism", "color"), ("prism", "position"), ("bisect", "variance"), ("halve", "residual")):
            with self.subTest(refine=refine, score=score):
                command = ("optimize", tetrahedra, "--deterministic", "--time-limit", 0, "--iterations", 200, "--rays", 512,
                           "--refine", refine, "--score", score, "--move", "safe", "--last-round", 0.8)
                whole, resumed = (self.folder / "run" / f"{name}_{refine}_{score}" for name in ("whole", "resumed"))
                self.assert_done(self.run_stage(*command, "-o", whole))
                self.interrupt_and_resume(resumed, command, rows=15)
                self.assertIn("round 2", (resumed / "log.txt").read_text())
                self.assertEqual(hashes(resumed)["field.tetf"], hashes(whole)["field.tetf"])

    def test_a_resumed_optimize_with_harmonics_gives_the_same_bytes(self):
        command = ("optimize", self.tiny_tetrahedra(train=16, paint=by_direction), "--deterministic",
                   "--time-limit", 0, "--iterations", 280, "--rays", 512, "--sh", "auto")
        whole, resumed = self.folder / "run" / "whole", self.folder / "run" / "resumed"
        self.assert_done(self.run_stage(*command, "-o", whole))
        # Between the unlocking of the first degree (15 %) and its judgement (30 %).
        self.interrupt_and_resume(resumed, command, rows=8)
        self.assertGreaterEqual(self.manifest(whole)["counts"]["harmonics_degree"], 1)
        self.assertEqual(hashes(resumed)["field.tetf"], hashes(whole)["field.tetf"])

    def test_a_deterministic_optimize_gives_the_same_bytes_however_it_ran(self):
        # Turned cameras, so that corrections of them are kept (with this seed by a wide margin).
        tetrahedra = self.tiny_tetrahedra(turned_rad=0.05)
        results = ("field.tetf", "exposure.json", "cameras.json")
        command = ("optimize", tetrahedra, "--deterministic", "--time-limit", 0, "--iterations", 300, "--seed", 3,
                   "--checkpoint-interval", 0.2, "--exposure", "on", "--poses", "on")
        fields = []
        for threads in ("1", "2"):
            out = self.folder / "run" / f"threads_{threads}"
            self.assert_done(self.run_stage(*command, "-o", out,
                                            environment={"LP_NUM_THREADS": threads}))
            self.assertEqual(self.manifest(out)["counts"]["clamped_addends"], 0)
            fields.append([(out / name).read_bytes() for name in results])
        out = self.folder / "run" / "resumed"
        self.interrupt_and_resume(out, command, rows=15)
        fields.append([(out / name).read_bytes() for name in results])
        self.assertEqual(fields[0], fields[1])
        self.assertEqual(fields[0], fields[2])


if __name__ == "__main__":
    unittest.main()
