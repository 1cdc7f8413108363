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
import copy
import inspect
import json
import math
import os
import sys
import time
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, TypeVar, Union

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
    _bake_option_names,
    _compare,
    _annual_glare,
    _daylight,
    _FrameSequence,
    _measure,
    _measure_option_names,
    _Render,
    _render_option_names,
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
    "annual_glare",
    "aov_names",
    "bake",
    "builtin_scenes",
    "compare",
    "daylight",
    "measure",
    "photon_radii",
    "render",
    "render_frames",
    "set_threads",
    "trace_photons",
]

Option = Union[bool, int, float, str, Sequence[Any], "os.PathLike[str]", None]
"""A value of an option of the command line."""

Progress = Union[bool, Callable[[float], Any], None]

_INTERVAL = 0.05  # seconds between two looks at signals and progress


_Function = TypeVar("_Function", bound=Callable[..., Any])


def _with_options(names: List[str]) -> Callable[[_Function], _Function]:
    """Shows the options of a command in a function's signature, in place of **options."""

    def show(function: _Function) -> _Function:
        own = inspect.signature(function)
        parameters = [p for p in own.parameters.values() if p.kind is not inspect.Parameter.VAR_KEYWORD]
        for name in (name.replace("-", "_") for name in names):
            if name not in own.parameters:
                parameters.append(inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None))
        setattr(function, "__signature__", own.replace(parameters=parameters))
        return function

    return show


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

    def __init__(self, scene: Scene, *, camera: Union[str, Camera, None] = None, **options: Option) -> None:
        if isinstance(camera, Camera):
            scene, camera = _with_camera(scene, camera)
        self._render = _Render(scene, camera=camera, **options)

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
    named = copy.copy(camera)
    named.name = name
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


@_with_options(_render_option_names())
def render(
    scene: Scene, *, progress: Progress = None, camera: Union[str, Camera, None] = None, **options: Option
) -> Picture:
    """Renders a scene and returns its picture.

    The keywords are the options of `glowworm render`, and take the same values, texts such as "10k" too; `glowworm
    render --help` explains them. None leaves the choice to Glowworm. The most used are:

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
    job = Render(scene, camera=camera, **options)
    with _shown(progress) as show:
        job.wait(progress=show)
    return job.picture()


@_with_options(_render_option_names())
def render_frames(
    scene: Scene, cameras: Sequence[Camera], *, progress: Progress = None, **options: Option
) -> Iterator[Picture]:
    """Renders a still scene from one camera after another, and yields the pictures.

    Frames share photons, which are traced once for all cameras. A frame is the same, bit for bit, whichever others are
    rendered. progress is called with the finished share of each frame. The other keywords are render()'s.
    """
    sequence = _FrameSequence(scene, list(cameras), **options)
    for frame in range(len(cameras)):
        with _shown(progress) as show:
            picture = sequence.render(frame, show)
        yield picture


@_with_options(_measure_option_names())
def measure(
    scene: Scene,
    points: ArrayLike,
    normals: ArrayLike,
    *,
    on_surfaces: bool = False,
    progress: Progress = None,
    **options: Option,
) -> Dict[str, NDArray[np.float32]]:
    """Measures the light that arrives at sensors from the half space around their normals, as `glowworm measure` does.

    points: (m, 3), metres. normals: (m, 3), unit. on_surfaces: the sensors lie on surfaces of the scene, so that
    photons show caustics there. The other keywords are render()'s.

    Returns irradiance (m, 3), W m^-2, and its parts direct (from lights), indirect (from surfaces) and caustic (through
    glass and by mirrors); illuminance (m,), lx by 179 lm/W; and relative_error (m,), the error of the illuminance
    over itself, of which twice holds the truth with a chance of 95%, or inf where no sample found light. Raises Error
    for sensors inside of solid objects.
    """
    with _shown(progress) as show:
        return _measure(scene, points, normals, on_surfaces, show, **options)


@_with_options(_measure_option_names())
def daylight(
    scene: Scene,
    weather: Union[str, "os.PathLike[str]"],
    points: ArrayLike,
    normals: ArrayLike,
    *,
    hours: str = "8-18",
    occupied: Optional[Sequence[int]] = None,
    shades: Sequence[Scene] = (),
    shade_of_hour: Optional[Sequence[int]] = None,
    area: Optional[ArrayLike] = None,
    on_surfaces: bool = False,
    sky_patches: int = 145,
    ground: float = 0.2,
    sun_step: float = 7.5,
    turn: float = 0,
    autonomy_lux: float = 300,
    sun_lux: float = 1000,
    sun_hours: float = 250,
    useful: Sequence[float] = (100, 300, 3000),
    glare: float = 0.4,
    progress: Progress = None,
    **options: Option,
) -> Dict[str, Any]:
    """Finds the daylight of a year at sensors, as `glowworm daylight` does. The scene's own lights are off.

    weather: a weather file (EPW). points: (m, 3), metres. normals: (m, 3), unit. hours: the occupied hours of every day,
    in standard time, or occupied: 0 or 1 for each hour of the file. shades: scenes in other states of their shades, and
    shade_of_hour: 0 for scene, or n for the n-th of them, for each hour. area: m^2 around each sensor, for sDA and ASE.
    ground: reflectance of the ground outside. turn: degrees from -z to north, to the left. Of the other keywords,
    samples (two a round), photons, gather, nearest, noise, time, seed and memory have an effect; `glowworm daylight
    --help` explains all of them.

    Returns hours (h, 3): month, day and hour, which ends then; illuminance (m, h), lx; sun (m, h), the part of the sun
    without any bounce; for each sensor and the occupied hours mean (lx), autonomy (share of hours with autonomy_lux),
    continuous, useful (m, 4), sun_hours, and glare (share of hours with a simplified DGP of `glare` or more, for level
    normals); daylight_factor; relative_error of the mean, of which twice holds the truth with a chance of 95%; and for
    the area the shares sDA (autonomy of half of the hours) and ASE (more than sun_hours with sun_lux of direct sun).
    """
    given: Dict[str, Any] = {
        "hours": hours,
        "occupied": None if occupied is None else [int(hour) for hour in occupied],
        "shades": list(shades),
        "shade_of_hour": shade_of_hour,
        "area": area,
        "on_surfaces": on_surfaces,
        "sky_patches": sky_patches,
        "ground": ground,
        "sun_step": sun_step,
        "turn": turn,
        "autonomy_lux": autonomy_lux,
        "sun_lux": sun_lux,
        "sun_hours": sun_hours,
        "useful": list(useful),
        "glare": glare,
    }
    with _shown(progress) as show:
        return _daylight(scene, os.fspath(weather), points, normals, given, show, **options)


@_with_options(_measure_option_names())
def annual_glare(
    scene: Scene,
    weather: Union[str, "os.PathLike[str]"],
    views: Sequence[Camera],
    *,
    hours: str = "8-18",
    occupied: Optional[Sequence[int]] = None,
    shades: Sequence[Scene] = (),
    shade_of_hour: Optional[Sequence[int]] = None,
    sky_patches: int = 145,
    ground: float = 0.2,
    sun_step: float = 7.5,
    turn: float = 0,
    view_pixels: int = 128,
    progress: Progress = None,
    **options: Option,
) -> Dict[str, Any]:
    """Rates the glare of views in every hour of a year by their luminances, as `glowworm daylight --views` does.

    views: cameras with projection "fisheye" or "hemispherical" and a field_of_view of 180. view_pixels: along a
    side of their pictures. photons, gather, seed and memory have an effect; the rest is as for daylight().

    Returns hours (h, 3), as daylight() does, and views, a dictionary for each: dgp (h), the daylight glare probability;
    illuminance (h), lx on the plane across the view; dgp_error and illuminance_error (h), standard errors (the truth lies
    within twice the error with a chance of 95%); exceeded, the DGP that 5% of the occupied hours exceed; and the numbers of
    occupied hours with a DGP above 0.35, 0.40 and 0.45: perceptible, disturbing and intolerable.
    """
    given: Dict[str, Any] = {
        "hours": hours,
        "occupied": None if occupied is None else [int(hour) for hour in occupied],
        "shades": list(shades),
        "shade_of_hour": shade_of_hour,
        "sky_patches": sky_patches,
        "ground": ground,
        "sun_step": sun_step,
        "turn": turn,
        "view_pixels": view_pixels,
    }
    with _shown(progress) as show:
        return _annual_glare(scene, os.fspath(weather), list(views), given, show, **options)


@_with_options(_bake_option_names())
def bake(
    scene: Scene,
    path: Union[str, "os.PathLike[str]"],
    *,
    format: str = "emissive",
    light: str = "all",
    atlas: Union[int, float, str] = 0,
    texels_per_metre: float = 0.0,
    exposure: Optional[float] = None,
    allow_outside: bool = False,
    progress: Progress = None,
    **options: Option,
) -> None:
    """Writes a scene with its light in textures as a GLB file, as `glowworm bake` does.

    format: "emissive", "unlit", "lightmap" or "vertex". light: "all", or "indirect": the viewer adds direct light
    to a lightmap. atlas: side of an atlas in texels; texels_per_metre: their density; 0 leaves both to Glowworm.
    exposure: stops, by which values are multiplied as 2^exposure; None maps their mean to grey. allow_outside: the file
    may hold content of files outside of the scene file's folder. The other keywords are render()'s; samples count in
    each texel.
    """
    with _shown(progress) as show:
        _bake(scene, path, format, light, atlas, texels_per_metre, exposure, allow_outside, show, **options)


def _picture(value: Any, layer: str) -> Picture:
    if isinstance(value, Picture):
        return value
    if isinstance(value, (str, os.PathLike)):
        return Picture.read(value)
    return Picture({layer: value})


def compare(picture: Any, reference: Any, *, layer: str = "image", leave_out: float = 0.0) -> Dict[str, Any]:
    """Measures how far a picture I is from its reference R, as `glowworm compare` does.

    Both are a Picture, an array of shape (height, width, 3), or the path of a file. leave_out is the share of the
    pixels with the largest error that the means of squares leave out. Returns mse, relative_mse (over R^2 + 0.01),
    relative_rmse, psnr_db, luminance_ratio and rgb_ratio (mean of I over mean of R), largest_difference, pixels and
    pixels_not_finite.
    """
    return _compare(_picture(picture, layer), _picture(reference, layer), layer, leave_out)
