"""The dynamics of a robot as source code for other programs: what is written, one C99 file, one Python module."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import version
from math import prod

import numpy as np

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.dynamics.function import KINDS, Kind
from robodyn.dynamics.plan import Plan, plan
from robodyn.dynamics.regressor import parameters
from robodyn.equations.ode import identifier, identifiers
from robodyn.errors import InputError
from robodyn.programs.export import (
    LIBRARIES,
    Library,
    c_function,
    comment,
    docstring,
    literal,
    prototype,
    python_function,
    wrapped,
)
from robodyn.programs.program import Program
from robodyn.robot.model import Model
from robodyn.scene.fit import check_moves, refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.files import write_whole
from robodyn.support.wording import alternatives, listed

_SMOOTH = "sign(qd) is qd / sqrt(qd^2 + slip_speed^2), slip_speed"
_JUMPS = (
    "Coulomb friction: sign(0) = 0, and sign has derivative 0, also at its step at rest. With slip_speed in\n"
    "the scene it is smooth."
)


@dataclass(frozen=True)
class Job:
    """A function to write, named by its kind's word; widths: how many numbers each argument has; shapes: of results."""

    kind: Kind
    program: Program
    widths: dict[str, int]
    shapes: dict[str, tuple[int, ...]]

    @staticmethod
    def of(kind: Kind, plan: Plan) -> Job:
        return Job(kind, kind.program(plan), kind.widths(plan), kind.shapes(plan))

    @property
    def name(self) -> str:
        return self.kind.word

    @property
    def sizes(self) -> dict[str, int]:
        return {name: prod(shape) for name, shape in self.shapes.items()}

    @property
    def meaning(self) -> str:
        return f"{self.kind.meaning}; {self.program.size} operations"


def title(model: Model, form: str) -> str:
    return f'Dynamics of "{model.name}" {form}, written by robodyn {version("robodyn")}.'


def description(plan: Plan, jobs: Iterable[Job]) -> str:
    """Return units, coordinates, effects and what derivatives mean, in lines."""
    model, scene = plan.model, plan.scene
    law = "tau = M(q) qdd + b(q, qd)."
    if scene.loaded:
        growing = f"Friction of {listed(scene.loaded)} grows with load, so that tau = M qdd + b does not hold"
        law = f"{growing};\nM of the derivatives is d tau / d qdd."
    units = (
        f"{law} SI units: q [rad or m], qd [rad/s or m/s], qdd [rad/s^2 or m/s^2],\n"
        "tau and b [N m or N], M [kg m^2, kg m or kg]. tau is what the actuators supply along the joints' axes."
    )
    places = ["Coordinates, in the order of q:"]
    for joint in model.independent:
        if joint.kind == "floating":
            places += [
                f"  q[{joint.coordinate}..{joint.coordinate + 6}]  {joint.name}: x y z [m] and quaternion qx qy qz qw,"
                f" in the axes of the {'ground' if joint.coordinate == 0 else 'parent'}",
                f"  qd[{joint.rate}..{joint.rate + 5}]  its angular velocity in body axes, then the rate of x y z;"
                " qdd and tau likewise",
            ]
        else:
            place = f"q[{joint.coordinate}]" + ("" if model.nq == model.n else f", qd[{joint.rate}]")
            places.append(f"  {place}  {joint.name}: {joint.kind}, {'m' if joint.kind == 'prismatic' else 'rad'}")
    for joint in (body.joint for body in model.bodies if body.joint.mimics is not None):
        places.append(f"  {joint.name} = {joint.multiplier!r} {joint.mimics} + {joint.offset!r}")
    gravity = ", ".join(repr(float(g)) for g in scene.gravity)
    effects = [f"Gravity ({gravity}) m/s^2, in the axes of the {'ground' if model.floating else 'base'}. Effects:"]
    for effect, verdict in plan.verdicts:
        if verdict.active:
            reason = "" if effect.name in ("gravity", "inertia", "coriolis", "moving base") else f"; {verdict.reason}"
            effects.append(f"  {effect.name}: {effect.adds}{reason}")
    parts = [units, "\n".join(places), "\n".join([*effects, *_friction(plan)])]
    if scene.columns:
        parts.append(f"columns: the numbers that wrenches name, in this order: {listed(scene.columns)}.")
    floating = any(joint.kind == "floating" for joint in model.independent)
    if any(job.name.endswith("derivatives") for job in jobs):
        turns = ": of a floating base by a small turn about the\nbody's axes, then by a shift along the ground's"
        parts.append(f"Columns of d / d q are by the coordinates, in the order of qd{turns if floating else ''}.")
    if floating:
        parts.append(
            "The length of a quaternion does not matter. Automatic differentiation finds derivatives by each of its\n"
            "four numbers alone; by a turn about body axis x, y or z the derivative is half of the sum of their\n"
            "products with (w, z, -y, -x), (-z, w, x, -y) or (y, -x, w, -z)."
        )
    return "\n\n".join(parts)


def _friction(plan: Plan) -> list[str]:
    rubs = [
        (joint.name, friction)
        for _, joint, friction in joints_with_friction(plan.model, plan.scene)
        if friction.viscous or friction.dry or friction.load
    ]
    coupled = ((motor.name, motor.friction) for motor in plan.scene.coupled)
    rubs += [(name, friction) for name, friction in coupled if friction.viscous or friction.dry]
    if not rubs:
        return ["No friction."]
    lines = ["Friction, SI units:"]
    for name, friction in rubs:
        idle = () if friction.stribeck else ("stribeck_velocity",)
        acting = [f"{each} {value!r}" for each, value in asdict(friction).items() if value and each not in idle]
        lines.append(f"  {name}: {', '.join(acting)}")
    if any(friction.dry or friction.load for _, friction in rubs):
        slip = plan.scene.slip_speed
        lines.append(f"Coulomb friction is smooth: {_SMOOTH} {slip!r}." if slip else _JUMPS)
    return lines


def c_file(plan: Plan, jobs: Sequence[Job]) -> str:
    """Return functions of a robot in a scene as the text of a file in C99, which is C++ too: ASCII, <math.h> alone."""
    model, prefix = plan.model, identifier(plan.model.name, "robot").lower()
    theta = list(parameters(plan)) if any(job.name == "regressor" for job in jobs) else []
    heads, bodies = [], []
    for job in jobs:
        name = f"{prefix}_{job.name}"
        results = "".join(f"\n   {each.name}: {each.meaning}" for each in job.kind.results)
        heads.append(f"/* {job.meaning}{results} */\n{prototype(name, job.widths, job.sizes)};")
        bodies.append(c_function(name, job.program, job.widths, job.sizes))
    if theta:
        array = f"const double {prefix}_theta[{len(theta)}]"
        names = "".join(f"\n   {comment(name)}" for name, _ in theta)
        heads.append(f"/* the parameters, in the order of the columns of Y:{names} */\nextern {array};")
        bodies.append(f"{array} = {{\n" + "".join(f"    {literal(value)},\n" for _, value in theta) + "};\n")
    condition, guard = f"{prefix.upper()}_DECLARATIONS_ONLY", f"{prefix.upper()}_DYNAMICS_H"
    text = (
        f"{title(model, 'in C')}\n\n{description(plan, jobs)}\n\n"
        "Matrices are in row-major order. An array that is written to may be one that is read.\n"
        f"For declarations alone define {condition} before including this file."
    )
    lines = [
        "/*",
        *(f" * {line}".rstrip() for line in comment(text).split("\n")),
        " */",
        f"#ifndef {guard}\n#define {guard}\n",
        f"#define {prefix.upper()}_NQ {model.nq}\n#define {prefix.upper()}_N {model.n}\n",
        "/* places of the coordinates in q, and of their rates in qd, qdd and tau */",
        _enumerated(f"{prefix}_q", model.coordinates),
        _enumerated(f"{prefix}_qd", model.rates),
        '\n#ifdef __cplusplus\nextern "C" {\n#endif',
        *heads,
        f"#ifdef __cplusplus\n}}\n#endif\n\n#endif /* {guard} */\n",
        f"#ifndef {condition}\n#include <math.h>\n",
        *bodies,
        f"#endif /* {condition} */\n",
    ]
    return "\n".join(lines)


def _enumerated(prefix: str, names: Sequence[str]) -> str:
    places = enumerate(identifiers(names, "joint"))
    return "enum {\n" + ",\n".join(f"    {prefix}_{name}".upper() + f" = {k}" for k, name in places) + "\n};"


def python_file(plan: Plan, jobs: Sequence[Job], library: Library) -> str:
    """Return functions of a robot in a scene as the text of a module, which imports the library and nothing else."""
    signatures, functions = ["Functions:"], []
    for job in jobs:
        signatures.append(f"  {job.name}({', '.join(job.widths)}) -> {', '.join(job.shapes)}: {job.meaning}")
        given = ", ".join(f"{source} {library.shape((width,))}" for source, width in job.widths.items())
        results = zip(job.kind.results, job.shapes.values(), strict=True)
        found = [f"{name} {library.shape(shape)}: {meaning}" for (name, _, meaning), shape in results]
        doc = "\n".join([f"Return {job.kind.meaning}.", "", f"Takes {given}; returns", *found, ""])
        functions.append(python_function(library, job.name, job.program, job.widths, job.shapes, doc))
    head = [title(plan.model, f"for {library.title}"), "\n".join(signatures)]
    text = "\n\n".join([*head, library.notes, description(plan, jobs)])
    constants = [
        _tuple("COORDINATES", map(ascii, plan.model.coordinates)),
        _tuple("RATES", map(ascii, plan.model.rates)),
    ]
    if any(job.name == "regressor" for job in jobs):
        names, theta = zip(*parameters(plan), strict=True)
        constants += [_tuple("PARAMETERS", map(ascii, names)), _tuple("THETA", map(literal, theta))]
    return "\n".join(
        [f"{docstring(text + chr(10))}\n", library.imports, "", *constants, library.support, "", *functions]
    )


def _tuple(name: str, entries: Iterable[str]) -> str:
    return "\n".join([f"{name} = (", *wrapped(entries, 4), ")"])


WORDS = {kind.word: kind for kind in KINDS.values()}
TARGETS: dict[str, Callable[[Plan, Sequence[Job]], str]] = {
    "c": c_file,
    **{name: partial(python_file, library=library) for name, library in LIBRARIES.items()},
}
"""By the name that a user gives: what writes a file."""


def export(
    model: Model,
    to: str,
    what: str | Iterable[str] = "torques",
    *,
    scene: Scene = DEFAULT,
    out: str | os.PathLike[str] | None = None,
) -> str:
    """Return source code that computes the dynamics of a robot in a scene, without robodyn.

    Every target has the same operations: those of the traced recursion, with the scene folded in. No library is needed
    to write; what is written imports that of its target, and nothing else.

    Args:
        to: "c" (C99), "numpy", "casadi", "jax" or "torch" (Python modules).
        what: the functions, each of which is named as here: "torques" (what `inverse_dynamics` returns), "mass_matrix",
            "bias" (`bias_forces`), "coriolis" (`coriolis_matrix`), "forward" (`forward_dynamics`), "derivatives"
            (`inverse_dynamics_derivatives`), "forward_derivatives" (`forward_dynamics_derivatives`), "regressor";
            several as a list, or with commas.
        scene: gravity, friction and so on. Where its wrenches name columns, these are one more argument.
        out: a file to write it to as well.

    Returns:
        The text of the file. Its head says units, the order of joints, and what derivatives are by.

    Raises:
        InputError: no such target or function, nothing can move, a constant overflows, `out` cannot be written.
        SceneError: the scene does not fit the model, or closes loops.

    Accuracy: within 1e-12 of the largest result; of derivatives of the code that libraries find too.
    """
    refuse_others(model, scene)
    _check_known("target", to, TARGETS)
    asked = what.split(",") if isinstance(what, str) else what if isinstance(what, Iterable) else [what]
    words = list(dict.fromkeys(word.strip() if isinstance(word, str) else word for word in asked))
    for word in words:
        _check_known("function", word, WORDS)
    if not words:
        raise InputError("no function to export is named", remedy=f"functions: {listed(tuple(WORDS))}")
    out = None if out is None else os.fspath(out)
    a_plan = plan(model, scene)
    check_moves(model)
    name, ending = os.path.splitext(os.path.basename(out or "").lower())
    if to in LIBRARIES and ending == ".py" and (name in LIBRARIES or name in sys.stdlib_module_names):
        what = f"a module of this name hides {name}, which it or what it imports needs"
        raise InputError(what, remedy="name another file", file=out)
    with np.errstate(all="ignore"):
        text = TARGETS[to](a_plan, [Job.of(WORDS[word], a_plan) for word in words])
    if out is not None:
        write_whole(out, text.encode(), remedy="name another file")
    return text


def _check_known(noun: str, word: str, known: Iterable[str]) -> None:
    if word not in tuple(known):
        remedy = alternatives(str(word), tuple(known), f"{noun}s")
        raise InputError(f"there is no {noun} {word!r} to export", remedy=remedy)
