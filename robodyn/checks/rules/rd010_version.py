"""The version of a description is one that readers know.

urdfdom reads version="1.0" to "1.2", and refuses the file with any other: also "1" and "2.0". Without
one it is 1.0.
"""

import re

from robodyn.checks.examples import one_link
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.support.wording import shown

_KNOWN = re.compile(r"1\.[0-2]")


@rule(Severity.ERROR, good=one_link().replace("<robot ", '<robot version="1.0" '), bad=('"1.0"', '"2.0"'))
def check(context: Context) -> Faults:
    root = context.view.root
    version = root.get("version")
    if version is not None and not _KNOWN.fullmatch(version):
        what = f"the version is {shown(version)}; urdfdom reads 1.0 to 1.2 and refuses others"
        yield Fault(value_span(root, "version"), what, 'write version="1.0", or leave it out', subject=None)
