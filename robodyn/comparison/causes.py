"""Why the inertial of a link is another in a second file: the slip of writing or conversion that makes one of both."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, permutations
from math import isclose

import numpy as np

from robodyn.robot.load import placement
from robodyn.robot.masses.mistakes import Given, corrections
from robodyn.robot.model import Model
from robodyn.robot.urdf.parts import Inertial
from robodyn.solids.inertia.laws import Inertia, combined, inertia_of, rotation_law, symmetric
from robodyn.support.floats import Floats

NEAR = 2e-3
"""Relative difference that is left where a cause explains what differs; texts have few digits."""
_UNITS = {1e3: "1000", 1e6: "1e6", 1e9: "1e9", 0.45359237: "0.4536 (pounds)", 25.4: "25.4", 1e4: "1e4", 100.0: "100"}
Parts = dict[str, tuple[Inertia, Inertial]]
"""Moments of links in the axes of their body, and what the file says of them."""


def near(one: Floats, other: Floats, within: float = NEAR) -> bool:
    return bool(np.abs(one - other).max() <= within * max(np.abs(one).max(), np.abs(other).max(), 1e-300))


def tensor_cause(c: Floats, tensors: tuple[Floats, Floats], axes: tuple[Floats, Floats], mass: float) -> str:
    """Return the slip that makes one tensor of the other, "" if there is none.

    Args:
        c: (3,) centre of mass from the link's origin, in the link's axes [m].
        tensors: (3, 3), (3, 3) of A and B about the centre of mass, in the link's axes [kg m^2].
        axes: (3, 3), (3, 3) those in which each file writes its tensor, in the link's.
        mass: kg.
    """
    ways = (*tensors, axes[0], "B"), (*tensors[::-1], axes[1], "A")
    for right, wrong, R, where in ways:
        if not near(R, np.eye(3), 1e-6):
            local = R.T @ right @ R
            if near(wrong, local):
                return f"in {where} the rotation of the inertial is lost"
            if near(wrong, R.T @ local @ R):
                return f"in {where} the rotation of the inertial is the other way round"
        diagonal = np.diag(np.diagonal(right))
        if near(wrong, diagonal) and not near(right, diagonal):
            return f"in {where} the products of inertia are dropped"
    for right, wrong, _, where in ways:
        entries = tuple(wrong[np.triu_indices(3)].tolist())
        slips, corrected = corrections(Given(mass, c, np.eye(3), entries))
        found = [(slip.weight, slip.what) for slip, tensor in zip(slips, corrected, strict=True) if near(tensor, right)]
        if found:
            return f"in {where} {max(found)[1]}"
    return factor_cause(tensors[1], tensors[0], "the inertia")


def factor_cause(theirs: Floats, mine: Floats, what: str, any_factor: bool = True) -> str:
    """Return that one is the other times a factor of units or, if that is asked for, of any kind; "" if it is not."""
    k = np.unravel_index(int(np.argmax(np.abs(mine))), mine.shape)
    ratio = float(theirs[k] / mine[k]) if mine[k] else 0.0
    if ratio <= 0.0 or not near(theirs, ratio * mine):
        return ""
    for factor, words in _UNITS.items():
        for times, where in ((factor, "B"), (1.0 / factor, "A")):
            if isclose(ratio, times, rel_tol=NEAR):
                return f"{what} in {where} is {words} times the other: another unit"
    return f"{what} in B is {ratio:.4g} times the other" if any_factor else ""


def mass_cause(mine: tuple[float, Floats, Floats], theirs: tuple[float, Floats, Floats]) -> str:
    """Return what explains that mass differs, by (mass, centre, tensor about it) of both; "" if nothing does."""
    (m, c, I), (n, d, J) = mine, theirs
    if m <= 0.0 or n <= 0.0:
        return f"in {'A' if m <= 0.0 else 'B'} the link has no mass"
    with_it = near(J, n / m * I) and np.abs(c - d).max() <= 1e-4 * max(float(np.abs(c).max()), 1e-3)
    if with_it or near(J, I):
        factor = factor_cause(np.array([n]), np.array([m]), "the mass")
        return f"{factor}, and its inertia with it" if with_it else factor
    for mass, centre, tensor, where in ((n, d, J, "B"), (m, c, I, "A")):
        if Given(mass, centre, np.eye(3), tuple(tensor[np.triu_indices(3)].tolist())).made_up:
            return f"in {where} mass and inertia are round numbers: a placeholder"
    return "mass, centre and inertia are those of another body, as of shapes of one density"


def centre_cause(c: Floats, d: Floats) -> str:
    """Return what explains that the centre of mass is another, of A and B; "" if nothing does."""
    scale = max(float(np.abs(c).max()), float(np.abs(d).max()))
    if not d.any() or not c.any():
        return f"in {'A' if d.any() else 'B'} the centre of mass is at the link's origin"
    for count in (1, 2, 3):
        for flipped in combinations(range(3), count):
            signs = np.where(np.isin(np.arange(3), flipped), -1.0, 1.0)
            if np.abs(signs * c - d).max() <= NEAR * scale and np.abs(c[list(flipped)]).max() > NEAR * scale:
                return f"the sign of {', '.join('xyz'[k] for k in flipped)} is another"
    if any(np.abs(c[list(order)] - d).max() <= NEAR * scale for order in permutations(range(3))):
        return "its coordinates are permuted"
    return factor_cause(d, c, "the centre of mass")


def parts_of(model: Model, i: int) -> Parts:
    """Return the links of a body that have an inertial, each with its moments in the body's axes."""
    found: Parts = {}
    for link in [] if model.description is None else model.description.links:
        frame = model.links.get(link.name)
        if link.inertial is not None and frame is not None and frame.body == i:
            turn, c = placement(link.inertial.origin)
            tensor = rotation_law(symmetric(link.inertial.inertia), turn)
            found[link.name] = inertia_of(link.inertial.mass, c, tensor, frame.R, frame.p), link.inertial
    return found


def lost_or_twice(mine: Inertia, theirs: Inertia, parts: Parts) -> Iterator[tuple[str, str]]:
    """Yield the link of one body whose moments the other lacks ("not at all"), or has "twice"."""
    for name, (part, _) in parts.items():
        less = Inertia(mine.m - part.m, mine.mc - part.mc, mine.I - part.I)
        for other, how in ((less, "not at all"), (combined((mine, part)), "twice")):
            same = isclose(other.m, theirs.m, rel_tol=1e-5) and near(other.I, theirs.I, 1e-4)
            if part.m > 0.0 and same and near(other.mc, theirs.mc, 1e-4):
                yield name, how
