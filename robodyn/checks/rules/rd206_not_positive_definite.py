"""The inertia matrix is positive definite.

A principal moment of inertia is a sum of mass times distance squared. With one that is zero or
negative the kinetic energy of a spin about its axis is not positive, and simulations gain energy from nothing. The
principal moments are the eigenvalues of the matrix: large products make one negative although the diagonal is positive.
Where no cause explains the tensor, the unsafe fix is the nearest that a body can have. Traversaro, Brossette, Escande,
Nori, Identification of fully physical consistent inertial parameters (IROS 2016).
"""

from robodyn.checks.bodies.masses import principal_moments, tensors, widest
from robodyn.checks.causes.causes import explained
from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule


@rule(Severity.ERROR, good=one_link(), bad=('"0.01"', '"-0.01"'), explains=("RD301", "RD303", "RD402", "RD901"))
def check(context: Context) -> Faults:
    bound = context.thresholds.positive_definite
    for link, inertial, tensor in tensors(context):
        small, middle, large = principal_moments(tensor)
        if small > bound * large:
            continue
        what = (
            "the inertia matrix is not positive definite: its principal moments are "
            f"{small:.6g}, {middle:.6g}, {large:.6g} kg m^2"
        )
        remedy = "every principal moment of a body is positive; write its inertia about the centre of mass"
        fault = Fault(inertial.entries[widest(tensor)].span, what, remedy, small, bound * large)
        yield explained(context, fault, link)
