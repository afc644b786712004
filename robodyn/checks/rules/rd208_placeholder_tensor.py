"""The inertia is that of the part, not a stand-in.

The identity matrix, a power of ten times it, six equal entries, and numbers copied from a link of
another mass are stand-ins; of left and right RD401 judges the masses. An inertia of 1 kg m^2 is that of a solid ball
of 2 kg with a radius of 1.1 m. Numbers within 5 % of the inertia of the link's own shapes, as those of a solid ball
may be, are no stand-in.
"""

from math import isclose, log10

from robodyn.checks.bodies.masses import tensors
from robodyn.checks.bodies.uniform import shaped
from robodyn.checks.bodies.weighed import given
from robodyn.checks.examples import INERTIA, inertia, one_link
from robodyn.checks.mirror.pairs import pairs
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.masses.weighing import apart
from robodyn.robot.urdf.view import LinkView

_FRACTION = 0.01
"""Of the mass of its rigid group; a placeholder on less than this is a remark."""

_NEAR = 0.05


@rule(
    Severity.WARNING,
    good=one_link(),
    bad=(INERTIA, inertia("1 0 0 1 0 1")),
    explains=("RD206", "RD207", "RD301", "RD303", "RD402"),
)
def check(context: Context) -> Faults:
    first_with: dict[tuple[float, ...], LinkView] = {}
    mirrored = {frozenset((pair.left.name, pair.right.name)) for pair in context.once(pairs)}
    for link, inertial, tensor in tensors(context):
        if not link.mass:
            continue
        twin = first_with.setdefault(tensor, link)
        pattern = _pattern(tensor)
        unlike = twin.mass and not isclose(twin.mass, link.mass, rel_tol=0.1)
        if pattern is None and twin.mass and unlike and frozenset((link.name, twin.name)) not in mirrored:
            pattern = (
                f"the same six numbers as link '{twin.name}', whose mass is {twin.mass:g} kg and not {link.mass:g}"
            )
        if pattern is not None and not _is_the_shape_s(context, link):
            what = f"the inertia looks like a placeholder: {pattern}"
            remedy = "write the inertia of the part; robodyn inertia computes it from its mesh"
            yield Fault(inertial.entries[0].span, what, remedy, measured=tensor[0], severity=_severity(context, link))


def _is_the_shape_s(context: Context, link: LinkView) -> bool:
    """Return whether the tensor is that of the uniform solid that the link's shapes are."""
    said, shape = given(link), context.once(shaped).get(link.name)
    return said is not None and shape is not None and apart(said.tensor, said.mass, shape.solid.along(said.R)) <= _NEAR


def _pattern(tensor: tuple[float, ...]) -> str | None:
    xx, xy, xz, yy, yz, zz = tensor
    if len(set(tensor)) == 1:
        return f"six times {xx:g}"
    if any((xy, xz, yz)) or not xx == yy == zz or xx < 0:
        return None
    power = log10(xx)
    if power == 0:
        return "the identity matrix, 1 kg m^2 three times"
    return f"{xx:g} times the identity" if isclose(power, round(power), abs_tol=1e-12) else None


def _severity(context: Context, link: LinkView) -> Severity:
    """Return a warning where the link is more than a small part of its body; which that is only a tree tells."""
    tree = context.tree_or_none
    if tree is None:
        return Severity.NOTE
    whole = tree.group[link.name].mass
    return Severity.NOTE if whole and link.mass is not None and link.mass < _FRACTION * whole else Severity.WARNING
