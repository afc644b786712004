"""What acts on a body, by the names that texts of the DAE form give joints and loops."""

from __future__ import annotations

from typing import NamedTuple

from robodyn.equations.dae.dae import Dae


class Acting(NamedTuple):
    """A force F and, unless it can carry none, a moment M: what joint or loop, "-" on the body that holds the other."""

    sign: str
    name: str
    moment: bool = True


def acting(found: Dae, i: int) -> list[Acting]:
    """Return what acts on body i: its own joint i, those of the bodies that it carries, and L1, L2 ... for loops."""
    model, system = found.robot.model, found.robot.system
    felt = [k for k, joint in enumerate(system.joints) if joint.kind != "floating" or _driven(found, k)]
    own = [Acting("", str(i))] if i in felt else []
    carried = [Acting("-", str(k)) for k in felt if model.parents[k] == i]
    loops = [
        Acting(sign, f"L{k}", loop.kind not in ("point", "directions"))
        for k, loop in enumerate(system.loops, 1)
        for sign, end in (("", loop.body), ("-", loop.other))
        if end == i
    ]
    return own + carried + loops


def _driven(found: Dae, i: int) -> bool:
    """Return whether something drives the floating joint of body i."""
    rate = found.robot.model.bodies[i].joint.rate
    return bool(found.tau[rate : rate + 6].any())
