#!/usr/bin/env python3
"""Errors of filtered pictures over the noise of unfiltered ones: bench/results/filter.md.

Light of the scenes changes within a pixel: lamps 0.5 to 50 mm from ceilings and walls, contact shadows, spots of sun
light. Each is rendered with several numbers of samples and seeds, and filtered by this program and by that of --before,
which get the same samples. The reference is a long render without filter. The path tracer checks it: the first table has
the mean of the reference over that of the path tracer, of all pixels and of those near steep light. These lie within six
pixels of one whose samples deviate by more than their mean.

A pixel's error is the root mean square over the seeds. Its noise is that of the unfiltered picture: the deviation of the
reference's samples over the root of their number in the picture, the unfiltered error over the same seeds, or 1% of the
pixel's radiance, whichever is largest. The second table has the largest error over noise, the error over noise that 1% of
the pixels exceed, the mean near steep light over that of the unfiltered picture, and the relative error of the picture.

References and samples stay in build/filter/, and are made where they are missing.

usage: tables_filter.py [--before PROGRAM] [--seeds N] [SCENE...]
"""
import argparse
import os
import subprocess
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "build/release/python"))
import glowworm  # noqa: E402

from figures import luminance  # noqa: E402

PROGRAM = os.path.join(ROOT, "build/release/bin/glowworm")
CACHE = os.path.join(ROOT, "build/filter")
RESULTS = os.path.join(ROOT, "bench/results/filter.md")
SIZE = "64x48"
SAMPLES = (2, 4, 8, 16, 32)
REFERENCE_SAMPLES, PATHS = 256, 512
LEAST_NOISE = 0.01
NEAR = 6  # pixels


def quad(a, b, c, d):
    """A rectangle of four corners in order."""
    points = " ".join(f"{v:g}" for corner in (a, b, c, d) for v in corner)
    return f'Shape "trianglemesh" "point3 P" [{points}] "integer indices" [0 1 2 0 2 3]\n'


def box(low, high):
    (x, y, z), (u, v, w) = low, high
    corners = [(x, y, z), (u, y, z), (u, v, z), (x, v, z), (x, y, w), (u, y, w), (u, v, w), (x, v, w)]
    faces = [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (3, 2, 6, 7), (0, 3, 7, 4), (1, 2, 6, 5)]
    return "".join(quad(*(corners[i] for i in face)) for face in faces)


def lamp(a, b, c, d, radiance=100):
    return ('AttributeBegin\nMaterial "diffuse" "rgb reflectance" [0 0 0]\n'
            f'AreaLightSource "diffuse" "rgb L" [{radiance} {radiance} {radiance}] "bool twosided" [true]\n'
            + quad(a, b, c, d) + "AttributeEnd\n")


def room(look_at, content, fov=50):
    """A room of 4 x 2.5 x 5 m."""
    return (f'LookAt {look_at} 0 1 0\nCamera "perspective" "float fov" [{fov}]\n'
            'WorldBegin\nMaterial "diffuse" "rgb reflectance" [0.6 0.6 0.6]\n'
            + box((-2, 0, -2), (2, 2.5, 3)) + content)


def under_ceiling(distance):
    y = 2.5 - distance
    return room("0 1.2 2.8 0 2.2 -1", lamp((-0.3, y, -0.3), (0.3, y, -0.3), (0.3, y, 0.3), (-0.3, y, 0.3)))


def beside_wall(distance, look_at="0 1.2 1.2 0.2 1.3 -2"):
    z = -2 + distance
    return room(look_at, lamp((-0.3, 1, z), (0.3, 1.1, z), (0.2, 1.7, z), (-0.4, 1.6, z)))


# A table whose top and feet lie close to a floor, below a small lamp; a board with holes in the sun.
CONTACT = room("0 1 1.5 0 0 -0.6",
               box((-0.5, 0.004, -0.9), (0.1, 0.06, -0.4)) + box((0.3, 0, -0.7), (0.5, 0.3, -0.5))
               + lamp((0.6, 2, 0.2), (0.7, 2, 0.2), (0.7, 2, 0.3), (0.6, 2, 0.3), 1500))


def board_with_holes(y, holes, low=-2, high=2):
    """A horizontal board of strips along z, with slits of given places and widths along x."""
    edges = [low]
    for place, width in holes:
        edges += [place, place + width]
    edges.append(high)
    return "".join(quad((a, y, low), (b, y, low), (b, y, high), (a, y, high))
                   for a, b in zip(edges[::2], edges[1::2]))


SUN = ('LookAt 0 1.2 1.5 0 0 -0.6 0 1 0\nCamera "perspective" "float fov" [50]\nWorldBegin\n'
       'LightSource "distant" "rgb L" [60 60 60] "point3 from" [0.3 3 0.2] "point3 to" [0 0 0]\n'
       'LightSource "infinite" "rgb L" [0.5 0.5 0.5]\nMaterial "diffuse" "rgb reflectance" [0.6 0.6 0.6]\n'
       + quad((-2, 0, -2), (2, 0, -2), (2, 0, 2), (-2, 0, 2))
       + board_with_holes(1.5, [(-0.5, 0.002), (-0.2, 0.02), (0.1, 0.1), (0.6, 0.005)]))

SCENES = {
    "ceiling-0.5mm": under_ceiling(0.0005),
    "ceiling-2mm": under_ceiling(0.002),
    "ceiling-10mm": under_ceiling(0.01),
    "ceiling-50mm": under_ceiling(0.05),
    "wall-1mm": beside_wall(0.001),
    "wall-5mm": beside_wall(0.005),
    "contact": CONTACT,
    "sun": SUN,
}


def run(*command):
    subprocess.run([*map(str, command), "--quiet"], check=True)


def picture(name, file, *options):
    """A picture of a scene from the cache, rendered with these options if it is not there."""
    path = os.path.join(CACHE, f"{name}-{SIZE}-{file}")
    if not os.path.exists(path):
        scene = os.path.join(CACHE, name + ".pbrt")
        with open(scene, "w", encoding="utf-8") as out:
            out.write(SCENES[name])
        to = ["--precision", "float"] if path.endswith(".exr") else []
        run(PROGRAM, "render", scene, "--size", SIZE, "-o", path, *to, *options)
    return path


def grown(mask, reach):
    """Pixels at most that many steps from one of the mask, along rows and columns."""
    for axis in (0, 1):
        mask = np.any([np.roll(np.pad(mask, reach), step, axis) for step in range(-reach, reach + 1)], axis=0)
        mask = mask[reach:-reach, reach:-reach]
    return mask


class Reference:
    def __init__(self, name):
        file = picture(name, "reference.exr", "--samples", REFERENCE_SAMPLES, "--filter", "off", "--aov", "noise",
                       "--photons", 500000, "--seed", 999)
        layers = glowworm.Picture.read(file)
        self.image = luminance(layers["image"])
        self.spread = np.squeeze(layers["noise"]) * REFERENCE_SAMPLES**0.5
        self.steep = self.spread > self.image
        self.near = grown(self.steep, NEAR) & ~self.steep & (self.image < 10 * np.median(self.image))

    def noise(self, samples, unfiltered):
        own = np.sqrt(np.mean((unfiltered - self.image) ** 2, axis=0))
        return np.maximum.reduce([self.spread / samples**0.5, own, LEAST_NOISE * self.image])

    def relative_error(self, pictures):
        scale = self.image**2 + 0.01 * self.image.mean() ** 2
        return np.sqrt(np.mean((pictures - self.image) ** 2 / scale))


def merged(program, part):
    """The filtered and the unfiltered luminance of a part."""
    file = os.path.join(CACHE, "merged.exr")
    run(program, "merge", part, "-o", file, "--precision", "float")
    layers = glowworm.Picture.read(file)
    return luminance(layers["image"]), luminance(layers["unfiltered"])


def ratio(image, other, mask=True):
    """Mean of an image over that of another, of the pixels of a mask."""
    total = np.sum(other, where=mask)
    return f"{np.sum(image, where=mask) / total:.3f}" if total > 0 else "-"


def check_row(name):
    reference = Reference(name)
    paths = luminance(glowworm.Picture.read(picture(
        name, "paths.exr", "--integrator", "path", "--samples", PATHS, "--seed", 5))["image"])
    near = ratio(reference.image, paths, reference.near)
    return f"| {name} | {ratio(reference.image, paths)} | {near} | {reference.near.mean():.0%} |"


def rows(name, programs, seeds):
    reference = Reference(name)
    for samples in SAMPLES:
        parts = [picture(name, f"{samples}-{seed}.part", "--samples", samples, "--seed", seed, "--photons", 100000,
                         "--aov", "unfiltered", "--part", "1/1") for seed in range(1, seeds + 1)]
        cells = []
        for program in programs:
            filtered, unfiltered = map(np.array, zip(*(merged(program, part) for part in parts)))
            over = np.sqrt(np.mean((filtered - reference.image) ** 2, axis=0)) / reference.noise(samples, unfiltered)
            near = ratio(filtered.mean(axis=0), unfiltered.mean(axis=0), reference.near)
            cells.append((f"{over.max():.1f}", f"{np.percentile(over, 99):.2f}", near,
                          f"{reference.relative_error(filtered):.4f}"))
        columns = [" | ".join(column) for column in zip(*cells)]
        yield f"| {name} | {samples} | " + " | ".join(columns) + f" | {reference.relative_error(unfiltered):.4f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", metavar="PROGRAM")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=list(SCENES))
    options = parser.parse_args()
    os.makedirs(CACHE, exist_ok=True)
    os.makedirs(os.path.dirname(RESULTS), exist_ok=True)
    programs = [options.before, PROGRAM] if options.before else [PROGRAM]
    names = ("before", "now") if options.before else ("now",)
    columns = [f"{column}, {when}" for column in ("largest", "1% exceed", "near", "relative error") for when in names]
    lines = ["# Errors of filtered pictures over the noise of unfiltered ones", "",
             f"Written by `bench/tables_filter.py`, which says what the columns are: pictures of {SIZE} pixels, "
             f"{options.seeds} seeds.", "", "| scene | reference over paths | near | pixels near |",
             "| --- |" + " ---: |" * 3]
    for name in options.scenes:
        lines.append(check_row(name))
        print(lines[-1], flush=True)
    lines += ["", "| scene | samples | " + " | ".join(columns) + " | relative error, unfiltered |",
              "| --- |" + " ---: |" * (len(columns) + 2)]
    for name in options.scenes:
        for line in rows(name, programs, options.seeds):
            lines.append(line)
            print(line, flush=True)
    with open(RESULTS, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
