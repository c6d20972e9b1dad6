"""Contact forces of compliant fin-ray fingers from their deformation. Units are N, mm and degrees, unless a name states another unit."""

from collections.abc import Iterable, Sequence
from os import PathLike
from typing import Any, NoReturn, Optional, Union, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "Alternative",
    "FinrayError",
    "Forces",
    "Locator",
    "Observation",
    "Press",
    "Refused",
    "Scene",
    "Sensor",
    "Shape",
    "StreamSensor",
    "__version__",
    "press",
    "read_image",
    "solve",
]

__version__: str

_Path = Union[str, "PathLike[str]"]
_Floats = npt.NDArray[np.float64]
_Nodes = npt.NDArray[np.int64]
_Image = npt.NDArray[np.uint8]
# The argument of a constructor that does not exist.
_NoValue = NoReturn
_Number = Union[float, "np.integer[Any]", "np.floating[Any]"]
_Numbers = Union[npt.NDArray["np.integer[Any]"], npt.NDArray["np.floating[Any]"]]
_Contact = Union[str, _Number]
_Contacts = Union[_Contact, Sequence[_Contact], _Numbers, npt.NDArray[np.str_], None]
_Loads = Union[_Numbers, Iterable[Union[Sequence[_Number], _Numbers]], None]

class FinrayError(Exception):
    """The input is wrong, or a result cannot be computed. The message says why."""

class Refused(FinrayError):
    """The input has the right form, but yields no estimate: no finger in an image, or forces that are not identifiable."""

@final
class Scene:
    """A finger with its camera, markers and contacts."""
    def __new__(cls, _: _NoValue) -> Scene: ...
    @staticmethod
    def read(path: _Path) -> Scene: ...
    @staticmethod
    def parse(text: str) -> Scene: ...
    @staticmethod
    def paper() -> Scene: ...
    @property
    def name(self) -> str: ...
    @property
    def key_nodes(self) -> _Floats: ...
    @property
    def marked_nodes(self) -> _Nodes: ...
    @property
    def front_length_mm(self) -> float: ...
    @property
    def camera_size_px(self) -> Optional[tuple[int, int]]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def model_error(self) -> float: ...
    def _repr_svg_(self) -> str: ...

@final
class Shape:
    """Displacements of the key nodes of a finger."""
    def __new__(cls, _: _NoValue) -> Shape: ...
    @property
    def nodes(self) -> _Nodes: ...
    @property
    def positions(self) -> _Floats: ...
    @property
    def displacements(self) -> _Floats: ...
    @property
    def rotations(self) -> _Floats: ...
    @property
    def hinge_displacements(self) -> _Floats: ...
    @property
    def warnings(self) -> list[str]: ...
    def observation(self) -> Observation: ...
    def _repr_svg_(self) -> str: ...

@final
class Observation:
    """Observed markers of a finger.

    Args:
        nodes: nodes of the markers; shape (n,).
        displacements: displacements, mm, finger frame; shape (n, 2).
        positions: positions on the deformed finger, mm, finger frame; shape (n, 2).
        sigma_mm: standard deviation of one coordinate, mm; one number or shape (n,).
    """
    def __new__(
        cls,
        nodes: npt.ArrayLike,
        displacements: Optional[npt.ArrayLike] = None,
        *,
        positions: Optional[npt.ArrayLike] = None,
        sigma_mm: Optional[npt.ArrayLike] = None,
    ) -> Observation: ...
    @property
    def nodes(self) -> _Nodes: ...
    @property
    def pixels(self) -> Optional[_Floats]: ...
    @property
    def positions(self) -> Optional[_Floats]: ...
    @property
    def displacements(self) -> Optional[_Floats]: ...
    @property
    def sigma_mm(self) -> Optional[_Floats]: ...
    @property
    def marker_sigma_mm(self) -> Optional[_Floats]: ...
    @property
    def base_pose(self) -> Optional[tuple[float, float, float]]: ...
    @property
    def warnings(self) -> list[str]: ...
    def __len__(self) -> int: ...

@final
class Locator:
    """Locates the markers of a scene's finger in images.

    Args:
        scene: scene with the tables camera and markers.
        rest: image of the unloaded finger, the reference of displacements; None: from the scene.
    """
    def __new__(cls, scene: Scene, rest: Optional[_Image] = None) -> Locator: ...
    def locate(self, image: _Image) -> Observation: ...
    @property
    def rest_residual_px(self) -> Optional[float]: ...
    @property
    def rest_warning(self) -> Optional[str]: ...
    @property
    def motion_blur_px(self) -> Optional[float]: ...

@final
class Sensor:
    """Estimates contact forces from observations of a finger.

    Args:
        scene: the finger.
        contact_at: contacts at positions along the front plate, mm or texts such as "80@-20" and "auto@auto".
        contact: contacts at nodes, numbers or texts such as "19@normal".
        noise_mm: standard deviation of one coordinate, mm; None: from the scene, the observation or the residual.
        estimator: name of the estimator.
        network: file of a network of `finray train`; None: the shipped networks.
        mesh_nodes: number of mesh nodes; None: refined until the result converges.
        friction: friction coefficient for contacts with standard deviations ("80+-1@0+-5").
    """
    def __new__(
        cls,
        scene: Scene,
        contact_at: _Contacts = None,
        *,
        contact: _Contacts = None,
        noise_mm: Optional[float] = None,
        estimator: str = "nonlinear",
        network: Optional[_Path] = None,
        mesh_nodes: Optional[int] = None,
        friction: float = 0.0,
    ) -> Sensor: ...
    def sense(self, observation: Observation) -> Forces: ...
    def alternatives(self, observation: Observation) -> list[Alternative]: ...

@final
class Alternative:
    """One of several answers that explain an observation about equally well."""
    def __new__(cls, _: _NoValue) -> Alternative: ...
    @property
    def contact(self) -> int: ...
    @property
    def s_mm(self) -> float: ...
    @property
    def s_interval_mm(self) -> tuple[float, float]: ...
    @property
    def angle_deg(self) -> float: ...
    @property
    def force_n(self) -> float: ...
    @property
    def interval_n(self) -> tuple[float, float]: ...
    @property
    def excess_misfit(self) -> float: ...

@final
class Forces:
    """Estimated forces, in the order of the contacts: first contact_at, then contact."""
    def __new__(cls, _: _NoValue) -> Forces: ...
    @property
    def contacts(self) -> list[str]: ...
    @property
    def s_mm(self) -> _Floats: ...
    @property
    def angle_deg(self) -> _Floats: ...
    @property
    def force_n(self) -> _Floats: ...
    @property
    def sigma_n(self) -> _Floats: ...
    @property
    def interval_n(self) -> _Floats: ...
    @property
    def warnings(self) -> list[str]: ...
    def __len__(self) -> int: ...

@final
class StreamSensor:
    """Senses the forces in each frame of a stream.

    Args:
        scene: the finger; for images, with the tables camera and markers.
        contact_at, contact: contacts, as for Sensor.
        noise_mm: standard deviation of one coordinate, mm; None: the scene's, else that of each marker.
        estimator, network: as for Sensor.
        rest_frames: number of first frames that show the unloaded finger.
    """
    def __new__(
        cls,
        scene: Scene,
        contact_at: _Contacts = None,
        *,
        contact: _Contacts = None,
        noise_mm: Optional[float] = None,
        estimator: str = "nonlinear",
        network: Optional[_Path] = None,
        rest_frames: int = 0,
    ) -> StreamSensor: ...
    def line(self, frame: Union[_Image, Observation], *, time_s: Optional[float] = None, dropped: int = 0) -> str: ...
    def refused_line(self, reason: str, *, time_s: Optional[float] = None, dropped: int = 0) -> str: ...

@final
class Press:
    """True and sensed forces of a simulated press."""
    def __new__(cls, _: _NoValue) -> Press: ...
    @property
    def step(self) -> _Nodes: ...
    @property
    def travel_mm(self) -> _Floats: ...
    @property
    def contact(self) -> list[str]: ...
    @property
    def s_mm(self) -> _Floats: ...
    @property
    def angle_deg(self) -> _Floats: ...
    @property
    def force_n(self) -> _Floats: ...
    @property
    def friction_n(self) -> _Floats: ...
    @property
    def sensed_n(self) -> _Floats: ...
    @property
    def sigma_n(self) -> _Floats: ...
    @property
    def read_s_mm(self) -> _Floats: ...
    @property
    def read_angle_deg(self) -> _Floats: ...
    @property
    def shape(self) -> Shape: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def stopped(self) -> Optional[str]: ...
    def __len__(self) -> int: ...

def solve(
    scene: Scene,
    load_at: _Loads = None,
    *,
    load: _Loads = None,
    kinematics: str = "corotational",
    mesh_nodes: Optional[int] = None,
) -> Shape: ...
def press(
    scene: Scene, *, noise_mm: Optional[float] = None, seed: int = 1, fineness: Optional[int] = None
) -> Press: ...
def read_image(path: _Path) -> _Image: ...
