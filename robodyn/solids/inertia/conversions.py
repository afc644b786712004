"""Mass properties from matrices, moments and integrals; and as they are asked for, or as URDF writes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import InputError
from robodyn.programs.vectors import ZERO, Array, Scalar, rotation_from_rpy
from robodyn.solids.inertia.exact import exact, fraction
from robodyn.solids.inertia.laws import Inertia, rotation_law, second_moments
from robodyn.solids.inertia.properties import MassProperties
from robodyn.support.floats import Floats


def from_inertia(mass: float, com: ArrayLike, I_c: ArrayLike) -> MassProperties:
    """Return the body with this inertia matrix about its centre of mass, as a URDF or a data sheet gives it.

    Args:
        mass: kg.
        com: (3,) m.
        I_c: (3, 3) symmetric [kg m^2].

    Raises:
        InputError: see `MassProperties`.

    Accuracy: S_c + S_low within 2^-106 of tr(I_c) / 2 1 - I_c, entry by entry, and `inertia` gives I_c back within
        2 eps of its largest entry. Of a plate or a needle the smallest second moment is as good as the digits of I_c.
    """
    return MassProperties(mass, np.asarray(com), second_moments(exact(I_c)))


def from_moments(moments: Inertia) -> MassProperties:
    """Return the body with these moments about the origin of its frame; undoes `MassProperties.moments`.

    Accuracy: for the moments as given, as for `from_inertia`.
    """
    if not moments.m:
        return from_inertia(0.0, ZERO, moments.I)
    first = exact(moments.mc)
    com = first / fraction(moments.m)
    return MassProperties(moments.m, com, second_moments(exact(moments.I)) - np.outer(first, com))


def from_integrals(
    volume: ArrayLike,
    first: ArrayLike,
    second: ArrayLike,
    *,
    density: float,
    reference: ArrayLike = ZERO,
    scale: Scalar = 1.0,
    area: float | None = None,
) -> MassProperties:
    """Return the uniform body over which x - r and (x - r)(x - r)^T have these integrals, r being the reference.

    c = r + first / V, S_c = density (second - first first^T / V).

    Args:
        volume, first, second: V, (3,) and (3, 3) in units of the shape's file, floats of any width or fractions.
        density: kg/m^3.
        reference: (3,) in units of the file.
        scale: metres in a unit of the file; 0.001 is not quite a thousandth, fractions.Fraction(1, 1000) is.
        area: of the surface, in units of the file.

    Raises:
        InputError: the volume is zero, or a number is not finite.

    Accuracy: for the integrals as given, `com` correctly rounded and S_c + S_low within 2^-106, entry by entry.
    """
    if not volume:
        raise InputError("the shape has no volume", remedy="take its surface as a shell of some thickness")
    k, V = fraction(scale), fraction(volume)
    mass, com, S = _uniform(V * k**3, exact(first) * k**4, exact(second) * k**5, fraction(density))
    surface = None if area is None else fraction(area) * k**2
    return MassProperties(mass, com + exact(reference) * k, S, V * k**3, surface)


def from_surface_integrals(
    area: ArrayLike,
    first: ArrayLike,
    second: ArrayLike,
    *,
    density: float,
    thickness: float,
    reference: ArrayLike = ZERO,
    scale: Scalar = 1.0,
) -> MassProperties:
    """The thin uniform shell over whose surface x - r and (x - r)(x - r)^T have these integrals; m = density t A.

    Args:
        area, first, second: A, (3,) and (3, 3) in units of the shape's file.
        thickness: t [m], small against the shape: the mass lies on the surface.
        density, reference, scale: as for `from_integrals`.

    Raises:
        InputError: the area is zero, or a number is not finite.

    Accuracy: as for `from_integrals`.
    """
    if not area:
        raise InputError("the shape has no surface")
    k, t = fraction(scale), fraction(thickness)
    surface = fraction(area) * k**2
    mass, com, S = _uniform(surface * t, exact(first) * k**3 * t, exact(second) * k**4 * t, fraction(density))
    return MassProperties(mass, com + exact(reference) * k, S, surface * t, surface)


def _uniform(volume: Scalar, first: Array, second: Array, density: Scalar) -> tuple[Scalar, Array, Array]:
    """Mass, centre of mass from the reference and second moments about it."""
    com = first / volume
    return density * volume, com, density * (second - np.outer(first, com))


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
