#!/usr/bin/env python3
"""Times the glare of a year at views of the office of tables_year.py: bench/results/annual-glare.md.

usage: tables_annual_glare.py
"""
import os
import pathlib
import platform
import tempfile

from tables_year import ROOT, SCENES_OF_TABLE, office, run, write_weather

# Eyes at desks: towards the window, and along it.
VIEWS = ("-vta -vp 3 1.2 4 -vd 0 0 1 -vu 0 1 0 -vh 180 -vv 180", "-vta -vp 3 1.2 6.5 -vd 1 0 0.3 -vu 0 1 0 -vh 180 -vv 180")


def main():
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_weather(folder / "made.epw")
        (folder / "desks.vf").write_text("".join(f"rvu {view}\n" for view in VIEWS), encoding="utf-8")
        for label, tilt, slats in SCENES_OF_TABLE:
            scene, table = folder / f"s{slats}.obj", folder / f"g{slats}.csv"
            office(tilt, slats).write(scene)
            wall, spent, memory = run("daylight", scene, "--epw", folder / "made.epw", "--views", folder / "desks.vf",
                                      "--dgp", table)
            lit = sum(any(float(cell) > 0 for cell in line.split(",")[3:]) for line in
                      table.read_text(encoding="utf-8").splitlines() if line[:1].isdigit())
            rows.append(f"| {label} | {lit} | {spent:.0f} | {spent / len(VIEWS):.0f} | {wall:.0f} | {memory:.0f} |")
            print(rows[-1], flush=True)
    lines = ["# Glare of a year", "Written by `bench/tables_annual_glare.py`.", "",
             f"DGP of every hour at {len(VIEWS)} views at the same time; {platform.machine()}, {os.cpu_count()} cores, "
             "which others shared.", "",
             "| scene | hours with light | CPU s | CPU s a view | s | MB |", "| --- | --- | --- | --- | --- | --- |", *rows]
    target = ROOT / "bench/results/annual-glare.md"
    target.parent.mkdir(exist_ok=True)
    target.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
