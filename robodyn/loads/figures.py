"""From gathered statistics to the figures that a motor-sizing engineer reads; loads that overflow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from robodyn.dynamics.effects.friction import friction_of
from robodyn.dynamics.plan import Plan, runner_of
from robodyn.errors import InputError
from robodyn.loads.result import ComponentLoad, EffectReport, JointLoad
from robodyn.loads.statistics import FOUNDATION, Statistics
from robodyn.robot.limits import binding
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import Floats

REMEDY = "are masses, lengths, times and the motion in SI units?"


def check_loads(loads: Floats, names: Sequence[str], first_row: int, file: str | None) -> None:
    """Raise if a load of some sample is not finite.

    Args:
        loads: (N, k), column by column of `names`; sample 0 is the data row `first_row`.

    Raises:
        InputError: naming the first row and its load.
    """
    if not np.isfinite(loads).all():
        row, column = np.argwhere(~np.isfinite(loads))[0]
        raise InputError(f"row {first_row + row}: {names[column]} overflows", remedy=REMEDY, file=file)


def check_figures(figures: Iterable[ArrayLike], peaks: ArrayLike, file: str | None) -> None:
    """Raise if a power, a square or an integral over the motion is not finite though the loads were."""
    if not all(np.isfinite(values).all() for values in figures):
        largest = float(np.abs(peaks).max(initial=0.0))
        what = f"the loads are finite, their squares or powers overflow; the largest is {largest:.3g}"
        raise InputError(what, remedy=REMEDY, file=file)


def joint_of_rates(model: Model) -> list[Joint]:
    """Return the joint that each entry of qd belongs to."""
    return [joint for joint in model.independent for _ in range(6 if joint.kind == "floating" else 1)]


def position_of_rates(model: Model) -> list[int]:
    """Return the entry of q that goes with each entry of qd; for a floating joint qx qy qz and x y z."""
    places: list[int] = []
    for joint in model.independent:
        at = joint.coordinate
        places += [at + k for k in (3, 4, 5, 0, 1, 2)] if joint.kind == "floating" else [at]
    return places


def joint_load(
    gathered: Statistics,
    k: int,
    joint: Joint,
    name: str,
    scene: Scene,
    shares: Mapping[str, float],
    uncertainty: tuple[float, float | None],
) -> JointLoad:
    """Return the figures of joint k.

    RMS `sqrt(integral tau^2 dt / T)`, cubic mean `cbrt(integral |qd tau^3| dt / integral |qd| dt)`, work
    `integral max(+-tau qd, 0) dt`. `uncertainty` is a standard deviation
    and an error bar. The torque of a motion of one sample is its mean and its RMS.
    """
    totals = gathered.integrals.totals
    mean, (torque, speed) = gathered.integrals.mean, (gathered.torque, gathered.speed)
    single = torque.kept["value"]
    travel = float(totals["travel"][k])
    friction = friction_of(joint, scene)
    held = shares.get("gravity", 0.0) + shares.get("joint spring", 0.0)
    return JointLoad(
        name=name,
        unit="N" if joint.kind == "prismatic" else "N m",
        peak=float(single[k]),
        peak_time=float(torque.time[k]),
        peak_row=int(torque.row[k]),
        peak_speed=float(torque.kept["speed"][k]),
        rms=float(np.sqrt(mean("square", single**2)[k])),
        mean=float(mean("torque", single)[k]),
        cubic_mean=float(totals["wear"][k] / travel) ** (1 / 3) if travel else 0.0,
        max_speed=float(speed.kept["value"][k]),
        max_speed_time=float(speed.time[k]),
        max_speed_row=int(speed.row[k]),
        torque_at_max_speed=float(speed.kept["torque"][k]),
        peak_power=float(gathered.power_most[k]),
        least_power=float(gathered.power_least[k]),
        work_positive=float(totals["positive"][k]),
        work_negative=float(totals["negative"][k]),
        hold=0.5 * (friction.forward - friction.backward) + friction.load * abs(held),
        effort_limit=binding(joint.effort),
        velocity_limit=binding(joint.velocity),
        seconds_over_effort=float(totals["over effort"][k]),
        seconds_over_velocity=float(totals["over velocity"][k]),
        lower=joint.lower,
        upper=joint.upper,
        q_min=float(gathered.q_min[k]),
        q_max=float(gathered.q_max[k]),
        uncertainty=uncertainty[0],
        error_bar=uncertainty[1],
        shares=dict(shares),
    )


def shares_at_peaks(plan: Plan, at_peak: Mapping[int, Mapping[str, Floats]], first_rate: int) -> list[dict[str, float]]:
    """For each joint what every active effect adds to its peak, each from the recursion with that effect alone.

    Accuracy: the shares of a joint add up to its peak within 1e-12 of the largest torque.
    """
    states = [at_peak[k] for k in range(len(at_peak))]
    shares: list[dict[str, float]] = [{} for _ in states]
    if states:
        sources = {name: np.stack([state[name] for state in states]) for name in states[0] if name != "off"}
        for effect in plan.effects:
            tau = runner_of(plan.share(effect), plan)(sources, len(states), executor="numpy")
            for k, share in enumerate(shares):
                share[effect.name] = float(tau[k, first_rate + k])
    return shares


def base_loads(gathered: Statistics) -> tuple[ComponentLoad, ...]:
    """Peak with sign, its time, and RMS of each component of the base wrench, and of Fxy and Mxy: foundation loads."""
    peaks = gathered.base.kept["value"]
    rms = np.sqrt(gathered.integrals.mean("base square", peaks**2))
    rows = zip(FOUNDATION, peaks, gathered.base.time, rms, strict=True)
    return tuple(ComponentLoad(name, float(peak), float(time), float(mean)) for name, peak, time, mean in rows)


def effect_reports(plan: Plan, explain: bool) -> tuple[EffectReport, ...]:
    """Return every effect with its verdict and its operations; with `explain`, what its absence would save."""
    total = plan.torques().size
    return tuple(
        EffectReport(
            effect.name,
            verdict,
            plan.share(effect).size if verdict.active else 0,
            (total - plan.without(effect).size if verdict.active else 0) if explain else None,
        )
        for effect, verdict in plan.verdicts
    )
