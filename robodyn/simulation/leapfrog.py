"""Whether Verlet's method applies: accelerations must not depend on speeds, which the traced program shows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from robodyn.dynamics.effects.effect import Effect
from robodyn.errors import InputError
from robodyn.programs.program import trace
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.simulation.equations import STATE, Equations


def check_leapfrog(equations: Equations) -> None:
    """Raise if the accelerations of a robot in a scene depend on its speeds.

    Raises:
        InputError: they do; it names the effects that make them.
    """
    scene, effects = equations.scene, equations.plan.effects
    if not _needs_speed(equations, effects):
        return
    undriven = Equations(replace(equations.plan, scene=replace(scene, drive={})))
    causes = [effect.name for effect in effects if _needs_speed(undriven, [effect])]
    causes = ["loops"] if scene.loops else causes
    causes += ["drives with kd"] * any(drive.kd for drive in scene.drive.values())
    what = f"verlet does not apply: accelerations depend on speeds ({', '.join(causes)})"
    raise InputError(what, remedy="--method gauss2 keeps energy too, whatever forces there are")


def _needs_speed(equations: Equations, effects: Sequence[Effect]) -> bool:
    nq, n = equations.model.nq, equations.model.n

    def outputs(tape: Tape) -> Iterable[Scalar]:
        state = equations.state(tape)
        return equations.accelerations(state.q, state.qd, equations.given(tape), effects)[0]

    return bool({(STATE, nq + i) for i in range(n)} & trace(outputs).inputs)
