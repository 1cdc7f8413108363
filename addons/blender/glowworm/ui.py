"""Settings, panels and buttons."""
import os

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from . import program, scene


class GlowwormPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name='Program', subtype='FILE_PATH',
                            description='The program glowworm; empty: the one of PATH')

    def draw(self, _context):
        self.layout.prop(self, 'program')


class GlowwormSettings(bpy.types.PropertyGroup):
    samples: IntProperty(name='Samples', min=0, description='Camera samples of each pixel; 0 is automatic')
    noise: FloatProperty(name='Noise (%)', min=0, max=50,
                         description='Stop at this relative standard error of the picture; 0: do not')
    seconds: IntProperty(name='Time (s)', min=0, description='End after this time; 0: do not')
    photons: IntProperty(name='Photons', min=0, description='Photons in the map; 0 is automatic')
    is_reference: BoolProperty(name='Path tracer', description='Render by the path tracer, to check a picture')
    options: StringProperty(name='Options', description='More options of glowworm render')


class GlowwormLayer(bpy.types.PropertyGroup):
    use_direct: BoolProperty(name='Direct light')
    use_indirect: BoolProperty(name='Indirect light')
    use_caustic: BoolProperty(name='Caustics')
    use_emitted: BoolProperty(name='Emitted light')
    use_albedo: BoolProperty(name='Albedo')
    use_noise: BoolProperty(name='Noise')


class _Panel:
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    COMPAT_ENGINES = {'GLOWWORM'}

    @classmethod
    def poll(cls, context):
        return context.engine == 'GLOWWORM'


class GLOWWORM_PT_quality(_Panel, bpy.types.Panel):
    bl_label = 'Quality and time'
    bl_context = 'render'

    def draw(self, context):
        self.layout.use_property_split = True
        for name in ('samples', 'noise', 'seconds', 'photons', 'is_reference', 'options'):
            self.layout.prop(context.scene.glowworm, name)


class GLOWWORM_PT_files(_Panel, bpy.types.Panel):
    bl_label = 'Files'
    bl_context = 'render'

    def draw(self, _context):
        self.layout.operator('glowworm.export')
        self.layout.operator('glowworm.bake')


class GLOWWORM_PT_passes(_Panel, bpy.types.Panel):
    bl_label = 'Passes'
    bl_context = 'view_layer'

    def draw(self, context):
        self.layout.use_property_split = True
        for name in ('use_pass_z', 'use_pass_normal', 'use_pass_cryptomatte_object', 'use_pass_cryptomatte_material'):
            self.layout.prop(context.view_layer, name)
        for name in GlowwormLayer.__annotations__:
            self.layout.prop(context.view_layer.glowworm, name)


def _path(path):
    return os.path.abspath(bpy.path.abspath(path))


def _export(context, folder):
    """Writes the scene as a render would see it."""
    os.makedirs(folder, exist_ok=True)
    return scene.export(folder, context.evaluated_depsgraph_get())


class GLOWWORM_OT_export(bpy.types.Operator, ExportHelper):
    """Write the scene that Glowworm renders to a folder: scene.pbrt, meshes and images"""
    bl_idname = 'glowworm.export'
    bl_label = 'Export the scene'
    filename_ext = ''
    use_filter_folder = True

    def execute(self, context):
        exported = _export(context, _path(self.filepath))
        for line in exported.report:
            self.report({'WARNING'}, line)
        return {'FINISHED'}


class GLOWWORM_OT_bake(bpy.types.Operator, ExportHelper):
    """Bake the light of all surfaces to a GLB file that viewers show"""
    bl_idname = 'glowworm.bake'
    bl_label = 'Bake to lit.glb'
    filename_ext = '.glb'

    def execute(self, context):
        target = _path(self.filepath)
        folder = target + '.scene'
        exported = _export(context, folder)
        for line in exported.report:
            self.report({'WARNING'}, line)
        settings = context.scene.glowworm
        command = [program.path(), 'bake', exported.path, '--up', 'z', '--studio-light', 'off', '-o', target,
                   *settings.options.split()]
        if settings.samples:
            command += ['--samples', str(settings.samples)]
        if settings.photons:
            command += ['--photons', str(settings.photons)]
        try:
            print(program.run(command, folder, lambda: False).strip())
        except RuntimeError as error:
            self.report({'ERROR'}, str(error))
            return {'CANCELLED'}
        return {'FINISHED'}


CLASSES = (GlowwormPreferences, GlowwormSettings, GlowwormLayer, GLOWWORM_PT_quality, GLOWWORM_PT_files,
           GLOWWORM_PT_passes, GLOWWORM_OT_export, GLOWWORM_OT_bake)


def _shared_panels():
    """Blender's own panels that fit every engine: of lights, materials and so on, where Cycles does not replace them."""
    left_out = {'VIEWLAYER_PT_filter', 'VIEWLAYER_PT_layer_passes', 'RENDER_PT_simplify'}
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, 'COMPAT_ENGINES', ())
        of_data = getattr(panel, 'bl_context', '') in ('data', 'material', 'world')
        # Eevee has another name in Blender 4.2 to 4.5.
        of_eevee = 'BLENDER_EEVEE' in engines or 'BLENDER_EEVEE_NEXT' in engines
        fits = 'BLENDER_RENDER' in engines or of_eevee and of_data
        if fits and panel.__name__ not in left_out:
            yield panel


def register():
    for item in CLASSES:
        bpy.utils.register_class(item)
    bpy.types.Scene.glowworm = PointerProperty(type=GlowwormSettings)
    bpy.types.ViewLayer.glowworm = PointerProperty(type=GlowwormLayer)
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.add('GLOWWORM')


def unregister():
    for panel in bpy.types.Panel.__subclasses__():
        if panel not in CLASSES and 'GLOWWORM' in getattr(panel, 'COMPAT_ENGINES', ()):
            panel.COMPAT_ENGINES.discard('GLOWWORM')
    del bpy.types.ViewLayer.glowworm
    del bpy.types.Scene.glowworm
    for item in reversed(CLASSES):
        bpy.utils.unregister_class(item)
