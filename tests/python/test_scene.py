"""Scenes: from files, built in, and from arrays."""
import pickle

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


def test_instances_are_meshes_at_many_places():
    grid = np.stack(np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), [0.0]), -1).reshape(-1, 3)
    at = np.arange(72).reshape(8, 9)[:, :8].reshape(-1)
    triangles = np.concatenate([np.stack([at, at + 1, at + 10], -1), np.stack([at, at + 10, at + 9], -1)])
    places = np.tile(np.eye(4), (5, 1, 1))
    places[:, 2, 3] = range(5)
    builder = glowworm.SceneBuilder()
    builder.add_material()
    builder.add_instances(grid, triangles, places, name="shelf")
    builder.add_instances(grid, triangles, places[:, :3] + [0, 0, 0, 3])
    scene = builder.build()
    assert len(scene.triangles) == 10 * 128
    # The first place of each is a copy, and comes before all instances.
    heights = np.array([0, 3, 1, 2, 3, 4, 4, 5, 6, 7])
    np.testing.assert_allclose(scene.positions[:, 2].reshape(10, 81), np.repeat(heights[:, None], 81, 1))
    with pytest.raises(ValueError, match="transforms are not of shape"):
        builder.add_instances(grid, triangles, places[0])


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
    with pytest.raises(glowworm.Error, match="'mirror' is not known\\n  Choose from: diffuse, metal"):
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


def test_cameras_can_be_pickled():
    camera = glowworm.Camera(
        (0, 1, 5), (0, 0, 0), field_of_view=25, lens_radius=0.5, focal_distance=3, name="main", projection="fisheye"
    )
    read = pickle.loads(pickle.dumps(camera))
    for member in ("field_of_view", "orthographic_size", "lens_radius", "focal_distance", "name", "projection"):
        assert getattr(read, member) == getattr(camera, member)
    np.testing.assert_array_equal(read.eye, camera.eye)


def test_options_of_loading_change_a_scene(tmp_path):
    path = tmp_path / "square.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    turned = glowworm.Scene.load(path, up="z", scale=0.5, studio_light=False)
    np.testing.assert_allclose(turned.positions, [[0, 0, 0], [0.5, 0, 0], [0, 0, -0.5]])
    assert turned.lights == [] and any("no light" in note for note in turned.notes)
    assert len(glowworm.Scene.load(path).lights) == 1, "the studio light"
    assert glowworm.Scene.load(path, environment=(1, 2, 3)).lights == ["environment"]
    assert len(glowworm.Scene.load(path, sky="cie:16").lights) == 1
    with pytest.raises(glowworm.Error, match="Did you mean 'scale'"):
        glowworm.Scene.load(path, scal=2)
    with pytest.raises(glowworm.Error, match="neither y nor z"):
        glowworm.Scene.load(path, up="x")


def test_lights_are_edited(builder):
    builder.add_point_light((0, 0, 1), 4)
    scene = builder.build()
    (lamp,) = scene.lights
    options = dict(size=(8, 8), samples=4, photons=1000, integrator="path", progress=False)
    image = glowworm.render(scene, **options).image
    np.testing.assert_allclose(glowworm.render(scene.with_lights({lamp: {"scale": 2}}), **options).image, 2 * image, rtol=1e-5)
    assert not glowworm.render(scene.with_lights({lamp: {"on": False}}), **options).image.any()
    moved = glowworm.render(scene.with_lights({lamp: {"move": (0, 0, 1)}}), **options).image
    np.testing.assert_allclose(moved[4, 4], image[4, 4] / 4, rtol=0.1)
    with pytest.raises(glowworm.Error, match="lamp"):
        scene.with_lights({"lamp": {}})
    with pytest.raises(ValueError, match="colour"):
        scene.with_lights({lamp: {"colour": 1}})


def test_textures_colour_surfaces():
    builder = glowworm.SceneBuilder()
    texels = [[[1, 0, 0], [0, 1, 0]], [[0, 0, 1], [1, 1, 1]]]
    texture = builder.add_texture(texels)
    paint = builder.add_material(color=0.5, color_texture=texture)
    corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    builder.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], uvs=[[0, 0], [1, 0], [1, 1], [0, 1]], material=paint)
    builder.add_camera(glowworm.Camera((0, 0, 5), (0, 0, 0), orthographic_size=2))
    albedo = glowworm.render(builder.build(), size=(2, 2), samples=64, photons=1000, aov="albedo", progress=False)["albedo"]
    # Over a texel its own weight is 3/4 on average, in both directions.
    weight = np.array([[0.75, 0.25], [0.25, 0.75]])
    np.testing.assert_allclose(albedo, 0.5 * np.einsum("ia,jb,abc->ijc", weight, weight, texels), atol=0.02)
    with pytest.raises(glowworm.Error, match="texture 7 of 1"):
        builder = glowworm.SceneBuilder()
        builder.add_texture(np.ones((1, 1, 3)))
        builder.add_material(color_texture=7)
    with pytest.raises(glowworm.Error, match="out of range"):
        builder.add_texture(np.full((1, 1, 3), 2.0))


def test_media_fill_boxes_and_bodies():
    def builder():
        out = glowworm.SceneBuilder()
        out.add_medium(0.1, (1, 2, 3), g=0.5, emission=2, name="fog")
        return out

    made = builder()
    grid = np.arange(24, dtype=np.float32).reshape(2, 3, 4)
    smoke = made.add_medium(1, np.ones((2, 3, 4, 3)), density=grid, box=[[0, 0, 0], [4, 3, 2]])
    assert smoke == 1
    made.set_ambient_medium(0)
    made.add_material("interface", inside=smoke, outside=0)
    made.add_material("glass", inside=-1)
    made.add_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert made.build().triangles.shape == (1, 3)
    for match, mistake in [
        ("medium 3 of 1", lambda b: b.add_material(inside=3)),
        ("medium 3 of 1", lambda b: b.set_ambient_medium(3)),
        ("g = 1", lambda b: b.add_medium(1, 1, g=1)),
        ("sigma_s of", lambda b: b.add_medium(1, -1)),
        ("density is -1", lambda b: b.add_medium(1, 1, density=-np.ones((1, 1, 1)), box=[[0, 0, 0], [1, 1, 1]])),
        ("grid without a box", lambda b: b.add_medium(1, 1, density=np.ones((1, 1, 1)))),
        ("fills a box", lambda b: b.add_medium(1, 1, box=[[0, 0, 0], [1, 0, 1]])),
    ]:
        with pytest.raises(glowworm.Error, match=match):
            mistake(builder())
    with pytest.raises(ValueError, match="another number of cells"):
        builder().add_medium(np.ones((1, 1, 2, 3)), 1, density=grid, box=[[0, 0, 0], [1, 1, 1]])
