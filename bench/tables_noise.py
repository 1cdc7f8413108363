#!/usr/bin/env python3
"""The error that renders with --noise predict, and their true error: bench/results/noise.md.

Each scene is rendered to several targets with several seeds; the table has root mean squares over the seeds. The true
error is that of the pixels' luminance against two renders of other seeds with many photons, whose noise would be alike in
a whole region of a small picture: the sum of their unfiltered layers, with the emission of surface samples. It is relative
as the predicted one is (relative_error() in src/film/filtered.h). Both include the noise of the photons, which all
samples share; the true error also includes what the filter blurs. The last column has the share of the worst 1% of the
pixels in the square of the true error.

A second table sets the layer `noise` against the spread of sixteen renders of other samples with the same photons. Their
chi-squared is the sum over renders of (pixel - mean)^2 / noise^2, of 15 degrees of freedom.

References stay in build/noise/, and are made where they are missing.

usage: tables_noise.py [--samples N] [SCENE...]     scenes of ../shared are left out where there are none
"""
import argparse
import os
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "build/release/python"))
import glowworm  # noqa: E402

from figures import luminance  # noqa: E402
from tables_equal_time import SCENES, path_of  # noqa: E402

CACHE = os.path.join(ROOT, "build/noise")
TARGETS = (0.1, 0.05, 0.025)
REFERENCE_PHOTONS = 8_000_000
SEEDS = (11, 12, 13, 14)  # of the pictures
RENDERS, SAMPLES = 16, 16
# The median and the 99.9% quantile of chi-squared of 15 degrees of freedom.
MEDIAN, RARE = 14.339, 37.697


def reference(name, scene, seed, **settings):
    """Luminance of all layers of light. That of emission is by surface samples, which have little noise behind glass."""
    path = os.path.join(CACHE, f"{name}-{settings['size']}-{settings['samples']}-{seed}.npy")
    if not os.path.exists(path):
        layers = ("emitted", "direct", "indirect", "caustic")
        picture = glowworm.render(scene, photons=REFERENCE_PHOTONS, aov=",".join(layers), seed=seed, **settings)
        os.makedirs(CACHE, exist_ok=True)
        np.save(path, luminance(sum(picture[layer] for layer in layers)))
    return np.load(path)


def relative_squares(image, references):
    """Relative squared errors of the image's pixels. Each is the product of the differences from two independent
    references, in which their noise cancels on average."""
    mean = sum(references) / 2
    return ((image - references[0]) * (image - references[1]) / (mean**2 + 0.01 * mean.mean() ** 2)).ravel()


def root_mean_square(values):
    return np.sqrt(np.mean(np.square(values)))


def rows(name, samples):
    """One row for each target."""
    scene = glowworm.Scene.load(path_of(name))
    settings = {"size": SCENES[name][1], "samples": samples, "progress": False}
    references = [reference(name, scene, seed, **settings) for seed in (1, 2)]
    for target in TARGETS:
        pictures = [glowworm.render(scene, noise=target, seed=seed, **settings) for seed in SEEDS]
        predicted = root_mean_square([float(picture.metadata["glowworm:relative_error"]) for picture in pictures])
        squares = np.sort(np.mean([relative_squares(luminance(p["image"]), references) for p in pictures], axis=0))
        total = max(squares.sum(), 1e-9)
        true, worst = (total / len(squares)) ** 0.5, min(squares[int(0.99 * len(squares)):].sum() / total, 1)
        mean = np.mean([picture.statistics["mean_samples"] for picture in pictures])
        yield f"| {name} | {target} | {mean:.1f} | {predicted:.4f} | {true:.4f} | {predicted / true:.2f} | {worst:.0%} |"


def spread_row(name):
    """Of renders that have their samples from parts of one picture, so the same photons."""
    scene = glowworm.Scene.load(path_of(name))
    pictures = [glowworm.render(scene, samples=RENDERS * SAMPLES, part=f"{i + 1}/{RENDERS}", size=SCENES[name][1],
                                aov="noise", progress=False) for i in range(RENDERS)]
    variance = np.var([luminance(p["image"]) for p in pictures], axis=0, ddof=1)
    predicted = np.mean([np.square(p["noise"]) for p in pictures], axis=0).reshape(variance.shape)
    noisy = predicted > 0
    chi_squared = (RENDERS - 1) * variance[noisy] / predicted[noisy]
    return f"| {name} | {np.median(chi_squared) / MEDIAN:.2f} | {np.mean(chi_squared > RARE):.1%} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=128)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=list(SCENES))
    options = parser.parse_args()
    lines = ["# Predicted and true error of renders with --noise", "", "Made by `bench/tables_noise.py`, which says how.", "",
             "| scene | --noise | samples a pixel | predicted | true | predicted / true | share of the worst 1% |", "| --- |" + " --- |" * 6]
    scenes = [name for name in options.scenes if path_of(name).startswith("builtin:") or os.path.exists(path_of(name))]
    for name in scenes:
        for line in rows(name, options.samples):
            lines.append(line)
            print(line, flush=True)
    lines += ["", f"Chi-squared of {RENDERS} renders of {SAMPLES} samples (0.1% of normal numbers are above that quantile):",
              "", "| scene | median / its expectation | above the 99.9% quantile |", "| --- | --- | --- |"]
    for name in scenes:
        lines.append(spread_row(name))
        print(lines[-1], flush=True)
    results = os.path.join(ROOT, "bench/results/noise.md")
    os.makedirs(os.path.dirname(results), exist_ok=True)
    with open(results, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
