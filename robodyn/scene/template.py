"""A scene to begin with as TOML: what can be said of a robot's surroundings, every line of it switched off."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from robodyn.robot.kinematics import configuration, link_poses
from robodyn.robot.model import Joint, Model
from robodyn.scene.scene import DEFAULT
from robodyn.support.wording import toml_key, toml_string

_HEAD = """Scene of the robot {name}, begun by: robodyn scene init
As it stands it changes nothing: robodyn computes as without a scene.
Lines that begin with # and no blank are examples. Take away the # of one and put in your numbers; each is
valid by itself. Numbers stand for what the description says, or for what only you can know."""


def scene_toml(model: Model) -> str:
    """Return a scene with a robot's joints and links, what its description says of them, and each key explained; as
    written it makes no difference. Lines with `#` and no blank behind it are examples, each valid alone."""
    blocks = [_comment(_HEAD.format(name=toml_key(model.name)))]
    blocks.append(_comment("Gravity in the axes of the ground, m/s^2.") + f"gravity = {list(DEFAULT.gravity)}\n")
    for text, lines in _sections(model):
        if lines:
            blocks.append(_comment(text) + "".join(f"#{line}\n" for line in lines))
    return "\n".join(blocks)


def _sections(model: Model) -> Iterator[tuple[str, Sequence[str]]]:
    single = [body.joint for body in model.bodies if body.joint.kind in ("revolute", "prismatic")]
    own = [joint for joint in model.independent if joint.kind != "floating"]
    depth = [0]
    for body in model.bodies[1:]:
        depth.append(depth[body.parent] + 1)
    # the link behind the most joints, the last of them in the file
    last_link = max(enumerate(model.links), key=lambda each: (depth[model.links[each[1]].body], each[0]))[1]
    tip = toml_string(last_link)
    yield _FRICTION, _of_each("friction", single, lambda each: {"viscous": each.damping, "coulomb": each.friction})
    yield _SLIP, ["slip_speed = 0.001"]
    yield _ROTOR, _of_each("rotor", single, lambda each: {"inertia": each.rotor_inertia, "gear": each.reduction})
    if carried := [joint for joint in single if joint.link]:
        last, on = toml_key(carried[-1].name), toml_string(carried[-1].link)
        yield _SPIN, [f"rotor.{last} = {{ inertia = 0.0001, gear = 100.0, axis = [0.0, 0.0, 1.0], on = {on} }}"]

    def motor(joint: Joint) -> dict[str, float]:
        gear = abs(joint.reduction) or 1.0
        peak, speed = (joint.effort or 0.0) / gear, (joint.velocity or 0.0) * gear
        peak, speed = peak if peak > 0 else 1.0, speed if speed > 0 else 100.0
        return {"efficiency": 1.0, "continuous": peak, "peak": peak, "max_speed": speed}

    yield _MOTOR, _of_each("motor", own, motor)
    if own:
        yield _THERMAL, [f"motor.{toml_key(own[0].name)}.thermal = {{ {_WINDING} }}"]
        yield _GEAR, [f"gear.{toml_key(own[0].name)}.life = {{ {_RATED} }}"]
    if len(own) > 1:
        shares = ", ".join(f"{toml_key(joint.name)} = 1.0" for joint in own[-2:])
        yield _COUPLED, [f'coupled = [{{ name = "motor", joints = {{ {shares} }}, inertia = 0.0001, gear = 100.0 }}]']
    yield _SPRING, _of_each("spring", single, lambda each: {"stiffness": 0.0, "rest": _rest(each)})
    yield _PAYLOAD, [f"payload = [{{ link = {tip}, mass = 1.0, com = {_ZERO} }}]"]
    yield _WRENCH, [f'wrench = [{{ link = {tip}, frame = "world", force = {_DOWN}, moment = {_ZERO} }}]']
    yield _FLUID, [f"fluid = {{ density = 1000.0, link = [{{ link = {tip}, volume = 0.001, centre = {_ZERO} }}] }}"]
    yield _BASE, ['base.motion = "moving"']
    yield _INITIAL, [f"initial.q.{toml_key(joint.name)} = {_rest(joint)!r}" for joint in own]
    yield "", [f"initial.qd.{toml_key(joint.name)} = 0.0" for joint in own]
    yield _DRIVE, _of_each("drive", own, lambda each: {"kp": 100.0, "kd": 10.0, "reference": _rest(each)})
    yield _BETWEEN, ['between_rows = "hold"']
    yield _LIMITS, ['joint_limits = "ignore"', "limit_spring = { stiffness = 10000.0, damping = 100.0 }"]
    if own:  # the tip is held where it is when a simulation begins
        at = link_poses(model, configuration(model, {joint.name: _rest(joint) for joint in own}))[last_link].p
        place = [round(float(x), 12) for x in at]
        held = f'point = {_ZERO}, to = "ground", to_point = {place}'
        yield _LOOP, [f'loop = [{{ name = "closure", link = {tip}, {held} }}]']
    yield _BAUMGARTE, ["baumgarte = 10.0"]
    if own:
        last = toml_string(own[-1].name)
        yield _PASSIVE, [f"actuated = [{last}]", f"passive = [{last}]"]
        yield _SHARE, ['share = "weighted"', 'weights = "effort"', f"weights.{toml_key(own[-1].name)} = 2.0"]
    yield _CONTACT, [f'contact = [{{ name = "foot", link = {tip}, friction = 0.7 }}]']
    yield _UNCERTAINTY, ['uncertainty = { mass = "5 %", com = "3 mm", inertia = "10 %", friction = "20 %" }']
    yield _COST, ["contact_cost = { forces = 1.0, torques = 1.0, within_limits = true }"]


_ZERO, _DOWN = "[0.0, 0.0, 0.0]", "[0.0, 0.0, -10.0]"
_FRICTION = """Friction, in place of the description's: viscous N m s/rad, coulomb N m or [forward, backward], stribeck
N m with stribeck_velocity rad/s, load a share of the torque that passes the gear; for prismatic joints N, m/s."""
_SLIP = "Coulomb friction grows over this speed, rad/s: f qd / sqrt(qd^2 + slip_speed^2)."
_ROTOR = "Rotors add gear^2 inertia to a joint: kg m^2 about the motor's axis, gear its turns for one of the joint."
_SPIN = "Rotors whose gyroscopic moments count: on the link that carries them, axis in its axes; one is enough."
_MOTOR = """Data sheets of motors, by which torques judges them: peak and continuous N m at the motor's shaft, a number
or [[speed, torque], ...]; max_speed rad/s; efficiency of the gear; gear and inertia here or in rotor; slides may have
lead m per turn or pitch_radius m."""
_THERMAL = """How a motor heats up: ohm, N m/A, K/W, J/K, degrees Celsius; beside a data sheet [motor.JOINT.thermal].
torques then tells its temperatures along the motion and repeated for ever, and the power on the DC bus."""
_GEAR = "Lives of gears whose ratio is known: h at this torque of the output N m and this speed of the input rad/s."
_RATED = "rated_life = 7000.0, rated_torque = 50.0, rated_speed = 200.0"
_WINDING = (
    "resistance = 1.0, torque_constant = 0.1, winding_housing = 1.0, housing_ambient = 5.0, winding_capacity = 10.0, "
    "housing_capacity = 500.0, winding_limit = 155.0"
)
_COUPLED = "Motors that turn with a sum of joints, coefficient times speed, as in wrists: inertia kg m^2, gear."
_SPRING = "Springs that pull a joint towards rest: stiffness N m/rad, rest rad."
_PAYLOAD = "Masses fixed to links: mass kg, com m, inertia [ixx, ixy, ixz, iyy, iyz, izz] kg m^2 about it."
_WRENCH = 'Forces N and moments N m on links, numbers or columns; axes of the "link", "base" or "world".'
_FLUID = "Water or air: density kg/m^3, velocity m/s; of each link volume m^3, its centre m, drag_area [x, y, z] m^2."
_BASE = "A base that moves: as the columns base_x ... of the trajectory say; in a simulation it is free."
_INITIAL = "Where a simulation begins: q rad or m, qd rad/s or m/s; numbers or names of columns of --traj."
_DRIVE = """What drives a joint in a simulation: torque + kp (reference - q) + kd (speed - qd); torque, reference and
speed are numbers or names of columns of --traj. Joints without a drive are free."""
_BETWEEN = 'Torques between the rows of --traj: "linear" without this line, or "hold" the last row\'s.'
_LIMITS = "A simulation ends at a limit of a joint, or ignores it, or has springs: N m/rad, N m s/rad."
_LOOP = 'A point of a link is held at a point of another or of the "ground"; kind "point", "hinge", "weld".'
_PASSIVE = "Joints that drive, or those that nothing drives; give one of these lists."
_SHARE = """Actuators that are more than enough share a load by the least sum of weighted squares of their torques; a
weight is a number, or "effort" for 1 / (effort limit)^2."""
_CONTACT = """What a link of a robot whose base moves stands on: point or polygon in the link's frame, normal in the
ground's axes, friction; on: "always", "auto", a column, or intervals of time."""
_UNCERTAINTY = "Standard deviations of masses, centres, inertias, friction, as a share or with a unit: error bars."
_COST = "Of all contact forces that balance, those of least forces |f|^2 / W^2 + torques (tau / limit)^2 are taken."
_BAUMGARTE = "1/s: errors of loops decay at this rate; without this line they are projected away after each step."


def _comment(text: str) -> str:
    return "".join(f"# {line}".rstrip() + "\n" for line in text.splitlines())


def _of_each(table: str, joints: Sequence[Joint], values: Callable[[Joint], dict[str, float]]) -> list[str]:
    lines = []
    for joint in joints:
        keys = ", ".join(f"{key} = {value!r}" for key, value in values(joint).items())
        lines.append(f"{table}.{toml_key(joint.name)} = {{ {keys} }}")
    return lines


def _rest(joint: Joint) -> float:
    """Return zero, or the limit nearest to it."""
    lower, upper = joint.lower or 0.0, joint.upper or 0.0
    crossed = joint.lower is not None and joint.upper is not None and lower > upper
    return 0.0 if crossed else max(lower, 0.0) or min(upper, 0.0)
