"""The inertia is not far below that of the smallest shell with the link's mass.

The largest sphere that fits into the box around a link's shapes, with the mass in its surface, has a
moment of inertia of 2/3 m r^2; parts of that size have more, for they are longer than thick. A tenth of it means that
nearly all mass is in one spot. That of a point is RD204's.
"""

from robodyn.checks.bodies.masses import is_a_point, principal_moments
from robodyn.checks.bodies.unit_slips import judged
from robodyn.checks.examples import SHAPED_INERTIA, a_shaped_link, inertia
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule

_LEAST = 0.1


@rule(Severity.WARNING, Stage.TREE, good=a_shaped_link(), bad=(SHAPED_INERTIA, inertia("4e-5 0 0 5e-5 0 3e-5")))
def check(context: Context) -> Faults:
    for body in judged(context):
        tensor, box = body.link.tensor, body.box
        if tensor is None or body.S is None or box is None or is_a_point(body.link):
            continue
        radius = float((box.hi - box.lo).min()) / 2
        shell = 2 / 3 * body.mass * radius**2
        largest = principal_moments(tensor)[2]
        if 0 < largest < _LEAST * shell:
            what = (
                f"the largest principal moment {largest:.3g} kg m^2 is {largest / shell:.2g} of that of a shell "
                f"of its mass that fits into its shapes (radius {radius:.3g} m)"
            )
            remedy = "check the unit (kg m^2) and the mass; write the inertia of the part"
            yield Fault(body.tensor_span, what, remedy, largest, _LEAST * shell)
