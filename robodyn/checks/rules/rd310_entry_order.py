"""The entries are in URDF's order: ixx ixy ixz iyy iyz izz.

MuJoCo's fullinertia is ixx iyy izz ixy ixz iyz, Voigt's order ixx iyy izz iyz ixz ixy, and a
triangle by columns ixx ixy iyy ixz iyz izz; a matrix of nine entries, row by row, has iyx in fourth place. Pasting
one for another gives a tensor that no body has, or wrong products. RD206 and RD207 name the cause of tensors that no
body has; this rule reports those that a body could have, but not this link, by its mirror twin or its shapes.
"""

from robodyn.checks.causes.causes import faults
from robodyn.checks.examples import IMAGE, inertia, two_arms
from robodyn.checks.rule import Context, Faults, Severity, rule


@rule(Severity.WARNING, good=two_arms(), bad=(IMAGE, inertia("0.02 0.002 -0.004 0.03 -0.003 0.025")))
def check(context: Context) -> Faults:
    return faults(context, "RD310")
