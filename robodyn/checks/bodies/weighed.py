"""What the shapes of each link say of its inertial."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from math import isfinite, pi

import numpy as np

from robodyn.checks.bodies.bodies import Body, bodies, share
from robodyn.checks.bodies.masses import pose
from robodyn.checks.bodies.repeated import repeated
from robodyn.checks.bodies.uniform import shaped
from robodyn.checks.context import Context
from robodyn.programs.vectors import product
from robodyn.robot.masses.likeness import Uniform
from robodyn.robot.masses.slips import PRODUCTS, Given
from robodyn.robot.masses.units import raised
from robodyn.robot.masses.weighing import DOUBTED, Cause, Weighed, weigh
from robodyn.robot.urdf.view import LinkView
from robodyn.support.wording import figure, one_of

_EXACT = 0.02


def given(link: LinkView) -> Given | None:
    """Return what a link says; None where a number cannot be read, there is no mass or no inertia, or the rpy of the
    inertial is in degrees."""
    mass, tensor = link.mass, link.tensor
    if link.inertial is None or tensor is None or mass is None or not 0 < mass < float("inf") or not any(tensor):
        return None
    placed, turns = pose(link.inertial.origin), link.inertial.origin.rpy.or_default(0.0, 0.0, 0.0) or ()
    if placed is None or any(abs(turn) > 2.0 * pi for turn in turns) or not all(map(isfinite, (*tensor, *placed.p))):
        return None
    return Given(mass, product(placed.R.T, placed.p), placed.R, tensor)


def weighed(context: Context) -> Mapping[str, Weighed]:
    """Return by link the verdict of its shapes. From stage TREE on.

    Of a link that is less than 1 % of its rigid group only where its numbers were made from the very shapes.
    """
    shapes, known = context.once(shaped), context.once(bodies)
    found = {}
    for name, body in known.items():
        said = given(body.link)
        if said is None or name not in shapes:
            continue
        verdict = _verdict(_numbers(said, shapes[name].solid.along(said.R)))
        exact = verdict.named and not verdict.units and verdict.named[0].apart <= _EXACT
        if exact or share(context, body) is not None:
            found[name] = verdict
    return found


Numbers = tuple[float, bytes, bytes, tuple[float, ...], float, bytes, bytes]
"""Mass, centre, axes and entries of what is given; volume, centre and second moments of the shapes."""


def _numbers(given: Given, shapes: Uniform) -> Numbers:
    own = given.mass, given.c.tobytes(), given.R.tobytes(), given.entries
    return *own, shapes.volume, shapes.c.tobytes(), shapes.S.tobytes()


@lru_cache(maxsize=1024)
def _verdict(numbers: Numbers) -> Weighed:
    """Return what `weigh` does, once for the same numbers: a quarter of the links of a robot are like another one."""
    mass, c, R, entries, volume, centre, S = numbers
    given = Given(mass, np.frombuffer(c), np.frombuffer(R).reshape(3, 3), entries)
    return weigh(given, Uniform(volume, np.frombuffer(centre), np.frombuffer(S).reshape(3, 3)))


def judged(context: Context, tensors: bool = True) -> Iterator[Body]:
    """Yield the bodies whose mass matters in their group, where no slip of units is suspected and no mass repeated.

    Args:
        tensors: leave out those of which a slip of the tensor is named, too.
    """
    verdicts, again = context.once(weighed), context.once(repeated)
    for name, body in context.once(bodies).items():
        verdict = verdicts.get(name)
        explained = verdict is not None and (verdict.units or (tensors and verdict.named))
        if not explained and name not in again and share(context, body) is not None:
            yield body


def suspected(context: Context, body: Body, centre: bool = False) -> str | None:
    """Return what may explain that an inertia, or else a centre of mass, does not fit the shapes, in words; None if
    nothing does."""
    verdict = context.once(weighed).get(body.link.name)
    if verdict is None or verdict.right > DOUBTED:
        return None
    said, fits = given(body.link), (one for one in verdict.causes if _of_centre(one) == centre)
    if not centre and said is not None and raised(said) and any(said.entries[k] for k in PRODUCTS):
        return one_of([f"its moments were raised to {figure(said.entries[0], 2)} kg m^2, as simulators are helped"])
    return one_of(one.what for one in fits)


def _of_centre(cause: Cause) -> bool:
    return cause.units is not None and cause.units.factors[1] != 1
