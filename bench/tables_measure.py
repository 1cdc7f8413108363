#!/usr/bin/env python3
"""Times measurements to a relative error, by photon maps and by path tracing: bench/results/measure.md.

usage: tables_measure.py [PROGRAM]      scenes of ../shared are left out where there are none
"""
import json
import os
import pathlib
import platform
import resource
import subprocess
import sys
import tempfile

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


def measure(scene, grid, options):
    """Returns mean illuminance (lx), sensors, samples, seconds of all cores and relative error."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        stats, table = f"{folder}/s.json", f"{folder}/t.json"
        subprocess.run([PROGRAM, "measure", scene, "--grid", grid, "--noise", NOISE, "--time", LIMIT, "--stats", stats,
                        "-o", table, "-q", *options], check=True)
        statistics = json.loads(pathlib.Path(stats).read_text(encoding="utf-8"))
        points = json.loads(pathlib.Path(table).read_text(encoding="utf-8"))["points"]
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    levels = [p["E_lx"] for p in points]
    mean = sum(levels) / len(levels)
    # As --noise has it: the root of the mean of variance / (E^2 + 0.01 mean^2).
    errors = [(p["relative_error"] * p["E_lx"]) ** 2 / (p["E_lx"] ** 2 + 0.01 * mean**2) for p in points]
    return mean, len(points), statistics["passes"], seconds, (sum(errors) / len(errors)) ** 0.5


def main():
    lines = ["# Measurements", "", f"## CPU seconds to a relative standard error of {NOISE}",
             f"{platform.machine()}, {os.cpu_count()} cores; `bench/tables_measure.py`; at most {LIMIT} each.", "",
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
    target = ROOT / "bench/results/measure.md"
    target.parent.mkdir(exist_ok=True)
    target.write_text("\n".join(lines) + "\n", encoding="utf-8")


main()
