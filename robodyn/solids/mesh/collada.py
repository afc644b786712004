"""COLLADA before trimesh reads it: unit and axes, positions that are not finite, and nothing but geometry."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import BinaryIO
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from robodyn.solids.mesh.source import Source

_LOOKS = (
    "bind_material",
    "instance_light",
    "instance_camera",
    *(f"library_{name}" for name in ("materials", "effects", "images", "lights", "cameras", "animations")),
)
"""Elements without which a scene has the same shape. A reference that is broken in one of them hides geometry."""


def bare(source: Source, stream: BinaryIO) -> tuple[float | None, str, bytes]:
    """Metres per unit and the axis that points up, None and "" if it names none; and the document without its looks.

    Raises:
        MeshError: the unit is no length, or a position is not finite or an index negative, which
            pycollada would read as 0 and as counted from the end.
        ElementTree.ParseError: it is no XML.
    """
    root = ElementTree.parse(stream).getroot()
    asset = root.find("{*}asset")
    unit = None if asset is None else asset.find("{*}unit")
    metres = None if unit is None or "meter" not in unit.attrib else _positive(source, unit.attrib["meter"])
    up = "" if asset is None else (asset.findtext("{*}up_axis") or "").strip()
    _check_positions(source, root)
    if any("-" in (indices.text or "") for indices in root.iterfind(".//{*}p")):
        raise source.error("an index is negative", remedy="the file is damaged: export it again")
    for parent in list(root.iter()):
        for child in list(parent):
            if _tag(child) in _LOOKS:
                parent.remove(child)
    return metres, up, ElementTree.tostring(root, "utf-8")


def _tag(element: Element) -> str:
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


def _positive(source: Source, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise source.error(f"the unit {text[:40]!r} is not a length in metres", remedy="repair <unit meter>")
    return value


def _check_positions(source: Source, root: Element) -> None:
    for name, numbers in _positions(root):
        text = numbers.text or ""
        if "n" not in text.lower():
            continue
        for at, word in enumerate(text.split()):
            if not math.isfinite(float(word)):
                what = f"vertex {at // 3 + 1} of {name!r} has the coordinate {word}"
                raise source.error(what, remedy="coordinates must be finite")


def _positions(root: Element) -> Iterator[tuple[str, Element]]:
    """Name and array of each source of positions."""
    used = {
        place.get("source", "").removeprefix("#")
        for place in root.iterfind(".//{*}vertices/{*}input")
        if place.get("semantic") == "POSITION"
    }
    for known in root.iterfind(".//{*}source"):
        numbers = known.find("{*}float_array")
        name = known.get("id", "")
        if name in used and numbers is not None:
            yield name, numbers
