#!/usr/bin/env python3
"""Photons that frames of a moving scene keep: bench/results/kept.md.

The room of ../shared/scenes/bitterli-veach-ajar-pbrt, where all light comes through the gap of a door; in turn its door
turns, a lamp that is added above the table moves, and the door turns in haze. Frame by frame, photons of paths that
leave their lamp as before and meet nothing that moved are kept. The last frame is rendered alone, too, which keeps
photons of the first frame only: the table says whether both have the same bits.

usage: tables_kept.py [--program FILE]
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCE = ROOT / "../shared/scenes/bitterli-veach-ajar-pbrt"
RESULTS = ROOT / "bench/results/kept.md"
FRAMES = 5
HAZE = "30m"
DOOR = 'NamedMaterial "Door"\nShape "plymesh"\n    "string filename" [ "models/Mesh006.ply" ]'
POT = '\nNamedMaterial "Pot2"\n'
HINGE = "-2.8 0 -6.15"
LAMP = """AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 600 500 400 ]
ActiveTransform EndTime
Translate 0.4 0 0.2
ActiveTransform All
Translate -1.9 1.6 -2.7
Shape "sphere" "float radius" 0.05
AttributeEnd
"""


def opposite(place):
    return " ".join(f"{-float(x):g}" for x in place.split())


def write_scenes(folder):
    """Writes a file for each motion, and returns their names."""
    for part in ("models", "textures"):
        (folder / part).symlink_to((SOURCE / part).resolve())
    text = "TransformTimes 0 1\n" + (SOURCE / "veach-ajar-jpgtex.pbrt").read_text()
    turn = (f"AttributeBegin\nActiveTransform EndTime\nTranslate {HINGE}\nRotate 8 0 1 0\nTranslate {opposite(HINGE)}\n"
            "ActiveTransform All\n")
    material, shape = DOOR.split("\n", 1)
    files = {"a door that turns by 2 degrees": text.replace(DOOR, f"{material}\n{turn}{shape}\nAttributeEnd"),
             "a lamp that moves by 11 cm": text.replace(POT, "\n" + LAMP + POT, 1)}
    names = {}
    for i, (name, changed) in enumerate(files.items()):
        if changed == text:
            raise SystemExit(f"{SOURCE} has changed: {name} cannot be made")
        names[name] = folder / f"{i}.pbrt"
        names[name].write_text(changed)
    return names


def render(program, folder, scene, prefix, frames, *options):
    subprocess.run([program, "render", scene, "--frames", frames, "--fps", str(FRAMES - 1), "--shutter", "0", "--size", "160x90",
                    "--samples", "1", "--precision", "float", "--quiet", *options, "-o", folder / f"{prefix}#.exr", "--stats",
                    folder / f"{prefix}#.json"], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/glowworm"))
    program = parser.parse_args().program
    lines = ["# Photons kept where things move", "",
             "Written by `bench/tables_kept.py`, which says what moves: means of the frames after the first.", "",
             "| between frames | photons | kept | tracing, s | alone |",
             "| --- | ---: | ---: | ---: | --- |"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scenes = [(what, scene, ()) for what, scene in write_scenes(folder).items()]
        what, scene, _ = scenes[0]
        scenes.append((f"{what}, with --haze {HAZE}", scene, ("--haze", HAZE)))
        for number, (what, scene, options) in enumerate(scenes):
            prefix = f"{number}-"
            render(program, folder, scene, prefix, f"0-{FRAMES - 1}", *options)
            render(program, folder, scene, prefix + "own", str(FRAMES - 1), *options)
            stats = [json.loads((folder / f"{prefix}{i}.json").read_text()) for i in range(1, FRAMES)]
            stored = sum(s["count"]["photons_stored"] for s in stats)
            kept = sum(s["count"]["photons_kept"] for s in stats)
            seconds = sum(s["time_s"]["trace_photons"] for s in stats) / len(stats)
            same = subprocess.run([program, "compare", folder / f"{prefix}{FRAMES - 1}.exr",
                                   folder / f"{prefix}own{FRAMES - 1}.exr", "--json"], stdout=subprocess.PIPE, text=True)
            bits = "same bits" if json.loads(same.stdout)["relative_rmse"] == 0 else "OTHER BITS"
            lines.append(f"| {what} | {stored // len(stats)} | {100 * kept / stored:.0f}% | {seconds:.2f} | {bits} |")
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
