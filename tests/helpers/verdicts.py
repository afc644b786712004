"""What a robot that was identified on a bench is said to bear on another motion: bars, probabilities of verdicts."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import patch

import numpy as np

import robodyn
from robodyn.dynamics.regressor import INERTIAL
from robodyn.identification.result import carriers
from robodyn.loads import uncertain_report as uncertain_figures
from robodyn.loads.uncertain_report import Figures
from robodyn.loads.uncertainty import UncertaintyPass
from robodyn.scene.scene import Friction, Motor, Rotor, Scene
from robodyn.scene.uncertainty import Covariance, Uncertainty
from robodyn.solids.inertia.laws import Inertia, symmetric
from robodyn.trajectory.motion import Trajectory


class Verdicts:
    """A robot of a `Bench` on a motion: figures are each joint's peak, then each joint's RMS [N m].

    Attributes:
        true: (2 n,) figures of the robot as it is.
    """

    def __init__(self, bench, motion, samples=100, span=2.0):
        self.bench, self.n = bench, bench.model.n
        self.time = np.linspace(0.0, span, samples)
        self.states = motion(bench.rng, self.time, self.n)
        self.scene = Scene(friction=dict.fromkeys(bench.model.rates, Friction(0.1, 0.1, -0.1)))
        found = robodyn.regressor(bench.model, *self.states, scene=self.scene)
        self.Y, self.names = found.Y, found.names
        self.carried = carriers(bench.base, self.names)
        self.theta = self._described(found.theta)
        self.true = self.figures(bench.beta)

    def _described(self, theta):
        """Return the truth, as `robodyn.regressor` names it."""
        truth = dict(zip(self.bench.structure.names, self.bench.theta.tolist(), strict=True))
        for name in self.bench.model.rates:
            dry, offset = truth[f"{name}.coulomb"], truth[f"{name}.offset"]
            truth |= {f"{name}.forward": offset + dry, f"{name}.backward": offset - dry}
        return np.array([truth.get(name, value) for name, value in zip(self.names, theta.tolist(), strict=True)])

    def parameters(self, values):
        """Return parameters that have these base parameters."""
        return self.theta + self.carried @ (values - self.bench.beta)

    def figures(self, values):
        """Return (2 n,) of base parameters."""
        tau = self.Y @ self.parameters(values)
        return np.concatenate(
            [np.abs(tau).max(axis=0), np.sqrt(np.trapezoid(tau**2, self.time, axis=0) / self.time[-1])]
        )

    def known(self, values, C):
        """Return the covariance file's content."""
        own = np.flatnonzero(self.carried.any(axis=1))
        part = self.carried[own]
        names = tuple(self.names[k] for k in own)
        return Covariance(names, self.parameters(values)[own], part @ C @ part.T)

    def public(self, values, C, limits):
        """Return the limits of `robodyn.torques`, each with a bar, for motors with these: of peaks, then of RMS."""
        theta = self.parameters(values)
        of = dict(zip(self.names, theta.tolist(), strict=True))
        rates, kinds = self.bench.model.rates, ("viscous", "forward", "backward")
        pairs = zip(rates, limits[: self.n].tolist(), limits[self.n :].tolist(), strict=True)
        scene = Scene(
            friction={name: Friction(*(of[f"{name}.{kind}"] for kind in kinds)) for name in rates},
            rotor={name: Rotor(of[f"{name}.rotor"], 1.0) for name in rates},
            motor={name: Motor(continuous=low, peak=high) for name, high, low in pairs},
            uncertainty=Uncertainty(covariance=self.known(values, C)),
        )
        model = with_bodies(self.bench.model, self.names, theta)
        found = robodyn.torques(model, robodyn.motion(model, self.time, *self.states), scene).uncertainty.joints
        told = [{limit.quantity: limit for limit in joint.limits} for joint in found]
        return [each[kind] for kind in ("motor torque", "RMS motor torque") for each in told]

    def direct(self, values, C, limits):
        """Return (2 n) bars and probabilities as `public` does, of loads and derivatives by the regressor."""
        scene = replace(self.scene, uncertainty=Uncertainty(covariance=self.known(values, C)))
        gathered = UncertaintyPass(self.bench.model, scene, slice(0, self.n), [], False, "numpy")
        at = {name: k for k, name in enumerate(self.names)}
        changes = [self.Y[:, :, at[each.name]] * each.deviation for each in gathered.found.each]
        loads = np.pad(self.Y @ self.parameters(values), ((0, 0), (0, 6)))
        gathered._runners[frozenset()] = _Known(np.pad(np.stack(changes, axis=2), ((0, 0), (0, 6), (0, 0))))
        gathered.take(Trajectory(self.time, *self.states), {}, loads, frozenset(), 1)
        figures = Figures(gathered)
        found = [figures.peak(k) for k in range(self.n)] + [figures.rms(k) for k in range(self.n)]
        pairs = zip(found, limits.tolist(), strict=True)
        return [each.bar() for each in found], np.array([each.within(limit) for each, limit in pairs])

    def judged(self, logs, spread=4.0):
        """Return whether bars hold the truth, stated probabilities and verdicts of the truth, each (logs, 2 n).

        Limits are up to `spread` standard errors off the true figure, whatever the log is. There are 1000 draws.
        """
        errors = np.std([self.figures(values) for values, _ in logs], axis=0)
        off = self.bench.rng.uniform(-spread, spread, (len(logs), 2 * self.n))
        with patch.object(uncertain_figures, "DRAWS", 1000):
            found = [self.direct(*log, self.true + z * errors) for log, z in zip(logs, off, strict=True)]
        held = [[holds(bar, true) for bar, true in zip(bars, self.true, strict=True)] for bars, _ in found]
        return np.array(held), np.stack([stated for _, stated in found]), off > 0.0


def holds(bar, size):
    """Return whether an error bar holds a magnitude."""
    return bar.low <= np.copysign(size, bar.value) <= bar.high


def with_bodies(model, names, theta):
    """Return a model with the bodies of parameters, as `robodyn.regressor` names them."""
    of, bodies = dict(zip(names, theta.tolist(), strict=True)), []
    for body in model.bodies:
        m, x, y, z, *moments = (of[f"{body.name}.{kind}"] for kind in INERTIAL)
        bodies.append(replace(body, inertia=Inertia(m, np.array([x, y, z]), symmetric(moments))))
    return replace(model, bodies=tuple(bodies))


class _Known:
    """Stands for the runner of derivatives (k, n + 6, m), which are known."""

    def __init__(self, values):
        self.values = values.reshape(len(values), -1)
        self.program = self
        self.outputs = range(self.values.shape[1])

    def run(self, given, count, **_):
        return self
