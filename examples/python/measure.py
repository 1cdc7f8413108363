"""Measures the light on a work plane, and writes a table and a picture of it."""
import numpy as np

import glowworm

scene = glowworm.Scene.load("builtin:ajar")
low, high = scene.positions.min(axis=0), scene.positions.max(axis=0)

# Sensors that face up, in a grid at 0.8 m.
columns, rows = 8, 6
x = low[0] + (np.arange(columns) + 0.5) / columns * (high[0] - low[0])
z = low[2] + (np.arange(rows) + 0.5) / rows * (high[2] - low[2])
x, z = np.meshgrid(x, z)
points = np.stack([x, np.full_like(x, 0.8), z], axis=-1).reshape(-1, 3)
normals = np.tile([0.0, 1.0, 0.0], (len(points), 1))

measured = glowworm.measure(scene, points, normals, samples=8, gather=64)
lux = measured["illuminance"].reshape(rows, columns)
print(np.array2string(lux, precision=0, suppress_small=True, prefix="lx: "))
share = measured["indirect"].sum() / measured["irradiance"].sum()
print(f"mean {lux.mean():.1f} lx, {100 * share:.0f}% of it indirect")
print(f"standard error of a sensor: {100 * np.median(measured['relative_error']):.1f}%")

table = np.concatenate([points, lux.reshape(-1, 1)], axis=1)
np.savetxt("lux.csv", table, delimiter=",", header="x,y,z,E_lx", comments="", fmt="%.6g")
glowworm.Picture({"image": np.repeat(lux[:, :, None] / 179, 3, axis=2)}).write("lux.png")
