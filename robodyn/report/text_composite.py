"""Composite bodies as text for a person: combined meshes, a link, a robot at a configuration."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from robodyn.report.check_words import check_line
from robodyn.report.table import PLAIN, Page, number, printable
from robodyn.report.text_body import AXES, inertia_table, point_text, principal_table
from robodyn.robot.masses.declared import LinkInertia, RobotInertia
from robodyn.robot.masses.from_shapes import LinkShapes
from robodyn.solids.composite_mass import Combination
from robodyn.solids.inertia.properties import MassProperties
from robodyn.solids.inertia.validity import Validity, validity
from robodyn.solids.inertia.view import View
from robodyn.support.floats import ranked

if TYPE_CHECKING:
    from robodyn.checks.run import Checked

_PLACED = tuple(f"{axis} [m]" for axis in AXES)


def combination_text(found: Combination, view: View, page: Page = PLAIN) -> str:
    """The parts by mass, and the body that they make."""
    reach = float(np.abs(found.box).max())
    rows = [
        (part.name, *_weights(body, found.body), number(part.body.volume or 0.0), *_point(body, reach))
        for part, body in zip(found.parts, found.placed, strict=True)
    ]
    head = ("part", "mass [kg]", "share [%]", "volume [m^3]", *_PLACED)
    assumed = ", at an assumed density" if any(part.assumed for part in found.parts) else ""
    lines = [f"repaired: {part.name}: {step.what}" for part in found.parts for step in part.repairs]
    lines += [f"warning: {part.name}: {text}" for part in found.parts for text in part.warnings]
    return "\n".join(
        (
            f"{len(rows)} meshes as one rigid body\n",
            "Parts by mass, with their centres of mass\n" + page.table((head, _by_mass(rows, found.placed))),
            _sums(found.body, reach, assumed),
            inertia_table(found.body, view, page),
            principal_table(found.body, page),
            _lines([*lines, *(f"warning: {text}" for text in found.warnings)]),
        )
    )


def robot_text(found: RobotInertia, view: View, checked: Checked, page: Page = PLAIN) -> str:
    """Links by mass, the whole robot at its configuration, in the frame of the base, and what a check says of it."""
    placed = [link.placed for link in found.links]
    reach = max(float(np.abs(body.com).max()) for body in placed)
    rows = [
        (link.name, *_weights(body, found.body), *_point(body, reach), f"{link.validity.slack:.3f}")
        for link, body in zip(found.links, placed, strict=True)
    ]
    head = ("link", "mass [kg]", "share [%]", *_PLACED, "slack")
    at = ", ".join(f"{name} {value:.6g}" for name, value in found.at.items()) or "no joint moves"
    return "\n".join(
        (
            f"{printable(found.file)}: robot '{printable(found.name)}', "
            f"{found.massive} of {found.count} links with mass, in the frame of the base\nat {printable(at)}\n",
            "Links by mass, with their centres of mass\n" + page.table((head, _by_mass(rows, placed))),
            _sums(found.body, reach),
            inertia_table(found.body, view, page),
            principal_table(found.body, page),
            _physical(validity(found.body), " as a whole")
            + _checked(checked)
            + _lines(f"warning: {text}" for text in found.warnings),
        )
    )


def link_text(file: str, found: LinkInertia, view: View, checked: Checked, page: Page = PLAIN) -> str:
    """What a link declares, whether a body can be so, and what a check says of the link."""
    return "\n".join(
        (
            f"{printable(file)}:{found.line}: link '{printable(found.name)}' as declared, in its own frame\n",
            _sums(found.body),
            inertia_table(found.body, view, page),
            principal_table(found.body, page),
            _physical(found.validity) + _checked(checked),
        )
    )


def link_shapes_text(file: str, found: LinkShapes, view: View, page: Page = PLAIN) -> str:
    """What the shapes of a link make."""
    return "\n".join(
        (
            f"{printable(file)}:{found.line}: link '{printable(found.name)}' "
            f"from its <{found.kind}> shapes, in its own frame\n",
            _sums(found.body, float(np.abs(found.shapes.box).max()), f", {found.weight}"),
            inertia_table(found.body, view, page),
            principal_table(found.body, page),
            _physical(validity(found.body)) + _lines(f"remark: {text}" for text in found.shapes.remarks),
        )
    )


def _weights(body: MassProperties, whole: MassProperties) -> tuple[str, str]:
    return number(body.mass), f"{100 * body.mass / whole.mass:.1f}"


def _point(body: MassProperties, reach: float) -> tuple[str, ...]:
    return tuple(number(x, reach) for x in body.com)


def _by_mass(rows: list[tuple[str, ...]], bodies: Iterable[MassProperties]) -> list[tuple[str, ...]]:
    masses = [body.mass for body in bodies]
    return [rows[k] for k in ranked(range(len(rows)), masses.__getitem__)]


def _sums(body: MassProperties, reach: float = 0.0, remark: str = "") -> str:
    lines = [f"mass            {number(body.mass)} kg{remark}"]
    if body.volume is not None:
        lines.append(f"volume          {number(body.volume)} m^3")
    if body.density is not None:
        lines.append(f"density         {number(body.density)} kg/m^3")
    return "\n".join([*lines, f"centre of mass  {point_text(body.com, reach)} m", ""])


def _checked(checked: Checked) -> str:
    listed = f" (robodyn check {shlex.quote(checked.files[0])})" if checked.findings else ""
    return f"check: {check_line(checked)}{listed}\n"


def _physical(found: Validity, which: str = "") -> str:
    """The verdict with its margin: I_1 + I_2 - I_3 over the largest moment, twice the smallest second moment."""
    small, middle, large = (number(moment) for moment in found.moments)
    margin = f"I_1 + I_2 - I_3 = {small} + {middle} - {large} kg m^2, {found.slack:.4f} of the largest"
    if found.faults:
        return f"not physical{which}: {'; '.join(found.faults)} ({margin})\n"
    return f"physical{which}: no second moment is negative ({margin})\n"


def _lines(texts: Iterable[str]) -> str:
    return "".join(f"{printable(text)}\n" for text in texts)
