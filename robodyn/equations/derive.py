"""The worked solution of a robot's dynamics, step by step from its frames to the equations of motion.

Each line is written once, of quantities that have a name and a value: products and sums make both, so that what a
formula says and what stands behind it cannot differ. Run on bodies named i, j and k the same lines are the general
laws; on the robot's bodies, with traced scalars, they are its equations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
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
from robodyn.programs.program import trace
from robodyn.programs.run.numpy_blocks import NumpyBlocks
from robodyn.programs.scalar import Tape
from robodyn.programs.vectors import ZERO, Array, Scalar, cross, frame, skew, total
from robodyn.robot.kinematics import Values, configuration, rates
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.linear import eigen
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
AT_JOINTS = {"viscous friction": "D", "coulomb friction": "K", "joint spring": "S", "rotor inertia": "N"}
"""Effects that act along joints, and the letters of their terms."""
SHARES = {"gravity": "G", "coriolis": "C", **AT_JOINTS}
EFFECTS = {*SHARES, "inertia", "moving base", "mimic", "payload"}


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


def joined(terms: Iterable[Named]) -> str:
    return " + ".join(term.name for term in terms).replace("+ -", "- ") or "0"


@dataclass(eq=False)
class Equation:
    """A line worked out: left = sum of terms = total.

    Attributes:
        total: a scalar, a vector or a matrix of SymPy expressions, traced scalars at first; as are the values of terms.
        value: of the left side, where an earlier line has it: what the sum is to be equal to. number: of the first of
            these component equations.
        grid: names of blocks, in place of terms.
    """

    left: str
    total: Any = None
    terms: list[Named] = field(default_factory=list)
    value: Any = None
    number: int = 0
    grid: Sequence[Sequence[str]] = ()

    def change(self, function: Callable[[Any], Any]) -> None:
        """Put what a function makes of them in place of all values, in their order."""
        self.terms = [replace(term, value=function(term.value)) for term in self.terms]
        self.total, self.value = (None if x is None else function(x) for x in (self.total, self.value))


class Part(NamedTuple):
    """The equations of a body, or of what the title says; words stand before them."""

    title: str
    equations: Sequence[Equation] = ()
    words: str = ""


class Step(NamedTuple):
    """words: what is done, and why. laws: in general, of body i on body j, which carries bodies k. counts: a table."""

    title: str
    parts: Sequence[Part] = ()
    laws: Sequence[str] = ()
    words: Sequence[str] = ()
    counts: Sequence[Sequence[str]] = ()


@dataclass(frozen=True, eq=False)
class Derivation:
    """A worked solution.

    Attributes:
        letters: with their values. known: (name, value or "", meaning) of coordinates, velocities and accelerations.
        written_out: whether every line is in the coordinates, and not in components that earlier lines define.
        steps: each with words, general laws, and parts of equations: left, terms by name and value, total.
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
    """A body with what is known of it, by letters of which the names end in its number; lines add what they find.

    Attributes:
        held, driven: names of the unknown reactions, and of what acts along its joint.
    """

    label: str
    joint: Joint | None = None
    title: str = ""
    parent: _Body | None = None
    children: list[_Body] = field(default_factory=list)
    turns: bool = True
    slides: bool = True
    known: dict[str, Named] = field(default_factory=dict)
    held: list[str] = field(default_factory=list)
    driven: list[str] = field(default_factory=list)

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

    def where(self, **values: Any) -> _Body:
        """The same body with other values."""
        other = replace(self, known=dict(self.known))
        other.give(**values)
        return other

    def find(self, rules: Rules, letters: Iterable[str], j: _Body) -> list[Array]:
        """Give this body what rules find on body j, and return it."""
        for letter in letters:
            self.give(**{letter: total(term.value for term in rules[letter](self, j))})
        return [self.known[letter].value for letter in letters]


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
DRIVES: Rules = {"tau": lambda b, j: [times(b.e.T, b.M if b.turns else b.F)]}
VECTORS = ("w", "v", "wd", "a", "v_c", "a_c", "p", "r", "e", "P", "H", "Pd", "Hd", "g", "F", "M")


def laws(rules: Rules, turns: bool = True) -> list[str]:
    """Return rules as general laws of the body i on the body j, which carries bodies k; its joint turns and slides."""
    i, j, k = (_Body(label, turns=turns) for label in "ijk")
    for body in (i, j, k):
        body.give(**dict.fromkeys(VECTORS, ZERO), R=np.eye(3), I=np.eye(3), m=0.0, qd=0.0, qdd=0.0)
    i.parent, i.children = j, [k]
    return [f"{i.name(left)} = {joined(rule(i, j))}" for left, rule in rules.items()]


def _bodies(lettered: Lettered, gravity: Array, sample: Sample, tape: Tape) -> tuple[_Body, list[_Body]]:
    """Return the ground, in the axes of a base that is held, and the bodies that move, with what is given of them."""
    model, motions = sample.model, sample.motions()
    ground = _Body("0")
    every: list[_Body] = []
    for i, (body, motion) in enumerate(zip(model.bodies, motions, strict=True)):
        joint, (m, r, I) = body.joint, lettered.mass_properties(i, tape)
        if i == 0:
            one = _Body("0", joint, f"Body 0, {body.name}, free to move") if model.floating else ground
            g = gravity if model.floating else motion.R.T @ gravity
            one.give(w=motion.w, v=motion.v, wd=motion.wd, a=motion.a, g=g, F=ZERO, M=ZERO, m=m, r=r, I=I)
        else:
            parent, turns = every[body.parent], joint.kind == "revolute"
            moves = f"{'turns' if turns else 'slides'} on body {body.parent}, {model.bodies[body.parent].name}"
            title = f"Body {i}, {body.name}: its joint {joint.name} {moves}"
            one = _Body(str(i), joint, title, parent, [], turns, not turns)
            parent.children.append(one)
            one.give(m=m, r=r, I=I, R=_without_noise(motion.R, NOISE), p=motion.p, e=joint.axis)
            one.give(q=sample.position(joint), qd=sample.speed(joint), qdd=sample.acceleration(joint))
        every.append(one)
    return ground, every if model.floating else every[1:]


def _without_noise(values: Any, least: float) -> Any:
    """Return an array, or a scalar, with zeros for numbers that are not larger than `least`."""
    return np.vectorize(lambda x: 0.0 if isinstance(x, float) and abs(x) <= least else x, [object])(values)


def _unknowns(body: _Body, acting: bool) -> list[tuple[str, str, Floats]]:
    """Return the reactions at a joint, and last what acts along it, Q where friction, springs or rotors do beside the
    drive: names, each with F or M, which it is a component of, and its direction."""
    axis = np.asarray(body.e.value, dtype=float)
    held, last = dict(zip(AXES, np.eye(3), strict=True)), AXES[int(np.abs(axis).argmax())]
    if np.abs(axis).max() != 1.0:
        held, last = dict(zip("12a", frame(axis), strict=True)), "a"
    along = "M" if body.turns else "F"
    places = [(letter, direction) for letter in "FM" for direction in held]
    places.remove((along, last))
    reactions = [(body.name(letter) + direction, letter, held[direction]) for letter, direction in places]
    return [*reactions, (body.name("Q" if acting else "tau"), along, axis)]


WORDS = """\
Frames, coordinates and what is known: Body i has its axes at its joint. In the axes of the body before it, p is the way
from that body's origin to its own; R turns components in its own axes into those. In its own axes, e is the joint's
axis, r the way from the origin to the mass centre, I the inertia matrix about it; m is the mass. All vectors of a body
are written in its own axes.

Velocities, from the base outwards: A body has the velocities of the body that carries it, turned into its own axes, and
what its joint adds: e qd to w where it turns, to v where it slides. v_c is the velocity of the mass centre.

Accelerations, from the base outwards: The same once more: wd and a are the accelerations of the body and of its origin,
seen from the ground. The axis of a joint turns with the body before it: hence the cross products with qd.

Momenta and their rates: P is the linear momentum, H the angular momentum about the mass centre; Pd and Hd are their
rates, seen from the ground. In axes that turn with w components of H change besides: hence w x H.

Free bodies: Each joint is cut. The body before exerts on the body the force F at the joint and the moment M about its
origin. A joint of f degrees of freedom holds 6 - f components, the unknown reactions; along its freedom acts the drive.
Gravity is turned outwards as velocities are.

Euler's laws of each body: Euler's first law: the momentum changes by the sum of the forces. Euler's second law: the
angular momentum about the mass centre changes by the sum of the moments about it. The unknown reactions stand in them.

The differential-algebraic equations: The laws of all bodies are a system of differential and algebraic equations (DAE).
Its differential unknowns are the coordinates, of which second derivatives stand in it. Its algebraic unknowns are the
reactions, of which no derivative does. Where the motion of the joints is given it is linear and algebraic; where the
drives are given, the accelerations are unknown in their place.

Elimination, from the tips to the base: A body at a tip carries nothing: its laws hold no reactions but those of its own
joint, and are solved for them. They are then known in the laws of the body before, and so on to the base.

The drives: What a drive has to give is the component of the reaction along the axis: of M where the joint turns, of F
where it slides.

The ordinary differential equations: Sorted by accelerations, the drives give M qdd and a bias, which is what is left
where nothing accelerates.

The recursive order formulation: The recursions of all bodies are one equation of stacked vectors: twists V_i = (w_i,
v_i) and wrenches W_i = (M_i, F_i) about the origins. A_i takes the twist of the body before to body i, h_i is the
direction of the joint, B_i has inertia about the origin and mass; z_i and b_i are what velocities alone make, and
gravity is in z, as an acceleration of the ground upwards. Gamma has A_i in the row of body i and the column of the body
before it, so that products alone invert 1 - Gamma: Phi."""
"""What is done in each step, and why, by its title."""


State = tuple[Floats, Floats, Floats]


class _Solution:
    """The steps, worked out on one tape.

    Attributes:
        known: names of the components that later lines take for known, to be filled; None writes all out.
        reactions: names of the unknown reactions.
        compared: pairs of arrays that are to be equal: the drives and M qdd + bias; generalized forces without what
            acts along joints, and M, each as the order formulation has them and as the steps before.
    """

    def __init__(self, lettered: Lettered, state: State | None, tape: Tape, known: list[str] | None) -> None:
        self.lettered, self.tape, self.known, self.numbers = lettered, tape, known, state is not None
        self.sample, self.gravity, self.scene = lettered.sample(tape), lettered.gravity(tape), lettered.plan.scene
        if state is not None:
            self.gravity = np.array(self.scene.gravity, dtype=object)
            q, qd, qdd = (tuple(part.tolist()) for part in state)
            self.sample = replace(self.sample, q=q, qd=qd, qdd=qdd)
        self.model, self.effects = self.sample.model, Plan(lettered.plan.model, self.scene).effects
        self.ground, self.bodies = _bodies(lettered, self.gravity, self.sample, tape)
        still = at_rest(self.sample)
        beside = [effect for effect in self.effects if effect.name in AT_JOINTS]
        self.beside = {effect.name: effect.add(still, self.sample, self.scene).at_joint for effect in beside}
        self.reactions: list[str] = []
        self.compared: list[tuple[Any, Any]] = []
        self.steps: list[Step] = []
        self._frames()
        self._recursion("Velocities, from the base outwards", VELOCITIES)
        self._recursion("Accelerations, from the base outwards", ACCELERATIONS)
        self._recursion("Momenta and their rates", MOMENTA)
        self._free_bodies()
        self._add(Step("Euler's laws of each body", self._worked_out(self.bodies, LAWS, find=False), laws(LAWS)))
        self._system()
        self.bodies.reverse()
        self._recursion("Elimination, from the tips to the base", ELIMINATION)
        self.bodies.reverse()
        self._drives()
        self._ode()
        self._order_formulation()

    def _add(self, step: Step) -> None:
        """Add a step, with what is said of every robot before its words."""
        words = dict(text.split(": ", 1) for text in WORDS.split("\n\n"))
        self.steps.append(step._replace(words=[" ".join(words[step.title].split()), *step.words]))

    def _recursion(self, title: str, rules: Rules) -> None:
        self._add(Step(title, self._worked_out(self.bodies, rules), laws(rules)))

    def _frames(self) -> None:
        parts = [] if self.model.floating else [Part("Ground", [Equation("g_0", self.ground.g.value)])]
        for body in self.bodies:
            follows = body.joint is not None and body.joint.mimics is not None
            letters = [*("q" * follows), *("" if body.free else "Rpe"), *"mrI"]
            parts.append(Part(body.title, [Equation(body.name(x), body.known[x].value) for x in letters]))
        self._add(Step("Frames, coordinates and what is known", parts))

    def _worked_out(self, bodies: Iterable[_Body], rules: Rules, find: bool = True) -> list[Part]:
        """Apply rules to bodies in their order, which finds what stands on the left, or with find=False is a law that
        holds for what does."""
        parts, number = [], 1
        for body in bodies:
            equations = []
            for letter, rule in rules.items():
                left = body.name(letter)
                if body.free and letter in ("w", "v", "wd", "a", "g"):
                    equations.append(Equation(left, body.known[letter].value))
                    continue
                terms = rule(body, body.parent or body)
                equation = Equation(left, total(term.value for term in terms), terms)
                if find:
                    body.known[letter] = Named(left, self._named(left, equation.total))
                else:
                    equation.value, equation.number, number = body.known[letter].value, number, number + 3
                equations.append(equation)
            parts.append(Part(body.title, equations))
        return parts

    def _named(self, left: str, value: Array) -> Array:
        """Return what later lines take for the value of a vector."""
        if self.known is None:
            return value
        out = np.array(value, dtype=object)
        for k, x in enumerate(value):
            if not isinstance(x, float):
                self.known.append(left + AXES[k])
                out[k] = self.tape.input(KNOWN, len(self.known) - 1)
        return out

    def _free_bodies(self) -> None:
        """Put unknowns in place of the reactions."""
        acting = {i for torques in self.beside.values() for i in torques}
        parts, rows = [], [("body", "f", "6 - f", "unknown reactions", "along the joint")]
        for body, (title, found, _) in zip(self.bodies, self._worked_out(self.bodies, GRAVITY), strict=True):
            equations, felt = list(found), [f"the weight {times(body.m, body.g).name} at the mass centre"]
            if not body.free:
                values = {"F": np.zeros(3, dtype=object), "M": np.zeros(3, dtype=object)}
                for name, letter, unit in _unknowns(body, int(body.label) in acting):
                    self.reactions.append(name)
                    unknown = self.tape.input(REACTIONS, len(self.reactions) - 1)
                    values[letter] = values[letter] + np.array([float(x) * unknown for x in unit], dtype=object)
                    body.held.append(name)
                body.driven = [body.held.pop()]
                body.give(**values)
                equations += [Equation(body.F.name, body.F.value), Equation(body.M.name, body.M.value)]
                felt.append(f"{body.F.name} and {body.M.name} at its joint")
            felt += [f"-F_{k.label} and -M_{k.label} of body {k.label} at p_{k.label}" for k in body.children]
            parts.append(Part(title, equations, f"On it act {', '.join(felt)}."))
            freedom, along = ("6", "-") if body.free else ("1", *body.driven)
            rows.append((body.label, freedom, str(len(body.held)), ", ".join(body.held) or "-", along))
        held = sum(len(body.held) for body in self.bodies)
        rows.append(("together", str(self.model.n), str(held), "", ""))
        self._add(Step("Free bodies", parts, laws(GRAVITY), counts=rows))

    def _system(self) -> None:
        """Count equations and unknowns of the laws of all bodies."""
        n, joints = len(self.bodies), sum(len(body.driven) for body in self.bodies)
        rows, unknowns = [("laws of body", "equations", "unknowns in them")], []
        for body in self.bodies:
            names = [self.lettered.symbols["qdd", i].name for i in range(6)] if body.free else []
            names += [name for one in (body, *body.children) for name in (*one.held, *one.driven)]
            rows.append((body.label, "6", ", ".join(names)))
        unknowns = [f"{5 * joints} reactions", f"{joints} along joints"] if joints else []
        unknowns += ["6 accelerations of the base"] if self.model.floating else []
        rows.append(("together", str(6 * n), ", ".join(unknowns)))
        equations = f"6 x {count(n, 'body', 'bodies')} = {6 * n} equations for {' + '.join(unknowns)}"
        words = [
            f"There are {count(self.model.n, 'coordinate')} and, where the motion of the joints is given, {equations}."
        ]
        if followers := sum(body.joint.mimics is not None for body in self.model.bodies):
            words.append(
                f"{count(followers, 'joint')} that follow others: what acts along them is the force of the coupling, "
                "which the drive of the joint that leads has to give."
            )
        self._add(Step("The differential-algebraic equations", (), (), words, rows))

    def _drives(self) -> None:
        """Find tau, the generalized forces by rate, and the part of each effect that acts along joints."""
        self.tau = np.zeros(self.model.n, dtype=object)
        self.parts = {effect: np.zeros(self.model.n, dtype=object) for effect in self.beside}
        equations: dict[int, Equation] = {}
        for body in self.bodies:
            joint = body.joint
            if body.parent is None or joint is None:
                self.tau[:6] = [*body.M.value, *body.F.value]
                continue
            i, rate = int(body.label), joint.rate
            own = [(effect, torques[i]) for effect, torques in self.beside.items() if i in torques]
            terms = DRIVES["tau"](body, body.parent)
            terms += [Named(body.name(AT_JOINTS[effect]), torque, word=effect) for effect, torque in own]
            if joint.mimics is not None:
                ratio = Named(f"{joint.multiplier:g}", float(joint.multiplier))
                terms = [replace(times(ratio, term), word=term.word) for term in terms]
            for term in terms:
                self.tau[rate] = self.tau[rate] + term.value
                if term.word:
                    self.parts[term.word][rate] = self.parts[term.word][rate] + term.value
            leader = self.lettered.symbols["qdd", rate].name.replace("qdd", "tau")
            equations.setdefault(rate, Equation(leader)).terms.extend(terms)
            equations[rate].total = self.tau[rate]
        general = [f"{law} | where it turns" for law in laws(DRIVES)]
        general += [f"{law} | where it slides" for law in laws(DRIVES, turns=False)]
        base = "Nothing holds the base: F_0 and M_0 vanish. These are the six equations of its motion."
        found = [equations[rate] for rate in sorted(equations)]
        self._add(Step("The drives", [Part("", found)], general, [base] * self.model.floating))

    def _mass(self, effects: Sequence[Effect]) -> Named:
        """M of effects: the forces for one unit acceleration at a time."""
        still = replace(self.sample, qd=(0.0,) * self.model.n)
        moving = [replace(still, qdd=tuple(unit)) for unit in np.eye(self.model.n).tolist()]
        columns = [loads(sample, applied(effects, sample, self.scene)).tau for sample in moving]
        return Named("M", np.array(columns, dtype=object).T)

    def _ode(self) -> None:
        """Sort the drives by accelerations, by the recursion with one effect at a time."""
        n = self.model.n
        gap = "," if n > 9 else ""
        self.accelerating = [effect for effect in self.effects if effect not in self.lettered.plan.effects]
        still, M = replace(self.sample, qdd=(0.0,) * n), self._mass(self.accelerating)
        qdd = Named("qdd", np.array(self.sample.qdd, dtype=object))
        entries = [Equation(f"M_{i + 1}{gap}{k + 1}", M.value[i, k]) for i in range(n) for k in range(i, n)]
        parts = [Part("Mass matrix M, symmetric", [Equation("M", M.value)] if self.numbers else entries)]
        terms = [times(M, qdd)]
        for effect in self.lettered.plan.effects:
            if effect.name in SHARES:
                share = effect.add(effect.background(at_rest(still), still, self.scene), still, self.scene)
                share = replace(share, gravity=self.gravity) if share.gravity.any() else share
                one = Named(SHARES[effect.name], np.array(loads(still, share).tau, dtype=object))
                entries = [Equation(f"{one.name}_{i + 1}", x) for i, x in enumerate(one.value)]
                parts.append(
                    Part(effect.name.capitalize(), [Equation(one.name, one.value)] if self.numbers else entries)
                )
                terms.append(one)
        self.compared.append((total(term.value for term in terms), self.tau))
        base = "Rows 1 to 3 are the components of M_0, rows 4 to 6 those of F_0; on the right they are zero."
        law = f"{joined(terms)} = tau"
        self._add(Step("The ordinary differential equations", parts, [law], [base] * self.model.floating))

    def _order_formulation(self) -> None:
        """Stack the recursions of all bodies, each in its own axes."""
        N, n = 6 * len(self.bodies), self.model.n
        Gamma, h, B = (Named(x, np.zeros((N, m), dtype=object)) for x, m in (("Gamma", N), ("h", n), ("B", N)))
        z, b = (Named(x, np.zeros(N, dtype=object)) for x in "zb")
        parts, own = [], [slice(k, k + 6) for k in range(0, N, 6)]
        for i, body in zip(own, self.bodies, strict=True):
            equations, parent, joint = [], body.parent, body.joint
            if parent in self.bodies:
                rows = [[body.R.T, Named("0", np.zeros((3, 3)))], [-times(body.R.T, tilde(body.p)), body.R.T]]
                equations.append(_blocks(body.name("A"), rows))
                Gamma.value[i, own[self.bodies.index(parent)]] = equations[0].total
            if parent is None or joint is None:
                h.value[i, :6], z.value[i] = np.eye(6), [*ZERO, *-body.g.value]
            else:
                axis = np.array([*body.e.value, *ZERO] if body.turns else [*ZERO, *body.e.value], dtype=object)
                equations.append(Equation(body.name("h"), axis))
                h.value[i, joint.rate] = axis * float(joint.multiplier)
                before = parent.where(wd=ZERO, a=ZERO if parent in self.bodies else -parent.g.value)
                z.value[i] = np.concatenate(body.where(qdd=0.0).find(ACCELERATIONS, ("wd", "a"), before))
            first = times(body.m, tilde(body.r))
            rows = [[body.I - times(first, tilde(body.r)), first], [-first, times(body.m, Named("1", np.eye(3)))]]
            equations.append(_blocks(body.name("B"), rows))
            B.value[i, i] = equations[-1].total
            alone = replace(body.where(wd=ZERO, a=ZERO, g=ZERO), children=[])
            *_, F, M = alone.find({**ACCELERATIONS, **MOMENTA, **ELIMINATION}, ("a_c", "Pd", "Hd", "F", "M"), alone)
            b.value[i] = [*M, *F]
            equations += [Equation(body.name(x.name), x.value[i]) for x in (z, b)]
            parts.append(Part(body.title, equations))
        parts.append(Part("All bodies", _grids(self.bodies)))
        general: list[str] = []

        def law(left: str, right: Named) -> Named:
            general.append(f"{left} = {right.name}")
            return Named(left, right.value)

        qd, qdd = (Named(name, np.array(getattr(self.sample, name), dtype=object)) for name in ("qd", "qdd"))
        Phi = law("Phi", _inverse(Named("1", np.eye(N)) - Gamma))
        law("V", times(Phi, h, qd))
        Vd = law("Vd", times(Phi, times(h, qdd) + z))
        W = law("W", times(B, Vd) + b)
        forces = [Named("tau", self.tau), *(-Named(AT_JOINTS[effect], part) for effect, part in self.parts.items())]
        rotors = "rotor inertia" in self.parts
        more = ["What acts along joints beside is no part of it, and taken off tau."] * bool(self.parts)
        more += ["M_N is the share of M that rotors have."] * rotors
        tau = law(joined(forces), times(h.T, Phi.T, W))
        M_of_bodies = law("M - M_N" if rotors else "M", times(h.T, Phi.T, B, Phi, h))
        bodies_alone = self._mass([effect for effect in self.accelerating if effect.name not in AT_JOINTS])
        self.compared += [(tau.value, total(x.value for x in forces)), (M_of_bodies.value, bodies_alone.value)]
        J = times(Phi, h)
        rows_of_J = [Equation(body.name("J"), J.value[i]) for i, body in zip(own, self.bodies, strict=True)]
        parts.append(Part(f"The rows of J = {J.name} of each body: its Jacobian", rows_of_J))
        self._add(Step("The recursive order formulation", parts, general, more))


def _grids(bodies: Sequence[_Body]) -> list[Equation]:
    """Gamma and Phi by names of their blocks: on the way to a body each that is passed stands in a product."""
    Gamma, Phi = ([["0"] * len(bodies) for _ in bodies] for _ in range(2))
    for k, body in enumerate(bodies):
        if body.parent in bodies:
            j, A = bodies.index(body.parent), body.name("A")
            Gamma[k][j], Phi[k] = A, ["0" if x == "0" else f"{A} {x}".removesuffix(" 1") for x in Phi[j]]
        Phi[k][k] = "1"
    return [Equation("Gamma", grid=Gamma), Equation("Phi", grid=Phi)]


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
    return Equation(left, value, grid=[[one.name for one in row] for row in rows])


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

    All values are SymPy expressions: `derive(model).steps[8].parts[0].equations[0].total` is the torque of the first
    drive, whose `terms` have a name and a value each.

    Args:
        at, qd, qdd: of the joints, in order or by name [rad or m, per s, per s^2]. A base that moves stands upright at
            rest, and accelerates as its six equations demand.
        kinds: of numbers that become letters: m, l, c, I, g. positive: names of letters that SymPy takes to be.

    Raises:
        InputError: there are no equations, or too many coordinates for formulas; SceneError: the scene has loops,
            contacts or effects that are no part of this solution.

    Accuracy: in numbers, what is said to agree does so within 1e-12 of the largest; in formulas it does so exactly.
    """
    if scene.loops:
        what = "the scene closes loops, whose reactions no elimination from the tips finds"
        raise SceneError(what, remedy="robodyn equations --form dae")
    check_equations(model, scene)
    for effect in Plan(model, scene).effects:
        if effect.name not in EFFECTS:
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
    agreed = _agreement(lettered, state)
    try:
        written_out, steps = True, _written(lettered, state, None)
    except TooLargeError:
        written_out, steps = False, _written(lettered, state, [])
    *others, ode, order = steps
    at = len(steps) - 2, len(steps) - 1
    last = f"Its tau and the drives of step {at[0]} {agreed[1]}; its M and that of step {at[1]} {agreed[2]}."
    checks = ((ode, f"The sum and the drives of the step before {agreed[0]}."), (order, last))
    steps = (*others, *(step._replace(parts=[*step.parts, Part("Check", (), x)]) for step, x in checks))
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


def _written(lettered: Lettered, state: State | None, known: list[str] | None) -> Sequence[Step]:
    """Return all steps in SymPy expressions; TooLargeError where they are to be written out, without `known`, and are
    too long."""
    found: list[_Solution] = []
    values: list[Any] = []

    def collected(value: Any) -> Any:
        values.append(np.asarray(value, dtype=object))
        return value

    def outputs(tape: Tape) -> Iterator[Scalar]:
        found.append(_Solution(lettered, state, tape, known))
        for equation in _equations(found[0]):
            if state is not None:
                _settle(equation)
            equation.change(collected)
        return (x for value in values for x in value.ravel())

    program, symbol = trace(outputs), module().Symbol
    for source, names in ((KNOWN, known or ()), (REACTIONS, found[0].reactions)):
        lettered.symbols |= {(source, k): symbol(name, real=True) for k, name in enumerate(names)}
    distinct = lettered.written(program.distinct, longest=LONGEST if known is None else np.inf)
    entries = iter([distinct[k] for k in program.homes])

    def written(value: Any) -> Any:
        out = np.array([next(entries) for _ in range(np.size(value))], dtype=object)
        return out.reshape(np.shape(value)) if np.ndim(value) else out[0]

    for equation in _equations(found[0]):
        equation.change(written)
    return found[0].steps


def _equations(found: _Solution) -> Iterator[Equation]:
    return (equation for step in found.steps for part in step.parts for equation in part.equations)


def _settle(equation: Equation) -> None:
    """Put zeros in place of numbers that rounding leaves of them."""
    sizes = [0.0]
    for value in (*(term.value for term in equation.terms), equation.total, equation.value):
        sizes += [abs(x) for x in np.ravel(np.asarray(value, dtype=object)) if isinstance(x, float)]
    equation.change(lambda value: _without_noise(value, NOISE * max(sizes)))


def _agreement(lettered: Lettered, state: State | None) -> list[str]:
    """Return in words how the pairs that are compared come out: as formulas, else in numbers."""

    def outputs(tape: Tape) -> list[Scalar]:
        pairs = _Solution(lettered, state, tape, None).compared
        return [x for array in (*(a - b for a, b in pairs), *(b for _, b in pairs)) for x in np.ravel(array)]

    program, n = trace(outputs), lettered.plan.model.n
    if state is None:
        with suppress(TooLargeError):
            differences = replace(program, outputs=program.outputs[: n * (n + 2)])
            if not any(Forms(lettered.symbols, COMPARED).outputs(differences)):
                return ["are the same: every difference vanishes, term by term"] * 3
    values = np.array([letter.value for letter in lettered.letters])
    widths = {"q": lettered.plan.model.nq, "qd": n, "qdd": n, LETTERS: len(values)}
    states = {source: np.random.default_rng(0).uniform(-2.0, 2.0, (STATES, k)) for source, k in widths.items()}
    states[LETTERS] = np.tile(values, (STATES, 1))
    out = np.abs(NumpyBlocks(program, widths)(states, STATES)).max(axis=0)
    largest = [part.max() for part in np.split(out, np.cumsum([n, n, n * n] * 2)[:-1])]
    off = [x / (scale or 1.0) for x, scale in zip(largest[:3], largest[3:], strict=True)]
    where = f" at {STATES} random states" if state is None else ""
    return [f"differ{where} by {'less than 1e-12' if x <= 1e-12 else f'{x:.0e}'} of the largest" for x in off]
