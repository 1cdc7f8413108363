"""Photons, photon maps, density estimation and rays."""
import gc
import signal
import threading

import numpy as np
import pytest
from conftest import square_builder

import glowworm


@pytest.fixture(scope="module")
def sunny():
    """The square, lit by 2, 3 and 4 W m^-2 from above."""
    builder = square_builder()
    builder.add_directional_light((0, 0, -1), (2, 3, 4))
    return builder.build()


def test_photons_carry_the_power_that_arrives(sunny):
    photons = glowworm.trace_photons(sunny, photons=20_000)
    assert len(photons) >= 20_000
    assert photons.positions.shape == photons.flux.shape == (len(photons), 3)
    np.testing.assert_allclose(photons.flux.sum(axis=0, dtype=float), [8, 12, 16], rtol=0.05)
    np.testing.assert_allclose(photons.normals, np.broadcast_to([0, 0, 1], photons.normals.shape))
    np.testing.assert_allclose(photons.directions[0], [0, 0, 1])
    assert photons.emitted >= len(photons)
    assert len(glowworm.trace_photons(sunny, photons=1000, caustic=True)) == 0


def test_photon_arrays_are_views(sunny):
    photons = glowworm.trace_photons(sunny, photons=1000)
    for name in ("positions", "directions", "flux", "normals"):
        array = getattr(photons, name)
        assert array.base is photons
        assert array.__array_interface__["data"] == getattr(photons, name).__array_interface__["data"]
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 0
    flux = photons.flux
    kept = flux.copy()
    del photons, array
    gc.collect()
    np.testing.assert_array_equal(flux, kept)


def test_a_photon_map_shows_irradiance_and_radiance(sunny):
    photon_map = glowworm.PhotonMap(sunny, photons=100_000, nearest=500)
    points = np.array([[0, 0, 0], [0.3, -0.2, 0]])
    up = np.array([[0, 0, 1], [0, 0, 1]])
    irradiance = photon_map.irradiance(points, up)
    np.testing.assert_allclose(irradiance, [[2, 3, 4]] * 2, rtol=0.1)
    np.testing.assert_allclose(photon_map.radiance(points, up), irradiance * [0.5, 0.25, 1] / np.pi, rtol=1e-5)
    assert (photon_map.irradiance(points, -up) == 0).all()
    assert len(photon_map) >= 100_000
    with pytest.raises(glowworm.Error, match="point 0 is not on a surface"):
        photon_map.radiance(points + [0, 0, 0.5], up)
    with pytest.raises(glowworm.Error, match="normal 1 has length 2"):
        photon_map.irradiance(points, up * [[1], [2]])
    with pytest.raises(ValueError, match="there are 1 normals for 2 points"):
        photon_map.irradiance(points, up[:1])
    with pytest.raises(ValueError, match=r"points\[1, 0\] is nan"):
        photon_map.irradiance([[0, 0, 0], [np.nan, 0, 0]], up)
    with pytest.raises(glowworm.Error, match="kernel 'triangle'"):
        glowworm.PhotonMap(sunny, kernel="triangle")
    with pytest.raises(glowworm.Error, match="engine 'fast'"):
        glowworm.PhotonMap(sunny, engine="fast")


def test_counts_may_be_texts_and_floats(sunny):
    wanted = glowworm.trace_photons(sunny, photons=1000, seed=3).positions
    for photons in (1e3, "1k"):
        np.testing.assert_array_equal(glowworm.trace_photons(sunny, photons=photons, seed=3.0).positions, wanted)
    for wrong in (1.5, -1, "many", 2**70):
        with pytest.raises(ValueError, match="photons"):
            glowworm.trace_photons(sunny, photons=wrong)
    with pytest.raises(ValueError, match="seed is more than"):
        glowworm.trace_photons(sunny, seed="1e10")


@pytest.mark.parametrize("engine", ["blocked", "forward", "reverse", "knn", "brute"])
def test_irradiance_is_right_up_to_edges(sunny, engine):
    photons = 2_000 if engine == "brute" else 50_000
    photon_map = glowworm.PhotonMap(sunny, photons=photons, nearest=photons // 250, engine=engine)
    along = np.linspace(-0.98, 0.98, 100)
    for depth in (0.0005, 0.03, 0.06):
        edge = np.full(100, 1 - depth)
        x, y = np.concatenate([edge, -edge, along, along]), np.concatenate([along, along, edge, -edge])
        points = np.stack([x, y, 0 * x], axis=1)
        found = photon_map.irradiance(points, np.broadcast_to([0, 0, 1], points.shape)).mean(axis=0)
        # Some fifty discs of so many photons lie along the edges: a standard error of 1 to 2%, 5% with few photons.
        np.testing.assert_allclose(found, [2, 3, 4], rtol=0.15 if engine == "brute" else 0.05, err_msg=str(depth))


@pytest.mark.parametrize("kind", ["diffuse", "metal", "glossy", "plastic", "glass"])
def test_irradiance_does_not_depend_on_the_material(kind):
    builder = glowworm.SceneBuilder("floor")
    corners = [[-2, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]]
    color = 0.0 if kind == "diffuse" else 0.8
    paint = builder.add_material(kind, color=color, roughness=0.05)
    builder.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], material=paint)
    builder.add_point_light([0, 1, 0], 2.0)
    scene = builder.build()
    # Below the light: its intensity over the square of its distance.
    photon_map = glowworm.PhotonMap(scene, photons=50_000, nearest=1000)
    np.testing.assert_allclose(photon_map.irradiance([[0, 0, 0]], [[0, 1, 0]]), [[2, 2, 2]], rtol=0.1)
    assert len(glowworm.trace_photons(scene, photons=1000)) >= 1000


def test_density_agrees_with_a_double_loop():
    random = np.random.default_rng(7)
    positions, points = random.random((500, 3)), random.random((50, 3))
    flux = random.random((500, 3))
    radii = glowworm.photon_radii(positions, k=20)
    assert radii.shape == (500,)
    distance = np.linalg.norm(points[:, None] - positions[None], axis=2) / radii
    weight = np.where(distance < 1, 3 / np.pi * (1 - distance), 0) / radii**2
    index = glowworm.DensityIndex(positions, flux, radii, kernel="cone")
    np.testing.assert_allclose(index.sum(points), weight @ flux, rtol=1e-3, atol=1e-2)
    assert glowworm.DensityIndex(positions, flux, 0.1).sum(np.zeros((0, 3))).shape == (0, 3)
    with pytest.raises(ValueError, match="there are 3 radii for 500 positions"):
        glowworm.DensityIndex(positions, flux, [1, 2, 3])
    with pytest.raises(glowworm.Error, match="radius"):
        glowworm.DensityIndex(positions, flux, 0)


def test_rays_hit_the_square(square):
    tracer = glowworm.Tracer(square)
    origins = np.array([[0.5, 0.5, 3], [0.5, 0.5, 3], [5, 0, 3]])
    directions = np.array([[0, 0, -2], [0, 0, 1], [0, 0, -1]])
    hits = tracer.intersect(origins, directions)
    assert len(hits) == 3
    np.testing.assert_allclose(hits.distance, [1.5, np.inf, np.inf])
    assert hits.triangle.tolist()[1:] == [-1, -1]
    np.testing.assert_allclose(hits.normal, [[0, 0, 1], [0, 0, 0], [0, 0, 0]])
    a, b, c = square.positions[square.triangles[hits.triangle[0]]]
    u, v = hits.barycentric[0]
    np.testing.assert_allclose(a * (1 - u - v) + b * u + c * v, [0.5, 0.5, 0], atol=1e-6)
    assert hits.distance is hits.distance and hits.normal is hits.normal, "no copies"
    occluded = tracer.occluded(origins, directions)
    assert occluded.dtype == bool and occluded.tolist() == [True, False, False]
    assert not tracer.occluded(origins, directions, t_max=1.4).any()
    assert tracer.occluded(origins, directions, t_max=[1.6, 1, 1]).tolist() == [True, False, False]
    for infinite in (np.inf, [np.inf] * 3):
        assert tracer.occluded(origins, directions, t_max=infinite).tolist() == [True, False, False]
        np.testing.assert_array_equal(tracer.intersect(origins, directions, t_max=infinite).distance, hits.distance)
    assert tracer.intersect(origins, directions, t_min=1.6).triangle[0] == -1


def test_hits_do_not_depend_on_threads_and_outlive_the_tracer(cornell):
    random = np.random.default_rng(3)
    origins = 0.1 + 0.35 * random.random((20_000, 3))
    directions = random.normal(size=origins.shape)
    directions[5000:15_000] = [0.3, 0.2, 1] + 0.001 * np.arange(10_000)[:, None] * [0.1, 0.02, 0]
    origins[5000:15_000] = origins[5000]
    found = []
    try:
        for threads in (1, 3):
            glowworm.set_threads(threads)
            found.append(glowworm.Tracer(cornell).intersect(origins, directions))
    finally:
        glowworm.set_threads(0)
    gc.collect()
    for name in ("distance", "triangle", "barycentric", "normal"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))
    hit = found[0].triangle >= 0
    assert hit.mean() > 0.5
    corners = cornell.positions[cornell.triangles[found[0].triangle[hit]]].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    np.testing.assert_allclose(found[0].normal[hit], normals, atol=1e-5)
    assert len(glowworm.Tracer(cornell).intersect(np.zeros((0, 3)), np.zeros((0, 3)))) == 0


def test_wrong_rays_are_refused(square):
    tracer = glowworm.Tracer(square)
    with pytest.raises(ValueError, match="there are 1 directions for 2 origins"):
        tracer.intersect(np.zeros((2, 3)), np.ones((1, 3)))
    with pytest.raises(glowworm.Error, match="ray 1 has no length"):
        tracer.occluded(np.zeros((2, 3)), [[0, 0, 1], [0, 0, 0]])
    with pytest.raises(ValueError, match=r"directions\[0, 2\] is nan"):
        tracer.occluded(np.zeros((1, 3)), [[0, 0, np.nan]])
    for intersect in (tracer.intersect, tracer.occluded):
        with pytest.raises(ValueError, match=r"origins\[1, 0\] is inf"):
            intersect([[0, 0, 0], [np.inf, 0, 0]], np.ones((2, 3)))
        with pytest.raises(glowworm.Error, match="t_min"):
            intersect(np.zeros((1, 3)), np.ones((1, 3)), t_min=-1)
    with pytest.raises(TypeError, match="origins has dtype bool"):
        tracer.intersect(np.zeros((1, 3), dtype=bool), [[0, 0, 1]])
    with pytest.raises(ValueError, match="3 values of t_max for 2 origins"):
        tracer.intersect(np.zeros((2, 3)), np.ones((2, 3)), t_max=[1, 2, 3])
    with pytest.raises(ValueError, match=r"t_max\[1\] is nan"):
        tracer.intersect(np.zeros((2, 3)), np.ones((2, 3)), t_max=[np.inf, np.nan])
    with pytest.raises(glowworm.Error, match="ray 0 has no length"):
        tracer.intersect(np.zeros((1, 3)), np.zeros((1, 3)), t_max=np.inf)


def test_ctrl_c_ends_photon_tracing(cornell):
    for work in (glowworm.trace_photons, glowworm.PhotonMap):
        timer = threading.Timer(0.2, signal.raise_signal, [signal.SIGINT])
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            work(cornell, photons=20_000_000)
        timer.join()
