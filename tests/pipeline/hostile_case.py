"""Base of the tests of hostile input: tables of cases, which run in parallel and must all end well, and
what they start from."""
import concurrent.futures
import copy
import hashlib
import itertools
import json
import os
import re
import subprocess

from stage_case import BIN, StageCase
from tiny_dataset import write_tiny_dataset

# Longest that any case may take, on a busy machine [s]: less than for ever.
CASE_LIMIT = 60

# What takes the place of a value in a JSON file.
VALUES = (None, True, -1, 0, 1e308, 2**63, "", "x\x1b[2J\ny", "../../victims/a", [], {}, [[[[]]]], [None] * 3)


def leaves(value, path=()):
    """The paths of all values in a JSON value; of lists only the first two items."""
    yield path
    items = value.items() if isinstance(value, dict) else (
        list(enumerate(value))[:2] if isinstance(value, list) else ())
    for key, item in items:
        yield from leaves(item, path + (key,))


def replaced(value, path, new):
    """A copy of the JSON value with another value at `path`."""
    if not path:
        return new
    result = copy.deepcopy(value)
    at = result
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = new
    return result


class HostileCase(StageCase):
    """A test case of such tables. Nothing outside of output folders may be touched."""

    def setUp(self):
        super().setUp()
        self.numbers = itertools.count()
        self.victims = self.folder / "victims"
        (self.victims / "docs").mkdir(parents=True)
        (self.victims / "docs" / "a").write_text("mine")

    def fresh(self):
        """The path of an output folder that no other case has."""
        return self.folder / f"out-{next(self.numbers)}"

    # One case.

    def run_case(self, stage, arguments, through=(), **options):
        """Runs a stage (by the program `through`, if any) and returns what is wrong with how it ended, or None."""
        try:
            result = subprocess.run(
                [*through, BIN / f"tetrec-{stage}", *arguments], stdin=subprocess.DEVNULL, capture_output=True,
                timeout=CASE_LIMIT, check=False, **options)
        except subprocess.TimeoutExpired:
            return "did not end", b""
        lines = result.stderr.split(b"\n")[:-1]
        errors = [line for line in lines if line.startswith(f"tetrec-{stage}: ".encode())]
        if result.returncode not in (0, 2, 3, 4):
            return f"ended with {result.returncode}", result.stderr
        if result.returncode and (len(errors) != 1 or errors[0] != lines[-1] or b"filesystem error" in errors[0]):
            return "does not end with one clear line", result.stderr
        if re.search(rb"[\x00-\x09\x0b-\x1f\x7f]", result.stderr):
            return "prints control characters", result.stderr
        return None, result

    def run_cases(self, cases, expected=None, least=1):
        """Runs (name, stage, arguments[, options]) in parallel, and expects that all end well; `expected` gets
        the result too, and returns what is wrong with it, or None. Returns the number of cases."""
        def run(case):
            name, stage, arguments, *options = case
            wrong, result = self.run_case(stage, arguments, **(options[0] if options else {}))
            if wrong is None and expected is not None:
                wrong = expected(name, result)
                result = result.stderr
            return None if wrong is None else f"{name}: {wrong}: {result[-600:]!r}"

        cases = list(cases)
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            failures = [failure for failure in pool.map(run, cases) if failure]
        self.assertEqual(failures, [], f"{len(failures)} of {len(cases)} cases")
        self.assertGreaterEqual(len(cases), least)
        self.assertEqual((self.victims / "docs" / "a").read_text(), "mine")
        self.assertEqual(len(list(self.victims.rglob("*"))), 2)

    # What the cases start from.

    def dataset(self, name="ball"):
        folder = self.folder / name
        write_tiny_dataset(folder, train=6, validation=0, test=2)
        (folder / "transforms_val.json").unlink()
        return folder

    def chain(self):
        """A finished run of all stages; its folders by the name of the stage."""
        run = self.folder / "run"
        folders = {"import": run / "1_scene", "tetrahedralize": run / "2_tetrahedra", "optimize": run / "3_field",
                   "render": run / "4_views", "surface": run / "5_surface", "evaluate": run / "6_report"}
        self.assert_done(self.run_stage("import", self.dataset(), "-o", folders["import"]))
        for stage, arguments in self.commands(folders).items():
            if stage != "import":
                self.assert_done(self.run_stage(stage, *arguments))
        return folders

    def commands(self, folders):
        """The quickest command of each stage."""
        return {
            "import": (self.folder / "ball", "-o", folders["import"]),
            "tetrahedralize": (folders["import"], "-o", folders["tetrahedralize"], "--resolution", "6",
                               "--outer-points", "20"),
            "optimize": (folders["tetrahedralize"], "-o", folders["optimize"], "--time-limit", "0",
                         "--iterations", "2", "--rays", "64", "--renderer", "reference", "--watched-views", "1"),
            "render": (folders["optimize"], "-o", folders["render"], "--renderer", "reference", "--samples", "1"),
            "surface": (folders["optimize"], "-o", folders["surface"], "--isovalue", "0.5"),
            "evaluate": (folders["render"], "-o", folders["evaluate"]),
        }

    def forge(self, folder, relative, content):
        """Replaces or adds an output of a stage, its record in the manifest, and that of its result in the
        manifests of the stages after it."""
        record = {"path": relative, "bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
        manifest = json.loads((folder / "manifest.json").read_text())
        manifest["outputs"] = [output for output in manifest["outputs"] if output["path"] != relative] + [record]
        self.replace(folder / relative, content)
        self.replace(folder / "manifest.json", json.dumps(manifest).encode())
        for later in folder.parent.glob("*/manifest.json"):
            made = json.loads(later.read_text())
            for made_from in made["inputs"]:
                if made_from.get("stage") == manifest["stage"]:
                    made_from["sha256"] = self.hash_of_result(manifest)
                    self.replace(later, json.dumps(made).encode())

    @staticmethod
    def hash_of_result(manifest):
        """HashOfResult of src/core/stage_input.h."""
        sources = [item["sha256"] for item in manifest["inputs"] if item["kind"] == "stage"]
        hashed = [manifest["outputs"], sources] if sources else manifest["outputs"]
        text = json.dumps(hashed, separators=(",", ":"), sort_keys=True, ensure_ascii=False)
        return hashlib.sha256(text.encode()).hexdigest()

    @staticmethod
    def replace(path, content):
        """Writes a new file, so that other hard links to the old one keep what they are."""
        path.unlink(missing_ok=True)
        path.write_bytes(content)
