"""Materials, colours and textures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from robodyn.checks.examples import arm
from robodyn.checks.meshes.files import MeshSearch, State
from robodyn.checks.rule import Context, Fault, Faults, Severity, namesakes, rule
from robodyn.checks.rules.text import own_elements
from robodyn.robot.urdf.document import Element, unexpanded
from robodyn.robot.urdf.view import Subject, numbers, value_span
from robodyn.support.wording import alternatives, count, figure, shown, shown_path

_SEEN = 0.1
"""Two colours that differ by more in a number are two."""
_SHAPE = """<link name="base">
    <visual><geometry><box size="0.1 0.1 0.1"/></geometry><material name="grey"/></visual>
  </link>"""
_GREY = '\n  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>'


@rule(
    "RD621",
    Severity.WARNING,
    good=arm(more=_GREY).replace('<link name="base"/>', _SHAPE),
    bad=arm().replace('<link name="base"/>', _SHAPE),
    explains=("RD901",),
)
def undefined_material(context: Context) -> Faults:
    """A material that is named is defined, once, in one colour.

    Where a <material> has a name and neither color nor texture, and no other of that name has them, viewers draw the
    link in a colour of their own. Two <material> of one name in <robot> make urdfdom refuse the file; a <material>
    without a name makes it drop the shape, and what follows in that link. Of two colours of one name urdfdom takes the
    first for all shapes, others each shape's own, and Drake refuses them.
    """
    root = context.view.root
    shared = root.findall("material")
    local = [
        material
        for link in context.view.links
        for geometry in link.geometries
        for material in geometry.element.findall("material")
    ]
    for again, first in namesakes(shared):
        twice = again.get("name") or ""
        what = f"a second <material> {shown(twice)} in <robot> after line {first.line}: urdfdom refuses the file"
        at, subject = value_span(again, "name"), Subject("material", twice)
        yield Fault(at, what, "keep one of them", subject=subject, severity=Severity.ERROR)
    yield from _two_colours(shared, local)
    defined = dict.fromkeys(material.get("name") for material in (*shared, *local) if _looks(material))
    undefined: dict[str, list[Element]] = {}
    for material in local:
        name = material.get("name")
        if name is None and material.children:
            what = "the <material> has no name: urdfdom drops the shape"
            yield Fault(material.span, what, 'write name="..."', severity=Severity.ERROR)
        if name and name not in defined and not _looks(material):
            undefined.setdefault(name, []).append(material)
    for missing, uses in undefined.items():
        more = f" (used by {count(len(uses), 'shape')})" if uses[1:] else ""
        what = f"no <material> {shown(missing)} has a color or a texture{more}"
        remedy = alternatives(missing, [each for each in defined if each], "materials")
        yield Fault(value_span(uses[0], "name"), what, remedy)


def _looks(material: Element) -> bool:
    return any(child.tag in ("color", "texture") for child in material.children)


def _two_colours(shared: Iterable[Element], local: Iterable[Element]) -> Iterator[Fault]:
    """Names of which a shape has another colour than the first, each once."""
    first: dict[str, tuple[Element, tuple[float, ...]]] = {}
    told = set()
    for material, is_used in (*((each, False) for each in shared), *((each, True) for each in local)):
        name, rgba = material.get("name"), numbers(material.find("color"), "rgba", 4).values
        if not name or rgba is None:
            continue
        other, colour = first.setdefault(name, (material, rgba))
        if is_used and name not in told and any(abs(a - b) > _SEEN for a, b in zip(rgba, colour, strict=True)):
            told.add(name)
            here, there = (" ".join(map(figure, each)) for each in (rgba, colour))
            what = f"the <material> {shown(name)} is {here} here and {there} in line {other.line}"
            yield Fault(value_span(material, "name"), what, "give one of the two another name")


_RED = '\n  <material name="red"><color rgba="0.8 0.1 0.1 1"/></material>'


@rule("RD622", Severity.WARNING, good=arm(more=_RED), bad=("0.8 0.1 0.1", "204 26 26"), explains=("RD901",))
def colour_range(context: Context) -> Faults:
    """Colours are four numbers from 0 to 1: red, green, blue and opacity.

    urdfdom drops a colour with a number outside; others show it white, or black. Numbers to 255 are the most
    frequent cause. An opacity of 0 is a shape that nobody sees, which some do on purpose.
    """
    for element, _, subject in context.once(own_elements):
        rgba = numbers(element, "rgba", 4) if element.tag == "color" else None
        if rgba is None or rgba.values is None or all(0 <= value <= 1 for value in rgba.values):
            continue
        worst = max(rgba.values, key=lambda value: abs(value - 0.5))
        bytewise = worst > 1 and all(0 <= value <= 255 for value in rgba.values)
        first = " ".join(f"{figure(value / 255)}" for value in rgba.values[:3])
        remedy = f'divide by 255: "{first} 1"' if bytewise and worst > 2 else "write four numbers from 0 to 1"
        what = f"the color has {figure(worst)}, which is not from 0 to 1: urdfdom drops it"
        yield Fault(rgba.span, what, remedy, worst, 1.0 if worst > 1 else 0.0, subject=subject)


_WOOD = '\n  <material name="wood"><texture filename="package://part/wood.png"/></material>'


@rule("RD623", Severity.WARNING, good=arm(more=_WOOD), bad=("package://part/wood.png", "package:///wood.png"))
def texture_missing(context: Context) -> Faults:
    """Every texture is there.

    Viewers draw the shape white, or say so at each frame, where the picture is missing. Names of textures are
    looked up as those of meshes are.
    """
    meshes = MeshSearch(context)
    seen = set()
    for element, _, subject in context.once(own_elements):
        uri = element.get("filename") if element.tag == "texture" else None
        if not uri or unexpanded(uri) or uri in seen:
            continue
        seen.add(uri)
        state = meshes.find(uri, ()).state
        if state in (State.MISSING, State.OTHER_CASE):
            how = "not there" if state is State.MISSING else "there in another case"
            what, remedy = f"the texture {shown_path(uri)} is {how}", "correct its name, or delete <texture>"
            yield Fault(value_span(element, "filename"), what, remedy, subject=subject)
