"""Writes a Blender scene as pbrt text beside its meshes and images.

The text keeps Blender's coordinates, z up. Depsgraph, camera, lights and world are read as they are at the frame.
"""
import math
import os
from dataclasses import dataclass, field

import bpy
from mathutils import Matrix, Vector

from . import luminaire, pbrt
from .images import Images
from .materials import Materials, Report, nodes_of, surface_output
from .meshes import write_parts

_DRAWN = {'MESH', 'CURVE', 'SURFACE', 'META', 'FONT'}


@dataclass
class Exported:
    """A scene on disk."""
    path: str
    width: int     # of the part that is rendered
    height: int
    report: Report = field(default_factory=Report)


def picture_size(scene):
    """Width and height of the whole picture, and of its rendered part x0, x1, y0, y1 from the upper left corner."""
    render = scene.render
    width = max(1, int(render.resolution_x * render.resolution_percentage / 100))
    height = max(1, int(render.resolution_y * render.resolution_percentage / 100))
    if not render.use_border:
        return width, height, (0, width, 0, height)
    x0, x1 = int(render.border_min_x * width), int(render.border_max_x * width)
    y0, y1 = int(render.border_min_y * height), int(render.border_max_y * height)
    return width, height, (x0, max(x1, x0 + 1), height - max(y1, y0 + 1), height - y0)


def lamp_power(lamp):
    """A lamp's energy for red, green and blue. Blender 4.5 and later multiply it by 2^exposure and by the colour of a
    temperature."""
    energy = lamp.energy * 2 ** getattr(lamp, 'exposure', 0.0)
    tint = lamp.temperature_color if getattr(lamp, 'use_temperature', False) else (1.0, 1.0, 1.0)
    return tuple(energy * c * t for c, t in zip(lamp.color, tint))


def area_factor(lamp, area):
    """By what the power of a lamp is multiplied: 1, or its area where Blender 4.5 and later do not divide by it."""
    return 1.0 if getattr(lamp, 'normalize', True) else area


class Exporter:
    def __init__(self, folder, depsgraph):
        self.folder, self.depsgraph = folder, depsgraph
        self.scene = depsgraph.scene
        self.report = Report()
        self.lines = []
        self.images = Images(folder)
        self.materials = Materials(self.lines.append, self.images, self.report)
        self.meshes = {}

    def write(self):
        width, height, part = picture_size(self.scene)
        self.camera()
        self.lines.append(' '.join([
            'Film "rgb"', pbrt.parameter('integer', 'xresolution', width),
            pbrt.parameter('integer', 'yresolution', height), f'"integer pixelbounds" [{part[0]} {part[1]} {part[2]} {part[3]}]']))
        self.lines.append('WorldBegin')
        self._world_and_objects()
        path = os.path.join(self.folder, 'scene.pbrt')
        with open(path, 'w', encoding='utf-8') as file:
            file.write('\n'.join(self.lines) + '\n')
        return Exported(path, part[1] - part[0], part[3] - part[2], self.report)

    def body(self):
        """The text after WorldBegin."""
        self._world_and_objects()
        return '\n'.join(self.lines)

    def _world_and_objects(self):
        self.world()
        for instance in self.depsgraph.object_instances:
            if instance.show_self:
                self.instance(instance)

    # Camera

    def camera(self):
        camera = self.scene.camera
        if camera is None:
            raise RuntimeError('The scene has no camera.')
        camera = camera.evaluated_get(self.depsgraph)
        data = camera.data
        place = camera.matrix_world.normalized()
        # pbrt's cameras look along +z, Blender's along -z.
        to_camera = Matrix.Diagonal((1, 1, -1, 1)) @ place.inverted()
        self.lines.append(f'Transform {pbrt.matrix(to_camera)}')
        corners = data.view_frame(scene=self.scene)
        is_flat = data.type == 'ORTHO'
        if data.type == 'PANO':
            self.report.add(camera.name, 'a panoramic camera is taken as a perspective one')
        xs, ys = ([corner[axis] / (1 if is_flat else -corner.z) for corner in corners] for axis in (0, 1))
        window = (min(xs), max(xs), min(ys), max(ys))
        text = ['Camera', '"orthographic"' if is_flat else '"perspective"', f'"float screenwindow" {pbrt.numbers(window)}']
        if not is_flat:
            text.append('"float fov" [90]')
        if data.dof.use_dof:
            size = 1.0 if is_flat else data.lens / 1000
            text.append(pbrt.parameter('float', 'lensradius', size / (2 * data.dof.aperture_fstop)))
            text.append(pbrt.parameter('float', 'focaldistance', self._focus(place, data.dof)))
        self.lines.append(' '.join(text))

    @staticmethod
    def _focus(place, dof):
        if dof.focus_object is None:
            return dof.focus_distance
        ahead = place.to_3x3() @ Vector((0, 0, -1))
        return abs((dof.focus_object.matrix_world.translation - place.translation).dot(ahead))

    # World

    def world(self):
        world = self.scene.world
        if world is None:
            return
        if not nodes_of(world):
            self._sky(tuple(world.color))
            return
        self.materials.owner = world.name
        output = surface_output(world.node_tree)
        node = self.materials.background(output) if output else None
        if node is None:
            return
        strength = max(0.0, node.inputs['Strength'].default_value)
        image = self.materials.environment_image(node.inputs['Color'])
        if image is None:
            color = self.materials.fixed_color(node.inputs['Color'])
            self._sky(tuple(strength * c for c in color))
            return
        path, turn = image
        # Blender's image runs from -x clockwise around z, pbrt's from +x counter-clockwise.
        place = turn.inverted() @ Matrix.Diagonal((-1, 1, 1, 1))
        self.lines.append(f'AttributeBegin\nTransform {pbrt.matrix(place)}\nLightSource "infinite" '
                          f'{pbrt.parameter("string", "filename", path)} {pbrt.parameter("float", "scale", strength)}\n'
                          'AttributeEnd')

    def _sky(self, color):
        if max(color) > 0:
            self.lines.append(f'LightSource "infinite" "rgb L" {pbrt.numbers(color)}')

    # Objects

    def instance(self, instance):
        ob = instance.object
        place = instance.matrix_world.copy()
        if ob.type == 'LIGHT':
            self.lamp(ob, place)
        elif ob.type in _DRAWN:
            self.drawn(ob, place)
        elif ob.type in ('VOLUME', 'CURVES', 'POINTCLOUD', 'GPENCIL', 'GREASEPENCIL'):
            self.report.add(ob.name, f'objects of type {ob.type} are left out')

    def drawn(self, ob, place):
        key = (ob.data.as_pointer() if ob.data else 0, tuple(m.name_full if m else '' for m in self._slots(ob)),
               ob.visible_camera)
        if key not in self.meshes:
            self.meshes[key] = self._mesh(ob, f'mesh{len(self.meshes)}')
        name, parts = self.meshes[key]
        lines = [self._shape(ob, surface, path) for surface, path in parts if surface.emits]
        if any(not surface.emits for surface, _ in parts):
            lines.append(f'ObjectInstance {pbrt.quoted(name)}')
        if lines:
            self.lines.append('\n'.join(['AttributeBegin', f'Transform {pbrt.matrix(place)}', *lines, 'AttributeEnd']))

    @staticmethod
    def _slots(ob):
        return [slot.material for slot in ob.material_slots]

    def _mesh(self, ob, name):
        """The parts of a mesh by material. Those that emit are written at each place; others are an object of pbrt."""
        slots = self._slots(ob)
        mesh = ob.to_mesh()
        files = write_parts(mesh, self.folder, name) if mesh else []
        ob.to_mesh_clear()
        parts = [(self.materials.surface(slots[min(slot, len(slots) - 1)] if slots else None), os.path.basename(path))
                 for slot, path in files]
        shapes = [self._shape(ob, surface, path) for surface, path in parts if not surface.emits]
        if shapes:
            self.lines.append('\n'.join([f'ObjectBegin {pbrt.quoted(name)}', *shapes, 'ObjectEnd']))
        return name, parts

    def _shape(self, ob, surface, path):
        lines = ['AttributeBegin']
        lines.append(f'NamedMaterial {pbrt.quoted(surface.name)}' if surface.name
                     else 'Material "diffuse" "rgb reflectance" [0 0 0]')
        if surface.emits:
            text = ['AreaLightSource "diffuse" "bool twosided" true', f'"rgb L" {pbrt.numbers(surface.radiance)}',
                    pbrt.parameter('string', 'name', ob.name)]
            if surface.image:
                text.append(pbrt.parameter('string', 'filename', surface.image))
            lines.append(' '.join(text))
        shape = ['Shape "plymesh"', pbrt.parameter('string', 'filename', path), pbrt.parameter('string', 'name', ob.name)]
        if surface.alpha != 1:
            is_texture = isinstance(surface.alpha, str)
            shape.append(pbrt.parameter('texture' if is_texture else 'float', 'alpha', surface.alpha))
        shape.append(self._visibility(ob))
        return '\n'.join([*lines, ' '.join(shape), 'AttributeEnd'])

    @staticmethod
    def _visibility(ob):
        # Lamps are not seen by cameras unless the user wants it.
        return '' if ob.visible_camera else '"bool seenbycameras" false'

    # Lamps

    def lamp(self, ob, place):
        lamp = ob.data
        color = tuple(power * factor for power, factor in zip(lamp_power(lamp), self._lamp_nodes(ob)))
        if max(color) <= 0:
            return
        write = {'POINT': self._point, 'SPOT': self._spot, 'SUN': self._sun, 'AREA': self._area}[lamp.type]
        write(ob, lamp, place, color)

    def _lamp_nodes(self, ob):
        lamp = ob.data
        if not nodes_of(lamp):
            return (1.0, 1.0, 1.0)
        self.materials.owner = ob.name
        return self.materials.lamp_factors(lamp.node_tree)

    def _light(self, ob, place, text):
        self.lines.append('\n'.join(['AttributeBegin', f'Transform {pbrt.matrix(place)}',
                                     f'{text} {pbrt.parameter("string", "name", ob.name)}', 'AttributeEnd']))

    @staticmethod
    def _unscaled(place):
        return Matrix.Translation(place.translation) @ place.to_3x3().normalized().to_4x4()

    # A point lamp of P watts sends P / (4 pi) W sr^-1 to all sides, which a picture of Cycles shows. A spot lamp of P watts
    # has the same intensity on its axis, whatever its cone; an area lamp has a radiance of P over four times its area.

    def _point(self, ob, lamp, place, color):
        intensity = tuple(c / (4 * math.pi) for c in color)
        if lamp.shadow_soft_size > 0:
            # A sphere of radius r shows a disk of the area pi r^2 to every side.
            area = math.pi * lamp.shadow_soft_size ** 2
            factor = area_factor(lamp, 4 * area)
            self._shining(ob, Matrix.Translation(place.translation), tuple(i * factor / area for i in intensity),
                          f'Shape "sphere" {pbrt.parameter("float", "radius", lamp.shadow_soft_size)}')
        else:
            self._light(ob, place, f'LightSource "point" "rgb I" {pbrt.numbers(intensity)}')

    def _spot(self, ob, lamp, place, color):
        if lamp.shadow_soft_size > 0:
            self.report.add(ob.name, 'a spot lamp is taken without radius')
            color = tuple(c * area_factor(lamp, 4 * math.pi * lamp.shadow_soft_size ** 2) for c in color)
        path = os.path.join(self.folder, f'lamp{len(self.lines)}.ies')
        luminaire.write(path, lambda angle: self._spot_share(lamp, angle), lamp.spot_size / 2)
        intensity = tuple(c / (4 * math.pi) for c in color)
        self._light(ob, self._unscaled(place), f'LightSource "goniometric" {pbrt.parameter("string", "filename", path)} '
                    f'"rgb I" {pbrt.numbers(intensity)}')

    @staticmethod
    def _spot_share(lamp, angle):
        """A spot lamp's intensity over its intensity on the axis."""
        cosine, edge = math.cos(angle), math.cos(lamp.spot_size / 2)
        width = (1 - edge) * lamp.spot_blend
        t = 1.0 if width == 0 else min(max((cosine - edge) / width, 0.0), 1.0)
        # Before 3.5, Cycles multiplied by the cosine, too.
        return t * t * (3 - 2 * t) * (cosine if bpy.app.version < (3, 5) else 1)

    def _sun(self, ob, lamp, place, color):
        if lamp.angle > math.radians(1):
            self.report.add(ob.name, 'a sun is taken without angle')
        if not getattr(lamp, 'normalize', True):
            self.report.add(ob.name, 'the strength of a sun does not grow with its angle')
        self._light(ob, self._unscaled(place), 'LightSource "distant" "point3 from" [0 0 0] "point3 to" [0 0 -1] '
                    f'"rgb L" {pbrt.numbers(color)}')

    def _area(self, ob, lamp, place, color):
        x = lamp.size
        y = lamp.size_y if lamp.shape in ('RECTANGLE', 'ELLIPSE') else lamp.size
        is_round = lamp.shape in ('DISK', 'ELLIPSE')
        if getattr(lamp, 'spread', math.pi) < math.pi - 1e-3:
            self.report.add(ob.name, 'the spread of an area lamp is taken as 180 degrees')
        sides = place.to_3x3() @ Vector((x, 0, 0)), place.to_3x3() @ Vector((0, y, 0))
        area = sides[0].length * sides[1].length * (math.pi / 4 if is_round else 1)
        if area <= 0:
            return
        corners = self._outline(x / 2, y / 2, 64 if is_round else 4)
        # The polygon inside of an ellipse is smaller than the ellipse, and shines as much.
        size = 64 / 2 * math.sin(2 * math.pi / 64) / math.pi if is_round else 1
        radiance = tuple(c * area_factor(lamp, area) / (4 * area * size) for c in color)
        triangles = ' '.join(f'0 {i + 1} {i}' for i in range(1, len(corners) - 1))
        points = ' '.join(f'{pbrt.number(px)} {pbrt.number(py)} 0' for px, py in corners)
        normals = ' '.join(['0 0 -1'] * len(corners))
        self._shining(ob, place, radiance, f'Shape "trianglemesh" "point3 P" [{points}] "normal N" [{normals}] '
                      f'"integer indices" [{triangles}]')

    @staticmethod
    def _outline(rx, ry, count):
        if count == 4:
            return [(-rx, -ry), (rx, -ry), (rx, ry), (-rx, ry)]
        angles = [2 * math.pi * i / count for i in range(count)]
        return [(rx * math.cos(angle), ry * math.sin(angle)) for angle in angles]

    def _shining(self, ob, place, radiance, shape):
        name = pbrt.parameter('string', 'name', ob.name)
        self.lines.append('\n'.join([
            'AttributeBegin', f'Transform {pbrt.matrix(place)}', 'Material "diffuse" "rgb reflectance" [0 0 0]',
            f'AreaLightSource "diffuse" "rgb L" {pbrt.numbers(radiance)} {name}', f'{shape} {name} {self._visibility(ob)}',
            'AttributeEnd']))


def export(folder, depsgraph):
    """Writes folder/scene.pbrt and its files. Returns an Exported."""
    return Exporter(folder, depsgraph).write()
