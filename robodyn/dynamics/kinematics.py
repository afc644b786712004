"""Where links are and how they move, for arrays of samples."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.arrays import arrays_of, results
from robodyn.dynamics.plan import plan, runner_of
from robodyn.errors import InputError
from robodyn.programs import derivative
from robodyn.programs.program import trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar, cross, vector
from robodyn.robot.kinematics import poses, velocities
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT
from robodyn.support.floats import Floats
from robodyn.support.wording import alternatives, shown


class LinkPose(NamedTuple):
    """R (..., 3, 3) takes components in the link's axes to the ground's; p (..., 3) is the link's origin there [m]."""

    R: Floats
    p: Floats


def forward_kinematics(
    model: Model, q: ArrayLike, link: str, *, executor: str = "auto", threads: int | None = None
) -> LinkPose:
    """Return where a link is at q (..., nq), as for `inverse_dynamics`; InputError if there is no such link.

    Accuracy: 1e-14 of the longest chain of offsets, for chains of up to 100 bodies.
    """
    sources, shape = arrays_of(model, {"q": q})
    found = results(_runner(model, link), sources, shape, (12,), None, executor, threads)
    return LinkPose(found[..., :9].reshape(*shape, 3, 3), found[..., 9:])


def jacobian(
    model: Model,
    q: ArrayLike,
    link: str,
    point: Sequence[float] = (0.0, 0.0, 0.0),
    *,
    executor: str = "auto",
    threads: int | None = None,
) -> Floats:
    """Return J (..., 6, n) with (w, v) = J qd: velocities of a link and of its point, in the ground's axes.

    A force f at the point and a moment m on the link do `J^T (m, f)` along the coordinates. The point is in the link's
    frame [m]; rows are wx wy wz vx vy vz [rad/s, m/s], columns as `model.rates`. InputError for a link or point that is
    none.

    Accuracy: 1e-14 of the largest entry of its three rows, for chains of up to 100 bodies.
    """
    at = tuple(float(x) for x in point)
    if len(at) != 3 or not np.isfinite(at).all():
        raise InputError(f"{at} is no point", remedy="three finite coordinates in metres")
    sources, shape = arrays_of(model, {"q": q})
    return results(_runner(model, link, at), sources, shape, (6, model.n), None, executor, threads)


@lru_cache(maxsize=16)
def _runner(model: Model, link: str, point: tuple[float, ...] | None = None) -> Runner:
    """The pose of a link, or the Jacobian of a point of it, ready to run."""
    if link not in model.links:
        remedy = alternatives(link, list(model.links), "links")
        raise InputError(f"no link {shown(link)}", remedy=remedy, file=model.file)
    a_plan = plan(model, DEFAULT)

    def outputs(tape: Tape) -> Iterable[Scalar]:
        sample = a_plan.sample(tape)
        body, R, p = sample.model.links[link]
        joints = sample.motions()
        where = poses(model.parents, joints)[body]
        if point is None:
            return [*(where.R @ R).ravel(), *(where.p + where.R @ p)]
        w, v = velocities(model.parents, joints)[body]
        motion = [*(where.R @ w), *(where.R @ (v + cross(w, p + R @ vector(*point))))]
        return [x for row in derivative.jacobian(motion, [{rate: 1.0} for rate in sample.qd]) for x in row]

    return runner_of(trace(outputs), a_plan)
