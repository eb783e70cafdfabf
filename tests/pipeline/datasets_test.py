"""scripts/fetch_dataset: what it installs, what it refuses, how it downloads."""
import fcntl
import gzip
import hashlib
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile

from file_server import FileServer
from stage_case import limit_file_size
from tiny_dataset import write_png

ROOT = pathlib.Path(__file__).resolve().parents[2]
FETCH = ROOT / "scripts" / "fetch_dataset"
SPECS = ROOT / "datasets_spec"
COUNTS = {"train": 3, "val": 1, "test": 2}
WIDTH, HEIGHT = 4, 3
# Runs a program that dies before one of the steps that change installed data; the first argument is
# the number of that step.
DYING = """
import os, pathlib, runpy, shutil, sys
left = int(sys.argv[1])
def dying(step):
    def run(*arguments, **options):
        global left
        if left == 0:
            os._exit(99)
        left -= 1
        return step(*arguments, **options)
    return run
pathlib.Path.rename, shutil.rmtree = dying(pathlib.Path.rename), dying(shutil.rmtree)
sys.argv = sys.argv[2:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def write_cube(folder):
    """Writes a NeRF-synthetic data set of grey images."""
    for split, count in COUNTS.items():
        (folder / split).mkdir(parents=True)
        for i in range(count):
            write_png(folder / split / f"r_{i}.png", WIDTH, HEIGHT, bytes([128] * 4 * WIDTH * HEIGHT))
        frames = [{"file_path": f"./{split}/r_{i}", "transform_matrix": []} for i in range(count)]
        (folder / f"transforms_{split}.json").write_text(json.dumps({"frames": frames}))


def zip_of(folder, prefix):
    """The bytes of a zip file of a folder's files, stored below `prefix`."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(folder.rglob("*")):
            archive.write(path, f"{prefix}/{path.relative_to(folder)}")
    return out.getvalue()


def state(folder):
    """Every path below a folder with its content and modification time."""
    return {str(path.relative_to(folder)): (path.stat().st_mtime_ns, path.is_file() and path.read_bytes())
            for path in sorted(folder.rglob("*"))}


class DatasetsTest(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tetrec-test-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.to = self.folder / "datasets"
        self.cube = self.folder / "mine" / "cube"
        write_cube(self.cube)
        self.archive = zip_of(self.cube, "shapes/cube")

    def describe(self, name="cube", **archive):
        """Writes a spec of the cube, modelled on lego's; its archive has no hash unless given."""
        spec = json.loads((SPECS / "lego.json").read_text())
        spec["name"] = name
        spec["archive"] |= {"file": "shapes.zip", "folder": f"shapes/{name}", "sha256": None,
                            "urls": [], "by_hand": "https://example.org/shapes"} | archive
        for entry, count in zip(spec["pictures"], COUNTS.values()):
            entry |= {"counts": [count], "size_px": [WIDTH, HEIGHT]}
        specs = self.folder / "specs"
        specs.mkdir(exist_ok=True)
        (specs / f"{name}.json").write_text(json.dumps(spec))

    def describe_photos(self, folder, count):
        """Describes 'walk', photos in `folder` of an archive with an unknown layout."""
        self.describe("walk", folder=None)
        path = self.folder / "specs" / "walk.json"
        spec = json.loads(path.read_text())
        spec |= {"kind": "photos", "required": [],
                 "pictures": [{"folder": folder, "counts": [count], "size_px": None}]}
        path.write_text(json.dumps(spec))

    def fetch(self, *arguments, specs=None, dies_before=None, **options):
        dying = [] if dies_before is None else ["-c", DYING, dies_before]
        command = [sys.executable, *dying, FETCH, "--specs", specs or self.folder / "specs", "--to", self.to,
                   "--retry-wait", "0", *arguments]
        environment = {k: v for k, v in os.environ.items() if not k.lower().endswith("_proxy")}
        return subprocess.run([str(word) for word in command], capture_output=True, text=True,
                              timeout=60, check=False, env=environment, **options)

    def serve(self, *arguments, **options):
        server = FileServer(*arguments, **options)
        self.addCleanup(server.close)
        return server

    def write(self, content, name="shapes.zip"):
        path = self.folder / name
        path.write_bytes(content)
        return path

    def assert_in_place(self, result, source=None):
        self.assertEqual(result.returncode, 0, result.stderr)
        for path in (source or self.cube).rglob("*"):
            if path.is_file():
                copy = self.to / "cube" / path.relative_to(source or self.cube)
                self.assertEqual(copy.read_bytes(), path.read_bytes(), copy)
        self.assert_nothing_half_done()

    def assert_nothing_half_done(self):
        if self.to.exists():
            self.assertEqual([p for p in self.to.glob(".*") if p.name != ".lock"], [])

    def assert_refused(self, result, exit_code, *parts):
        """Expects one line of error with each of `parts`, and nothing installed."""
        self.assertEqual(result.returncode, exit_code, result.stdout + result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertTrue(result.stderr.startswith("fetch_dataset: "), result.stderr)
        for part in parts:
            self.assertIn(part, result.stderr)
        self.assertFalse((self.to / "cube").exists())
        self.assert_nothing_half_done()

    # Data that the user has.

    def test_a_zip_archive_is_unpacked_checked_and_installed(self):
        self.describe(bytes=len(self.archive), sha256=hashlib.sha256(self.archive).hexdigest())
        result = self.fetch("cube", "--from", self.write(self.archive))
        self.assert_in_place(result)
        self.assertIn(f"tetrec-import {self.to}/cube", result.stdout)

    def test_the_data_is_found_in_a_tar_archive_with_another_layout(self):
        self.describe()
        path = self.folder / "cube.tar.gz"
        with tarfile.open(path, "w:gz") as archive:
            archive.add(self.cube, "from a friend/cube")
        self.assert_in_place(self.fetch("cube", "--from", path))

    def test_only_the_data_sets_own_part_of_an_archive_is_unpacked(self):
        self.describe()
        shutil.copytree(self.cube, self.folder / "mine" / "ball")
        path = self.write(zip_of(self.folder / "mine", "shapes"))
        self.assert_in_place(self.fetch("cube", "--from", path))
        self.assertEqual(sorted(p.name for p in self.to.iterdir()), [".lock", "cube"])

    def test_a_folder_is_copied_also_if_its_parent_is_given(self):
        self.describe()
        self.assert_in_place(self.fetch("cube", "--from", self.folder / "mine"))
        self.assertTrue((self.cube / "train" / "r_0.png").exists())

    def test_photos_are_found_where_most_images_of_the_archive_are(self):
        self.describe_photos(".", 3)
        path = self.write(zip_of(self.cube / "train", "Walk/frames"))
        self.assertEqual(self.fetch("walk", "--from", path).returncode, 0)
        self.assertEqual(len(list((self.to / "walk").iterdir())), 3)

    def test_photos_in_a_named_folder_are_found_below_any_other(self):
        self.describe_photos("images", 3)
        path = self.write(zip_of(self.cube / "train", "walk-main/data/images"))
        self.assertEqual(self.fetch("walk", "--from", path).returncode, 0)
        self.assertEqual(len(list((self.to / "walk" / "images").iterdir())), 3)

    def test_a_second_run_does_nothing(self):
        self.describe()
        path = self.write(self.archive)
        self.assert_in_place(self.fetch("cube", "--from", path))
        before = state(self.to)
        result = self.fetch("cube", "--from", path)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("is installed", result.stdout)
        self.assertEqual(state(self.to), before)

    def test_leftovers_of_a_killed_run_are_removed(self):
        self.describe()
        (self.to / ".cube.new").mkdir(parents=True)
        (self.to / ".cube.new" / "half.png").touch()
        self.assert_in_place(self.fetch("cube", "--from", self.cube))
        self.assertFalse((self.to / "cube" / "half.png").exists())

    # Damaged installed data.

    def put_damaged_cube(self):
        """Installs the cube and removes one of its images; returns the state of the folder."""
        self.describe()
        self.assert_in_place(self.fetch("cube", "--from", self.cube))
        (self.to / "cube" / "test" / "r_1.png").unlink()
        return state(self.to / "cube")

    def assert_refused_in_place(self, result, *parts):
        self.assertEqual(result.returncode, 3, result.stdout + result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        for part in parts:
            self.assertIn(part, result.stderr)

    def test_the_advice_for_damaged_installed_data_works(self):
        self.put_damaged_cube()
        for arguments in ([], ["--from", self.cube], ["--check"], ["--allow-partial"]):
            self.assert_refused_in_place(self.fetch("cube", *arguments), "r_1.png is missing",
                                         f"run with --again, which replaces {self.to}/cube")
        self.assert_in_place(self.fetch("cube", "--from", self.cube, "--again"))
        self.assertEqual(self.fetch("cube").returncode, 0)

    def test_again_also_replaces_data_that_only_differs_and_installs_missing_data(self):
        self.describe()
        self.assert_in_place(self.fetch("cube", "--from", self.cube, "--again"))
        write_png(self.to / "cube" / "train" / "r_0.png", 2, 1, bytes(8))
        self.assert_refused_in_place(self.fetch("cube"), "2 x 1 pixels", "--allow-partial", "--again")
        self.assert_in_place(self.fetch("cube", "--from", self.cube, "--again"))

    def test_installed_data_stays_until_the_new_data_is_complete_and_checked(self):
        before = self.put_damaged_cube()
        (self.cube / "val" / "r_0.png").unlink()
        failing = {"val/r_0.png": ["--from", self.cube], "--from shapes.zip": [],
                   "neither a folder nor": ["--from", self.write(self.archive[:-30])]}
        for part, arguments in failing.items():
            result = self.fetch("cube", "--again", *arguments)
            self.assertIn(result.returncode, (3, 4))
            self.assertIn(part, result.stderr)
            self.assertEqual(state(self.to / "cube"), before)
            self.assert_nothing_half_done()

    def test_a_replacement_killed_anywhere_loses_nothing(self):
        self.put_damaged_cube()
        damaged = self.folder / "damaged"
        shutil.copytree(self.to / "cube", damaged)
        outcomes = []
        for step in range(20):
            shutil.rmtree(self.to)
            shutil.copytree(damaged, self.to / "cube")
            killed = self.fetch("cube", "--from", self.cube, "--again", dies_before=step)
            if killed.returncode == 0:
                break
            self.assertEqual(killed.returncode, 99, killed.stderr)
            result = self.fetch("cube")
            outcomes.append(result.returncode)
            if result.returncode == 0:  # the new data is installed already
                self.assert_in_place(result)
            else:
                self.assert_refused_in_place(result, "r_1.png is missing", "--again")
            self.assertFalse((self.to / ".cube.old").exists())
            self.assert_in_place(self.fetch("cube", "--from", self.cube, "--again"))
        self.assert_in_place(killed)
        # Until the new data is installed the old data is restored: at the clean-up and at both
        # renames. After that only the old data and leftovers remain to be removed.
        self.assertEqual(outcomes, [3, 3, 3, 0, 0])

    def test_a_link_is_replaced_and_its_target_left_alone(self):
        before = self.put_damaged_cube()
        (self.to / "cube").rename(self.folder / "elsewhere")
        (self.to / "cube").symlink_to(self.folder / "elsewhere")
        self.assert_in_place(self.fetch("cube", "--from", self.cube, "--again"))
        self.assertFalse((self.to / "cube").is_symlink())
        self.assertEqual(state(self.folder / "elsewhere"), before)

    def test_two_runs_in_one_folder_do_not_collide(self):
        self.describe()
        self.to.mkdir()
        with (self.to / ".lock").open("w") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            self.assert_refused(self.fetch("cube", "--from", self.cube), 4, "another fetch_dataset")
        self.assert_in_place(self.fetch("cube", "--from", self.cube))

    def test_a_full_disk_is_an_environment_error(self):
        self.describe()
        (self.cube / "large.bin").write_bytes(bytes(100000))
        result = self.fetch("cube", "--from", self.cube, preexec_fn=limit_file_size(50000))
        self.assert_refused(result, 4, "large.bin")

    def test_check_installs_nothing(self):
        self.describe()
        for source in (self.cube, self.write(self.archive)):
            result = self.fetch("cube", "--from", source, "--check")
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assertFalse(self.to.exists())

    def test_a_single_file_needs_no_archive(self):
        volume = bytes(range(256))
        self.describe("cloud", format="file", file="cloud.raw", folder=None, bytes=256,
                      sha256=hashlib.sha256(volume).hexdigest())
        path = self.folder / "specs" / "cloud.json"
        spec = json.loads(path.read_text()) | {"kind": "volume", "required": ["cloud.raw"], "pictures": []}
        path.write_text(json.dumps(spec))
        self.assertEqual(self.fetch("cloud", "--from", self.write(volume, "any name")).returncode, 0)
        self.assertEqual((self.to / "cloud" / "cloud.raw").read_bytes(), volume)
        wrong = self.fetch("cloud", "--from", self.write(volume[::-1], "wrong"), "--to", self.to / "b")
        self.assert_refused(wrong, 3, "sha256", spec["archive"]["sha256"])

    # Data that differs from the original.

    def test_a_wrong_hash_is_refused_unless_allowed_and_then_named(self):
        self.describe(sha256="0" * 64)
        path = self.write(self.archive)
        self.assert_refused(self.fetch("cube", "--from", path), 3, "sha256", "--allow-partial")
        result = self.fetch("cube", "--from", path, "--allow-partial")
        self.assert_in_place(result)
        self.assertIn(f"differs: shapes.zip has sha256 {hashlib.sha256(self.archive).hexdigest()}",
                      result.stdout)

    def test_a_missing_image_is_refused_whatever_is_allowed(self):
        self.describe()
        (self.cube / "test" / "r_1.png").unlink()
        for source in (self.cube, self.write(zip_of(self.cube, "shapes/cube"))):
            self.assert_refused(self.fetch("cube", "--from", source, "--allow-partial"), 3, "r_1.png")

    def test_fewer_and_smaller_images_are_refused_unless_allowed(self):
        self.describe()
        write_png(self.cube / "train" / "r_0.png", 2, 1, bytes(8))
        (self.cube / "transforms_test.json").write_text(json.dumps({"frames": [{"file_path": "test/r_0.png"}]}))
        differences = ["1 images of 2 x 1 pixels, 4 x 3 expected", "transforms_test.json: 1 images, 2 expected"]
        self.assert_refused(self.fetch("cube", "--from", self.cube), 3, *differences)
        result = self.fetch("cube", "--from", self.cube, "--allow-partial")
        self.assert_in_place(result)
        for difference in differences:
            self.assertIn("differs: ", result.stdout)
            self.assertIn(difference, result.stdout)
        self.assertIn("differs", self.fetch("--list").stdout)
        self.assertEqual(self.fetch("cube").returncode, 3)
        self.assertEqual(self.fetch("cube", "--allow-partial").returncode, 0)

    def test_a_file_that_is_not_an_image_is_named(self):
        self.describe()
        (self.cube / "val" / "r_0.png").write_bytes(b"\xff\xd8\xff\xe0\x00")
        self.assert_refused(self.fetch("cube", "--from", self.cube, "--allow-partial"), 3, "val/r_0.png")

    def test_truncated_files_are_refused_whatever_is_allowed(self):
        self.describe()
        picture = self.cube / "train" / "r_1.png"
        picture.write_bytes(picture.read_bytes()[:-12])  # the last chunk
        result = self.fetch("cube", "--from", self.cube, "--allow-partial")
        self.assert_refused(result, 3, "train/r_1.png", "not a complete PNG")
        self.describe("cloud", format="file", file="cloud.raw", folder=None, bytes=256, sha256="0" * 64)
        path = self.folder / "specs" / "cloud.json"
        spec = json.loads(path.read_text()) | {"kind": "volume", "required": ["cloud.raw"], "pictures": []}
        path.write_text(json.dumps(spec))
        result = self.fetch("cloud", "--from", self.write(bytes(200), "part"), "--allow-partial")
        self.assert_refused(result, 3, "is truncated: 200 of 256 bytes")

    def test_a_list_that_names_files_outside_is_refused(self):
        self.describe()
        write_png(self.folder / "mine" / "r_0.png", WIDTH, HEIGHT, bytes(4 * WIDTH * HEIGHT))
        for name in ("../r_0", "/etc/passwd", "train/../../r_0.png"):
            (self.cube / "transforms_val.json").write_text(json.dumps({"frames": [{"file_path": name}]}))
            self.assert_refused(self.fetch("cube", "--from", self.cube), 3, name, "outside")

    def test_a_broken_list_is_named(self):
        self.describe()
        for text in ("{", "[]", '{"frames": 3}', '{"frames": [{"file_path": 3}]}', "[" * 100000):
            (self.cube / "transforms_val.json").write_text(text)
            self.assert_refused(self.fetch("cube", "--from", self.cube), 3, "transforms_val.json")

    def test_the_archive_of_something_else_is_refused(self):
        self.describe()
        (self.cube / "transforms_val.json").unlink()
        self.assert_refused(self.fetch("cube", "--from", self.cube), 3, "transforms_val.json")
        (self.cube / "transforms_train.json").unlink()
        other = self.write(zip_of(self.cube, "other"))
        self.assert_refused(self.fetch("cube", "--from", other), 3, "is it the archive of cube?")

    def test_another_data_set_of_the_same_kind_is_refused(self):
        self.describe()
        self.describe("ball")
        for source in (self.cube, self.write(zip_of(self.cube, "cube"))):
            for check in ([], ["--check"]):
                result = self.fetch("ball", "--from", source, "--allow-partial", *check)
                self.assert_refused(result, 3, "another data set, cube")
        self.assertFalse((self.to / "ball").exists())

    def keep_archive(self, content):
        """Writes an archive where an earlier download would have left it."""
        (self.to / "archives").mkdir(parents=True)
        (self.to / "archives" / "shapes.zip").write_bytes(content)

    def test_a_kept_archive_that_differs_can_be_allowed(self):
        self.describe(sha256="0" * 64)
        self.keep_archive(self.archive)
        self.assert_refused(self.fetch("cube"), 3, "sha256", "--allow-partial")
        result = self.fetch("cube", "--allow-partial")
        self.assert_in_place(result)
        self.assertEqual(result.stdout.count("differs: shapes.zip has sha256"), 1, result.stdout)

    def test_the_advice_for_a_kept_archive_that_is_damaged_works(self):
        server = self.serve({"/shapes.zip": self.archive})
        advice = f"to get it again, remove {self.to}/archives/shapes.zip"
        for sha256 in (None, hashlib.sha256(self.archive).hexdigest()):
            self.describe(urls=[f"{server.url}/shapes.zip"], sha256=sha256)
            shutil.rmtree(self.to, ignore_errors=True)
            self.keep_archive(self.archive[:-30])
            self.assert_refused(self.fetch("cube"), 3, advice)
            self.assertEqual(server.requests, [])
            (self.to / "archives" / "shapes.zip").unlink()
            self.assert_in_place(self.fetch("cube"))
            server.requests.clear()

    def test_again_unpacks_a_kept_archive_again(self):
        server = self.serve({"/shapes.zip": self.archive})
        self.describe(urls=[f"{server.url}/shapes.zip"], sha256=hashlib.sha256(self.archive).hexdigest())
        self.assert_in_place(self.fetch("cube"))
        (self.to / "cube" / "transforms_val.json").unlink()
        self.assert_in_place(self.fetch("cube", "--again"))
        self.assertEqual(server.requests, [("/shapes.zip", None)])

    # Hostile archives.

    def hostile_zip(self, *members):
        """A good archive with additional members (name or ZipInfo, content)."""
        path = self.write(self.archive, "hostile.zip")
        with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
            for name, content in members:
                archive.writestr(name, content)
        return path

    def test_a_zip_that_leaves_the_folder_is_refused(self):
        self.describe()
        for name in ("../evil", "shapes/cube/../../../evil", "/tmp/evil", "..\\evil", "\\evil",
                     "C:\\evil", "shapes/cube/" + "x" * 900, "shapes/cube/" + "y" * 300):
            result = self.fetch("cube", "--from", self.hostile_zip((name, b"evil")))
            self.assert_refused(result, 3, "hostile.zip contains", "do not trust it")
        self.assertFalse((self.folder / "evil").exists())

    def test_a_zip_with_a_link_is_refused(self):
        self.describe()
        link = zipfile.ZipInfo("shapes/cube/train/more")
        link.external_attr = 0o120777 << 16
        self.assert_refused(self.fetch("cube", "--from", self.hostile_zip((link, b"/etc"))), 3, "a link")

    def test_a_zip_that_contains_a_name_twice_is_refused(self):
        self.describe()
        twice = self.hostile_zip(("shapes//cube/./transforms_train.json", b"{}"))
        self.assert_refused(self.fetch("cube", "--from", twice), 3, "twice")
        both = self.hostile_zip(("shapes/cube/both", b"file"), ("shapes/cube/both/x", b"file in it"))
        self.assert_refused(self.fetch("cube", "--from", both), 3, "as a file and as a folder")

    def test_an_unbounded_tar_header_is_refused_unread(self):
        self.describe()
        path = self.folder / "hostile.tar.gz"
        header = tarfile.TarInfo("pax")
        header.type, header.size = tarfile.XHDTYPE, 64 << 20
        for first in (b"", tarfile.TarInfo("file").tobuf(tarfile.PAX_FORMAT)):
            path.write_bytes(gzip.compress(first + header.tobuf(tarfile.USTAR_FORMAT) + bytes(1 << 20)))
            self.assert_refused(self.fetch("cube", "--from", path), 3, "a header of 67108864 bytes")

    def test_a_zip_bomb_is_refused_before_anything_is_written(self):
        self.describe()
        bomb = self.hostile_zip(("shapes/cube/zeros", bytes(100 << 20)))
        self.assertLess(bomb.stat().st_size, 1 << 20)
        self.assert_refused(self.fetch("cube", "--from", bomb), 3, "unpacks to more than")

    def test_a_tar_with_links_devices_or_ways_out_is_refused(self):
        self.describe()
        kinds = {"a symbolic link": tarfile.SYMTYPE, "a hard link": tarfile.LNKTYPE, "a device": tarfile.CHRTYPE,
                 "a pipe": tarfile.FIFOTYPE, "../a way out": tarfile.REGTYPE, "/a way out": tarfile.REGTYPE}
        for name, kind in kinds.items():
            path = self.folder / "hostile.tar"
            with tarfile.open(path, "w") as archive:
                archive.add(self.cube, "shapes/cube")
                info = tarfile.TarInfo(name)
                info.type, info.linkname = kind, "/etc/passwd"
                archive.addfile(info)
            self.assert_refused(self.fetch("cube", "--from", path), 3, name, "do not trust it")

    def test_a_tar_that_claims_an_absurd_size_costs_nothing(self):
        self.describe()
        info = tarfile.TarInfo("shapes/cube/huge")
        info.size = 1 << 60
        path = self.write(info.tobuf(tarfile.GNU_FORMAT) + bytes(1024), "hostile.tar")
        self.assert_refused(self.fetch("cube", "--from", path), 3, "unpacks to more than")

    def test_broken_archives_are_named(self):
        self.describe()
        tar = io.BytesIO()
        with tarfile.open(fileobj=tar, mode="w:gz") as archive:
            archive.add(self.cube, "shapes/cube")
        with zipfile.ZipFile(io.BytesIO(self.archive)) as archive:
            info = archive.getinfo("shapes/cube/transforms_train.json")
        flipped = bytearray(self.archive)
        flipped[info.header_offset + 30 + len(info.filename) + info.compress_size // 2] ^= 0xff
        for content in (b"", b"no archive", self.archive[:-30], tar.getvalue()[:300], bytes(flipped)):
            self.assert_refused(self.fetch("cube", "--from", self.write(content)), 3, "shapes.zip")

    # Downloads.

    def test_a_download_is_installed_and_used_for_other_scenes_too(self):
        shutil.copytree(self.cube, self.folder / "mine" / "ball")
        shapes = zip_of(self.folder / "mine", "shapes")
        server = self.serve({"/shapes.zip": shapes})
        for name in ("cube", "ball"):
            self.describe(name, urls=[f"{server.url}/shapes.zip"], bytes=len(shapes),
                          sha256=hashlib.sha256(shapes).hexdigest())
        self.assert_in_place(self.fetch("cube"))
        self.assert_in_place(self.fetch("cube"))
        self.assertEqual(self.fetch("ball").returncode, 0)
        self.assertEqual(server.requests, [("/shapes.zip", None)])
        self.assertEqual(os.listdir(self.to / "archives"), ["shapes.zip"])

    def test_an_interrupted_connection_is_resumed(self):
        server = self.serve({"/shapes.zip": self.archive}, cut_after=len(self.archive) // 3 + 1)
        self.describe(urls=[f"{server.url}/shapes.zip"])
        self.assert_in_place(self.fetch("cube"))
        step = server.cut_after
        self.assertEqual(server.requests, [("/shapes.zip", None), ("/shapes.zip", f"bytes={step}-"),
                                           ("/shapes.zip", f"bytes={2 * step}-")])

    def half_done(self, server, half, tag, **archive):
        """Leaves an incomplete download as an earlier run would, then fetches."""
        self.describe(urls=[f"{server.url}/shapes.zip"], **archive)
        (self.to / "archives").mkdir(parents=True)
        (self.to / "archives" / "shapes.zip.part").write_bytes(half)
        (self.to / "archives" / "shapes.zip.part.tag").write_text(tag)
        return self.fetch("cube")

    def test_a_later_run_continues_where_the_earlier_one_stopped(self):
        server = self.serve({"/shapes.zip": self.archive})
        self.assert_in_place(self.half_done(server, self.archive[:100], '"1"'))
        self.assertEqual(server.requests, [("/shapes.zip", "bytes=100-")])

    def test_a_download_that_only_lacked_its_name_is_not_repeated(self):
        server = self.serve({"/shapes.zip": self.archive})
        self.assert_in_place(self.half_done(server, self.archive, '"1"'))
        self.assertEqual(server.requests, [("/shapes.zip", f"bytes={len(self.archive)}-")])

    def test_a_file_that_changed_meanwhile_is_downloaded_anew(self):
        server = self.serve({"/shapes.zip": self.archive}, etag='"2"')
        self.assert_in_place(self.half_done(server, bytes(100), '"1"'))

    def test_a_server_without_ranges_starts_over(self):
        server = self.serve({"/shapes.zip": self.archive}, ranges=False)
        self.assert_in_place(self.half_done(server, self.archive[:100], '"1"'))

    def test_without_hash_and_tag_nothing_is_glued_together(self):
        server = self.serve({"/shapes.zip": self.archive}, etag="")
        self.assert_in_place(self.half_done(server, bytes(100), ""))
        self.assertEqual(server.requests, [("/shapes.zip", None)])

    def test_a_download_with_a_wrong_hash_is_deleted(self):
        server = self.serve({"/shapes.zip": self.archive})
        self.describe(urls=[f"{server.url}/shapes.zip"], sha256="0" * 64)
        self.assert_refused(self.fetch("cube"), 3, "sha256", server.url, "deleted")
        self.assertEqual(os.listdir(self.to / "archives"), [])

    def test_a_download_of_another_size_is_not_started(self):
        server = self.serve({"/shapes.zip": self.archive})
        self.describe(urls=[f"{server.url}/shapes.zip"], bytes=7)
        self.assert_refused(self.fetch("cube"), 3, "7 expected", server.url)
        self.assertEqual(os.listdir(self.to / "archives"), [])

    def test_the_next_url_is_tried_if_one_fails(self):
        server = self.serve({"/shapes.zip": self.archive})
        self.describe(urls=[f"{server.url}/gone.zip", f"{server.url}/shapes.zip"])
        self.assert_in_place(self.fetch("cube"))

    def test_a_download_that_fails_says_what_to_do(self):
        page = self.serve({"/shapes.zip": b"<html>sign in</html>"}, content_type="text/html; charset=utf-8")
        gone = self.serve({})
        stuck = self.serve({"/shapes.zip": self.archive}, cut_after=0)
        closed = FileServer({})
        closed.close()
        for server, reason in ((page, "web page"), (gone, "404"), (stuck, "ended early"), (closed, "refused")):
            self.describe(urls=[f"{server.url}/shapes.zip"])
            self.assert_refused(self.fetch("cube"), 4, reason, "fetch_dataset cube --from shapes.zip",
                                "get shapes.zip from https://example.org/shapes")

    def test_data_that_only_a_browser_can_get_is_reported_in_one_line(self):
        self.describe()
        self.assert_refused(self.fetch("cube"), 4, "https://example.org/shapes", "--from shapes.zip")

    # The command line and the real descriptions.

    def test_list_shows_what_is_installed(self):
        self.describe()
        self.describe("ball", bytes=1500000)
        self.assert_in_place(self.fetch("cube", "--from", self.cube))
        lines = {line.split()[0]: line for line in self.fetch("--list").stdout.splitlines()}
        self.assertRegex(lines["cube"], r"nerf-synthetic +CC-BY-NC +\? +yes ")
        self.assertRegex(lines["ball"], r"nerf-synthetic +CC-BY-NC +1\.5 MB +no ")
        (self.to / "cube" / "train" / "r_0.png").unlink()
        self.assertRegex(self.fetch("--list").stdout, r"cube .* broken ")

    def test_wrong_command_lines_are_refused(self):
        self.describe()
        for arguments, part in ((["ball"], "known are cube"), ([], "--list"), (["--list", "cube"], "no name"),
                                (["cube", "--from", "/no/such"], "/no/such"), (["cube", "--check"], "--from"),
                                (["cube", "--from", self.folder], "give another folder"),
                                (["cube", "--check", "--again"], "one of them")):
            self.assert_refused(self.fetch(*arguments), 2, part)
        self.assertEqual(self.fetch("--no-such").returncode, 2)
        (self.folder / "specs" / "cube.json").write_text('{"name": "cube"}')
        self.assert_refused(self.fetch("cube"), 3, "cube.json lacks title")

    def check_import_options(self, kinds):
        """Checks that the help of each program lists the options of every import command of these kinds."""
        helps = {}
        for path in sorted(SPECS.glob("*.json")):
            spec = json.loads(path.read_text())
            if spec.get("kind") not in kinds:
                continue
            stage = spec["import"][0]
            if stage not in helps:
                helps[stage] = self.help_of(stage)
            for option in (word for word in spec["import"] if word.startswith("-")):
                self.assertRegex(helps[stage], rf"(^|[ ,]){re.escape(option)}[ ,]", path.name)
        return sorted(helps)

    def help_of(self, stage):
        program = pathlib.Path(os.environ["TETREC_BIN_DIR"]) / stage
        return subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout

    def test_every_import_command_of_images_uses_existing_options(self):
        self.assertEqual(self.check_import_options(("nerf-synthetic", "photos", "colmap")),
                         ["tetrec-import", "tetrec-sfm"])

    def test_every_import_command_of_volumes_uses_existing_options(self):
        if "--transfer-function" not in self.help_of("tetrec-import"):
            self.skipTest("this tetrec-import reads no volumes")
        self.assertEqual(self.check_import_options(("volume",)), ["tetrec-import"])

    def test_the_reduced_copies_at_hand_pass_with_the_expected_differences(self):
        datasets = pathlib.Path(os.environ.get("TETREC_DATASETS", ROOT / ".." / "shared" / "datasets"))
        if not datasets.exists():
            self.skipTest(f"no data sets at {datasets} (TETREC_DATASETS)")
        differences = {
            ("tooth", "volumes"): [],
            ("fox", "fox"): ["images: 50 images of 540 x 960 pixels"],
            ("lego", "lego"): ["_train.json: 100 images of 400 x 400", "_val.json: 100 images of 400 x 400",
                               "_test.json: 25 images, 200 expected", "_test.json: 25 images of 400 x 400"]}
        for (name, folder), expected in differences.items():
            result = self.fetch(name, "--from", datasets / folder, "--check", "--allow-partial", specs=SPECS)
            self.assertEqual(result.returncode, 0, result.stderr)
            found = [line for line in result.stdout.splitlines() if "differs: " in line]
            self.assertEqual(len(found), len(expected), result.stdout)
            for line, part in zip(found, expected):
                self.assertIn(part, line)


if __name__ == "__main__":
    unittest.main()
