"""Hostile files, folders, options and limits, in tables: whatever a stage is given, it ends soon, with 0 or
with one clear line and the exit code of the user's, the data's or the machine's fault; it prints no
control characters and touches nothing outside of its folder."""
import json
import os
import pathlib
import re
import resource
import shutil
import struct
import subprocess
import unittest

from hostile_case import CASE_LIMIT, VALUES, HostileCase, leaves, replaced
from stage_case import BIN

WORDS = ("nan", "-1", "1e400", "0", "99999999999999999999", "\x1b[2J", "", "../victims")


class HostileTest(HostileCase):
    """Each test is one class of attacks."""

    def test_views_with_similar_names_have_files_of_their_own(self):
        ball = self.dataset()
        long = "d" * 200
        tables = {
            "numbers": ["frame.0000", "frame.0001", "1305031102.175304", "1305031102.175305", "a", "b", "c", "d"],
            "folders": ["a/01", "a_01", "a/02", "a_02", "b/a/01", "b_a/01", "b/a_01", "b_a_01"],
            "types": ["x.jpg", "x.png", "x", "0.jpg", "0.JPG", "0.png", "0.PNG", "0"],
            "long": [f"{long}/{long}/{i}" for i in range(4)] + [f"{long}_{long}/{i}"[:250] for i in range(4)],
            "unicode": ["Größe", "Gro\u0308ße", "写真", "\u202egnp", "a b", "a'b", "a\"b", "$(x)"],
        }
        frames = [frame for split in ("train", "test")
                  for frame in json.loads((ball / f"transforms_{split}.json").read_text())["frames"]]
        angle = json.loads((ball / "transforms_train.json").read_text())["camera_angle_x"]
        for name, names in tables.items():
            folder, out = self.folder / name, self.folder / f"{name}-scene"
            for frame, view in zip(frames, names):
                picture = folder / "p" / view
                if not picture.suffix.lower() in (".png", ".jpg"):
                    picture = picture.with_name(picture.name + ".png")
                picture.parent.mkdir(parents=True, exist_ok=True)
                if not picture.exists():
                    shutil.copy(ball / f"{frame['file_path']}.png", picture)
                frame["picture"] = picture.relative_to(folder).as_posix()
            unique = {frame["picture"]: frame for frame in frames}
            (folder / "transforms.json").write_text(json.dumps({"camera_angle_x": angle, "frames": [
                {"file_path": picture, "transform_matrix": frame["transform_matrix"]}
                for picture, frame in unique.items()]}))
            result = self.run_stage("import", folder, "-o", out)
            self.assert_done(result)
            views = json.loads((out / "scene.json").read_text())["views"]
            self.assertEqual(len(views), len(unique), name)
            self.assertEqual(len({view["image"] for view in views}), len(views), name)
            self.assertEqual(len(list((out / "images").rglob("*.png"))), len(views), name)

    def test_nothing_outside_of_an_output_folder_is_touched(self):
        folders = self.chain()
        commands = self.commands(folders)
        victim, docs = self.victims / "docs" / "a", self.victims / "docs"

        def status_that_lists(role, path):
            def change(folder):
                (folder / "link").symlink_to(self.victims)
                status = json.loads((folder / "status.json").read_text())
                status[role] = [path]
                (folder / "status.json").write_text(json.dumps(status))
            return change

        def link(name, target):
            def change(folder):
                (folder / name).unlink(missing_ok=True)
                (folder / name).symlink_to(target)
            return change

        def pipe(folder):
            (folder / "log.txt").unlink()
            os.mkfifo(folder / "log.txt")

        def output_is_link(folder):
            for entry in list(folder.iterdir()):
                if entry.name in ("manifest.json", "status.json", "log.txt", ".lock"):
                    continue
                shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
                entry.symlink_to(docs if entry.is_dir() else victim)

        traps = {
            **{f"{role} {path}": status_that_lists(role, path) for role in ("scratch", "own", "caches")
               for path in ("link/docs", "link", "../victims/docs", "/tmp/../" + str(docs))},
            **{name: link(name, victim) for name in
               (".lock", "log.txt", "status.json.tmp", "manifest.json.tmp", "field.tetf.tmp", "mesh.tet.tmp",
                "scene.json.tmp", "surface.ply.tmp", "views.json.tmp", "metrics.json.tmp", "new")},
            "pipe": pipe, "outputs": output_is_link,
        }

        def cases():
            for stage in ("import", "tetrahedralize", "surface", "evaluate"):
                for name, trap in traps.items():
                    for how in ("--force", None):
                        out = self.folder / "traps" / f"{stage} {name} {how}".replace("/", "_")
                        shutil.copytree(folders[stage], out)
                        trap(out)
                        if how is None:
                            (out / "manifest.json").unlink()
                        arguments = [out if argument == folders[stage] else argument
                                     for argument in commands[stage]]
                        yield f"{stage}: {name} {how}", stage, [*arguments, *([how] if how else [])]
        self.run_cases(cases(), least=150)

    def test_damage_of_equal_size_is_noticed(self):
        folders = self.chain()
        commands = self.commands(folders)
        followers = {"import": "tetrahedralize", "tetrahedralize": "optimize", "optimize": "surface",
                     "render": "evaluate"}

        def cases():
            for stage, follower in followers.items():
                for output in self.manifest(folders[stage])["outputs"]:
                    for place in (0, 0.4, 0.99):
                        damaged = self.folder / "damaged" / f"{stage}-{output['path'].replace('/', '_')}-{place}"
                        shutil.copytree(folders[stage], damaged, copy_function=os.link)
                        file = damaged / output["path"]
                        content = bytearray(file.read_bytes())
                        content[int(place * len(content))] ^= 1
                        file.unlink()
                        file.write_bytes(content)
                        arguments = [damaged if argument == folders[stage] else argument
                                     for argument in commands[follower]]
                        arguments[arguments.index("-o") + 1] = self.fresh()
                        yield output["path"], follower, arguments

        def names_the_file(name, result):
            wanted = f"{name} is missing or was changed".encode()
            return None if result.returncode == 3 and wanted in result.stderr else "does not name the file"
        self.run_cases(cases(), names_the_file, least=60)

    def test_json_of_other_kinds_than_expected(self):
        folders = self.chain()
        commands = self.commands(folders)

        def mutations(step, folder_of_file, relative, stage, arguments, forged=True):
            value = json.loads((folder_of_file / relative).read_text())
            changes = [(path, new) for path in leaves(value) for new in VALUES]
            for number, (path, new) in enumerate(changes[::step]):
                copied = self.folder / "json" / f"{stage}-{relative}-{number}"
                shutil.copytree(folder_of_file, copied, copy_function=os.link)
                for name in (relative, "manifest.json"):
                    if (folder_of_file / name).exists():
                        (copied / name).unlink()
                        shutil.copy(folder_of_file / name, copied / name)
                content = json.dumps(replaced(value, path, new)).encode()
                if forged:
                    self.forge(copied, relative, content)
                else:
                    (copied / relative).write_bytes(content)
                yield (f"{relative} {path} = {new!r}"[:120], stage,
                       [copied if a == folder_of_file else self.folder / "out" / f"{stage}-{relative}-{number}"
                        if a == folders.get(stage) else a for a in arguments])

        def cases():
            yield from mutations(6, folders["import"], "scene.json", "tetrahedralize", commands["tetrahedralize"])
            yield from mutations(5, self.folder / "ball", "transforms_train.json", "import", commands["import"],
                                 forged=False)
            yield from mutations(4, folders["render"], "views.json", "evaluate", commands["evaluate"])
            yield from mutations(4, folders["optimize"], "world.json", "surface", commands["surface"])
            yield from mutations(7, folders["tetrahedralize"], "manifest.json", "optimize", commands["optimize"],
                                 forged=False)
            yield from mutations(7, folders["evaluate"], "status.json", "evaluate",
                                 commands["evaluate"], forged=False)
        self.run_cases(cases(), least=400)

    def test_json_that_is_nested_deeply(self):
        folders = self.chain()
        commands = self.commands(folders)
        places = {"import": (self.folder / "ball", "transforms_train.json"),
                  "tetrahedralize": (folders["import"], "scene.json"),
                  "surface": (folders["optimize"], "world.json"), "evaluate": (folders["render"], "views.json"),
                  "render": (folders["optimize"], "manifest.json")}

        def cases():
            for stage, (folder, name) in places.items():
                for depth in (101, 5000, 200000):
                    for text in ("[" * depth, "[" * depth + "]" * depth, '{"frames":' * depth + "1" + "}" * depth):
                        copied = self.folder / "deep" / f"{stage}-{depth}-{len(text)}"
                        shutil.copytree(folder, copied)
                        if name != "manifest.json" and (copied / "manifest.json").exists():
                            self.forge(copied, name, text.encode())
                        else:
                            (copied / name).write_text(text)
                        arguments = [copied if a == folder else a for a in commands[stage]]
                        arguments[arguments.index("-o") + 1] = self.fresh()
                        yield f"{name} {depth}", stage, arguments
        self.run_cases(cases(), lambda _, result: None if result.returncode == 3 else "is taken", least=45)

    def test_pipes_devices_and_folders_in_place_of_files(self):
        ball, photos = self.dataset(), self.folder / "photos"
        photos.mkdir()
        for i in range(3):
            shutil.copy(ball / "train" / f"r_{i}.png", photos)
        model = self.folder / "model"
        (model / "images").mkdir(parents=True)
        for name in ("cameras.txt", "images.txt", "points3D.txt"):
            (model / name).write_text("# empty\n")
        volume = self.folder / "volume"
        volume.mkdir()
        (volume / "v.nhdr").write_text("NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n"
                                       "data file: v.raw\n")
        (volume / "v.raw").write_bytes(bytes(8))
        (volume / "t.json").write_text('{"opacity": [[0, 0], [1, 1]], "colour": [[0, 1, 0, 0]]}')
        scene = self.folder / "scene"
        self.assert_done(self.run_stage("import", ball, "-o", scene))
        tables = (
            ("import", ball, ("transforms_train.json", "transforms_test.json", "train/r_1.png"), ("{}",)),
            ("sfm", photos, ("r_1.png",), ("{}",)),
            ("import", model, ("cameras.txt", "images.txt", "points3D.txt"), ("{}",)),
            ("import", volume, ("v.nhdr", "v.raw", "t.json"), ("{}/v.nhdr", "--transfer-function", "{}/t.json")),
            ("tetrahedralize", scene, ("manifest.json", "scene.json", "images/train/r_1.png"), ("{}",)))

        def make(kind, path):
            path.unlink()
            if kind == "pipe":
                os.mkfifo(path)
            elif kind == "folder":
                path.mkdir()
            else:
                path.symlink_to(kind)

        def cases():
            for stage, folder, files, arguments in tables:
                for file in files:
                    for kind in ("pipe", "folder", "/dev/zero", "/dev/full", "/dev/tty", "/proc/self/mem", "loop",
                                 "/nowhere", "x" * 255):
                        copied = self.folder / "odd" / f"{stage}-{file}-{kind}".replace("/", "_")[:250]
                        shutil.copytree(folder, copied)
                        make(file.split("/")[-1] if kind == "loop" else kind, copied / file)
                        words = [word.format(copied) for word in arguments]
                        yield f"{stage} {file} {kind[:20]}", stage, [*words, "-o", self.fresh()]
        def is_refused(name, result):
            may_be_missing = name in ("import transforms_test.json /nowhere", f"import transforms_test.json {'x' * 20}")
            return "is taken" if result.returncode == 0 and not may_be_missing else None
        self.run_cases(cases(), is_refused, least=110)

    def test_damaged_photos_of_every_format(self):
        if not shutil.which("heif-enc"):
            self.skipTest("heif-enc is not installed (scripts/setup.sh)")
        ball = self.dataset()
        # Without COLMAP, what can be read ends there.
        programs = self.folder / "programs"
        programs.mkdir()
        (programs / "heif-convert").symlink_to(shutil.which("heif-convert"))
        heic = self.folder / "whole.heic"
        subprocess.run(["heif-enc", ball / "train" / "r_0.png", "-o", heic], check=True, capture_output=True)
        heic, png = heic.read_bytes(), (ball / "train" / "r_2.png").read_bytes()  # no copy of the others

        def entries(*given, width=8, offset=8):
            """A TIFF file of grey pixels with these entries of its directory in place of others."""
            tags = {256: (4, 1, width), 257: (4, 1, 8), 258: (3, 1, 8), 259: (3, 1, 1), 262: (3, 1, 1),
                    273: (4, 1, offset), 277: (3, 1, 1), 278: (4, 1, 8), 279: (4, 1, 64)} | dict(given)
            return (b"II*\0" + struct.pack("<I", 72) + bytes(range(64)) + struct.pack("<H", len(tags))
                    + b"".join(struct.pack("<HHII", tag, *value) for tag, value in sorted(tags.items())))

        def tiff(*given, following=0, **fields):
            return entries(*given, **fields) + struct.pack("<I", following)

        refused = {
            **{f"HEIC cut at {share}": heic[:int(share * len(heic))] for share in (0.01, 0.1, 0.5, 0.9)},
            "HEIC of nothing": heic[:12], "HEIC and zeros": heic[:40] + bytes(1000),
            "HEIC of text": b"\0\0\0\x18ftypheic" + b"x" * 500,
            "TIFF cut": tiff()[:40], "TIFF without pixels": tiff(offset=10 ** 6), "TIFF of nothing": b"II*\0",
            "TIFF of a huge image": tiff(width=2 ** 31), "TIFF of no width": tiff(width=0),
            "TIFF bomb": tiff((257, (4, 1, 16000)), width=16000),
            "TIFF of floats": tiff((258, (3, 1, 32)), (339, (3, 1, 3))), "TIFF with sign": tiff((339, (3, 1, 2))),
            "TIFF of 9 channels": tiff((277, (3, 1, 9))), "TIFF of no compression known": tiff((259, (3, 1, 999))),
            "TIFF of huge tiles": tiff((322, (4, 1, 2 ** 30)), (323, (4, 1, 2 ** 30)), (324, (4, 1, 8)),
                                       (325, (4, 1, 64))),
            "large TIFF": b"II+\0" + b"\xff" * 100, "text": b"text", "EXR": b"\x76\x2f\x31\x01" + bytes(100),
        }
        read = {"TIFF": tiff(), "TIFF that ends in itself": tiff(following=72), "PNG": png, "HEIC": heic,
                "TIFF turned": tiff((274, (3, 1, 6))), "TIFF with EXIF of itself": tiff((34665, (4, 1, 72)))}
        flipped = {}
        for name, content in (("HEIC", heic), ("TIFF", tiff())):
            for place in range(4, min(len(content), 500), 9):
                changed = bytearray(content)
                changed[place] ^= 0xFF
                flipped[f"{name} changed at {place}"] = bytes(changed)

        def cases():
            for name, content in (refused | read | flipped).items():
                for extension in ("heic", "tif", "jpg") if name in refused or name in read else ("heic",):
                    photos = self.folder / "odd photos" / f"{name} {extension}"
                    photos.mkdir(parents=True)
                    for i in range(2):
                        shutil.copy(ball / "train" / f"r_{i}.png", photos)
                    (photos / f"x.{extension}").write_bytes(content)
                    yield name, "sfm", [photos, "-o", self.fresh(), "--max-unreadable", "0"], {
                        "env": {**os.environ, "PATH": str(programs)}}

        def ends_rightly(name, result):
            if name in flipped:
                return None
            return None if result.returncode == (3 if name in refused else 4) else "is taken for something else"
        self.run_cases(cases(), ends_rightly, least=100)

    def test_names_that_are_no_text(self):
        ball = self.dataset()
        names = (b"Gr\xf6\xdfe", b"a\nb", b"\x1b[2J", b"\xff" * 200, b"\xc0\xaf", b"x" * 255, b"\xe2\x80\xae", b"-", b"'")

        def cases():
            for name in names:
                root = os.fsencode(self.folder)
                photos = os.path.join(root, b"photos " + name[:200])
                os.mkdir(photos)
                for i in range(3):
                    shutil.copy(ball / "train" / f"r_{i}.png",
                                os.path.join(photos, name[:200] + b"%d.png" % i))
                shown = repr(name[:20])
                environment = {"env": {**os.environ, "PATH": "/nowhere"}}  # before COLMAP is looked for
                yield f"photos {shown}", "sfm", [photos, "-o", self.fresh()], environment
                folder = os.path.join(root, b"data " + name[:200])
                shutil.copytree(ball, os.fsdecode(folder))
                yield f"data set {shown}", "import", [folder, "-o", self.fresh()]
                yield f"output {shown}", "import", [ball, "-o", os.path.join(root, b"out " + name)]
                yield f"stage {shown}", "tetrahedralize", [folder, "-o", self.fresh()]
        self.run_cases(cases(), least=36)

    def test_paths_that_no_file_system_has(self):
        ball = self.dataset()
        paths = ("", ".", "/", "//", "..", "x" * 300, "x/" * 3000, "/dev/null", "/dev/null/x", "/proc/self/x",
                 str(self.folder / "loop" / "x"), "\x01", "~", "-")
        (self.folder / "loop").symlink_to("loop")

        def cases():
            for stage in ("sfm", "import", "tetrahedralize", "optimize", "render", "surface", "evaluate", "chart"):
                for path in paths:
                    options = {"cwd": ball}
                    yield f"{stage} input {path[:20]!r}", stage, [path, "-o", self.fresh()], options
                    yield f"{stage} output {path[:20]!r}", stage, [ball, "-o", path], options
        self.run_cases(cases(), least=200)

    def test_values_of_every_option(self):
        missing = self.folder / "missing"

        def cases():
            for stage in ("sfm", "import", "tetrahedralize", "optimize", "render", "surface", "evaluate", "chart",
                          "bench"):
                text = subprocess.run([BIN / f"tetrec-{stage}", "--help"], capture_output=True, text=True,
                                      check=True).stdout
                self.assertLessEqual(max(map(len, text.splitlines())), 100, stage)
                for option in sorted(set(re.findall(r"^  (?:-o,)?(--[a-z0-9-]+)", text, re.M))):
                    if option in ("--help", "--version"):
                        continue
                    # Every value for some options, so that each is tried often, and in little time.
                    start = sum(option.encode()) % 2
                    for word in WORDS[start::2]:
                        # A benchmark with valid values would run.
                        end = ["--no-such-option"] if stage == "bench" else [missing]
                        yield (f"{stage} {option} {word!r}", stage,
                               ["-o", self.fresh(), *([f"{option}={word}"] if word else [option, ""]), *end])
        # Valid values meet a folder that is missing. Which are valid, the next test asks.
        self.run_cases(cases(), lambda _, result: None if result.returncode in (2, 3) else "is no plain refusal",
                       least=400)

    def test_numbers_of_every_kind_of_option(self):
        missing = self.folder / "missing"
        refused = (
            ("optimize", "--iterations", "99999999999999999999"), ("optimize", "--max-density", "1e300"),
            ("optimize", "--max-density", "nan"), ("optimize", "--rays", "-1"), ("optimize", "--rounds", "nan"),
            ("optimize", "--budget-tets", "-1"), ("optimize", "--budget-mb", "99999999999"),
            ("optimize", "--budget", "full"),
            ("optimize", "--time-limit", "5min"), ("optimize", "--color-rate", "0"), ("optimize", "--seed", "-1"),
            ("bench", "--stop", "nan"), ("bench", "--stop", "0.6"), ("bench", "--size", "0"), ("bench", "--tets", "-1"),
            ("sfm", "--max-size", "99999999999999999999"), ("sfm", "--holdout", "-1"), ("sfm", "--retries", "nan"),
            ("sfm", "--bounds", "0,0,0,1,1,0"), ("sfm", "--max-unreadable", "1"), ("surface", "--extent", "0,0,0,1,1,1"),
            ("sfm", "--frames", "1"), ("render", "--path", "spiral"), ("render", "--fps", "nan"),
            ("import", "--downscale", "inf"), ("import", "--bounds", "0,0,0,0,0,nan"), ("import", "--spacing", "1x1"),
            ("render", "--samples", "0"), ("render", "--samples", "1e9"), ("render", "--device", ""),
            ("surface", "--smoothing", "-1"), ("surface", "--isovalue", "inf"), ("surface", "--margin", "nan"),
            ("surface", "--isovalue", "1e-50"), ("evaluate", "--seed", "3"), ("evaluate", "--surface-samples", "5000"),
            ("surface", "--texture", "-5"), ("surface", "--smooth-normals", "101"), ("surface", "--align-rounds", "101"),
            ("evaluate", "--threshold", "-inf"), ("tetrahedralize", "--resolution", "513"))

        def cases():
            for stage, option, word in refused:
                yield (f"{stage} {option} {word}", stage,
                       [*([] if stage == "bench" else [missing]), "-o", self.fresh(), f"{option}={word}"])

        def names_the_option(name, result):
            _, option, *_ = name.split(" ")
            right = result.returncode == 2 and option.encode() in result.stderr
            return None if right else "is not refused by name"
        self.run_cases(cases(), names_the_option, least=20)
        for stage in ("sfm", "chart", "bench"):
            self.assertIn(f"tetrec-{stage} ", self.run_stage(stage, "--version").stdout)
        result = self.run_stage("optimize", missing, "-o", self.fresh(), "--iteration", 3)
        self.assert_fails(result, 2, "did you mean --iterations?")

    def test_charts_of_hostile_names_and_numbers(self):
        head = "iteration,seconds,rays,loss,train_psnr,heldout_psnr,tets,vertices,phase\n"
        titles = ("'", "''", "'a'", "\"", "`touch victims/x`", "$(touch victims/x)", "\\", "\\n", "@x", "%s", "=1+1",
                  "'; !touch victims/x #", "x" * 5000)
        numbers = ("5e-324", "1e-320", "1e308", "1e-300", "nan", "inf", "-1", "0")

        def run_folder(name, seconds):
            folder = self.folder / "charts" / name
            folder.mkdir(parents=True)
            rows = "".join(f"{i},{value},10,0.1,20,{20 + i},10,10,optimise\n" for i, value in enumerate(seconds))
            (folder / "metrics.csv").write_text(head + rows)
            return folder

        def cases():
            plain = run_folder("plain", ("1", "2"))
            options = {"cwd": self.folder}
            for i, title in enumerate(titles):
                out = self.folder / f"chart {i}"
                yield f"title {title[:20]}", "chart", [plain, "-o", out, f"--title={title}"], options
            for i, number in enumerate(numbers):
                folder = run_folder(number, ("1", number))
                yield f"seconds {number}", "chart", [folder, "-o", self.folder / f"seconds {i}"], options
            for i, name in enumerate(("=1+1", "@x", "'", "`x`", "+1", "-1")):
                folder = run_folder("named/" + name, ("1", "2"))
                yield f"run {name}", "chart", [folder, "-o", self.folder / f"run {i}"], options
            yield "here", "chart", [plain, "-o", "."], {"cwd": run_folder("here", ("1",))}
        if shutil.which("gnuplot") is None:
            self.skipTest("gnuplot, which draws the charts, is not installed")
        self.run_cases(cases(), least=25)
        for name in ("run 0", "run 1", "run 4", "run 5"):
            self.assertEqual((self.folder / name / "chart.csv").read_text().splitlines()[1][0], "'")

    def test_limits_of_the_machine(self):
        ball = self.dataset()
        limits = [*(f"--fsize={size}" for size in (0, 1, 1000, 5000)), *(f"--nofile={count}" for count in (8, 12))]

        def cases():
            for limit in limits:
                yield f"limit {limit}", "import", [ball, "-o", self.fresh()], {"through": ("prlimit", limit)}
        self.run_cases(cases(), least=6)

    def test_too_little_memory_for_a_driver_is_said_before_it_crashes(self):
        tetrahedra = self.tiny_tetrahedra(train=4, validation=0, test=1)

        def cases():
            for size in range(320, 1000, 80):  # [MiB]
                yield f"{size} MiB", "optimize", [tetrahedra, "-o", self.fresh(), "--device", "cpu"], {
                    "through": ("prlimit", f"--as={size << 20}")}
        self.run_cases(cases(), lambda _, result: None if result.returncode == 4 else "is taken", least=8)

    def test_no_threads_and_folders_of_others(self):
        ball = self.dataset()
        closed, out = self.folder / "closed", self.folder / "out"
        shutil.copytree(ball / "train", closed)
        out.mkdir(mode=0o777)
        for folder in (self.folder, out):
            folder.chmod(0o777)
        closed.chmod(0)

        def as_nobody(processes=None):
            def change():
                if os.geteuid() == 0:
                    os.setresgid(65534, 65534, 65534)
                    os.setresuid(65534, 65534, 65534)
                if processes is not None:
                    resource.setrlimit(resource.RLIMIT_NPROC, (processes, processes))
            return {"preexec_fn": change}
        if subprocess.run(["test", "-x", BIN / "tetrec-import"], check=False, **as_nobody()).returncode:
            self.skipTest("another user cannot run the programs in this folder")
        self.run_cases([("no threads", "import", [ball, "-o", out / "1_scene"], as_nobody(1))],
                       lambda _, result: "fails" if result.returncode else None)
        self.run_cases([(stage, stage, [closed, "-o", out / stage], as_nobody()) for stage in ("sfm", "import")],
                       lambda _, result: None if result.returncode == 4 else f"ends with {result.returncode}")

    def test_closed_streams_receive_nothing(self):
        ball = self.dataset()
        for closed in ((0,), (1,), (2,), (0, 1, 2)):
            out = self.folder / f"closed {closed}"

            def close_streams(streams=closed):
                for stream in streams:
                    os.close(stream)
            result = subprocess.run([BIN / "tetrec-import", ball, "-o", out], preexec_fn=close_streams, check=False,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=CASE_LIMIT)
            self.assertEqual(result.returncode, 0)
            self.assertRegex((out / ".lock").read_text(), r"\A[0-9]+\n\Z")
            self.assertEqual(self.status(out), "done")

    def test_make_takes_names_as_they_are(self):
        make = pathlib.Path(__file__).resolve().parents[2] / "pipeline"
        for name in ("$(shell touch victims/x)", "${HOME}", "$$x", "`touch victims/x`", "$(touch victims/x)", "a b'\""):
            for variable in ("INPUT", "RUN"):
                words = {"INPUT": "nowhere", "RUN": "nowhere", variable: name}
                result = subprocess.run(
                    ["make", "-C", make, "check", *(f"{key}={value}" for key, value in words.items())],
                    cwd=self.folder, env={**os.environ, "PWD": str(self.folder)}, capture_output=True, text=True,
                    check=False)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(f"INPUT is '{self.folder}/{words['INPUT']}', which does not exist", result.stderr)
        self.assertEqual(len(list(self.victims.rglob("*"))), 2)
        folder = self.folder / "x$(shell touch y)z"
        folder.mkdir()
        result = subprocess.run(["make", "--no-print-directory", "-C", make, "check", "INPUT=nowhere", "RUN=x"],
                                cwd=folder, env={**os.environ, "PWD": str(folder)}, capture_output=True, text=True,
                                check=False)
        self.assertIn(f"INPUT is '{folder}/nowhere'", result.stderr)
        self.assertFalse((make / "y").exists())
        # Without -C the shell's PWD may be out of date.
        result = subprocess.run(["make", "-f", make / "Makefile", "check", "INPUT=nowhere", "RUN=x"],
                                cwd=self.victims, env={**os.environ, "PWD": "/elsewhere"}, capture_output=True,
                                text=True, check=False)
        self.assertIn(f"INPUT is '{self.victims}/nowhere'", result.stderr)

    def test_a_data_set_for_the_wrong_stage_is_named_at_once(self):
        ball = self.dataset()
        result = self.run_stage("sfm", ball, "-o", self.folder / "out")
        self.assert_fails(result, 3, "tetrec-import", "nerf-synthetic")
        self.assertFalse((self.folder / "out").exists())
        scene = self.folder / "scene"
        self.assert_done(self.run_stage("import", ball, "-o", scene))
        result = self.run_stage("tetrahedralize", scene / "scene.json", "-o", self.folder / "out")
        self.assert_fails(result, 3, f"is a file; give the folder that it is in: {scene}")


if __name__ == "__main__":
    unittest.main()
