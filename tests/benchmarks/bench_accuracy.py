"""Errors of torques, wrenches and derivatives: `cd tests && python -m benchmarks.bench_accuracy`.

An error is the largest difference of a case over the largest expected number of that case.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from statistics import median

import mpmath
import numpy as np
from benchmarks.derivative_errors import derivatives_table
from helpers.example_robots import PATHS
from helpers.markdown_tables import main, table
from helpers.oracles import frictionless, golden_model, random_state, reference, run, worst
from helpers.pinocchio_robots import PinocchioRobot
from helpers.robot_catalogue import runs
from helpers.small_robots import chain

import robodyn
from robodyn.dynamics.effects.effect import Sample
from robodyn.dynamics.plan import EFFECTS, Plan, applied, loads

STATES = 4
HEAD = ("quantity", "compared with", "cases", "median error", "largest error")


def golden_errors() -> Iterator[tuple[float, float, float]]:
    """Errors of torques, joint wrenches and mass matrix of every golden case."""
    for name, numbers in reference("golden_inverse_dynamics")["models"].items():
        model = golden_model(name)
        for case in numbers["cases"]:
            scene = robodyn.Scene(gravity=tuple(case["gravity"]))
            plan, state = Plan(model, scene), [case[key] for key in ("q", "qd", "qdd")]
            found = run(plan.wrenches(joints=True), plan, *state)[0]
            of_joint = case["joint_wrench_on_child_at_joint_origin_in_link_frame"]
            expected = dict(zip(numbers["joint_names"], of_joint, strict=True))
            wrenches = np.array([[expected[body.joint.name][part] for part in "fn"] for body in model.bodies[1:]])
            tau_scale = np.abs(case["tau"]).max() or np.abs(wrenches[:, 1]).max()
            yield (
                worst(found[: model.n], case["tau"], tau_scale),
                worst(found[model.n :].reshape(-1, 2, 3)[1:], wrenches, np.abs(wrenches).max()),
                worst(robodyn.mass_matrix(model, case["q"]), case["M"]),
            )


def pinocchio_errors(moving_base: bool) -> Iterator[float]:
    """The largest error of each real robot's torques at random states."""
    for path in PATHS:
        model = robodyn.load(path, moving_base=moving_base)
        state = random_state(model, np.random.default_rng(0), STATES)
        expected = PinocchioRobot(path, free=moving_base).torques(model, *state)
        yield worst(robodyn.inverse_dynamics(model, *state, scene=frictionless(model)), expected)


def chain_errors(links: int = 100) -> Iterator[float]:
    """Errors of the torques of planar and of twisted chains at random states, against the recursion with 50 digits."""
    for skew in (False, True):
        model, scene = chain(links, skew), robodyn.Scene()
        states = random_state(model, np.random.default_rng(0), STATES)
        for state in zip(*states, strict=True):
            with mpmath.workdps(50):
                sample = Sample(model, *(tuple(map(mpmath.mpf, part)) for part in state))
                expected = [float(x) for x in loads(sample, applied(EFFECTS, sample, scene)).tau]
            yield worst(robodyn.inverse_dynamics(model, *state), expected)


def share_errors() -> Iterator[float]:
    """How far the shares of the effects are from adding up to each peak, of the largest peak."""
    for _, result in runs():
        largest = max((abs(joint.peak) for joint in result.joints), default=0.0)
        off = [abs(sum(joint.shares.values()) - joint.peak) for joint in result.joints]
        yield max(off, default=0.0) / (largest or 1.0)


def row(quantity: str, against: str, errors: Iterable[float]) -> tuple[str, ...]:
    found = list(errors)
    return quantity, against, str(len(found)), f"{median(found):.0e}", f"{max(found):.0e}"


def accuracy_table() -> str:
    tau, wrenches, M = zip(*golden_errors(), strict=True)
    digits, momentum = "50-digit reference", "momentum recursion, every motion of robots/"
    checks = [result.checks for _, result in runs()]
    rows = [
        row("torques", digits, tau),
        row("wrenches at the joints", digits, wrenches),
        row("mass matrix", digits, M),
        row("torques, chains of 100 links", "the same recursion with 50 digits", chain_errors()),
        *(
            row(f"torques, {'free' if moving else 'fixed'} base", "Pinocchio, robots of example-robot-data", errors)
            for moving, errors in ((moving, pinocchio_errors(moving)) for moving in (False, True))
        ),
        row("base force (Euler's first law)", momentum, [check.first_law for check in checks]),
        row("base moment (Euler's second law)", momentum, [check.second_law for check in checks]),
        row("power", momentum, [check.power for check in checks]),
        row("sum of the effects' shares", "peak torques, every motion of robots/", share_errors()),
    ]
    return table(HEAD, rows, left=(0, 1))


def report() -> str:
    return accuracy_table() + "\n" + derivatives_table()


if __name__ == "__main__":
    main(report, __doc__)
