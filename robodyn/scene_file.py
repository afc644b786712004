"""Reading scene.toml; an unknown key is an error that lists the valid ones."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from robodyn.errors import SceneError
from robodyn.scene import Entry, ExternalWrench, Friction, Immersed, Payload, Rotor, Scene, Spring, Vector
from robodyn.urdf.wording import listed

FRAMES = ("link", "base", "world")
MOTIONS = ("fixed", "moving")


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """The scene that a TOML file describes.

    Args:
        path: a file with the keys `gravity`, `friction`, `rotor`, `spring`, `payload`, `wrench`, `base`.

    Raises:
        SceneError: the file cannot be read, is not TOML, has a key that is not understood, lacks one, or has a value of
            the wrong type or size. Whether joints and links exist is asked by `check_scene`.
    """
    file = os.fspath(path)
    try:
        with open(path, "rb") as handle:
            data = handle.read()
    except (OSError, ValueError) as error:
        raise SceneError(f"cannot be read: {getattr(error, 'strerror', None) or error}", file=file) from None
    return parse_scene(data, file)


def parse_scene(data: bytes, file: str = "<scene>") -> Scene:
    """The scene that TOML text describes; see `load_scene`."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        table = _Table(tomllib.loads(data.decode("utf-8")), "the scene", file)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise SceneError(f"is not TOML: {error or 'nested too deeply'}", file=file) from None
    scene = Scene(
        gravity=table.vector("gravity", Scene.gravity),
        friction={name: _friction(entry) for name, entry in table.tables("friction")},
        rotor={name: _rotor(entry) for name, entry in table.tables("rotor")},
        spring={name: _spring(entry) for name, entry in table.tables("spring")},
        payloads=tuple(_payload(entry) for entry in table.list("payload")),
        wrenches=tuple(_wrench(entry) for entry in table.list("wrench")),
        moving_base=_moving_base(table),
        **_fluid(table),
    )
    table.finish()
    return scene


class _Table:
    """A TOML table from which keys are taken one by one; `finish` complains of those left over."""

    def __init__(self, values: Any, what: str, file: str) -> None:
        if not isinstance(values, Mapping):
            raise SceneError(f"{what} is {values!r}, not a table", remedy="write key = value pairs", file=file)
        self.values, self.what, self.file = dict(values), what, file
        self.known: list[str] = []

    def error(self, what: str, remedy: str | None = None) -> SceneError:
        return SceneError(f"{self.what}: {what}", remedy=remedy, file=self.file)

    def take(self, key: str, default: Any) -> Any:
        self.known.append(key)
        value = self.values.pop(key, default)
        if value is ...:
            raise self.error(f'"{key}" is missing')
        return value

    def number(self, key: str, default: Any = ...) -> Any:
        value = self.take(key, default)
        return value if value is default else self._number(key, value)

    def _number(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise self.error(f'"{key}" is {value!r}, not a finite number')
        return float(value)

    def numbers(self, key: str, count: int, default: Any = ...) -> Any:
        value = self.take(key, default)
        if value is default:
            return value
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != count:
            raise self.error(f'"{key}" is {value!r}, not {count} numbers')
        return tuple(self._number(key, entry) for entry in value)

    def vector(self, key: str, default: Any = ...) -> Vector:
        vector: Vector = self.numbers(key, 3, default)
        return vector

    def entries(self, key: str) -> tuple[Entry, Entry, Entry]:
        value = self.take(key, (0.0, 0.0, 0.0))
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 3:
            raise self.error(f'"{key}" is {value!r}, not three numbers or names of columns')
        x, y, z = (entry if isinstance(entry, str) and entry else self._number(key, entry) for entry in value)
        return x, y, z

    def text(self, key: str, default: Any = ..., choices: Sequence[str] = ()) -> str:
        value = self.take(key, default)
        if not isinstance(value, str) or not value:
            raise self.error(f'"{key}" is {value!r}, not a name')
        if choices and value not in choices:
            raise self.error(f'"{key}" is "{value}"', remedy=f"one of: {', '.join(choices)}")
        return value

    def tables(self, key: str) -> list[tuple[str, _Table]]:
        values = _Table(self.take(key, {}), f"[{key}]", self.file).values
        return [(name, _Table(value, f"[{key}] {name}", self.file)) for name, value in values.items()]

    def list(self, key: str) -> list[_Table]:
        values = self.take(key, [])
        if not isinstance(values, list):
            raise self.error(f'"{key}" is not a list of tables', remedy=f"write [[{key}]] above each")
        return [_Table(value, f"[[{key}]] number {k}", self.file) for k, value in enumerate(values, 1)]

    def finish(self) -> None:
        for key in self.values:
            raise self.error(f'unknown key "{key}"', remedy=f"valid keys: {listed(self.known)}")


def _friction(table: _Table) -> Friction:
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
    friction = Friction(
        viscous, forward, backward, table.number("stribeck", None), table.number("stribeck_velocity", 0.01)
    )
    table.finish()
    for key, value in (("viscous", viscous), ("coulomb", forward), ("stribeck", friction.stribeck or 0.0)):
        if value < 0:
            raise table.error(f'"{key}" is {value:g}, which drives the joint', remedy="friction is positive or zero")
    if friction.stribeck_velocity <= 0:
        raise table.error(f'"stribeck_velocity" is {friction.stribeck_velocity:g}', remedy="give a positive speed")
    return friction


def _rotor(table: _Table) -> Rotor:
    rotor = Rotor(table.number("inertia"), table.number("gear", None))
    table.finish()
    if rotor.inertia < 0:
        raise table.error(f'"inertia" is {rotor.inertia:g}', remedy="it is positive or zero")
    return rotor


def _spring(table: _Table) -> Spring:
    spring = Spring(table.number("stiffness"), table.number("rest", 0.0))
    table.finish()
    return spring


def _payload(table: _Table) -> Payload:
    payload = Payload(
        table.text("link"),
        table.number("mass"),
        table.vector("com", Payload.com),
        table.numbers("inertia", 6, Payload.inertia),
    )
    table.finish()
    return payload


def _wrench(table: _Table) -> ExternalWrench:
    wrench = ExternalWrench(
        table.text("link"),
        table.entries("force"),
        table.entries("moment"),
        table.vector("point", ExternalWrench.point),
        table.text("frame", "link", FRAMES),
    )
    table.finish()
    return wrench


def _fluid(table: _Table) -> dict[str, Any]:
    if "fluid" not in table.values:
        table.known.append("fluid")
        return {}
    fluid = _Table(table.take("fluid", ...), "[fluid]", table.file)
    density = fluid.number("density")
    if density < 0:
        raise fluid.error(f'"density" is {density:g}', remedy="it is positive or zero")
    velocity = fluid.vector("velocity", Scene.fluid_velocity)
    immersed = tuple(_immersed(entry) for entry in fluid.list("link"))
    fluid.finish()
    return {"fluid_density": density, "fluid_velocity": velocity, "immersed": immersed}


def _immersed(table: _Table) -> Immersed:
    immersed = Immersed(
        table.text("link"),
        table.number("volume", 0.0),
        table.vector("centre", Immersed.centre),
        table.vector("drag_area", Immersed.drag_area),
    )
    table.finish()
    if immersed.volume < 0 or min(immersed.drag_area) < 0:
        raise table.error("volume and drag_area are positive or zero", remedy="drag opposes motion by itself")
    return immersed


def _moving_base(table: _Table) -> bool:
    base = _Table(table.take("base", {}), "[base]", table.file)
    moving = base.text("motion", "fixed", MOTIONS) == "moving"
    base.finish()
    return moving
