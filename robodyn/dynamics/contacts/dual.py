"""The least contact forces of whole blocks of samples, by Newton's method on the dual."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.contacts.problem import FEASIBLE
from robodyn.dynamics.contacts.program import runner
from robodyn.support.floats import Floats

SOFTNESS = (1e-2, 1e-4, 1e-6, 1e-7)
"""rho of the stages; the last one's is what weighs forces against a residual that nothing can balance."""
ROUNDING = 1e-14
"""Of |b|: a residual that is rounding."""
NOISE = 4e-15
"""Of |nu|: what rounding may leave of a gradient."""
NEAR = (0.1, 0.1, 0.1, 1e-9)
"""A stage ends where psi's gradient is this part of the residual."""
ENOUGH = 1e-4
"""The part of the decrease that a step promises that it must bring (Armijo)."""
SHORTEST = 1e-6
"""A step that must be shorter is lost in rounding."""
STEPS = 300


class Cones(NamedTuple):
    """G f = b of N samples with |b| = 1, f in cones about the z axes of K points.

    Attributes:
        G: (N, R, 3 K). b: (N, R). cosine, sine: (N, K), of the half angles atan(mu).
    """

    G: Floats
    b: Floats
    cosine: Floats
    sine: Floats

    def chosen(self, rows: Any) -> Cones:
        """Return those of some samples."""
        return Cones(*(columns(part[rows]) for part in self))


def columns(values: Floats) -> Floats:
    """Return the same values (N, ...), N innermost in memory."""
    return np.moveaxis(np.ascontiguousarray(np.moveaxis(values, 0, -1)), -1, 0)


def least_forces(cones: Cones, executor: str = "auto", expected: int = 0) -> Floats:
    """Return f (N, K, 3) in the cones with G f = b and the least 1/2 |f|^2.

    Where there is none, 1/2 |f|^2 + 1/2 |b - G f|^2 / rho is least, rho = 1e-7.

    Method: f = P(G^T nu), P being the projection onto the cones, where nu is the least of the convex
    psi(nu) = 1/2 |P(G^T nu)|^2 - b . nu + 1/2 rho |nu - c|^2, whose gradient is piecewise smooth: semismooth Newton
    steps, backtracking where psi does not fall. First c = 0, and rho falls from 1e-2 to 1e-7; then c follows nu (the
    proximal point algorithm, Rockafellar 1976), which takes the residual rho (nu - c) to rounding where forces exist.

    Args:
        executor, expected: as for `contact_forces`.
    """
    N, R, width = cones.G.shape

    def run(kind: str, part: Cones, **given: Floats) -> Floats:
        count = len(part.b)
        sources = {"G": np.moveaxis(part.G, 0, -1).reshape(R * width, count).T, **given}
        sources |= {"b": part.b, "cosine": part.cosine, "sine": part.sine}
        return runner(kind, R, width // 3)(sources, count, executor=executor, expected=STEPS * (expected or N) // 20)

    nu = run("start", cones, rho=np.full((N, 1), 1e-12))
    nu = _least(cones, nu, run)
    return run("forces", cones, nu=nu).reshape(N, width // 3, 3)


class _State(NamedTuple):
    """Of each sample that is not done, and its place among all."""

    sample: Any
    at: Floats
    step: Floats
    length: Floats
    value: Floats
    slope: Floats
    centre: Floats
    stage: Any
    residual: Floats
    gradient: Floats
    best: Floats
    soft: Floats

    @property
    def rho(self) -> Floats:
        rho: Floats = np.asarray(SOFTNESS)[np.clip(self.stage, 0, len(SOFTNESS) - 1)]
        return rho

    def chosen(self, rows: Any) -> _State:
        return _State(*(columns(part[rows]) for part in self))


def _least(cones: Cones, nu: Floats, run: Callable[..., Floats]) -> Floats:
    """Return the least nu of all samples; a sample begins with the last stage, and with the first if that fails."""
    found, state, part = np.array(nu), _begun(nu), cones
    for _ in range(STEPS):
        trial = state.at + state.length[:, None] * state.step
        out = run("step", part, nu=trial, centre=state.centre, rho=state.rho[:, None])
        state, done = _next_stage(_searched(state, trial, out))
        if done.any():
            lost = state.residual > FEASIBLE
            found[state.sample[done]] = np.where(lost[:, None], state.soft, state.at)[done]
            if done.all():
                return found
            state, part = state.chosen(~done), part.chosen(~done)
    found[state.sample] = np.where((state.stage >= len(SOFTNESS))[:, None], state.soft, state.at)
    return found


def _begun(nu: Floats) -> _State:
    N = len(nu)
    zero, infinite = np.zeros(N), np.full(N, np.inf)
    stage = np.full(N, -1)
    return _State(
        np.arange(N), nu, np.zeros_like(nu), zero, infinite, zero, nu, stage, infinite, infinite, infinite, nu
    )


def _searched(state: _State, trial: Floats, out: Floats) -> _State:
    """Return the state at the trials that are good enough; where they are not, with shorter steps."""
    R = trial.shape[1]
    value, down, ahead = out[:, 0], out[:, 1 : 1 + R], out[:, 1 + R :]
    promised = state.slope * state.length
    gradient = np.sqrt(_dot(down, down))
    good = (value <= state.value - ENOUGH * promised) | (gradient <= 0.5 * state.gradient)
    with np.errstate(all="ignore"):
        bent = promised * state.length / (2.0 * (value - state.value + promised))
        shorter = np.clip(np.nan_to_num(bent, nan=0.0), 0.1 * state.length, 0.5 * state.length)
    rest = down + state.rho[:, None] * (trial - state.centre)
    return state._replace(
        at=np.where(good[:, None], trial, state.at),
        step=np.where(good[:, None], ahead, state.step),
        length=np.where(good, 1.0, shorter),
        value=np.where(good, value, state.value),
        slope=np.where(good, _dot(down, ahead), state.slope),
        residual=np.where(good, np.sqrt(_dot(rest, rest)), state.residual),
        gradient=np.where(good, gradient, state.gradient),
    )


def _next_stage(state: _State) -> tuple[_State, Any]:
    """Return the state with the samples whose stage has ended in the next one, and which are done."""
    last = len(SOFTNESS) - 1
    near = np.asarray(NEAR)[np.clip(state.stage, 0, last)] * state.residual
    near = np.maximum(np.maximum(near, ROUNDING), NOISE * np.sqrt(_dot(state.at, state.at)))
    ended = (state.length == 1.0) & (state.gradient <= near)
    ended |= state.length < SHORTEST
    done = ended & (state.residual <= ROUNDING) | ended & (state.stage > last) & (state.residual > 0.5 * state.best)
    ended |= (state.stage < 0) & (state.length == 1.0)
    follows = ended & (state.stage >= last)
    centre = np.where(ended[:, None], np.where(follows[:, None], state.at, 0.0), state.centre)
    soft = np.where((ended & (state.stage == last))[:, None], state.at, state.soft)
    state = state._replace(
        stage=state.stage + ended,
        centre=centre,
        soft=soft,
        best=np.where(follows, state.residual, state.best),
        value=np.where(ended, np.inf, state.value),
        length=np.where(ended, 0.0, state.length),
    )
    return state, done


def _dot(x: Floats, y: Floats) -> Floats:
    found: Floats = np.einsum("ni,ni->n", x, y)
    return found
