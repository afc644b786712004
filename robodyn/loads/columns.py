"""Names of the columns of tables of results."""

from __future__ import annotations

from collections.abc import Sequence

from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.trajectory.columns.signals import COMPONENTS


def output_names(model: Model, reactions: bool, momentum: bool = False, scene: Scene = DEFAULT) -> list[str]:
    """Names of the columns of loads: tau, then the base wrench, then joint wrenches, then momentum and energy.

    In a scene with constraints tau of the drives alone, and after it the wrenches of loops and contacts.
    """
    names = [f"tau_{name}" for name in model.rates]
    if reactions:
        names += [f"base_{part}" for part in COMPONENTS]
        names += [f"{part}_{body.joint.name}" for body in model.bodies[1:] for part in COMPONENTS]
    if momentum:
        from robodyn.loads.momenta import NAMES

        names += NAMES
    return _constrained(model, scene, names) if scene.constrained else names


def _constrained(model: Model, scene: Scene, names: Sequence[str]) -> list[str]:
    """Return the names under constraints; names: those of the tree."""
    from robodyn.dynamics.constraints.constraint_jacobian import columns_of
    from robodyn.dynamics.constraints.solve import actuation

    passive = actuation(model, scene).passive.tolist()
    driven = [name for name, free in zip(names, passive, strict=False) if not free]
    wrenches = [column for name in scene.constraint_names for column in columns_of(name)]
    return [*driven, *wrenches, *names[model.n :]]
