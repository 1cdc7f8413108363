"""Shader nodes as materials of Glowworm's pbrt text. What a material can't express is listed by Report.add()."""
import math
from dataclasses import dataclass
from typing import Any

from mathutils import Euler, Matrix

from . import pbrt
from .images import has_alpha

_BLACK, _WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
_FACTOR = ('Factor', 'Fac')  # names of one socket in different versions
# Inputs of Principled BSDF that are not rendered, by their names in different versions. Weights have no effect where they
# are 0, tints that are colours where they are white; 'Specular Tint' is a weight before Blender 4.
_NOT_OF_PRINCIPLED = (('Subsurface Weight', 'Subsurface'), ('Thin Film Thickness',), ('Diffuse Roughness',),
                      ('Specular Tint',), ('Coat Tint',))


class Report:
    """Features of a scene that the picture does not show as Blender would, each once."""

    def __init__(self):
        self.lines = {}

    def add(self, owner, text):
        self.lines[f'{owner}: {text}'] = True

    def __iter__(self):
        return iter(self.lines)


@dataclass
class Surface:
    """A material slot's surface. Values are numbers, colours, or names of textures."""
    name: str = ''               # of its NamedMaterial; empty: none is defined, and it reflects nothing
    alpha: Any = 1.0             # share of the rays that meet the surface
    radiance: tuple = _BLACK     # emitted on both sides, W sr^-1 m^-2
    image: str = ''              # file that multiplies radiance

    @property
    def emits(self):
        return any(c > 0 for c in self.radiance)


def _socket(node, *names):
    """The first input that the node has. Blender 4 renamed some inputs of Principled BSDF."""
    return next((node.inputs[name] for name in names if name in node.inputs), None)


def _source(socket):
    """The node and output socket that feed an input, without reroutes; or None."""
    while socket is not None and socket.is_linked:
        link = socket.links[0]
        if link.from_node.type != 'REROUTE':
            return link.from_node, link.from_socket
        socket = link.from_node.inputs[0]
    return None


def _mean(value):
    return sum(value) / len(value) if isinstance(value, tuple) else value


def _constant(socket):
    value = socket.default_value
    return tuple(value)[:3] if hasattr(value, '__len__') else float(value)


def nodes_of(owner):
    """The node tree of a material, world or lamp, or None where Blender does not use it. Blender 5 always uses those of
    materials and worlds, and will drop the switch."""
    return owner.node_tree if getattr(owner, 'use_nodes', True) else None


def surface_output(tree):
    """The Material Output or World Output node that is rendered, or None."""
    outputs = [node for node in tree.nodes if node.type in ('OUTPUT_MATERIAL', 'OUTPUT_WORLD')]
    outputs = [node for node in outputs if getattr(node, 'target', 'ALL') in ('ALL', 'CYCLES')]
    return next((node for node in outputs if node.is_active_output), outputs[0] if outputs else None)


class Materials:
    """Writes materials and textures as they are first used. @param write: takes a line of pbrt text"""

    def __init__(self, write, images, report):
        self.write, self.images, self.report = write, images, report
        self.surfaces = {}
        self.count = 0
        self.owner = ''
        self.textures = {}

    def surface(self, material):
        key = material.name_full if material else ''
        if key not in self.surfaces:
            self.owner = key or 'no material'
            self.surfaces[key] = self._read(material)
        return self.surfaces[key]

    def _read(self, material):
        if material is None:
            return Surface(self._define('diffuse', 'none', [('rgb', 'reflectance', (0.8, 0.8, 0.8))]))
        if not nodes_of(material):
            color = tuple(material.diffuse_color)[:3]
            return Surface(self._define('diffuse', material.name_full, [('rgb', 'reflectance', color)]))
        output = surface_output(material.node_tree)
        source = _source(output.inputs['Surface']) if output else None
        if output and output.inputs['Volume'].is_linked:
            self._note('volumes are left out')
        if output and output.inputs['Displacement'].is_linked:
            self._note('displacement is left out')
        if source is None:
            return Surface()
        return self._shader(source[0], material.name_full)

    def _note(self, text):
        self.report.add(self.owner, text)

    # Materials

    def _define(self, kind, name, parameters):
        """Writes a material; textures of colours and numbers are told by their type. Returns its name."""
        text = [f'MakeNamedMaterial {pbrt.quoted(name)} {pbrt.parameter("string", "type", kind)}']
        for type_, key, value in parameters:
            if value is not None:
                is_texture = isinstance(value, str) and type_ in ('rgb', 'float')
                text.append(pbrt.parameter('texture' if is_texture else type_, key, value))
        self.write('\n  '.join(text))
        return name

    def _part(self):
        self.count += 1
        return f'{self.owner} part {self.count}'

    def _normals(self, node):
        """The parameters of a shader's normal map or bump map."""
        source = _source(_socket(node, 'Normal'))
        if source is None:
            return []
        maker = source[0]
        if maker.type == 'NORMAL_MAP' and maker.space == 'TANGENT':
            color = _source(maker.inputs['Color'])
            if color and color[0].type == 'TEX_IMAGE' and color[0].image:
                if abs(_constant(maker.inputs['Strength']) - 1) > 1e-3:
                    self._note('the strength of a normal map is taken as 1')
                path = self.images.path(color[0].image)
                return [('string', 'normalmap', path)] if path else []
        if maker.type == 'BUMP':
            height = self.number(maker.inputs['Height'])
            if isinstance(height, str):
                scale = _constant(maker.inputs['Distance']) * _constant(maker.inputs['Strength'])
                return [('float', 'displacement', self._scaled(height, -scale if maker.invert else scale, True))]
        self._note(f'{maker.bl_label} at a normal is left out')
        return []

    def _shader(self, node, name):
        recipe = getattr(self, '_' + node.type.lower(), None)
        if recipe:
            return recipe(node, name)
        color = _socket(node, 'Color', 'Base Color')
        self._note(f'{node.bl_label} is not supported' + (', replaced by a diffuse one' if color else ', left out'))
        if color is None:
            return Surface()
        return Surface(self._define('diffuse', name, [('rgb', 'reflectance', self.color(color))]))

    def _bsdf_diffuse(self, node, name):
        if self.number(node.inputs['Roughness']) != 0:
            self._note('the roughness of Diffuse BSDF is taken as 0')
        color = self.color(node.inputs['Color'])
        return Surface(self._define('diffuse', name, [('rgb', 'reflectance', color), *self._normals(node)]))

    def _bsdf_translucent(self, node, name):
        parameters = [('rgb', 'reflectance', _BLACK), ('rgb', 'transmittance', self.color(node.inputs['Color']))]
        return Surface(self._define('diffusetransmission', name, parameters + self._normals(node)))

    def _bsdf_glossy(self, node, name):
        """A metal whose reflectance at normal incidence is the colour."""
        return Surface(self._define('metallicroughness', name, [
            ('rgb', 'reflectance', self.color(node.inputs['Color'])), ('float', 'metallic', 1.0),
            ('float', 'roughness', self._roughness(node)), *self._normals(node)]))

    _bsdf_anisotropic = _bsdf_glossy

    def _roughness(self, node):
        """0 for the distribution 'sharp' of Blender before 4."""
        return 0.0 if getattr(node, 'distribution', '') == 'SHARP' else self.number(node.inputs['Roughness'])

    def _bsdf_glass(self, node, name, reflects=True):
        color = self.color(node.inputs['Color'])
        roughness = self._roughness(node)
        alpha = self._product(roughness, roughness) if isinstance(roughness, str) else roughness * roughness
        return Surface(self._define('dielectric', name, [
            ('float', 'eta', max(1.0, _mean(self._fixed(node.inputs['IOR'])))), ('float', 'roughness', alpha),
            ('bool', 'remaproughness', False), ('rgb', 'reflectance', color if reflects else _BLACK),
            ('rgb', 'transmittance', color), *self._normals(node)]))

    def _bsdf_refraction(self, node, name):
        return self._bsdf_glass(node, name, reflects=False)

    def _bsdf_transparent(self, node, name):
        color = self._fixed(node.inputs['Color'])
        if max(color) - min(color) < 1e-4:
            return Surface(alpha=1 - color[0])
        return Surface(self._define('thindielectric', name, [('float', 'eta', 1.0001), ('rgb', 'transmittance', color)]))

    def _emission(self, node, _name):
        return Surface(**self._light(node.inputs['Color'], node.inputs['Strength']))

    def _light(self, color, strength):
        """The radiance of an emission's colour and strength."""
        factor = max(0.0, _mean(self._fixed(strength)))
        source = _source(color)
        if source and source[0].type == 'TEX_IMAGE' and source[0].image and factor > 0:
            path = self.images.path(source[0].image, 'opaque')
            if path:
                return {'radiance': (factor,) * 3, 'image': path}
        value = self._fixed(color)
        value = value if isinstance(value, tuple) else (value,) * 3
        return {'radiance': tuple(max(0.0, c) * factor for c in value)}

    def _bsdf_principled(self, node, name):
        def get(*names):
            return self.number(_socket(node, *names))

        color = self.color(node.inputs['Base Color'])
        transmission = get('Transmission Weight', 'Transmission')
        eta, specular = self._reflectance_of(node, _mean(self._fixed(_socket(node, 'Transmission Weight', 'Transmission'))))
        parameters = [
            ('rgb', 'reflectance', color), ('float', 'metallic', get('Metallic')),
            ('float', 'roughness', get('Roughness')), ('float', 'eta', eta), ('float', 'specular', specular),
            ('float', 'transmission', transmission), ('float', 'clearcoat', get('Coat Weight', 'Clearcoat')),
            ('float', 'clearcoatroughness', get('Coat Roughness', 'Clearcoat Roughness')),
            ('float', 'anisotropy', get('Anisotropic')),
            ('float', 'anisotropyrotation', 360 * _mean(self._fixed(node.inputs['Anisotropic Rotation'])))]
        sheen = _mean(self._fixed(_socket(node, 'Sheen Weight', 'Sheen')))
        if sheen > 0:
            # A colour since Blender 4; before it, a share of the base colour's hue.
            tint = _constant(node.inputs['Sheen Tint'])
            parameters.append(('rgb', 'sheen', self._product(min(sheen, 1.0), tint if isinstance(tint, tuple) else _WHITE)))
        self._note_principled(node)
        emission = _socket(node, 'Emission Color', 'Emission')
        light = self._light(emission, node.inputs['Emission Strength'])
        alpha = get('Alpha')
        return Surface(self._define('metallicroughness', name, parameters + self._normals(node)), alpha=alpha, **light)

    def _note_principled(self, node):
        for names in _NOT_OF_PRINCIPLED:
            socket = _socket(node, *names)
            if socket is None:
                continue
            value = _constant(socket)
            if socket.is_linked or value not in (0.0, _WHITE):
                self._note(f'{socket.name} is left out')

    def _reflectance_of(self, node, transmission):
        """The index of refraction and the weight of the facets. In Blender 3 the index holds for transmission alone,
        and 0.08 times Specular is the reflectance at normal incidence. In Blender 4 the index sets it, and the level
        scales it by up to 2."""
        index = max(1.0, _mean(self._fixed(node.inputs['IOR'])))
        level = _mean(self._fixed(_socket(node, 'Specular IOR Level', 'Specular')))
        if transmission > 0.5:
            return index, 1.0
        old = 'Specular' in node.inputs
        f0 = 0.08 * level if old else ((index - 1) / (index + 1)) ** 2 * 2 * level
        root = math.sqrt(min(max(f0, 0.0), 0.9))
        return (1 + root) / (1 - root), 1.0 if root > 0 else 0.0

    def _mix_shader(self, node, name):
        factor = self.number(node.inputs[0])
        sides = []
        for socket in (node.inputs[1], node.inputs[2]):
            source = _source(socket)
            sides.append(self._shader(source[0], self._part()) if source else Surface())
        first, second = sides
        if factor in (0.0, 1.0):
            return sides[int(factor)]
        if self._is_clear(first):
            second.alpha = self._product(second.alpha, factor)
            return second
        if self._is_clear(second):
            first.alpha = self._product(first.alpha, self._opposite(factor))
            return first
        if first.alpha != 1 or second.alpha != 1:
            self._note('a mix of surfaces that are transparent in part is taken as opaque')
        share = _mean(factor) if not isinstance(factor, str) else 0.5
        if isinstance(factor, str) and (first.emits or second.emits):
            self._note('a textured mix with emission is taken as an even one')
        radiance = tuple(a * (1 - share) + b * share for a, b in zip(first.radiance, second.radiance))
        names = [side.name or self._define('diffuse', self._part(), [('rgb', 'reflectance', _BLACK)]) for side in sides]
        text = ' '.join(pbrt.quoted(part) for part in names)
        amount = pbrt.parameter('texture' if isinstance(factor, str) else 'float', 'amount', factor)
        self.write(f'MakeNamedMaterial {pbrt.quoted(name)} "string type" "mix" "string materials" [{text}] {amount}')
        return Surface(name, radiance=radiance, image=first.image or second.image)

    @staticmethod
    def _is_clear(surface):
        return not surface.name and not surface.emits and surface.alpha == 0

    def _add_shader(self, node, _name):
        sides = [self._shader(source[0], self._part()) for source in map(_source, node.inputs) if source]
        with_surface = [side for side in sides if side.name]
        if len(with_surface) > 1:
            self._note('Add Shader of two surfaces shows the first')
        out = with_surface[0] if with_surface else Surface()
        if not with_surface and any(self._is_clear(side) for side in sides):
            self._note('emission of a transparent surface is taken as opaque')
        out.radiance = tuple(sum(side.radiance[c] for side in sides) for c in range(3))
        out.image = next((side.image for side in sides if side.image), '')
        return out

    # Lamps and world

    def lamp_factors(self, tree):
        """By what a lamp's nodes multiply its colour."""
        output = next((node for node in tree.nodes if node.type == 'OUTPUT_LIGHT'), None)
        source = _source(output.inputs['Surface']) if output else None
        if source is None or source[0].type != 'EMISSION':
            self._note('nodes of a lamp other than Emission are left out')
            return _WHITE
        return self._light(source[0].inputs['Color'], source[0].inputs['Strength'])['radiance']

    def background(self, output):
        """The Background node of a world, the first of a mix; or None."""
        source = _source(output.inputs['Surface'])
        while source and source[0].type == 'MIX_SHADER':
            self._note('a mix of backgrounds shows the first')
            source = _source(source[0].inputs[1])
        if source and source[0].type != 'BACKGROUND':
            self._note(f'{source[0].bl_label} is left out')
        return source[0] if source and source[0].type == 'BACKGROUND' else None

    def environment_image(self, socket):
        """The file of an Environment Texture, and the matrix from directions of the world to its own; or None."""
        source = _source(socket)
        if source is None or source[0].type != 'TEX_ENVIRONMENT' or source[0].image is None:
            return None
        node = source[0]
        path = self.images.path(node.image)
        if path is None:
            self._note(f'the image {node.image.name} has no pixels')
            return None
        if node.projection != 'EQUIRECTANGULAR':
            self._note('a mirror ball is taken as an equirectangular image')
        vector = _source(node.inputs['Vector'])
        if vector is None or vector[0].type != 'MAPPING':
            return path, Matrix.Identity(4)
        turn = Euler(self._fixed(vector[0].inputs['Rotation'])).to_matrix().to_4x4()
        return path, turn.inverted() if vector[0].vector_type == 'TEXTURE' else turn

    def fixed_color(self, socket):
        value = self._fixed(socket)
        return value if isinstance(value, tuple) else (value,) * 3

    # Textures

    def _fixed(self, socket):
        """The value of an input that can't be a texture."""
        value = self._value(socket, isinstance(_constant(socket), float))
        if isinstance(value, str):
            self._note(f'a texture at {socket.name} is left out')
            return _constant(socket)
        return value

    def color(self, socket):
        """A colour, clamped to what a surface can reflect, or the name of a texture of colours."""
        value = self._value(socket, False)
        if isinstance(value, str):
            return value
        value = value if isinstance(value, tuple) else (value,) * 3
        return tuple(min(max(c, 0.0), 1.0) for c in value)

    def number(self, socket):
        """A number, or the name of a texture of numbers."""
        value = self._value(socket, True)
        return value if isinstance(value, str) else float(_mean(value))

    def _value(self, socket, is_float):
        source = _source(socket)
        if source is None:
            return _constant(socket)
        node, output = source
        recipe = getattr(self, '_from_' + node.type.lower(), None)
        value = recipe(node, output, is_float) if recipe else None
        if value is not None:
            return value
        self._note(f'{node.bl_label} is not supported: {socket.name} keeps its value')
        return _constant(socket)

    def _texture(self, is_float, kind, parameters):
        """Writes a texture, unless one like it exists. Returns its name."""
        text = ' '.join([pbrt.quoted('float' if is_float else 'spectrum'), pbrt.quoted(kind)] + parameters)
        if text not in self.textures:
            self.textures[text] = f'texture {len(self.textures) + 1}'
            self.write(f'Texture {pbrt.quoted(self.textures[text])} {text}')
        return self.textures[text]

    @staticmethod
    def _operand(name, value, is_float):
        if isinstance(value, str):
            return pbrt.parameter('texture', name, value)
        if is_float:
            return pbrt.parameter('float', name, _mean(value))
        return pbrt.parameter('rgb', name, value if isinstance(value, tuple) else (value,) * 3)

    def _product(self, a, b, is_float=True):
        if not isinstance(a, str) and not isinstance(b, str):
            if isinstance(a, tuple) or isinstance(b, tuple):
                a, b = (v if isinstance(v, tuple) else (v,) * 3 for v in (a, b))
                return tuple(x * y for x, y in zip(a, b))
            return a * b
        return self._texture(is_float, 'scale', [self._operand('tex', a, is_float), self._operand('scale', b, is_float)])

    def _scaled(self, texture, factor, is_float):
        return self._product(texture, float(factor), is_float)

    def _blend(self, a, b, amount, is_float):
        if not any(isinstance(v, str) for v in (a, b, amount)):
            if not isinstance(a, tuple) and not isinstance(b, tuple):
                return a * (1 - amount) + b * amount
            a, b = (v if isinstance(v, tuple) else (v,) * 3 for v in (a, b))
            return tuple(x * (1 - amount) + y * amount for x, y in zip(a, b))
        return self._texture(is_float, 'mix', [self._operand('tex1', a, is_float), self._operand('tex2', b, is_float),
                                               self._operand('amount', amount, True)])

    def _opposite(self, value):
        return self._blend(1.0, 0.0, value, True) if isinstance(value, str) else 1 - value

    def _from_rgb(self, node, output, _is_float):
        return tuple(output.default_value)[:3]

    def _from_value(self, node, output, _is_float):
        return float(output.default_value)

    def _from_tex_image(self, node, output, is_float):
        image = node.image
        from_alpha = output.name == 'Alpha'
        if image is None:
            return 0.0 if is_float else _BLACK
        uses_alpha = from_alpha or node.outputs['Alpha'].is_linked
        path = self.images.path(image, 'own' if uses_alpha and not (is_float and not from_alpha)
                                else 'grey' if is_float else 'opaque')
        if path is None:
            self._note(f'the image {image.name} has no pixels')
            return None
        if from_alpha and not has_alpha(image):
            return 1.0
        if node.projection != 'FLAT':
            self._note('a projected image is mapped by uv')
        space = image.colorspace_settings.name
        parameters = [pbrt.parameter('string', 'filename', path)]
        if not image.is_float:
            parameters.append(pbrt.parameter('string', 'encoding', 'sRGB' if space == 'sRGB' else 'linear'))
        wrap = {'REPEAT': 'repeat', 'EXTEND': 'clamp', 'CLIP': 'black'}.get(node.extension, 'repeat')
        parameters.append(pbrt.parameter('string', 'wrap', wrap))
        if node.interpolation == 'Closest':
            parameters.append(pbrt.parameter('string', 'filter', 'point'))
        return self._texture(is_float, 'imagemap', parameters + self._mapping(node))

    def _from_tex_checker(self, node, output, is_float):
        scale = _mean(self._fixed(node.inputs['Scale']))
        source = _source(node.inputs['Vector'])
        if source is None or (source[1].name != 'UV' and source[0].type not in ('UVMAP', 'MAPPING')):
            self._note('a checker in space is mapped by uv')
        if output.name in _FACTOR:
            colors = (1.0, 0.0) if is_float else (_WHITE, _BLACK)
        else:
            colors = [self._value(node.inputs[name], is_float) for name in ('Color1', 'Color2')]
        # Blender's first colour lies where the sum of the cells is odd.
        return self._texture(is_float, 'checkerboard', [
            self._operand('tex1', colors[1], is_float), self._operand('tex2', colors[0], is_float),
            *self._mapping(node, scale)])

    def _mapping(self, node, scale=1.0):
        """The parameters of a texture's place in uv."""
        source = _source(node.inputs['Vector'])
        size, offset = (scale, scale), (0.0, 0.0)
        if source and source[0].type == 'MAPPING':
            mapping = source[0]
            turn = tuple(self._fixed(mapping.inputs['Rotation']))
            if mapping.vector_type != 'POINT' or any(abs(angle) > 1e-6 for angle in turn):
                self._note('Mapping counts for its location and scale alone')
            size = tuple(scale * v for v in self._fixed(mapping.inputs['Scale'])[:2])
            offset = tuple(scale * v for v in self._fixed(mapping.inputs['Location'])[:2])
            source = _source(mapping.inputs['Vector'])
        if source and source[1].name not in ('UV', 'Vector'):
            self._note(f'a texture mapped by {source[1].name} is mapped by uv')
        out = []
        for name, value, standard in zip(('uscale', 'vscale', 'udelta', 'vdelta'), size + offset, (1, 1, 0, 0)):
            if value != standard:
                out.append(pbrt.parameter('float', name, float(value)))
        return out

    def _mix_of(self, mode, amount, a, b, is_float):
        if mode == 'MIX':
            return self._blend(a, b, amount, is_float)
        if mode == 'MULTIPLY':
            both = self._product(a, b, is_float)
            return both if amount == 1 else self._blend(a, both, amount, is_float)
        return None

    def _from_mix_rgb(self, node, _output, is_float):
        a, b = (self._value(node.inputs[name], is_float) for name in ('Color1', 'Color2'))
        return self._mix_of(node.blend_type, self.number(_socket(node, *_FACTOR)), a, b, is_float)

    def _from_mix(self, node, _output, is_float):
        """The node Mix, whose hidden inputs belong to other types of data."""
        ends = {'RGBA': 'RGBA', 'FLOAT': 'VALUE', 'VECTOR': 'VECTOR'}.get(node.data_type)
        if ends is None:
            return None
        a, b = (next(s for s in node.inputs if s.name == name and s.type == ends) for name in ('A', 'B'))
        amount = next(s for s in node.inputs if s.name == 'Factor' and s.type == 'VALUE')
        mode = node.blend_type if node.data_type == 'RGBA' else 'MIX'
        return self._mix_of(mode, self.number(amount), self._value(a, is_float), self._value(b, is_float), is_float)

    def _from_invert(self, node, _output, is_float):
        value = self._value(node.inputs['Color'], is_float)
        one, zero = (1.0, 0.0) if is_float else (_WHITE, _BLACK)
        if isinstance(value, str):
            amount = self.number(_socket(node, *_FACTOR))
            return self._blend(one, zero, value, True) if is_float and amount == 1 else None
        return tuple(1 - c for c in value) if isinstance(value, tuple) else 1 - value

    def _from_math(self, node, _output, _is_float):
        if node.operation != 'MULTIPLY':
            return None
        return self._product(self.number(node.inputs[0]), self.number(node.inputs[1]))

    def _from_rgbtobw(self, node, _output, is_float):
        return self.number(node.inputs['Color']) if is_float else None

    def _from_light_path(self, node, output, _is_float):
        """Light paths count as camera rays."""
        self._note('Light Path is taken as for camera rays')
        return 1.0 if output.name == 'Is Camera Ray' else 0.0
