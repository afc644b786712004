"""Reading scene.toml; an unknown key is an error that lists the valid ones."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from robodyn.errors import SceneError, unreadable
from robodyn.scene.parts import CoupledMotor, ExternalWrench, Friction, Immersed, Payload, Rotor, Spring
from robodyn.scene.read_constraints import constraints_of
from robodyn.scene.read_motors import motors_of
from robodyn.scene.read_simulation import simulated_of
from robodyn.scene.scene import Scene
from robodyn.scene.toml_table import WHOLE, SceneTable, read_toml
from robodyn.support.input_file import read_input

if TYPE_CHECKING:
    from robodyn.scene.uncertainty import Uncertainty

FRAMES = ("link", "base", "world")
MOTIONS = ("fixed", "moving")
_HELD = "true if something carries the base, else leave it out"
NOT_COMPUTED = ("ground", "floor")


def load_scene(path: str | os.PathLike[str], *more: str | os.PathLike[str]) -> Scene:
    """Return the scene that a TOML file describes, or several together.

    Args:
        path, more: files with the keys `gravity`, `friction`, `rotor`, `coupled`, `spring`, `payload`, `wrench`,
            `fluid`, `base`, `slip_speed`, `initial`, `drive`, `between_rows`, `joint_limits`, `limit_spring`, `loop`,
            `baumgarte`, `motor`, `actuated`,
            `passive`, `share`, `weights`, `contact`, `contact_cost`, `uncertainty`.

    Raises:
        SceneError: the file cannot be read, is not TOML, has a key that is not understood, lacks one, or has a value of
            the wrong type or size, or two files give the same key. Whether joints and links exist is asked by
            `check_scene`.
    """
    parts = []
    for each in (path, *more):
        file = os.fspath(each)
        try:
            parts.append((read_input(each, typed=True), file))
        except (OSError, ValueError) as error:
            raise unreadable(error, file) from None
    return parse_scenes(parts)


def parse_scenes(parts: Sequence[tuple[bytes, str]]) -> Scene:
    """Return the scene that several TOML texts describe together, each with the name of its file; see `load_scene`."""
    if len(parts) == 1:
        return parse_scene(*parts[0])
    from robodyn.scene.merge import merged

    try:
        return _scene(merged(parts), " + ".join(file for _, file in parts))
    except SceneError as error:
        for data, file in parts:  # say which file it is, if one has the same error for itself
            try:
                parse_scene(data, file)
            except SceneError as own:
                if (own.what, own.remedy) == (error.what, error.remedy):
                    raise own from None
        raise


def parse_scene(data: bytes, file: str = "<scene>") -> Scene:
    """Return the scene that TOML text describes; see `load_scene`."""
    return _scene(read_toml(data, file), file)


def _scene(values: dict[str, Any], file: str) -> Scene:
    table = SceneTable(values, WHOLE, file)
    scene = Scene(
        gravity=table.vector("gravity", Scene.gravity),
        friction={name: _friction(entry) for name, entry in table.tables("friction")},
        **motors_of(table, {name: _rotor(entry) for name, entry in table.tables("rotor")}),
        spring={name: entry.read(Spring) for name, entry in table.tables("spring")},
        payloads=tuple(entry.read(Payload) for entry in table.list("payload")),
        wrenches=tuple(_wrench(entry) for entry in table.list("wrench")),
        **_base(table),
        slip_speed=table.nonnegative("slip_speed", 0.0, "it is positive, or 0 for sign(qd)"),
        **constraints_of(table),
        baumgarte=table.nonnegative("baumgarte", 0.0, "it is positive, or 0 for projection after each step"),
        **simulated_of(table),
        **_fluid(table),
        uncertainty=_uncertainty(table),
        coupled=tuple(_coupled(entry) for entry in table.list("coupled")),
    )
    for key in NOT_COMPUTED:
        if key in table.values:
            what = f'"{key}" is no key: the ground is where a [[contact]] of a link stands'
            raise table.error(what, remedy="give [[contact]] name, link and point or polygon")
    table.finish()
    return scene


def _uncertainty(table: SceneTable) -> Uncertainty | None:
    if "uncertainty" not in table.values:
        table.known.append("uncertainty")
        return None
    from robodyn.scene.read_uncertainty import uncertainty_of

    return uncertainty_of(table)


def _wrench(table: SceneTable) -> ExternalWrench:
    wrench = ExternalWrench(
        table.text("link"),
        table.entries("force"),
        table.entries("moment"),
        table.vector("point", ExternalWrench.point),
        table.text("frame", ExternalWrench.frame, FRAMES),
    )
    table.finish()
    return wrench


def _friction(table: SceneTable, single: bool = True) -> Friction:
    viscous = table.number("viscous", 0.0)
    if isinstance(table.values.get("coulomb"), list):
        forward, backward = table.numbers("coulomb", 2)
        if forward < 0 or backward > 0:
            raise table.error(
                f'"coulomb" is [{forward:g}, {backward:g}], which drives the joint',
                remedy="the torque at qd > 0 is positive or zero, the one at qd < 0 negative or zero",
            )
    else:
        forward = table.number("coulomb", 0.0)
        backward = -forward
    stribeck, velocity = table.number("stribeck", None), table.number("stribeck_velocity", 0.01)
    friction = Friction(viscous, forward, backward, stribeck, velocity, table.number("load", 0.0) if single else 0.0)
    table.finish()
    for key, value in (("viscous", viscous), ("coulomb", forward), ("stribeck", friction.stribeck or 0.0)):
        if value < 0:
            raise table.error(f'"{key}" is {value:g}, which drives the joint', remedy="friction is positive or zero")
    if friction.stribeck_velocity <= 0:
        raise table.error(f'"stribeck_velocity" is {friction.stribeck_velocity:g}', remedy="give a positive speed")
    return friction


def _coupled(table: SceneTable) -> CoupledMotor:
    name, joints = table.text("name"), SceneTable(table.take("joints", ...), f"{table.what} joints", table.file)
    coefficients = {joint: joints.number(joint) for joint in list(joints.values)}
    if not any(coefficients.values()):
        raise table.error('"joints" has no coefficient that is not 0', remedy="such as { joint5 = 1.0, joint6 = 1.0 }")
    inertia, gear = table.nonnegative("inertia", 0.0), table.number("gear", 1.0)
    return CoupledMotor(name, coefficients, inertia, gear, _friction(table, single=False))


def _rotor(table: SceneTable) -> Rotor:
    inertia, gear, axis = table.nonnegative("inertia"), table.number("gear", None), table.vector("axis", None)
    rotor = Rotor(inertia, gear, axis, table.text("on") if "on" in table.values else "")
    table.known.append("on")
    table.finish()
    return rotor


def _fluid(table: SceneTable) -> dict[str, Any]:
    if "fluid" not in table.values:
        table.known.append("fluid")
        return {}
    fluid = SceneTable(table.take("fluid", ...), "[fluid]", table.file)
    density = fluid.nonnegative("density")
    velocity = fluid.vector("velocity", Scene.fluid_velocity)
    immersed = tuple(_immersed(entry) for entry in fluid.list("link"))
    fluid.finish()
    return {"fluid_density": density, "fluid_velocity": velocity, "immersed": immersed}


def _immersed(table: SceneTable) -> Immersed:
    immersed = table.read(Immersed)
    if immersed.volume < 0 or min(immersed.drag_area) < 0:
        raise table.error("volume and drag_area are positive or zero", remedy="drag opposes motion by itself")
    return immersed


def _base(table: SceneTable) -> dict[str, Any]:
    base = SceneTable(table.take("base", {}), "[base]", table.file)
    moving, held = base.text("motion", "fixed", MOTIONS) == "moving", base.flag("held", False, _HELD)
    base.finish()
    return {"moving_base": moving, "held": held}
