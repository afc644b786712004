"""IFToMM's benchmarks A01 and A02 in one run: `cd tests && python -m benchmarks.bench_iftomm`.

A01, a pendulum let go from the horizontal: the cheapest setting of each program that keeps the bob within 1 mm of its
exact place at 10, 100, 1000 and 2000 s. Settings are tried from coarse to fine; the least of some repetitions counts.
A02, N four-bars through loops: time for 10 s, and the errors of place and energy. Times are those of the processor, in
one process and one thread; imports do not count, nor does reading the robot. MuJoCo steps in C, ten seconds of A01 a
call; Pinocchio's `aba` is called from Python, as it has no integrator; SciPy's methods are given a plain Python
function. First calls are made in processes of their own whose cache of machine code is empty: they trace the equations
and have LLVM compile them.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from functools import partial
from math import cos, sin
from pathlib import Path
from time import process_time

import mujoco
import numpy as np
import pinocchio as pin
from helpers.closed_chains import four_bars
from helpers.machine import machine
from helpers.markdown_tables import main, table
from scipy.integrate import solve_ivp

import robodyn

ROBOTS = Path(__file__).parents[2] / "robots"
REFERENCE = Path(__file__).parents[1] / "data" / "reference"
BAR = 1e-3
G = 9.81
PLACES = [
    row[:3]
    for row in json.loads((REFERENCE / "analytic.json").read_text())["A01_pendulum_exact"]["rows"]
    if float(row[0]) in (10.0, 100.0, 1000.0, 2000.0)
]
"""Of the bob: t, x, z."""
STEPS = (0.1, 0.05, 0.04, 0.025, 0.02, 0.0125, 0.01, 0.008, 0.005, 0.004, 0.0025, 0.002, 0.001, 0.0005, 0.00025)
RTOL = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
LONG = 2000.0
EVERY = 10.0
"""s between records of fixed steps."""

Run = Callable[[float], list[float]]
"""The angle at every time of PLACES, by a step [s] or a tolerance."""


def error(angles: Iterable[float]) -> float:
    """m, the largest distance of the bob from where it should be."""
    pairs = zip(angles, PLACES, strict=True)
    return max(float(np.hypot(cos(q) - float(x), sin(q) - float(z))) for q, (_, x, z) in pairs)


def of_records(q: Iterable[float]) -> list[float]:
    """The angles at the times of PLACES, from records every 10 s that begin at 0."""
    rows = list(q)
    return [float(rows[round(float(t) / EVERY)]) for t, _, _ in PLACES]


def ours(method: str) -> Run:
    model = robodyn.load(ROBOTS / "pendulum.urdf")

    def run(step: float) -> list[float]:
        steps, every = round(LONG / step), round(EVERY / step)
        zero = np.zeros((1, 1))
        found = robodyn.rollouts(
            model, zero, zero, steps, step, every=every, method=method, executor="compiled", threads=1
        )
        return of_records(found.q[:, 0, 0])

    return run


def scipys(method: str) -> Run:
    def run(rtol: float) -> list[float]:
        times = [float(t) for t, _, _ in PLACES]
        how = {"t_eval": times, "rtol": rtol, "atol": rtol}
        found = solve_ivp(lambda _, y: (y[1], -G * cos(y[0])), (0.0, LONG), (0.0, 0.0), method, **how)
        return found.y[0].tolist() if found.success else [0.0] * len(times)

    return run


def mujocos(integrator: str) -> Run:
    def run(step: float) -> list[float]:
        model = mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{step!r}" integrator="{integrator}" gravity="0 0 -{G}"/><worldbody><body>'
            '<joint axis="0 -1 0"/><inertial pos="1 0 0" mass="1" diaginertia="1e-12 1e-12 1e-12"/></body></worldbody>'
            "</mujoco>"
        )
        data, q = mujoco.MjData(model), [0.0]
        for _ in range(round(LONG / EVERY)):
            mujoco.mj_step(model, data, round(EVERY / step))
            q.append(float(data.qpos[0]))
        return of_records(q)

    return run


def pinocchios() -> Run:
    model = pin.buildModelFromUrdf(str(ROBOTS / "pendulum.urdf"))
    data, still = model.createData(), np.zeros(1)

    def rate(angle: float, v: np.ndarray) -> np.ndarray:
        return pin.aba(model, data, np.array((cos(angle), sin(angle))), v, still)

    def run(step: float) -> list[float]:
        q, v, records = 0.0, np.zeros(1), [0.0]
        for k in range(round(LONG / step)):
            a1 = rate(q, v)
            v2 = v + step / 2 * a1
            a2 = rate(q + step / 2 * v[0], v2)
            v3 = v + step / 2 * a2
            a3 = rate(q + step / 2 * v2[0], v3)
            v4 = v + step * a3
            a4 = rate(q + step * v3[0], v4)
            q += step / 6 * (v[0] + 2 * v2[0] + 2 * v3[0] + v4[0])
            v = v + step / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            if (k + 1) % round(EVERY / step) == 0:
                records.append(q)
        return of_records(records)

    return run


def cheapest(run: Run, settings: Iterable[float]) -> tuple[float, float, float]:
    """The first setting that is accurate enough, its error, and the least time of some runs."""
    for setting in settings:
        start = process_time()
        found = error(run(setting))
        spent = [process_time() - start]
        if found <= BAR:
            while sum(spent) < 1.0 and len(spent) < 30:
                start = process_time()
                run(setting)
                spent.append(process_time() - start)
            return setting, found, min(spent)
    return np.nan, np.nan, np.nan


COLD = """\
import sys, time
sys.path.insert(0, {tests!r})
import numpy as np, robodyn, robodyn.simulation.rollouts, llvmlite.binding
from helpers.closed_chains import four_bars
{ready}
start = time.process_time()
{call}
print(time.process_time() - start)
"""


def first_call(ready: str, call: str) -> float:
    """s of a call in a new process whose cache of machine code is empty."""
    code = COLD.format(tests=str(Path(__file__).parents[1]), ready=ready, call=call)
    with tempfile.TemporaryDirectory() as folder:
        around = {**os.environ, "ROBODYN_CACHE": folder}
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=folder, env=around, check=True, stdout=subprocess.PIPE, text=True
        )
    return float(done.stdout)


def a01() -> str:
    rows, times = [], {}
    for name, run, settings in (
        *((f"robodyn, {method}", ours(method), STEPS) for method in ("verlet", "rk4", "gauss6")),
        *((f"MuJoCo, {method}", mujocos(method), STEPS[3:]) for method in ("RK4", "implicitfast")),
        *((f"SciPy, {method}", scipys(method), RTOL) for method in ("DOP853", "RK45", "LSODA", "Radau")),
        ("Pinocchio's `aba`, RK4 in Python", pinocchios(), STEPS[5:]),
    ):
        setting, found, spent = cheapest(run, settings)
        times[name] = (spent, setting)
        said = f"rtol {setting:.0e}" if settings is RTOL else f"{setting:g} s"
        rows.append([name, said, f"{found:.1e}", f"{1e3 * spent:.3g}"])
    best = min((name for name in times if name.startswith("robodyn")), key=lambda name: times[name][0])
    peer = min((name for name in times if not name.startswith("robodyn")), key=lambda name: times[name][0])
    for row in rows:
        row.append(f"{times[row[0]][0] / times[best][0]:.3g}")
    method, step, zero = best.split(", ")[1], times[best][1], "np.zeros((1, 1))"
    steps = round(LONG / step)
    how = f'every={steps}, method="{method}", executor="compiled"'
    call = f"robodyn.rollouts(model, {zero}, {zero}, {steps}, {step}, {how})"
    cold = first_call(f"model = robodyn.load({str(ROBOTS / 'pendulum.urdf')!r})", call)
    head = ("A01: 2000 s", "setting", "error [m]", "time [ms]", "ratio")
    faster, at_first = times[peer][0] / times[best][0], times[peer][0] / cold
    said = (
        f"\n{best}, is {faster:.3g} times as fast as the fastest of the others, {peer}. Its first call, with\n"
        f"tracing and machine code being made, takes {1e3 * cold:.0f} ms: {at_first:.2g} times as fast.\n\n"
    )
    return table(head, rows, left=(0, 1)) + said


def reduced(count: int) -> np.ndarray:
    """x, z of B0 after 10 s, from the exact reduction to one degree of freedom."""
    ratio = ((count + 1) / 2 + count) * G / ((count + 1) / 3 + count)
    how = {"rtol": 1e-13, "atol": 1e-13}
    found = solve_ivp(lambda _, y: (y[1], -ratio * cos(y[0])), (0.0, 10.0), (np.pi / 2, -1.0), "DOP853", **how)
    angle = found.y[0, -1]
    return np.array((cos(angle), sin(angle)))


def mujoco_bars(count: int, step: float, integrator: str) -> mujoco.MjModel:
    """The four-bars with `connect`, as stiff as MuJoCo takes: a time constant of two steps."""
    inertial = '<inertial pos=".5 0 0" mass="1" diaginertia="1e-9 .08333333333333333 .08333333333333333"/>'
    hinge = '<joint axis="0 -1 0"/>'
    bodies = "".join(
        f'<body name="k{k}" pos="{k} 0 0">{hinge}{inertial}'
        + (f'<body name="c{k}" pos="1 0 0">{hinge}{inertial}</body>' if k < count else "")
        + "</body>"
        for k in range(count + 1)
    )
    stiff = f'solref="{2 * step!r} 1" solimp="0.9999 0.9999 0.001"'
    ties = "".join(f'<connect body1="c{k}" body2="k{k + 1}" anchor="1 0 0" {stiff}/>' for k in range(count))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{step!r}" integrator="{integrator}" gravity="0 0 -{G}"/>'
        f"<worldbody>{bodies}</worldbody><equality>{ties}</equality></mujoco>"
    )


def by_mujoco(count: int, step: float, integrator: str) -> tuple[float, float, float]:
    """Errors of place and energy, and seconds."""
    model = mujoco_bars(count, step, integrator)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    for k in range(model.nbody - 1):
        crank = model.body(k + 1).name[0] == "k"
        data.qpos[k], data.qvel[k] = (np.pi / 2, -1.0) if crank else (-np.pi / 2, 1.0)
    mujoco.mj_forward(model, data)
    begun, drift, start = data.energy.sum(), 0.0, process_time()
    for _ in range(100):
        mujoco.mj_step(model, data, round(0.1 / step))
        drift = max(drift, abs(data.energy.sum() - begun))
    spent = process_time() - start
    angle = data.qpos[0]
    return float(np.abs(np.array((cos(angle), sin(angle))) - reduced(count)).max()), drift, spent


def by_robodyn(count: int, step: float) -> tuple[float, float, float]:
    model, scene = four_bars(count)
    run = partial(robodyn.simulate, model, scene, 10.0, step=step, executor="compiled")
    result, spent = run(), []
    for _ in range(3):
        start = process_time()
        run()
        spent.append(process_time() - start)
    angle = result.q[-1, 0]
    place = float(np.abs(np.array((cos(angle), sin(angle))) - reduced(count)).max())
    return place, result.energy_drift, min(spent)


def a02() -> str:
    rows = []
    for count in (2, 8, 40):
        call = 'robodyn.simulate(model, scene, 10.0, step=0.01, executor="compiled")'
        cold = f"{1e3 * first_call(f'model, scene = four_bars({count})', call):.3g}"
        for step, first in ((1e-2, cold), (2e-3, "as above")):
            place, drift, spent = by_robodyn(count, step)
            figures = (f"{place:.0e}", f"{drift:.0e}", f"{1e3 * spent:.3g}", first)
            rows.append((f"{count}", "robodyn, rk4", f"{1e3 * step:g} ms", *figures))
        for integrator in ("RK4", "implicitfast"):
            place, drift, spent = by_mujoco(count, 1e-3, integrator)
            figures = (f"{place:.0e}", f"{drift:.0e}", f"{1e3 * spent:.3g}", "-")
            rows.append((f"{count}", f"MuJoCo, {integrator}", "1 ms", *figures))
    head = ("A02: 10 s, N", "program", "step", "error of B0 [m]", "energy drift [J]", "time [ms]", "first call [ms]")
    return table(head, rows, left=(1,))


def report() -> str:
    return a01() + a02() + "\n" + machine("scipy", "mujoco", "pin", "llvmlite")


if __name__ == "__main__":
    main(report, __doc__)
