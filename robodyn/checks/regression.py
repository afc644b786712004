"""How the dynamics of a robot differ from those of another version of its file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import DescriptionError, InputError
from robodyn.programs.vectors import length
from robodyn.robot.load import load
from robodyn.robot.model import Model
from robodyn.support.floats import first_largest

SAME = 1e-9
"""Relative differences that are no more are rounding."""
_PLAIN = ("-c", "safe.bareRepository=explicit", "-c", "core.fsmonitor=false")
"""No settings that name programs are taken from a repository that lies among the files of another."""
_STATES = 32
_SEED = 20_26


class Change(NamedTuple):
    """One difference: of a `joint`, a `link` or the `robot`, its name, what is different, and how much."""

    kind: str
    name: str
    what: str
    size: float


def _no_version(name: str, ref: str, said: str) -> InputError:
    if "not a git repository" in said:
        return InputError(f"{name} is in no git repository, which has its versions", remedy="leave --against out")
    if os.path.exists(ref):
        what = f"--against takes a revision of git, and {ref!r} is a file"
        return InputError(what, remedy=f"give one such as HEAD~1 or main, with which {name} itself is compared")
    if "invalid object name" in said or "bad revision" in said:
        what, remedy = f"git has no revision {ref!r}", "give one such as HEAD~1 or main: git log lists them"
    else:
        what, remedy = f"there is no {name} at the revision {ref!r}", "give one that has it: git log FILE lists them"
    return InputError(what, remedy=remedy)


def model_at(file: str, ref: str) -> Model | None:
    """Return the robot of a file at a git revision; None where the description there cannot be read.

    Raises:
        InputError: git is not there, or knows no such revision or file.
    """
    folder, name = os.path.split(os.path.abspath(file))
    if not ref or ref.startswith("-"):
        raise _no_version(name, ref, "invalid object name")
    from robodyn.support.children import run_program

    call = ("git", *_PLAIN, "show", f"{ref}:./{name}")
    try:
        run = run_program(*call, folder=folder, GIT_NO_LAZY_FETCH="1", LC_ALL="C")
    except OSError as error:
        raise InputError(f"git cannot be run: {error}", remedy="install git, or leave --against out") from None
    if run.returncode:
        raise _no_version(name, ref, run.stderr.decode(errors="replace"))
    try:
        return load(run.stdout)
    except DescriptionError:
        return None


def changes(before: Model, after: Model) -> Iterator[Change]:
    """Yield what differs in joints, in masses, centres and tensors of links with everything fixed to them, and in the
    torques: of inverse dynamics in 32 random states, the same in every run, of the coordinates that both have, the
    others being at rest, the largest difference in a state over the largest torque there."""
    yield from (change for change in (*_joints(before, after), *_bodies(before, after)) if change.size > SAME)
    common = [name for name in after.rates if name in before.rates]
    if not common or any(joint.kind == "floating" for joint in (*before.independent, *after.independent)):
        return
    rng = np.random.default_rng(_SEED)
    states = [rng.uniform(-2.0, 2.0, (_STATES, len(common))) for _ in range(3)]
    tau = []
    for model in (before, after):
        places = [model.rates.index(name) for name in common]
        given = np.zeros((3, _STATES, model.n))
        given[:, :, places] = states
        tau.append(inverse_dynamics(model, *given, executor="numpy")[:, places])
    difference, largest = np.abs(tau[1] - tau[0]).max(axis=1), np.abs(tau).max(axis=(0, 2))
    relative = difference / np.where(largest > 0.0, largest, 1.0)
    worst = first_largest(relative)
    if (apart := float(relative[worst])) > SAME:
        what = f"torques differ by up to {100 * apart:.3g} % in random states ({difference[worst]:.3g} N m or N)"
        yield Change("robot", after.name, what, apart)


def _joints(before: Model, after: Model) -> Iterator[Change]:
    old, new = (
        {body.joint.name: body.joint for body in model.bodies if body.joint.kind != "fixed"}
        for model in (before, after)
    )
    yield from (Change("robot", after.name, f"joint {name!r} is gone", np.inf) for name in old if name not in new)
    for name, joint in new.items():
        if name not in old:
            yield Change("joint", name, "the joint is new", np.inf)
            continue
        for what in ("kind", "axis", "lower", "upper", "effort", "velocity", "damping", "friction"):
            was, now = (getattr(each, what) for each in (old[name], joint))
            if what == "axis":
                was, now = tuple(was.tolist()), tuple(now.tolist())
            if was != now:
                words = [f"{value:g}" if isinstance(value, float) else str(value) for value in (was, now)]
                word = "type" if what == "kind" else what
                yield Change("joint", name, f"{word} {words[0]} has become {words[1]}", np.inf)
        moved = max(float(np.abs(old[name].R - joint.R).max()), float(np.abs(old[name].p - joint.p).max()))
        yield Change("joint", name, f"its place has moved by {moved:.3g} (m, or in the rotation)", moved)
    if [name for name in before.joint_names if name in new] != [name for name in after.joint_names if name in old]:
        yield Change("robot", after.name, "the joints are in another order", np.inf)


def _bodies(before: Model, after: Model) -> Iterator[Change]:
    old = {body.name: body.inertia for body in before.bodies}
    for body in after.bodies:
        if body.name not in old:
            continue
        was, now = old[body.name], body.inertia
        mass = abs(now.m - was.m) / max(abs(now.m), abs(was.m), 1e-300)
        yield Change("link", body.name, f"mass {was.m:.6g} kg has become {now.m:.6g} kg", mass)
        centre = length(now.centre_of_mass - was.centre_of_mass)
        yield Change("link", body.name, f"the centre of mass has moved by {centre:.3g} m", centre)
        size = max(float(np.abs(now.I).max()), float(np.abs(was.I).max()), 1e-300)
        tensor = float(np.abs(now.I - was.I).max()) / size
        yield Change("link", body.name, f"the inertia about its origin has changed by {100 * tensor:.3g} %", tensor)
