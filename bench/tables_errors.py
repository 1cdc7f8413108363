#!/usr/bin/env python3
"""Stated errors of sensors against the spread of their values over seeds: bench/results/errors.md.

usage: tables_errors.py [PROGRAM]
"""
import csv
import pathlib
import subprocess
import tempfile

import numpy

from tables_sensors import PROGRAM, ROOT, SCENES, write_case

SENSORS, SEEDS = 8, 32
HEAD = """# Stated errors of sensors

Written by `bench/tables_errors.py`: `glowworm measure` at its defaults, %d sensors, %d seeds. z is the distance of a value
from the mean of its sensor over seeds, as a multiple of the error that is stated with the value. An error
comes from few batches and follows a t distribution; it is scaled so that the truth lies within twice the error with a
chance of 95%%.

| scene | rms z | beyond 2 | beyond 3 | stated error |
| --- | ---: | ---: | ---: | ---: |
"""


def measured(folder, seed):
    """E_lx and its error for each sensor."""
    out = folder / "out.csv"
    subprocess.run([PROGRAM, "measure", folder / "scene.pbrt", "--points", folder / "points.pts", "-o", out, "-q",
                    f"--seed={seed}"], check=True)
    rows = list(csv.DictReader(line for line in out.open(encoding="utf-8") if line[0] != "#"))
    value = numpy.array([float(row["E_lx"]) for row in rows])
    return value, value * [float(row["relative_error"]) for row in rows]


def main():
    text = HEAD % (SENSORS, SEEDS)
    for name, scene, sides, height in SCENES:
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place)
            write_case(folder, scene, sides, height, SENSORS)
            value, error = (numpy.array(a) for a in zip(*(measured(folder, seed) for seed in range(SEEDS))))
        # A mean over seeds holds each value, too.
        z = (value - value.mean(axis=0)) * (SEEDS / (SEEDS - 1)) ** 0.5 / error
        row = [f"{(z**2).mean() ** 0.5:.2f}", *(f"{100 * (abs(z) > n).mean():.1f}%" for n in (2, 3)),
               f"{100 * ((error / value) ** 2).mean() ** 0.5:.2f}%"]
        text += f"| {name} | {' | '.join(row)} |\n"
        print(text.splitlines()[-1], flush=True)
    (ROOT / "bench/results/errors.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
