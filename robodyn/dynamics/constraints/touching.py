"""Which points of a scene's contacts touch at each sample."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robodyn.dynamics.constraints.constraint_jacobian import contact_jacobian
from robodyn.dynamics.constraints.structure import Mask
from robodyn.dynamics.constraints.tree import normal_of
from robodyn.dynamics.plan import Plan
from robodyn.errors import InputError
from robodyn.programs.vectors import product
from robodyn.scene.parts import ALWAYS, AUTO, Contact
from robodyn.support.floats import Floats
from robodyn.support.wording import shown


def touching(
    plan: Plan, q: Floats, qd: Floats, time: Floats | None, columns: Mapping[str, Floats], executor: str = "auto"
) -> Mask:
    """Return (N, K) which points touch, contact after contact.

    With AUTO each point by itself touches where it is at most `height` above the plane `normal . p = level` and slower
    than `speed`; otherwise a contact touches with all of its points.

    Args:
        q, qd: (N, nq), (N, n).
        time: (N,) s; None where there is none.
        columns: (N,) by name.

    Raises:
        InputError: intervals of time and no time, or a column that is missing.
    """
    contacts, at = plan.scene.contacts, 0
    found = np.zeros((len(q), sum(len(contact.points) for contact in contacts)), dtype=bool)
    near = _near(plan, q, qd, executor) if any(contact.on == AUTO for contact in contacts) else found
    for contact in contacts:
        k = slice(at, at + len(contact.points))
        found[:, k] = near[:, k] if contact.on == AUTO else _switched(contact, time, columns, len(q))[:, None]
        at = k.stop
    return found


def _switched(contact: Contact, time: Floats | None, columns: Mapping[str, Floats], count: int) -> Mask:
    """Return (N,) whether a contact is on by itself, by a column or by intervals."""
    if contact.on == ALWAYS:
        return np.ones(count, dtype=bool)
    if isinstance(contact.on, str):
        if contact.on not in columns:
            what = f"[[contact]] {shown(contact.name)} is on by the column {shown(contact.on)}"
            raise InputError(what, remedy="pass it as columns={name: values}")
        return np.asarray(columns[contact.on] != 0.0)
    if time is None:
        what = f"[[contact]] {shown(contact.name)} is on in intervals of time, and states have none"
        raise InputError(what, remedy="use robodyn.torques of a motion, or a column")
    return np.asarray(np.any([(time >= start) & (time <= end) for start, end in contact.on], axis=0))


def _near(plan: Plan, q: Floats, qd: Floats, executor: str) -> Mask:
    """Return (N, K) which points are low and slow."""
    here, parts, at = contact_jacobian(plan, q, qd, executor), [], 0
    for contact in plan.scene.contacts:
        k, normal = slice(at, at + len(contact.points)), normal_of(contact, plan.scene)
        high = product(normal, here.places[:, k].transpose(0, 2, 1)) - contact.level
        fast = np.sqrt((here.speeds[:, k] ** 2).sum(axis=2))
        parts.append((high <= contact.height) & (fast <= contact.speed))
        at = k.stop
    return np.hstack(parts)
