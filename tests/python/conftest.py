"""Scenes for tests of the Python module."""
import os

import numpy as np
import pytest

import glowworm


def square_builder(color=(0.5, 0.25, 1.0)):
    """A builder with a square of side 2 at z = 0, facing +z, and a camera that looks at it from z = 2."""
    builder = glowworm.SceneBuilder("square")
    paint = builder.add_material("diffuse", color=color, name="paint")
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float32)
    builder.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], material=paint, name="square")
    builder.add_camera(glowworm.Camera((0, 0, 2), (0, 0, 0), field_of_view=20))
    return builder


@pytest.fixture
def builder():
    return square_builder()


@pytest.fixture(scope="session")
def square():
    """The square under a white sky."""
    made = square_builder()
    made.set_environment(1.0)
    return made.build()


@pytest.fixture(scope="session")
def cornell():
    return glowworm.Scene.load("builtin:cornell")


@pytest.fixture(scope="session")
def program():
    """The path of the command line."""
    return os.environ["GLOWWORM_PROGRAM"]


TINY = dict(size=(8, 8), samples=4, gather=4, photons=1000, progress=False)
"""Options of a render that takes milliseconds."""
ENDLESS = dict(size=(64, 64), samples=1_000_000, photons=1000, progress=False)
"""Options of a render that takes hours."""
