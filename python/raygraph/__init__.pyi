from os import PathLike
from typing import Any, Callable, Iterable, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

__version__: str
__all__: list[str]

_Path = Union[str, "PathLike[str]"]

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

class Scene:
    @property
    def file(self) -> str: ...

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
    progress: Optional[Callable[[Progress], Any]] = None,
    device: Union[None, Device, Sequence[Device]] = None,
    **settings: Any,
) -> Picture: ...
def read(path: _Path) -> Picture: ...
def merge(pictures: Iterable[Union[Picture, _Path]]) -> Picture: ...
