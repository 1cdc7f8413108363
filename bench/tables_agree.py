#!/usr/bin/env python3
"""Compares sensors, pictures and paths in places that are hard for one of them: a light shelf in the sun, a mirrored pipe,
solid glazing, blinds: bench/results/agree.md.

usage: tables_agree.py [PROGRAM]
"""
import csv
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from figures import luminance
from tables_sensors import HEAD, SKY, blinds, grey, quad

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, os.path.join(ROOT, "build/release/python"))
import glowworm  # noqa: E402

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/bin/glowworm"
SEEDS = 4
WATT = 179  # lm
RADIANCE = 30  # of the sky
SUN = 'LightSource "distant" "rgb L" [500 500 500] "point3 from" [%s] "point3 to" [0 0 0]\n'
MIRROR = 'Material "conductor" "rgb reflectance" [%g %g %g] "float roughness" 0\n'
# By Schlick's term, as mirrors of OBJ and glTF files.
WHITENING_MIRROR = 'Material "metallicroughness" "rgb reflectance" [%g %g %g] "float metallic" 1 "float roughness" 0\n'
GLASS = 'Material "dielectric" "float eta" 1.5\n'
RADIUS, LENGTH, REFLECTANCE = 0.15, 3, 0.95  # of the pipes, round and square
INNER = 0.98 * RADIUS  # places beside the facets do not count
FACETS = 64
SENSORS = 300
RAYS = 4_000_000  # of a value by hand
PIXELS = 96  # along a side of a picture: those with their middle within INNER do not reach over the pipe's wall
# Name and options of each way to measure, and of each to render.
MEASURES = (("sensors", []), ("by photons", ["--integrator", "gather"]), ("by paths", ["--integrator", "path"]))
PICTURES = (("picture", ["--samples", "8"]), ("path-traced", ["--integrator", "path", "--samples", "128"]))


def room_with_window():
    """4 x 3 x 6 m with a window in z = 6."""
    x, y, z = 4, 3, 6
    text = grey(0.2) + quad((0, 0, 0), (0, 0, z), (x, 0, z), (x, 0, 0))
    text += grey(0.7) + quad((0, y, 0), (x, y, 0), (x, y, z), (0, y, z))
    text += grey(0.5) + quad((0, 0, 0), (x, 0, 0), (x, y, 0), (0, y, 0)) + quad((0, 0, z), (0, 0, 0), (0, y, 0), (0, y, z))
    text += quad((x, 0, 0), (x, 0, z), (x, y, z), (x, y, 0))
    for a, b, c, d in ((0, 4, 0, 1), (0, 4, 2.8, 3), (0, 0.5, 1, 2.8), (3.5, 4, 1, 2.8)):
        text += quad((b, c, z), (a, c, z), (a, d, z), (b, d, z))
    return text


def light_shelf():
    """A mirror in the window throws the sun on the ceiling."""
    shelf = quad((0.5, 2, 6), (3.5, 2, 6), (3.5, 2, 5.2), (0.5, 2, 5.2))
    return SUN % "0 1 1" + SKY + room_with_window() + MIRROR % (0.9, 0.9, 0.9) + shelf


def solid_glazing():
    """A closed box of glass in the window, and the sun on the floor behind it."""
    (a, b, c), (d, e, f) = (0.5, 1, 5.98), (3.5, 2.8, 6)
    glass = quad((a, b, c), (a, e, c), (d, e, c), (d, b, c)) + quad((a, b, f), (d, b, f), (d, e, f), (a, e, f))
    glass += quad((a, b, c), (d, b, c), (d, b, f), (a, b, f)) + quad((a, e, c), (a, e, f), (d, e, f), (d, e, c))
    glass += quad((a, b, c), (a, b, f), (a, e, f), (a, e, c)) + quad((d, b, c), (d, e, c), (d, e, f), (d, b, f))
    return SUN % "0 1 1" + SKY + room_with_window() + GLASS + glass


def below_pipe():
    """A sheet that transmits half, and is seen from below, in a black surface around the pipe."""
    text = 'Material "diffuse" "rgb reflectance" [0 0 0]\n'
    for low, high in (((-3, -3), (3, -0.2)), ((-3, 0.2), (3, 3)), ((-3, -0.2), (-0.2, 0.2)), ((0.2, -0.2), (3, 0.2))):
        (a, b), (c, d) = low, high
        text += quad((a, 0, b), (a, 0, d), (c, 0, d), (c, 0, b))
    text += 'Material "diffusetransmission" "rgb reflectance" [0 0 0] "rgb transmittance" [0.5 0.5 0.5]\n'
    return text + quad((-0.2, 0, -0.2), (-0.2, 0, 0.2), (0.2, 0, 0.2), (0.2, 0, -0.2))


def pipe(mirror, outline):
    """A pipe from the sky, of mirrors, around an outline in the plan."""
    text = SKY + mirror % (REFLECTANCE, REFLECTANCE, REFLECTANCE)
    for (ax, az), (bx, bz) in zip(outline, outline[1:] + outline[:1]):
        text += quad((ax, 0, az), (bx, 0, bz), (bx, LENGTH, bz), (ax, LENGTH, az))
    return text + below_pipe()


def radius_of_facets():
    """To their edges: they enclose the area of the circle."""
    return RADIUS * math.sqrt(2 * math.pi / FACETS / math.sin(2 * math.pi / FACETS))


def mirrored_pipe():
    """A round pipe."""
    turns, radius = [2 * math.pi * i / FACETS for i in range(FACETS)], radius_of_facets()
    return pipe(MIRROR, [(radius * math.cos(t), radius * math.sin(t)) for t in turns])


def square_pipe():
    """A square pipe of mirrors that whiten towards grazing angles."""
    return pipe(WHITENING_MIRROR, [(RADIUS, RADIUS), (-RADIUS, RADIUS), (-RADIUS, -RADIUS), (RADIUS, -RADIUS)])


def sunny_blinds():
    """The room behind blinds, in the sun."""
    return SUN % "-1 1 0.3" + blinds().removeprefix(HEAD)


class EvenNumbers:
    """Points of a unit cube, spread evenly by the powers of a root (M. Roberts, "The Unreasonable Effectiveness of
    Quasirandom Sequences", 2018)."""

    def __init__(self, dimensions, shift=0):
        self.root, self.power, self.shift = 2.0, 0, shift
        for _ in range(64):
            self.root = (1 + self.root) ** (1 / (dimensions + 1))

    def random(self, count):
        """Their next coordinate."""
        self.power += 1
        return (self.shift + np.arange(1, count + 1) * self.root**-self.power) % 1


def directions(count, numbers):
    """Even ones, as an even sky gives light to a plane: sines and cosines from its normal, and azimuths."""
    sin2 = numbers.random(count)
    return np.sqrt(sin2), np.sqrt(1 - sin2), 2 * math.pi * numbers.random(count)


def share_of_pipe(reflectance, most=INNER):
    """Transmittance of a round pipe of mirrors, under an even sky, to what is within a radius. reflectance: by cosine"""
    numbers = EvenNumbers(4)
    r = most * np.sqrt(numbers.random(RAYS))
    sine, cosine, turn = directions(RAYS, numbers)
    across = LENGTH * sine / cosine  # way in the plan
    b = r * np.sin(turn)
    half = np.sqrt(RADIUS**2 - b**2)
    first = half - r * np.cos(turn)
    bounces = np.where(across < first, 0, 1 + np.floor((across - first) / (2 * half)))
    return float(np.mean(reflectance(sine * half / RADIUS) ** bounces))


def share_of_facets(reflectance, most=INNER):
    """The same of the round pipe with the facets of the scene."""
    numbers = EvenNumbers(4)
    rays = RAYS // 10
    r, around = most * np.sqrt(numbers.random(rays)), 2 * math.pi * numbers.random(rays)
    place = r * np.array([np.cos(around), np.sin(around)])
    sine, cosine, turn = directions(rays, numbers)
    way, left, share = np.array([np.cos(turn), np.sin(turn)]), LENGTH * sine / cosine, np.ones(rays)
    turns = 2 * math.pi * (np.arange(FACETS) + 0.5) / FACETS
    normals = np.array([np.cos(turns), np.sin(turns)]).T
    distance = radius_of_facets() * math.cos(math.pi / FACETS)
    inside = np.arange(rays)
    while len(inside):
        nearest, facet = np.full(len(inside), np.inf), np.zeros(len(inside), int)
        for k, normal in enumerate(normals):
            to = normal @ way[:, inside]
            with np.errstate(divide="ignore", invalid="ignore"):
                here = np.where(to > 1e-12, np.maximum(distance - normal @ place[:, inside], 0) / to, np.inf)
            facet[here < nearest] = k
            nearest = np.minimum(nearest, here)
        hits = left[inside] > nearest
        inside, nearest, normal = inside[hits], nearest[hits], normals[facet[hits]].T
        place[:, inside] += nearest * way[:, inside]
        left[inside] -= nearest
        to = np.sum(normal * way[:, inside], axis=0)
        share[inside] *= reflectance(sine[inside] * to)
        way[:, inside] -= 2 * to * normal
        inside = inside[share[inside] > 1e-7]
    return float(np.mean(share))


def share_of_square_pipe(reflectance, most=INNER):
    """The same of a square one, to a square of half that side."""
    numbers = EvenNumbers(5)
    sine, cosine, turn = directions(RAYS, numbers)
    share = np.ones(RAYS)
    for part in (abs(np.cos(turn)), abs(np.sin(turn))):
        start = RADIUS + most * (2 * numbers.random(RAYS) - 1)
        bounces = np.floor((start + part * LENGTH * sine / cosine) / (2 * RADIUS))
        share *= reflectance(part * sine) ** bounces
    return float(np.mean(share))


def schlick(cosine):
    """C. Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994."""
    return REFLECTANCE + (1 - REFLECTANCE) * (1 - cosine) ** 5


def constant(cosine):
    return REFLECTANCE + 0 * cosine


def fresnel(cosine):
    """Of a metal of refractive index 1 and the absorption that makes its reflectance at normal incidence, as pbrt's
    conductors by reflectance are (pbrt-v4, ConductorMaterial)."""
    k = 2 * math.sqrt(REFLECTANCE / (1 - REFLECTANCE))
    index2, cosine2 = complex(1, k) ** 2, cosine**2
    inner = np.sqrt(index2 - (1 - cosine2))
    s = (cosine - inner) / (cosine + inner)
    p = (index2 * cosine - inner) / (index2 * cosine + inner)
    return (abs(s) ** 2 + abs(p) ** 2) / 2


# Name, scene, middle of the places, half their side, normal of sensors, eye, what the surface turns to radiance, and
# illuminance by hand or None.
CASES = (
    ("light shelf, spot on the ceiling", light_shelf, (2, 3, 4.6), 0.1, (0, -1, 0), (2, 1.5, 4.6), 0.7, None),
    ("mirrored pipe, round", mirrored_pipe, (0, 0, 0), RADIUS, (0, 1, 0), (0, -1.5, 0), 0.5,
     WATT * math.pi * RADIANCE * share_of_facets(fresnel)),
    ("mirrored pipe, square", square_pipe, (0, 0, 0), INNER, (0, 1, 0), (0, -1.5, 0), 0.5,
     WATT * math.pi * RADIANCE * share_of_square_pipe(schlick)),
    ("solid glazing, in the sun", solid_glazing, (2, 0, 4.2), 0.1, (0, 1, 0), (2, 1.5, 4.2), 0.2, None),
    ("blinds in the sun", sunny_blinds, (3, 0, 2), 0.3, (0, 1, 0), (3, 1.5, 2), 0.2, None),
)


def inside(x, z, half):
    """Whether a place counts: pipes are round."""
    return half != RADIUS or x * x + z * z < INNER**2


def measured(folder, case, options, seed):
    _, _, (x, y, z), half, normal, _, _, _ = case
    # No grid: slats and their shadows repeat.
    numbers = EvenNumbers(2, np.random.default_rng(seed).random())
    offsets = [half * (2 * numbers.random(SENSORS) - 1) for _ in range(2)]
    places = [(x + a, y + 1e-4 * normal[1], z + b) for a, b in zip(*offsets) if inside(a, b, half)]
    (folder / "p.pts").write_text("".join("%g %.5f %g %g %g %g\n" % (*p, *normal) for p in places), encoding="utf-8")
    subprocess.run([PROGRAM, "measure", folder / "scene.pbrt", "--points", folder / "p.pts", "-o", folder / "e.csv", "-q",
                    "--noise", "2%", "--time", "30s", "--seed", str(seed), *options], check=True)
    rows = csv.DictReader(line for line in (folder / "e.csv").open(encoding="utf-8") if line[0] != "#")
    return np.mean([float(row["E_lx"]) for row in rows])


def rendered(folder, case, options, seed):
    _, _, middle, half, _, eye, share, _ = case
    angle = 2 * math.degrees(math.atan(half / 1.5))
    up = "0,0,1"
    subprocess.run([PROGRAM, "render", folder / "scene.pbrt", "--view", ",".join(map(str, (*eye, *middle))) + "," + up,
                    "--fov", str(angle), "--size", f"{PIXELS}x{PIXELS}", "-o", folder / "p.exr", "-q", "--seed", str(seed),
                    "--precision", "float", *options], check=True)
    values = luminance(glowworm.Picture.read(str(folder / "p.exr"))["image"].reshape(PIXELS, PIXELS, -1)[..., :3])
    steps = [half * (2 * (i + 0.5) / PIXELS - 1) for i in range(PIXELS)]
    return WATT * math.pi / share * np.mean([values[i, k] for i in range(PIXELS) for k in range(PIXELS)
                                             if inside(steps[i], steps[k], half)])


def cell(values):
    return f"{np.mean(values):.4g} +- {np.std(values, ddof=1) / len(values) ** 0.5:.2g}"


def main():
    names = [name for name, _ in MEASURES + PICTURES]
    lines = ["# Agreement", "Written by `bench/tables_agree.py`.", "",
             "Mean illuminance (lx) of a small place, by evenly spread sensors 0.1 mm above it and by pictures of it, and the "
             f"standard error over {SEEDS} seeds. By hand: evenly spread rays that count the reflections in a pipe {LENGTH} m long and "
             f"{2 * RADIUS} m wide, under an even sky. The round one has {FACETS} facets of the metal (pbrt's conductor) that "
             f"reflects {REFLECTANCE} at normal incidence, the square one of a mirror that whitens towards grazing angles (Schlick), as "
             "OBJ and glTF files have it. The second table has what other pipes transmit. Sensors behind blinds are in stripes "
             "of sun and shade, which makes most of their error; all ways have the same places. Pictures are too bright there: "
             "kernels of photons reach over the gaps between slats.", "",
             f"| place | by hand | {' | '.join(names)} |", "| --- | --- |" + " --- |" * len(names)]
    for case in CASES:
        with tempfile.TemporaryDirectory() as text:
            folder = pathlib.Path(text)
            (folder / "scene.pbrt").write_text(HEAD + case[1](), encoding="utf-8")
            row = [cell([of(folder, case, options, seed) for seed in range(SEEDS)])
                   for ways, of in ((MEASURES, measured), (PICTURES, rendered)) for _, options in ways]
        lines.append(f"| {case[0]} | {f'{case[-1]:.4g}' if case[-1] else ''} | {' | '.join(row)} |")
        print(lines[-1], flush=True)
    lines += ["", "| mirrored pipe, all of its end | metal | Schlick | the same reflectance at all angles |",
              "| --- | --- | --- | --- |"]
    for name, share in (("round", share_of_pipe), ("square", share_of_square_pipe)):
        lines.append(f"| {name} | " + " | ".join(f"{share(of, RADIUS):.3f}" for of in (fresnel, schlick, constant)) + " |")
    target = ROOT / "bench/results/agree.md"
    target.parent.mkdir(exist_ok=True)
    target.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
