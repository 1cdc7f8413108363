"""Scenes: from files, built in, and from arrays."""
import numpy as np
import pytest
from conftest import TINY, square_builder

import glowworm


def test_built_in_scenes_load():
    assert "cornell" in glowworm.builtin_scenes()
    scene = glowworm.Scene.load("builtin:cornell")
    assert scene.name == "cornell"
    assert len(scene.cameras) >= 1
    with pytest.raises(glowworm.Error, match="Did you mean 'cornell'"):
        glowworm.Scene.load("builtin:cornel")


def test_files_load(tmp_path):
    path = tmp_path / "triangle.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = glowworm.Scene.load(str(path))
    assert scene.triangles.shape == (1, 3)
    path.write_text("v 0 0 zero\nf 1 2 3\n")
    with pytest.raises(glowworm.Error, match="triangle.obj:1"):
        glowworm.Scene.load(str(path))


def test_other_formats_are_read_by_the_program_beside_the_module(tmp_path):
    path = tmp_path / "triangle.off"
    path.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    assert glowworm.Scene.load(str(path)).triangles.shape == (1, 3)


def test_pictures_of_scenes_are_read_by_the_library_beside_the_module(tmp_path):
    glowworm.Picture({"image": np.full((2, 2, 3), 0.5)}).write(str(tmp_path / "grey.png"), exposure=0)
    assert glowworm.Picture.read(str(tmp_path / "grey.png")).image.shape == (2, 2, 3)


def test_geometry_is_a_view_of_the_scene(square):
    positions, triangles = square.positions, square.triangles
    np.testing.assert_array_equal(triangles, [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(positions[2], [1, 1, 0])
    np.testing.assert_array_equal(square.triangle_materials, [0, 0])
    assert square.materials == ["paint"]
    assert positions.base is square
    assert positions.__array_interface__["data"] == square.positions.__array_interface__["data"]
    with pytest.raises(ValueError, match="read-only"):
        positions[0, 0] = 1


def test_arrays_of_other_types_make_the_same_scene():
    def positions_of(corners, triangles):
        builder = glowworm.SceneBuilder()
        builder.add_material()
        builder.add_mesh(corners, triangles)
        return builder.build().positions

    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    wanted = positions_of(corners, [[0, 1, 2]])
    wide = np.zeros((3, 6))
    wide[:, ::2] = corners
    for other in (np.array(corners, dtype=np.float64), np.array(corners, dtype=np.int16), wide[:, ::2]):
        np.testing.assert_array_equal(positions_of(other, np.array([[0, 1, 2]], dtype=np.uint8)), wanted)


CORNERS = np.zeros((3, 3))
TRIANGLE = [[0, 1, 2]]


@pytest.mark.parametrize(
    "error, match, positions, triangles, others",
    [
        (ValueError, r"positions has shape \(4,\); expected \(n, 3\)", np.zeros(4), TRIANGLE, {}),
        (ValueError, r"positions has shape \(3, 2\)", np.zeros((3, 2)), TRIANGLE, {}),
        (TypeError, "positions has dtype <U1", [["a", "b", "c"]], TRIANGLE, {}),
        (TypeError, "positions has dtype complex128", CORNERS.astype(complex), TRIANGLE, {}),
        (TypeError, "positions has dtype object", None, TRIANGLE, {}),
        (ValueError, r"positions\[1, 2\] is nan", np.array([[0, 0, 0], [0, 0, np.nan]]), TRIANGLE, {}),
        (ValueError, r"positions\[0, 0\] is inf", np.array([[1e300, 0, 0]]), TRIANGLE, {}),
        (TypeError, "triangles has dtype float64; expected whole numbers", CORNERS, [[0.0, 1, 2]], {}),
        (ValueError, r"triangles has shape \(3,\)", CORNERS, [0, 1, 2], {}),
        (ValueError, r"triangles\[0, 1\] is -1", CORNERS, [[0, -1, 2]], {}),
        (glowworm.Error, "3", CORNERS, [[0, 1, 3]], {}),
        (ValueError, "there are 2 normals for 3 positions", CORNERS, TRIANGLE, {"normals": np.zeros((2, 3))}),
        (ValueError, r"radiance has shape \(2,\)", CORNERS, TRIANGLE, {"radiance": [1, 2]}),
        (glowworm.Error, "radiance", CORNERS, TRIANGLE, {"radiance": -1}),
        (glowworm.Error, "material 7", CORNERS, TRIANGLE, {"material": 7}),
        (TypeError, "", CORNERS, TRIANGLE, {"material": "paint"}),
    ],
)
def test_wrong_arrays_are_refused(builder, error, match, positions, triangles, others):
    with pytest.raises(error, match=match):
        builder.add_mesh(positions, triangles, **others)


def test_wrong_values_are_refused(builder):
    with pytest.raises(glowworm.Error, match=r"\[0, 1\]"):
        builder.add_material(color=1.5)
    with pytest.raises(ValueError, match="'mirror' is not one of diffuse, metal"):
        builder.add_material("mirror")
    with pytest.raises(glowworm.Error, match="intensity"):
        builder.add_point_light((0, 0, 1), -1)
    with pytest.raises(glowworm.Error, match="no length"):
        builder.add_directional_light((0, 0, 0), 1)
    with pytest.raises(glowworm.Error, match="angles"):
        builder.add_spot_light((0, 0, 1), (0, 0, -1), 1, inner_angle=50, outer_angle=40)
    with pytest.raises(ValueError, match="4 channels"):
        builder.set_environment(np.ones((2, 4, 4)))
    with pytest.raises(glowworm.Error, match="direction"):
        builder.add_camera(glowworm.Camera((0, 0, 1), (0, 0, 1)))
    with pytest.raises(ValueError, match="eye"):
        glowworm.Camera((0, np.inf, 1), (0, 0, 1))
    with pytest.raises(glowworm.Error, match="triangle"):
        glowworm.SceneBuilder().build()


def center(builder):
    picture = glowworm.render(builder.build(), **{**TINY, "samples": 64}, integrator="path", filter="off")
    return picture.image[3:5, 3:5].mean(axis=(0, 1))


def test_lights_shine_as_their_units_say():
    sun, point, spot, sky = (square_builder(color=1) for _ in range(4))
    sun.add_directional_light((0, 0, -3), (np.pi, 0, 2 * np.pi))
    np.testing.assert_allclose(center(sun), [1, 0, 2], rtol=0.01)
    point.add_point_light((0, 0, 2), 4 * np.pi)
    np.testing.assert_allclose(center(point), 1, rtol=0.01)
    spot.add_spot_light((0, 0, 2), (0, 0, -1), 4 * np.pi)
    np.testing.assert_allclose(center(spot), 1, rtol=0.01)
    image = np.zeros((8, 16, 3))
    image[:, :8] = 2  # the left half is x < 0
    sky.set_environment(image)
    np.testing.assert_allclose(center(sky), 1, rtol=0.05)


def test_every_kind_of_material_renders():
    for kind in ("diffuse", "metal", "glass", "glossy", "pane", "plastic"):
        builder = glowworm.SceneBuilder()
        material = builder.add_material(kind, color=(0.8, 0.6, 0.4), roughness=0.3, name=kind)
        builder.add_mesh([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], TRIANGLE, material=material)
        builder.set_environment(1)
        picture = glowworm.render(builder.build(), **TINY)
        assert np.isfinite(picture.image).all()
        assert picture.image.max() > 0.2, kind
