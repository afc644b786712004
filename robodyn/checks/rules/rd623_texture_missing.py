"""Every texture is there.

Viewers draw the shape white, or say so at each frame, where the picture is missing. Names of textures
are looked up as those of meshes are.
"""

from robodyn.checks.examples import arm
from robodyn.checks.meshes.files import Look, State
from robodyn.checks.reading.grammar import own_elements
from robodyn.checks.rule import Context, Fault, Faults, Severity, rule
from robodyn.robot.urdf.numbers import value_span
from robodyn.robot.urdf.xml_reader import unexpanded
from robodyn.support.wording import shown_path

_WOOD = '\n  <material name="wood"><texture filename="package://part/wood.png"/></material>'


@rule(Severity.WARNING, good=arm(more=_WOOD), bad=("package://part/wood.png", "package:///wood.png"))
def check(context: Context) -> Faults:
    look = Look(context)
    seen = set()
    for element, _, subject in context.once(own_elements):
        uri = element.get("filename") if element.tag == "texture" else None
        if not uri or unexpanded(uri) or uri in seen:
            continue
        seen.add(uri)
        state = look.up(uri, ()).state
        if state in (State.MISSING, State.OTHER_CASE):
            what = f"the texture {shown_path(uri)} is " + (
                "not there" if state is State.MISSING else "there in another case"
            )
            remedy = "correct its name, or delete <texture>"
            yield Fault(value_span(element, "filename"), what, remedy, subject=subject)
