"""Glowworm as a render engine of Blender."""
import bpy

from . import engine, ui

bl_info = {
    'name': 'Glowworm',
    'description': 'Global illumination by photon maps',
    'author': 'The Glowworm authors',
    'version': (0, 1, 0),
    'blender': (3, 4, 0),
    'location': 'Render Properties > Render Engine',
    'category': 'Render',
}


def register():
    ui.register()
    bpy.utils.register_class(engine.GlowwormEngine)


def unregister():
    bpy.utils.unregister_class(engine.GlowwormEngine)
    ui.unregister()
