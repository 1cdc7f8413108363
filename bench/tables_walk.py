#!/usr/bin/env python3
"""A walk through the atrium: cost of frames that share their maps, and flicker: bench/results/walk.md.

The walk is rendered as a sequence, whose frames share photons and guides, and frame by frame with photons of its own for
each, as a renderer without sequences does. Both are rendered with two seeds.

Cost is the processor time of a frame. Flicker is the root mean square over time of the noise at fixed points of surfaces,
over the picture's mean; noise is the same over points and frames, and patches are means of 9 x 9 pixels around the
points. The difference of the two seeds at a point has no signal, so its spread over the frames that see the point, over
the root of two, is flicker without the change of the picture. Points are pixels of the frame in the middle; another
frame sees a point if one of its pixels lies within 1% of the depth. Both rows have the same few frames.

Frames stay in build/walk/, and are made where they are missing.

usage: tables_walk.py [--frames N] [--size WxH] [SCENE]
"""
import argparse
import json
import os
import subprocess
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "build/release/python"))
import glowworm  # noqa: E402

from figures import luminance, processor_seconds  # noqa: E402

PROGRAM = os.path.join(ROOT, "build/release/bin/glowworm")
CACHE = os.path.join(ROOT, "build/walk")
RESULTS = os.path.join(ROOT, "bench/results/walk.md")
LAYERS = "position,depth"
SEEDS = (1, 2)
NEAR = 0.01
FEWEST_FRAMES = 4  # in which a point is seen
OWN_FRAMES, OWN_STEP = 4, 3  # frames with photons of their own, and every how many-th they are
PATCH = 4  # pixels around a point


def run(*command):
    """Runs the program, and returns its processor seconds."""
    before = processor_seconds()
    subprocess.run([PROGRAM, *map(str, command), "--quiet"], check=True)
    return processor_seconds() - before


class Walk:
    def __init__(self, scene, frames, size):
        self.frames = frames
        self.script = os.path.join(CACHE, f"walk-{frames}.json")
        with open(self.script, "w", encoding="utf-8") as out:
            json.dump({"frames": frames, "moves": [{"from": 0, "to": frames, "fly": [0, 0, 2.0], "look": [25, 0]}]}, out)
        self.common = [scene, "--script", self.script, "--size", size, "--precision", "float", "--aov", LAYERS]
        self.name = f"{scene.replace(':', '-').replace('/', '-')}-{size}-{frames}"

    def folder(self, kind):
        path = os.path.join(CACHE, f"{self.name}-{kind}")
        os.makedirs(path, exist_ok=True)
        return path

    def render(self, kind, frames, seed):
        """Renders frames of a run, unless they are there. Their processor seconds are in a file."""
        folder = self.folder(kind)
        for frame in frames:
            file = os.path.join(folder, f"{frame:03}.json")
            if os.path.exists(file):
                continue
            seconds = run("render", *self.common, "--seed", seed, "--frames", frame, "-o",
                          os.path.join(folder, "###.exr"))
            with open(file, "w", encoding="utf-8") as out:
                json.dump(seconds, out)

    def render_shared(self, seed):
        """The whole sequence in one process; the time of the first frame alone tells what the others take."""
        folder = self.folder(f"shared-{seed}")
        file = os.path.join(folder, "seconds.json")
        if not os.path.exists(file):
            first = run("render", *self.common, "--seed", seed, "--frames", 0, "-o", os.path.join(folder, "###.exr"))
            os.remove(os.path.join(folder, "000.exr"))
            whole = run("render", *self.common, "--seed", seed, "-o", os.path.join(folder, "###.exr"))
            with open(file, "w", encoding="utf-8") as out:
                json.dump([first, (whole - first) / (self.frames - 1)], out)
        with open(file, encoding="utf-8") as text:
            return json.load(text)

    def picture(self, kind, frame):
        return glowworm.Picture.read(os.path.join(self.folder(kind), f"{frame:03}.exr"))


def patches(image, reach):
    """Means of squares around each pixel."""
    side = 2 * reach + 1
    padded = np.pad(image, reach, mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, (side, side)).mean(axis=(2, 3))


def noise_of(walk, kinds, frames, reach):
    """Flicker and noise, relative to the mean, of patches around the points of two runs, and the number of points."""
    middle = walk.picture(kinds[0], frames[len(frames) // 2])
    depth = np.squeeze(np.asarray(middle["depth"])).reshape(-1)
    points = np.asarray(middle["position"]).reshape(-1, 3)[::7]
    points = points[np.isfinite(depth[::7])]
    series = np.full((len(frames), len(points)), np.nan)
    mean = []
    for i, frame in enumerate(frames):
        one, other = (walk.picture(kind, frame) for kind in kinds)
        a, b = luminance(one["image"]), luminance(other["image"])
        mean.append((a.mean() + b.mean()) / 2)
        difference = patches(a - b, reach).reshape(-1)
        places = np.asarray(one["position"]).reshape(-1, 3)
        far = np.squeeze(np.asarray(one["depth"])).reshape(-1)
        # |p - q|^2 = |p|^2 - 2 p q + |q|^2, relative to the middle of the points.
        p, q = points - points.mean(axis=0), places - points.mean(axis=0)
        distance = (p**2).sum(axis=1)[:, None] - 2 * p @ q.T + (q**2).sum(axis=1)[None]
        nearest = distance.argmin(axis=1)
        offset = np.linalg.norm(points - places[nearest], axis=1)
        seen = offset < NEAR * far[nearest]
        series[i, seen] = difference[nearest[seen]]
    series = series[:, np.isfinite(series).sum(axis=0) >= FEWEST_FRAMES]
    scale = 2**0.5 * np.mean(mean)
    count = np.isfinite(series).sum(axis=0)
    flicker = np.sqrt(np.mean(np.nanvar(series, axis=0) * count / (count - 1)))
    return flicker / scale, np.sqrt(np.nanmean(series**2)) / scale, series.shape[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--size", default="160x90")
    parser.add_argument("scene", nargs="?", default="builtin:atrium")
    options = parser.parse_args()
    os.makedirs(CACHE, exist_ok=True)
    os.makedirs(os.path.dirname(RESULTS), exist_ok=True)
    walk = Walk(options.scene, options.frames, options.size)
    own = list(range(0, options.frames, OWN_STEP))[:OWN_FRAMES]
    shared = [walk.render_shared(seed) for seed in SEEDS]
    seconds = []
    for seed in SEEDS:
        for frame in own:
            # Other photons for each frame.
            walk.render(f"own-{seed}", [frame], 1000 * seed + frame)
            with open(os.path.join(walk.folder(f"own-{seed}"), f"{frame:03}.json"), encoding="utf-8") as text:
                seconds.append(json.load(text))
    lines = ["# A walk through a scene", "",
             f"Written by `bench/tables_walk.py`, which says what the columns are: {options.frames} frames of "
             f"{options.size} pixels of {options.scene}, with default settings.", "",
             "| frames | first, s | each further, s | flicker | noise | patches: flicker | noise | points |",
             "| --- |" + " ---: |" * 7]
    first, each = np.mean(shared, axis=0)
    rows = [("share photons and guides", first, each, [f"shared-{s}" for s in SEEDS], own),
            ("have their own", np.mean(seconds), np.mean(seconds), [f"own-{s}" for s in SEEDS], own)]
    for name, begin, further, kinds, frames in rows:
        flicker, noise, points = noise_of(walk, kinds, frames, 0)
        of_patches = noise_of(walk, kinds, frames, PATCH)
        lines.append(f"| {name} | {begin:.2f} | {further:.2f} | {flicker:.2%} | {noise:.2%} | {of_patches[0]:.2%} | "
                     f"{of_patches[1]:.2%} | {points} |")
        print(lines[-1], flush=True)
    with open(RESULTS, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
