"""What programs refuse of how elements and numbers are written: what is missing, repeated, or no number.

Each looks at some elements only, so that what another program refuses may pass.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite

from robodyn.checks.consumers.found import Found, named
from robodyn.checks.context import Context
from robodyn.checks.grammar import KINDS
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.parts import INERTIA, SHAPES, SIZES
from robodyn.robot.urdf.view import JointView, LinkView

_NUMBER = re.compile(r"[+-]?((\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|inf(inity)?|nan)", re.ASCII | re.IGNORECASE)
_MOTION = ("dynamics", "limit")
Tags = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Grammar:
    """How one program reads.

    Attributes:
        children: what it looks at in an element; in a joint, what does not depend on its type.
        motion: what else it looks at in joints, by their type.
        needed, optional: attributes by element.
        takes: whether it takes a text for so many numbers, of an attribute.
        once: whether it refuses an element twice in one place, or else takes the first.
        shapes: the kinds of shapes in which it wants one that it knows.
    """

    children: Mapping[str, Tags]
    motion: Mapping[str, Tags]
    needed: Mapping[str, Tags]
    optional: Mapping[str, Tags]
    takes: Callable[[str, int, str], bool]
    once: bool
    shapes: Tags

    def refused(self, context: Context) -> list[Found]:
        """Return what it refuses, at the attribute or element."""
        found: list[Found] = []
        owners: tuple[LinkView | JointView, ...] = (*context.view.links, *context.view.joints)
        for owner in owners:
            self._within(owner.element, named(owner), found)
        for element in context.view.root.findall("material"):
            self._within(element, "the robot", found)
        return found

    def _within(self, element: Element, where: str, found: list[Found]) -> None:
        self._attributes(element, where, found)
        looks = self.children.get(element.tag, ())
        if element.tag == "joint":
            looks += self.motion.get(element.get("type") or "", ())
        seen = set()
        for child in element.children if looks else ():
            tag = child.tag
            if tag not in looks:
                continue
            if tag in seen and tag not in KINDS[element.tag].repeated:
                if self.once:
                    found.append(Found(child.span, f"a second <{tag}> in {where}"))
                continue
            seen.add(tag)
            self._within(child, where, found)
        if element.tag in self.shapes and not any(child.tag in SHAPES for child in _geometry(element)):
            found.append(Found(element.span, f"a <{element.tag}> without a shape in {where}"))

    def _attributes(self, element: Element, where: str, found: list[Found]) -> None:
        needed, values = self.needed.get(element.tag, ()), element.values
        for name in needed:
            if name not in values:
                found.append(Found(element.span, f"<{element.tag}> without {name} in {where}"))
        for name in (*needed, *self.optional.get(element.tag, ())):
            text = values.get(name)
            count = 0 if text is None else KINDS[element.tag].attributes[name]
            if text is not None and count and _plainly(text) != count and not self.takes(text, count, name):
                found.append(Found(value_span(element, name), f'{name}="{text}" in {where}'))


def _geometry(element: Element) -> list[Element]:
    found = element.find("geometry")
    return [] if found is None else found.children


def _all_numbers(text: str, count: int, _: str) -> bool:
    words = text.split()
    return len(words) == count and all(map(_NUMBER.fullmatch, words))


def _finite(text: str, count: int, name: str) -> bool:
    """Return whether they are finite; a single one may have something behind it, and a scale may be one number."""
    words = text.split()
    if len(words) != count and not (name == "scale" and len(words) == 1):
        return False
    found = [_NUMBER.match(word) if count == 1 else _NUMBER.fullmatch(word) for word in words]
    return all(match is not None and isfinite(float(match[0])) for match in found)


@lru_cache(maxsize=1 << 14)
def _plainly(text: str) -> int:
    """Return how many finite numbers a text holds, by the quickest test; -1 where that has to be looked at closer."""
    words = text.split()
    try:
        return len(words) if all(map(isfinite, map(float, words))) and "_" not in text else -1
    except ValueError:
        return -1


_SHAPE_SIZES = {**SIZES, "mesh": ("filename",)}
_INERTIAL = {"inertial": ("origin", "mass", "inertia"), "geometry": SHAPES, "material": ("color",)}
_ORIGIN = {"origin": ("xyz", "rpy"), "mesh": ("scale",), "dynamics": ("damping", "friction")}
_LIMITED = ("revolute", "continuous", "prismatic")

MUJOCO = Grammar(
    children={
        **_INERTIAL,
        "link": ("inertial", "visual", "collision"),
        "visual": ("material",),
        "collision": ("origin", "geometry"),
        "joint": ("parent", "child", "origin", "axis"),
    },
    motion=dict.fromkeys((*_LIMITED, "planar", "floating"), _MOTION),
    needed={"mass": ("value",), "inertia": INERTIA, "axis": ("xyz",), "color": ("rgba",), **_SHAPE_SIZES},
    optional={**_ORIGIN, "limit": ("lower", "upper", "effort")},
    takes=_all_numbers,
    once=True,
    shapes=("collision",),
)
DRAKE = Grammar(
    children={
        **_INERTIAL,
        "link": ("inertial", "visual", "collision"),
        "visual": ("origin", "geometry", "material"),
        "collision": ("origin", "geometry"),
        "joint": ("origin",),
    },
    motion={**dict.fromkeys(_LIMITED, ("axis", *_MOTION)), "planar": ("axis",)},
    needed={"color": ("rgba",), **_SHAPE_SIZES},
    optional={
        **_ORIGIN,
        "mass": ("value",),
        "inertia": INERTIA,
        "axis": ("xyz",),
        "limit": ("lower", "upper", "effort", "velocity"),
    },
    takes=_finite,
    once=False,
    shapes=("visual", "collision"),
)
