"""A description with what a scene says of its robot: the way of friction, rotors, springs and loops into a file."""

from __future__ import annotations

from dataclasses import asdict, fields, replace
from typing import Any

from robodyn.robot.urdf.parts import Description, Inertial, Joint, Link, Origin, Transmission
from robodyn.robot.write.common import free_name
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.wording import listed

_TAKEN = {"gravity", "friction", "rotor", "spring", "loops", "payloads", "moving_base", "held"}


def described(description: Description, scene: Scene) -> tuple[Description, list[str]]:
    """Return the description with friction, rotors and payloads of a scene, and its gravity, springs, loops and base as
    tables; and what of the scene no description says, a line each.

    Payloads become links, fixed to those that carry them. The scene is whole: it has what the description says of it.
    """
    lost, lopsided, steeper, spinning = list[str](), list[str](), list[str](), list[str]()
    joints = list(description.joints)
    for k, joint in enumerate(joints):
        if (friction := scene.friction.get(joint.name)) is None:
            continue
        dry = (friction.forward - friction.backward) / 2.0
        joints[k] = replace(joint, damping=friction.viscous, friction=dry)
        if friction.forward != -friction.backward:
            lopsided.append(joint.name)
        if friction.load or friction.stribeck is not None:
            steeper.append(joint.name)
    motors = {each.joint: each for each in description.transmissions}
    known = {joint.name for joint in joints}
    for name, rotor in scene.rotor.items():
        old = motors.get(name, Transmission(f"{name}_transmission", name))
        gear = old.reduction if rotor.ratio is None else rotor.ratio
        inertia = old.rotor_inertia if rotor.inertia is None else rotor.inertia
        if name in known:
            motors[name] = replace(old, reduction=gear, rotor_inertia=inertia)
        if rotor.spins:
            spinning.append(name)
    links = list(description.links)
    names = {link.name for link in links} | known
    for load in scene.payloads:
        name = free_name(f"{load.link}_payload", names)
        names |= {name}
        links.append(Link(name, Inertial(load.mass, Origin(load.com), load.inertia)))
        joints.append(Joint(f"{name}_fixed", "fixed", load.link, name))
    for what, of in (
        ("friction that differs by direction, of which the mean is written", lopsided),
        ("friction of breakaway and friction that grows with load", steeper),
        ("axes of rotors, and with them gyroscopic moments", spinning),
        ("friction and rotors of parts of planar joints", [*{*scene.friction, *scene.rotor} - known]),
    ):
        lost += [f"{what}: {listed(of)}"] if of else []
    said = [f.name for f in fields(Scene) if getattr(scene, f.name) != getattr(DEFAULT, f.name)]
    others = [name for name in said if name not in _TAKEN]
    lost += [f"of the scene: {listed([name.replace('_', ' ') for name in others])}"] if others else []
    tables: dict[str, Any] = {"gravity": list(scene.gravity)} if scene.gravity != DEFAULT.gravity else {}
    tables |= {"spring": {name: asdict(each) for name, each in scene.spring.items()}} if scene.spring else {}
    tables |= {"loop": [asdict(loop) for loop in scene.loops]} if scene.loops else {}
    tables |= {"base": {"motion": "moving"}} if scene.moving_base else {}
    changed = replace(description, links=tuple(links), joints=tuple(joints), scene=tables)
    return replace(changed, transmissions=tuple(motors.values())), lost
