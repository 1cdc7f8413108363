#!/usr/bin/env python3
"""Error against the truth at given processor times: the path tracer, an older program, and this one.

The truth is the mean of two renders of our path tracer of other seeds. Half of their difference is its own noise, whose
square is subtracted from each squared error; where the rest is negative, the table says '< noise'. The error is relRMSE,
by pixel without the worst 2% and with all, and by blocks of 8 x 8 pixels, whose means a viewer sees as blotches.

Each method is rendered with 1, 2, 4, ... samples until its processor time exceeds the longest one wanted. Errors between
are interpolated on logarithmic scales. '-' stands where one sample takes longer than the time.

Writes bench/results/truth.md. Truths stay in build/truth/, and are made where they are missing. Rows of scenes that a
run leaves out stay in the table, if it has the same times and methods.

usage: tables_truth.py [--times S,...] [--before PROGRAM] [--truth-samples N] [--seeds N] [SCENE...]
"""
import argparse
import math
import os
import sys
import tempfile

import tables_equal_time as equal_time
from tables_equal_time import PROGRAM, ROOT, glowworm, path_of, render, table_head

CACHE = os.path.join(ROOT, "build/truth")
RESULTS = os.path.join(ROOT, "bench/results/truth.md")
BLOCK = 8
MOST_SAMPLES = 1 << 16

# Sides are multiples of a block.
SIZES = {
    "cornell-grey": "96x96",
    "cornell-box": "96x96",
    "sponza-sun": "128x80",
    "veach-bidir": "128x96",
    "staircase2": "72x128",
    "living-room": "128x72",
    "veach-ajar": "128x72",
    "classroom": "128x72",
    "cornell": "96x96",
    "atrium": "128x72",
    "ajar": "128x96",
    "window-room": "128x96",
    "ring": "128x96",
    "glass-sphere": "128x96",
}
DEFAULT_SCENES = ("cornell", "atrium", "living-room", "classroom")


def blocks_of(picture):
    height, width, channels = picture.shape
    parts = picture.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels)
    return parts.mean(axis=(1, 3), dtype="float64").astype("float32")


# What is measured: of a picture and the truth, relRMSE.
MEASURES = {
    "pixels": lambda a, b: glowworm.compare(a, b, leave_out=equal_time.LEAVE_OUT)["relative_rmse"],
    "all pixels": lambda a, b: glowworm.compare(a, b)["relative_rmse"],
    "blocks": lambda a, b: glowworm.compare(blocks_of(a), blocks_of(b))["relative_rmse"],
}


class Truth:
    """The truth of a scene, the two halves that it is the mean of, and its noise by measure."""

    def __init__(self, name, samples):
        halves = self.halves = []
        for half in (1, 2):
            file = os.path.join(CACHE, f"{name}-{SIZES[name]}-{samples}-{half}.exr")
            if not os.path.exists(file):
                options = ["--integrator", "path", "--samples", str(samples // 2), "--seed", str(990000 + half)]
                render(name, options, file, SIZES[name])
            halves.append(glowworm.Picture.read(file)["image"])
        self.picture = sum(halves) / 2
        self.noise = {measure: rmse(*halves) / 2 for measure, rmse in MEASURES.items()}

    def squared_errors(self, picture):
        return {measure: rmse(picture, self.picture) ** 2 - self.noise[measure] ** 2 for measure, rmse in MEASURES.items()}


class Method:
    """Renders of one program, and their errors by processor time."""

    def __init__(self, name, program, options):
        self.name, self.program, self.options = name, program, options

    def curve(self, scene, truth, longest, seeds, output):
        """Tuples of processor seconds and squared errors, means over seeds, by growing numbers of samples."""
        out, samples = [], 1
        while samples <= MOST_SAMPLES and (not out or out[-1][0] < longest):
            seconds, squares = 0.0, dict.fromkeys(MEASURES, 0.0)
            for seed in range(1, seeds + 1):
                options = [*self.options, "--samples", str(samples), "--seed", str(seed)]
                seconds += render(scene, options, output, SIZES[scene], self.program) / seeds
                for measure, square in truth.squared_errors(glowworm.Picture.read(output)["image"]).items():
                    squares[measure] += square / seeds
            print(f"{scene:14} {self.name:12} {samples:6} samples {seconds:8.2f} s  "
                  + "  ".join(f"{m} {math.copysign(math.sqrt(abs(s)), s):.4f}" for m, s in squares.items()), flush=True)
            out.append((seconds, squares))
            samples *= 2
        return out


def error_at(curve, wanted, measure):
    """The error at a processor time: nan: no render is as short, 0: below the noise of the truth."""
    for (t0, before), (t1, after) in zip(curve, curve[1:]):
        if t0 <= wanted <= t1:
            if min(before[measure], after[measure]) <= 0:
                return 0.0
            share = math.log(wanted / t0) / math.log(t1 / t0)
            return math.sqrt(before[measure] ** (1 - share) * after[measure] ** share)
    return math.nan


def cell(error):
    return "-" if math.isnan(error) else "< noise" if error <= 0 else f"{error:.4f}"


def rows_of(scene, methods, options, folder):
    truth = Truth(scene, options.truth_samples)
    output = os.path.join(folder, "image.exr")
    curves = [m.curve(scene, truth, max(options.times), options.seeds, output) for m in methods]
    for time in options.times:
        for measure in MEASURES:
            cells = [cell(error_at(curve, time, measure)) for curve in curves]
            yield f"| {scene} | {time:g} | {measure} | {truth.noise[measure]:.4f} | {' | '.join(cells)} |"


def kept_rows(head, scenes, results=RESULTS):
    """Rows of other scenes in the table that exists, if its head is the same."""
    if not os.path.exists(results):
        return []
    with open(results, encoding="utf-8") as file:
        lines = file.read().splitlines()
    if lines[:len(head)] != head:
        return []
    return [line for line in lines[len(head):] if line.split("|")[1].strip() not in scenes]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", type=lambda text: [float(t) for t in text.split(",")], default=[5.0, 20.0],
                        help="processor seconds (default: 5,20)")
    parser.add_argument("--before", metavar="PROGRAM", help="an older program to compare with")
    parser.add_argument("--truth-samples", type=int, default=2048, help="of the path tracer, in both renders")
    parser.add_argument("--seeds", type=int, default=1, help="renders of each number of samples")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=list(DEFAULT_SCENES), help=f"of {', '.join(SIZES)}")
    options = parser.parse_args()
    if unknown := set(options.scenes) - set(SIZES):
        sys.exit(f"tables_truth: there is no scene {', '.join(sorted(unknown))}; there are {', '.join(SIZES)}")
    methods = [Method("path tracer", PROGRAM, ["--integrator", "path"])]
    if options.before:
        methods.append(Method("before", options.before, []))
    methods.append(Method("glowworm", PROGRAM, []))
    for folder in (CACHE, os.path.dirname(RESULTS)):
        os.makedirs(folder, exist_ok=True)
    head = ["# Error against the truth at processor times", "",
            f"relRMSE against {options.truth_samples} samples of the path tracer, whose own noise is subtracted:",
            "by pixel without the worst 2%, by pixel, and by means of 8 x 8 pixels. Written by `bench/tables_truth.py`,",
            f"which says how; times are {', '.join(f'{t:g}' for t in options.times)} s.", "",
            *table_head(["scene", "processor seconds", "error of", "noise of truth", *(m.name for m in methods)])]
    names = [name for name in options.scenes if path_of(name).startswith("builtin:") or os.path.exists(path_of(name))]
    rows = kept_rows(head, names)
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            rows += rows_of(name, methods, options, folder)
            with open(RESULTS, "w", encoding="utf-8") as file:
                file.write("\n".join(head + rows) + "\n")


if __name__ == "__main__":
    main()
