"""The viewer: its page in a browser, who may use it, and what it shows of a run."""
import http.client
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time
import urllib.parse

from stage_case import TIME_LIMIT, StageCase

PYTHON = pathlib.Path("/usr/bin/python3")  # Debian's, for which Debian's selenium is installed
PICTURE = "picture?mode=color&w=32&h=32&view=0"


class ViewTest(StageCase):

    def open_viewer(self, run):
        """Starts the viewer; returns its process and its address."""
        process = self.start("view", run, "--device", "cpu")
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        address = process.stdout.readline().strip()
        if not address:
            stderr = process.stderr.read()
            self.skip_without_vulkan(process.wait(), stderr)
            self.fail(stderr)
        return process, address

    def ask(self, address, path="", **headers):
        """Status, type and body of the answer to a GET below the address, or of an absolute path."""
        url = urllib.parse.urlsplit(address)
        connection = http.client.HTTPConnection(url.hostname, url.port, timeout=TIME_LIMIT)
        self.addCleanup(connection.close)
        connection.request("GET", path if path.startswith("/") else url.path + path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers.get_content_type(), answer.read()

    def test_only_requests_with_the_token_for_a_loopback_host_are_answered(self):
        self.tiny_tetrahedra()
        process, address = self.open_viewer(self.folder / "run")
        url = urllib.parse.urlsplit(address)
        self.assertEqual(url.hostname, "127.0.0.1")
        self.assertEqual(self.ask(address)[:2], (200, "text/html"))
        self.assertEqual(self.ask(address, PICTURE)[:2], (200, "image/jpeg"))
        self.assertEqual(self.ask(address, PICTURE, Host=f"localhost:{url.port}")[0], 200)
        self.assertEqual(self.ask(address, "nothing")[0], 404)
        wrong = url.path[:-2] + ("0" if url.path[-2] != "0" else "1") + "/"
        for path, host in (("/", None), ("/picture", None), (wrong, None), (wrong + PICTURE, None),
                           (url.path, f"evil.example:{url.port}"), (url.path + PICTURE, "evil.example")):
            with self.subTest(path=path, host=host):
                self.assertEqual(self.ask(address, path, **({"Host": host} if host else {}))[0], 403)
        status, _, reason = self.ask(address, "picture?mode=color&w=99999&h=32&view=0")
        self.assertEqual((status, reason), (400, b"w is '99999'; expected a number from 8 to 4096\n"))
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=TIME_LIMIT)
        self.assertEqual(process.returncode, 130, stderr)
        self.assertIn("tetrec-view: stopped by the user", stderr.splitlines()[-1])

    def test_odd_requests_and_a_crowd_of_silent_connections_keep_nobody_out(self):
        self.tiny_tetrahedra()
        process, address = self.open_viewer(self.folder / "run")
        url = urllib.parse.urlsplit(address)
        host = f"Host: 127.0.0.1:{url.port}"

        def answer(*lines):
            """The status of the answer to a request of these lines, and its length."""
            with socket.create_connection((url.hostname, url.port), timeout=TIME_LIMIT) as connection:
                connection.sendall("".join(line + "\r\n" for line in (*lines, "Connection: close", "")).encode())
                parts = iter(lambda: connection.recv(1 << 16), b"")
                content = b"".join(parts)
            return int(content.split()[1]), len(content)

        get = f"GET {url.path} HTTP/1.1"
        self.assertEqual(answer(get, host)[0], 200)
        for lines, status in (((get,), 403), ((get, host, "Host: evil"), 403), ((get, "Host: evil", host), 403),
                              ((get, host, "Range: bytes=" + ",".join(900 * ["0-"])), 400),
                              ((f"POST {url.path} HTTP/1.1", host, "Content-Length: 99999999999"), 405),
                              ((f"DELETE {url.path} HTTP/1.1", host), 405)):
            status_of_answer, length = answer(*lines)
            self.assertEqual(status_of_answer, status, lines)
            self.assertLess(length, 200_000)  # 900 times the refusal, not 900 times the page
        for query in ("w=-1&h=8", "w=nan&h=8", "w=8&h=1e300", "w=%00&h=%ff%fe", "w=8&h=8&view=-1",
                      "w=8&h=8&eye=inf,0,0&forward=0,0,1&up=0,1,0&fov=40", "w=" + 5000 * "9" + "&h=8"):
            status, _, reason = self.ask(address, "picture?mode=color&" + query)
            self.assertEqual(status, 400, query)
            self.assertRegex(reason, rb"\A[^\x00-\x1f]{1,200}\n\Z", query)
        crowd = [socket.create_connection((url.hostname, url.port)) for _ in range(150)]
        for connection in crowd:
            self.addCleanup(connection.close)
            connection.sendall(b"GET /")
        before = time.monotonic()
        self.assertEqual(self.ask(address, "status")[0], 200)
        self.assertLess(time.monotonic() - before, 30)  # [s]
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130)

    def test_a_run_that_changes_or_vanishes_keeps_the_last_field_shown(self):
        tetrahedra = self.tiny_tetrahedra()
        process, address = self.open_viewer(self.folder / "run")

        def problem():
            return json.loads(self.ask(address, "status")[2])["problem"]

        self.assertEqual(self.ask(address, PICTURE)[0], 200)
        os.mkfifo(tetrahedra / "pipe")
        (tetrahedra / "pipe").rename(tetrahedra / "field.tetf")
        self.wait_for(lambda: "field.tetf" in problem(), process, "the pipe was noticed")
        shutil.rmtree(self.folder / "run")
        self.wait_for(lambda: "no field" in problem(), process, "the loss was noticed")
        self.assertEqual(self.ask(address, PICTURE)[0], 200)
        status, _, reason = self.ask(address, PICTURE.replace("color", "photo"))
        self.assertEqual(status, 500)
        self.assertIn(b".png", reason)
        self.assertIsNone(process.poll())

    def test_a_newer_field_of_the_run_replaces_the_shown_one_and_a_checkpoint_can_be_seen(self):
        tetrahedra, field = self.tiny_tetrahedra(), self.folder / "run" / "3_field"
        process, address = self.open_viewer(self.folder / "run")

        def status():
            return json.loads(self.ask(address, "status")[2])

        def picture():
            return self.ask(address, PICTURE)[2]

        self.assertEqual(status()["field"], "start, before any fit")
        start = picture()
        optimize = self.start("optimize", tetrahedra, "-o", field, "--time-limit", 0, "--iterations",
                              100000, "--checkpoint-interval", 0.2)
        self.addCleanup(optimize.communicate)
        self.addCleanup(optimize.kill)
        self.wait_for(lambda: status()["field"] == "last checkpoint of an unfinished fit", process,
                      "the checkpoint was shown")
        self.wait_for(lambda: picture() != start, process, "the picture changed")
        optimize.kill()
        optimize.wait()
        # A damaged file keeps the last field shown.
        (field / "checkpoint.bin").write_bytes(b"TETRECKI, and nothing else")
        self.wait_for(lambda: status()["problem"], process, "the damage was noticed")
        self.assertIn("checkpoint.bin", status()["problem"])
        shown = status()["loaded"]
        self.assertEqual((self.ask(address, PICTURE)[0], status()["loaded"]), (200, shown))

    def test_a_repeated_run_is_shown_with_its_new_scene(self):
        self.tiny_tetrahedra()
        process, address = self.open_viewer(self.folder / "run")

        def answer(path):
            return json.loads(self.ask(address, path)[2])

        before = answer("scene")
        self.assertEqual(before["number"], answer("status")["scene"])
        shutil.rmtree(self.folder / "ball")
        self.tiny_tetrahedra(train=36)
        self.wait_for(lambda: answer("status")["scene"] > before["number"], process, "the scene was shown")
        after = answer("scene")
        self.assertEqual(after["number"], answer("status")["scene"])
        self.assertEqual(answer("status")["problem"], "")
        self.assertLess(len(after["views"]), len(before["views"]))
        for index, status in ((len(after["views"]) - 1, 200), (len(before["views"]) - 1, 400)):
            self.assertEqual(self.ask(address, PICTURE.replace("view=0", f"view={index}"))[0], status)

    def test_wrong_input_is_refused_in_one_line(self):
        empty = self.folder / "empty"
        empty.mkdir()
        self.assert_fails(self.run_stage("view", self.folder / "nowhere"), 2, "nowhere", "not a folder")
        self.assert_fails(self.run_stage("view", empty), 3, "empty", "contains no run")
        self.assert_fails(self.run_stage("view", empty, "--port", 70000), 2, "--port", "70000")
        scene = self.tiny_scene()
        self.assert_fails(self.run_stage("view", scene.parent), 3, "contains no field yet")

    def test_the_page_draws_pictures_and_answers_a_drag_keys_and_modes(self):
        if not (pathlib.Path("/usr/bin/chromedriver").exists() and subprocess.run(
                [PYTHON, "-c", "import selenium"], check=False, capture_output=True).returncode == 0):
            self.skipTest("chromium-driver or python3-selenium is not installed (scripts/setup.sh)")
        self.tiny_tetrahedra()
        _, address = self.open_viewer(self.folder / "run")
        result = subprocess.run(
            [PYTHON, "-B", pathlib.Path(__file__).with_name("open_viewer.py"), address],
            check=False, capture_output=True, text=True, timeout=300)
        self.assertEqual(result.returncode, 0, result.stderr)
        for look, page in json.loads(result.stdout).items():
            with self.subTest(look=look):
                self.assertEqual((page["console"], page["message"]), ([], ""))
                hashes = [hash_ for hash_, _ in page["pictures"]]
                self.assertEqual(len(set(hashes)), len(hashes), "a picture did not change")
                self.assertGreater(min(colors for _, colors in page["pictures"]), 8)
                self.assertTrue(page["draft_ms"])  # a drag is answered by smaller pictures
                self.assertLessEqual(page["too_wide_px"], 0)
                self.assertIn("does not answer", page["silence"])
