"""A material that is named is defined, once.

Where a <material> has a name and neither color nor texture, and no other of that name has them,
viewers draw the link in a colour of their own. Two <material> of one name in <robot> make urdfdom refuse the whole file
("material is not unique"); a <material> without a name makes it drop the shape, and what follows in that link.
"""

from collections.abc import Iterator

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.elements import Element
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.view import Subject
from robodyn.support.wording import alternatives, count, shown

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
    defined = {material.get("name") for material in (*shared, *local) if _looks(material)}
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
