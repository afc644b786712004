"""The equations of motion at one configuration, in ODE form: M(q) qdd + bias = tau, the bias split by effect."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from robodyn.dynamics.arrays import zero_columns
from robodyn.dynamics.inverse import bias_forces, mass_matrix
from robodyn.dynamics.plan import Plan, plan, runner_of
from robodyn.errors import InputError
from robodyn.robot.kinematics import Values, beyond_limits, configuration, rates
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves, refuse_constraints, refuse_load, refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.linear import eigen
from robodyn.support.wording import listed


def check_equations(model: Model, scene: Scene) -> None:
    """Raise InputError where nothing can move or wrenches name columns, which only a trajectory has; SceneError where
    the scene has contacts."""
    refuse_others(model, scene)
    refuse_constraints(scene, loops=True)
    refuse_load(scene)
    check_moves(model)
    if scene.columns:
        raise InputError(
            f"the scene's wrenches name columns of a trajectory: {listed(scene.columns)}",
            remedy="give them as numbers; equations have no trajectory",
        )


def bias_plan(model: Model, scene: Scene) -> Plan:
    return replace(plan(model, scene), zero_columns=frozenset(("qdd", i) for i in range(model.n)))


def identifier(name: str, otherwise: str) -> str:
    """The letters and digits of a name, with single underscores for all else; `otherwise` in front of a digit."""
    words = [word for word in re.split(r"[^A-Za-z0-9]+", name) if word]
    text = "_".join(words) or otherwise
    return text if text[0].isalpha() else f"{otherwise}_{text}"


def identifiers(names: Iterable[str], otherwise: str) -> tuple[str, ...]:
    """Return an identifier for each name; those that would be alike, but for capitals, are numbered."""
    out: list[str] = []
    taken: set[str] = set()
    for name in names:
        first = text = identifier(name, otherwise)
        number = 1
        while text.lower() in taken:
            number += 1
            text = f"{first}_{number}"
        taken.add(text.lower())
        out.append(text)
    return tuple(out)


@dataclass(frozen=True, eq=False)
class Ode:
    """M(q) qdd + bias(q, qd) = tau in numbers.

    Attributes:
        coordinates, rates: names of the entries of q, and of qd, qdd, tau and every array below.
        units: of the entries of tau, N m or N.
        M: (n, n) kg m^2, kg m or kg.
        shares: of the bias, by effect [N m or N]; they add up to it.
        cond: condition number of M in SI units; infinite if M is singular.
        warnings: coordinates beyond their limits, and what the description leaves to be guessed.
    """

    robot: str
    gravity: tuple[float, float, float]
    coordinates: tuple[str, ...]
    rates: tuple[str, ...]
    units: tuple[str, ...]
    q: Floats
    qd: Floats
    M: Floats
    shares: Mapping[str, Floats]
    bias: Floats
    cond: float
    warnings: tuple[str, ...]


def ode(model: Model, scene: Scene = DEFAULT, at: Values = (), qd: Values = ()) -> Ode:
    """Return the equations of motion at a configuration.

    Each share of the bias comes from a program of its own, never from a difference.

    Args:
        at: coordinates in order or by name, the rest zero; a base that moves stands at the ground's origin, upright.
        qd: likewise of the rates; a base that moves is at rest.

    Raises:
        InputError: there are no equations, `at` or `qd` names no joint, or a result is not finite.

    Accuracy: M and bias as `mass_matrix` and `bias_forces`; the shares add up to the bias within 1e-12 of the largest.
    """
    check_equations(model, scene)
    q, speeds = configuration(model, at), rates(model, qd)
    with np.errstate(all="ignore"):
        M = mass_matrix(model, q, scene=scene, executor="numpy")
        bias = bias_forces(model, q, speeds, scene=scene, executor="numpy")
        sources = {"q": q[None], "qd": speeds[None], "qdd": np.zeros((1, model.n)), "columns": np.empty((1, 0))}
        resting = zero_columns({name: sources[name] for name in ("qd", "qdd")})
        at_rest = replace(bias_plan(model, scene), zero_columns=resting)
        shares = {
            effect.name: runner_of(at_rest.share(effect), at_rest)(sources, 1, executor="numpy")[0]
            for effect in at_rest.effects
            if effect.name != "mimic"
        }
        if not np.isfinite([*M, bias, *shares.values()]).all():
            raise InputError("the equations overflow at this configuration", remedy="smaller numbers", file=model.file)
        moments = np.abs(eigen(M)[0])
    least, most = float(moments.min()), float(moments.max())
    return Ode(
        robot=model.name,
        gravity=scene.gravity,
        coordinates=model.coordinates,
        rates=model.rates,
        units=units_of(model),
        q=q,
        qd=speeds,
        M=M,
        shares=shares,
        bias=bias,
        cond=most / least if least > model.n * np.finfo(float).eps * most else float("inf"),
        warnings=(*beyond_limits(model, q), *model.notes),
    )


def units_of(model: Model) -> tuple[str, ...]:
    units = ["N m"] * model.n
    for joint in model.independent:
        if joint.kind == "prismatic":
            units[joint.rate] = "N"
        elif joint.kind == "floating":
            units[joint.rate + 3 : joint.rate + 6] = ["N"] * 3
    return tuple(units)
