"""A material that is named is defined, once, in one colour.

Where a <material> has a name and neither color nor texture, and no other of that name has them,
viewers draw the link in a colour of their own. Two <material> of one name in <robot> make urdfdom refuse the whole file
("material is not unique"); a <material> without a name makes it drop the shape, and what follows in that link.
Of two colours of one name urdfdom takes the first for all shapes, others each shape's own, and Drake refuses them.
"""

from collections.abc import Iterable, Iterator

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import numbers, value_span
from robodyn.robot.urdf.view import Subject
from robodyn.support.wording import alternatives, count, figure, shown

_SEEN = 0.1
"""Two colours that differ by more in a number are two."""
_SHAPE = """<link name="base">
    <visual><geometry><box size="0.1 0.1 0.1"/></geometry><material name="grey"/></visual>
  </link>"""
_GREY = '\n  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>'


@rule(
    Severity.WARNING,
    good=arm(more=_GREY).replace('<link name="base"/>', _SHAPE),
    bad=arm().replace('<link name="base"/>', _SHAPE),
    explains=("RD901",),
)
def check(context: Context) -> Faults:
    root = context.view.root
    shared = root.findall("material")
    local = [
        material
        for link in context.view.links
        for geometry in link.geometries
        for material in geometry.element.findall("material")
    ]
    yield from _twice(shared)
    yield from _two_colours(shared, local)
    defined = dict.fromkeys(material.get("name") for material in (*shared, *local) if _looks(material))
    undefined: dict[str, list[Element]] = {}
    for material in local:
        name = material.get("name")
        if name is None and material.children:
            yield Fault(
                material.span,
                "the <material> has no name: urdfdom drops the shape",
                'write name="..."',
                severity=Severity.ERROR,
            )
        if name and name not in defined and not _looks(material):
            undefined.setdefault(name, []).append(material)
    for name, uses in undefined.items():
        more = f" (used by {count(len(uses), 'shape')})" if uses[1:] else ""
        what = f"no <material> {shown(name)} has a color or a texture{more}"
        remedy = alternatives(name, [each for each in defined if each], "materials")
        yield Fault(value_span(uses[0], "name"), what, remedy)


def _looks(material: Element) -> bool:
    return any(child.tag in ("color", "texture") for child in material.children)


def _two_colours(shared: Iterable[Element], local: Iterable[Element]) -> Iterator[Fault]:
    """Yield the names of which a shape has another colour than the first, each once."""
    first: dict[str, tuple[Element, tuple[float, ...]]] = {}
    told = set()
    for material, is_used in (*((each, False) for each in shared), *((each, True) for each in local)):
        name, rgba = material.get("name"), numbers(material.find("color"), "rgba", 4).values
        if not name or rgba is None:
            continue
        other, colour = first.setdefault(name, (material, rgba))
        if is_used and name not in told and any(abs(a - b) > _SEEN for a, b in zip(rgba, colour, strict=True)):
            told.add(name)
            what = f"the <material> {shown(name)} is {_words(rgba)} here and {_words(colour)} in line {other.line}"
            yield Fault(value_span(material, "name"), what, "give one of the two another name")


def _words(rgba: tuple[float, ...]) -> str:
    return " ".join(map(figure, rgba))


def _twice(shared: list[Element]) -> Iterator[Fault]:
    """Yield the materials of <robot> that are there a second time, which urdfdom refuses."""
    first: dict[str, Element] = {}
    for material in shared:
        name = material.get("name")
        if name and first.setdefault(name, material) is not material:
            line = first[name].line
            what = f"a second <material> {shown(name)} in <robot> after line {line}: urdfdom refuses the file"
            yield Fault(
                value_span(material, "name"),
                what,
                "keep one of them",
                subject=Subject("material", name),
                severity=Severity.ERROR,
            )
