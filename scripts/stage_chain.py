"""What the measuring scripts share: running stages, reading what they wrote, tables."""
import csv
import json
import pathlib
import shlex
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent


class StageFailed(Exception):
    pass


class Chain:
    """Runs stages one after another and keeps their results in one folder."""

    def __init__(self, programs, scene, folder, log):
        self.programs, self.scene, self.folder, self.log = programs, scene, folder, log
        self.commands = []

    def run(self, stage, *words, output):
        command = [str(self.programs / f"tetrec-{stage}"), *map(str, words), "-o", str(output)]
        self.commands.append(shlex.join(command))
        print(f"  {stage} ...", flush=True)
        start = time.monotonic()
        output.parent.mkdir(parents=True, exist_ok=True)
        result = subprocess.run(command, stdout=self.log, stderr=subprocess.PIPE, text=True, check=False)
        self.log.write(result.stderr)
        if result.returncode:
            last = (result.stderr.strip().splitlines() or ["it said nothing"])[-1]
            raise StageFailed(f"tetrec-{stage} ended with {result.returncode}: {last}")
        print(f"  {stage}: {time.monotonic() - start:.0f} s", flush=True)
        return output

    def path(self, name):
        return self.folder / name


def watched_curve(path):
    """The best and the last PSNR of the watched views in metrics.csv [dB]; (None, None) without any."""
    with open(path, encoding="utf-8", newline="") as file:
        values = [float(row["heldout_psnr"]) for row in csv.DictReader(file) if row.get("heldout_psnr")]
    return (max(values), values[-1]) if values else (None, None)


def numbers_of(chain):
    """The numbers of one finished scene, from what its stages wrote."""
    metrics = json.loads((chain.path("6_report") / "metrics.json").read_text())
    optimize = json.loads((chain.path("3_field") / "manifest.json").read_text())
    best, end = watched_curve(chain.path("3_field") / "metrics.csv")
    # A view that is identical to its truth has no PSNR.
    views = [view for view in metrics["views"] if view["psnr"] is not None]
    worst = min(views, key=lambda view: view["psnr"], default={"psnr": None, "name": None})
    truth = (metrics["surface"] or {}).get("ground_truth") or {}
    depth = metrics.get("depth") or {}
    return {"psnr": metrics["psnr"], "worst_psnr": worst["psnr"], "worst_view": worst["name"],
            "watched_best": best, "watched_end": end,
            "depth_error_percent": depth.get("median_error_percent_of_diagonal"),
            "f_score": truth.get("f_score"), "f_score_at_percent": truth.get("threshold_percent_of_diagonal"),
            "ssim": metrics["ssim"], "tets": metrics["tets"],
            "memory_mib": optimize["peak_rss_bytes"] / 2**20, "seconds": metrics["seconds"]["optimize"],
            "steps": optimize["counts"].get("iterations"), "held_out_views": len(metrics["views"]),
            "resolution": metrics["resolution"], "background": metrics["background"],
            "rays_per_pixel": metrics["rays_per_pixel"], "split": metrics["split"],
            "device": metrics["device"], "warnings": metrics["warnings"]}


def cell(value, form):
    return "–" if value is None else form.format(value)


def table(headings, rows):
    lines = ["| " + " | ".join(headings) + " |", "|" + "---|" * len(headings)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def git_revision():
    result = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True,
                            text=True, check=False)
    return result.stdout.strip() or "unknown"
