#!/usr/bin/python3
"""Baked light against the path tracer at the same points, steps across seams, and time and memory of bakes.

Reads places and light from the files that a bake writes, and measures irradiance there by `glowworm measure`.
Writes bench/results/bake.md. Needs python3-numpy, and npm for gltf-validator.

usage: tables_bake.py [--program PROGRAM] [--texels N] [--atlas N] [--samples N,...] [--paths N] [--seams SCENE,...] [TABLE...]
tables: truth, seams, scale
"""
import argparse
import json
import math
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "build/release/python"))
import glowworm  # noqa: E402

SHARED = ROOT / "../shared/scenes"
RESULTS = ROOT / "bench/results/bake.md"
COMPONENTS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
SIGMA = 0.02  # of a baked texel, relative: the target of the error
BEYOND = 5
HIDDEN = 1e-6  # Share of the brightest light that only comes through the gap of rounding between two surfaces.


class Lightmap:
    """A GLB file of --format lightmap --texture exr: triangles, their texture coordinates, and irradiance in W m^-2."""

    def __init__(self, path):
        data = path.read_bytes()
        size = struct.unpack_from("<I", data, 12)[0]
        self.json, self.bytes = json.loads(data[20 : 20 + size]), data[28 + size :]
        self.folder = path.parent
        corners, uvs, atlases, materials = [], [], [], []
        self.pictures = {}
        for node in self.json["nodes"]:
            for primitive in self.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
                material = self.json["materials"][primitive["material"]]
                light = (material.get("extras") or {}).get("light")
                if not light:
                    continue
                attributes = primitive["attributes"]
                index = self.array(primitive["indices"]).reshape(-1, 3)
                corners.append(self.array(attributes["POSITION"])[index])
                uvs.append(self.array(attributes[f"TEXCOORD_{light['texCoord']}"])[index])
                atlases += [light["file"]] * len(index)
                # Of one surface; layers of brightness have materials of their own.
                surface = material.get("name"), str(material["pbrMetallicRoughness"].get("baseColorFactor"))
                materials += [surface] * len(index)
                if light["file"] not in self.pictures:
                    self.pictures[light["file"]] = glowworm.Picture.read(str(self.folder / light["file"]))["image"]
        self.corners, self.uvs = numpy.concatenate(corners), numpy.concatenate(uvs)
        self.atlases, self.materials = numpy.array(atlases), materials
        self.side = len(next(iter(self.pictures.values())))

    def array(self, accessor):
        a = self.json["accessors"][accessor]
        view = self.json["bufferViews"][a["bufferView"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        width = WIDTHS[a["type"]]
        values = numpy.frombuffer(self.bytes, COMPONENTS[a["componentType"]], a["count"] * width, start)
        return values.reshape(-1, width).astype(float if a["componentType"] == 5126 else int).squeeze()

    def light(self, atlas, uv):
        """Irradiance as viewers show it: bilinear."""
        picture = self.pictures[atlas]
        x, y = uv * self.side - 0.5
        i, j = math.floor(x), math.floor(y)
        s, t = x - i, y - j
        at = lambda c, r: picture[min(max(r, 0), self.side - 1), min(max(c, 0), self.side - 1)]
        return (1 - t) * ((1 - s) * at(i, j) + s * at(i + 1, j)) + t * ((1 - s) * at(i, j + 1) + s * at(i + 1, j + 1))

    def random_points(self, count, generator):
        """Points on triangles, even over texels: atlas, coordinates, position and normal of each."""
        a, b = self.uvs[:, 1] - self.uvs[:, 0], self.uvs[:, 2] - self.uvs[:, 0]
        area = abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        out = []
        for t in generator.choice(len(area), count, p=area / area.sum()):
            u, v = generator.random(2)
            if u + v > 1:
                u, v = 1 - u, 1 - v
            at = lambda corners: corners[0] * (1 - u - v) + corners[1] * u + corners[2] * v
            p, q, r = self.corners[t]
            normal = numpy.cross(q - p, r - p)
            out.append((self.atlases[t], at(self.uvs[t]), at(self.corners[t]), normal / numpy.linalg.norm(normal)))
        return out


def bake(program, scene, options, output):
    """Runs a bake. Returns its wall and processor seconds, peak memory in MB, and what it printed."""
    script = ("import resource,subprocess,sys,time;t=time.monotonic();"
              "r=subprocess.run(sys.argv[1:],stderr=subprocess.PIPE,text=True);"
              "u=resource.getrusage(resource.RUSAGE_CHILDREN);print(time.monotonic()-t,u.ru_utime+u.ru_stime,"
              "u.ru_maxrss/1024);print(r.stderr);sys.exit(r.returncode)")  # fmt: skip
    command = [program, "bake", scene, *options, "-o", output]
    run = subprocess.run([sys.executable, "-c", script, *map(str, command)], stdout=subprocess.PIPE, text=True)
    if run.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}:\n{run.stdout}")
    first, _, said = run.stdout.partition("\n")
    return [float(word) for word in first.split()], said


def measured(program, scene, points, options, folder):
    """Irradiance in W m^-2 and its standard error, three channels a point. Removes points that lie in solid objects, as
    those beneath boxes that stand on the floor do."""
    file, table = folder / "points.txt", folder / "table.json"
    command = [str(x) for x in (program, "measure", scene, "--points", file, "--integrator", "path", *options, "-o", table,
                                "-q")]  # fmt: skip
    while True:
        file.write_text("\n".join(" ".join(f"{x:.9g}" for x in (*p, *n)) for _, _, p, n in points) + "\n")
        result = subprocess.run(command, capture_output=True, text=True)
        inside = re.search(r"inside of solid objects.*?: ([0-9, ]+)", result.stderr)
        if not inside:
            break
        for i in sorted(map(int, inside[1].split(",")), reverse=True):
            del points[i]
    if result.returncode != 0:
        raise SystemExit(result.stderr)
    return json.loads(table.read_text())


def truth(o):
    """The error of a baked Cornell box at random points, for several numbers of samples."""
    program, atlas, count = o.program, o.atlas, o.texels
    lines = ["| samples | rays | s | processor s | mean ratio | relRMSE | of the reference | beyond 5 sigma | black |",
             "| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"]  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        points, table = None, None
        for samples in o.samples.split(","):
            options = ["--atlas", atlas, "--format", "lightmap", "--texture", "exr", "--samples", samples]
            (wall, processor, _), said = bake(program, "builtin:cornell", options, folder / "lit.glb")
            lit = Lightmap(folder / "lit.glb")
            if not points:
                points = [(a, uv, p + 1e-5 * n, n) for a, uv, p, n in lit.random_points(count, numpy.random.default_rng(1))]
                table = measured(program, "builtin:cornell", points, ["--samples", o.paths], folder)["points"]
            reference = numpy.array([[p["E_R"], p["E_G"], p["E_B"]] for p in table])
            relative = numpy.array([p["relative_error"] for p in table])
            light = numpy.array([lit.light(a, uv) for a, uv, _, _ in points])
            shown = reference.max(axis=1) > HIDDEN * reference.max()  # Not where boxes stand on the floor.
            reference, relative, light = reference[shown], relative[shown], light[shown]
            scale = numpy.sqrt(reference**2 + 0.01 * reference.mean() ** 2)
            noise = relative[:, None] * reference / scale
            error = (light - reference) / scale
            rms = math.sqrt(max((error**2).mean() - (noise**2).mean(), 0))
            level = abs(light - reference).sum(axis=1) / reference.sum(axis=1)
            beyond = int((level > BEYOND * numpy.hypot(SIGMA, relative)).sum())
            black = int((light.max(axis=1) <= 0).sum())
            rays = said.split(" samples x ")[1].split()[0]
            lines.append(f"| {samples} | {rays} | {wall:.1f} | {processor:.1f} | {light.mean() / reference.mean():.4f} | "
                         f"{rms:.4f} | {math.sqrt((noise**2).mean()):.4f} | {beyond} of {len(light)} | {black} |")  # fmt: skip
            print(lines[-1], flush=True)
    return (f"## Cornell box, {atlas} x {atlas} texels, against the path tracer\n{count} random points of the surfaces; "
            f"irradiance as viewers show it, by bilinear filtering, against {o.paths} paths each. relRMSE is without the "
            f"reference's own error; sigma is {SIGMA:.0%} of the irradiance and the error of the reference.\n\n"
            + "\n".join(lines) + "\n")  # fmt: skip


def seam_steps(lit, stops):
    """Steps in codes of 8 bits across edges that two triangles of one plane and material show by different texels."""
    edges = {}
    for t, (corners, uvs) in enumerate(zip(lit.corners, lit.uvs)):
        normal = numpy.cross(corners[1] - corners[0], corners[2] - corners[0])
        length = numpy.linalg.norm(normal)
        if length == 0:
            continue
        keys = [corner.tobytes() for corner in corners]
        for i in range(3):
            j = (i + 1) % 3
            edges.setdefault(frozenset((keys[i], keys[j])), []).append(
                (t, normal / length, {keys[i]: uvs[i], keys[j]: uvs[j]}))  # fmt: skip
    code = lambda light: 255 * numpy.interp(light / math.pi * 2**stops, CURVE_IN, CURVE_OUT)
    steps = []
    for ends, sides in edges.items():
        if len(sides) != 2 or len(ends) != 2 or sides[0][1] @ sides[1][1] < 0.9999:
            continue
        (s, _, here), (t, _, there) = sides
        if lit.materials[s] != lit.materials[t]:
            continue
        p, q = ends
        if lit.atlases[s] == lit.atlases[t] and all(abs(here[e] - there[e]).max() < 1e-6 for e in ends):
            continue
        for w in (0.1, 0.3, 0.5, 0.7, 0.9):
            a = lit.light(lit.atlases[s], here[p] * (1 - w) + here[q] * w)
            b = lit.light(lit.atlases[t], there[p] * (1 - w) + there[q] * w)
            steps.append(abs(code(a) - code(b)).max())
    return numpy.array(steps)


CURVE_IN = numpy.linspace(0, 1, 4097) ** 2
CURVE_OUT = numpy.where(CURVE_IN <= 0.0031308, 12.92 * CURVE_IN, 1.055 * CURVE_IN ** (1 / 2.4) - 0.055)


def seams(o):
    """Steps across seams between charts of one plane."""
    lines = ["| scene | places on seams | mean | 99% | largest | beyond 1 |", "| --- | ---: | ---: | ---: | ---: | ---: |"]
    with tempfile.TemporaryDirectory() as name:
        file = pathlib.Path(name) / "lit.glb"
        for scene in o.seams.split(","):
            options = ["--atlas", o.atlas, "--format", "lightmap", "--texture", "exr", "--samples", 4]
            bake(o.program, f"builtin:{scene}", options, file)
            lit = Lightmap(file)
            stops = lit.json["asset"]["extras"]["glowworm"]["exposure_stops"]
            steps = seam_steps(lit, stops)
            lines.append(f"| {scene} | {len(steps)} | {steps.mean():.2f} | {numpy.quantile(steps, 0.99):.2f} | "
                         f"{steps.max():.2f} | {(steps > 1).mean():.2%} |")  # fmt: skip
            print(lines[-1], flush=True)
    return ("## Steps across seams\nLargest difference of red, green and blue between two charts that meet in a plane of one "
            "material, of irradiance over pi with the exposure of the file, in sRGB codes of 8 bits.\n\n" + "\n".join(lines) + "\n")  # fmt: skip


def many_meshes(path, side):
    """A GLB file of side^2 boxes over a floor, each a mesh of its own, under a lamp."""
    quads = [((1, 0, 0), (0, 1, 0), (0, 0, 1)), ((0, 1, 0), (0, 0, 1), (1, 0, 0)), ((0, 0, 1), (1, 0, 0), (0, 1, 0))]
    box = []
    for n, u, v in quads:
        n, u, v = (numpy.array(w, "<f4") for w in (n, u, v))
        for s in (1, -1):
            box += [s * n - u - s * v, s * n + u - s * v, s * n + u + s * v, s * n - u + s * v]
    box = numpy.array(box, "<f4") * 0.4
    faces = numpy.array([[4 * q + i for i in (0, 1, 2, 0, 2, 3)] for q in range(6)], "<u2").ravel()
    slab = numpy.array([[-side, 0, -side], [-side, 0, side], [side, 0, side], [side, 0, -side]], "<f4") * 0.7
    binary, views, accessors, meshes, nodes = b"", [], [], [], []

    def add(values, kind, components):
        nonlocal binary
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": values.nbytes})
        accessors.append({"bufferView": len(views) - 1, "componentType": 5126 if kind == "VEC3" else 5123, "type": kind,
                          "count": values.size // components})  # fmt: skip
        if kind == "VEC3":
            accessors[-1].update(min=values.min(axis=0).tolist(), max=values.max(axis=0).tolist())
        binary += values.tobytes() + b"\0" * (-values.nbytes % 4)
        return len(accessors) - 1

    index = add(faces, "SCALAR", 1)
    quad = add(numpy.array([0, 1, 2, 0, 2, 3], "<u2"), "SCALAR", 1)

    def mesh(positions, indices, material, where):
        meshes.append({"primitives": [{"attributes": {"POSITION": add(positions, "VEC3", 3)}, "indices": indices,
                                       "material": material}]})  # fmt: skip
        nodes.append({"mesh": len(meshes) - 1, "translation": where})

    for i in range(side * side):
        mesh(box * (0.6 + 0.4 * (i * 7 % 11) / 11), index, 0, [1.2 * (i % side - side / 2), 0.5, 1.2 * (i // side - side / 2)])
    mesh(slab, quad, 0, [0, 0, 0])
    mesh(slab[::-1].copy() * 0.2, quad, 1, [0, 20, 0])
    content = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
               "meshes": meshes, "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(binary)}],
               "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}}, {"emissiveFactor": [1, 1, 1]}]}  # fmt: skip
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A) + text
                     + struct.pack("<II", len(binary), 0x004E4942) + binary)  # fmt: skip


def validated(file):
    """What gltf-validator says of a file."""
    web = ROOT / "examples/web"
    if not (web / "node_modules").exists():
        subprocess.run(["npm", "--prefix", web, "ci", "--no-audit", "--no-fund"], check=True, stdout=subprocess.DEVNULL)
    run = subprocess.run([ROOT / "scripts/check-bake", file], stdout=subprocess.PIPE, text=True)
    return run.stdout.split(": ", 1)[1].splitlines()[0]


def scale(o):
    """Time and memory of large bakes."""
    lines = ["| scene | atlas | memory | s | processor s | us a texel | peak MB | GLB MB | gltf-validator | result |",
             "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- | --- |"]  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        many_meshes(folder / "meshes.glb", 100)
        sponza = SHARED / "sponza-dabrovic/pbrt/sponza-sun.pbrt"
        runs = [("builtin:cornell", side, "4G") for side in (256, 512, 1024, 2048)]
        runs += [(folder / "meshes.glb", 1024, "4G"), ("builtin:atrium-large", 2048, "4G"), (sponza, 4096, "2G")]
        for scene, atlas, memory in runs:
            if not str(scene).startswith("builtin:") and not scene.exists():
                continue
            options = ["--atlas", atlas, "--memory", memory, "--samples", 2, "--gather", 8]
            (wall, processor, peak), said = bake(o.program, scene, options, folder / "lit.glb")
            told = next(line for line in said.splitlines() if " samples x " in line)
            result = told.split(": ", 1)[1].split(" samples x ")[0].rsplit(",", 1)[0]
            texels = int(said.split(" points, ")[0].rsplit(" ", 1)[1])
            lines.append(f"| {pathlib.Path(str(scene)).name} | {atlas} | {memory} | {wall:.0f} | {processor:.1f} | "
                         f"{1e6 * processor / texels:.1f} | {peak:.0f} | {(folder / 'lit.glb').stat().st_size / 1e6:.1f} | "
                         f"{validated(folder / 'lit.glb')} | {result} |")  # fmt: skip
            print(lines[-1], flush=True)
    return ("## Time and memory\n2 samples of 8 rays for each texel. The peak is that of the whole process.\n\n"
            + "\n".join(lines) + "\n")  # fmt: skip


def old_page():
    """The tables of earlier runs, of which each keeps its commit."""
    return RESULTS.read_text(encoding="utf-8") if RESULTS.exists() else ""


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default=ROOT / "build/release/bin/glowworm")
    parser.add_argument("--atlas", type=int, default=1024)
    parser.add_argument("--texels", type=int, default=2000)
    parser.add_argument("--samples", default="2,4,6")
    parser.add_argument("--seams", default="ajar,atrium")
    parser.add_argument("--paths", type=int, default=8192)
    parser.add_argument("table", nargs="*", default=["truth", "seams", "scale"])
    o = parser.parse_args()
    run = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], stdout=subprocess.PIPE, text=True)
    for name in o.table:
        title, _, text = {"truth": truth, "seams": seams, "scale": scale}[name](o).partition("\n")
        sections = dict(part.split("\n", 1) for part in old_page().split("\n## ")[1:])
        sections[title.removeprefix("## ")] = f"Commit {run.stdout.strip()}, {os.cpu_count()} cores.\n{text}"
        page = "".join(f"\n## {key}\n{value.rstrip()}\n" for key, value in sorted(sections.items()))
        RESULTS.parent.mkdir(parents=True, exist_ok=True)
        RESULTS.write_text("# Bakes\nWritten by `bench/tables_bake.py`.\n" + page, encoding="utf-8")
    print(f"wrote {RESULTS}")


if __name__ == "__main__":
    main()
