"""The worked solution of a robot's dynamics, step by step from its frames to the equations of motion.

Each line is written once, of quantities that have a name and a value: products and sums make both, so that what a
formula says and what stands behind it cannot differ. Run on bodies named i, j and k the same lines are the general
laws; on the robot's bodies, with traced scalars, they are its equations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain, pairwise
from typing import Any, NamedTuple

import numpy as np

from robodyn.dynamics.effects.effect import Effect, Sample
from robodyn.dynamics.inverse import bias_forces, mass_matrix
from robodyn.dynamics.plan import Plan, applied, at_rest, loads
from robodyn.equations.closed import MOST_JOINTS
from robodyn.equations.forms import LETTERS, Forms, TooLargeError, module
from robodyn.equations.letters import AXES, Letter, Lettered
from robodyn.equations.ode import check_equations
from robodyn.errors import InputError, SceneError
from robodyn.programs.linear import eigen
from robodyn.programs.program import trace
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import ZERO, Array, Scalar, cross, frame, skew, total
from robodyn.robot.kinematics import Values, configuration, rates
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.wording import count

ATOM, PRODUCT, CROSS, SUM = range(4)
"""How tightly a name holds together: what is looser stands in brackets."""
LONGEST = 150
"""Terms of a component up to which all is written out in the coordinates; beyond, in what earlier lines define."""
KNOWN, REACTIONS = "known", "reactions"
"""Sources of inputs: components that earlier lines define, and unknown reactions."""
COMPARED = 150_000
"""Products of terms that may be formed to compare as formulas; beyond, numbers are compared, at so many states:"""
STATES = 16
NOISE = 1e-12
"""In numbers what is smaller beside the largest of its equation is what rounding leaves of zero."""
AT_JOINTS = {"viscous friction": "D", "coulomb friction": "K", "joint spring": "S", "rotor inertia": "J"}
"""Effects that act along joints, and the letters of their terms."""
OF_BODIES = ("gravity", "inertia", "coriolis", "moving base", "mimic", "payload")


@dataclass(frozen=True, eq=False)
class Named:
    """A scalar, vector or matrix, its name in formulas, and a word for what it is, as Coriolis."""

    name: str
    value: Any = 0.0
    binding: int = ATOM
    word: str = ""

    def within(self, most: int) -> str:
        return f"({self.name})" if self.binding > most else self.name

    @property
    def T(self) -> Named:
        return Named(f"{self.within(ATOM)}^T", np.transpose(self.value))

    def __neg__(self) -> Named:
        return Named(f"-{self.within(CROSS)}", -self.value, self.binding)

    def __add__(self, other: Named) -> Named:
        return Named(f"{self.name} + {other.name}", self.value + other.value, SUM)

    def __sub__(self, other: Named) -> Named:
        return Named(f"{self.name} - {other.within(CROSS)}", self.value - other.value, SUM)


def times(*factors: Named) -> Named:
    """Return the product of matrices, vectors and scalars."""
    value = factors[-1].value
    for left in (factor.value for factor in reversed(factors[:-1])):
        matrices = np.ndim(left) == 2 or np.ndim(left) == np.ndim(value) == 1
        value = left @ value if matrices else left * value if np.ndim(left) else value * left
    return Named(" ".join(factor.within(PRODUCT) for factor in factors), value, PRODUCT)


def across(a: Named, b: Named, word: str = "") -> Named:
    return Named(f"{a.within(ATOM)} x {b.within(ATOM)}", cross(a.value, b.value), CROSS, word)


def tilde(a: Named) -> Named:
    """[a], the matrix for which [a] b = a x b."""
    return Named(f"[{a.name}]", skew(a.value))


def joined(names: Iterable[str]) -> str:
    return " + ".join(names).replace("+ -", "- ") or "0"


@dataclass(eq=False)
class Equation:
    """A line worked out: left = sum of terms = total.

    Attributes:
        total: a scalar, a vector or a matrix, traced, then of SymPy expressions; as are the values of terms.
        value: of the left side, where an earlier line has it: what the sum is to be equal to. number: of the first of
            these component equations.
        grid: names of blocks, in place of terms.
    """

    left: str
    total: Any = None
    terms: list[Named] = field(default_factory=list)
    value: Any = None
    number: int = 0
    grid: tuple[tuple[str, ...], ...] = ()


class Part(NamedTuple):
    """The equations of a body, or of what the title says; words stand before them."""

    title: str
    equations: Sequence[Equation] = ()
    words: str = ""


class Step(NamedTuple):
    """words: what is done, and why. laws: in general, of body i on body j, which carries bodies k. counts: a table."""

    title: str
    words: Sequence[str]
    laws: Sequence[str] = ()
    parts: Sequence[Part] = ()
    counts: Sequence[Sequence[str]] = ()


@dataclass(frozen=True, eq=False)
class Derivation:
    """A worked solution.

    Attributes:
        letters: with their values. known: (name, value or "", meaning) of coordinates, velocities and accelerations.
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
    """A body with what is known of it, by letters of which the names end in its number; lines add what they find."""

    label: str
    title: str = ""
    parent: _Body | None = None
    children: list[_Body] = field(default_factory=list)
    turns: bool = True
    slides: bool = True
    known: dict[str, Named] = field(default_factory=dict)

    def __getattr__(self, letter: str) -> Named:
        try:
            return self.known[letter]
        except KeyError:
            raise AttributeError(letter) from None

    @property
    def free(self) -> bool:
        """Whether nothing holds it: a base that moves."""
        return self.parent is None

    def name(self, letter: str) -> str:
        return f"{letter}{'' if letter.endswith('_c') else '_'}{self.label}"

    def give(self, **values: Any) -> None:
        self.known |= {letter: Named(self.name(letter), value) for letter, value in values.items()}

    def along(self, x: Named, moves: bool) -> list[Named]:
        """A vector along the joint's axis, if the joint moves so."""
        return [times(self.e, x)] if moves else []

    def carried(self, term: Callable[[_Body], Named]) -> list[Named]:
        """A term for each body that this one carries; for the body k of a general law, a sum."""
        found = [(k, term(k)) for k in self.children]
        return [replace(one, name=f"sum_k {one.within(PRODUCT)}") if k.label == "k" else one for k, one in found]

    def minus_carried(self, term: Callable[[_Body], Named]) -> list[Named]:
        return [-one for one in self.carried(term)]

    def arm(self, k: _Body) -> Named:
        """The moment about this body's mass centre of the force on body k, which it carries."""
        return across(k.p - self.r, times(k.R, k.F))


Rules = Mapping[str, Callable[[_Body, _Body], list[Named]]]
"""By the letter of what it finds, or states the law of, the terms of a line of body b on body j."""
TWO = Named("2", 2.0)
VELOCITIES: Rules = {
    "w": lambda b, j: [times(b.R.T, j.w), *b.along(b.qd, b.turns)],
    "v": lambda b, j: [times(b.R.T, j.v), times(b.R.T, across(j.w, b.p)), *b.along(b.qd, b.slides)],
    "v_c": lambda b, j: [b.v, across(b.w, b.r)],
}
ACCELERATIONS: Rules = {
    "wd": lambda b, j: [
        times(b.R.T, j.wd),
        *(across(times(b.R.T, j.w), turned) for turned in b.along(b.qd, b.turns)),
        *b.along(b.qdd, b.turns),
    ],
    "a": lambda b, j: [
        times(b.R.T, j.a),
        replace(times(b.R.T, across(j.wd, b.p)), word="Euler"),
        replace(times(b.R.T, across(j.w, across(j.w, b.p))), word="centripetal"),
        *(across(times(TWO, b.R.T, j.w), slid, "Coriolis") for slid in b.along(b.qd, b.slides)),
        *b.along(b.qdd, b.slides),
    ],
    "a_c": lambda b, j: [b.a, across(b.wd, b.r, "Euler"), across(b.w, across(b.w, b.r), "centripetal")],
}
MOMENTA: Rules = {
    "P": lambda b, j: [times(b.m, b.v_c)],
    "H": lambda b, j: [times(b.I, b.w)],
    "Pd": lambda b, j: [times(b.m, b.a_c)],
    "Hd": lambda b, j: [times(b.I, b.wd), across(b.w, b.H)],
}
GRAVITY: Rules = {"g": lambda b, j: [times(b.R.T, j.g)]}
LAWS: Rules = {
    "Pd": lambda b, j: [times(b.m, b.g), b.F, *b.minus_carried(lambda k: times(k.R, k.F))],
    "Hd": lambda b, j: [
        b.M,
        -across(b.r, b.F),
        *b.minus_carried(lambda k: times(k.R, k.M)),
        *b.minus_carried(b.arm),
    ],
}
ELIMINATION: Rules = {
    "F": lambda b, j: [b.Pd, -times(b.m, b.g), *b.carried(lambda k: times(k.R, k.F))],
    "M": lambda b, j: [b.Hd, across(b.r, b.F), *b.carried(lambda k: times(k.R, k.M)), *b.carried(b.arm)],
}


def _generic() -> _Body:
    """The body i on the body j, which carries bodies k; its joint turns and slides."""
    vectors = ("w", "v", "wd", "a", "v_c", "a_c", "p", "r", "e", "P", "H", "Pd", "Hd", "g", "F", "M")
    i, j, k = (_Body(label) for label in "ijk")
    for body in (i, j, k):
        body.give(**dict.fromkeys(vectors, ZERO), R=np.eye(3), I=np.eye(3), m=0.0, qd=0.0, qdd=0.0)
    i.parent, i.children = j, [k]
    return i


def laws(rules: Rules) -> list[str]:
    """Return rules as general laws."""
    i = _generic()
    assert i.parent is not None
    return [f"{i.name(left)} = {joined(x.name for x in rule(i, i.parent))}" for left, rule in rules.items()]


class _Sheet:
    """What works out lines on one tape."""

    def __init__(self, tape: Tape, names: list[str] | None) -> None:
        """Args: names: of the components that later lines take for known, to be filled; None writes all out."""
        self._tape, self._names = tape, names

    def _known(self, left: str, value: Any) -> Any:
        if self._names is None:
            return value
        out = np.array(value, dtype=object)
        for k, x in enumerate(value):
            if not isinstance(x, float):
                self._names.append(left + AXES[k])
                out[k] = self._tape.input(KNOWN, len(self._names) - 1)
        return out

    def work_out(self, bodies: Iterable[_Body], rules: Rules, find: bool = True) -> list[Part]:
        """Apply rules to bodies in their order, which finds what stands on the left, or with find=False is a law that
        holds for what does."""
        parts, number = [], 0
        for body in bodies:
            equations = []
            for letter, rule in rules.items():
                left = body.name(letter)
                if body.parent is None and letter in ("w", "v", "wd", "a", "g"):
                    equations.append(Equation(left, body.known[letter].value))
                    continue
                terms = rule(body, body.parent or body)
                equation = Equation(left, total(term.value for term in terms), terms)
                if find:
                    body.known[letter] = Named(left, self._known(left, equation.total))
                else:
                    equation.value, number = body.known[letter].value, number + 3
                    equation.number = number - 2
                equations.append(equation)
            parts.append(Part(body.title, equations))
        return parts


def _bodies(lettered: Lettered, gravity: Array, sample: Sample, tape: Tape) -> tuple[_Body, list[_Body]]:
    """Return the ground, in the axes of a base that is held, and the bodies that move, with what is given of them."""
    model, motions = sample.model, sample.motions()
    ground = _Body("0")
    every: list[_Body] = []
    for i, (body, motion) in enumerate(zip(model.bodies, motions, strict=True)):
        joint, (m, r, I) = body.joint, lettered.mass_properties(i, tape)
        if i == 0:
            one = _Body("0", f"Body 0, {body.name}, free to move") if model.floating else ground
            g = gravity if model.floating else motion.R.T @ gravity
            one.give(w=motion.w, v=motion.v, wd=motion.wd, a=motion.a, g=g, F=ZERO, M=ZERO, m=m, r=r, I=I)
            every.append(one)
            continue
        one = _Body(str(i), "", every[body.parent], [], joint.kind == "revolute", joint.kind == "prismatic")
        every[body.parent].children.append(one)
        one.give(m=m, r=r, I=I, R=_right_angles(motion.R), p=motion.p, e=joint.axis)
        one.give(q=sample.position(joint), qd=sample.speed(joint), qdd=sample.acceleration(joint))
        moves, before = "turns" if one.turns else "slides", model.bodies[body.parent].name
        one.title = f"Body {i}, {body.name}: its joint {joint.name} {moves} on body {body.parent}, {before}"
        every.append(one)
    return ground, every if model.floating else every[1:]


def _right_angles(R: Array) -> Array:
    """Return a rotation in numbers with zeros for what rounding leaves of them."""
    turned: Array = np.vectorize(lambda x: 0.0 if isinstance(x, float) and abs(x) <= NOISE else x, [object])(R)
    return turned


def unknowns(body: _Body, acting: bool) -> dict[str, dict[str, Floats]]:
    """Return directions by names of the unknown components, of force F, moment M and what acts along the joint.

    Args: acting: whether friction, springs or rotors act beside the drive.
    """
    out: dict[str, dict[str, Floats]] = {"F": {}, "M": {}, "along": {}}
    if body.free:
        return out
    axis = np.asarray(body.e.value, dtype=float)
    held = dict(zip(AXES, np.eye(3), strict=True))
    last = AXES[int(np.abs(axis).argmax())]
    if np.abs(axis).max() != 1.0:
        held, last = dict(zip("12a", frame(axis), strict=True)), "a"
    for letter in "FM":
        for direction, unit in held.items():
            if direction != last or (letter == "M") != body.turns:
                out[letter][body.name(letter) + direction] = unit
    out["along"][body.name("Q" if acting else "tau")] = axis
    return out


def _put_unknowns(body: _Body, acting: bool, tape: Tape, names: list[str]) -> list[Equation]:
    """Put unknowns in place of the reactions of a body; their names are added to `names`."""
    found = unknowns(body, acting)
    along = "M" if body.turns else "F"
    for letter in "FM" if not body.free else "":
        value = np.zeros(3, dtype=object)
        for name, unit in (found[letter] | (found["along"] if letter == along else {})).items():
            names.append(name)
            unknown = tape.input(REACTIONS, len(names) - 1)
            value = value + np.array([float(x) * unknown for x in unit], dtype=object)
        body.give(**{letter: value})
    return [] if body.free else [Equation(body.F.name, body.F.value), Equation(body.M.name, body.M.value)]


class _Traced(NamedTuple):
    """A solution in traced scalars; alone: the generalized forces by rate without what acts along joints beside."""

    steps: list[Step]
    bodies: list[_Body]
    tau: list[Scalar]
    alone: list[Scalar]


WORDS = """\
frames: Body i has its axes at its joint. In the axes of the body before it, p is the way from that body's origin to
its own; R turns components in its own axes into those. In its own axes, e is the joint's axis, r the way from the
origin to the mass centre, I the inertia matrix about it; m is the mass. All vectors of a body are written in its own
axes.

velocities: A body has the velocities of the body that carries it, turned into its own axes, and what its joint adds:
e qd to w where it turns, to v where it slides. v_c is the velocity of the mass centre.

accelerations: The same once more: wd and a are the accelerations of the body and of its origin, seen from the ground.
The axis of a joint turns with the body before it: hence the cross products with qd.

momenta: P is the linear momentum, H the angular momentum about the mass centre; Pd and Hd are their rates, seen from
the ground. In axes that turn with w components of H change besides: hence w x H.

free: Each joint is cut. The body before exerts on the body the force F at the joint and the moment M about its
origin. A joint of f degrees of freedom holds 6 - f components, the unknown reactions; along its freedom acts the
drive. Gravity is turned outwards as velocities are.

laws: Euler's first law: the momentum changes by the sum of the forces. Euler's second law: the angular momentum about
the mass centre changes by the sum of the moments about it. The unknown reactions stand in them.

elimination: A body at a tip carries nothing: its laws hold no reactions but those of its own joint, and are solved
for them. They are then known in the laws of the body before, and so on to the base.

drives: What a drive has to give is the component of the reaction along the axis: of M where the joint turns, of F
where it slides.

order: The recursions of all bodies are one equation of stacked vectors: twists V_i = (w_i, v_i) and wrenches W_i =
(M_i, F_i) about the origins. A_i takes the twist of the body before to body i, h_i is the direction of the joint, B_i
has inertia about the origin and mass; z_i and b_i are what velocities alone make, and gravity is in z, as an
acceleration of the ground upwards. Gamma has A_i in the row of body i and the column of the body before it, so that
products alone invert 1 - Gamma: Phi."""
"""What is done in each step, and why."""


def _words(step: str) -> str:
    texts = dict(text.split(": ", 1) for text in WORDS.split("\n\n"))
    return " ".join(texts[step].split())


def _solution(
    lettered: Lettered, gravity: Array, sample: Sample, tape: Tape, known: list[str] | None, names: list[str]
) -> _Traced:
    """Return the steps from frames to drives.

    Args:
        known, names: of components that lines find, and of reactions, to be filled; without `known` all is written out.
    """
    sheet, model, scene = _Sheet(tape, known), sample.model, lettered.plan.scene
    ground, bodies = _bodies(lettered, gravity, sample, tape)
    effects = [effect for effect in Plan(lettered.plan.model, scene).effects if effect.name in AT_JOINTS]
    beside = {effect.name: effect.add(at_rest(sample), sample, scene).at_joint for effect in effects}
    acting = {str(i) for torques in beside.values() for i in torques}
    given = [] if model.floating else [Part("Ground", [Equation("g_0", ground.g.value)])]
    for body in bodies:
        mimics = model.bodies[int(body.label)].joint.mimics is not None
        letters = [*("q" * mimics), *("" if body.free else "Rpe"), *"mrI"]
        given.append(Part(body.title, [Equation(body.name(x), body.known[x].value) for x in letters]))
    steps = [Step("Frames, coordinates and what is known", [_words("frames")], (), given)]

    def work_out(title: str, words: str, rules: Rules, order: Sequence[_Body] = bodies, find: bool = True) -> None:
        steps.append(Step(title, [_words(words)], laws(rules), sheet.work_out(order, rules, find)))

    work_out("Velocities, from the base outwards", "velocities", VELOCITIES)
    work_out("Accelerations, from the base outwards", "accelerations", ACCELERATIONS)
    work_out("Momenta and their rates", "momenta", MOMENTA)
    work_out("Free bodies", "free", GRAVITY)
    free, rows, system = [], [("body", "f", "6 - f", "unknown reactions", "along the joint")], []
    for body, part in zip(bodies, steps.pop().parts, strict=True):
        reactions = _put_unknowns(body, body.label in acting, tape, names)
        felt = [f"the weight {times(body.m, body.g).name} at the mass centre"]
        felt += [] if body.free else [f"{body.F.name} and {body.M.name} at its joint"]
        felt += [f"-F_{k.label} and -M_{k.label} of body {k.label} at p_{k.label}" for k in body.children]
        free.append(Part(part.title, [*part.equations, *reactions], f"On it act {', '.join(felt)}."))
        own, *carried = [unknowns(one, one.label in acting) for one in (body, *body.children)]
        held, along = [*own["F"], *own["M"]], [*own["along"]]
        rows.append((body.label, "6" if body.free else "1", str(len(held)), ", ".join(held) or "-", *(along or "-")))
        system.append(
            (body.label, "6", ", ".join([*held, *along, *chain(*(chain(*x.values()) for x in carried))]) or "-")
        )
    rows.append(("together", str(model.n), str(sum(int(row[2]) for row in rows[1:])), "", ""))
    steps.append(Step("Free bodies", [_words("free")], laws(GRAVITY), free, rows))
    work_out("Euler's laws of each body", "laws", LAWS, bodies, False)
    steps.append(_system(bodies, model, system))
    work_out("Elimination, from the tips to the base", "elimination", ELIMINATION, bodies[::-1])
    tau, alone, drives = _drives(bodies, model, beside)
    words = [_words("drives")]
    if model.floating:
        words.append("Nothing holds the base: F_0 and M_0 vanish. These are the six equations of its motion.")
    i = _generic()
    general = [f"tau_i = {times(i.e.T, x).name} | where it {moves}" for x, moves in ((i.M, "turns"), (i.F, "slides"))]
    steps.append(Step("The drives", words, general, [Part("", drives)] if drives else ()))
    return _Traced(steps, bodies, tau, alone)


def _system(bodies: list[_Body], model: Model, rows: list[Any]) -> Step:
    """Count equations and unknowns of the laws of all bodies."""
    n, joints = len(bodies), sum(not body.free for body in bodies)
    reactions, followers = 5 * joints, sum(body.joint.mimics is not None for body in model.bodies)
    parts = [f"{reactions} reactions + {joints} along the joints"] if joints else []
    parts += ["6 accelerations of the base"] if model.floating else []
    words = [
        "The laws of all bodies are a system of differential and algebraic equations (DAE). Its differential "
        f"unknowns are the {model.n} coordinates, of which second derivatives stand in it. Its algebraic unknowns are "
        f"the {reactions} reactions, of which no derivative does.",
        f"Where the motion is given: 6 x {count(n, 'body', 'bodies')} = {6 * n} equations for {' + '.join(parts)}, "
        "linear and algebraic. Where the drives are given, the accelerations are unknown in their place.",
    ]
    if followers:
        words.append(
            f"{count(followers, 'joint')} that follow others: what acts along them is the force of the coupling, which "
            "the drive of the joint that leads has to give."
        )
    head = ("laws of body", "equations", "unknowns in them")
    end = ("together", str(6 * n), f"{reactions} reactions, {joints} along joints")
    return Step("The differential-algebraic equations", words, (), (), [head, *rows, end])


def _drives(
    bodies: list[_Body], model: Model, beside: Mapping[str, Mapping[int, Scalar]]
) -> tuple[list[Scalar], list[Scalar], list[Equation]]:
    """Return the generalized forces by rate, those without what acts along joints beside, and the drives' equations."""
    tau: list[Scalar] = [0.0] * model.n
    alone, equations = list(tau), dict[int, Equation]()
    leading = {joint.rate: joint for joint in model.independent}
    for body in bodies:
        if body.free:
            tau[:6] = alone[:6] = [*body.M.value, *body.F.value]
            continue
        i, joint = int(body.label), model.bodies[int(body.label)].joint
        terms = [times(body.e.T, body.M if body.turns else body.F)]
        for effect, torques in beside.items():
            if i in torques:
                terms.append(Named(body.name(AT_JOINTS[effect]), torques[i], word=effect))
        if joint.mimics is not None:
            ratio = Named(f"{joint.multiplier:g}", float(joint.multiplier))
            terms = [replace(times(ratio, term), word=term.word) for term in terms]
        leader = next(b for b in bodies if not b.free and model.bodies[int(b.label)].joint is leading[joint.rate])
        equations.setdefault(joint.rate, Equation(leader.name("tau"), 0.0)).terms.extend(terms)
        tau[joint.rate] = total([tau[joint.rate], *(term.value for term in terms)])
        alone[joint.rate] = alone[joint.rate] + terms[0].value
        equations[joint.rate].total = tau[joint.rate]
    return tau, alone, [equations[rate] for rate in sorted(equations)]


class _Collected(NamedTuple):
    """M row by row and the shares of the bias by effect, as the recursion makes them; M of bodies alone."""

    M: Array
    shares: dict[str, list[Scalar]]
    alone: Array


def _collected(lettered: Lettered, gravity: Array, sample: Sample) -> _Collected:
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
            terms = replace(terms, gravity=gravity) if terms.gravity.any() else terms
            shares[effect.name] = loads(still, terms).tau
    effects = Plan(lettered.plan.model, scene).effects
    accelerating = [effect for effect in effects if effect not in lettered.plan.effects]
    return _Collected(mass(accelerating), shares, mass([one for one in accelerating if one.name not in AT_JOINTS]))


def _ode(found: _Collected, model: Model, numbers: bool, agreed: str) -> Step:
    n = len(found.M)
    gap = "," if n > 9 else ""
    entries = [Equation(f"M_{i + 1}{gap}{k + 1}", found.M[i, k]) for i in range(n) for k in range(i, n)]
    parts = [Part("Mass matrix M, symmetric", [Equation("M", found.M)] if numbers else entries)]
    for effect, share in found.shares.items():
        letter = {"gravity": "G", "coriolis": "C"}.get(effect) or AT_JOINTS[effect]
        rows = [Equation(f"{letter}_{i + 1}", x) for i, x in enumerate(share)]
        parts.append(Part(effect.capitalize(), [Equation(letter, np.array(share, dtype=object))] if numbers else rows))
    words = [
        "Sorted by accelerations, the drives give M qdd and a bias, which is what is left where nothing accelerates."
    ]
    if model.floating:
        words.append("Rows 1 to 3 are the components of M_0, rows 4 to 6 those of F_0; on the right they are zero.")
    law = (
        joined(["M qdd", *({"gravity": "G", "coriolis": "C"}.get(x) or AT_JOINTS[x] for x in found.shares)]) + " = tau"
    )
    parts.append(Part("Check", (), f"The sum and the drives of the step before {agreed}."))
    return Step("The ordinary differential equations", words, [law], parts)


def _inverse(a: Named) -> Named:
    """The inverse of a matrix with 1 on its diagonal and 0 above it."""
    X = np.eye(len(a.value)).astype(object)
    for i, row in enumerate(a.value):
        for j, x in enumerate(row[:i]):
            if not (isinstance(x, float) and x == 0.0):
                X[i] = X[i] - X[j] * x
    return Named(f"{a.within(ATOM)}^-1", X)


def _blocks(left: str, rows: Sequence[Sequence[Named]]) -> Equation:
    value = np.block([[np.asarray(one.value, dtype=object) for one in row] for row in rows])
    return Equation(left, value, grid=tuple(tuple(one.name for one in row) for row in rows))


class _Order(NamedTuple):
    """The recursive order formulation: its parts, laws, and what it finds for M and the forces of the bodies alone."""

    parts: list[Part]
    laws: list[str]
    M: Array
    tau: Array


def _order_formulation(bodies: list[_Body], model: Model, sample: Sample) -> _Order:
    """Stack the recursions of all bodies, each in its own axes."""
    N, n = len(bodies), model.n
    place = {id(body): k for k, body in enumerate(bodies)}
    Gamma, B = (np.zeros((6 * N, 6 * N), dtype=object) for _ in range(2))
    h, z, b = np.zeros((6 * N, n), dtype=object), np.zeros(6 * N, dtype=object), np.zeros(6 * N, dtype=object)
    parts, names, reach = [], [["0"] * N for _ in range(N)], [["0"] * N for _ in range(N)]
    nothing, unit = Named("0", np.zeros((3, 3))), Named("1", np.eye(3))
    for k, body in enumerate(bodies):
        own, equations, parent = slice(6 * k, 6 * k + 6), [], body.parent
        other = place.get(id(parent))
        if other is not None:
            rows = [[body.R.T, nothing], [-times(body.R.T, tilde(body.p)), body.R.T]]
            equations.append(_blocks(body.name("A"), rows))
            Gamma[own, 6 * other : 6 * other + 6], names[k][other] = equations[0].total, body.name("A")
            reach[k] = ["0" if x == "0" else f"{body.name('A')} {x}".removesuffix(" 1") for x in reach[other]]
        reach[k][k] = "1"
        if parent is None:
            h[own, :6], z[own] = np.eye(6), [*ZERO, *-body.g.value]
        else:
            joint = model.bodies[int(body.label)].joint
            axis = np.array([*body.e.value, *ZERO] if body.turns else [*ZERO, *body.e.value], dtype=object)
            equations.append(Equation(body.name("h"), axis))
            h[own, joint.rate] = axis * float(joint.multiplier)
            turning = across(times(body.R.T, parent.w), times(body.e, body.qd)).value
            carried = times(body.R.T, across(parent.w, across(parent.w, body.p))).value
            up = -body.g.value if other is None else ZERO
            z[own] = [*turning, *(carried + up)] if body.turns else [*ZERO, *(carried + up + 2.0 * turning)]
        first = times(body.m, tilde(body.r))
        about = body.I - times(first, tilde(body.r))
        equations.append(_blocks(body.name("B"), [[about, first], [-first, times(body.m, unit)]]))
        B[own, own] = equations[-1].total
        spin = times(about, body.w)
        b[own] = [*across(body.w, spin).value, *across(body.w, across(body.w, times(body.m, body.r))).value]
        parts.append(Part(body.title, [*equations, Equation(body.name("z"), z[own]), Equation(body.name("b"), b[own])]))
    G, H, mass, drift, bias = (Named(*x) for x in (("Gamma", Gamma), ("h", h), ("B", B), ("z", z), ("b", b)))
    qd, qdd = (Named(name, np.array(getattr(sample, name), dtype=object)) for name in ("qd", "qdd"))
    inverse = _inverse(Named("1", np.eye(6 * N)) - G)
    Phi = Named("Phi", inverse.value)
    V, Vd = times(Phi, H, qd), times(Phi, times(H, qdd) + drift)
    W = times(mass, Named("Vd", Vd.value)) + bias
    tau, M = times(H.T, Phi.T, Named("W", W.value)), times(H.T, Phi.T, mass, Phi, H)
    grids = (("Gamma", names), ("Phi", reach))
    parts.append(Part("All bodies", [Equation(left, grid=tuple(map(tuple, grid))) for left, grid in grids]))
    J = times(Phi, H)
    each = [Equation(body.name("J"), J.value[6 * k : 6 * k + 6]) for k, body in enumerate(bodies)]
    parts.append(Part(f"The rows of J = {J.name} of each body: its Jacobian", each))
    said = (("Phi", inverse), ("V", V), ("Vd", Vd), ("W", W), ("tau", tau), ("M", M))
    return _Order(parts, [f"{left} = {right.name}" for left, right in said], M.value, tau.value)


def derive(
    model: Model,
    scene: Scene = DEFAULT,
    at: Values | None = None,
    qd: Values | None = None,
    qdd: Values | None = None,
    kinds: Sequence[str] = (),
    positive: Iterable[str] = (),
) -> Derivation:
    """Return the worked solution: as formulas, or in numbers where at, qd or qdd is given (what is not is zero).

    Args:
        at, qd, qdd: of the joints, in order or by name [rad or m, per s, per s^2]. A base that moves stands upright at
            rest, and accelerates as its six equations demand.
        kinds: of numbers that become letters, of `letters.KINDS`. positive: names of symbols that are.

    Raises:
        InputError: there are no equations, or too many coordinates for formulas; SceneError: the scene has loops,
            contacts or effects that are no part of this solution.

    Accuracy: in numbers, what is said to agree does so within 1e-12 of the largest; in formulas it does so exactly.
    """
    if scene.loops:
        what = "the scene closes loops, whose reactions no elimination from the tips finds"
        raise SceneError(what, remedy="robodyn equations --form dae")
    check_equations(model, scene)
    known = {*OF_BODIES, *AT_JOINTS}
    for effect in Plan(model, scene).effects:
        if effect.name not in known:
            what = f"the scene has effects that are no part of this solution: {effect.name}"
            raise SceneError(what, remedy="leave them out; robodyn equations knows them")
    numbers = not (at is None and qd is None and qdd is None)
    joints = model.n - 6 if model.floating else model.n
    if joints > MOST_JOINTS and not numbers:
        what = f"{joints} joints are too many for formulas, which go up to {MOST_JOINTS}"
        raise InputError(what, remedy="--at gives the solution in numbers", file=model.file)
    model, scene = _with_payloads(model, scene)
    lettered = Lettered(model, scene, kinds, positive)
    state = _state(model, scene, *(() if x is None else x for x in (at, qd, qdd))) if numbers else None
    agreed, written_out = _agreement(lettered, state), True
    try:
        steps = _written(lettered, state, agreed, written_out)
    except TooLargeError:
        written_out = False
        steps = _written(lettered, state, agreed, written_out)
    rows = []
    for k, (kind, meaning) in enumerate((("q", "coordinate"), ("qd", "velocity"), ("qdd", "acceleration"))):
        for (source, i), symbol in lettered.symbols.items():
            if source == kind:
                of = model.coordinates[i] if kind == "q" else model.rates[i]
                rows.append((symbol.name, "" if state is None else f"{state[k][i]:.6g}", f"{meaning} of {of}"))
    letters = tuple(letter for letter in lettered.letters if not (numbers and letter.kind == "g"))
    return Derivation(model.name, scene.gravity, letters, tuple(rows), numbers, written_out, steps)


def _with_payloads(model: Model, scene: Scene) -> tuple[Model, Scene]:
    """Return the model with the masses of the scene's payloads in its bodies, and the scene without them."""
    payload = [effect for effect in Plan(model, scene).effects if effect.name == "payload"]
    still = (0.0,) * model.n
    inertias = applied(payload, Sample(model, (0.0,) * model.nq, still, still), scene).inertias
    bodies = tuple(replace(body, inertia=inertia) for body, inertia in zip(model.bodies, inertias, strict=True))
    return (replace(model, bodies=bodies), replace(scene, payloads=())) if payload else (model, scene)


State = tuple[Floats, Floats, Floats]


def _state(model: Model, scene: Scene, at: Values, qd: Values, qdd: Values) -> State:
    """Return q, qd and qdd, of a base that moves those that no force on it demands."""
    q, speeds, accelerations = configuration(model, at), rates(model, qd), rates(model, qdd)
    if model.floating:
        M = mass_matrix(model, q, scene=scene, executor="numpy")
        rest = bias_forces(model, q, speeds, scene=scene, executor="numpy")[:6] + M[:6, 6:] @ accelerations[6:]
        moments = np.abs(eigen(M[:6, :6])[0])
        if moments.min() <= 6 * np.finfo(float).eps * moments.max():
            what = "the acceleration of the base is open: about some axis the robot has no inertia"
            raise InputError(what, remedy="formulas, without --at, need none", file=model.file)
        accelerations[:6] = -np.linalg.solve(M[:6, :6], rest)
    return q, speeds, accelerations


class _Pieces(NamedTuple):
    sample: Sample
    solved: _Traced
    collected: _Collected
    order: _Order


def _pieces(lettered: Lettered, state: State | None, tape: Tape, known: list[str] | None, names: list[str]) -> _Pieces:
    sample, gravity = lettered.sample(tape), lettered.gravity(tape)
    if state is not None:
        gravity = np.array(lettered.plan.scene.gravity, dtype=object)
        q, qd, qdd = (tuple(part.tolist()) for part in state)
        sample = replace(sample, q=q, qd=qd, qdd=qdd)
    solved = _solution(lettered, gravity, sample, tape, known, names)
    collected = _collected(lettered, gravity, sample)
    return _Pieces(sample, solved, collected, _order_formulation(solved.bodies, sample.model, sample))


def _written(lettered: Lettered, state: State | None, agreed: Sequence[str], written_out: bool) -> tuple[Step, ...]:
    """Return all steps in SymPy expressions; TooLargeError where they are to be written out and are too long."""
    known: list[str] | None = None if written_out else []
    names: list[str] = []
    found: list[Step] = []

    def outputs(tape: Tape) -> Iterator[Scalar]:
        sample, solved, collected, order = _pieces(lettered, state, tape, known, names)
        found.extend([*solved.steps, _ode(collected, sample.model, state is not None, agreed[0])])
        place = len(found)
        last = f"Its tau and the drives of step {place - 1} {agreed[1]}; its M and that of step {place} {agreed[2]}."
        title = "The recursive order formulation"
        found.append(Step(title, [_words("order")], order.laws, [*order.parts, Part("Check", (), last)]))
        for equation in _equations(found) if state is not None else ():
            _settle(equation)
        for array in _values(_equations(found), lambda value: value):
            yield from np.asarray(array, dtype=object).ravel()

    program, symbol = trace(outputs), module().Symbol
    lettered.symbols |= {(KNOWN, k): symbol(name, real=True) for k, name in enumerate(known or ())}
    lettered.symbols |= {(REACTIONS, k): symbol(name, real=True) for k, name in enumerate(names)}
    distinct = lettered.written(program.distinct, longest=LONGEST if written_out else np.inf)
    entries = iter([distinct[k] for k in program.homes])

    def written(array: Any) -> Any:
        out = np.empty(np.shape(array), dtype=object)
        for index in np.ndindex(out.shape):
            out[index] = next(entries)
        return out if out.shape else out.item()

    for _ in _values(_equations(found), written):
        pass
    return tuple(found)


def _equations(steps: Iterable[Step]) -> Iterator[Equation]:
    return (equation for step in steps for part in step.parts for equation in part.equations)


def _settle(equation: Equation) -> None:
    """Put zeros in place of numbers that rounding leaves of them."""
    found = [*(term.value for term in equation.terms), equation.total, equation.value]
    sizes = [abs(x) for array in found for x in np.ravel(np.asarray(array, dtype=object)) if isinstance(x, float)]
    least = NOISE * max(sizes, default=0.0)
    for _ in _values(
        [equation], np.vectorize(lambda x: 0.0 if isinstance(x, float) and abs(x) <= least else x, [object])
    ):
        pass


def _values(equations: Iterable[Equation], change: Callable[[Any], Any]) -> Iterator[Any]:
    """Put what `change` makes of them in place of all values, in their order, and yield them."""
    for equation in equations:
        equation.terms = [replace(term, value=change(term.value)) for term in equation.terms]
        equation.total, equation.value = (None if x is None else change(x) for x in (equation.total, equation.value))
        yield from (term.value for term in equation.terms)
        yield from (x for x in (equation.total, equation.value) if x is not None)


def _agreement(lettered: Lettered, state: State | None) -> list[str]:
    """Return in words how M qdd + bias less tau, and tau and M of the order formulation less these, come out: as
    formulas, else in numbers."""
    n = lettered.plan.model.n

    def outputs(tape: Tape) -> Iterator[Scalar]:
        sample, solved, collected, order = _pieces(lettered, state, tape, None, [])
        for i in range(n):
            shares = [
                *(collected.M[i, k] * sample.qdd[k] for k in range(n)),
                *(x[i] for x in collected.shares.values()),
            ]
            yield solved.tau[i] - total(shares)
        yield from (order.tau[i] - solved.alone[i] for i in range(n))
        yield from (order.M - collected.alone).ravel()
        yield from (*solved.tau, *collected.M.ravel())

    program, ends = trace(outputs), np.cumsum((0, n, n, n * n, n, n * n)).tolist()
    if state is None:
        with suppress(TooLargeError):
            forms = Forms(lettered.symbols, COMPARED).outputs(replace(program, outputs=program.outputs[: ends[3]]))
            if not any(forms):
                return ["are the same: every difference vanishes, term by term"] * 3
    values = np.array([letter.value for letter in lettered.letters])
    widths = {"q": lettered.plan.model.nq, "qd": n, "qdd": n, LETTERS: len(values)}
    states = {source: np.random.default_rng(0).uniform(-2.0, 2.0, (STATES, k)) for source, k in widths.items()}
    states[LETTERS] = np.tile(values, (STATES, 1))
    out = NumpyBlocks(program, widths)(states, STATES)
    sizes = [float(np.abs(out[:, a:b]).max(initial=0.0)) for a, b in pairwise(ends)]
    off = [x / (scale or 1.0) for x, scale in zip(sizes[:3], (sizes[3], sizes[3], sizes[4]), strict=True)]
    where = f" at {STATES} random states" if state is None else ""
    return [f"differ{where} by {'less than 1e-12' if x <= 1e-12 else f'{x:.0e}'} of the largest" for x in off]
