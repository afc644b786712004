"""`info`: a description at a glance: counts and mass, the tree, meshes, findings, and what to run next."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from robodyn.checks.overview import Branch, Overview
from robodyn.programs.vectors import product
from robodyn.report.check import check_data, check_line
from robodyn.report.document import Section, Table, paragraphs, select, written
from robodyn.report.table import axis_text, number, point_text
from robodyn.robot.urdf.parts import Limit
from robodyn.support.wording import count, shown

if TYPE_CHECKING:
    from robodyn.checks.overview import Overview


_UNITS = {"prismatic": ("m", "N", "m/s")}
_ANGULAR = ("rad", "N m", "rad/s")
_MOST_MISSING = 5
_DEEPEST = 40


def overview_sections(found: Overview) -> Iterator[Section]:
    """Yield counts and mass, the tree as a table, then meshes, findings and what to run next."""
    branches, merged, kinds = found.branches, found.types.get("fixed", 0), found.types.items()
    joints = ", ".join(f"{amount} {kind}" for kind, amount in kinds)
    lines = [f"{found.file}: robot {shown(found.name)}", f"links: {len(branches)}, {found.massive} with mass"]
    lines.append(f"joints: {sum(found.types.values())}{joints and f' ({joints})'}")
    freedoms = f"degrees of freedom: {found.freedoms}"
    if found.base_freedoms:
        freedoms += f", {found.base_freedoms} of them the base's"
    if merged:
        freedoms += f"; {count(merged, 'fixed joint is', 'fixed joints are')} merged"
    if found.mimics:
        freedoms += f"; {count(found.mimics, 'joint mimics another', 'joints mimic others')}"
    if found.loops:
        freedoms += f"; of the open tree, which {count(found.loops, '<constraint> closes', '<constraint>s close')}"
    centre = ""
    if found.com is not None:
        values = ", ".join(f"{name} {value:.6g}" for name, value in found.moved.items())
        where = "where every joint is zero" + (f" or at its limit nearest to zero: {values}" if values else "")
        point = point_text(found.com, float(np.abs(found.com).max()))
        centre = f", centre of mass {point} m in the frame of {shown(found.base)}, {where}"
    mass = f"mass: {number(found.mass)} kg{centre}"
    yield paragraphs([*lines, freedoms, mass, *(f"note: {note}" for note in found.notes)])
    deepest = max(branch.depth for branch in branches)
    step = 2 if deepest <= _DEEPEST // 2 else 1
    rows = [_row(branch, min(branch.depth * step, _DEEPEST)) for branch in branches]
    head = ["link", "mass [kg]", "joint", "type", "axis", "lower", "upper", "effort", "velocity", "mimics"]
    kept = [k for k in range(len(head)) if k < 2 or any(row[k] for row in rows)]
    yield [Table("", [head[k] for k in kept], [[row[k] for k in kept] for row in rows])]
    meshes = found.meshes
    missing = len(meshes.missing)
    lines = (
        [f"meshes: {meshes.references} in {count(meshes.names, 'file')}, "] if meshes.references else ["meshes: none"]
    )
    if meshes.references:
        lines[0] += f"{missing} not found:" if missing else "all found"
    for link, geometry in meshes.missing[:_MOST_MISSING]:
        lines.append(f"  {geometry.filename} (link {shown(link)}, line {geometry.line})")
    lines += [f"  and {missing - _MOST_MISSING} more"] if missing > _MOST_MISSING else []
    yield paragraphs([*lines, f"check: {check_line(found.checked)}"])
    if found.next:
        yield paragraphs(["next:", *(f"  {command}" for command in found.next)])


def _row(branch: Branch, indent: int) -> list[str]:
    """Return a link's row; - where a limit is to be expected but not given."""
    mass, joint = "" if branch.mass is None else number(branch.mass), branch.joint
    row = [" " * indent + branch.name, mass]
    if joint is None:
        return [*row, *[""] * 8]
    axis, mimic = "", ""
    if joint.type not in ("fixed", "floating"):
        direction = np.array(joint.axis) / max(map(abs, joint.axis))
        direction = direction / np.sqrt(product(direction, direction))
        along = np.count_nonzero(direction) <= 1  # a letter stands for an axis of the joint's frame
        axis = axis_text(direction.tolist()) if along else f"({', '.join(f'{value:.4g}' for value in direction)})"
    if joint.mimic is not None:
        factor, offset = joint.mimic.multiplier, joint.mimic.offset
        mimic = joint.mimic.joint + ("" if factor == 1 else f" * {factor:.6g}")
        mimic += f" {'+' if offset > 0 else '-'} {abs(offset):.6g}" if offset else ""
    limits = [""] * 4
    if joint.type in ("revolute", "prismatic", "continuous"):
        length, effort, speed = _UNITS.get(joint.type, _ANGULAR)
        limit = joint.limit or Limit()
        units = {"lower": "", "upper": f" {length}", "effort": f" {effort}", "velocity": f" {speed}"}
        values = ((getattr(limit, name), unit) for name, unit in units.items())
        limits = ["-" if value is None else number(value) + unit for value, unit in values]
        if joint.type == "continuous":
            limits[:2] = "", ""
    return [*row, joint.name, joint.type, axis, *limits, mimic]


def overview_json(found: Overview) -> str:
    """Return a description at a glance; links and joints stand depth first."""
    counts = select(
        found,
        "links links_with_mass:massive joints joints_by_type:types mimic_joints:mimics loops merged_fixed_joints "
        "degrees_of_freedom:freedoms base_degrees_of_freedom:base_freedoms",
        links=len(found.branches),
        joints=sum(found.types.values()),
        merged_fixed_joints=found.types.get("fixed", 0),
    )
    limits = " ".join(f"{name}:limit.{name}" for name in ("lower", "upper", "effort", "velocity"))
    keys, joints = f"name line type parent child axis {limits} mimic[joint multiplier offset]", []
    for joint in (branch.joint for branch in found.branches if branch.joint):
        joints.append(select(joint, keys, axis=None if joint.type in ("fixed", "floating") else joint.axis))
    missing = [{"link": link, **select(each, "kind filename line")} for link, each in found.meshes.missing]
    return written(
        select(
            found,
            "robot:name file counts mass? com com_frame:base at at_zero links:branches[name line depth mass "
            "joint:joint.name] joints meshes check notes next",
            counts=counts,
            at_zero=not found.moved,
            joints=joints,
            meshes=select(found.meshes, "references files:names missing", missing=missing),
            check=check_data(found.checked),
        )
    )
