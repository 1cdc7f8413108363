#!/usr/bin/env python3
"""Measures sensors in an open office and in hard places, by the program's own choice, by paths and by photons, on one
thread: bench/results/sensors.md.

usage: tables_sensors.py [PROGRAM]
"""
import csv
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

from figures import processor_seconds

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/bin/glowworm"
COUNTS = (1, 10, 100)
WAYS = (("chosen", []), ("paths", ["--integrator", "path"]), ("photons", ["--integrator", "gather"]))
HEAD = 'Camera "perspective"\nWorldBegin\n'
SKY = 'LightSource "infinite" "rgb L" [30 30 30]\n'


def grey(reflectance):
    return f'Material "diffuse" "rgb reflectance" [{reflectance} {reflectance} {reflectance}]\n'


def quad(*corners):
    places = " ".join("%g %g %g" % corner for corner in corners)
    return f'Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [{places}]\n'


def room(x, y, z, walls="lrfb", ceiling=True):
    """The inside of a box from the origin, of reflectances 0.2, 0.5 and 0.7."""
    sides = {"f": ((0, 0, 0), (x, 0, 0), (x, y, 0), (0, y, 0)), "b": ((x, 0, z), (0, 0, z), (0, y, z), (x, y, z)),
             "l": ((0, 0, z), (0, 0, 0), (0, y, 0), (0, y, z)), "r": ((x, 0, 0), (x, 0, z), (x, y, z), (x, y, 0))}
    text = grey(0.2) + quad((0, 0, 0), (0, 0, z), (x, 0, z), (x, 0, 0))
    if ceiling:
        text += grey(0.7) + quad((0, y, 0), (x, y, 0), (x, y, z), (0, y, z))
    return text + grey(0.5) + "".join(quad(*sides[name]) for name in walls)


def office():
    text = HEAD + room(10, 3, 8)
    for x in (1.25, 3.75, 6.25, 8.75):
        for z in (1.4, 4, 6.6):
            lamp = quad((x - 0.6, 2.98, z - 0.15), (x + 0.6, 2.98, z - 0.15), (x + 0.6, 2.98, z + 0.15),
                        (x - 0.6, 2.98, z + 0.15))
            text += f'AttributeBegin\nAreaLightSource "diffuse" "rgb L" [20 20 20]\n{lamp}AttributeEnd\n'
    return text


def well():
    return HEAD + SKY + room(2, 12, 2, ceiling=False)


def pipe():
    """A room below a mirrored pipe of radius 0.15 and length 3, reflectance 0.95."""
    text = HEAD + SKY + room(4, 2.5, 4, ceiling=False) + grey(0.7)
    circle = [(math.cos(2 * math.pi * i / 32), math.sin(2 * math.pi * i / 32)) for i in range(33)]
    shell = ""
    for (px, pz), (qx, qz) in zip(circle, circle[1:]):
        k, l = 2 / max(abs(px), abs(pz)), 2 / max(abs(qx), abs(qz))
        inner = [(2 + 0.15 * px, 2 + 0.15 * pz), (2 + 0.15 * qx, 2 + 0.15 * qz)]
        (ax, az), (bx, bz) = inner
        text += quad((ax, 2.5, az), (2 + k * px, 2.5, 2 + k * pz), (2 + l * qx, 2.5, 2 + l * qz), (bx, 2.5, bz))
        shell += quad((ax, 2.5, az), (bx, 2.5, bz), (bx, 5.5, bz), (ax, 5.5, az))
    return text + 'Material "conductor" "rgb reflectance" [0.95 0.95 0.95] "float roughness" 0\n' + shell


def blinds():
    """A room with slats of 7 cm, 5 cm apart, in its window."""
    text = HEAD + SKY + room(6, 3, 4, walls="rfb") + grey(0.5) + quad((0, 0, 4), (0, 0, 0), (0, 1, 0), (0, 1, 4))
    text += grey(0.7)
    for i in range(40):
        y = 1 + 0.05 * i
        text += quad((0, y + 0.03, 0), (0, y + 0.03, 4), (-0.06, y - 0.01, 4), (-0.06, y - 0.01, 0))
    return text


# Name, scene, the sides of the area of sensors, and their height.
SCENES = (("open office", office, (10, 8), 0.8), ("well of 2 x 2 x 12 m", well, (2, 2), 0.1),
          ("below a mirrored pipe", pipe, (4, 4), 0.8), ("behind blinds", blinds, (6, 4), 0.8))


def write_case(folder, scene, sides, height, count):
    """Writes scene.pbrt, and points.pts with so many sensors that face upwards."""
    random.seed(1)
    (folder / "scene.pbrt").write_text(scene(), encoding="utf-8")
    x, z = sides
    (folder / "points.pts").write_text("".join(
        f"{x * random.uniform(0.1, 0.9):.4f} {height} {z * random.uniform(0.1, 0.9):.4f} 0 1 0\n"
        for _ in range(count)), encoding="utf-8")


def measure(folder, options):
    """Returns processor seconds, relative error (root of the mean square over sensors), mean lx and the method."""
    before = processor_seconds()
    subprocess.run([PROGRAM, "measure", folder / "scene.pbrt", "--points", folder / "points.pts", "-o",
                    folder / "out.csv", "--stats", folder / "stats.json", "--threads", "1", "-q", *options], check=True)
    seconds = processor_seconds() - before
    rows = list(csv.DictReader(line for line in (folder / "out.csv").open(encoding="utf-8") if line[0] != "#"))
    error = math.sqrt(sum(float(row["relative_error"]) ** 2 for row in rows) / len(rows))
    settings = json.loads((folder / "stats.json").read_text(encoding="utf-8"))["settings"]
    method = "paths" if settings["integrator"] == "path" else "passes of photons"
    return seconds, error, sum(float(row["E_lx"]) for row in rows) / len(rows), f"{settings['samples']} {method}"


def main():
    lines = ["# Sensors", "Written by `bench/tables_sensors.py`. Processor seconds on one thread, with the start of the "
             "program. The last column is the processor time for the same variance, over that of path tracing.", "",
             "| scene | sensors | method | samples | CPU s | relative error | mean, lx | time for the same error |",
             "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for name, scene, sides, height in SCENES:
        for count in COUNTS:
            with tempfile.TemporaryDirectory() as text:
                folder = pathlib.Path(text)
                write_case(folder, scene, sides, height, count)
                found = [(way, *measure(folder, options)) for way, options in WAYS]
            cost_of_paths = found[1][1] * found[1][2] ** 2
            for way, seconds, error, mean, samples in found:
                lines.append(f"| {name} | {count} | {way} | {samples} | {seconds:.2f} | {100 * error:.2f}% | {mean:.4g} "
                             f"| {seconds * error**2 / cost_of_paths:.2g} |")
                print(lines[-1], flush=True)
    target = ROOT / "bench/results/sensors.md"
    target.parent.mkdir(exist_ok=True)
    target.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
