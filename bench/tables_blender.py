#!/usr/bin/python3
"""Error at equal processor time in Blender: Cycles (with its denoiser too, where Blender has it), and the add-on by default.

Each scene of addons/blender/tests is rendered by the add-on. Cycles gets the samples that take as long, by a line through
its times at 16 and 256 samples; seconds are of all cores and include what Blender does before and after. Each program is
measured against itself, since materials differ in details (bench/results/published/blender.md). Cycles has no bias, so
its error is the difference of two renders. Ours is the mean product of differences from two path-traced pictures of 256
samples, whose own noise does not count on average. Errors are roots of means over the reference's square and that of a
tenth of its mean, without the worst 2% of the pixels.

Writes bench/results/blender-time.md, and the pictures to build/blender-time/.

usage: tables_blender.py [SCENE...]      GLOWWORM: another program than build/release/bin/glowworm
"""
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
OUT = os.path.join(ROOT, "build", "blender-time")
FEW, REFERENCE = 16, 256  # samples
# Path tracers that read scenes of others, by their names as packages; POV-Ray and Sunflow read their own languages alone.
RENDERERS = ("appleseed", "luxcorerender", "mitsuba", "pbrt", "radiance", "yafaray")


def start_blender():
    if not shutil.which("blender"):
        sys.exit("Blender is not installed (Debian: apt-get install --no-install-recommends blender).")
    program = os.environ.get("GLOWWORM") or os.path.join(ROOT, "build", "release", "bin", "glowworm")
    subprocess.run(["blender", "-b", "--factory-startup", "-P", os.path.abspath(__file__), "--",
                    *sys.argv[1:]], env={**os.environ, "GLOWWORM": program}, check=True)


def trimmed(squares):
    """The root of a mean over pixels, without the worst 2%."""
    import numpy as np
    pixels = squares.mean(axis=-1).ravel()
    kept = np.argsort(np.abs(pixels))[: int(0.98 * len(pixels))]
    return max(float(pixels[kept].mean()), 0.0) ** 0.5


def scale_of(references):
    mean = (references[0] + references[1]) / 2
    return mean ** 2 + (0.1 * mean.mean()) ** 2


def error(picture, references):
    """Of a picture against two independent references, whose noise does not count on average."""
    return trimmed((picture - references[0]) * (picture - references[1]) / scale_of(references))


def noise(pair, references):
    """Error of one of two renders that differ by their seeds, of a program without bias."""
    return trimmed((pair[0] - pair[1]) ** 2 / 2 / scale_of(references))


class Renders:
    """The pictures of one scene, and their processor seconds."""

    def __init__(self, compare, build):
        import bpy
        self.picture, self.stem = compare.picture, os.path.join(OUT, build.__name__)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene
        self.scene.render.resolution_x, self.scene.render.resolution_y = 96, 64
        self.scene.render.image_settings.file_format = "OPEN_EXR"
        self.scene.render.image_settings.color_depth = "32"
        build()
        compare.use_cycles(self.scene)

    def cycles(self, samples, seed, denoised=False):
        self.scene.render.engine = "CYCLES"
        self.scene.cycles.samples, self.scene.cycles.seed = samples, seed
        self.scene.cycles.use_denoising = denoised
        return self.picture(self.scene, f"{self.stem}-cycles-{samples}-{seed}{'-denoised' if denoised else ''}.exr")

    def glowworm(self, options=""):
        self.scene.render.engine = "GLOWWORM"
        self.scene.glowworm.options = options
        return self.picture(self.scene, f"{self.stem}-glowworm{options.replace(' ', '')}.exr")


def row(renders, name, denoises):
    ours, seconds = renders.glowworm()
    references = [renders.cycles(REFERENCE, seed) for seed in (3, 4)]
    few, many = renders.cycles(FEW, 1)[1], min(seconds for _, seconds in references)
    each = max((many - few) / (REFERENCE - FEW), 1e-5)
    samples = max(1, round(FEW + (seconds - few) / each))
    theirs, their_seconds = renders.cycles(samples, 2)
    others, _ = renders.cycles(samples, 5)
    own = [renders.glowworm(f"--integrator path --samples {REFERENCE} --seed {seed}")[0] for seed in (1, 2)]
    cycles = [picture for picture, _ in references]
    numbers = [noise((theirs, others), cycles), error(ours, own), error(ours, cycles)]
    if denoises:
        numbers.insert(1, error(renders.cycles(samples, 2, True)[0], cycles))
    texts = [f"{100 * number:.1f}" for number in numbers]
    return f"| {name} | {seconds:.1f} | {samples} | {their_seconds:.1f} | {' | '.join(texts)} |"


def others():
    """What the package lists of this machine have of other renderers."""
    found = subprocess.run(["apt-cache", "search", "--names-only", f"^({'|'.join(RENDERERS)})"], capture_output=True,
                           text=True, check=True).stdout.splitlines()
    names = ", ".join(line.split()[0] for line in found) or "none"
    return f"Of other renderers ({', '.join(RENDERERS)}), Debian packages {names}."


def main():
    import bpy
    tests = os.path.join(ROOT, "addons", "blender", "tests")
    sys.path[:0] = [tests, os.path.dirname(tests)]
    import _cycles
    import compare
    import glowworm
    import scenes
    os.makedirs(OUT, exist_ok=True)
    glowworm.register()
    names = sys.argv[sys.argv.index("--") + 1:]
    denoises = bool(getattr(_cycles, "with_openimagedenoise", False))
    heads = ["scene", "s", "samples of Cycles", "Cycles, s", "Cycles", *(["Cycles, denoised"] if denoises else []), "ours",
             "ours, by Cycles"]
    lines = ["# Against Cycles at equal processor time", "",
             f"`bench/tables_blender.py`, Blender {bpy.app.version_string}, pictures of 96 x 64. Errors in %, against the same "
             "program;", "the last column is ours against Cycles, with all differences of materials and lamps.", others(),
             "", "| " + " | ".join(heads) + " |", "|" + " --- |" * len(heads)]
    for build in scenes.SCENES:
        if names and build.__name__ not in names:
            continue
        lines.append(row(Renders(compare, build), build.__name__, denoises))
        print(lines[-1], flush=True)
    with open(os.path.join(ROOT, "bench", "results", "blender-time.md"), "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    try:
        import bpy  # noqa: F401
        inside = True
    except ImportError:
        inside = False
    if inside:
        main()
    else:
        start_blender()
