"""measure(): sensors."""
import signal
import subprocess
import threading

import numpy as np
import pytest
from conftest import square_builder

import glowworm

QUICK = dict(samples=8, gather=16, photons=5000, progress=False)


@pytest.fixture(scope="module")
def sunny():
    """The square, lit by 2, 3 and 4 W m^-2 from above."""
    builder = square_builder()
    builder.add_directional_light((0, 0, -1), (2, 3, 4))
    return builder.build()


def test_measures_the_irradiance_of_the_sun_by_its_cosine(sunny):
    slope = np.sqrt(0.5)
    points = [[0, 0, 1], [0.2, 0.1, 1], [0, 0, 0.5]]
    measured = glowworm.measure(sunny, points, [[0, 0, 1], [0, slope, slope], [0, 0, -1]], **QUICK)
    assert measured["irradiance"].shape == (3, 3)
    np.testing.assert_allclose(measured["direct"][:2], np.outer([1, slope], [2, 3, 4]), rtol=1e-3)
    np.testing.assert_allclose(measured["direct"][2], 0, atol=1e-6)
    parts = measured["direct"] + measured["indirect"] + measured["caustic"]
    np.testing.assert_allclose(measured["irradiance"], parts, rtol=1e-5)
    # The square reflects 0.5, 0.25 and 1 of it; half a metre above it fills a share of the view in closed form.
    x = 1 / 0.5
    form_factor = 4 / np.pi * x / np.hypot(1, x) * np.arctan(x / np.hypot(1, x))
    np.testing.assert_allclose(measured["indirect"][2], form_factor * np.array([1, 0.75, 4]), rtol=0.15)
    luminance = measured["irradiance"] @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(measured["illuminance"], 179 * luminance, rtol=1e-3)
    assert measured["relative_error"].shape == (3,)


def test_measures_as_the_command_line_does(program, cornell, tmp_path):
    points = np.array([[0.1, 0.4, 0.1], [0.3, 0.45, 0.3], [0.45, 0.4, 0.2]], dtype=np.float32)
    normals = np.tile(np.float32([0, 1, 0]), (3, 1))
    np.savetxt(tmp_path / "sensors.pts", np.concatenate([points, normals], axis=1), fmt="%.9g")
    words = "--samples 4 --gather 9 --photons 5000 -q -o".split()
    command = [program, "measure", "builtin:cornell", "--points", "sensors.pts", *words, "lux.csv"]
    subprocess.run(command, cwd=tmp_path, check=True)
    theirs = np.loadtxt(tmp_path / "lux.csv", delimiter=",", comments=["#", "x"])
    ours = glowworm.measure(cornell, points, normals, samples=4, gather=9, photons=5000, progress=False)
    # The table has six digits, of the error three.
    np.testing.assert_allclose(ours["irradiance"], theirs[:, 7:10], rtol=1e-5)
    np.testing.assert_allclose(ours["illuminance"], theirs[:, 10], rtol=1e-5)
    np.testing.assert_allclose(ours["relative_error"], theirs[:, 11], rtol=1e-2)


def test_error_of_light_that_was_not_found_is_unknown(sunny):
    options = dict(samples=2, gather=4, photons=1000, progress=False)
    measured = glowworm.measure(sunny, [[0, 0, -1]], [[0, 0, -1]], **options)
    assert measured["illuminance"][0] == 0
    assert measured["relative_error"][0] == np.inf


def test_refuses_wrong_sensors(sunny):
    up = [[0, 0, 1]]
    for match, points, normals in [
        ("there are no sensors", np.zeros((0, 3)), np.zeros((0, 3))),
        ("normal 0 has length 2", up, [[0, 0, 2]]),
        ("normal 0 has length 0", up, [[0, 0, 0]]),
    ]:
        with pytest.raises(glowworm.Error, match=match):
            glowworm.measure(sunny, points, normals, **QUICK)
    with pytest.raises(ValueError, match=r"points\[0, 1\] is nan"):
        glowworm.measure(sunny, [[0, np.nan, 0]], up, **QUICK)
    with pytest.raises(ValueError, match="there are 2 normals for 1 points"):
        glowworm.measure(sunny, up, up * 2, **QUICK)
    with pytest.raises(glowworm.Error, match="two samples"):
        glowworm.measure(sunny, up, up, **{**QUICK, "samples": 1})


def test_ctrl_c_and_progress_end_it(sunny):
    endless = {**QUICK, "samples": 1_000_000}
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        glowworm.measure(sunny, [[0, 0, 1]], [[0, 0, 1]], **endless)
    timer.join()

    def stop(share):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        glowworm.measure(sunny, [[0, 0, 1]], [[0, 0, 1]], **{**endless, "progress": stop})


@pytest.fixture(scope="module")
def weather(tmp_path_factory):
    """A day of a weather file, overcast but for noon."""
    rows = ["LOCATION,Munich,-,DEU,made up,0,48.13,11.70,1,529"] + 6 * ["HEADER"]
    rows.append("DATA PERIODS,1,1,Data,Sunday,6/21,6/21")
    for hour in range(1, 25):
        direct, diffuse = 700 * (hour == 12), 100 * (8 < hour < 17)
        rows.append(f"1999,6,21,{hour},60,?9,20,10,50,95000,0,0,300,0,{direct},{diffuse},0,0")
    path = tmp_path_factory.mktemp("weather") / "a.epw"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def test_finds_the_daylight_of_a_year(sunny, weather):
    # The square stands upright; sensors before it face the sky and the square.
    points, normals = [[0, 0, 1], [0, 0, 0.2]], [[0, 1, 0], [0, 0, -1]]
    year = glowworm.daylight(sunny, weather, points, normals, samples=4, hours="8-16", progress=False)
    assert year["illuminance"].shape == year["sun"].shape == (2, 24)
    assert year["hours"][11].tolist() == [6, 21, 12]
    assert year["useful"].shape == (2, 4)
    np.testing.assert_allclose(year["useful"].sum(axis=1), 1, rtol=1e-6)
    np.testing.assert_allclose(year["mean"], year["illuminance"][:, 8:16].mean(axis=1), rtol=1e-5)
    assert year["illuminance"][0, 11] > 2 * year["illuminance"][0, 12] > 0
    assert year["sun"][0, 11] > 0 and year["sun"][0, 12] == 0
    assert year["sun_hours"].tolist() == [1, 0]
    assert year["sDA"] == 1 and year["ASE"] == 0
    with pytest.raises(glowworm.Error, match="`occupied` has 2 hours"):
        glowworm.daylight(sunny, weather, points, normals, occupied=[0, 1], progress=False)
    with pytest.raises(glowworm.Error, match="names no hours"):
        glowworm.daylight(sunny, weather, points, normals, hours="9", progress=False)


def test_the_north_of_a_year_turns_to_the_left(sunny, weather):
    quick = dict(samples=4, photons=5000, progress=False)
    south = glowworm.daylight(sunny, weather, [[0, 0, 1]], [[0, 0, 1]], **quick)["sun"]
    turned = glowworm.daylight(sunny, weather, [[0, 0, 1]], [[1, 0, 0]], turn=90, **quick)["sun"]
    assert south[0, 11] > 10_000
    np.testing.assert_allclose(turned, south, rtol=1e-4)


def test_rates_views_over_a_year(sunny, weather):
    up = glowworm.Camera([0, 0, 1], [0, 1, 1], [0, 0, 1], field_of_view=180, projection="fisheye")
    options = {"view_pixels": 16, "photons": 20000, "gather": 8, "progress": False}
    year = glowworm.annual_glare(sunny, weather, [up], hours="11-12", **options)
    assert year["hours"][11].tolist() == [6, 21, 12]
    (view,) = year["views"]
    assert view["dgp"].shape == view["illuminance_error"].shape == (24,)
    sensor = glowworm.daylight(sunny, weather, [[0, 0, 1]], [[0, 1, 0]], samples=4, progress=False)["illuminance"][0]
    np.testing.assert_allclose(view["illuminance"][8:16], sensor[8:16], rtol=0.1)
    assert view["dgp"][0] == view["dgp_error"][0] == 0
    assert view["exceeded"] == pytest.approx(view["dgp"][11])
    assert view["perceptible"] == view["intolerable"] == (1 if view["dgp"][11] > 0.45 else 0)
    assert (view["illuminance_error"][8:16] > 0).all()
    with pytest.raises(glowworm.Error, match="half space before an eye"):
        glowworm.annual_glare(sunny, weather, [glowworm.Camera([0, 0, 1], [0, 1, 1], [0, 0, 1])], **options)
