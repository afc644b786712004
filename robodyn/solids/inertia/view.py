"""Mass properties as they are asked for: about some point, in some axes, or as URDF writes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robodyn.programs.vectors import ZERO, rotation_from_rpy
from robodyn.solids.inertia.exact import Floats
from robodyn.solids.inertia.laws import rotation_law
from robodyn.solids.inertia.properties import MassProperties


def inertial_element(body: MassProperties, indent: str = "    ") -> str:
    """Return the <inertial> element of a link, about the centre of mass in the axes of the link's frame.

    Numbers are the shortest that read back as the same floats, so that nothing is lost: `ixy` and so on are entries of
    the inertia matrix, -integral of x y dm. The smallest second moment of a plate or a needle is beyond its six floats.

    Args:
        indent: what each line starts with; children are indented by two more blanks.

    Returns:
        Five lines, the last without a line break.
    """
    I = body.inertia
    names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    inertia = " ".join(f'{name}="{_number(I[place])}"' for name, place in names.items())
    lines = (
        "<inertial>",
        f'  <origin xyz="{" ".join(map(_number, body.com))}" rpy="0 0 0"/>',
        f'  <mass value="{_number(body.mass)}"/>',
        f"  <inertia {inertia}/>",
        "</inertial>",
    )
    return "\n".join(indent + line for line in lines)


def _number(value: float) -> str:
    return repr(float(value))


Vector = tuple[float, float, float]


@dataclass(frozen=True)
class View:
    """About which point, and in which axes, an inertia matrix is wanted.

    Attributes:
        about: "com", "origin" or a point of the mesh's frame [m].
        rpy: fixed-axis roll, pitch and yaw of the axes in the mesh's [rad].
    """

    about: Literal["com", "origin"] | Vector = "com"
    rpy: Vector = (0.0, 0.0, 0.0)

    def inertia(self, body: MassProperties) -> tuple[Floats, Floats]:
        """The point [m] in the mesh's frame and the inertia matrix about it, R^T I R, in the view's axes [kg m^2]."""
        point = body.com if self.about == "com" else np.array(ZERO if self.about == "origin" else self.about)
        R = rotation_from_rpy(*self.rpy)
        return point, rotation_law(body.about(point), R.T)

    @property
    def words(self) -> str:
        place = {"com": "the centre of mass", "origin": "the origin"}.get(str(self.about), f"{self.about} m")
        turned = f", axes turned by roll, pitch, yaw {self.rpy} rad" if any(self.rpy) else ""
        return f"about {place}{turned}"
