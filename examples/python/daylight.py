"""Finds the daylight of a year on a work plane, and prints when it suffices: daylight.py [WEATHER.epw]

Without a weather file it takes two days that it makes up.
"""
import sys

import numpy as np

import glowworm


def write_days(path):
    """A clear day of June and an overcast one of December."""
    rows = ["LOCATION,Munich,-,DEU,made up,0,48.13,11.70,1,529"] + 6 * ["HEADER"]
    rows.append("DATA PERIODS,1,1,Data,Sunday,6/21,12/21")
    for month, direct, diffuse in (6, 600, 150), (12, 0, 100):
        for hour in range(1, 25):
            up = 9 < hour < 16
            total = 0.8 * direct * up + diffuse * up
            rows.append(f"1999,{month},21,{hour},60,?9,20,10,50,95000,0,0,300,{total},{direct * up},{diffuse * up},0,0")
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(rows) + "\n")
    return path


weather = sys.argv[1] if len(sys.argv) > 1 else write_days("days.epw")
scene = glowworm.Scene.load("builtin:window-room")
low, high = scene.positions.min(axis=0), scene.positions.max(axis=0)
x, z = np.meshgrid(np.linspace(low[0], high[0], 6)[1:-1], np.linspace(low[2], high[2], 5)[1:-1])
points = np.stack([x, np.full_like(x, 0.8), z], axis=-1).reshape(-1, 3)
normals = np.tile([0.0, 1.0, 0.0], (len(points), 1))

year = glowworm.daylight(scene, weather, points, normals, samples=4)
print(f"sDA {100 * year['sDA']:.0f}%, ASE {100 * year['ASE']:.0f}%")
print("daylight autonomy of each sensor:", np.round(year["autonomy"], 2))
months = year["hours"][:, 0]
for month in np.unique(months):
    print(f"month {month}: mean {year['illuminance'][:, months == month].mean():.0f} lx")
