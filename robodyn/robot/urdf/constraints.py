"""The <constraint> elements of a description: what the proposal for URDF says closes its loops."""

from __future__ import annotations

from dataclasses import dataclass

from robodyn.robot.urdf.document import read_document
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import numbers
from robodyn.robot.urdf.parts import ZERO, Description, Origin, Vector
from robodyn.robot.urdf.strict import Strict
from robodyn.robot.urdf.structure import by_name
from robodyn.support.wording import alternatives, shown

TAG = "constraint"
AXIS: Vector = (1.0, 0.0, 0.0)
"""What is taken where there is none, as for a joint."""


@dataclass(frozen=True, slots=True)
class Constraint:
    """A joint that closes a loop: it ties a frame of one link to a frame of another.

    Attributes:
        type: of a joint; the proposal does not list them.
        parent, child: links.
        parent_origin, child_origin: the frames, in those of the links.
        parent_axis, child_axis: as written, in the axes of the frames.
    """

    name: str
    type: str
    parent: str
    parent_origin: Origin
    parent_axis: Vector
    child: str
    child_origin: Origin
    child_axis: Vector
    line: int


def constraint_count(description: Description) -> int:
    """Return how many there are, whatever they say."""
    return len(_elements(description))


def read_constraints(description: Description) -> tuple[Constraint, ...]:
    """Return the constraints in the order of the file.

    Source: the proposal to urdfdom_headers, pull request 108: elements of <robot> beside its joints.

    Raises:
        DescriptionError: a name is missing, twice there or refers to nothing; a number is none; with the line.
    """
    strict = Strict(description.file)
    links = [link.name for link in description.links]
    found = (_constraint(element, links, strict) for element in _elements(description))
    return tuple(by_name(found, TAG, strict).values())


def _elements(description: Description) -> list[Element]:
    if b"<" + TAG.encode() not in description.data:
        return []
    return read_document(description.data, description.file).root.findall(TAG)


def _constraint(element: Element, links: list[str], strict: Strict) -> Constraint:
    name = strict.text(element, "name", f"<{TAG}>")
    owner = f"{TAG} {shown(name)}"
    ends = {}
    for role in ("parent", "child"):
        link = strict.text(strict.needed_child(element, role, owner), "link", owner)
        if link not in links:
            what = f"the {role} of {owner} is link {shown(link)}, which does not exist"
            raise strict.error(element.line, what, alternatives(link, links, "links"))
        ends[role] = link
    return Constraint(
        name,
        strict.text(element, "type", owner),
        ends["parent"],
        _origin(element, "parent_origin", owner, strict),
        _vector(element, "parent_axis", "xyz", owner, strict, AXIS),
        ends["child"],
        _origin(element, "child_origin", owner, strict),
        _vector(element, "child_axis", "xyz", owner, strict, AXIS),
        element.line,
    )


def _origin(element: Element, tag: str, owner: str, strict: Strict) -> Origin:
    xyz, rpy = (_vector(element, tag, name, owner, strict, ZERO) for name in ("xyz", "rpy"))
    return Origin(xyz, rpy)


def _vector(element: Element, tag: str, name: str, owner: str, strict: Strict, default: Vector) -> Vector:
    part = strict.child(element, tag, owner)
    return default if part is None else strict.vector(numbers(part, name, 3), owner, *default)
