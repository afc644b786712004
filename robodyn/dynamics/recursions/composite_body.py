"""The mass matrix by composite bodies, entry by entry, for any scalar."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.dynamics.recursions.articulated_body import AXES, turns_of
from robodyn.dynamics.recursions.articulated_inertia import articulated, at_parent, wrench_at_parent
from robodyn.dynamics.recursions.sparse import Entries, add_entry
from robodyn.programs.vectors import Array
from robodyn.robot.model import Model
from robodyn.robot.motion_types import Motion
from robodyn.solids.inertia.moments import Inertia


def composite_body(
    model: Model, motions: Sequence[Motion], inertias: Sequence[Inertia], rotors: Sequence[float]
) -> Entries:
    """M(q) as the entries (i, j), i <= j, that can be other than zero: pairs of joints of which one carries the other.

    Inward, the bodies that a joint carries are one rigid body, A its inertia; a unit acceleration of that joint asks
    for the wrench `F = A S`, and carried on inward F has the entry `M_ij = S_j . F` along the axis of every joint met.

    Source: Featherstone, *Rigid Body Dynamics Algorithms* (2008), table 6.2.

    Args:
        model: of `aligned`.
        motions, inertias: of each body.
        rotors: n reflected rotor inertias, added on the diagonal [kg m^2 or kg].

    Returns:
        A floating joint's entries are along its body's axes.

    Accuracy: 1e-14 of the largest entry.
    """
    A: list[Array] = [articulated(body) for body in inertias]
    entries: Entries = {(rate, rate): rotor for rate, rotor in enumerate(rotors) if rotor}
    for i, body in reversed(list(enumerate(model.bodies))):
        for rate, axis in enumerate(AXES[body.joint.kind], body.joint.rate):
            _column(entries, model, motions, i, rate, A[i][axis] * body.joint.multiplier)
        if (j := body.parent) >= 0:
            A[j] = A[j] + at_parent(A[i], turns_of(body.joint, motions[i].R), motions[i].p)
    return entries


def rates_inward(model: Model) -> list[int]:
    """All rates, those of the tips first: an order in which M is factorised without further entries."""
    inward = reversed(model.bodies)
    return list(
        dict.fromkeys(joint.rate + k for joint in (b.joint for b in inward) for k in range(len(AXES[joint.kind])))
    )


def _column(entries: Entries, model: Model, motions: Sequence[Motion], i: int, rate: int, F: Array) -> None:
    """Adds what the wrench F about body i does along the axes of the joints from body i to the base."""
    own = True
    while i >= 0:
        joint = model.bodies[i].joint
        for other, axis in enumerate(AXES[joint.kind], joint.rate):
            share = joint.multiplier * F[axis]
            if own:
                if other >= rate:
                    add_entry(entries, rate, other, share)
            else:
                add_entry(entries, rate, other, share * 2.0 if other == rate else share)
        F, own, i = wrench_at_parent(F, motions[i].R, motions[i].p), False, model.bodies[i].parent
