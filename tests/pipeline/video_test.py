"""Videos of a field."""
import json
import shutil
import subprocess

from stage_case import StageCase


class VideoTest(StageCase):

    def setUp(self):
        super().setUp()
        if not shutil.which("ffprobe"):
            self.skipTest("ffmpeg is not installed (scripts/setup.sh)")

    def probe(self, path):
        result = subprocess.run(
            ["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", path],
            check=True, capture_output=True, text=True)
        return json.loads(result.stdout)["streams"][0]

    def test_a_path_becomes_a_video_of_the_asked_length_and_size(self):
        field = self.folder / "run" / "3_field"
        self.assert_done(self.run_stage("optimize", self.tiny_tetrahedra(), "-o", field,
                                        "--time-limit", 0, "--iterations", 20))
        # A path in which ffmpeg would find a pattern and a protocol.
        orbit = self.folder / "file:%03d"
        self.assert_done(self.run_stage("render", field, "-o", orbit, "--path", "orbit",
                                        "--seconds", 0.5, "--fps", 10, "--size", 64))
        video = self.probe(orbit / "video.mp4")
        self.assertEqual((video["codec_name"], video["width"], video["height"], video["nb_read_frames"],
                          video["r_frame_rate"]), ("h264", 64, 64, "5", "10/1"))
        self.assertFalse((orbit / "frames").exists())
        cameras = self.folder / "cameras"
        self.assert_done(self.run_stage("render", field, "-o", cameras, "--path", "cameras", "--frames", 7))
        self.assertEqual(self.probe(cameras / "video.mp4")["nb_read_frames"], "7")
        self.assertEqual(self.manifest(cameras)["counts"]["frames"], 7)

        self.assert_fails(self.run_stage("render", field, "-o", self.folder / "x", "--path", "orbit",
                                         "--fps", 0), 2, "--fps is 0")
        for options in (("--frames", 3), ("--path", "none", "--frames", 3)):
            self.assert_fails(self.run_stage("render", field, "-o", self.folder / "x", *options), 2,
                              "--frames", "--path")
        (self.folder / "empty").mkdir()
        self.assert_fails(self.run_stage("render", field, "-o", self.folder / "x", "--path", "orbit",
                                         environment={"PATH": str(self.folder / "empty")}),
                          4, "ffmpeg", "install")
