"""Description -> URDF: a URDF by edits that leave every other byte as it is, of another format a new text."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import Any
from xml.sax.saxutils import escape

from robodyn.errors import InputError
from robodyn.robot.urdf import parts
from robodyn.robot.urdf.description import _REDUCTIONS, _ROTOR_INERTIAS, read_urdf
from robodyn.robot.urdf.document import Element, read_document
from robodyn.robot.urdf.edits import Edit, edited, with_attributes, with_comment, with_first_child
from robodyn.robot.urdf.parts import Description, Geometry, Joint, Link, Origin, Transmission
from robodyn.robot.urdf.sources import EXPANDED, Search
from robodyn.robot.write.common import MARK, Written, check_possible, comments_of, tag, text
from robodyn.support.wording import listed

_LOOPS = {"weld": "fixed", "hinge": "revolute", "point": "spherical"}


def write_urdf(description: Description, out: str) -> Written:
    """Return the URDF of a description for a file of this name.

    Names of meshes that are relative to the folder of the source are made relative to that of `out`.

    Raises:
        DescriptionError: a link is impossible.
        InputError: the source is UTF-16.
    """
    check_possible(description)
    lines, lost = _constraints(description)
    for key, what in (("gravity", "gravity"), ("spring", "springs"), ("base", "a base that moves")):
        if key in description.scene:
            lost.append(f"{what} {listed(list(description.scene['spring']))}" if key == "spring" else what)
    if description.file.endswith(EXPANDED):
        lost.append("macros and arguments of xacro, whose expansion it is")
    if description.format != "urdf":
        return Written(new_urdf(description, out, [line for _, line in lines]).encode(), lost, {})
    return Written(_edited(description, out, lines), lost, {})


def _edited(description: Description, out: str, more: list[tuple[str, str]]) -> bytes:
    """Return the source with what differs from it, and with elements that are new at its end."""
    document = read_document(description.data, description.file)
    if document.data != description.data:
        raise InputError("the file is UTF-16 and cannot be edited", remedy="save it as UTF-8", file=description.file)
    before, root = read_urdf(description.data, description.file, description.search.package_paths), document.root
    read: list[Any] = [*before.links, *before.joints, *before.transmissions]
    old = {(type(each), each.name): each for each in read}
    edits = [] if MARK.encode() in document.data else [with_comment(document.data, [MARK.strip()])]
    there, lines = {each.get("name") for each in root.findall("constraint")}, list[str]()
    for link in description.links:
        lines += [] if (Link, link.name) in old else _link(link, out, description.search)
    for joint in description.joints:
        was = old.get((Joint, joint.name))
        if isinstance(was, Joint) and (was.damping, was.friction) != (joint.damping, joint.friction):
            edits += _dynamics(_named(root, "joint", joint.name), joint)
        lines += [] if was else _joint(joint)
    for each in description.transmissions:
        driven = old.get((Transmission, each.name))
        if isinstance(driven, Transmission):
            edits += _motor(_named(root, "transmission", each.name), driven, each)
        else:
            lines += _transmission(each)
    for element in root.walk():
        name = element.get("filename")
        if element.tag == "mesh" and name and (new := relative(description.search, name, out)) != name:
            edits += with_attributes(element, {"filename": escape(new, {'"': "&quot;"})})
    data = edited(document.data, edits, document.encoding)
    lines += [line for name, line in more if name not in there]
    end = data.rindex(b"</") if lines else len(data)
    added = "".join(f"  {line}\n" for line in lines)
    return data[:end] + added.encode(document.encoding, "xmlcharrefreplace") + data[end:]


def relative(search: Search, name: str, out: str) -> str:
    """Return the name of a mesh as a file of another folder says it; packages, absolute names and what is not found
    stay."""
    path = None if "://" in name or os.path.isabs(name) else search.find(name)
    there = os.path.join(os.path.dirname(out) or os.curdir, name)
    if path is None or (os.path.exists(there) and os.path.samefile(path, there)):
        return name
    return os.path.relpath(path, os.path.dirname(out) or os.curdir).replace(os.sep, "/")


def _named(root: Element, kind: str, name: str) -> Element:
    return next(each for each in root.findall(kind) if (each.get("name") or "") == name)


def _dynamics(element: Element, joint: Joint) -> Iterator[Edit]:
    values, child = {"damping": text(joint.damping), "friction": text(joint.friction)}, element.find("dynamics")
    if child is None:
        yield with_first_child(element, [tag("dynamics", **values)])
    else:
        yield from with_attributes(child, values)


def _motor(element: Element, was: Transmission, now: Transmission) -> Iterator[Edit]:
    """Yield the edits that give a transmission another reduction and rotor."""
    places, lines = [*element.findall("actuator"), *element.findall("joint"), element], list[str]()
    for tags, before, value in (
        (_REDUCTIONS, was.reduction, now.reduction),
        (_ROTOR_INERTIAS, was.rotor_inertia, now.rotor_inertia),
    ):
        found = [child for place in places for child in place.children if child.tag in tags]
        if value is None or before == value:
            continue
        lines += [] if found else [f"<{tags[0]}>{text(value)}</{tags[0]}>"]
        for child in found:
            end = child.span.end
            if child.get("value") is not None:
                yield from with_attributes(child, {"value": text(value)})
            else:
                yield Edit(end, child.positions.data.index(b"<", end), text(value))
    if lines:
        yield with_first_child(places[0], lines)


def new_urdf(description: Description, out: str, more: Sequence[str] = ()) -> str:
    """Return the URDF of a description of any format, for a file of this name, with more elements at its end."""
    comments, lines = comments_of(description.data) if description.data else {}, list[str]()
    lines += [f"<!--{each}-->" for each in dict.fromkeys([MARK, *comments.get(("", ""), [])])]
    lines.append(tag("robot", ">", name=description.name or "robot"))
    for link in description.links:
        said = [each for kind in ("body", "link") for each in comments.get((kind, link.name), [])]
        lines += [*(f"  <!--{each}-->" for each in said), *_indented(_link(link, out, description.search))]
    for joint in description.joints:
        said = comments.get(("joint", joint.name), [])
        lines += [*(f"  <!--{each}-->" for each in said), *_indented(_joint(joint))]
    for each in description.transmissions:
        lines += _indented(_transmission(each))
    return "\n".join(['<?xml version="1.0"?>', *lines, *_indented([*more]), "</robot>", ""])


def _indented(lines: list[str]) -> list[str]:
    return [f"  {line}" for line in lines]


def _origin(origin: Origin) -> list[str]:
    if origin == Origin():
        return []
    return [tag("origin", xyz=origin.xyz, rpy=origin.rpy if any(origin.rpy) else None)]


def _link(link: Link, out: str, search: Search) -> list[str]:
    body: list[str] = []
    if link.inertial is not None:
        values = dict(zip(parts.INERTIA, link.inertial.inertia, strict=True))
        own = [*_origin(link.inertial.origin), tag("mass", value=link.inertial.mass), tag("inertia", **values)]
        body += ["<inertial>", *_indented(own), "</inertial>"]
    for each in link.geometries:
        own = [*_origin(each.origin), "<geometry>", f"  {_shape(each, out, search)}", "</geometry>"]
        body += [f"<{each.kind}>", *_indented(own), f"</{each.kind}>"]
    return [tag("link", ">", name=link.name), *_indented(body), "</link>"] if body else [tag("link", name=link.name)]


def _shape(each: Geometry, out: str, search: Search) -> str:
    if each.shape == "mesh":
        name = relative(search, each.filename or "", out)
        return tag("mesh", filename=name, scale=None if each.scale == (1.0, 1.0, 1.0) else each.scale)
    names = parts.SIZES[each.shape]
    values: dict[str, Any] = {"size": each.size} if each.shape == "box" else dict(zip(names, each.size, strict=True))
    return tag(each.shape, **values)


def _joint(joint: Joint) -> list[str]:
    body = [*_origin(joint.origin), tag("parent", link=joint.parent), tag("child", link=joint.child)]
    if joint.type in parts.WITH_AXIS or joint.axis != (1.0, 0.0, 0.0):
        body.append(tag("axis", xyz=joint.axis))
    if (limit := joint.limit) is not None:
        said = {"lower": limit.lower, "upper": limit.upper, "effort": limit.effort, "velocity": limit.velocity}
        body.append(tag("limit", **said))
    if joint.damping or joint.friction:
        body.append(tag("dynamics", damping=joint.damping, friction=joint.friction))
    if (mimic := joint.mimic) is not None:
        body.append(tag("mimic", joint=mimic.joint, multiplier=mimic.multiplier, offset=mimic.offset))
    return [tag("joint", ">", name=joint.name, type=joint.type), *_indented(body), "</joint>"]


def _transmission(each: Transmission) -> list[str]:
    inner = [f"  <mechanicalReduction>{text(each.reduction)}</mechanicalReduction>"]
    inner += [] if each.rotor_inertia is None else [f"  <rotorInertia>{text(each.rotor_inertia)}</rotorInertia>"]
    actuator = [tag("actuator", ">", name=f"{each.joint}_motor"), *inner, "</actuator>"]
    lines = ["<type>transmission_interface/SimpleTransmission</type>", tag("joint", name=each.joint), *actuator]
    return [tag("transmission", ">", name=each.name), *_indented(lines), "</transmission>"]


def _constraints(description: Description) -> tuple[list[tuple[str, str]], list[str]]:
    """Return the loops by name as <constraint> elements, and what is lost of them."""
    names, lines, lost = {link.name for link in description.links}, list[tuple[str, str]](), list[str]()
    for loop in description.scene.get("loop", []):
        if loop["to"] not in names or loop.get("directions"):
            lost.append(f"the loop {loop['name']}, to the ground or held along some directions")
            continue
        kind, rpy = loop["kind"], loop.get("rpy") if loop["kind"] == "weld" else None
        inner = [tag("constraint", ">", name=loop["name"], type=_LOOPS[kind])]
        for role, end, point, axis, turn in (
            ("parent", "to", "to_point", "to_axis", rpy),
            ("child", "link", "point", "axis", None),
        ):
            inner += [tag(role, link=loop[end]), tag(f"{role}_origin", xyz=loop.get(point, parts.ZERO), rpy=turn)]
            inner += [tag(f"{role}_axis", xyz=loop[axis])] if kind == "hinge" else []
        lines.append((loop["name"], "".join([*inner, "</constraint>"])))
    return lines, lost
