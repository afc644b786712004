"""The mass matrix for arrays of samples."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of, results
from robodyn.dynamics.effects import rigid_bodies
from robodyn.dynamics.effects.motors import mass_entries
from robodyn.dynamics.plan import applied, plan
from robodyn.dynamics.recursions.newton_euler import mass_matrix as mass_matrix_of
from robodyn.dynamics.runners import runner_of
from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats


def mass_matrix(
    model: Model, q: ArrayLike, *, scene: Scene = DEFAULT, executor: str = "auto", threads: int | None = None
) -> Floats:
    """M(q), with payloads and rotor inertias of the scene.

    Args:
        q: (..., nq) rad or m.
        executor, threads: as for `inverse_dynamics`.

    Returns:
        (..., n, n) kg m^2, kg m or kg; exactly symmetric.

    Raises:
        InputError: a shape that does not fit the model.

    Accuracy: 1e-14 of the largest entry.
    """
    refuse_others(model, scene)
    sources, shape = arrays_of(model, {"q": q})
    return results(mass_runner(model, scene), sources, shape, (model.n, model.n), None, executor, threads)


@lru_cache(maxsize=16)
def mass_runner(model: Model, scene: Scene) -> Runner:
    """Return the entries of M(q) row by row, ready to run."""
    a_plan = plan(model, scene)

    def outputs(tape: Any) -> Any:
        sample = a_plan.sample(tape)
        inertias = applied([rigid_bodies.PAYLOAD], sample, scene).inertias
        return mass_matrix_of(model, sample.q, inertias, mass_entries(sample, scene)).ravel()

    return runner_of(trace(outputs), a_plan)
