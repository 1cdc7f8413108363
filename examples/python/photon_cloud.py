"""Traces photons, writes them as a cloud of coloured points, and sums them on a grid of points of the floor."""
import numpy as np

import glowworm

scene = glowworm.Scene.load("builtin:cornell")
photons = glowworm.trace_photons(scene, photons=50_000)
print(photons, f"carry {photons.flux.sum(axis=0, dtype=float)} W")

# A cloud for MeshLab, CloudCompare or Blender: each photon in the colour of its flux.
color = photons.flux / photons.flux.max(axis=1, keepdims=True)
points = np.empty(len(photons), dtype=[("position", "<f4", 3), ("color", "u1", 3)])
points["position"] = photons.positions
points["color"] = np.round(255 * color)
header = f"""ply
format binary_little_endian 1.0
element vertex {len(points)}
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
end_header
"""
with open("photons.ply", "wb") as file:
    file.write(header.encode() + points.tobytes())

# Irradiance of a row of points on the floor, by the photons around them.
photon_map = glowworm.PhotonMap(scene, photons=200_000)
low, high = scene.positions.min(axis=0), scene.positions.max(axis=0)
row = np.linspace(low, high, 11)[1:-1]
row[:, 1], row[:, 2] = 0, low[2] + 0.1 * (high[2] - low[2])
irradiance = photon_map.irradiance(row, np.tile([0, 1, 0], (len(row), 1)))
for x, rgb in zip(row[:, 0], irradiance):
    print(f"x = {x:.2f} m: {rgb.mean():6.2f} W m^-2")
print("the cloud is in photons.ply")
