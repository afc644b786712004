"""Proposals of what an inertia tensor was meant to be: one function for each way in which it goes wrong.

Each is given what the link says and yields corrections. None judges them; `robodyn.checks.causes.causes` does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations, permutations, product

import numpy as np

from robodyn.solids.inertia.laws import parallel_axis, rotation_law, symmetric
from robodyn.support.floats import Floats

PRODUCTS = ((0, 1), (0, 2), (1, 2))
_NAMES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_ORDERS = {
    "ixx iyy izz ixy ixz iyz (MuJoCo's fullinertia)": (0, 3, 4, 1, 5, 2),
    "ixx iyy izz iyz ixz ixy (Voigt's)": (0, 5, 4, 1, 3, 2),
    "ixx ixy iyy ixz iyz izz (a triangle by columns)": (0, 1, 3, 2, 4, 5),
}
"""Where the entries ixx, ixy, ixz, iyy, iyz, izz stand in each order."""
_DECADES = tuple(k for k in range(-6, 7) if k)


@dataclass(frozen=True, eq=False)
class Given:
    """What a link says.

    Attributes:
        mass: kg.
        c: (3,) centre of mass from the link's origin, in the axes of the inertial [m].
        R: (3, 3) the inertial's axes in the link's.
        entries: ixx, ixy, ixz, iyy, iyz, izz [kg m^2].
        copy: (3, 3) the tensor of the mirror twin as it stands, if it has one, in the axes of the inertial.
    """

    mass: float
    c: Floats
    R: Floats
    entries: tuple[float, ...]
    copy: Floats | None = None

    @property
    def tensor(self) -> Floats:
        """(3, 3) a new array [kg m^2]."""
        return symmetric(self.entries)

    @property
    def steiner(self) -> Floats:
        """m (|c|^2 1 - c c^T), the term of the parallel axis theorem."""
        return parallel_axis(np.zeros((3, 3)), self.mass, self.c)


@dataclass(frozen=True, eq=False)
class Proposal:
    """What was meant and what went wrong; `I` is None where the entries that are left do not tell."""

    what: str
    I: Floats | None


def signs(given: Given) -> Iterator[Proposal]:
    """Yield products of inertia with the other sign, as where they are defined as +integral xy dm.

    Without a twin all three: the principal moments do not tell three flipped signs from one, nor two from none.
    """
    nonzero = [entry for entry in PRODUCTS if given.tensor[entry]]
    for count in range(len(nonzero), 0, -1) if given.copy is not None else (3,):
        for flipped in combinations(nonzero, count):
            I = given.tensor
            for i, j in flipped:
                I[i, j] = I[j, i] = -I[i, j]
            names = ", ".join("i" + "xyz"[i] + "xyz"[j] for i, j in flipped)
            yield Proposal(f"the products of inertia ({names}) have the wrong sign", I)


def about_origin(given: Given) -> Iterator[Proposal]:
    if given.c.any():
        yield Proposal(
            "the tensor is taken about the link's origin, not the centre of mass", given.tensor - given.steiner
        )


def parallel_axis_again(given: Given) -> Iterator[Proposal]:
    if given.c.any():
        what = "the parallel-axis term is {} a tensor that is about the centre of mass already"
        yield Proposal(what.format("subtracted from"), given.tensor + given.steiner)
        yield Proposal(what.format("added twice to"), given.tensor - 2.0 * given.steiner)


def not_rotated(given: Given) -> Iterator[Proposal]:
    if np.abs(given.R - np.eye(3)).max() > 1e-6:
        what = "the tensor is in the link's axes: the rpy of the inertial is not applied to it"
        yield Proposal(what, rotation_law(given.tensor, given.R.T))


def reordered(given: Given) -> Iterator[Proposal]:
    """Yield entries in the order of another format, products under each other's names, or nine entries read as six."""
    e = given.entries
    if e[1] == e[3] and e[0] > 0.0 and e[4] > 0.0 and e[3] < e[4]:
        what = "a matrix of nine entries, row by row, is read as six: iyy holds iyx, iyz holds iyy and izz holds iyz"
        yield Proposal(what, None)
    for order, places in _ORDERS.items():
        yield Proposal(f"the entries are in the order {order}", symmetric([e[place] for place in places]))
    for a, b, c in permutations((1, 2, 4)):
        if (a, b, c) != (1, 2, 4):
            what = f"the products of inertia are in another order: {_NAMES[a]} {_NAMES[b]} {_NAMES[c]}"
            yield Proposal(what, symmetric((e[0], e[a], e[b], e[3], e[c], e[5])))


def decade(given: Given) -> Iterator[Proposal]:
    """Yield one entry times a power of ten. Without a twin a moment: a product that is small enough always fits."""
    places = range(6) if given.copy is not None else (0, 3, 5)
    for place, k in product(places, _DECADES):
        value = given.entries[place]
        if value:
            entries = list(given.entries)
            entries[place] = float(f"{value!r}e{k}") if "e" not in repr(value) else value * 10.0**k
            what = f"{_NAMES[place]} is {value:g} and {10.0**-k:g} times what it was meant to be"
            yield Proposal(what, symmetric(entries))


def permuted(given: Given) -> Iterator[Proposal]:
    """Yield the tensor in axes of other names, with its products and without."""
    for order in permutations(range(3)):
        if order != (0, 1, 2):
            names = " ".join("xyz"[i] for i in order)
            turned = given.tensor[np.ix_(order, order)]
            yield Proposal(f"the axes are permuted: x y z should be {names}", turned)
            kept = given.tensor
            kept[np.diag_indices(3)] = np.diagonal(given.tensor)[list(order)]
            yield Proposal(f"the moments of inertia are permuted: ixx iyy izz belong to {names}", kept)


def copied(given: Given) -> Iterator[Proposal]:
    """Yield the tensor of the mirror twin, not reflected."""
    if given.copy is not None and np.abs(given.tensor - given.copy).max() <= 1e-6 * np.abs(given.copy).max():
        yield Proposal("the tensor is a copy of its mirror twin's, which is not reflected", None)


FORMS: dict[str, Callable[[Given], Iterator[Proposal]]] = {
    "RD306": signs,
    "RD307": about_origin,
    "RD308": parallel_axis_again,
    "RD309": not_rotated,
    "RD310": reordered,
    "RD311": decade,
    "RD312": permuted,
    "RD313": copied,
}
"""By the code of the rule that documents it."""
