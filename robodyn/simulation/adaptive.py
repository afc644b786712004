"""Steps as long as a tolerance allows: DOP853 and Radau of SciPy."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robodyn.errors import InputError
from robodyn.execute.repeated import COLUMNS
from robodyn.inverse import runner_of
from robodyn.plan import Plan
from robodyn.simulation.equations import STATE, Equations
from robodyn.simulation.fixed import Motion
from robodyn.simulation.how import TooMuchError
from robodyn.simulation.limits import Limits
from robodyn.simulation.methods import Method
from robodyn.simulation.table import Signal

Floats = NDArray[np.float64]
EXPECTED = 4000
"""Evaluations that a motion usually takes at least: machine code is made for them where that is quicker."""

GENTLER = "give a larger --rtol, or --method radau where friction or a drive is stiff"


def adaptive_motion(
    plan: Plan,
    method: Method,
    state: Floats,
    duration: float,
    rtol: float,
    limits: Limits,
    executor: str,
    signal: Signal,
    most: float = inf,
) -> Motion:
    """The motion from a state (width,), recorded at every step that the method takes.

    The error of each step is kept below `rtol (1 + |y|)` in q, qd and work. Quaternions are four numbers here, of any
    length; those of the record have unit length.

    Args:
        most: evaluations of the equations of motion.

    Raises:
        TooMuchError: it takes more.
        InputError: the method gives up.
    """
    from scipy.integrate import solve_ivp

    equations = Equations(plan)
    runner = runner_of(equations.derivatives(), plan, {STATE: equations.width, COLUMNS: len(signal.curves)})
    used, count, expected = "", 0, EXPECTED if most == inf else int(most)

    def rates(time: float, y: Any) -> Any:
        nonlocal used, count
        columns = y.reshape(len(y), -1)
        samples = columns.shape[1]
        count += samples
        if count > most:
            what = f"{method.name} has taken {most:.3g} evaluations and is at {time:.3g} s"
            raise TooMuchError(what, time, columns[:, 0], GENTLER)
        sources = {STATE: np.vstack((columns, np.zeros(samples))).T}
        if signal.curves:
            sources[COLUMNS] = np.repeat(signal.at(np.array([time])), samples, axis=0)
        found = runner.run(sources, samples, executor=executor, expected=expected)
        used = found.choice.executor
        return found.values.T.reshape(y.shape)

    def room(_: float, y: Any) -> float:
        return float(limits.room(y[: plan.model.nq]).min())

    room.terminal, room.direction = True, -1.0  # type: ignore[attr-defined]
    events = [room] if limits.stops else None
    how = {"method": method.scipy, "rtol": rtol, "atol": rtol, "events": events, "vectorized": True}
    how["max_step"] = signal.longest_step
    with np.errstate(all="ignore"):
        found = solve_ivp(rates, (0.0, duration), state[:-1], **how)
    if found.status < 0 or not np.isfinite(found.y).all():
        at = f"{method.name} gives up at {found.t[-1]:.6g} s: {str(found.message).lower().rstrip('.')}"
        raise InputError(at, remedy=GENTLER)
    new = np.diff(found.t, prepend=-1.0) > 0.0  # all but a limit that is reached where the motion begins
    time, states = found.t[new], np.column_stack((found.y.T, np.zeros(len(found.t))))[new]
    for joint in plan.model.independent:
        if joint.kind == "floating":
            h = states[:, joint.coordinate + 3 : joint.coordinate + 7]
            h /= np.linalg.norm(h, axis=1)[:, None]
    ended = limits.nearest(states[-1]).reached(float(time[-1])) if found.status == 1 else ""
    return Motion(time, states, len(time) - 1, 1, used, ended, int(found.nfev))
