"""RD511: joints that mimic each other, or themselves."""

from __future__ import annotations

from collections.abc import Iterator

from robodyn.checks.context import Context
from robodyn.checks.examples import LIMIT, a_joint, a_link, arm
from robodyn.checks.rule import Fault, Rule, Severity, Stage
from robodyn.checks.structure import cycles
from robodyn.checks.view import value_span
from robodyn.support.wording import listed

_FOLLOWER = f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="shoulder"/>'


def check(context: Context) -> Iterator[Fault]:
    joints = context.view.joint
    masters = {name: joint.mimic.joint for name, joint in joints.items() if joint.mimic is not None}
    for cycle in cycles(masters):
        first = min((joints[name] for name in cycle), key=lambda joint: joint.element.start)
        assert first.mimic is not None, "it follows a joint"
        yield Fault(
            at=value_span(first.mimic.element, "joint"),
            subject=first.subject,
            what="it mimics itself" if len(cycle) == 1 else f"joints mimic each other in a cycle: {listed(cycle)}",
            remedy="let one of them be free",
        )


RULE = Rule(
    code="RD511",
    name="mimic-cycle",
    severity=Severity.E,
    stage=Stage.DOCUMENT,
    summary="Mimic joints follow one that is free, at last.",
    explanation="""In a cycle no joint has a position of its own. Some readers follow it for ever.""",
    bad=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore", _FOLLOWER.replace("shoulder", "elbow"))),
    good=arm(more=a_link("fore") + a_joint("elbow", "upper", "fore", _FOLLOWER)),
    check=check,
)
