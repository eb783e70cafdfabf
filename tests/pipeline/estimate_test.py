"""What make prints before it starts a stage: the estimate of the time of the whole chain, and commands."""
import pathlib
import subprocess
import unittest

from stage_case import BIN, StageCase

PIPELINE = pathlib.Path(__file__).resolve().parents[2] / "pipeline"


class EstimateTest(StageCase):
    """Runs `make estimate`, which starts no stage."""

    def estimate(self, folder, **variables):
        words = {"INPUT": folder, "BUILD": BIN.parent} | variables
        result = subprocess.run(
            ["make", "--no-print-directory", "-C", PIPELINE, "estimate", *(f"{k}={v}" for k, v in words.items())],
            capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertFalse((self.folder / "run").exists())
        return result.stdout

    def test_it_counts_photos_and_the_time_of_the_optimisation(self):
        photos = self.folder / "a $x 'b'" / "sub"
        photos.mkdir(parents=True)
        for i in range(60):
            (photos / f"{i}.{('jpg', 'PNG', 'JPEG', 'HEIC', 'tif', 'TIFF')[i % 6]}").touch()
        (photos / "notes.txt").touch()
        # 600 + 60 x 2 + 30 s; 660 + 60 x 5 + 60 s.
        self.assertIn("about 12 to 17 minutes, of which 10.0 are optimisation", self.estimate(photos.parent))
        self.assertIn("about 4 to 9 minutes, of which 2.0", self.estimate(photos.parent, PRESET="fast"))
        # Of a video, 80 frames are taken. A folder that leads back to itself is no reason to stop.
        video = self.folder / "walk.MPG"
        video.write_bytes(b"")
        self.assertIn("about 5 to 10 minutes, of which 2.0", self.estimate(video, PRESET="fast"))
        (photos.parent / "back").symlink_to(photos.parent)
        self.assertIn("minutes, of which", self.estimate(photos.parent))
        (photos.parent / "transforms.json").touch()
        self.assertIn("about 10 to 12 minutes", self.estimate(photos.parent))

    def test_without_a_limit_on_time_there_is_none(self):
        self.assertEqual(self.estimate(self.folder, TIME_LIMIT=0), "")
        self.assertEqual(self.estimate(self.folder, OPTIMIZE_OPTIONS="--iterations 5 --time-limit=0"), "")

    def test_a_limit_among_the_options_replaces_that_of_the_preset(self):
        words = {"INPUT": self.folder, "RUN": self.folder / "run", "BUILD": BIN.parent}
        for options in ("", "--time-limit 0 --iterations 5", "--time-limit=30"):
            result = subprocess.run(
                ["make", "--no-print-directory", "-n", "-C", PIPELINE, "field", f"OPTIMIZE_OPTIONS={options}",
                 *(f"{k}={v}" for k, v in words.items())], capture_output=True, text=True, check=False)
            self.assertEqual(result.returncode, 0, result.stderr)
            command, = (line for line in result.stdout.splitlines() if "/tetrec-optimize" in line)
            self.assertEqual(command.count("--time-limit"), 1, command)


if __name__ == "__main__":
    unittest.main()
