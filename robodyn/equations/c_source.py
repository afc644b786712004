"""The equations of motion of a robot as one C99 file: declarations behind a guard, then the functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version

import numpy as np

from robodyn.dynamics.effects.viscous_friction import joints_with_friction
from robodyn.dynamics.forward import acceleration_program
from robodyn.dynamics.inverse import mass_runner
from robodyn.dynamics.plan import plan
from robodyn.equations.ode import bias_plan, check_equations, identifier, identifiers
from robodyn.errors import InputError
from robodyn.programs.program import Program
from robodyn.programs.run.c_code import c_function, comment, prototype
from robodyn.robot.model import Model
from robodyn.scene.scene import DEFAULT, Friction, Scene


@dataclass(frozen=True)
class Job:
    """A function to write: what it computes, in words, and from which arrays."""

    name: str
    what: str
    program: Program
    sources: tuple[str, ...]
    output: str


def c_source(model: Model, scene: Scene = DEFAULT) -> str:
    """Inverse dynamics, mass matrix, bias and forward dynamics of a robot in a scene, as the text of a C99 file.

    Args:
        scene: gravity, friction and so on, all of it folded into the functions.

    Returns:
        ASCII text; it includes <math.h> and nothing else, and compiles without warnings as C99 and as C++.

    Raises:
        InputError: nothing of the robot can move, the scene needs columns of a trajectory, or a constant overflows.

    Accuracy: within 1e-13 of robodyn's own results, relative to the largest.
    """
    check_equations(model, scene)
    prefix = identifier(model.name, "robot").lower()
    with np.errstate(all="ignore"):
        jobs, left_out = _jobs(model, scene)
    widths = {"q": model.nq, "qd": model.n, "qdd": model.n, "tau": model.n}
    arrays = {job: {source: widths[source] for source in job.sources} for job in jobs}
    heads = [
        f"/* {job.what}; {job.program.size} operations */\n"
        f"{prototype(f'{prefix}_{job.name}', arrays[job], job.output, len(job.program.outputs))};"
        for job in jobs
    ]
    bodies = [c_function(f"{prefix}_{job.name}", job.program, arrays[job], job.output) for job in jobs]
    top = _lead(model, scene, prefix, left_out)
    return "\n".join([*top, _guarded(model, prefix, heads), _implementation(prefix, bodies)])


def _jobs(model: Model, scene: Scene) -> tuple[list[Job], str]:
    """Return the functions, and why one is missing."""
    jobs = [
        Job("inverse_dynamics", "tau of a motion", plan(model, scene).torques(), ("q", "qd", "qdd"), "tau"),
        Job("mass_matrix", "M(q), row by row", mass_runner(model, scene).program, ("q",), "M"),
        Job("bias", "tau of a motion without acceleration", bias_plan(model, scene).torques(), ("q", "qd"), "b"),
    ]
    try:
        program = acceleration_program(plan(model, scene))
    except InputError as error:
        return jobs, f"forward_dynamics is left out: {error.what}\n"
    what = "the acceleration that tau makes"
    return [*jobs, Job("forward_dynamics", what, program, ("q", "qd", "tau"), "qdd")], ""


def _lead(model: Model, scene: Scene, prefix: str, left_out: str) -> list[str]:
    text = (
        f'Equations of motion of "{model.name}", written by robodyn {version("robodyn")}.\n\n'
        "tau = M(q) qdd + b(q, qd). SI units: q [rad or m], qd [rad/s or m/s], qdd [rad/s^2 or m/s^2],\n"
        "tau and b [N m or N], M [kg m^2, kg m or kg] in row-major order. tau is what the actuators supply\n"
        "along the joints' axes. An array that is written to may be one that is read.\n\n"
        + _coordinates(model)
        + _surroundings(model, scene)
        + left_out
        + f"\nFor declarations alone define {prefix.upper()}_DECLARATIONS_ONLY before including this file.\n"
    )
    lines = comment(text).rstrip("\n").split("\n")
    return ["/*", *(f" * {line}".rstrip() for line in lines), " */"]


def _coordinates(model: Model) -> str:
    lines = ["Coordinates, in the order of q:"]
    for joint in model.independent:
        if joint.kind == "floating":
            lines += [
                f"  q[{joint.coordinate}..{joint.coordinate + 6}]  {joint.name}: x y z [m] and quaternion qx qy qz qw,"
                f" in the axes of the {'ground' if joint.coordinate == 0 else 'parent'}",
                f"  qd[{joint.rate}..{joint.rate + 5}]  its angular velocity in body axes, then the rate of x y z;"
                " qdd and tau likewise",
            ]
        else:
            place = f"q[{joint.coordinate}]" + ("" if model.nq == model.n else f", qd[{joint.rate}]")
            lines.append(f"  {place}  {joint.name}: {joint.kind}, {'m' if joint.kind == 'prismatic' else 'rad'}")
    for body in model.bodies:
        if body.joint.mimics is not None:
            lines.append(f"  {body.joint.name} = {body.joint.multiplier!r} {body.joint.mimics} + {body.joint.offset!r}")
    return "\n".join(lines) + "\n\n"


def _surroundings(model: Model, scene: Scene) -> str:
    gravity = ", ".join(repr(float(g)) for g in scene.gravity)
    lines = [f"Gravity ({gravity}) m/s^2, in the axes of the {'ground' if model.floating else 'base'}. Effects:"]
    for effect, verdict in plan(model, scene).verdicts:
        if verdict.active:
            reason = "" if effect.name in ("gravity", "inertia", "coriolis", "moving base") else f"; {verdict.reason}"
            lines.append(f"  {effect.name}: {effect.adds}{reason}")
    rubs = [
        f"  {joint.name}: {_constants(friction)}"
        for _, joint, friction in joints_with_friction(model, scene)
        if friction.viscous or friction.dry
    ]
    lines += ["Friction, SI units:", *rubs] if rubs else ["No friction."]
    return "\n".join(lines) + "\n"


def _constants(friction: Friction) -> str:
    """Return those that act."""
    idle = () if friction.stribeck else ("stribeck_velocity",)
    return ", ".join(f"{name} {value!r}" for name, value in asdict(friction).items() if value and name not in idle)


def _guarded(model: Model, prefix: str, heads: Sequence[str]) -> str:
    guard = f"{prefix.upper()}_DYNAMICS_H"
    return "\n".join(
        [
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            f"#define {prefix.upper()}_NQ {model.nq}",
            f"#define {prefix.upper()}_N {model.n}",
            "",
            "/* places of the coordinates in q, and of their rates in qd, qdd and tau */",
            _enumerated(f"{prefix}_q", model.coordinates),
            _enumerated(f"{prefix}_qd", model.rates),
            "",
            "#ifdef __cplusplus",
            'extern "C" {',
            "#endif",
            *heads,
            "#ifdef __cplusplus",
            "}",
            "#endif",
            "",
            f"#endif /* {guard} */",
            "",
        ]
    )


def _enumerated(prefix: str, names: Sequence[str]) -> str:
    places = enumerate(identifiers(names, "joint"))
    return "enum {\n" + ",\n".join(f"    {prefix}_{name}".upper() + f" = {k}" for k, name in places) + "\n};"


def _implementation(prefix: str, bodies: Sequence[str]) -> str:
    condition = f"{prefix.upper()}_DECLARATIONS_ONLY"
    return "\n".join([f"#ifndef {condition}", "#include <math.h>", "", *bodies, f"#endif /* {condition} */", ""])
