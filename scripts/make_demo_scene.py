#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the bundled demo scene: photos, a NeRF-synthetic set of the subject, exact cameras and the true surface.

Everything comes from scripts/blender_demo, rendered with Blender's Cycles on the CPU (Debian 12: Blender 3.4).
Needs nothing but Python and Blender. The same options give the same pictures.
"""
import argparse
import shutil
import subprocess
import sys
from pathlib import Path

PARTS = ("photos", "nerf", "mesh")
EXIT_BUG, EXIT_USAGE, EXIT_ENVIRONMENT, EXIT_INTERRUPTED = 1, 2, 4, 130


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="folder to write; existing files are replaced")
    parser.add_argument("--only", choices=PARTS, action="append", help="make this part alone (may be repeated)")
    parser.add_argument("--blender", default="blender", help="the Blender 3.x executable")
    parser.add_argument("--seed", type=int, default=1, help="seed of the camera walk and of the light samples")
    parser.add_argument("--threads", type=int, default=0, help="render threads, 0: all cores")
    parser.add_argument("--photos", type=int, default=40, help="number of photos on the one walk around the table")
    parser.add_argument("--width", type=int, default=640, help="photo width [pixels]; the height is 3/4 of it")
    parser.add_argument("--samples", type=int, default=32, help="light paths per photo pixel, the light smoothed after")
    parser.add_argument("--quality", type=int, default=88, help="JPEG quality")
    parser.add_argument("--first", type=int, default=0, help="first photo to render, to look at a few")
    parser.add_argument("--stride", type=int, default=1, help="render every n-th photo, to look at a few")
    parser.add_argument("--nerf-size", type=int, default=128, help="NeRF picture width and height [pixels]")
    parser.add_argument("--nerf-samples", type=int, default=256, help="light paths per NeRF pixel")
    parser.add_argument("--nerf-views", type=int, nargs=3, default=(24, 6, 8), metavar=("TRAIN", "VAL", "TEST"),
                        help="pictures per split")
    options = parser.parse_args()

    def refuse(message):
        sys.exit(fail(EXIT_USAGE, message))

    low = {"photos": 3, "width": 16, "samples": 1, "quality": 1, "first": 0, "stride": 1, "nerf_size": 8,
           "nerf_samples": 1}
    for name, least in low.items():
        if getattr(options, name) < least:
            refuse(f"--{name.replace('_', '-')} is {getattr(options, name)}, must be at least {least}")
    if min(options.nerf_views) < 1:
        refuse("--nerf-views needs at least 1 picture per split")
    if options.quality > 100:
        refuse(f"--quality is {options.quality}, must be at most 100")
    if options.width % 4:
        refuse(f"--width is {options.width}, must be a multiple of 4")
    return options


def fail(code, message):
    print(f"make_demo_scene: error: {message}", file=sys.stderr)
    return code


def main():
    options = parse_options()
    blender = shutil.which(options.blender)
    if not blender:
        return fail(EXIT_ENVIRONMENT, f"'{options.blender}' not found; install it "
                    "(apt-get install --no-install-recommends blender) or name it with --blender")
    try:
        options.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        return fail(EXIT_ENVIRONMENT, f"cannot make the folder '{options.out}': {error.strerror}; choose another --out")
    command = [blender, "--background", "--factory-startup", "--python-exit-code", str(EXIT_BUG)]
    if options.threads:
        command += ["--threads", str(options.threads)]
    command += ["--python", str(Path(__file__).resolve().parent / "blender_demo" / "main.py"), "--",
                "--out", str(options.out.resolve()), "--parts", *(options.only or PARTS)]
    for name in ("seed", "photos", "width", "samples", "quality", "first", "stride", "nerf_size", "nerf_samples"):
        command += [f"--{name.replace('_', '-')}", str(getattr(options, name))]
    command += ["--nerf-views", *map(str, options.nerf_views)]

    # Blender prints several lines per picture; only ours, marked, go to the user, the rest is kept for a failure.
    chatter = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          errors="replace") as process:
        for line in process.stdout:
            if line.startswith("demo: "):
                print(line[6:], end="", flush=True)
            else:
                chatter = (chatter + [line.strip()])[-40:]
    if process.returncode:
        told = [line for line in chatter if "Error" in line] or chatter or ["no output"]
        return fail(EXIT_BUG, f"'{blender}' ended with {process.returncode}: {told[-1]}")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
