"""Mass, centre of mass and second moments of a body, its principal axes, and how they are made, moved and shown."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import fsum
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from robodyn.errors import InputError
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, length, product, rotation_from_rpy
from robodyn.solids.inertia.laws import (
    Inertia,
    exact,
    fraction,
    inertia_matrix,
    orthogonal,
    parallel_axis,
    principal_moments,
    rotation_law,
    rounded,
    second_moments,
)
from robodyn.support.floats import Floats, first_largest
from robodyn.support.linear import eigen

EQUAL = 1e-9
FARTHEST = 1e100
"""Coordinates of a point [m] whose squares are still numbers, also times masses."""
Pose = tuple[Array, Array]
"""Rotation (3, 3) and origin (3,) [m] of a frame in another."""
_NOTHING = np.zeros((3, 3))
Vector = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Principal:
    """Principal moments of inertia about one point, in ascending order.

    moments: (3,) kg m^2; axes: (3, 3) the unit axes as rows, right-handed: I = axes^T diag(moments) axes; second: (3,)
    second moments along the axes [kg m^2]; groups: numbers of the axes whose moments are equal, within this tolerance
    of the largest: any orthonormal basis of what they span is as good as the one given.
    """

    moments: Floats
    axes: Floats
    second: Floats
    groups: tuple[tuple[int, ...], ...]
    tolerance: float

    def __post_init__(self) -> None:
        for array in (self.moments, self.axes, self.second):
            array.flags.writeable = False

    @property
    def remark(self) -> str | None:
        """Which axes are not unique, in words; None where all are but for their signs."""
        if len(self.groups) == 3:
            return None
        equal = f"equal within {self.tolerance:g}"
        if len(self.groups) == 1:
            return f"all principal moments are {equal}: every axis is principal"
        (lone,) = (group[0] for group in self.groups if len(group) == 1)
        ((first, other),) = (group for group in self.groups if len(group) == 2)
        along = ", ".join(f"{x:.6g}" for x in self.axes[lone].round(9) + 0.0)
        return (
            f"principal moments {first + 1} and {other + 1} are {equal}: "
            f"every axis normal to axis {lone + 1} = ({along}) is principal"
        )


def principal_axes(S: Array, S_low: Array | float = 0.0, tolerance: float = EQUAL) -> Principal:
    """Principal moments and axes of the second moments S + S_low: I v_i = I_i v_i with I = tr(S) 1 - S.

    Method: Jacobi's, in floats; then once more on the matrix seen from the axes found, which is computed in fractions.
    That matrix is diagonal but for rounding, so that its small entries are as accurate as its large ones.

    Unique axes point so that their largest component is positive, the last so that they are right-handed. Of equal
    moments the axes follow the coordinate axes: all three are these, or the first of two is the projection of the
    coordinate axis nearest to their plane.

    Args:
        S, S_low: (3, 3) kg m^2, floats or fractions, and what floats leave of them.
        tolerance: moments are equal if they differ by no more than this part of the largest.

    Accuracy: each principal moment and second moment within 16 eps of that of the matrix as given, however small, if
        it is positive definite with second moments down to 1e-20 of the largest. Axes orthonormal within 8 eps, and
        axes I axes^T diagonal within 16 eps of the largest moment, where no two are counted as equal.
    """
    given = exact(S) + exact(S_low)
    _, rough = eigen(rounded(given))
    second, correction = eigen(rounded(product(exact(rough), given, exact(rough).T)))
    moments = principal_moments(second)
    within = tolerance * np.abs(moments).max()
    groups: list[tuple[int, ...]] = [(0,)]
    for i in (1, 2):
        if second[i - 1] - second[i] <= within:
            groups[-1] += (i,)
        else:
            groups.append((i,))
    axes = product(correction, rough)
    if len(groups) == 1:
        axes = IDENTITY.copy()
    elif len(groups) == 3:
        one, other = pointed(axes[0]), pointed(axes[1])
        axes = np.array((one, other, cross(one, other)))
    else:
        lone_first = len(groups[0]) == 1
        lone = pointed(axes[0 if lone_first else 2])
        nearest = IDENTITY[first_largest(-np.abs(lone), noise=EQUAL)]
        projection = nearest - lone * product(lone, nearest)
        one = projection / length(projection)
        other = cross(lone, one)
        axes = np.array((lone, one, other) if lone_first else (one, other, lone))
    return Principal(moments, axes + 0.0, second, tuple(groups), tolerance)


def pointed(axis: Floats) -> Floats:
    """Return the axis or its opposite, with the largest component (the first of several) positive."""
    return np.asarray(axis * np.sign(axis[first_largest(np.abs(axis))]), dtype=float)


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass properties of a body, in the axes of its frame.

    The second moments S_c = integral of (x - c)(x - c)^T dm are kept, and not the inertia matrix I_c = tr(S_c) 1 - S_c,
    in whose digits the smallest second moment of a plate or a needle is lost. The laws are computed in fractions, and
    their results kept as sums of two floats. Nothing asks whether the body can exist; `inertia/validity` does.

    Attributes:
        mass: kg; negative for a hole.
        com: (3,) centre of mass [m].
        S_c: (3, 3) second moments about the centre of mass [kg m^2]. May be given as fractions or wide floats.
        volume: m^3; area: of the surface [m^2]; where they are known.
        S_low: (3, 3) what the floats S_c leave of the second moments.

    Raises:
        InputError: a number is not finite, a shape is wrong, or the second moments are not symmetric.

    Accuracy: S_c + S_low holds 106 bits of each number, and so, in any pose, each principal moment of a body k times as
        long as it is thick within 32 eps + 2^-104 k^2.
    """

    mass: float
    com: Floats
    S_c: Floats
    volume: float | None = None
    area: float | None = None
    S_low: Floats = field(default_factory=lambda: _NOTHING)

    def __post_init__(self) -> None:
        com, shapes = exact(self.com), (np.shape(self.com), np.shape(self.S_c), np.shape(self.S_low))
        if shapes != ((3,), (3, 3), (3, 3)):
            raise InputError(f"centre of mass and second moments of shapes {shapes}, not ((3,), (3, 3), (3, 3))")
        S = self.S_exact
        if np.abs(S - S.T).max() > fraction(1e-12) * np.abs(S).max():
            raise InputError("the second moments are not symmetric", remedy="give S_ij = S_ji")
        S = (S + S.T) / 2
        high = rounded(S)
        for name, array in (("com", rounded(com)), ("S_c", high), ("S_low", rounded(S - exact(high)))):
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        for name in ("mass", "volume", "area"):
            value = getattr(self, name)
            object.__setattr__(self, name, None if value is None else float(rounded(exact(value))))

    @property
    def density(self) -> float | None:
        """Mass per volume [kg/m^3]; None where the volume is not known or zero."""
        return self.mass / self.volume if self.volume else None

    @property
    def S_exact(self) -> Array:
        """S_c + S_low as fractions."""
        S: Array = exact(self.S_c) + exact(self.S_low)
        return S

    @property
    def inertia(self) -> Floats:
        """I_c = tr(S_c) 1 - S_c, the inertia matrix about the centre of mass [kg m^2]. Accuracy: each entry within eps
        of itself if no second moment is negative."""
        return inertia_matrix(self.S_c)

    def about(self, point: Array) -> Floats:
        """Return the inertia matrix about a point of the frame [m], by the parallel axis theorem."""
        return parallel_axis(self.inertia, self.mass, self.com - point)

    @property
    def moments(self) -> Inertia:
        """Mass, first moment and inertia matrix about the frame's origin, as the dynamics takes them."""
        return Inertia(self.mass, self.mass * self.com, self.about(ZERO))

    @cached_property
    def principal(self) -> Principal:
        """Principal moments and axes about the centre of mass; see `principal_axes`."""
        return principal_axes(self.S_c, self.S_low)

    @property
    def gyration(self) -> float:
        """The largest radius of gyration about an axis through the centre of mass [m]; 0 where there is no mass."""
        return float((self.principal.moments.max() / self.mass) ** 0.5) if self.mass > 0 else 0.0

    def placed(self, R: Array, p: Array) -> MassProperties:
        """The body in the outer frame in which its own stands at rotation R and origin p: c -> R c + p, S -> R S R^T. A
        reflection R gives the mirror image; InputError if it is not orthogonal within 1e-9. Accuracy: for R and p as
        given, `com` correctly rounded and S_c + S_low within 2^-106, entry by entry."""
        com, S = self.carried(R, p)
        return self._with(S, com=com)

    def carried(self, R: Array, p: Array) -> tuple[Array, Array]:
        """Centre of mass and second moments of `placed`, as fractions, for sums that are to be rounded once."""
        turn = exact(orthogonal(np.asarray(R, dtype=float)))
        return product(turn, exact(self.com)) + exact(p), product(turn, self.S_exact, turn.T)

    def scaled_to_mass(self, mass: float) -> MassProperties:
        """S -> S mass / m; accuracy as for `placed`. Raises InputError where the body has no mass."""
        if not self.mass:
            raise InputError("a body without mass cannot be scaled to one", remedy="give its density")
        return self._with(self.S_exact * (fraction(mass) / fraction(self.mass)), mass=mass)

    def __neg__(self) -> MassProperties:
        """Return the body as a hole: what it is added to loses it."""
        return self._with(-self.S_exact, mass=-self.mass, volume=None if self.volume is None else -self.volume)

    def __add__(self, other: MassProperties) -> MassProperties:
        """Both bodies fixed to each other, given in the same frame; see `composite`."""
        return composite(((self, (IDENTITY, ZERO)), (other, (IDENTITY, ZERO))))

    def __sub__(self, other: MassProperties) -> MassProperties:
        """Return the body with a hole the shape of `other`, given in the same frame."""
        return self + -other

    def _with(self, S: Array, **changes: Any) -> MassProperties:
        return replace(self, S_c=S, S_low=_NOTHING, **changes)


def composite(parts: Iterable[tuple[MassProperties, Pose]]) -> MassProperties:
    """Return the mass properties of bodies at given poses, in the frame in which these are given.

    m = sum m_i, c = sum m_i c_i / m, S_c = sum (S_i + m_i (c_i - c)(c_i - c)^T), in fractions that are rounded once. A
    part of negative mass is a hole. Volumes and surfaces are added where all are known. InputError where masses that
    are not all zero add up to zero, or a rotation is not orthogonal.

    Accuracy: `com` correctly rounded and S_c + S_low within 2^-106, entry by entry, in every order of the parts.
    """
    given = tuple(parts)
    placed = [(fraction(body.mass), *body.carried(R, p)) for body, (R, p) in given]
    m = sum(mass for mass, _, _ in placed)
    if not m and any(mass for mass, _, _ in placed):
        raise InputError("the masses of the parts add up to zero: they have no centre of mass")
    first = sum((mass * centre for mass, centre, _ in placed), exact(ZERO))
    c = first / m if m else first
    S = exact(np.zeros((3, 3)))
    for mass, centre, S_i in placed:
        S = S + S_i + mass * np.outer(centre - c, centre - c)
    volumes, areas = ([getattr(body, name) for body, _ in given] for name in ("volume", "area"))
    volume, area = (None if None in numbers else fsum(numbers) for numbers in (volumes, areas))
    return MassProperties(m, c, S, volume, area)


def from_inertia(mass: float, com: ArrayLike, I_c: ArrayLike) -> MassProperties:
    """Return the body with this inertia matrix about its centre of mass, as a URDF or a data sheet gives it. Accuracy:
    S_c + S_low within 2^-106 of tr(I_c) / 2 1 - I_c, entry by entry; of a plate or a needle the smallest second moment
    is as good as the digits of I_c."""
    return MassProperties(mass, np.asarray(com), second_moments(exact(I_c)))


def from_moments(moments: Inertia) -> MassProperties:
    """Return the body with these moments about the origin of its frame; undoes `MassProperties.moments`."""
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
) -> MassProperties:
    """Return the uniform body over which x - r and (x - r)(x - r)^T have these integrals, r being the reference.

    c = r + first / V, S_c = density (second - first first^T / V).

    Args:
        volume, first, second, reference: in units of the shape's file, floats of any width or fractions.
        density: kg/m^3.
        scale: metres in a unit of the file.

    Raises:
        InputError: the volume is zero, or a number is not finite.

    Accuracy: for the integrals as given, `com` correctly rounded and S_c + S_low within 2^-106, entry by entry.
    """
    if not volume:
        raise InputError("the shape has no volume", remedy="take its surface as a shell of some thickness")
    k, V, rho = fraction(scale), fraction(volume), fraction(density)
    com = exact(first) / V
    S = (exact(second) - np.outer(exact(first), com)) * (rho * k**5)
    return MassProperties(rho * V * k**3, (com + exact(reference)) * k, S, V * k**3)


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
        density, reference, scale: as for `from_integrals`, as are errors and accuracy.
    """
    if not area:
        raise InputError("the shape has no surface")
    k, t = fraction(scale), fraction(thickness)
    surface = fraction(area) * k**2
    body = from_integrals(area, first, second, density=fraction(density) * t / k, reference=reference, scale=k)
    return replace(body, volume=surface * t, area=surface)


def inertial_element(body: MassProperties) -> str:
    """Return the <inertial> element of a link, about the centre of mass in the axes of the link's frame. Numbers are
    the shortest that read back as the same floats; `ixy` and so on are entries of the inertia matrix, -integral of x y
    dm. Five lines, the last without a line break."""
    entries = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), body.inertia[np.triu_indices(3)].tolist(), strict=True)
    inertia = " ".join(f'{name}="{entry!r}"' for name, entry in entries)
    return (
        "<inertial>\n"
        f'  <origin xyz="{" ".join(map(repr, body.com.tolist()))}" rpy="0 0 0"/>\n'
        f'  <mass value="{body.mass!r}"/>\n'
        f"  <inertia {inertia}/>\n"
        "</inertial>"
    )


@dataclass(frozen=True)
class View:
    """About which point of the mesh's frame [m], and in which axes, fixed-axis rpy [rad], an inertia is wanted."""

    about: Literal["com", "origin"] | Vector = "com"
    rpy: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not isinstance(self.about, str) and max(map(abs, self.about)) > FARTHEST:
            raise InputError(f"the point {self.about} is too far away", remedy=f"stay within {FARTHEST:g} m")

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
