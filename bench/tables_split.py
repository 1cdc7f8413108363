#!/usr/bin/env python3
"""What the squared error of a filtered picture is made of: noise of rays, noise of photons, bias of photons and of the
filter. The largest part tells where more work helps: samples, photons, or neither.

Three pictures of a seed are parts of one render (--part): they share the photons, so their differences are noise of
rays. Pictures of other seeds differ by the noise of photons, too. What is left of the error against the truth is bias.
Unfiltered renders with the same photons tell the bias of these; the rest is the filter's. It is negative where the
filter undoes a part of the bias of photons.

Neighbouring parts of a sequence of samples complement each other, and the first and the third resemble each other: they
are in the same strata. Half of each is as for parts that are independent.

Squared errors are relative, as those of `glowworm compare`: (p - t)^2 / (t^2 + 0.01), with t the truth, over the pixels
but for the 2% with most error, and over means of blocks of 8 x 8 pixels. Parts that are small beside the noise of rays
are uncertain by a tenth of it, and may be negative. The truth is of bench/tables_truth.py; its own noise is subtracted.
Where that is larger than the error, bias cannot be told: the table has '-'.

Writes bench/results/split.md. Rows of scenes that a run leaves out stay in the table, if it has the same settings.

usage: tables_split.py [--samples N] [--photons N] [--truth-samples N] [--seeds N] [SCENE...]
"""
import argparse
import itertools
import os
import subprocess
import sys
import tempfile

import numpy as np
import tables_truth
from tables_equal_time import LEAVE_OUT, PROGRAM, ROOT, glowworm, path_of, render, table_head
from tables_truth import SIZES, Truth, blocks_of

RESULTS = os.path.join(ROOT, "bench/results/split.md")
DEFAULT_SCENES = ("cornell", "atrium", "window-room", "ajar")
# Unfiltered renders have this multiple of the samples, because their noise is larger, and only their bias counts.
MORE_SAMPLES = 4
PARTS = 3


def parts_of(scene, options, samples, seed, folder):
    """Pictures of so many samples each, with the same photons."""
    pictures = []
    for part in range(1, PARTS + 1):
        file, output = (os.path.join(folder, name) for name in ("one.part", "one.exr"))
        whole = ["--samples", str(4 * samples), "--part", f"{part}/4", "--seed", str(seed)]
        render(scene, [*options, *whole], file, SIZES[scene])
        # It says that the other samples are missing.
        subprocess.run([PROGRAM, "merge", file, "--quiet", "-o", output], check=True, capture_output=True)
        pictures.append(glowworm.Picture.read(output)["image"].astype(np.float64))
    return pictures


class Measure:
    """Relative squared differences of pictures, in which `pictures` have most error left out."""

    def __init__(self, truth, blocks, pictures):
        self.blocks = blocks
        self.truth = self.of(truth)
        error = sum(self.squares(p, truth) for p in pictures)
        share = 0 if blocks else LEAVE_OUT
        self.kept = error <= np.quantile(error, 1 - share)

    def of(self, picture):
        return blocks_of(picture) if self.blocks else picture

    def squares(self, a, b):
        return ((self.of(a) - self.of(b)) ** 2 / (self.truth**2 + 0.01)).mean(axis=2)

    def difference(self, a, b):
        return self.squares(a, b)[self.kept].mean()

    def split(self, groups, truth, noise):
        """Noise of rays, noise of photons, and bias, of groups of pictures that share photons."""
        complements = [self.difference(*pair) for a, b, c in groups for pair in ((a, b), (b, c))]
        alike = [self.difference(a, c) for a, _, c in groups]
        rays = (np.mean(complements) + np.mean(alike)) / 4
        others = [self.difference(p, q) for g, h in itertools.combinations(groups, 2) for p in g for q in h]
        all_noise = np.mean(others) / 2
        error = np.mean([self.difference(p, truth) for group in groups for p in group])
        return rays, all_noise - rays, error - noise - all_noise


def rows_of(scene, options, folder):
    halves = Truth(scene, options.truth_samples).halves
    truth = sum(half.astype(np.float64) for half in halves) / 2
    photons = ["--photons", str(options.photons)]

    def pictures(options_of_all, samples):
        return [parts_of(scene, options_of_all, samples, seed, folder) for seed in range(1, options.seeds + 1)]

    filtered = pictures(photons, options.samples)
    unfiltered = pictures([*photons, "--filter", "off"], MORE_SAMPLES * options.samples)
    for name in ("pixels", "blocks"):
        measure = Measure(truth, name == "blocks", [p for group in filtered for p in group])
        noise = measure.difference(*halves) / 4
        rays, noise_of_photons, bias = measure.split(filtered, truth, noise)
        *_, of_photons = measure.split(unfiltered, truth, noise)
        whole = rays + noise_of_photons + bias
        parts = (whole, rays, noise_of_photons, of_photons, bias - of_photons)
        known = (True,) * len(parts) if whole > noise else (False, True, True, False, False)
        cells = " | ".join(f"{part * 1e6:.1f}" if is_known else "-" for part, is_known in zip(parts, known))
        print(f"{scene:14} {name:8} {cells}", flush=True)
        yield f"| {scene} | {name} | {cells} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--photons", type=int, default=500000)
    parser.add_argument("--truth-samples", type=int, default=2048, help="of the path tracer, in both renders")
    parser.add_argument("--seeds", type=int, default=2, help="at least 2")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=list(DEFAULT_SCENES), help=f"of {', '.join(SIZES)}")
    options = parser.parse_args()
    if unknown := set(options.scenes) - set(SIZES):
        sys.exit(f"tables_split: there is no scene {', '.join(sorted(unknown))}; there are {', '.join(SIZES)}")
    for folder in (tables_truth.CACHE, os.path.dirname(RESULTS)):
        os.makedirs(folder, exist_ok=True)
    head = ["# Each scene's squared error split", "",
            f"Of pictures of {options.samples} samples and {options.photons} photons, against {options.truth_samples} samples of the path",
            f"tracer, in millionths, by {options.seeds} seeds. Written by `bench/tables_split.py`, which says how.", "",
            *table_head(["scene", "error of", "squared error", "noise of rays", "noise of photons", "bias of photons",
                         "bias of the filter"])]
    names = [name for name in options.scenes if path_of(name).startswith("builtin:") or os.path.exists(path_of(name))]
    rows = tables_truth.kept_rows(head, names, RESULTS)
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            rows += rows_of(name, options, folder)
            with open(RESULTS, "w", encoding="utf-8") as file:
                file.write("\n".join(head + rows) + "\n")


if __name__ == "__main__":
    main()
