#!/usr/bin/env python3
"""Error at equal processor time: the path tracer, and photon mapping with and without guided gather rays, filter and
adaptive sampling.

Renders each scene with several numbers of samples, or to several noise targets, and interpolates the error of each method at the processor time of
16 samples without guide and filter. The error is relRMSE without the worst 2% of the pixels, against a progressive render
of this program (another seed, no filter) in two halves, whose difference tells the reference's own noise, which is
taken off.
Writes bench/results/equal_time.md. References stay in build/equal-time/, and are made where they are missing.

usage: tables_equal_time.py [--samples-of-reference N] [--samples 2,4,8,16,32] [SCENE...]
"""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PROGRAM = os.path.join(ROOT, "build/release/bin/glowworm")
SHARED = os.path.join(ROOT, "../shared/scenes")
CACHE = os.path.join(ROOT, "build/equal-time")
RESULTS = os.path.join(ROOT, "bench/results/equal_time.md")
# Processor seconds are compared at those of the first method with so many samples.
SAMPLES_OF_FIRST = 16
LEAVE_OUT = "0.02"

SCENES = {
    "cornell-grey": ("cornell-grey-pbrt/cornell-grey-reference.pbrt", "96x96"),
    "cornell-box": ("bitterli-cornell-box-pbrt/cornell-box-reference.pbrt", "96x96"),
    "sponza-sun": ("sponza-dabrovic/pbrt/sponza-sun.pbrt", "160x100"),
    "veach-bidir": ("bitterli-veach-bidir-pbrt/veach-bidir-reference.pbrt", "128x96"),
    "staircase2": ("bitterli-staircase2-pbrt/staircase2-reference.pbrt", "72x128"),
    "living-room": ("bitterli-living-room-pbrt/living-room-reference.pbrt", "128x72"),
    "veach-ajar": ("bitterli-veach-ajar-pbrt/veach-ajar-reference.pbrt", "128x72"),
    "classroom": ("classroom-pbrt/classroom-reference.pbrt", "120x68"),
    "cornell": ("builtin:cornell", "96x96"),
    "atrium": ("builtin:atrium", "128x72"),
    "ajar": ("builtin:ajar", "128x96"),
    "window-room": ("builtin:window-room", "128x96"),
    "ring": ("builtin:ring", "128x96"),
    "glass-sphere": ("builtin:glass-sphere", "128x96"),
}
# The first is what the others are compared with.
METHODS = {
    "neither": ["--filter", "off", "--no-gather-guiding"],
    "path tracer": ["--integrator", "path"],
    "guide": ["--filter", "off"],
    "filter": ["--no-gather-guiding"],
    "both": [],
    "all": [],
}
# Adaptive sampling is that of renders to a noise target.
NOISE_TARGETS = (0.3, 0.15, 0.075, 0.0375, 0.02)


def path_of(name):
    file, _ = SCENES[name]
    return file if file.startswith("builtin:") else os.path.join(SHARED, file)


def render(name, options, output):
    """Renders a scene; returns processor seconds. Exits with the program's message if it fails."""
    command = [PROGRAM, "render", path_of(name), "--size", SCENES[name][1], "--quiet", "-o", output, *options]
    before = os.times()
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"tables_equal_time: {' '.join(command)}\n{result.stderr}")
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def compare(image, reference, *options):
    out = subprocess.run([PROGRAM, "compare", image, reference, "--json", *options], capture_output=True, text=True)
    if out.returncode != 0:
        sys.exit(f"tables_equal_time: {out.stderr}")
    return json.loads(out.stdout)


def reference_of(name, samples):
    """Two halves of a reference, so that their difference tells its noise: (file, relRMSE of the mean)."""
    halves = []
    for half in (1, 2):
        halves.append(os.path.join(CACHE, f"{name}-{samples}-{half}.exr"))
        if not os.path.exists(halves[-1]):
            seed = str(990000 + half)
            render(name, ["--samples", str(samples // 2), "--progressive", "--filter", "off", "--seed", seed], halves[-1])
    noise = compare(halves[0], halves[1], "--leave-out", LEAVE_OUT)["relative_rmse"] / math.sqrt(2)
    return halves, noise


def error_of(image, halves, noise):
    """relRMSE against the mean of the halves: of each, less its noise."""
    squares = [compare(image, half, "--leave-out", LEAVE_OUT)["relative_rmse"] ** 2 - noise**2 for half in halves]
    return math.sqrt(max(sum(squares) / len(squares), 0.0))


def at_time(curve, seconds):
    """Error at a processor time, by log-log interpolation; NaN outside of the curve."""
    for (t0, e0), (t1, e1) in zip(curve, curve[1:]):
        if t0 <= seconds <= t1 and e0 > 0 and e1 > 0:
            share = math.log(seconds / t0) / math.log(t1 / t0)
            return math.exp(math.log(e0) + share * (math.log(e1) - math.log(e0)))
    return math.nan


def measure(name, options, folder):
    halves, noise = reference_of(name, options.samples_of_reference)
    curves = {}
    for method, arguments in METHODS.items():
        efforts = [["--samples", str(n if method != "path tracer" else 16 * n)] for n in options.samples]
        if method == "all":
            efforts = [["--noise", str(target)] for target in NOISE_TARGETS]
        curves[method] = []
        for effort in efforts:
            image = os.path.join(folder, "image.exr")
            seconds = render(name, [*effort, *arguments], image)
            curves[method].append((seconds, error_of(image, halves, noise)))
            print(f"{name:14} {method:12} {' '.join(effort)} {seconds:8.2f} s  error {curves[method][-1][1]:.4f}", flush=True)
    time = curves[next(iter(METHODS))][options.samples.index(SAMPLES_OF_FIRST)][0]
    return time, {method: at_time(curve, time) for method, curve in curves.items()}, noise


def row(name, result):
    time, errors, noise = result
    first = next(iter(errors.values()))
    cells = [f"{error:.4f}" if i == 0 else f"{error:.4f} ({error / first:.2f})" for i, error in enumerate(errors.values())]
    return f"| {name} | {time:.1f} | {noise:.4f} | " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples-of-reference", type=int, default=256)
    parser.add_argument("--samples", type=lambda text: [int(n) for n in text.split(",")], default=[2, 4, 8, 16, 32])
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=list(SCENES))
    options = parser.parse_args()
    if unknown := set(options.scenes) - set(SCENES):
        sys.exit(f"tables_equal_time: there is no scene {', '.join(sorted(unknown))}; there are {', '.join(SCENES)}")
    if SAMPLES_OF_FIRST not in options.samples:
        sys.exit(f"tables_equal_time: --samples needs {SAMPLES_OF_FIRST}")
    os.makedirs(CACHE, exist_ok=True)
    os.makedirs(os.path.dirname(RESULTS), exist_ok=True)
    lines = [
        "# Error at equal processor time",
        "",
        f"relRMSE without the worst 2% of the pixels, at the processor time of {SAMPLES_OF_FIRST} samples with neither, and in",
        "brackets its ratio to their error. Made by `bench/tables_equal_time.py`, which says how.",
        "",
        "| scene | seconds | noise of reference | " + " | ".join(METHODS) + " |",
        "| --- |" + " --- |" * (2 + len(METHODS)),
    ]
    with tempfile.TemporaryDirectory() as folder:
        for name in options.scenes:
            if not os.path.exists(path_of(name)) and not path_of(name).startswith("builtin:"):
                print(f"{name}: {path_of(name)} is missing")
                continue
            lines.append(row(name, measure(name, options, folder)))
            print(lines[-1], flush=True)
    with open(RESULTS, "w") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
