"""Finds the daylight of a year on a work plane, and prints when it suffices: daylight.py WEATHER.epw"""
import sys

import numpy as np

import glowworm

scene = glowworm.Scene.load("builtin:ajar")
low, high = scene.positions.min(axis=0), scene.positions.max(axis=0)
x, z = np.meshgrid(np.linspace(low[0], high[0], 8)[1:-1], np.linspace(low[2], high[2], 6)[1:-1])
points = np.stack([x, np.full_like(x, 0.8), z], axis=-1).reshape(-1, 3)
normals = np.tile([0.0, 1.0, 0.0], (len(points), 1))

year = glowworm.daylight(scene, sys.argv[1], points, normals, noise=0.05)
print(f"sDA {100 * year['sDA']:.0f}%, ASE {100 * year['ASE']:.0f}%")
print("daylight autonomy of each sensor:", np.round(year["autonomy"], 2))
months = year["hours"][:, 0]
for month in range(1, 13):
    if (months == month).any():
        print(f"month {month}: mean {year['illuminance'][:, months == month].mean():.0f} lx")
