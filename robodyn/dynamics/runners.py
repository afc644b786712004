"""Programs of a plan, ready to run."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

from robodyn.dynamics.effects.effect import ZeroColumns
from robodyn.dynamics.plan import Plan, plan
from robodyn.programs.program import Program
from robodyn.programs.run.runner import Runner
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene


@lru_cache(maxsize=16)
def torque_runner(model: Model, scene: Scene, zero_columns: ZeroColumns = frozenset()) -> Runner:
    """Return tau of their plan, ready to run."""
    a_plan = plan(model, scene, zero_columns)
    return runner_of(a_plan.torques(), a_plan)


def runner_of(program: Program, a_plan: Plan, more: Mapping[str, int] = MappingProxyType({})) -> Runner:
    """Return a program of this plan, ready to run; `more` are widths of sources that are its own."""
    model = a_plan.model
    widths = {"q": model.nq, "qd": model.n, "qdd": model.n, "tau": model.n, "columns": len(a_plan.scene.columns)}
    return Runner(program, {**widths, **more})
