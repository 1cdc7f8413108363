#!/usr/bin/env python3
"""Error at equal processor time: the path tracer, and photon mapping with and without guided gather rays, filter and
adaptive sampling.

The time is that of 16 samples (--samples) with neither guide nor filter (nor rays to bright patches). Each method is
rendered with twice or half of the samples, or of the square of a noise target, until its times enclose that one, and its
error there is interpolated. Numbers of samples are powers of two, which are the best stratified. The error is relRMSE
without the worst 2% of the pixels, against the mean of two progressive renders of this program of other seeds without
filter; half of their difference is the reference's own noise, which is taken off.

A second table has the error of filtered progressive renders of half the size with few photons, and the slope of its
logarithm over that of the time, with two standard errors of the straight line.

Writes bench/results/equal-time.md. References stay in build/equal-time/, and are made where they are missing.

--before PROGRAM compares all methods with an older program at its default options.

A filter has more to average in larger pictures: --times 2 doubles their sides, and leaves out the second table.

With --cost, writes bench/results/guide-and-filter.md alone: processor seconds of guide and filter at the same samples,
each over those of neither in the same round of runs.

usage: tables_equal_time.py [--samples-of-reference N] [--samples N] [--times N] [--methods NAME,...] [--seeds N]
                            [--before PROGRAM] [--cost] [SCENE...]
"""
import argparse
import math
import os
import subprocess
import sys
import tempfile

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "build/release/python"))
import glowworm  # noqa: E402

PROGRAM = os.path.join(ROOT, "build/release/bin/glowworm")
SHARED = os.path.join(ROOT, "../shared/scenes")
CACHE = os.path.join(ROOT, "build/equal-time")
RESULTS = os.path.join(ROOT, "bench/results/equal-time.md")
COSTS = os.path.join(ROOT, "bench/results/guide-and-filter.md")
LEAVE_OUT = 0.02
# Renders of a method at most, until their times enclose the one wanted.
MOST_RENDERS = 5

SCENES = {
    "cornell-grey": ("cornell-grey-pbrt/cornell-grey-reference.pbrt", "160x160"),
    "cornell-box": ("bitterli-cornell-box-pbrt/cornell-box-reference.pbrt", "160x160"),
    "sponza-sun": ("sponza-dabrovic/pbrt/sponza-sun.pbrt", "224x140"),
    "veach-bidir": ("bitterli-veach-bidir-pbrt/veach-bidir-reference.pbrt", "176x132"),
    "staircase2": ("bitterli-staircase2-pbrt/staircase2-reference.pbrt", "108x192"),
    "living-room": ("bitterli-living-room-pbrt/living-room-reference.pbrt", "192x108"),
    "veach-ajar": ("bitterli-veach-ajar-pbrt/veach-ajar-reference.pbrt", "192x108"),
    "classroom": ("classroom-pbrt/classroom-reference.pbrt", "192x108"),
    "cornell": ("builtin:cornell", "160x160"),
    "atrium": ("builtin:atrium", "208x120"),
    "ajar": ("builtin:ajar", "192x144"),
    "window-room": ("builtin:window-room", "176x132"),
    "ring": ("builtin:ring", "176x132"),
    "glass-sphere": ("builtin:glass-sphere", "176x132"),
    "fog-box": ("media-pbrt/fog-box.pbrt", "64x64"),
    "shafts": ("media-pbrt/shafts.pbrt", "80x60"),
    "gas-caustic": ("media-pbrt/gas-caustic.pbrt", "64x64"),
    "volumetric-caustic": ("bitterli-cornell-box-pbrt/volumetric-caustic.pbrt", "96x54"),
}


def of_samples(work):
    return ["--samples", str(round(work))]


# Options, and work to begin with. The first method is what the others are compared with.
METHODS = {
    "neither": (["--filter", "off", "--no-gather-guiding"], of_samples, 16),
    "path tracer": (["--integrator", "path"], of_samples, 256),
    "guide": (["--filter", "off"], of_samples, 16),
    "filter": (["--no-gather-guiding"], of_samples, 16),
    "both": ([], of_samples, 16),
    # Adaptive sampling is that of renders to a noise target.
    "all": ([], lambda work: ["--noise", f"{0.04 / math.sqrt(work):.5f}"], 1),
}
# Scenes and samples of the second table.
SLOPE_SCENES = ("cornell", "ajar", "veach-bidir")
SLOPE_SAMPLES = (4, 8, 16, 32, 64, 128, 256, 512)
SLOPE_PHOTONS = 40000
# Renders of the table of costs.
COST_METHODS = ("guide", "filter", "both")
COST_SIZE, COST_OPTIONS, COST_ROUNDS = "512x512", ["--samples", "16", "--gather", "16"], 3


def path_of(name):
    file, _ = SCENES[name]
    return file if file.startswith("builtin:") else os.path.join(SHARED, file)


def render(name, options, output, size=None, program=PROGRAM):
    """Renders a scene; returns processor seconds. Exits with the program's message if it fails."""
    size = size or SCENES[name][1]
    command = [program, "render", path_of(name), "--size", size, "--quiet", "-o", output, *options]
    before = os.times()
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"tables_equal_time: {' '.join(command)}\n{result.stderr}")
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def relative_rmse(image, reference):
    return glowworm.compare(image, reference, leave_out=LEAVE_OUT)["relative_rmse"]


def halves_of_reference(name, samples):
    halves = []
    for half in (1, 2):
        file = os.path.join(CACHE, f"{name}-{SCENES[name][1]}-{half}.exr")
        if not os.path.exists(file):
            seed = str(990000 + half)
            render(name, ["--samples", str(samples // 2), "--progressive", "--filter", "off", "--seed", seed], file)
        halves.append(glowworm.Picture.read(file)["image"])
    return halves


def halved(picture):
    """A picture of half the size: means of squares of four pixels, as its box filter would render them."""
    height, width, channels = picture.shape
    return picture.reshape(height // 2, 2, width // 2, 2, channels).mean(axis=(1, 3), dtype=np.float64).astype(np.float32)


class Scene:
    """A scene with its reference."""

    def __init__(self, name, options, folder):
        self.name = name
        self.halves = halves_of_reference(name, options.samples_of_reference)
        self.seeds = range(1, options.seeds + 1)
        self.methods, self.work = options.methods, options.samples / 16
        self.first_program = options.before or PROGRAM
        self.output = os.path.join(folder, "image.exr")

    def noise(self):
        """relRMSE of the reference's own noise."""
        return relative_rmse(*self.halves) / 2

    def try_out(self, options, size=None, program=PROGRAM):
        """Processor seconds and error, the mean over seeds."""
        seconds = squares = 0
        reference, noise = sum(self.halves) / 2, self.noise()
        for seed in self.seeds:
            seconds += render(self.name, [*options, "--seed", str(seed)], self.output, size, program) / len(self.seeds)
            error = relative_rmse(glowworm.Picture.read(self.output)["image"], reference)
            squares += (error**2 - noise**2) / len(self.seeds)
        error = math.sqrt(max(squares, 0))
        print(f"{self.name:14} {' '.join(options):50} {seconds:7.2f} s  error {error:.4f}", flush=True)
        return seconds, error

    def error_at(self, method, wanted):
        """Error of a method at a processor time, interpolated between renders, on logarithmic scales."""
        options, effort, work = METHODS[method]
        work *= self.work
        curve = []
        while len(curve) < MOST_RENDERS:
            seconds, error = self.try_out([*effort(work), *options])
            curve.append((seconds, error))
            if len(curve) > 1 and min(curve)[0] <= wanted <= 1.05 * max(curve)[0]:
                break
            missing = math.log2(wanted / seconds)
            work *= 2.0 ** (math.ceil(missing) if missing > 0 else math.floor(missing))
        curve.sort()
        pairs = [pair for pair in zip(curve, curve[1:]) if pair[0][0] <= wanted <= 1.05 * pair[1][0]]
        if not pairs or pairs[0][0][1] <= 0 or pairs[0][1][1] <= 0:
            return math.nan
        (t0, e0), (t1, e1) = pairs[0]
        return e0 * (e1 / e0) ** (math.log(wanted / t0) / math.log(t1 / t0))

    def row(self):
        first, *others = self.methods
        options, effort, work = METHODS[first]
        seconds, error = self.try_out([*effort(self.work * work), *options], program=self.first_program)
        cells = [f"{error:.4f}"]
        for method in others:
            own = self.error_at(method, seconds)
            cells.append(f"{own:.4f} ({own / error:.2f})")
        return f"| {self.name} | {seconds:.1f} | {self.noise():.4f} | " + " | ".join(cells) + " |"

    def slope_row(self):
        self.halves = [halved(half) for half in self.halves]
        height, width, _ = self.halves[0].shape
        options = ["--progressive", "--photons", str(SLOPE_PHOTONS)]
        curve = [self.try_out([*options, *of_samples(n)], f"{width}x{height}") for n in SLOPE_SAMPLES]
        time, error = np.log(np.array(curve).T)
        (slope, _), covariance = np.polyfit(time, error, 1, cov=True)
        cells = [f"{e:.4f}" for _, e in curve]
        span = curve[-1][0] / curve[0][0]
        return f"| {self.name} | {' | '.join(cells)} | {span:.0f} | {slope:.2f} ± {2 * math.sqrt(covariance[0, 0]):.2f} |"


def table_head(names):
    return ["| " + " | ".join(names) + " |", "| --- |" + " --- |" * (len(names) - 1)]


def cost_row(name, output):
    methods = ("neither", *COST_METHODS)
    seconds = np.array([[render(name, [*COST_OPTIONS, *METHODS[method][0]], output, COST_SIZE) for method in methods]
                        for _ in range(COST_ROUNDS)])
    ratios = (seconds[:, 1:] / seconds[:, :1]).T
    cells = [f"{np.median(r):.2f} ({min(r):.2f} to {max(r):.2f})" for r in ratios]
    return f"| {name} | {np.median(seconds[:, 0]):.1f} | {' | '.join(cells)} |"


def write_costs(names):
    lines = ["# Processor seconds of guide and filter, over those of neither", "",
             f"Renders of {COST_SIZE} pixels with `{' '.join(COST_OPTIONS)}`: median and range of {COST_ROUNDS} rounds.",
             "Written by `bench/tables_equal_time.py --cost`.", "",
             *table_head(["scene", "seconds of neither", *COST_METHODS])]
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            lines.append(cost_row(name, os.path.join(folder, "image.exr")))
            print(lines[-1], flush=True)
    with open(COSTS, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples-of-reference", type=int, default=48, help="of those that are missing")
    parser.add_argument("--samples", type=int, default=16, help="of the method whose time is that of all")
    parser.add_argument("--times", type=int, default=1, help="sides of the pictures, times those of the list of scenes")
    parser.add_argument("--methods", type=lambda text: text.split(","), default=list(METHODS),
                        help="the first is compared with")
    parser.add_argument("--before", metavar="PROGRAM", help="an older program, with which all methods are compared")
    parser.add_argument("--seeds", type=int, default=1, help="renders of each cell")
    parser.add_argument("--cost", action="store_true", help="write the table of costs alone")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=list(SCENES))
    options = parser.parse_args()
    if unknown := set(options.scenes) - set(SCENES):
        sys.exit(f"tables_equal_time: there is no scene {', '.join(sorted(unknown))}; there are {', '.join(SCENES)}")
    if unknown := set(options.methods) - set(METHODS):
        sys.exit(f"tables_equal_time: there is no method {', '.join(sorted(unknown))}; there are {', '.join(METHODS)}")
    if options.before:
        # An older program may not know the options of this one.
        METHODS["before"] = ([], of_samples, 16)
        options.methods.insert(0, "before")
    for name, (file, size) in SCENES.items():
        SCENES[name] = (file, "x".join(str(options.times * int(side)) for side in size.split("x")))
    os.makedirs(CACHE, exist_ok=True)
    os.makedirs(os.path.dirname(RESULTS), exist_ok=True)
    names = [name for name in options.scenes if path_of(name).startswith("builtin:") or os.path.exists(path_of(name))]
    if options.cost:
        return write_costs(names)
    lines = [
        "# Error at equal processor time",
        "",
        f"relRMSE without the worst 2% of the pixels, at the processor time of {options.samples} samples with '{options.methods[0]}',",
        f"and in brackets its ratio to that error. 'neither' is neither guide nor filter. Sides of pictures are {options.times} times those",
        "listed in `bench/tables_equal_time.py`, which made this table and says how.",
        "",
        *table_head(["scene", "seconds", "noise of reference", *options.methods]),
    ]
    slopes = []
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            scene = Scene(name, options, folder)
            lines.append(scene.row())
            print(lines[-1], flush=True)
            if name in SLOPE_SCENES and options.times == 1:
                slopes.append(scene.slope_row())
                print(slopes[-1], flush=True)
    if slopes:
        samples = [f"{n} samples" for n in SLOPE_SAMPLES]
        lines += ["", "## Error of filtered progressive renders", "",
                  *table_head(["scene", *samples, "longest over shortest time", "slope"]), *slopes]
    with open(RESULTS, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
