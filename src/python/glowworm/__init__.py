"""Glowworm: global illumination from photon maps.

Radiance is linear RGB (Rec. 709) in W sr^-1 m^-2, flux is in W, irradiance in W m^-2, lengths are metres.

    import glowworm
    scene = glowworm.Scene.load("builtin:cornell")
    picture = glowworm.render(scene, size=(256, 256), aov=["albedo", "depth"])
    picture.write("cornell.png")
    picture["depth"]  # an array of shape (256, 256)
"""
from __future__ import annotations

import contextlib
import json
import math
import os
import sys
import time
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

from ._glowworm import (
    Camera,
    DensityIndex,
    Error,
    Hits,
    PhotonMap,
    Photons,
    Picture,
    Scene,
    SceneBuilder,
    Tracer,
    __version__,
    _bake,
    _compare,
    _measure,
    _Render,
    aov_names,
    builtin_scenes,
    photon_radii,
    set_threads,
    trace_photons,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Camera",
    "DensityIndex",
    "Error",
    "Hits",
    "PhotonMap",
    "Photons",
    "Picture",
    "Render",
    "Scene",
    "SceneBuilder",
    "Tracer",
    "__version__",
    "aov_names",
    "bake",
    "builtin_scenes",
    "compare",
    "measure",
    "photon_radii",
    "render",
    "set_threads",
    "trace_photons",
]

Progress = Union[bool, Callable[[float], Any], None]

_INTERVAL = 0.05  # seconds between two looks at signals and progress


def _text(value: Any) -> str:
    """The text of an option on the command line."""
    if isinstance(value, (list, tuple)):
        return ",".join(str(part) for part in value)
    return str(value)


def _options(given: Dict[str, Any]) -> List[Tuple[str, str]]:
    """Keywords as options of the command line; those that are None or False are left out."""
    out = []
    for key, value in given.items():
        # The only option with a word for yes and no: all others are flags.
        if key == "filter" and isinstance(value, bool):
            value = "auto" if value else "off"
        if value is None or value is False:
            continue
        if key == "size" and not isinstance(value, str):
            width, height = value
            value = f"{width}x{height}"
        out.append((key.replace("_", "-"), "" if value is True else _text(value)))
    return out


class _Bar:
    """A bar on standard error."""

    WIDTH = 40

    def __call__(self, share: float) -> None:
        full = int(share * self.WIDTH)
        print(f"\r[{'=' * full}{' ' * (self.WIDTH - full)}] {100 * share:3.0f}%", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        print("\r\033[K", end="", file=sys.stderr, flush=True)


class Render:
    """A render in a thread of its own.

    Takes the options of render(). The methods may be called at any time, from any thread.
    """

    def __init__(self, scene: Scene, *, camera: Union[str, Camera, None] = None, **options: Any) -> None:
        if isinstance(camera, Camera):
            scene, camera = _with_camera(scene, camera)
        self._render = _Render(scene, _options({"camera": camera, **options}))

    def cancel(self) -> None:
        """Stops the render after the task under way."""
        self._render.cancel()

    def wait(self, seconds: Optional[float] = None, progress: Optional[Callable[[float], Any]] = None) -> bool:
        """Waits for the end, but no longer than this, and returns whether it is done.

        Raises the render's error. Calls progress with the finished share, in [0, 1]. If that raises, or on Ctrl-C, the
        render is cancelled and the exception is raised.
        """
        try:
            end = math.inf if seconds is None else time.monotonic() + seconds
            while not self._render.wait_for(max(0, min(end - time.monotonic(), _INTERVAL))):
                if progress is not None:
                    progress(self._render.progress())
                if time.monotonic() >= end:
                    return False
        except BaseException:
            self._render.cancel()
            self._render.wait()
            raise
        self._render.wait()
        return True

    @property
    def done(self) -> bool:
        return self._render.done()

    @property
    def cancelled(self) -> bool:
        """Whether cancel() ended it."""
        return self._render.cancelled()

    @property
    def progress(self) -> float:
        """Finished share of the work, in [0, 1]."""
        return self._render.progress()

    def picture(self) -> Picture:
        """The picture so far, or the finished one. Black where nothing is rendered yet."""
        picture = self._render.picture()
        if self._render.done():
            picture._statistics = self.statistics()
        return picture

    def statistics(self) -> Dict[str, Any]:
        """Settings, counts and times. Call it after the render has ended."""
        statistics: Dict[str, Any] = json.loads(self._render.statistics())
        return statistics


def _with_camera(scene: Scene, camera: Camera) -> Tuple[Scene, str]:
    """The scene with one more camera, and that one's name in it."""
    name = camera.name or "camera"  # no name would be the scene's first camera
    while name in scene.cameras:
        name += "'"
    named = Camera(
        camera.eye,
        camera.target,
        camera.up,
        field_of_view=camera.field_of_view,
        orthographic_size=camera.orthographic_size,
        lens_radius=camera.lens_radius,
        focal_distance=camera.focal_distance,
        name=name,
    )
    return scene.with_camera(named), name


def _shows_progress() -> bool:
    """Whether standard error is a terminal or a notebook."""
    return sys.stderr.isatty() or "ipykernel" in sys.modules


@contextlib.contextmanager
def _shown(progress: Progress) -> Iterator[Optional[Callable[[float], Any]]]:
    """The function that shows progress, or None."""
    if callable(progress):
        yield progress
    elif progress or (progress is None and _shows_progress()):
        bar = _Bar()
        try:
            yield bar
        finally:
            bar.close()
    else:
        yield None


def render(
    scene: Scene,
    *,
    progress: Progress = None,
    size: Union[Tuple[int, int], str, None] = None,
    crop: Optional[Sequence[float]] = None,
    pixel_bounds: Optional[Sequence[int]] = None,
    part: Optional[str] = None,
    camera: Union[str, Camera, None] = None,
    aov: Union[str, Sequence[str], None] = None,
    integrator: Optional[str] = None,
    engine: Optional[str] = None,
    kernel: Optional[str] = None,
    radius: Optional[str] = None,
    reorder: Optional[int] = None,
    filter: Union[bool, str, None] = None,
    seed: Optional[int] = None,
    light_groups: bool = False,
    indirect_only: bool = False,
    progressive: bool = False,
    no_gather_guiding: bool = False,
    no_adaptive: bool = False,
    no_secondary_gather: bool = False,
    no_guiding: bool = False,
    samples: Union[int, str, None] = None,
    gather: Union[int, str, None] = None,
    photons: Union[int, str, None] = None,
    traced: Union[int, str, None] = None,
    nearest: Optional[int] = None,
    prefer: Optional[str] = None,
    time: Union[float, str, None] = None,
    noise: Union[float, str, None] = None,
    memory: Union[int, str, None] = None,
    disk: Optional[str] = None,
    share: Optional[str] = None,
) -> Picture:
    """Renders a scene and returns its picture.

    The keywords are the options of `glowworm render`, and take the same values; `glowworm render --help` explains
    them. None leaves the choice to Glowworm. The most used are:

    size: (width, height) in pixels.
    crop: (x0, y0, x1, y1), the part to render, as fractions from the upper left corner.
    camera: a name of scene.cameras, or a Camera.
    aov: layers beside the image, names of aov_names().
    integrator: "gather" (photon maps), "path" (path tracing, the reference) or "photons" (the map shown directly).
    samples: camera samples of each pixel; gather: final gather rays of each; photons: in the map.
    time: seconds after which it stops, or "5m"; noise: relative standard error at which it stops.
    memory: bytes beside the scene, or "4G".

    progress: None shows a bar on a terminal and in a notebook, True always, False never. A function is called with the
    finished share, in [0, 1]; if it raises, the render ends and the exception is raised. Ctrl-C ends the render and
    raises KeyboardInterrupt. Other Python threads run meanwhile. Raises Error for settings that make no sense.
    """
    options = dict(locals())
    del options["scene"], options["progress"]
    job = Render(scene, **options)
    with _shown(progress) as show:
        job.wait(progress=show)
    return job.picture()


def measure(
    scene: Scene,
    points: ArrayLike,
    normals: ArrayLike,
    *,
    on_surfaces: bool = False,
    progress: Progress = None,
    samples: Union[int, str, None] = None,
    gather: Union[int, str, None] = None,
    photons: Union[int, str, None] = None,
    nearest: Optional[int] = None,
    integrator: Optional[str] = None,
    engine: Optional[str] = None,
    seed: Optional[int] = None,
    time: Union[float, str, None] = None,
    noise: Union[float, str, None] = None,
    memory: Union[int, str, None] = None,
) -> Dict[str, NDArray[np.float32]]:
    """Measures the light that arrives at sensors from the half space around their normals, as `glowworm measure` does.

    points: (m, 3), metres. normals: (m, 3), unit. on_surfaces: the sensors lie on surfaces of the scene, so that
    photons show caustics there. The other keywords are those of render().

    Returns irradiance (m, 3), W m^-2, and its parts direct (from lights), indirect (from surfaces) and caustic (through
    glass and by mirrors); illuminance (m,), lx by 179 lm/W; and relative_error (m,), the error of the illuminance
    over itself, of which twice holds the truth with a chance of 95%. Raises Error for sensors inside of solid objects.
    """
    options = dict(locals())
    for name in ("scene", "points", "normals", "on_surfaces", "progress"):
        del options[name]
    with _shown(progress) as show:
        return _measure(scene, points, normals, _options(options), on_surfaces, show)


def bake(
    scene: Scene,
    path: Union[str, "os.PathLike[str]"],
    *,
    format: str = "emissive",
    light: str = "all",
    atlas: int = 0,
    texels_per_metre: float = 0.0,
    exposure: Optional[float] = None,
    allow_outside: bool = False,
    progress: Progress = None,
    samples: Union[int, str, None] = None,
    gather: Union[int, str, None] = None,
    photons: Union[int, str, None] = None,
    nearest: Optional[int] = None,
    integrator: Optional[str] = None,
    engine: Optional[str] = None,
    filter: Union[bool, str, None] = None,
    seed: Optional[int] = None,
    time: Union[float, str, None] = None,
    noise: Union[float, str, None] = None,
    memory: Union[int, str, None] = None,
) -> None:
    """Writes a scene with its light in textures as a GLB file, as `glowworm bake` does.

    format: "emissive", "unlit", "lightmap" or "vertex". light: "all", or "indirect": the viewer adds direct light
    to a lightmap. atlas: side of an atlas in texels; texels_per_metre: their density; 0 leaves both to Glowworm.
    exposure: stops, by which values are multiplied as 2^exposure; None maps their mean to grey. allow_outside: the file
    may hold content of files outside of the scene file's folder. The other keywords are those of render(); samples are those of each texel.
    """
    options = dict(locals())
    for name in ("scene", "path", "format", "light", "atlas", "texels_per_metre", "exposure", "allow_outside", "progress"):
        del options[name]
    with _shown(progress) as show:
        _bake(
            scene,
            os.fspath(path),
            _options(options),
            format,
            light,
            atlas,
            texels_per_metre,
            exposure,
            allow_outside,
            show,
        )


def _picture(value: Any, layer: str) -> Picture:
    if isinstance(value, Picture):
        return value
    if isinstance(value, (str, os.PathLike)):
        return Picture.read(os.fspath(value))
    return Picture({layer: value})


def compare(picture: Any, reference: Any, *, layer: str = "image", leave_out: float = 0.0) -> Dict[str, Any]:
    """Measures how far a picture I is from its reference R, as `glowworm compare` does.

    Both are a Picture, an array of shape (height, width, 3), or the path of a file. leave_out is the share of the
    pixels with the largest error that the means of squares leave out. Returns mse, relative_mse (over R^2 + 0.01),
    relative_rmse, psnr_db, luminance_ratio and rgb_ratio (mean of I over mean of R), largest_difference, pixels and
    pixels_not_finite.
    """
    return _compare(_picture(picture, layer), _picture(reference, layer), layer, leave_out)
