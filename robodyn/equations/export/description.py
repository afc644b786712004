"""What the head of an exported file says: units, the order of coordinates, and what the numbers in it stand for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from importlib.metadata import version

from robodyn.dynamics.effects.friction import joints_with_friction
from robodyn.dynamics.plan import Plan
from robodyn.equations.export.job import Job
from robodyn.robot.model import Model
from robodyn.scene.parts import Friction
from robodyn.support.wording import listed

_SMOOTH = "sign(qd) is qd / sqrt(qd^2 + slip_speed^2), slip_speed"
_JUMPS = (
    "Coulomb friction: sign(0) = 0, and sign has derivative 0, also at its step at rest. With slip_speed in\n"
    "the scene it is smooth."
)


def title(model: Model, form: str) -> str:
    """Return the first line."""
    return f'Dynamics of "{model.name}" {form}, written by robodyn {version("robodyn")}.'


def description(plan: Plan, jobs: Iterable[Job]) -> str:
    """Return units, coordinates, effects and what derivatives mean, in lines."""
    parts = [
        f"{_law(plan)} SI units: q [rad or m], qd [rad/s or m/s], qdd [rad/s^2 or m/s^2],\n"
        "tau and b [N m or N], M [kg m^2, kg m or kg]. tau is what the actuators supply along the joints' axes.",
        _coordinates(plan.model),
        _surroundings(plan),
        *_notes(plan, list(jobs)),
    ]
    return "\n\n".join(parts)


def _law(plan: Plan) -> str:
    """Return what holds of the torques."""
    if not plan.scene.loaded:
        return "tau = M(q) qdd + b(q, qd)."
    growing = f"Friction of {listed(plan.scene.loaded)} grows with load, so that tau = M qdd + b does not hold"
    return f"{growing};\nM of the derivatives is d tau / d qdd."


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
    return "\n".join(lines)


def _surroundings(plan: Plan) -> str:
    model, scene = plan.model, plan.scene
    gravity = ", ".join(repr(float(g)) for g in scene.gravity)
    lines = [f"Gravity ({gravity}) m/s^2, in the axes of the {'ground' if model.floating else 'base'}. Effects:"]
    for effect, verdict in plan.verdicts:
        if verdict.active:
            reason = "" if effect.name in ("gravity", "inertia", "coriolis", "moving base") else f"; {verdict.reason}"
            lines.append(f"  {effect.name}: {effect.adds}{reason}")
    return "\n".join([*lines, *_friction(plan)])


def _friction(plan: Plan) -> list[str]:
    """Return the constants of the joints, and what stands for the sign of speeds."""
    rubs = [
        (joint.name, friction)
        for _, joint, friction in joints_with_friction(plan.model, plan.scene)
        if friction.viscous or friction.dry or friction.load
    ]
    coupled = ((motor.name, motor.friction) for motor in plan.scene.coupled)
    rubs += [(name, friction) for name, friction in coupled if friction.viscous or friction.dry]
    if not rubs:
        return ["No friction."]
    lines = ["Friction, SI units:", *(f"  {name}: {_constants(friction)}" for name, friction in rubs)]
    if any(friction.dry or friction.load for _, friction in rubs):
        slip = plan.scene.slip_speed
        lines.append(f"Coulomb friction is smooth: {_SMOOTH} {slip!r}." if slip else _JUMPS)
    return lines


def _constants(friction: Friction) -> str:
    """Return those that act."""
    idle = () if friction.stribeck else ("stribeck_velocity",)
    return ", ".join(f"{name} {value!r}" for name, value in asdict(friction).items() if value and name not in idle)


def _notes(plan: Plan, jobs: list[Job]) -> list[str]:
    found = []
    if plan.scene.columns:
        found.append(f"columns: the numbers that wrenches name, in this order: {listed(plan.scene.columns)}.")
    floating = any(joint.kind == "floating" for joint in plan.model.independent)
    if any(job.name.endswith("derivatives") for job in jobs):
        text = "Columns of d / d q are by the coordinates, in the order of qd"
        if floating:
            text += ": of a floating base by a small turn about the\nbody's axes, then by a shift along the ground's"
        found.append(f"{text}.")
    if floating:
        found.append(
            "The length of a quaternion does not matter. Automatic differentiation finds derivatives by each of its\n"
            "four numbers alone; by a turn about body axis x, y or z the derivative is half of the sum of their\n"
            "products with (w, z, -y, -x), (-z, w, x, -y) or (y, -x, w, -z)."
        )
    return found
