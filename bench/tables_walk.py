#!/usr/bin/env python3
"""A walk of 120 frames through scenes: cost of frames that share their maps and light, and flicker: bench/results/walk.md.

The walk is rendered in three ways: with photons of its own for each frame, as a renderer without sequences does; with
photons and guides that all frames share; and with light of earlier frames as well (--reuse). Only the last walks all the
way. Scenes are builtin:atrium, and the living room of ../shared/scenes where that folder exists.

Cost is the processor time of a frame. Flicker is the root mean square over time of the noise at fixed points of surfaces,
over the picture's mean, in frames that follow each other; noise is the same over points and frames. The difference of
two seeds at a point has no signal, so its spread over the frames that see the point, over the root of two, is flicker
without the change of the picture. Points are pixels of the frame in the middle; another frame sees a point if one of its
pixels lies within 1% of the depth. A pixel at an edge of a surface shows no point: there, what it shows depends on where
the edge cuts it. So a second set of columns has the points alone whose 3 x 3 pixels show one smooth surface, in each
frame; its median is of the flicker of single points.

With --noise, frames end by noise, and one more row has a camera that stands still: there, light of earlier frames
counts wholly.

Frames stay in build/walk/, and are made where they are missing.

usage: tables_walk.py [--frames N] [--size WxH] [--walk N] [--window FIRST-LAST] [--noise SHARE] [SCENE...]
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
LAYERS = "position,depth,normal"
SEEDS = (1, 2)
NEAR = 0.01
FEWEST_FRAMES = 4  # in which a point is seen
REUSE = 8
WINDOW = "24-35"  # frames whose flicker is measured
EVERY_OWN = 4  # of these have photons of their own, too
LIVING_ROOM = os.path.join(ROOT, "../shared/scenes/bitterli-living-room-pbrt/living-room-jpgtex.pbrt")
# Metres to the right, up and ahead, and degrees to the right and up, of the whole walk.
MOVES = {"builtin:atrium": ([0, 0, 6], [40, 0]), LIVING_ROOM: ([0.3, 0, 1], [-20, 0])}


def run(*command):
    """Runs the program, and returns its processor seconds."""
    before = processor_seconds()
    subprocess.run([PROGRAM, *map(str, command), "--quiet"], check=True)
    return processor_seconds() - before


class Walk:
    def __init__(self, scene, options):
        self.frames, self.length = options.frames, options.walk or options.frames
        first, last = map(int, options.window.split("-"))
        self.window = range(first, last + 1)
        self.scene = scene if scene.startswith("builtin:") else os.path.basename(os.path.dirname(scene))
        name = self.scene.replace(":", "-")
        self.name = f"{name}-{options.size}-{self.frames}{f'-of-{options.walk}' if options.walk else ''}" + (
            f"-at-{options.noise}" if options.noise else "")
        fly, look = MOVES.get(scene, ([0, 0, 1], [20, 0]))
        self.walks = self.script("", [{"from": 0, "to": self.length, "fly": fly, "look": look}])
        self.stands = self.script("-stands", [])
        self.common = [scene, "--size", options.size, "--precision", "float", "--aov", LAYERS]
        if options.noise:
            self.common += ["--noise", options.noise]

    def script(self, suffix, moves):
        path = os.path.join(CACHE, f"{self.name}{suffix}.json")
        with open(path, "w", encoding="utf-8") as out:
            json.dump({"frames": self.length, "moves": moves}, out)
        return path

    def folder(self, kind):
        path = os.path.join(CACHE, f"{self.name}-{kind}")
        os.makedirs(path, exist_ok=True)
        return path

    def render(self, kind, seed, frames, *more):
        """Renders frames, unless they are there. Returns processor seconds, which are kept in a file."""
        folder = self.folder(kind)
        file = os.path.join(folder, f"{frames}.json")
        if not os.path.exists(file):
            script = self.stands if kind.startswith("still") else self.walks
            seconds = run("render", *self.common, "--script", script, "--seed", seed, "--frames", frames, *more, "-o",
                          os.path.join(folder, "###.exr"))
            with open(file, "w", encoding="utf-8") as out:
                json.dump(seconds, out)
        with open(file, encoding="utf-8") as text:
            return json.load(text)

    def render_own(self):
        """Frames with other photons for each; returns the seconds of one."""
        return np.mean([self.render(f"own-{seed}", 1000 * seed + frame, str(frame))
                        for seed in SEEDS for frame in self.window[::EVERY_OWN]])

    def render_sequence(self, kind, last, *more):
        """Frames up to the last, and those of the window by the other seed. Returns the seconds of the first, and of
        each further one."""
        first = self.render(f"{kind}-first", SEEDS[0], "0")
        whole = self.render(f"{kind}-{SEEDS[0]}", SEEDS[0], f"0-{last}", *more)
        self.render(f"{kind}-{SEEDS[1]}", SEEDS[1], f"{self.window[0]}-{self.window[-1]}", *more)
        return first, (whole - first) / last

    def render_still(self):
        """Frames of a camera that stands still. Returns the seconds of the first, and of each of the next three."""
        first = self.render("still-first", SEEDS[0], "0")
        return first, (self.render("still", SEEDS[0], "0-3", "--reuse", REUSE) - first) / 3

    def picture(self, kind, frame):
        return glowworm.Picture.read(os.path.join(self.folder(kind), f"{frame:03}.exr"))


class Frame:
    """What a picture shows at each pixel."""

    def __init__(self, picture):
        self.light = luminance(picture["image"])
        self.depth = np.squeeze(np.asarray(picture["depth"]))
        self.place = np.where(np.isfinite(self.depth)[..., None], np.asarray(picture["position"]), np.inf)
        self.normal = np.asarray(picture["normal"])

    def inside(self):
        """Whether the 3 x 3 pixels around each show one smooth surface."""
        alone = np.isfinite(self.depth) & (np.linalg.norm(self.normal, axis=2) > 0.98)
        out = np.pad(np.ones(np.subtract(alone.shape, 2), bool), 1)
        for by in [(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1)]:
            around = [np.roll(a, by, (0, 1)) for a in (self.place, self.normal, alone)]
            with np.errstate(invalid="ignore"):
                off_plane = np.abs(((around[0] - self.place) * self.normal).sum(axis=2))
            turned = ((around[1] - self.normal)**2).sum(axis=2)
            out &= around[2] & (off_plane < NEAR * self.depth) & (turned < 0.04)
        return (out & alone).reshape(-1)

    def find(self, points):
        """The pixel nearest to each point, and whether it shows it."""
        middle = points.mean(axis=0)
        p, q = points - middle, np.where(np.isfinite(self.place.reshape(-1, 3)), self.place.reshape(-1, 3) - middle, 1e6)
        nearest = ((p**2).sum(axis=1)[:, None] - 2 * p @ q.T + (q**2).sum(axis=1)[None]).argmin(axis=1)
        return nearest, np.linalg.norm(p - q[nearest], axis=1) < NEAR * self.depth.reshape(-1)[nearest]


def spread(series, scale):
    """Flicker, noise, median flicker and number of the points that enough frames see."""
    series = series[:, np.isfinite(series).sum(axis=0) >= FEWEST_FRAMES]
    count = np.isfinite(series).sum(axis=0)
    variance = np.nanvar(series, axis=0) * count / (count - 1)
    return (*(np.sqrt([variance.mean(), np.nanmean(series**2), np.median(variance)]) / scale), series.shape[1])


def noise_of(walk, kind, frames):
    """spread() of the points of a run by two seeds, and of those within surfaces."""
    middle = Frame(walk.picture(f"{kind}-{SEEDS[0]}", frames[len(frames) // 2]))
    chosen = np.flatnonzero(np.isfinite(middle.depth))[::5]
    points, within = middle.place.reshape(-1, 3)[chosen], middle.inside()[chosen]
    every, inside = (np.full((len(frames), len(points)), np.nan) for _ in range(2))
    mean = []
    for i, number in enumerate(frames):
        one, other = (Frame(walk.picture(f"{kind}-{seed}", number)) for seed in SEEDS)
        mean.append((one.light.mean() + other.light.mean()) / 2)
        difference = (one.light - other.light).reshape(-1)
        nearest, seen = one.find(points)
        every[i, seen] = difference[nearest[seen]]
        seen &= within & one.inside()[nearest]
        inside[i, seen] = difference[nearest[seen]]
    scale = 2**0.5 * np.mean(mean)
    return spread(every, scale), spread(inside, scale)


def rows_of(walk):
    """Rows of the table."""
    own = walk.render_own()
    shared = walk.render_sequence("shared", walk.window[-1])
    reused = walk.render_sequence("reused", walk.frames - 1, "--reuse", REUSE)
    single = noise_of(walk, "shared", walk.window)
    for name, kind, first, further in [("share photons and guides", "shared", *shared),
                                       (f"and light of {REUSE} before", "reused", *reused)]:
        cells = [f"{first:.2f} | {further:.2f}"]
        for (flicker, noise, median, points), (_, of_one, _, _) in zip(noise_of(walk, kind, walk.window), single):
            cells.append(f"{flicker:.2%} | {noise:.2%} | {flicker / of_one:.0%} | {median:.2%} | {points}")
        yield f"| {walk.scene} | {name} | {' | '.join(cells)} |"
    yield f"| {walk.scene} | have their own photons | {own:.2f} | {own:.2f} |" + " |" * 10
    if "--noise" in walk.common:
        first, further = walk.render_still()
        yield f"| {walk.scene} | light of {REUSE} before, camera at rest | {first:.2f} | {further:.2f} |" + " |" * 10


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--size", default="128x72")
    parser.add_argument("--walk", type=int, help="frames of the whole walk, of which the first --frames are rendered")
    parser.add_argument("--window", default=WINDOW)
    parser.add_argument("--noise", default="", help="of each frame, 2%% for example; without, frames have default samples")
    parser.add_argument("scenes", nargs="*", default=[s for s in MOVES if s.startswith("builtin:") or os.path.exists(s)])
    options = parser.parse_args()
    if options.frames <= int(options.window.split("-")[1]):
        parser.error(f"--frames must be more than the end of --window {options.window}")
    os.makedirs(CACHE, exist_ok=True)
    os.makedirs(os.path.dirname(RESULTS), exist_ok=True)
    how = f"at {options.noise} noise" if options.noise else "with default settings"
    lines = ["# A walk through scenes", "",
             f"Written by `bench/tables_walk.py`, which says what the columns are: {options.frames} frames of "
             f"{options.size} pixels, {how}. The ratio is flicker over the noise of frames that use no light again.", "",
             "| scene | frames | first, s | each further, s | all points: flicker | noise | ratio | median | points | "
             "within surfaces: flicker | noise | ratio | median | points |",
             "| --- | --- |" + " ---: |" * 12]
    for scene in options.scenes:
        for row in rows_of(Walk(scene, options)):
            lines.append(row)
            print(row, flush=True)
    with open(RESULTS, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
