"""Whatever a joint moves has mass.

Links joined by fixed joints are one body, a rigid group. A moving group without any mass makes the
mass matrix singular: the joint's acceleration is undefined. Where other bodies with mass hang on the group, it is a
warning: the mass matrix is regular then, but MuJoCo makes up a mass from collision shapes or refuses the robot, and
Gazebo drops the group and all that hangs on it.
"""

from math import fsum

from robodyn.checks.bodies.masses import carried_masses
from robodyn.checks.consumers.water import inventions
from robodyn.checks.examples import longer_arm
from robodyn.checks.reading.tree import Group
from robodyn.checks.rule import Context, Fault, Faults, Severity, Stage, rule
from robodyn.support.wording import listed


@rule(
    Severity.ERROR,
    Stage.TREE,
    good=longer_arm("tip", "flange", "", "", "fixed"),
    bad=longer_arm("tip", "wrist", ""),
    explains=("RD901",),
)
def check(context: Context) -> Faults:
    carried = context.once(carried_masses)
    for group in context.tree.groups:
        if group.joint is None or any(link.inertial is not None for link in group.links):
            continue
        first = group.links[0]
        onward = carried[group] > 0
        with_it = f" with {listed([link.name for link in group.links[1:]])}" if len(group.links) > 1 else ""
        what = f"joint '{group.joint.name}' moves it{with_it}, and it has no mass" + (
            f"; what hangs on it has {carried[group]:g} kg" if onward else ""
        )
        what += f"; MuJoCo {_in_mujoco(context, group)}, Gazebo drops it" + " and what hangs on it" * onward
        remedy = "add an <inertial>" if onward else "add an <inertial>, or make the joint fixed"
        severity = Severity.WARNING if onward else Severity.ERROR
        yield Fault(first.name_span, what, remedy, measured=0.0, severity=severity, kind="a joint moves no mass")


def _in_mujoco(context: Context, group: Group) -> str:
    masses = inventions(context, group.links).values()
    known = [mass for mass in masses if mass is not None]
    if not masses:
        return "refuses it"
    return f"invents {f'{fsum(known):.3g} kg' if known else 'a mass'} from its collision shapes"
