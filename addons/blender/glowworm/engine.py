"""The render engine: exports, runs the program, and hands its layers to Blender as passes."""
import os
import shutil
import tempfile
import time

import bpy
import gpu
import numpy
from gpu_extras.presets import draw_texture_2d

from . import cryptomatte, exr, preview, program, scene

# Pass of Blender, its channels, and the layer and channels of Glowworm.
_COLOR, _XYZ = ('R', 'G', 'B'), ('X', 'Y', 'Z')
_PASSES = {
    'Depth': ('Z', 'depth', ('Z',)),
    'Normal': ('XYZ', 'normal', _XYZ),
    'Direct': ('RGB', 'direct', _COLOR),
    'Indirect': ('RGB', 'indirect', _COLOR),
    'Caustic': ('RGB', 'caustic', _COLOR),
    'Emitted': ('RGB', 'emitted', _COLOR),
    'Albedo': ('RGB', 'albedo', _COLOR),
    'Noise': ('X', 'noise', ('Y',)),
}


def _passes(layer):
    """The passes of _PASSES that a view layer asks for."""
    own = layer.glowworm
    wanted = {
        'Depth': layer.use_pass_z, 'Normal': layer.use_pass_normal, 'Direct': own.use_direct,
        'Indirect': own.use_indirect, 'Caustic': own.use_caustic, 'Emitted': own.use_emitted, 'Albedo': own.use_albedo,
        'Noise': own.use_noise}
    out = {name: _PASSES[name] for name, is_wanted in wanted.items() if is_wanted}
    for kind, is_wanted in (('Object', layer.use_pass_cryptomatte_object),
                            ('Material', layer.use_pass_cryptomatte_material)):
        for level in range(3 if is_wanted else 0):
            name = f'Crypto{kind}{level:02}'
            out[name] = ('RGBA', name, ('R', 'G', 'B', 'A'))
    return out


def _layers_to_ask(passes):
    names = {'cryptomatte' if layer.startswith('Crypto') else layer for _, layer, _ in passes.values()}
    return sorted(names | {'alpha'})


class GlowwormEngine(bpy.types.RenderEngine):
    """Renders a scene by the program glowworm."""
    bl_idname = 'GLOWWORM'
    bl_label = 'Glowworm'
    bl_use_preview = False
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True
    bl_use_postprocess = True

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, 'Combined', 4, 'RGBA', 'COLOR')
        for name, (channels, _, _) in _passes(renderlayer).items():
            kind = 'COLOR' if channels.startswith('RGB') else 'VECTOR' if channels == 'XYZ' else 'VALUE'
            self.register_pass(scene, renderlayer, name, len(channels), channels, kind)

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.preview = None

    def __del__(self):
        if getattr(self, 'preview', None):
            self.preview.close()
        # Blender 4.4 and later free the engine's own data here; earlier ones have no such method.
        free = getattr(super(), '__del__', None)
        if free:
            free()

    def view_update(self, context, depsgraph):
        """The viewport's scene has changed."""
        if self.preview is None:
            self.preview = preview.Preview()
        self._try(lambda: self.preview.update(depsgraph))

    def view_draw(self, context, depsgraph):
        """Draws the best picture so far, and asks to be called again while a better one is on its way."""
        region, view = context.region, context.region_data
        camera = preview.camera_text(view.view_matrix, view.window_matrix, view.is_perspective)
        if self._try(lambda: self.preview.look(camera, region.width, region.height)):
            self.tag_redraw()
        pixels = self.preview.picture()
        if pixels is None:
            return
        height, width, _ = pixels.shape
        texture = gpu.types.GPUTexture((width, height), format='RGBA16F',
                                       data=gpu.types.Buffer('FLOAT', pixels.size, pixels.ravel()))
        gpu.state.blend_set('ALPHA_PREMULT')
        self.bind_display_space_shader(depsgraph.scene)
        draw_texture_2d(texture, (0, 0), region.width, region.height)
        self.unbind_display_space_shader()
        gpu.state.blend_set('NONE')

    def _try(self, work):
        try:
            return work()
        except (RuntimeError, OSError, ValueError) as error:
            self.update_stats('Glowworm', str(error))
            return False

    def render(self, depsgraph):
        settings = depsgraph.scene.glowworm
        folder = tempfile.mkdtemp(prefix='glowworm-')
        try:
            self.update_stats('Glowworm', 'writing the scene')
            exported = scene.export(folder, depsgraph)
            for line in exported.report:
                print('Glowworm:', line)
            if any(True for _ in exported.report):
                self.report({'INFO'}, 'Glowworm: some features are not rendered; the console lists them')
            self._run(settings, exported, depsgraph.view_layer)
        except (RuntimeError, OSError, ValueError) as error:
            self.report({'ERROR'}, str(error))
            self.error_set(str(error))
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _run(self, settings, exported, layer):
        passes = _passes(layer)
        folder = os.path.dirname(exported.path)
        picture = os.path.join(folder, 'picture.exr')
        command = [program.path(), 'render', exported.path, '-o', picture, '--precision', 'float', '--preview',
                   '--studio-light', 'off', '--aov', ','.join(_layers_to_ask(passes)), *program.arguments(settings)]
        started = time.monotonic()
        shown = [0.0, -1]

        def tick():
            seconds = int(time.monotonic() - started)
            if seconds > shown[1]:
                shown[1] = seconds
                self.update_stats('Glowworm', f'{seconds} s')
                if settings.seconds:
                    self.update_progress(min(seconds / settings.seconds, 1.0))
            if os.path.exists(picture) and os.path.getmtime(picture) > shown[0]:
                shown[0] = os.path.getmtime(picture)
                self._show(picture, exported, layer, passes)
            return self.test_break()

        print(program.run(command, folder, tick).strip())
        if os.path.exists(picture):
            self._show(picture, exported, layer, passes)

    def _show(self, picture, exported, layer, passes):
        channels, texts = exr.read(picture)
        result = self.begin_result(0, 0, exported.width, exported.height, layer=layer.name)
        target = result.layers[0].passes
        self._fill(target['Combined'], [channels[c] for c in 'RGBA'])
        for name, (letters, source, names) in passes.items():
            if name not in target:
                self.add_pass(name, len(letters), letters, layer=layer.name)
            values = [channels[f'{source}.{c}'] for c in names]
            if name == 'Depth':
                values = [numpy.where(numpy.isfinite(values[0]), values[0], 1e10)]
            self._fill(target[name], values)
        self.end_result(result)
        whole = self.get_result()
        for key, value in cryptomatte.renamed(texts, layer.name).items():
            whole.stamp_data_add_field(key, value)

    @staticmethod
    def _fill(target, channels):
        rows = numpy.stack([channel[::-1] for channel in channels], axis=-1)
        target.rect.foreach_set(numpy.ascontiguousarray(rows, 'f4').reshape(-1, len(channels)))
