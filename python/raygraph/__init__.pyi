from os import PathLike
from typing import Any, Callable, Iterable, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
__all__: list[str]

_Path = Union[str, "PathLike[str]"]
_Vec3 = Tuple[float, float, float]
_Vec4 = Tuple[float, float, float, float]

class Error(Exception):
    kind: str

class Device:
    def __init__(self, select: str = "", *, validation: bool = False) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def driver(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def validation_messages(self) -> int: ...

class Progress:
    @property
    def samples(self) -> int: ...
    @property
    def samples_wanted(self) -> Optional[int]: ...
    @property
    def samples_per_second(self) -> float: ...
    @property
    def relative_error(self) -> Optional[float]: ...
    @property
    def seconds_left(self) -> Optional[float]: ...

class Node:
    name: str
    matrix: NDArray[np.float64]
    translation: _Vec3
    rotation: _Vec4
    scale: _Vec3
    visible: bool
    @property
    def index(self) -> int: ...
    @property
    def world_matrix(self) -> NDArray[np.float64]: ...
    @property
    def parent(self) -> Optional[Node]: ...

class Material:
    alpha_cutoff: float
    alpha_mode: str
    anisotropy_rotation: float
    anisotropy_strength: float
    anisotropy_texture: Optional[NDArray[np.uint8]]
    attenuation_color: _Vec3
    attenuation_distance: float
    base_color_factor: _Vec4
    base_color_texture: Optional[NDArray[np.uint8]]
    clearcoat_factor: float
    clearcoat_normal_scale: float
    clearcoat_normal_texture: Optional[NDArray[np.uint8]]
    clearcoat_roughness_factor: float
    clearcoat_roughness_texture: Optional[NDArray[np.uint8]]
    clearcoat_texture: Optional[NDArray[np.uint8]]
    diffuse_transmission_color_factor: _Vec3
    diffuse_transmission_color_texture: Optional[NDArray[np.uint8]]
    diffuse_transmission_factor: float
    diffuse_transmission_texture: Optional[NDArray[np.uint8]]
    dispersion: float
    double_sided: bool
    emissive_factor: _Vec3
    emissive_strength: float
    emissive_texture: Optional[NDArray[np.uint8]]
    ior: float
    iridescence_factor: float
    iridescence_ior: float
    iridescence_texture: Optional[NDArray[np.uint8]]
    iridescence_thickness_maximum: float
    iridescence_thickness_minimum: float
    iridescence_thickness_texture: Optional[NDArray[np.uint8]]
    metallic_factor: float
    metallic_roughness_texture: Optional[NDArray[np.uint8]]
    multiscatter_color_factor: _Vec3
    name: str
    normal_scale: float
    normal_texture: Optional[NDArray[np.uint8]]
    occlusion_strength: float
    occlusion_texture: Optional[NDArray[np.uint8]]
    priority: int
    retroreflection_factor: float
    retroreflection_texture: Optional[NDArray[np.uint8]]
    roughness_factor: float
    scatter_anisotropy: float
    scatter_color_factor: _Vec3
    scatter_color_texture: Optional[NDArray[np.uint8]]
    scatter_mean_cosine: float
    scatter_strength_factor: float
    scatter_strength_texture: Optional[NDArray[np.uint8]]
    sheen_color_factor: _Vec3
    sheen_color_texture: Optional[NDArray[np.uint8]]
    sheen_roughness_factor: float
    sheen_roughness_texture: Optional[NDArray[np.uint8]]
    specular_color_factor: _Vec3
    specular_color_texture: Optional[NDArray[np.uint8]]
    specular_factor: float
    specular_glossiness: bool
    specular_texture: Optional[NDArray[np.uint8]]
    thickness_factor: float
    transmission_factor: float
    transmission_texture: Optional[NDArray[np.uint8]]
    unlit: bool
    @property
    def index(self) -> int: ...

class Light:
    name: str
    color: _Vec3
    intensity: float
    range: float
    inner_cone_angle: float
    outer_cone_angle: float
    @property
    def index(self) -> int: ...
    @property
    def kind(self) -> str: ...
    @property
    def node(self) -> Optional[Node]: ...

class Camera:
    name: str
    y_fov: float
    x_mag: float
    y_mag: float
    @property
    def index(self) -> int: ...
    @property
    def orthographic(self) -> bool: ...
    @property
    def node(self) -> Optional[Node]: ...

class Scene:
    def __init__(self) -> None: ...
    @property
    def file(self) -> str: ...
    @property
    def bounds(self) -> Optional[Tuple[_Vec3, _Vec3]]: ...
    @property
    def nodes(self) -> list[Node]: ...
    @property
    def materials(self) -> list[Material]: ...
    @property
    def lights(self) -> list[Light]: ...
    @property
    def cameras(self) -> list[Camera]: ...
    def add_node(
        self, name: str = "", *, parent: Optional[Node] = None, matrix: Optional[ArrayLike] = None
    ) -> Node: ...
    def add_material(self, name: str = "", **fields: Any) -> Material: ...
    def add_mesh(
        self,
        positions: ArrayLike,
        indices: Optional[ArrayLike] = None,
        *,
        normals: Optional[ArrayLike] = None,
        uvs: Optional[ArrayLike] = None,
        colors: Optional[ArrayLike] = None,
        tangents: Optional[ArrayLike] = None,
        material: Optional[Material] = None,
        name: str = "",
        parent: Optional[Node] = None,
        matrix: Optional[ArrayLike] = None,
    ) -> Node: ...
    def add_spheres(
        self,
        centers: ArrayLike,
        radii: ArrayLike,
        *,
        colors: Optional[ArrayLike] = None,
        material: Optional[Material] = None,
        name: str = "",
        parent: Optional[Node] = None,
        matrix: Optional[ArrayLike] = None,
    ) -> Node: ...
    def add_light(
        self,
        kind: str,
        *,
        name: str = "",
        parent: Optional[Node] = None,
        matrix: Optional[ArrayLike] = None,
        **fields: Any,
    ) -> Light: ...
    def add_camera(
        self,
        name: str = "",
        *,
        orthographic: bool = False,
        parent: Optional[Node] = None,
        matrix: Optional[ArrayLike] = None,
        **fields: float,
    ) -> Camera: ...
    def set_environment(self, environment: Union[_Path, ArrayLike], name: str = "environment") -> None: ...

class Picture(dict[str, NDArray[Any]]):
    def _repr_png_(self) -> bytes: ...
    @property
    def display(self) -> NDArray[np.uint8]: ...
    def save(self, path: _Path) -> None: ...
    @property
    def size(self) -> Tuple[int, int]: ...
    @property
    def samples(self) -> int: ...
    @property
    def seconds(self) -> float: ...
    @property
    def was_stopped(self) -> bool: ...
    @property
    def relative_error(self) -> Optional[float]: ...
    @property
    def settings(self) -> dict[str, str]: ...
    @property
    def device(self) -> str: ...

def devices() -> list[dict[str, Any]]: ...
def set_default_device(device: Optional[Device]) -> None: ...
def load(
    path: _Path,
    *,
    scene: Union[str, int] = "",
    variant: Union[str, int] = "",
    points: Union[str, float] = "off",
    lines: Union[str, float] = "off",
    env: _Path = "",
    root: _Path = "",
) -> Scene: ...
def look_at(
    eye: Sequence[float], target: Sequence[float], up: Sequence[float] = ..., fov: float = 40.0
) -> str: ...
def render(
    scene: Union[Scene, _Path],
    spp: Optional[int] = None,
    size: Optional[Tuple[int, int]] = None,
    *,
    aovs: Iterable[str] = (),
    denoise: Union[bool, str] = False,
    seconds: Optional[float] = None,
    error: Optional[float] = None,
    sample_offset: int = 0,
    exposure: float = 0.0,
    tonemap: str = "",
    white_point: Union[None, float, str] = None,
    resume: Union[None, Picture, _Path] = None,
    progress: Optional[Callable[[Progress], Any]] = None,
    device: Union[None, Device, Sequence[Device]] = None,
    **settings: Any,
) -> Picture: ...
def read(path: _Path) -> Picture: ...
def merge(pictures: Iterable[Union[Picture, _Path]]) -> Picture: ...
def run_pass(
    glsl: str,
    inputs: Optional[Mapping[str, ArrayLike]] = None,
    outputs: Optional[Mapping[str, Any]] = None,
    *,
    constants: Optional[ArrayLike] = None,
    groups: Optional[Tuple[int, int, int]] = None,
    include: _Path = "",
    device: Optional[Device] = None,
) -> dict[str, NDArray[Any]]: ...
def compare(
    reference: Union[Picture, _Path, ArrayLike],
    picture: Union[Picture, _Path, ArrayLike],
    *,
    exposure: float = 0.0,
    device: Optional[Device] = None,
) -> dict[str, Any]: ...
def verify(
    scene: Scene,
    picture: Union[Picture, _Path, ArrayLike],
    *,
    size: Optional[Tuple[int, int]] = None,
    tolerance: float = 0.05,
    max_samples: int = 1024,
    cache: _Path = "",
    device: Optional[Device] = None,
    **settings: Any,
) -> dict[str, Any]: ...
def explain(
    scene: Scene,
    pixel: Tuple[int, int],
    *,
    size: Optional[Tuple[int, int]] = None,
    brightest: int = 1,
    sample: Optional[int] = None,
    first_sample: int = 0,
    sample_count: int = 64,
    device: Optional[Device] = None,
    **settings: Any,
) -> dict[str, Any]: ...
