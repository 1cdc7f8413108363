#!/usr/bin/env python3
"""Times measurements to a relative error, by photon maps and by path tracing, a daylight matrix, and renders and rays
from Python: bench/results/measure.md.

usage: tables_measure.py [PROGRAM]      scenes of ../shared are left out where there are none
"""
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time

from figures import processor_seconds

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/bin/glowworm"
SHARED = ROOT / "../shared/scenes"
NOISE = "2%"
LIMIT = "5m"  # for one measurement

# Name, file, and a grid of about 1,000 sensors at the height of a table.
SCENES = [
    ("builtin:ajar", "builtin:ajar", "y=0.8,0.199"),
    ("living-room", SHARED / "bitterli-living-room-pbrt/living-room-reference.pbrt", "y=0.8,0.154"),
    ("veach-ajar", SHARED / "bitterli-veach-ajar-pbrt/veach-ajar-reference.pbrt", "y=0.8,0.374"),
]

RENDER = {"size": "320x240", "samples": "8", "gather": "64"}  # a render of some 20 s of the atrium
REPEATS = 5
PYTHON = """
import sys
import glowworm
glowworm.render(glowworm.Scene.load("builtin:atrium"), size=(320, 240), samples=8, gather=64, progress=False
                ).write(sys.argv[1])
"""

RAYS = """
import sys
import time
import numpy as np
import glowworm
glowworm.set_threads(1)
tracer = glowworm.Tracer(glowworm.Scene.load("builtin:atrium"))
rays = np.fromfile(sys.argv[1], dtype=np.float32).reshape(-1, 6)
for times in (1, 10):
    origins, directions = (np.tile(rays[:, k:k + 3], (times, 1)) for k in (0, 3))
    seconds = []
    for _ in range(30 // times + 10):
        start = time.process_time()
        tracer.intersect(origins, directions)
        seconds.append(time.process_time() - start)
    print(len(origins), len(origins) / np.median(seconds))
"""


def matrix():
    """Returns wall seconds and processor seconds of a daylight matrix of some 1,000 sensors, and its sensors."""
    with tempfile.TemporaryDirectory() as folder:
        table, out = f"{folder}/t.json", f"{folder}/d.mtx"
        where = ["builtin:window-room", "--grid", "y=0.8,0.159"]
        subprocess.run([PROGRAM, "measure", *where, "--samples", "2", "--photons", "1000", "-o", table, "-q"],
                       check=True)
        sensors = len(json.loads(pathlib.Path(table).read_text(encoding="utf-8"))["points"])
        start, before = time.monotonic(), processor_seconds()
        subprocess.run([PROGRAM, "measure", *where, "--sky-patches", "145", "-o", out, "-q"], check=True)
        return time.monotonic() - start, processor_seconds() - before, sensors


def renders():
    """Returns the medians of processor seconds of one render from the command line and from Python, in turn."""
    seconds = [[], []]
    module = {**os.environ, "PYTHONPATH": str(ROOT / "build/release/python")}
    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/x.exr"
        options = [text for name, value in RENDER.items() for text in (f"--{name}", value)]
        commands = ([PROGRAM, "render", "builtin:atrium", *options, "-o", out, "-q"],
                    ["/usr/bin/python3", "-c", PYTHON, out])
        for _ in range(REPEATS):
            for k, command in enumerate(commands):
                before = processor_seconds()
                subprocess.run(command, check=True, env=module)
                seconds[k].append(processor_seconds() - before)
    return statistics.median(seconds[0]), statistics.median(seconds[1])


def rays():
    """Returns rows of million camera rays of the atrium a second on one thread, medians of runs in turn."""
    rates = {}
    module = {**os.environ, "PYTHONPATH": str(ROOT / "build/release/python")}
    with tempfile.TemporaryDirectory() as folder:
        file = f"{folder}/rays"
        for _ in range(REPEATS):
            words = subprocess.run([ROOT / "build/release/bin/ray_bench", "camera", file], check=True, text=True,
                                   stdout=subprocess.PIPE).stdout.split()
            for name, rate in zip(("Embree, one by one", "our tracer, one batch of 102400"), words):
                rates.setdefault(name, []).append(float(rate))
            text = subprocess.run(["/usr/bin/python3", "-c", RAYS, file], check=True, text=True, env=module,
                                  stdout=subprocess.PIPE).stdout
            for line in text.splitlines():
                count, rate = line.split()
                rates.setdefault(f"Python, `Tracer.intersect()`, batches of {count}", []).append(float(rate))
    medians = {name: 1e-6 * statistics.median(values) for name, values in rates.items()}
    first = next(iter(medians.values()))
    return [f"| {name} | {rate:.2f} | {rate / first:.2f} |" for name, rate in medians.items()]


def measure(scene, grid, options):
    """Returns mean illuminance (lx), sensors, samples, seconds of all cores and relative error."""
    before = processor_seconds()
    with tempfile.TemporaryDirectory() as folder:
        stats, table = f"{folder}/s.json", f"{folder}/t.json"
        subprocess.run([PROGRAM, "measure", scene, "--grid", grid, "--noise", NOISE, "--time", LIMIT, "--stats", stats,
                        "-o", table, "-q", *options], check=True)
        passes = json.loads(pathlib.Path(stats).read_text(encoding="utf-8"))["passes"]
        points = json.loads(pathlib.Path(table).read_text(encoding="utf-8"))["points"]
    seconds = processor_seconds() - before
    levels = [p["E_lx"] for p in points]
    mean = sum(levels) / len(levels)
    # As --noise has it: the root of the mean of variance / (E^2 + 0.01 mean^2).
    errors = [(p["relative_error"] * p["E_lx"]) ** 2 / (p["E_lx"] ** 2 + 0.01 * mean**2) for p in points]
    return mean, len(points), passes, seconds, (sum(errors) / len(errors)) ** 0.5


def main():
    lines = ["# Measurements", "Written by `bench/tables_measure.py`.", "", f"## CPU seconds to a relative standard error of {NOISE}",
             f"{platform.machine()}, {os.cpu_count()} cores; at most {LIMIT} each.", "",
             "| scene | sensors | method | samples | relative error | mean, lx | CPU s | times |",
             "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for name, scene, grid in SCENES:
        if not str(scene).startswith("builtin:") and not pathlib.Path(scene).exists():
            continue
        seconds = []
        for method, options in (("photon maps", []), ("path tracing", ["--integrator", "path"])):
            mean, sensors, samples, s, error = measure(str(scene), grid, options)
            seconds.append(s)
            lines.append(f"| {name} | {sensors} | {method} | {samples} | {100 * error:.2f}% | {mean:.4g} | {s:.3g} | "
                         f"{s / seconds[0]:.3g} |")
            print(lines[-1], flush=True)
    wall, seconds, sensors = matrix()
    lines += ["", "## Daylight matrix",
              f"145 patches x {sensors} sensors of window-room: {wall:.3g} s, {seconds:.3g} s of processor time.", ""]
    program, module = renders()
    lines += ["## Python", f"The same render of the atrium, medians of {REPEATS}: command line {program:.3g} s of "
              f"processor time, Python {module:.3g} s ({100 * (module / program - 1):+.1f}%)."]
    lines += ["", "Camera rays of the atrium, 320 x 320, on one thread.", "",
              "| way | million rays/s | times |", "| --- | --- | --- |", *rays()]
    print("\n".join(lines[-14:]))
    target = ROOT / "bench/results/measure.md"
    target.parent.mkdir(exist_ok=True)
    target.write_text("\n".join(lines) + "\n", encoding="utf-8")


main()
