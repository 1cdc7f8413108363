"""Renders the scenes by Cycles and by the add-on, and compares the means of their pictures.

usage: blender -b --factory-startup -P compare.py -- FOLDER [NAME...]

FOLDER gets the pictures of both side by side, and the table as Markdown. The status is 1 if a mean differs by more
than 2%.
"""
import os
import sys
import time

import bpy
import numpy

here = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [here, os.path.dirname(here)]
import glowworm  # noqa: E402
import scenes  # noqa: E402
from glowworm import exr, images  # noqa: E402

LIMIT = 0.02


def use_cycles(scene):
    scene.render.engine = 'CYCLES'
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = 'CPU', 256, False, False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 64
    cycles.transparent_max_bounces, cycles.blur_glossy, cycles.light_sampling_threshold = 64, 0, 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.pixel_filter_type = 'BOX'


def picture(scene, path):
    """Renders to a file. Returns height x width x 3 values and the processor's seconds, of child processes too."""
    scene.render.filepath = path
    before = os.times()
    bpy.ops.render.render(write_still=True)
    after = os.times()
    channels, _ = exr.read(path)
    return numpy.stack([channels[c] for c in 'RGB'], -1), sum(after[:4]) - sum(before[:4])


def save_beside(path, pictures):
    """Writes pictures side by side as sRGB, of one exposure, 4 times as large."""
    both = numpy.hstack(pictures)
    both = numpy.clip(both / max(numpy.percentile(both, 97), 1e-6), 0, 1)
    both = numpy.where(both < 0.0031308, 12.92 * both, 1.055 * both ** (1 / 2.4) - 0.055)
    images.write_png(path, (both * 255 + 0.5).astype('u1').repeat(4, axis=0).repeat(4, axis=1))


def compare(build, folder):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 96, 64
    scene.render.image_settings.file_format = 'OPEN_EXR'
    scene.render.image_settings.color_depth = '32'
    build()
    stem = os.path.join(folder, build.__name__)
    use_cycles(scene)
    theirs, their_seconds = picture(scene, stem + '-cycles.exr')
    scene.render.engine = 'GLOWWORM'
    ours, our_seconds = picture(scene, stem + '-glowworm.exr')
    save_beside(stem + '.png', [theirs, ours])
    if theirs.shape != ours.shape:
        raise SystemExit(f'{build.__name__}: the pictures have {theirs.shape} and {ours.shape} values')
    means = theirs.mean(), ours.mean()
    colors = ours.mean(axis=(0, 1)) / theirs.mean(axis=(0, 1)) - 1
    return build, means, colors, their_seconds, our_seconds


def main():
    folder, *names = sys.argv[sys.argv.index('--') + 1:]
    folder = os.path.abspath(folder)
    os.makedirs(folder, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    glowworm.register()
    lines = ['# Pictures against Cycles', '',
             '## Means of pictures of 96 x 64, Cycles with 256 samples and no denoiser, Glowworm by default',
             f'`scripts/test-addon`, Blender {bpy.app.version_string}; s: seconds of the processor, loading included.', '',
             '| scene | what | Cycles | Glowworm | difference | of red, green, blue | Cycles, s | Glowworm, s |',
             '| --- | --- | --- | --- | --- | --- | --- | --- |']
    failed = []
    for build in scenes.SCENES:
        if names and build.__name__ not in names:
            continue
        _, (theirs, ours), colors, their_seconds, our_seconds = compare(build, folder)
        difference = ours / theirs - 1
        if abs(difference) > LIMIT:
            failed.append(build.__name__)
        of_colors = ', '.join(f'{100 * c:+.1f}%' for c in colors)
        lines.append(f'| {build.__name__} | {build.__doc__.splitlines()[0]} | {theirs:.4f} | {ours:.4f} | '
                     f'{100 * difference:+.2f}% | {of_colors} | {their_seconds:.1f} | {our_seconds:.1f} |')
        print(lines[-1], flush=True)
    with open(os.path.join(folder, 'blender.md'), 'w', encoding='utf-8') as file:
        file.write('\n'.join(lines) + '\n')
    if failed:
        print('Means differ by more than 2%:', ', '.join(failed))
    sys.stdout.flush()
    os._exit(1 if failed else 0)


if __name__ == '__main__':
    try:
        main()
    except Exception:
        import traceback
        traceback.print_exc()
        os._exit(1)
