"""Ten small scenes made by script. Each function fills an empty file; the camera looks along +y from a room's open side."""
import math

import bpy
import numpy
from mathutils import Vector


# Names of Principled BSDF's inputs since Blender 4.
_RENAMED = {'Clearcoat': 'Coat Weight', 'Clearcoat Roughness': 'Coat Roughness', 'Specular': 'Specular IOR Level'}


def material(name, shader='ShaderNodeBsdfPrincipled', **inputs):
    """A material of one shader. inputs: names of sockets in Blender 3, with _ for a space, and their values."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    node = nodes.new(shader)
    for key, value in inputs.items():
        key = key.replace('_', ' ')
        node.inputs[key if key in node.inputs else _RENAMED[key]].default_value = value
    links.new(node.outputs[0], nodes.new('ShaderNodeOutputMaterial').inputs['Surface'])
    return made, node


def diffuse(name, color):
    return material(name, 'ShaderNodeBsdfDiffuse', Color=(*color, 1))[0]


def link(made, output, socket):
    made.node_tree.links.new(output, socket)


def mesh(name, points, faces, made, uvs=None):
    data = bpy.data.meshes.new(name)
    data.from_pydata(points, [], faces)
    if uvs:
        layer = data.uv_layers.new()
        for loop, uv in zip(layer.data, uvs):
            loop.uv = uv
    if made:
        data.materials.append(made)
    return place(bpy.data.objects.new(name, data))


def place(ob, location=None, rotation=None, scale=None, collection=None):
    (collection or bpy.context.scene.collection).objects.link(ob)
    if location:
        ob.location = location
    if rotation:
        ob.rotation_euler = [math.radians(a) for a in rotation]
    if scale:
        ob.scale = scale
    return ob


def square(name, made, size=2.0, **at):
    h = size / 2
    ob = mesh(name, [(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)], [(0, 1, 2, 3)], made,
              [(0, 0), (1, 0), (1, 1), (0, 1)])
    bpy.context.scene.collection.objects.unlink(ob)
    return place(ob, **at)


def primitive(add, made, smooth=False, **options):
    add(**options)
    ob = bpy.context.object
    ob.data.materials.append(made)
    for polygon in ob.data.polygons:
        polygon.use_smooth = smooth
    return ob


def cube(made, location, size=1.0, **options):
    return primitive(bpy.ops.mesh.primitive_cube_add, made, location=location, size=size, **options)


def ball(made, location, radius=0.5):
    return primitive(bpy.ops.mesh.primitive_uv_sphere_add, made, True, location=location, radius=radius, segments=48,
                     ring_count=24)


def lamp(kind, energy, location, target=None, **settings):
    data = bpy.data.lights.new(kind.lower(), kind)
    data.energy = energy
    for key, value in settings.items():
        setattr(data, key, value)
    ob = place(bpy.data.objects.new(kind.lower(), data), location)
    if target:
        ob.rotation_euler = (Vector(target) - Vector(location)).to_track_quat('-Z', 'Y').to_euler()
    return ob


def camera(location=(0, -4, 1.2), target=(0, 0, 0.9), lens=30):
    data = bpy.data.cameras.new('camera')
    data.lens = lens
    ob = place(bpy.data.objects.new('camera', data), location)
    ob.rotation_euler = (Vector(target) - Vector(location)).to_track_quat('-Z', 'Y').to_euler()
    bpy.context.scene.camera = ob
    return ob


def sky(color, strength=1.0):
    world = bpy.data.worlds.new('sky')
    world.use_nodes = True
    node = world.node_tree.nodes['Background']
    node.inputs['Color'].default_value = (*color, 1)
    node.inputs['Strength'].default_value = strength
    bpy.context.scene.world = world
    return world


def room():
    """A room without a front wall."""
    white, red, green = (diffuse(n, c) for n, c in (
        ('white', (0.7, 0.7, 0.7)), ('red', (0.6, 0.1, 0.08)), ('green', (0.15, 0.5, 0.12))))
    square('floor', white, 4)
    square('ceiling', white, 4, location=(0, 0, 2.5), rotation=(180, 0, 0))
    square('back', white, 4, location=(0, 2, 1), rotation=(90, 0, 0))
    square('left', red, 4, location=(-2, 0, 1), rotation=(0, 90, 0))
    square('right', green, 4, location=(2, 0, 1), rotation=(0, -90, 0))
    return white


def ground():
    floor = diffuse('ground', (0.4, 0.38, 0.35))
    square('ground', floor, 20)
    return floor


def modifiers():
    """Subdivision, bevel, array and mirrored objects in a room with a rectangular lamp."""
    white = room()
    body = cube(white, (-0.8, 0.3, 0.5), 0.9)
    body.modifiers.new('bevel', 'BEVEL').width = 0.1
    soft = cube(diffuse('blue', (0.1, 0.2, 0.6)), (0.7, 0, 0.5), 1.0)
    soft.modifiers.new('subdivision', 'SUBSURF').render_levels = 3
    row = cube(white, (-1.2, -0.8, 0.1), 0.2)
    row.modifiers.new('array', 'ARRAY').count = 6
    row.scale = (-1, 1, 1)
    lamp('AREA', 40, (0, -0.6, 2.45), shape='RECTANGLE', size=1.2, size_y=0.6)
    camera()


def instances():
    """Collection instances and linked copies under a sun and a sky."""
    ground()
    hidden = bpy.data.collections.new('tree')
    stem = cube(diffuse('wood', (0.3, 0.2, 0.1)), (0, 0, 0.4), 0.25, scale=(1, 1, 3))
    crown = ball(diffuse('leaf', (0.15, 0.4, 0.1)), (0, 0, 1.1), 0.45)
    for ob in (stem, crown):
        bpy.context.scene.collection.objects.unlink(ob)
        hidden.objects.link(ob)
    for i in range(5):
        tree = bpy.data.objects.new(f'tree {i}', None)
        tree.instance_type, tree.instance_collection = 'COLLECTION', hidden
        place(tree, (1.1 * i - 2.2, 0.5 * (i % 2), 0), (0, 0, 30 * i), (1, 1, 0.8 + 0.1 * i))
    copy = bpy.data.objects.new('copy', crown.data)
    place(copy, (0, -1.2, 0.2), scale=(0.5, 0.5, 0.5))
    lamp('SUN', 3, (0, 0, 5), (1, 2, 0), angle=0.005)
    sky((0.3, 0.4, 0.6))
    camera()


def particles():
    """Objects scattered by a particle system."""
    floor = ground()
    seed = ball(diffuse('seed', (0.7, 0.5, 0.1)), (50, 50, 50), 0.5)
    patch = square('patch', floor, 3.5, location=(0, 0.5, 0.02))
    patch.modifiers.new('particles', 'PARTICLE_SYSTEM')
    settings = patch.particle_systems[0].settings
    settings.type, settings.count, settings.render_type = 'HAIR', 40, 'OBJECT'
    settings.use_advanced_hair = True
    settings.instance_object, settings.particle_size, settings.size_random = seed, 0.4, 0.5
    sky((0.8, 0.8, 0.8))
    camera()


def hdri():
    """An image as sky, turned around z."""
    ground()
    ball(diffuse('clay', (0.7, 0.6, 0.5)), (-0.7, 0, 0.5))
    ball(material('steel', Base_Color=(0.9, 0.9, 0.9, 1), Metallic=1.0, Roughness=0.3)[0], (0.7, 0, 0.5))
    width, height = 64, 32
    y, x = numpy.mgrid[0:height, 0:width]
    pixels = numpy.ones((height, width, 4), 'f4')
    pixels[..., 0] = 0.2 + 0.6 * x / width
    pixels[..., 1] = 0.3
    pixels[..., 2] = 0.2 + 0.6 * y / height
    pixels[20:24, 10:16, :3] = (30, 25, 15)
    image = bpy.data.images.new('sky', width, height, float_buffer=True, is_data=True)
    image.pixels.foreach_set(pixels.ravel())
    tree = sky((1, 1, 1), 0.8).node_tree
    texture, mapping = tree.nodes.new('ShaderNodeTexEnvironment'), tree.nodes.new('ShaderNodeMapping')
    texture.image = image
    mapping.inputs['Rotation'].default_value = (0, 0, math.radians(70))
    tree.links.new(tree.nodes.new('ShaderNodeTexCoord').outputs['Generated'], mapping.inputs['Vector'])
    tree.links.new(mapping.outputs[0], texture.inputs['Vector'])
    tree.links.new(texture.outputs['Color'], tree.nodes['Background'].inputs['Color'])
    camera()


def glass():
    """Solid glass, clear and rough, and a mirror, under a sky."""
    ground()
    ball(material('clear', 'ShaderNodeBsdfGlass', Color=(1, 1, 1, 1), IOR=1.5, Roughness=0.0)[0], (-1.1, 0, 0.55))
    ball(material('frosted', 'ShaderNodeBsdfGlass', Color=(0.7, 0.9, 0.8, 1), IOR=1.4, Roughness=0.2)[0], (0, 0, 0.55))
    ball(material('mirror', 'ShaderNodeBsdfGlossy', Color=(0.9, 0.85, 0.8, 1), Roughness=0.0)[0], (1.1, 0, 0.55))
    cube(diffuse('red', (0.7, 0.1, 0.1)), (0, 1.5, 0.5), 1.0)
    sky((0.7, 0.8, 1.0))
    camera()


def lamps():
    """A lamp of each kind, in watts."""
    white = room()
    cube(white, (0.6, 0.5, 0.4), 0.8)
    lamp('POINT', 20, (-1.2, 0, 1.6), shadow_soft_size=0.0, color=(1, 0.8, 0.6))
    lamp('POINT', 10, (1.2, -2, 2.4), shadow_soft_size=0.1, color=(0.6, 0.8, 1))
    lamp('SPOT', 60, (0, -1, 2.3), (-0.5, 0.5, 0), shadow_soft_size=0.0, spot_size=1.0, spot_blend=0.4)
    lamp('AREA', 8, (0, -0.8, 2.45), shape='DISK', size=0.5)
    lamp('SUN', 0.5, (0, -3, 3), (0, 1, 0.5), angle=0.0)
    camera()


def chart():
    """An image of coloured cells; its alpha is 0 in every fourth one."""
    image = bpy.data.images.new('chart', 32, 32, alpha=True)
    y, x = numpy.mgrid[0:32, 0:32] // 8
    pixels = numpy.ones((32, 32, 4), 'f4')
    pixels[..., 0], pixels[..., 1], pixels[..., 2] = 0.2 + 0.2 * x, 0.3 + 0.15 * y, 0.5
    pixels[..., 3] = numpy.where((x + y) % 4 == 3, 0.0, 1.0)
    image.pixels.foreach_set(pixels.ravel())
    return image


def textures():
    """Images, a checker, a mapping and transparency from alpha."""
    ground()
    image = chart()
    made, node = material('panel', 'ShaderNodeBsdfDiffuse')
    texture = made.node_tree.nodes.new('ShaderNodeTexImage')
    texture.image = image
    link(made, texture.outputs['Color'], node.inputs['Color'])
    square('panel', made, 1.6, location=(-1.1, 0.3, 0.9), rotation=(90, 0, 0))
    holes, node = material('holes', Specular=0.0, Roughness=1.0)
    texture = holes.node_tree.nodes.new('ShaderNodeTexImage')
    texture.image, texture.interpolation = image, 'Closest'
    link(holes, texture.outputs['Color'], node.inputs['Base Color'])
    link(holes, texture.outputs['Alpha'], node.inputs['Alpha'])
    square('holes', holes, 1.6, location=(1.1, 0.3, 0.9), rotation=(90, 0, 20))
    checked, node = material('checked', 'ShaderNodeBsdfDiffuse')
    nodes = checked.node_tree.nodes
    checker, mapping, place_of = (nodes.new(f'ShaderNode{n}') for n in ('TexChecker', 'Mapping', 'TexCoord'))
    checker.inputs['Scale'].default_value = 5
    checker.inputs['Color1'].default_value = (0.8, 0.2, 0.1, 1)
    checker.inputs['Color2'].default_value = (0.1, 0.2, 0.7, 1)
    mapping.inputs['Scale'].default_value = (2, 1, 1)
    mapping.inputs['Location'].default_value = (0.05, 0.02, 0.01)
    link(checked, place_of.outputs['UV'], mapping.inputs['Vector'])
    link(checked, mapping.outputs[0], checker.inputs['Vector'])
    link(checked, checker.outputs['Color'], node.inputs['Color'])
    square('checked', checked, 1.6, location=(0, -1, 0.05))
    sky((0.8, 0.8, 0.8))
    camera()


def animation():
    """A later frame: keyed places, a shape key and a keyed lamp."""
    white = room()
    box = cube(white, (-1, 0, 0.5), 0.8)
    box.keyframe_insert('location', frame=1)
    box.location, box.rotation_euler = (1, 0.5, 0.9), (0.3, 0.2, 0.5)
    box.keyframe_insert('location', frame=20)
    soft = ball(diffuse('blue', (0.1, 0.2, 0.6)), (-0.6, -0.3, 0.5))
    soft.shape_key_add(name='rest')
    tall = soft.shape_key_add(name='tall')
    for point in tall.data:
        point.co.z *= 2
    tall.value = 0
    tall.keyframe_insert('value', frame=1)
    tall.value = 1
    tall.keyframe_insert('value', frame=20)
    light = lamp('AREA', 5, (0, -0.8, 2.45), shape='SQUARE', size=1.0)
    light.data.keyframe_insert('energy', frame=1)
    light.data.energy = 60
    light.data.keyframe_insert('energy', frame=20)
    camera()
    bpy.context.scene.frame_set(12)


def emitters():
    """Shining meshes, plain and by an image, mixed and translucent surfaces."""
    room()
    ball(material('lamp', 'ShaderNodeEmission', Color=(1, 0.7, 0.4, 1), Strength=6.0)[0], (-1, 0.5, 1.7), 0.25)
    made, node = material('screen', 'ShaderNodeEmission', Strength=3.0)
    texture = made.node_tree.nodes.new('ShaderNodeTexImage')
    texture.image = chart()
    link(made, texture.outputs['Color'], node.inputs['Color'])
    square('screen', made, 1.0, location=(0.9, 1.5, 1.3), rotation=(90, 0, 0))
    leaf = material('leaf', 'ShaderNodeBsdfTranslucent', Color=(0.3, 0.7, 0.2, 1))[0]
    square('leaf', leaf, 0.8, location=(0.2, 0, 0.8), rotation=(80, 0, 10))
    made, first = material('mixed', 'ShaderNodeBsdfDiffuse', Color=(0.8, 0.1, 0.1, 1))
    nodes = made.node_tree.nodes
    mix, second = nodes.new('ShaderNodeMixShader'), nodes.new('ShaderNodeBsdfDiffuse')
    second.inputs['Color'].default_value = (0.1, 0.1, 0.8, 1)
    mix.inputs[0].default_value = 0.3
    output = next(n for n in nodes if n.type == 'OUTPUT_MATERIAL')
    link(made, first.outputs[0], mix.inputs[1])
    link(made, second.outputs[0], mix.inputs[2])
    link(made, mix.outputs[0], output.inputs['Surface'])
    cube(made, (-0.5, -0.4, 0.3), 0.6)
    camera()


def view():
    """Sensor, shift and crop, hidden collections, text and curves."""
    ground()
    bpy.ops.object.text_add(location=(-1.3, 0, 0.1), rotation=(math.pi / 2, 0, 0))
    bpy.context.object.data.body, bpy.context.object.data.extrude = 'Abc', 0.1
    bpy.context.object.data.materials.append(diffuse('ink', (0.1, 0.1, 0.4)))
    bpy.ops.curve.primitive_bezier_circle_add(location=(1.2, 0.3, 0.6), rotation=(math.pi / 2, 0, 0), radius=0.5)
    bpy.context.object.data.bevel_depth = 0.12
    bpy.context.object.data.materials.append(diffuse('tube', (0.7, 0.3, 0.1)))
    hidden = bpy.data.collections.new('hidden')
    bpy.context.scene.collection.children.link(hidden)
    wall = cube(diffuse('wall', (0.9, 0.9, 0.9)), (0, -2, 1), 2.0)
    bpy.context.scene.collection.objects.unlink(wall)
    hidden.objects.link(wall)
    hidden.hide_render = True
    lamp('SUN', 2, (0, 0, 5), (1, 2, 0), angle=0.0)
    sky((0.4, 0.45, 0.5))
    data = camera().data
    data.sensor_fit, data.sensor_height, data.shift_x, data.shift_y = 'VERTICAL', 22, 0.1, -0.05
    render = bpy.context.scene.render
    render.use_border, render.use_crop_to_border = True, True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.1, 0.9, 0.2, 1.0


def materials():
    """Principled surfaces: plastic, metal, a coat and a rough dielectric."""
    ground()
    looks = [dict(Base_Color=(0.6, 0.2, 0.1, 1), Roughness=0.5), dict(Base_Color=(0.9, 0.7, 0.3, 1), Metallic=1.0, Roughness=0.2),
             dict(Base_Color=(0.1, 0.3, 0.6, 1), Roughness=0.7, Clearcoat=1.0, Clearcoat_Roughness=0.05),
             dict(Base_Color=(0.5, 0.5, 0.5, 1), Specular=0.2, Roughness=0.3)]
    for i, look in enumerate(looks):
        ball(material(f'look {i}', **look)[0], (1.1 * i - 1.65, 0, 0.5))
    lamp('AREA', 120, (-1, -2, 3), (0, 0, 0.5), shape='SQUARE', size=1.5)
    sky((0.3, 0.35, 0.4))
    camera()


SCENES = (modifiers, instances, particles, hdri, glass, lamps, textures, animation, emitters, view, materials)
