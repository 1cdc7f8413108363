"""Builds the Python module by CMake for `pip install .`; pyproject.toml has the rest."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent
# What the module starts, beside it.
COMPANIONS = ["bin/glowworm-reader", "bin/glowworm-assimp", "bin/glowworm-openvdb"]


class CMakeBuild(build_ext):
    """Builds the module in build/pip, or in the folder that GLOWWORM_BUILD names, and copies it."""

    def build_extension(self, extension):
        build = pathlib.Path(os.environ.get("GLOWWORM_BUILD", ROOT / "build" / "pip")).resolve()
        configure = ["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", f"-DPython3_EXECUTABLE={sys.executable}"]
        if not (build / "build.ninja").exists():
            configure += ["-DCMAKE_BUILD_TYPE=Release", "-DGLOWWORM_BUILD_TESTS=OFF", "-DGLOWWORM_BUILD_BENCHMARKS=OFF"]
        subprocess.run(configure, check=True)
        targets = ["glowworm_python", "glowworm_reader", "glowworm_assimp", "glowworm_openvdb"]
        subprocess.run(["cmake", "--build", build, "--target", *targets], check=True)
        target = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(build / "python" / "glowworm" / target.name, target)
        for companion in COMPANIONS:
            shutil.copy(build / companion, target.parent)


version = re.search(r"project\(glowworm VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
setup(version=version, ext_modules=[Extension("glowworm._glowworm", sources=[])], cmdclass={"build_ext": CMakeBuild})
