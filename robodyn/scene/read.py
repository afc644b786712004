"""The door of this room: scene.toml -> Scene; an unknown key is an error that lists the valid ones.

1. `toml_table` makes tables of the files, several of which are one scene, and reads dataclasses out of tables.
2. Those are in `scene` and `uncertainty`: their fields are the keys, whose types say what may stand there.
3. What stands otherwise in the file than in the dataclass is read here, and what keys say of each other is checked.
4. `fit` sees whether joints and links exist, and adds the loops that a description closes by itself.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Mapping
from itertools import pairwise
from math import inf, isfinite, pi
from typing import Annotated, Any

import numpy as np

from robodyn.errors import SceneError, unreadable
from robodyn.scene import scene as parts
from robodyn.scene.scene import Scene
from robodyn.scene.toml_table import WHOLE, Sources, TomlTable, merged, read_toml
from robodyn.scene.uncertainty import Deviation, LinkUncertainty, Uncertainty, read_covariance
from robodyn.support.input_file import read_input

_SPEEDS = {"rad/s": 1.0, "rpm": pi / 30.0}
"""Units of speed that a data sheet may have, in rad/s."""
_MOST_POINTS, _FLAT = 64, 1e-6
"""Of a contact; directions that span less are taken for parallel."""
_UNITS = {
    "mass": {"kg": 1.0, "g": 1e-3},
    "com": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "inertia": {"kg m^2": 1.0},
    "friction": {"N m": 1.0, "N": 1.0},
}
"""The units of absolute standard deviations, in SI."""
_AMOUNT = re.compile(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*")
_POINTS = "points are [speed, torque], such as [[0, 1.3], [300, 0.9]]"


def load_scene(path: str | os.PathLike[str], *more: str | os.PathLike[str]) -> Scene:
    """Return the scene that a TOML file describes, or several together; docs/reference/scene.md has its keys.

    Raises:
        SceneError: a file cannot be read, is not TOML, has a key that is not understood, lacks one, or has a value of
            the wrong type or size, or two files give the same key. `check_scene` asks whether joints and links exist.
    """
    return parse_scenes(scene_sources(path, *more))


def scene_sources(*paths: str | os.PathLike[str]) -> list[tuple[bytes, str]]:
    """Return the bytes of files, each with its name; SceneError for one that cannot be read."""
    sources = []
    for each in paths:
        file = os.fspath(each)
        try:
            sources.append((read_input(each, typed=True), file))
        except (OSError, ValueError) as error:
            raise unreadable(error, file) from None
    return sources


def parse_scene(data: bytes, file: str = "<scene>") -> Scene:
    """Return the scene that TOML text describes; see `load_scene`."""
    return parse_scenes([(data, file)])


def parse_scenes(sources: Sources) -> Scene:
    """Return the scene that several TOML texts describe together, each with the name of its file; see `load_scene`."""
    return scene_from(scene_tables(sources), sources)


def scene_tables(sources: Sources) -> dict[str, Any]:
    """Return the tables of several TOML texts."""
    return read_toml(*sources[0]) if len(sources) == 1 else merged(sources)


def scene_from(values: Mapping[str, Any], sources: Sources) -> Scene:
    """Return the scene that the tables of TOML texts describe, or of a description (`Description.scene`)."""
    for key in ("ground", "floor"):
        if key in values:
            what = f'{WHOLE}: "{key}" is no key: the ground is where a [[contact]] of a link stands'
            raise SceneError(what, remedy="give [[contact]] name, link and point or polygon", file=sources[0][1])
    table = TomlTable(values, WHOLE, sources)
    rotors = {name: entry.read(parts.Rotor, **_turns(entry)) for name, entry in table.tables("rotor")}
    motors = {name: _motor(entry, name, rotors) for name, entry in table.tables("motor")}
    contacts = tuple(_contact(entry) for entry in table.list("contact"))
    loops = tuple(_loop(entry) for entry in table.list("loop"))
    for name, count in Counter([*(loop.name for loop in loops), *(contact.name for contact in contacts)]).items():
        if count > 1:
            what = f'{count} loops and contacts have the name "{name}"'
            raise table.error(what, "give each a name of its own")
    base, initial = table.table("base", {}), table.table("initial", {})
    motion = base.value("motion", Annotated[str, parts.one_of("fixed", "moving")], "fixed")
    held = base.value("held", bool, False)
    base.finish()
    begun = {f"initial_{key}": _numbers(initial, key, parts.Entry, f"[initial] {key}", {}) for key in ("q", "qd")}
    initial.finish()
    return table.read(
        Scene,
        friction={name: _friction(entry) for name, entry in table.tables("friction")},
        motor=motors,
        gear_life={name: _gear(entry) for name, entry in table.tables("gear")},
        rotor=rotors,
        coupled=tuple(_coupled(entry) for entry in table.list("coupled")),
        spring={name: entry.read(parts.Spring) for name, entry in table.tables("spring")},
        payloads=tuple(entry.read(parts.Payload) for entry in table.list("payload")),
        wrenches=tuple(
            entry.read(parts.ExternalWrench, cause="surroundings", axes="") for entry in table.list("wrench")
        ),
        loops=loops,
        contacts=contacts,
        contact_cost=table.table("contact_cost", {}).read(parts.ContactCost),
        drive={name: entry.read(parts.Drive) for name, entry in table.tables("drive")},
        uncertainty=_uncertainty(table.table("uncertainty", None)),
        **_fluid(table),
        moving_base=motion == "moving",
        held=held,
        **begun,
        **_limits(table),
        **_actuation(table),
    )


def _friction(table: TomlTable, **given: Any) -> parts.Friction:
    if isinstance(table.values.get("coulomb"), list):
        forward, backward = table.value("coulomb", tuple[float, float])
        if forward < 0 or backward > 0:
            what = f'"coulomb" is [{forward:g}, {backward:g}], which drives the joint'
            remedy = "the torque at qd > 0 is positive or zero, the one at qd < 0 negative or zero"
            raise table.error(what, remedy, "coulomb")
    else:
        forward = table.value("coulomb", parts.DryTorque, 0.0)
        backward = -forward
    return table.read(parts.Friction, forward=forward, backward=backward, **given)


def _turns(table: TomlTable) -> dict[str, float | None]:
    """Return gear and lead of a rotor; a pinion's lead is the circumference of its pitch circle."""
    gear = table.value("gear", float, None)
    lead, radius = (table.value(key, parts.Positive, None) for key in ("lead", "pitch_radius"))
    if lead is not None and radius is not None:
        raise table.error('"lead" and "pitch_radius" are both given', "a screw has a lead, a pinion a radius", "lead")
    return {"gear": gear, "lead": lead if radius is None else 2.0 * pi * radius}


def _motor(table: TomlTable, name: str, rotors: dict[str, parts.Rotor]) -> parts.Motor:
    """Return what a data sheet says of a motor; its rotor, which may stand there too, is added to the rotors."""
    keys = [key for key in ("inertia", "gear", "lead", "pitch_radius") if key in table.values]
    rotor = {"inertia": table.value("inertia", parts.NonNegative, None), **_turns(table)}
    if keys and name in rotors:
        raise table.error(f'"{keys[0]}" and [rotor] {name} say the same', "leave [rotor] out", keys[0])
    if rotor["gear"] == 0:
        raise table.error('"gear" is 0', "turns of the motor per turn of the joint", "gear")
    if keys:
        rotors[name] = parts.Rotor(**rotor)
    unit = _SPEEDS[table.value("speed_unit", Annotated[str, parts.one_of(*_SPEEDS)], "rad/s")]
    continuous, peak = (_curve(table, key, unit) for key in ("continuous", "peak"))
    fastest = table.field(parts.Motor, "max_speed")
    thermal = table.table("thermal", None, f"[motor.{name}.thermal]")
    motor = table.read(
        parts.Motor,
        continuous=continuous,
        peak=peak,
        max_speed=None if fastest is None else fastest * unit,
        thermal=None if thermal is None else _thermal(thermal),
    )
    if continuous is not None and peak is not None:
        (speeds, torques), (places, limits) = (
            np.transpose(((0.0, of),) if isinstance(of, float) else of) for of in (continuous, peak)
        )
        for speed, torque, most in zip(speeds, torques, np.interp(speeds, places, limits), strict=True):
            if torque > most:
                what = f'"continuous" allows {torque:g} at {speed:g} rad/s and "peak" {most:g}'
                raise table.error(what, f"are they swapped? {_POINTS}", "continuous")
    return motor


def _thermal(table: TomlTable) -> parts.Thermal:
    found = table.read(parts.Thermal)
    if (found.housing_ambient is None) != (found.housing_capacity is None):
        what = '"housing_ambient" and "housing_capacity" go together, and one is given'
        raise table.error(what, "give both, or neither: the housing then stays at ambient")
    return found


def _gear(table: TomlTable) -> parts.GearLife:
    life = table.table("life", what=f"{table.what} life")
    table.finish()
    unit = _SPEEDS[life.value("speed_unit", Annotated[str, parts.one_of(*_SPEEDS)], "rad/s")]
    found: parts.GearLife = life.read(parts.GearLife, rated_speed=unit * life.field(parts.GearLife, "rated_speed"))
    return found


def _curve(table: TomlTable, key: str, unit: float) -> float | parts.Curve | None:
    if not isinstance(table.values.get(key), list):
        torque: float | None = table.value(key, parts.IfKnown, None)
        return torque
    points = table.value(key, Annotated[parts.Curve, parts.Rule(bool, _POINTS)])
    speeds, torques = zip(*points, strict=True)
    wrong, values = "", torques
    if speeds[0] < 0 or any(b <= a for a, b in pairwise(speeds)):
        wrong, values = f'the speeds of "{key}" do not increase from 0 on', speeds
    elif min(torques) < 0 or not max(torques):
        wrong = f'the torques of "{key}" are not positive'
    if wrong:
        raise table.error(f"{wrong}: {', '.join(f'{value:g}' for value in values)}", _POINTS, key)
    return tuple((speed * unit, torque) for speed, torque in points)


def _coupled(table: TomlTable) -> parts.CoupledMotor:
    name, joints = table.value("name", str), _numbers(table, "joints", float, f"{table.what} joints")
    if not any(joints.values()):
        remedy = "such as { joint5 = 1.0, joint6 = 1.0 }"
        raise table.error('"joints" has no coefficient that is not 0', remedy, "joints")
    inertia, gear = table.value("inertia", parts.NonNegative, 0.0), table.value("gear", float, 1.0)
    return parts.CoupledMotor(name, joints, inertia, gear, _friction(table, load=0.0))


def _numbers(table: TomlTable, key: str, kind: Any, what: str, default: Any = ...) -> dict[str, Any]:
    values = table.table(key, default, what)
    return {name: values.value(name, kind) for name in list(values.values)}


def _loop(table: TomlTable) -> parts.Loop:
    given: dict[str, Any] = {"kind": table.field(parts.Loop, "kind")}
    given |= {name: getattr(parts.Loop, name) for name in ("axis", "to_axis", "rpy", "directions")}
    if given["kind"] == "hinge":
        axis = table.value("axis", parts.Direction)
        given |= {"axis": axis, "to_axis": table.value("to_axis", parts.Direction, axis)}
    elif given["kind"] == "weld":
        given["rpy"] = table.field(parts.Loop, "rpy")
    else:
        found: tuple[parts.Vector, ...] = table.field(parts.Loop, "directions")
        lengths, wrong = np.linalg.norm(np.array(found).reshape(-1, 3), axis=1), ""
        if not all(lengths):
            wrong = 'one of "directions" is zero'
        elif len(found) > 3:
            wrong = f'"directions" are {len(found)}, not at most 3 vectors of 3 numbers'
        elif found and np.linalg.svd(np.array(found) / lengths[:, None], compute_uv=False).min() <= _FLAT:
            wrong = 'two of "directions" are parallel, or three lie in a plane'
        if wrong:
            raise table.error(wrong, "give each direction once, in the axes of the other link", "directions")
        given["directions"] = found
    loop = table.read(parts.Loop, **given)
    if loop.link == loop.to:
        raise table.error(f'"link" and "to" are both "{loop.link}"', "a loop connects two links", "to")
    return loop


def _contact(table: TomlTable) -> parts.Contact:
    polygon = table.value("polygon", tuple[parts.Vector, ...], None)
    if polygon is None:
        points = (table.value("point", parts.Vector, (0.0, 0.0, 0.0)),)
    elif "point" in table.values:
        raise table.error('"point" and "polygon" are both given', "give one of them", "polygon")
    elif len(polygon) > _MOST_POINTS or len(set(polygon)) < max(len(polygon), 3):
        what = f'"polygon" has {len(set(polygon))} different points'
        raise table.error(what, f"give at least 3, each once, and at most {_MOST_POINTS}", "polygon")
    else:
        points = polygon
    on = given = table.take("on", parts.Contact.on)
    if not isinstance(given, str) or not given:
        try:
            on = table.converted("on", given, tuple[tuple[float, float], ...])
        except SceneError:
            on = ()
        if not on or any(start > end for start, end in on):
            remedy = f'give "{parts.ALWAYS}", "{parts.AUTO}", the name of a column, or intervals: [[0, 0.5], [1, 1.5]]'
            raise table.error(f'"on" is {given!r:.60}', remedy, "on")
    return table.read(parts.Contact, points=points, on=on)


def _fluid(scene: TomlTable) -> dict[str, Any]:
    fluid = scene.table("fluid", {"density": Scene.fluid_density})
    density = fluid.value("density", parts.NonNegative)
    velocity = fluid.value("velocity", parts.Vector, Scene.fluid_velocity)
    immersed = tuple(entry.read(parts.Immersed) for entry in fluid.list("link"))
    fluid.finish()
    return {"fluid_density": density, "fluid_velocity": velocity, "immersed": immersed}


def _limits(scene: TomlTable) -> dict[str, Any]:
    given = scene.table("limit_spring", None)
    kind = scene.field(Scene, "joint_limits", Scene.joint_limits if given is None else "spring")
    if (given is not None) != (kind == "spring"):
        what = f'"joint_limits" is "{kind}" ' + ("without" if given is None else "with") + " a [limit_spring]"
        remedy = "give its stiffness, N m/rad" if given is None else 'write joint_limits = "spring"'
        raise scene.error(what, remedy, "joint_limits")
    return {"joint_limits": kind, "limit_spring": None if given is None else given.read(parts.LimitSpring)}


def _actuation(scene: TomlTable) -> dict[str, Any]:
    if {"actuated", "passive"} <= scene.values.keys():
        what = '"actuated" and "passive" are both given'
        raise scene.error(what, "give one: the other joints are the other", "passive")
    actuated, passive = scene.field(Scene, "actuated"), scene.field(Scene, "passive")
    weights = scene.values.get("weights")
    share = scene.field(Scene, "share", Scene.share if weights is None else "weighted")
    if weights is not None and share != "weighted":
        raise scene.error('"weights" are given, and "share" is "least"', 'write share = "weighted"', "share")
    found = {"actuated": actuated, "passive": passive, "share": share, "weight": Scene.weight, "weights": {}}
    if weights == parts.EFFORT:
        return {**found, "weight": scene.take("weights")}
    each = scene.table("weights", {})
    kind = Annotated[float, parts.Rule(lambda x: x > 0.0, f'give a positive weight, or "{parts.EFFORT}" for its limit')]
    given = {
        name: parts.EFFORT if value == parts.EFFORT else each.value(name, kind)
        for name, value in list(each.values.items())
    }
    return {**found, "weights": given}


def _uncertainty(table: TomlTable | None) -> Uncertainty | None:
    """Return standard deviations, or the covariance that stands in a file beside the scene and alone in its table."""
    if table is None:
        return None
    name = table.value("covariance", str, None)
    if name is not None:
        if table.values:
            what = f'"covariance" is all that is uncertain, and there is {", ".join(table.values)} too'
            raise table.error(what, "leave one of them out", "covariance")
        return Uncertainty(covariance=read_covariance(os.path.join(table.folder, name)))
    links, joints = {}, {}
    for name, each in table.tables("link", "[uncertainty.link]"):
        links[name] = each.read(LinkUncertainty, **{key: _deviation(each, key) for key in ("mass", "com", "inertia")})
    for name, each in table.tables("joint", "[uncertainty.joint]"):
        friction = _deviation(each, "friction")
        each.finish()
        if friction is not None:
            joints[name] = friction
    general = {key: _deviation(table, key) for key in _UNITS}
    return table.read(Uncertainty, link=links, joint=joints, covariance=None, **general)


def _deviation(table: TomlTable, key: str) -> Deviation | None:
    given = table.take(key, None)
    if given is None:
        return None
    units = {"%": 0.01, **_UNITS[key]}
    found = _AMOUNT.fullmatch(given) if isinstance(given, str) else None
    unit = " ".join(found[2].replace("*", " ").split()) if found else ""
    try:
        value = float(found[1]) * units[unit] if found else inf
    except (ValueError, KeyError):
        value = inf
    if not isfinite(value):
        examples = " or ".join(f'{key} = "5 {each}"' for each in units)
        what = f'"{key}" is {given!r:.60}, not a standard deviation with its unit'
        raise table.error(what, f"write {examples}", key)
    return Deviation(value, relative=unit == "%")
