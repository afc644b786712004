"""What writers of every format share: what is refused, comments of the source, numbers."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.parts import Description, Link
from robodyn.solids.inertia.laws import symmetric
from robodyn.solids.inertia.validity import unphysical
from robodyn.support.wording import shown

ROUNDING = 1e-12
"""By what a tensor may miss a law of bodies, relative to its largest moment."""
MARK = " converted by robodyn "
"""The comment by which what is written is told from what is not."""
_PARTS = ("link", "body", "joint")


class Written(NamedTuple):
    """A description in a format: the text, what it cannot say, a line each, and files beside it by relative name."""

    data: bytes
    lost: list[str]
    files: dict[str, bytes]


def check_possible(description: Description) -> None:
    """Raise DescriptionError if a link has a mass or a tensor that no body has."""
    for link in description.links:
        if link.inertial is None:
            continue
        if link.inertial.mass < 0.0:
            raise impossible(description, link, f"its mass is {link.inertial.mass:g} kg", "RD201")
        why = unphysical(symmetric(link.inertial.inertia), ROUNDING)
        if why:
            raise impossible(description, link, why, "RD207" if "triangle" in why else "RD206")


def impossible(description: Description, link: Link, why: str, code: str) -> DescriptionError:
    what, remedy = f"link {shown(link.name)} is impossible: {why}", f"correct it; robodyn rule {code} tells how"
    return DescriptionError(what, remedy=remedy, file=description.file, line=link.line)


def free_name(name: str, taken: Collection[str]) -> str:
    """Return the name, with a number behind it if it is taken."""
    return next(each for k in range(len(taken) + 1) if (each := f"{name}{k or ''}") not in taken)


def text(*values: float) -> str:
    """Return numbers that read back as the same floats; without the sign of 0."""
    return " ".join(str(int(v)) if v == int(v) and abs(v) < 1e15 else repr(v) for v in (float(v) + 0.0 for v in values))


def tag(name: str, end: str = "/>", /, **values: str | float | Iterable[float] | None) -> str:
    """Return a start tag with those of its attributes that are not None; `_` behind a name is left out."""
    pairs = ((key.rstrip("_"), value) for key, value in values.items() if value is not None)
    return f"<{name}" + "".join(f" {key}={quoteattr(_word(value))}" for key, value in pairs) + end


def _word(value: str | float | Iterable[float]) -> str:
    if isinstance(value, str):
        return value
    return text(*np.atleast_1d(np.asarray(value if isinstance(value, (float, int)) else list(value))).tolist())


def comments_of(data: bytes) -> dict[tuple[str, str], list[str]]:
    """Return the comments of a description by tag and name of the link, body or joint that they stand in or before;
    under ("", "") those of the file."""
    found: dict[tuple[str, str], list[str]] = {}
    waiting: list[str] = []
    inside: list[tuple[str, str]] = []

    def keep(owner: tuple[str, str]) -> None:
        if waiting:
            found.setdefault(owner, []).extend(waiting)
            waiting.clear()

    def begin(name: str, values: dict[str, str]) -> None:
        own = inside[-1] if inside else ("", "")
        if name in _PARTS and "name" in values and (name == "body" or own[0] in ("", "body")):
            keep((name, values["name"]))
            own = (name, values["name"])
        else:
            keep(own)
        inside.append(own)

    def end(_: str) -> None:
        keep(inside.pop())

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.CommentHandler = waiting.append
    parser.Parse(data, True)
    keep(("", ""))
    return found
