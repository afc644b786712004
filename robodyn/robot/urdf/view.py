"""Links, joints and numbers of a document as far as they can be read: nothing here raises, what is missing or
unreadable is None, what is wrong with a number is data. Of several children with one tag the first counts, as in
urdfdom. Rules report the faults; strict reading (`description`) raises the first."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from typing import Any, Generic, TypeVar

from robodyn.robot.urdf.document import Element, Span
from robodyn.robot.urdf.parts import INERTIA, JOINT_TYPES, SHAPES, SIZES
from robodyn.support.floats import LARGEST, SMALLEST
from robodyn.support.wording import shown

TEXT = ""
"""The name that stands for the text of an element where its attributes are named."""
_UNBOUNDED = ("limit", "safety_controller", "lower", "upper", "effort", "velocity")
"""Elements in which files write the largest float for no limit at all."""
_MOVING = frozenset(JOINT_TYPES) - {"fixed"}
T = TypeVar("T")
P = TypeVar("P")
N = TypeVar("N", bound="_Named")


class NumbersError(ValueError):
    """What is wrong, and as `remedy` what to write."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(what)
        self.remedy = remedy


def parse_numbers(text: str, count: int, tag: str = "") -> tuple[float, ...]:
    """Return exactly `count` finite numbers of an element with this tag; NumbersError with what is wrong and what to
    write. What is next to nothing is 0, but of axes, which are made to unit vectors; limits may be of any size. What
    float() takes beyond URDF (`1_000`, `inf`, `nan`, digits outside ASCII) is refused."""
    return (_parsed_before if len(text) <= _SHORT else _parsed)(text, count, tag)


def _parsed(text: str, count: int, tag: str) -> tuple[float, ...]:
    words = text.split()
    try:
        numbers = tuple(map(float, words))
    except ValueError:
        raise _not_numbers(text) from None
    if "_" in text or not text.isascii():
        raise _not_numbers(text)
    if len(numbers) != count:
        wanted = "one number" if count == 1 else f"{count} numbers with blanks between them"
        raise NumbersError(f"has {len(numbers)} numbers, not {count}: {shown(text)}", f"write {wanted}")
    for number in numbers:
        if not isfinite(number):
            raise NumbersError(f"is not finite: {shown(text)}", "write a finite number")
        if abs(number) > LARGEST and tag not in _UNBOUNDED:
            raise NumbersError(f"is too large: {shown(text)}", f"nothing of a robot exceeds {LARGEST:g} in SI units")
    return tuple(number if abs(number) >= SMALLEST or not number or tag == "axis" else 0.0 for number in numbers)


_SHORT = 80
_parsed_before = lru_cache(maxsize=1 << 14)(_parsed)
"""For short texts: rules and strict reading ask for the same, and most of a description is "0 0 0" and the like."""


def _not_numbers(text: str) -> NumbersError:
    strange = next((character for character in text if not character.isascii()), None)
    if strange is not None:
        name = f"{unicodedata.name(strange, 'a character').lower()} (U+{ord(strange):04X})"
        better = "a hyphen for minus" if strange in "\u2212\u2013" else "ASCII"
        better = "a plain blank" if strange.isspace() else better
        article = "an" if name[0] in "aeiou" else "a"
        return NumbersError(f"has {article} {name}: {shown(text)}", f"write {better} in its place")
    if "," in text:
        return NumbersError(f"has a comma: {shown(text)}", "separate numbers with blanks and write a decimal point")
    return NumbersError(f"is not a number: {shown(text)}", "write a decimal number such as -1.5e-3")


@dataclass(slots=True, eq=False)
class Numbers:
    """The numbers of one attribute, or what is wrong with them: `values` is None where it is absent or has a `problem`,
    `element` where that of the attribute is absent, too."""

    element: Element | None
    attribute: str
    given: bool
    values: tuple[float, ...] | None = None
    problem: NumbersError | None = None

    @property
    def value(self) -> float | None:
        """The first number, which of most attributes is the only one."""
        return None if self.values is None else self.values[0]

    @property
    def span(self) -> Span:
        """What stands between the quotes; of an absent attribute the element's start tag."""
        assert self.element is not None, "a number without an element has no place"
        return value_span(self.element, self.attribute)

    def or_default(self, *default: float) -> tuple[float, ...] | None:
        """Return the values; the default where the attribute is absent; None where it cannot be read."""
        return self.values if self.given else default


def numbers(element: Element | None, attribute: str, count: int) -> Numbers:
    """Return the numbers of an attribute, or of the element's `TEXT`, with what is wrong with them as data."""
    text = None if element is None else element.text if attribute == TEXT else element.values.get(attribute)
    if element is None or text is None:
        return Numbers(element, attribute, False)
    try:
        return Numbers(element, attribute, True, parse_numbers(text, count, element.tag))
    except NumbersError as error:
        return Numbers(element, attribute, True, None, error)


def value_span(element: Element, attribute: str) -> Span:
    """Return what stands between the quotes of an attribute; the start tag where it is absent."""
    found = element.attributes.get(attribute)
    return element.span if found is None else found.value_span


@dataclass(frozen=True, slots=True)
class Subject:
    """The part of the robot that a finding is about: its kind (robot, link, joint, ...) and its name."""

    kind: str
    name: str

    @property
    def words(self) -> str:
        """`link 'arm'`"""
        return f"{self.kind} {shown(self.name)}"


class Kept(Generic[T]):
    """A property that is computed when it is first asked for, and kept: `cached_property` without its lock."""

    def __init__(self, read: Callable[[Any], T]) -> None:
        self._read = read

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, part: Any, owner: type) -> T:
        part.__dict__[self._name] = value = self._read(part)
        return value


def _number(name: str, count: int = 1, child: str = "") -> Kept[Numbers]:
    return Kept(lambda part: numbers(part.element.find(child) if child else part.element, name, count))


def _text(name: str, child: str = "") -> Kept[str]:
    def read(part: Part) -> str:
        element = part.element.find(child) if child else part.element
        return (element and element.get(name)) or ""

    return Kept(read)


def _child(tag: str, kind: Callable[[Element], P]) -> Kept[P | None]:
    return Kept(lambda part: None if (found := part.element.find(tag)) is None else kind(found))


class OriginView:
    """A pose: of an absent element or attribute, zero."""

    xyz = _number("xyz", 3)
    rpy = _number("rpy", 3)

    def __init__(self, owner: Element) -> None:
        self.element = owner.find("origin")


class Part:
    """One element, and the pose in it."""

    def __init__(self, element: Element) -> None:
        self.element = element

    @Kept
    def origin(self) -> OriginView:
        return OriginView(self.element)


class InertialView(Part):
    mass = _number("value", child="mass")
    mass_element = _child("mass", lambda element: element)
    inertia_element = _child("inertia", lambda element: element)

    @Kept
    def entries(self) -> tuple[Numbers, ...]:
        return tuple(numbers(self.inertia_element, name, 1) for name in INERTIA)

    @Kept
    def tensor(self) -> tuple[float, ...] | None:
        """ixx, ixy, ixz, iyy, iyz, izz [kg m^2], if all six can be read."""
        values = tuple(entry.values[0] for entry in self.entries if entry.values is not None)
        return values if len(values) == len(INERTIA) else None


class GeometryView(Part):
    """<visual> or <collision> (`kind`), and the first shape in it."""

    @property
    def kind(self) -> str:
        return self.element.tag

    @Kept
    def shape(self) -> Element | None:
        found = self.element.find("geometry")
        return None if found is None else next((child for child in found.children if child.tag in SHAPES), None)

    @property
    def tag(self) -> str:
        """What the shape is; empty without one."""
        return "" if self.shape is None else self.shape.tag

    @property
    def uri(self) -> str:
        """The file of a mesh; empty where it names none."""
        return ("" if self.shape is None else self.shape.get("filename")) or ""

    @Kept
    def sizes(self) -> tuple[Numbers, ...]:
        return tuple(numbers(self.shape, name, 3 if name == "size" else 1) for name in SIZES.get(self.tag, ()))

    @Kept
    def scale(self) -> Numbers:
        return numbers(self.shape, "scale", 3)


class LimitView(Part):
    lower = _number("lower")
    upper = _number("upper")
    effort = _number("effort")
    velocity = _number("velocity")

    @property
    def range(self) -> tuple[float, float] | None:
        """lower and upper, 0 where one is absent, as URDF has it; None where one cannot be read."""
        lower, upper = self.lower.or_default(0.0), self.upper.or_default(0.0)
        return None if lower is None or upper is None else (lower[0], upper[0])


class MimicView(Part):
    joint = _text("joint")
    multiplier = _number("multiplier")
    offset = _number("offset")


class _Named(Part):
    """<link> or <joint>; what is missing of its texts is empty."""

    name = _text("name")

    @property
    def subject(self) -> Subject:
        return Subject(self.element.tag, self.name)

    @property
    def name_span(self) -> Span:
        return value_span(self.element, "name")


class LinkView(_Named):
    inertial = _child("inertial", InertialView)

    @Kept
    def geometries(self) -> tuple[GeometryView, ...]:
        return tuple(GeometryView(child) for child in self.element.children if child.tag in ("visual", "collision"))

    @property
    def mass(self) -> float | None:
        """kg; 0 without an <inertial>; None where it is missing in one or cannot be read."""
        return 0.0 if self.inertial is None else self.inertial.mass.value

    @property
    def tensor(self) -> tuple[float, ...] | None:
        return None if self.inertial is None else self.inertial.tensor


class JointView(_Named):
    type = _text("type")
    parent = _text("link", "parent")
    child = _text("link", "child")
    axis = _number("xyz", 3, "axis")
    damping = _number("damping", child="dynamics")
    friction = _number("friction", child="dynamics")
    limit = _child("limit", LimitView)
    mimic = _child("mimic", MimicView)

    @property
    def moves(self) -> bool:
        return self.type in _MOVING


class View:
    """`links` and `joints` in the order of the file; `link` and `joint` by name, the first of each name."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self.links = tuple(LinkView(element) for element in root.children if element.tag == "link")
        self.joints = tuple(JointView(element) for element in root.children if element.tag == "joint")
        self.link, self.joint = _by_name(self.links), _by_name(self.joints)


def _by_name(parts: Sequence[N]) -> dict[str, N]:
    named: dict[str, N] = {}
    for part in parts:
        if part.name:
            named.setdefault(part.name, part)
    return named
