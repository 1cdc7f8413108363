#!/usr/bin/env python3
"""White materials in a white furnace by all integrators and by bakes: bench/results/furnace.md.

A plane that absorbs nothing, or a ball of glass, lies in light of radiance 1 from all sides. A camera looks at the plane
at angles of 25 to 65 degrees. Every pixel and every texel should be 1.

usage: tables_furnace.py [MATERIAL...]     some of the materials, by the beginning of their names
"""
import base64
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
# Renders of each cell differ in their seed. The spread of the first ones gives the number for this standard error.
FIRST, MOST, ERROR = 4, 24, 0.0014
# Only photons on the visible part of the plane count, so that this error would take many renders.
MOST_BY_PHOTONS = 4
INTEGRATORS = {
    "path": {"integrator": "path", "samples": 32},
    "gather": {"integrator": "gather", "samples": 16, "photons": 2_000, "no_guiding": True},
    "gather, engine knn": {"integrator": "gather", "engine": "knn", "samples": 16, "photons": 2_000, "no_guiding": True},
    "photons": {"integrator": "photons", "samples": 4, "photons": 60_000},
}
BAKE = {"samples": 4, "photons": 2_000, "atlas": 64}
COLUMNS = (*INTEGRATORS, "bake")
HEAD = """# White materials in a furnace

Written by `bench/tables_furnace.py`. A plane that absorbs nothing, or a ball of glass, in light of radiance 1 from all
sides. It should be 1. For each integrator: mean over the pixels of a picture that sees the plane at angles of 25 to 65
degrees, over renders of different seeds, and its standard error by their spread. For bakes: the same over the texels of
bakes, which show the light that the plane reflects; '-' is a material that bakes leave as it is. Bakes show no light
that passes through a material.

%d of %d cells are further from 1 than 0.5%% and two standard errors.

| material | alpha | %s |
| --- | ---: | %s |
"""
PBRT = """LookAt 0 2 2  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "%s" %s
%s
"""
PLANE = 'Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 3  3 0 3  3 0 -3  -3 0 -3]'
BALL = 'Shape "sphere" "float radius" 1.5'


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
    """A material of glTF, by its alpha, in a glowing box. Factors that are None are the roughness."""
    def write(alpha):
        roughness = alpha ** 0.5
        factors = {"KHR_materials_" + name: {key: roughness if value is None else value for key, value in factor.items()}
                   for name, factor in extensions.items()}
        plane = [-3, 0, 3, 3, 0, 3, 3, 0, -3, -3, 0, -3]
        box = [x for i in range(8) for x in (8 * (i & 1) - 4, 3 * (i & 2) - 3, 2 * (i & 4) - 4)]
        corners = [0, 1, 2, 0, 2, 3]
        # The walls face inwards.
        walls = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3]
        corner_uv = [0, 0, 1, 0, 1, 1, 0, 1]
        data = b"".join((struct.pack(f"<{len(x)}f", *x) for x in (plane, box, corner_uv)))
        data += b"".join(struct.pack(f"<{len(x)}H", *x) for x in (corners, walls))
        views, at = [], 0
        for length in (48, 96, 32, 12, 72):
            views.append({"buffer": 0, "byteOffset": at, "byteLength": length})
            at += length
        counts = ((4, "VEC3", 5126), (8, "VEC3", 5126), (4, "VEC2", 5126), (6, "SCALAR", 5123), (36, "SCALAR", 5123))
        accessors = [{"bufferView": i, "count": n, "type": kind, "componentType": number}
                     for i, (n, kind, number) in enumerate(counts)]
        for i, bound in ((0, (3, 0, 3)), (1, (4, 3, 4))):
            accessors[i].update(min=[-x for x in bound], max=list(bound))
        black = {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
                 "emissiveFactor": [1, 1, 1], "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}
        white = {"pbrMetallicRoughness": {"metallicFactor": metallic, "roughnessFactor": roughness}, "doubleSided": True,
                 "extensions": factors}
        attributes = ({"POSITION": 0, "TEXCOORD_0": 2}, {"POSITION": 1})
        meshes = [{"primitives": [{"attributes": attributes[i], "indices": i + 3, "material": i}]} for i in (0, 1)]
        uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        return ".gltf", json.dumps({
            "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1]}], "scene": 0, "nodes": [{"mesh": 0}, {"mesh": 1}],
            "meshes": meshes, "materials": [white, black], "accessors": accessors, "bufferViews": views,
            "buffers": [{"byteLength": len(data), "uri": uri}], "images": [{"uri": tilted_normal()}],
            "textures": [{"source": 0}],
            "extensionsUsed": ["KHR_materials_specular", *factors]})
    return write


WHITE = '"rgb reflectance" [1 1 1] '
MATERIALS = {
    "metal": pbrt("conductor", WHITE),
    "glass ball": pbrt("dielectric", shape=BALL),
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
    "brushed glass ball, 4:1": brushed("dielectric", shape=BALL),
    "brushed plastic, 4:1": brushed("coateddiffuse", WHITE + '"float thickness" 0 "integer maxdepth" 500 '),
}


def file_of(folder, material, alpha):
    suffix, text = material(alpha)
    path = os.path.join(folder, "furnace" + suffix)
    with open(path, "w") as file:
        file.write(text)
    return path


def over_seeds(value, most=MOST):
    """Mean of value(seed) over as many seeds as its spread asks for, and its standard error."""
    values = [value(seed) for seed in range(FIRST)]
    wanted = math.ceil(FIRST * (np.std(values, ddof=1) / FIRST ** 0.5 / ERROR) ** 2)
    values += [value(seed) for seed in range(FIRST, min(wanted, most))]
    return np.mean(values), np.std(values, ddof=1) / len(values) ** 0.5


def baked(scene, path, folder, seed):
    """Mean of the texels that a bake writes; None if it leaves the material as it is."""
    picture = os.path.join(folder, "atlas.exr")
    options = [f"--{name}={value}" for name, value in BAKE.items()]
    run = subprocess.run([PROGRAM, "bake", path, "-q", "-o", os.path.join(folder, "baked.glb"), "--exposure=0", "--filter=off",
                          f"--seed={seed}", f"--atlas-picture={picture}", "--no-guiding", *options], capture_output=True, text=True)
    if "no surface to bake" in run.stderr:
        return None
    if run.returncode != 0:
        raise RuntimeError(run.stderr)
    return glowworm.Picture.read(picture)["image"].mean()


def measured(column, scene, path, folder, more):
    """Mean and standard error of a cell; None if there is no such thing."""
    if column == "bake":
        if baked(scene, path, folder, 0) is None:
            return None
        return over_seeds(lambda seed: baked(scene, path, folder, seed))
    camera = glowworm.Camera(EYE, (0, 0, 0), field_of_view=40)
    settings = {**INTEGRATORS[column], "size": (16, 16), "filter": False, "progress": False}
    settings["samples"] *= more
    return over_seeds(lambda seed: glowworm.render(scene, camera=camera, seed=seed, **settings).image.mean(),
                      MOST_BY_PHOTONS if column == "photons" else MOST)


def main(wanted):
    rows, cells, off = [], 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for name, material in MATERIALS.items():
            if wanted and not name.startswith(tuple(wanted)):
                continue
            for alpha in ALPHAS:
                path = file_of(folder, material, alpha)
                scene = glowworm.Scene.load(path)
                row = []
                for column in COLUMNS:
                    # Paths in rough glass have much noise, and cost little.
                    found = measured(column, scene, path, folder, 4 if "glass ball" in name else 1)
                    row.append("-" if found is None else "%.4f +- %.4f" % found)
                    if found is not None:
                        cells += 1
                        off += abs(found[0] - 1) > 0.005 + 2 * found[1]
                rows.append(f"| {name} | {alpha} | {' | '.join(row)} |")
                print(rows[-1], flush=True)
    with open(os.path.join(ROOT, "bench/results/furnace.md"), "w") as page:
        head = HEAD % (off, cells, " | ".join(COLUMNS), " | ".join("---:" for _ in COLUMNS))
        page.write(head + "\n".join(rows) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
