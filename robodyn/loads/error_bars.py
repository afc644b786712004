"""Why loads may be off: too few samples, energy that does not balance, a base that nothing holds; and by how much."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import hypot
from typing import TYPE_CHECKING

import numpy as np

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.errors import TOO_FEW, Caveat
from robodyn.loads.result import Checks, ComponentLoad, EnergyBalance, JointLoad, Sizing
from robodyn.programs.vectors import length
from robodyn.robot.base_guess import untouched
from robodyn.robot.model import Model
from robodyn.scene.scene import Scene
from robodyn.support.floats import BEYOND, Floats, steady
from robodyn.support.wording import count, figure, shown
from robodyn.trajectory.motion import FEW, NOISE, Trajectory

if TYPE_CHECKING:
    from robodyn.loads.constraints import ConstraintPass

OPEN = 0.5
"""Of the rms of derived accelerations: what is open above it is not an error of some rows but of the motion."""
COUNTS = 0.1  # of a joint's peak: what is open of accelerations and makes less of a torque does not count
COARSE = 1e-2  # of the energy that goes in and out: where sampling explains more, it may explain all
NEGLIGIBLE = 1e-3  # of the largest torque: a joint whose peak is smaller is judged as if it had this one
TINY = 1e-300
RATE = 100.0  # Hz that is asked for, and more where there are more samples than that already
VANISHING = 0.01  # of the weight, or of the largest force that balances: a base wrench below it is rounding or noise


def bar_caveats(joints: Sequence[JointLoad], sizing: Sizing | None) -> Iterator[Caveat]:
    """Yield caveats about limits within the error bars of peaks; a motor's bar is the same share as its joint's."""
    bars = [(joint, joint.error_bar or 0.0) for joint in joints]
    of_joints = [(joint, bar, abs(joint.peak), joint.effort_limit, "") for joint, bar in bars]
    of_motors = [
        (joint, bar * near.torque / max(abs(joint.peak), TINY), near.torque, near.limit, "the motor of ")
        for (joint, bar), own in zip(bars, sizing.joints if sizing else (), strict=False)
        if own.motor and (near := own.motor.nearest)
    ]
    for beyond, what in ((False, "may be beyond its limit"), (True, "may be within its limit")):
        near_it = [
            (abs(peak - limit) / bar, joint, bar, peak, limit, whose)
            for joint, bar, peak, limit, whose in (*of_joints, *of_motors)
            if limit is not None and bar and (peak > BEYOND * limit) is beyond and abs(peak - limit) < bar
        ]
        if near_it:
            _, joint, bar, peak, limit, whose = min(near_it, key=lambda each: steady(each[0]))
            who = f"{whose}{shown(joint.name)}{f', and {len(near_it) - 1} more,' if len(near_it) > 1 else ''}"
            said = f"the peak of {who} {what}: {figure(peak)} within {figure(bar, 2)} {joint.unit}, limit {limit:g}"
            yield Caveat(f"unless within the error bar of {who.rstrip(',')}", f"{said} {joint.unit}")


def carried(
    model: Model, scene: Scene, base: Sequence[ComponentLoad], joints: Sequence[JointLoad], checks: Checks, looped: bool
) -> tuple[Caveat, ...]:
    """Return what is in doubt about what carries the base, and what carries the robot at floating joints: nothing where
    the scene says that the base is held, where no wrench is left, where a base that does not move may well be bolted
    down, and where loops hold the base (`looped`): what they leave is told of its rates."""
    weight = model.total_mass * hypot(*scene.gravity)
    least_force = VANISHING * max(weight, checks.largest_force)
    least_moment = VANISHING * max(weight * model.reach, checks.largest_moment)
    parts = {joint.name: joint.rms for joint in joints} | {part.name: part.rms for part in base}
    floating = [body.joint.name for body in model.bodies[1:] if body.joint.kind == "floating"]
    found = []
    for name, kinds in (("", ("f", "m")), *((name, (f"{name}_v", f"{name}_w")) for name in floating)):
        force, moment = (hypot(*(parts[f"{kind}{axis}"] for axis in "xyz")) for kind in kinds)
        wrench = f"{figure(force)} N and {figure(moment)} N m (RMS)"
        if force <= least_force and moment <= least_moment:
            continue
        if name:
            what = f"nothing drives the floating joint {shown(name)}, whose motion takes {wrench}"
            found.append(Caveat("as long as what floats is carried (assumed)", f"{what}; give it as [[wrench]]"))
        elif not (looped or scene.held or any(each.cause == "contact" for each in scene.wrenches)):
            loads, free = "which a robot that floats cannot have", ""
            why = (
                "the wrenches of the scene do not carry it" if scene.wrenches else "there is no contact that carries it"
            )
            if not model.floating:
                loads, why = "loads of a robot that hangs by its base", untouched(model)
                free = 'let the base move ([base] motion = "moving", base_ columns) and '
            said = (
                f"the ground holds the base with {wrench}, {loads}: {why}; "
                "if something carries the base, such as bolts or a vehicle, say so (--base-held, or [base] held = "
                f"true), otherwise {free}say where its feet stand ([[contact]])"
            )
            if why:
                found.append(Caveat("as long as the base is held (assumed)", said))
    return tuple(found)


class ErrorBars:
    """Error bars of joint torques, by their derivatives by derived accelerations, of which something is open; guessed:
    whether the motion is of way-points; unknown: whether nothing tells how far accelerations are right."""

    def __init__(self, model: Model, scene: Scene, rates: slice, constraints: ConstraintPass | None) -> None:
        """Args: rates: the entries of tau that are joints; constraints: of the motion, if there are any."""
        self.model, self.scene, self.rates, self.constraints = model, scene, rates, constraints
        self.off_squares, self.squares = np.zeros(model.n), np.zeros(model.n)
        self.guessed = self.unknown = False
        self._first: Floats | None = None

    def update(self, block: Trajectory) -> tuple[Floats, Floats]:
        """Return (N, n) the noise of accelerations of a block, and by how much they may be off."""
        found = block.sampling
        self.unknown |= found is None or found.unknown or len(found.off) != len(block)
        if found is None or len(found.off) != len(block):
            return np.zeros_like(block.qdd), np.zeros_like(block.qdd)
        self.guessed = found.guessed
        self.off_squares, self.squares = self.off_squares + found.off_squares, self.squares + found.squares
        return found.noise, found.off

    def caveats(
        self, joints: Sequence[JointLoad], bars: Sequence[float], balance: EnergyBalance, samples: int, span: float
    ) -> tuple[Caveat, ...]:
        """Return what is in doubt for want of samples over a span of time, or because the energy does not balance."""
        rate = max(RATE, 4.0 * (samples - 1) / span if span > 0.0 else 0.0)
        how_many = f"{count(samples, 'sample')} over {figure(span)} s are"
        remedy = f"give samples at {figure(rate, 1)} Hz"
        found = []
        if joints and (self.off_squares > OPEN**2 * self.squares).any():
            least = NEGLIGIBLE * max(abs(joint.peak) for joint in joints)
            pairs = zip(bars, joints, strict=True)
            bar, joint = max(pairs, key=lambda pair: pair[0] / max(abs(pair[1].peak), least, TINY))
            if bar > COUNTS * max(abs(joint.peak), least):
                said = (
                    f"{how_many} too few to derive accelerations: the peak of {shown(joint.name)}, "
                    f"{figure(joint.peak)} {joint.unit}, may be off by {figure(bar, 2)} {joint.unit}; "
                    f"{remedy} or more, or give velocities and accelerations"
                )
                found.append(Caveat(TOO_FEW, said))
        # where it is coarse, the trapezoidal rule cannot tell a wrong rate from too few samples
        off = f"energy balance is off by {balance.worst:.3g} J of {balance.turnover:.3g} J"
        if not balance.consistent and balance.explained <= COARSE * balance.turnover and samples >= FEW:
            said = f"{off}: velocities or accelerations are not the rates of the positions"
            found.append(Caveat("by torques that are not trusted (energy does not balance)", said))
        elif not balance.consistent and not found:
            said = (
                f"{off}: {how_many} too few to tell whether velocities and accelerations are the rates of "
                f"the positions, or what happens between the samples; {remedy} or more"
            )
            found.append(Caveat("at the samples given (too few for the energy check)", said))
        return tuple(found)

    def over_block(self, state: Mapping[str, Floats]) -> Floats | float:
        """Return (joints, N) by how much torques may be off, 0 for guesses; state: with noise, off (N, n). Noise s of
        accelerations adds up as sqrt(sum_j (M_kj s_j)^2), what is in doubt besides as sum_j |M_kj d_j|: joints that
        move together have corners together. Where constraints bear a part, M is that of the first pose."""
        noise, off = NOISE * state["noise"], state["off"]
        if self.guessed or not off.any():
            return 0.0
        if self.constraints is None:
            M = self._inertia(state["q"])[:, self.rates]
        else:
            if self._first is None:
                self._first = self.response({name: values[0] for name, values in state.items()})[self.rates]
            M = self._first[None]
        M = np.abs(M.transpose(1, 0, 2))
        doubt = (M * np.maximum(off - noise, 0.0)).sum(axis=2)
        return np.asarray(doubt + np.sqrt(((M * np.minimum(noise, off)) ** 2).sum(axis=2)))

    def _inertia(self, q: Floats) -> Floats:
        """Return (N, n, n) M of poses (N, nq); friction that grows with load adds at most its share, which is taken."""
        from robodyn.dynamics.inverse import mass_matrix

        M = mass_matrix(self.model, np.ascontiguousarray(q), scene=self.scene)
        for _, joint, friction in joints_with_friction(self.model, self.scene):
            if friction.load:
                M[..., joint.rate, :] *= 1.0 + friction.load
        return M

    def at_peak(self, k: int, state: Mapping[str, Floats], shares: Mapping[str, float]) -> tuple[float, float]:
        """Return what noise of accelerations does to joint k at its peak, sqrt(sum (M_kj s_j)^2), and what is open
        where they are guessed: sum |M_kj off_j|, and, as way-points may be places of rest, all that their derived
        speeds make of the torque, of which these are the shares."""
        if not state["off"].any():
            return 0.0, 0.0
        M = self.response(state)[k + self.rates.start]
        of_speed = sum(abs(shares.get(name, 0.0)) for name in ("coriolis", "viscous friction"))
        return length(M * state["noise"]), float((np.abs(M) * state["off"]).sum()) + of_speed

    def response(self, state: Mapping[str, Floats], own: bool = False) -> Floats:
        """Return (n, n) by how much torques of a sample change with accelerations: M, or as of `ConstraintPass`."""
        return self._inertia(state["q"]) if self.constraints is None else self.constraints.response(state, own)
