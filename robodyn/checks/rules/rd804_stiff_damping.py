"""Inertia and damping of a joint allow steps of 1 ms."""

from robodyn.checks.examples import arm
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.checks.statics.reflected_inertia import reflected_inertias

STEP = 1e-3
"""s; the usual step of a simulation."""


@rule(
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""A joint of damping b and reflected inertia J = 1 / (M^-1)_ii comes to rest within J / b. Explicit
Euler with a longer step than 2 J / b overshoots more with every step; the rule asks for {STEP:g} s. Real joints have
the inertia of a rotor times the square of the gear ratio, which most descriptions leave out. J is taken at the
middle of the ranges.""",
    good=arm('<axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="30" velocity="3"/><dynamics damping="1"/>'),
    bad=('"1"', '"50"'),
    default=Severity.ERROR,
)
def check(context: Context) -> Faults:
    for joint, inertia in context.once(reflected_inertias):
        step = 2.0 * inertia / joint.damping
        if not 0.0 < step < STEP:
            continue
        view = context.view.joint[joint.name]
        unit = "kg" if joint.kind == "prismatic" else "kg m^2"
        what = (
            f"damping {joint.damping:g} on a reflected inertia of {inertia:.3g} {unit}: explicit integration "
            f"diverges with steps above {step:.2g} s"
        )
        remedy = (
            "add the rotor's inertia (rotorInertia and mechanicalReduction of its transmission), lower the "
            "damping, or integrate implicitly"
        )
        at = view.element.span if view.damping.element is None else view.damping.span
        yield Fault(at, what, remedy, step, STEP)
