"""The file as written: every element and attribute of a URDF, with its place."""

from __future__ import annotations

import os
from dataclasses import dataclass
from xml.parsers import expat

from robodyn.errors import DescriptionError
from robodyn.robot.urdf.builder import RUN_XACRO, Builder
from robodyn.robot.urdf.elements import Attribute, Element
from robodyn.robot.urdf.source_positions import BOM, Span
from robodyn.robot.urdf.sources import as_utf8, read_source
from robodyn.support.wording import shown

__all__ = ["Attribute", "Document", "Element", "Span", "read_document"]

_REMEDIES = {
    expat.errors.XML_ERROR_UNDEFINED_ENTITY: "write & as &amp;",
    expat.errors.XML_ERROR_DUPLICATE_ATTRIBUTE: "keep one of the two",
    expat.errors.XML_ERROR_JUNK_AFTER_DOC_ELEMENT: "keep one <robot> and nothing after it",
    expat.errors.XML_ERROR_MISPLACED_XML_PI: "nothing, not even a blank, may stand before <?xml",
    expat.errors.XML_ERROR_INCORRECT_ENCODING: "correct encoding=... in the first line",
    expat.errors.XML_ERROR_UNKNOWN_ENCODING: "save it as UTF-8",
}


@dataclass(frozen=True)
class Document:
    """A parsed file. Spans are byte offsets into `data`, text in `encoding`.

    `data` are the bytes of the file, except for UTF-16, which is transcoded to UTF-8 first.
    """

    file: str
    data: bytes
    root: Element
    encoding: str = "utf-8"


def read_document(source: str | os.PathLike[str] | bytes, name: str | None = None) -> Document:
    """The elements and attributes of a URDF file with their places.

    Method: expat, which neither fetches nor (a document type being refused) expands an entity; one pass, no recursion.

    Args:
        source: path of the file, or its bytes.
        name: the file as messages shall show it; by default the path, and `<stdin>` for bytes.

    Returns:
        The document; its root element is `<robot>`. Elements and attributes that URDF does not know are kept.

    Raises:
        DescriptionError: the file cannot be read, is not XML or not URDF, has a document type, an undeclared
            prefix outside the extension elements, or is left over from xacro; with the line.
    """
    file, original = read_source(source, name)
    data, transcoded = as_utf8(file, original)
    if not data.removeprefix(BOM).strip():
        raise DescriptionError("the file is empty", remedy="give a URDF file", file=file, line=1)
    builder = Builder(file, data, "utf-8" if transcoded else None)
    try:
        builder.parser.Parse(data, True)
    except expat.ExpatError as error:
        raise _malformed(builder, error) from None
    except (LookupError, ValueError) as error:
        raise DescriptionError(
            f"cannot decode the text: {error}", remedy="save it as UTF-8", file=file, line=1
        ) from None
    assert builder.root is not None, "expat refuses a document without an element"
    return Document(file, data, _checked_root(file, builder.root), builder.places.encoding)


def _malformed(builder: Builder, error: expat.ExpatError) -> DescriptionError:
    if b"\0" in builder.places.data:
        return DescriptionError(
            "this is a binary file, not XML", remedy="give a URDF file", file=builder.file, line=error.lineno
        )
    text = expat.ErrorString(error.code)
    remedy = _REMEDIES.get(text)
    if builder.stack:
        element = builder.stack[-1]
        text += f" inside {shown(element.tag)} of line {element.line}"
        remedy = remedy or "the file may be cut off, or its end tag is missing"
    elif builder.root is None and remedy is None:
        remedy = "the file must be XML with the root element <robot>"
    return DescriptionError(f"malformed XML: {text}", remedy=remedy, file=builder.file, line=error.lineno)


def _checked_root(file: str, root: Element) -> Element:
    if root.tag == "robot":
        return root
    remedies = {"sdf": "this is SDF; convert it to URDF", "mujoco": "this is MJCF; convert it to URDF"}
    remedy = remedies.get(root.tag, RUN_XACRO if file.endswith(".xacro") else "give a URDF file")
    raise DescriptionError(
        f"the root element is {shown(root.tag)}, not 'robot'", remedy=remedy, file=file, line=root.line
    )
