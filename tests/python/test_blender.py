"""The Blender add-on with stand-ins for Blender's nodes and lamps, whose inputs and properties differ between 3.4 and 5.

Names and defaults are those of Blender's Python API (docs.blender.org/api, 3.4, 4.5 and 5.0).
"""
import importlib
import math
import pathlib
import sys
import types

import pytest

ADD_ON = pathlib.Path(__file__).resolve().parents[2] / "addons" / "blender" / "glowworm"

WHITE = (1.0, 1.0, 1.0, 1.0)
# Inputs of Principled BSDF in both versions: what the two call differently, and what has the same name.
SAME = {"Base Color": (0.8, 0.6, 0.4, 1.0), "Metallic": 0.2, "Roughness": 0.3, "IOR": 1.5, "Alpha": 1.0, "Anisotropic": 0.1,
        "Anisotropic Rotation": 0.25, "Normal": (0.0, 0.0, 0.0), "Emission Strength": 2.0}
OF_3 = {"Subsurface": 0.0, "Specular": 0.5, "Specular Tint": 0.0, "Sheen": 0.4, "Sheen Tint": 0.5, "Clearcoat": 0.6,
        "Clearcoat Roughness": 0.1, "Transmission": 0.0, "Emission": (0.1, 0.2, 0.3, 1.0)}
OF_4 = {"Subsurface Weight": 0.0, "Specular IOR Level": 0.5, "Specular Tint": WHITE, "Sheen Weight": 0.4, "Sheen Roughness": 0.5,
        "Sheen Tint": WHITE, "Coat Weight": 0.6, "Coat Roughness": 0.1, "Coat IOR": 1.5, "Coat Tint": WHITE,
        "Transmission Weight": 0.0, "Emission Color": (0.1, 0.2, 0.3, 1.0), "Thin Film Thickness": 0.0, "Diffuse Roughness": 0.0}


class Socket:
    def __init__(self, name, value=0.0):
        self.name, self.default_value, self.links = name, value, []

    @property
    def is_linked(self):
        return bool(self.links)


class Node:
    def __init__(self, kind, inputs, **properties):
        self.type = self.bl_label = kind
        self.inputs = {name: Socket(name, value) for name, value in inputs.items()}
        self.__dict__.update(properties)


def link(node, socket, output=""):
    socket.links = [types.SimpleNamespace(from_node=node, from_socket=Socket(output))]


def material(node, **switch):
    """A material of one shader. switch: use_nodes, where the version of Blender has it."""
    output = Node("OUTPUT_MATERIAL", {"Surface": None, "Volume": None, "Displacement": None}, target="ALL", is_active_output=True)
    link(node, output.inputs["Surface"])
    return types.SimpleNamespace(name_full="made", node_tree=types.SimpleNamespace(nodes=[output]),
                                 diffuse_color=WHITE, **switch)


@pytest.fixture
def add_on(monkeypatch):
    """Modules of the add-on by their names."""
    mathutils = types.SimpleNamespace(Euler=None, Matrix=None, Vector=None)
    package = types.ModuleType("add_on")
    package.__path__ = [str(ADD_ON)]
    for name, module in (("bpy", types.ModuleType("bpy")), ("mathutils", mathutils), ("add_on", package)):
        monkeypatch.setitem(sys.modules, name, module)
    yield lambda name: importlib.import_module(f"add_on.{name}")
    for name in [name for name in sys.modules if name.startswith("add_on.")]:
        del sys.modules[name]


def read(add_on, made):
    """The text of a material, what it emits, and what is reported."""
    materials = add_on("materials")
    lines, report = [], materials.Report()
    surface = materials.Materials(lines.append, None, report).surface(made)
    return "\n".join(lines), surface, list(report)


def principled(inputs, **changed):
    return Node("BSDF_PRINCIPLED", {**SAME, **inputs, **{key.replace("_", " "): value for key, value in changed.items()}})


def test_principled_is_the_same_in_blender_3_and_4(add_on):
    old, surface, notes = read(add_on, material(principled(OF_3), use_nodes=True))
    new, other, new_notes = read(add_on, material(principled(OF_4)))
    assert surface.radiance == other.radiance == pytest.approx((0.2, 0.4, 0.6))
    assert notes == new_notes == []
    assert '"float clearcoat" [0.6' in old and '"float clearcoatroughness" [0.1' in old and '"rgb sheen" [0.4' in old
    # The reflectance at normal incidence is 4% in both: of 'Specular' 0.5, and of the index 1.5.
    assert new == old


def test_inputs_that_are_not_rendered_are_reported(add_on):
    _, _, old = read(add_on, material(principled(OF_3, Specular_Tint=0.5, Subsurface=0.2), use_nodes=True))
    assert old == ["made: Subsurface is left out", "made: Specular Tint is left out"]
    _, _, new = read(add_on, material(principled(OF_4, Coat_Tint=(1, 0, 0, 1), Subsurface_Weight=0.2, Diffuse_Roughness=0.5)))
    assert new == [f"made: {name} is left out" for name in ("Subsurface Weight", "Diffuse Roughness", "Coat Tint")]


def test_sheen_is_tinted_by_colours_alone(add_on):
    text, _, _ = read(add_on, material(principled(OF_4, Sheen_Tint=(1.0, 0.5, 0.25, 1.0))))
    assert '"rgb sheen" [0.4 0.2 0.1]' in text


def test_material_without_nodes(add_on):
    made = material(principled(OF_3), use_nodes=False)
    made.diffuse_color = (0.5, 0.25, 0.125, 1.0)
    text, _, _ = read(add_on, made)
    assert '[0.5 0.25 0.125]' in text and "metallicroughness" not in text


@pytest.mark.parametrize("factor", ["Fac", "Factor"])
def test_factor_has_two_names(add_on, factor):
    made = principled(OF_4)
    link(Node("INVERT", {factor: 1.0, "Color": (0.2, 0.4, 0.6, 1.0)}), made.inputs["Base Color"], "Color")
    text, _, _ = read(add_on, material(made))
    assert '"rgb reflectance" [0.8 0.6 0.4]' in text


def test_lamp_power(add_on):
    scene = add_on("scene")
    old = types.SimpleNamespace(energy=10.0, color=(1.0, 0.5, 0.25))
    assert scene.lamp_power(old) == (10.0, 5.0, 2.5) and scene.area_factor(old, 3.0) == 1.0
    new = types.SimpleNamespace(energy=10.0, color=(1.0, 0.5, 0.25), exposure=1.0, use_temperature=True,
                                temperature_color=(1.0, 0.8, 0.4), normalize=False)
    assert scene.lamp_power(new) == pytest.approx((20.0, 8.0, 2.0)) and scene.area_factor(new, 3.0) == 3.0
    new.use_temperature, new.normalize = False, True
    assert scene.lamp_power(new) == pytest.approx((20.0, 10.0, 5.0)) and scene.area_factor(new, math.pi) == 1.0
