"""Figures by matplotlib, without a window and the same from one run to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robodyn.errors import InputError
from robodyn.support.extras import need
from robodyn.support.wording import alternatives

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMS = "svg", "png", "pdf"


def form_of(path: str) -> str:
    """The form of a picture by the suffix of its file.

    Raises:
        InputError: there is none such.
    """
    suffix = path.rpartition(".")[2].lower() if "." in path else ""
    if suffix not in FORMS:
        raise InputError("unknown type of picture by this suffix", remedy="name it .svg, .png or .pdf", file=path)
    return suffix


def new_figure(width: float = 8.0, height: float = 5.0) -> Figure:
    """An empty figure, in inches.

    Raises:
        InputError: matplotlib is not installed.
    """
    need("plots", "matplotlib")
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def rendered(figure: Figure, form: str = "svg", dpi: float = 150.0) -> bytes:
    """The picture as the content of a file; letters of an SVG stay letters."""
    from io import BytesIO

    import matplotlib as mpl

    if form not in FORMS:
        raise InputError(f"no picture is made as {form!r}", remedy=alternatives(form, FORMS, "forms"))
    stream = BytesIO()
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": None}[form]
    with mpl.rc_context({"svg.hashsalt": "robodyn", "svg.fonttype": "none"}):
        figure.savefig(stream, format=form, dpi=dpi, metadata=undated)
    return stream.getvalue()
