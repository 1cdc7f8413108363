#!/usr/bin/env python3
"""Compares irradiance by photon maps with path tracing, with and without boundary correction: bench/results/engines.md.

The points are where gather rays of a picture end. The usual method, which looks for the k nearest photons, divides their
flux by the area of a whole disc; at edges and on small surfaces, part of that disc is empty.

usage: tables_engines.py [SCENE...]     built-in scenes
"""
import os
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "build/release/python"))
import glowworm  # noqa: E402

SCENES = ("cornell", "atrium")
ROWS = [(photons, engine, k, corrected) for photons in (200_000, 1_000_000)
        for engine, k in (("blocked", 50), ("knn", 50)) for corrected in (False, True)]
HEAD = """# Irradiance by engines

Written by `bench/tables_engines.py`: the mean irradiance at %d points where gather rays end, divided by the mean that
path tracing finds with %d paths a point, and the standard error over the points.

| scene | photons | engine | k | boundary correction | over paths |
| --- | ---: | --- | ---: | --- | ---: |
"""
POINTS, PATHS = 2000, 512


def unit(v):
    return v / np.linalg.norm(v, axis=1)[:, None]


def ends_of_gather_rays(scene):
    """Places and normals of the ends of one diffuse ray from what each pixel sees."""
    picture = glowworm.render(scene, size=(96, 72), samples=1, integrator="path", aov="position,normal", filter=False,
                              progress=False)
    places, normals = (np.asarray(picture[layer]).reshape(-1, 3) for layer in ("position", "normal"))
    seen = np.isfinite(places).all(1) & (np.linalg.norm(normals, axis=1) > 0.9)
    places, normals = places[seen], unit(normals[seen])
    random = np.random.default_rng(0)
    directions = unit(normals + unit(random.normal(size=normals.shape)))
    starts = places + 1e-3 * normals
    hits = glowworm.Tracer(scene).intersect(starts, directions)
    distance = np.asarray(hits.distance)
    met = random.permutation(np.flatnonzero(np.isfinite(distance)))[:POINTS]
    ends = starts[met] + directions[met] * distance[met][:, None]
    facing = unit(np.asarray(hits.normal)[met])
    facing[(facing * directions[met]).sum(1) > 0] *= -1
    return ends, facing


def main(scenes):
    rows = []
    for name in scenes or SCENES:
        scene = glowworm.Scene.load("builtin:" + name)
        places, normals = ends_of_gather_rays(scene)
        right = np.asarray(glowworm.measure(scene, places, normals, on_surfaces=True, integrator="path", samples=PATHS,
                                            progress=False)["irradiance"]).mean(1)
        for photons, engine, k, corrected in ROWS:
            photon_map = glowworm.PhotonMap(scene, photons=photons, engine=engine, nearest=k,
                                            boundary_correction=corrected)
            found = np.asarray(photon_map.irradiance(places, normals)).mean(1)
            error = (found - right).std() / len(right) ** 0.5 / right.mean()
            rows.append(f"| {name} | {photons:,} | {engine} | {k} | {'yes' if corrected else 'no'} | "
                        f"{found.mean() / right.mean():.3f} +- {error:.3f} |")
            print(rows[-1], flush=True)
    with open(os.path.join(ROOT, "bench/results/engines.md"), "w") as page:
        page.write(HEAD % (POINTS, PATHS) + "\n".join(rows) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
