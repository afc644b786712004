"""The largest principal moment is no greater than the sum of the other two.

I_1 + I_2 - I_3 is twice the second moment of the mass along the third axis, a sum of mass times
distance squared, and so never negative. The entries of the diagonal say too little: the law holds for the principal
moments, in every axes. Where no cause explains the tensor, the unsafe fix is the nearest that a body can have. Wensing,
Kim, Slotine, Linear matrix inequalities for physically consistent inertial parameter identification (RA-L 2018).
"""

from robodyn.checks.bodies.masses import principal_moments, tensors
from robodyn.checks.causes.causes import explained
from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.support.wording import figure


@rule(Severity.ERROR, good=one_link(), bad=('izz="0.02"', 'izz="0.05"'), explains=("RD301", "RD303", "RD402", "RD901"))
def check(context: Context) -> Faults:
    limits = context.thresholds
    for link, inertial, tensor in tensors(context):
        small, middle, large = principal_moments(tensor)
        if small <= limits.positive_definite * large or small + middle >= (1 - limits.triangle) * large:
            continue
        diagonal = {k: tensor[k] for k in (0, 3, 5)}
        largest = max(diagonal, key=lambda k: diagonal[k])
        lack = figure(100 - 100 * (small + middle) / large, 2)
        what = (
            f"no body has the principal moments {small:.6g}, {middle:.6g}, {large:.6g} kg m^2: the two smaller "
            f"add up to {small + middle:.6g}, {lack} % less than the largest"
        )
        remedy = "the largest may not exceed the sum of the others; robodyn inertia computes them from a mesh"
        fault = Fault(inertial.entries[largest].span, what, remedy, large, small + middle)
        yield explained(context, fault, link)
