"""The package: version, types, examples and notebooks."""
import json
import os
import pathlib
import subprocess
import sys

import pytest

import glowworm

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples" / "python"
TYPED_PROGRAM = """
import numpy as np
import glowworm

scene: glowworm.Scene = glowworm.Scene.load("builtin:cornell")
picture = glowworm.render(scene, size=(8, 8), aov=["depth"], progress=lambda share: None)
mean: float = float(picture["depth"].mean())
hits = glowworm.Tracer(scene).intersect(np.zeros((1, 3)), [[0, 0, 1]])
first: int = int(hits.triangle[0])
lux = glowworm.measure(scene, [[0.3, 0.1, 0.3]], [[0, 1, 0]], noise="5%")["illuminance"]
"""


def mypy(*arguments):
    return subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True)


def test_the_version_is_that_of_the_command_line(program):
    printed = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
    assert glowworm.__version__ in printed


def test_types_are_checked(tmp_path):
    package = str(pathlib.Path(glowworm.__file__).parent)
    cache = str(tmp_path / "cache")
    right, wrong = tmp_path / "right.py", tmp_path / "wrong.py"
    right.write_text(TYPED_PROGRAM)
    wrong.write_text(TYPED_PROGRAM.replace("size=(8, 8)", "size={8, 9}"))
    result = mypy("mypy", "--strict", "--cache-dir", cache, package, str(right))
    assert result.returncode == 0, result.stdout
    refused = mypy("mypy", "--strict", "--cache-dir", cache, str(wrong))
    assert refused.returncode == 1 and "size" in refused.stdout


def test_stubs_name_what_the_module_has(tmp_path):
    allowed = tmp_path / "allowed"
    # Made by pybind11 for every class, or names of types alone.
    allowed.write_text(r"""
glowworm\._glowworm\..*\.__(init|new)__
glowworm\._glowworm\.(Color|Count|Option|Path|Vector)
""")
    result = mypy("mypy.stubtest", "glowworm._glowworm", "--concise", "--allowlist", str(allowed))
    # Every class of pybind11 has a metaclass of its own.
    left = [line for line in result.stdout.splitlines() if "metaclass differs" not in line]
    assert left == [], result.stderr


def test_public_names_have_docstrings():
    for name in glowworm.__all__:
        if name != "__version__":
            assert getattr(glowworm, name).__doc__, name


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.name)
def test_examples_run(path, tmp_path):
    result = subprocess.run([sys.executable, path], cwd=tmp_path, capture_output=True, text=True, env=os.environ)
    assert result.returncode == 0, result.stderr
    assert result.stdout


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.ipynb")), ids=lambda path: path.name)
def test_notebooks_run(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    notebook = json.loads(path.read_text())
    assert notebook["nbformat"] == 4
    names = {}
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(cells) >= 3
    for cell in cells:
        assert cell["outputs"] == [], "outputs are not kept"
        exec(compile("".join(cell["source"]), str(path), "exec"), names)
