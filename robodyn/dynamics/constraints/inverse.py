"""Inverse dynamics under constraints for arrays of samples."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of, numbers, zero_sources
from robodyn.dynamics.constraints.constraint_jacobian import closures, constraint_columns, open_scene, tree_scene
from robodyn.dynamics.constraints.solve import ConstraintSolver, actuation, touching
from robodyn.dynamics.loops.closure import loops_size
from robodyn.dynamics.plan import Plan, plan, torque_runner
from robodyn.errors import InputError
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import shown

CLOSED = 1e-3
"""rad, or of the loops' size and at most m, by which loops may be open."""


class ConstrainedForces(NamedTuple):
    """What the drives, loops and contacts of a robot bear.

    Attributes:
        tau: (..., n) of the drives [N m or N], 0 at passive rates but for what nothing gives.
        wrenches: by name (..., 6) force [N] and moment [N m] on its link: of a loop at its point in the axes of the
            other link, of a contact at the middle of its points in the axes of the ground.
    """

    tau: Floats
    wrenches: Mapping[str, Floats]


def constraint_forces(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    *,
    scene: Scene,
    columns: Mapping[str, ArrayLike] | None = None,
    executor: str = "auto",
    threads: int | None = None,
) -> ConstrainedForces:
    """Return torques of the drives, and the forces of loops and contacts, that a motion takes.

    `S_a tau_a + J^T x = M qdd + b`, solved for the torques of the joints that drive and the forces x of loops and
    contacts; see docs/explanation/constraints.md for what is taken where they are open.

    Args:
        model, executor, threads: as for `inverse_dynamics`.
        q, qd, qdd: (..., nq), (..., n), (..., n); all coordinates, on the loops.
        scene: with loops, contacts or passive joints.
        columns: (...) values of the columns that the scene's wrenches and contacts name.

    Raises:
        InputError: as `inverse_dynamics`; or a number is not finite; or a loop is open by more than 1e-3 rad, 1e-3 m or
            1e-3 of its size; or a contact is on by intervals of time.

    Accuracy: 1e-10 of the largest torque, where the loops are not nearly singular.
    """
    tau, wrenches = _solved(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, executor, threads)
    parts = {name: wrenches[..., 6 * i : 6 * i + 6] for i, name in enumerate(scene.constraint_names)}
    return ConstrainedForces(tau, parts)


def as_tree(
    model: Model, state: tuple[ArrayLike, ArrayLike, ArrayLike], scene: Scene, columns: Mapping[str, ArrayLike]
) -> tuple[Scene, dict[str, ArrayLike], Floats]:
    """Return the scene of `tree_scene`, its columns at a state (q, qd, qdd), and (..., n) what that takes at passive
    rates and nothing gives, 0 elsewhere."""
    given = dict(zip(("q", "qd", "qdd"), state, strict=True))
    tau, wrenches = _solved(model, given, scene, columns, "numpy", None)
    found = dict(zip(constraint_columns(scene), np.moveaxis(wrenches, -1, 0), strict=True))
    missing = np.where(actuation(model, scene).passive, tau, 0.0)
    return tree_scene(model, scene), {**columns, **found}, missing


def _solved(
    model: Model,
    given: Mapping[str, ArrayLike],
    scene: Scene,
    columns: Mapping[str, ArrayLike],
    executor: str,
    threads: int | None,
) -> tuple[Floats, Floats]:
    """Return torques (..., n) and wrenches (..., c) by `constraint_columns`."""
    sources, shape = arrays_of(model, given, scene, columns)
    samples = prod(shape)
    for name in given:
        finite = np.isfinite(sources[name]).all(axis=1)
        if not finite.all():
            raise InputError(f"{name} of sample {np.argmin(finite)} is not finite", remedy="leave such samples out")
    on = {name: _of_samples(name, columns[name], shape) for name in scene.motion_columns if name in columns}
    runner = torque_runner(model, open_scene(scene), zero_sources(sources))
    open_tau = runner.run(sources, samples, executor=executor, threads=threads).values
    q, qd = np.ascontiguousarray(sources["q"]), np.ascontiguousarray(sources["qd"])
    solver = ConstraintSolver(plan(model, scene), executor)
    tau, wrenches = np.empty((samples, model.n)), np.empty((samples, len(constraint_columns(scene))))
    for k in solver.pieces(samples):
        here = {name: values[k] for name, values in on.items()}
        found = solver.solve(q[k], qd[k], open_tau[k], touching(solver.plan, q[k], qd[k], None, here, executor))
        _check_closed(solver.plan, found.gap)
        tau[k], wrenches[k] = found.tau, found.wrenches
    return tau.reshape(*shape, model.n), wrenches.reshape(*shape, wrenches.shape[1])


def _of_samples(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Floats:
    given = numbers(name, values, np.dtype(float))
    if np.isnan(given).any():
        what = f"column {shown(name)} of contacts is not a number at {np.isnan(given).sum()} of {given.size} samples"
        raise InputError(what, remedy="0 where a contact is off, 1 where it is on")
    try:
        return np.broadcast_to(given, shape).reshape(prod(shape))
    except ValueError:
        what = f"column {shown(name)} of contacts has the shape {given.shape}, the samples {shape}"
        raise InputError(what, remedy="give one value for each sample") from None


def _check_closed(a_plan: Plan, gap: Floats) -> None:
    """Raise if a loop is open; gap: (N, m) phi of the loops' equations."""
    if not gap.size:
        return
    found = closures(a_plan)
    equations = [(each.loop.name, equation.unit) for each in found for equation in each.equations]
    size = min(1.0, loops_size(a_plan.model, found))
    shares = np.abs(gap).max(axis=0) / [size if unit == "m" else 1.0 for _, unit in equations]
    worst = int(shares.argmax())
    if shares[worst] > CLOSED:
        name, unit = equations[worst]
        what = f"loop {shown(name)} is open by {np.abs(gap[:, worst]).max():.3g} {unit}"
        remedy = "give coordinates that close it; robodyn.torques finds them from those of the drives"
        raise InputError(what, remedy=remedy)
