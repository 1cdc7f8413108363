"""Passes, export, bake, preview and cancelling of the add-on.

usage: blender -b --factory-startup -P passes.py -- FOLDER
"""
import os
import shutil
import sys
import time
import traceback

import bpy
import numpy

here = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [here, os.path.dirname(here)]
import glowworm  # noqa: E402
import scenes  # noqa: E402
from glowworm import cryptomatte, exr, preview, program  # noqa: E402


def check(is_right, what):
    if not is_right:
        raise AssertionError(what)


def render_passes(folder):
    scene, layer = bpy.context.scene, bpy.context.view_layer
    scene.render.engine = 'GLOWWORM'
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.glowworm.samples = 2
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_cryptomatte_object = True
    layer.glowworm.use_direct = layer.glowworm.use_indirect = layer.glowworm.use_noise = True
    settings = scene.render.image_settings
    if hasattr(settings, 'media_type'):  # since Blender 5
        settings.media_type = 'MULTI_LAYER_IMAGE'
    settings.file_format, settings.color_depth, settings.exr_codec = 'OPEN_EXR_MULTILAYER', '32', 'ZIP'
    scene.render.filepath = os.path.join(folder, 'passes.exr')
    bpy.ops.render.render(write_still=True)
    channels, texts = exr.read(scene.render.filepath)
    channels = {name.split('.', 1)[1]: values for name, values in channels.items()}
    for name in ('Combined.R', 'Depth.Z', 'Normal.X', 'Direct.R', 'Indirect.B', 'Noise.X', 'CryptoObject00.R'):
        check(name in channels, f'{name} is missing among {sorted(channels)}')
    depth = channels['Depth.Z']
    check(0.5 < depth.min() < depth.max() < 20, 'depths of a room')
    length = sum(channels[f'Normal.{c}'] ** 2 for c in 'XYZ')
    check(abs(numpy.median(length) - 1) < 0.01, 'normals have length 1')
    floor = channels['Normal.Z'][-3:, 20:28]
    check(floor.min() > 0.99, 'the floor points along z')
    light = channels['Direct.G'] + channels['Indirect.G']
    check(abs(light.mean() / channels['Combined.G'].mean() - 1) < 0.3, 'direct and indirect light make the picture')
    ids = channels['CryptoObject00.R'].view('u4')
    manifest = next(value for key, value in texts.items() if key.endswith('/manifest'))
    check(f'"{ids[-2, 24]:08x}"' in manifest, 'the manifest names the floor')
    names = [value for key, value in texts.items() if key.startswith('cryptomatte/') and key.endswith('/name')]
    check(f'{layer.name}.CryptoObject' in names, f'Blender finds the matte by the layer: {names}')


def write_files(folder):
    target = os.path.join(folder, 'exported')
    check(bpy.ops.glowworm.export(filepath=target) == {'FINISHED'}, 'export')
    check(os.path.exists(os.path.join(target, 'scene.pbrt')), 'scene.pbrt')
    glb = os.path.join(folder, 'lit.glb')
    bpy.context.scene.glowworm.options = '--atlas 64'
    check(bpy.ops.glowworm.bake(filepath=glb) == {'FINISHED'}, 'bake')
    with open(glb, 'rb') as file:
        check(file.read(4) == b'glTF', 'lit.glb is a GLB file')
    bpy.context.scene.glowworm.options = ''


def preview_of_camera():
    """The last picture of a preview shows the camera's view."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.glowworm.samples = 4
    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera
    text = preview.camera_text(camera.matrix_world.normalized().inverted(),
                               camera.calc_matrix_camera(depsgraph, x=48, y=32), camera.data.type != 'ORTHO')
    view = preview.Preview()
    view.update(depsgraph)
    sizes = []
    deadline = time.monotonic() + 120
    while view.look(text, 48, 32) and time.monotonic() < deadline:
        time.sleep(0.02)
        if view.picture() is not None and view.picture().shape not in sizes:
            sizes.append(view.picture().shape)
    found = view.picture()
    check(found.shape == (32, 48, 4) and len(sizes) > 1, f'pictures grow: {sizes}')
    folder = view.folder
    view.close()
    check(not os.path.exists(folder), 'a closed preview leaves no files')
    target = os.path.join(os.path.dirname(scene.render.filepath), 'again.exr')
    scene.render.filepath = target
    bpy.ops.render.render(write_still=True)
    channels, _ = exr.read(target)
    rendered = next(values for name, values in channels.items() if name.endswith('Combined.G'))[::-1]
    check(abs(found[..., 1].mean() / rendered.mean() - 1) < 0.1, 'a preview is as bright as a render')
    check(numpy.corrcoef(found[..., 1].ravel(), rendered.ravel())[0, 1] > 0.8, 'a preview shows what the camera sees')


def cancel(folder):
    """A cancelled render keeps what it has."""
    picture = os.path.join(folder, 'cancelled.exr')
    ticks = []

    def tick():
        ticks.append(os.path.exists(picture))
        return ticks[-1] or len(ticks) > 300

    program.run([program.path(), 'render', 'builtin:cornell', '--size', '64x48', '--samples', '100000', '--preview', '-o',
                 picture], folder, tick)
    check(os.path.exists(picture) and len(ticks) <= 300, 'a cancelled render ends with a picture')


def main():
    folder = os.path.abspath(sys.argv[sys.argv.index('--') + 1])
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    check(cryptomatte.murmur3(b'hello') == 0x248bfa47, 'MurmurHash3')
    bpy.ops.wm.read_factory_settings(use_empty=True)
    glowworm.register()
    scenes.modifiers()
    render_passes(folder)
    write_files(folder)
    preview_of_camera()
    cancel(folder)
    glowworm.unregister()
    print('passes.py: passes, export, bake, preview and cancelling work')


try:
    main()
    status = 0
except Exception:
    traceback.print_exc()
    status = 1
sys.stdout.flush()
sys.stderr.flush()
os._exit(status)
