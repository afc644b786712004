"""The plan: which effects a scene calls for, why, and the programs that compute them. The door of this room.

From a model and a scene to numbers:

1. `plan` asks each of `EFFECTS` whether it is on; `applied` lets those that are add their terms.
2. `loads` gives the terms of a sample to the recursion, `recursions/newton_euler.py` (`forward.py` and the mass matrix
   to those of `recursions/articulated_body.py`), over scalars that are traced: a program without all that is zero.
3. `runner_of` makes the program ready to run on arrays of samples, which `arrays.py` takes and gives.
4. Functions of arrays: `inverse.py` (mass and Coriolis matrix too), `forward.py`, `derivatives.py`, `kinematics.py`,
   `regressor.py` (and parameters that are not known well), `momenta.py` (and self-checks by them); of one sample:
   `function.py`.
5. What holds a robot: `loops/` closes chains, `contacts/` finds forces inside cones of friction, `constraints/` the
   torques of the drives from both; `initial_state.py` says where a motion begins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import NamedTuple

from robodyn.dynamics.effects import forces, friction, motors, rigid_bodies
from robodyn.dynamics.effects.effect import Effect, Sample, Terms, Verdict, ZeroColumns
from robodyn.dynamics.effects.friction import load_torques
from robodyn.dynamics.recursions.newton_euler import joint_torques, newton_euler
from robodyn.programs.program import Program, trace
from robodyn.programs.run.runner import Runner
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import Scalar
from robodyn.robot.kinematics import Wrench, motions
from robodyn.robot.model import Frame, Model
from robodyn.scene.fit import check_scene, refuse_constraints
from robodyn.scene.scene import Scene
from robodyn.solids.inertia.laws import Inertia

EFFECTS: tuple[Effect, ...] = (
    rigid_bodies.GRAVITY,
    rigid_bodies.INERTIA,
    rigid_bodies.CORIOLIS,
    rigid_bodies.MOVING_BASE,
    rigid_bodies.PAYLOAD,
    friction.VISCOUS,
    friction.COULOMB,
    motors.ROTOR,
    motors.COUPLED,
    motors.GYROSCOPIC,
    forces.SPRING,
    forces.LIMIT_SPRING,
    forces.EXTERNAL,
    forces.LOOPS,
    forces.CONTACTS,
    forces.FLUID,
    friction.LOAD,
    rigid_bodies.MIMIC,
)


class Loads(NamedTuple):
    tau: list[Scalar]
    reactions: list[Wrench]


@dataclass(frozen=True)
class Plan:
    """What is computed for one model and scene, for motions that are zero where `zero_columns` says so: the (source,
    column) pairs of q, qd and qdd that are zero throughout, and folded away."""

    model: Model
    scene: Scene
    zero_columns: ZeroColumns = frozenset()

    @cached_property
    def verdicts(self) -> tuple[tuple[Effect, Verdict], ...]:
        """For every effect of the catalogue, whether it is on and why."""
        return tuple((effect, effect.why(self.model, self.scene, self.zero_columns)) for effect in EFFECTS)

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        return tuple(effect for effect, verdict in self.verdicts if verdict.active)

    @cached_property
    def _scalars(self) -> Model:
        """The model with its numbers as Python's floats, which NumPy multiplies and adds in order as traced scalars."""
        bodies = []
        for body in self.model.bodies:
            joint, (m, mc, I) = body.joint, body.inertia
            joint = replace(joint, R=joint.R.astype(object), p=joint.p.astype(object), axis=joint.axis.astype(object))
            bodies.append(replace(body, joint=joint, inertia=Inertia(m, mc.astype(object), I.astype(object))))
        links = {
            name: Frame(body, R.astype(object), p.astype(object)) for name, (body, R, p) in self.model.links.items()
        }
        return replace(self.model, bodies=tuple(bodies), links=links)

    def sample(self, tape: Tape) -> Sample:
        """Return a sample whose scalars are the inputs of `tape`, or 0.0 where the motion is still."""

        def of(source: str, count: int) -> tuple[Scalar, ...]:
            return tuple(0.0 if (source, i) in self.zero_columns else tape.input(source, i) for i in range(count))

        columns = {name: tape.input("columns", i) for i, name in enumerate(self.scene.columns)}
        return Sample(self._scalars, of("q", self.model.nq), of("qd", self.model.n), of("qdd", self.model.n), columns)

    def torques(self) -> Program:
        """The program of tau alone, all effects together."""
        refuse_constraints(self.scene)
        return self.without(None)

    def wrenches(self, joints: bool = False) -> Program:
        """The program of tau, then the base wrench (f, n), then with `joints` the wrench of every joint's body."""
        refuse_constraints(self.scene)

        def outputs(tape: Tape) -> Iterable[Scalar]:
            result = loads(*self.terms(tape))
            wrenches = result.reactions if joints else result.reactions[:1]
            return [*result.tau, *(x for wrench in wrenches for part in wrench for x in part)]

        return trace(outputs, self.model.tips_first)

    def share(self, effect: Effect) -> Program:
        """The program of the part of tau that one effect makes: the same recursion with nothing else on."""

        def outputs(tape: Tape) -> Iterable[Scalar]:
            if effect.by_load:
                return self.missing_without(tape, effect)
            sample = self.sample(tape)
            terms = effect.add(effect.background(at_rest(sample), sample, self.scene), sample, self.scene)
            return loads(sample, terms).tau

        return trace(outputs, self.model.tips_first)

    def without(self, effect: Effect | None) -> Program:
        """The program of tau with one effect left out: what the others cost."""
        return trace(lambda tape: loads(*self.terms(tape, effect)).tau, self.model.tips_first)

    def missing_without(self, tape: Tape, effect: Effect) -> list[Scalar]:
        """What an effect adds to tau where all others are on."""
        whole, rest = loads(*self.terms(tape)).tau, loads(*self.terms(tape, effect)).tau
        return [a - b for a, b in zip(whole, rest, strict=True)]

    def terms(self, tape: Tape, but: Effect | None = None) -> tuple[Sample, Terms]:
        """The sample of `tape`, and what all effects but one add up to in it."""
        sample = self.sample(tape)
        return sample, applied((effect for effect in self.effects if effect is not but), sample, self.scene)


def at_rest(sample: Sample) -> Terms:
    """Return the robot standing still without gravity: the terms to which effects add."""
    nothing = (0.0,) * sample.model.n
    return Terms(nothing, nothing, tuple(body.inertia for body in sample.model.bodies))


def applied(effects: Iterable[Effect], sample: Sample, scene: Scene) -> Terms:
    terms = at_rest(sample)
    for effect in effects:
        terms = effect.add(terms, sample, scene)
    return terms


def loads(sample: Sample, terms: Terms) -> Loads:
    """Return torques and joint wrenches of one sample, in whatever scalar it is made of."""
    model = sample.model
    joints = motions(model, sample.q, terms.qd, terms.qdd)
    reactions = newton_euler(model.parents, joints, terms.inertias, terms.gravity, terms.wrenches)
    at_joint = terms.with_torques(load_torques(terms, model, reactions)).at_joint
    return Loads(joint_torques(model, joints, reactions, at_joint), reactions)


@lru_cache(maxsize=16)
def plan(model: Model, scene: Scene, zero_columns: ZeroColumns = frozenset()) -> Plan:
    """Return the Plan of a model in a scene, the same one for the same arguments; SceneError if these do not fit."""
    check_scene(scene, model)
    return Plan(model, scene, zero_columns)


@lru_cache(maxsize=16)
def torque_runner(model: Model, scene: Scene, zero_columns: ZeroColumns = frozenset()) -> Runner:
    a_plan = plan(model, scene, zero_columns)
    return runner_of(a_plan.torques(), a_plan)


@lru_cache(maxsize=64)
def ready(program: Callable[[Plan], Program], a_plan: Plan) -> Runner:
    """Return a program of a plan, ready to run; the same one for the same arguments."""
    return runner_of(program(a_plan), a_plan)


def runner_of(program: Program, a_plan: Plan, more: Mapping[str, int] = MappingProxyType({})) -> Runner:
    """Return a program of this plan, ready to run; `more` are widths of sources that are its own."""
    model = a_plan.model
    widths = {"q": model.nq, "qd": model.n, "qdd": model.n, "tau": model.n, "columns": len(a_plan.scene.columns)}
    return Runner(program, {**widths, **more})
