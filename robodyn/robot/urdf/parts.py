"""What a description consists of: names, SI numbers and the lines they come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from robodyn.robot.urdf.sources import Search

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
WITH_AXIS = frozenset({"revolute", "continuous", "prismatic", "planar"})
WITH_RANGE = frozenset({"revolute", "prismatic"})
INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "capsule": ("radius", "length")}
SHAPES = (*SIZES, "mesh")
Kind = Literal["visual", "collision"]
Shape = Literal["box", "cylinder", "sphere", "capsule", "mesh"]


@dataclass(frozen=True, slots=True)
class Origin:
    """Pose of a frame in its parent: `xyz` in metres, fixed-axis roll, pitch, yaw in radians."""

    xyz: Vector = ZERO
    rpy: Vector = ZERO


@dataclass(frozen=True, slots=True)
class Inertial:
    """Mass [kg], and (ixx, ixy, ixz, iyy, iyz, izz) [kg m^2] about the centre of mass in the axes of `origin`."""

    mass: float
    origin: Origin
    inertia: tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Geometry:
    """A shape on a link; `size` [m]: box x, y, z; sphere radius; cylinder and capsule radius, length; mesh nothing."""

    kind: Kind
    origin: Origin
    shape: Shape
    size: tuple[float, ...] = ()
    filename: str | None = None
    scale: Vector = (1.0, 1.0, 1.0)
    line: int = 1


@dataclass(frozen=True, slots=True)
class Link:
    name: str
    inertial: Inertial | None = None
    geometries: tuple[Geometry, ...] = ()
    line: int = 1


@dataclass(frozen=True, slots=True)
class Limit:
    """Position [rad or m], effort [N m or N] and speed [rad/s or m/s]; None where the file says nothing."""

    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None


@dataclass(frozen=True, slots=True)
class Mimic:
    """This joint's position is `multiplier * position(joint) + offset`."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Joint:
    """`axis` as written, in the joint frame; `damping` viscous [N m s/rad, N s/m], `friction` Coulomb [N m, N]."""

    name: str
    type: str
    parent: str
    child: str
    origin: Origin = Origin()
    axis: Vector = (1.0, 0.0, 0.0)
    limit: Limit | None = None
    damping: float = 0.0
    friction: float = 0.0
    mimic: Mimic | None = None
    line: int = 1


@dataclass(frozen=True, slots=True)
class Transmission:
    """One motor on one joint: motor turns per joint turn, and the rotor's inertia [kg m^2] if the file has it."""

    name: str
    joint: str
    reduction: float = 1.0
    rotor_inertia: float | None = None
    line: int = 1


@dataclass(frozen=True, slots=True)
class Description:
    """A robot: links and joints in the order of the file, forming one tree with the root link `root`.

    Attributes:
        notes: doubts, each with its line.
        search: where the files are that it names.
        data: the bytes that it was read from.
        scene: what the file says beyond links and joints, as the tables of a scene.toml would; see `scene_of`.
        format: of the file: "urdf", also of what xacro made, "mjcf" or "sdf".
    """

    name: str
    file: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    transmissions: tuple[Transmission, ...]
    root: str
    notes: tuple[tuple[int, str], ...]
    search: Search
    data: bytes = b""
    scene: Mapping[str, Any] = field(default_factory=dict, hash=False)
    format: str = "urdf"

    @property
    def massive(self) -> tuple[Link, ...]:
        """The links with mass: those whose <inertial> has a mass other than 0."""
        return tuple(link for link in self.links if link.inertial is not None and link.inertial.mass)
