"""The calibrated description: the original text in which nothing but inertials and friction is edited."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from robodyn.errors import InputError
from robodyn.identification.link_inertias import link_inertias
from robodyn.robot.model import Joint, Model
from robodyn.robot.urdf.document import Document, read_document
from robodyn.robot.urdf.edits import Edit, edited, with_attributes, with_comment, with_first_child
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.packages import EXPANDED, Search
from robodyn.robot.urdf.parts import INERTIA, Description
from robodyn.robot.urdf.view import LinkView, View
from robodyn.solids.inertia.conversions import inertial_element
from robodyn.solids.inertia.properties import MassProperties
from robodyn.support.floats import Floats
from robodyn.support.wording import count, listed, shown_path


class Calibrated(NamedTuple):
    """The text, and notes on what is not as one might expect, a line each."""

    data: bytes
    notes: tuple[str, ...]


def calibrated_urdf(
    model: Model,
    names: Sequence[str],
    described: Floats,
    theta: Floats,
    *,
    comment: Sequence[str] = (),
    friction: bool = False,
) -> Calibrated:
    """Return the description's text with the inertials of bodies that theta changes, every other byte as it was.

    See `link_inertias` for links fixed to each other. Inertias stand in the axes of their links. Numbers are the
    shortest that read back as the same floats. Of a xacro file it is the expanded text.

    Args:
        names, described, theta: of `robodyn.regressor`, before and after identification.
        comment: lines of a comment at the top.
        friction: edit `<dynamics>`, too: `damping` is viscous and `friction` is (forward - backward) / 2.

    Raises:
        InputError: the file is UTF-16, or as `link_inertias`.

    Accuracy: bodies of the text have theta within 1e-12 of the largest parameter of a kind, joints exactly.
    """
    description, document = _source(model)
    view, found = View(document.root), link_inertias(model, described, theta)
    edits = [with_comment(document.data, comment)] if comment else []
    for name, body in found.bodies.items():
        edits += _inertial(view.link[name], body)
    notes = list(found.notes)
    if friction:
        changes, lopsided = _dynamics(model, view, dict(zip(names, theta.tolist(), strict=True)))
        edits += changes
        if lopsided:
            why = "which differs forwards and backwards: a scene can say it"
            notes.append(f"<dynamics friction> is the mean of the friction of {listed(lopsided)}, {why}")
    if description.file.endswith(EXPANDED):
        notes.append("the description is xacro; this is its expansion, to which macros and arguments are lost")
    return Calibrated(edited(document.data, edits, document.encoding), tuple(notes))


def lost_meshes(description: Description, path: str) -> str | None:
    """Return a line on meshes that a description loses when it is written to another folder; None if none is lost."""
    names = list(dict.fromkeys(g.filename for link in description.links for g in link.geometries if g.filename))
    there = Search(path, description.search.package_paths)
    lost = [name for name in names if (old := description.search.find(name)) and not _same(old, there.find(name))]
    if not lost:
        return None
    folder = os.path.dirname(description.file.removesuffix(EXPANDED)) or os.curdir
    what = f"{count(len(lost), 'mesh', 'meshes')} of {len(names)} will not be found beside {shown_path(path)}"
    return f"{what}, by the names that the description has: write it into {shown_path(folder)}"


def _same(old: os.PathLike[str], new: os.PathLike[str] | None) -> bool:
    return new is not None and os.path.samefile(old, new)


def _source(model: Model) -> tuple[Description, Document]:
    description = model.description
    assert description is not None, "models are made of descriptions"
    document = read_document(description.data, description.file)
    if document.data != description.data:
        raise InputError("the file is UTF-16 and cannot be edited", remedy="save it as UTF-8", file=description.file)
    return description, document


def _inertial(link: LinkView, body: MassProperties) -> Iterator[Edit]:
    """Yield the edits that give a link these mass properties."""
    lines = inertial_element(body, "").splitlines()
    if link.inertial is None:
        yield with_first_child(link.element, lines)
        return
    element, I, missing = link.inertial.element, body.inertia, list[str]()
    products = (I[0, 0], I[0, 1], I[0, 2], I[1, 1], I[1, 2], I[2, 2])
    origin = {"xyz": _numbers(*body.com)}
    if any(link.inertial.origin.rpy.or_default(0.0) or ()):
        origin["rpy"] = "0 0 0"
    inertia = {name: _numbers(value) for name, value in zip(INERTIA, products, strict=True)}
    children = {"origin": origin, "mass": {"value": _numbers(body.mass)}, "inertia": inertia}
    for line, (tag, values) in zip(lines[1:-1], children.items(), strict=True):
        child = element.find(tag)
        if child is None:
            missing.append(line.strip())
        else:
            yield from with_attributes(child, values)
    if missing:
        yield with_first_child(element, missing)


def _dynamics(model: Model, view: View, theta: dict[str, float]) -> tuple[list[Edit], list[str]]:
    """Return the edits of friction, and the joints of which that does not say all."""
    edits, lopsided = list[Edit](), list[str]()
    for body in model.bodies:
        joint = body.joint
        if f"{joint.name}.viscous" not in theta or joint.name not in view.joint:
            continue
        viscous, forward, backward = (theta[f"{joint.name}.{part}"] for part in ("viscous", "forward", "backward"))
        dry = (forward - backward) / 2.0
        edits += _friction(view.joint[joint.name].element, joint, viscous, dry)
        if forward != -backward:
            lopsided.append(joint.name)
    return edits, lopsided


def _friction(element: Element, joint: Joint, viscous: float, dry: float) -> Iterator[Edit]:
    """Yield the edits that give a joint this damping and friction, if it has others."""
    if (viscous, dry) == (joint.damping, joint.friction):
        return
    child, values = element.find("dynamics"), {"damping": _numbers(viscous), "friction": _numbers(dry)}
    if child is None:
        yield with_first_child(element, [f'<dynamics damping="{values["damping"]}" friction="{values["friction"]}"/>'])
    else:
        yield from with_attributes(child, values)


def _numbers(*values: float) -> str:
    return " ".join(repr(float(value)) for value in values)
