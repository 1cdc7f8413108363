#!/usr/bin/env python3
"""Times a year of an office with blinds and 1,000 sensors, and compares hours of it with measurements of single hours:
bench/results/year.md.

usage: tables_year.py [PROGRAM [HOURS [SENSORS [PATHS [SCENES]]]]]
  HOURS hours (40) are measured by path tracing at SENSORS of the sensors (6) with PATHS paths each (8192),
  in the first SCENES scenes (2)
"""
import csv
import math
import os
import pathlib
import platform
import random
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/bin/glowworm"
HOURS, SENSORS, PATHS, SCENES = (int(word) for word in (sys.argv[2:] + ["40", "6", "8192", "2"][len(sys.argv[2:]):]))

WIDTH, HEIGHT, DEPTH = 6, 3, 8  # of the office (m): x, y, z; its window faces south, towards z
COLORS = {"floor": 0.2, "ceiling": 0.8, "wall": 0.5, "slat": 0.7, "desk": 0.4}
# Name, tilt of the slats (degrees), and their number.
SCENES_OF_TABLE = (("office with blinds", 30, 36), ("office without blinds", 0, 0))
LATITUDE, LONGITUDE, ZONE = 48.13, 11.70, 1


class Model:
    """Quads with materials, as an OBJ file."""

    def __init__(self):
        self.points, self.faces = [], []

    def quad(self, material, *corners):
        self.faces.append((material, len(self.points)))
        self.points += corners

    def box(self, material, low, high):
        (a, b, c), (d, e, f) = low, high
        self.quad(material, (a, b, c), (d, b, c), (d, b, f), (a, b, f))
        self.quad(material, (a, e, c), (a, e, f), (d, e, f), (d, e, c))
        self.quad(material, (a, b, c), (a, e, c), (d, e, c), (d, b, c))
        self.quad(material, (a, b, f), (d, b, f), (d, e, f), (a, e, f))
        self.quad(material, (a, b, c), (a, b, f), (a, e, f), (a, e, c))
        self.quad(material, (d, b, c), (d, e, c), (d, e, f), (d, b, f))

    def write(self, path):
        lines = [f"mtllib {path.stem}.mtl"]
        lines += [f"v {x:g} {y:g} {z:g}" for x, y, z in self.points]
        for material, first in self.faces:
            lines += [f"o {material}", f"usemtl {material}", "f " + " ".join(str(first + k) for k in range(1, 5))]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        colors = "".join(f"newmtl {name}\nKd {r} {r} {r}\n" for name, r in COLORS.items())
        glass = "newmtl glass\nKd 0 0 0\nd 0.1\nTf 0.9 0.9 0.9\nillum 4\nNi 1.5\n"
        path.with_suffix(".mtl").write_text(colors + glass, encoding="utf-8")


def office(tilt, slats=36):
    """The office; slats of 6 cm behind the glass, tilted by degrees, their outer edges down."""
    m, w, h, d = Model(), WIDTH, HEIGHT, DEPTH
    m.quad("floor", (0, 0, 0), (0, 0, d), (w, 0, d), (w, 0, 0))
    m.quad("ceiling", (0, h, 0), (w, h, 0), (w, h, d), (0, h, d))
    m.quad("wall", (0, 0, 0), (w, 0, 0), (w, h, 0), (0, h, 0))
    m.quad("wall", (0, 0, 0), (0, h, 0), (0, h, d), (0, 0, d))
    m.quad("wall", (w, 0, 0), (w, 0, d), (w, h, d), (w, h, 0))
    left, right, low, high, out = 0.5, w - 0.5, 0.9, 2.7, d + 0.3
    for a, b in (((0, 0, d), (w, low, out)), ((0, high, d), (w, h, out)), ((0, low, d), (left, high, out)),
                 ((right, low, d), (w, high, out))):
        m.box("wall", a, b)
    m.quad("glass", (left, low, d + 0.15), (right, low, d + 0.15), (right, high, d + 0.15), (left, high, d + 0.15))
    dy, dz = 0.03 * math.sin(math.radians(tilt)), 0.03 * math.cos(math.radians(tilt))
    for i in range(slats):
        y, z = low + (i + 0.5) * (high - low) / slats, d + 0.06
        m.quad("slat", (left, y - dy, z + dz), (right, y - dy, z + dz), (right, y + dy, z - dz), (left, y + dy, z - dz))
    for i in range(3):
        for j in range(3):
            m.box("desk", (0.6 + 1.9 * i, 0.7, 1 + 2.3 * j), (2 + 1.9 * i, 0.74, 1.8 + 2.3 * j))
    return m


def altitude(day, hour):
    """Of the sun, radians; only to make up weather."""
    declination = 0.4093 * math.sin(2 * math.pi * (day - 81) / 368)
    turn = math.pi * (hour + (LONGITUDE - 15 * ZONE) / 15) / 12
    phi = math.radians(LATITUDE)
    return math.asin(math.sin(phi) * math.sin(declination) - math.cos(phi) * math.cos(declination) * math.cos(turn))


def write_weather(path):
    """A year of clear, hazy and overcast days, made by a formula."""
    numbers, months = random.Random(1), (31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)
    lines = [f"LOCATION,Munich,-,DEU,made up,0,{LATITUDE},{LONGITUDE},{ZONE},529"] + ["HEADER"] * 6
    lines.append("DATA PERIODS,1,1,Data,Sunday,1/1,12/31")
    day = 0
    for month, length in enumerate(months, 1):
        for date in range(1, length + 1):
            day += 1
            clear = numbers.choice((1, 0.6, 0))
            for hour in range(1, 25):
                up = max(math.sin(altitude(day, hour - 0.5)), 0)
                direct = round(clear * 900 * up**0.3) if up > 0.02 else 0
                diffuse = round(up * (400 - 280 * clear)) if up > 0 else 0
                lines.append(f"1999,{month},{date},{hour},60,?9,20,10,50,95000,0,0,300,{direct * up + diffuse:.0f},"
                             f"{direct},{diffuse},0,0")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def run(*words):
    """Runs the program; returns wall seconds, processor seconds and peak memory (MB)."""
    start = time.monotonic()
    child = subprocess.Popen([PROGRAM, *map(str, words), "-q"])
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise subprocess.CalledProcessError(child.returncode, child.args)
    return time.monotonic() - start, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def rows_of(path):
    with open(path, encoding="utf-8") as file:
        return list(csv.reader(line for line in file if not line.startswith("#")))


def compare(name, scene, weather, year, folder):
    """Rows of the table: how far the year is from paths of single hours, with and without the sun."""
    places = [(WIDTH * (i + 0.5) / 25, DEPTH * (j + 0.5) / 40) for i in range(25) for j in range(40)]
    chosen = random.Random(2).sample(range(len(places)), SENSORS)
    points = folder / "some.pts"
    points.write_text("".join(f"{places[i][0]:g} 0.8 {places[i][1]:g} 0 1 0\n" for i in chosen), encoding="utf-8")
    lit = [row for row in rows_of(year)[1:] if max(map(float, row[3:])) > 100]
    direct = {tuple(row[1:4]): float(row[14]) for row in rows_of(weather)[8:]}
    found = {False: [], True: []}
    for row in random.Random(3).sample(lit, HOURS):
        month, day, hour = row[:3]
        table = folder / "hour.csv"
        # Few photons: they bring what the panes reflect of the sun to places where paths do not find it.
        run("measure", scene, "--points", points, "--sky", f"epw:{weather},{month},{day},{hour}", "--integrator", "path",
            "--samples", PATHS, "--photons", 10000, "-o", table)
        values = [(float(row[3 + place]), float(line[10]), float(line[11]) * float(line[10]))
                  for place, line in zip(chosen, rows_of(table)[1:])]
        found[direct[month, day, hour] > 0].append(values)
    rows = []
    for sunny, hours in found.items():
        if not hours:
            continue
        apart = [math.sqrt(sum((o - m) ** 2 for o, m, e in h) / sum(m * m for o, m, e in h)) for h in hours]
        errors = [math.sqrt(sum(e * e for o, m, e in h) / sum(m * m for o, m, e in h)) for h in hours]
        every = [v for h in hours for v in h]
        bias = sum(o for o, m, e in every) / sum(m for o, m, e in every) - 1
        within = sum(abs(o - m) <= 0.05 * m + 2 * e for o, m, e in every) / len(every)
        rows.append(f"| {name} | {'with' if sunny else 'without'} | {len(hours)} | {100 * bias:+.1f}% | "
                    f"{100 * statistics.median(apart):.1f}% | {100 * max(apart):.1f}% | "
                    f"{100 * statistics.median(errors):.1f}% | {100 * within:.1f}% |")
    return rows


def main():
    times, differences = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        weather, points = folder / "made.epw", folder / "grid.pts"
        write_weather(weather)
        points.write_text("".join(f"{WIDTH * (i + 0.5) / 25:g} 0.8 {DEPTH * (j + 0.5) / 40:g} 0 1 0\n"
                                  for i in range(25) for j in range(40)), encoding="utf-8")
        for label, tilt, slats in SCENES_OF_TABLE[:SCENES]:
            scene, year = folder / f"s{slats}.obj", folder / f"y{slats}.csv"
            office(tilt, slats).write(scene)
            wall, spent, memory = run("daylight", scene, "--epw", weather, "--points", points, "-o", year)
            times.append(f"| {label} | {wall:.0f} | {spent:.0f} | {memory:.0f} |")
            print(times[-1], flush=True)
            differences += compare(label, scene, weather, year, folder)
            print(*differences[-2:], sep="\n", flush=True)
    lines = ["# A year of daylight", "Written by `bench/tables_year.py`.", "",
             f"8,760 hours of 1,000 sensors, 145 patches of the sky; {platform.machine()}, {os.cpu_count()} cores.", "",
             "| scene | s | CPU s | MB |", "| --- | --- | --- | --- |", *times, "",
             f"Against `glowworm measure --integrator path` of {HOURS} hours with more than 100 lx at {SENSORS} sensors, "
             f"{PATHS} paths each. Differences are root mean squares over the sensors of an hour, relative to their "
             "illuminance; the bias is of the sum over hours and sensors.", "",
             "| scene | sun | hours | bias | median difference | largest | median error of paths | within 5% and twice the "
             "error of paths |", "| --- | --- | --- | --- | --- | --- | --- | --- |", *differences]
    target = ROOT / "bench/results/year.md"
    target.parent.mkdir(exist_ok=True)
    target.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
