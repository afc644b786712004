"""The door of this room: two models -> what differs, and what that does to the torques.

1. `alignment` matches the bodies, and finds how the frame of each stands in that of its partner.
2. `differences` lists what is apart: the tree, joints, masses, what acts on joints, each with its cause if one is seen.
3. `torques` says what that does: for each joint the largest difference over poses and motions within the limits, and
   which single difference is guilty of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robodyn.comparison.alignment import Pair, aligned
from robodyn.comparison.differences import Difference, differences
from robodyn.comparison.torques import TorqueDifference, torque_differences
from robodyn.robot.model import Model
from robodyn.scene.fit import scene_of
from robodyn.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Comparison:
    """What two descriptions of one robot differ in.

    Attributes:
        a, b: the models.
        pairs: which body of b each of a is, and how its frame stands there.
        differences: those that act on the torques first, the largest first.
        torques: for each joint that both have, in the order of a; empty where loops or free bodies let no
            torque be compared joint by joint.
        tolerance: torque [N m, N] that may differ; None: nothing may.
        notes: what was not compared, and links of another name.
    """

    a: Model
    b: Model
    pairs: tuple[Pair, ...]
    differences: tuple[Difference, ...]
    torques: tuple[TorqueDifference, ...]
    tolerance: float | None
    notes: tuple[str, ...] = ()

    @property
    def worst(self) -> TorqueDifference | None:
        """The joint whose torque differs most, in the share of its limit or, without one, of its largest torque."""
        return max(self.torques, key=lambda one: one.share, default=None)

    @property
    def equal(self) -> bool:
        """Whether nothing differs; with a tolerance whatever changes torques by no more is nothing."""
        if any(one.exceeds(self.tolerance) for one in self.torques):
            return False
        forgiven = self.tolerance is not None and bool(self.torques)
        return not [one for one in self.differences if not (one.acts and forgiven)]


def compare(
    a: Model, b: Model, scene_a: Scene | None = None, scene_b: Scene | None = None, *, tolerance: float | None = None
) -> Comparison:
    """Return what differs between two models of one robot, and what it does to the torques.

    Args:
        scene_a, scene_b: what surrounds each; by default what its own file says of it.
        tolerance: what changes no torque by more [N m or N] is no difference; by default all is.

    Raises:
        InputError: a scene does not fit its model.
    """
    scenes = scene_of(a) if scene_a is None else scene_a, scene_of(b) if scene_b is None else scene_b
    pairs = aligned(a, b)
    found = differences(a, b, scenes, pairs)
    torques, notes = torque_differences(a, b, scenes, pairs, found)
    return Comparison(a, b, pairs, _ranked(found, torques), torques, tolerance, (*_renamed(a, b, pairs), *notes))


def _ranked(found: Sequence[Difference], torques: Sequence[TorqueDifference]) -> tuple[Difference, ...]:
    guilt = {id(one.difference): one.share for one in sorted(torques, key=lambda one: one.share)}
    return tuple(sorted(found, key=lambda one: (-guilt.get(id(one), 0.0), not one.acts)))


def _renamed(a: Model, b: Model, pairs: Sequence[Pair]) -> list[str]:
    names = ((a.bodies[pair.a].name, b.bodies[pair.b].name) for pair in pairs if pair.a)
    return [f"link {mine!r} is {theirs!r} in B" for mine, theirs in names if mine != theirs]
