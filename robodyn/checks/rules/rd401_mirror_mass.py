"""A left link weighs what the right one does."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from math import isclose

from robodyn.checks.examples import IMAGE, two_arms
from robodyn.checks.mirror.loads import MASS, ONE_OF_TWO, Twins, twins
from robodyn.checks.mirror.names import row_of
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.support.wording import figure, shown

_UNITS = (
    (1000.0, "in grams, 1000 times the other"),
    (1 / 0.45359237, "in pounds, 2.2046 times the other"),
)
_DIGITS = (
    (10.0, "10 times the other, as with the decimal point one place off"),
    (100.0, "100 times the other, as with the decimal point two places off"),
)
_EXACT = 1e-3
"""How far the ratio may be from a factor: masses of twins are equal or differ by chance."""

_LEGS = 16
"""More than any robot has in a row."""


@rule(
    Severity.WARNING,
    Stage.MODEL,
    explanation=f"""Links are twins if their names are each other's but for left and right, and at q = 0 each stands
where the mirror image of the other does; the plane is found from the robot. Masses may differ by {100 * MASS:g} %.
Where two parts that stand opposite each other do differ, as two tools do, a waiver says so. A ratio of 1000, 2.2046, 10
or 100 is named as the slip that makes it. The one that is in grams or pounds, or that weighs what no other of the legs
in front and behind does, is the wrong one; where neither tells, both are named.""",
    good=two_arms(),
    bad=(f'"2"/>{IMAGE}', f'"2.1"/>{IMAGE}'),
    explains=("RD208", "RD313"),
)
def check(context: Context) -> Faults:
    for one in context.once(twins):
        if one.mass_differs:
            yield _fault(context, one)


def _fault(context: Context, one: Twins) -> Fault:
    left, right = one.masses
    unit, others = _named(one, _UNITS), _others(context, one)
    is_left = left > right if unit else others is not None and others[0]
    link = context.view.link[one.pair.left.name] if is_left else one.link
    assert link.inertial is not None, "it has mass"
    mass, its = (left, right) if is_left else (right, left)
    twin = f"{shown(one.pair.right.name)} (line {one.pair.right.line})" if is_left else one.other
    told = "" if others is None else f"; {others[1]} other links of this row weigh that"
    apart = figure(100 * abs(left - right) / max(left, right), 2)
    what = f"the mass is {mass:g} kg, that of its mirror twin {twin} {its:g} kg, {apart} % apart{told}"
    how = unit or _named(one, _DIGITS)
    cause = None if how is None else f"{'it' if mass > its else 'that of the twin'} is {how}"
    remedy = ONE_OF_TWO if unit is None and others is None else f"correct it, to {its:g} kg if the parts are alike"
    return Fault(link.inertial.mass.span, what, remedy, mass, its, cause=cause)


def _named(one: Twins, factors: tuple[tuple[float, str], ...]) -> str | None:
    """Return what makes one mass a round number of times the other, if it is one."""
    ratio = max(one.masses) / min(one.masses)
    return next((how for factor, how in factors if isclose(ratio, factor, rel_tol=_EXACT)), None)


def _others(context: Context, one: Twins) -> tuple[bool, int] | None:
    """Return whether it is the left link that weighs what no other leg's does, and how many weigh what the right one
    does, or the other way round; None where the other legs do not tell."""
    legs = context.once(_legs)[row_of(one.pair.left.name)]
    masses = [mass for other in legs if other is not one for mass in other.masses][:_LEGS]
    alike = [sum(abs(other - mass) <= MASS * mass for other in masses) for mass in one.masses]
    if len(masses) < 2 or max(alike) < len(masses) or min(alike):
        return None
    return alike[1] > alike[0], max(alike)


def _legs(context: Context) -> Mapping[str, Sequence[Twins]]:
    """Return the twins in front, behind and so on together."""
    found: dict[str, list[Twins]] = defaultdict(list)
    for one in context.once(twins):
        found[row_of(one.pair.left.name)].append(one)
    return found
