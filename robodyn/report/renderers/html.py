"""A report as one HTML file that needs no network: light and dark, for screens, phones and paper."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robodyn.report.document import Document, Download, Heading, code_lines
from robodyn.report.table import is_numeric, printable
from robodyn.support.extras import need

if TYPE_CHECKING:
    from markupsafe import Markup

_ASSETS = Path(__file__).parent / "assets"


def html(document: Document) -> str:
    """Return the page.

    Every word is escaped, and the page's policy lets no script run but its own and no address be loaded.
    """
    need("HTML reports", "jinja2")
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    strict: dict[str, Any] = {"autoescape": True, "undefined": StrictUndefined}
    room = Environment(loader=FileSystemLoader(_ASSETS), trim_blocks=True, lstrip_blocks=True, **strict)
    room.filters |= {"words": printable, "name": _name, "unit": _unit, "code": code_lines, "data": _data}
    room.tests["block"] = lambda block, name: type(block).__name__ == name
    script = _asset("page.js")
    digest = base64.b64encode(hashlib.sha256(f"\n{script}\n".encode()).digest()).decode()
    page = room.get_template("page.html.j2").render(
        document=document,
        style=Markup(_asset("page.css")),
        script=Markup(script),
        digest=digest,
        sections=[block.text for block in document.blocks if isinstance(block, Heading)],
        numeric=_numeric,
        explained=explained,
        svg=lambda figure: Markup(figure.svg),
    )
    return str(page)


def _name(text: str) -> Markup:
    """Return words in which a long name may go on in the next line after an underscore or a slash."""
    from markupsafe import Markup, escape

    return Markup(re.sub(r"([_/])(?=\w{3})", r"\1<wbr>", str(escape(printable(text)))))


def _unit(title: str) -> str:
    """Return a title whose unit in brackets stays on one line."""
    return re.sub(r"\[[^\]]*\]", lambda unit: unit[0].replace(" ", "\u00a0"), printable(title))


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text(encoding="utf-8").strip()


def _numeric(table: Any) -> list[bool]:
    return [is_numeric([row[k] for row in table.rows]) for k in range(len(table.head))]


def _data(file: Download) -> str:
    """Return the address that holds a file."""
    return f"data:{file.kind};charset=utf-8;base64,{base64.b64encode(file.text.encode()).decode()}"


MEANINGS = {
    "at [s]": "time of the value before it",
    "RMS": "root mean square over the whole time: what heats a motor",
    "cubic mean": "cube root of the mean of |torque|^3, weighted by speed: what wears a gear",
    "peak": "largest magnitude, with its sign",
    "max speed": "speed of largest magnitude, with its sign",
    "peak power [W]": "largest product of torque and speed",
    "least": "smallest value, the most negative one",
    "least power [W]": "smallest product of torque and speed; negative where the load drives the joint",
    "work [J]": "energy that the actuator puts in",
    "returned [J]": "energy that goes back to the actuator, negative",
    "of effort limit": "how much of the effort limit of the description the peak takes",
    "of velocity limit": "how much of the velocity limit of the description the largest speed takes",
    "sum": "the peak: what the effects add up to",
    "error (95 %)": "what noise and smoothing make the peak be off by, at most in 19 of 20 cases",
    "friction holds": "at rest, Coulomb friction bears a torque of up to this",
    "duty": "share of the time in which the joint moves",
    "mean speed": "mean magnitude of the speed over the whole time",
    "peak in row": "row of the trajectory at which the torque is largest",
    "speed then": "speed at the moment of the peak",
    "torque then": "torque at the moment of the largest speed",
    "static peak": "largest torque that standing still in the poses of the motion would take",
    "static RMS": "root mean square of the torque that standing still would take",
    "hold share": "static RMS over RMS: how much of the load is holding, not moving",
    "gear": "turns of the motor for each turn of the joint",
    "efficiency": "share of the power that the gear passes on",
    "inertia ratio": "inertia of the load, reflected to the motor, over that of the rotor",
    "u": "first direction across the axis of the bearing",
    "v": "second direction across the axis of the bearing",
    "axis a": "direction of the axis of the bearing",
    "fu [N]": "force along u",
    "fv": "force along v",
    "fa": "force along the axis",
    "mu [N m]": "moment about u, across the axis",
    "mv": "moment about v, across the axis",
    "ma": "moment about the axis, where the joint holds it",
    "radial f": "resultant of the forces across the axis",
    "tilting m": "resultant of the moments across the axis",
    "along normal [N]": "least and largest force with which the contact presses while it is on",
    "of it used": "sum of the forces along the ground over friction times the sum of those along the normal, at most",
    "margin [mm]": "least distance of the centre of pressure from the edges of the polygon",
    "centre of pressure [mm]": "where it is then, from the middle of the polygon, in the axes of the ground",
    "determined": "whether no other force balances the motion; where others do, the least is given",
    "its noise": "standard deviation of what is no motion in the data",
    "grid": "step of the numbers in the data, of an encoder for instance",
    "noise left": "standard deviation that noise typically leaves in the highest derivative",
    "operations alone": "arithmetic operations for each sample with this effect alone",
    "saved without": "operations for each sample that would be saved without this effect",
    "slack": "(I_1 + I_2 - I_3) over the largest principal moment: 1 for a ball, 0 for a plate or a needle, negative "
    "where no body can be so",
    "share [%]": "of the mass of the whole",
    "difference [%]": "|I_declared - I_shapes| / |I_shapes| about the centres of mass",
    "centres apart [m]": "distance of the declared centre of mass from that of the shapes",
    "I_1 ratio": "smallest principal moment, declared over that of the shapes",
    "I_2 ratio": "middle principal moment, declared over that of the shapes",
    "I_3 ratio": "largest principal moment, declared over that of the shapes",
    "asymmetry": "share of the volume that its image does not cover",
    "quartiles [ms]": "a quarter of the runs took less, a quarter took more",
    "quartiles [ns]": "a quarter of the runs took less, a quarter took more",
    "energy drift": "largest error of the energy balance, relative to the largest kinetic energy",
    "evaluations": "how often the equations of motion were evaluated",
    "|phi| [m, rad]": "how far the loop comes apart",
    "|phi'| [m/s, rad/s]": "how fast the loop comes apart",
    "drive's peak": "largest torque or force of the drive, with its sign",
}


def explained(head: Iterable[str]) -> dict[str, str]:
    """Return the meanings of those titles of columns that have one."""
    return {title: MEANINGS[title] for title in head if title in MEANINGS}
