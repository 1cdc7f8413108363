#!/usr/bin/env python3
"""Scenes of many instances, kept and expanded: memory, time and pictures. Writes bench/results/instances.md.

The scene is a field of boulders under a sky. Needs python3-numpy.

usage: tables_instances.py [--program PROGRAM] [CASE...]     cases: INSTANCESxTRIANGLES, 1000x100000 for example
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench/results/instances.md"
CASES = ["10000x12", "10000x100", "1000x1000", "100x20000", "1000x100000"]
MOST_EXPANDED = 3_000_000  # triangles; more do not fit into every machine
HEAD = """# Instances

Written by `bench/tables_instances.py`. The first place of a boulder is a copy of its mesh.

A field of boulders under a sky, 320 x 240 pixels with one sample, loading included; {cores} cores, which others shared.
The difference is relRMSE of both pictures, and of two seeds (`glowworm compare`).

| boulders | triangles of each | instances | s | processor s | peak MB | difference | of two seeds |
| ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: |
"""


def boulder(triangles):
    """A closed mesh with about that many triangles: vertices and indices."""
    rings = max(2, int((triangles / 4) ** 0.5 + 0.5))
    columns = 2 * rings
    v, u = numpy.mgrid[0 : rings + 1, 0 : columns + 1]
    theta, phi = numpy.pi * v / rings, 2 * numpy.pi * u / columns
    radius = 1 + 0.15 * numpy.sin(5 * phi) * numpy.sin(theta) ** 2 + 0.1 * numpy.cos(7 * theta)
    points = numpy.stack([radius * numpy.sin(theta) * numpy.cos(phi), radius * numpy.cos(theta),
                          -radius * numpy.sin(theta) * numpy.sin(phi)], -1).reshape(-1, 3)
    at = lambda j, i: j * (columns + 1) + i  # noqa: E731
    corners = []
    for j in range(rings):
        for i in range(columns):
            a, b, c, d = at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)
            corners += [(a, b, c), (a, c, d)]
    return points.astype("<f4"), numpy.array(corners, "<i4")


def write_ply(path, points, corners):
    faces = numpy.empty(len(corners), [("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, corners
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
              f"property float z\nelement face {len(corners)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + points.tobytes() + faces.tobytes())


def write_scene(folder, instances, triangles):
    points, corners = boulder(triangles)
    write_ply(folder / "boulder.ply", points, corners)
    random = numpy.random.default_rng(1)
    side = 2.5 * instances**0.5
    lines = ["LookAt 0 6 %g 0 0 %g 0 1 0" % (0.45 * side + 6, 0.2 * side), 'Camera "perspective" "float fov" 50',
             "WorldBegin", 'LightSource "infinite" "rgb L" [0.4 0.5 0.7]',
             'LightSource "distant" "point3 from" [1 2 1] "rgb L" [3 2.8 2.5]',
             'Material "diffuse" "rgb reflectance" [0.4 0.35 0.3]',
             'Shape "bilinearmesh" "point3 P" [%g 0 %g  %g 0 %g  %g 0 %g  %g 0 %g]'
             % (-side, side, side, side, -side, -side, side, -side),
             'ObjectBegin "boulder"', 'Material "diffuse" "rgb reflectance" [0.6 0.5 0.35]',
             'Shape "plymesh" "string filename" "boulder.ply"', "ObjectEnd"]
    for x, z in random.uniform(-side / 2, side / 2, (instances, 2)):
        a, b, c = random.uniform(0.3, 0.9, 3)
        turn, mirror = random.uniform(0, 360), random.choice([-1, 1])
        lines.append(f"AttributeBegin Translate {x:g} {0.5 * b:g} {z:g} Rotate {turn:g} 0.3 1 0.1 "
                     f'Scale {mirror * a:g} {b:g} {c:g} ObjectInstance "boulder" AttributeEnd')
    path = folder / "field.pbrt"
    path.write_text("\n".join(lines) + "\n")
    return path, len(corners)


def render(program, scene, picture, *options):
    """Seconds, processor seconds and peak memory in MB."""
    command = [program, "render", scene, "-o", picture, "--size", "320x240", "--samples", "1", "--quiet", *options]
    started = time.monotonic()
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{command} failed")
    return time.monotonic() - started, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1000


def difference(program, a, b):
    out = subprocess.run([program, "compare", a, b, "--json"], stdout=subprocess.PIPE, text=True).stdout
    return json.loads(out)["relative_rmse"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/glowworm"))
    parser.add_argument("cases", nargs="*", default=CASES)
    o = parser.parse_args()
    rows = []
    for case in o.cases:
        instances, triangles = map(int, case.split("x"))
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            scene, count = write_scene(folder, instances, triangles)
            kept = render(o.program, scene, folder / "kept.exr")
            cells = [(f"| {instances} | {count} | kept | %.1f | %.1f | %.0f |" % kept)]
            if instances * count <= MOST_EXPANDED:
                expanded = render(o.program, scene, folder / "expanded.exr", "--instances", "expand")
                render(o.program, scene, folder / "other.exr", "--seed", "7")
                cells[0] += (f" {difference(o.program, folder / 'expanded.exr', folder / 'kept.exr'):.5f} |"
                             f" {difference(o.program, folder / 'other.exr', folder / 'kept.exr'):.5f} |")
                cells.append(f"| {instances} | {count} | expanded | %.1f | %.1f | %.0f | | |" % expanded)
            else:
                cells[0] += " | |"
            rows += cells
            print("\n".join(cells), flush=True)
    RESULTS.write_text(HEAD.format(cores=os.cpu_count()) + "\n".join(rows) + "\n")


main()
