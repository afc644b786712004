"""The scene of a calibrated robot: friction, rotors and coupled motors, of which a description says a part only."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace

from robodyn.dynamics.effects.friction import friction_of, joints_with_friction
from robodyn.dynamics.effects.motors import rotor_of
from robodyn.robot.model import Model
from robodyn.scene.parts import CoupledMotor, Friction, Rotor
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats
from robodyn.support.toml_text import toml_key, toml_string


def calibrated(model: Model, names: Sequence[str], theta: Floats, scene: Scene = DEFAULT) -> Scene:
    """Return the scene with the friction and the rotors of theta, which replace what the description says of them.

    What theta does not hold stays: the speed of Stribeck's excess, gears. Joints without friction or rotor, in theta as
    before, are not named.

    Args:
        names, theta: of `robodyn.regressor` for this model and scene.

    Accuracy: `robodyn.regressor` of it has theta, rotors within 2 eps.
    """
    found = dict(zip(names, theta.tolist(), strict=True))
    friction, rotors = dict(scene.friction), dict(scene.rotor)
    for _, joint, old in joints_with_friction(model, scene):
        new = _friction(joint.name, old, found)
        if new != Friction() or old != Friction():
            friction[joint.name] = new
        inertia, gear = rotor_of(joint, scene)
        reflected = found.get(f"{joint.name}.rotor", 0.0)
        if gear and (inertia or reflected):
            before = rotors.get(joint.name, Rotor(None))
            rotors[joint.name] = replace(before, inertia=reflected / gear / gear, gear=gear)
    coupled = tuple(_coupled(motor, found) for motor in scene.coupled)
    return replace(scene, friction=friction, rotor=rotors, coupled=coupled)


def _coupled(motor: CoupledMotor, found: dict[str, float]) -> CoupledMotor:
    inertia = found.get(f"{motor.name}.rotor", motor.reflected) / motor.gear / motor.gear
    return replace(motor, inertia=inertia, friction=_friction(motor.name, motor.friction, found))


def _friction(motor: str, old: Friction, found: dict[str, float]) -> Friction:
    parts = ("viscous", "forward", "backward", "stribeck")
    return replace(old, **{part: found[name] for part in parts if (name := f"{motor}.{part}") in found})


def friction_toml(model: Model, scene: Scene, comment: Sequence[str] = ()) -> str:
    """Return as TOML what a scene says of friction and rotors: what `robodyn.load_scene` reads back the same.

    Args:
        comment: lines at the top.
    """
    blocks = ["".join(f"# {line}".rstrip() + "\n" for line in comment)] if comment else []
    if scene.slip_speed:
        blocks.append(f"slip_speed = {scene.slip_speed!r}\n")
    for _, joint, _ in joints_with_friction(model, scene):
        key = toml_key(joint.name)
        if joint.name in scene.friction:
            blocks.append(_table(f"[friction.{key}]", _entries(friction_of(joint, scene))))
        if joint.name in scene.rotor:
            inertia, gear = rotor_of(joint, scene)
            values = (("inertia", repr(inertia)), ("gear", repr(gear)))
            blocks.append(_table(f"[rotor.{key}]", (*values, *_carried(scene.rotor[joint.name]))))
    for motor in scene.coupled:
        turned = ", ".join(f"{toml_key(name)} = {part!r}" for name, part in motor.joints.items())
        rotor = ("inertia", repr(motor.inertia)), ("gear", repr(motor.gear))
        entries = ("name", toml_string(motor.name)), ("joints", f"{{ {turned} }}"), *rotor, *_entries(motor.friction)
        blocks.append(_table("[[coupled]]", entries))
    return "\n".join(blocks)


def _carried(rotor: Rotor) -> Iterator[tuple[str, str]]:
    """Yield keys and values of how a rotor stands, as far as it is said."""
    if rotor.axis is not None:
        yield "axis", repr([float(x) for x in rotor.axis])
    if rotor.on:
        yield "on", toml_string(rotor.on)


def _entries(friction: Friction) -> Iterator[tuple[str, str]]:
    """Yield keys and values of a joint's friction, as far as they are not the default."""
    yield "viscous", repr(friction.viscous)
    forward, backward = friction.forward, friction.backward
    yield "coulomb", repr(forward) if forward == -backward else f"[{forward!r}, {backward!r}]"
    for field in fields(Friction)[3:]:
        value = getattr(friction, field.name)
        if value != field.default:
            yield field.name, repr(value)


def _table(header: str, entries: Iterator[tuple[str, str]] | Sequence[tuple[str, str]]) -> str:
    return f"{header}\n" + "".join(f"{key} = {value}\n" for key, value in entries)
