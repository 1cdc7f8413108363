import os
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

Color = Union[float, Sequence[float], NDArray[Any]]
Path = Union[str, "os.PathLike[str]"]
Count = Union[int, float, str]
Option = Union[bool, int, float, str, Sequence[Any], "os.PathLike[str]", None]
Vector = Union[Sequence[float], NDArray[Any]]

class Error(RuntimeError):
    code: str
    place: Optional[Tuple[str, int, int]]

def set_threads(threads: int) -> None: ...
def builtin_scenes() -> List[str]: ...
def aov_names() -> List[str]: ...
def _render_option_names() -> List[str]: ...
def _measure_option_names() -> List[str]: ...
def _bake_option_names() -> List[str]: ...
def _compare(picture: Picture, reference: Picture, layer: str, leave_out: float) -> Dict[str, Any]: ...

def _measure(
    scene: Scene,
    points: ArrayLike,
    normals: ArrayLike,
    on_surfaces: bool,
    progress: Optional[Callable[[float], Any]],
    **kwargs: Option,
) -> Dict[str, NDArray[np.float32]]: ...

def _daylight(
    scene: Scene,
    weather: str,
    points: ArrayLike,
    normals: ArrayLike,
    given: Dict[str, Any],
    progress: Optional[Callable[[float], Any]],
    **kwargs: Option,
) -> Dict[str, Any]: ...
def _annual_glare(
    scene: Scene,
    weather: str,
    views: Sequence[Camera],
    given: Dict[str, Any],
    progress: Optional[Callable[[float], Any]],
    **kwargs: Option,
) -> Dict[str, Any]: ...
def _bake(
    scene: Scene,
    path: Path,
    format: str,
    light: str,
    atlas: Count,
    texels_per_metre: float,
    exposure: Optional[float],
    allow_outside: bool,
    progress: Optional[Callable[[float], Any]],
    **kwargs: Option,
) -> None: ...

class Camera:
    eye: Any
    target: Any
    up: Any
    field_of_view: float
    orthographic_size: float
    lens_radius: float
    focal_distance: float
    name: str
    projection: str
    def __init__(
        self,
        eye: Vector,
        target: Vector,
        up: Vector = ...,
        *,
        field_of_view: float = ...,
        orthographic_size: float = ...,
        lens_radius: float = ...,
        focal_distance: float = ...,
        name: str = ...,
        projection: str = ...,
    ) -> None: ...

class Scene:
    @staticmethod
    def load(path: Path, **kwargs: Option) -> Scene: ...
    @property
    def name(self) -> str: ...
    @property
    def cameras(self) -> List[str]: ...
    @property
    def materials(self) -> List[str]: ...
    @property
    def notes(self) -> List[str]: ...
    @property
    def positions(self) -> NDArray[np.float32]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def triangle_materials(self) -> NDArray[np.uint32]: ...
    @property
    def lights(self) -> List[str]: ...
    def with_lights(self, edits: Dict[str, Dict[str, Any]]) -> Scene: ...
    def with_camera(self, camera: Camera) -> Scene: ...

class SceneBuilder:
    def __init__(self, name: str = ...) -> None: ...
    def add_material(
        self,
        kind: str = ...,
        *,
        color: Color = ...,
        roughness: float = ...,
        metallic: float = ...,
        ior: float = ...,
        color_texture: Optional[int] = ...,
        name: str = ...,
        inside: Optional[int] = ...,
        outside: Optional[int] = ...,
        unseen: bool = ...,
    ) -> int: ...
    def add_medium(
        self,
        absorption: Union[Color, ArrayLike] = ...,
        scattering: Union[Color, ArrayLike] = ...,
        *,
        g: float = ...,
        emission: Union[Color, ArrayLike] = ...,
        box: Optional[ArrayLike] = ...,
        density: Optional[ArrayLike] = ...,
        name: str = ...,
    ) -> int: ...
    def set_ambient_medium(self, medium: int) -> None: ...
    def add_texture(self, image: ArrayLike) -> int: ...
    def add_mesh(
        self,
        positions: ArrayLike,
        triangles: ArrayLike,
        *,
        material: int = ...,
        normals: Optional[ArrayLike] = ...,
        uvs: Optional[ArrayLike] = ...,
        radiance: Optional[Color] = ...,
        two_sided: bool = ...,
        name: str = ...,
    ) -> None: ...
    def add_instances(
        self,
        positions: ArrayLike,
        triangles: ArrayLike,
        transforms: ArrayLike,
        *,
        material: int = ...,
        normals: Optional[ArrayLike] = ...,
        uvs: Optional[ArrayLike] = ...,
        radiance: Optional[Color] = ...,
        two_sided: bool = ...,
        name: str = ...,
    ) -> None: ...
    def add_point_light(self, position: Vector, intensity: Color) -> None: ...
    def add_spot_light(
        self,
        position: Vector,
        direction: Vector,
        intensity: Color,
        *,
        inner_angle: float = ...,
        outer_angle: float = ...,
    ) -> None: ...
    def add_directional_light(self, direction: Vector, irradiance: Color) -> None: ...
    def set_environment(self, radiance: Union[Color, ArrayLike]) -> None: ...
    def add_camera(self, camera: Camera) -> None: ...
    def build(self) -> Scene: ...

class Picture:
    _statistics: Dict[str, Any]
    def __init__(self, layers: Dict[str, Any]) -> None: ...
    @staticmethod
    def read(path: Path) -> Picture: ...
    def write(self, path: Path, exposure: Optional[float] = ..., precision: str = ...) -> None: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def place(self) -> Tuple[int, int, int, int]: ...
    @property
    def metadata(self) -> Dict[str, str]: ...
    @property
    def statistics(self) -> Dict[str, Any]: ...
    @property
    def automatic_exposure(self) -> float: ...
    @property
    def image(self) -> NDArray[np.float32]: ...
    def keys(self) -> List[str]: ...
    def channels(self, layer: str = ...) -> str: ...
    def png(self, layer: str = ..., exposure: Optional[float] = ...) -> bytes: ...
    def _repr_png_(self) -> Optional[bytes]: ...
    def __getitem__(self, layer: str) -> NDArray[np.float32]: ...
    def __contains__(self, layer: str) -> bool: ...

class _FrameSequence:
    def __init__(self, scene: Scene, cameras: Sequence[Camera], **kwargs: Option) -> None: ...
    def render(self, frame: int, progress: Optional[Callable[[float], Any]]) -> Picture: ...

class _Render:
    def __init__(self, scene: Scene, **kwargs: Option) -> None: ...
    def cancel(self) -> None: ...
    def wait(self) -> None: ...
    def wait_for(self, seconds: float) -> bool: ...
    def done(self) -> bool: ...
    def cancelled(self) -> bool: ...
    def progress(self) -> float: ...
    def picture(self) -> Picture: ...
    def statistics(self) -> str: ...

@final
class Photons:
    @property
    def positions(self) -> NDArray[np.float32]: ...
    @property
    def directions(self) -> NDArray[np.float32]: ...
    @property
    def flux(self) -> NDArray[np.float32]: ...
    @property
    def normals(self) -> NDArray[np.float32]: ...
    @property
    def emitted(self) -> int: ...
    def __len__(self) -> int: ...

def trace_photons(scene: Scene, *, photons: Count = ..., seed: Count = ..., caustic: bool = ...) -> Photons: ...

class PhotonMap:
    def __init__(
        self,
        scene: Scene,
        *,
        photons: Count = ...,
        seed: Count = ...,
        nearest: Count = ...,
        kernel: str = ...,
        boundary_correction: bool = ...,
        engine: str = ...,
    ) -> None: ...
    def irradiance(self, points: ArrayLike, normals: ArrayLike) -> NDArray[np.float32]: ...
    def radiance(self, points: ArrayLike, normals: ArrayLike) -> NDArray[np.float32]: ...
    @property
    def emitted(self) -> int: ...
    def __len__(self) -> int: ...

class DensityIndex:
    def __init__(
        self,
        positions: ArrayLike,
        flux: ArrayLike,
        radii: ArrayLike,
        *,
        normals: Optional[ArrayLike] = ...,
        kernel: str = ...,
        engine: str = ...,
    ) -> None: ...
    def sum(self, points: ArrayLike, normals: Optional[ArrayLike] = ...) -> NDArray[np.float32]: ...
    def __len__(self) -> int: ...

def photon_radii(positions: ArrayLike, k: Count = ...) -> NDArray[np.float32]: ...

@final
class Hits:
    @property
    def distance(self) -> NDArray[np.float32]: ...
    @property
    def triangle(self) -> NDArray[np.int32]: ...
    @property
    def barycentric(self) -> NDArray[np.float32]: ...
    @property
    def normal(self) -> NDArray[np.float32]: ...
    def __len__(self) -> int: ...

class Tracer:
    def __init__(self, scene: Scene) -> None: ...
    def intersect(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: float = ...,
        t_max: Optional[ArrayLike] = ...,
    ) -> Hits: ...
    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: float = ...,
        t_max: Optional[ArrayLike] = ...,
    ) -> NDArray[np.bool_]: ...
