"""The state at rest nearest to one that is given, and how well the stiffness is known there."""

from __future__ import annotations

import numpy as np

from robodyn.equations.linearized.static_balance import Balance, Standing
from robodyn.errors import InputError
from robodyn.programs.linear import eigen, min_norm_solution, range_basis
from robodyn.programs.vectors import length, product
from robodyn.support.floats import Floats, first_largest

_STEPS, _HALVINGS = 60, 12
_NEAR, _NEARLY = 1e-12, 1e-10
"""Parts of the torques that balance: from where on one step is the last, and what is enough."""
_DEPENDENT = 1e-10
"""Directions in which the torques change by less than this part of the most are left alone: nothing holds there."""
_AROUND = 0.5
"""rad, or the same part of the robot's reach [m]: what Newton's method finds farther away is not near."""
_SINKS, _LONGEST = 400, 0.3
"""Steps downhill at most, and how long each may be, as `_AROUND`."""
_FAR = 4.0 * np.pi
"""As `_AROUND`: what has gone two turns downhill goes on for ever."""
_HOLD = "give the joint a drive with kp or a spring, or begin elsewhere (--at)"
_SUNK = 1e-5
"""A part of the torques that balance, from which Newton's method ends it."""


def equilibrium_near(robot: Standing, q: Floats) -> Floats:
    """Return q (nq,) at which the robot stays at rest.

    Method: Newton's, the shortest step that makes the linear torques vanish, halved until it helps, which finds what is
    near, stable or not. Where there is nothing near, the robot sinks, as if through something viscous, to a state that
    is stable: Newton's steps with the absolute values of the stiffness' eigenvalues, which lead downhill past saddles
    (Dauphin et al., "Identifying and attacking the saddle point problem", 2014). Newton's method ends it.

    Raises:
        InputError: there is none, or none was found; the joint that is farthest from balance is named.

    Accuracy: what is left of the torques is at most 1e-10 of those that balance, most often 1e-12.
    """
    _check_exists(robot, q)
    found, here = _by_newton(robot, q, _AROUND)
    if here.part > _NEARLY:
        found, here = _by_newton(robot, _sunk(robot, q), _LONGEST)
    if here.part <= _NEARLY:
        return _as_begun(robot, q, found, here)
    raise InputError(f"no equilibrium is found: {_most(robot, here)} stay unbalanced", remedy=_HOLD)


def _check_exists(robot: Standing, q: Floats) -> None:
    """Raise if a torque is missing that does not change with the configuration, here and elsewhere: nothing balances
    the weight of a free base, or of a slide that is not held."""
    elsewhere = None if robot.chain else robot.moved(q, 0.1 + 0.618 * np.arange(1.0, robot.model.n + 1.0) % 1.0)
    if elsewhere is None:
        return
    here, there = robot.balance(q), robot.balance(elsewhere)
    nothing = _NEAR * np.minimum(here.scale, there.scale)
    changes = (np.maximum(np.abs(here.stiffness), np.abs(there.stiffness)) * robot.lengths).max(axis=1)
    constant = (changes <= nothing) & (np.abs(here.missing - there.missing) <= nothing) & (here.parts > _NEARLY)
    if constant.any():
        left = here._replace(missing=np.where(constant, here.missing, 0.0))
        what = f"there is no equilibrium: {_most(robot, left)} stay unbalanced at every configuration"
        floats = robot.model.floating and constant[:6].any()
        raise InputError(
            what, remedy="a free base falls: bolt it down, or leave out --equilibrium" if floats else _HOLD
        )


def _most(robot: Standing, here: Balance) -> str:
    k = first_largest(here.parts)
    return f"{abs(here.missing[k]):.3g} {robot.units[k]} at {robot.model.rates[k]}"


def _as_begun(robot: Standing, q: Floats, found: Floats, here: Balance) -> Floats:
    """Return what was found, with coordinates that rounding alone has moved where they were, or at 0, if as good."""
    plain = np.where(np.abs(found - q) <= _NEAR, q, np.where(np.abs(found) <= _NEAR, 0.0, found))
    return plain if robot.balance(plain).part <= max(here.part, _NEAR) else found


def _by_newton(robot: Standing, q: Floats, around: float) -> tuple[Floats, Balance]:
    """Return where it ends, within this distance, and what is not balanced there."""
    here, gone = robot.balance(q), np.zeros(robot.model.n)
    for _ in range(_STEPS):
        last, step = here.part <= _NEAR, newton_step(robot, here)
        better = _first_that_helps(robot, q, here, step, around * robot.lengths, gone)
        if better is None:
            break
        q, here, gone = better
        if last:
            break
    return q, here


def newton_step(robot: Standing, here: Balance) -> Floats:
    """Return the shortest step (n,) after which nothing would be missing if torques were linear."""
    N = _scaled(robot, here)
    return np.asarray(
        product(N, min_norm_solution(product(N.T, here.stiffness, N), -product(N.T, here.missing), _DEPENDENT))
    )


def _scaled(robot: Standing, here: Balance) -> Floats:
    """Return the directions in coordinates in which all joints are about as stiff, however small what they carry."""
    stiff = here.scale / robot.lengths
    stiff = np.where(stiff > 0.0, stiff, 1.0)
    root = np.sqrt(stiff)[:, None]
    return here.directions / root if robot.chain is None else range_basis((here.directions * root).T, 0.0).T / root


def _first_that_helps(
    robot: Standing, q: Floats, here: Balance, step: Floats, within: Floats, gone: Floats
) -> tuple[Floats, Balance, Floats] | None:
    """Return q, what is missing and how far it is after the step, halved until less is missing."""
    scale = np.where(here.scale > 0.0, here.scale, 1.0)
    for halving in range(_HALVINGS):
        part = step * 0.5**halving
        if (np.abs(gone + part) <= within).all() and (tried := robot.moved(q, part)) is not None:
            there = robot.balance(tried)
            if length(there.missing / scale) < length(here.missing / scale):
                return tried, there, gone + part
    return None


def _sunk(robot: Standing, q: Floats) -> Floats:
    """Return q after steps downhill, each accepted if the torques do work along it."""
    here, longest, gone = robot.balance(q), _LONGEST, np.zeros(robot.model.n)
    for _ in range(_SINKS):
        if here.part <= _SUNK or (np.abs(gone) > _FAR * robot.lengths).any():
            break
        step = _downhill(robot, here, longest)
        tried = robot.moved(q, step)
        there = None if tried is None else robot.balance(tried)
        if tried is None or there is None or product(here.missing + there.missing, step) >= 0.0:
            longest *= 0.25
            continue
        q, here, longest, gone = tried, there, min(2.0 * longest, _LONGEST), gone + step
    return q


def _downhill(robot: Standing, here: Balance, longest: float) -> Floats:
    """Return the step (n,) that ends along each principal direction of the stiffness where its torque would vanish."""
    N = _scaled(robot, here)
    S = product(N.T, here.stiffness, N)
    values, V = eigen(0.5 * (S + S.T))
    D = product(N, V.T)
    torque, far = product(D.T, here.missing), np.abs(D / robot.lengths[:, None]).max(axis=0)
    felt = np.abs(torque) > _NEAR * product(np.abs(D).T, here.scale)
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.where(felt, np.clip(-torque / np.abs(values), -longest / far, longest / far), 0.0)
    return np.asarray(product(D, along))


_NEWTON_STEPS = 4.0
"""Of Newton's, to be on the far side of an equilibrium: where two meet, at a fold, each of his goes half the way."""
_ROUNDED = 4.0 * float(np.finfo(float).eps)
_LONGEST_STEP = 0.1
"""rad, or the same part of the robot's reach [m]."""


def along(stiffness: Floats, directions: Floats, own: list[int]) -> Floats:
    """Return the stiffness (k, k) of the coordinates `own` of motions in these directions (n, k)."""
    N = np.linalg.solve(directions[own].T, directions.T).T
    return np.asarray(product(N.T, stiffness, N))


def stiffness_in_doubt(robot: Standing, q: Floats, here: Balance, own: list[int]) -> Floats:
    """Return how the stiffness (k, k) changes on the way to where the equilibrium may be, which is off by what is
    missing and by rounding: next to nothing, but near a fold, where a stable equilibrium meets an unstable one."""
    missing = np.where(np.abs(here.missing) < _ROUNDED * here.scale, _ROUNDED * here.scale, here.missing)
    step = _NEWTON_STEPS * newton_step(robot, here._replace(missing=missing))
    step /= max(1.0, float(np.abs(step / robot.lengths).max(initial=0.0)) / _LONGEST_STEP)
    if (there := robot.moved(q, step)) is None:
        return np.zeros((len(own), len(own)))
    other = robot.balance(there)
    return along(other.stiffness, other.directions, own) - along(here.stiffness, here.directions, own)
