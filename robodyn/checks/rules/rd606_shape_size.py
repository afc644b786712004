"""RD606: a scale or a size that is zero or negative."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import a_shaped_link
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.view import GeometryView, LinkView, Numbers, numbers

_SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "capsule": ("radius", "length")}


def check(context: Context) -> Iterator[Fault]:
    for link in context.view.links:
        for geometry in link.geometries:
            yield from _faults(link, geometry)


def _faults(link: LinkView, geometry: GeometryView) -> Iterator[Fault]:
    shape = geometry.shape
    if shape is None:
        return
    if shape.tag == "mesh":
        scale = numbers(shape, "scale", 3)
        if scale.values is not None and min(scale.values) <= 0:
            yield _scale_fault(link, scale, scale.values)
        return
    for attribute in _SIZES[shape.tag]:
        size = numbers(shape, attribute, 3 if shape.tag == "box" else 1)
        if size.values is not None and min(size.values) <= 0:
            yield Fault(
                at=size.span,
                subject=link.subject,
                what=f"the {attribute} of the <{geometry.kind}> {shape.tag} is {_shown(size.values)}, not positive",
                remedy="write the size in metres, or remove the shape",
                measured=min(size.values),
                bound=0.0,
            )


def _scale_fault(link: LinkView, scale: Numbers, values: tuple[float, ...]) -> Fault:
    if 0 in values:
        what, remedy = "leaves no volume", 'write scale="1 1 1", or leave it out'
    elif sum(value < 0 for value in values) % 2:
        what, remedy = "mirrors the mesh, and turns it inside out in programs that do not turn its faces", _EXPORT
    else:
        what, remedy = "is negative, which some programs take as positive", _EXPORT
    return Fault(
        at=scale.span,
        subject=link.subject,
        what=f"the scale {_shown(values)} {what}",
        remedy=remedy,
        measured=min(values),
        bound=0.0,
    )


_EXPORT = "export a mesh of this part, or turn it by its rpy"


def _shown(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:g}" for value in values)


RULE = Rule(
    code="RD606",
    name="shape-size",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="Sizes and scales of shapes are positive.",
    explanation="""A box, cylinder, sphere or capsule without size, or a mesh with a scale of zero, is refused by some
programs and dropped by others. A negative scale makes a mirror image: its faces then look inwards, which renderers,
collision and inertia take differently.""",
    bad=a_shaped_link(shape='<box size="0.1 0 0.25"/>'),
    good=a_shaped_link(),
    check=check,
)
