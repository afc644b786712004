"""Which joints and loops act on a body, by the names that texts of the DAE form give them."""

from __future__ import annotations

from robodyn.maximal.dae import Dae


def acting(found: Dae, i: int) -> list[tuple[str, str]]:
    """(sign, name) of what acts on body i: its own joint i, "-" for those that it carries, L1, L2 ... for loops."""
    model, system = found.robot.model, found.robot.system
    own = [("", str(i))] if system.joints[i].kind != "floating" or any(found.tau[:6]) else []
    carried = [("-", str(k)) for k, parent in enumerate(model.parents) if parent == i]
    loops = [
        (sign, f"L{k}")
        for k, loop in enumerate(system.loops, 1)
        for sign, end in (("", loop.body), ("-", loop.other))
        if end == i
    ]
    return own + carried + loops
