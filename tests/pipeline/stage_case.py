"""Base of the tests of stages: runs them as programs in a temporary folder."""
import hashlib
import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from tiny_dataset import write_tiny_dataset

BIN = pathlib.Path(os.environ["TETREC_BIN_DIR"])

# Longest that any one stage may take on these tiny inputs, on a busy machine [s].
TIME_LIMIT = 300


class StageCase(unittest.TestCase):
    """A test case with a temporary folder (`self.folder`)."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tetrec-test-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def program(self, stage):
        path = BIN / f"tetrec-{stage}"
        if not path.exists():
            self.fail(f"{path.name} was not built")
        return path

    def skip_without_vulkan(self, returncode, stderr):
        """Skips the test if a stage failed because this build has no Vulkan renderers."""
        if returncode == 4 and "needs Vulkan, which this build was made without" in stderr:
            self.skipTest("this build has no Vulkan renderers (TETREC_VULKAN=OFF)")

    def start(self, stage, *arguments, environment=None, **options):
        """Starts a stage and returns its process."""
        return subprocess.Popen(
            [self.program(stage), *map(str, arguments)], stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, env=os.environ | (environment or {}), **options)

    def run_stage(self, stage, *arguments, **options):
        """Runs a stage to its end."""
        process = self.start(stage, *arguments, **options)
        try:
            out, err = process.communicate(timeout=TIME_LIMIT)
        finally:
            process.kill()
        return subprocess.CompletedProcess(process.args, process.returncode, out, err)

    def assert_done(self, result):
        self.skip_without_vulkan(result.returncode, result.stderr)
        self.assertEqual(result.returncode, 0, result.stderr)

    def assert_fails(self, result, exit_code, *parts):
        """Expects the exit code and one error, in the last line, that contains each of `parts`."""
        self.assertEqual(result.returncode, exit_code, result.stderr)
        program = pathlib.Path(result.args[0]).name
        errors = [line for line in result.stderr.splitlines() if line.startswith(program + ": ")]
        self.assertEqual(len(errors), 1, result.stderr)
        self.assertEqual(errors[0], result.stderr.splitlines()[-1])
        self.assertNotIn("bug", errors[0])
        for part in parts:
            self.assertIn(part, errors[0])

    def tiny_scene(self, **dataset):
        """Makes the scene folder of the tiny data set; `dataset` as write_tiny_dataset takes it."""
        write_tiny_dataset(self.folder / "ball", **dataset)
        scene = self.folder / "run" / "1_scene"
        self.assert_done(self.run_stage("import", self.folder / "ball", "-o", scene))
        return scene

    def tiny_tetrahedra(self, **dataset):
        """Makes the tetrahedra folder of the tiny data set: a coarse mesh."""
        tetrahedra = self.folder / "run" / "2_tetrahedra"
        self.assert_done(self.run_stage("tetrahedralize", self.tiny_scene(**dataset), "-o", tetrahedra,
                                        "--resolution", 16, "--outer-points", 50))
        return tetrahedra

    def manifest(self, folder):
        return json.loads((folder / "manifest.json").read_text())

    def status(self, folder):
        return json.loads((folder / "status.json").read_text())["status"]

    def wait_for(self, condition, process, what):
        """Waits until condition() is true; fails if the process ends before."""
        deadline = time.monotonic() + TIME_LIMIT
        while not condition():
            if process.poll() is not None:
                stderr = process.stderr.read()
                self.skip_without_vulkan(process.returncode, stderr)
                self.fail(f"ended ({process.returncode}) before {what}: {stderr}")
            self.assertLess(time.monotonic(), deadline, f"waited for {what}")
            time.sleep(0.01)


def hashes(folder):
    """sha256 of every file below a folder, except those that describe the run itself."""
    own = {"manifest.json", "status.json", "log.txt", ".lock"}
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*")) if path.is_file() and path.name not in own
    }


def limit_file_size(size):
    """For preexec_fn of subprocess: no file can grow beyond `size` bytes. A write that would exceed it
    fails (EFBIG), as on a full disk, instead of ending the process."""
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return limit
