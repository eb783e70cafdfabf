"""Damaged files of a run, whose hashes in the manifests fit, so that the programs that read them are reached:
each ends with one clear line that names the file and a remedy, or does without the file and says so."""
import hashlib
import json
import os
import shutil
import unittest

from hostile_case import VALUES, HostileCase, leaves, replaced

# Which programs read a file, and which of VALUES in which of its places are tried.
READERS = (
    ("3_field", "exposure.json", ("surface", "evaluate"), 61),
    ("3_field", "cameras.json", ("surface", "evaluate"), 83),
    ("3_field", "left_out.json", ("surface",), 47),
    ("3_field", "growth.json", ("evaluate", "chart"), 53),
    ("3_field", "metrics.csv", ("evaluate", "chart"), None),
    ("3_field", "world.json", ("surface",), None),
    ("4_views", "views.json", ("evaluate",), None),
)

# What stands in a cell of metrics.csv.
CELLS = ("", "nan", "-1", "1e999", "1e308", "99999999999999999999", "x\x1b[2J", "\"", "1,1")


class DamagedRunTest(HostileCase):

    def finished_run(self):
        """The folder of a finished run whose optimiser estimated exposures and cameras, and left out a photo."""
        folders = self.chain()
        field = folders["optimize"]
        views = json.loads((folders["import"] / "scene.json").read_text())["views"]
        estimates = {"exposure.json": {"gain": [1, 1, 1], "offset": [0, 0, 0]},
                     "cameras.json": {"rotation_deg": 0, "move": 0, "shift_px": 0}}
        for file, values in estimates.items():
            content = {"schema": 1, "views": [
                {"name": view["name"], "cam_from_world": view["cam_from_world"], **values} for view in views]}
            self.forge(field, file, json.dumps(content).encode())
        left_out = {"schema": 1, "views": [{"name": views[0]["name"]}]}
        self.forge(field, "left_out.json", json.dumps(left_out).encode())
        return field.parent

    def copy_of(self, run):
        """A copy of a run whose files are the same on disk, except those that are locked."""
        copied = self.fresh()
        shutil.copytree(run, copied, copy_function=os.link, ignore=shutil.ignore_patterns(".lock"))
        return copied

    @staticmethod
    def command(stage, run):
        return stage.split(" ")[0], {
            "surface": (run / "3_field", "-o", run / "surface", "--isovalue", "0.5", "--texture", "64"),
            "evaluate": (run / "4_views", "-o", run / "report"),
            "evaluate with surface": (run / "4_views", run / "5_surface", "-o", run / "report"),
            "chart": (run / "3_field", "-o", run / "chart"),
            "view": (run,),
        }[stage]

    @staticmethod
    def says(name, result, *parts):
        """What is wrong with a line that should contain each of `parts`, or None."""
        missing = [part for part in parts if part.encode() not in result.stderr]
        return f"does not say {missing}" if missing else None

    def test_files_that_are_cut_missing_or_something_else(self):
        run = self.finished_run()
        self.run_cases(((stage, *self.command(stage, self.copy_of(run))) for stage in ("surface", "evaluate")),
                       lambda _, result: "fails" if result.returncode else None)
        forged = {
            "empty": lambda content: b"", "cut": lambda content: content[:len(content) // 2].rpartition(b"\n")[0],
            "no text": lambda content: b"\xff\xfe\0" + content, "NaN": lambda content: b'{"schema": NaN}\n',
            "huge": lambda content: b'{"schema": 1e999}\n', "of a later version": lambda content: b'{"schema": 2}\n'}

        def pipe(path):
            path.unlink()
            os.mkfifo(path)

        def folder(path):
            path.unlink()
            path.mkdir()

        def link_to_nothing(path):
            path.unlink()
            path.symlink_to("/nowhere")

        gone = {"missing": lambda path: path.unlink(), "pipe": pipe, "folder": folder, "link": link_to_nothing}

        def cases():
            for stage_folder, file, stages, _ in READERS:
                for stage in stages:
                    for name, change in forged.items():
                        copied = self.copy_of(run)
                        self.forge(copied / stage_folder, file, change((run / stage_folder / file).read_bytes()))
                        yield f"{file} {name}", *self.command(stage, copied)
                for name, change in gone.items():
                    copied = self.copy_of(run)
                    change(copied / stage_folder / file)
                    yield f"{file} {name}", *self.command(stages[0], copied)
            for name, change in forged.items():
                copied = self.copy_of(run)
                self.replace(copied / "3_field" / "exposure.json", change(b""))
                yield f"exposure.json {name}", *self.command("view", copied)

        def is_named(name, result):
            file = name.split(" ")[0]
            # The report does without curves, and without the stages that a damaged folder hides.
            may_be_done_without = b"warning" in result.stderr and b"/report.html" in result.stderr
            if result.returncode not in (3, 0 if may_be_done_without else 3):
                return "is taken"
            return self.says(name, result, file, "; run tetrec-")
        self.run_cases(cases(), is_named, least=60)

    def test_values_of_other_kinds(self):
        run = self.finished_run()

        def cases():
            for folder, file, stages, step in READERS:
                if step is None:
                    continue
                value = json.loads((run / folder / file).read_text())
                for start, stage in enumerate(stages):
                    for path, new in [(path, new) for path in leaves(value) for new in VALUES][start::step]:
                        copied = self.copy_of(run)
                        self.forge(copied / folder, file, json.dumps(replaced(value, path, new)).encode())
                        yield f"{file} {path} = {new!r}", *self.command(stage, copied)
            # What manifests say beside their outputs, whose hashes must fit.
            for folder, field, stage in (("1_scene", ("inputs", 0, "path"), "evaluate"),
                                         ("5_surface", ("notes",), "evaluate with surface"),
                                         ("5_surface", ("notes", "coordinates"), "evaluate with surface"),
                                         ("3_field", ("counts", "watched_views"), "chart"),
                                         ("3_field", ("previous",), "chart")):
                for new in VALUES[::6]:
                    copied = self.copy_of(run)
                    value = json.loads((run / folder / "manifest.json").read_text())
                    self.replace(copied / folder / "manifest.json", json.dumps(replaced(value, field, new)).encode())
                    yield f"manifest.json {field} = {new!r}", *self.command(stage, copied)
            head, *rows = (run / "3_field" / "metrics.csv").read_text().splitlines()
            for column in range(head.count(",") + 1):
                copied = self.copy_of(run)
                cells = rows[-1].split(",")
                cells[column] = CELLS[column % len(CELLS)]
                self.forge(copied / "3_field", "metrics.csv", "\n".join([head, *rows, ",".join(cells), ""]).encode())
                yield f"metrics.csv {column} = {cells[column]!r}", *self.command("chart", copied)

        def is_named(name, result):
            if result.returncode == 0 or name.startswith("manifest.json"):
                return None
            return self.says(name, result, name.split(" ")[0], "; run tetrec-")
        self.run_cases(cases(), is_named, least=40)

    def stopped_fit(self):
        """The folder of an optimisation that was killed after a checkpoint, and the command for a folder."""
        tetrahedra = self.tiny_tetrahedra(train=6, validation=0, test=1)

        def command(out):
            return "optimize", (tetrahedra, "-o", out, "--time-limit", "0", "--iterations", "100", "--rays", "64",
                                "--renderer", "reference", "--checkpoint-interval", "0")
        stopped = self.fresh()
        stage, arguments = command(stopped)
        process = self.start(stage, *arguments)
        self.wait_for((stopped / "checkpoint.bin").exists, process, "the first checkpoint")
        process.kill()
        process.communicate()
        return stopped, command

    def test_damaged_checkpoints(self):
        stopped, command = self.stopped_fit()
        whole = (stopped / "checkpoint.bin").read_bytes()
        body = whole[:-64]

        def changed(content, place, new):
            return content[:place] + new + content[place + len(new):]

        def with_checksum(content):
            return content + hashlib.sha256(content).hexdigest().encode()

        size = len(whole)
        damaged = {
            **{f"bit {bit}": changed(whole, bit // 8, bytes([whole[bit // 8] ^ 1 << bit % 8]))
               for bit in range(5, 8 * size, 8 * size // 12)},
            **{f"cut at {end}": whole[:end] for end in (0, 7, 100, size // 2, size - 65, size - 1)},
            "longer": whole + b"0", "zeros": bytes(size), "without a checksum": body,
            "of another version": with_checksum(changed(body, 7, b"A")),
        }
        forged = {  # of the magic, iteration, seconds, rays and pace; 64 is the number of rounds
            "no time": with_checksum(changed(body, 16, b"\xff" * 8)),
            "no rays per step": with_checksum(changed(body, 32, bytes(8))),
            "of another device": with_checksum(changed(body, 32, (65536).to_bytes(8, "little"))),
            "too many judging views": with_checksum(changed(body, 80, b"\xff" * 8)),
            **{f"no number at {place}": with_checksum(changed(body, place, b"\xff" * 4))
               for place in (size // 2 // 4 * 4, size * 3 // 4 // 4 * 4)},
        }

        def cases():
            for name, content in (damaged | forged | {"whole": whole}).items():
                copied = self.copy_of(stopped)
                self.replace(copied / "checkpoint.bin", content)
                yield name, *command(copied)
                if name == "zeros":
                    fresh = self.copy_of(stopped)
                    self.replace(fresh / "checkpoint.bin", content)
                    stage, arguments = command(fresh)
                    yield "forced", stage, [*arguments, "--force"]

        def is_refused(name, result):
            if name in ("whole", "forced"):
                if result.returncode:
                    return "fails"
                return self.says(name, result, *(["continues from"] if name == "whole" else []))
            if result.returncode != 3:
                return "is taken"
            if name == "of another device":
                return self.says(name, result, "checkpoint.bin", "65536 rays", "not 4096", "force a fresh run")
            return self.says(name, result, "checkpoint.bin", "force a fresh run" if name in damaged else "")
        self.run_cases(cases(), is_refused, least=20)


if __name__ == "__main__":
    unittest.main()
