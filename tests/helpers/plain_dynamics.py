"""Small robots by equations of their own, and their motions in more digits: oracles for simulated accuracy.

The equations are written by hand, but for those of trees, and integrated by LSODA, which switches between Adams'
methods and backward differences, or by extrapolation of the midpoint rule in long doubles.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from helpers.simulated_robots import mass_on_a_table, pendulum, slide
from helpers.small_robots import random_tree
from robodyn import forward_dynamics
from robodyn.robot.model import Model
from robodyn.scene.scene import Drive, Friction, Scene

G = 9.81
Rates = Callable[[Any, Any], list[Any]]
"""qdd of q and qd, numbers of any kind."""


class Plain(NamedTuple):
    """A robot with joints that rub and are driven, and its equations by hand.

    Attributes:
        solve: qdd of q, qd and the torques on the joints.
    """

    model: Model
    names: tuple[str, ...]
    gravity: float
    solve: Callable[[Any, Any, Any], list[Any]]


def plain_slide(mass):
    return Plain(slide(mass), ("j1",), 0.0, lambda q, qd, tau: [tau[0] / mass])


def plain_pendulum():
    return Plain(pendulum(), ("j1",), G, lambda q, qd, tau: [tau[0] - G * np.sin(q[0])])


def plain_double_pendulum():
    """Point masses of 1 kg on rods of 1 m; the second angle counts from the first rod."""

    def solve(q, qd, tau):
        s, c = np.sin(q[1]), np.cos(q[1])
        lower = G * np.sin(q[0] + q[1])
        first = tau[0] + s * qd[1] * (2 * qd[0] + qd[1]) - 2 * G * np.sin(q[0]) - lower
        second = tau[1] - s * qd[0] * qd[0] - lower
        both, alone = 3 + 2 * c, 1 + c
        det = both - alone * alone
        return [(first - alone * second) / det, (both * second - alone * first) / det]

    return Plain(pendulum(masses=2), ("j1", "j2"), G, solve)


def plain_turntable(inertia):
    """1 kg on a slide through the axis of a turntable."""

    def solve(q, qd, tau):
        w, r, rd = qd[0], q[1], qd[1]
        return [(tau[0] - 2 * r * rd * w) / (inertia + r * r), tau[1] + r * w * w]

    return Plain(mass_on_a_table(inertia), ("turn", "rail"), 0.0, solve)


def plain_tree(seed):
    """A tree of three skew joints, by robodyn's own forward dynamics of one sample after another."""
    model = random_tree(seed, n=3, kinds=("revolute", "prismatic"))

    def solve(q, qd, tau):
        return forward_dynamics(model, np.array(q), np.array(qd), np.array(tau), executor="compiled").tolist()

    return Plain(model, model.joint_names, G, solve)


class Case(NamedTuple):
    """A motion for a sweep: what robodyn is given, and the rates of q and qd by hand."""

    model: Model
    scene: Scene
    duration: float
    rates: Callable[[Any], Any]
    start: Any


def case(plain: Plain, joints: dict[str, dict[str, float]], q, qd, duration: float, slip: float = 1e-3) -> Case:
    """A case of joints by name with `f` (Coulomb), `d` (viscous), `kp`, `kd`, `to` (reference) and `tau`."""
    parts = [{"f": 0.0, "d": 0.0, "kp": 0.0, "kd": 0.0, "to": 0.0, "tau": 0.0} | joints.get(n, {}) for n in plain.names]
    named = dict(zip(plain.names, parts, strict=True))
    scene = Scene(
        gravity=(0.0, 0.0, -plain.gravity),
        friction={n: Friction(forward=p["f"], backward=-p["f"], viscous=p["d"]) for n, p in named.items()},
        drive={n: Drive(p["tau"], p["kp"], p["kd"], p["to"]) for n, p in named.items()},
        initial_q=dict(zip(plain.names, q, strict=True)),
        initial_qd=dict(zip(plain.names, qd, strict=True)),
        slip_speed=slip,
        joint_limits="ignore",
    )

    def rates(y):
        n = len(parts)
        tau = [
            p["tau"] + p["kp"] * (p["to"] - x) - (p["kd"] + p["d"]) * v - p["f"] * v / np.sqrt(v * v + slip * slip)
            for p, x, v in zip(parts, y[:n], y[n:], strict=True)
        ]
        return [*y[n:], *plain.solve(y[:n], y[n:], tau)]

    return Case(plain.model, scene, duration, rates, [*q, *qd])


def by_lsoda(case: Case, times, rtol: float):
    """States (N, 2 n) at increasing times, the first of which is 0."""
    from scipy.integrate import odeint

    return odeint(lambda _, y: case.rates(y), case.start, times, tfirst=True, rtol=rtol, atol=rtol * 1e-4, mxstep=10**6)


def in_long_doubles(case: Case, times, tolerance: float = 1e-17):
    """States (N, 2 n) at increasing times by Gragg's, Bulirsch's and Stoer's extrapolation, without stiff parts."""
    counts = range(2, 18, 2)

    def rates(y):
        return np.array(case.rates(y), dtype=np.longdouble)

    def step(y, h):
        """The state after a step, and how much the last extrapolation changed it."""
        first, table = rates(y), []
        for k, count in enumerate(counts):
            part = h / count
            before, here = y, y + part * first
            for _ in range(count - 1):
                before, here = here, before + 2 * part * rates(here)
            row = [(before + here + part * rates(here)) / 2]
            for j in range(1, k + 1):
                ratio = np.longdouble(count) / np.longdouble(counts[k - j])
                row.append(row[j - 1] + (row[j - 1] - table[k - 1][j - 1]) / (ratio * ratio - 1))
            table.append(row)
        return table[-1][-1], float(np.abs(table[-1][-1] - table[-1][-2]).max() / (1 + np.abs(y).max()))

    y, now, h = np.array(case.start, dtype=np.longdouble), np.longdouble(0.0), np.longdouble(0.02)
    found = [y]
    for time in times[1:]:
        while now < time:
            last = h >= time - now
            part = time - now if last else h
            after, error = step(y, part)
            if error <= tolerance:
                y, now = after, np.longdouble(time) if last else now + part
            if not last or error > tolerance:
                h = part * min(4.0, max(0.2, 0.9 * (tolerance / max(error, 1e-30)) ** (1 / 15)))
        found.append(y)
    return np.array(found, dtype=float)
