#!/usr/bin/env python3
"""White materials in a white furnace by all integrators and by bakes: bench/results/furnace.md.

A plane that absorbs nothing, or a ball of glass, lies in light of radiance 1 from all sides. A camera looks at the plane
at angles of 25 to 65 degrees. Every pixel and every texel should be 1.

usage: tables_furnace.py [MATERIAL...]     some of the materials, by the beginning of their names
"""
import base64
import concurrent.futures
import functools
import json
import math
import os
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "build/release/python"))
import glowworm  # noqa: E402

PROGRAM = os.path.join(ROOT, "build/release/bin/glowworm")
ALPHAS = (0.0, 0.3, 1.0)
EYE = (0, 2, 2)
FURNACE = "1,1,1"  # radiance of the environment
# Renders of each cell differ in their seed. The spread of the first ones gives the number for this standard error.
FIRST, MOST, ERROR = 4, 32, 0.002
# Means over many photons have less noise, and where emission is unguided, all materials meet the same photons.
PHOTONS = {"integrator": "photons", "samples": 1, "photons": 20_000, "nearest": 100, "no_guiding": True}
INTEGRATORS = {
    "path": {"integrator": "path", "samples": 16},
    "gather": {"integrator": "gather", "samples": 4, "photons": 2_000, "no_guiding": True},
    "photons": PHOTONS,
    "photons, engine knn": {**PHOTONS, "engine": "knn"},
}
# Paths in rough glass have much noise, and cost little. No photon is stored on it.
BALL = {"samples": 256}
BAKE = {"samples": 4, "photons": 2_000, "atlas": 64}
WORKERS = 4
COLUMNS = (*INTEGRATORS, "bake")
HEAD = """# White materials in a furnace

Written by `bench/tables_furnace.py`. A plane that absorbs nothing, or a ball of glass, in light of radiance 1 from all
sides. It should be 1. For each integrator: mean over the pixels of a picture that sees the plane at angles of 25 to 65
degrees, over renders of different seeds, and its standard error by their spread. For bakes: the same over the texels.
'-' is a material that bakes leave as it is, or an engine without photons, since none is stored on glass. Gather rays find
light here, not photons, so two engines show the photons directly. A seed's excess
of photons, measured on a diffuse plane, is subtracted where that makes the spread smaller.

%d of %d cells are further from 1 than 0.5%% and two standard errors.

| material | alpha | %s |
| --- | ---: | %s |
"""
PBRT = """LookAt 0 2 2  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
Material "%s" %s
%s
"""
# What the camera sees, and 0.2 m around.
CORNERS = (-0.91, 0, 1.27, 0.91, 0, 1.27, 1.88, 0, -2.49, -1.88, 0, -2.49)
PLANE = f'Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [{" ".join(map(str, CORNERS))}]'
SPHERE = 'Shape "sphere" "float radius" 1.5'


def numbers(**values):
    return " ".join(f'"float {name}" {value}' for name, value in values.items())


def pbrt(kind, extra="", shape=PLANE):
    """A material of pbrt, by its alpha."""
    own = '"bool remaproughness" false ' + extra
    return lambda alpha: (".pbrt", PBRT % (kind, own + numbers(roughness=alpha), shape))


def brushed(kind, extra="", shape=PLANE):
    """The same, of four times the alpha along one axis as along the other."""
    own = '"bool remaproughness" false ' + extra
    return lambda alpha: (".pbrt", PBRT % (kind, own + numbers(uroughness=alpha, vroughness=alpha / 4), shape))


def tilted_normal():
    """A texture of one normal, as the URI of a PNG."""
    normal = np.array([0.25, 0.1, 1.0])
    row = bytes([0, *np.rint(255 * (normal / np.linalg.norm(normal) / 2 + 0.5)).astype(int)])
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(row)), (b"IEND", b""))
    png = b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(data)) + kind + data +
                                          struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks)
    return "data:image/png;base64," + base64.b64encode(png).decode()


def lacquered(coat):
    white = '"rgb reflectance" [1 1 1] "integer maxdepth" 500 "bool remaproughness" false '
    return lambda alpha: (".pbrt", PBRT % ("coatedconductor", white + numbers(**{
        "conductor.roughness": alpha, "interface.roughness": coat, "thickness": 0}), PLANE))


def gltf(metallic=0.0, **extensions):
    """A material of glTF, by its alpha. Factors that are None are the roughness."""
    def write(alpha):
        roughness = alpha ** 0.5
        factors = {"KHR_materials_" + name: {key: roughness if value is None else value for key, value in factor.items()}
                   for name, factor in extensions.items()}
        corners = [0, 1, 2, 0, 2, 3]
        corner_uv = [0, 0, 1, 0, 1, 1, 0, 1]
        data = b"".join((struct.pack(f"<{len(x)}f", *x) for x in (CORNERS, corner_uv)))
        data += struct.pack(f"<{len(corners)}H", *corners)
        views, at = [], 0
        for length in (48, 32, 12):
            views.append({"buffer": 0, "byteOffset": at, "byteLength": length})
            at += length
        counts = ((4, "VEC3", 5126), (4, "VEC2", 5126), (6, "SCALAR", 5123))
        accessors = [{"bufferView": i, "count": n, "type": kind, "componentType": number}
                     for i, (n, kind, number) in enumerate(counts)]
        accessors[0].update(min=[min(CORNERS[k::3]) for k in range(3)], max=[max(CORNERS[k::3]) for k in range(3)])
        white = {"pbrMetallicRoughness": {"metallicFactor": metallic, "roughnessFactor": roughness}, "doubleSided": True,
                 "extensions": factors}
        mesh = {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}
        uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        used = {"extensionsUsed": list(factors)} if factors else {}
        return ".gltf", json.dumps({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0, "nodes": [{"mesh": 0}],
            "meshes": [mesh], "materials": [white], "accessors": accessors, "bufferViews": views,
            "buffers": [{"byteLength": len(data), "uri": uri}], "images": [{"uri": tilted_normal()}],
            "textures": [{"source": 0}], **used})
    return write


DIFFUSE = "diffuse"
WHITE = '"rgb reflectance" [1 1 1] '
MATERIALS = {
    DIFFUSE: lambda alpha: (".pbrt", PBRT % ("diffuse", WHITE, PLANE)),
    "metal": pbrt("conductor", WHITE),
    "glass ball": pbrt("dielectric", shape=SPHERE),
    "plastic": pbrt("coateddiffuse", WHITE + '"float thickness" 0 "integer maxdepth" 500 '),
    "metal under a smooth coat": lacquered(0),
    "metal under a coat of alpha 0.3": lacquered(0.3),
    "glTF dielectric": gltf(),
    "glTF half metal": gltf(0.5),
    "glTF metal": gltf(1.0),
    "glTF metal, smooth clearcoat": gltf(1.0, clearcoat={"clearcoatFactor": 1}),
    "glTF dielectric, rough clearcoat": gltf(clearcoat={"clearcoatFactor": 1, "clearcoatRoughnessFactor": None}),
    "glTF thin glass": gltf(transmission={"transmissionFactor": 1}),
    "glTF sheen": gltf(sheen={"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": None}),
    "glTF diffuse transmission": gltf(diffuse_transmission={"diffuseTransmissionFactor": 0.5}),
    "glTF iridescence": gltf(1.0, iridescence={"iridescenceFactor": 1}),
    "glTF iridescent dielectric": gltf(iridescence={"iridescenceFactor": 1}),
    "glTF clearcoat with a normal of its own": gltf(
        clearcoat={"clearcoatFactor": 1, "clearcoatRoughnessFactor": None, "clearcoatNormalTexture": {"index": 0}}),
    "glTF sheen under a clearcoat": gltf(sheen={"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": None},
                                         clearcoat={"clearcoatFactor": 1}),
    "glTF anisotropy": gltf(1.0, anisotropy={"anisotropyStrength": 0.7}),
    "brushed metal, 4:1": brushed("conductor", WHITE),
    "brushed glass ball, 4:1": brushed("dielectric", shape=SPHERE),
    "brushed plastic, 4:1": brushed("coateddiffuse", WHITE + '"float thickness" 0 "integer maxdepth" 500 '),
}


def file_of(folder, material, alpha):
    suffix, text = material(alpha)
    path = os.path.join(folder, "furnace" + suffix)
    with open(path, "w") as file:
        file.write(text)
    return path


def scene_of(path):
    return glowworm.Scene.load(path, environment=FURNACE)


def over_seeds(value, by_chance=None):
    """Mean of value(seed) over as many seeds as its spread asks for, and its standard error. by_chance(seed): an error of
    mean 0 that is subtracted where this makes the spread smaller"""
    values = np.array([value(seed) for seed in range(FIRST)])
    if by_chance:
        better = values - [by_chance(seed) for seed in range(FIRST)]
        if np.std(better) < np.std(values):
            values, of_seed = better, value
            value = lambda seed: of_seed(seed) - by_chance(seed)
    wanted = math.ceil(FIRST * (np.std(values, ddof=1) / FIRST ** 0.5 / ERROR) ** 2)
    values = np.append(values, [value(seed) for seed in range(FIRST, min(wanted, MOST))])
    return np.mean(values), np.std(values, ddof=1) / len(values) ** 0.5


def baked(scene, path, folder, seed):
    """Mean of the texels that a bake writes; None if it leaves the material as it is."""
    picture = os.path.join(folder, "atlas.exr")
    options = [f"--{name}={value}" for name, value in BAKE.items()]
    run = subprocess.run([PROGRAM, "bake", path, "-q", "-o", os.path.join(folder, "baked.glb"), "--exposure=0",
                          "--filter=off", "--no-guiding", f"--seed={seed}", f"--environment={FURNACE}",
                          f"--atlas-picture={picture}", *options], capture_output=True, text=True)
    if "no surface to bake" in run.stderr:
        return None
    if run.returncode != 0:
        raise RuntimeError(run.stderr)
    return glowworm.Picture.read(picture)["image"].mean()


def pictured(column, scene, seed, **own):
    """Mean of the pixels by an integrator. own: settings of the material"""
    camera = glowworm.Camera(EYE, (0, 0, 0), field_of_view=40)
    settings = {**INTEGRATORS[column], **own, "size": (16, 16), "filter": False, "progress": False}
    return glowworm.render(scene, camera=camera, seed=seed, **settings).image.mean()


@functools.cache
def by_chance(column, seed):
    """The excess of a seed's photons, by the mean of a diffuse plane."""
    with tempfile.TemporaryDirectory() as folder:
        return pictured(column, scene_of(file_of(folder, MATERIALS[DIFFUSE], 0)), seed) - 1


def measured(column, name, scene, path, folder):
    """Mean and standard error of a cell; None if there is no such thing."""
    if column == "bake":
        if baked(scene, path, folder, 0) is None:
            return None
        return over_seeds(lambda seed: baked(scene, path, folder, seed))
    own = BALL if "glass ball" in name else {}
    if own and "engine" in INTEGRATORS[column]:
        return None
    compares = column.startswith("photons") and not own and name != DIFFUSE
    return over_seeds(lambda seed: pictured(column, scene, seed, **own),
                      (lambda seed: by_chance(column, seed)) if compares else None)


def row_of(name, alpha):
    """A row of the page, and for each cell that is there whether it is off."""
    cells, off = [], []
    with tempfile.TemporaryDirectory() as folder:
        path = file_of(folder, MATERIALS[name], alpha)
        scene = scene_of(path)
        for column in COLUMNS:
            found = measured(column, name, scene, path, folder)
            cells.append("-" if found is None else "%.4f +- %.4f" % found)
            if found is not None:
                off.append(abs(found[0] - 1) > 0.005 + 2 * found[1])
    return f"| {name} | {alpha} | {' | '.join(cells)} |", off


def main(wanted):
    wanted = tuple(wanted) or ("",)
    keys = [(name, alpha) for name in MATERIALS if name.startswith(wanted)
            for alpha in (ALPHAS if name != DIFFUSE else ALPHAS[-1:])]
    rows, off = [], []
    # Renders are too small for all processors.
    with concurrent.futures.ProcessPoolExecutor(WORKERS) as pool:
        for row, of_row in pool.map(row_of, *zip(*keys)):
            rows.append(row)
            off += of_row
            print(row, flush=True)
    with open(os.path.join(ROOT, "bench/results/furnace.md"), "w") as page:
        head = HEAD % (sum(off), len(off), " | ".join(COLUMNS), " | ".join("---:" for _ in COLUMNS))
        page.write(head + "\n".join(rows) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
