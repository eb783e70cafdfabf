"""Videos as input."""
import json
import pathlib
import shutil
import subprocess

from stage_case import StageCase
from tiny_dataset import write_png

DEMO_PHOTOS = pathlib.Path(__file__).resolve().parents[2] / "datasets_spec" / "demo" / "photos"


class VideoInputTest(StageCase):

    def setUp(self):
        super().setUp()
        if not shutil.which("ffmpeg"):
            self.skipTest("ffmpeg is not installed (scripts/setup.sh)")

    def test_cameras_of_a_video_are_found(self):
        if not shutil.which("colmap"):
            self.skipTest("COLMAP is not installed (scripts/setup.sh)")
        photos = self.folder / "photos"
        photos.mkdir()
        for i, path in enumerate(sorted(DEMO_PHOTOS.glob("*.jpg"))[:10]):
            shutil.copy(path, photos / f"{i:02}.jpg")
        video = self.folder / "walk.mp4"
        subprocess.run(["ffmpeg", "-loglevel", "error", "-framerate", "5", "-i", photos / "%02d.jpg",
                        "-pix_fmt", "yuv420p", "-crf", "12", video], check=True)
        scene = self.folder / "run" / "1_scene"
        find_cameras = ("sfm", video, "-o", scene, "--frames", 10, "--max-size", 160, "--max-features", 1500)
        self.assert_done(self.run_stage(*find_cameras))
        content = json.loads((scene / "scene.json").read_text())
        # The change between two photos differs, so that a stretch may contain two of them.
        self.assertIn(len(content["views"]), range(7, 11))
        self.assertGreater(content["point_count"], 200)

        # The scene stays if a later run finds no frames, or no features.
        (self.folder / "notes.txt").write_text("not a video")
        self.assert_fails(self.run_stage("sfm", self.folder / "notes.txt", "-o", scene, "--force"), 3,
                          "cannot be read as a video")
        grey = self.folder / "grey"
        grey.mkdir()
        for i in range(3):
            write_png(grey / f"{i}.png", 32, 32, bytes((100 + i, 99, 98, 255)) * 32 * 32)
        self.assert_fails(self.run_stage("sfm", grey, "-o", scene), 3, "COLMAP found no model")
        self.assertIn("up to date", self.run_stage(*find_cameras).stdout)
        self.assertEqual([path.name for path in scene.iterdir() if path.name in ("work", "video")], [])

    def test_what_is_no_video_is_one_clear_line(self):
        (self.folder / "notes.txt").write_text("not a video")
        self.assert_fails(self.run_stage("sfm", self.folder / "notes.txt", "-o", self.folder / "scene"), 3,
                          "notes.txt", "cannot be read as a video")
        (self.folder / "photos").mkdir()
        self.assert_fails(self.run_stage("sfm", self.folder / "photos", "-o", self.folder / "scene",
                                         "--frames", 9), 2, "--frames", "is a folder")
