"""The inertia matrix as it is asked for: about some point, in some axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robodyn.programs.vectors import ZERO, rotation_from_rpy
from robodyn.solids.inertia.exact import Floats
from robodyn.solids.inertia.laws import rotation_law
from robodyn.solids.inertia.properties import MassProperties

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
