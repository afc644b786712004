"""The worked solution of a robot's dynamics, step by step from its frames to the equations of motion.

Each line is written once, of quantities that have a name and a value: products and sums make both, so that what a
formula says and what stands behind it cannot differ. Run on bodies named i, j and k the same lines are the general laws;
on the robot's bodies, with traced scalars, they are its equations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample
from robodyn.dynamics.inverse import bias_forces, mass_matrix
from robodyn.dynamics.plan import Plan, applied, at_rest, loads
from robodyn.equations.closed import MOST_JOINTS, PRODUCTS, TooLargeError, module
from robodyn.equations.letters import AXES, SOURCE, Letter, Lettered
from robodyn.equations.ode import check_equations
from robodyn.errors import InputError, SceneError
from robodyn.programs.linear import eigen
from robodyn.programs.program import Program, trace
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import IDENTITY, ZERO, Array, Scalar, cross, frame, skew, total
from robodyn.robot.kinematics import Values, configuration, rates
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import count, listed

ATOM, PRODUCT, CROSS, SUM = range(4)
"""How tightly a name holds together: what is looser stands in brackets."""
WRITTEN_OUT = 120_000
"""Products of terms up to which every line is written out in the coordinates; beyond, in what earlier lines define."""
LONGEST = 40
"""Terms of an entry that is written out."""
KNOWN, REACTIONS = "known", "reactions"
"""Sources of inputs: components that earlier lines define, and unknown reactions."""
STATES = 16
AT_JOINTS = {"viscous friction": "D", "coulomb friction": "C", "joint spring": "S", "rotor inertia": "A"}
"""Effects that act along joints, and the letters of their terms."""
OF_BODIES = ("gravity", "inertia", "coriolis", "moving base", "mimic", "payload")


@dataclass(frozen=True, eq=False)
class Named:
    """A scalar, vector or matrix, and its name in formulas."""

    name: str
    value: Any = 0.0
    binding: int = ATOM

    def within(self, most: int) -> str:
        return f"({self.name})" if self.binding > most else self.name

    @property
    def T(self) -> Named:
        return Named(f"{self.within(ATOM)}^T", self.value.T)

    def __neg__(self) -> Named:
        return Named(f"-{self.within(CROSS)}", -self.value, self.binding)


def times(*factors: Named) -> Named:
    """Return the product of matrices, vectors and scalars."""
    value = factors[-1].value
    for left in (factor.value for factor in reversed(factors[:-1])):
        if np.ndim(left) == 2 or (np.ndim(left) == np.ndim(value) == 1):
            value = left @ value
        else:
            value = left * value if np.ndim(left) else value * left
    return Named(" ".join(factor.within(PRODUCT) for factor in factors), value, PRODUCT)


def across(a: Named, b: Named) -> Named:
    return Named(f"{a.within(ATOM)} x {b.within(ATOM)}", cross(a.value, b.value), CROSS)


def less(a: Named, b: Named) -> Named:
    return Named(f"{a.within(SUM)} - {b.within(CROSS)}", a.value - b.value, SUM)


def tilde(a: Named) -> Named:
    """[a], the matrix for which [a] b = a x b."""
    return Named(f"[{a.name}]", skew(a.value))


class Line(NamedTuple):
    """left = the sum of terms, some of which have a name of their own, as Coriolis."""

    left: str
    terms: Sequence[Named]
    words: Sequence[str] = ()

    @property
    def law(self) -> str:
        return f"{self.left} = {joined(term.name for term in self.terms)}"


def joined(names: Iterable[str]) -> str:
    return " + ".join(names).replace("+ -", "- ") or "0"


@dataclass(frozen=True, eq=False)
class Equation:
    """A line worked out.

    Attributes:
        names, words, values: of the terms; `total` is their sum (), (3,), (6,) or a matrix of SymPy expressions, scalars
            while it is being traced.
        value: of the left side, where an earlier line has it: what the sum is to be equal to.
        grid: names of blocks, in place of terms.
    """

    left: str
    names: tuple[str, ...]
    words: tuple[str, ...]
    values: tuple[Any, ...]
    total: Any
    value: Any = None
    grid: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, eq=False)
class Part:
    """The equations of a body, or of what the title says; `long`: what a page folds away."""

    title: str
    equations: tuple[Equation, ...] = ()
    words: tuple[str, ...] = ()
    long: bool = False


@dataclass(frozen=True, eq=False)
class Step:
    """Attributes: words: what is done, and why. laws: in general, of body i on body j, which carries bodies k."""

    title: str
    words: tuple[str, ...]
    laws: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()
    counts: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, eq=False)
class Derivation:
    """Attributes:
    letters: with their values. known: (name, value or "", meaning) of coordinates, rates and accelerations.
    written_out: whether every line is in the coordinates, and not in components that earlier lines define.
    """

    robot: str
    gravity: tuple[float, float, float]
    letters: tuple[Letter, ...]
    known: tuple[tuple[str, str, str], ...]
    numbers: bool
    written_out: bool
    steps: tuple[Step, ...]


@dataclass(eq=False)
class _Body:
    """A body with what is given of it, under names that end in its number; lines add what they find, by attribute."""

    label: str
    title: str = ""
    parent: _Body | None = None
    children: list[_Body] = field(default_factory=list)
    turns: bool = True
    slides: bool = True
    free: bool = False
    given: dict[str, Named] = field(default_factory=dict)

    def __getattr__(self, name: str) -> Named:
        try:
            return self.given[name]
        except KeyError:
            raise AttributeError(name) from None

    def name(self, letter: str) -> str:
        return f"{letter}_{self.label}"

    def give(self, **values: Any) -> None:
        self.given |= {key: Named(self.name(key), value) for key, value in values.items()}

    def carried(self, term: Callable[[_Body], Named]) -> list[Named]:
        """Return a term for each body that this one carries; of the body k of a general law, a sum."""
        found = [(k, term(k)) for k in self.children]
        return [replace(one, name=f"sum_k {one.within(PRODUCT)}") if k.label == "k" else one for k, one in found]


def _generic() -> _Body:
    """The body i on the body j, which carries bodies k; turning and sliding."""
    names = {letter: ZERO for letter in ("w", "v", "wd", "a", "v_c", "a_c", "p", "r", "e", "P", "H", "g", "F", "M", "G")}
    names |= {"R": np.eye(3), "I": np.eye(3), "m": 0.0, "qd": 0.0, "qdd": 0.0, "Pd": ZERO, "Hd": ZERO}
    i, j, k = (_Body(label) for label in "ijk")
    for body in (i, j, k):
        body.give(**{letter: value for letter, value in names.items() if "_c" not in letter})
        body.given |= {letter: Named(f"{letter}{body.label}", ZERO) for letter in ("v_c", "a_c")}
    i.parent, i.children = j, [k]
    return i


TWO = Named("2", 2.0)


def _angular_velocity(b: _Body, j: _Body) -> Line:
    return Line(b.name("w"), [times(b.R.T, j.w), *([times(b.e, b.qd)] if b.turns else [])])


def _velocity(b: _Body, j: _Body) -> Line:
    terms = [times(b.R.T, j.v), times(b.R.T, across(j.w, b.p))]
    return Line(b.name("v"), [*terms, *([times(b.e, b.qd)] if b.slides else [])])


def _velocity_of_centre(b: _Body, j: _Body) -> Line:
    return Line(f"v_c{b.label}", [b.v, across(b.w, b.r)])


def _angular_acceleration(b: _Body, j: _Body) -> Line:
    terms = [times(b.R.T, j.wd)]
    if b.turns:
        terms += [across(times(b.R.T, j.w), times(b.e, b.qd)), times(b.e, b.qdd)]
    return Line(b.name("wd"), terms)


def _acceleration(b: _Body, j: _Body) -> Line:
    euler, centripetal = across(j.wd, b.p), across(j.w, across(j.w, b.p))
    terms, words = [times(b.R.T, j.a), times(b.R.T, euler), times(b.R.T, centripetal)], ["", "Euler", "centripetal"]
    if b.slides:
        terms += [across(times(TWO, b.R.T, j.w), times(b.e, b.qd)), times(b.e, b.qdd)]
        words += ["Coriolis", ""]
    return Line(b.name("a"), terms, words)


def _acceleration_of_centre(b: _Body, j: _Body) -> Line:
    terms = [b.a, across(b.wd, b.r), across(b.w, across(b.w, b.r))]
    return Line(f"a_c{b.label}", terms, ("", "Euler", "centripetal"))


def _momentum(b: _Body, j: _Body) -> Line:
    return Line(b.name("P"), [times(b.m, b.v_c)])


def _angular_momentum(b: _Body, j: _Body) -> Line:
    return Line(b.name("H"), [times(b.I, b.w)])


def _momentum_rate(b: _Body, j: _Body) -> Line:
    return Line(b.name("Pd"), [times(b.m, b.a_c)])


def _angular_momentum_rate(b: _Body, j: _Body) -> Line:
    return Line(b.name("Hd"), [times(b.I, b.wd), across(b.w, b.H)])


def _gravity(b: _Body, j: _Body) -> Line:
    return Line(b.name("g"), [times(b.R.T, j.g)])


def _weight(b: _Body, j: _Body) -> Line:
    return Line(b.name("G"), [times(b.m, b.g)])


def _first_law(b: _Body, j: _Body) -> Line:
    return Line(b.name("Pd"), [b.G, b.F, *(-one for one in b.carried(lambda k: times(k.R, k.F)))])


def _arm(b: _Body, k: _Body) -> Named:
    """The moment about the mass centre of b of the force that b exerts on k."""
    return across(less(k.p, b.r), times(k.R, k.F))


def _second_law(b: _Body, j: _Body) -> Line:
    carried = [*b.carried(lambda k: times(k.R, k.M)), *b.carried(lambda k: _arm(b, k))]
    return Line(b.name("Hd"), [b.M, -across(b.r, b.F), *(-one for one in carried)])


def _force(b: _Body, j: _Body) -> Line:
    return Line(b.name("F"), [b.Pd, -b.G, *b.carried(lambda k: times(k.R, k.F))])


def _moment(b: _Body, j: _Body) -> Line:
    carried = [*b.carried(lambda k: times(k.R, k.M)), *b.carried(lambda k: _arm(b, k))]
    return Line(b.name("M"), [b.Hd, across(b.r, b.F), *carried])


Rule = Callable[[_Body, _Body], Line]
VELOCITIES: dict[str, Rule] = {"w": _angular_velocity, "v": _velocity, "v_c": _velocity_of_centre}
ACCELERATIONS: dict[str, Rule] = {
    "wd": _angular_acceleration,
    "a": _acceleration,
    "a_c": _acceleration_of_centre,
}
MOMENTA: dict[str, Rule] = {
    "P": _momentum,
    "H": _angular_momentum,
    "Pd": _momentum_rate,
    "Hd": _angular_momentum_rate,
}
WEIGHTS: dict[str, Rule] = {"g": _gravity, "G": _weight}
LAWS: dict[str, Rule] = {"Pd": _first_law, "Hd": _second_law}
ELIMINATION: dict[str, Rule] = {"F": _force, "M": _moment}


def laws(rules: dict[str, Rule]) -> tuple[str, ...]:
    """Return rules as general laws."""
    i = _generic()
    assert i.parent is not None
    return tuple(rule(i, i.parent).law for rule in rules.values())


class _Sheet:
    """What works out lines on one tape."""

    def __init__(self, tape: Tape, names: list[str] | None) -> None:
        """Args: names: of the components that later lines take for known, to be filled; None writes all out."""
        self._tape, self._names = tape, names

    def found(self, line: Line, value: Any = None) -> tuple[Equation, Named]:
        values = tuple(term.value for term in line.terms)
        words = tuple(line.words) or ("",) * len(values)
        equation = Equation(line.left, tuple(term.name for term in line.terms), words, values, total(values), value)
        return equation, Named(line.left, self._known(line.left, equation.total))

    def _known(self, left: str, value: Any) -> Any:
        if self._names is None:
            return value
        out = np.array(value, dtype=object)
        for k, x in enumerate(value):
            if not isinstance(x, float):
                self._names.append(left + AXES[k])
                out[k] = self._tape.input(KNOWN, len(self._names) - 1)
        return out

    def work_out(self, bodies: Iterable[_Body], rules: dict[str, Rule], last: bool = False) -> tuple[Part, ...]:
        """Apply rules to bodies in their order; last: only say that the two sides are equal, which finds nothing."""
        parts = []
        for body in bodies:
            equations = []
            for letter, rule in rules.items():
                if body.parent is None and letter in ("w", "v", "wd", "a", "g"):
                    equations.append(stated(body.name(letter), body.given[letter].value))
                    continue
                line = rule(body, body.parent or body)
                equation, named = self.found(line, body.given[letter].value if last else None)
                equations.append(equation)
                if not last:
                    body.given[letter] = named
            parts.append(Part(body.title, tuple(equations)))
        return tuple(parts)


def stated(left: str, value: Any) -> Equation:
    return Equation(left, (), (), (), value)


def _bodies(lettered: Lettered, sample: Sample, tape: Tape) -> list[_Body]:
    """Return the bodies that move, with what is given of them; the ground's axes are those of the base."""
    model, motions = sample.model, sample.motions()
    gravity = lettered.gravity(tape)
    if not model.floating:
        gravity = motions[0].R.T @ gravity
    ground = _Body("0")
    ground.give(w=ZERO, v=ZERO, wd=ZERO, a=ZERO, g=gravity)
    every: list[_Body] = []
    for i, (body, motion) in enumerate(zip(model.bodies, motions, strict=True)):
        joint, (m, r, I) = body.joint, lettered.mass_properties(i, tape)
        one = _Body(str(i), turns=joint.kind == "revolute", slides=joint.kind == "prismatic")
        every.append(one)
        one.give(m=m, r=r, I=I, R=motion.R, p=motion.p, e=joint.axis)
        if i == 0:
            one.free, one.title = joint.kind == "floating", f"Body 0, {body.name}, free to move"
            one.give(w=motion.w, v=motion.v, wd=motion.wd, a=motion.a, g=gravity, F=ZERO, M=ZERO)
            continue
        one.parent = every[body.parent] if body.parent or model.floating else ground
        one.parent.children.append(one)
        one.give(qd=sample.speed(joint), qdd=sample.acceleration(joint), q=sample.position(joint))
        kind = "turns" if one.turns else "slides"
        one.title = f"Body {i}, {body.name}: joint {joint.name} {kind} on body {body.parent}"
    return every if model.floating else every[1:]


def _directions(axis: Any) -> tuple[tuple[str, ...], Floats]:
    """Return letters and rows of three directions, the last along the axis: x, y, z, or 1, 2 and the axis."""
    axis = np.asarray(axis, dtype=float)
    if np.abs(axis).max() == 1.0:
        along = int(np.abs(axis).argmax())
        rest = [k for k in range(3) if k != along]
        return (*(AXES[k] for k in rest), AXES[along]), np.array([*np.eye(3)[rest], axis])
    return ("1", "2", "a"), frame(axis)


def unknowns(body: _Body, acting: bool) -> tuple[dict[str, list[str]], str]:
    """Return names of the unknown components of force and moment, and that of what acts along the joint.

    Args: acting: whether friction, springs or rotors act beside the drive.
    """
    if body.free:
        return {"F": [], "M": []}, ""
    letters, _ = _directions(body.e.value)
    every = sorted(letters)
    free = "M" if body.turns else "F"
    held = {letter: [x for x in every if letter != free or x != letters[2]] for letter in "FM"}
    return {letter: [f"{body.name(letter)}{x}" for x in held[letter]] for letter in "FM"}, body.name(
        "Q" if acting else "tau"
    )


def _unknown_reactions(body: _Body, acting: bool, tape: Tape, names: list[str]) -> list[Equation]:
    """Put unknowns in place of the reactions of a body, which bear the names `names`."""
    if body.free:
        return []
    (letters, rows), (held, along) = _directions(body.e.value), unknowns(body, acting)
    out = []
    for letter in "FM":
        value = np.zeros(3, dtype=object)
        for direction, row in zip(letters, rows, strict=True):
            name = f"{body.name(letter)}{direction}"
            if name not in held[letter]:
                name = along
            names.append(name)
            unknown = tape.input(REACTIONS, len(names) - 1)
            value = value + np.array([float(x) * unknown for x in row], dtype=object)
        body.give(**{letter: value})
        out.append(stated(body.name(letter), value))
    return out


class _Traced(NamedTuple):
    """A solution in traced scalars: steps from frames to torques, bodies, generalized forces of the bodies alone by
    rate, and all together."""

    steps: list[Step]
    bodies: list[_Body]
    tau: list[Scalar]
    alone: list[Scalar]


def _solution(
    lettered: Lettered, effects: Sequence[Effect], sample: Sample, tape: Tape, known: list[str] | None, names: list[str]
) -> _Traced:
    """Args: known, names: names of components and of reactions, to be filled; no `known` writes all out."""
    sheet, model, scene = _Sheet(tape, known), sample.model, lettered.plan.scene
    bodies = _bodies(lettered, sample, tape)
    at_joints = {
        effect.name: effect.add(at_rest(sample), sample, scene).at_joint
        for effect in effects
        if effect.name in AT_JOINTS
    }
    acting = {str(i) for torques in at_joints.values() for i in torques}
    frames = []
    for body in bodies:
        given = ["R", "p", "e"] if body.parent else []
        joint = model.bodies[int(body.label)].joint
        follows = [stated(body.name("q"), body.q.value)] if joint.mimics is not None else []
        equations = [stated(body.name(key), body.given[key].value) for key in (*given, "m", "r", "I")]
        frames.append(Part(body.title, (*follows, *equations)))
    steps = [_frames(bodies, tuple(frames), model)]
    outward = sheet.work_out(bodies, VELOCITIES)
    steps.append(Step("Velocities, from the base outwards", VELOCITY_WORDS, laws(VELOCITIES), outward))
    outward = sheet.work_out(bodies, ACCELERATIONS)
    steps.append(Step("Accelerations, from the base outwards", ACCELERATION_WORDS, laws(ACCELERATIONS), outward))
    momenta = sheet.work_out(bodies, MOMENTA)
    steps.append(Step("Momenta and their rates", MOMENTUM_WORDS, laws(MOMENTA), momenta))
    parts = []
    for body, part in zip(bodies, sheet.work_out(bodies, WEIGHTS), strict=True):
        reactions = _unknown_reactions(body, body.label in acting, tape, names)
        parts.append(replace(part, equations=(*part.equations, *reactions), words=(_on(body),)))
    steps.append(Step("Free bodies", FREE_BODY_WORDS, laws(WEIGHTS), tuple(parts), _counted(bodies, acting)))
    both = sheet.work_out(bodies, LAWS, last=True)
    steps.append(Step("Euler's two laws of each body", LAW_WORDS, laws(LAWS), both))
    steps.append(_system(bodies, model, acting))
    inward = sheet.work_out(reversed(bodies), ELIMINATION)
    steps.append(Step("Elimination, from the tips to the base", ELIMINATION_WORDS, laws(ELIMINATION), inward))
    torques, tau, alone = _torques(sheet, bodies, model, at_joints)
    steps.append(torques)
    return _Traced(steps, bodies, tau, alone)


VELOCITY_WORDS = (
    "A body has the velocities of the body that carries it, turned into its own axes, and what its joint adds: e qd to "
    "w where it turns, to v where it slides. v_c is the velocity of the mass centre.",
)
ACCELERATION_WORDS = (
    "The same once more: wd and a are the rates of w and of the velocity of the origin, seen from the ground, with their "
    "components in the body's axes. The axis of a joint turns with the body before it, which gives the cross products.",
)
MOMENTUM_WORDS = (
    "P is the linear momentum, H the angular momentum about the mass centre. Components in axes that turn with w change "
    "even where the vector does not: hence w x H in the rate of H.",
)
FREE_BODY_WORDS = (
    "Each joint is cut. F and M are the force at the joint and the moment about its origin that the body before exerts on "
    "the body: unknown components where the joint holds, 6 - f of them, and the drive along the freedom that it leaves.",
)
LAW_WORDS = (
    "Euler's first law: the linear momentum changes by the sum of the forces. Euler's second law: the angular momentum "
    "about the mass centre changes by the sum of the moments about it. By components in the body's axes, the unknown "
    "reactions in them:",
)
ELIMINATION_WORDS = (
    "A body at a tip carries nothing: its two laws hold the reactions of its own joint alone and are solved for them. "
    "These are then known in the laws of the body before, and so on to the base.",
)
TORQUE_WORDS = (
    "What the drive has to give is the component of the reaction along the axis: of M where the joint turns, of F where "
    "it slides.",
)


def _frames(bodies: list[_Body], parts: tuple[Part, ...], model: Model) -> Step:
    words = (
        "Body i has its axes where its joint is. In the axes of the body before it, p is the way from that body's origin "
        "to its own, R turns components from its own axes into those; e is the joint's axis. m is the mass, r the way from "
        "the origin to the mass centre, I the inertia matrix about the mass centre, in the body's own axes.",
        f"{count(len(bodies), 'body', 'bodies')} that move, {count(model.n, 'degree')} of freedom. All vectors of a body "
        "have components in its own axes.",
    )
    return Step("Frames, coordinates and what is known", words, (), parts)


def _on(body: _Body) -> str:
    words = f"the weight G_{body.label} at its mass centre"
    if not body.free:
        words += f", F_{body.label} and M_{body.label} at its joint"
    for k in body.children:
        words += f", -F_{k.label} and -M_{k.label} of body {k.label} at p_{k.label}"
    return f"On it act {words}."


def _counted(bodies: list[_Body], acting: set[str]) -> tuple[tuple[str, ...], ...]:
    rows = [("body", "f", "6 - f", "unknown reactions", "along the joint")]
    for body in bodies:
        held, along = unknowns(body, body.label in acting)
        reactions = [*held["F"], *held["M"]]
        rows.append((body.label, "6" if body.free else "1", str(len(reactions)), listed(reactions) or "none", along or "-"))
    return tuple(rows)


def _system(bodies: list[_Body], model: Model, acting: set[str]) -> Step:
    """Count the equations and unknowns of the laws of all bodies."""
    n, free = len(bodies), any(body.free for body in bodies)
    drives, followers = n - free, sum(body.joint.mimics is not None for body in model.bodies)
    reactions = 5 * drives
    several = count(n, "body", "bodies")
    words = [
        "The laws of all bodies together are a system of differential and algebraic equations (DAE). Differential unknowns "
        f"are the coordinates, whose second derivatives stand in it: {model.n}; algebraic unknowns are the reactions, "
        f"of which no derivative does: {reactions}.",
        f"{several} x 6 = {6 * n} equations"
        + (f" = {reactions} reactions + {drives} along the joints" if drives else "")
        + (" + 6 accelerations of the base, which nothing holds" if free else "")
        + ".",
        "Where the motion is given, what acts along the joints and the reactions are unknown and the system is linear and "
        "algebraic. Where the drives are given, the accelerations are unknown in their place.",
    ]
    if followers:
        words.append(
            f"{count(followers, 'joint')} that follow others: what acts along them is the force of the coupling, and goes "
            "into the drive of the joint that leads."
        )
    rows = [("laws of body", "equations", "unknowns in them")]
    for body in bodies:
        names = []
        for joint in (body, *body.children):
            held, along = unknowns(joint, joint.label in acting)
            names += [*held["F"], *held["M"], *([along] if along else [])]
        rows.append((body.label, "6", listed(names) or "none"))
    rows.append(("together", str(6 * n), f"{reactions} reactions, {drives} along joints"))
    return Step("The differential-algebraic equations", tuple(words), (), (), tuple(rows))


def _along(body: _Body) -> Named:
    acting = body.M if body.turns else body.F
    return times(replace(body.e, name=f"{body.e.name}^T"), acting)


def _torques(
    sheet: _Sheet, bodies: list[_Body], model: Model, at_joints: dict[str, Any]
) -> tuple[Step, list[Scalar], list[Scalar]]:
    """Return the torques and forces of the drives, and all in the order of the rates; those of bodies alone, too."""
    tau: list[Scalar] = [0.0] * model.n
    alone: list[Scalar] = [0.0] * model.n
    equations, words = [], list(TORQUE_WORDS)
    for body in bodies:
        if body.free:
            tau[:6] = alone[:6] = [*body.M.value, *body.F.value]
            words.append(
                "Nothing holds the base: F_0 and M_0 of the step before vanish, which are the equations for its motion."
            )
            continue
        joint = model.bodies[int(body.label)].joint
        if joint.mimics is not None:
            continue
        terms, named = [], []
        for other in bodies:
            shared = None if other.free else model.bodies[int(other.label)].joint
            if shared is None or shared.rate != joint.rate:
                continue
            each = [(_along(other), "")]
            for effect, torques in at_joints.items():
                if int(other.label) in torques:
                    each.append((Named(other.name(AT_JOINTS[effect]), torques[int(other.label)]), effect))
            for one, word in each:
                ratio = Named(f"{shared.multiplier:g}", float(shared.multiplier))
                terms.append(one if shared.mimics is None else times(ratio, one))
                named.append(word)
                if not word:
                    alone[joint.rate] = alone[joint.rate] + terms[-1].value
        sums = total(term.value for term in terms)
        names = tuple(term.name for term in terms)
        equations.append(Equation(body.name("tau"), names, tuple(named), tuple(t.value for t in terms), sums))
        tau[joint.rate] = sums
    i = _generic()
    law = (f"tau_i = {_along(replace(i, turns=True)).name}", f"tau_i = {_along(replace(i, turns=False)).name}")
    return Step("The drives", tuple(words), law, (Part("", tuple(equations)),)), tau, alone


class _Collected(NamedTuple):
    """M row by row and the shares of the bias by effect, of the recursion; M of the bodies alone."""

    M: Array
    shares: dict[str, list[Scalar]]
    alone: Array


def _collected(lettered: Lettered, effects: Sequence[Effect], sample: Sample, tape: Tape) -> _Collected:
    """Run the recursion with one unit acceleration at a time, and with each effect where nothing accelerates."""
    n, scene = sample.model.n, lettered.plan.scene
    still = replace(sample, qdd=(0.0,) * n)

    def mass(which: Sequence[Effect]) -> Array:
        columns = []
        for k in range(n):
            moving = replace(still, qd=still.qdd, qdd=tuple(float(k == other) for other in range(n)))
            columns.append(loads(moving, applied(which, moving, scene)).tau)
        return np.array(columns, dtype=object).T

    shares = {}
    for effect in lettered.plan.effects:
        if effect.name != "mimic":
            terms = effect.add(effect.background(at_rest(still), still, scene), still, scene)
            terms = replace(terms, gravity=lettered.gravity(tape)) if terms.gravity.any() else terms
            shares[effect.name] = loads(still, terms).tau
    accelerating = [effect for effect in effects if effect not in lettered.plan.effects]
    bodies = [effect for effect in accelerating if effect.name not in AT_JOINTS]
    return _Collected(mass(accelerating), shares, mass(bodies))


def _ode(found: _Collected, bodies: list[_Body], words: tuple[str, ...], numbers: bool) -> Step:
    rows = range(len(found.M))
    parts = [Part("Mass matrix", tuple(stated(f"M_{i + 1}{j + 1}", found.M[i, j]) for i in rows for j in rows if j >= i))]
    for effect, entries in found.shares.items():
        letter = {"gravity": "G", "coriolis": "V"}.get(effect, AT_JOINTS.get(effect, "B"))
        equations = tuple(stated(f"{letter}_{i + 1}", entries[i]) for i in rows)
        parts.append(Part(effect.capitalize(), equations))
    order = [name for body in bodies for name in (["M_0", "F_0"] if body.free else [])]
    explained = (
        "Sorted by accelerations, what the drives give is M qdd and a bias: what is left where nothing accelerates."
        + (" The first three rows are those of M_0, the next three those of F_0." if order else ""),
    )
    law = "M qdd + " + joined(found.shares) + " = tau"
    return Step("The ordinary differential equations", (*explained, *words), (law,), tuple(parts))


def _inverse(a: Named) -> Named:
    """The inverse of a matrix with 1 on its diagonal and 0 above it."""
    L, n = a.value, len(a.value)
    X = np.eye(n).astype(object)
    for i in range(n):
        for j in range(i):
            if not (isinstance(L[i, j], float) and L[i, j] == 0.0):
                X[i] = X[i] - X[j] * L[i, j]
    return Named(f"{a.within(ATOM)}^-1", X)


def _plus(a: Named, b: Named) -> Named:
    return Named(f"{a.within(SUM)} + {b.within(SUM)}", a.value + b.value, SUM)


def _blocks(rows: Sequence[Sequence[Named]]) -> tuple[Any, tuple[tuple[str, ...], ...]]:
    """Return a matrix of blocks and their names."""
    value = np.block([[np.asarray(one.value, dtype=object) for one in row] for row in rows])
    return value, tuple(tuple(one.name for one in row) for row in rows)


NOTHING, UNIT = Named("0", np.zeros((3, 3))), Named("1", np.eye(3))


class _Order(NamedTuple):
    """The recursive order formulation: its parts, laws, and what it finds for M and the forces of the bodies alone."""

    parts: tuple[Part, ...]
    laws: tuple[str, ...]
    M: Array
    tau: Array


def _order_formulation(bodies: list[_Body], model: Model, sample: Sample) -> _Order:
    """Stack the recursions of all bodies: twists (w, v), wrenches (M, F) about the origins, in each body's own axes."""
    N, n, place = len(bodies), model.n, {body.label: k for k, body in enumerate(bodies)}
    Gamma, B = (np.zeros((6 * N, 6 * N), dtype=object) for _ in range(2))
    H, z, b = np.zeros((6 * N, n), dtype=object), np.zeros(6 * N, dtype=object), np.zeros(6 * N, dtype=object)
    parts, names = [], [["0"] * N for _ in range(N)]
    for k, body in enumerate(bodies):
        own, equations = slice(6 * k, 6 * k + 6), []
        parent = body.parent
        if parent is not None:
            value, grid = _blocks([[body.R.T, NOTHING], [-times(body.R.T, tilde(body.p)), body.R.T]])
            if parent.label in place and (parent.free or parent.parent is not None):
                other = place[parent.label]
                Gamma[own, 6 * other : 6 * other + 6] = value
                names[k][other] = body.name("A")
                equations.append(Equation(body.name("A"), (), (), (), value, grid=grid))
        joint = model.bodies[int(body.label)].joint
        if body.free:
            H[own, :6] = np.eye(6)
        else:
            axis = [*body.e.value, *ZERO] if body.turns else [*ZERO, *body.e.value]
            equations.append(stated(body.name("h"), np.array(axis, dtype=object)))
            H[own, joint.rate] = np.array(axis, dtype=object) * float(joint.multiplier)
        first = times(body.m, tilde(body.r))
        about = less(body.I, times(first, tilde(body.r)))
        B[own, own], grid = _blocks([[about, first], [-first, times(body.m, UNIT)]])
        equations.append(Equation(body.name("B"), (), (), (), B[own, own], grid=grid))
        if parent is None:
            z[own] = [*ZERO, *(-body.g.value)]
        else:
            spinning = across(times(body.R.T, parent.w), times(body.e, body.qd)).value
            carried = times(body.R.T, across(parent.w, across(parent.w, body.p))).value
            up = ZERO if parent.label in place and (parent.free or parent.parent is not None) else -body.g.value
            z[own] = [*(spinning if body.turns else ZERO), *(carried + up + (2.0 * spinning if body.slides else ZERO))]
        turning = across(body.w, times(Named("I", about.value), body.w)).value
        b[own] = [*turning, *across(body.w, across(body.w, times(body.r, body.m))).value]
        equations += [stated(body.name("z"), z[own]), stated(body.name("b"), b[own])]
        parts.append(Part(body.title, tuple(equations), long=True))
    named = {"Gamma": Gamma, "H": H, "B": B, "z": z, "b": b, "qd": np.array(sample.qd, dtype=object)}
    G, h, mass, drift, bias, qd = (Named(name, value) for name, value in named.items())
    qdd = Named("qdd", np.array(sample.qdd, dtype=object))
    inverse = _inverse(less(Named("1", np.eye(6 * N)), G))
    Phi = Named("Phi", inverse.value)
    V, Vd = times(Phi, h, qd), times(Phi, _plus(times(h, qdd), drift))
    W = _plus(times(mass, Named("Vd", Vd.value)), bias)
    tau, M = times(h.T, Phi.T, Named("W", W.value)), times(h.T, Phi.T, mass, Phi, h)
    columns = times(Phi, h)
    reach = [["0"] * N for _ in range(N)]
    for k, body in enumerate(bodies):
        reach[k][k] = "1"
        other = None if body.parent is None else place.get(body.parent.label)
        if other is not None and names[k][other] != "0":
            reach[k] = [joined_product(names[k][other], x) if x != "0" else y for x, y in zip(reach[other], reach[k], strict=True)]
    whole = (
        Equation("Gamma", (), (), (), None, grid=tuple(map(tuple, names))),
        Equation("Phi", (), (), (), None, grid=tuple(map(tuple, reach))),
    )
    shown = stated(columns.name, columns.value)
    said = [("Phi", inverse), ("V", V), ("Vd", Vd), ("W", W), ("tau", tau), ("M", M)]
    laws = ("V = Gamma V + H qd", *(f"{left} = {right.name}" for left, right in said))
    parts += [Part("Of all bodies together", whole), Part("The columns of the Jacobian", (shown,), long=True)]
    return _Order(tuple(parts), laws, M.value, tau.value)


def joined_product(left: str, right: str) -> str:
    return left if right == "1" else f"{left} {right}"


ORDER_WORDS = (
    "The recursions of all bodies are one equation of stacked vectors: twists V_i = (w_i, v_i) and wrenches "
    "W_i = (M_i, F_i) about the origins. A_i takes the twist of the body before to body i, h_i is the joint's direction, "
    "B_i holds inertia about the origin and mass, z_i and b_i what comes of velocities; gravity is an upward acceleration "
    "of the ground, in z. Gamma has A_i where body i is carried, zeros elsewhere, so that 1 - Gamma is inverted by "
    "products alone: Phi.",
)


def derive(
    model: Model,
    scene: Scene = DEFAULT,
    at: Values | None = None,
    qd: Values | None = None,
    qdd: Values | None = None,
    kinds: Sequence[str] = (),
    positive: Iterable[str] = (),
) -> Derivation:
    """Return the worked solution: in the coordinates, or in numbers where at, qd or qdd is given (what is not is zero).

    Args:
        at, qd, qdd: of the joints, in order or by name [rad or m, per s, per s^2].
        kinds: of numbers that are letters, of `letters.KINDS`. positive: names of symbols that are.

    Raises:
        InputError: there are no equations, or too many coordinates for formulas; SceneError: the scene has loops,
            contacts or effects that are no part of the chapter.

    Accuracy: in letters, what is said to agree does so exactly; in numbers within 1e-12 of the largest.
    """
    if scene.loops:
        what, remedy = "the scene closes loops, whose reactions cannot be eliminated from the tips", "robodyn equations --form dae"
        raise SceneError(what, remedy=remedy)
    check_equations(model, scene)
    known = {*OF_BODIES, *AT_JOINTS}
    for effect in Plan(model, scene).effects:
        if effect.name not in known:
            what = f"the scene has {effect.name}, which is no part of this solution: {listed(sorted(known))}"
            raise SceneError(what, remedy="leave it out; robodyn equations and fbd know it")
    numbers = not (at is None and qd is None and qdd is None)
    if not numbers and model.n > MOST_JOINTS and not model.floating or model.n > 2 * MOST_JOINTS and not numbers:
        what = f"{model.n} coordinates are too many for formulas, which go up to {MOST_JOINTS}"
        raise InputError(what, remedy="--at gives the solution in numbers", file=model.file)
    model, scene = _with_payloads(model, scene)
    lettered = Lettered(model, scene, kinds, positive)
    effects = Plan(model, scene).effects
    state = _state(model, scene, at or (), qd or (), qdd or ()) if numbers else None
    out = None
    for written_out in (True, False):
        try:
            out = _written(lettered, effects, state, written_out)
            break
        except TooLargeError:
            continue
    assert out is not None
    names = [("q", "coordinate"), ("qd", "velocity"), ("qdd", "acceleration")]
    rows = []
    for k, (source, meaning) in enumerate(names):
        for (of, i), symbol in lettered.symbols.items():
            if of == source:
                base = source != "q" and model.floating and i < 6
                joint = "the base" if base else model.rates[i if source != "q" or not model.floating else i - 1]
                rows.append((symbol.name, "" if state is None else f"{state[k][i]:.6g}", f"{meaning} of {joint}"))
    return Derivation(
        model.name, scene.gravity, lettered.letters, tuple(rows), numbers, written_out, out
    )


def _with_payloads(model: Model, scene: Scene) -> tuple[Model, Scene]:
    """Return the model with the masses of the scene's payloads in its bodies, and the scene without them."""
    if not scene.payloads:
        return model, scene
    a_plan = Plan(model, scene)
    (payload,) = (effect for effect in a_plan.effects if effect.name == "payload")
    n = model.n
    sample = Sample(model, (0.0,) * model.nq, (0.0,) * n, (0.0,) * n)
    inertias = applied((payload,), sample, scene).inertias
    bodies = tuple(replace(body, inertia=inertia) for body, inertia in zip(model.bodies, inertias, strict=True))
    return replace(model, bodies=bodies), replace(scene, payloads=())


State = tuple[Floats, Floats, Floats]


def _state(model: Model, scene: Scene, at: Values, qd: Values, qdd: Values) -> State:
    """Return q, qd, qdd; a base that nothing holds stands upright at rest and accelerates as its six equations say."""
    q, speeds, accelerations = configuration(model, at), rates(model, qd), rates(model, qdd)
    if model.floating:
        M = mass_matrix(model, q, scene=scene, executor="numpy")
        rest = bias_forces(model, q, speeds, scene=scene, executor="numpy")[:6] + M[:6, 6:] @ accelerations[6:]
        moments = np.abs(eigen(M[:6, :6])[0])
        if moments.min() <= 6 * np.finfo(float).eps * moments.max():
            raise InputError("the base has no definite acceleration: the robot has no inertia about some axis")
        accelerations[:6] = -np.linalg.solve(M[:6, :6], rest)
    return q, speeds, accelerations


def _written(lettered: Lettered, effects: Sequence[Effect], state: State | None, written_out: bool) -> tuple[Step, ...]:
    """Return all steps in SymPy expressions; TooLargeError where they are to be written out and are too long."""
    known: list[str] | None = None if written_out else []
    names: list[str] = []
    found: list[Step] = []
    extra: list[tuple[tuple[str, ...], _Order]] = []

    def sample_of(tape: Tape) -> Sample:
        sample = lettered.sample(tape)
        if state is not None:
            q, qd, qdd = (tuple(map(float, part)) for part in state)
            sample = replace(sample, q=q, qd=qd, qdd=qdd)
        return sample

    def differences(tape: Tape) -> Iterator[Scalar]:
        sample = sample_of(tape)
        solved, collected = (
            _solution(lettered, effects, sample, tape, None, []),
            _collected(lettered, effects, sample, tape),
        )
        order = _order_formulation(solved.bodies, sample.model, sample)
        n = sample.model.n
        for i in range(n):
            summed = total(collected.M[i, k] * sample.qdd[k] for k in range(n))
            yield solved.tau[i] - (summed + total(share[i] for share in collected.shares.values()))
        for i in range(n):
            yield order.tau[i] - solved.alone[i]
        for i in range(n):
            for k in range(n):
                yield order.M[i, k] - collected.alone[i, k]
        yield from solved.tau
        yield from collected.M.ravel()

    agreed = _agreement(lettered, trace(differences), lettered.plan.model.n, state is not None)

    def outputs(tape: Tape) -> Iterator[Scalar]:
        sample = sample_of(tape)
        solved = _solution(lettered, effects, sample, tape, known, names)
        collected = _collected(lettered, effects, sample, tape)
        ode = _ode(collected, solved.bodies, (f"The sum and the torques of the step before {agreed[0]}.",), state is not None)
        order = _order_formulation(solved.bodies, sample.model, sample)
        last = (f"Its torques and those of step 9 {agreed[1]}. Its M and that of the step before {agreed[2]}.",)
        end = Step("The recursive order formulation", ORDER_WORDS, order.laws, (*order.parts, Part("Seen to agree", (), last)))
        found.extend([*solved.steps, ode, end])
        for array in _arrays(found):
            yield from np.asarray(array, dtype=object).ravel()

    program = trace(outputs)
    symbol = module().Symbol
    lettered.symbols |= {(KNOWN, k): symbol(name, real=True) for k, name in enumerate(known or ())}
    lettered.symbols |= {(REACTIONS, k): symbol(name, real=True) for k, name in enumerate(names)}
    distinct, homes = lettered.written(program.distinct, PRODUCTS), program.homes
    entries = iter(distinct[k] for k in homes)

    def written(array: Any) -> Any:
        if array is None:
            return None
        out = np.empty(np.shape(array), dtype=object)
        for place in np.ndindex(out.shape):
            out[place] = next(entries)
        return out if out.shape else out.item()

    return tuple(
        replace(
            step,
            parts=tuple(
                replace(
                    part,
                    equations=tuple(
                        replace(
                            equation,
                            values=tuple(written(value) for value in equation.values),
                            total=written(equation.total),
                            value=written(equation.value),
                        )
                        for equation in part.equations
                    ),
                )
                for part in step.parts
            ),
        )
        for step in found
    )


def _arrays(steps: Iterable[Step]) -> Iterator[Any]:
    """Yield all values, in the order in which they are put back."""
    for step in steps:
        for part in step.parts:
            for equation in part.equations:
                yield from (x for x in (*equation.values, equation.total, equation.value) if x is not None)


def _agreement(lettered: Lettered, program: Program, n: int, numbers: bool) -> tuple[str, str, str]:
    """Return in words how three differences came out, those of `_written`: exactly zero in letters, or as numbers."""
    values = np.array([letter.value for letter in lettered.letters])
    widths = {"q": lettered.plan.model.nq, "qd": n, "qdd": n, SOURCE: len(values)}
    rng = np.random.default_rng(0)
    states = {source: rng.uniform(-2.0, 2.0, (STATES, widths[source])) for source in ("q", "qd", "qdd")}
    states[SOURCE] = np.tile(values, (STATES, 1))
    out = NumpyBlocks(program, widths)(states, STATES)
    largest = [np.abs(out[:, a:b]).max(initial=0.0) for a, b in ((0, n), (n, 2 * n), (2 * n, 2 * n + n * n))]
    tau, M = (np.abs(out[:, a:b]).max(initial=0.0) for a, b in ((2 * n + n * n, 3 * n + n * n), (3 * n + n * n, None)))
    off = [x / (scale or 1.0) for x, scale in zip(largest, (tau, tau, M), strict=True)]
    words = [f"differ by {'less than 1e-12' if x <= 1e-12 else f'{x:.0e}'} of the largest" for x in off]
    return words[0], words[1], words[2]
